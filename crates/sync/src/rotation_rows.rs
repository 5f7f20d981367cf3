//! Rotations in files: as rigid transformations without translation, which are checked when read.

use gmpcr_geometry::{isometry, matrix_rows};
use nalgebra::{Rotation3, Vector3};
use serde::{Deserializer, Serializer};

pub(crate) fn serialize<S: Serializer>(
    rotations: &[Rotation3<f64>],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let poses = rotations
        .iter()
        .map(|rotation| isometry(rotation, &Vector3::zeros()));
    matrix_rows::list::serialize(&poses.collect::<Vec<_>>(), serializer)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<Rotation3<f64>>, D::Error> {
    let poses = matrix_rows::list::deserialize(deserializer)?;
    Ok(poses
        .iter()
        .map(|pose| pose.rotation.to_rotation_matrix())
        .collect())
}

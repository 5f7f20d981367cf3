//! Descriptors in files: one list of 33 numbers for each point.

use crate::{FPFH_DIMENSION, Fpfh};
use serde::{Deserialize, Deserializer, Serializer, de::Error};

pub(crate) fn serialize<S: Serializer>(
    descriptors: &[Fpfh],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(descriptors.iter().map(|descriptor| &descriptor[..]))
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<Fpfh>, D::Error> {
    let rows = <Vec<Vec<f32>>>::deserialize(deserializer)?;
    let read = |(index, row): (usize, &Vec<f32>)| {
        Fpfh::try_from(&row[..]).map_err(|_| {
            let len = row.len();
            D::Error::custom(format!(
                "descriptor {index} has {len} numbers, not {FPFH_DIMENSION}"
            ))
        })
    };
    rows.iter().enumerate().map(read).collect()
}

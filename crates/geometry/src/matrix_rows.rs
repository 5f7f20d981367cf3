//! Rigid transformations in files: the 12 numbers of `[R | t]`, row by row.
//!
//! For `#[serde(with = "gmpcr_geometry::matrix_rows")]` on a field of type [`Isometry3<f64>`], or
//! `matrix_rows::list` on a `Vec` of them.

use nalgebra::{Isometry3, Matrix3, Vector3};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

use crate::{isometry, nearest_rotation};

/// The numbers of `[R | t]`, row by row.
pub fn rows(transformation: &Isometry3<f64>) -> [f64; 12] {
    let matrix = transformation.to_matrix();
    std::array::from_fn(|k| matrix[(k / 4, k % 4)])
}

/// The transformation of the numbers of `[R | t]`; `None` if `R` is no rotation up to 1e-6, or a number not
/// finite.
pub fn from_rows(rows: &[f64; 12]) -> Option<Isometry3<f64>> {
    let rotation = Matrix3::from_fn(|row, column| rows[4 * row + column]);
    let deviation = (rotation.transpose() * rotation - Matrix3::identity())
        .abs()
        .max();
    let is_rigid = rows.iter().all(|number| number.is_finite())
        && deviation < 1e-6
        && rotation.determinant() > 0.0;
    let translation = Vector3::new(rows[3], rows[7], rows[11]);
    is_rigid.then(|| isometry(&nearest_rotation(&rotation), &translation))
}

/// Writes a transformation.
///
/// # Errors
/// Those of the serializer.
pub fn serialize<S: Serializer>(
    transformation: &Isometry3<f64>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    rows(transformation).serialize(serializer)
}

/// Reads a transformation.
///
/// # Errors
/// If there are not 12 numbers, or their 3×3 part is no rotation.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Isometry3<f64>, D::Error> {
    let rows = <[f64; 12]>::deserialize(deserializer)?;
    from_rows(&rows).ok_or_else(|| D::Error::custom("the 12 numbers are no rigid transformation"))
}

/// The same for a list of transformations.
pub mod list {
    use super::*;

    /// Writes transformations.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn serialize<S: Serializer>(
        transformations: &[Isometry3<f64>],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(transformations.iter().map(rows))
    }

    /// Reads transformations.
    ///
    /// # Errors
    /// As for a single one, with its position.
    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<Isometry3<f64>>, D::Error> {
        let all = <Vec<[f64; 12]>>::deserialize(deserializer)?;
        let read = |(position, rows)| {
            from_rows(rows)
                .ok_or_else(|| D::Error::custom(format!("transformation {position} is not rigid")))
        };
        all.iter().enumerate().map(read).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_lead_back_to_the_transformation_and_sheared_ones_are_refused() {
        let transformation =
            Isometry3::new(Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.3, 0.2, -2.0));
        let mut numbers = rows(&transformation);
        let back = from_rows(&numbers).unwrap();
        assert!((back.to_matrix() - transformation.to_matrix()).norm() < 1e-14);
        numbers[1] += 0.1;
        assert_eq!(from_rows(&numbers), None);
        assert_eq!(from_rows(&[f64::NAN; 12]), None);
    }
}

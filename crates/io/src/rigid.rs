//! Rigid transformations as numbers in a row: quaternion form and matrix form.

use std::io::{self, Write};

use nalgebra::{
    Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3, Vector4,
};

/// How far an entry of a written rotation may be from the nearest rotation, and the length of a
/// quaternion from 1. Files are written with few digits, but larger errors are not due to rounding.
pub(crate) const ROTATION_TOLERANCE: f64 = 1e-2;

/// The transformation of `x y z qx qy qz qw`; the quaternion is brought to unit length, and refused if its
/// length is off by more than [`ROTATION_TOLERANCE`].
///
/// A quaternion of unit length up to rounding is taken as it is. So all bits come back of what was
/// written with all digits.
pub(crate) fn from_quaternion_row(row: [f64; 7]) -> Result<Isometry3<f64>, String> {
    let [x, y, z, qx, qy, qz, qw] = row;
    let quaternion = Quaternion::new(qw, qx, qy, qz);
    let length = quaternion.norm();
    let excess = (length - 1.0).abs();
    if excess.is_nan() || excess > ROTATION_TOLERANCE {
        return Err(format!(
            "a quaternion of length {length} is not a rotation within {ROTATION_TOLERANCE}"
        ));
    }
    let rotation = if excess <= 1e-14 {
        UnitQuaternion::new_unchecked(quaternion)
    } else {
        UnitQuaternion::new_normalize(quaternion)
    };
    Ok(Isometry3::from_parts(Translation3::new(x, y, z), rotation))
}

/// `x y z qx qy qz qw`, each with the digits that give the same number back.
pub(crate) fn write_quaternion_row(
    file: &mut impl Write,
    transformation: &Isometry3<f64>,
) -> io::Result<()> {
    let [x, y, z] = transformation.translation.vector.into();
    let [qx, qy, qz, qw] = Vector4::into(transformation.rotation.coords);
    write!(file, "{x:?} {y:?} {z:?} {qx:?} {qy:?} {qz:?} {qw:?}")
}

/// The transformation of the upper three rows `[R | t]` of its matrix, row by row.
///
/// `R` is replaced by the nearest rotation; one further away than [`ROTATION_TOLERANCE`] in any
/// entry is refused.
pub(crate) fn from_matrix_rows(rows: [f64; 12]) -> Result<Isometry3<f64>, String> {
    let [a, b, c, x, d, e, f, y, g, h, i, z] = rows;
    let written = Matrix3::new(a, b, c, d, e, f, g, h, i);
    let rotation = nearest_rotation(&written)
        .filter(|rotation| (rotation - written).amax() <= ROTATION_TOLERANCE)
        .ok_or_else(|| {
            let det = written.determinant();
            format!(
                "the 3x3 part is not a rotation within {ROTATION_TOLERANCE} (determinant {det})"
            )
        })?;
    let rotation = Rotation3::from_matrix_unchecked(rotation);
    Ok(Isometry3::from_parts(
        Vector3::new(x, y, z).into(),
        UnitQuaternion::from_rotation_matrix(&rotation),
    ))
}

/// Whether the fourth row of a 4×4 matrix is that of a rigid transformation.
pub(crate) fn check_last_row(row: [f64; 4]) -> Result<(), String> {
    let is_near = |(entry, expected): (f64, f64)| (entry - expected).abs() <= ROTATION_TOLERANCE;
    if row.into_iter().zip([0.0, 0.0, 0.0, 1.0]).all(is_near) {
        return Ok(());
    }
    Err("the last row of the matrix is not 0 0 0 1".to_owned())
}

/// The upper three rows `[R | t]` of the matrix of `transformation`.
pub(crate) fn matrix_rows(transformation: &Isometry3<f64>) -> [[f64; 4]; 3] {
    let matrix = transformation.to_homogeneous();
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
}

/// The rotation nearest to `matrix` in the Frobenius norm, for a matrix that is almost one.
///
/// Newton's iteration `X <- (X + X^-T) / 2` for the polar factor (Higham, 1986) doubles the number
/// of correct digits in each step. Five steps lead from an error of 0.1 below the rounding error.
fn nearest_rotation(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let mut polar = *matrix;
    if polar.determinant() <= 0.0 {
        return None;
    }
    for _ in 0..6 {
        polar = (polar + polar.try_inverse()?.transpose()) / 2.0;
    }
    Some(polar)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn some_pose() -> Isometry3<f64> {
        Isometry3::new(Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.3, -0.5, 0.9))
    }

    fn flat(rows: [[f64; 4]; 3]) -> [f64; 12] {
        std::array::from_fn(|k| rows[k / 4][k % 4])
    }

    #[test]
    fn the_matrix_rows_give_the_transformation_back() {
        let pose = some_pose();
        let back = from_matrix_rows(flat(matrix_rows(&pose))).unwrap();
        assert_relative_eq!(back, pose, epsilon = 1e-14);
    }

    #[test]
    fn a_rotation_by_180_degrees_survives_its_matrix() {
        let pose = Isometry3::rotation(Vector3::y() * std::f64::consts::PI);
        let back = from_matrix_rows(flat(matrix_rows(&pose))).unwrap();
        assert!(back.rotation.angle_to(&pose.rotation) < 1e-14);
    }

    #[test]
    fn a_rounded_matrix_becomes_the_nearest_rotation() {
        let pose = some_pose();
        let rounded = flat(matrix_rows(&pose)).map(|entry| (entry * 1e3).round() / 1e3);
        let back = from_matrix_rows(rounded).unwrap();
        let rotation = back.rotation.to_rotation_matrix().into_inner();
        assert_relative_eq!(
            rotation.transpose() * rotation,
            Matrix3::identity(),
            epsilon = 1e-14
        );
        // Nearest: the difference to the rounded matrix, rotated back, is symmetric.
        let rounded = Matrix3::from_fn(|row, column| rounded[row * 4 + column]);
        let stretch = rotation.transpose() * rounded;
        assert_relative_eq!(stretch, stretch.transpose(), epsilon = 1e-14);
    }

    #[test]
    fn what_is_no_rotation_is_refused() {
        let mirror = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0];
        let scaled = [1.1, 0.0, 0.0, 0.0, 0.0, 1.1, 0.0, 0.0, 0.0, 0.0, 1.1, 0.0];
        for rows in [mirror, scaled, [0.0; 12], [1e-200; 12], [1e200; 12]] {
            assert!(from_matrix_rows(rows).is_err(), "{rows:?}");
        }
        assert!(from_quaternion_row([0.0; 7]).is_err());
        assert!(from_quaternion_row([1e200; 7]).is_err());
    }

    #[test]
    fn rounded_quaternions_are_normalized() {
        let pose = from_quaternion_row([0.0, 0.0, 0.0, 0.0, 0.0, 0.705, 0.705]).unwrap();
        let right_angle =
            UnitQuaternion::from_scaled_axis(Vector3::z() * std::f64::consts::FRAC_PI_2);
        assert!(pose.rotation.angle_to(&right_angle) < 1e-15);
    }

    #[test]
    fn quaternions_far_from_unit_length_are_refused() {
        for qw in [0.991, 1.009] {
            assert!(from_quaternion_row([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, qw]).is_ok());
        }
        for qw in [0.989, 1.011, 2.0, f64::NAN, f64::INFINITY] {
            assert!(from_quaternion_row([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, qw]).is_err());
        }
    }
}

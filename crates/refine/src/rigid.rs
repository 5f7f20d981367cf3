//! A rigid transformation as plain numbers, for inner loops.

use nalgebra::Isometry3;

/// `x ↦ R x + t`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rigid {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

impl Rigid {
    pub fn new(transformation: &Isometry3<f64>) -> Self {
        let rotation = transformation.rotation.to_rotation_matrix();
        let row = |k| [0, 1, 2].map(|column| rotation[(k, column)]);
        Self {
            rotation: [row(0), row(1), row(2)],
            translation: transformation.translation.vector.into(),
        }
    }

    /// `R v`.
    #[inline(always)]
    pub fn rotate(&self, v: &[f64; 3]) -> [f64; 3] {
        let r = &self.rotation;
        [dot(&r[0], v), dot(&r[1], v), dot(&r[2], v)]
    }

    /// `R x + t`.
    #[inline(always)]
    pub fn apply(&self, x: &[f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.rotate(x);
        let t = &self.translation;
        [a + t[0], b + t[1], c + t[2]]
    }

    /// `Rᵀ v`.
    #[inline(always)]
    pub fn rotate_back(&self, v: &[f64; 3]) -> [f64; 3] {
        let [x, y, z] = &self.rotation;
        [0, 1, 2].map(|k| x[k] * v[0] + y[k] * v[1] + z[k] * v[2])
    }
}

#[inline(always)]
pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn minus(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;

    #[test]
    fn it_is_the_isometry() {
        let isometry = Isometry3::new(Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.3, 1.2, -0.7));
        let rigid = Rigid::new(&isometry);
        let x = [0.4, 5.0, -6.0];
        let difference = Point3::from(rigid.apply(&x)) - isometry * Point3::from(x);
        assert!(difference.norm() < 1e-14);
        let back = Vector3::from(rigid.rotate_back(&rigid.rotate(&x))) - Vector3::from(x);
        assert!(back.norm() < 1e-14);
        let product = Vector3::from(cross(&x, &[1.0, 2.0, 3.0]));
        assert_eq!(
            product,
            Vector3::from(x).cross(&Vector3::new(1.0, 2.0, 3.0))
        );
    }
}

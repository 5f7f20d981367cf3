//! One Gauss–Newton step that leaves alone what the data do not determine.

use nalgebra::{Isometry3, Matrix6, SymmetricEigen, Vector6};

use crate::PairEquations;
use crate::tangent::Tangent;

/// A step of a relative pose `T`, which becomes `T · transformation`.
pub(crate) struct Step {
    pub transformation: Isometry3<f64>,
    /// How far it moves the corresponding points, about.
    pub length: f64,
    /// Directions that were left as they were: `ξ` of a unit of length.
    pub undetermined: Vec<Vector6<f64>>,
}

impl Step {
    /// Solves the equations in their eigenvectors, in coordinates around the corresponding points. A direction is
    /// determined if its eigenvalue exceeds `min_stability` times the sum of the weights. A step longer than
    /// `max_length` is shortened.
    pub fn new(equations: &PairEquations, min_stability: f64, max_length: f64) -> Self {
        let tangent = Tangent {
            center: equations.center.coords,
            scale: equations.spread,
        };
        if tangent.scale <= 0.0 {
            return Self::none();
        }
        let basis = tangent.basis();
        let eigen = SymmetricEigen::new(basis.transpose() * equations.hessian * basis);
        let gradient = basis.transpose() * equations.gradient;
        let (mut eta, mut undetermined) = (Vector6::zeros(), Vec::new());
        for (k, &value) in eigen.eigenvalues.iter().enumerate() {
            let direction = eigen.eigenvectors.column(k);
            if value > min_stability * equations.weight {
                eta -= direction * (direction.dot(&gradient) / value);
            } else {
                undetermined.push(basis * direction);
            }
        }
        let length = eta.norm();
        if length > max_length {
            eta *= max_length / length;
        }
        Self {
            transformation: tangent.transformation(&eta),
            length: length.min(max_length),
            undetermined,
        }
    }

    /// Corresponding points that are all at one place determine nothing.
    fn none() -> Self {
        Self {
            transformation: Isometry3::identity(),
            length: 0.0,
            undetermined: (0..6).map(|k| Vector6::ith(k, 1.0)).collect(),
        }
    }
}

/// The smallest eigenvalue of a Hessian in coordinates around a center, where rotations are measured by how
/// far they move points at the distance `scale`; at least 0.
pub(crate) fn smallest_eigenvalue(hessian: &Matrix6<f64>, tangent: &Tangent) -> f64 {
    let basis = tangent.basis();
    let values = (basis.transpose() * hessian * basis).symmetric_eigenvalues();
    values.min().max(0.0)
}

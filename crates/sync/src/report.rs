use gmpcr_posegraph::Components;
use nalgebra::Isometry3;

/// Poses of all scans, with diagnostics.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Synchronization {
    /// `T_i`, from each scan's frame into that of the lowest scan of its component, which has the
    /// identity. Poses of different components do not compare.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows::list"))]
    pub world_from_scan: Vec<Isometry3<f64>>,
    /// Which scans share a frame: the components of the graph of edges of positive weight.
    pub components: Components,
    /// One report per edge of the graph, in its order.
    pub edges: Vec<EdgeReport>,
    /// One report per component, in the order of `components`.
    pub reports: Vec<ComponentReport>,
}

/// What became of an edge.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct EdgeReport {
    /// Weight `w⁰` that the edge came with.
    pub initial_weight: f64,
    /// Weight after the last reweighting. If it is small against the initial one, the edge is probably
    /// an outlier.
    pub final_weight: f64,
    /// Angle in radians between the measured and the final relative rotation; `None` where the
    /// edge, being without weight, joins two components.
    pub rotation_residual: Option<f64>,
    /// Distance between the measured and the final relative translation, in the unit of the input;
    /// `None` as for the rotation.
    pub translation_residual: Option<f64>,
    /// The initial weight and that after each reweighting iteration, up to the final weight. Edges
    /// between components are not reweighted.
    pub weights: Vec<f64>,
}

/// How the synchronization of one component went.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct ComponentReport {
    /// One record per reweighting iteration; [`EdgeReport::weights`] holds the weights.
    pub iterations: Vec<Iteration>,
    /// Largest [`eigen_residual`](crate::AveragedRotations::eigen_residual) of all rotation solves; 0 for
    /// methods without an eigenproblem.
    pub eigen_residual: f64,
    /// Smallest [`weakest_block`](crate::AveragedRotations::weakest_block) of all rotation solves; 1 for
    /// methods without an eigenproblem. Below about 1e-6 the reweighting has split the component in all
    /// but name.
    pub weakest_block: f64,
    /// [Residual](crate::SolvedTranslations::residual) of the final positions; 0 for those that were
    /// solved together with the rotations.
    pub position_residual: f64,
}

impl ComponentReport {
    /// Whether the eigenvectors that the rotations come from were found: `eigen_residual` is at most
    /// 1e-10. Otherwise the rotations are approximate, as may happen where reweighting leaves tiny
    /// eigenvalues; a method without an eigenproblem may help then.
    pub fn rotations_converged(&self) -> bool {
        self.eigen_residual <= 1e-10
    }

    /// Whether the equations of the positions were solved: `position_residual` is at most 1e-6, far
    /// below the noise of any measurement. Otherwise distant positions may be off against each other.
    pub fn positions_converged(&self) -> bool {
        self.position_residual <= 1e-6
    }
}

/// One reweighting iteration `ℓ` of a component.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Iteration {
    /// Overall rotation error `R = Σ w r²` of the normalized residuals. The weights are those before the
    /// update, but for [`Method::Consensus`](crate::Method::Consensus) those after it.
    pub weighted_error: f64,
    /// Memory coefficient `λ` that was used; `None` in the first iteration and for methods without
    /// one.
    pub memory: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residuals_above_their_limits_and_nan_are_not_converged() {
        let report = |eigen_residual, position_residual| ComponentReport {
            iterations: Vec::new(),
            eigen_residual,
            weakest_block: 1.0,
            position_residual,
        };
        let exact = report(0.0, 0.0);
        assert!(exact.rotations_converged() && exact.positions_converged());
        for (rotation, position) in [(1e-9, 1e-5), (f64::NAN, f64::NAN)] {
            let report = report(rotation, position);
            assert!(!report.rotations_converged() && !report.positions_converged());
        }
    }
}

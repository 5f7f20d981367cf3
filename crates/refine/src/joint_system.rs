//! One step of all poses.

use nalgebra::{Isometry3, Matrix6, Vector6};

use crate::block_system::BlockPattern;
use crate::equations::{PairEquations, equations};
use crate::tangent::{Tangent, adjoint};
use crate::{EquationParams, PairCounts, PosedSurface};

/// A pair that takes part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OverlappingPair {
    pub i: usize,
    pub j: usize,
    pub counts: PairCounts,
}

impl OverlappingPair {
    pub fn equations(&self, scans: &[PosedSurface], settings: &EquationParams) -> PairEquations {
        let (i, j) = (&scans[self.i], &scans[self.j]);
        equations(i.surface, j.surface, &relative_pose(i, j), settings)
    }
}

/// `i_from_j`.
pub(crate) fn relative_pose(i: &PosedSurface, j: &PosedSurface) -> Isometry3<f64> {
    i.frame_from_scan.inv_mul(&j.frame_from_scan)
}

/// The equations of all poses for a list of pairs.
pub(crate) struct JointSystem {
    pub pairs: Vec<OverlappingPair>,
    pattern: BlockPattern,
}

impl JointSystem {
    /// `None` if there are no pairs.
    pub fn new(scans: &[PosedSurface], pairs: Vec<OverlappingPair>) -> Option<Self> {
        if pairs.is_empty() {
            return None;
        }
        let ends = pairs.iter().map(|pair| (pair.i, pair.j));
        let pattern = BlockPattern::new(scans.len(), ends);
        Some(Self { pairs, pattern })
    }

    /// Moves the scans by one step, given the equations of the pairs. Returns how far the scan moves that moves
    /// most; `None` if the equations cannot be solved.
    pub fn step(
        &self,
        scans: &mut [PosedSurface],
        equations: &[PairEquations],
        damping: f64,
    ) -> Option<f64> {
        let tangents: Vec<_> = scans.iter().map(tangent).collect();
        let bases: Vec<_> = tangents.iter().map(Tangent::basis).collect();
        let mut system = self.pattern.equations();
        let weight: f64 = equations.iter().map(|pair| pair.weight).sum();
        let resistance = Matrix6::identity() * (damping * weight / scans.len() as f64);
        for node in 0..scans.len() {
            system.add_node(node, &resistance, &Vector6::zeros());
        }
        for (
            pair,
            PairEquations {
                hessian, gradient, ..
            },
        ) in self.pairs.iter().zip(equations)
        {
            let &OverlappingPair { i, j, .. } = pair;
            let j_from_i = relative_pose(&scans[i], &scans[j]).inverse();
            let (of_i, of_j) = (adjoint(&j_from_i) * bases[i], bases[j]);
            let (by_i, by_j) = (of_i.transpose() * hessian, of_j.transpose() * hessian);
            system.add_node(i, &(by_i * of_i), &(of_i.transpose() * gradient));
            system.add_node(j, &(by_j * of_j), &-(of_j.transpose() * gradient));
            system.add_pair(j, i, &-(by_j * of_i));
        }
        let steps = system.solve()?;
        for ((scan, tangent), step) in scans.iter_mut().zip(&tangents).zip(&steps) {
            scan.frame_from_scan *= tangent.transformation(step);
            scan.frame_from_scan.rotation.renormalize();
        }
        Some(steps.iter().map(|step| step.norm()).fold(0.0, f64::max))
    }
}

/// Coordinates in which a unit moves the points of a scan by about a unit of length.
fn tangent(scan: &PosedSurface) -> Tangent {
    Tangent {
        center: scan.surface.center().coords,
        scale: scan.surface.radius().max(scan.surface.voxel_size()),
    }
}

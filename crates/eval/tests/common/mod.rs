//! What the tests share.

use gmpcr_geometry::PointPairs;
use nalgebra::{Matrix6, Point3};

/// `Ω = Σ GᵀG` over points, `G = [I | −[p]×]`, as in the `gt.info` files.
pub fn information_matrix(points: &[Point3<f64>]) -> Matrix6<f64> {
    let pairs = PointPairs::new(points.to_vec(), points.to_vec()).expect("as many as each other");
    gmpcr_cliques::information_matrix(&pairs, 1.0)
}

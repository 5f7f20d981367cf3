//! What point clouds themselves say of their poses, and poses as exact as the clouds.
//!
//! Correspondences of descriptors propose relative poses. Whether one is an inlier, the surfaces tell better: where
//! two scans overlap, and whether one of them saw through what the other has there. And the surfaces make
//! poses far more exact than matched keypoints are.
//!
//! | step | item |
//! |---|---|
//! | a scan's surface, its grid and range image | [`Surface`], [`SurfaceParams`] |
//! | overlap and free-space violations of a pair | [`verify_pair`], [`VerifyParams`], [`PairCounts`], [`DirectedCounts`] |
//! | symmetric point-to-plane ICP of a pair, with its information matrix | [`refine_pair`], [`IcpParams`], [`PairRefinement`] |
//! | one step of it: the normal equations | [`pair_equations`], [`EquationParams`], [`PairEquations`] |
//! | the same for two rigid sets of scans | [`verify_sets`], [`SetSupport`], [`CrossPair`]; [`refine_sets`], [`SetIcpParams`], [`SetRefinement`]; [`PosedSurface`] |
//! | all poses at once | [`refine_jointly`], [`JointParams`], [`JointRefinement`], [`JointPair`] |
//! | who works on many pairs | [`PairMap`], [`Sequential`] |
//!
//! ```
//! use gmpcr_refine::{IcpParams, Surface, SurfaceParams, VerifyParams, refine_pair, verify_pair};
//! use nalgebra::{Isometry3, Point3, Vector3};
//!
//! // A floor and two walls, a point per voxel of 5 cm.
//! let (mut points, mut normals) = (Vec::new(), Vec::new());
//! for (axis, k) in (0..3).flat_map(|axis| (0..900).map(move |k| (axis, k))) {
//!     let on_wall = Vector3::new(0.0, f64::from(k % 30) + 0.5, f64::from(k / 30) + 0.5) * 0.05;
//!     points.push(Point3::from([0, 1, 2].map(|c| on_wall[(c + axis) % 3])));
//!     normals.push(Vector3::ith((3 - axis) % 3, 1.0));
//! }
//! let scan = Surface::new(&points, &normals, &SurfaceParams::from_voxel_size(0.05))?;
//!
//! let guess = Isometry3::translation(0.03, 0.02, -0.03);
//! let before = verify_pair(&scan, &scan, &guess, &VerifyParams::before_refinement())?;
//! assert!(before.smaller_side_ratio() > 0.9);
//! let refined = refine_pair(&scan, &scan, &guess, &IcpParams::precise())?;
//! assert!(refined.i_from_j.translation.vector.norm() < 1e-3);
//! # Ok::<(), gmpcr_refine::Error>(())
//! ```
//!
//! Lengths of the parameters are in voxels, so the defaults suit any unit; results are in the unit of the points,
//! angles in radians. `i_from_j` maps the coordinates of scan j into the frame of scan i. This crate knows surfaces
//! and transformations; it does not know descriptors, files or threads. Every function is a pure function of its
//! arguments: equal input gives equal bits.

mod block_system;
mod check;
mod counts;
mod equations;
mod error;
mod grid;
mod icp;
mod joint;
mod joint_system;
mod pair_map;
mod posed;
mod range_image;
mod rigid;
mod set_icp;
mod set_support;
mod smooth;
mod step;
mod surface;
mod tangent;
mod verify;

pub use counts::{DirectedCounts, PairCounts};
pub use equations::{EquationParams, PairEquations, pair_equations};
pub use error::Error;
pub use gmpcr_geometry::InvalidParameter;
pub use icp::{IcpParams, PairRefinement, refine_pair};
pub use joint::{JointPair, JointParams, JointRefinement, refine_jointly};
pub use pair_map::{PairMap, Sequential};
pub use posed::PosedSurface;
pub use set_icp::{SetIcpParams, SetRefinement, refine_sets};
pub use set_support::{CrossPair, SetSupport, verify_sets};
pub use surface::{Surface, SurfaceParams};
pub use verify::{VerifyParams, verify_pair};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

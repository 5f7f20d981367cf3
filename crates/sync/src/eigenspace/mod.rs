//! The smallest eigenvectors of large sparse matrices.

mod filter;
mod problem;
mod ritz;
mod search;

pub(crate) use problem::{Eigenspace, SemidefiniteMatrix};
pub(crate) use search::smallest_eigenvectors;

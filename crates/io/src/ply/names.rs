//! What the header calls things.

use ply_rs_bw::ply::ElementDef;

/// Names of the properties of a vertex that are its coordinates.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// Names of the properties of a vertex that make up its normal.
pub(super) const NORMAL: [&str; 3] = ["nx", "ny", "nz"];

/// The coordinate that a property of a vertex stands for.
pub(super) fn axis(property: &str) -> Option<usize> {
    AXES.iter().position(|name| *name == property)
}

/// What the header says of an element.
pub(super) fn announced(element: &ElementDef) -> String {
    format!("{} times element {:?}", element.count, element.name)
}

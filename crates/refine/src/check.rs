//! Which input all parts accept.

use gmpcr_geometry::MAX_COORDINATE;
use nalgebra::{Isometry3, Vector3};

use crate::Error;

/// The error of the first coordinate that is no number of safe size.
pub(crate) fn coordinates<'a>(
    what: &'static str,
    vectors: impl IntoIterator<Item = &'a Vector3<f64>>,
) -> Result<(), Error> {
    for (index, vector) in vectors.into_iter().enumerate() {
        numbers(what, index, vector.iter())?;
    }
    Ok(())
}

/// The error of the first transformation that is not of finite numbers, with its position.
pub(crate) fn transformations<'a>(
    all: impl IntoIterator<Item = &'a Isometry3<f64>>,
) -> Result<(), Error> {
    for (index, transformation) in all.into_iter().enumerate() {
        let rotation = transformation.rotation.coords.iter();
        let translation = transformation.translation.vector.iter();
        numbers("transformation", index, rotation.chain(translation))?;
    }
    Ok(())
}

fn numbers<'a>(
    what: &'static str,
    index: usize,
    mut numbers: impl Iterator<Item = &'a f64>,
) -> Result<(), Error> {
    match numbers.find(|c| c.is_nan() || c.abs() > MAX_COORDINATE) {
        Some(&value) => Err(Error::Coordinate { what, index, value }),
        None => Ok(()),
    }
}

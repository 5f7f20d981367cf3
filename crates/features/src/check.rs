//! Ranges in which squares and cubes of lengths neither overflow nor vanish.

use crate::{Error, InvalidParameter};
use nalgebra::{Point3, Vector3};

pub(crate) const LARGEST: f64 = gmpcr_geometry::MAX_COORDINATE;
pub(crate) const SMALLEST: f64 = 1e-100;

pub(crate) fn points(points: &[Point3<f64>]) -> Result<(), Error> {
    points
        .iter()
        .enumerate()
        .try_for_each(|(index, point)| coordinates("point", index, &point.coords))
}

pub(crate) fn normals(normals: &[Vector3<f64>]) -> Result<(), Error> {
    normals
        .iter()
        .enumerate()
        .try_for_each(|(index, normal)| coordinates("normal", index, normal))
}

fn coordinates(what: &'static str, index: usize, vector: &Vector3<f64>) -> Result<(), Error> {
    match vector.iter().find(|&&value| !is_coordinate(value)) {
        Some(&value) => Err(Error::Coordinate { what, index, value }),
        None => Ok(()),
    }
}

fn is_coordinate(value: f64) -> bool {
    (-LARGEST..=LARGEST).contains(&value)
}

pub(crate) fn viewpoint(viewpoint: &Point3<f64>) -> Result<(), InvalidParameter> {
    let axes = ["viewpoint.x", "viewpoint.y", "viewpoint.z"];
    axes.into_iter()
        .zip(viewpoint.iter())
        .try_for_each(|(name, &value)| {
            let allowed = "a number from -1e100 to 1e100";
            InvalidParameter::check(is_coordinate(value), name, value, allowed)
        })
}

pub(crate) fn length(name: &str, value: f64) -> Result<(), InvalidParameter> {
    let is_length = (SMALLEST..=LARGEST).contains(&value);
    InvalidParameter::check(is_length, name, value, "a length from 1e-100 to 1e100")
}

pub(crate) fn count(name: &str, value: usize) -> Result<(), InvalidParameter> {
    InvalidParameter::check(value >= 1, name, value as f64, "at least 1")
}

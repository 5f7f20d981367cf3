//! Ranges in which squares and cubes of lengths neither overflow nor vanish.

use crate::Error;
use nalgebra::{Point3, Vector3};

pub(crate) const LARGEST: f64 = 1e100;
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

pub(crate) fn viewpoint(viewpoint: &Point3<f64>) -> Result<(), Error> {
    coordinates("viewpoint", 0, &viewpoint.coords)
}

pub(crate) fn length(name: &'static str, value: f64) -> Result<(), Error> {
    if (SMALLEST..=LARGEST).contains(&value) {
        return Ok(());
    }
    Err(Error::Parameter {
        name,
        value,
        allowed: "a length from 1e-100 to 1e100",
    })
}

pub(crate) fn count(name: &'static str, value: usize) -> Result<(), Error> {
    if value > 0 {
        return Ok(());
    }
    Err(Error::Parameter {
        name,
        value: 0.0,
        allowed: "1 or more",
    })
}

fn coordinates(what: &'static str, index: usize, vector: &Vector3<f64>) -> Result<(), Error> {
    match vector
        .iter()
        .find(|value| !(-LARGEST..=LARGEST).contains(*value))
    {
        Some(&value) => Err(Error::Coordinate { what, index, value }),
        None => Ok(()),
    }
}

//! What a result.json says of poses, whatever form it has.

use std::path::Path;

use gmpcr::geometry::matrix_rows::from_rows;
use gmpcr::nalgebra::Isometry3;
use serde::Deserialize;
use serde_json::Value;

use crate::outcome::Failure;
use crate::result::{FORMAT, ResultFile};

/// Poses, and which of them share a frame.
pub struct Estimate {
    pub world_from_scan: Vec<Isometry3<f64>>,
    /// The scans of each component.
    pub components: Vec<Vec<usize>>,
    /// The component of each scan.
    pub labels: Vec<usize>,
}

impl Estimate {
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let known = serde_json::from_str::<Value>(&text).map_err(|error| error.to_string());
        let estimate = known.and_then(|content| match content["format"].as_u64() {
            Some(1) => Self::of_form_1(content),
            Some(format) if format == u64::from(FORMAT) => Self::of_form_2(content),
            Some(format) => Err(format!(
                "the form of the file is {format}, known are 1 and {FORMAT}"
            )),
            None => Err("it has no \"format\"".into()),
        });
        estimate.map_err(|reason| {
            Failure::of(path, format!("no result.json of gmpcr register: {reason}"))
        })
    }

    fn of_form_2(content: Value) -> Result<Self, String> {
        let file: ResultFile =
            serde_json::from_value(content).map_err(|error| error.to_string())?;
        let registration = file.registration;
        Self::new(
            registration.world_from_scan,
            registration.components.members().to_vec(),
        )
    }

    fn of_form_1(content: Value) -> Result<Self, String> {
        let file: Form1 = serde_json::from_value(content).map_err(|error| error.to_string())?;
        let pose = |(scan, of_scan): (usize, &Scan1)| {
            let pose = from_rows(&of_scan.world_from_scan);
            pose.ok_or_else(|| format!("the pose of scan {scan} is no rigid transformation"))
        };
        let poses = file.scans.iter().enumerate().map(pose);
        Self::new(poses.collect::<Result<_, _>>()?, file.components)
    }

    /// Checks that every scan is in one component.
    fn new(
        world_from_scan: Vec<Isometry3<f64>>,
        components: Vec<Vec<usize>>,
    ) -> Result<Self, String> {
        let mut labels = vec![None; world_from_scan.len()];
        for (label, scans) in components.iter().enumerate() {
            for &scan in scans {
                match labels.get_mut(scan) {
                    Some(place @ None) => *place = Some(label),
                    Some(Some(_)) => return Err(format!("scan {scan} is in two components")),
                    None => {
                        return Err(format!(
                            "component {label} names a scan {scan}, which is not there"
                        ));
                    }
                }
            }
        }
        let labels = labels.into_iter().enumerate();
        let label = |(scan, label): (usize, Option<usize>)| {
            label.ok_or_else(|| format!("scan {scan} is in no component"))
        };
        Ok(Self {
            labels: labels.map(label).collect::<Result<_, _>>()?,
            world_from_scan,
            components,
        })
    }

    /// The label of the largest component, the first of equal ones.
    pub fn largest_component(&self) -> usize {
        let components = self.components.iter().enumerate().rev();
        components
            .max_by_key(|(_, scans)| scans.len())
            .map_or(0, |(label, _)| label)
    }
}

/// What counts here of form 1, in which poses belonged to scans.
#[derive(Deserialize)]
struct Form1 {
    scans: Vec<Scan1>,
    components: Vec<Vec<usize>>,
}

#[derive(Deserialize)]
struct Scan1 {
    world_from_scan: [f64; 12],
}

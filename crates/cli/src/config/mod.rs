//! All parameters by name: what a file, the command line and the results say of them.

mod keys;

use std::fmt::Write;
use std::path::Path;

use gmpcr::{Params, Preset};
use serde_json::{Value, json};
use toml::Table;

use crate::arguments::Tuning;
use crate::outcome::Failure;
use keys::{KEYS, unknown_key};

/// The voxel size is a length in the unit of the scans, and may be "auto".
const VOXEL_SIZE: &str = "features.voxel_size";
/// Degrees for people, radians in [`Params`].
const RESIDUAL_SCALE: &str = "sync.residual_scale";

/// The parameters of a run. Lengths are in voxels until the voxel size is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// In the unit of the scans; `None` to estimate it.
    pub voxel_size: Option<f64>,
    in_voxels: Params,
}

impl Config {
    /// Preset, file, voxel size and single parameters, the later ones winning.
    pub fn new(tuning: &Tuning) -> Result<Self, Failure> {
        let mut config = Self::preset(tuning.preset);
        if let Some(path) = &tuning.config {
            config.read(path)?;
        }
        config.voxel_size = tuning.voxel.or(config.voxel_size);
        for assignment in &tuning.set {
            config.assign(assignment)?;
        }
        config.check()?;
        Ok(config)
    }

    fn preset(preset: Preset) -> Self {
        Self {
            voxel_size: None,
            in_voxels: preset.params().with_voxel_size(1.0),
        }
    }

    /// Checks ranges, in the units of the keys.
    fn check(&self) -> Result<(), Failure> {
        let features = &self.in_voxels.features;
        for (name, length) in [
            ("features.normals.radius", features.normals.radius),
            ("features.fpfh.radius", features.fpfh.radius),
        ] {
            if !(1e-3..=1e3).contains(&length) {
                return Err(
                    format!("{name} is {length}: it must be from 0.001 to 1000 voxels").into(),
                );
            }
        }
        let scale = self.in_voxels.sync.residual_scale;
        if scale <= 0.0 {
            let degrees = rounded(scale.to_degrees());
            return Err(format!("{RESIDUAL_SCALE} is {degrees}: it must be positive").into());
        }
        Ok(self.in_voxels.validate()?)
    }

    /// All parameters at a voxel size, in the unit of the scans.
    pub fn params(&self, voxel_size: f64) -> Params {
        self.in_voxels.clone().scaled(voxel_size)
    }

    fn read(&mut self, path: &Path) -> Result<(), Failure> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let table: Table = text
            .parse()
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let mut entries = Vec::new();
        flatten("", &table, &mut entries);
        for (name, value) in entries {
            self.set(&name, value)
                .map_err(|reason| format!("{}: {reason}", path.display()))?;
        }
        Ok(())
    }

    /// `path=value`, the value as in the file; quotes around words may be left out.
    fn assign(&mut self, assignment: &str) -> Result<(), Failure> {
        let Some((name, text)) = assignment.split_once('=') else {
            return Err(format!("--set {assignment}: NAME=VALUE is needed").into());
        };
        let (name, text) = (name.trim(), text.trim());
        let table = format!("value = {text}").parse::<Table>();
        let value = table.ok().and_then(|mut table| table.remove("value"));
        let value = value.unwrap_or_else(|| toml::Value::String(text.to_owned()));
        let outcome = self.set(name, &value);
        outcome.map_err(|reason| format!("--set {assignment}: {reason}").into())
    }

    fn set(&mut self, name: &str, value: &toml::Value) -> Result<(), String> {
        if !KEYS.iter().any(|(path, _)| *path == name) {
            return Err(unknown_key(name));
        }
        let wanted = |what: &str| format!("{name} is {value}, but must be {what}");
        let number = || match value {
            toml::Value::Integer(value) => Some(*value as f64),
            toml::Value::Float(value) if value.is_finite() => Some(*value),
            _ => None,
        };
        if name == VOXEL_SIZE {
            let positive = number().filter(|&voxel_size| voxel_size > 0.0);
            if positive.is_none() && value.as_str() != Some("auto") {
                return Err(wanted("\"auto\" or a positive number"));
            }
            self.voxel_size = positive;
            return Ok(());
        }
        let mut tree = self.tree();
        let Some(place) = tree.pointer_mut(&pointer(name)) else {
            return Err(unknown_key(name));
        };
        *place = match place {
            Value::String(_) => json!(value.as_str().ok_or_else(|| wanted("a name"))?),
            Value::Number(before) if before.is_u64() => {
                let count = value
                    .as_integer()
                    .and_then(|value| usize::try_from(value).ok());
                json!(count.ok_or_else(|| wanted("a whole number"))?)
            }
            _ => {
                let number = number().ok_or_else(|| wanted("a number"))?;
                json!(if name == RESIDUAL_SCALE {
                    number.to_radians()
                } else {
                    number
                })
            }
        };
        self.in_voxels = serde_json::from_value(tree).map_err(|error| error.to_string())?;
        Ok(())
    }

    /// The parameters as a tree of names.
    fn tree(&self) -> Value {
        json!(self.in_voxels)
    }

    /// The value of a parameter, as the file has it.
    fn get(&self, name: &str) -> Value {
        let value = self.tree().pointer(&pointer(name)).cloned();
        match (name, value) {
            (VOXEL_SIZE, _) => self.voxel_size.map_or(json!("auto"), |size| json!(size)),
            (RESIDUAL_SCALE, _) => {
                json!(rounded(self.in_voxels.sync.residual_scale.to_degrees()))
            }
            (_, value) => value.unwrap_or_default(),
        }
    }

    /// The file of parameters, each with what it means.
    pub fn to_toml(&self) -> String {
        let mut text = String::from("# Lengths are in voxels, but for the voxel size itself.\n");
        let mut section = "";
        for (path, help) in KEYS {
            let (of, name) = path.rsplit_once('.').unwrap_or(("", path));
            if of != section {
                section = of;
                let _ = write!(text, "\n[{section}]");
            }
            let _ = write!(text, "\n# {help}\n{name} = {}\n", self.get(path));
        }
        text
    }

    /// All parameters by their paths.
    pub fn to_json(&self) -> Value {
        let values = KEYS
            .iter()
            .map(|(path, _)| ((*path).to_owned(), self.get(path)));
        Value::Object(values.collect())
    }
}

/// The place of a parameter in the tree.
fn pointer(name: &str) -> String {
    format!("/{}", name.replace('.', "/"))
}

/// Angles are in degrees outside and in radians inside; the way there and back costs a last digit.
fn rounded(degrees: f64) -> f64 {
    (degrees * 1e12).round() / 1e12
}

/// Path and value of every entry.
fn flatten<'t>(section: &str, table: &'t Table, entries: &mut Vec<(String, &'t toml::Value)>) {
    for (name, value) in table {
        let path = match section {
            "" => name.clone(),
            _ => format!("{section}.{name}"),
        };
        match value {
            toml::Value::Table(inner) => flatten(&path, inner, entries),
            _ => entries.push((path, value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tuning(preset: Preset, set: &[&str]) -> Tuning {
        Tuning {
            preset,
            voxel: None,
            config: None,
            set: set.iter().map(|&text| text.to_owned()).collect(),
        }
    }

    fn complaint(set: &str) -> String {
        let outcome = Config::new(&tuning(Preset::ThreeDMatch, &[set]));
        outcome.unwrap_err().to_string()
    }

    #[test]
    fn a_preset_at_five_centimeters_has_the_numbers_of_the_paper() {
        for &preset in Preset::ALL {
            let config = Config::new(&tuning(preset, &[])).unwrap();
            assert_eq!(config.params(0.05), preset.params());
        }
    }

    #[test]
    fn the_printed_parameters_read_back_as_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("params.toml");
        let changes = [
            "features.voxel_size=0.02",
            "sync.method=hara",
            "sync.residual_scale=7",
        ];
        let written = Config::new(&tuning(Preset::Eth, &changes)).unwrap();
        std::fs::write(&path, written.to_toml()).unwrap();
        let mut from_file = tuning(Preset::ThreeDMatch, &[]);
        from_file.config = Some(path);
        let read = Config::new(&from_file).unwrap();
        assert_eq!(read.to_json(), written.to_json());
        assert_eq!(read.params(1.0), written.params(1.0));
    }

    #[test]
    fn every_parameter_can_be_set_and_shows() {
        let unchanged = Config::preset(Preset::ThreeDMatch);
        for (path, _) in KEYS {
            let value = match unchanged.get(path) {
                Value::Number(value) if value.is_u64() => toml::Value::Integer(7),
                Value::String(value) if value == "adaptive" => "consensus".into(),
                _ => toml::Value::Float(0.25),
            };
            let mut config = unchanged.clone();
            config.set(path, &value).unwrap();
            let shown: toml::Value = serde_json::from_value(config.get(path)).unwrap();
            assert_eq!(shown, value, "{path}");
            assert_ne!(config, unchanged, "{path}");
        }
    }

    #[test]
    fn every_parameter_of_the_library_has_a_comment() {
        fn leaves(path: &str, value: &Value, found: &mut Vec<String>) {
            match value {
                Value::Object(fields) => {
                    for (name, value) in fields {
                        leaves(&format!("{path}.{name}"), value, found);
                    }
                }
                _ => found.push(path.trim_start_matches('.').to_owned()),
            }
        }
        let mut found = Vec::new();
        leaves("", &Config::preset(Preset::default()).tree(), &mut found);
        // Each scan has a viewpoint of its own.
        found.retain(|path| path != "features.normals.viewpoint");
        let mut commented: Vec<_> = KEYS.iter().map(|(path, _)| path.to_string()).collect();
        found.sort();
        commented.sort();
        assert_eq!(found, commented);
    }

    #[test]
    fn the_affinity_of_the_clique_graph_is_of_first_order() {
        let text = Config::preset(Preset::default()).to_toml();
        let comment = text.lines().zip(text.lines().skip(1));
        let comment = comment.filter(|(_, line)| line.starts_with("min_affinity"));
        assert!(
            comment
                .map(|(comment, _)| comment)
                .all(|c| c.starts_with("# First-order"))
        );
    }

    #[test]
    fn what_cannot_be_is_named() {
        for (set, reason) in [
            ("neighbors", "NAME=VALUE is needed"),
            (
                "neighbors=3",
                "no parameter neighbors; is one of these meant: features.normals.max_neighbors,",
            ),
            (
                "posegraph.neighbors=-1",
                "posegraph.neighbors is -1, but must be a whole number",
            ),
            (
                "posegraph.neighbors=many",
                "is \"many\", but must be a whole number",
            ),
            (
                "features.voxel_size=0",
                "must be \"auto\" or a positive number",
            ),
            (
                "features.voxel_size=nan",
                "must be \"auto\" or a positive number",
            ),
            (
                "sync.method=best",
                "no synchronization method is named \"best\"",
            ),
            (
                "features.normals.radius=-1",
                "is -1: it must be from 0.001 to 1000 voxels",
            ),
            ("sync.residual_scale=-5", "is -5: it must be positive"),
            (
                "sync.history.max_memory=1",
                "parameter sync.history.max_memory is 1",
            ),
            (
                "compatibility.retained_fraction=1.5",
                "it must be in (0, 1]",
            ),
        ] {
            let said = complaint(set);
            assert!(said.contains(reason), "{said}");
        }
    }
}

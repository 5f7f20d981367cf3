//! All parameters by name: what a file, the command line and the results say of them.

mod keys;

use std::fmt::Write;
use std::path::Path;

use gmpcr::features::FeatureParams;
use gmpcr::sync::{AdaptiveHistory, History, Method};
use gmpcr::{Params, Preset};
use serde_json::json;
use toml::{Table, Value};

use crate::arguments::Tuning;
use crate::outcome::Failure;
use keys::{Access, KEYS, Key, unknown_key};

/// The parameters of a run. Lengths are in working voxels until the voxel is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// The working voxel in the unit of the scans; `None` to estimate it.
    pub voxel: Option<f64>,
    normal_radius: f64,
    normal_neighbors: usize,
    descriptor_radius: f64,
    descriptor_neighbors: usize,
    tolerance: f64,
    inlier_threshold: f64,
    method: Method,
    history: AdaptiveHistory,
    /// Everything else. Lengths and method in it do not count.
    params: Params,
}

impl Config {
    /// Preset, file, voxel and single parameters, the later ones winning.
    pub fn new(tuning: &Tuning) -> Result<Self, Failure> {
        let mut config = Self::preset(tuning.preset);
        if let Some(path) = &tuning.config {
            config.read(path)?;
        }
        config.voxel = tuning.voxel.or(config.voxel);
        for assignment in &tuning.set {
            config.assign(assignment)?;
        }
        config.check()?;
        Ok(config)
    }

    /// Checks ranges, in the names and units of the keys.
    fn check(&self) -> Result<(), Failure> {
        for (name, length) in [
            ("features.normal_radius", self.normal_radius),
            ("features.descriptor_radius", self.descriptor_radius),
        ] {
            if !(1e-3..=1e3).contains(&length) {
                return Err(
                    format!("{name} is {length}: it must be from 0.001 to 1000 voxels").into(),
                );
            }
        }
        for (name, count) in [
            ("features.normal_neighbors", self.normal_neighbors),
            ("features.descriptor_neighbors", self.descriptor_neighbors),
        ] {
            if count == 0 {
                return Err(format!("{name} is 0: it must be at least 1").into());
            }
        }
        let params = self.params(1.0);
        if params.sync.residual_scale <= 0.0 {
            let degrees = rounded(params.sync.residual_scale.to_degrees());
            return Err(format!("sync.residual_scale is {degrees}: it must be positive").into());
        }
        let outcome = params.validate();
        Ok(outcome.map_err(|error| error.to_string().replace("sync.method.", "sync."))?)
    }

    fn preset(preset: Preset) -> Self {
        let params = preset.params();
        let features = FeatureParams::from_voxel_size(1.0);
        let history = match params.sync.method {
            Method::HistoryAware(History::Adaptive(history)) => history,
            _ => AdaptiveHistory::default(),
        };
        Self {
            voxel: None,
            normal_radius: features.normals.radius,
            normal_neighbors: features.normals.max_neighbors,
            descriptor_radius: features.fpfh.radius,
            descriptor_neighbors: features.fpfh.max_neighbors,
            // Two voxels: the paper's 0.10 m at the customary voxel of 0.05 m.
            tolerance: 2.0,
            inlier_threshold: 2.0,
            method: params.sync.method,
            history,
            params,
        }
    }

    /// The parameters of the registration at a working voxel.
    pub fn params(&self, voxel: f64) -> Params {
        let mut params = self.params.clone();
        params.compatibility.tolerance = self.tolerance * voxel;
        params.cliques.inlier_threshold = self.inlier_threshold * voxel;
        params.sync.method = self.method();
        params
    }

    /// The parameters of the features at a working voxel.
    pub fn features(&self, voxel: f64) -> FeatureParams {
        let mut params = FeatureParams::from_voxel_size(voxel);
        params.normals.radius = self.normal_radius * voxel;
        params.normals.max_neighbors = self.normal_neighbors;
        params.fpfh.radius = self.descriptor_radius * voxel;
        params.fpfh.max_neighbors = self.descriptor_neighbors;
        params
    }

    /// The method, an adaptive one with the history's parameters.
    fn method(&self) -> Method {
        match self.method {
            Method::HistoryAware(History::Adaptive(_)) => History::Adaptive(self.history).into(),
            other => other,
        }
    }

    fn read(&mut self, path: &Path) -> Result<(), Failure> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let table: Table = text
            .parse()
            .map_err(|error| format!("{}: {error}", path.display()))?;
        for (name, value) in flattened(&table) {
            self.set(&name, value)
                .map_err(|reason| format!("{}: {reason}", path.display()))?;
        }
        Ok(())
    }

    /// `name=value`, the value as in the file; quotes around words may be left out.
    fn assign(&mut self, assignment: &str) -> Result<(), Failure> {
        let Some((name, text)) = assignment.split_once('=') else {
            return Err(format!("--set {assignment}: NAME=VALUE is needed").into());
        };
        let (name, text) = (name.trim(), text.trim());
        let table = format!("value = {text}").parse::<Table>();
        let value = table.ok().and_then(|mut table| table.remove("value"));
        let value = value.unwrap_or_else(|| Value::String(text.to_owned()));
        let outcome = self.set(name, &value);
        outcome.map_err(|reason| format!("--set {assignment}: {reason}").into())
    }

    fn set(&mut self, name: &str, value: &Value) -> Result<(), String> {
        let Some(key) = KEYS.iter().find(|key| key.name == name) else {
            return Err(unknown_key(name));
        };
        let wanted = |what: &str| format!("{name} is {value}, but must be {what}");
        let number = || match value {
            Value::Integer(value) => Some(*value as f64),
            Value::Float(value) if value.is_finite() => Some(*value),
            _ => None,
        };
        match key.access {
            Access::Voxel => {
                let positive = number().filter(|&voxel| voxel > 0.0);
                if positive.is_none() && value.as_str() != Some("auto") {
                    return Err(wanted("\"auto\" or a positive number"));
                }
                self.voxel = positive;
            }
            Access::Count(field) => {
                let count = value.as_integer().and_then(|value| value.try_into().ok());
                *field(self) = count.ok_or_else(|| wanted("a whole number"))?;
            }
            Access::Number(field) => {
                *field(self) = number().ok_or_else(|| wanted("a number"))?;
            }
            Access::Degrees(field) => {
                *field(self) = number().ok_or_else(|| wanted("a number"))?.to_radians();
            }
            Access::Method => {
                let name = value.as_str().ok_or_else(|| wanted("a name"))?;
                self.method = name.parse().map_err(|unknown| format!("{unknown}"))?;
                if self.method.name() == "no-recovery" {
                    self.history.recovery = 0.0;
                }
            }
        }
        Ok(())
    }

    fn get(&self, key: &Key) -> Value {
        // The fields are reached through one function each, which needs something to change.
        let mut copy = self.clone();
        match key.access {
            Access::Voxel => self
                .voxel
                .map_or(Value::String("auto".into()), Value::Float),
            Access::Count(field) => Value::Integer(*field(&mut copy) as i64),
            Access::Number(field) => Value::Float(*field(&mut copy)),
            Access::Degrees(field) => Value::Float(rounded(field(&mut copy).to_degrees())),
            Access::Method => Value::String(self.method().name().to_owned()),
        }
    }

    /// The file of parameters, each with what it means.
    pub fn to_toml(&self) -> String {
        let mut text = String::from("# Lengths are in working voxels.\n");
        let mut section = "";
        for key in KEYS {
            let (of, name) = key.name.split_once('.').unwrap_or(("", key.name));
            if of != section {
                section = of;
                let _ = write!(text, "\n[{section}]");
            }
            let _ = write!(text, "\n# {}\n{name} = {}\n", key.help, self.get(key));
        }
        text
    }

    /// All parameters by their names.
    pub fn to_json(&self) -> serde_json::Value {
        let values = KEYS.iter().map(|key| {
            let value = match self.get(key) {
                Value::Integer(value) => json!(value),
                Value::Float(value) => json!(value),
                other => json!(other.as_str()),
            };
            (key.name.to_owned(), value)
        });
        serde_json::Value::Object(values.collect())
    }
}

/// Angles are in degrees outside and in radians inside; the way there and back costs a last digit.
fn rounded(degrees: f64) -> f64 {
    (degrees * 1e12).round() / 1e12
}

/// `section.name` and value of every entry.
fn flattened(table: &Table) -> Vec<(String, &Value)> {
    let mut entries = Vec::new();
    for (name, value) in table {
        match value {
            Value::Table(section) => {
                let inner = section.iter();
                entries.extend(inner.map(|(key, value)| (format!("{name}.{key}"), value)));
            }
            _ => entries.push((name.clone(), value)),
        }
    }
    entries
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
    fn a_preset_at_five_centimetres_has_the_numbers_of_the_paper() {
        for preset in Preset::ALL {
            let config = Config::new(&tuning(preset, &[])).unwrap();
            assert_eq!(config.params(0.05), preset.params());
            assert_eq!(config.features(0.05), FeatureParams::default());
        }
    }

    #[test]
    fn the_printed_parameters_read_back_as_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("params.toml");
        let changes = ["voxel=0.02", "sync.method=hara", "sync.residual_scale=7"];
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
        for key in KEYS {
            let value = match key.access {
                Access::Voxel => Value::Float(0.3),
                Access::Count(_) => Value::Integer(7),
                Access::Number(_) | Access::Degrees(_) => Value::Float(0.25),
                Access::Method => Value::String("consensus".into()),
            };
            let mut config = unchanged.clone();
            config.set(key.name, &value).unwrap();
            assert_eq!(config.get(key), value, "{}", key.name);
            assert_ne!(config, unchanged, "{}", key.name);
        }
    }

    #[test]
    fn what_cannot_be_is_named() {
        for (set, reason) in [
            ("neighbors", "NAME=VALUE is needed"),
            (
                "neighbors=3",
                "no parameter neighbors; is one of these meant: features.normal_neighbors,",
            ),
            (
                "posegraph.neighbors=-1",
                "posegraph.neighbors is -1, but must be a whole number",
            ),
            (
                "posegraph.neighbors=many",
                "is \"many\", but must be a whole number",
            ),
            ("voxel=0", "must be \"auto\" or a positive number"),
            ("voxel=nan", "must be \"auto\" or a positive number"),
            (
                "sync.method=best",
                "no synchronisation method is named \"best\"",
            ),
            (
                "features.normal_radius=-1",
                "is -1: it must be from 0.001 to 1000 voxels",
            ),
            ("sync.residual_scale=-5", "is -5: it must be positive"),
            ("sync.max_memory=1", "parameter sync.max_memory is 1"),
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

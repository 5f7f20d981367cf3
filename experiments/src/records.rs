//! The figures that experiments yield, kept in files so that a stopped run can go on.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

use gmpcr_eval::Spread;
use gmpcr_io::write_text;

/// One figure: what was run, in which of several runs, what was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Row of a table: a method, a number of scans, ...
    pub configuration: String,
    /// Number of the run.
    pub run: usize,
    /// What was measured.
    pub metric: String,
    /// The figure.
    pub value: f64,
}

impl Record {
    pub fn new(
        configuration: impl Into<String>,
        run: usize,
        metric: impl Into<String>,
        value: f64,
    ) -> Self {
        Self {
            configuration: configuration.into(),
            run,
            metric: metric.into(),
            value,
        }
    }
}

/// An experiment on one scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit<'a> {
    pub experiment: &'a str,
    pub descriptors: &'a str,
    pub scene: &'a str,
    /// What the files of the scene are recognized by.
    pub input: &'a str,
}

/// (experiment, descriptors, scene)
type Key = (String, String, String);

impl Unit<'_> {
    fn key(&self) -> Key {
        let Self {
            experiment,
            descriptors,
            scene,
            ..
        } = *self;
        (experiment.into(), descriptors.into(), scene.into())
    }
}

/// The records of the units that were asked for or added since the store was opened, and their files
/// `records/<experiment>/<descriptors>/<scene>.csv`, whose first line tells the settings and the input.
pub struct Store {
    folder: PathBuf,
    settings: String,
    /// Whether the files that are there count for nothing.
    fresh: bool,
    units: BTreeMap<Key, Vec<Record>>,
}

impl Store {
    /// Opens a folder, which is made if it is not there.
    pub fn open(out: &Path, settings: &str, fresh: bool) -> Result<Self, Failure> {
        let folder = out.join("records");
        make_folder(&folder)?;
        Ok(Self {
            folder,
            settings: settings.to_owned(),
            fresh,
            units: BTreeMap::new(),
        })
    }

    /// Whether the records of a unit are there, from the same settings and input.
    pub fn holds(&mut self, unit: &Unit) -> bool {
        let kept = (!self.fresh).then(|| self.kept(unit)).flatten();
        let is_kept = kept.is_some();
        self.units.extend(kept.map(|records| (unit.key(), records)));
        is_kept
    }

    /// The records in a unit's file, if it was made from the same settings and input.
    fn kept(&self, unit: &Unit) -> Option<Vec<Record>> {
        let file = self.file(unit);
        let text = fs::read_to_string(&file).ok()?;
        let records = parse(&text);
        if records.is_none() {
            let file = file.display();
            eprintln!("{file} is not a file of records: it is written anew");
        }
        records.filter(|_| text.lines().next() == Some(&self.first_line(unit)))
    }

    fn file(&self, unit: &Unit) -> PathBuf {
        let folder = self.folder.join(unit.experiment).join(unit.descriptors);
        folder.join(format!("{}.csv", unit.scene))
    }

    fn first_line(&self, unit: &Unit) -> String {
        format!("# {}; {}", self.settings, unit.input)
    }

    /// Takes the records of a unit and writes them to its file.
    pub fn add(&mut self, unit: &Unit, records: Vec<Record>) -> Result<(), Failure> {
        let file = self.file(unit);
        file.parent().map_or(Ok(()), make_folder)?;
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(HEADER)?;
        for record in &records {
            let (run, value) = (record.run.to_string(), record.value.to_string());
            writer.write_record([&record.configuration, &run, &record.metric, &value])?;
        }
        let rows = String::from_utf8(writer.into_inner()?)?;
        let text = format!("{}\n{rows}", self.first_line(unit));
        self.units.insert(unit.key(), records);
        Ok(write_text(file, &text)?)
    }

    /// Descriptors that an experiment has records for.
    pub fn descriptors(&self, experiment: &str) -> Vec<&str> {
        let of_it = self.units.keys().filter(|key| key.0 == experiment);
        let mut names: Vec<&str> = of_it.map(|key| key.1.as_str()).collect();
        names.dedup();
        names
    }

    /// The records of one experiment with one kind of descriptors.
    pub fn select(&self, experiment: &str, descriptors: &str) -> Selection<'_> {
        let of_it = |(key, _): &(&Key, _)| key.0 == experiment && key.1 == descriptors;
        let scenes = self.units.iter().filter(of_it);
        Selection {
            scenes: scenes
                .map(|(key, records)| (key.2.as_str(), records.as_slice()))
                .collect(),
        }
    }
}

const HEADER: [&str; 4] = ["configuration", "run", "metric", "value"];

fn parse(text: &str) -> Option<Vec<Record>> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    if reader.headers().ok()? != HEADER.as_slice() {
        return None;
    }
    let rows = reader.records().map(|row| parse_row(&row.ok()?));
    rows.collect()
}

fn parse_row(row: &csv::StringRecord) -> Option<Record> {
    let (run, value) = (row.get(1)?.parse().ok()?, row.get(3)?.parse().ok()?);
    Some(Record::new(row.get(0)?, run, row.get(2)?, value))
}

fn make_folder(folder: &Path) -> Result<(), String> {
    fs::create_dir_all(folder)
        .map_err(|error| format!("cannot create {}: {error}", folder.display()))
}

/// Records of one experiment, scene by scene.
pub struct Selection<'a> {
    pub scenes: Vec<(&'a str, &'a [Record])>,
}

impl Selection<'_> {
    /// The configurations in the order in which they were recorded first.
    pub fn configurations(&self) -> Vec<String> {
        self.distinct(|record| Some(&record.configuration))
    }

    /// What the records name, each name once, in the order in which they were recorded first.
    pub fn distinct(&self, name: impl Fn(&Record) -> Option<&str>) -> Vec<String> {
        let records = self.scenes.iter().flat_map(|(_, records)| *records);
        let mut names: Vec<String> = Vec::new();
        for name in records.filter_map(name) {
            if !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        }
        names
    }

    /// Names of the scenes.
    pub fn names(&self) -> Vec<String> {
        let names = self.scenes.iter().map(|(scene, _)| (*scene).to_owned());
        names.collect()
    }

    /// The records of one scene alone.
    pub fn alone(&self) -> impl Iterator<Item = Self> {
        self.scenes.iter().map(|scene| Self {
            scenes: vec![*scene],
        })
    }

    /// Figures of all runs on one scene, by run.
    pub fn of_scene(&self, scene: &str, configuration: &str, metric: &str) -> Vec<(usize, f64)> {
        let scenes = self.scenes.iter().filter(|(name, _)| *name == scene);
        let records = scenes.flat_map(|(_, records)| *records);
        let wanted = records.filter(|r| r.configuration == configuration && r.metric == metric);
        wanted.map(|record| (record.run, record.value)).collect()
    }

    /// Mean and spread over the runs on one scene.
    pub fn scene_spread(&self, scene: &str, configuration: &str, metric: &str) -> Option<Spread> {
        let figures = self.of_scene(scene, configuration, metric);
        let values: Vec<f64> = figures.into_iter().map(|(_, value)| value).collect();
        Spread::of(&values)
    }

    /// Spread over the runs of the mean over the scenes, each scene weighing the same.
    pub fn mean_spread(&self, configuration: &str, metric: &str) -> Option<Spread> {
        let means: Vec<f64> = self
            .by_run(configuration, metric)
            .values()
            .map(|values| values.iter().sum::<f64>() / values.len() as f64)
            .collect();
        Spread::of(&means)
    }

    /// Spread over the runs of the sum over the scenes of one metric by that of another.
    pub fn ratio_spread(&self, configuration: &str, part: &str, whole: &str) -> Option<Spread> {
        let (parts, wholes) = (
            self.by_run(configuration, part),
            self.by_run(configuration, whole),
        );
        let sum = |values: &[f64]| values.iter().sum::<f64>();
        let ratios: Vec<f64> = parts
            .iter()
            .filter_map(|(run, part)| Some(sum(part) / sum(wholes.get(run)?)))
            .collect();
        Spread::of(&ratios)
    }

    fn by_run(&self, configuration: &str, metric: &str) -> BTreeMap<usize, Vec<f64>> {
        let mut runs: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for (scene, _) in &self.scenes {
            for (run, value) in self.of_scene(scene, configuration, metric) {
                runs.entry(run).or_default().push(value);
            }
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Unit = Unit {
        experiment: "recall",
        descriptors: "fpfh",
        scene: "a",
        input: "12 bytes",
    };

    #[test]
    fn records_survive_and_those_of_other_settings_or_input_do_not_count() {
        let folder = tempfile::tempdir().unwrap();
        let records = vec![Record::new("K, \"6\"", 1, "3dmatch", 0.1 + 0.2)];
        let mut store = Store::open(folder.path(), "seed 0", false).unwrap();
        store.add(&UNIT, records.clone()).unwrap();
        let mut again = Store::open(folder.path(), "seed 0", false).unwrap();
        assert!(again.select("recall", "fpfh").scenes.is_empty());
        assert!(again.holds(&UNIT));
        assert_eq!(
            again.select("recall", "fpfh").scenes,
            [("a", records.as_slice())]
        );
        let changed = Unit {
            input: "13 bytes",
            ..UNIT
        };
        assert!(!again.holds(&changed));
        for (settings, fresh) in [("seed 1", false), ("seed 0", true)] {
            let mut other = Store::open(folder.path(), settings, fresh).unwrap();
            assert!(!other.holds(&UNIT));
        }
    }

    #[test]
    fn a_foreign_or_cut_file_does_not_count() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("records/recall/fpfh");
        fs::create_dir_all(&place).unwrap();
        for text in [
            "",
            "# s; 12 bytes\nconfi",
            "# s; 12 bytes\nconfiguration,run,metric,value\nx,y,z,1\n",
        ] {
            fs::write(place.join("a.csv"), text).unwrap();
            let mut store = Store::open(folder.path(), "s", false).unwrap();
            assert!(!store.holds(&UNIT), "{text}");
        }
    }

    #[test]
    fn means_weigh_scenes_alike_and_ratios_weigh_pairs_alike() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path(), "", false).unwrap();
        for (scene, registered, pairs) in [("a", 1.0, 1.0), ("b", 1.0, 3.0)] {
            let figure = |metric, value| Record::new("c", 0, metric, value);
            let ratio = figure("ratio", registered / pairs);
            let records = vec![
                ratio,
                figure("registered", registered),
                figure("pairs", pairs),
            ];
            store.add(&Unit { scene, ..UNIT }, records).unwrap();
        }
        let selection = store.select("recall", "fpfh");
        let mean = selection.mean_spread("c", "ratio").unwrap().mean;
        assert!((mean - 2.0 / 3.0).abs() < 1e-12);
        let pooled = selection.ratio_spread("c", "registered", "pairs").unwrap();
        assert_eq!((pooled.mean, pooled.count), (0.5, 1));
        assert!(selection.mean_spread("d", "ratio").is_none());
    }
}

//! The program, and simulated scans to run it on.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use gmpcr::Registration;
use gmpcr::nalgebra::{Isometry3, Matrix3, Matrix3x4, Point3, Rotation3, Vector3};
use gmpcr_io::{ColoredCloud, Coordinates, write_merged_ply};
use gmpcr_sim::{DepthCamera, SimParams, SimulatedScans, simulate};
use serde_json::Value;
use tempfile::TempDir;

pub fn program(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gmpcr"));
    command.args(arguments);
    command
}

/// Runs the program; what it prints and its exit code.
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    pub fn of(arguments: &[&str]) -> Self {
        program(arguments).output().unwrap().into()
    }

    /// Runs the program, which must end with this exit code.
    pub fn ending_with(code: i32, arguments: &[&str]) -> Self {
        let run = Self::of(arguments);
        assert_eq!(
            run.code,
            Some(code),
            "{arguments:?}: {}{}",
            run.stdout,
            run.stderr
        );
        run
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap()
    }
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self {
            code: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }
}

/// A folder of inputs and a place for outputs, removed in the end.
pub struct Workplace(TempDir);

impl Workplace {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// With the simulated scans as PLY files in `scans`.
    pub fn with_scans() -> Self {
        let place = Self::new();
        for (k, cloud) in room().clouds.iter().enumerate() {
            write_ply(&place.create("scans").join(format!("scan_{k}.ply")), cloud);
        }
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn text(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    /// A folder in it.
    pub fn create(&self, name: &str) -> PathBuf {
        let path = self.path(name);
        fs::create_dir_all(&path).unwrap();
        path
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        fs::write(self.path(name), content).unwrap();
        self.text(name)
    }

    /// Registers the folder of a name into that of another; the content of `result.json`.
    pub fn register(&self, code: i32, scans: &str, out: &str, options: &[&str]) -> Value {
        let (scans, folder) = (self.text(scans), self.text(out));
        let arguments = [&["register", &scans, "-o", &folder], options].concat();
        Run::ending_with(code, &arguments);
        self.result(out)
    }

    pub fn result(&self, out: &str) -> Value {
        let text = fs::read_to_string(self.path(out).join("result.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    }

    pub fn files(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(folder)).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = names.collect();
        names.sort();
        names
    }
}

/// A few scans of a furnished room, and their ground truth.
pub fn room() -> &'static SimulatedScans {
    static ROOM: OnceLock<SimulatedScans> = OnceLock::new();
    ROOM.get_or_init(|| {
        let camera = DepthCamera {
            horizontal_fov: 1.4,
            ..DepthCamera::default()
        };
        simulate(&SimParams {
            num_scans: 6,
            camera,
            ..SimParams::default()
        })
        .unwrap()
    })
}

pub fn write_ply(path: &Path, points: &[Point3<f64>]) {
    let cloud = ColoredCloud {
        points,
        world_from_points: Isometry3::identity(),
        color: [0; 3],
    };
    write_merged_ply(path, Coordinates::Double, [cloud]).unwrap();
}

/// The pose of the 12 numbers of `[R | t]`.
pub fn pose(numbers: &Value) -> Isometry3<f64> {
    let numbers = numbers
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap());
    let matrix = Matrix3x4::from_row_iterator(numbers);
    let rotation: Matrix3<f64> = matrix.fixed_columns::<3>(0).into();
    let translation: Vector3<f64> = matrix.column(3).into();
    let rotation = Rotation3::from_matrix_unchecked(rotation);
    Isometry3::from_parts(translation.into(), rotation.into())
}

/// The registration of a result, as the library has it.
pub fn registration(result: &Value) -> Registration {
    serde_json::from_value(result["registration"].clone()).unwrap()
}

/// The poses of a result, which has all scans in one frame.
pub fn poses(result: &Value) -> Vec<Isometry3<f64>> {
    let registration = registration(result);
    assert_eq!(registration.components.members().len(), 1);
    registration.world_from_scan
}

/// The largest errors of the relative poses, in radians and meters.
fn largest_errors(poses: &[Isometry3<f64>], ground_truth: &[Isometry3<f64>]) -> (f64, f64) {
    let (mut rotation, mut translation) = (0f64, 0f64);
    for i in 0..poses.len() {
        for j in 0..i {
            let expected = ground_truth[i].inv_mul(&ground_truth[j]);
            let error = poses[i].inv_mul(&poses[j]).inverse() * expected;
            rotation = rotation.max(error.rotation.angle());
            translation = translation.max(error.translation.vector.norm());
        }
    }
    (rotation, translation)
}

/// All relative poses are within the 15° and 0.3 m by which benchmarks count a pair as registered.
pub fn assert_close(poses: &[Isometry3<f64>], ground_truth: &[Isometry3<f64>]) {
    let (rotation, translation) = largest_errors(poses, ground_truth);
    assert!(
        rotation < 0.26 && translation < 0.3,
        "off by {rotation} rad and {translation} m"
    );
}

/// The folder of real scans, if it is there.
pub fn real_data(scene: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("GMPCR_DATA") else {
        eprintln!("skipped: GMPCR_DATA names no folder of real scans");
        return None;
    };
    let folder = PathBuf::from(root).join(scene);
    if !folder.is_dir() {
        eprintln!("skipped: {} is not there, see GMPCR_DATA", folder.display());
        return None;
    }
    Some(folder)
}

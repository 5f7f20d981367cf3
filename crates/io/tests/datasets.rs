//! Scenes of each layout: small ones, complete and broken, and the real ones.
//!
//! The real scenes are in the folder that `GMPCR_DATA` names; without them the tests say that they skip.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

use gmpcr_io::{
    Error, Layout, LogEntry, Scene, read_npy_matrix, read_points, read_scene, scene_folders,
    write_gt_log, write_poses_3x4,
};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use tempfile::TempDir;

/// A folder to be filled, removed at the end.
struct Folder(TempDir);

impl Folder {
    /// A scene's folder with empty files of these names.
    fn with(names: &[&str]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        fs::create_dir(folder.root().join("kitchen")).unwrap();
        names.iter().for_each(|name| folder.write(name, ""));
        folder
    }

    fn with_clouds(num_scans: usize) -> Self {
        let folder = Self::with(&[]);
        folder.clouds("", num_scans);
        folder
    }

    fn root(&self) -> &Path {
        self.0.path()
    }

    fn scene(&self) -> PathBuf {
        self.root().join("kitchen")
    }

    /// Path of a file of the scene, whose folder is created.
    fn file(&self, name: &str) -> PathBuf {
        let path = self.scene().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        path
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.file(name), text).unwrap();
    }

    fn remove(&self, name: &str) {
        fs::remove_file(self.file(name)).unwrap();
    }

    fn clouds(&self, place: &str, num_scans: usize) {
        (0..num_scans).for_each(|i| self.write(&format!("{place}cloud_bin_{i}.ply"), ""));
    }

    fn log(&self, name: &str, pairs: &[(usize, usize)], num_scans: usize) {
        let entries: Vec<LogEntry> = pairs
            .iter()
            .map(|&(i, j)| LogEntry {
                i,
                j,
                num_scans,
                i_from_j: pose(j as f64),
            })
            .collect();
        write_gt_log(self.file(name), &entries).unwrap();
    }

    fn info(&self, name: &str, pairs: &[(usize, usize)], num_scans: usize) {
        let rows = "9 0 0 0 0 0\n".repeat(6);
        let entries = pairs
            .iter()
            .map(|(i, j)| format!("{i} {j} {num_scans}\n{rows}"));
        self.write(name, &entries.collect::<String>());
    }

    fn poses(&self, name: &str, scans: impl IntoIterator<Item = usize>) {
        let poses: Vec<_> = scans
            .into_iter()
            .map(|scan| (scan, pose(scan as f64)))
            .collect();
        write_poses_3x4(self.file(name), &poses).unwrap();
    }

    /// A matrix that is no finite number throughout, or that of scan `i`.
    fn pose(&self, name: &str, i: Option<usize>) {
        let matrix = i.map(|i| pose(i as f64).to_homogeneous());
        let entry = |row, column| matrix.map_or(f64::NEG_INFINITY, |matrix| matrix[(row, column)]);
        let row = |row| {
            format!(
                "{:?} {:?} {:?} {:?}\n",
                entry(row, 0),
                entry(row, 1),
                entry(row, 2),
                entry(row, 3)
            )
        };
        self.write(name, &(0..4).map(row).collect::<String>());
    }

    fn read(&self, layout: Layout) -> Scene {
        read_scene(self.scene(), layout).unwrap()
    }

    fn detect(&self) -> Option<Layout> {
        Layout::of(self.scene()).unwrap()
    }

    /// The error, which is to tell each of these things.
    fn complains(&self, layout: Layout, things: &[&str]) {
        let error = read_scene(self.scene(), layout).unwrap_err();
        assert!(matches!(error, Error::Incomplete { .. }), "{error}");
        let said = error.to_string();
        for thing in things.iter().chain(&["kitchen is incomplete: "]) {
            assert!(said.contains(thing), "{thing:?} is not in: {said}");
        }
        let Error::Incomplete { problems, .. } = error else {
            unreachable!()
        };
        assert_eq!(problems.len(), things.len(), "{said}");
    }
}

fn pose(x: f64) -> Isometry3<f64> {
    Isometry3::new(Vector3::new(x, 0.5, 0.0), Vector3::new(0.0, 0.3, 0.1 * x))
}

const PAIRS: [(usize, usize); 2] = [(0, 1), (0, 2)];

fn complete_3dmatch() -> Folder {
    let folder = Folder::with_clouds(3);
    folder.log("gt.log", &PAIRS, 3);
    folder.info("gt.info", &PAIRS, 3);
    folder
}

#[test]
fn a_scene_of_3dmatch_has_all_its_ground_truth() {
    let folder = complete_3dmatch();
    folder.log("gt_3dlomatch.log", &[(1, 2)], 3);
    folder.info("gt_3dlomatch.info", &[(1, 2)], 3);
    folder.write("overlap.csv", "i,j,mean,min\n0,1,0.5,0.25\n");
    folder.write("gt_overlap.log", "0,1,0.125\n");
    folder.poses("poses.txt", 0..3);
    folder.write("merged.ply", "");
    assert_eq!(folder.detect(), Some(Layout::ThreeDMatch));

    let scene = folder.read(Layout::ThreeDMatch);
    assert_eq!(scene.name, "kitchen");
    assert_eq!(scene.scans.len(), 3);
    let cloud = scene.scans[2].cloud.as_ref().unwrap();
    assert_eq!(*cloud, folder.file("cloud_bin_2.ply"));
    assert!(scene.scans[2].descriptors.is_none());

    let ground_truth = &scene.ground_truth;
    let names: Vec<&str> = ground_truth
        .pair_lists
        .iter()
        .map(|list| &*list.name)
        .collect();
    assert_eq!(names, ["3dlomatch", "gt"]);
    let gt = ground_truth.pair_list("gt").unwrap();
    assert_eq!(gt.file, folder.file("gt.log"));
    assert!(
        (gt.pairs[1].i_from_j.inverse() * pose(2.0))
            .rotation
            .angle()
            < 1e-12
    );
    assert_eq!(gt.information.as_ref().unwrap()[1][(0, 0)], 9.0);
    let overlaps = ground_truth.overlaps.as_ref().unwrap();
    let overlaps = overlaps.iter().map(|pair| (pair.i, pair.j, pair.overlap));
    assert_eq!(overlaps.collect::<Vec<_>>(), [(0, 1, 0.5)]);
    let poses = ground_truth.world_from_scan.as_ref().unwrap();
    assert!((poses[2].unwrap().translation.x - 2.0).abs() < 1e-12);
}

#[test]
fn the_official_lists_and_the_table_of_all_pairs_are_preferred() {
    let folder = Folder::with_clouds(2);
    for (name, num_pairs) in [("gt_3dmatch", 0), ("official_3dmatch", 1)] {
        folder.log(&format!("{name}.log"), &PAIRS[..num_pairs], 2);
        folder.info(&format!("{name}.info"), &PAIRS[..num_pairs], 2);
    }
    folder.write("gt_overlap.log", "");
    folder.write("official_gt_overlap.log", "0,1,0.25\n");
    let ground_truth = folder.read(Layout::ThreeDMatch).ground_truth;
    assert_eq!(ground_truth.pair_lists.len(), 1);
    assert_eq!(ground_truth.pair_list("3dmatch").unwrap().pairs.len(), 1);
    assert_eq!(ground_truth.overlaps.unwrap()[0].overlap, 0.25);
}

#[test]
fn the_ground_truth_may_lie_in_the_neighboring_folder_of_the_evaluation() {
    let folder = Folder::with_clouds(3);
    folder.log("../kitchen-evaluation/gt.log", &PAIRS, 3);
    folder.info("../kitchen-evaluation/gt.info", &PAIRS, 3);
    assert_eq!(folder.detect(), Some(Layout::ThreeDMatch));
    let ground_truth = folder.read(Layout::ThreeDMatch).ground_truth;
    assert!(ground_truth.pair_list("gt").unwrap().information.is_some());
    assert_eq!(scene_folders(folder.root()).unwrap(), [folder.scene()]);
}

#[test]
fn missing_scans_are_named_once_and_long_lists_are_cut() {
    let folder = complete_3dmatch();
    folder.remove("cloud_bin_1.ply");
    let missing = "missing clouds: cloud_bin_1.ply";
    folder.complains(
        Layout::ThreeDMatch,
        &[missing, "gt.log counts 3 scans, 2 are there"],
    );

    let folder = complete_3dmatch();
    folder.remove("cloud_bin_2.ply");
    let beyond = "gt.log names scans that are missing: cloud_bin_2.ply";
    folder.complains(
        Layout::ThreeDMatch,
        &[beyond, "gt.log counts 3 scans, 2 are there"],
    );

    let folder = Folder::with(&["cloud_bin_12.ply"]);
    let names =
        "cloud_bin_0.ply, cloud_bin_1.ply, cloud_bin_2.ply, cloud_bin_3.ply, cloud_bin_4.ply";
    folder.complains(
        Layout::ThreeDMatch,
        &[&format!("missing clouds: {names} and 7 more")],
    );

    let folder = Folder::with(&["PointCloud/cloud_bin_0.ply", "PointCloud/cloud_bin_2.ply"]);
    let missing = Path::new("PointCloud").join("cloud_bin_1.ply");
    folder.complains(Layout::ThreeDMatch, &[&missing.display().to_string()]);
}

#[test]
fn all_problems_are_told_at_once() {
    let folder = Folder::with(&["cloud_bin_0.ply", "cloud_bin_2.ply", "cloud_bin_2.pcd"]);
    folder.log("gt.log", &[(0, 7), (1, 1)], 60);
    folder.info("official_3dmatch.info", &PAIRS, 60);
    folder.write("overlap.csv", "0,9,0.5\n");
    folder.poses("poses.txt", [0, 0, 5]);
    folder.complains(
        Layout::ThreeDMatch,
        &[
            "missing clouds: cloud_bin_1.ply",
            "clouds of the same number: cloud_bin_2.pcd = cloud_bin_2.ply",
            "missing beside official_3dmatch.info: official_3dmatch.log",
            "missing beside gt.log: gt.info",
            "gt.log counts 60 scans, 2 are there",
            "gt.log names scans that are missing: cloud_bin_7.ply",
            "gt.log pairs scans with themselves: 1",
            "overlap.csv names scans that are missing: cloud_bin_9.ply",
            "poses.txt has 1 rows of scans that it had before",
            "poses.txt has no row of: cloud_bin_2.pcd",
            "poses.txt names scans that are missing: cloud_bin_5.ply",
        ],
    );
}

#[test]
fn log_and_info_of_different_pairs_are_refused() {
    let folder = complete_3dmatch();
    folder.info("gt.info", &PAIRS[..1], 3);
    let start = "gt.log and gt.info list different pairs: ";
    folder.complains(Layout::ThreeDMatch, &[&format!("{start}2 and 1 of them")]);
    folder.info("gt.info", &[(0, 1), (1, 2)], 3);
    let difference = format!("{start}(0, 2) where the other has (1, 2)");
    folder.complains(Layout::ThreeDMatch, &[&difference]);
    folder.complains(Layout::Eth, &[&difference]);
}

#[test]
fn a_broken_file_is_named_with_its_line() {
    let folder = complete_3dmatch();
    for (name, text) in [
        ("gt.log", "0 1 3\n1 0 0 0\n"),
        ("gt.info", "0 1\n"),
        ("overlap.csv", "0,1\n"),
        ("poses.txt", "1 2 3\n"),
    ] {
        let sound = fs::read(folder.file(name)).unwrap_or_default();
        folder.write(name, text);
        let said = read_scene(folder.scene(), Layout::ThreeDMatch)
            .unwrap_err()
            .to_string();
        assert!(said.contains(&format!("{name}:1: ")), "{said}");
        fs::write(folder.file(name), sound).unwrap();
    }
    assert!(read_scene(folder.scene().join("absent"), Layout::Eth).is_err());
    assert!(Layout::of(folder.scene().join("absent")).is_err());
}

#[test]
fn a_folder_without_scans_is_no_scene() {
    let folder = Folder::with(&["gt.log", "gt.info", "cloud.ply", "notes.txt"]);
    assert_eq!(folder.detect(), None);
    let layouts = [
        Layout::ThreeDMatch,
        Layout::Yoho,
        Layout::ScanNet,
        Layout::Eth,
    ];
    for layout in layouts {
        let error = read_scene(folder.scene(), layout).unwrap_err();
        assert!(matches!(error, Error::NothingFound { .. }), "{error}");
        assert!(error.to_string().contains("kitchen holds no "), "{error}");
    }
    let error = scene_folders(folder.root()).unwrap_err();
    assert!(matches!(error, Error::NothingFound { .. }), "{error}");
}

/// The folders of YOHO's release, and of SGHR's.
const YOHO_FILES: [&str; 4] = [
    "Keypoints_PC/cloud_bin_0Keypoints.npy",
    "Keypoints_PC/cloud_bin_1Keypoints.npy",
    "yoho_desc/0.npy",
    "yoho_desc/1.npy",
];

#[test]
fn keypoints_and_descriptors_of_two_folders_are_paired_by_number() {
    let other: [&[&str]; 3] = [
        &[
            "keypoints/0.npy",
            "keypoints/1.npy",
            "YOHO_Desc/0.npy",
            "YOHO_Desc/1.npy",
        ],
        &[
            "kpts/a_0.kpts.npy",
            "kpts/a_1.kpts.npy",
            "yoho/a_0.desc.npy",
            "yoho/a_1.desc.npy",
        ],
        &["0.kpts.npy", "1.kpts.npy", "0.desc.npy", "1.desc.npy"],
    ];
    for names in other.into_iter().chain([&YOHO_FILES[..]]) {
        let folder = Folder::with(names);
        folder.write("Keypoints/cloud_bin_0Keypoints.txt", "7\n");
        assert_eq!(folder.detect(), Some(Layout::Yoho), "{names:?}");
        let scene = folder.read(Layout::Yoho);
        assert_eq!(scene.scans.len(), 2);
        let set = scene.scans[1].descriptors.as_ref().unwrap();
        assert_eq!(set.name, "1");
        assert_eq!(set.keypoints, folder.file(names[1]));
        assert_eq!(set.descriptors, folder.file(names[3]));
        assert!(scene.scans[1].cloud.is_none());
    }
}

#[test]
fn a_scene_of_yoho_has_the_ground_truth_beside_its_clouds() {
    let folder = Folder::with(&YOHO_FILES);
    folder.clouds("PointCloud/", 2);
    folder.log("PointCloud/gt.log", &PAIRS[..1], 2);
    folder.log("PointCloud/gtLo.log", &[], 2);
    let scene = folder.read(Layout::Yoho);
    let cloud = scene.scans[1].cloud.as_ref().unwrap();
    assert_eq!(*cloud, folder.file("PointCloud/cloud_bin_1.ply"));
    assert_eq!(
        scene.ground_truth.pair_list("gt").unwrap().information,
        None
    );
    assert!(scene.ground_truth.pair_list("3dlomatch").is_some());

    folder.remove("yoho_desc/0.npy");
    folder.write("yoho_desc/7.npy", "");
    let path = |name| Path::new("yoho_desc").join(name).display().to_string();
    let missing = format!("missing descriptors: {}", path("0.npy"));
    let surplus = format!("descriptors of no scan: {}", path("7.npy"));
    folder.complains(Layout::Yoho, &[&missing, &surplus]);
}

#[test]
fn descriptors_without_clouds_are_numbered_without_gaps() {
    let folder = Folder::with(&["0.kpts.npy", "0.desc.npy", "2.kpts.npy", "2.desc.npy"]);
    folder.complains(Layout::Yoho, &["missing keypoints: 1.kpts.npy"]);
    folder.write("1.desc.npy", "");
    let surplus = "descriptors of no scan: 1.desc.npy";
    folder.complains(Layout::Yoho, &["missing keypoints: 1.kpts.npy", surplus]);
}

#[test]
fn poses_of_scans_come_from_either_place_and_may_be_unknown() {
    for (cloud, pose) in [
        ("cloud_bin_", "cloud_bin_"),
        ("scans/scan_00", "scans/scan_00"),
        ("scan_", "pose/"),
        ("PointCloud/cloud_bin_", "poses/00000"),
    ] {
        let folder = Folder::with(&[]);
        for scan in 0..3 {
            folder.write(&format!("{cloud}{scan}.pcd"), "");
            folder.pose(&format!("{pose}{scan}.txt"), (scan != 1).then_some(scan));
        }
        assert_eq!(folder.detect(), Some(Layout::ScanNet), "{pose}");
        let scene = folder.read(Layout::ScanNet);
        assert_eq!(scene.scans.len(), 3);
        let poses = scene.ground_truth.world_from_scan.unwrap();
        assert_eq!(poses.len(), 3);
        assert_eq!(poses[1], None);
        assert!((poses[2].unwrap().translation.x - 2.0).abs() < 1e-12);

        folder.remove(&format!("{pose}2.txt"));
        folder.pose(&format!("{pose}5.txt"), Some(5));
        let file = |i| Path::new(&format!("{pose}{i}.txt")).display().to_string();
        let [missing, surplus] = [file(2), file(5)];
        let missing = format!("missing poses: {missing}");
        folder.complains(
            Layout::ScanNet,
            &[&missing, &format!("poses of no scan: {surplus}")],
        );
    }
}

#[test]
fn one_table_of_poses_serves_as_well_and_may_have_unknown_ones() {
    let folder = Folder::with(&["scan_0.ply", "scan_1.ply"]);
    assert_eq!(folder.detect(), None);
    folder.complains(
        Layout::ScanNet,
        &["no poses: neither poses.txt nor pose/0.txt"],
    );
    let lost = "-inf ".repeat(12);
    folder.write(
        "poses.txt",
        &format!("0 1 0 0 7 0 1 0 0 0 0 1 0\n1 {lost}\n"),
    );
    assert_eq!(folder.detect(), Some(Layout::ScanNet));
    let poses = folder
        .read(Layout::ScanNet)
        .ground_truth
        .world_from_scan
        .unwrap();
    assert_eq!(poses, [Some(Isometry3::translation(7.0, 0.0, 0.0)), None]);
}

#[test]
fn clouds_of_free_names_need_a_number() {
    let folder = Folder::with(&["scan_0.ply", "merged.ply"]);
    folder.poses("poses.txt", [0]);
    folder.complains(Layout::ScanNet, &["clouds without a number: merged.ply"]);
}

#[test]
fn a_scene_of_eth_needs_pairs_but_no_information() {
    let folder = Folder::with(&[]);
    folder.clouds("PointCloud/", 3);
    folder.complains(Layout::Eth, &["no pairs: gt.log is missing"]);
    folder.log("PointCloud/gt.log", &PAIRS, 3);
    assert_eq!(folder.detect(), Some(Layout::Eth));
    let ground_truth = folder.read(Layout::Eth).ground_truth;
    let gt = ground_truth.pair_list("gt").unwrap();
    assert_eq!((gt.pairs.len(), &gt.information), (2, &None));
    let missing = Path::new("PointCloud")
        .join("gt.info")
        .display()
        .to_string();
    folder.complains(Layout::ThreeDMatch, &[&missing]);
}

#[test]
fn numbers_beyond_all_bounds_are_problems_and_no_panics() {
    let huge = usize::MAX;
    let folder = Folder::with_clouds(2);
    folder.log("gt.log", &[(0, huge)], huge);
    folder.write("overlap.csv", &format!("{huge},0,0.5\n"));
    folder.poses("poses.txt", [0, 1, huge]);
    folder.write(&format!("{huge}.kpts.npy"), "");
    folder.write(&format!("cloud_bin_{huge}0.ply"), "");
    for layout in [
        Layout::ThreeDMatch,
        Layout::Yoho,
        Layout::ScanNet,
        Layout::Eth,
    ] {
        let said = read_scene(folder.scene(), layout).unwrap_err().to_string();
        let missing = "missing clouds: cloud_bin_2.ply, cloud_bin_3.ply, ";
        assert!(said.contains(missing) && said.len() < 5000, "{said}");
        assert!(
            said.contains(&format!("gt.log counts {huge} scans, 3 are there")),
            "{said}"
        );
    }
    let mut scene = Scene::of_clouds(folder.scene()).unwrap();
    assert!(scene.attach_descriptors(folder.scene()).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_folder_causes_a_panic(
        files in proptest::collection::vec((
            proptest::sample::select(vec![
                "gt.log", "gt.info", "overlap.csv", "poses.txt", "pose/0.txt", "cloud_bin_0.txt",
                "PointCloud/cloud_bin_1.ply", "cloud_bin_0.ply", "scan_3.pcd", "0.kpts.npy",
                "Keypoints_PC/0.npy", "features/0.npy", "features", "poses", "cloud_bin_é7.ply",
            ]),
            "[0-9,.ij \\-\n]{0,40}",
        ), 0..8),
    ) {
        let folder = Folder::with(&[]);
        for (name, text) in &files {
            let path = folder.scene().join(name);
            if fs::create_dir_all(path.parent().unwrap()).is_ok() {
                // A folder may stand where a file should, and the reverse.
                let _ = fs::write(path, text);
            }
        }
        let detected = Layout::of(folder.scene());
        prop_assert!(detected.is_ok());
        for layout in [Layout::ThreeDMatch, Layout::Yoho, Layout::ScanNet, Layout::Eth] {
            if let Ok(scene) = read_scene(folder.scene(), layout) {
                prop_assert!(!scene.scans.is_empty());
                let poses = scene.ground_truth.world_from_scan;
                prop_assert!(poses.is_none_or(|poses| poses.len() == scene.scans.len()));
            }
        }
    }
}

/// The folder of real data if all of these are in it.
fn data(wanted: &[&str]) -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("GMPCR_DATA").unwrap_or_default());
    let absent = wanted.iter().find(|name| !folder.join(name).is_dir());
    match absent {
        None => Some(folder),
        Some(name) => {
            println!("skipped: no {name} in GMPCR_DATA={}", folder.display());
            None
        }
    }
}

/// Name, and numbers of scans, pairs of 3DMatch, pairs of 3DLoMatch, and overlaps.
const REAL: [(&str, [usize; 4]); 4] = [
    ("hotel_umd3", [37, 54, 49, 666]),
    ("mit_lab", [38, 77, 72, 703]),
    ("redkitchen", [60, 506, 525, 1770]),
    ("stanford_bunny", [10, 23, 13, 45]),
];

#[test]
fn real_scenes_are_complete() {
    let Some(data) = data(&REAL.map(|(name, _)| name)) else {
        return;
    };
    let scenes = scene_folders(&data).unwrap();
    for (name, counts) in REAL {
        let folder = data.join(name);
        assert!(scenes.contains(&folder), "{name} is not in {scenes:?}");
        assert_eq!(Layout::of(&folder).unwrap(), Some(Layout::ThreeDMatch));
        let scene = read_scene(&folder, Layout::ThreeDMatch).unwrap();
        let pairs = |list| scene.ground_truth.pair_list(list).unwrap().pairs.len();
        let overlaps = scene.ground_truth.overlaps.as_ref().unwrap().len();
        let found = [
            scene.scans.len(),
            pairs("3dmatch"),
            pairs("3dlomatch"),
            overlaps,
        ];
        assert_eq!((&*scene.name, found), (name, counts));

        let read = read_points(scene.scans[0].cloud.as_ref().unwrap()).unwrap();
        assert!(!read.points.is_empty());
        assert_poses_agree_with_pairs(&scene);
    }
}

/// The pairs were computed from the poses, up to the few digits of the files.
fn assert_poses_agree_with_pairs(scene: &Scene) {
    let poses = scene.ground_truth.world_from_scan.as_ref().unwrap();
    for list in &scene.ground_truth.pair_lists {
        assert_eq!(list.information.as_ref().unwrap().len(), list.pairs.len());
        for pair in &list.pairs {
            let i_from_j = poses[pair.i].unwrap().inv_mul(&poses[pair.j].unwrap());
            let difference = i_from_j.inv_mul(&pair.i_from_j);
            assert!(
                difference.rotation.angle() < 1e-3,
                "{} {pair:?}",
                scene.name
            );
            assert!(
                difference.translation.vector.norm() < 1e-3,
                "{} {pair:?}",
                scene.name
            );
        }
    }
}

#[test]
fn real_descriptors_are_attached_to_their_scans() {
    let Some(data) = data(&["redkitchen", "hotel_umd3", "mit_lab", "descriptors"]) else {
        return;
    };
    for name in ["redkitchen", "hotel_umd3", "mit_lab"] {
        let learned = data.join("descriptors").join(name);
        let mut scene = read_scene(data.join(name), Layout::ThreeDMatch).unwrap();
        scene.attach_descriptors(&learned).unwrap();
        for (i, scan) in scene.scans.iter().enumerate() {
            let set = scan.descriptors.as_ref().unwrap();
            assert_eq!(set.keypoints, learned.join(format!("{i}.kpts.npy")));
            assert_eq!(set.descriptors, learned.join(format!("{i}.desc.npy")));
        }
        let set = scene.scans[1].descriptors.as_ref().unwrap();
        let keypoints = read_npy_matrix(&set.keypoints).unwrap();
        let descriptors = read_npy_matrix(&set.descriptors).unwrap();
        assert_eq!((keypoints.columns, descriptors.columns), (3, 32));
        assert_eq!(keypoints.rows, descriptors.rows);
        #[cfg(feature = "scans")]
        assert_eq!(set.read().unwrap().len(), keypoints.rows);

        let mut other = read_scene(data.join("redkitchen"), Layout::ThreeDMatch).unwrap();
        assert_eq!(
            other.attach_descriptors(&learned).is_ok(),
            name == "redkitchen"
        );
    }
    let scenes = scene_folders(data.join("descriptors")).unwrap();
    assert!(scenes.len() >= 3);
    for folder in scenes {
        assert_eq!(Layout::of(&folder).unwrap(), Some(Layout::Yoho));
        assert!(read_scene(&folder, Layout::Yoho).unwrap().scans.len() > 30);
    }
}

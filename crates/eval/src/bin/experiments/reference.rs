//! Figures of others, printed beside ours.
//!
//! From the paper: its tables. From other systems: measured on graphs of the same kind (another random generator, other seeds), Open3D 0.20,
//! GTSAM 4.3, COLMAP 4.2 (GLOMAP's rotation averaging), SE-Sync of 2022-07, SGHR's synchroniser; mean /
//! median over the scans, three seeds.

use crate::experiment::Experiment;
use crate::table::Table;

/// The paper's tables that belong to an experiment.
pub fn tables(experiment: Experiment) -> Vec<Table> {
    match experiment {
        Experiment::Recall => vec![recall(), pose_errors()],
        Experiment::Ablation => vec![ablation()],
        Experiment::Views => vec![views()],
        Experiment::Retrieval => vec![retrieval()],
        Experiment::Connectivity => vec![connectivity()],
        Experiment::Sync => Vec::new(),
        Experiment::Time => vec![time()],
    }
}

fn table<const N: usize>(title: &str, header: [&str; N], rows: &[[&str; N]]) -> Table {
    let mut table = Table::new(format!("In the paper: {title}"), header);
    rows.iter().for_each(|row| table.row(*row));
    table
}

/// Paper, table "Registration recall on 3DMatch, 3DLoMatch, and ETH".
fn recall() -> Table {
    table(
        "registration recall (%), 8 scenes of 3DMatch and 4 of ETH, YOHO descriptors but for RAP",
        ["method", "3DMatch", "3DLoMatch", "ETH"],
        &[
            ["EIGSE3", "40.1", "26.5", "96.3"],
            ["L1-IRLS", "68.6", "49.0", "90.2"],
            ["RotAvg", "77.2", "60.3", "96.6"],
            ["LITS", "80.8", "65.2", "48.4"],
            ["HARA", "83.8", "71.9", "96.0"],
            ["SGHR", "96.2", "81.6", "99.1"],
            ["SMVR", "96.7", "83.0", "99.6"],
            ["RAP", "85.6", "73.0", "99.8"],
            ["GMPCR", "97.2", "89.6", "99.7"],
        ],
    )
}

/// Paper, table "Rotation and translation error on ScanNet".
fn pose_errors() -> Table {
    table(
        "shares under thresholds (%) and errors on ScanNet",
        [
            "method",
            "3°",
            "5°",
            "10°",
            "30°",
            "45°",
            "mean (°)",
            "median (°)",
            "0.05 m",
            "0.1 m",
            "0.25 m",
            "0.5 m",
            "0.75 m",
            "mean (m)",
            "median (m)",
        ],
        &[
            [
                "EIGSE3", "40.8", "46.3", "51.9", "61.2", "65.7", "40.6", "37.1", "23.9", "38.5",
                "51.0", "59.3", "66.1", "0.88", "0.84",
            ],
            [
                "L1-IRLS", "46.3", "54.2", "61.6", "64.3", "66.8", "41.8", "34.0", "24.1", "38.5",
                "48.3", "55.6", "60.9", "1.05", "1.01",
            ],
            [
                "RotAvg", "50.2", "60.1", "65.3", "66.8", "68.8", "38.5", "31.6", "31.8", "49.0",
                "58.8", "63.3", "65.6", "0.96", "0.83",
            ],
            [
                "LITS", "54.3", "69.4", "75.6", "78.5", "80.3", "24.9", "19.9", "31.4", "54.4",
                "72.3", "76.7", "79.6", "0.65", "0.56",
            ],
            [
                "HARA", "55.7", "63.7", "69.0", "70.8", "72.1", "34.7", "31.3", "35.2", "53.6",
                "65.4", "68.6", "71.7", "0.86", "0.71",
            ],
            [
                "LMVR", "48.3", "53.6", "58.9", "63.2", "64.0", "48.1", "33.7", "34.5", "49.1",
                "58.5", "61.6", "63.9", "0.83", "0.55",
            ],
            [
                "SGHR", "59.1", "73.1", "80.8", "82.5", "83.0", "21.7", "19.0", "39.9", "64.1",
                "76.7", "79.0", "81.9", "0.56", "0.49",
            ],
            [
                "SMVR", "58.0", "71.4", "80.0", "86.0", "86.5", "18.9", "17.6", "39.0", "61.7",
                "76.6", "81.5", "84.8", "0.46", "0.44",
            ],
            [
                "RAP", "33.1", "41.0", "49.5", "60.1", "64.4", "44.1", "28.0", "20.9", "33.2",
                "46.8", "56.1", "62.0", "1.05", "0.85",
            ],
            [
                "GMPCR", "54.8", "70.9", "83.4", "86.3", "86.6", "20.2", "19.2", "35.4", "59.7",
                "79.4", "82.8", "84.4", "0.46", "0.40",
            ],
        ],
    )
}

/// Paper, table "Ablation study on 3DMatch and 3DLoMatch".
fn ablation() -> Table {
    table(
        "ablation, registration recall (%), 8 scenes, YOHO descriptors",
        ["configuration", "3DMatch", "3DLoMatch"],
        &[
            ["baseline", "91.6", "82.5"],
            ["+ pair selection", "96.0", "88.7"],
            ["+ spectral filtering", "96.4", "89.0"],
            ["+ memory coefficient", "97.0", "89.5"],
            ["+ recovery term (full)", "97.2", "89.6"],
        ],
    )
}

/// Paper, table "Registration recall (%) under increasing numbers of views".
fn views() -> Table {
    table(
        "registration recall (%) over the number of views, 6 scenes of more than 50",
        ["list, method", "10", "20", "30", "40", "50", "all"],
        &[
            [
                "3DMatch, SGHR",
                "77.4",
                "92.1",
                "92.4",
                "94.4",
                "95.3",
                "95.3",
            ],
            [
                "3DMatch, SMVR",
                "84.9",
                "89.1",
                "90.6",
                "84.8",
                "92.3",
                "95.8",
            ],
            [
                "3DMatch, RAP",
                "74.5",
                "83.8",
                "86.7",
                "88.3",
                "84.0",
                "87.7",
            ],
            [
                "3DMatch, GMPCR",
                "84.0",
                "94.4",
                "95.4",
                "96.0",
                "97.0",
                "96.9",
            ],
            [
                "3DLoMatch, SGHR",
                "62.6",
                "72.3",
                "80.4",
                "81.2",
                "82.2",
                "83.3",
            ],
            [
                "3DLoMatch, SMVR",
                "60.2",
                "72.7",
                "75.8",
                "72.4",
                "79.7",
                "80.1",
            ],
            [
                "3DLoMatch, RAP",
                "56.1",
                "68.5",
                "77.1",
                "79.7",
                "75.4",
                "78.4",
            ],
            [
                "3DLoMatch, GMPCR",
                "74.0",
                "80.6",
                "87.4",
                "90.4",
                "92.5",
                "93.4",
            ],
        ],
    )
}

/// Paper, table "Scan-pair retrieval quality for pose graph construction".
fn retrieval() -> Table {
    table(
        "retrieval of overlapping pairs",
        [
            "data set, ranking",
            "R@4 (%)",
            "R@8 (%)",
            "R@12 (%)",
            "regret at 4",
            "regret at 8",
            "regret at 12",
        ],
        &[
            [
                "3DLoMatch, SGHR",
                "60.3",
                "61.5",
                "60.6",
                "0.0866",
                "0.0749",
                "0.0617",
            ],
            [
                "3DLoMatch, SMVR",
                "63.2",
                "62.5",
                "62.9",
                "0.0820",
                "0.0699",
                "0.0552",
            ],
            [
                "3DLoMatch, GMPCR",
                "73.2",
                "74.5",
                "72.7",
                "0.0380",
                "0.0322",
                "0.0287",
            ],
            [
                "ScanNet, SGHR",
                "71.0",
                "69.1",
                "70.1",
                "0.0664",
                "0.0694",
                "0.0576",
            ],
            [
                "ScanNet, SMVR",
                "74.8",
                "73.8",
                "73.1",
                "0.0485",
                "0.0498",
                "0.0461",
            ],
            [
                "ScanNet, GMPCR",
                "78.0",
                "77.7",
                "76.7",
                "0.0311",
                "0.0354",
                "0.0338",
            ],
            [
                "ETH, SGHR",
                "77.3",
                "63.3",
                "63.2",
                "0.0235",
                "0.0276",
                "0.0247",
            ],
            [
                "ETH, SMVR",
                "85.7",
                "70.1",
                "67.5",
                "0.0133",
                "0.0209",
                "0.0188",
            ],
            [
                "ETH, GMPCR",
                "86.4",
                "79.0",
                "77.9",
                "0.0076",
                "0.0088",
                "0.0096",
            ],
        ],
    )
}

/// Paper, table "Connectivity of pose graphs constructed by GMPCR under different Top-K settings".
fn connectivity() -> Table {
    table(
        "connectivity over K, 8 scenes, YOHO descriptors",
        [
            "list, K",
            "connected",
            "C max",
            "LCC min (%)",
            "R min (%)",
            "mean edges",
        ],
        &[
            ["3DMatch, 1", "0/8", "19", "8.8", "3.3", "39.0"],
            ["3DMatch, 2", "3/8", "5", "42.1", "42.1", "73.4"],
            ["3DMatch, 3", "6/8", "3", "57.9", "57.9", "106.9"],
            ["3DMatch, 4", "6/8", "3", "57.9", "57.9", "139.5"],
            ["3DMatch, 5", "8/8", "1", "100.0", "100.0", "173.0"],
            ["3DMatch, 6", "8/8", "1", "100.0", "100.0", "206.2"],
            ["3DMatch, 7", "8/8", "1", "100.0", "100.0", "237.6"],
            ["3DMatch, 8", "8/8", "1", "100.0", "100.0", "271.6"],
            ["3DMatch, 9", "8/8", "1", "100.0", "100.0", "304.6"],
            ["3DMatch, 10", "8/8", "1", "100.0", "100.0", "337.2"],
            ["3DLoMatch, 1", "0/8", "18", "8.3", "3.3", "39.0"],
            ["3DLoMatch, 2", "1/8", "5", "42.1", "6.7", "72.0"],
            ["3DLoMatch, 3", "5/8", "3", "45.9", "45.9", "105.1"],
            ["3DLoMatch, 4", "6/8", "2", "76.3", "76.3", "138.2"],
            ["3DLoMatch, 5", "7/8", "2", "76.3", "76.3", "171.6"],
            ["3DLoMatch, 6", "7/8", "2", "76.3", "76.3", "203.8"],
            ["3DLoMatch, 7", "7/8", "2", "76.3", "76.3", "236.4"],
            ["3DLoMatch, 8", "8/8", "1", "100.0", "100.0", "270.1"],
            ["3DLoMatch, 9", "8/8", "1", "100.0", "100.0", "303.6"],
            ["3DLoMatch, 10", "8/8", "1", "100.0", "100.0", "335.8"],
        ],
    )
}

/// Paper, table "Average runtime for registering one 3DMatch scene".
fn time() -> Table {
    table(
        "average time per scene of 3DMatch (s)",
        ["method", "main module", "synchronisation", "total"],
        &[
            ["SGHR", "37.1", "2.3", "39.4"],
            ["SMVR", "38.1", "5.2", "43.3"],
            ["RAP", "–", "–", "10.4"],
            ["GMPCR", "23.3", "0.4", "23.7"],
        ],
    )
}

/// Share of wrong edges in percent and "mean / median" rotation error in degrees.
type Figures = &'static [(u32, &'static str)];

/// Other systems on a family of pose graphs: name, figures, time in milliseconds.
pub fn synchronization(family: &str) -> &'static [(&'static str, Figures, &'static str)] {
    match family {
        "uniform" => &[
            (
                "maximal spanning tree",
                &[
                    (0, "5.0 / 4.6"),
                    (10, "20 / 6.1"),
                    (20, "34 / 5.3"),
                    (30, "64 / 33"),
                    (40, "93 / 101"),
                    (50, "100 / 114"),
                    (60, "102 / 107"),
                ],
                "1",
            ),
            (
                "Open3D, tree and global optimization",
                &[
                    (0, "3.2 / 2.9"),
                    (10, "19 / 4.9"),
                    (20, "33 / 4.7"),
                    (30, "64 / 32"),
                    (40, "93 / 100"),
                    (50, "100 / 114"),
                    (60, "102 / 107"),
                ],
                "12–170",
            ),
            (
                "GTSAM, chordal and LM",
                &[
                    (0, "0.57 / 0.50"),
                    (10, "23 / 17"),
                    (20, "37 / 32"),
                    (30, "50 / 44"),
                    (40, "66 / 59"),
                    (50, "92 / 89"),
                    (60, "100 / 97"),
                ],
                "13–130",
            ),
            (
                "GTSAM, LM with Cauchy loss",
                &[
                    (0, "0.64 / 0.54"),
                    (10, "0.71 / 0.56"),
                    (20, "1.63 / 0.65"),
                    (30, "0.89 / 0.70"),
                    (40, "8.2 / 0.86"),
                    (50, "31 / 2.3"),
                    (60, "50 / 2.3"),
                ],
                "25–84",
            ),
            (
                "GTSAM, LM with Geman–McClure loss",
                &[
                    (0, "0.72 / 0.58"),
                    (10, "0.80 / 0.64"),
                    (20, "2.11 / 0.79"),
                    (30, "3.78 / 0.79"),
                    (40, "7.4 / 1.02"),
                    (50, "28 / 3.0"),
                    (60, "63 / 33"),
                ],
                "35–96",
            ),
            (
                "GTSAM, GNC with truncated squares",
                &[
                    (0, "0.58 / 0.51"),
                    (10, "0.65 / 0.53"),
                    (20, "1.88 / 0.60"),
                    (30, "1.68 / 0.65"),
                    (40, "15 / 0.80"),
                    (50, "40 / 25"),
                    (60, "88 / 70"),
                ],
                "57–700",
            ),
            (
                "GTSAM, Shonan with Huber loss",
                &[
                    (0, "1.16 / 1.07"),
                    (10, "1.26 / 1.15"),
                    (20, "1.96 / 1.28"),
                    (30, "2.46 / 1.45"),
                    (40, "10.6 / 1.75"),
                    (50, "11.6 / 2.0"),
                    (60, "67 / 42"),
                ],
                "53–135",
            ),
            (
                "COLMAP, rotation averaging",
                &[
                    (0, "1.21 / 1.10"),
                    (10, "1.30 / 1.16"),
                    (20, "2.06 / 1.23"),
                    (30, "1.67 / 1.40"),
                    (40, "10.8 / 1.75"),
                    (50, "46 / 34"),
                    (60, "78 / 85"),
                ],
                "16–31",
            ),
            (
                "COLMAP, then GTSAM with Geman–McClure loss",
                &[
                    (0, "0.72 / 0.58"),
                    (10, "0.82 / 0.64"),
                    (20, "2.09 / 0.78"),
                    (30, "1.08 / 0.85"),
                    (40, "4.9 / 0.97"),
                    (50, "19 / 1.8"),
                    (60, "48 / 23"),
                ],
                "42–67",
            ),
            (
                "SGHR, its own program, 50 iterations",
                &[
                    (0, "1.62 / 1.54"),
                    (20, "1.75 / 1.62"),
                    (40, "7.6 / 2.13"),
                    (60, "53 / 30"),
                ],
                "1800–2000",
            ),
            (
                "SE-Sync",
                &[
                    (0, "0.57 / 0.50"),
                    (20, "31 / 22"),
                    (40, "77 / 68"),
                    (60, "95 / 96"),
                ],
                "26–106",
            ),
        ],
        "coherent" => &[
            (
                "GTSAM, LM with Geman–McClure loss",
                &[(20, "2.7 / 0.79"), (40, "14 / 1.2")],
                "–",
            ),
            (
                "GTSAM, GNC with truncated squares",
                &[(20, "1.44 / 0.60"), (40, "7.8 / 0.76")],
                "–",
            ),
            (
                "GTSAM, Shonan with Huber loss",
                &[(20, "1.47 / 1.23"), (40, "6.1 / 1.9")],
                "–",
            ),
            (
                "COLMAP, rotation averaging",
                &[(20, "1.40 / 1.21"), (40, "22 / 2.0")],
                "–",
            ),
            (
                "COLMAP, then GTSAM with Geman–McClure loss",
                &[(20, "1.65 / 0.78"), (40, "14 / 1.2")],
                "–",
            ),
        ],
        "informative" => &[
            (
                "Open3D, tree and global optimization",
                &[(20, "5.3 / 4.5"), (40, "8.5 / 6.4"), (60, "11.6 / 5.8")],
                "–",
            ),
            (
                "GTSAM, LM with Geman–McClure loss",
                &[(20, "2.9 / 0.70"), (40, "12 / 1.1"), (60, "79 / 65")],
                "–",
            ),
            (
                "GTSAM, GNC with truncated squares",
                &[(20, "1.88 / 0.59"), (40, "8.2 / 0.73"), (60, "60 / 38")],
                "–",
            ),
            (
                "COLMAP, then GTSAM with Geman–McClure loss",
                &[(20, "1.80 / 0.68"), (40, "6.0 / 0.87"), (60, "34 / 2.1")],
                "–",
            ),
            (
                "GTSAM, Shonan with Huber loss",
                &[(20, "2.5 / 1.2"), (40, "4.8 / 1.65"), (60, "18.7 / 2.5")],
                "–",
            ),
            (
                "SGHR, its own program, 50 iterations",
                &[(20, "1.67 / 1.63"), (40, "5.6 / 2.0"), (60, "12.0 / 2.9")],
                "–",
            ),
        ],
        "geometric500" => &[
            (
                "COLMAP, rotation averaging",
                &[(0, "1.60 / 1.46"), (20, "4.2 / 1.64"), (40, "85 / 121")],
                "120–170",
            ),
            (
                "GTSAM, LM with Geman–McClure loss",
                &[(0, "1.58 / 1.42"), (20, "3.8 / 1.66"), (40, "12.7 / 2.07")],
                "600–1500",
            ),
            (
                "COLMAP, then GTSAM with Geman–McClure loss",
                &[(0, "1.59 / 1.43"), (20, "2.8 / 1.68"), (40, "6.8 / 2.03")],
                "780–1100",
            ),
            (
                "GTSAM, GNC with truncated squares",
                &[(0, "1.21 / 1.09"), (20, "timeout"), (40, "timeout")],
                "810",
            ),
            (
                "GTSAM, Shonan with Huber loss",
                &[(0, "1.54 / 1.38"), (20, "4.9 / 1.56"), (40, "21 / 2.8")],
                "1500–2500",
            ),
            ("SE-Sync", &[(0, "1.18 / 1.06"), (20, "65 / 54")], "270–800"),
            (
                "Open3D, tree and global optimization",
                &[(0, "timeout"), (20, "timeout"), (40, "107 / 107")],
                "5400",
            ),
        ],
        "geometric5000" => &[
            (
                "COLMAP, rotation averaging",
                &[(0, "1.68 / 1.54"), (20, "7.5 / 1.81"), (40, "117 / 119")],
                "2900–3700",
            ),
            (
                "GTSAM, LM with Geman–McClure loss",
                &[(0, "1.76 / 1.63"), (20, "timeout"), (40, "timeout")],
                "29900",
            ),
        ],
        _ => &[],
    }
}

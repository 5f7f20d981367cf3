//! All synchronisation methods on pose graphs of which a share of the edges is wrong.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::Instant;

use gmpcr::posegraph::{PoseEdge, PoseGraph};
use gmpcr::sync::{Method, SyncParams, synchronize};
use gmpcr_eval::{Gauge, PoseError, absolute_errors};
use gmpcr_io::{G2o, G2oEdge, G2oVertex, read_g2o, write_g2o};
use gmpcr_sim::{EdgeWeights, Outliers, PoseGraphSimParams, Topology, simulate_pose_graph};
use nalgebra::{Isometry3, Matrix6, Vector6};
use rand::RngExt;
use rayon::prelude::*;

use crate::arguments::Arguments;
use crate::figures::{Panel, Series, write_figure};
use crate::progress::Progress;
use crate::records::{Record, Selection, Store, Unit};
use crate::reference;
use crate::registering::generator;
use crate::scene::fingerprint;
use crate::table::{Table, number};

const EXPERIMENT: &str = "sync";
const FILES: &str = "files";
const STATISTICS: [&str; 5] = [
    "rotation mean",
    "rotation median",
    "translation mean",
    "translation median",
    "seconds",
];

/// Header of the column of times.
const TIME: &str = "ms";

/// A family of simulated graphs: one table.
struct Family {
    name: &'static str,
    title: &'static str,
    params: PoseGraphSimParams,
    /// Shares of wrong edges in percent.
    outliers: &'static [u32],
    /// Graphs per share, in multiples of the runs that are asked for.
    graphs_per_run: usize,
}

fn families() -> Vec<Family> {
    let random = PoseGraphSimParams::default();
    let geometric = |num_scans| PoseGraphSimParams {
        num_scans,
        topology: Topology::Geometric,
        ..random
    };
    let family = |name, title, params, outliers, graphs_per_run| Family {
        name,
        title,
        params,
        outliers,
        graphs_per_run,
    };
    let coherent = PoseGraphSimParams {
        outliers: Outliers::Coherent,
        ..random
    };
    let informative = PoseGraphSimParams {
        weights: EdgeWeights::Informative,
        ..random
    };
    vec![
        family(
            "uniform",
            "50 scans, random edges, uniform outliers",
            random,
            &[0, 10, 20, 30, 40, 50, 60],
            4,
        ),
        family(
            "coherent",
            "50 scans, random edges, self-consistent outliers",
            coherent,
            &[10, 20, 30, 40, 50, 60],
            4,
        ),
        family(
            "informative",
            "50 scans, random edges, uniform outliers, weights that tell",
            informative,
            &[20, 40, 60],
            4,
        ),
        family(
            "geometric500",
            "500 scans, edges between neighbours, uniform outliers",
            geometric(500),
            &[0, 20, 40],
            1,
        ),
        family(
            "geometric5000",
            "5000 scans, edges between neighbours, uniform outliers",
            geometric(5000),
            &[0, 20, 40],
            0,
        ),
    ]
}

impl Family {
    fn num_graphs(&self, num_runs: usize) -> usize {
        (self.graphs_per_run * num_runs).max(1)
    }
}

/// A pose graph and its true poses.
struct Problem {
    graph: PoseGraph,
    world_from_scan: Vec<Isometry3<f64>>,
}

/// Units of work: a share of wrong edges of a family, or a file.
pub fn num_units(arguments: &Arguments) -> usize {
    let of_families = families()
        .iter()
        .map(|family| family.outliers.len())
        .sum::<usize>();
    of_families + arguments.graphs.len()
}

/// Runs what is not in the store yet.
pub fn run_all(
    arguments: &Arguments,
    store: &mut Store,
    progress: &Progress,
    failures: &mut Vec<String>,
) {
    for family in families() {
        for &percent in family.outliers {
            let label = format!("{}, {percent} % wrong", family.title);
            let unit = Unit {
                experiment: EXPERIMENT,
                descriptors: family.name,
                scene: &scene_of(percent),
                input: "simulated",
            };
            let run = || run_family(&family, percent, arguments);
            run_unit(&unit, label, run, store, progress, failures);
        }
    }
    for file in &arguments.graphs {
        let input = fingerprint(&[file]);
        let unit = Unit {
            experiment: EXPERIMENT,
            descriptors: FILES,
            scene: &file.display().to_string().replace(['/', '\\'], "_"),
            input: &input,
        };
        let label = file.display().to_string();
        let run = || read_problem(file).and_then(|problem| run_methods(&problem, 0));
        run_unit(&unit, label, run, store, progress, failures);
    }
}

fn run_unit(
    unit: &Unit,
    label: String,
    run: impl FnOnce() -> Result<Vec<Record>, Box<dyn Error>>,
    store: &mut Store,
    progress: &Progress,
    failures: &mut Vec<String>,
) {
    if !store.holds(unit) {
        progress.begin(label.clone());
        let outcome = run().and_then(|records| store.add(unit, records));
        failures.extend(outcome.err().map(|error| format!("{label}: {error}")));
    }
    progress.advance(1);
}

/// Shares sort as their names do.
fn scene_of(percent: u32) -> String {
    format!("{percent:02}")
}

/// All graphs of a family with this share of wrong edges; the first is kept as a file.
fn run_family(
    family: &Family,
    percent: u32,
    arguments: &Arguments,
) -> Result<Vec<Record>, Box<dyn Error>> {
    let mut records = Vec::new();
    for run in 0..family.num_graphs(arguments.runs as usize) {
        let params = PoseGraphSimParams {
            seed: generator(arguments.seed, run, percent as usize).random(),
            outlier_share: f64::from(percent) / 100.0,
            ..family.params
        };
        let problem = simulated_problem(&params)?;
        if run == 0 {
            let folder = arguments.out.join("graphs");
            fs::create_dir_all(&folder)?;
            let file = folder.join(format!("{}_{}.g2o", family.name, scene_of(percent)));
            write_problem(&file, &problem, &params)?;
        }
        records.extend(run_methods(&problem, run)?);
    }
    Ok(records)
}

fn simulated_problem(params: &PoseGraphSimParams) -> Result<Problem, Box<dyn Error>> {
    let simulated = simulate_pose_graph(params)?;
    let edges = simulated.edges.iter().map(|edge| PoseEdge {
        i: edge.i,
        j: edge.j,
        i_from_j: edge.i_from_j,
        weight: edge.weight,
    });
    Ok(Problem {
        graph: PoseGraph::new(params.num_scans, edges.collect())?,
        world_from_scan: simulated.world_from_scan,
    })
}

/// Writes a graph with the true poses as vertices, for other programs and for `--graphs`.
fn write_problem(
    file: &Path,
    problem: &Problem,
    params: &PoseGraphSimParams,
) -> Result<(), gmpcr_io::Error> {
    let (rotation, translation) = (
        params.rotation_noise.powi(-2),
        params.translation_noise.powi(-2),
    );
    let [t, r] = [translation, rotation];
    let information = Matrix6::from_diagonal(&Vector6::new(t, t, t, r, r, r));
    let vertices = problem.world_from_scan.iter().enumerate();
    let edges = problem.graph.edges().iter();
    let graph = G2o {
        vertices: vertices
            .map(|(id, pose)| G2oVertex {
                id,
                world_from_vertex: *pose,
            })
            .collect(),
        edges: edges
            .map(|edge| G2oEdge {
                i: edge.i,
                j: edge.j,
                i_from_j: edge.i_from_j,
                information,
            })
            .collect(),
    };
    write_g2o(file, &graph)
}

/// Reads a graph whose vertices are the truth; all edges weigh the same.
fn read_problem(file: &Path) -> Result<Problem, Box<dyn Error>> {
    let read = read_g2o(file)?;
    let vertices = read.vertices.iter().enumerate();
    let places: BTreeMap<usize, usize> = vertices.map(|(place, v)| (v.id, place)).collect();
    let place = |id: usize| {
        let place = places.get(&id).copied();
        place.ok_or_else(|| format!("vertex {id} of an edge has no VERTEX_SE3:QUAT"))
    };
    let edge = |edge: &G2oEdge| {
        Ok(PoseEdge {
            i: place(edge.i)?,
            j: place(edge.j)?,
            i_from_j: edge.i_from_j,
            weight: 1.0,
        })
    };
    let edges: Result<Vec<_>, String> = read.edges.iter().map(edge).collect();
    let poses = read.vertices.iter().map(|vertex| vertex.world_from_vertex);
    Ok(Problem {
        graph: PoseGraph::new(read.vertices.len(), edges?)?,
        world_from_scan: poses.collect(),
    })
}

fn run_methods(problem: &Problem, run: usize) -> Result<Vec<Record>, Box<dyn Error>> {
    let records = Method::ALL
        .par_iter()
        .map(|method| run_method(problem, *method, run));
    let records: Result<Vec<_>, gmpcr_eval::Error> = records.collect();
    Ok(records?.concat())
}

fn run_method(
    problem: &Problem,
    method: Method,
    run: usize,
) -> Result<Vec<Record>, gmpcr_eval::Error> {
    let params = SyncParams {
        method,
        ..SyncParams::default()
    };
    let start = Instant::now();
    let found = synchronize(&problem.graph, &params);
    let seconds = start.elapsed().as_secs_f64();
    let mut errors = Vec::new();
    for scans in found.components.members() {
        let of_component =
            |poses: &[Isometry3<f64>]| scans.iter().map(|&scan| poses[scan]).collect::<Vec<_>>();
        let estimated = of_component(&found.world_from_scan);
        let truth = of_component(&problem.world_from_scan);
        errors.extend(absolute_errors(&estimated, &truth, Gauge::LeastAbsolute)?);
    }
    let mut degrees: Vec<f64> = errors.iter().map(PoseError::rotation_degrees).collect();
    let mut metres: Vec<f64> = errors.iter().map(|error| error.translation).collect();
    let values = [
        mean(&degrees),
        median(&mut degrees),
        mean(&metres),
        median(&mut metres),
        seconds,
    ];
    let record = |(statistic, value)| Record::new(method.name(), run, statistic, value);
    Ok(STATISTICS.into_iter().zip(values).map(record).collect())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = [values.len().saturating_sub(1) / 2, values.len() / 2];
    middle
        .map(|k| values.get(k).copied().unwrap_or(0.0))
        .iter()
        .sum::<f64>()
        / 2.0
}

pub fn report(store: &Store, folder: &Path, text: &mut String) -> Result<(), Box<dyn Error>> {
    let mut panels = Vec::new();
    for family in families() {
        let records = store.select(EXPERIMENT, family.name);
        if !records.scenes.is_empty() {
            report_family(&family, &records, text);
            panels.push(panel(&family, &records));
        }
    }
    if !panels.is_empty() {
        write_figure(&folder.join("sync.svg"), &panels)?;
    }
    let records = store.select(EXPERIMENT, FILES);
    for (scene, _) in &records.scenes {
        let header = ["method"].into_iter().chain(STATISTICS);
        let mut table = Table::new(format!("{scene}: errors (°, m) and time"), header);
        for method in records.configurations() {
            let figure =
                |statistic| number(records.scene_spread(scene, &method, statistic), 1.0, 3);
            table.row([method.clone()].into_iter().chain(STATISTICS.map(figure)));
        }
        table.append_to(text);
    }
    Ok(())
}

/// Mean rotation error of each method over the share of wrong edges.
fn panel(family: &Family, records: &Selection) -> Panel {
    let line = |method: String| {
        let points = family.outliers.iter().filter_map(|&percent| {
            let error = records.scene_spread(&scene_of(percent), &method, "rotation mean")?;
            Some((f64::from(percent), error.mean))
        });
        Series::new(method.clone(), points.collect())
    };
    let lines: Vec<_> = records.configurations().into_iter().map(line).collect();
    Panel::new(family.name, "wrong edges (%)", "mean rotation error (°)").lines(&lines)
}

fn report_family(family: &Family, records: &Selection, text: &mut String) {
    let methods = records.configurations();
    let num_graphs = methods.first().map_or(0, |method| {
        let scene = scene_of(family.outliers[0]);
        records.of_scene(&scene, method, STATISTICS[0]).len()
    });
    let title = format!(
        "{}: rotation error (°), mean / median over scans, mean of {num_graphs} graphs; wall time of one of two threads",
        family.title
    );
    let shares = || family.outliers.iter().map(|percent| format!("{percent} %"));
    let method = || std::iter::once("method".to_owned());
    let mut rotations = Table::new(title, method().chain(shares()).chain([TIME.to_owned()]));
    let title = format!(
        "{}: translation error (m), mean / median over scans",
        family.title
    );
    let mut translations = Table::new(title, method().chain(shares()));
    for method in methods {
        let figure = |percent: u32, statistic, factor, digits| {
            number(
                records.scene_spread(&scene_of(percent), &method, statistic),
                factor,
                digits,
            )
        };
        let row = |statistics: [&'static str; 2], digits| {
            let cell = |&percent: &u32| {
                statistics
                    .map(|statistic| figure(percent, statistic, 1.0, digits))
                    .join(" / ")
            };
            let cells = family.outliers.iter().map(cell);
            std::iter::once(method.clone())
                .chain(cells)
                .collect::<Vec<_>>()
        };
        let ends = [family.outliers.first(), family.outliers.last()];
        let times = ends
            .into_iter()
            .flatten()
            .map(|&percent| figure(percent, STATISTICS[4], 1e3, 1));
        let time = times.collect::<Vec<_>>().join("–");
        rotations.row(
            row([STATISTICS[0], STATISTICS[1]], 2)
                .into_iter()
                .chain([time]),
        );
        translations.row(row([STATISTICS[2], STATISTICS[3]], 3));
    }
    for system in reference::systems(family.name) {
        let columns = shares().chain([TIME.to_owned()]);
        let cell = |column| {
            system
                .figures
                .get(&column)
                .map_or("–", String::as_str)
                .to_owned()
        };
        let name = format!("*{}*", system.name);
        rotations.row(std::iter::once(name).chain(columns.map(cell)));
    }
    rotations.append_to(text);
    translations.append_to(text);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_graph_is_read_as_the_same_problem() {
        let params = PoseGraphSimParams {
            num_scans: 12,
            ..PoseGraphSimParams::default()
        };
        let problem = simulated_problem(&params).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("graph.g2o");
        write_problem(&file, &problem, &params).unwrap();
        let read = read_problem(&file).unwrap();
        assert_eq!(read.graph.edges().len(), problem.graph.edges().len());
        let [ours, theirs] = [&problem, &read].map(|p| run_methods(p, 0).unwrap());
        for (a, b) in ours
            .iter()
            .zip(&theirs)
            .filter(|(a, _)| a.metric != "seconds")
        {
            assert!((a.value - b.value).abs() < 1e-6, "{a:?}, {b:?}");
        }
        let of_method = |method: Method| {
            ours.iter()
                .filter(move |r| r.configuration == method.name())
        };
        for method in Method::ALL {
            let error = of_method(method)
                .find(|r| r.metric == "rotation mean")
                .unwrap();
            assert!(error.value < 4.0, "{error:?}");
        }
    }

    #[test]
    fn every_family_names_its_own_shares_and_parameters_that_simulate() {
        for family in families() {
            assert!(family.outliers.is_sorted());
            let params = PoseGraphSimParams {
                num_scans: 20,
                ..family.params
            };
            assert!(simulated_problem(&params).is_ok(), "{}", family.name);
        }
    }
}

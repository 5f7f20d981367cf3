//! `gmpcr sync`: poses from the relative poses of a g2o file.

mod residuals;

use std::fmt::Write;
use std::time::Duration;

use gmpcr::nalgebra::Isometry3;
use gmpcr::posegraph::PoseGraph;
use gmpcr::sync::{ComponentReport, SyncParams, Synchronization, synchronize};
use gmpcr_io::{G2oPoseGraph, read_g2o, write_g2o};
use serde_json::{Value, json};

use crate::arguments::SyncArguments;
use crate::outcome::{Answer, Failure};
use crate::progress::Progress;
use crate::table::counted;
use residuals::{Residuals, residual_table};

pub fn run(
    arguments: &SyncArguments,
    is_verbose: bool,
    progress: &Progress,
) -> Result<Answer, Failure> {
    let named = |reason| Failure::of(&arguments.graph, reason);
    let file = G2oPoseGraph::new(&read_g2o(&arguments.graph)?)
        .map_err(|error| named(error.to_string()))?;
    let params = SyncParams {
        iterations: arguments.iterations as usize,
        method: arguments.method,
        ..SyncParams::default()
    };
    let (result, time) = progress.stage("synchronization", 1, || {
        Ok(progress.item(|| synchronize(&file.graph, &params))??)
    })?;
    progress.finish();
    if let Some(out) = &arguments.out {
        let solved = file.solved(&result.world_from_scan, &result.components);
        write_g2o(out, &solved)?;
    }
    let before: Option<Vec<Isometry3<f64>>> = file.initial_poses.iter().copied().collect();
    let solved = Solved {
        arguments,
        graph: &file.graph,
        before: before.map(|poses| Residuals::of(&file.graph, &poses)),
        after: Residuals::of(&file.graph, &result.world_from_scan),
        result: &result,
        time,
    };
    Ok(Answer {
        text: solved.text(is_verbose),
        json: Some(solved.to_json()),
        is_complete: result.components.members().len() == 1,
    })
}

/// What there is to tell.
struct Solved<'a> {
    arguments: &'a SyncArguments,
    graph: &'a PoseGraph,
    /// Of the poses of the file, if it has all.
    before: Option<Residuals>,
    after: Residuals,
    result: &'a Synchronization,
    time: Duration,
}

impl Solved<'_> {
    fn text(&self, is_verbose: bool) -> String {
        let mut text = format!(
            "{} poses, {} edges, {}: {} in {:.3} s\n",
            self.graph.num_scans(),
            self.graph.edges().len(),
            counted(self.num_components(), "component"),
            self.arguments.method,
            self.time.as_secs_f64()
        );
        text += &self.limits();
        text.push('\n');
        text += &residual_table(self.before.as_ref(), &self.after);
        if is_verbose {
            let _ = write!(
                text,
                "\neigenvector residual {:.1e}, residual of positions {:.1e}\n",
                self.eigen_residual(),
                self.position_residual()
            );
        }
        if let Some(out) = &self.arguments.out {
            let _ = write!(text, "\n{} written\n", out.display());
        }
        text
    }

    /// What keeps the result from being all that it could be.
    fn limits(&self) -> String {
        let mut text = String::new();
        let reports = &self.result.reports;
        let unused = self.num_unused();
        if unused > 0 {
            let edges = counted(unused, "edge");
            let _ = writeln!(text, "{edges} without information on the rotation not used");
        }
        if !reports.iter().all(ComponentReport::rotations_converged) {
            let residual = self.eigen_residual();
            let _ = writeln!(
                text,
                "rotations were not solved to the end (eigenvector residual {residual:.1e}): consensus, l1-irls \
                 and hara have no eigenproblem"
            );
        }
        if !reports.iter().all(ComponentReport::positions_converged) {
            let residual = self.position_residual();
            let _ = writeln!(
                text,
                "positions were not solved to the end (residual {residual:.1e}): relative poses of distant scans may \
                 be inaccurate"
            );
        }
        text
    }

    fn to_json(&self) -> Value {
        json!({
            "method": self.arguments.method,
            "poses": self.graph.num_scans(),
            "edges": self.graph.edges().len(),
            "unused_edges": self.num_unused(),
            "components": self.num_components(),
            "seconds": self.time.as_secs_f64(),
            "eigen_residual": self.eigen_residual(),
            "position_residual": self.position_residual(),
            "before": self.before.as_ref().map(Residuals::to_json),
            "after": self.after.to_json(),
        })
    }

    fn num_components(&self) -> usize {
        self.result.components.members().len()
    }

    fn num_unused(&self) -> usize {
        let edges = self.graph.edges().iter();
        edges.filter(|edge| edge.weight == 0.0).count()
    }

    fn eigen_residual(&self) -> f64 {
        self.largest(|report| report.eigen_residual)
    }

    fn position_residual(&self) -> f64 {
        self.largest(|report| report.position_residual)
    }

    fn largest(&self, of: fn(&ComponentReport) -> f64) -> f64 {
        self.result.reports.iter().map(of).fold(0.0, f64::max)
    }
}

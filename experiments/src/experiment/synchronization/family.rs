//! The families of simulated pose graphs.

use gmpcr_sim::{EdgeWeights, Outliers, PoseGraphSimParams, Topology};

/// A family of simulated graphs: one table.
pub struct Family {
    pub name: &'static str,
    pub title: &'static str,
    pub params: PoseGraphSimParams,
    /// Ratios of outlier edges in percent.
    pub outliers: &'static [u32],
    /// Graphs per ratio, in multiples of the runs that are asked for.
    pub graphs_per_run: usize,
}

pub fn families() -> Vec<Family> {
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
            "50 scans, random edges, uniform outliers, informative weights",
            informative,
            &[20, 40, 60],
            4,
        ),
        family(
            "geometric500",
            "500 scans, edges between neighbors, uniform outliers",
            geometric(500),
            &[0, 20, 40],
            1,
        ),
        family(
            "geometric5000",
            "5000 scans, edges between neighbors, uniform outliers",
            geometric(5000),
            &[0, 20, 40],
            0,
        ),
    ]
}

impl Family {
    /// Number of graphs of each ratio.
    pub fn num_graphs(&self, num_runs: usize) -> usize {
        (self.graphs_per_run * num_runs).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::super::problem::Problem;
    use super::*;

    #[test]
    fn every_family_has_ascending_ratios_and_parameters_that_simulate() {
        for family in families() {
            assert!(family.outliers.is_sorted());
            let params = PoseGraphSimParams {
                num_scans: 20,
                ..family.params
            };
            assert!(Problem::simulate(&params).is_ok(), "{}", family.name);
        }
    }
}

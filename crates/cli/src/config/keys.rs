//! The parameters by their names.

use super::Config;

/// A parameter: its name, what it is for, and how to get at it.
pub(super) struct Key {
    pub name: &'static str,
    pub help: &'static str,
    pub access: Access,
}

pub(super) enum Access {
    Voxel,
    Count(fn(&mut Config) -> &mut usize),
    Number(fn(&mut Config) -> &mut f64),
    Degrees(fn(&mut Config) -> &mut f64),
    Method,
}

const fn key(name: &'static str, help: &'static str, access: Access) -> Key {
    Key { name, help, access }
}

pub(super) const KEYS: &[Key] = &[
    key(
        "voxel",
        "Working voxel in the unit of the scans, or \"auto\": estimated from them.",
        Access::Voxel,
    ),
    key(
        "features.normal_radius",
        "Normals are fitted to the points within this radius.",
        Access::Number(|config| &mut config.normal_radius),
    ),
    key(
        "features.normal_neighbors",
        "At most so many points are fitted.",
        Access::Count(|config| &mut config.normal_neighbors),
    ),
    key(
        "features.descriptor_radius",
        "FPFH descriptors see the points within this radius.",
        Access::Number(|config| &mut config.descriptor_radius),
    ),
    key(
        "features.descriptor_neighbors",
        "At most so many points are described.",
        Access::Count(|config| &mut config.descriptor_neighbors),
    ),
    key(
        "correspondence.num_samples",
        "Keypoints per scan, N_s. More cost time with their square, and help scans of little overlap.",
        Access::Count(|config| &mut config.params.correspondence.num_samples),
    ),
    key(
        "correspondence.max_correspondences",
        "Correspondences per pair of scans, N_o.",
        Access::Count(|config| &mut config.params.correspondence.max_correspondences),
    ),
    key(
        "retrieval.min_scans",
        "So many scans or more have promising pairs scored only, fewer have all. 0 always retrieves.",
        Access::Count(|config| &mut config.params.retrieval.min_scans),
    ),
    key(
        "retrieval.candidates_per_scan",
        "Partners that each scan proposes by its descriptors.",
        Access::Count(|config| &mut config.params.retrieval.candidates_per_scan),
    ),
    key(
        "retrieval.expansions",
        "Rounds, at most, in which scans then propose neighbours of their neighbours.",
        Access::Count(|config| &mut config.params.retrieval.expansions),
    ),
    key(
        "retrieval.candidates_per_expansion",
        "Most confident neighbours that count in such a round, and partners that each scan proposes.",
        Access::Count(|config| &mut config.params.retrieval.candidates_per_expansion),
    ),
    key(
        "compatibility.tolerance",
        "Two correspondences agree if their distances differ by less than this, tau_c.",
        Access::Number(|config| &mut config.tolerance),
    ),
    key(
        "compatibility.retained_fraction",
        "Share of the correspondences that the spectral filter retains, r_s.",
        Access::Number(|config| &mut config.params.compatibility.retained_fraction),
    ),
    key(
        "posegraph.neighbors",
        "Edges that each scan proposes, K.",
        Access::Count(|config| &mut config.params.posegraph.neighbors),
    ),
    key(
        "cliques.max_cliques",
        "Cliques per pair that propose a motion, K_c.",
        Access::Count(|config| &mut config.params.cliques.max_cliques),
    ),
    key(
        "cliques.inlier_threshold",
        "A motion explains a correspondence that it brings closer together than this, tau_in.",
        Access::Number(|config| &mut config.inlier_threshold),
    ),
    key(
        "cliques.min_affinity",
        "Second-order affinity above which correspondences are joined in the search for cliques.",
        Access::Number(|config| &mut config.params.cliques.min_affinity),
    ),
    key(
        "cliques.work_budget",
        "Steps after which the search for cliques of a pair ends.",
        Access::Count(|config| &mut config.params.cliques.work_budget),
    ),
    key(
        "sync.method",
        "adaptive (the paper's), no-recovery, sghr, memoryless, eigse3, l1, l1-irls, rotavg-lhalf, hara or consensus.",
        Access::Method,
    ),
    key(
        "sync.iterations",
        "Reweighting iterations, L.",
        Access::Count(|config| &mut config.params.sync.iterations),
    ),
    key(
        "sync.residual_scale",
        "Rotation residual that costs an edge the factor e, s_r, in degrees.",
        Access::Degrees(|config| &mut config.params.sync.residual_scale),
    ),
    key(
        "sync.min_memory",
        "Memory of the residuals while the solution changes fast, lambda_min (adaptive only).",
        Access::Number(|config| &mut config.history.min_memory),
    ),
    key(
        "sync.max_memory",
        "Memory of a settled solution, lambda_max (adaptive only).",
        Access::Number(|config| &mut config.history.max_memory),
    ),
    key(
        "sync.sensitivity",
        "Sensitivity of the memory to changes of the overall residual, kappa (adaptive only).",
        Access::Number(|config| &mut config.history.sensitivity),
    ),
    key(
        "sync.recovery",
        "How much of its weight an edge regains whose residual falls, rho (adaptive only).",
        Access::Number(|config| &mut config.history.recovery),
    ),
];

/// Names the parameters of the same section, or of the same name in another one.
pub(super) fn unknown_key(name: &str) -> String {
    let parts: Vec<_> = name.split('.').filter(|part| !part.is_empty()).collect();
    let is_alike = |key: &&Key| parts.iter().any(|part| key.name.contains(part));
    let alike: Vec<_> = KEYS.iter().filter(is_alike).map(|key| key.name).collect();
    let meant = match alike.as_slice() {
        [] => String::new(),
        _ => format!("is one of these meant: {}? ", alike.join(", ")),
    };
    format!("there is no parameter {name}; {meant}`gmpcr params` prints all")
}

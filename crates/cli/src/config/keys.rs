//! The parameters by their paths.

/// The path of each parameter within [`Params`](gmpcr::Params), and what it is for.
pub(super) const KEYS: &[(&str, &str)] = &[
    (
        "features.voxel_size",
        "Voxel size in the unit of the scans, or \"auto\": estimated from them.",
    ),
    (
        "features.normals.radius",
        "Normals are fitted to the points within this radius.",
    ),
    (
        "features.normals.max_neighbors",
        "At most so many points are fitted.",
    ),
    (
        "features.fpfh.radius",
        "FPFH descriptors see the points within this radius.",
    ),
    (
        "features.fpfh.max_neighbors",
        "At most so many points enter a descriptor.",
    ),
    (
        "correspondence.num_samples",
        "Keypoints per scan, N_s. More cost time with their square, and help scans of little overlap.",
    ),
    (
        "correspondence.max_correspondences",
        "Correspondences per pair of scans, N_o.",
    ),
    (
        "retrieval.min_scans",
        "So many scans or more have promising pairs scored only, fewer have all. 0 always retrieves.",
    ),
    (
        "retrieval.candidates_per_scan",
        "Partners that each scan proposes by its descriptors.",
    ),
    (
        "retrieval.expansions",
        "Rounds, at most, in which scans then propose neighbors of their neighbors.",
    ),
    (
        "retrieval.candidates_per_expansion",
        "Most confident neighbors that count in such a round, and partners that each scan proposes.",
    ),
    (
        "compatibility.tolerance",
        "Two correspondences agree if their distances differ by less than this, tau_c.",
    ),
    (
        "compatibility.retained_fraction",
        "Fraction of the correspondences that the spectral filter retains, r_s.",
    ),
    ("posegraph.neighbors", "Edges that each scan proposes, K."),
    (
        "cliques.max_cliques",
        "Cliques per pair that propose a relative pose, K_c.",
    ),
    (
        "cliques.inlier_threshold",
        "A correspondence is an inlier if the relative pose brings it closer together than this, tau_in.",
    ),
    (
        "cliques.min_affinity",
        "First-order affinity above which correspondences are connected in the search for cliques.",
    ),
    (
        "cliques.work_budget",
        "Steps after which the search for cliques of a pair ends.",
    ),
    (
        "sync.method",
        "adaptive (the paper's), no-recovery, sghr, memoryless, eigse3, l1, l1-irls, rotavg-lhalf, hara or consensus.",
    ),
    ("sync.iterations", "Reweighting iterations, L."),
    (
        "sync.residual_scale",
        "Rotation residual that costs an edge the factor e, s_r, in degrees.",
    ),
    (
        "sync.history.min_memory",
        "Memory of the residuals while the solution changes fast, lambda_min (adaptive only).",
    ),
    (
        "sync.history.max_memory",
        "Memory of a settled solution, lambda_max (adaptive only).",
    ),
    (
        "sync.history.sensitivity",
        "Sensitivity of the memory to changes of the overall residual, kappa (adaptive only).",
    ),
    (
        "sync.history.recovery",
        "How much of its weight an edge regains whose residual falls, rho (adaptive only).",
    ),
];

/// Names the parameters of the same section, or of the same name in another one.
pub(super) fn unknown_key(name: &str) -> String {
    let parts: Vec<_> = name.split('.').filter(|part| !part.is_empty()).collect();
    let is_alike = |key: &&str| parts.iter().any(|part| key.contains(part));
    let paths = KEYS.iter().map(|&(path, _)| path);
    let alike: Vec<_> = paths.filter(is_alike).collect();
    let meant = match alike.as_slice() {
        [] => String::new(),
        _ => format!("is one of these meant: {}? ", alike.join(", ")),
    };
    format!("there is no parameter {name}; {meant}`gmpcr params` prints all")
}

//! The transformation between two scans, and what supports it.
//!
//! ```text
//! cargo run --release --example 01_two_scans                 # two simulated scans
//! cargo run --release --example 01_two_scans -- A.ply B.ply
//! ```

use std::env;
use std::error::Error;

use gmpcr::io::read_points;
use gmpcr::{Cloud, Params, compute_features, register_pair};
use gmpcr_sim::{SimParams, simulate};

fn main() -> Result<(), Box<dyn Error>> {
    let files: Vec<String> = env::args().skip(1).collect();
    let clouds = match files.as_slice() {
        [a, b] => vec![read_points(a)?.into(), read_points(b)?.into()],
        [] => simulated()?,
        _ => return Err("name two files, or none".into()),
    };

    // Voxel size, downsampling, normals, FPFH.
    let set = compute_features(clouds)?;
    println!("voxel size        {:.4}", set.voxel_size);

    // Matching, spectral filter, maximal cliques.
    let params = Params::default().with_voxel_size(set.voxel_size);
    let pair = register_pair(&set.scans[0], &set.scans[1], &params)?;
    println!("correspondences   {}", pair.correspondences.len());
    println!("retained          {}", pair.retained.len());
    println!("raw confidence    {:.1}", pair.raw_confidence);

    let Some(pose) = &pair.estimate.pose else {
        println!("no transformation: the scans share no surface, or too little");
        return Ok(());
    };
    println!("inlier ratio      {:.2}", pose.inlier_ratio);
    let a_from_b = set.between_clouds(0, &pose.target_from_source, 1);
    println!(
        "from the second scan to the first:\n{:.4}",
        a_from_b.to_matrix()
    );

    // How well each direction is determined, for a pose graph of your own.
    let information = pair.information();
    println!(
        "information (translation, rotation):\n{:.0}",
        information.unwrap_or_default()
    );
    Ok(())
}

fn simulated() -> Result<Vec<Cloud>, Box<dyn Error>> {
    let params = SimParams {
        num_scans: 2,
        ..SimParams::default()
    };
    let scans = simulate(&params)?;
    let a_from_b = scans.world_from_scan[0].inv_mul(&scans.world_from_scan[1]);
    println!("ground truth:\n{:.4}", a_from_b.to_matrix());
    Ok(scans.clouds.into_iter().map(Cloud::new).collect())
}

use gmpcr_correspondence::{Descriptors, Scan};
use gmpcr_features::{
    self as features, FPFH_DIMENSION, FeatureParams, LocalCloud, common_voxel_size,
    estimate_voxel_size, localize_georeferenced, remove_stray_points,
};
use nalgebra::{Isometry3, Point3};
use rayon::prelude::*;

use crate::progress::StageProgress;
use crate::{Cloud, Error, Observer, Registration, Stage, StageTimes};

/// Where the voxel size comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum VoxelSize {
    /// The one of the parameters. Descriptors of clouds that come one by one compare if all have the same.
    Given,
    /// The median of those that suit the clouds. The other lengths keep their ratios to the voxel size of the
    /// parameters.
    Estimated,
}

/// Scans made of clouds, ready to be registered, and how they were made.
///
/// Registration sees the points of each cloud less an origin of its own, which is zero but for georeferenced
/// clouds: numbers of seven digits before the point have few left behind it.
/// [`in_cloud_frames`](Self::in_cloud_frames) leads back to the coordinates of the clouds.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ScanSet {
    /// The clouds less their origins and their stray points.
    pub clouds: Vec<LocalCloud>,
    /// One per cloud, in its coordinates. A cloud without features is a scan without points.
    pub scans: Vec<Scan>,
    /// The length from which all others follow, in the unit of the clouds.
    pub voxel_size: f64,
    /// Points of each cloud that were left out because they are far from all others.
    pub num_strays: Vec<usize>,
    /// Why a cloud has no features.
    pub problems: Vec<Option<features::Error>>,
    /// Wall time of the stages.
    pub times: StageTimes,
}

/// Turns clouds into scans without being told anything: voxel size, downsampling, normals, FPFH.
///
/// The voxel size is the median of those that suit the clouds
/// ([`estimate_voxel_size`]); the other lengths follow from it. Stray and georeferenced points are taken
/// care of. A cloud whose features cannot be computed has its reason in [`ScanSet::problems`].
///
/// # Errors
/// [`Error::NoExtent`] if no cloud has two different points.
///
/// ```
/// use gmpcr::nalgebra::Point3;
/// use gmpcr::{Cloud, Params, compute_features, register};
///
/// // A wavy sheet of about a meter, seen from zero.
/// let points = (0..1600).map(|k| (k % 40, k / 40)).map(|(x, y)| {
///     let (x, y) = (f64::from(x) * 0.025, f64::from(y) * 0.025);
///     Point3::new(x, y, 1.0 + 0.1 * (7.0 * x).sin() * (5.0 * y).cos())
/// });
/// let cloud = Cloud::new(points.collect());
/// let set = compute_features(vec![cloud.clone(), cloud])?;
/// let params = Params::default().with_voxel_size(set.voxel_size);
/// let registration = set.in_cloud_frames(register(&set.scans, &params)?);
/// assert!(registration.connectivity.is_connected);
/// # Ok::<(), gmpcr::Error>(())
/// ```
pub fn compute_features(clouds: Vec<Cloud>) -> Result<ScanSet, Error> {
    let in_voxels = FeatureParams::from_voxel_size(1.0);
    compute_features_with(clouds, &in_voxels, VoxelSize::Estimated, &())
}

/// As [`compute_features`], with parameters and with an observer.
///
/// # Errors
/// Those of [`compute_features`], [`Error::Parameter`], and [`Error::Cancelled`] if the observer says so.
///
/// ```
/// use gmpcr::nalgebra::Point3;
/// use gmpcr::{Cloud, Params, VoxelSize, compute_features_with};
///
/// let points = (0..900).map(|k| Point3::new(f64::from(k % 30) * 0.03, f64::from(k / 30) * 0.03, 1.0));
/// let cloud = Cloud::new(points.collect());
/// let params = Params::default().with_voxel_size(0.1);
/// let set = compute_features_with(vec![cloud], &params.features, VoxelSize::Given, &())?;
/// assert_eq!((set.voxel_size, set.scans[0].len()), (0.1, 100));
/// # Ok::<(), gmpcr::Error>(())
/// ```
pub fn compute_features_with(
    clouds: Vec<Cloud>,
    params: &FeatureParams,
    voxel_size: VoxelSize,
    observer: &dyn Observer,
) -> Result<ScanSet, Error> {
    params
        .validate()
        .map_err(|error| error.within("features"))?;
    let mut times = StageTimes::default();
    let mut clouds = localized(clouds);
    let params = match voxel_size {
        VoxelSize::Given => *params,
        VoxelSize::Estimated => {
            let estimate = || estimated_voxel_size(&clouds, observer);
            let voxel_size = times.timed(Stage::VoxelSize, estimate)?;
            params.scaled(voxel_size / params.voxel_size)
        }
    };
    params
        .validate()
        .map_err(|error| error.within("features"))?;
    let progress = StageProgress::begin(Stage::Features, clouds.len(), observer);
    let compute = |cloud: &mut LocalCloud| progress.item(|| Ok(scan_of(cloud, &params)));
    let computed: Vec<_> = times.timed(Stage::Features, || {
        let computed = clouds.par_iter_mut().map(compute);
        computed.collect::<Result<_, Error>>()
    })?;
    let mut set = ScanSet {
        clouds,
        scans: Vec::new(),
        voxel_size: params.voxel_size,
        num_strays: Vec::new(),
        problems: Vec::new(),
        times,
    };
    for (num_strays, scan) in computed {
        let (scan, problem) = match scan {
            Ok(scan) => (scan, None),
            Err(problem) => (no_points(FPFH_DIMENSION), Some(problem)),
        };
        set.scans.push(scan);
        set.num_strays.push(num_strays);
        set.problems.push(problem);
    }
    Ok(set)
}

impl ScanSet {
    /// Clouds whose features come from elsewhere: `scans[k]` has keypoints in the coordinates of `clouds[k]`,
    /// and descriptors. The voxel size is estimated from the clouds unless it is given here.
    ///
    /// # Errors
    /// [`Error::ScansAndClouds`] if there is not one scan per cloud, [`Error::NoExtent`] if the voxel size cannot
    /// be estimated, and [`Error::Cancelled`] if the observer says so.
    pub fn with_scans(
        clouds: Vec<Cloud>,
        scans: Vec<Scan>,
        voxel_size: Option<f64>,
        observer: &dyn Observer,
    ) -> Result<Self, Error> {
        if clouds.len() != scans.len() {
            return Err(Error::ScansAndClouds {
                scans: scans.len(),
                clouds: clouds.len(),
            });
        }
        let mut times = StageTimes::default();
        let clouds = localized(clouds);
        let scans = clouds.iter().zip(scans).map(|(cloud, scan)| {
            let points = scan.points().iter().map(|point| point - cloud.origin);
            Ok(Scan::new(points.collect(), scan.descriptors().clone())?)
        });
        let scans = scans.collect::<Result<_, Error>>()?;
        let estimate = || estimated_voxel_size(&clouds, observer);
        let voxel_size = match voxel_size {
            Some(voxel_size) => voxel_size,
            None => times.timed(Stage::VoxelSize, estimate)?,
        };
        Ok(Self {
            num_strays: vec![0; clouds.len()],
            problems: vec![None; clouds.len()],
            scans,
            clouds,
            voxel_size,
            times,
        })
    }

    /// A registration of [`scans`](Self::scans) in the coordinates that the clouds came in: poses and relative
    /// poses of their frames. See [`Registration::with_scan_frames`].
    ///
    /// # Panics
    /// If the registration is of another number of scans.
    #[must_use]
    pub fn in_cloud_frames(&self, registration: Registration) -> Registration {
        registration.with_scan_frames(&self.cloud_from_local())
    }

    /// The [pose graph](Registration::posed_graph) of a registration of [`scans`](Self::scans), in the coordinates
    /// that the clouds came in.
    ///
    /// # Panics
    /// If the registration is of another number of scans.
    #[cfg(feature = "io")]
    pub fn posed_graph(&self, registration: &Registration) -> gmpcr_io::PosedGraph {
        let cloud_from_local = self.cloud_from_local();
        let graph = registration.posed_graph();
        graph.with_scan_frames(|scan| cloud_from_local[scan])
    }

    /// From the coordinates of [`clouds`](Self::clouds) to the world of a registration that is
    /// [in the coordinates](Self::in_cloud_frames) that they came in: to put the clouds into one.
    ///
    /// # Panics
    /// If the registration is of another number of scans.
    pub fn world_from_local(&self, in_cloud_frames: &Registration) -> Vec<Isometry3<f64>> {
        assert_eq!(
            self.clouds.len(),
            in_cloud_frames.ids.len(),
            "one scan per cloud"
        );
        let poses = in_cloud_frames.world_from_scan.iter();
        let frames = poses.zip(self.cloud_from_local());
        frames
            .map(|(pose, cloud_from_local)| pose * cloud_from_local)
            .collect()
    }

    /// A transformation from the coordinates of scan `j` to those of scan `i`, in the coordinates that their
    /// clouds came in: `N_i T_ij N_j⁻¹`.
    ///
    /// # Panics
    /// If a scan does not exist.
    pub fn between_clouds(&self, i: usize, i_from_j: &Isometry3<f64>, j: usize) -> Isometry3<f64> {
        let [of_i, of_j] = [i, j].map(|scan| self.clouds[scan].original_from_local());
        of_i * i_from_j * of_j.inverse()
    }

    /// From the coordinates of [`clouds`](Self::clouds) and [`scans`](Self::scans) to those that the clouds came
    /// in.
    fn cloud_from_local(&self) -> Vec<Isometry3<f64>> {
        let clouds = self.clouds.iter();
        clouds.map(LocalCloud::original_from_local).collect()
    }
}

/// Turns one cloud into a scan with known parameters, on the calling thread: for clouds that come one by one, or
/// do not all fit into memory. Coordinates stay as they are. Descriptors compare between scans of one voxel size.
///
/// # Errors
/// Those of [`features::compute_features`].
pub fn compute_scan(
    points: &[Point3<f64>],
    params: &FeatureParams,
) -> Result<Scan, features::Error> {
    let features = features::compute_features(points, params)?;
    let rows = features.descriptors.into_flattened();
    let descriptors = Descriptors::new(rows, FPFH_DIMENSION);
    Ok(descriptors
        .ok()
        .and_then(|descriptors| Scan::new(features.points, descriptors).ok())
        .expect("features are finite, one row per point"))
}

fn localized(clouds: Vec<Cloud>) -> Vec<LocalCloud> {
    let clouds = clouds.into_iter();
    let mut clouds: Vec<_> = clouds
        .map(|cloud| LocalCloud::new(cloud.points, cloud.viewpoint))
        .collect();
    localize_georeferenced(&mut clouds);
    clouds
}

/// The voxel size that suits most clouds.
fn estimated_voxel_size(clouds: &[LocalCloud], observer: &dyn Observer) -> Result<f64, Error> {
    let progress = StageProgress::begin(Stage::VoxelSize, clouds.len(), observer);
    // A cloud with a coordinate beyond all bounds has no say; its stray points are left out later.
    let estimate = |cloud: &LocalCloud| Ok(estimate_voxel_size(&cloud.points).ok().flatten());
    let estimates = clouds
        .par_iter()
        .map(|cloud| progress.item(|| estimate(cloud)));
    let estimates: Vec<Option<f64>> = estimates.collect::<Result<_, Error>>()?;
    common_voxel_size(estimates.into_iter().flatten()).ok_or(Error::NoExtent)
}

/// Stray points left out, and the scan of the others.
fn scan_of(
    cloud: &mut LocalCloud,
    params: &FeatureParams,
) -> (usize, Result<Scan, features::Error>) {
    let num_strays = remove_stray_points(&mut cloud.points, params.voxel_size);
    let mut params = *params;
    params.normals.viewpoint = cloud.viewpoint;
    (num_strays, compute_scan(&cloud.points, &params))
}

fn no_points(dimension: usize) -> Scan {
    let none = Descriptors::new(Vec::new(), dimension);
    none.ok()
        .and_then(|descriptors| Scan::new(Vec::new(), descriptors).ok())
        .expect("no points and no descriptors are a scan")
}

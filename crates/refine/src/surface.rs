use std::cmp::Ordering;
use std::fmt;

use gmpcr_geometry::InvalidParameter;
use nalgebra::{Point3, Vector3};

use crate::grid::{self, SparseGrid};
use crate::range_image::RangeImage;
use crate::smooth::smooth;
use crate::{Error, check};

/// Deviation of a normal's length from 1 that is accepted.
const LENGTH_TOLERANCE: f64 = 1e-3;
/// Raw points nearer to the viewpoint than this, in voxels, are the sensor's own mount, or noise.
const MIN_RAW_DEPTH: f64 = 4.0;

/// How a [`Surface`] is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct SurfaceParams {
    /// The voxel size that the points were downsampled with, in their unit; positive. It is the edge of
    /// the grid's cells, and all lengths of the other parameters are multiples of it. Default 0.05 (meters).
    pub voxel_size: f64,
    /// Points of a surface that are looked up in others, at most; at least 1. Default 600. Time grows
    /// with it; refined poses become hardly more exact.
    pub max_queries: usize,
    /// Each point is moved along its normal to the mean of its neighbors within this radius whose normals
    /// agree, in voxels; in [1, 3], or 0 for none. Default 2. It averages noise; planes stay as they are. With
    /// noise of a third of a voxel, refined poses have less than half the error.
    pub smoothing_radius: f64,
    /// Width of the range image's pixels, as the tangent of their angle; from 0.005 to 0.5. Default 0.025
    /// (1.4°). The sensor's rays should be less than 1.5 pixels apart.
    pub pixel: f64,
}

impl Default for SurfaceParams {
    fn default() -> Self {
        Self {
            voxel_size: 0.05,
            max_queries: 600,
            smoothing_radius: 2.0,
            pixel: 0.025,
        }
    }
}

impl SurfaceParams {
    /// The default with another voxel size.
    #[must_use]
    pub fn from_voxel_size(voxel_size: f64) -> Self {
        Self {
            voxel_size,
            ..Self::default()
        }
    }

    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let &Self {
            voxel_size,
            max_queries,
            smoothing_radius,
            pixel,
        } = self;
        InvalidParameter::check_positive("voxel_size", voxel_size)?;
        let queries = max_queries as f64;
        InvalidParameter::check(max_queries >= 1, "max_queries", queries, "at least 1")?;
        let is_radius = smoothing_radius == 0.0 || (1.0..=3.0).contains(&smoothing_radius);
        let (name, value) = ("smoothing_radius", smoothing_radius);
        InvalidParameter::check(is_radius, name, value, "0 or in [1, 3]")?;
        let is_angle = (0.005..=0.5).contains(&pixel);
        InvalidParameter::check(is_angle, "pixel", pixel, "in [0.005, 0.5]")
    }
}

/// A point of a surface and its unit normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    pub point: [f64; 3],
    pub normal: [f64; 3],
}

/// The surface that one scan saw, ready to be compared with others.
///
/// Points with unit normals in the scan's frame, one per voxel, and what makes comparisons fast:
///
/// - **Queries**: some hundred points, spread evenly over the surface, that are looked up in other surfaces.
/// - **Grid**: each cell of a voxel's size within two cells of a point knows the point nearest to its
///   center. A lookup takes constant time.
/// - **Range image**, if the [viewpoint](Self::seen_from) is known: how far the sensor saw in each direction.
///   What another scan has in front of that is a contradiction.
///
/// Everything is independent of the order of the points, down to the bits. A translation of the frame
/// changes results by rounding only, since the grid begins at the smallest coordinates of the points. A
/// rotation of the frame changes the cells and the choice of queries, and so results within the accuracy of
/// the sampling.
///
/// Points are [smoothed](SurfaceParams::smoothing_radius) before. Points without normal, which is zero then,
/// are left out. An empty surface is allowed; it overlaps with nothing. Memory is linear in the points, about
/// 130 kB per thousand, and up to 150 kB more for the range image.
///
/// ```
/// use gmpcr_refine::{Surface, SurfaceParams};
/// use nalgebra::{Point3, Vector3};
///
/// // A wall of 2 m × 2 m, two meters in front of the sensor, and the raw points it comes from.
/// let sheet = |step: f64, count: i32| -> Vec<_> {
///     let at = move |k: i32| f64::from(k) * step - 1.0;
///     (0..count * count).map(|k| Point3::new(at(k % count), at(k / count), 2.0)).collect()
/// };
/// let points = sheet(0.05, 40);
/// let normals = vec![-Vector3::z(); points.len()];
/// let surface = Surface::new(&points, &normals, &SurfaceParams::from_voxel_size(0.05))?
///     .seen_from(Point3::origin(), &sheet(0.01, 200))?;
/// assert_eq!((surface.len(), surface.num_queries()), (1600, 600));
/// assert!(surface.has_viewpoint());
/// # Ok::<(), gmpcr_refine::Error>(())
/// ```
#[derive(Clone)]
pub struct Surface {
    params: SurfaceParams,
    /// Along a space-filling curve.
    pub(crate) patches: Vec<Patch>,
    pub(crate) queries: Vec<Patch>,
    pub(crate) grid: SparseGrid,
    pub(crate) range_image: Option<RangeImage>,
    center: Point3<f64>,
    radius: f64,
}

impl Surface {
    /// Builds the surface of points with unit normals; zero normals are allowed and their points left out.
    /// The points should be downsampled, one per voxel. `O(n log n)`.
    ///
    /// # Errors
    /// [`Error::Parameter`], [`Error::LengthMismatch`], [`Error::Coordinate`] for coordinates that are no
    /// numbers within ±1e100, [`Error::NormalLength`] for lengths that differ from 1 by more than 0.001,
    /// [`Error::ExtentTooLarge`], [`Error::TooManyPoints`].
    pub fn new(
        points: &[Point3<f64>],
        normals: &[Vector3<f64>],
        params: &SurfaceParams,
    ) -> Result<Self, Error> {
        params.validate()?;
        check_input(points, normals, params.voxel_size)?;
        let mut patches = patches(points, normals);
        let cell = params.voxel_size;
        sort_along_curve(&mut patches, cell);
        if params.smoothing_radius > 0.0 {
            smooth(&mut patches, params.smoothing_radius * cell);
        }
        let (center, radius) = bounding_sphere(&patches);
        Ok(Self {
            params: *params,
            queries: evenly_chosen(&patches, params.max_queries),
            grid: SparseGrid::new(patches.iter().map(|patch| patch.point), cell),
            range_image: None,
            center,
            radius,
            patches,
        })
    }

    /// Adds where the sensor stood, in the frame of the scan, and all points that it measured: what it
    /// looked through is free space.
    ///
    /// The raw points fill the faces of a cube around the viewpoint, so the sensor may see all around. A
    /// scan that is fused from several images should have viewpoints close to each other. Raw points nearer than
    /// 4 voxels are left out. `O(m)` for `m` raw points, which are not kept.
    ///
    /// # Errors
    /// [`Error::Coordinate`] for coordinates that are no numbers within ±1e100.
    pub fn seen_from(mut self, viewpoint: Point3<f64>, raw: &[Point3<f64>]) -> Result<Self, Error> {
        check::coordinates("viewpoint", [&viewpoint.coords])?;
        check::coordinates("raw point", raw.iter().map(|point| &point.coords))?;
        let min_depth = MIN_RAW_DEPTH * self.params.voxel_size;
        let raw = raw.iter().map(|point| point.coords.into());
        let image = RangeImage::new(viewpoint.coords.into(), raw, self.params.pixel, min_depth);
        self.range_image = Some(image);
        Ok(self)
    }

    /// The voxel size.
    pub fn voxel_size(&self) -> f64 {
        self.params.voxel_size
    }

    /// Number of points with a normal.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    /// Whether no point has a normal.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// Number of points that are looked up in other surfaces.
    pub fn num_queries(&self) -> usize {
        self.queries.len()
    }

    /// Whether free space is known.
    pub fn has_viewpoint(&self) -> bool {
        self.range_image.is_some()
    }

    /// The mean of the points, in the scan's frame; of an empty surface the origin.
    pub fn center(&self) -> Point3<f64> {
        self.center
    }

    /// The largest distance of a point from the [center](Self::center); of an empty surface 0.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl fmt::Debug for Surface {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter
            .debug_struct("Surface")
            .field("params", &self.params)
            .field("len", &self.len())
            .field("num_queries", &self.num_queries())
            .field("has_viewpoint", &self.has_viewpoint())
            .field("center", &self.center)
            .field("radius", &self.radius)
            .finish_non_exhaustive()
    }
}

fn check_input(
    points: &[Point3<f64>],
    normals: &[Vector3<f64>],
    voxel_size: f64,
) -> Result<(), Error> {
    let (num_points, num_normals) = (points.len(), normals.len());
    if num_points != num_normals {
        return Err(Error::LengthMismatch {
            num_points,
            num_normals,
        });
    }
    if num_points >= u32::MAX as usize {
        return Err(Error::TooManyPoints { num_points });
    }
    check::coordinates("point", points.iter().map(|point| &point.coords))?;
    check::coordinates("normal", normals)?;
    for (index, normal) in normals.iter().enumerate() {
        let length = normal.norm();
        if length != 0.0 && (length - 1.0).abs() > LENGTH_TOLERANCE {
            return Err(Error::NormalLength { index, length });
        }
    }
    for axis in 0..3 {
        let along = || points.iter().map(|point| point[axis]);
        let extent =
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min);
        if extent / voxel_size > grid::MAX_SPAN {
            return Err(Error::ExtentTooLarge {
                axis,
                extent,
                voxel_size,
            });
        }
    }
    Ok(())
}

/// The points that have a normal.
fn patches(points: &[Point3<f64>], normals: &[Vector3<f64>]) -> Vec<Patch> {
    let known = points.iter().zip(normals).filter(|(_, n)| n.norm() > 0.0);
    let patch = |(point, normal): (&Point3<f64>, &Vector3<f64>)| Patch {
        point: point.coords.into(),
        normal: normal.normalize().into(),
    };
    known.map(patch).collect()
}

/// Sorts by the Morton code of the cells, and in a cell by coordinates: an order that depends on the set only.
fn sort_along_curve(patches: &mut Vec<Patch>, cell: f64) {
    let corner = grid::corner(patches.iter().map(|patch| patch.point));
    let code = |patch: &Patch| grid::morton_code(&grid::cell_of(&patch.point, &corner, 1.0 / cell));
    let mut keyed: Vec<_> = patches.iter().map(|patch| (code(patch), *patch)).collect();
    let numbers = |patch: &Patch| patch.point.into_iter().chain(patch.normal);
    let by_numbers = |a: &Patch, b: &Patch| {
        let order = numbers(a).zip(numbers(b)).map(|(a, b)| a.total_cmp(&b));
        order.fold(Ordering::Equal, Ordering::then)
    };
    keyed.sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| by_numbers(&a.1, &b.1)));
    patches.clear();
    patches.extend(keyed.into_iter().map(|(_, patch)| patch));
}

/// Every `n/m`-th point along the curve.
fn evenly_chosen(patches: &[Patch], max_queries: usize) -> Vec<Patch> {
    let (n, m) = (patches.len(), max_queries.min(patches.len()));
    let chosen = |k: usize| patches[((2 * k + 1) as u128 * n as u128 / (2 * m) as u128) as usize];
    (0..m).map(chosen).collect()
}

/// The mean of the points and their largest distance from it.
fn bounding_sphere(patches: &[Patch]) -> (Point3<f64>, f64) {
    let points = || patches.iter().map(|patch| Vector3::from(patch.point));
    let Some(first) = points().next() else {
        return (Point3::origin(), 0.0);
    };
    let center = first + points().map(|p| p - first).sum::<Vector3<f64>>() / patches.len() as f64;
    let radius = points().map(|p| (p - center).norm()).fold(0.0, f64::max);
    (center.into(), radius)
}

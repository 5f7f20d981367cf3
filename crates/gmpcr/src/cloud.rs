use nalgebra::Point3;

/// A cloud as a file has it.
///
/// ```
/// use gmpcr::Cloud;
/// use gmpcr::nalgebra::Point3;
///
/// let points = vec![Point3::new(1.0, 0.0, 0.5), Point3::new(1.0, 0.1, 0.5)];
/// let cloud = Cloud::new(points).with_viewpoint(Point3::new(0.0, 0.0, 1.7));
/// assert_eq!(cloud.viewpoint.map(|point| point.z), Some(1.7));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Cloud {
    /// The points, in any unit and frame.
    pub points: Vec<Point3<f64>>,
    /// Where the sensor stood, in the frame of the points; `None` where the file does not say.
    pub viewpoint: Option<Point3<f64>>,
}

impl Cloud {
    /// A cloud of which the viewpoint is not known.
    pub fn new(points: Vec<Point3<f64>>) -> Self {
        Self {
            points,
            viewpoint: None,
        }
    }

    /// The same cloud, seen from a place in the frame of the points.
    #[must_use]
    pub fn with_viewpoint(mut self, viewpoint: Point3<f64>) -> Self {
        self.viewpoint = Some(viewpoint);
        self
    }
}

#[cfg(feature = "io")]
impl From<gmpcr_io::PointFile> for Cloud {
    fn from(file: gmpcr_io::PointFile) -> Self {
        Self {
            points: file.points,
            viewpoint: file.viewpoint,
        }
    }
}

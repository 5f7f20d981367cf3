//! What users of the types rely on beside the numbers.

use gmpcr_features::{Error, FeatureParams, Features, FpfhParams, LocalCloud, NormalParams};

#[test]
fn the_types_go_between_threads() {
    fn check<T: Send + Sync>() {}
    check::<Error>();
    check::<FeatureParams>();
    check::<Features>();
    check::<FpfhParams>();
    check::<LocalCloud>();
    check::<NormalParams>();
}

#[cfg(feature = "serde")]
mod files {
    use gmpcr_features::compute_features;
    use nalgebra::Point3;
    use serde_json::{from_value, json, to_value};

    use super::*;

    #[test]
    fn all_types_come_back_as_they_were() {
        let points: Vec<_> = (0..400)
            .map(|k| Point3::new(f64::from(k % 20), f64::from(k / 20), f64::from(k).sin()) * 0.05)
            .collect();
        let params = FeatureParams::from_voxel_size(0.07);
        let features = compute_features(&points, &params).unwrap();
        let cloud = LocalCloud::new(points, Some(Point3::new(0.1, 0.2, 0.3)));
        let written = to_value((&features, &params, &cloud)).unwrap();
        let read: (Features, FeatureParams, LocalCloud) = from_value(written).unwrap();
        assert_eq!(read, (features, params, cloud));
    }

    #[test]
    fn absent_parameters_are_the_default_and_unknown_ones_refused() {
        let partial = json!({ "voxel_size": 0.1, "normals": { "max_neighbors": 9 } });
        let mut expected = FeatureParams {
            voxel_size: 0.1,
            ..FeatureParams::default()
        };
        expected.normals.max_neighbors = 9;
        assert_eq!(from_value::<FeatureParams>(partial).unwrap(), expected);
        assert!(from_value::<FeatureParams>(json!({ "fpfh": { "range": 1.0 } })).is_err());
    }

    #[test]
    fn descriptors_of_another_length_are_refused() {
        let features = json!({
            "points": [[0.0, 0.0, 0.0]], "normals": [[0.0, 0.0, 1.0]], "descriptors": [[1.0, 2.0]],
        });
        let error = from_value::<Features>(features).unwrap_err().to_string();
        assert!(
            error.starts_with("descriptor 0 has 2 numbers, not 33"),
            "{error}"
        );
    }
}

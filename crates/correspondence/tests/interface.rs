//! What users of the types rely on beside the numbers.

use gmpcr_correspondence::{
    CorrespondenceError, CorrespondenceParams, Descriptors, DimensionsDiffer, Keypoints, Match,
    Scan, correspondences,
};
use nalgebra::Point3;

/// Two points and their descriptors.
fn scan(dimension: usize) -> Result<Scan, Box<dyn std::error::Error>> {
    let values = (0..2 * dimension).map(|k| k as f32 * 0.3);
    let descriptors = Descriptors::new(values.collect(), dimension)?;
    Ok(Scan::new(
        vec![Point3::origin(), Point3::new(0.1, 2.0, -3.0)],
        descriptors,
    )?)
}

#[test]
fn the_types_go_between_threads() {
    fn check<T: Send + Sync>() {}
    check::<CorrespondenceParams>();
    check::<CorrespondenceError>();
    check::<Descriptors>();
    check::<Keypoints>();
    check::<Match>();
    check::<Scan>();
}

#[test]
fn every_parameter_out_of_range_is_named() {
    let good = CorrespondenceParams::default();
    assert_eq!(good.validate(), Ok(()));
    let num_samples = CorrespondenceParams {
        num_samples: 2,
        ..good.clone()
    };
    let max_correspondences = CorrespondenceParams {
        max_correspondences: 0,
        ..good
    };
    let cases = [
        (num_samples, "num_samples"),
        (max_correspondences, "max_correspondences"),
    ];
    for (params, name) in cases {
        assert_eq!(params.validate().unwrap_err().name, name);
        let scan = scan(3).unwrap();
        assert_eq!(Keypoints::sample(&scan, &params).unwrap_err().name, name);
        let keypoints = Keypoints::sample(&scan, &CorrespondenceParams::default()).unwrap();
        match correspondences(&keypoints, &keypoints, &params) {
            Err(CorrespondenceError::Parameter(error)) => assert_eq!(error.name, name),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn keypoints_of_different_dimensions_have_no_correspondences() {
    let params = CorrespondenceParams::default();
    let [i, j] =
        [3, 4].map(|dimension| Keypoints::sample(&scan(dimension).unwrap(), &params).unwrap());
    let differ = DimensionsDiffer { i: 3, j: 4 };
    assert_eq!(correspondences(&i, &j, &params), Err(differ.into()));
}

#[cfg(feature = "serde")]
mod files {
    use gmpcr_correspondence::match_descriptors;
    use serde_json::{from_value, json, to_value};

    use super::*;

    #[test]
    fn all_types_come_back_as_they_were() {
        let scan = scan(3).unwrap();
        let params = CorrespondenceParams {
            num_samples: 7,
            ..Default::default()
        };
        let keypoints = Keypoints::sample(&scan, &params).unwrap();
        let matches = match_descriptors(scan.descriptors(), scan.descriptors()).unwrap();
        let written = to_value((&scan, &params, &keypoints, &matches)).unwrap();
        let read: (Scan, CorrespondenceParams, Keypoints, Vec<Match>) =
            from_value(written).unwrap();
        assert_eq!(read, (scan, params, keypoints, matches));
    }

    #[test]
    fn absent_parameters_are_the_default_and_unknown_ones_refused() {
        let partial: CorrespondenceParams = from_value(json!({ "num_samples": 9 })).unwrap();
        assert_eq!(
            partial,
            CorrespondenceParams {
                num_samples: 9,
                ..Default::default()
            }
        );
        assert!(from_value::<CorrespondenceParams>(json!({ "samples": 9 })).is_err());
    }

    #[test]
    fn scans_and_keypoints_are_checked_when_they_are_read() {
        let ragged = json!({ "values": [1.0, 2.0, 3.0], "dimension": 2 });
        let error = from_value::<Descriptors>(ragged).unwrap_err().to_string();
        assert_eq!(error, "3 numbers do not fill rows of 2");
        let mut written = to_value(scan(3).unwrap()).unwrap();
        written["points"][0][1] = json!(1e200);
        assert!(from_value::<Scan>(written).is_err());
        let keypoints = Keypoints::sample(&scan(3).unwrap(), &CorrespondenceParams::default());
        let mut written = to_value(keypoints.unwrap()).unwrap();
        written["rows"] = json!([0]);
        let error = from_value::<Keypoints>(written).unwrap_err().to_string();
        assert_eq!(error, "1 rows, but 2 points");
    }
}

//! What users of the types rely on beside the numbers.

use gmpcr_geometry::{InvalidParameter, PairsError, PointPairs, SignedSvd3};

#[test]
fn the_types_go_between_threads() {
    fn check<T: Send + Sync>() {}
    check::<PointPairs>();
    check::<PairsError>();
    check::<SignedSvd3>();
    check::<InvalidParameter>();
}

#[cfg(feature = "serde")]
mod files {
    use gmpcr_geometry::{PointPairs, SignedSvd3, matrix_rows};
    use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
    use serde::{Deserialize, Serialize};
    use serde_json::{from_value, json, to_value};

    #[test]
    fn point_pairs_come_back_as_they_were() {
        let points = vec![Point3::new(0.1, 2.0, -3.0), Point3::origin()];
        let pairs = PointPairs::new(points.clone(), points).unwrap();
        let written = to_value(&pairs).unwrap();
        assert_eq!(from_value::<PointPairs>(written).unwrap(), pairs);
    }

    #[test]
    fn point_pairs_are_checked_when_they_are_read() {
        let ragged = json!({ "target": [[0.0, 0.0, 0.0]], "source": [] });
        let error = from_value::<PointPairs>(ragged).unwrap_err().to_string();
        assert_eq!(error, "1 target points do not pair with 0 source points");
        let huge = json!({ "target": [[0.0, 0.0, 1e200]], "source": [[0.0, 0.0, 0.0]] });
        assert!(from_value::<PointPairs>(huge).is_err());
        let unknown = json!({ "target": [], "source": [], "weights": [] });
        assert!(from_value::<PointPairs>(unknown).is_err());
    }

    #[test]
    fn decompositions_come_back_as_they_were() {
        let svd = SignedSvd3::new(&Matrix3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0));
        let written = to_value(&svd).unwrap();
        assert_eq!(from_value::<SignedSvd3>(written).unwrap(), svd);
    }

    #[derive(Serialize, Deserialize)]
    struct Poses {
        #[serde(with = "matrix_rows")]
        first: Isometry3<f64>,
        #[serde(with = "matrix_rows::list")]
        all: Vec<Isometry3<f64>>,
    }

    #[test]
    fn transformations_are_twelve_numbers_and_rigid() {
        let first = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.1, -2.0, 0.3));
        let poses = Poses {
            first,
            all: vec![first.inverse(); 2],
        };
        let mut written = to_value(&poses).unwrap();
        assert_eq!(written["first"].as_array().unwrap().len(), 12);
        let read: Poses = from_value(written.clone()).unwrap();
        assert!((read.first.to_matrix() - first.to_matrix()).norm() < 1e-14);
        assert!((read.all[1].to_matrix() - first.inverse().to_matrix()).norm() < 1e-14);
        written["all"][1][0] = json!(3.0);
        let error = from_value::<Poses>(written).err().unwrap().to_string();
        assert!(
            error.starts_with("transformation 1 is not rigid"),
            "{error}"
        );
    }
}

//! What users of the types rely on beside the candidates.

use gmpcr_posegraph::PairConfidences;
use gmpcr_retrieval::{Index, RetrievalError, RetrievalParams, candidate_pairs, further_pairs};

#[test]
fn the_types_go_between_threads() {
    fn check<T: Send + Sync>() {}
    check::<Index>();
    check::<RetrievalError>();
    check::<RetrievalParams>();
}

#[test]
fn every_parameter_out_of_range_is_named() {
    let good = RetrievalParams::default();
    assert_eq!(good.validate(), Ok(()));
    let per_scan = RetrievalParams {
        candidates_per_scan: 0,
        ..good.clone()
    };
    let per_expansion = RetrievalParams {
        candidates_per_expansion: 0,
        ..good
    };
    let cases = [
        (per_scan, "candidates_per_scan"),
        (per_expansion, "candidates_per_expansion"),
    ];
    let none = PairConfidences::new(0, Vec::new()).unwrap();
    for (params, name) in cases {
        assert_eq!(params.validate().unwrap_err().name, name);
        assert_eq!(further_pairs(&none, &params).unwrap_err().name, name);
        match candidate_pairs(&[], &params) {
            Err(RetrievalError::Parameter(error)) => assert_eq!(error.name, name),
            other => panic!("{other:?}"),
        }
    }
}

#[cfg(feature = "serde")]
mod files {
    use serde_json::{from_value, json, to_value};

    use super::*;

    #[test]
    fn parameters_come_back_as_they_were() {
        let params = RetrievalParams {
            min_scans: 7,
            ..RetrievalParams::default()
        };
        assert_eq!(
            from_value::<RetrievalParams>(to_value(&params).unwrap()).unwrap(),
            params
        );
    }

    #[test]
    fn absent_parameters_are_the_default_and_unknown_ones_refused() {
        let partial: RetrievalParams = from_value(json!({ "expansions": 2 })).unwrap();
        assert_eq!(
            partial,
            RetrievalParams {
                expansions: 2,
                ..RetrievalParams::default()
            }
        );
        assert!(from_value::<RetrievalParams>(json!({ "rounds": 2 })).is_err());
    }
}

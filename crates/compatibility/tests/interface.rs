//! What users of the types rely on beside the numbers.

use gmpcr_compatibility::{
    CompatibilityGraph, CompatibilityParams, DominantEigenpair, PointPairs, Route, SpectralFilter,
};

#[test]
fn the_types_go_between_threads() {
    fn check<T: Send + Sync>() {}
    check::<CompatibilityGraph>();
    check::<CompatibilityParams>();
    check::<DominantEigenpair>();
    check::<Route>();
    check::<SpectralFilter>();
}

#[test]
fn every_parameter_out_of_range_is_named() {
    let good = CompatibilityParams::default();
    assert_eq!(good.validate(), Ok(()));
    let tolerance = [0.0, -1.0, f64::NAN, f64::INFINITY].map(|tolerance| {
        let params = CompatibilityParams {
            tolerance,
            ..good.clone()
        };
        (params, "tolerance")
    });
    let fraction = [0.0, -0.5, 1.1, f64::NAN].map(|retained_fraction| {
        let params = CompatibilityParams {
            retained_fraction,
            ..good.clone()
        };
        (params, "retained_fraction")
    });
    for (params, name) in tolerance.into_iter().chain(fraction) {
        assert_eq!(params.validate().unwrap_err().name, name);
        let error = SpectralFilter::new(&PointPairs::default(), &params).unwrap_err();
        assert_eq!(error.name, name);
    }
}

#[cfg(feature = "serde")]
mod files {
    use nalgebra::Point3;
    use serde_json::{from_value, json, to_value};

    use super::*;

    fn filter(params: &CompatibilityParams) -> Result<SpectralFilter, Box<dyn std::error::Error>> {
        let points = |scale: f64| {
            (0..9)
                .map(f64::from)
                .map(move |k| Point3::new(k.sin(), (2.0 * k).cos(), scale * k))
        };
        let pairs = PointPairs::new(points(0.1).collect(), points(0.11).collect())?;
        Ok(SpectralFilter::new(&pairs, params)?)
    }

    #[test]
    fn all_types_come_back_as_they_were() {
        let params = CompatibilityParams {
            tolerance: 0.3,
            ..Default::default()
        };
        let filter = filter(&params).unwrap();
        assert!(filter.raw_confidence() > 0.0);
        let written = to_value((&filter, &params)).unwrap();
        let read: (SpectralFilter, CompatibilityParams) = from_value(written).unwrap();
        assert_eq!(read, (filter, params));
    }

    #[test]
    fn absent_parameters_are_the_default_and_unknown_ones_refused() {
        let partial: CompatibilityParams = from_value(json!({ "tolerance": 9.0 })).unwrap();
        assert_eq!(
            partial,
            CompatibilityParams {
                tolerance: 9.0,
                ..Default::default()
            }
        );
        assert!(from_value::<CompatibilityParams>(json!({ "tau": 9.0 })).is_err());
    }

    #[test]
    fn graphs_are_checked_when_they_are_read() {
        let graph = filter(&CompatibilityParams::default()).unwrap().graph;
        let mut written = to_value(&graph).unwrap();
        assert_eq!(
            from_value::<CompatibilityGraph>(written.clone()).unwrap(),
            graph
        );
        written["fcg"][0][1] = json!(1.5);
        assert!(from_value::<CompatibilityGraph>(written).is_err());
    }
}

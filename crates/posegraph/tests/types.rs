//! What users may rely on of the public types.

use gmpcr_posegraph::{
    Bridge, Components, ConfidenceError, Connectivity, InvalidParameter, PairConfidences,
    PoseGraph, PoseGraphError, PoseGraphParams,
};

#[test]
fn types_may_go_from_thread_to_thread() {
    fn check<T: Send + Sync>() {}
    check::<(Components, Connectivity, PairConfidences, PoseGraph)>();
    check::<(Bridge, PoseGraphParams)>();
    check::<(ConfidenceError, PoseGraphError, InvalidParameter)>();
}

#[cfg(feature = "serde")]
#[test]
fn parameters_and_plain_results_survive_a_file() {
    use gmpcr_posegraph::bridges;

    let params: PoseGraphParams = serde_json::from_str("{}").expect("all have defaults");
    assert_eq!(params, PoseGraphParams::default());
    assert!(serde_json::from_str::<PoseGraphParams>(r#"{ "neighbours": 3 }"#).is_err());

    let figures = Connectivity::new(4, &[(0, 1), (1, 2)], 3);
    let text = serde_json::to_string(&(&figures, bridges(2, [(0, 1)]))).expect("plain data");
    let read: (Connectivity, Vec<Bridge>) = serde_json::from_str(&text).expect("its own text");
    assert_eq!(read, (figures, bridges(2, [(0, 1)])));
}

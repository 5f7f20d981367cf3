//! Synchronization methods as the experiments use them.

use crate::failure::Failure;

use gmpcr::posegraph::PoseGraph;
use gmpcr::sync::{AdaptiveHistory, History, Method, SyncParams, Synchronization, synchronize};

/// What SGHR does.
pub fn sghr() -> Method {
    History::Sghr.into()
}

/// The same parameters without the recovery term.
pub fn without_recovery(params: &SyncParams) -> SyncParams {
    let method = match params.method {
        Method::HistoryAware(History::Adaptive(history)) => {
            let history = AdaptiveHistory {
                recovery: 0.0,
                ..history
            };
            History::Adaptive(history).into()
        }
        other => other,
    };
    SyncParams {
        method,
        ..params.clone()
    }
}

/// The poses of a graph.
pub fn synchronized(graph: &PoseGraph, params: &SyncParams) -> Result<Synchronization, Failure> {
    Ok(synchronize(graph, params))
}

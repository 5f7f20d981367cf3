//! Synchronisation of relative poses: connection-Laplacian rotation averaging, translation least squares and history-aware reweighting.

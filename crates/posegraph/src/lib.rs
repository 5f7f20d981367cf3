//! Scan-pair confidences, top-K union selection, connectivity figures and the pose graph.

//! Evaluation protocols of multiview point cloud registration on plain values.

//! Spectral consistency-guided multiview point cloud registration: globally consistent poses of many scans, also at low overlap.

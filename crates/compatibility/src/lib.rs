//! First- and second-order compatibility graphs of point correspondences, their dominant eigenvector, spectral filtering and scan-pair confidence.

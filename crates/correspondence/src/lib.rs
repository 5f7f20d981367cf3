//! Described scans, farthest-point sampling in descriptor space and mutual nearest-neighbour matching.

//! Simulated depth-camera scans of generated indoor scenes with ground truth.

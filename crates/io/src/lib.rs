//! Point clouds, descriptors, poses and pose graphs in the files that people already have.

//! From a raw point cloud to described keypoints: voxel grid, oriented normals, FPFH.

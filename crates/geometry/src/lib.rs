//! Paired points, nearest rotations and rotation angles: the small rigid geometry that the gmpcr crates share.

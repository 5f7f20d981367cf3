//! Relative pose from contaminated correspondences: maximal cliques of a compatibility graph, weighted Kabsch, hypothesis choice by inlier ratio.

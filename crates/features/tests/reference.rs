//! The definitions written down plainly, with all pairs of points, against the fast functions.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail")]

mod common;

use common::{bumpy_sheet, unit_vectors};
use gmpcr_features::{FpfhParams, NormalParams, estimate_normals, fpfh, voxel_grid};
use nalgebra::{Matrix3, Point3, Vector3};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Mean point of each voxel, by voxel.
fn plain_voxel_grid(points: &[Point3<f64>], size: f64) -> Vec<Point3<f64>> {
    let origin = [0, 1, 2]
        .map(|axis| points.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min) - 0.5 * size);
    let mut voxels = BTreeMap::<_, Vec<_>>::new();
    for point in points {
        let cell = [0, 1, 2].map(|axis| ((point[axis] - origin[axis]) / size).floor() as i64);
        voxels.entry(cell).or_default().push(point.coords);
    }
    voxels
        .values()
        .map(|v| (v.iter().sum::<Vector3<f64>>() / v.len() as f64).into())
        .collect()
}

/// The point itself, then the nearest others closer than the radius; ties by index.
fn plain_neighbors(points: &[Point3<f64>], i: usize, radius: f64, most: usize) -> Vec<usize> {
    let distance = |j: usize| (points[j] - points[i]).norm_squared();
    let mut near: Vec<usize> = (0..points.len())
        .filter(|&j| distance(j) < radius * radius)
        .collect();
    near.sort_by(|&a, &b| {
        distance(a)
            .total_cmp(&distance(b))
            .then((a != i).cmp(&(b != i)))
    });
    near.truncate(most);
    near
}

fn plain_normals(points: &[Point3<f64>], params: &NormalParams) -> Vec<Vector3<f64>> {
    let normal = |i: usize| {
        let near = plain_neighbors(points, i, params.radius, params.max_neighbors);
        let view = params.viewpoint - points[i];
        if near.len() < 3 {
            return view.normalize();
        }
        let mean = near.iter().map(|&j| points[j].coords).sum::<Vector3<f64>>() / near.len() as f64;
        let offset = |&j: &usize| points[j].coords - mean;
        let scatter: Matrix3<f64> = near.iter().map(offset).map(|o| o * o.transpose()).sum();
        let svd = scatter.symmetric_eigen();
        let normal = svd.eigenvectors.column(svd.eigenvalues.imin()).into_owned();
        if normal.dot(&view) < 0.0 {
            -normal
        } else {
            normal
        }
    };
    (0..points.len()).map(normal).collect()
}

/// The three features of a pair, as numbers.
fn plain_features(
    (p, n): (Point3<f64>, Vector3<f64>),
    (q, m): (Point3<f64>, Vector3<f64>),
) -> [f64; 3] {
    let line = (q - p) / (q - p).norm();
    if n.dot(&line).abs().acos() > m.dot(&line).abs().acos() {
        return frame_features(m, n, -line);
    }
    frame_features(n, m, line)
}

fn frame_features(u: Vector3<f64>, target: Vector3<f64>, line: Vector3<f64>) -> [f64; 3] {
    let v = line.cross(&u).normalize();
    let w = u.cross(&v);
    [
        w.dot(&target).atan2(u.dot(&target)),
        v.dot(&target),
        u.dot(&line),
    ]
}

fn plain_spfh(
    points: &[Point3<f64>],
    normals: &[Vector3<f64>],
    i: usize,
    others: &[usize],
) -> [f64; 33] {
    let mut histogram = [0.0; 33];
    for &j in others {
        let [f0, f1, f2] = if points[i] == points[j] {
            [0.0; 3]
        } else {
            plain_features((points[i], normals[i]), (points[j], normals[j]))
        };
        let parts = [(f0 + PI) / (2.0 * PI), (f1 + 1.0) / 2.0, (f2 + 1.0) / 2.0];
        for (feature, part) in parts.into_iter().enumerate() {
            let bin = ((11.0 * part).floor() as usize).min(10);
            histogram[11 * feature + bin] += 100.0 / others.len() as f64;
        }
    }
    histogram
}

fn plain_fpfh(
    points: &[Point3<f64>],
    normals: &[Vector3<f64>],
    params: &FpfhParams,
) -> Vec<[f64; 33]> {
    let others =
        |i: usize| plain_neighbors(points, i, params.radius, params.max_neighbors).split_off(1);
    let spfh = |i: usize| plain_spfh(points, normals, i, &others(i));
    let descriptor = |i: usize| {
        let mut sum = [0.0; 33];
        for j in others(i).into_iter().filter(|&j| points[j] != points[i]) {
            let squared_distance = (points[j] - points[i]).norm_squared();
            for (s, h) in sum.iter_mut().zip(spfh(j)) {
                *s += h / squared_distance;
            }
        }
        let mut own = spfh(i);
        for (own, sum) in own.chunks_mut(11).zip(sum.chunks(11)) {
            let total: f64 = sum.iter().sum();
            if total > 0.0 {
                own.iter_mut()
                    .zip(sum)
                    .for_each(|(o, s)| *o += 100.0 * s / total);
            }
        }
        own
    };
    (0..points.len()).map(descriptor).collect()
}

fn sorted(mut points: Vec<Point3<f64>>) -> Vec<Point3<f64>> {
    points.sort_by(|a, b| {
        a.coords
            .as_slice()
            .partial_cmp(b.coords.as_slice())
            .unwrap()
    });
    points
}

fn assert_same_descriptors(fast: &[[f32; 33]], plain: &[[f64; 33]]) {
    assert_eq!(fast.len(), plain.len());
    for (i, (fast, plain)) in fast.iter().zip(plain).enumerate() {
        for (k, (a, b)) in fast.iter().zip(plain).enumerate() {
            assert!(
                (f64::from(*a) - b).abs() < 1e-4,
                "point {i}, bin {k}: {a} instead of {b}"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn voxel_grid_is_the_mean_of_the_points_of_each_voxel(
        seed in any::<u64>(), num_points in 1_usize..200, size in 0.02..2.0,
    ) {
        let cloud = bumpy_sheet(num_points, seed);
        let fast = sorted(voxel_grid(&cloud, size).unwrap());
        let plain = sorted(plain_voxel_grid(&cloud, size));
        prop_assert_eq!(fast.len(), plain.len());
        for (a, b) in fast.iter().zip(&plain) {
            prop_assert!((a - b).norm() < 1e-14);
        }
    }

    #[test]
    fn normals_are_those_of_the_definition(
        seed in any::<u64>(), num_points in 1_usize..120, max_neighbors in 4_usize..40,
    ) {
        let cloud = bumpy_sheet(num_points, seed);
        let params = NormalParams { radius: 0.3, max_neighbors, ..NormalParams::default() };
        let fast = estimate_normals(&cloud, &params).unwrap();
        for (a, b) in fast.iter().zip(plain_normals(&cloud, &params)) {
            prop_assert!((a - b).norm() < 1e-6, "{} instead of {}", a, b);
        }
    }

    #[test]
    fn descriptors_are_those_of_the_definition(
        seed in any::<u64>(), num_points in 1_usize..80, max_neighbors in 1_usize..40,
    ) {
        let cloud = bumpy_sheet(num_points, seed);
        let normals = unit_vectors(num_points, !seed);
        let params = FpfhParams { radius: 0.4, max_neighbors };
        let fast = fpfh(&cloud, &normals, &params).unwrap();
        assert_same_descriptors(&fast, &plain_fpfh(&cloud, &normals, &params));
    }

    #[test]
    fn descriptors_of_a_cloud_with_duplicates_are_those_of_the_definition(
        seed in any::<u64>(), max_neighbors in 1_usize..40,
    ) {
        let mut cloud = bumpy_sheet(40, seed);
        cloud.extend_from_within(5..25);
        let normals = unit_vectors(60, !seed);
        let params = FpfhParams { radius: 0.4, max_neighbors };
        let fast = fpfh(&cloud, &normals, &params).unwrap();
        assert_same_descriptors(&fast, &plain_fpfh(&cloud, &normals, &params));
    }
}

//! What a registration says of its weak places, on pose graphs that are made to have them.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use gmpcr::geometry::PointPairs;
use gmpcr::nalgebra::{Isometry3, Point3, Vector3};
use gmpcr::{Params, Registration, Warning, register_matches};

fn pose(scan: usize) -> Isometry3<f64> {
    let k = scan as f64;
    Isometry3::new(
        Vector3::new(k, 0.5 * k, -k),
        Vector3::new(0.2 * k, -0.1, 0.3 * k),
    )
}

/// Correspondences of two scans, all of which a transformation explains: that of the poses, after `error`.
fn matches(i: usize, j: usize, error: Isometry3<f64>) -> PointPairs {
    let points = (0..30).map(f64::from);
    let points = points.map(|k| Point3::new((k * 1.3).sin() * 2.0, (k * 0.7).cos() * 2.0, k.sin()));
    let source: Vec<_> = points.collect();
    let i_from_j = error * pose(i).inv_mul(&pose(j));
    PointPairs::new(source.iter().map(|p| i_from_j * p).collect(), source).unwrap()
}

fn registered(
    num_scans: usize,
    edges: &[(usize, usize)],
    outliers: &[(usize, usize)],
) -> Registration {
    let turned = Isometry3::new(Vector3::new(3.0, 0.0, 0.0), Vector3::x() * 1.5);
    let right = edges
        .iter()
        .map(|&(i, j)| ((i, j), matches(i, j, Isometry3::identity())));
    let wrong = outliers
        .iter()
        .map(|&(i, j)| ((i, j), matches(i, j, turned)));
    let all: BTreeMap<_, _> = right.chain(wrong).collect();
    register_matches(num_scans, &all, &Params::default(), &()).unwrap()
}

/// Triangles 0 1 2 and 3 4 5.
const TRIANGLES: [(usize, usize); 6] = [(0, 1), (0, 2), (1, 2), (3, 4), (3, 5), (4, 5)];

fn warnings(registration: &Registration) -> Vec<Warning> {
    registration.warnings(&Params::default())
}

#[test]
fn a_consistent_triangle_gives_no_warning() {
    let registration = registered(3, &TRIANGLES[..3], &[]);
    assert!(warnings(&registration).is_empty());
    assert!(registration.bridges().is_empty());
    assert_eq!(registration.trusted_parts().members(), [vec![0, 1, 2]]);
}

#[test]
fn scans_without_edges_and_other_frames_are_named() {
    let registration = registered(9, &[&TRIANGLES[..], &[(6, 7)]].concat(), &[]);
    assert_eq!(
        warnings(&registration),
        [
            Warning::Unregistered {
                scan: 8,
                num_unresolved: 0
            },
            Warning::SeparateFrame {
                scans: vec![3, 4, 5]
            },
            Warning::SeparateFrame { scans: vec![6, 7] },
        ]
    );
    // A single scan is where it belongs.
    assert!(warnings(&registered(1, &[], &[])).is_empty());
}

#[test]
fn an_edge_between_triangles_is_a_bridge_and_their_own_are_none() {
    let registration = registered(6, &[&TRIANGLES[..], &[(2, 3)]].concat(), &[]);
    let bridges = registration.bridges();
    assert_eq!(bridges.len(), 1);
    let edge = &registration.edges[bridges[0].edge];
    assert_eq!((edge.i, edge.j), (2, 3));
    assert_eq!(bridges[0].smaller_side, [3, 4, 5]);
    assert_eq!(
        warnings(&registration),
        [Warning::Bridge {
            edge: bridges[0].edge,
            scans: vec![3, 4, 5]
        }]
    );
    // Two scans alone cannot be more than a bridge to each other.
    assert!(warnings(&registered(2, &[(0, 1)], &[])).is_empty());
}

#[test]
fn an_outlier_edge_contradicts_the_result_and_connects_nothing() {
    let complete = [
        (0, 1),
        (0, 2),
        (0, 3),
        (1, 2),
        (1, 3),
        (2, 3),
        (3, 4),
        (2, 4),
    ];
    let registration = registered(5, &complete, &[(0, 4)]);
    let found = warnings(&registration);
    let [Warning::Contradiction { edge }] = found[..] else {
        panic!("{found:?}");
    };
    let outlier = &registration.edges[edge];
    assert_eq!((outlier.i, outlier.j), (0, 4));
    assert!(!outlier.is_trusted());
    assert_eq!(found[0].scans(&registration), [0, 4]);
    assert_eq!(registration.trusted_parts().members().len(), 1);
}

#[test]
fn the_weakest_edges_are_a_spanning_forest_in_ascending_order() {
    let registration = registered(9, &[&TRIANGLES[..], &[(2, 3), (6, 7)]].concat(), &[]);
    let weakest = registration.weakest_edges();
    assert_eq!(weakest.len(), 6);
    let weights = weakest
        .iter()
        .map(|&k| registration.edges[k].synchronization.final_weight);
    assert!(weights.collect::<Vec<_>>().is_sorted());
}

//! The nearest points within a radius, in an order that does not depend on the search tree.

use crate::Error;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Point3;
use std::cmp::Ordering;
use std::num::NonZero;

type Metric = SquaredEuclidean<f64>;

/// Another point of the cloud, seen from the point at the center of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Neighbor {
    pub(crate) squared_distance: f64,
    pub(crate) index: u32,
}

impl Neighbor {
    pub(crate) fn at(&self) -> usize {
        self.index as usize
    }

    /// Nearer first; among equally far points the one that comes first in the cloud.
    fn order(&self, other: &Self) -> Ordering {
        self.squared_distance
            .total_cmp(&other.squared_distance)
            .then(self.index.cmp(&other.index))
    }
}

/// How far a search reaches: points strictly closer than `radius`, and of these the nearest
/// `max_neighbors`, counting the point at the center.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    pub(crate) radius: f64,
    pub(crate) max_neighbors: usize,
}

impl Reach {
    pub(crate) fn covers(&self, other: &Self) -> bool {
        self.radius >= other.radius && self.max_neighbors >= other.max_neighbors
    }

    /// The part within reach of a list that is in order and reaches at least as far.
    pub(crate) fn of<'a>(&self, neighbors: &'a [Neighbor]) -> &'a [Neighbor] {
        let squared_radius = self.radius * self.radius;
        let inside = neighbors.partition_point(|n| n.squared_distance < squared_radius);
        &neighbors[..inside.min(self.max_neighbors - 1)]
    }
}

/// Search tree over a cloud whose coordinates are finite.
pub(crate) struct Search {
    points: Vec<[f64; 3]>,
    tree: ImmutableKdTree<f64, 3>,
}

impl Search {
    pub(crate) fn new(points: &[Point3<f64>]) -> Result<Self, Error> {
        let points: Vec<[f64; 3]> = points.iter().map(|point| point.coords.into()).collect();
        let tree = ImmutableKdTree::new_from_slice(&points).map_err(|_| Error::TooManyPoints {
            num_points: points.len(),
        })?;
        Ok(Self { points, tree })
    }

    /// Fills `neighbors` with the other points within reach of point `center`, nearest first.
    pub(crate) fn around(&self, center: usize, reach: Reach, neighbors: &mut Vec<Neighbor>) {
        neighbors.clear();
        let wanted = reach.max_neighbors.min(self.points.len());
        self.collect(center, reach.radius * reach.radius, wanted, neighbors);
        neighbors.retain(|neighbor| neighbor.at() != center);
        keep_smallest(neighbors, wanted - 1);
        neighbors.sort_unstable_by(Neighbor::order);
    }

    /// The `wanted` nearest points and all that are as far away as the last of them.
    ///
    /// The tree breaks ties as it likes. One point more than wanted shows whether there is a tie
    /// at the end; then all candidates are collected.
    fn collect(&self, center: usize, squared_radius: f64, wanted: usize, out: &mut Vec<Neighbor>) {
        let query = self.tree.query(&self.points[center]);
        let nearest = query
            .nearest_n::<Metric>(NonZero::<usize>::MIN.saturating_add(wanted))
            .within(squared_radius)
            .exclusive_boundaries()
            .execute();
        match nearest.get(wanted) {
            Some(next) if next.distance == nearest[wanted - 1].distance => {
                self.collect_within(center, next.distance, out);
            }
            _ => out.extend(nearest.iter().take(wanted).map(|found| Neighbor {
                squared_distance: found.distance,
                index: found.item,
            })),
        }
    }

    fn collect_within(&self, center: usize, squared_distance: f64, out: &mut Vec<Neighbor>) {
        self.tree
            .query(&self.points[center])
            .within::<Metric>(squared_distance)
            .unsorted()
            .visit(|found| {
                out.push(Neighbor {
                    squared_distance: found.distance,
                    index: found.item,
                });
            });
    }

    /// The neighbors of every point.
    pub(crate) fn everywhere(&self, reach: Reach) -> Neighborhoods {
        let mut all = Neighborhoods {
            ends: Vec::new(),
            neighbors: Vec::new(),
        };
        let mut neighbors = Vec::new();
        for center in 0..self.points.len() {
            self.around(center, reach, &mut neighbors);
            all.neighbors.extend_from_slice(&neighbors);
            all.ends.push(all.neighbors.len());
        }
        all
    }
}

fn keep_smallest(neighbors: &mut Vec<Neighbor>, count: usize) {
    if neighbors.len() > count {
        neighbors.select_nth_unstable_by(count, Neighbor::order);
        neighbors.truncate(count);
    }
}

/// The neighbors of each point of a cloud, nearest first, without the point itself.
pub(crate) struct Neighborhoods {
    ends: Vec<usize>,
    neighbors: Vec<Neighbor>,
}

impl Neighborhoods {
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[Neighbor]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts
            .zip(&self.ends)
            .map(|(start, &end)| &self.neighbors[start..end])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn by_scanning_all(points: &[Point3<f64>], center: usize, reach: Reach) -> Vec<Neighbor> {
        let mut all: Vec<_> = (0..points.len())
            .filter(|&k| k != center)
            .map(|k| Neighbor {
                squared_distance: (points[k] - points[center]).norm_squared(),
                index: k as u32,
            })
            .filter(|neighbor| neighbor.squared_distance < reach.radius * reach.radius)
            .collect();
        all.sort_by(Neighbor::order);
        all.truncate(reach.max_neighbors - 1);
        all
    }

    /// Coordinates should be small integers, so that distances are exact and ties are ties.
    fn assert_finds_what_scanning_finds(points: &[Point3<f64>]) {
        let search = Search::new(points).unwrap();
        let mut found = Vec::new();
        for (radius, max_neighbors) in [(1.5, 5), (3.0, 20), (3.0, 1), (1e9, 7), (2.0, 100_000)] {
            let reach = Reach {
                radius,
                max_neighbors,
            };
            for center in (0..points.len()).step_by(7) {
                search.around(center, reach, &mut found);
                assert_eq!(
                    found,
                    by_scanning_all(points, center, reach),
                    "center {center}"
                );
            }
        }
    }

    #[test]
    fn ties_on_a_lattice_go_to_the_first_points() {
        let scrambled = |k: usize| k * 379 % 1000;
        let point = |k: usize| Point3::new((k % 10) as f64, (k / 10 % 10) as f64, (k / 100) as f64);
        assert_finds_what_scanning_finds(&(0..1000).map(scrambled).map(point).collect::<Vec<_>>());
    }

    #[test]
    fn thousands_of_points_in_one_place_are_no_trouble() {
        assert_finds_what_scanning_finds(&[Point3::new(1.0, 2.0, 3.0); 2000]);
    }

    #[test]
    fn points_in_few_places_are_no_trouble() {
        let cloud: Vec<_> = (0..2000)
            .map(|k| Point3::new((k % 3) as f64, 0.0, 0.0))
            .collect();
        assert_finds_what_scanning_finds(&cloud);
    }

    #[test]
    fn points_on_a_line_are_no_trouble() {
        let cloud: Vec<_> = (0..2000)
            .map(|k| Point3::new(1.0, 2.0, 2.0) * f64::from(k))
            .collect();
        assert_finds_what_scanning_finds(&cloud);
        let cloud: Vec<_> = (0..2000)
            .map(|k| Point3::new(7.0, f64::from(k), 7.0))
            .collect();
        assert_finds_what_scanning_finds(&cloud);
    }

    #[test]
    fn a_point_at_the_radius_is_outside() {
        let cloud = [Point3::origin(), Point3::new(2.0, 0.0, 0.0)];
        let search = Search::new(&cloud).unwrap();
        let mut found = Vec::new();
        search.around(
            0,
            Reach {
                radius: 2.0,
                max_neighbors: 9,
            },
            &mut found,
        );
        assert_eq!(found, []);
        search.around(
            0,
            Reach {
                radius: 2.0 + 1e-15,
                max_neighbors: 9,
            },
            &mut found,
        );
        assert_eq!(
            found,
            [Neighbor {
                squared_distance: 4.0,
                index: 1
            }]
        );
    }

    #[test]
    fn a_shorter_reach_takes_the_head_of_a_longer_list() {
        let cloud: Vec<_> = (0..50)
            .map(|k| Point3::new(f64::from(k), 0.0, 0.0))
            .collect();
        let search = Search::new(&cloud).unwrap();
        let far = search.everywhere(Reach {
            radius: 20.0,
            max_neighbors: 30,
        });
        let mut near = Vec::new();
        for reach in [(5.0, 30), (20.0, 4), (20.0, 30), (0.5, 1)] {
            let reach = Reach {
                radius: reach.0,
                max_neighbors: reach.1,
            };
            for (center, neighbors) in far.iter().enumerate() {
                search.around(center, reach, &mut near);
                assert_eq!(reach.of(neighbors), near);
            }
        }
    }
}

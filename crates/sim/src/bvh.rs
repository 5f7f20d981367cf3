//! A bounding volume hierarchy: which primitive a ray meets first, without asking each one.

use nalgebra::Vector3;

use crate::primitive::Primitive;
use crate::ray::{Hit, Ray};

/// Primitives a leaf holds at most.
const LEAF_SIZE: usize = 2;

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub min: Vector3<f64>,
    pub max: Vector3<f64>,
}

impl Bounds {
    const NOTHING: Self = Self {
        min: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        max: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    pub(crate) fn around(parts: impl Iterator<Item = Self>) -> Self {
        parts.fold(Self::NOTHING, |all, part| Self {
            min: all.min.inf(&part.min),
            max: all.max.sup(&part.max),
        })
    }

    /// Half the surface, to which the chance of a random ray to enter is proportional.
    fn half_surface(&self) -> f64 {
        let size = self.max - self.min;
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    fn center(&self) -> Vector3<f64> {
        (self.min + self.max) / 2.0
    }

    /// Where the ray enters, if it does so before `limit`.
    ///
    /// A ray that runs inside a bounding plane yields NaN there, which no comparison lets in.
    fn entry(&self, origin: &Vector3<f64>, inverse: &Vector3<f64>, limit: f64) -> Option<f64> {
        let (mut enter, mut exit) = (0.0, limit);
        for axis in 0..3 {
            let low = (self.min[axis] - origin[axis]) * inverse[axis];
            let high = (self.max[axis] - origin[axis]) * inverse[axis];
            let (near, far) = if inverse[axis] > 0.0 {
                (low, high)
            } else {
                (high, low)
            };
            enter = if near > enter { near } else { enter };
            exit = if far < exit { far } else { exit };
        }
        // The slack covers the rounding of the reciprocals at flat boxes.
        (enter <= exit + 1e-9).then_some(enter)
    }
}

#[derive(Debug, Clone, Copy)]
enum Node {
    /// The left child follows its parent; the right one is named.
    Inner {
        right: usize,
    },
    Leaf {
        start: usize,
        end: usize,
    },
}

/// A binary tree of boxes over primitives.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bvh {
    nodes: Vec<(Bounds, Node)>,
    /// Primitives in the order of the leaves.
    order: Vec<usize>,
}

impl Bvh {
    pub(crate) fn new(primitives: &[Primitive]) -> Self {
        let bounds: Vec<Bounds> = primitives.iter().map(Primitive::bounds).collect();
        let mut tree = Self {
            nodes: Vec::new(),
            order: (0..primitives.len()).collect(),
        };
        if !primitives.is_empty() {
            tree.build(&bounds, 0, primitives.len());
        }
        tree
    }

    fn build(&mut self, bounds: &[Bounds], start: usize, end: usize) {
        let all = Bounds::around(self.order[start..end].iter().map(|&k| bounds[k]));
        let node = self.nodes.len();
        self.nodes.push((all, Node::Leaf { start, end }));
        if end - start <= LEAF_SIZE {
            return;
        }
        let (axis, left_size) = best_split(bounds, &mut self.order[start..end]);
        sort_along(bounds, &mut self.order[start..end], axis);
        let middle = start + left_size;
        self.build(bounds, start, middle);
        self.nodes[node].1 = Node::Inner {
            right: self.nodes.len(),
        };
        self.build(bounds, middle, end);
    }

    /// The nearest meeting of `ray` with any of `primitives` closer than `limit`.
    pub(crate) fn first_hit(&self, primitives: &[Primitive], ray: &Ray, limit: f64) -> Option<Hit> {
        let inverse = ray.direction.map(f64::recip);
        let mut best: Option<Hit> = None;
        let mut reach = limit;
        let mut open = Vec::with_capacity(32);
        let entry = |node: usize, reach: f64| {
            self.nodes
                .get(node)
                .and_then(|n| n.0.entry(&ray.origin.coords, &inverse, reach))
        };
        open.extend(entry(0, reach).map(|distance| (distance, 0)));
        while let Some((distance, node)) = open.pop() {
            if distance > reach {
                continue;
            }
            match self.nodes[node].1 {
                Node::Inner { right } => {
                    let left = node + 1;
                    let near_last = nearer_last(
                        entry(left, reach).map(|d| (d, left)),
                        entry(right, reach).map(|d| (d, right)),
                    );
                    open.extend(near_last.into_iter().flatten());
                }
                Node::Leaf { start, end } => {
                    for &primitive in &self.order[start..end] {
                        if let Some(hit) = primitives[primitive].intersect(ray)
                            && hit.distance < reach
                        {
                            reach = hit.distance;
                            best = Some(Hit {
                                distance: reach,
                                normal: hit.normal,
                                primitive,
                            });
                        }
                    }
                }
            }
        }
        best
    }
}

/// The axis, and how many primitives go to its lower side, that make the expected work least:
/// `surface · count` summed over both sides (the surface area heuristic of Goldsmith and Salmon,
/// IEEE CG&A 1987), over all splits of the order along each axis.
fn best_split(bounds: &[Bounds], order: &mut [usize]) -> (usize, usize) {
    let mut best = (f64::INFINITY, 0, order.len() / 2);
    for axis in 0..3 {
        sort_along(bounds, order, axis);
        let lower = growing_cost(order.iter().map(|&k| bounds[k]));
        let upper = growing_cost(order.iter().rev().map(|&k| bounds[k]));
        for left in 1..order.len() {
            let cost = lower[left - 1] + upper[order.len() - left - 1];
            if cost < best.0 {
                best = (cost, axis, left);
            }
        }
    }
    (best.1, best.2)
}

/// `surface · count` of the first one, two, three … boxes.
fn growing_cost(boxes: impl Iterator<Item = Bounds>) -> Vec<f64> {
    let grow = |all: &mut Bounds, (index, part): (usize, Bounds)| {
        *all = Bounds::around([*all, part].into_iter());
        Some(all.half_surface() * (index + 1) as f64)
    };
    boxes.enumerate().scan(Bounds::NOTHING, grow).collect()
}

fn sort_along(bounds: &[Bounds], order: &mut [usize], axis: usize) {
    order.sort_by(|&a, &b| {
        let along = |k: usize| bounds[k].center()[axis];
        along(a).total_cmp(&along(b)).then(a.cmp(&b))
    });
}

type Branch = Option<(f64, usize)>;

/// The two branches with the nearer one last, so that a stack opens it first.
fn nearer_last(left: Branch, right: Branch) -> [Branch; 2] {
    match (left, right) {
        (Some(a), Some(b)) if a.0 <= b.0 => [Some(b), Some(a)],
        _ => [left, right],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Stream, generator, rigid_transformation, uniform};
    use nalgebra::Point3;

    fn slow_hit(primitives: &[Primitive], ray: &Ray, limit: f64) -> Option<f64> {
        primitives
            .iter()
            .filter_map(|primitive| primitive.intersect(ray))
            .map(|hit| hit.distance)
            .filter(|&distance| distance < limit)
            .min_by(f64::total_cmp)
    }

    #[test]
    fn the_tree_finds_what_asking_every_primitive_finds() {
        let mut rng = generator(11, Stream::World);
        for size in [0, 1, 2, 5, 60] {
            let primitives: Vec<Primitive> = (0..size)
                .map(|k| {
                    let place = rigid_transformation(&mut rng, 2.0);
                    let size = uniform(&mut rng, 0.05, 0.6);
                    match k % 3 {
                        0 => Primitive::oriented_box(Vector3::new(size, 0.2, 0.4), place),
                        1 => Primitive::sphere(place.translation.vector.into(), size),
                        _ => Primitive::oriented_box(Vector3::new(size, 0.5, 0.0), place),
                    }
                })
                .collect();
            let tree = Bvh::new(&primitives);
            for _ in 0..500 {
                let origin = Point3::from(rigid_transformation(&mut rng, 3.0).translation.vector);
                let direction = rigid_transformation(&mut rng, 1.0) * Vector3::x_axis();
                let ray = Ray { origin, direction };
                let fast = tree
                    .first_hit(&primitives, &ray, 5.0)
                    .map(|hit| hit.distance);
                assert_eq!(fast, slow_hit(&primitives, &ray, 5.0));
            }
        }
    }

    #[test]
    fn a_ray_along_a_face_of_a_bounding_box_still_hits() {
        let size = Vector3::new(2.0, 2.0, 0.0);
        let floor = Primitive::oriented_box(size, nalgebra::Isometry3::identity());
        let tree = Bvh::new(&[floor]);
        for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 1.0)] {
            for (z, direction) in [(-1.0, Vector3::z_axis()), (1.0, -Vector3::z_axis())] {
                let ray = Ray {
                    origin: Point3::new(x, y, z),
                    direction,
                };
                let hit = tree.first_hit(&[floor], &ray, 9.0).unwrap();
                assert_eq!(hit.distance, 1.0);
            }
        }
    }
}

//! Less noise: every point is moved along its normal to the mean of its neighbors.

use std::ops::Range;

use crate::grid;
use crate::rigid::{dot, minus};
use crate::surface::Patch;

/// Bits of a cell's number along an axis.
const AXIS_BITS: u32 = 21;
/// Cosine of the angle of normals above which a neighbor belongs to the same surface.
const MIN_NORMAL_COSINE: f64 = 0.7;

/// Moves every point along its normal to the weighted mean of its neighbors on the same surface,
///
/// ```text
/// p ← p + n · Σ w (q − p) · n / Σ w,     w = 1 − ‖q − p‖² / radius²,     n_q · n > 0.7
/// ```
///
/// the point itself among them. Planes stay as they are. The points must span fewer cells of the radius than
/// the grid can number. `O(n log n)` for evenly spread points.
pub(crate) fn smooth(patches: &mut [Patch], radius: f64) {
    let corner = grid::corner(patches.iter().map(|patch| patch.point));
    let cell_of = |patch: &Patch| grid::cell_of(&patch.point, &corner, 1.0 / radius).map(u64::from);
    let cells: Vec<_> = patches.iter().map(cell_of).collect();
    let mut order: Vec<_> = cells.iter().map(|&cell| pack(cell)).zip(0..).collect();
    order.sort_unstable();
    let sorted: Vec<_> = order
        .iter()
        .map(|&(_, k): &(u64, usize)| patches[k])
        .collect();
    let (mut rows, mut key_of_rows) = (Default::default(), None);
    for (patch, &(key, k)) in sorted.iter().zip(&order) {
        if key_of_rows != Some(key) {
            rows = rows_around(cells[k], &order);
            key_of_rows = Some(key);
        }
        let neighbors = rows.iter().flat_map(|row| &sorted[row.clone()]);
        let along = mean_offset(patch, neighbors, radius);
        patches[k].point = [0, 1, 2].map(|c| patch.point[c] + along * patch.normal[c]);
    }
}

fn pack([x, y, z]: [u64; 3]) -> u64 {
    x | y << AXIS_BITS | z << (2 * AXIS_BITS)
}

/// Where, among the sorted points, those of the cells around a cell are: row by row. Cells have a margin, so
/// no number is negative.
fn rows_around([x, y, z]: [u64; 3], order: &[(u64, usize)]) -> [Range<usize>; 9] {
    let place = |key: u64| order.partition_point(|&(other, _)| other < key);
    std::array::from_fn(|row| {
        let (y, z) = (y + row as u64 % 3 - 1, z + row as u64 / 3 - 1);
        place(pack([x - 1, y, z]))..place(pack([x + 2, y, z]))
    })
}

/// How far the neighbors lie in the direction of the normal, in the mean.
fn mean_offset<'a>(patch: &Patch, neighbors: impl Iterator<Item = &'a Patch>, radius: f64) -> f64 {
    let inverse_square = 1.0 / (radius * radius);
    let (mut sum, mut weights) = (0.0, 0.0);
    for neighbor in neighbors {
        let away = minus(&neighbor.point, &patch.point);
        let weight = 1.0 - dot(&away, &away) * inverse_square;
        if weight > 0.0 && dot(&neighbor.normal, &patch.normal) > MIN_NORMAL_COSINE {
            sum += weight * dot(&away, &patch.normal);
            weights += weight;
        }
    }
    sum / weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(height: impl Fn(usize) -> f64) -> Vec<Patch> {
        let patch = |k: usize| Patch {
            point: [(k % 30) as f64, (k / 30) as f64, height(k)],
            normal: [0.0, 0.0, 1.0],
        };
        (0..900).map(patch).collect()
    }

    #[test]
    fn noise_of_a_plane_is_averaged_and_a_plane_kept() {
        let mut noisy = sheet(|k| if k * 7 % 11 < 5 { 0.2 } else { -0.2 });
        smooth(&mut noisy, 2.5);
        let squares: f64 = noisy.iter().map(|patch| patch.point[2].powi(2)).sum();
        assert!((squares / 900.0).sqrt() < 0.1, "{squares}");
        let mut plane = sheet(|_| 0.0);
        smooth(&mut plane, 2.5);
        for (smoothed, before) in plane.iter().zip(sheet(|_| 0.0)) {
            assert_eq!(smoothed.point, before.point);
        }
    }

    #[test]
    fn it_is_the_mean_over_all_points_in_the_radius() {
        let patches = sheet(|k| (k as f64).sin());
        let mut smoothed = patches.clone();
        smooth(&mut smoothed, 2.2);
        for (patch, smoothed) in patches.iter().zip(&smoothed) {
            let expected = patch.point[2] + mean_offset(patch, patches.iter(), 2.2);
            assert!((smoothed.point[2] - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn the_other_side_of_a_wall_is_another_surface() {
        let mut wall = sheet(|_| 0.0);
        let mut back = sheet(|_| -0.3);
        for patch in &mut back {
            patch.normal = [0.0, 0.0, -1.0];
        }
        wall.extend(back);
        smooth(&mut wall, 2.0);
        assert!(wall[..900].iter().all(|patch| patch.point[2] == 0.0));
        smooth(&mut [], 2.0);
    }
}

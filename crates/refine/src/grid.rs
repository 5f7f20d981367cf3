//! The nearest point of a surface, looked up by cell.

use crate::rigid::{dot, minus};

/// Cells along the edge of a block: a power of two.
const EDGE: usize = 1 << EDGE_BITS;
const EDGE_BITS: u32 = 2;
const CELLS: usize = EDGE * EDGE * EDGE;
/// Cells that a point reaches to each side along each axis.
const REACH: u32 = 2;
/// Cells before the first point.
const MARGIN: f64 = (REACH + 1) as f64;
/// Bits of a cell's number along an axis.
const AXIS_BITS: u32 = 21;
/// Cells along an axis that points may span, so that their numbers fit with the margin.
pub(crate) const MAX_SPAN: f64 = 2_097_000.0;
/// No point, no block.
const NONE: u32 = u32::MAX;
const EMPTY: u64 = u64::MAX;

/// A grid over a cloud: each cell near the surface knows the point that is nearest to its center.
///
/// Cells come in blocks of 4×4×4, found by a hash table, so memory goes with the surface and not with its
/// bounding box. The grid begins at the smallest coordinates of the cloud: it moves with the cloud where
/// that is translated.
#[derive(Clone, Debug)]
pub(crate) struct SparseGrid {
    /// The smallest coordinates of the points.
    corner: [f64; 3],
    inverse_cell: f64,
    /// Cells along each axis.
    size: [f64; 3],
    table: BlockTable,
    /// Of each block its cells, x fastest.
    nearest: Vec<u32>,
}

/// The smallest coordinates of the points, where a grid over them begins.
pub(crate) fn corner(points: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    points.fold([f64::INFINITY; 3], |corner, point| {
        [0, 1, 2].map(|axis| corner[axis].min(point[axis]))
    })
}

/// The position in cells. Those of the points begin at the margin, so that all cells in reach have numbers.
#[inline(always)]
fn in_cells(position: &[f64; 3], corner: &[f64; 3], inverse_cell: f64) -> [f64; 3] {
    minus(position, corner).map(|offset| offset * inverse_cell + MARGIN)
}

/// The number of the cell that holds a point.
pub(crate) fn cell_of(point: &[f64; 3], corner: &[f64; 3], inverse_cell: f64) -> [u32; 3] {
    in_cells(point, corner, inverse_cell).map(|offset| offset as u32)
}

/// The bits of three numbers in turns: points sorted by it are near their neighbors.
pub(crate) fn morton_code(cell: &[u32; 3]) -> u64 {
    let spread = |number: u32| {
        (0..AXIS_BITS).fold(0, |code, bit| {
            code | (u64::from(number >> bit & 1) << (3 * bit))
        })
    };
    spread(cell[0]) | spread(cell[1]) << 1 | spread(cell[2]) << 2
}

impl SparseGrid {
    /// A grid over points whose cells have numbers below [`MAX_SPAN`]. Of points that are equally near to a
    /// cell's center, the first counts.
    pub fn new(points: impl Iterator<Item = [f64; 3]> + Clone, cell: f64) -> Self {
        let corner = corner(points.clone());
        let inverse_cell = 1.0 / cell;
        let cells = || points.clone().map(|p| cell_of(&p, &corner, inverse_cell));
        let table = BlockTable::new(occupied_blocks(cells()));
        let size = cells().fold([0.0; 3], |size: [f64; 3], cell| {
            [0, 1, 2].map(|axis| size[axis].max(f64::from(cell[axis] + REACH + 1)))
        });
        let mut grid = Self {
            corner,
            inverse_cell,
            size,
            nearest: vec![NONE; CELLS * table.num_blocks],
            table,
        };
        let mut distances = vec![f64::INFINITY; grid.nearest.len()];
        for (index, (point, cell_of_point)) in points.clone().zip(cells()).enumerate() {
            grid.stamp(index as u32, &point, cell_of_point, cell, &mut distances);
        }
        grid
    }

    /// Enters a point into all cells that it reaches.
    fn stamp(
        &mut self,
        index: u32,
        point: &[f64; 3],
        cell: [u32; 3],
        edge: f64,
        distances: &mut [f64],
    ) {
        for block in blocks_within_reach(cell) {
            let Some(start) = self.table.find(pack(&block)) else {
                continue;
            };
            let range = |axis: usize| {
                let first = block[axis] << EDGE_BITS;
                let last = first + EDGE as u32 - 1;
                first.max(cell[axis] - REACH)..=last.min(cell[axis] + REACH)
            };
            for z in range(2) {
                for y in range(1) {
                    for x in range(0) {
                        let at = [x, y, z];
                        let center = [0, 1, 2]
                            .map(|k| self.corner[k] + (f64::from(at[k]) + 0.5 - MARGIN) * edge);
                        let offset = minus(&center, point);
                        let (place, distance) =
                            (start * CELLS + place(x, y, z), dot(&offset, &offset));
                        if distance < distances[place] {
                            distances[place] = distance;
                            self.nearest[place] = index;
                        }
                    }
                }
            }
        }
    }

    /// The point nearest to the center of the cell that holds `position`, if one is within reach.
    #[inline(always)]
    pub fn nearest(&self, position: &[f64; 3]) -> Option<usize> {
        let [x, y, z] = in_cells(position, &self.corner, self.inverse_cell);
        let inside = x >= 0.0
            && y >= 0.0
            && z >= 0.0
            && x < self.size[0]
            && y < self.size[1]
            && z < self.size[2];
        if !inside {
            return None;
        }
        let [x, y, z] = [x as u32, y as u32, z as u32];
        let block = self.table.find(pack(&[x, y, z].map(|c| c >> EDGE_BITS)))?;
        let index = self.nearest[block * CELLS + place(x, y, z)];
        (index != NONE).then_some(index as usize)
    }

    /// Blocks that hold cells.
    #[cfg(test)]
    pub fn num_blocks(&self) -> usize {
        self.table.num_blocks
    }
}

/// Place of a cell within its block.
#[inline(always)]
fn place(x: u32, y: u32, z: u32) -> usize {
    const MASK: u32 = EDGE as u32 - 1;
    ((((z & MASK) << EDGE_BITS | (y & MASK)) << EDGE_BITS) | (x & MASK)) as usize
}

#[inline(always)]
fn pack(block: &[u32; 3]) -> u64 {
    u64::from(block[0]) | u64::from(block[1]) << AXIS_BITS | u64::from(block[2]) << (2 * AXIS_BITS)
}

/// The eight blocks with cells that a point in this cell reaches.
fn blocks_within_reach(cell: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let first = cell.map(|c| (c - REACH) >> EDGE_BITS);
    let last = cell.map(|c| (c + REACH) >> EDGE_BITS);
    (first[2]..=last[2]).flat_map(move |z| {
        (first[1]..=last[1]).flat_map(move |y| (first[0]..=last[0]).map(move |x| [x, y, z]))
    })
}

/// Keys of all blocks that the points reach, ascending. Points in the order of a space-filling curve share
/// theirs with the point before.
fn occupied_blocks(cells: impl Iterator<Item = [u32; 3]>) -> Vec<u64> {
    let mut keys = Vec::new();
    let mut before = None;
    for cell in cells {
        let corner = cell.map(|c| (c - REACH) >> EDGE_BITS);
        if before != Some(corner) {
            keys.extend(blocks_within_reach(cell).map(|block| pack(&block)));
            before = Some(corner);
        }
    }
    keys.sort_unstable();
    keys.dedup();
    keys
}

/// A hash table from the key of a block to its number, with open addressing. It is only ever asked for keys.
#[derive(Clone, Debug)]
struct BlockTable {
    slots: Vec<(u64, u32)>,
    shift: u32,
    num_blocks: usize,
}

impl BlockTable {
    fn new(keys: Vec<u64>) -> Self {
        let bits = (2 * keys.len() + 2).next_power_of_two().trailing_zeros();
        let mut table = Self {
            slots: vec![(EMPTY, NONE); 1 << bits],
            shift: u64::BITS - bits,
            num_blocks: keys.len(),
        };
        for (number, key) in keys.into_iter().enumerate() {
            let mut slot = table.first_slot(key);
            while table.slots[slot].0 != EMPTY {
                slot = (slot + 1) & (table.slots.len() - 1);
            }
            table.slots[slot] = (key, number as u32);
        }
        table
    }

    /// Fibonacci hashing.
    #[inline(always)]
    fn first_slot(&self, key: u64) -> usize {
        (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> self.shift) as usize
    }

    #[inline(always)]
    fn find(&self, key: u64) -> Option<usize> {
        let mut slot = self.first_slot(key);
        loop {
            let (found, number) = self.slots[slot];
            if found == key {
                return Some(number as usize);
            }
            if found == EMPTY {
                return None;
            }
            slot = (slot + 1) & (self.slots.len() - 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn grid(points: &[[f64; 3]], cell: f64) -> SparseGrid {
        SparseGrid::new(points.iter().copied(), cell)
    }

    fn coordinates() -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3(-3.0..3.0)
    }

    proptest! {
        #[test]
        fn a_lookup_is_the_search_through_all_points(
            points in prop::collection::vec(coordinates(), 0..40), asked in coordinates(),
        ) {
            let cell = 0.4;
            let grid = grid(&points, cell);
            let start = corner(points.iter().copied());
            let within = |p: &[f64; 3]| (0..3).all(|k| {
                let number = |x: f64| ((x - start[k]) / cell).floor();
                (number(p[k]) - number(asked[k])).abs() <= f64::from(REACH)
            });
            let distance = |p: &[f64; 3]| {
                let center = [0, 1, 2].map(|k| {
                    start[k] + (((asked[k] - start[k]) / cell).floor() + 0.5) * cell
                });
                let offset = minus(&center, p);
                dot(&offset, &offset)
            };
            let near = points.iter().enumerate().filter(|(_, p)| within(p));
            let expected = near.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
            let found = grid.nearest(&asked);
            prop_assert_eq!(found.is_some(), expected.is_some());
            if let (Some(found), Some((_, expected))) = (found, expected) {
                prop_assert!((distance(&points[found]) - distance(expected)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn memory_goes_with_the_surface() {
        let sheet =
            |height: f64| (0..900).map(move |k| [f64::from(k % 30), f64::from(k / 30), height]);
        let near: Vec<_> = sheet(0.0).chain(sheet(100.0)).collect();
        let far: Vec<_> = sheet(0.0).chain(sheet(100_000.0)).collect();
        assert_eq!(grid(&near, 1.0).num_blocks(), grid(&far, 1.0).num_blocks());
    }

    #[test]
    fn positions_that_are_no_numbers_have_no_nearest_point() {
        let grid = grid(&[[0.0; 3]], 1.0);
        for x in [f64::NAN, f64::INFINITY, -1e300, 1e300] {
            assert_eq!(grid.nearest(&[x, 0.0, 0.0]), None);
        }
        assert_eq!(grid.nearest(&[0.4, 0.4, -0.4]), Some(0));
    }
}

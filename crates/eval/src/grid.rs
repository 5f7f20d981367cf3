//! A hash grid: is there a point within a fixed radius?

use nalgebra::{Point3, distance_squared};

/// Integer coordinates of a cubic cell.
type Cell = [i32; 3];

/// The cell of edge length `size` that holds `point`.
fn cell_of(point: &Point3<f64>, size: f64) -> Cell {
    [point.x, point.y, point.z].map(|x| (x / size).floor() as i32)
}

/// Marks a free slot of the table.
const FREE: u32 = u32::MAX;

/// Points sorted into cells twice as wide as the search radius, so that a ball touches at most
/// eight of them. The cells stand in an open hash table.
#[derive(Debug, Clone)]
pub(crate) struct Grid {
    radius: f64,
    points: Vec<Point3<f64>>,
    /// One entry per occupied cell: the cell and its range of `points`.
    cells: Vec<(Cell, usize, usize)>,
    /// Slots that name an entry of `cells`, or are free. Its length is a power of two.
    table: Vec<u32>,
}

impl Grid {
    /// A grid over the points; over none of them if the radius is not positive, within which no point lies.
    pub(crate) fn new(points: &[Point3<f64>], radius: f64) -> Self {
        let points = if radius > 0.0 { points } else { &[] };
        let mut keyed: Vec<(Cell, Point3<f64>)> = points
            .iter()
            .map(|point| (cell_of(point, 2.0 * radius), *point))
            .collect();
        keyed.sort_by_key(|(cell, _)| *cell);
        let mut grid = Self {
            radius,
            points: keyed.iter().map(|(_, point)| *point).collect(),
            cells: Vec::new(),
            table: Vec::new(),
        };
        let mut start = 0;
        for group in keyed.chunk_by(|a, b| a.0 == b.0) {
            grid.cells.push((group[0].0, start, start + group.len()));
            start += group.len();
        }
        grid.index_cells();
        grid
    }

    fn index_cells(&mut self) {
        self.table = vec![FREE; (4 * self.cells.len()).next_power_of_two()];
        for (entry, (cell, ..)) in self.cells.iter().enumerate() {
            let mut slot = self.first_slot(cell);
            while self.table[slot] != FREE {
                slot = self.next_slot(slot);
            }
            self.table[slot] = entry as u32;
        }
    }

    /// Whether some point lies within the radius of `query`.
    pub(crate) fn reaches(&self, query: &Point3<f64>) -> bool {
        let size = 2.0 * self.radius;
        let low = [query.x, query.y, query.z].map(|x| ((x - self.radius) / size).floor() as i32);
        let high = [query.x, query.y, query.z].map(|x| ((x + self.radius) / size).floor() as i32);
        (low[0]..=high[0]).any(|x| {
            (low[1]..=high[1])
                .any(|y| (low[2]..=high[2]).any(|z| self.cell_reaches(&[x, y, z], query)))
        })
    }

    fn cell_reaches(&self, cell: &Cell, query: &Point3<f64>) -> bool {
        let limit = self.radius * self.radius;
        let mut slot = self.first_slot(cell);
        while let Some((found, start, end)) = self.cells.get(self.table[slot] as usize) {
            if found == cell {
                let inside = &self.points[*start..*end];
                return inside
                    .iter()
                    .any(|point| distance_squared(point, query) <= limit);
            }
            slot = self.next_slot(slot);
        }
        false
    }

    /// Multiplies each coordinate by a large odd number and mixes the upper bits down.
    fn first_slot(&self, cell: &Cell) -> usize {
        const ODD: [u64; 3] = [
            0x9E37_79B9_7F4A_7C15,
            0xC2B2_AE3D_27D4_EB4F,
            0x1656_67B1_9E37_79F9,
        ];
        let mixed = (0..3).fold(0_u64, |hash, k| {
            hash ^ (cell[k] as u64).wrapping_mul(ODD[k])
        });
        (mixed ^ (mixed >> 32)) as usize & (self.table.len() - 1)
    }

    fn next_slot(&self, slot: usize) -> usize {
        (slot + 1) & (self.table.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points() -> impl Strategy<Value = Vec<Point3<f64>>> {
        prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 0..100)
            .prop_map(|points| points.into_iter().map(Point3::from).collect())
    }

    proptest! {
        #[test]
        fn the_grid_finds_what_asking_every_point_finds(points in points(), others in points()) {
            for radius in [0.01, 0.1, 0.4] {
                let grid = Grid::new(&points, radius);
                for query in others.iter().chain(&points) {
                    let is_near = |p: &Point3<f64>| distance_squared(p, query) <= radius * radius;
                    prop_assert_eq!(grid.reaches(query), points.iter().any(is_near));
                }
            }
        }
    }
}

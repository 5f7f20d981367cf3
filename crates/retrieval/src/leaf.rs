use crate::ranking::Rankings;
use crate::rows::Rows;

/// Distances that are computed together, as vector registers.
const BLOCK: usize = 16;

/// Scratch for the rows of a leaf.
#[derive(Default)]
pub(crate) struct Leaf {
    /// In blocks of 16 rows that hold coordinate after coordinate.
    values: Vec<f32>,
    scans: Vec<u32>,
}

impl Leaf {
    /// Enters the members' distances to each other in their rankings. Returns how many there are.
    pub(crate) fn rank(&mut self, rows: &Rows, members: &[u32], rankings: &mut Rankings) -> usize {
        self.load(rows, members);
        let block_len = BLOCK * rows.dimension();
        for (i, &member) in members.iter().enumerate() {
            let blocks = self.values.chunks_exact(block_len).enumerate();
            for (k, block) in blocks.skip(i / BLOCK) {
                let distances = squared_distances(rows.row(member), block);
                let others = (i + 1).max(k * BLOCK)..members.len().min((k + 1) * BLOCK);
                for j in others.filter(|&j| self.scans[i] != self.scans[j]) {
                    rankings.insert(member, distances[j % BLOCK], self.scans[j]);
                    rankings.insert(members[j], distances[j % BLOCK], self.scans[i]);
                }
            }
        }
        members.len() * members.len().saturating_sub(1) / 2
    }

    fn load(&mut self, rows: &Rows, members: &[u32]) {
        self.scans.clear();
        self.scans
            .extend(members.iter().map(|&member| rows.scan(member)));
        let num_blocks = members.len().div_ceil(BLOCK);
        self.values.clear();
        self.values
            .resize(num_blocks * BLOCK * rows.dimension(), 0.0);
        for (k, &member) in members.iter().enumerate() {
            let start = k / BLOCK * BLOCK * rows.dimension() + k % BLOCK;
            let lane = self.values[start..].iter_mut().step_by(BLOCK);
            for (place, &value) in lane.zip(rows.row(member)) {
                *place = value;
            }
        }
    }
}

fn squared_distances(query: &[f32], block: &[f32]) -> [f32; BLOCK] {
    let mut sums = [0.0; BLOCK];
    for (coordinates, x) in block.as_chunks::<BLOCK>().0.iter().zip(query) {
        for (sum, y) in sums.iter_mut().zip(coordinates) {
            *sum += (x - y) * (x - y);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use gmpcr_correspondence::Descriptors;

    use super::*;

    /// The scans of the other rows, by the distance to their nearest.
    fn plain_ranking(scans: &[&Descriptors], scan: usize, row: usize) -> Vec<usize> {
        let query = scans[scan].row(row);
        let distance = |other: &[f32]| -> f64 {
            query
                .iter()
                .zip(other)
                .map(|(x, y)| f64::from(x - y).powi(2))
                .sum()
        };
        let nearest = |other: usize| scans[other].rows().map(distance).fold(f64::MAX, f64::min);
        let mut others: Vec<_> = (0..scans.len()).filter(|&other| other != scan).collect();
        others.sort_by(|&a, &b| nearest(a).total_cmp(&nearest(b)));
        others.truncate(Rankings::LENGTH);
        others
    }

    #[test]
    fn a_leaf_of_all_rows_gives_exact_rankings() {
        for dimension in [1, 7, 33] {
            let value = |k: usize| (k as f32 * 1.37 + (k * k % 101) as f32).sin();
            let scan = |s: usize| {
                (0..(s + 2) * dimension)
                    .map(|k| value(k + 1000 * s))
                    .collect()
            };
            let scans = (0..11).map(|s| Descriptors::new(scan(s), dimension).unwrap());
            let scans: Vec<_> = scans.collect();
            let references: Vec<_> = scans.iter().collect();
            let rows = Rows::new(&references).unwrap();
            let members: Vec<u32> = (0..rows.len() as u32).collect();
            let mut rankings = Rankings::new(rows.len());
            Leaf::default().rank(&rows, &members, &mut rankings);
            let mut row = 0;
            for (scan, descriptors) in scans.iter().enumerate() {
                for k in 0..descriptors.len() {
                    let ranking: Vec<_> = rankings.scans(row).collect();
                    assert_eq!(ranking, plain_ranking(&references, scan, k));
                    row += 1;
                }
            }
        }
    }
}

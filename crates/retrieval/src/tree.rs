use crate::rows::Rows;

/// Visits the leaves of a random-projection tree: sets of at most `max_leaf` rows that are likely to
/// be near each other.
///
/// On level `l` every set is halved at the median of its rows' projections onto the direction
/// `(±1, …, ±1)` of that level (Dasgupta and Freund 2008), so that all leaves are of one size up to
/// one row. The directions depend on `tree` and `l` only, a row's projection on the row only: another
/// order of the rows gives the same leaves, but for equal projections at a median.
///
/// Rows on a line are cut at the same places by every tree, so that neighbors there stay apart.
pub(crate) fn for_each_leaf(rows: &Rows, tree: usize, max_leaf: usize, visit: impl FnMut(&[u32])) {
    let mut depth = 0;
    while rows.len().div_ceil(1 << depth) > max_leaf {
        depth += 1;
    }
    let directions: Vec<_> = (0..depth)
        .map(|level| direction(tree, level, rows.dimension()))
        .collect();
    let projections = rows.iter().flat_map(|row| {
        directions
            .iter()
            .map(|direction| ordered(dot(row, direction)))
    });
    let mut splitter = Splitter {
        depth,
        projections: projections.collect(),
        keys: Vec::with_capacity(rows.len()),
        visit,
    };
    let mut members: Vec<u32> = (0..rows.len() as u32).collect();
    splitter.split(&mut members, 0);
}

struct Splitter<Visit> {
    /// Levels of the tree.
    depth: usize,
    /// Row by row, one for each level.
    projections: Vec<u32>,
    /// Scratch: the members of the set that is halved, behind their projections.
    keys: Vec<u64>,
    visit: Visit,
}

impl<Visit: FnMut(&[u32])> Splitter<Visit> {
    fn split(&mut self, members: &mut [u32], level: usize) {
        if level == self.depth {
            (self.visit)(members);
            return;
        }
        let middle = members.len() / 2;
        self.keys.clear();
        self.keys.extend(members.iter().map(|&row| {
            let projection = self.projections[row as usize * self.depth + level];
            u64::from(projection) << 32 | u64::from(row)
        }));
        self.keys.select_nth_unstable(middle);
        for (member, &key) in members.iter_mut().zip(&self.keys) {
            *member = key as u32;
        }
        let (lower, upper) = members.split_at_mut(middle);
        self.split(lower, level + 1);
        self.split(upper, level + 1);
    }
}

/// A fixed vector of signs that look random.
fn direction(tree: usize, level: usize, dimension: usize) -> Vec<f32> {
    let seed = (tree as u64) << 32 | level as u64;
    let sign = |axis: u64| match scrambled(scrambled(seed) ^ axis) & 1 {
        0 => 1.0,
        _ => -1.0,
    };
    (0..dimension as u64).map(sign).collect()
}

/// SplitMix64's output function (Steele, Lea and Flood 2014).
fn scrambled(seed: u64) -> u64 {
    let z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Independent partial sums, which the compiler turns into vector registers.
const LANES: usize = 8;

fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0; LANES];
    let ((a_blocks, a_rest), (b_blocks, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (x, y) in a_blocks.iter().zip(b_blocks) {
        for lane in 0..LANES {
            sums[lane] += x[lane] * y[lane];
        }
    }
    for (sum, (x, y)) in sums.iter_mut().zip(a_rest.iter().zip(b_rest)) {
        *sum += x * y;
    }
    sums.iter().sum()
}

/// Bits that are ordered as the numbers are.
fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    match x.is_sign_negative() {
        true => !bits,
        false => bits | 1 << 31,
    }
}

#[cfg(test)]
mod tests {
    use gmpcr_correspondence::Descriptors;

    use super::*;

    fn leaves(values: Vec<f32>, dimension: usize, tree: usize, max_leaf: usize) -> Vec<Vec<u32>> {
        let scan = Descriptors::new(values, dimension).unwrap();
        let mut leaves = Vec::new();
        let rows = Rows::new(&[&scan]).unwrap();
        for_each_leaf(&rows, tree, max_leaf, |leaf| leaves.push(leaf.to_vec()));
        leaves
    }

    #[test]
    fn every_row_is_in_one_of_the_leaves_which_are_of_one_size() {
        for num_rows in [1, 2, 63, 64, 65, 128, 129, 1000] {
            let values = (0..3 * num_rows).map(|k| (k as f32 * 1.7).sin());
            let leaves = leaves(values.collect(), 3, 0, 64);
            let sizes = leaves.iter().map(Vec::len);
            assert!(sizes.clone().max().unwrap() <= 64);
            assert!(sizes.clone().max().unwrap() - sizes.min().unwrap() <= 1);
            let mut rows = leaves.concat();
            rows.sort_unstable();
            assert_eq!(rows, (0..num_rows).collect::<Vec<u32>>());
        }
    }

    #[test]
    fn a_line_is_cut_into_intervals() {
        let leaves = leaves((0..16).map(|k| k as f32).collect(), 1, 3, 4);
        for mut leaf in leaves {
            leaf.sort_unstable();
            assert!(leaf.windows(2).all(|pair| pair[1] == pair[0] + 1));
        }
    }

    #[test]
    fn no_rows_make_one_empty_leaf() {
        assert_eq!(leaves(vec![], 3, 0, 64), [vec![0u32; 0]]);
    }

    #[test]
    fn trees_differ() {
        let values: Vec<f32> = (0..300).map(|k| (k as f32 * 1.7).sin()).collect();
        assert_ne!(leaves(values.clone(), 3, 0, 10), leaves(values, 3, 1, 10));
    }

    #[test]
    fn ordered_bits_are_in_the_order_of_the_numbers() {
        let numbers = [
            f32::NEG_INFINITY,
            -2.0,
            -1e-40,
            0.0,
            1e-40,
            3.0,
            f32::INFINITY,
        ];
        assert!(
            numbers
                .windows(2)
                .all(|pair| ordered(pair[0]) < ordered(pair[1]))
        );
    }
}

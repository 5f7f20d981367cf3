/// For every row, the scans whose descriptors come nearest, found so far: at most
/// [`LENGTH`](Rankings::LENGTH) different ones, nearest first.
#[derive(Clone, Debug)]
pub(crate) struct Rankings {
    /// Squared distance in the upper half, scan in the lower: ordered by distance, then scan.
    entries: Vec<[u64; Self::LENGTH]>,
}

impl Rankings {
    pub(crate) const LENGTH: usize = 8;
    const NONE: u64 = u64::MAX;

    pub(crate) fn new(num_rows: usize) -> Self {
        Self {
            entries: vec![[Self::NONE; Self::LENGTH]; num_rows],
        }
    }

    /// Takes into account that `scan` has a descriptor at `squared_distance` from `row`. The order in
    /// which this is said changes nothing.
    pub(crate) fn insert(&mut self, row: u32, squared_distance: f32, scan: u32) {
        // The bits of nonnegative numbers are ordered as the numbers are.
        let entry = u64::from(squared_distance.to_bits()) << 32 | u64::from(scan);
        let ranking = &mut self.entries[row as usize];
        let last = Self::LENGTH - 1;
        if entry >= ranking[last] {
            return;
        }
        let known = ranking.iter().position(|&known| known as u32 == scan);
        let mut place = known.unwrap_or(last);
        if entry >= ranking[place] {
            return;
        }
        while place > 0 && entry < ranking[place - 1] {
            ranking[place] = ranking[place - 1];
            place -= 1;
        }
        ranking[place] = entry;
    }

    /// The scans of a row, nearest first.
    pub(crate) fn scans(&self, row: usize) -> impl Iterator<Item = usize> {
        let known = self.entries[row]
            .iter()
            .take_while(|&&entry| entry != Self::NONE);
        known.map(|&entry| entry as u32 as usize)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_nearest_different_scans_are_kept_in_order(
            seen in prop::collection::vec((0..6u8, 0..14u32), 0..80),
        ) {
            let mut rankings = Rankings::new(1);
            let mut nearest = BTreeMap::new();
            for (distance, scan) in seen {
                rankings.insert(0, f32::from(distance), scan);
                let least = nearest.entry(scan).or_insert(distance);
                *least = distance.min(*least);
            }
            let mut expected: Vec<_> = nearest.into_iter().map(|(scan, d)| (d, scan)).collect();
            expected.sort_unstable();
            expected.truncate(Rankings::LENGTH);
            let expected: Vec<_> = expected.iter().map(|&(_, scan)| scan as usize).collect();
            prop_assert_eq!(rankings.scans(0).collect::<Vec<_>>(), expected);
        }
    }
}

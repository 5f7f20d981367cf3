use std::iter::repeat_n;

use gmpcr_correspondence::{Descriptors, DimensionsDiffer};

/// The descriptors of all scans, one below the other.
pub(crate) struct Rows {
    values: Vec<f32>,
    dimension: usize,
    scan_of_row: Vec<u32>,
}

impl Rows {
    pub(crate) fn new(scans: &[&Descriptors]) -> Result<Self, DimensionsDiffer> {
        let mut filled = scans.iter().filter(|scan| !scan.is_empty());
        let dimension = filled.next().map_or(1, |first| first.dimension());
        if let Some(other) = filled.find(|other| other.dimension() != dimension) {
            return Err(DimensionsDiffer {
                i: dimension,
                j: other.dimension(),
            });
        }
        let num_rows: usize = scans.iter().map(|scan| scan.len()).sum();
        assert!(
            u32::try_from(scans.len().max(num_rows)).is_ok(),
            "{} scans and {num_rows} descriptors are too many to index",
            scans.len()
        );
        let values = scans.iter().flat_map(|scan| scan.values());
        let scan_of_row = (0..).zip(scans);
        let scan_of_row = scan_of_row.flat_map(|(scan, rows)| repeat_n(scan, rows.len()));
        Ok(Self {
            values: values.copied().collect(),
            dimension,
            scan_of_row: scan_of_row.collect(),
        })
    }

    pub(crate) fn len(&self) -> usize {
        self.scan_of_row.len()
    }

    pub(crate) fn dimension(&self) -> usize {
        self.dimension
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &[f32]> {
        self.values.chunks_exact(self.dimension)
    }

    pub(crate) fn row(&self, index: u32) -> &[f32] {
        let start = index as usize * self.dimension;
        &self.values[start..start + self.dimension]
    }

    pub(crate) fn scan(&self, row: u32) -> u32 {
        self.scan_of_row[row as usize]
    }
}

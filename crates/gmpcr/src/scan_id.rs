use std::fmt;

/// The name of a scan within one [`IncrementalRegistration`](crate::IncrementalRegistration): it stays the
/// same while other scans come and go, and is never given twice.
///
/// In a batch ([`register`](crate::register)) the id of a scan is its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(transparent)
)]
pub struct ScanId(u64);

impl ScanId {
    /// The ids of the first scans that were ever added.
    pub(crate) fn first(count: usize) -> Vec<Self> {
        (0..count as u64).map(Self).collect()
    }

    pub(crate) fn next(self) -> Self {
        Self(self.0 + 1)
    }

    /// How many scans had been added before this one.
    pub fn number(self) -> u64 {
        self.0
    }
}

impl Default for ScanId {
    /// The id of the scan that was added first.
    fn default() -> Self {
        Self(0)
    }
}

impl fmt::Display for ScanId {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

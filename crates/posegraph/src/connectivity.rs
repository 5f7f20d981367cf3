use crate::components::Components;

/// How well a selection of edges connects the scans: the columns of the paper's connectivity table
/// (section "Pose Graph Connectivity Analysis"), for one scene.
///
/// ```
/// use gmpcr_posegraph::Connectivity;
///
/// let figures = Connectivity::new(4, &[(0, 1), (1, 2)], 3);
/// assert!(!figures.is_connected);
/// assert_eq!((figures.num_components, figures.num_edges), (2, 2));
/// assert_eq!((figures.largest_component_ratio, figures.reachability), (0.75, 0.25));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Connectivity {
    /// Whether all scans are in one component.
    pub is_connected: bool,
    /// Number of components, `C`; isolated scans count.
    pub num_components: usize,
    /// Fraction of the scans in the largest component, `LCC`.
    pub largest_component_ratio: f64,
    /// Fraction of the scans that can be reached from the reference scan, itself included, `R`.
    pub reachability: f64,
    /// Number of edges, `M`.
    pub num_edges: usize,
}

impl Connectivity {
    /// Figures of the graph with nodes `0..num_scans` and undirected `edges`. The ratios of no
    /// scans are 1, and so is the connectivity.
    ///
    /// # Panics
    /// If an edge or, unless there are no scans, the reference is outside `0..num_scans`.
    pub fn new(num_scans: usize, edges: &[(usize, usize)], reference: usize) -> Self {
        let components = Components::new(num_scans, edges.iter().copied());
        let sizes = components.members().iter().map(Vec::len);
        let ratio = |size: Option<usize>| size.map_or(1.0, |size| size as f64 / num_scans as f64);
        let reached =
            (num_scans > 0).then(|| components.members()[components.label(reference)].len());
        Self {
            is_connected: components.members().len() <= 1,
            num_components: components.members().len(),
            largest_component_ratio: ratio(sizes.max()),
            reachability: ratio(reached),
            num_edges: edges.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_scans_are_connected() {
        let figures = Connectivity::new(0, &[], 0);
        assert!(figures.is_connected);
        assert_eq!((figures.num_components, figures.reachability), (0, 1.0));
    }
}

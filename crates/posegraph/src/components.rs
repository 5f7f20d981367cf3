/// The connected components of a graph: the sets of scans that can share a frame.
///
/// ```
/// use gmpcr_posegraph::Components;
///
/// let components = Components::new(5, [(0, 3), (3, 4)]);
/// assert_eq!(components.members(), [vec![0, 3, 4], vec![1], vec![2]]);
/// assert_eq!(components.label(4), 0);
/// assert_eq!(components.largest(), [0, 3, 4]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Components {
    labels: Vec<usize>,
    members: Vec<Vec<usize>>,
}

impl Components {
    /// Components of the graph with nodes `0..num_scans` and undirected `edges`, numbered by their
    /// lowest node. `O(num_scans + edges)` up to the inverse Ackermann function.
    ///
    /// # Panics
    /// If an edge names a node outside `0..num_scans`.
    pub fn new(num_scans: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Self {
        let mut parent: Vec<usize> = (0..num_scans).collect();
        for (i, j) in edges {
            let (i, j) = (root(&mut parent, i), root(&mut parent, j));
            // The lower root wins, so that a root is the lowest node of its component.
            parent[i.max(j)] = i.min(j);
        }
        let (mut labels, mut members) = (Vec::with_capacity(num_scans), Vec::new());
        for node in 0..num_scans {
            let root = root(&mut parent, node);
            let label = if root == node {
                members.len()
            } else {
                labels[root]
            };
            if root == node {
                members.push(Vec::new());
            }
            labels.push(label);
            members[label].push(node);
        }
        Self { labels, members }
    }

    /// The nodes of each component, ascending.
    pub fn members(&self) -> &[Vec<usize>] {
        &self.members
    }

    /// The nodes of the largest component, ascending: the first of equal ones, nothing of no nodes.
    pub fn largest(&self) -> &[usize] {
        let members = self.members.iter().rev();
        members
            .max_by_key(|nodes| nodes.len())
            .map_or(&[], Vec::as_slice)
    }

    /// The component of a node.
    ///
    /// # Panics
    /// If the node is outside `0..num_scans`.
    pub fn label(&self, node: usize) -> usize {
        self.labels[node]
    }

    /// The component of every node.
    pub fn labels(&self) -> &[usize] {
        &self.labels
    }
}

/// The representative of a node's set; halves the path to it on the way.
fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}

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
pub struct Connectivity {
    /// Whether all scans are in one component.
    pub is_connected: bool,
    /// Number of components, `C`; isolated scans count.
    pub num_components: usize,
    /// Share of the scans in the largest component, `LCC`.
    pub largest_component_ratio: f64,
    /// Share of the scans that can be reached from the reference scan, itself included, `R`.
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
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn components_are_the_classes_of_reachability(
            n in 1..12usize, edges in prop::collection::vec((0..12usize, 0..12usize), 0..12)
        ) {
            let edges: Vec<_> = edges.into_iter().map(|(i, j)| (i % n, j % n)).collect();
            let components = Components::new(n, edges.iter().copied());
            let joins = |i, j| i == j || edges.contains(&(i, j)) || edges.contains(&(j, i));
            let reaches = |i: usize, j: usize| {
                let mut reached = vec![i];
                for _ in 0..n {
                    let next = (0..n).find(|l| !reached.contains(l) && reached.iter().any(|&m| joins(m, *l)));
                    reached.extend(next);
                }
                reached.contains(&j)
            };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                prop_assert_eq!(reaches(i, j), components.label(i) == components.label(j));
            }
            let firsts: Vec<_> = components.members().iter().map(|m| m[0]).collect();
            prop_assert!(firsts.is_sorted());
        }
    }

    #[test]
    fn no_scans_are_connected() {
        let figures = Connectivity::new(0, &[], 0);
        assert!(figures.is_connected);
        assert_eq!((figures.num_components, figures.reachability), (0, 1.0));
    }
}

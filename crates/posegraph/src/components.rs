use crate::disjoint_sets::DisjointSets;

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
///
/// In files they are the list of [`members`](Self::members).
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(into = "Members", try_from = "Members")
)]
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
        let mut sets = DisjointSets::new(num_scans);
        for (i, j) in edges {
            sets.join(i, j);
        }
        let (mut labels, mut members) = (Vec::with_capacity(num_scans), Vec::new());
        for node in 0..num_scans {
            let root = sets.lowest(node);
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

/// The components as they stand in files.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
struct Members(Vec<Vec<usize>>);

#[cfg(feature = "serde")]
impl From<Components> for Members {
    fn from(components: Components) -> Self {
        Self(components.members)
    }
}

#[cfg(feature = "serde")]
impl TryFrom<Members> for Components {
    type Error = &'static str;

    fn try_from(Members(members): Members) -> Result<Self, Self::Error> {
        let num_scans = members.iter().map(Vec::len).sum();
        if members.iter().flatten().any(|&node| node >= num_scans) {
            return Err("the components do not number their scans without gaps");
        }
        let joined = members.iter().flat_map(|nodes| nodes.windows(2));
        let components = Self::new(num_scans, joined.map(|pair| (pair[0], pair[1])));
        if components.members != members {
            return Err("the components overlap or are not in ascending order");
        }
        Ok(components)
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

    #[cfg(feature = "serde")]
    #[test]
    fn components_of_files_are_checked() {
        let components = Components::new(4, [(1, 3)]);
        let text = serde_json::to_string(&components).unwrap();
        assert_eq!(text, "[[0],[1,3],[2]]");
        assert_eq!(
            serde_json::from_str::<Components>(&text).unwrap(),
            components
        );
        for wrong in [
            "[[1],[0]]",
            "[[1,0]]",
            "[[0],[2]]",
            "[[0,1],[1]]",
            "[[0],[]]",
        ] {
            assert!(
                serde_json::from_str::<Components>(wrong).is_err(),
                "{wrong}"
            );
        }
    }
}

use std::str::FromStr;

use gmpcr_geometry::isometry;
use nalgebra::{Isometry3, Rotation3};

use crate::subgraph::Subgraph;
use crate::translations::subgraph_translations;
use crate::{AdaptiveHistory, History, Iteration, SyncParams};
use crate::{consensus, eigse3, hara, history_aware, lie_averaging};

/// How a pose graph is synchronised: the paper's way, and others to compare with or to choose where
/// many edges are wrong.
///
/// All take the same graph and honour its weights. [`SyncParams::iterations`] counts reweightings and
/// [`SyncParams::residual_scale`] is the scale of the robust loss, where the method has such. Methods
/// that average rotations only get their positions by
/// [`solve_translations`](crate::solve_translations) under the final weights.
///
/// | name | method | wrong edges | positions help the rotations |
/// |---|---|---|---|
/// | `adaptive` | [`HistoryAware`](Self::HistoryAware), the paper | reweighted | no |
/// | `no-recovery` | the same with `ρ = 0` | reweighted | no |
/// | `sghr` | the same with SGHR's history | reweighted | no |
/// | `memoryless` | the same without history | reweighted | no |
/// | `eigse3` | [`EigSe3`](Self::EigSe3) | trusted | yes |
/// | `l1` | [`RotAvg`](Self::RotAvg) | ℓ₁ | no |
/// | `l1-irls` | [`RotAvg`](Self::RotAvg), L1-IRLS | Geman–McClure | no |
/// | `rotavg-lhalf` | [`RotAvg`](Self::RotAvg) | ℓ½ | no |
/// | `hara` | [`Hara`](Self::Hara) | found by triplets | no |
/// | `consensus` | [`Consensus`](Self::Consensus) | found by triangles and votes | yes |
///
/// ```
/// use gmpcr_sync::{History, Method};
///
/// assert_eq!("sghr".parse(), Ok(Method::HistoryAware(History::Sghr)));
/// assert_eq!(Method::default().name(), "adaptive");
/// assert!("best".parse::<Method>().unwrap_err().to_string().contains("consensus"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// The paper: connection-Laplacian rotation averaging, reweighted by residual history;
    /// translation least squares.
    HistoryAware(History),
    /// EIG-SE(3): spectral synchronisation of rotations and positions at once (Arrigoni, Rossi,
    /// Fusiello, SIAM J. Imaging Sciences 2016).
    ///
    /// The stacked 4×4 matrices `X_i = T_i⁻¹` of noise-free measurements `T̂_ij = X_i X_j⁻¹` satisfy
    ///
    /// ```text
    /// (D ⊗ I₄ − Z) X = 0,   Z_ij = w_ij T̂_ij,   D_ii = Σ_j w_ij
    /// ```
    ///
    /// With noise, the four right singular vectors of smallest singular value take the place of `X`. A
    /// change of basis makes the bottom rows of their blocks `[0 0 0 1]` in the least-squares sense,
    /// and the 3×3 parts are projected onto SO(3). Lengths are measured in the mean distance of the
    /// scans from their centroid along a spanning tree of maximal weight, so that their unit does not
    /// matter.
    ///
    /// All edges are trusted: there are no iterations, and a few wrong edges spoil all poses. The
    /// singular vectors are found as eigenvectors of the normal matrix, by filtered block
    /// iteration with refined solves. Its pattern joins each scan with the neighbours of its neighbours,
    /// and its gaps are the squares of small numbers in graphs of large diameter: there noise tells
    /// more than in the other methods.
    EigSe3,
    /// Rotation averaging with a robust loss, `argmin Σ w⁰_ij ρ(r_ij)` (Chatterjee and Govindu,
    /// "Efficient and robust large-scale rotation averaging", ICCV 2013, and "Robust relative
    /// rotation averaging", TPAMI 2018).
    ///
    /// From the rotations along a spanning tree of maximal weight, steps in the tangent space lead to
    /// the weighted least squares over SO(3), each by one solve with the graph Laplacian. Reweighting
    /// by `w = w⁰ min(1, σ / 10 r)`, with `σ` the [`SyncParams::residual_scale`], leads on to the ℓ₁
    /// average; below `σ / 10` the loss is a parabola. From there the weights of the [`RobustLoss`] go
    /// on alike. L1-IRLS of 2013 is this with [`RobustLoss::GemanMcClure`]; the authors prefer
    /// [`RobustLoss::LHalf`] in 2018. They solve each linearised ℓ₁ problem by linear programming;
    /// here the norm is that of the rotation vector, so that the result does not depend on the axes.
    ///
    /// At most [`SyncParams::iterations`] reweightings with either loss, but no fewer than 20 of ℓ₁, as
    /// the start is far; none (plain least squares) if that is 0. Each costs one sparse factorisation
    /// of an `N × N` matrix and a few solves. A minimum found need not be the lowest.
    RotAvg(RobustLoss),
    /// HARA: rotation averaging that begins with the edges that most triangles confirm (Lee and
    /// Civera, "HARA: A hierarchical approach for robust rotation averaging", CVPR 2022).
    ///
    /// 1. The support of an edge is the number of triangles it is part of whose rotations compose to
    ///    less than a threshold: 0.5, 1 and 2 times the [`SyncParams::residual_scale`].
    /// 2. A spanning tree grows by the edge of the highest support, up to 10, and among equals of the
    ///    strictest threshold. Without support it grows by the edge of the highest weight, and the new
    ///    scan takes, of the rotations that its edges from the tree propose, the one nearest to all.
    /// 3. A first least squares leaves out the edges that the tree contradicts by more than 8 times the
    ///    scale (weight 10⁻⁶), and [`RobustLoss::LHalf`] refines it. Together these take at most
    ///    [`SyncParams::iterations`] reweightings; 0 is plain least squares.
    ///
    /// Simplified: the paper takes its thresholds from percentiles of sampled loop errors, adds
    /// unsupported scans by the number of their edges, and never takes filtered edges back. Finding the
    /// triangles costs `O(Σ deg² log deg)`.
    Hara,
    /// Our own, for graphs where many edges are wrong. It lives on triangles: on graphs with few of
    /// them it is no better than others, and where more than a third of the edges tell one and the
    /// same wrong story, their triangles mislead it.
    ///
    /// 1. Edges that close triangles in rotation *and* translation are right: random edges do not.
    ///    The median gap of the triangles whose rotations close is the translation noise.
    /// 2. The parts that such edges hold together are solved by least squares, then joined one by
    ///    one, each time the two parts that most of the edges between them agree on. Then each scan moves
    ///    to where more of its edges want it, until none does.
    /// 3. All edges: reweighted least squares, first of rotations, then of translations, with the
    ///    Geman–McClure loss of both residuals, `w = w⁰ (1 + (r_R/σ_R)² + (r_t/σ_t)²)⁻²`, its scale
    ///    falling from four times the noise to the noise. `σ_R` is [`SyncParams::residual_scale`].
    /// 4. Rotations and translations at once, by reweighted Gauss–Newton steps down the loss
    ///
    ///    ```text
    ///    Σ w⁰_ij ρ(‖log(R̂_ijᵀ R_iᵀ R_j)‖² / s_R² + ‖R_iᵀ (t_j − t_i) − t̂_ij‖² / s_t²),   ρ(x) = x / (1 + x)
    ///    ```
    ///
    ///    since long edges tell rotations better by where they lead than by how they turn. `s` is four
    ///    times the noise that the residuals of agreeing edges show, each step anew.
    ///
    /// Steps 3 and 4 take at most [`SyncParams::iterations`] reweightings each. Where no triangle closes,
    /// step 2 grows a tree and rotations alone are judged, until step 4 finds the noise of the
    /// translations. Without the redundancy to tell the noise, step 4 keeps the scales of step 3. It is
    /// left out where its factor would have more than four million numbers, as that of 2000 scans
    /// joined with their ten neighbours in space, or of 600 joined at random.
    ///
    /// `O(Σ deg²)` over the nodes for the triangles, and one sparse factorisation per reweighting, in step
    /// 4 of a `6N × 6N` matrix.
    Consensus,
}

/// Loss of iteratively reweighted rotation averaging, [`Method::RotAvg`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RobustLoss {
    /// `ρ(r) = r`: weights `w⁰ min(1, σ / 10 r)` with `σ` the [`SyncParams::residual_scale`].
    L1,
    /// `ρ(r) = √r`: weights `w⁰ min(1, (σ / 10 r)^{3/2})`.
    LHalf,
    /// `ρ(r) = r² / (r² + σ²)`: weights `w⁰ / (1 + r²/σ²)²`.
    GemanMcClure,
}

/// A name that no [`Method`] has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no synchronisation method is named {name:?}: known are {}",
    known_names()
)]
pub struct UnknownMethod {
    /// The name.
    pub name: String,
}

impl Method {
    /// All methods, with default parameters.
    pub const ALL: [Self; 10] = [
        Self::HistoryAware(History::Adaptive(AdaptiveHistory::DEFAULT)),
        Self::HistoryAware(History::Adaptive(AdaptiveHistory {
            recovery: 0.0,
            ..AdaptiveHistory::DEFAULT
        })),
        Self::HistoryAware(History::Sghr),
        Self::HistoryAware(History::Memoryless),
        Self::EigSe3,
        Self::RotAvg(RobustLoss::L1),
        Self::RotAvg(RobustLoss::GemanMcClure),
        Self::RotAvg(RobustLoss::LHalf),
        Self::Hara,
        Self::Consensus,
    ];

    /// Short name, as in the table above; parameters do not show in it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::HistoryAware(History::Adaptive(history)) if history.recovery == 0.0 => {
                "no-recovery"
            }
            Self::HistoryAware(History::Adaptive(_)) => "adaptive",
            Self::HistoryAware(History::Sghr) => "sghr",
            Self::HistoryAware(History::Memoryless) => "memoryless",
            Self::EigSe3 => "eigse3",
            Self::RotAvg(RobustLoss::L1) => "l1",
            Self::RotAvg(RobustLoss::GemanMcClure) => "l1-irls",
            Self::RotAvg(RobustLoss::LHalf) => "rotavg-lhalf",
            Self::Hara => "hara",
            Self::Consensus => "consensus",
        }
    }
}

fn known_names() -> String {
    Method::ALL.map(|method| method.name()).join(", ")
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let found = Self::ALL.into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| UnknownMethod {
            name: name.to_owned(),
        })
    }
}

impl Default for Method {
    fn default() -> Self {
        Self::HistoryAware(History::default())
    }
}

impl From<History> for Method {
    fn from(history: History) -> Self {
        Self::HistoryAware(history)
    }
}

/// The solution of one component.
pub(crate) struct Solution {
    pub world_from_node: Vec<Isometry3<f64>>,
    pub final_weights: Vec<f64>,
    pub iterations: Vec<Iteration>,
    pub eigen_residual: f64,
    pub weakest_block: f64,
    pub position_residual: f64,
}

impl Solution {
    /// Synchronises one component. Its lowest node has the identity.
    pub fn new(graph: &Subgraph, initial_weights: Vec<f64>, params: &SyncParams) -> Self {
        if graph.measurements.is_empty() {
            let poses = vec![Isometry3::identity(); graph.num_nodes];
            return Self::of_poses(poses, Vec::new(), Vec::new());
        }
        match params.method {
            Method::HistoryAware(history) => {
                history_aware::synchronize(graph, initial_weights, history, params)
            }
            Method::EigSe3 => eigse3::synchronize(graph, initial_weights),
            Method::RotAvg(loss) => lie_averaging::rot_avg(graph, initial_weights, loss, params),
            Method::Hara => hara::synchronize(graph, initial_weights, params),
            Method::Consensus => consensus::synchronize(graph, initial_weights, params),
        }
    }

    /// A solution that neither an eigenproblem nor translation least squares led to.
    pub fn of_poses(
        world_from_node: Vec<Isometry3<f64>>,
        final_weights: Vec<f64>,
        iterations: Vec<Iteration>,
    ) -> Self {
        Self {
            world_from_node,
            final_weights,
            iterations,
            eigen_residual: 0.0,
            weakest_block: 1.0,
            position_residual: 0.0,
        }
    }

    /// Rotations, completed by translation least squares under the final weights.
    pub fn of_rotations(
        graph: &Subgraph,
        rotations: &[Rotation3<f64>],
        final_weights: Vec<f64>,
        iterations: Vec<Iteration>,
    ) -> Self {
        let translations = subgraph_translations(graph, rotations, &final_weights);
        let parts = rotations.iter().zip(&translations.positions);
        let poses = parts.map(|(rotation, t)| isometry(rotation, t)).collect();
        Self {
            position_residual: translations.residual,
            ..Self::of_poses(poses, final_weights, iterations)
        }
    }
}

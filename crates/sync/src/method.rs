use std::fmt;
use std::str::FromStr;

/// How a pose graph is synchronized: the paper's way, and others to compare with or to choose where
/// many edges are outliers.
///
/// All take the same graph and honor its weights. `L`, the
/// [`SyncParams::iterations`](crate::SyncParams::iterations), counts reweightings, and `σ`, the
/// [`SyncParams::residual_scale`](crate::SyncParams::residual_scale), is the scale of the robust loss,
/// where the method has such.
/// Methods that average rotations only get their positions by
/// [`solve_translations`](crate::solve_translations) under the final weights.
///
/// | name | method | outliers | positions help the rotations |
/// |---|---|---|---|
/// | `adaptive` | [`Adaptive`](Self::Adaptive), the paper | reweighted | no |
/// | `no-recovery` | [`NoRecovery`](Self::NoRecovery): the same with `ρ = 0` | reweighted | no |
/// | `sghr` | [`Sghr`](Self::Sghr): the same with SGHR's history | reweighted | no |
/// | `memoryless` | [`Memoryless`](Self::Memoryless): the same without history | reweighted | no |
/// | `eigse3` | [`EigSe3`](Self::EigSe3) | trusted | yes |
/// | `l1` | [`L1`](Self::L1) | ℓ₁ | no |
/// | `l1-irls` | [`L1Irls`](Self::L1Irls) | Geman–McClure | no |
/// | `rotavg-lhalf` | [`RotAvgLHalf`](Self::RotAvgLHalf) | ℓ½ | no |
/// | `hara` | [`Hara`](Self::Hara) | found by triplets | no |
/// | `consensus` | [`Consensus`](Self::Consensus) | found by triangles and votes | yes |
///
/// In files a method is its name.
///
/// ```
/// use gmpcr_sync::Method;
///
/// assert_eq!("sghr".parse(), Ok(Method::Sghr));
/// assert_eq!(Method::default().to_string(), "adaptive");
/// assert!("best".parse::<Method>().unwrap_err().to_string().contains("consensus"));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// The paper: connection-Laplacian rotation averaging, reweighted by residual history;
    /// translation least squares.
    ///
    /// The memory of the history adapts to the evolution of the overall error, and edges whose
    /// residual falls recover: see [`AdaptiveHistory`](crate::AdaptiveHistory).
    #[default]
    Adaptive,
    /// [`Adaptive`](Self::Adaptive) without recovery, `ρ = 0`; the other parameters of the
    /// history hold.
    NoRecovery,
    /// [`Adaptive`](Self::Adaptive) with the accumulating history of SGHR (Wang et al., CVPR 2023):
    /// with `θ` the residual in degrees, `w ← w exp(−2 θ (ℓ+1) / (L(L+1)/2))`, multiplied on over all
    /// iterations. SGHR has `L = 50`.
    Sghr,
    /// [`Adaptive`](Self::Adaptive) without history: each iteration forgets the last,
    /// `w = w⁰ exp(−r)`.
    Memoryless,
    /// EIG-SE(3): spectral synchronization of rotations and positions at once (Arrigoni, Rossi,
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
    /// All edges are trusted: there are no iterations, and a few outliers spoil all poses. The
    /// singular vectors are found as eigenvectors of the normal matrix, by filtered block
    /// iteration with refined solves. Its pattern joins each scan with the neighbors of its neighbors,
    /// and its gaps are the squares of small numbers in graphs of large diameter: there noise has more
    /// effect than in the other methods.
    EigSe3,
    /// Rotation averaging with the ℓ₁ loss, `argmin Σ w⁰_ij r_ij` (Chatterjee and Govindu,
    /// "Efficient and robust large-scale rotation averaging", ICCV 2013, and "Robust relative
    /// rotation averaging", TPAMI 2018).
    ///
    /// From the rotations along a spanning tree of maximal weight, steps in the tangent space lead to
    /// the weighted least squares over SO(3), each by one solve with the graph Laplacian. Reweighting
    /// by `w = w⁰ min(1, σ / 10 r)` leads on to the ℓ₁ average; below `σ / 10` the loss is a parabola.
    /// The authors solve each linearized ℓ₁ problem by linear programming; here the norm is that of the
    /// rotation vector, so that the result does not depend on the axes.
    ///
    /// At most `L` reweightings, but no fewer than 20, as the start is far; none
    /// (plain least squares) if that is 0. Each costs one sparse factorization of an `N × N` matrix and
    /// a few solves.
    L1,
    /// L1-IRLS of the paper of 2013 that [`L1`](Self::L1) names: from the ℓ₁ average on with the
    /// Geman–McClure loss `ρ(r) = r² / (r² + σ²)`, whose weights are `w⁰ / (1 + r²/σ²)²`.
    ///
    /// At most `L` more reweightings. A minimum found need not be the lowest.
    L1Irls,
    /// The choice of the paper of 2018 that [`L1`](Self::L1) names: from the ℓ₁ average on with the
    /// loss `ρ(r) = √r`, whose weights are `w⁰ min(1, (σ / 10 r)^{3/2})`.
    ///
    /// At most `L` more reweightings. A minimum found need not be the lowest.
    RotAvgLHalf,
    /// HARA: rotation averaging that begins with the edges that most triangles confirm (Lee and
    /// Civera, "HARA: A hierarchical approach for robust rotation averaging", CVPR 2022).
    ///
    /// 1. The support of an edge is the number of triangles it is part of whose rotations compose to
    ///    less than a threshold: 0.5, 1 and 2 times `σ`.
    /// 2. A spanning tree grows by the edge of the highest support, up to 10, and among equals of the
    ///    strictest threshold. Without support it grows by the edge of the highest weight, and the new
    ///    scan takes, of the rotations that its edges from the tree propose, the one nearest to all.
    /// 3. A first least squares leaves out the edges that the tree contradicts by more than `8 σ`
    ///    (weight 10⁻⁶), and the loss of [`RotAvgLHalf`](Self::RotAvgLHalf) refines it. Together these
    ///    take at most `L` reweightings; 0 is plain least squares.
    ///
    /// Simplified: the paper takes its thresholds from percentiles of sampled loop errors, adds
    /// unsupported scans by the number of their edges, and never takes filtered edges back. Finding the
    /// triangles costs `O(Σ deg² log deg)`.
    Hara,
    /// A method of this project, for graphs where many edges are outliers. It builds on triangles: on
    /// graphs with few of them it is no better than others, and where more than a third of the edges are
    /// outliers that agree with each other, their triangles mislead it.
    ///
    /// 1. Edges that close triangles in rotation *and* translation are inliers: random edges do not.
    ///    The median gap of the triangles whose rotations close is the translation noise.
    /// 2. The parts that such edges connect are solved by least squares, then joined one by
    ///    one, each time the two parts that most of the edges between them agree on. Then each scan moves
    ///    to where more of its edges place it, until none does.
    /// 3. All edges: reweighted least squares, first of rotations, then of translations, with the
    ///    Geman–McClure loss of both residuals, `w = w⁰ (1 + (r_R/σ_R)² + (r_t/σ_t)²)⁻²`, its scale
    ///    falling from four times the noise to the noise. `σ_R` is `σ`.
    /// 4. Rotations and translations at once, by reweighted Gauss–Newton steps down the loss
    ///
    ///    ```text
    ///    Σ w⁰_ij ρ(‖log(R̂_ijᵀ R_iᵀ R_j)‖² / s_R² + ‖R_iᵀ (t_j − t_i) − t̂_ij‖² / s_t²),   ρ(x) = x / (1 + x)
    ///    ```
    ///
    ///    since the translations of long edges determine rotations better than their rotations do. `s`
    ///    is four times the noise that the residuals of agreeing edges show, each step anew.
    ///
    /// Steps 3 and 4 take at most `L` reweightings each; if that is 0, the edges
    /// are weighted once by the poses of step 2. Where no triangle closes,
    /// step 2 grows a tree and rotations alone are compared, until step 4 finds the noise of the
    /// translations. Without the redundancy to find the noise, step 4 keeps the scales of step 3. It is
    /// left out where its factor would have more than four million numbers, as that of 2000 scans
    /// joined with their ten neighbors in space, or of 600 joined at random.
    ///
    /// `O(Σ deg²)` over the nodes for the triangles, and one sparse factorization per reweighting, in step
    /// 4 of a `6N × 6N` matrix.
    Consensus,
}

impl Method {
    /// All methods, in the order of the table above.
    pub const ALL: &'static [Self] = &[
        Self::Adaptive,
        Self::NoRecovery,
        Self::Sghr,
        Self::Memoryless,
        Self::EigSe3,
        Self::L1,
        Self::L1Irls,
        Self::RotAvgLHalf,
        Self::Hara,
        Self::Consensus,
    ];

    /// The name in the table above.
    pub fn name(self) -> &'static str {
        match self {
            Self::Adaptive => "adaptive",
            Self::NoRecovery => "no-recovery",
            Self::Sghr => "sghr",
            Self::Memoryless => "memoryless",
            Self::EigSe3 => "eigse3",
            Self::L1 => "l1",
            Self::L1Irls => "l1-irls",
            Self::RotAvgLHalf => "rotavg-lhalf",
            Self::Hara => "hara",
            Self::Consensus => "consensus",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let found = Self::ALL.iter().find(|method| method.name() == name);
        found.copied().ok_or_else(|| UnknownMethod {
            name: name.to_owned(),
        })
    }
}

/// A name that no [`Method`] has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no synchronization method is named {name:?}: known are {}",
    known_names()
)]
#[non_exhaustive]
pub struct UnknownMethod {
    /// The name.
    pub name: String,
}

fn known_names() -> String {
    let names: Vec<_> = Method::ALL.iter().map(|method| method.name()).collect();
    names.join(", ")
}

#[cfg(feature = "serde")]
impl serde::Serialize for Method {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Method {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        name.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_found_by_its_name() {
        for &method in Method::ALL {
            assert_eq!(method.name().parse(), Ok(method));
        }
        assert_eq!(Method::ALL[0], Method::default());
    }
}

use std::str::FromStr;

use crate::Params;

/// The paper's datasets, for which it gives parameters: to choose them by name.
///
/// ```
/// use gmpcr::{Params, Preset};
///
/// let preset: Preset = "threedlomatch".parse()?;
/// assert_eq!(preset.params(), Params::threedlomatch());
/// assert_eq!(Preset::default().name(), "threedmatch");
/// assert!("moon".parse::<Preset>().is_err());
/// # Ok::<(), gmpcr::UnknownPreset>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "lowercase")
)]
#[non_exhaustive]
pub enum Preset {
    /// [`Params::threedmatch`].
    #[default]
    ThreeDMatch,
    /// [`Params::threedlomatch`].
    ThreeDLoMatch,
    /// [`Params::scannet`].
    ScanNet,
    /// [`Params::eth`].
    Eth,
}

/// No preset has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no preset is named {name:?}: known are {}", known_names())]
#[non_exhaustive]
pub struct UnknownPreset {
    /// The name.
    pub name: String,
}

impl Preset {
    /// All presets.
    pub const ALL: &'static [Self] = &[
        Self::ThreeDMatch,
        Self::ThreeDLoMatch,
        Self::ScanNet,
        Self::Eth,
    ];

    /// Its name, by which it is parsed.
    pub fn name(self) -> &'static str {
        match self {
            Self::ThreeDMatch => "threedmatch",
            Self::ThreeDLoMatch => "threedlomatch",
            Self::ScanNet => "scannet",
            Self::Eth => "eth",
        }
    }

    /// Its parameters.
    pub fn params(self) -> Params {
        match self {
            Self::ThreeDMatch => Params::threedmatch(),
            Self::ThreeDLoMatch => Params::threedlomatch(),
            Self::ScanNet => Params::scannet(),
            Self::Eth => Params::eth(),
        }
    }
}

fn known_names() -> String {
    let names: Vec<_> = Preset::ALL.iter().map(|preset| preset.name()).collect();
    names.join(", ")
}

impl FromStr for Preset {
    type Err = UnknownPreset;

    fn from_str(name: &str) -> Result<Self, UnknownPreset> {
        let mut presets = Self::ALL.iter().copied();
        presets
            .find(|preset| preset.name() == name)
            .ok_or_else(|| UnknownPreset {
                name: name.to_owned(),
            })
    }
}

use std::fmt;
use std::time::{Duration, Instant};

/// A stage of the way from clouds to poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[non_exhaustive]
pub enum Stage {
    /// Estimate of the voxel size; its items are clouds.
    VoxelSize,
    /// Normals and descriptors; its items are clouds.
    Features,
    /// Farthest-point sampling; its items are scans.
    Sampling,
    /// Matching and scoring; its items are pairs of scans. It begins again for each round of pairs where they
    /// are retrieved; the retrieval itself has no items.
    Scoring,
    /// Choice of the edges, one item.
    Selection,
    /// Relative poses; its items are the selected pairs.
    PoseEstimation,
    /// Synchronization, one item.
    Synchronization,
}

impl Stage {
    /// All stages in their order.
    pub const ALL: &'static [Self] = &[
        Self::VoxelSize,
        Self::Features,
        Self::Sampling,
        Self::Scoring,
        Self::Selection,
        Self::PoseEstimation,
        Self::Synchronization,
    ];

    /// The name in words, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::VoxelSize => "voxel size",
            Self::Features => "features",
            Self::Sampling => "sampling",
            Self::Scoring => "pair scoring",
            Self::Selection => "pair selection",
            Self::PoseEstimation => "pose estimation",
            Self::Synchronization => "synchronization",
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// Wall time of the stages that were run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageTimes {
    /// In the order of [`Stage::ALL`].
    times: [Duration; Stage::ALL.len()],
}

impl StageTimes {
    /// Runs a part of a stage and adds its time.
    pub(crate) fn timed<T>(&mut self, stage: Stage, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.add(stage, start.elapsed());
        result
    }

    pub(crate) fn add(&mut self, stage: Stage, time: Duration) {
        self.times[stage as usize] += time;
    }

    /// The time of a stage; zero of one that was not run.
    pub fn of(&self, stage: Stage) -> Duration {
        self.times[stage as usize]
    }

    /// Sum of all stages.
    pub fn total(&self) -> Duration {
        self.times.iter().sum()
    }

    /// The stages that took time, in order.
    pub fn stages(&self) -> impl Iterator<Item = (Stage, Duration)> {
        let all = Stage::ALL.iter().map(|&stage| (stage, self.of(stage)));
        all.filter(|(_, time)| *time > Duration::ZERO)
    }
}

/// Seconds by the name of the stage.
#[cfg(feature = "serde")]
mod serde_impl {
    use std::collections::HashMap;

    use serde::ser::SerializeMap;
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    use super::*;

    impl Serialize for StageTimes {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            let mut map = serializer.serialize_map(None)?;
            for (stage, time) in self.stages() {
                map.serialize_entry(&stage, &time.as_secs_f64())?;
            }
            map.end()
        }
    }

    impl<'de> Deserialize<'de> for StageTimes {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            let mut times = Self::default();
            for (stage, seconds) in <HashMap<Stage, f64>>::deserialize(deserializer)? {
                let time = Duration::try_from_secs_f64(seconds).map_err(D::Error::custom)?;
                times.add(stage, time);
            }
            Ok(times)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stages_are_numbered_in_their_order() {
        let numbers = Stage::ALL.iter().map(|&stage| stage as usize);
        assert!(numbers.eq(0..Stage::ALL.len()));
    }
}

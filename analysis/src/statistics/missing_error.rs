//! Why a value has no standard error.

use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// The text of [`MissingError::SetByManifest`], by which a baseline is known to contain such a value.
pub(crate) const SET_BY_MANIFEST: &str =
    "the manifest sets the value, which is the same for every seed";

/// The text of [`MissingError::DependsOnStart`].
pub(crate) const DEPENDS_ON_START: &str =
    "the value differs from start to start: a standard error needs replicates";

/// The text of [`MissingError::NothingCounted`].
pub(crate) const NOTHING_COUNTED: &str = "nothing was counted";

/// Why the second moment of the speeds of a run with few events has no mean.
pub(crate) const AFTER_FEW_EVENTS: &str =
    "needs two frames with the channel temperature or per_collision after 5 events per disc";
/// Why frames far apart give no diffusion coefficient.
pub(crate) const FRAMES_FAR_APART: &str = "frames are more than a quarter of a mean free time apart, or a disc may have traveled a quarter of a side between two";
/// Why a short run gives no diffusion coefficient.
pub(crate) const SHORTER_THAN_WINDOW: &str = "the run is shorter than ten mean free times";

/// Why runs that differ by a rounding error stay close.
pub(crate) const NO_CHAOS: &str =
    "the exponent is compatible with 0: differences do not grow exponentially";

/// Reasons for a missing value that hold for some seeds of a manifest only: the number of events of a duration, and the fastest disc.
pub(crate) const BY_CHANCE: [&str; 4] =
    [AFTER_FEW_EVENTS, FRAMES_FAR_APART, SHORTER_THAN_WINDOW, NO_CHAOS];

/// Parts of the texts of [`MissingError::TooFewEntries`] and [`MissingError::TooCorrelated`], by which a baseline is known to contain a
/// value that scatters by an unknown amount.
const OF_SHORT_SERIES: [&str; 2] = [", the run has ", ": a standard error needs a longer run"];

/// Whether a reason states that the series is too short for an error. That may depend on the seed.
pub(crate) fn is_of_short_series(reason: &str) -> bool {
    OF_SHORT_SERIES.iter().any(|part| reason.contains(part))
}

/// Why a value has no standard error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MissingError {
    /// The series has fewer entries than an error needs.
    TooFewEntries {
        /// The entries.
        entries: Entries,
        /// The number needed.
        needs: u64,
        /// The number present.
        has: u64,
    },
    /// The entries are correlated over a large part of the series.
    TooCorrelated(Entries),
    /// The value changes systematically during the run, so the scatter of its parts is not a statistical error.
    Drifting,
    /// The value depends on the start of the run, and one run does not tell how much it differs from seed to seed.
    DependsOnStart,
    /// The manifest alone determines the value, which is the same for every seed.
    SetByManifest,
    /// No event was counted, so neither the value nor its scatter is known.
    NothingCounted,
}

/// The entries of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Entries {
    /// Recorded frames.
    #[default]
    Frames,
    /// Frames of the interval over which a value is averaged.
    AveragedFrames,
    /// Frames from which the structure was sampled.
    SampledFrames,
    /// Time intervals between frames.
    Intervals,
    /// Recorded collisions.
    Collisions,
}

impl Display for Entries {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Frames => "frames",
            Self::AveragedFrames => "averaged frames",
            Self::SampledFrames => "sampled frames",
            Self::Intervals => "intervals between frames",
            Self::Collisions => "collisions",
        })
    }
}

impl Display for MissingError {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewEntries { entries, needs, has } => {
                let [the_run_has, _] = OF_SHORT_SERIES;
                write!(formatter, "a standard error needs {needs} {entries}{the_run_has}{has}")
            }
            Self::TooCorrelated(entries) => {
                let [_, needs_longer_run] = OF_SHORT_SERIES;
                write!(
                    formatter,
                    "the {entries} are correlated over much of the run{needs_longer_run}"
                )
            }
            Self::Drifting => formatter
                .write_str("the value drifts during the run: a standard error needs replicates"),
            Self::SetByManifest => formatter.write_str(SET_BY_MANIFEST),
            Self::NothingCounted => formatter.write_str(NOTHING_COUNTED),
            Self::DependsOnStart => formatter.write_str(DEPENDS_ON_START),
        }
    }
}

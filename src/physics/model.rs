//! The one boundary between physics and the rest.

use crate::random::Seed;
use kinetoscope_recording::channels::ChannelDeclaration;
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::scenery::Scenery;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt;

/// How long a run is, as the model counts it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// `total` steps of length `step` in the model's time unit.
    Steps {
        /// Number of steps.
        total: u64,
        /// Length of one step, in the model's time unit.
        step: f64,
    },
    /// This many events.
    Events(u64),
    /// This long, in the model's time unit; any instant can be looked at.
    Time(f64),
}

/// Where the next frame is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// After this many steps or events since the start.
    Count(u64),
    /// At this time since the start, in the model's time unit.
    Time(f64),
}

/// Whether a call to [`Model::advance`] arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The target is reached: a frame may be taken.
    Reached,
    /// The budget was used up before the target.
    Working,
}

/// A start that can't be run, in words for the user: what is wrong and what would do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetupError(pub String);

/// Physics that went wrong while running (a blow-up, a collapse): a result, not a crash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SimulationFault(pub String);

impl fmt::Display for SetupError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl fmt::Display for SimulationFault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for SetupError {}
impl std::error::Error for SimulationFault {}

/// A physical system that can be moved, looked at and continued. The value is its own checkpoint.
///
/// How work is cut by `at_most`, and whether anybody looks, does not change a bit of the trajectory.
pub trait Model: Sized + Serialize + DeserializeOwned {
    /// The table `[model.<NAME>]`.
    type Config;
    /// The table's name.
    const NAME: &'static str;
    /// Raised with every change that alters a trajectory's bits; part of the run key.
    const PHYSICS_VERSION: u32;
    /// "s", "d", or "" for dimensionless time.
    const TIME_UNIT: &'static str;
    /// The columns of a particle's row in the state.
    const STATE_COLUMNS: &'static [StateColumn];
    /// The channels that [`Model::observe`] can fill, in file order.
    const CHANNELS: &'static [ChannelDeclaration];

    /// The state at the start. `opt_in` asks for the series that is recorded only on request: single collisions, which cost
    /// memory between frames, or contact forces.
    ///
    /// # Errors
    /// A start that can't be built or can't be run, with what would do instead.
    fn prepare(config: &Self::Config, seed: Seed, opt_in: bool) -> Result<Self, SetupError>;

    /// The channels that this run fills, in file order.
    fn channels(&self) -> &'static [ChannelDeclaration] {
        Self::CHANNELS
    }

    /// How long the run is.
    fn extent(&self) -> Extent;

    /// Particles that may still enter: what memory and disk must have room for beside those that are there.
    fn particles_to_come(&self) -> u64 {
        0
    }

    /// Moves toward the target by at most so many steps or events (at least one). The first call after a target was
    /// reached opens a new window: quantities "since the last frame" start again from zero.
    ///
    /// # Errors
    /// Physics that went wrong; the state may still be looked at.
    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, SimulationFault>;

    /// Steps or events since the start.
    fn count(&self) -> u64;

    /// Time since the start, computed from counts and never accumulated where steps are fixed.
    fn time(&self) -> f64;

    /// Fills an empty frame with the state at the target that was reached last.
    fn observe(&self, frame: &mut Frame);

    /// The drawing's fixed part.
    fn scenery(&self) -> Scenery;
}

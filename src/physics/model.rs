//! The boundary between physics and the rest of the program: what every model implements.

use crate::random::Seed;
use kinetoscope_console::{Explained, Message};
use kinetoscope_recording::channels::ChannelDeclaration;
use kinetoscope_recording::checkpoint::Content;
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::scenery::Scenery;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Length of a run, as the model counts it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Extent {
    /// `total` steps of length `step` in the model's time unit.
    Steps {
        /// Number of steps.
        total: u64,
        /// Length of one step, in the model's time unit.
        step: f64,
    },
    /// Number of events.
    Events(u64),
    /// Duration in the model's time unit; a frame can be taken at any instant.
    Time(f64),
}

/// Position of the next frame in the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// After this many steps or events since the start.
    Count(u64),
    /// At this time since the start, in the model's time unit.
    Time(f64),
}

impl Extent {
    /// The end of the run.
    #[must_use]
    pub fn end(self) -> Target {
        match self {
            Self::Steps { total, .. } | Self::Events(total) => Target::Count(total),
            Self::Time(duration) => Target::Time(duration),
        }
    }
}

/// Result of a call to [`Model::advance`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The target is reached: a frame may be taken.
    Reached,
    /// The budget was used up before the target.
    Working,
}

/// Whether to continue with a start that takes long to build. It is asked at least every tenth of a second, with the fraction of the
/// start that is complete.
pub type Proceed<'a> = &'a dyn Fn(f64) -> bool;

/// A start that cannot be run: what is wrong and what to change, for the user.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{}", .0.what)]
pub struct SetupError(pub Message);

impl SetupError {
    /// What is wrong with the start, and what to change.
    pub fn new(what: impl Into<String>, help: impl Into<String>) -> Self {
        Self(Message::new(what, help))
    }

    /// A start that was not completed, because [`Proceed`] returned `false`.
    #[must_use]
    pub fn stopped() -> Self {
        Self::new("stopped while the start was built", "run the same command again")
    }
}

impl Explained for SetupError {
    fn help(&self) -> Option<String> {
        self.0.help.clone()
    }
}

/// A physical failure of a running simulation (a blow-up, a collapse): a result, not a crash. Boxed, because each step returns one
/// or none.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{}", .0.message.what)]
pub struct SimulationFault(Box<FaultText>);

#[derive(Clone, Debug, PartialEq, Eq)]
struct FaultText {
    message: Message,
    /// Part of the recording: its bytes change only with the version of the physics.
    recorded: String,
}

impl SimulationFault {
    /// What failed, and what to change; recorded as two clauses.
    #[must_use]
    pub fn new(what: impl Into<String>, help: impl Into<String>) -> Self {
        let message = Message::new(what, help);
        let recorded = message.clause();
        Self::recorded_as(message, recorded)
    }

    /// A request that the contract of [`Model::advance`] excludes: no manifest leads to it.
    #[must_use]
    pub(crate) fn of_caller(what: String) -> Self {
        Self::recorded_as(what.clone().into(), what)
    }

    /// A failure that is recorded in other words.
    #[must_use]
    pub fn recorded_as(message: Message, recorded: String) -> Self {
        Self(Box::new(FaultText { message, recorded }))
    }

    /// The text in the recording: what failed, and what to change.
    #[must_use]
    pub fn recorded(&self) -> &str {
        &self.0.recorded
    }
}

impl Explained for SimulationFault {
    fn help(&self) -> Option<String> {
        self.0.message.help.clone()
    }
}

/// The properties that all runs of a model share.
#[derive(Clone, Copy, Debug)]
pub struct ModelKind {
    /// Name of the table `[model.<name>]`.
    pub name: &'static str,
    /// Version of the physics, part of the run key. Every change that alters a bit of a trajectory or of a recorded value raises it.
    pub physics_version: u32,
    /// Unit of time: "s", "d", or "" for dimensionless time.
    pub time_unit: &'static str,
    /// Columns of a particle's row in the state of most runs; [`Model::state_columns`] are those of one run.
    pub state_columns: &'static [StateColumn],
    /// Channels that [`Model::observe`] can fill, in file order.
    pub channels: &'static [ChannelDeclaration],
}

/// A physical system that can be advanced, observed and resumed. The serialized value is its checkpoint.
///
/// Invariant: neither the division of the work by `at_most` nor an observation changes a bit of the trajectory.
pub trait Model: Content + Send {
    /// The table `[model.<name>]`.
    type Config
    where
        Self: Sized;

    /// The properties that all runs of the model share.
    fn kind() -> &'static ModelKind
    where
        Self: Sized;

    /// Columns of a particle's row in the state of a run.
    fn state_columns(config: &Self::Config) -> &'static [StateColumn]
    where
        Self: Sized,
    {
        let _ = config;
        Self::kind().state_columns
    }

    /// Builds the state at the start. `opt_in` requests the series that is recorded only on request: single collisions,
    /// which take memory between frames, or contact forces.
    ///
    /// # Errors
    /// A start that cannot be built or cannot be run, with the remedy.
    fn prepare(config: &Self::Config, seed: Seed, opt_in: bool) -> Result<Self, SetupError>
    where
        Self: Sized;

    /// Builds the state at the start as [`Model::prepare`] does, unless `proceed` returns `false` before it is complete. A model whose
    /// start takes longer than a tenth of a second asks.
    ///
    /// # Errors
    /// As [`Model::prepare`], and [`SetupError::stopped`].
    fn prepare_while(
        config: &Self::Config,
        seed: Seed,
        opt_in: bool,
        _proceed: Proceed<'_>,
    ) -> Result<Self, SetupError>
    where
        Self: Sized,
    {
        Self::prepare(config, seed, opt_in)
    }

    /// Whether a model that was restored from a checkpoint can be a state of a run with this configuration: its constants are
    /// those of the configuration, all numbers are finite, all positions are possible, and indices name existing particles.
    /// The checksum of a checkpoint detects damage, but any program can compute it. With a valid state, no later step panics or
    /// takes forever; that it is the true state cannot be checked without a rerun.
    fn is_valid_for(&self, config: &Self::Config) -> bool
    where
        Self: Sized;

    /// The channels that this run fills, in file order.
    fn channels(&self) -> &'static [ChannelDeclaration];

    /// Length of the run.
    fn extent(&self) -> Extent;

    /// Number of particles that may still enter. Memory and disk must have room for them in addition to the present ones.
    fn particles_to_come(&self) -> u64 {
        0
    }

    /// Advances toward the target by at most `at_most` steps or events (at least one). The first call after a reached
    /// target opens a new window: quantities "since the last frame" start again from zero.
    ///
    /// # Errors
    /// A physical failure; the state may still be observed.
    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, SimulationFault>;

    /// Number of steps or events since the start.
    fn count(&self) -> u64;

    /// Time since the start, computed from counts and never accumulated where steps are fixed.
    fn time(&self) -> f64;

    /// Fills an empty frame with the state at the target that was reached last.
    fn observe(&self, frame: &mut Frame);

    /// The fixed part of the drawing. It is the same at any time of a run, so that a resumed run draws as it began; only walls may be
    /// those of the present, because they are drawn with the first frame.
    fn scenery(&self) -> Scenery;
}

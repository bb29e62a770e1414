//! Why a run is outside the range of a law: the condition that fails, and the value.

use crate::number_text::six_digits;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};

/// A condition of a law that a run does not meet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Violation {
    quantity: Quantity,
    failure: Failure,
}

/// How a condition fails.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Failure {
    /// The value is above its largest one.
    Above { value: f64, limit: f64 },
    /// The value is not below its limit.
    NotBelow { value: f64, limit: f64 },
    /// The value is below its least one.
    Below { value: f64, limit: f64 },
    /// A statement does not hold.
    Untrue,
}

macro_rules! quantities {
    ($($(#[$doc:meta])* $quantity:ident = $words:literal,)+) => {
        /// What the conditions of laws are about.
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        pub(crate) enum Quantity {
            $($(#[$doc])* $quantity,)+
        }

        impl Quantity {
            fn words(self) -> &'static str {
                match self {
                    $(Self::$quantity => $words,)+
                }
            }
        }
    };
}

quantities! {
    /// Eccentricity at the start.
    Eccentricity = "ε",
    /// Mean motion times time step.
    StepAngle = "ω Δt",
    /// Time over the period.
    Revolutions = "the number of revolutions",
    /// Recorded frames per period.
    FramesPerRevolution = "the number of frames per revolution",
    /// Time step over the duration of a contact.
    StepOverContact = "Δt over the duration of a contact",
    /// Damping times time step over mass.
    DampingStep = "η_n Δt/m",
    /// Surfaces in contact attract each other.
    Cohesion = "surfaces in contact attract each other (`cohesion_n`)",
    /// Area of the discs over that of the box, far from the walls where there are walls.
    PackingFraction = "φ",
    /// Diameter of a disc over the side of the box.
    DiameterOverSide = "d/L",
    /// Wave number times the diameter of a disc.
    WaveNumber = "Q d",
    /// Estimate of what an expansion in 1/N leaves out.
    NextOrder = "the next term of the expansion in 1/N",
    /// Variance of the angle by which a wall turns velocities.
    WallNoise = "the variance of the wall noise in rad^2",
    /// The total momentum of discs in a periodic box.
    Drift = "the discs drift through the periodic box (`remove_mean_velocity = false`)",
    /// Fixed obstacles among the discs.
    Obstacles = "there are obstacles",
    /// Obstacles that keep discs from the floor or from a part of the box.
    Barrier = "obstacles keep discs from the floor or from a part of the box",
    /// Number of discs.
    Discs = "the number of discs",
    /// Flow or clusters, above those of independent discs.
    FlowOrClusters = "flow or clusters above those of independent discs",
    /// Flow and clusters cannot be excluded from the states of some frames.
    FlowBetweenKeyframes = "flow and clusters are found from the states of all frames, which `kinetoscope fill` restores",
    /// No state from which flow and clusters could be found.
    StateOfManyDiscs = "there are fewer than 128 discs",
    /// Rms speed times time over the diameter of the container.
    Crossings = "the number of crossings of the container",
    /// The same since a partition was removed.
    CrossingsSinceRemoval = "the number of crossings since the partition was removed",
    /// Entropy that particles with few crossings lack, over the error of the change.
    EntropyOfSlowParticles = "the entropy that slow particles lack, over the error of the change,",
    /// The partition is not through the center.
    CentralPartition = "the partition is not through the center",
    /// A partition divides the particles.
    NoPartition = "a partition divides the particles",
    /// The start is no equilibrium.
    BarometricStart = "the particles do not start in barometric equilibrium",
    /// Speed of the wall over the rms speed.
    WallSpeed = "the speed of the wall over v_rms",
}

impl Quantity {
    /// The violation, unless the value is at most a limit. A NaN violates every condition.
    pub(crate) fn at_most(self, value: f64, limit: f64) -> Option<Violation> {
        self.unless(value <= limit, Failure::Above { value, limit })
    }

    /// The violation, unless the value is below a limit.
    pub(crate) fn below(self, value: f64, limit: f64) -> Option<Violation> {
        self.unless(value < limit, Failure::NotBelow { value, limit })
    }

    /// The violation, unless the value is at least a limit.
    pub(crate) fn at_least(self, value: f64, limit: f64) -> Option<Violation> {
        self.unless(value >= limit, Failure::Below { value, limit })
    }

    /// The violation, unless a condition without a value holds.
    pub(crate) fn required(self, holds: bool) -> Option<Violation> {
        self.unless(holds, Failure::Untrue)
    }

    fn unless(self, holds: bool, failure: Failure) -> Option<Violation> {
        (!holds).then_some(Violation { quantity: self, failure })
    }
}

impl Display for Violation {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let words = self.quantity.words();
        let (value, relation, limit) = match self.failure {
            Failure::Above { value, limit } => (value, "above", limit),
            Failure::NotBelow { value, limit } => (value, "not below", limit),
            Failure::Below { value, limit } => (value, "below", limit),
            Failure::Untrue => return formatter.write_str(words),
        };
        write!(formatter, "{words} is {}, {relation} {}", six_digits(value), six_digits(limit))
    }
}

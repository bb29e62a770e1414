//! `[model.packing]`: event-driven hard discs. Lengths and times are dimensionless, a disc has mass 1.

use super::GivenState;
use crate::diagnostics::Diagnostic;
use crate::keys::{Keys, Reader};
use crate::quantity::{BoxSide, NonNegative, Positive, Share};
use crate::tree::Node;
use crate::value::{TomlValue, words};
use serde_json::Value as Json;
use std::num::NonZeroU32;

/// All physics of a packing run. The box is centred on the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct PackingConfig {
    /// Number of discs n.
    pub discs: NonZeroU32,
    /// Width lx of the box.
    pub width: BoxSide,
    /// Height ly of the box.
    pub height: BoxSide,
    /// Radius of the discs, below half of the shorter side.
    pub radius: Positive,
    /// Coefficient of restitution alpha of a pair collision.
    pub restitution: Share,
    /// Variance of the angle by which a wall turns the outgoing direction, rad^2.
    pub wall_noise_variance_rad2: NonNegative,
    /// Law of the velocity components at the start.
    pub initial_velocities: InitialVelocities,
    /// When the run ends.
    pub length: RunLength,
    /// How discs are placed at the start.
    pub placement: PackingPlacement,
}

/// Law of the velocity components at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitialVelocities {
    /// Normal, variance 1.
    Unmodified,
    /// Normal, variance 1/n.
    Modified,
}

/// When a packing run ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RunLength {
    /// After this many events a disc, pair and wall collisions alike.
    EventsPerDisc(NonZeroU32),
    /// After this simulated time, in the model's unit.
    Duration(Positive),
}

/// How discs are placed at the start.
#[derive(Clone, Debug, PartialEq)]
pub enum PackingPlacement {
    /// Uniformly at random without overlap (packing fraction below 0.5).
    Random,
    /// On a regular lattice.
    Lattice,
    /// Written out, with velocities.
    Given(GivenState),
}

impl Default for PackingConfig {
    /// Fifty elastic discs in a box of 40 x 40 with the document's wall noise.
    fn default() -> Self {
        Self {
            discs: const { NonZeroU32::new(50).expect("not zero") },
            width: const { BoxSide::literal(40.0) },
            height: const { BoxSide::literal(40.0) },
            radius: const { Positive::literal(1.0) },
            restitution: const { Share::literal(1.0) },
            wall_noise_variance_rad2: const { NonNegative::literal(std::f64::consts::PI / 1000.0) },
            initial_velocities: InitialVelocities::Unmodified,
            length: RunLength::EventsPerDisc(const { NonZeroU32::new(100).expect("not zero") }),
            placement: PackingPlacement::Random,
        }
    }
}

words!(pub InitialVelocities { Unmodified = "unmodified", Modified = "modified" });

/// Names of the two lists of a given state: the model has no units.
const GIVEN: super::GivenNames =
    super::GivenNames { positions: "positions", velocities: "velocities" };

/// Packing fraction from which random placement is refused, by the input limits of the source document.
const RANDOM_PLACEMENT_LIMIT: f64 = 0.5;

impl PackingConfig {
    /// The keys of `[model.packing]`, in the order of the canonical manifest.
    pub(crate) fn keys(&mut self, keys: &mut impl Keys) {
        keys.key(
            "discs",
            "1",
            "Number of discs n; with a given placement it follows from that.",
            &mut self.discs,
        );
        keys.key(
            "width",
            "1",
            "Width lx of the box, which is centred on the origin.",
            &mut self.width,
        );
        keys.key("height", "1", "Height ly of the box.", &mut self.height);
        keys.key(
            "radius",
            "1",
            "Radius r of the discs, below half of the shorter side.",
            &mut self.radius,
        );
        keys.key(
            "restitution",
            "1",
            "Coefficient of restitution alpha of a pair collision.",
            &mut self.restitution,
        );
        keys.key(
            "wall_noise_variance_rad2",
            "rad^2",
            "Variance of the angle by which a wall turns the outgoing direction.",
            &mut self.wall_noise_variance_rad2,
        );
        keys.key(
            "initial_velocities",
            "",
            "Velocity components are normal with variance 1 (unmodified) or 1/n (modified).",
            &mut self.initial_velocities,
        );
        let (events, duration) = match self.length {
            RunLength::EventsPerDisc(events) => (Some(events), None),
            RunLength::Duration(duration) => (None, Some(duration)),
        };
        keys.exclusive(&["events_per_disc", "duration"]);
        if let Some(events) = keys.optional(
            "events_per_disc",
            "1",
            "The run ends after this many events a disc, pair and wall collisions alike.",
            events,
        ) {
            self.length = RunLength::EventsPerDisc(events);
        }
        if let Some(duration) = keys.optional(
            "duration",
            "1",
            "The run ends after this simulated time, in place of `events_per_disc`.",
            duration,
        ) {
            self.length = RunLength::Duration(duration);
        }
        keys.key(
            "placement",
            "",
            "How discs are placed at the start; random needs a packing fraction below 0.5.",
            &mut self.placement,
        );
    }

    /// The rules between the keys.
    pub(crate) fn check(&mut self, table: &mut Reader<'_>) {
        if let PackingPlacement::Given(state) = &self.placement {
            self.discs = state.count(table, "discs", self.discs);
        }
        let (width, height, radius) = (self.width.get(), self.height.get(), self.radius.get());
        let shorter = if width < height { width } else { height };
        if 2.0 * radius >= shorter {
            let title = format!(
                "a disc of radius {radius:?} does not fit into a box of {width:?} x {height:?}"
            );
            let label =
                format!("the radius must be below half of the shorter side, {:?}", shorter / 2.0);
            table.refuse(&["radius", "width", "height"], &title, &label);
            return;
        }
        let discs = f64::from(self.discs.get());
        let fraction = discs * std::f64::consts::PI * radius * radius / (width * height);
        if self.placement == PackingPlacement::Random && fraction >= RANDOM_PLACEMENT_LIMIT {
            let title = format!(
                "the packing fraction n pi r^2 / (lx ly) is {fraction:.3}; random placement needs less than {RANDOM_PLACEMENT_LIMIT}"
            );
            table.refuse(
                &["discs", "width", "height", "radius", "placement"],
                &title,
                "fewer or smaller discs, a larger box, or placement = \"lattice\"",
            );
        }
    }
}

impl TomlValue for PackingPlacement {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let words = [("random", Self::Random), ("lattice", Self::Lattice)];
        super::read_placement(node, name, &words, Self::Given, GIVEN, errors)
    }

    fn write(&self) -> String {
        match self {
            Self::Random => "\"random\"".to_owned(),
            Self::Lattice => "\"lattice\"".to_owned(),
            Self::Given(state) => state.write(GIVEN),
        }
    }

    fn schema() -> Json {
        super::placement_schema(&["random", "lattice"], GIVEN)
    }
}

//! `[model.packing]`: event-driven hard discs. Lengths and times are dimensionless, a disc has mass 1.

use super::{GivenState, StartFrom};
use crate::diagnostics::Diagnostic;
use crate::keys::{Keys, Reader};
use crate::quantity::{BoxSide, NonNegative, Positive, Share};
use crate::tree::Node;
use crate::value::{TomlValue, words};
use serde_json::Value as Json;
use std::num::NonZeroU32;

/// All physics of a packing run. The box is centered on the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct PackingConfig {
    /// Number of discs n.
    pub discs: NonZeroU32,
    /// Width lx of the box.
    pub width: BoxSide,
    /// Height ly of the box.
    pub height: BoxSide,
    /// What is at the edges of the box.
    pub boundary: Boundary,
    /// Mean radius of the discs; the largest is below half of the shorter side.
    pub radius: Positive,
    /// Radii are uniform between 1 - this and 1 + this times the mean; 0 for equal discs.
    pub polydispersity: NonNegative,
    /// Coefficient of restitution alpha of a pair collision.
    pub restitution: Share,
    /// Which pair collisions are elastic all the same.
    pub collapse_guard: CollapseGuard,
    /// Variance of the angle by which a wall turns the outgoing direction, rad^2.
    pub wall_noise_variance_rad2: NonNegative,
    /// Law of the velocity components at the start.
    pub initial_velocities: InitialVelocities,
    /// When the run ends.
    pub length: RunLength,
    /// How discs are placed at the start.
    pub placement: PackingPlacement,
    /// For a compressed start: by how much diameters grow while a disc of the thermal speed flies as far.
    pub compression_rate: Positive,
    /// For a compressed start: it ends before the full radius where the pressure over the ideal one reaches this.
    pub compression_pressure: Option<Positive>,
}

/// What is at the edges of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Hard walls.
    Walls,
    /// The opposite edge.
    Periodic,
}

/// What keeps inelastic discs from infinitely many collisions in a finite time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CollapseGuard {
    /// Nothing: a collapse is noticed and ends the run.
    Off,
    /// The TC model: a collision is elastic where one of the two discs collided less than this time ago.
    ContactTime(Positive),
    /// A collision is elastic where the discs approach slower than this.
    CutoffVelocity(Positive),
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
    /// Random as small discs that grow to their radius while they move and collide (Lubachevsky and Stillinger).
    Compressed,
    /// Written out, with velocities.
    Given(GivenState),
    /// As the run of a recording ended.
    Recorded(StartFrom),
}

impl Default for PackingConfig {
    /// Fifty elastic discs in a box of 40 x 40 with the document's wall noise.
    fn default() -> Self {
        Self {
            discs: const { NonZeroU32::new(50).expect("not zero") },
            width: const { BoxSide::literal(40.0) },
            height: const { BoxSide::literal(40.0) },
            boundary: Boundary::Walls,
            radius: const { Positive::literal(1.0) },
            polydispersity: const { NonNegative::literal(0.0) },
            restitution: const { Share::literal(1.0) },
            collapse_guard: CollapseGuard::Off,
            wall_noise_variance_rad2: const { NonNegative::literal(std::f64::consts::PI / 1000.0) },
            initial_velocities: InitialVelocities::Unmodified,
            length: RunLength::EventsPerDisc(const { NonZeroU32::new(100).expect("not zero") }),
            placement: PackingPlacement::Random,
            compression_rate: const { Positive::literal(0.01) },
            compression_pressure: None,
        }
    }
}

words!(pub Boundary { Walls = "walls", Periodic = "periodic" });
words!(pub InitialVelocities { Unmodified = "unmodified", Modified = "modified" });

/// Names of the two lists of a given state: the model has no units.
const GIVEN: super::GivenNames =
    super::GivenNames { positions: "positions", velocities: "velocities" };

/// Packing fraction from which random placement is refused, by the input limits of the source document.
const RANDOM_PLACEMENT_LIMIT: f64 = 0.5;

/// A periodic box is so many of the largest diameters wide, so that no disc meets another one both ways round.
pub const PERIODIC_DIAMETERS: f64 = 3.1;

impl PackingConfig {
    /// Radius of the largest disc that there can be.
    #[must_use]
    pub fn largest_radius(&self) -> f64 {
        self.radius.get() * (1.0 + self.polydispersity.get())
    }

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
            "Width lx of the box, which is centered on the origin.",
            &mut self.width,
        );
        keys.key("height", "1", "Height ly of the box.", &mut self.height);
        keys.key(
            "boundary",
            "",
            "What is at the edges: hard walls, or the opposite edge (periodic).",
            &mut self.boundary,
        );
        keys.key(
            "radius",
            "1",
            "Mean radius r of the discs; the largest is below half of the shorter side.",
            &mut self.radius,
        );
        keys.key(
            "polydispersity",
            "1",
            "Radii are uniform within this share of the mean to both sides, below 1; 0 for equal discs. All have mass 1.",
            &mut self.polydispersity,
        );
        keys.key(
            "restitution",
            "1",
            "Coefficient of restitution alpha of a pair collision.",
            &mut self.restitution,
        );
        self.guard_keys(keys);
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
        self.length_keys(keys);
        super::start_keys(
            "placement",
            "How discs are placed at the start; random needs a packing fraction below 0.5, compressed reaches any.",
            &["placement", "start_from"],
            &mut self.placement,
            keys,
        );
        keys.key(
            "compression_rate",
            "1",
            "For placement = \"compressed\": growth of a diameter over the distance that a disc of thermal speed flies meanwhile.",
            &mut self.compression_rate,
        );
        self.compression_pressure = keys.optional(
            "compression_pressure",
            "1",
            "For placement = \"compressed\": growth ends where P A / (N kT) reaches this, if before the full radius.",
            self.compression_pressure,
        );
    }

    fn guard_keys(&mut self, keys: &mut impl Keys) {
        let (time, velocity) = match self.collapse_guard {
            CollapseGuard::Off => (None, None),
            CollapseGuard::ContactTime(time) => (Some(time), None),
            CollapseGuard::CutoffVelocity(velocity) => (None, Some(velocity)),
        };
        keys.exclusive(&["contact_time", "cutoff_velocity"]);
        if let Some(time) = keys.optional(
            "contact_time",
            "1",
            "Pairs collide elastically where one of the two collided less than this time ago (TC model).",
            time,
        ) {
            self.collapse_guard = CollapseGuard::ContactTime(time);
        }
        if let Some(velocity) = keys.optional(
            "cutoff_velocity",
            "1",
            "Pairs collide elastically where they approach slower than this, in place of `contact_time`.",
            velocity,
        ) {
            self.collapse_guard = CollapseGuard::CutoffVelocity(velocity);
        }
    }

    fn length_keys(&mut self, keys: &mut impl Keys) {
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
    }

    /// The rules between the keys.
    pub(crate) fn check(&mut self, table: &mut Reader<'_>) {
        match &self.placement {
            PackingPlacement::Given(state) => self.discs = state.count(table, "discs", self.discs),
            PackingPlacement::Recorded(start) => {
                self.discs = start.count(table, "discs", self.discs);
            }
            PackingPlacement::Random | PackingPlacement::Lattice | PackingPlacement::Compressed => {
            }
        }
        let (width, height) = (self.width.get(), self.height.get());
        let (radius, spread) = (self.radius.get(), self.polydispersity.get());
        if spread >= 1.0 {
            let title = format!("`polydispersity` is {spread:?}: the smallest disc has no radius");
            table.refuse(&["polydispersity"], &title, "must be in [0, 1)");
            return;
        }
        let largest = radius * (1.0 + spread);
        let shorter = if width < height { width } else { height };
        if 2.0 * largest >= shorter {
            let title = format!(
                "a disc of radius {largest:?} does not fit into a box of {width:?} x {height:?}"
            );
            let label =
                format!("the radius must be below half of the shorter side, {:?}", shorter / 2.0);
            table.refuse(&["radius", "polydispersity", "width", "height"], &title, &label);
            return;
        }
        if self.boundary == Boundary::Periodic && shorter < PERIODIC_DIAMETERS * 2.0 * largest {
            let title = format!(
                "a periodic box of {width:?} x {height:?} is too small for discs of radius {largest:?}"
            );
            let label = format!("both sides must be at least {PERIODIC_DIAMETERS} diameters");
            table.refuse(&["boundary", "radius", "width", "height"], &title, &label);
        }
        let discs = f64::from(self.discs.get());
        let mean_square = radius * radius * (1.0 + spread * spread / 3.0);
        let fraction = discs * std::f64::consts::PI * mean_square / (width * height);
        if self.placement == PackingPlacement::Random && fraction >= RANDOM_PLACEMENT_LIMIT {
            let title = format!(
                "the packing fraction n pi r^2 / (lx ly) is {fraction:.3}; random placement \
            needs less than {RANDOM_PLACEMENT_LIMIT}"
            );
            table.refuse(
                &["discs", "width", "height", "radius", "placement"],
                &title,
                "fewer or smaller discs, a larger box, or placement = \"lattice\" or \"compressed\"",
            );
        }
    }
}

impl TomlValue for PackingPlacement {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let words = [
            ("random", Self::Random),
            ("lattice", Self::Lattice),
            ("compressed", Self::Compressed),
        ];
        super::read_placement(node, name, &words, Self::Given, GIVEN, errors)
    }

    fn write(&self) -> String {
        match self {
            Self::Random => "\"random\"".to_owned(),
            Self::Lattice => "\"lattice\"".to_owned(),
            Self::Compressed => "\"compressed\"".to_owned(),
            Self::Given(state) => state.write(GIVEN),
            Self::Recorded(start) => start.write(),
        }
    }

    fn schema() -> Json {
        super::placement_schema(&["random", "lattice", "compressed"], GIVEN)
    }
}

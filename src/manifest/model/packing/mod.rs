//! `[model.packing]`: event-driven hard discs. Lengths and times are dimensionless, and a disc has mass 1.

mod floor;
mod gravity_rules;
mod obstacle_rules;
mod obstacles;

pub use floor::Shaking;
pub use obstacles::{MAX_OBSTACLES, PackingObstacles, drawn_obstacles};

use crate::inline::inline_table;
use crate::keys::{Reader, rules};
use crate::model::contract::{MIN_WIDTH_DIAMETERS, Model};
use crate::model::sizes::rounded_down;
use crate::model::start::{check_lengths, starts};
use crate::quantity::{BoxSide, Finite, Fraction, NonNegative, Positive};
use crate::table::{choice, table};
use crate::value::{count, words};
use std::num::NonZeroU32;

table! {
    /// All physics of a packing run. The box is centered on the origin. By default, fifty elastic discs in a box of 40 x 40
    /// with specular walls.
    pub struct PackingConfig {
        /// Number of discs n; with a given placement it follows from that.
        discs: NonZeroU32 ["1"] = count(50),
        /// Width lx of the box, which is centered on the origin.
        width: BoxSide ["1"] = BoxSide::literal(40.0),
        /// Height ly of the box.
        height: BoxSide ["1"] = BoxSide::literal(40.0),
        /// What is at the edges: hard walls, or the opposite edge (periodic).
        boundary: Boundary [""] = Boundary::Walls,
        /// Mean radius r of the discs; the largest is below half of the shorter side.
        radius: Positive ["1"] = Positive::literal(1.0),
        /// Radii are uniform within this fraction of the mean to both sides, below 1; 0 for equal discs. All have mass 1.
        radius_half_width: NonNegative ["1"] = NonNegative::literal(0.0),
        /// Coefficient of restitution alpha of a collision of two discs, or of a disc and an obstacle.
        restitution: Fraction ["1"] = Fraction::literal(1.0),
        /// Which pair collisions are elastic all the same.
        collapse_guard: CollapseGuard [group] = CollapseGuard::Off,
        /// Variance of the angle by which a wall turns the outgoing direction; 0 for specular walls, pi/1000 in the packing
        /// exercise.
        wall_noise_variance_rad2: NonNegative ["rad^2"] = NonNegative::literal(0.0),
        /// Velocity components are normal with variance 1 (unit-variance) or 1/n (variance-1-over-n).
        initial_velocities: InitialVelocities [""] = InitialVelocities::UnitVariance,
        /// Whether the mean of the drawn velocities is subtracted, so that the total momentum is zero. A periodic box, where the
        /// mean would be a drift that nothing ends, does so unless this is false.
        remove_mean_velocity: bool [""] = false,
        /// When the run ends.
        length: RunLength [group] = RunLength::EventsPerDisc(count(100)),
        /// How discs are placed at the start; random needs a packing fraction below 0.5, compressed reaches any.
        placement: PackingPlacement [start] = PackingPlacement::Random,
        /// For placement = "compressed": growth of a diameter over the distance that a disc of thermal speed flies meanwhile.
        compression_rate: Positive ["1"] = Positive::literal(0.01),
        /// For placement = "compressed": growth ends where P A / (N kT) reaches this, if before the full radius.
        target_reduced_pressure: Option<Positive> ["1", optional],
        /// Uniform gravity toward -y, in which discs fly on parabolas; 0 for none. Needs boundary = "walls".
        gravity: NonNegative ["1", sparse] = NonNegative::literal(0.0),
        /// Temperature kT/m of a floor that emits the discs that fall on it with the velocities of a gas; a floor that reflects
        /// them where it is left out. Needs `gravity`.
        floor_temperature: Option<Positive> ["1", optional],
        /// A floor that is shaken. Needs `gravity`.
        shaking: Option<Shaking> [group],
        /// Discs that never move, from which the others rebound: `{ positions = [[x, y], ...], radius = r }`.
        obstacles: Option<PackingObstacles> ["1", optional],
    }
}

words! {
    /// What is at the edges of the box.
    pub enum Boundary {
        /// Hard walls.
        Walls = "walls",
        /// The opposite edge.
        Periodic = "periodic",
    }
}

choice! {
    /// What keeps inelastic discs from infinitely many collisions in a finite time.
    pub enum CollapseGuard {
        /// Discs collide elastically where one of the two collided less than this time ago (TC model).
        contact_time: ContactTime(Positive) ["1"],
        /// Discs collide elastically where they approach slower than this, in place of `contact_time`.
        cutoff_velocity: CutoffVelocity(Positive) ["1"],
        |
        /// Nothing: a collapse is detected and ends the run.
        Off,
    }
}

words! {
    /// Distribution of the velocity components at the start.
    pub enum InitialVelocities {
        /// Normal, variance 1.
        UnitVariance = "unit-variance",
        /// Normal, variance 1/n.
        VarianceOneOverN = "variance-1-over-n",
    }
}

choice! {
    /// When a packing run ends.
    pub enum RunLength {
        /// The run ends after this many events per disc, pair and wall collisions alike.
        events_per_disc: EventsPerDisc(NonZeroU32) ["1"],
        /// The run ends after this simulated time, in place of `events_per_disc`.
        duration: Duration(Positive) ["1"],
    }
}

impl RunLength {
    const fn counts_events(self) -> bool {
        matches!(self, Self::EventsPerDisc(_))
    }
}

inline_table! {
    /// Positions and velocities written out in a manifest, one pair per disc; the model has no units.
    pub struct PackingState = "{ positions = ..., velocities = ... }" with PackingState::rules {
        /// Centers, `[x, y]` each.
        positions: Vec<[Finite; 2]> [nonempty],
        /// Velocities, `[vx, vy]` each; as many as positions.
        velocities: Vec<[Finite; 2]> [nonempty],
    }
}

impl PackingState {
    fn rules(&self, name: &str, reader: &mut Reader<'_>) {
        let lengths = [self.positions.len(), self.velocities.len()];
        check_lengths(name, reader, ["positions", "velocities"], lengths);
    }
}

starts! {
    /// How discs are placed at the start.
    pub enum PackingPlacement {
        /// Uniformly at random without overlap (packing fraction below 0.5).
        Random = "random",
        /// On a regular lattice.
        Lattice = "lattice",
        /// Random as small discs that grow to their radius while they move and collide (Lubachevsky and Stillinger).
        Compressed = "compressed",
        | PackingState with positions
    }
}

/// Packing fraction from which random placement is rejected, by the input limits of the packing exercise.
const RANDOM_PLACEMENT_LIMIT: f64 = 0.5;

/// Packing fraction of the densest arrangement of equal discs, pi/(2 sqrt 3) (A. Thue 1910).
const DENSEST: f64 = 0.906_899_682_117_089_3;

/// Minimum width of a periodic box in largest diameters, so that no disc meets another one across both sides: the engine needs
/// three cells per axis, each wider than a diameter.
pub const PERIODIC_DIAMETERS: f64 = 3.1;

impl PackingConfig {
    /// Radius of the largest disc that there can be.
    #[must_use]
    pub fn largest_radius(&self) -> f64 {
        self.radius.get() * (1.0 + self.radius_half_width.get())
    }
}

impl Model for PackingConfig {
    fn intervals(&self, sound: bool) -> &'static [&'static str] {
        match self.length {
            RunLength::EventsPerDisc(_) if sound => &["every_collisions"],
            _ => &["every_time", "every_collisions"],
        }
    }

    fn duration(&self) -> Option<f64> {
        match self.length {
            RunLength::EventsPerDisc(_) => None,
            RunLength::Duration(duration) => Some(duration.get()),
        }
    }

    fn particles(&self) -> u64 {
        u64::from(self.discs.get())
    }

    fn draws_random_numbers(&self) -> bool {
        // On a lattice, the velocities are drawn.
        let is_given =
            matches!(self.placement, PackingPlacement::Given(_) | PackingPlacement::Recorded(_));
        !is_given
            || self.radius_half_width.get() > 0.0
            || self.wall_noise_variance_rad2.get() > 0.0
            || self.floor_temperature.is_some()
    }

    fn with_particles(&self, discs: NonZeroU32) -> Option<Self> {
        let is_uniform = matches!(
            self.placement,
            PackingPlacement::Random | PackingPlacement::Lattice | PackingPlacement::Compressed
        );
        let scale = (f64::from(discs.get()) / f64::from(self.discs.get())).sqrt();
        let side = |side: BoxSide| BoxSide::new(scale * side.get());
        let (width, height) = (side(self.width)?, side(self.height)?);
        // With variance 1/n, speeds depend on the number of discs.
        let keeps_speeds = self.initial_velocities == InitialVelocities::UnitVariance;
        let least = MIN_WIDTH_DIAMETERS * 2.0 * self.largest_radius();
        let is_wide = width.get() >= least && height.get() >= least;
        let is_free = self.gravity.get() == 0.0 && self.obstacles.is_none();
        (is_uniform && keeps_speeds && is_wide && is_free).then(|| Self {
            discs,
            width,
            height,
            ..self.clone()
        })
    }

    fn check(&mut self, table: &mut Reader<'_>) {
        self.discs = self.placement.count(table, "discs", self.discs);
        let is_given = table.has("remove_mean_velocity")
            || matches!(self.placement, PackingPlacement::Given(_) | PackingPlacement::Recorded(_));
        self.remove_mean_velocity |= self.boundary == Boundary::Periodic && !is_given;
        let (width, height) = (self.width.get(), self.height.get());
        let (radius, spread) = (self.radius.get(), self.radius_half_width.get());
        let largest = radius * (1.0 + spread);
        let shorter = if width < height { width } else { height };
        let half = shorter / 2.0;
        rules! { table;
            spread >= 1.0 => ["radius_half_width"]
                "`radius_half_width` is {spread:?}; must be in [0, 1)", "the smallest disc would have no radius";
            spread < 1.0 && 2.0 * largest >= shorter => ["radius", "radius_half_width", "width", "height"]
                "a disc of radius {largest:?} does not fit into a box of {width:?} x {height:?}",
                "the radius must be below half of the shorter side, {half:?}";
        }
        if spread >= 1.0 || 2.0 * largest >= shorter {
            return;
        }
        self.check_gravity(table);
        self.check_obstacles(table);
        let least = PERIODIC_DIAMETERS * 2.0 * largest;
        let discs = f64::from(self.discs.get());
        let mean_square = radius * radius * (1.0 + spread * spread / 3.0);
        let fraction = discs * std::f64::consts::PI * mean_square / (width * height);
        // The largest number below the limit; the cast saturates.
        let most = (RANDOM_PLACEMENT_LIMIT * discs / fraction).ceil() as u64 - 1;
        let fewer =
            if most > 0 { format!("at most {most} discs of this radius, ") } else { String::new() };
        let smaller = rounded_down(radius * (RANDOM_PLACEMENT_LIMIT / fraction).sqrt());
        let others = if self.obstacles.is_some() {
            ""
        } else if fraction < DENSEST {
            ", or placement = \"lattice\" or \"compressed\""
        } else {
            "; no start has a packing fraction above 0.907"
        };
        rules! { table;
            self.boundary == Boundary::Periodic && shorter < least => ["boundary", "radius", "width", "height"]
                "a periodic box of {width:?} x {height:?} is too small for discs of radius {largest:?}",
                "both sides must be at least {least:?}, {PERIODIC_DIAMETERS} diameters";
            self.boundary == Boundary::Periodic && self.discs.get() == 1 && self.length.counts_events() && self.obstacles.is_none() =>
                ["discs", "boundary", "placement"]
                "one disc in a periodic box never collides, so a run with `events_per_disc` would not end",
                "two discs or more, or `duration` in place of `events_per_disc`";
            self.placement == PackingPlacement::Random && fraction >= RANDOM_PLACEMENT_LIMIT =>
                ["discs", "width", "height", "radius", "placement"]
                "the packing fraction n pi r^2 / (lx ly) is {fraction:.3}; random placement needs less than {RANDOM_PLACEMENT_LIMIT}",
                "{fewer}a radius of at most {smaller:?}, or a larger box{others}";
        }
    }
}

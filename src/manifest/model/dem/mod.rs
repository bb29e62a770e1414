//! `[model.dem]`: discs with spring–dashpot contacts in a box.

mod insertion;
mod materials;
mod radius;
mod rules;
mod walls;

pub use insertion::DemInsertion;
pub use materials::{DISC, DemContactConstants, DemContactPair, DemMaterial, WALL};
pub use radius::DiscRadius;
pub use walls::{DemWall, DemWallShape};

use crate::diagnostics::Errors;
use crate::keys::Reader;
use crate::model::contract::{MIN_WIDTH_DIAMETERS, Model, check_steps};
use crate::model::start::Placement;
use crate::quantity::{Finite, Fraction, NonNegative, PoissonRatio, Positive};
use crate::table::{choice, table};
use crate::tree::{Node, Value};
use crate::value::{TomlValue, count, quoted, refuse, words};
use serde_json::{Value as Json, json};
use std::num::NonZeroU32;

table! {
    /// All physics of a DEM run. The box is `[0, width] x [0, height]`. The defaults are the dem exercise's values where
    /// they can be integrated: e = 0.5 instead of eta = 1.5e3, and the listing's radius.
    pub struct DemConfig {
        /// Number of discs; with a given placement it follows from that.
        discs: NonZeroU32 ["1"] = count(20),
        /// Mass of a disc of the mean radius; the areal density is the same for all discs.
        mass_kg: Positive ["kg"] = Positive::literal(1e-3),
        /// Radius of the discs; or { min, max }: uniform between the two; or { mean, std }: normal, drawn again
        /// beyond three standard deviations; or { small, large, small_fraction }: two sizes. At most 1 : 10.
        radius_m: DiscRadius ["m"] = DiscRadius::Equal(Positive::literal(5e-4)),
        /// Width of the box [0, width] x [0, height].
        width_m: Positive ["m"] = Positive::literal(0.04),
        /// Height of the box.
        height_m: Positive ["m"] = Positive::literal(0.04),
        /// Acceleration of gravity, [x, y].
        gravity_m_per_s2: [Finite; 2] ["m/s^2"] = [Finite::literal(0.0), Finite::literal(-9.81)],
        /// The elastic force of a contact.
        elasticity: Elasticity [group] = Elasticity::Spring(Positive::literal(5e4)),
        /// Poisson's ratio of the material of `youngs_modulus_pa`; 0.3 without this key.
        poisson_ratio: Option<PoissonRatio> ["1", optional],
        /// The dashpot of a contact.
        dissipation: Dissipation [group] = Dissipation::Restitution(Fraction::literal(0.5)),
        /// Whether the normal force is limited to repulsion: true sets it to zero where the dashpot would pull the discs together at the
        /// end of a contact.
        limit_damping: bool [""] = false,
        /// Coefficient of friction mu: a contact slides where its tangential spring would pull harder than mu times the
        /// normal force.
        friction: NonNegative ["1"] = NonNegative::literal(0.0),
        /// Coefficient of rolling friction: a spring and slider against the relative spin, its lever the reduced radius.
        rolling_friction: NonNegative ["1"] = NonNegative::literal(0.0),
        /// Cohesion F_c: a constant attraction of two surfaces in contact, of discs and of walls. The normal force is f - F_c, and the
        /// contact slides at mu f, with the force f that it would have without cohesion. Needs an explicit dashpot.
        cohesion_n: NonNegative ["N", sparse] = NonNegative::literal(0.0),
        /// The stiffness of the tangential springs.
        tangential_stiffness: TangentialStiffness [group] = TangentialStiffness::Ratio(Positive::literal(2.0 / 7.0)),
        /// Damping of the tangential spring over that of the normal one, while the contact sticks.
        tangential_to_normal_damping: NonNegative ["1"] = NonNegative::literal(0.5),
        /// What the discs are made of, drawn by fraction: { name, fraction, density_ratio, restitution, friction,
        /// rolling_friction, stiffness_ratio, cohesion_n }; what is left out is as for all. stiffness_ratio is the stiffness, or Young's
        /// modulus, over that of the manifest, which walls have.
        materials: Vec<DemMaterial> ["", sparse] = Vec::new(),
        /// Constants of contacts between two materials ("disc" where none is named), or of one with a "wall":
        /// { between, restitution, friction, rolling_friction, stiffness_ratio, cohesion_n }. Others follow: the smaller friction of
        /// the two, the stiffness k = 2 k_i k_j/(k_i + k_j), e^2 = (e_i^2 k_j + e_j^2 k_i)/(k_i + k_j), and the geometric mean of the cohesions.
        contact_pairs: Vec<DemContactPair> ["", sparse] = Vec::new(),
        /// Directions in which the box is periodic and has no walls.
        periodic: PeriodicSides [""] = PeriodicSides::None,
        /// Walls in addition to the box's: { from_m, to_m } or { center_m, radius_m, spin_rad_per_s } (a drum, discs inside),
        /// each with velocity_m_per_s, amplitude_m, frequency_hz: displacement u t + A sin(2 pi f t), the clock t running
        /// within moves_s = [from, to] only, where it is given.
        walls: Vec<DemWall> [""] = Vec::new(),
        /// Discs whose center sinks below this height are removed.
        remove_below_m: Option<Finite> ["m", optional],
        /// The part of the box that discs are placed in, [[x, y], [x, y]]: lower left and upper right corner.
        placement_region_m: Option<[[Finite; 2]; 2]> ["m", optional],
        /// Discs that fall in during the run: { discs, discs_per_s, from_m, to_m, velocity_m_per_s, starts_s }: one after
        /// the other, at random on the line between the two points, later where there is no room.
        insertion: Option<DemInsertion> ["", optional],
        /// Standard deviation of each component of normal velocities at the start, with no mean; without it, discs that
        /// are not given are at rest.
        velocity_std_m_per_s: Option<Positive> ["m/s", optional],
        /// How the equation of motion is discretized. Both are the same map of positions and half-step velocities. velocity-verlet
        /// begins half a kick before the requested velocity, so that the first recorded velocity is the requested one;
        /// semi-implicit-euler takes the requested velocity as that of half a step before, as the DEM exercise does.
        integrator: DemIntegrator [""] = DemIntegrator::VelocityVerlet,
        /// How the dashpots are discretized: explicit, with the velocities before the step; or implicit, with those after it, solved for
        /// all contacts together (projected Gauss-Seidel) and stable for any damping. Implicit dashpots support
        /// neither friction nor moving walls.
        dashpot: DemDashpot [""] = DemDashpot::Explicit,
        /// The time step, per contact or in seconds.
        time_step: TimeStep [group] = TimeStep::PerContact(Positive::literal(20.0)),
        /// What an unstable time step leads to: the run is rejected (error), or continues with a warning (warn).
        on_unstable_time_step: UnstableTimeStep [""] = UnstableTimeStep::Error,
        /// How discs are placed at the start; given velocities count, all others are at rest.
        placement: Placement [start] = Placement::Random,
        /// Simulated time.
        duration_s: Positive ["s"] = Positive::literal(1.0),
    }
}

words! {
    /// Directions in which the box is periodic.
    pub enum PeriodicSides {
        /// Four walls.
        None = "none",
        /// The left and right sides are identified.
        X = "x",
        /// The floor and the ceiling are identified.
        Y = "y",
        /// No walls.
        Both = "both",
    }
}

impl PeriodicSides {
    /// Whether the box is periodic in x, and in y.
    #[must_use]
    pub fn axes(self) -> [bool; 2] {
        match self {
            Self::None => [false, false],
            Self::X => [true, false],
            Self::Y => [false, true],
            Self::Both => [true, true],
        }
    }
}

choice! {
    /// The elastic force of a contact.
    pub enum Elasticity {
        /// Stiffness k of the contact spring.
        stiffness_n_per_m: Spring(Positive) ["N/m"],
        /// Young's modulus E of spheres that touch by Hertz's law, in place of `stiffness_n_per_m`. The force is 4/3 E* sqrt(R d) d at
        /// the overlap d, with 1/R the sum of 1/r and E* = E/(2 (1 - nu^2)); walls are of the same material. The stiffness k of
        /// other keys is then that at the largest expected overlap.
        youngs_modulus_pa: Hertz(Positive) ["Pa"],
    }
}

choice! {
    /// The stiffness of the tangential springs.
    pub enum TangentialStiffness {
        /// Stiffness of the tangential and rolling springs over that of the normal one.
        tangential_to_normal_stiffness: Ratio(Positive) ["1"],
        /// In place of `tangential_to_normal_stiffness`, with `youngs_modulus_pa`: "mindlin" for tangential springs whose stiffness
        /// increases with the circle of contact, k_t = 2 (1 - nu)/(2 - nu) 2 E* sqrt(R d). Rolling springs have the one at the largest
        /// expected overlap.
        tangential_law: Law(TangentialLaw) [""],
    }
}

words! {
    /// Laws of the tangential springs of spheres.
    pub enum TangentialLaw {
        /// Mindlin's stiffness without partial slip. As the contact unloads, the force decreases in proportion to the stiffness.
        Mindlin = "mindlin",
    }
}

choice! {
    /// The dashpot of a contact.
    pub enum Dissipation {
        /// Coefficient of restitution e wanted; the damping follows for each pair from its effective mass.
        restitution: Restitution(Fraction) ["1"],
        /// Damping eta itself, the same for every contact, in place of `restitution`.
        damping_n_s_per_m: Damping(NonNegative) ["N s/m"],
    }
}

words! {
    /// Time-stepping scheme of the DEM.
    pub enum DemIntegrator {
        /// The dem exercise's equation (3).
        SemiImplicitEuler = "semi-implicit-euler",
        /// Half kick, drift, half kick.
        VelocityVerlet = "velocity-verlet",
    }
}

words! {
    /// Velocities that the dashpots of the DEM use.
    pub enum DemDashpot {
        /// Those before the step: stable if eta dt/m_eff is below 1.
        Explicit = "explicit",
        /// Those after the step, solved for all contacts together (projected Gauss–Seidel): stable for any damping.
        Implicit = "implicit",
    }
}

words! {
    /// What a time step beyond the stability bounds leads to.
    pub enum UnstableTimeStep {
        /// The run is rejected before its first step.
        Error = "error",
        /// The run continues, with a warning in its log.
        Warn = "warn",
    }
}

choice! {
    /// The time step of the DEM.
    pub enum TimeStep {
        /// N_t of dt = pi sqrt(m/k) / N_t, m the smallest disc's mass.
        steps_per_wall_contact: PerContact(Positive) ["1"],
        /// Time step, in place of `steps_per_wall_contact`; or automatic: the longest that the stability bounds allow with a
        /// margin.
        time_step_s: Length(StepLength) ["s"],
    }
}

/// A time step, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepLength {
    /// This one.
    Fixed(Positive),
    /// The longest that the stability bounds allow with a margin.
    Automatic,
}

/// The word for [`StepLength::Automatic`].
const AUTOMATIC: &str = "automatic";

impl TomlValue for StepLength {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
        match &node.value {
            Value::Text(text) if text == AUTOMATIC => Some(Self::Automatic),
            Value::Text(_) => refuse(node, name, "a number > 0 or \"automatic\"", errors),
            _ => Positive::read(node, name, errors).map(Self::Fixed),
        }
    }

    fn write(&self) -> String {
        match self {
            Self::Fixed(step) => step.write(),
            Self::Automatic => quoted(AUTOMATIC),
        }
    }

    fn schema() -> Json {
        json!({ "anyOf": [Positive::schema(), { "enum": [AUTOMATIC] }] })
    }
}

/// Poisson's ratio of a material for which none is given.
const POISSON_RATIO: PoissonRatio = PoissonRatio::literal(0.3);

impl DemConfig {
    /// E* = E/(2 (1 - nu^2)) of Hertz's law, Pa, by Young's modulus E.
    #[must_use]
    pub fn effective_modulus_pa(&self, youngs_modulus: Positive) -> f64 {
        let ratio = self.poisson_ratio.unwrap_or(POISSON_RATIO).get();
        youngs_modulus.get() / (2.0 * (1.0 - ratio * ratio))
    }

    /// Whether the tangential springs are Mindlin's.
    #[must_use]
    pub fn has_mindlin_springs(&self) -> bool {
        matches!(self.tangential_stiffness, TangentialStiffness::Law(TangentialLaw::Mindlin))
    }

    /// Stiffness of the tangential springs over that of the normal one; 8 G* a over 2 E* a by Mindlin's law, with G* = G/(2 (2 - nu)) and
    /// E = 2 (1 + nu) G of both sides (Mindlin, J. Appl. Mech. 16 (1949) 259).
    #[must_use]
    pub fn tangential_to_normal_stiffness(&self) -> f64 {
        match self.tangential_stiffness {
            TangentialStiffness::Ratio(ratio) => ratio.get(),
            TangentialStiffness::Law(TangentialLaw::Mindlin) => {
                let ratio = self.poisson_ratio.unwrap_or(POISSON_RATIO).get();
                2.0 * (1.0 - ratio) / (2.0 - ratio)
            }
        }
    }
}

impl Model for DemConfig {
    fn intervals(&self, _sound: bool) -> &'static [&'static str] {
        &["every_s", "every_steps"]
    }

    fn duration(&self) -> Option<f64> {
        Some(self.duration_s.get())
    }

    fn particles(&self) -> u64 {
        let inserted = self.insertion.map_or(0, |insertion| insertion.discs.get());
        u64::from(self.discs.get()) + u64::from(inserted)
    }

    fn draws_random_numbers(&self) -> bool {
        let draws_start = match &self.placement {
            Placement::Random => true,
            Placement::Lattice => self.velocity_std_m_per_s.is_some(),
            Placement::Given(_) | Placement::Recorded(_) => false,
        };
        draws_start
            || !matches!(self.radius_m, DiscRadius::Equal(_))
            || self.materials.len() > 1
            || self.insertion.is_some()
    }

    fn with_particles(&self, discs: NonZeroU32) -> Option<Self> {
        let is_uniform = matches!(self.placement, Placement::Random | Placement::Lattice)
            && self.placement_region_m.is_none()
            && self.walls.is_empty()
            && self.insertion.is_none()
            && self.remove_below_m.is_none();
        // A bed of the same depth, because its weight and the height of a fall decide whether a run is rejected.
        let across = match self.gravity_m_per_s2.map(|g| g.get() != 0.0) {
            [false, _] => 0,
            [true, false] => 1,
            [true, true] => return None,
        };
        let mut sides = [self.width_m, self.height_m];
        let fraction = f64::from(discs.get()) / f64::from(self.discs.get());
        sides[across] = Positive::new(fraction * sides[across].get())?;
        let is_wide = sides[across].get() >= MIN_WIDTH_DIAMETERS * 2.0 * self.radius_m.range().1;
        let [width_m, height_m] = sides;
        (is_uniform && is_wide).then(|| Self { discs, width_m, height_m, ..self.clone() })
    }

    fn check(&mut self, table: &mut Reader<'_>) {
        self.discs = self.placement.count(table, "discs", self.discs);
        self.check_sizes(table);
        self.check_scene(table);
        let step = match self.time_step {
            TimeStep::Length(StepLength::Fixed(step)) => Some(step),
            _ => None,
        };
        check_steps(self.duration_s, step, table, &["time_step_s", "duration_s"]);
    }
}

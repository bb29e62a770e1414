//! The constants of a run and of a step, derived from the manifest once.

use super::expected_load;
use super::laws::Law;
use super::materials::{ContactLaw, Materials};
use super::neighbors::tiers::Scope;
use super::walls::{Motion, PlacedWall, Shape, Wall};
use crate::simd::registers::MAX_WIDTH;
use kinetoscope_manifest::model::{
    DemConfig, DemDashpot, DemIntegrator, DemWall, DemWallShape, StepLength, TimeStep,
};
use serde::{Deserialize, Serialize};

/// The constants of a run. SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Parameters {
    /// The box is `[0, sides[0]] x [0, sides[1]]`.
    pub(super) sides: [f64; 2],
    /// Acceleration of gravity g.
    pub(super) gravity: [f64; 2],
    /// The force law.
    pub(super) law: ContactLaw,
    /// Time step dt.
    pub(super) time_step: f64,
    /// Steps of the whole run.
    pub(super) total_steps: u64,
    /// Mean radius, that of a disc of `mass`.
    pub(super) radius: f64,
    /// Mass of a disc of the mean radius.
    pub(super) mass: f64,
    /// Mass of the smallest disc that the manifest allows: with drawn radii, the same time step in all replicates.
    pub(super) smallest_mass: f64,
    /// Smallest and largest radius that the manifest allows.
    pub(super) radius_range: (f64, f64),
    /// Directions in which the box has no walls.
    pub(super) periodic: [bool; 2],
    /// The walls of the box (left, right, floor, ceiling, unless periodic), then those of the manifest.
    pub(super) walls: Vec<Wall>,
    /// Height below which discs are removed.
    pub(super) outlet_below: Option<f64>,
    /// Whether frames contain the force of every contact and the sum of the forces on every disc.
    pub(super) records_forces: bool,
    /// Numbers in the widest register that may be used; results have the same bits at every width.
    #[serde(skip, default = "max_width")]
    pub(super) max_width: usize,
}

fn max_width() -> usize {
    MAX_WIDTH
}

/// The constants of a step, besides discs and lists.
#[derive(Clone, Copy)]
pub(super) struct StepContext<'a> {
    pub(super) parameters: &'a Parameters,
    pub(super) walls: &'a [PlacedWall],
    /// The largest overlap over radius that is known already.
    pub(super) known_overlap: f64,
    /// Time since the discs began to move, but at most a time step, s: before the first step, no pair was in contact.
    pub(super) time_before: f64,
    /// The part of the lists that the step must visit.
    pub(super) scope: Scope,
}

/// An automatic time step: pi sqrt(m/k) over this number, with c = eta dt/m_eff of at most the second value.
const AUTOMATIC_STEPS_PER_CONTACT: f64 = 20.0;
const AUTOMATIC_DAMPING_STEP: f64 = 0.2;

impl Parameters {
    pub(super) fn new(config: &DemConfig) -> Self {
        let radius_range = config.radius_m.range();
        let radius = config.radius_m.mean();
        let mass = config.mass_kg.get();
        let materials = Materials::new(config);
        let load = |weight| materials.scaled_load(weight);
        let normal = Law::of(config, materials.stiffness_range().0, load);
        let law = ContactLaw {
            normal,
            materials,
            only_pushes: config.limit_damping,
            is_implicit: config.dashpot == DemDashpot::Implicit,
            tangential_stiffness: normal.stiffness() * config.tangential_to_normal_stiffness(),
            tangential_to_normal_damping: config.tangential_to_normal_damping.get(),
        };
        let smallest_mass = law.materials.density_range().0 * mass_of(radius_range.0, radius, mass);
        let per_contact = |steps: f64| law.contact_time(smallest_mass) / steps;
        let time_step = match config.time_step {
            TimeStep::PerContact(steps) => per_contact(steps.get()),
            TimeStep::Length(StepLength::Fixed(step)) => step.get(),
            TimeStep::Length(StepLength::Automatic) => {
                let pair_mass = 0.5 * smallest_mass;
                let strongest = law.materials.strongest_dashpot();
                let damping = normal.largest_damping(strongest.damping(normal, pair_mass));
                let by_dashpot = AUTOMATIC_DAMPING_STEP * pair_mass / damping;
                let by_spring = per_contact(AUTOMATIC_STEPS_PER_CONTACT);
                if by_dashpot < by_spring { by_dashpot } else { by_spring }
            }
        };
        let sides = [config.width_m.get(), config.height_m.get()];
        let periodic = config.periodic.axes();
        let mut walls = box_walls(sides, periodic);
        walls.extend(config.walls.iter().map(wall));
        Self {
            sides,
            gravity: [config.gravity_m_per_s2[0].get(), config.gravity_m_per_s2[1].get()],
            law,
            time_step,
            total_steps: (config.duration_s.get() / time_step + 1e-9).floor() as u64,
            radius,
            mass,
            smallest_mass,
            radius_range,
            periodic,
            walls,
            outlet_below: config.remove_below_m.map(|height| height.get()),
            records_forces: false,
            max_width: MAX_WIDTH,
        }
    }

    /// Effective mass of the lightest pair: two discs of the smallest mass.
    pub(super) fn lightest_pair_mass(&self) -> f64 {
        0.5 * self.smallest_mass
    }

    /// Largest expected eta of the lightest pair with the strongest dashpot, N s/m.
    pub(super) fn strongest_damping(&self) -> f64 {
        let pair = self.law.materials.strongest_dashpot();
        let law = self.law.normal;
        law.largest_damping(pair.damping(law, self.lightest_pair_mass()))
    }

    /// Damping ratio of the weakest dashpot at an effective mass.
    pub(super) fn weakest_damping_ratio(&self, effective_mass: f64) -> f64 {
        let pairs = self.law.materials.all().iter();
        let ratios = pairs.map(|pair| pair.damping_ratio(self.law.normal, effective_mass));
        ratios.fold(f64::INFINITY, |least, ratio| if ratio < least { ratio } else { least })
    }

    /// Damping ratio of the strongest dashpot at an effective mass.
    pub(super) fn strongest_damping_ratio(&self, effective_mass: f64) -> f64 {
        let pair = self.law.materials.strongest_dashpot();
        pair.damping_ratio(self.law.normal, effective_mass)
    }

    /// Whether a center is inside the box. Discs may be beyond a periodic side until they are wrapped when the lists are
    /// built. A position that is not a number is outside.
    pub(super) fn is_inside(&self, center: [f64; 2]) -> bool {
        [0, 1].into_iter().all(|axis: usize| {
            let (at, side) = (center[axis], self.sides[axis]);
            if self.periodic[axis] { at.is_finite() } else { at >= 0.0 && at <= side }
        })
    }

    /// Vector from the second point to the first, across a periodic side if that is shorter, m.
    pub(super) fn separation(&self, one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis: usize| {
            let apart = one[axis] - other[axis];
            let side = self.sides[axis];
            if self.periodic[axis] { apart - side * libm::round(apart / side) } else { apart }
        })
    }

    /// The walls after `count` steps.
    pub(super) fn walls_at(&self, count: u64) -> Vec<PlacedWall> {
        self.walls.iter().map(|wall| wall.placed(count, self.time_step)).collect()
    }

    /// Displacements of the walls after `count` steps, m.
    pub(super) fn displacements_at(&self, count: u64) -> Vec<[f64; 2]> {
        let time = count as f64 * self.time_step;
        self.walls.iter().map(|wall| wall.motion.displacement(time)).collect()
    }

    /// Weight of a column of discs, N; see `expected_load`.
    pub(super) fn column_weight(&self, mass: f64, others: f64) -> f64 {
        expected_load::column_weight(mass, others, self.radius, self.sides, self.gravity)
    }

    /// Mass of a disc: discs of one material have one areal density.
    pub(super) fn mass_of(&self, radius: f64, material: u8) -> f64 {
        self.law.materials.density_ratio(material) * mass_of(radius, self.radius, self.mass)
    }

    /// The integrator's velocity of a disc without contacts, by that at the positions' time: v - g dt/2 with velocity Verlet, whose
    /// velocities are half a step behind; see `step`.
    pub(super) fn integrator_velocity(&self, config: &DemConfig, velocity: [f64; 2]) -> [f64; 2] {
        let half = 0.5 * self.time_step;
        match config.integrator {
            DemIntegrator::VelocityVerlet => {
                [velocity[0] - self.gravity[0] * half, velocity[1] - self.gravity[1] * half]
            }
            DemIntegrator::SemiImplicitEuler => velocity,
        }
    }

    /// Specific potential energy of a fall through the whole box, J/kg.
    pub(super) fn max_fall(&self) -> f64 {
        self.gravity[0].abs() * self.sides[0] + self.gravity[1].abs() * self.sides[1]
    }
}

/// The planes of the box in directions that are not periodic.
fn box_walls(sides: [f64; 2], periodic: [bool; 2]) -> Vec<Wall> {
    let plane = |point, normal| Wall::at_rest(Shape::Plane { point, normal });
    let mut walls = Vec::new();
    if !periodic[0] {
        walls.push(plane([0.0, 0.0], [1.0, 0.0]));
        walls.push(plane([sides[0], 0.0], [-1.0, 0.0]));
    }
    if !periodic[1] {
        walls.push(plane([0.0, 0.0], [0.0, 1.0]));
        walls.push(plane([0.0, sides[1]], [0.0, -1.0]));
    }
    walls
}

fn wall(config: &DemWall) -> Wall {
    let pair =
        |values: [kinetoscope_manifest::quantity::Finite; 2]| values.map(|value| value.get());
    let (shape, spin) = match config.shape {
        DemWallShape::Segment { from_m, to_m } => {
            (Shape::Segment { from: pair(from_m), to: pair(to_m) }, 0.0)
        }
        DemWallShape::Drum { center_m, radius_m, spin_rad_per_s } => {
            (Shape::Drum { center: pair(center_m), radius: radius_m.get() }, spin_rad_per_s.get())
        }
    };
    let motion = Motion {
        velocity: pair(config.velocity_m_per_s),
        amplitude: pair(config.amplitude_m),
        frequency: config.frequency_hz.get(),
        moves: config.moves_s.map(|moves| moves.map(|time| time.get())),
        spin,
    };
    Wall { shape, motion }
}

/// Mass of a disc at the areal density at which a disc of the mean radius has the mean mass.
fn mass_of(radius: f64, mean_radius: f64, mean_mass: f64) -> f64 {
    let ratio = radius / mean_radius;
    mean_mass * ratio * ratio
}

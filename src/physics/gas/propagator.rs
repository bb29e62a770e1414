//! How particles are moved: one of five ways, chosen by the manifest.

use super::collisions::Discs;
use super::exact::ExactClock;
use super::groups::{LANES, Particles};
use super::hit_by_hit::{Course, Thermal, WallLaw};
use super::motion::{Circle, Particle};
use super::pressure::speed_at;
use super::wall::Tally;
use super::{Container, STEP_ROUNDING, Substance};
use crate::model::{SetupError, Target};
use crate::random::Seed;
use kinetoscope_manifest::model::{GasConfig, Propagation};
use serde::{Deserialize, Serialize};

/// How particles are moved, and how far they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Propagator {
    /// Closed form, any time.
    Exact(ExactClock),
    /// Closed form from hit to hit, any time.
    HitByHit { duration_s: f64, time_s: f64, law: WallLaw, courses: Vec<Course> },
    /// Discs that collide, from event to event, any time.
    Colliding { duration_s: f64, discs: Discs },
    /// The document's steps, mended.
    Stepped {
        clock: StepClock,
        /// One a particle, and one for each empty lane.
        tallies: Vec<Tally>,
    },
    /// The document's steps as printed.
    Literal {
        clock: StepClock,
        tallies: Vec<Tally>,
        /// Particles that a 0/0 lost: they stay as they last were.
        frozen: Vec<bool>,
    },
}

/// Steps of one length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct StepClock {
    pub(super) time_step_s: f64,
    pub(super) total: u64,
    pub(super) done: u64,
}

impl StepClock {
    pub(super) fn new(duration_s: f64, time_step_s: f64) -> Self {
        let total = (duration_s / time_step_s + STEP_ROUNDING) as u64;
        Self { time_step_s, total, done: 0 }
    }

    /// Time after the steps done, s: a product, never a sum.
    pub(super) fn time_s(&self) -> f64 {
        self.done as f64 * self.time_step_s
    }

    /// The count that a target stands for; a time between two steps is the earlier one.
    pub(super) fn count_of(&self, target: Target) -> u64 {
        match target {
            Target::Count(count) => count,
            Target::Time(time) => (time / self.time_step_s + STEP_ROUNDING) as u64,
        }
    }
}

impl WallLaw {
    fn of(config: &GasConfig, seed: Seed, substance: &Substance, circle: Circle) -> Self {
        Self {
            circle,
            thermal: config.thermal_wall.map(|wall| Thermal {
                // k_B T = m s^2 for one component, 2 k_B T = m v^2 for both.
                thermal_speed: speed_at(
                    wall.temperature_k.get(),
                    substance.mass_kg,
                    substance.boltzmann_j_per_k,
                ) / std::f64::consts::SQRT_2,
                accommodation: wall.accommodation.get(),
                seed,
            }),
            half_opening: config.opening_width_m.map(|width| width.get() / circle.radius / 2.0),
        }
    }
}

impl Propagator {
    pub(super) fn of(
        config: &GasConfig,
        seed: Seed,
        particles: &Particles,
        substance: &Substance,
        container: Container,
    ) -> Result<Self, SetupError> {
        let duration_s = config.duration_s.get();
        let tallies = || {
            let mut tallies = vec![Tally::default(); particles.groups.len() * LANES];
            for (tally, particle) in tallies.iter_mut().zip(particles.iter()) {
                tally.begin(particle);
            }
            tallies
        };
        Ok(match (config.propagation, config.disc_radius_m) {
            (Propagation::Exact, Some(disc_radius)) => {
                let list: Vec<Particle> = particles.iter().collect();
                let radius = container.circle.radius;
                let discs = Discs::new(&list, &substance.mass_ratios, radius, disc_radius.get())?;
                Self::Colliding { duration_s, discs }
            }
            (Propagation::Exact, None)
                if config.thermal_wall.is_some() || config.opening_width_m.is_some() =>
            {
                let law = WallLaw::of(config, seed, substance, container.circle);
                let ratios = substance.mass_ratios.iter();
                let begun = particles
                    .iter()
                    .zip(ratios)
                    .map(|(particle, ratio)| law.begin(particle, 0.0, *ratio));
                Self::HitByHit { duration_s, time_s: 0.0, law, courses: begun.collect() }
            }
            (Propagation::Exact, None) => Self::Exact(ExactClock::new(
                duration_s,
                particles,
                &substance.mass_ratios,
                container.circle,
            )),
            (Propagation::Stepped { time_step_s }, _) => Self::Stepped {
                clock: StepClock::new(duration_s, time_step_s.get()),
                tallies: tallies(),
            },
            (Propagation::Literal { time_step_s }, _) => Self::Literal {
                clock: StepClock::new(duration_s, time_step_s.get()),
                tallies: tallies(),
                frozen: vec![false; particles.len()],
            },
        })
    }
}

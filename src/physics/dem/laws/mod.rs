//! The laws of the normal force of a contact. Adding one takes a file that implements [`NormalLaw`] and a line in the list.
//!
//! A law decides the elastic force, its potential energy, the dashpot, the stiffness that limits the time step, and the closed forms of
//! an impact. Friction, the clamp of the force at zero, the loops over contacts and the energy balance are the same for every law. The kernel is compiled
//! once per law, so that no contact costs a decision.

mod hertz;
mod linear_spring;
mod normal_law;

use super::expected_load::ExpectedLoad;
use super::motion;
use hertz::{Hertz, Mindlin};
use kinetoscope_manifest::model::{DemConfig, Elasticity};
use linear_spring::LinearSpring;
pub(crate) use normal_law::{Impact, NormalLaw};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

// `$` is an argument, because the macro that is defined within has arguments of its own.
macro_rules! laws {
    ($dollar:tt $($(#[$attribute:meta])* $law:ident),+ $(,)?) => {
        /// The law of a run.
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        pub(crate) enum Law {
            $($(#[$attribute])* $law($law)),+
        }

        /// Evaluates an expression with the law of a run, compiled for each type of law.
        macro_rules! with_law {
            ($dollar law:expr, $dollar name:ident => $dollar body:expr) => {
                match $dollar law {
                    $($(#[$attribute])* $crate::dem::laws::Law::$law($dollar name) => $dollar body),+
                }
            };
        }
    };
}

laws! { $
    LinearSpring,
    Hertz,
    Mindlin,
}
pub(crate) use with_law;

/// Least overlap over the radius for which the time step of Hertz's law is chosen: discs without gravity and velocities touch as well.
/// The stiffness increases with the root of the overlap; therefore, contacts of a hundredth of it last three times as long.
const LEAST_OVERLAP: f64 = 0.01;

impl Law {
    /// The law that the manifest requests, for materials with this smallest ratio of stiffness and the load by the weight.
    pub(super) fn of(config: &DemConfig, softest: f64, load: impl Fn(f64) -> f64) -> Self {
        match config.elasticity {
            Elasticity::Spring(stiffness) => {
                Self::LinearSpring(LinearSpring { stiffness: stiffness.get() })
            }
            Elasticity::Hertz(modulus) => {
                let ExpectedLoad { mass, speed, weight } = ExpectedLoad::of(config);
                let radius = config.radius_m.range().1;
                let ratio = radius / config.radius_m.mean();
                // As `ContactLaw::expected_overlap`.
                let mass = mass * ratio * ratio / softest;
                let hardest = Impact { speed, mass, radius, damping_ratio: 0.0 };
                let modulus = config.effective_modulus_pa(modulus);
                let (load, least) = (load(weight), LEAST_OVERLAP * radius);
                if config.has_mindlin_springs() {
                    return Self::Mindlin(Mindlin::new(modulus, &hardest, load, least));
                }
                Self::Hertz(Hertz::new(modulus, &hardest, load, least))
            }
        }
    }

    /// Elastic force, N; `radius` is R in m.
    pub(super) fn elastic_force(self, overlap: f64, radius: f64) -> f64 {
        fn of<L: NormalLaw>(law: L, overlap: f64, radius: f64) -> f64 {
            let circle = motion::circle_of_contact(radius, overlap);
            L::elastic_force(&law.constants(overlap), overlap, circle)
        }
        with_law!(self, law => of(law, overlap, radius))
    }

    /// Damping of a contact by that of its pair, N s/m, the overlap and the circle of contact, m.
    pub(super) fn damping(self, of_pair: f64, [overlap, circle]: [f64; 2]) -> f64 {
        fn of<L: NormalLaw>(law: L, of_pair: f64, overlap: f64, circle: f64) -> f64 {
            L::damping(&law.constants(overlap), of_pair, overlap, circle)
        }
        with_law!(self, law => of(law, of_pair, overlap, circle))
    }

    /// Largest damping of a contact that is expected, by that of its pair, N s/m.
    pub(super) fn largest_damping(self, of_pair: f64) -> f64 {
        self.damping(of_pair, self.largest())
    }

    /// The overlap and the circle of contact, m, at which the stiffness is the largest; see [`NormalLaw::largest`].
    pub(super) fn largest(self) -> [f64; 2] {
        with_law!(self, law => law.largest())
    }

    /// Potential energy of a contact, J; `radius` is R in m.
    pub(super) fn potential_energy(self, overlap: f64, radius: f64) -> f64 {
        let circle = motion::circle_of_contact(radius, overlap);
        with_law!(self, law => law.potential_energy(overlap, circle))
    }

    /// The key of the manifest that makes contacts stiffer.
    pub(super) fn key(self) -> &'static str {
        fn of<L: NormalLaw>(_: L) -> &'static str {
            L::KEY
        }
        with_law!(self, law => of(law))
    }

    /// Largest stiffness k, N/m.
    pub(super) fn stiffness(self) -> f64 {
        with_law!(self, law => law.stiffness())
    }

    /// The stiffness of a pair's damping; see [`NormalLaw::dashpot_stiffness`].
    pub(super) fn dashpot_stiffness(self) -> f64 {
        with_law!(self, law => law.dashpot_stiffness())
    }

    /// Largest overlap of an impact, m.
    pub(super) fn impact_overlap(self, impact: &Impact) -> f64 {
        with_law!(self, law => law.impact_overlap(impact))
    }

    /// Overlap under a load, m; `radius` is R in m.
    pub(super) fn overlap_under(self, force: f64, radius: f64) -> f64 {
        with_law!(self, law => law.overlap_under(force, radius))
    }

    /// Duration of a contact, s; see [`NormalLaw::contact_duration`].
    pub(super) fn contact_duration(self, mass: f64, damping_ratio: f64, tail: bool) -> Option<f64> {
        with_law!(self, law => law.contact_duration(mass, damping_ratio, tail))
    }

    /// The time pi sqrt(m/k), s, that a contact without a dashpot lasts on a linear spring; m is the effective mass.
    pub(super) fn contact_time(self, mass: f64) -> f64 {
        PI * (mass / self.stiffness()).sqrt()
    }

    /// Force of an impact without a dashpot, v sqrt(k m), N.
    pub(super) fn impact_force(self, speed: f64, mass: f64) -> f64 {
        speed * (self.stiffness() * mass).sqrt()
    }

    /// 6 k dt^2/m: the springs' part of the bound on the time step in a hexagonal bed.
    pub(super) fn bed_bound(self, mass: f64, time_step: f64) -> f64 {
        6.0 * self.stiffness() * time_step * time_step / mass
    }
}

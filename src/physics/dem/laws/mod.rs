//! The laws of the normal force of a contact. Adding one takes a file that implements [`NormalLaw`] and a line in the list.
//!
//! A law decides four things: the elastic force, its potential energy, the dashpot, and the stiffness that limits the time step. Friction,
//! the clamp of the force at zero, the loops over contacts and the energy balance are the same for every law. The kernel is compiled
//! once per law, so that no contact costs a decision.

mod linear_spring;
mod normal_law;

use kinetoscope_manifest::model::DemConfig;
use linear_spring::LinearSpring;
pub(crate) use normal_law::NormalLaw;
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
}
pub(crate) use with_law;

impl Law {
    /// The law that the manifest requests.
    pub(super) fn of(config: &DemConfig) -> Self {
        Self::LinearSpring(LinearSpring { stiffness: config.stiffness_n_per_m.get() })
    }

    /// Elastic force, N.
    pub(super) fn elastic_force(self, overlap: f64) -> f64 {
        fn of<L: NormalLaw>(law: L, overlap: f64) -> f64 {
            L::elastic_force(&law.constants(overlap), overlap)
        }
        with_law!(self, law => of(law, overlap))
    }

    /// Damping of a contact by that of its pair, N s/m.
    pub(super) fn damping(self, of_pair: f64, overlap: f64) -> f64 {
        fn of<L: NormalLaw>(law: L, of_pair: f64, overlap: f64) -> f64 {
            L::damping(&law.constants(overlap), of_pair, overlap)
        }
        with_law!(self, law => of(law, of_pair, overlap))
    }

    /// Potential energy of a contact, J.
    pub(super) fn potential_energy(self, overlap: f64) -> f64 {
        with_law!(self, law => law.potential_energy(overlap))
    }

    /// Largest stiffness k, N/m.
    pub(super) fn stiffness(self) -> f64 {
        with_law!(self, law => law.stiffness())
    }

    /// Overlap under a load, m.
    pub(super) fn overlap_under(self, force: f64) -> f64 {
        with_law!(self, law => law.overlap_under(force))
    }

    /// Duration of a contact without a dashpot, pi sqrt(m/k), s; m is the effective mass.
    pub(super) fn contact_time(self, mass: f64) -> f64 {
        PI * (mass / self.stiffness()).sqrt()
    }

    /// Frequency of a contact without a dashpot, sqrt(k/m), rad/s.
    pub(super) fn natural_frequency(self, mass: f64) -> f64 {
        (self.stiffness() / mass).sqrt()
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

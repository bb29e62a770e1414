//! A linear spring with a linear dashpot: Cundall and Strack, Géotechnique 29 (1979) 47; the DEM exercise's equation (1).

use super::normal_law::{Impact, NormalLaw};
use crate::dem::restitution;
use crate::simd::registers::Register;
use serde::{Deserialize, Serialize};

/// Stiffness k, N/m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct LinearSpring {
    pub(super) stiffness: f64,
}

impl NormalLaw for LinearSpring {
    type Constants<R: Register> = R;

    const HAS_CIRCLE: bool = false;
    const KEY: &'static str = "stiffness_n_per_m";

    #[inline(always)]
    fn constants<R: Register>(&self, any: R) -> R {
        any.splat(self.stiffness)
    }

    /// f_e = k delta; k in N/m, delta in m.
    #[inline(always)]
    fn elastic_force<R: Register>(stiffness: &R, overlap: R, _: R) -> R {
        *stiffness * overlap
    }

    /// eta, N s/m, whatever the overlap. The closed forms of a collision are in `restitution`.
    #[inline(always)]
    fn damping<R: Register>(_: &R, of_pair: R, _: R, _: R) -> R {
        of_pair
    }

    /// k delta^2/2, J.
    fn potential_energy(&self, overlap: f64, _: f64) -> f64 {
        0.5 * self.stiffness * overlap * overlap
    }

    fn stiffness(&self) -> f64 {
        self.stiffness
    }

    fn dashpot_stiffness(&self) -> f64 {
        self.stiffness
    }

    fn largest(&self) -> [f64; 2] {
        [0.0; 2]
    }

    fn impact_overlap(&self, impact: &Impact) -> f64 {
        let frequency = (self.stiffness / impact.mass).sqrt();
        restitution::max_overlap(impact.speed, impact.damping_ratio, frequency)
    }

    /// delta = f/k, m.
    fn overlap_under(&self, force: f64, _: f64) -> f64 {
        force / self.stiffness
    }

    fn contact_duration(&self, mass: f64, damping_ratio: f64, tail: bool) -> Option<f64> {
        restitution::contact_duration(damping_ratio, (self.stiffness / mass).sqrt(), tail)
    }
}

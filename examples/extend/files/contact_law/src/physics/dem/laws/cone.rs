//! A cone that is pressed into a plane.

use super::normal_law::{Impact, NormalLaw};
use crate::simd::registers::Register;
use serde::{Deserialize, Serialize};

/// f_e = kappa delta^2 of a blunt cone in an elastic plane (Sneddon, Int. J. Engng Sci. 3 (1965) 47).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Cone {
    /// kappa, Pa.
    modulus: f64,
    /// Largest overlap that is expected, m.
    largest_overlap: f64,
}

impl Cone {
    /// A contact with a modulus, Pa, and the stiffness at the largest overlap, N/m.
    pub(super) fn new(modulus: f64, stiffness: f64) -> Self {
        Self { modulus, largest_overlap: stiffness / (2.0 * modulus) }
    }
}

impl NormalLaw for Cone {
    type Constants<R: Register> = R;

    const HAS_CIRCLE: bool = false;
    const KEY: &'static str = "cone_modulus_pa";

    #[inline(always)]
    fn constants<R: Register>(&self, any: R) -> R {
        any.splat(self.modulus)
    }

    /// f_e = kappa delta^2.
    #[inline(always)]
    fn elastic_force<R: Register>(modulus: &R, overlap: R, _: R) -> R {
        *modulus * overlap * overlap
    }

    /// eta in proportion to the root of the stiffness, so that the restitution does not depend on the speed.
    #[inline(always)]
    fn damping<R: Register>(_: &R, of_pair: R, overlap: R, _: R) -> R {
        of_pair * overlap.sqrt()
    }

    /// kappa delta^3/3, J.
    fn potential_energy(&self, overlap: f64, _: f64) -> f64 {
        self.modulus * overlap * overlap * overlap / 3.0
    }

    /// 2 kappa delta_max, N/m.
    fn stiffness(&self) -> f64 {
        2.0 * self.modulus * self.largest_overlap
    }

    /// 3/4 of the stiffness over delta: with y = delta^(3/2) and dtau = delta^(1/2) dt, an impact is that of a linear spring
    /// (Antypov and Elliott, EPL 94 (2011) 50004, for Hertz's law).
    fn dashpot_stiffness(&self) -> f64 {
        1.5 * self.modulus
    }

    fn largest(&self) -> [f64; 2] {
        [self.largest_overlap, 0.0]
    }

    /// (3 m v^2/(2 kappa))^(1/3), m, without a dashpot.
    fn impact_overlap(&self, impact: &Impact) -> f64 {
        libm::cbrt(1.5 * impact.mass * impact.speed * impact.speed / self.modulus)
    }

    /// delta = sqrt(f/kappa), m.
    fn overlap_under(&self, force: f64, _: f64) -> f64 {
        (force / self.modulus).sqrt()
    }

    /// That of an elastic impact up to the largest overlap: v/delta = sqrt(k/(3 m)).
    fn contact_duration(&self, mass: f64, _: f64, _: bool) -> Option<f64> {
        Some(2.804_36 * (3.0 * mass / self.stiffness()).sqrt())
    }
}

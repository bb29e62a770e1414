//! Elastic spheres.

use super::normal_law::NormalLaw;
use crate::simd::registers::Register;
use serde::{Deserialize, Serialize};

/// Hertz's contact (Landau and Lifshitz, Theory of Elasticity, section 9).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct HertzContact {
    /// kappa, N/m^(3/2).
    modulus: f64,
    /// Largest overlap that is expected, m.
    largest_overlap: f64,
}

impl HertzContact {
    /// A contact with a modulus, N/m^(3/2), and the stiffness at the largest overlap, N/m.
    pub(super) fn new(modulus: f64, stiffness: f64) -> Self {
        let root = stiffness / (1.5 * modulus);
        Self { modulus, largest_overlap: root * root }
    }
}

/// kappa, and 1 over the root of the largest overlap, in all lanes.
#[derive(Clone, Copy)]
pub(crate) struct HertzConstants<R> {
    modulus: R,
    inverse_root: R,
}

impl NormalLaw for HertzContact {
    type Constants<R: Register> = HertzConstants<R>;

    #[inline(always)]
    fn constants<R: Register>(&self, any: R) -> HertzConstants<R> {
        HertzConstants {
            modulus: any.splat(self.modulus),
            inverse_root: any.splat(1.0 / self.largest_overlap.sqrt()),
        }
    }

    /// f_e = kappa delta^(3/2).
    #[inline(always)]
    fn elastic_force<R: Register>(constants: &HertzConstants<R>, overlap: R) -> R {
        constants.modulus * overlap * overlap.sqrt()
    }

    /// eta (delta/delta_max)^(1/4): proportional to the root of the stiffness, so that the restitution does not depend on the speed
    /// (Tsuji, Tanaka and Ishida, Powder Technology 71 (1992) 239).
    #[inline(always)]
    fn damping<R: Register>(constants: &HertzConstants<R>, of_pair: R, overlap: R) -> R {
        of_pair * (overlap.sqrt() * constants.inverse_root).sqrt()
    }

    /// 2/5 kappa delta^(5/2), J.
    fn potential_energy(&self, overlap: f64) -> f64 {
        0.4 * self.modulus * overlap * overlap * overlap.sqrt()
    }

    /// 3/2 kappa delta_max^(1/2), N/m.
    fn stiffness(&self) -> f64 {
        1.5 * self.modulus * self.largest_overlap.sqrt()
    }

    /// delta = (f/kappa)^(2/3), m.
    fn overlap_under(&self, force: f64) -> f64 {
        let root = libm::cbrt(force / self.modulus);
        root * root
    }
}

//! A linear spring with a linear dashpot: Cundall and Strack, Géotechnique 29 (1979) 47; the DEM exercise's equation (1).

use super::normal_law::NormalLaw;
use crate::simd::registers::Register;
use serde::{Deserialize, Serialize};

/// Stiffness k, N/m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct LinearSpring {
    pub(super) stiffness: f64,
}

impl NormalLaw for LinearSpring {
    type Constants<R: Register> = R;

    #[inline(always)]
    fn constants<R: Register>(&self, any: R) -> R {
        any.splat(self.stiffness)
    }

    /// f_e = k delta; k in N/m, delta in m.
    #[inline(always)]
    fn elastic_force<R: Register>(stiffness: &R, overlap: R) -> R {
        *stiffness * overlap
    }

    /// eta, N s/m, whatever the overlap. The closed forms of a collision are in `restitution`.
    #[inline(always)]
    fn damping<R: Register>(_: &R, of_pair: R, _: R) -> R {
        of_pair
    }

    /// k delta^2/2, J.
    fn potential_energy(&self, overlap: f64) -> f64 {
        0.5 * self.stiffness * overlap * overlap
    }

    fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// delta = f/k, m.
    fn overlap_under(&self, force: f64) -> f64 {
        force / self.stiffness
    }
}

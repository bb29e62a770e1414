//! Elastic spheres that touch in a plane: Hertz's law, with a dashpot whose restitution does not depend on the speed. Tangential springs
//! have a constant stiffness, or Mindlin's; see [`mindlin_slider`](crate::dem::motion::mindlin_slider).
//!
//! Landau and Lifshitz, Theory of Elasticity (1970), section 9: f_e = 4/3 E* a delta with the radius a = sqrt(R delta) of the circle of
//! contact, 1/R = 1/r_i + 1/r_j (R = r against a wall) and E* = E/(2 (1 - nu^2)) for one material. The stiffness is
//! df_e/d delta = 2 E* a.
//!
//! The dashpot is that of Tsuji, Tanaka and Ishida, Powder Technology 71 (1992) 239: eta is proportional to the root of the stiffness.
//! By Antypov and Elliott, EPL 94 (2011) 50004, the substitution y = delta^(5/4), dtau = delta^(1/4) dt turns the equation of a collision
//! into that of the linear spring and dashpot: with f_e = kappa delta^(3/2) and eta = alpha sqrt(kappa m) delta^(1/4),
//! y'' + alpha sqrt(kappa/m) y' + 5 kappa/(4 m) y = 0, an oscillator of the damping ratio zeta = alpha/sqrt 5. Speeds at y = 0
//! have the ratio e(zeta) of [`restitution`]. The force is zero where y'' is; therefore, e(zeta) with a clamped force holds as well.

use super::normal_law::{Impact, NormalLaw};
use crate::dem::{motion, restitution};
use crate::simd::registers::Register;
use serde::{Deserialize, Serialize};

/// Elastic spheres with tangential springs of a constant stiffness.
pub(crate) type Hertz = Spheres<false>;

/// Elastic spheres with Mindlin's tangential springs.
pub(crate) type Mindlin = Spheres<true>;

/// Elastic spheres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spheres<const MINDLIN: bool> {
    /// E*, Pa.
    modulus: f64,
    /// Largest overlap and radius of a circle of contact that are expected, m.
    largest: [f64; 2],
}

/// 4/3 E*, Pa, in all lanes.
#[derive(Clone, Copy)]
pub(crate) struct HertzConstants<R>(R);

/// Duration of a contact without a dashpot times v/delta_max: 4/5 sqrt(pi) Gamma(2/5)/Gamma(9/10).
const DURATION: f64 = 2.943_275_184_324_704_7;

impl<const MINDLIN: bool> Spheres<MINDLIN> {
    /// The law with the modulus E*, Pa, for an impact and a load that are the hardest ones expected.
    pub(super) fn new(modulus: f64, hardest: &Impact, load: f64, least_overlap: f64) -> Self {
        let law = Self { modulus, largest: [0.0; 2] };
        let expected = law.impact_overlap(hardest) + law.overlap_under(load, hardest.radius);
        let overlap = if expected > least_overlap { expected } else { least_overlap };
        Self { largest: [overlap, motion::circle_of_contact(hardest.radius, overlap)], ..law }
    }

    /// kappa of f_e = kappa delta^(3/2), N/m^(3/2).
    fn kappa(&self, radius: f64) -> f64 {
        4.0 / 3.0 * self.modulus * radius.sqrt()
    }
}

impl<const MINDLIN: bool> NormalLaw for Spheres<MINDLIN> {
    type Constants<R: Register> = HertzConstants<R>;

    const HAS_CIRCLE: bool = true;
    const HAS_MINDLIN_SPRINGS: bool = MINDLIN;
    const KEY: &'static str = "youngs_modulus_pa";

    #[inline(always)]
    fn constants<R: Register>(&self, any: R) -> HertzConstants<R> {
        HertzConstants(any.splat(4.0 / 3.0 * self.modulus))
    }

    /// f_e = 4/3 E* a delta.
    #[inline(always)]
    fn elastic_force<R: Register>(constants: &HertzConstants<R>, overlap: R, circle: R) -> R {
        constants.0 * circle * overlap
    }

    /// eta = 2 zeta sqrt(5/3 E* a m_eff).
    #[inline(always)]
    fn damping<R: Register>(_: &HertzConstants<R>, of_pair: R, _: R, circle: R) -> R {
        of_pair * circle.sqrt()
    }

    /// 8/15 E* a delta^2, J.
    fn potential_energy(&self, overlap: f64, circle: f64) -> f64 {
        8.0 / 15.0 * self.modulus * circle * overlap * overlap
    }

    /// 2 E* a_max, N/m.
    fn stiffness(&self) -> f64 {
        2.0 * self.modulus * self.largest[1]
    }

    /// 5/3 E*: 5/6 of the stiffness is that of the equivalent linear spring, and its factor a is that of `damping`.
    fn dashpot_stiffness(&self) -> f64 {
        5.0 / 3.0 * self.modulus
    }

    fn largest(&self) -> [f64; 2] {
        self.largest
    }

    /// (5 m v^2/(4 kappa))^(2/5) exp[-4/5 (b/w) acos(zeta)], m: y has the largest value of the equivalent oscillator.
    fn impact_overlap(&self, impact: &Impact) -> f64 {
        let &Impact { speed, mass, radius, damping_ratio } = impact;
        let frequency = (1.25 * self.kappa(radius) / mass).sqrt();
        let largest = restitution::max_overlap(1.25 * speed, damping_ratio, frequency);
        libm::pow(largest, 0.8)
    }

    /// delta = (f/kappa)^(2/3), m.
    fn overlap_under(&self, force: f64, radius: f64) -> f64 {
        let root = libm::cbrt(force / self.kappa(radius));
        root * root
    }

    /// That of an elastic impact up to the largest expected overlap: v/delta = sqrt(8 k/(15 m)) at the stiffness k there.
    fn contact_duration(&self, mass: f64, damping_ratio: f64, tail: bool) -> Option<f64> {
        let ends = tail || damping_ratio < 1.0;
        ends.then(|| DURATION * (15.0 / 8.0 * mass / self.stiffness()).sqrt())
    }
}

//! What a law of the normal force decides.

use crate::simd::registers::Register;

/// The normal force of a contact by its overlap delta, m: f = f_e - eta v_n with the elastic force f_e and the separating speed v_n.
///
/// Functions over registers are executed for one, four or eight contacts at a time. They must be `#[inline(always)]`. `circle` is the
/// radius a of the circle of contact, m; see [`motion::circle_of_contact`](crate::dem::motion::circle_of_contact).
pub(crate) trait NormalLaw: Copy + Send + Sync {
    /// The constants of the law, each in all lanes.
    type Constants<R: Register>: Copy;

    /// Whether the force depends on the circle of contact. If not, it is not computed.
    const HAS_CIRCLE: bool;

    /// Whether the stiffness of the tangential springs is proportional to the circle of contact; the law then needs the circle.
    const HAS_MINDLIN_SPRINGS: bool = false;

    /// The key of the manifest that makes contacts stiffer.
    const KEY: &'static str;

    /// The constants in all lanes of registers such as this one.
    fn constants<R: Register>(&self, any: R) -> Self::Constants<R>;

    /// Elastic force f_e, N, which pushes.
    fn elastic_force<R: Register>(constants: &Self::Constants<R>, overlap: R, circle: R) -> R;

    /// Damping eta of the dashpot, N s/m, by that of the pair, which is 2 zeta sqrt(k m_eff) with the `dashpot_stiffness`.
    fn damping<R: Register>(constants: &Self::Constants<R>, of_pair: R, overlap: R, circle: R)
    -> R;

    /// Potential energy, the integral of f_e over the overlap, J.
    fn potential_energy(&self, overlap: f64, circle: f64) -> f64;

    /// Largest stiffness k = df_e/d delta that is expected in a run, N/m: it limits the time step.
    fn stiffness(&self) -> f64;

    /// The stiffness k of a pair's damping, with which zeta gives the restitution e(zeta) of a linear spring.
    fn dashpot_stiffness(&self) -> f64;

    /// The overlap and the circle, m, at which the stiffness is the largest; 0 if the damping does not depend on them.
    fn largest(&self) -> [f64; 2];

    /// Largest overlap of an impact, m.
    fn impact_overlap(&self, impact: &Impact) -> f64;

    /// Overlap at which the elastic force is the given one, m; `radius` is R in m.
    fn overlap_under(&self, force: f64, radius: f64) -> f64;

    /// Duration of a contact, s, at an effective mass; `None` if it does not end. `tail` is that of
    /// [`restitution`](crate::dem::restitution).
    fn contact_duration(&self, mass: f64, damping_ratio: f64, tail: bool) -> Option<f64>;
}

/// An impact without gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Impact {
    /// Speed, m/s.
    pub(crate) speed: f64,
    /// Effective mass, kg.
    pub(crate) mass: f64,
    /// R: 1/R is the sum of the inverse radii, 1/m.
    pub(crate) radius: f64,
    /// zeta.
    pub(crate) damping_ratio: f64,
}

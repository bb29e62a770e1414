//! What a law of the normal force decides.

use crate::simd::registers::Register;

/// The normal force of a contact by its overlap delta, m: f = f_e - eta v_n with the elastic force f_e and the separating speed v_n.
///
/// Functions over registers are executed for one, four or eight contacts at a time. They must be `#[inline(always)]`.
pub(crate) trait NormalLaw: Copy + Send + Sync {
    /// The constants of the law, each in all lanes.
    type Constants<R: Register>: Copy;

    /// The constants in all lanes of registers such as this one.
    fn constants<R: Register>(&self, any: R) -> Self::Constants<R>;

    /// Elastic force f_e, N, which pushes.
    fn elastic_force<R: Register>(constants: &Self::Constants<R>, overlap: R) -> R;

    /// Damping eta of the dashpot, N s/m, by that of the pair, which is 2 zeta sqrt(k m_eff) with the law's `stiffness`.
    fn damping<R: Register>(constants: &Self::Constants<R>, of_pair: R, overlap: R) -> R;

    /// Potential energy, the integral of f_e over the overlap, J.
    fn potential_energy(&self, overlap: f64) -> f64;

    /// Largest stiffness k = df_e/d delta of a run, N/m: it limits the time step.
    fn stiffness(&self) -> f64;

    /// Overlap at which the elastic force is the given one, m.
    fn overlap_under(&self, force: f64) -> f64;
}

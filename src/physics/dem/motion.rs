//! The equations of motion of discs with spring–dashpot contacts, as they are executed; `laws` has the normal forces.
//!
//! Cundall and Strack, Géotechnique 29 (1979) 47; the DEM exercise's equation (1). Friction and rolling: Luding,
//! Granular Matter 10 (2008) 235, sections 3.2 and 3.3. The laws of a contact are generic over the register: each is written
//! once and runs for one, four or eight contacts at a time.

use crate::simd::registers::Register;

/// The equation of motion, m a = m g + sum of f_c, solved for a in m/s^2.
///
/// `gravity` is g in m/s^2, `contact_force` the sum of the contact forces f_c on the disc in N, `inverse_mass` is 1/m in 1/kg.
#[must_use]
#[inline(always)]
pub fn acceleration(gravity: [f64; 2], contact_force: [f64; 2], inverse_mass: f64) -> [f64; 2] {
    [gravity[0] + contact_force[0] * inverse_mass, gravity[1] + contact_force[1] * inverse_mass]
}

/// The equation of motion of the spin, I alpha = sum of torques, in rad/s^2, for a disc: I = m r^2/2.
///
/// The torque of a tangential force f_t on a disc is -a f_t with its `lever_arm` a, in addition to rolling resistance.
#[must_use]
#[inline(always)]
pub fn angular_acceleration(torque: f64, mass: f64, radius: f64) -> f64 {
    torque / moment_of_inertia(mass, radius)
}

/// Moment of inertia of a disc about its center, I = m r^2/2, in kg m^2.
#[must_use]
#[inline(always)]
pub fn moment_of_inertia(mass: f64, radius: f64) -> f64 {
    0.5 * mass * radius * radius
}

/// Lever arm of a tangential force, the distance from a disc's center to the contact point, a = r - delta/2, in m.
///
/// The arms of two discs add up to the distance of their centers. Therefore, their contact conserves the sum of orbital and spin
/// angular momentum. Against a wall, the contact point lies on its surface: a = r - delta, the distance of the center.
/// The velocities of the surfaces, a w, have the same arms, so that the work on the spins is that of the force.
#[inline(always)]
pub(crate) fn lever_arm<R: Register>(radius: R, overlap: R) -> R {
    radius - overlap.splat(0.5) * overlap
}

/// Effective mass of a pair, m_eff = m_i m_j / (m_i + m_j), in kg. Against a wall it is the disc's own mass.
#[must_use]
#[inline(always)]
pub fn effective_mass(first: f64, second: f64) -> f64 {
    first * second / (first + second)
}

/// Reduced radius of a pair, R = r_i r_j / (r_i + r_j), in m. Against a wall it is the disc's own radius.
#[inline(always)]
pub(crate) fn reduced_radius<R: Register>(first: R, second: R) -> R {
    first * second / (first + second)
}

/// Radius of the circle in which two spheres touch, a = sqrt(R delta), in m, by the reduced radius R and the overlap delta
/// (Landau and Lifshitz, Theory of Elasticity, section 9).
#[inline(always)]
pub(crate) fn circle_of_contact<R: Register>(reduced_radius: R, overlap: R) -> R {
    (reduced_radius * overlap).sqrt()
}

/// Squared distance d^2 = x^2 + y^2 of two centers, m^2.
#[inline(always)]
pub(crate) fn distance_squared<R: Register>([x, y]: [R; 2]) -> R {
    x * x + y * y
}

/// Whether two centers are closer than a reach: d^2 < reach^2. With reach = r_i + r_j, the two are in contact.
///
/// A position that is not a number is closer to nothing.
#[inline(always)]
pub(crate) fn is_closer<R: Register>(distance_squared: R, reach: R) -> R::Mask {
    distance_squared.is_less(reach * reach)
}

/// The normal force of a contact, N.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NormalForce<R> {
    /// f, positive if it pushes.
    pub(crate) force: R,
    /// The dissipative part, f_e - f.
    pub(crate) loss: R,
}

/// Equation (1) along the normal: f = f_e - eta v_n, but not less than f_min.
///
/// `elastic` is the law's elastic force f_e in N, k delta for a linear spring, `damping` eta in N s/m, `separating_speed` v_n in m/s:
/// the relative velocity along the normal, positive if the two move apart. `least_force` is f_min in N: 0 if the force is clamped
/// (Schwager and Pöschel, Granular Matter 9 (2007) 465), minus infinity with the attractive tail.
#[inline(always)]
pub(crate) fn normal_force<R: Register>(
    elastic: R,
    damping: R,
    separating_speed: R,
    least_force: R,
) -> NormalForce<R> {
    let force = (elastic - damping * separating_speed).larger(least_force);
    NormalForce { force, loss: elastic - force }
}

/// The part of a step for which a constant attraction of surfaces in contact acts, by the overlaps of the step before and of this one, m.
///
/// Forces act at the positions of a step, in the name of half a step to both sides. The attraction begins and ends where the overlap is 0: in
/// the first step of a contact, it acts for 1/2 and the part of the way to the present positions that lay within the overlap; in the first
/// step after it, for the part of the way that lay within, less 1/2. The sum over all steps is the time of the contact, so that the error of
/// the energy is of second order.
#[inline(always)]
pub(crate) fn attracted_part<R: Register>([before, now]: [R; 2]) -> R {
    let (zero, one, half) = (now.splat(0.0), now.splat(1.0), now.splat(0.5));
    let was_in_contact = zero.is_less(before);
    let within = before.larger(now);
    let share = within / (within - now.or_else(was_in_contact, before));
    let in_contact = one.or_else(was_in_contact, share + half);
    in_contact.or_else(zero.is_less(now), (share - half).or_zero(was_in_contact))
}

/// Equation (1) with the dashpot at the velocity of the step's end: f = (f_e - eta v_n) / (1 + c), but not less than f_min.
///
/// `separating_speed` is the v_n in m/s that the contact would have at the step's end without its own force, `damping_step` is
/// c = eta dt/m_eff. The other symbols are those of [`normal_force`].
#[inline(always)]
pub(crate) fn implicit_normal_force(
    elastic: f64,
    damping: f64,
    separating_speed: f64,
    damping_step: f64,
    least_force: f64,
) -> f64 {
    let force = (elastic - damping * separating_speed) / (1.0 + damping_step);
    force.larger(least_force)
}

/// Constants of springs with sliders.
#[derive(Clone, Copy, Debug)]
pub struct SliderConstants<R> {
    /// Stiffness k_t, N/m.
    pub stiffness: R,
    /// k_t/2, N/m.
    pub half_stiffness: R,
    /// 1/k_t, m/N.
    pub compliance: R,
}

/// The force of a spring with a slider after a step.
#[derive(Clone, Copy, Debug)]
pub struct TangentialForce<R> {
    /// Force on the disc along the tangent, N.
    pub force: R,
    /// Part of the force that is due to the dashpot, N; 0 while the contact slides.
    pub dashpot: R,
    /// Stretch of the spring after the step, m.
    pub stretch: R,
    /// Energy that the slider dissipated in the step, J.
    pub loss: R,
}

/// A spring in series with a slider that yields at |f| = `limit`, and a dashpot that acts while the slider holds:
///
/// xi' = xi + v_t dt; f = -k_t xi' - eta_t v_t while |f| <= mu f_n; else |f| = mu f_n and xi = -f/k_t.
///
/// `before` is xi in m from the step before, `travel` is v_t dt in m, `dashpot` is -eta_t v_t in N, `limit` is mu f_n >= 0 in N.
/// The slip counts with the mean of the spring's force before and after it: with velocities half a step behind the positions,
/// work and energy of the springs then agree exactly.
#[inline(always)]
pub(crate) fn spring_slider<R: Register>(
    spring: &SliderConstants<R>,
    before: R,
    travel: R,
    dashpot: R,
    limit: R,
) -> TangentialForce<R> {
    let stretched = before + travel;
    let trial = dashpot - spring.stiffness * stretched;
    let holds = trial.abs().is_at_most(limit);
    let zero = trial.splat(0.0);
    let sliding = limit.or_else(zero.is_less(trial), -limit);
    let yielded = -sliding * spring.compliance;
    let stretch = stretched.or_else(holds, yielded);
    let slip = zero.or_else(holds, stretched - yielded);
    TangentialForce {
        force: trial.or_else(holds, sliding),
        dashpot: dashpot.or_zero(holds),
        stretch,
        loss: spring.half_stiffness * (before + stretch) * slip,
    }
}

/// Overlap of two discs a step ago, by their present separation and the velocity that led to it, m.
#[inline(always)]
pub(crate) fn overlap_before<R: Register>(
    [x, y]: [R; 2],
    [vx, vy]: [R; 2],
    time_step: R,
    reach: R,
) -> R {
    reach - distance_squared([x - vx * time_step, y - vy * time_step]).sqrt()
}

/// Far below the root of any circle with an overlap, which is at least some 1e-16 of a radius.
const LEAST_ROOT: f64 = 1e-60;

/// The step of `spring_slider` with Mindlin's stiffness k_t = 8 G* a without partial slip (J. Appl. Mech. 16 (1949) 259), by the circles
/// of contact of the step before and of this one, over the largest expected one.
///
/// The elastic force stays while the circle grows, and decreases in proportion to it while it shrinks (Thornton, Cummins and Cleary, Powder
/// Technology 233 (2013) 30; `mindlin_rescale/force` of LAMMPS). Either way, the spring's energy U = k_t xi^2/2 is multiplied by the smaller
/// circle over the larger one. It cannot be gained by loading and unloading (Elata and Berryman, Mech. Mater. 24 (1996) 229); the
/// loss is one of friction.
///
/// The stretch is that of a spring with the `spring`'s stiffness k at the largest circle and the same energy: z = s xi with s^2 = a/a_max, and
/// the force is -k s z. Therefore, U and its loss at the end of a contact depend on z alone. The loss is the work,
/// (k/2) (s_0 z_0 + s z') v_t dt, less the gain of energy. It is not negative, except by (k_0 - k_t) |xi_0 xi'|/2 in a step of unloading in which
/// xi changes its sign.
#[must_use]
#[inline(always)]
pub fn mindlin_slider<R: Register>(
    spring: &SliderConstants<R>,
    circles: [R; 2],
    before: R,
    travel: R,
    dashpot: R,
    limit: R,
) -> TangentialForce<R> {
    // Surfaces that touch without an overlap have no circle, and no force.
    let least = before.splat(LEAST_ROOT);
    let [root_before, root] = [circles[0].sqrt(), circles[1].sqrt().larger(least)];
    let larger = root.larger(root_before);
    let ratio = root_before.or_else(root_before.is_less(root), root) / larger;
    let at_circle = SliderConstants {
        stiffness: spring.stiffness * root,
        half_stiffness: spring.half_stiffness,
        compliance: spring.compliance / root,
    };
    let slid = spring_slider(&at_circle, ratio * before, root * travel, dashpot, limit);
    let one = ratio.splat(1.0);
    let rescaled = (one - ratio * ratio) * before + (root_before - ratio * root) * travel;
    TangentialForce { loss: slid.loss + spring.half_stiffness * before * rescaled, ..slid }
}

/// Energy of a stretched spring, k_t xi^2/2, in J.
#[inline(always)]
pub(crate) fn spring_energy<R: Register>(half_stiffness: R, stretch: R) -> R {
    half_stiffness * stretch * stretch
}

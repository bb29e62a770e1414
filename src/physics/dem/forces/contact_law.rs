//! The laws of one contact with the constants of a run, for registers of any width. The formulas are in `motion`.

use crate::dem::block::Stretch;
use crate::dem::materials::{ContactConstants, ContactLaw};
use crate::dem::motion::{self, NormalForce, SliderConstants, TangentialForce};
use crate::simd::registers::{InstructionSet, Register};

/// The constants of the contact law, each in all lanes.
#[derive(Clone, Copy)]
pub(in crate::dem) struct LawRegisters<R> {
    pub(super) zero: R,
    pub(super) one: R,
    least_distance: R,
    stiffness: R,
    least_force: R,
    spring: SliderConstants<R>,
    tangential_to_normal_damping: R,
    time_step: R,
    /// Friction and rolling friction if all discs are of one material.
    pub(super) friction: [R; 2],
}

/// The geometry and the velocity of contacts.
#[derive(Clone, Copy)]
pub(in crate::dem) struct ContactKinematics<R> {
    /// Unit vectors from the partners to the discs.
    pub(super) normal: [R; 2],
    /// delta, m.
    pub(super) overlap: R,
    /// Relative velocity along the normal, m/s.
    pub(super) separating_speed: R,
    /// Relative velocity of the centers along the tangent (-ny, nx), m/s.
    pub(super) sliding_speed: R,
}

/// Friction of a contact: coefficients, surfaces and springs.
pub(super) struct Surfaces<'a> {
    pub(super) constants: &'a ContactConstants,
    /// r_i w_i + r_j w_j, m/s.
    pub(super) rim_speed: f64,
    /// w_i - w_j, rad/s.
    pub(super) rolling_rate: f64,
    /// r_i r_j / (r_i + r_j), or the disc's radius against a wall, m; `None` without rolling friction.
    pub(super) reduced_radius: Option<f64>,
}

/// The frictional forces of a contact and their energies.
pub(super) struct Friction {
    pub(super) tangential: TangentialForce<f64>,
    /// Torque of the rolling spring on the disc that the normal points to, N m; the partner's is its opposite.
    pub(super) rolling_torque: f64,
    /// Energy of both springs, J.
    pub(super) elastic: f64,
    /// Energy dissipated by the rolling slider, J.
    pub(super) rolling_loss: f64,
}

impl<R: Register> LawRegisters<R> {
    #[inline(always)]
    pub(super) fn new<const N: usize>(
        instructions: impl InstructionSet<N, Register = R>,
        law: &ContactLaw,
        time_step: f64,
    ) -> Self {
        let friction =
            law.materials.only().map_or([0.0; 2], |one| [one.friction, one.rolling_friction]);
        Self {
            zero: instructions.splat(0.0),
            one: instructions.splat(1.0),
            least_distance: instructions.splat(f64::MIN_POSITIVE),
            stiffness: instructions.splat(law.stiffness),
            least_force: instructions.splat(law.least_force()),
            spring: SliderConstants {
                zero: instructions.splat(0.0),
                stiffness: instructions.splat(law.tangential_stiffness),
                half_stiffness: instructions.splat(0.5 * law.tangential_stiffness),
                compliance: instructions.splat(1.0 / law.tangential_stiffness),
            },
            tangential_to_normal_damping: instructions.splat(law.tangential_to_normal_damping),
            time_step: instructions.splat(time_step),
            friction: [instructions.splat(friction[0]), instructions.splat(friction[1])],
        }
    }

    /// Kinematics from the separation of the centers, its square and the relative velocity.
    #[inline(always)]
    pub(super) fn kinematics(
        &self,
        [x, y]: [R; 2],
        distance_squared: R,
        reach: R,
        velocity: [R; 2],
    ) -> ContactKinematics<R> {
        let distance = distance_squared.sqrt();
        // Two centers on one point have no normal. Such an overlap ends the run; therefore, any force will do.
        let inverse = self.one / distance.larger(self.least_distance);
        ContactKinematics::new([x * inverse, y * inverse], reach - distance, velocity)
    }

    #[inline(always)]
    pub(super) fn normal_force(
        &self,
        contact: &ContactKinematics<R>,
        damping: R,
    ) -> NormalForce<R> {
        let ContactKinematics { overlap, separating_speed, .. } = *contact;
        motion::normal_force(self.stiffness, damping, overlap, separating_speed, self.least_force)
    }

    /// The force of the tangential spring; `rim_speed` is r_i w_i + r_j w_j, `limit` mu f_n.
    #[inline(always)]
    pub(super) fn sliding(
        &self,
        contact: &ContactKinematics<R>,
        damping: R,
        rim_speed: R,
        before: R,
        limit: R,
    ) -> TangentialForce<R> {
        let speed = contact.sliding_speed - rim_speed;
        let dashpot = -(self.tangential_to_normal_damping * damping) * speed;
        motion::spring_slider(&self.spring, before, speed * self.time_step, dashpot, limit)
    }

    /// The force of the rolling spring and its torque; it has no dashpot.
    #[inline(always)]
    pub(super) fn rolling(
        &self,
        reduced_radius: R,
        rolling_rate: R,
        before: R,
        limit: R,
    ) -> (TangentialForce<R>, R) {
        let travel = reduced_radius * rolling_rate * self.time_step;
        let rolled = motion::spring_slider(&self.spring, before, travel, -self.zero, limit);
        (rolled, reduced_radius * rolled.force)
    }

    /// Energy of stretched springs, J.
    #[inline(always)]
    pub(super) fn spring_energy(&self, stretch: R) -> R {
        motion::spring_energy(self.spring.half_stiffness, stretch)
    }

    /// Normal forces of a contact that presses, N: friction acts only there.
    #[inline(always)]
    pub(super) fn pressing(&self, normal_force: &NormalForce<R>) -> R {
        normal_force.force.larger(self.zero)
    }
}

impl LawRegisters<f64> {
    /// The friction of one contact; its springs advance by a step.
    #[inline]
    pub(super) fn friction(
        &self,
        contact: &ContactKinematics<f64>,
        surfaces: &Surfaces<'_>,
        normal_force: &NormalForce<f64>,
        damping: f64,
        stretch: &mut Stretch,
    ) -> Friction {
        let pressing = self.pressing(normal_force);
        let limit = surfaces.constants.friction * pressing;
        let tangential = self.sliding(contact, damping, surfaces.rim_speed, stretch[0], limit);
        stretch[0] = tangential.stretch;
        let mut friction = Friction {
            tangential,
            rolling_torque: 0.0,
            elastic: self.spring_energy(tangential.stretch),
            rolling_loss: 0.0,
        };
        if let Some(reduced_radius) = surfaces.reduced_radius {
            let limit = surfaces.constants.rolling_friction * pressing;
            let (rolled, torque) =
                self.rolling(reduced_radius, surfaces.rolling_rate, stretch[1], limit);
            stretch[1] = rolled.stretch;
            friction.rolling_torque = torque;
            friction.elastic += self.spring_energy(rolled.stretch);
            friction.rolling_loss = rolled.loss;
        }
        friction
    }
}

impl<R: Register> ContactKinematics<R> {
    #[inline(always)]
    pub(super) fn new([nx, ny]: [R; 2], overlap: R, [vx, vy]: [R; 2]) -> Self {
        Self {
            normal: [nx, ny],
            overlap,
            separating_speed: vx * nx + vy * ny,
            sliding_speed: vy * nx - vx * ny,
        }
    }

    /// Fx, Fy, Dx, Dy on the disc without friction.
    #[inline(always)]
    pub(super) fn along_normal(&self, normal: &NormalForce<R>) -> [R; 4] {
        let [nx, ny] = self.normal;
        [normal.force * nx, normal.force * ny, normal.loss * nx, normal.loss * ny]
    }

    /// Fx, Fy, Dx, Dy on the disc with friction along the tangent (-ny, nx).
    #[inline(always)]
    pub(super) fn with_friction(
        &self,
        normal: &NormalForce<R>,
        tangential: &TangentialForce<R>,
    ) -> [R; 4] {
        let ([nx, ny], [fx, fy, dx, dy]) = (self.normal, self.along_normal(normal));
        let TangentialForce { force, dashpot, .. } = *tangential;
        [fx - force * ny, fy + force * nx, dx + dashpot * ny, dy - dashpot * nx]
    }
}

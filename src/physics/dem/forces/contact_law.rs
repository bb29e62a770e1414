//! The laws of one contact with the constants of a run, for registers of any width. The formulas are in `motion`.

use crate::dem::block::Stretch;
use crate::dem::laws::NormalLaw;
use crate::dem::materials::ContactConstants;
use crate::dem::motion::{self, NormalForce, SliderConstants, TangentialForce};
use crate::dem::parameters::{Parameters, StepContext};
use crate::dem::totals::ContactSums;
use crate::simd::registers::{InstructionSet, Register};

/// The constants of the contact law, each in all lanes.
#[derive(Clone, Copy)]
pub(crate) struct LawRegisters<R: Register, L: NormalLaw> {
    pub(super) zero: R,
    normal: L::Constants<R>,
    least_force: R,
    spring: SliderConstants<R>,
    /// Inverse of the largest expected circle of contact, 1/m.
    inverse_circle: R,
    tangential_to_normal_damping: R,
    pub(super) time_step: R,
    /// Friction and rolling friction, of all discs if they are of one material.
    pub(super) friction: [R; 2],
    /// Stiffness over that of the manifest.
    stiffness_ratio: R,
    /// F_c.
    pub(super) cohesion: R,
    /// Whether any surfaces attract each other.
    pub(super) is_cohesive: bool,
    /// Time of the last step; 0 at the start.
    pub(super) time_before: R,
    /// Whether discs of several materials differ only in their friction and dashpots.
    pub(super) has_plain_springs: bool,
}

/// The geometry and the velocity of contacts.
#[derive(Clone, Copy)]
pub(crate) struct ContactKinematics<R> {
    /// Unit vectors from the partners to the discs.
    pub(super) normal: [R; 2],
    /// delta, m.
    pub(super) overlap: R,
    /// Radius of the circle of contact, m; 0 for laws without it.
    pub(super) circle: R,
    /// That of the step before, with Mindlin's springs; else 0.
    pub(super) circle_before: R,
    /// Relative velocity along the normal, m/s.
    pub(super) separating_speed: R,
    /// Relative velocity of the centers along the tangent (-ny, nx), m/s.
    pub(super) sliding_speed: R,
}

/// Friction of a contact: surfaces and damping.
pub(super) struct Surfaces {
    /// eta of the pair, N s/m.
    pub(super) damping: f64,
    /// Distance from the disc's center to the contact point, m.
    pub(super) arm: f64,
    /// Sum of the speeds a w of both surfaces about their centers, m/s.
    pub(super) surface_speed: f64,
    /// w_i - w_j, rad/s.
    pub(super) rolling_rate: f64,
    /// r_i r_j / (r_i + r_j), or the disc's radius against a wall, m; `None` without rolling friction.
    pub(super) reduced_radius: Option<f64>,
}

/// Torque on a disc and the part of it that dashpots take, N m.
pub(crate) type Torque = [f64; 2];

impl<R: Register, L: NormalLaw> LawRegisters<R, L> {
    #[inline(always)]
    pub(super) fn new<const N: usize>(
        instructions: impl InstructionSet<N, Register = R>,
        &StepContext { parameters: &Parameters { ref law, time_step, .. }, time_before, .. }: &StepContext<'_>,
        normal: L,
    ) -> Self {
        let zero = instructions.splat(0.0);
        let friction =
            law.materials.only().map_or([0.0; 2], |one| [one.friction, one.rolling_friction]);
        Self {
            zero,
            normal: normal.constants(zero),
            least_force: instructions.splat(law.least_force()),
            spring: SliderConstants {
                stiffness: instructions.splat(law.tangential_stiffness),
                half_stiffness: instructions.splat(0.5 * law.tangential_stiffness),
                compliance: instructions.splat(1.0 / law.tangential_stiffness),
            },
            inverse_circle: instructions.splat(1.0 / normal.largest()[1]),
            tangential_to_normal_damping: instructions.splat(law.tangential_to_normal_damping),
            time_step: instructions.splat(time_step),
            friction: friction.map(|coefficient| instructions.splat(coefficient)),
            stiffness_ratio: instructions.splat(1.0),
            cohesion: zero,
            is_cohesive: law.is_cohesive(),
            time_before: instructions.splat(time_before),
            has_plain_springs: law.materials.have_plain_springs(),
        }
    }

    /// The law of pairs with these constants: friction, rolling friction, stiffness over that of the manifest, and cohesion.
    #[inline(always)]
    pub(super) fn of_pairs(&self, constants: [R; 4]) -> Self {
        let [friction, rolling_friction, stiffness_ratio, cohesion] = constants;
        let SliderConstants { stiffness, half_stiffness, compliance } = self.spring;
        let spring = SliderConstants {
            stiffness: stiffness_ratio * stiffness,
            half_stiffness: stiffness_ratio * half_stiffness,
            compliance: compliance / stiffness_ratio,
        };
        Self { spring, friction: [friction, rolling_friction], stiffness_ratio, cohesion, ..*self }
    }

    /// The normal force without cohesion. If not `MIXED`, the stiffness is that of the manifest.
    #[inline(always)]
    pub(super) fn normal_force<const MIXED: bool>(
        &self,
        contact: &ContactKinematics<R>,
        damping: R,
    ) -> NormalForce<R> {
        let ContactKinematics { overlap, circle, separating_speed, .. } = *contact;
        let elastic = L::elastic_force(&self.normal, overlap, circle);
        let elastic = if MIXED { self.stiffness_ratio * elastic } else { elastic };
        let damping = L::damping(&self.normal, damping, overlap, circle);
        motion::normal_force(elastic, damping, separating_speed, self.least_force)
    }

    /// The part of the step for which two discs attract each other, by their separation, the velocity that led to it, and their reach;
    /// 0 without cohesion.
    #[inline(always)]
    pub(super) fn attracted_part(&self, separation: [R; 2], velocity: [R; 2], reach: R) -> R {
        if !self.is_cohesive {
            return self.zero;
        }
        let before = motion::overlap_before(separation, velocity, self.time_before, reach);
        motion::attracted_part([before, reach - motion::distance_squared(separation).sqrt()])
    }

    /// Fx, Fy, Dx, Dy on the disc with the attraction F_c, which dissipates nothing, for a part of the step.
    #[inline(always)]
    pub(super) fn attracted(&self, [fx, fy, dx, dy]: [R; 4], [nx, ny]: [R; 2], part: R) -> [R; 4] {
        if !self.is_cohesive {
            return [fx, fy, dx, dy];
        }
        let attraction = self.cohesion * part;
        [fx - attraction * nx, fy - attraction * ny, dx, dy]
    }

    /// The force of the tangential spring; `surface_speed` is a_i w_i + a_j w_j, `limit` mu f_n.
    #[inline(always)]
    pub(super) fn sliding(
        &self,
        contact: &ContactKinematics<R>,
        damping: R,
        surface_speed: R,
        before: R,
        limit: R,
    ) -> TangentialForce<R> {
        let speed = contact.sliding_speed - surface_speed;
        let damping = L::damping(&self.normal, damping, contact.overlap, contact.circle);
        let dashpot = -(self.tangential_to_normal_damping * damping) * speed;
        let travel = speed * self.time_step;
        if L::HAS_MINDLIN_SPRINGS {
            let inverse = self.inverse_circle;
            let circles = [contact.circle_before * inverse, contact.circle * inverse];
            motion::mindlin_slider(&self.spring, circles, before, travel, dashpot, limit)
        } else {
            motion::spring_slider(&self.spring, before, travel, dashpot, limit)
        }
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
}

impl<L: NormalLaw> LawRegisters<f64, L> {
    /// The law of a pair with these constants.
    #[inline(always)]
    pub(super) fn of_pair(&self, pair: &ContactConstants) -> Self {
        self.of_pairs(pair.of_contact())
    }

    /// Fx, Fy, Dx, Dy on the disc with friction, and the torque on it. The springs advance by a step, and a fraction of the
    /// energies is added to the sums.
    #[inline(always)]
    pub(super) fn with_friction(
        &self,
        contact: &ContactKinematics<f64>,
        normal: &NormalForce<f64>,
        surfaces: &Surfaces,
        stretch: &mut Stretch,
        sums: &mut ContactSums,
        fraction: f64,
    ) -> ([f64; 4], Torque) {
        let Surfaces { damping, arm, surface_speed, rolling_rate, reduced_radius } = *surfaces;
        // Friction acts only on a contact that presses.
        let pressing = normal.force.larger(0.0);
        let [friction, rolling_friction] = self.friction;
        let limit = friction * pressing;
        let slid = self.sliding(contact, damping, surface_speed, stretch[0], limit);
        let (mut elastic, mut torque) = (self.spring_energy(slid.stretch), -arm * slid.force);
        stretch[0] = slid.stretch;
        if let Some(reduced_radius) = reduced_radius {
            let limit = rolling_friction * pressing;
            let (rolled, on_disc) = self.rolling(reduced_radius, rolling_rate, stretch[1], limit);
            elastic += self.spring_energy(rolled.stretch);
            torque += on_disc;
            stretch[1] = rolled.stretch;
            sums.rolling += fraction * rolled.loss;
        }
        sums.elastic += fraction * elastic;
        sums.friction += fraction * slid.loss;
        (contact.with_friction(normal, &slid), [torque, arm * slid.dashpot])
    }

    /// Releases the springs of a contact that has ended: friction dissipates their energy, of which a fraction is added.
    #[inline(always)]
    pub(super) fn release(&self, stretch: &mut Stretch, sums: &mut ContactSums, fraction: f64) {
        sums.friction += fraction * self.spring_energy(stretch[0]);
        sums.rolling += fraction * self.spring_energy(stretch[1]);
        *stretch = [0.0; 2];
    }
}

impl<R: Register> ContactKinematics<R> {
    /// With the circle of contact, if the law has it, by the reduced radius.
    #[inline(always)]
    pub(super) fn with_circle<L: NormalLaw>(self, reduced_radius: R) -> Self {
        let circle = motion::circle_of_contact(reduced_radius, self.overlap);
        if L::HAS_CIRCLE { Self { circle, ..self } } else { self }
    }

    /// With the circle of contact of the step before, by the overlap there, which is not positive if the contact begins.
    #[inline(always)]
    pub(super) fn with_circle_before(self, reduced_radius: R, overlap: R) -> Self {
        let overlap = overlap.larger(overlap.splat(0.0));
        Self { circle_before: motion::circle_of_contact(reduced_radius, overlap), ..self }
    }

    /// Without overlap and speed where the mask does not hold.
    #[inline(always)]
    pub(super) fn or_zero(self, mask: R::Mask) -> Self {
        Self {
            overlap: self.overlap.or_zero(mask),
            separating_speed: self.separating_speed.or_zero(mask),
            ..self
        }
    }

    #[inline(always)]
    pub(super) fn new([nx, ny]: [R; 2], overlap: R, [vx, vy]: [R; 2]) -> Self {
        Self {
            normal: [nx, ny],
            overlap,
            circle: overlap.splat(0.0),
            circle_before: overlap.splat(0.0),
            separating_speed: vx * nx + vy * ny,
            sliding_speed: vy * nx - vx * ny,
        }
    }

    /// The kinematics of two discs from the separation of their centers, its square and the relative velocity.
    #[inline(always)]
    pub(super) fn between([x, y]: [R; 2], distance_squared: R, reach: R, velocity: [R; 2]) -> Self {
        let distance = distance_squared.sqrt();
        // Two centers on one point have no normal. Such an overlap ends the run; therefore, any force will do.
        let inverse = distance.splat(1.0) / distance.larger(distance.splat(f64::MIN_POSITIVE));
        Self::new([x * inverse, y * inverse], reach - distance, velocity)
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

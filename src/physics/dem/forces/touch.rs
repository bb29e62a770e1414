//! One contact: what its springs, dashpots and sliders do to the two that touch.

use crate::dem::discs::Discs;
use crate::dem::forces::contact::ContactLaw;
use crate::dem::materials::ContactConstants;
use crate::dem::motion::{self, SpringSlider};
use crate::dem::neighbors::springs::Stretch;

/// Two that overlap.
pub(in crate::dem) struct Touch {
    /// Unit vector from the other to the disc.
    pub(in crate::dem) normal: [f64; 2],
    /// delta, m.
    pub(in crate::dem) overlap: f64,
    /// Velocity of the disc against the other, spins left out, m/s.
    pub(in crate::dem) velocity: [f64; 2],
    /// w_i - w_j, rad/s.
    pub(in crate::dem) rolling_rate: f64,
    /// r_i w_i + r_j w_j, m/s.
    pub(in crate::dem) surface_speed: f64,
}

/// Normal force f and its dissipative part k delta - f, N.
pub(in crate::dem) struct Push {
    /// eta of the contact, N s/m.
    damping: f64,
    pub(in crate::dem) force: f64,
    pub(in crate::dem) loss: f64,
}

/// What friction does in a step.
pub(in crate::dem) struct Rub {
    /// Tangential force and the dashpot's share of it, N.
    pub(in crate::dem) force: f64,
    pub(in crate::dem) dashpot: f64,
    /// Torque of the rolling spring on the disc that the normal points to, N m; the other's is its opposite.
    pub(in crate::dem) rolling_torque: f64,
    /// Energy of both springs, J.
    pub(in crate::dem) elastic: f64,
    /// Energy taken by either slider, J.
    pub(in crate::dem) friction_loss: f64,
    pub(in crate::dem) rolling_loss: f64,
}

impl Touch {
    /// The contact of two discs, the second shifted; `None` where they are apart.
    #[inline]
    pub(in crate::dem) fn between(
        discs: &Discs,
        [disc, other]: [usize; 2],
        shift: [f64; 2],
        reach: f64,
    ) -> Option<Self> {
        let [[x, y], [other_x, other_y]] = [disc, other].map(|disc| discs.positions[disc]);
        let apart = [x - (other_x + shift[0]), y - (other_y + shift[1])];
        let squared = apart[0] * apart[0] + apart[1] * apart[1];
        (squared < reach * reach).then(|| {
            let [[vx, vy], [other_vx, other_vy]] = [disc, other].map(|disc| discs.velocities[disc]);
            Self::of(apart, squared, reach, [vx - other_vx, vy - other_vy])
        })
    }

    /// With the spins of the two.
    #[inline]
    pub(in crate::dem) fn turning(self, [spin, other_spin]: [f64; 2], radii: [f64; 2]) -> Self {
        Self {
            rolling_rate: spin - other_spin,
            surface_speed: radii[0] * spin + radii[1] * other_spin,
            ..self
        }
    }

    #[inline]
    pub(in crate::dem) fn of(
        apart: [f64; 2],
        squared: f64,
        reach: f64,
        velocity: [f64; 2],
    ) -> Self {
        let distance = squared.sqrt();
        // Centers on one point have no normal, and such an overlap ends the run: no force will do.
        let inverse = 1.0 / if distance > f64::MIN_POSITIVE { distance } else { f64::MIN_POSITIVE };
        Self {
            normal: [apart[0] * inverse, apart[1] * inverse],
            overlap: reach - distance,
            velocity,
            rolling_rate: 0.0,
            surface_speed: 0.0,
        }
    }

    #[inline]
    pub(in crate::dem) fn push(&self, law: &ContactLaw, damping: f64) -> Push {
        let speed = self.velocity[0] * self.normal[0] + self.velocity[1] * self.normal[1];
        let force = motion::contact_force(law.stiffness, damping, self.overlap, speed);
        let force = law.clamped(force);
        Push { force, damping, loss: law.stiffness * self.overlap - force }
    }

    /// Moves the springs of the contact on. `reduced_radius` is r_i r_j/(r_i + r_j) in m, or the disc's own
    /// against a wall; `None` without rolling friction. Slippage counts with the mean of the spring's force before and after it: with
    /// the velocities half a step behind the positions that makes work and energy of the springs agree exactly.
    #[inline]
    pub(in crate::dem) fn rub(
        &self,
        law: &ContactLaw,
        constants: &ContactConstants,
        time_step: f64,
        reduced_radius: Option<f64>,
        push: &Push,
        stretch: &mut Stretch,
    ) -> Rub {
        let pressing = if push.force > 0.0 { push.force } else { 0.0 };
        let damping = law.tangential_damping_share * push.damping;
        let stiffness = law.tangential_stiffness;
        let slide = |before: f64, speed: f64, limit: f64| {
            let travel = speed * time_step;
            let moved: SpringSlider =
                motion::spring_slider(stiffness, damping, before, travel, speed, limit);
            let loss = 0.5 * stiffness * (before + moved.stretch) * moved.slip;
            (moved, loss)
        };
        let [nx, ny] = self.normal;
        let speed = self.velocity[1] * nx - self.velocity[0] * ny - self.surface_speed;
        let (tangential, friction_loss) = slide(stretch[0], speed, constants.friction * pressing);
        let mut rub = Rub {
            force: tangential.force,
            dashpot: tangential.dashpot_force,
            rolling_torque: 0.0,
            elastic: 0.5 * stiffness * tangential.stretch * tangential.stretch,
            friction_loss,
            rolling_loss: 0.0,
        };
        stretch[0] = tangential.stretch;
        if let Some(reduced_radius) = reduced_radius {
            let travel = reduced_radius * self.rolling_rate * time_step;
            let limit = constants.rolling_friction * pressing;
            // Without a dashpot: rolling friction alone takes the energy.
            let rolling = motion::spring_slider(stiffness, 0.0, stretch[1], travel, 0.0, limit);
            rub.rolling_loss = 0.5 * stiffness * (stretch[1] + rolling.stretch) * rolling.slip;
            rub.elastic += 0.5 * stiffness * rolling.stretch * rolling.stretch;
            rub.rolling_torque = reduced_radius * rolling.force;
            stretch[1] = rolling.stretch;
        }
        rub
    }
}

impl Push {
    /// F and D along a normal.
    #[inline]
    pub(in crate::dem) fn along(&self, [nx, ny]: [f64; 2]) -> [f64; 4] {
        [self.force * nx, self.force * ny, self.loss * nx, self.loss * ny]
    }

    /// F and D with those of the tangent (-ny, nx).
    #[inline]
    pub(in crate::dem) fn and(&self, rub: &Rub, [nx, ny]: [f64; 2]) -> [f64; 4] {
        let [fx, fy, dx, dy] = self.along([nx, ny]);
        let (force, loss) = (rub.force, -rub.dashpot);
        [fx - force * ny, fy + force * nx, dx - loss * ny, dy + loss * nx]
    }
}

//! Several bodies that attract each other, about their common center of mass: what they conserve, and what is drawn of them.
//!
//! Energy and momenta are divided by the total mass, which leaves AU and days: m_i stands for G m_i over the sum of all.

use super::motion::{Mutual, Phase, add_scaled, cross, dot, length};
use super::track::{Lost, Scheme, Track, Turns};
use crate::model::SetupError;
use kinetoscope_manifest::model::OrbitBody;
use kinetoscope_recording::channels::{OrbitConserved, OrbitEnergy};
use kinetoscope_recording::frame::{Frame, Level};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery};
use serde::{Deserialize, Serialize};

/// Half the drawing's width over the largest distance from the center of mass at the start: orbits reach farther.
const MARGIN: f64 = 1.3;

/// The bodies, at one instant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Bodies {
    force: Mutual,
    start: Conserved,
    /// Drawn from -reach to reach, AU.
    reach: f64,
    /// AU/day.
    fastest: f64,
    pub(super) track: Track<Vec<f64>>,
}

/// What the exact motion keeps, over the total mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Conserved {
    /// AU^2/day^2.
    kinetic: f64,
    /// AU^2/day^2.
    potential: f64,
    /// AU^2/day.
    angular_momentum: [f64; 3],
    /// sum of m |r| |v|, AU^2/day: what the angular momentum's change is compared with, since it may be zero itself.
    angular_scale: f64,
    /// AU/day.
    momentum: [f64; 3],
    /// AU.
    center: [f64; 3],
    /// Smallest distance of two bodies, AU.
    closest: f64,
}

/// There is no one center to turn about.
struct NoSun;

impl Turns<Vec<f64>> for NoSun {
    fn side(&self, _position: &Vec<f64>) -> bool {
        true
    }

    fn between(&self, _from: &Vec<f64>, _to: &Vec<f64>) -> i64 {
        0
    }
}

impl Conserved {
    /// Sums in the order of the bodies' ids.
    fn of(gravitational_parameters: &[f64], phase: &Phase<Vec<f64>>) -> Self {
        let total: f64 = gravitational_parameters.iter().sum();
        let (places, _) = phase.position.as_chunks::<3>();
        let (velocities, _) = phase.velocity.as_chunks::<3>();
        let mut sums = Self {
            kinetic: 0.0,
            potential: 0.0,
            angular_momentum: [0.0; 3],
            angular_scale: 0.0,
            momentum: [0.0; 3],
            center: [0.0; 3],
            closest: f64::INFINITY,
        };
        for (i, (place, velocity)) in places.iter().zip(velocities).enumerate() {
            let share = gravitational_parameters[i] / total;
            sums.kinetic += 0.5 * share * dot(*velocity, *velocity);
            sums.angular_momentum =
                add_scaled(sums.angular_momentum, cross(*place, *velocity), share);
            sums.angular_scale += share * length(*place) * length(*velocity);
            sums.momentum = add_scaled(sums.momentum, *velocity, share);
            sums.center = add_scaled(sums.center, *place, share);
            for (j, other) in places.iter().enumerate().skip(i + 1) {
                let distance = length(add_scaled(*place, *other, -1.0));
                sums.potential -= share * gravitational_parameters[j] / distance;
                sums.closest = if distance < sums.closest { distance } else { sums.closest };
            }
        }
        sums
    }

    fn energy(&self) -> f64 {
        self.kinetic + self.potential
    }
}

impl Bodies {
    /// The bodies as given, moved so that their center of mass rests in the origin.
    pub(super) fn prepare(bodies: &[OrbitBody], scheme: &Scheme) -> Result<Self, SetupError> {
        let numbers = |of: fn(&OrbitBody) -> [f64; 3]| bodies.iter().flat_map(of).collect();
        let gravitational_parameters: Vec<f64> =
            bodies.iter().map(|body| body.gm_au3_per_day2.get()).collect();
        let mut phase = Phase {
            position: numbers(|body| body.position_au.map(|component| component.get())),
            velocity: numbers(|body| body.velocity_au_per_day.map(|component| component.get())),
        };
        let given = Conserved::of(&gravitational_parameters, &phase);
        for axis in 0..phase.position.len() {
            phase.position[axis] -= given.center[axis % 3];
            phase.velocity[axis] -= given.momentum[axis % 3];
        }
        let start = Conserved::of(&gravitational_parameters, &phase);
        check_start(&start)?;
        let largest = |numbers: &[f64]| {
            let lengths = numbers.as_chunks::<3>().0.iter().map(|vector| length(*vector));
            lengths.fold(0.0, |most, next| if next > most { next } else { most })
        };
        Ok(Self {
            start,
            reach: MARGIN * largest(&phase.position),
            fastest: largest(&phase.velocity),
            force: Mutual { gravitational_parameters },
            track: Track::new(phase, scheme),
        })
    }

    pub(super) fn advance(&mut self, scheme: &Scheme, steps: u64) -> Result<(), Lost> {
        self.track.walk(&self.force, scheme, steps, &NoSun)
    }

    pub(super) fn observe(&self, frame: &mut Frame) {
        let Phase { position, velocity } = &self.track.phase;
        let rows = position.as_chunks::<3>().0.iter().zip(velocity.as_chunks::<3>().0);
        for ([x, y, z], [vx, vy, vz]) in rows {
            frame.push_state(&[*x, *y, *z, *vx, *vy, *vz]);
        }
        let now = Conserved::of(&self.force.gravitational_parameters, &self.track.phase);
        frame.push(&OrbitEnergy {
            kinetic_au2_per_day2: now.kinetic,
            potential_au2_per_day2: now.potential,
            total_au2_per_day2: now.energy(),
            drift_ppm: (now.energy() - self.start.energy()) / self.start.energy().abs() * 1e6,
        });
        let turned = add_scaled(now.angular_momentum, self.start.angular_momentum, -1.0);
        let [x, y, z] = now.angular_momentum;
        frame.push(&OrbitConserved {
            angular_momentum_x_au2_per_day: x,
            angular_momentum_y_au2_per_day: y,
            angular_momentum_z_au2_per_day: z,
            angular_momentum_change_ppm: length(turned) / self.start.angular_scale * 1e6,
            momentum_au_per_day: length(now.momentum),
            center_of_mass_au: length(now.center),
            closest_au: now.closest,
            force_evaluations: self.track.evaluations,
        });
    }

    pub(super) fn scenery(&self) -> Scenery {
        let reach = self.reach;
        Scenery {
            walls: Vec::new(),
            view: [[-reach, -reach], [reach, reach]],
            drawn_radius: DrawnRadius::Fixed(0.02 * (2.0 * reach)),
            speed_range_top: 1.5 * self.fastest,
            speed_unit: "AU/d",
            arrows: true,
            force_range_top: None,
            trail: true,
        }
    }

    pub(super) fn announce(&self, frame: &mut Frame) {
        frame.log(
            Level::Info,
            format!(
                "{} bodies that attract each other, about their center of mass; energy {:.6e} AU^2/day^2 a unit of mass, \
                 closest pair {:.4} AU",
                self.force.gravitational_parameters.len(),
                self.start.energy(),
                self.start.closest
            ),
        );
    }
}

/// Refuses bodies that lie on each other, or numbers beyond what floating point can hold.
fn check_start(start: &Conserved) -> Result<(), SetupError> {
    let energy = start.energy();
    if start.closest > 0.0 && energy.is_finite() && energy != 0.0 && start.angular_scale > 0.0 {
        return Ok(());
    }
    Err(SetupError(format!(
        "bodies: with the closest two {} AU apart, a kinetic energy of {:e} and a potential energy of {:e} AU^2/day^2 a unit of \
         mass there is no motion to follow. Bodies must lie apart, one of them must move against the others, and the energy \
         must not be zero.",
        start.closest, start.kinetic, start.potential
    )))
}

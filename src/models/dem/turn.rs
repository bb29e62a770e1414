//! The equation of motion of the spins, discretised as that of the centres: w' = w + alpha dt. It is written for any width of
//! instructions.

use super::forces::{Forces, Own};
use super::motion;
use crate::vector_width::{self, Kernel};

/// Discs whose powers are summed side by side: the order of the sums does not depend on how many are taken at a time.
const STRANDS: usize = 4;

/// Turns a block's discs on by a step, and returns the power that dashpots take from the spins, W.
pub(super) fn turn(own: &mut Own<'_>, forces: &Forces, time_step: f64) -> f64 {
    let Forces { tangential, rolling, .. } = forces;
    let (spins, masses, radii) = (&mut *own.spins, own.masses, own.radii);
    let power = vector_width::run(Turn { spins, masses, radii, tangential, rolling, time_step });
    (power[0] + power[2]) + (power[1] + power[3])
}

/// Torque on a disc, N m, and the dashpots' share of it: the tangential forces act on the rim.
#[inline(always)]
pub(super) fn torque(radius: f64, [force, dashpot]: [f64; 2], rolling: f64) -> [f64; 2] {
    [rolling - radius * force, radius * dashpot]
}

/// The loop over a block.
struct Turn<'a> {
    spins: &'a mut [f64],
    masses: &'a [f64],
    radii: &'a [f64],
    tangential: &'a [[f64; 2]],
    rolling: &'a [f64],
    time_step: f64,
}

impl Kernel for Turn<'_> {
    type Output = [f64; STRANDS];

    #[inline(always)]
    fn run(self) -> [f64; STRANDS] {
        let Self { spins, masses, radii, tangential, rolling, time_step } = self;
        let half = 0.5 * time_step;
        let mut power = [0.0; STRANDS];
        let (spins, last_spins) = spins.as_chunks_mut::<STRANDS>();
        let (masses, last_masses) = masses.as_chunks::<STRANDS>();
        let (radii, last_radii) = radii.as_chunks::<STRANDS>();
        let (tangential, last_tangential) = tangential.as_chunks::<STRANDS>();
        let (rolling, last_rolling) = rolling.as_chunks::<STRANDS>();
        let bodies = spins.iter_mut().zip(masses).zip(radii);
        for (((spins, masses), radii), (tangential, rolling)) in
            bodies.zip(tangential.iter().zip(rolling))
        {
            for disc in 0..STRANDS {
                let [torque, loss] = torque(radii[disc], tangential[disc], rolling[disc]);
                let alpha = motion::angular_acceleration(torque, masses[disc], radii[disc]);
                power[disc] += loss * (spins[disc] + alpha * half);
                spins[disc] += alpha * time_step;
            }
        }
        // The few that do not fill a chunk.
        let bodies = last_spins.iter_mut().zip(last_masses).zip(last_radii);
        let friction = last_tangential.iter().zip(last_rolling);
        for ((((spin, &mass), &radius), (&tangential, &rolling)), power) in
            bodies.zip(friction).zip(&mut power)
        {
            let [torque, loss] = torque(radius, tangential, rolling);
            let alpha = motion::angular_acceleration(torque, mass, radius);
            *power += loss * (*spin + alpha * half);
            *spin += alpha * time_step;
        }
        power
    }
}

/// Speeds r w of the rims of discs, m/s.
pub(super) fn find_rim_speeds(speeds: &mut Vec<f64>, radii: &[f64], spins: &[f64]) {
    speeds.resize(radii.len(), 0.0);
    vector_width::run(RimSpeeds { speeds, radii, spins });
}

struct RimSpeeds<'a> {
    speeds: &'a mut [f64],
    radii: &'a [f64],
    spins: &'a [f64],
}

impl Kernel for RimSpeeds<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for ((speed, radius), spin) in self.speeds.iter_mut().zip(self.radii).zip(self.spins) {
            *speed = radius * spin;
        }
    }
}

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
        let (time_step, half) = (self.time_step, 0.5 * self.time_step);
        let mut power = [0.0; STRANDS];
        let chunks = self.spins.chunks_mut(STRANDS).zip(self.masses.chunks(STRANDS));
        let friction = self.tangential.chunks(STRANDS).zip(self.rolling.chunks(STRANDS));
        for (((spins, masses), radii), (tangential, rolling)) in
            chunks.zip(self.radii.chunks(STRANDS)).zip(friction)
        {
            let bodies = masses.iter().zip(radii).zip(tangential.iter().zip(rolling));
            for ((spin, ((&mass, &radius), (&tangential, &rolling))), power) in
                spins.iter_mut().zip(bodies).zip(&mut power)
            {
                let [torque, loss] = torque(radius, tangential, rolling);
                let alpha = motion::angular_acceleration(torque, mass, radius);
                *power += loss * (*spin + alpha * half);
                *spin += alpha * time_step;
            }
        }
        power
    }
}

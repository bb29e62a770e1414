//! The equation of motion of the spins, discretised as that of the centers: w' = w + alpha dt. It is written for any width of
//! instructions.

use crate::dem::forces::{Forces, Own};
use crate::dem::motion;
use crate::simd::dispatch::{self, Kernel, each};

/// Discs whose powers are summed side by side: the order of the sums does not depend on how many are taken at a time.
const STRANDS: usize = 4;

/// Turns a block's discs on by a step, and returns the power that dashpots take from the spins, W.
pub(super) fn turn(own: &mut Own<'_>, forces: &Forces, time_step: f64) -> f64 {
    let Forces { tangential, rolling, .. } = forces;
    if tangential.is_empty() {
        return 0.0;
    }
    let (spins, masses, radii) = (&mut *own.spins, own.masses, own.radii);
    let power = dispatch::run(Turn { spins, masses, radii, tangential, rolling, time_step });
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

/// Numbers of as many discs as are taken side by side.
type Strand = [f64; STRANDS];

/// Turns discs, and returns the power that dashpots take from each.
#[inline(always)]
fn move_on(
    spins: &mut Strand,
    masses: Strand,
    radii: Strand,
    tangential: [[f64; 2]; STRANDS],
    rolling: Strand,
    time_step: f64,
) -> Strand {
    let half = 0.5 * time_step;
    let before = *spins;
    let torques = each(|at| torque(radii[at], tangential[at], rolling[at])[0]);
    let losses = each(|at| torque(radii[at], tangential[at], rolling[at])[1]);
    let alpha = each(|at| motion::angular_acceleration(torques[at], masses[at], radii[at]));
    *spins = each(|at| before[at] + alpha[at] * time_step);
    each(|at| losses[at] * (before[at] + alpha[at] * half))
}

impl Kernel for Turn<'_> {
    type Output = Strand;

    #[inline(always)]
    fn run(self) -> Strand {
        let Self { spins, masses, radii, tangential, rolling, time_step } = self;
        let mut power = [0.0; STRANDS];
        let (spins, last_spins) = spins.as_chunks_mut::<STRANDS>();
        let (masses, last_masses) = masses.as_chunks::<STRANDS>();
        let (radii, last_radii) = radii.as_chunks::<STRANDS>();
        let (tangential, last_tangential) = tangential.as_chunks::<STRANDS>();
        let (rolling, last_rolling) = rolling.as_chunks::<STRANDS>();
        let bodies = spins.iter_mut().zip(masses).zip(radii);
        let friction = tangential.iter().zip(rolling);
        for (((spins, &masses), &radii), (&tangential, &rolling)) in bodies.zip(friction) {
            let taken = move_on(spins, masses, radii, tangential, rolling, time_step);
            let sum = power;
            power = each(|at| sum[at] + taken[at]);
        }
        // The few that do not fill a strand each, beside discs on which nothing acts.
        let few = last_spins.len();
        let (mut spins, mut masses, mut radii) = ([0.0; STRANDS], [1.0; STRANDS], [1.0; STRANDS]);
        let (mut tangential, mut rolling) = ([[0.0; 2]; STRANDS], [0.0; STRANDS]);
        spins[..few].copy_from_slice(last_spins);
        masses[..few].copy_from_slice(last_masses);
        radii[..few].copy_from_slice(last_radii);
        tangential[..few].copy_from_slice(last_tangential);
        rolling[..few].copy_from_slice(last_rolling);
        let taken = move_on(&mut spins, masses, radii, tangential, rolling, time_step);
        last_spins.copy_from_slice(&spins[..few]);
        each(|at| power[at] + taken[at])
    }
}

/// Speeds r w of the rims of discs, m/s.
pub(super) fn find_rim_speeds(speeds: &mut Vec<f64>, radii: &[f64], spins: &[f64]) {
    speeds.resize(radii.len(), 0.0);
    dispatch::run(RimSpeeds { speeds, radii, spins });
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

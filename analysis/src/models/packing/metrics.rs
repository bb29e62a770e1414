//! Metrics of a packing run.

use super::laws as law;
use crate::metric::definition::{Definition, definitions};

definitions! {
    TEMPERATURE_INITIAL: "temperature.initial", "", "granular temperature at the start", "T = <v^2>/2, first frame", [], 0.0;
    TEMPERATURE_FINAL: "temperature.final", "", "granular temperature at the end", "T = <v^2>/2, last frame", [law::COOLING], 0.0;
    TEMPERATURE_RATIO: "temperature.final_over_initial", "1", "ratio of the granular temperature at the end to that at the start", "<v^2>, last frame over first", [law::COOLING], 0.0;
    MEAN_SQUARE_VELOCITY_INITIAL: "mean_square_velocity.initial", "", "mean square velocity at the start", "<v^2>, first frame: the packing exercise's temperature", [], 0.0;
    MEAN_SQUARE_VELOCITY_FINAL: "mean_square_velocity.final", "", "mean square velocity at the end", "<v^2>, last frame: the packing exercise's temperature", [], 0.0;
    ENERGY_DRIFT: "energy.drift_relative", "1", "change of the kinetic energy", "kinetic energy, last frame against the first", [law::ELASTIC_ENERGY], 1e-9;
    ENERGY_RESIDUAL: "energy.residual_relative", "1", "error of the energy balance", "/energy, last frame: kinetic + potential + dissipated - from the floor - total at the start, over the energy exchanged; in gravity", [law::ENERGY_BALANCE], 1e-9;
    ENERGY_FROM_FLOOR: "energy.from_floor", "", "energy gained from the floor", "/energy, last frame: work of a shaken floor, or heat of one with a temperature; in gravity", [], 0.0;
    ENERGY_DISSIPATED: "energy.dissipated", "", "energy lost in collisions", "/energy, last frame: of collisions with restitution, of two discs and with obstacles; in gravity", [], 0.0;
    MEAN_HEIGHT: "height.mean", "", "mean height of the centers above their lowest position", "/state: <y> above the lowest position of a center, mean over the last three quarters of the run, error by blocking; in gravity", [law::BALANCE_OF_WEIGHT], 0.0;
    A2_FINAL: "a2.final", "1", "excess of the fourth moment of the velocities at the end", "<v^4>/(2 <v^2>^2) - 1, last frame", [], 0.0;
    A2_MEAN: "a2.mean", "1", "mean excess of the fourth moment of the velocities", "/per_collision, or sums over all collisions in /temperature: mean over time (over events for e < 1) after 5 events per disc; error by blocking, for e < 1 only in boxes in which no shear flow grows", [law::A2_FIXED_ENERGY, law::A2_FIXED_MOMENTUM, law::A2_COOLING], 0.0;
    COLLISION_RATE: "pair_collision_rate_per_disc", "", "collision rate per disc", "/collisions: pair collisions per disc and unit of time; conditional error at the energy of the run by blocking, to which the scatter of drawn energies is added", [law::COLLISION_RATE, law::COLLISION_RATE_OF_SIZES], 0.0;
    MEAN_FREE_TIME: "mean_free_time", "", "mean time between two collisions of a disc", "1 over pair_collision_rate_per_disc: mean time between two collisions with other discs", [law::COLLISION_RATE, law::COLLISION_RATE_OF_SIZES], 0.0;
    CONTACT_VALUE: "contact_value.from_collision_rate", "1", "enhancement of the collision rate by the density", "pair_collision_rate_per_disc over 2 sqrt(pi) n <d> sqrt(T) of discs without walls: χ, of several sizes <d_ij χ_ij>/<d>", [law::CONTACT_VALUE], 0.0;
    WALL_COLLISION_RATE: "wall_collision_rate_per_disc", "", "rate of wall collisions per disc", "/collisions: wall collisions per disc and unit of time; errors as of pair_collision_rate_per_disc", [law::WALL_COLLISION_RATE], 0.0;
    COMPRESSIBILITY: "compressibility_factor", "1", "ratio of the pressure to that of an ideal gas", "/pressure: P A/(N m T) by the pair virial since the start; conditional error by blocking, to which the scatter of the drift energy of a periodic box is added; unknown scatter of drawn radii", [law::COMPRESSIBILITY, law::COMPRESSIBILITY_OF_SIZES, law::COMPRESSIBILITY_AT_FREEZING], 0.0;
    COMPRESSIBILITY_BY_RATE: "compressibility_factor.from_collision_rate", "1", "ratio of the pressure to that of an ideal gas, from the collision rate", "1 + (1 + e)/2 (sqrt(pi)/4) d ν/sqrt(T) from the collision rate; of several sizes d is replaced by the mean distance of centers in a collision, by the contact values of the law; errors as of compressibility_factor", [law::VIRIAL_IDENTITY], 0.0;
    PRESSURE_VIRIAL: "pressure.virial", "", "pressure between the discs", "/pressure: by the pair virial since the start, over the area of the box with that of obstacles, whose impulses do not count", [], 0.0;
    PRESSURE_WALL: "pressure.wall", "", "pressure on the walls", "/pressure: impulse on the walls since the start, not on obstacles", [], 0.0;
    PRESSURE_REDUCED: "pressure.reduced", "1", "pressure in units of the temperature per squared diameter", "P d^2/(m T) = (4 φ/pi)(1 + (Z - 1)(N - 1)/N), with the temperature of velocities whose sum is zero and Z as compressibility_factor; discs of one size in a periodic box, φ of 0.25 or more", [law::PRESSURE_OF_FLUID, law::PRESSURE_AT_FREEZING], 0.0;
    PACKING_FRACTION: "packing_fraction", "1", "packing fraction", "φ = N pi d^2 / (4A) with the area A of the box, that of obstacles included", [], 0.0;
    PSI6_GLOBAL: "psi6.global", "1", "hexagonal order of the whole system", "/state: |mean over discs of psi6|, psi6 = mean of exp(6 i θ) over neighbors within 1.5 diameters, of discs of one size; mean over the sampled frames, error by blocking", [], 0.0;
    PSI6_LOCAL: "psi6.local", "1", "hexagonal order of the neighbors of a disc", "/state: mean over discs of |psi6|, over the sampled frames, error by blocking", [], 0.0;
    PAIR_CORRELATION: "pair_correlation.near_contact", "1", "density of neighbors near contact, relative to the mean density", "/state: g(r) over 1 to 1.1 diameters: pairs within 1.1 over those between 1 and 1.1 of as many points at random in the room of the centers, mean over the sampled frames, error by blocking", [], 0.0;
    CONTACT_VALUE_FROM_PAIRS: "contact_value.from_pairs", "1", "density of neighbors at contact, relative to the mean density", "/state: g(r) at contact by a parabola with the same means over three shells of 0.03 diameters, mean over the sampled frames, error by blocking; discs of one size in a periodic box, φ of 0.25 or more", [law::CONTACT_VALUE], 0.0;
    LONGEST_WAVES: "structure_factor.longest_waves", "1", "strength of the longest density waves, relative to points at random", "/state: S(Q) = |sum of exp(i Q . r)|^2/N for the longest wave along each side, mean of both and over the frames, error by blocking; discs of one size in a periodic box, φ of 0.25 or more", [law::COMPRESSIBILITY_OF_WAVES], 0.0;
    HEXATIC_EXPONENT: "psi6.correlation_exponent", "1", "exponent with which the hexagonal order decays over the distance", "/state: -log2 of the mean product of psi6 at distances from 1/4 to 1/2 of the shorter side over that from 1/8 to 1/4, at least 1.5 diameters, the ratio over the sampled frames, error by blocking; 0 in a crystal, at most 1/4 in a large hexatic; discs of one size in a periodic box, φ of 0.25 or more", [], 0.0;
    DISPLACEMENT: "mean_square_displacement.final", "", "mean square displacement at the end", "/state: mean |r - r(0)|^2 of the first 1000 discs, last frame; error from their scatter, up to a packing fraction of 0.45, above which neighbors move together, and for cooling discs in boxes so small that none flow together; in a periodic box by the nearest images from frame to frame, and none where a disc may have gone a quarter of a side between two", [], 0.0;
    DIFFUSION_GREEN_KUBO: "self_diffusion.from_velocities", "", "diffusion coefficient from the velocities", "/state: D = 1/2 integral of <v(0) . v(t)> over ten mean free times by the trapezoidal rule, first 1000 discs, mean over consecutive windows, error by blocking; elastic discs of one size in a periodic box with zero momentum, frames at most a quarter of a mean free time apart", [law::SELF_DIFFUSION], 0.0;
    DIFFUSION_EINSTEIN: "self_diffusion.from_displacements", "", "diffusion coefficient from the displacements", "/state: D = growth of mean |r - r(0)|^2 over 4 t, from five to ten mean free times after the start of the window; otherwise as self_diffusion.from_velocities", [law::SELF_DIFFUSION], 0.0;
    MEAN_FREE_PATH: "mean_free_path", "", "mean path between two collisions of a disc", "/events and /state: path of all discs over their collisions with other discs, after 5 events per disc, of elastic discs of one size, not in gravity; error by blocking over frames", [law::FREE_PATH], 0.0;
    LYAPUNOV: "lyapunov.exponent", "", "largest Lyapunov exponent", "/events and /state: mean growth rate of the logarithm of an infinitesimal difference, which is moved exactly through flights and collisions (Dellago, Posch and Hoover 1996), after the first quarter of the run, not in gravity; error by 8 blocks or more and ln(4) over the time", [law::SINAI, law::CHAINS], 0.0;
    DIVERGENCE_COLLISIONS: "lyapunov.divergence_collisions", "1", "collisions per disc until a rounding error has grown to 1", "/events: ln(2^53) over the growth of the logarithm of a small difference per collision of a disc; elastic discs without gravity; none where the growth is compatible with 0", [], 0.0;
    DIVERGENCE_TIME: "lyapunov.divergence_time", "", "time after which two runs that differ by a rounding error are unrelated", "ln(2^53) over lyapunov.exponent; none where the exponent is compatible with 0", [], 0.0;
    VELOCITY_AUTOCORRELATION: "velocity_autocorrelation.final", "1", "correlation of the velocities with those at the start", "/state: sum of v . v(0) over sum of v(0)^2 of the first 1000 discs, last frame", [], 0.0;
}

/// Metrics that follow from the states of all frames.
pub(super) const NEED_ALL_STATES: &[&Definition] = &[
    PSI6_GLOBAL,
    PSI6_LOCAL,
    CONTACT_VALUE_FROM_PAIRS,
    LONGEST_WAVES,
    HEXATIC_EXPONENT,
    PAIR_CORRELATION,
    MEAN_HEIGHT,
    DISPLACEMENT,
    DIFFUSION_GREEN_KUBO,
    DIFFUSION_EINSTEIN,
    MEAN_FREE_PATH,
    LYAPUNOV,
    DIVERGENCE_COLLISIONS,
    DIVERGENCE_TIME,
];

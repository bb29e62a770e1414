//! Metrics of an orbit run.

use super::laws as law;
use crate::metric::definition::{Definition, definitions};

definitions! {
    ENERGY_DRIFT: "energy.drift_relative", "1", "change of the energy", "/state: (E - E_0)/|E_0|, last frame", [law::EULER_ENERGY, law::ENERGY], 1e-13;
    DRIFT_PER_REVOLUTION: "energy.drift_per_revolution", "1", "relative change of the energy per revolution", "/state: ((E_0/E)^3 - 1)/3 per initial period: the initial rate", [law::EULER_ENERGY_PER_REVOLUTION], 0.0;
    MAX_ENERGY_ERROR: "energy.max_error_relative", "1", "largest relative error of the energy", "/state: largest |E - E_0|/|E_0| of the frames", [law::SYMPLECTIC_ENERGY], 0.0;
    ANGULAR_MOMENTUM_DRIFT: "angular_momentum.drift_relative", "1", "change of the angular momentum", "/state: (L - L_0)/L_0, last frame", [law::EULER_ANGULAR_MOMENTUM, law::ANGULAR_MOMENTUM], 1e-13;
    MIN_RADIUS: "radius.min", "AU", "least distance from the Sun", "/orbit: least |r|, found within the steps", [], 0.0;
    MAX_RADIUS: "radius.max", "AU", "largest distance from the Sun", "/orbit: largest |r|, found within the steps", [], 0.0;
    POSITION_ERROR: "position_error.final", "AU", "distance from the exact place at the end", "/state against the exact Kepler solution through the first frame, last frame", [law::EXACT], 1e-9;
    PHASE_ERROR: "phase_error.final", "rad", "angle to the exact orbit at the end", "/state: angle minus that of the exact solution, last frame; whole turns from /orbit, counted at every step", [law::EXACT], 1e-9;
    ECCENTRICITY_CHANGE: "eccentricity_vector.change", "1", "change of the eccentricity vector", "/state: |v × L/GM - r/|r||, change from the first frame to the last", [law::EXACT], 1e-9;
    SEMI_MAJOR_AXIS: "semi_major_axis", "AU", "semi-major axis", "/orbit: half the sum of min |r| and max |r|, of a run of a revolution or more", [], 0.0;
    AXIS_GROWTH: "semi_major_axis.growth_relative", "1", "relative growth of the semi-major axis", "/state: a/a_0 - 1 with a = -GM/(2E), last frame", [law::EULER_AXIS], 1e-13;
    PERIOD: "period.measured", "d", "period", "/orbit: time between passes of the direction of the start, found within the steps, mean over the revolutions", [law::KEPLERS_THIRD], 0.0;
    THIRD_LAW: "third_law.ratio", "1", "ratio of the two sides of Kepler's third law", "/orbit: 4 pi^2 over GM, times the cube of half the sum of min |r| and max |r|, over the square of the period", [law::KEPLERS_THIRD], 0.0;
    FORCE_EVALUATIONS: "force_evaluations", "1", "number of force evaluations", "/orbit or /conserved: force evaluations, last frame", [], 0.0;
    ANGULAR_MOMENTUM_CHANGE: "angular_momentum.max_change_relative", "1", "largest change of the angular momentum", "/state of several bodies: largest |L - L_0| / sum of m |r| |v| at the start", [law::MUTUAL_ANGULAR_MOMENTUM], 1e-12;
    RETURN_DISTANCE: "return_distance.final", "AU", "largest distance of a body from its start at the end", "/state of several bodies: largest distance of a body from its start, last frame", [], 0.0;
    CLOSEST_APPROACH: "closest_approach", "AU", "least distance between two bodies", "/closest_approach of several bodies: least separation of two bodies of which one attracts, without pairs with a body of more than half of the mass if others attract; found within its step", [], 0.0;
    CLOSEST_APPROACH_TIME: "closest_approach.time", "d", "time of the closest approach", "/closest_approach of several bodies: time of closest_approach", [], 0.0;
    CLOSEST_APPROACH_HILL_RADII: "closest_approach.hill_radii", "1", "least distance between two bodies in Hill radii", "/closest_approach of several bodies: least separation over the mutual Hill radius, mean distance from the central body times the cube root of the masses over three times the central one; of any pair", [], 0.0;
    CLOSEST_APPROACH_TIME_STEPS: "closest_approach.time_steps", "1", "number of time steps during the closest approach", "/closest_approach of several bodies: time steps in which the bodies of closest_approach move by their separation; below about ten, the method does not follow the encounter", [], 0.0;
    LYAPUNOV: "lyapunov.exponent", "1/d", "largest Lyapunov exponent", "/divergence: mean growth rate of the logarithm of the distance to a twin (Benettin, Galgani and Strelcyn 1976), after the first quarter of the run; error by 8 blocks or more and ln(4) over the time", [], 0.0;
    DIVERGENCE_TIME: "lyapunov.divergence_time", "d", "time after which two runs that differ by a rounding error are unrelated", "ln(2^53) over lyapunov.exponent; none where the exponent is compatible with 0", [], 0.0;
    APSIDAL_ROTATION: "apsidal_rotation", "rad", "rotation of the perihelion", "/state: angle by which the eccentricity vector has turned about L of the start, in (-pi, pi], first frame to last", [law::EXACT], 1e-7;
}

/// Metrics that follow from the states of all frames.
pub(super) const NEED_ALL_STATES: &[&Definition] = &[MAX_ENERGY_ERROR, ANGULAR_MOMENTUM_CHANGE];

//! What is measured of an orbit.

use super::definitions;
use crate::laws::orbit as law;

definitions! {
    ENERGY_DRIFT: "energy.drift_relative", "1", "/state: (E - E0)/|E0|, last frame", [law::EULER_ENERGY, law::ENERGY], 1e-9;
    DRIFT_PER_REVOLUTION: "energy.drift_per_revolution", "1", "/state: ((E0/E)^3 - 1)/3 a period of the start: the rate at the start", [law::EULER_ENERGY_PER_REVOLUTION], 0.0;
    LARGEST_ENERGY_ERROR: "energy.largest_error_relative", "1", "/state: largest |E - E0|/|E0| of the frames", [law::SYMPLECTIC_ENERGY], 0.0;
    ANGULAR_MOMENTUM_DRIFT: "angular_momentum.drift_relative", "1", "/state: (L - L0)/L0, last frame", [law::EULER_ANGULAR_MOMENTUM, law::ANGULAR_MOMENTUM], 1e-9;
    LEAST_RADIUS: "radius.min", "AU", "/state: least |r| of the frames", [], 0.0;
    LARGEST_RADIUS: "radius.max", "AU", "/state: largest |r| of the frames", [], 0.0;
    POSITION_ERROR: "position_error.final", "AU", "/state against the exact Kepler solution through the first frame, last frame", [law::EXACT], 1e-9;
    PHASE_ERROR: "phase_error.final", "rad", "/state: angle minus that of the exact solution, last frame", [law::EXACT], 1e-9;
    ECCENTRICITY_CHANGE: "eccentricity_vector.change", "1", "/state: |v x L/GM - r/|r||, change from the first frame to the last", [law::EXACT], 1e-9;
    PERIHELION_TURN: "eccentricity_vector.turn", "rad", "/state: angle by which the eccentricity vector has turned about L of the start, in (-pi, pi], first frame to last", [law::EXACT], 1e-7;
}

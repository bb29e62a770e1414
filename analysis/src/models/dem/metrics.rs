//! Metrics of a DEM run.

use super::laws as law;
use crate::metric::definition::{Definition, definitions};

definitions! {
    KINETIC: "energy.kinetic", "J", "kinetic energy at the end", "/energy, last frame", [], 0.0;
    GRAVITATIONAL: "energy.gravitational", "J", "gravitational energy at the end", "/energy, last frame", [], 0.0;
    ELASTIC: "energy.elastic", "J", "elastic energy at the end", "/energy, last frame", [], 0.0;
    DISSIPATED: "energy.dissipated", "J", "energy dissipated in contacts", "/energy, last frame", [], 0.0;
    FRICTION: "energy.friction", "J", "energy dissipated by friction", "/energy, last frame: the part of energy.dissipated due to friction", [], 0.0;
    FRICTION_FRACTION: "energy.friction_fraction", "1", "fraction of the dissipated energy that is due to friction", "/energy, last frame: energy.friction over energy.dissipated", [], 0.0;
    ROLLING: "energy.rolling", "J", "energy dissipated by rolling friction", "/energy, last frame: the part of energy.dissipated due to rolling friction", [], 0.0;
    ROTATIONAL: "energy.rotational", "J", "energy of rotation at the end", "/state: sum of I Ω^2/2, the part of energy.kinetic due to rotation, last frame", [], 0.0;
    WALL_WORK: "energy.wall_work", "J", "work of the moving walls", "/energy, last frame: wall work since the start", [], 0.0;
    DISCS_REMOVED: "discs_removed", "1", "number of discs that have left", "/wall_forces: discs removed through the outlet, last frame", [], 0.0;
    TOTAL_CHANGE: "energy.total_change_relative", "1", "relative change of the mechanical energy", "/energy: change of the mechanical energy, minus inserted energy, over the initial and inserted energy, last frame", [], 0.0;
    RELATIVE_RESIDUAL: "energy.residual_relative", "1", "error of the energy balance at the end", "/energy: change of the energy balance over the initial and inserted energy, last frame", [law::ENERGY_BALANCE], 1e-9;
    RESIDUAL: "energy.residual", "J", "error of the energy balance at the end", "/energy: change of the energy balance from the first to the last frame", [law::ENERGY_BALANCE], 0.0;
    RESIDUAL_PER_REBOUND: "energy.residual_per_rebound", "J", "error of the energy balance per rebound", "/energy and /state: energy-balance error divided by the number of rebounds of a single disc", [law::ENERGY_BALANCE], 0.0;
    MAX_RESIDUAL: "energy.max_residual_relative", "1", "largest error of the energy balance", "/energy: maximum size of the energy-balance error over the initial and inserted energy", [law::ENERGY_BALANCE], 1e-9;
    KINETIC_DISAGREEMENT: "energy.kinetic_disagreement_relative", "1", "difference between two records of the kinetic energy", "kinetic energy of /state against /energy, largest over frames, over the energy at the start and of all inserted discs", [law::KINETIC_ENERGY], 1e-9;
    RESTITUTION: "restitution.measured", "1", "measured restitution", "/state: sqrt(energy after / before) of each rebound of a single disc, mean", [law::RESTITUTION], 0.0;
    CONTACT_DURATION: "contact_duration.measured", "s", "duration of a contact", "/state: from touch to parting of each rebound of a single disc, by its parabolas before and after, mean", [law::CONTACT_DURATION, law::HERTZ_DURATION], 0.0;
    IMPACT_VELOCITY: "impact_velocity", "m/s", "velocity of the impacts", "/state: sqrt(2 E/m) of a single disc before each rebound, with its energy E above the touching height, mean", [], 0.0;
    MAX_OVERLAP: "max_overlap_over_radius", "1", "largest overlap of two discs in units of the radius", "/contact_statistics: largest since the start", [], 0.0;
    COORDINATION_NUMBER: "coordination_number", "1", "number of contacts per disc", "/contact_statistics: contacts per disc, with discs and walls, (2 pair_contacts + wall_contacts)/N, last frame", [], 0.0;
    PAIR_COORDINATION_NUMBER: "pair_coordination_number", "1", "number of contacts per disc with other discs", "/contact_statistics: contacts per disc with other discs only, 2 pair_contacts/N, last frame", [], 0.0;
    GRANULAR_TEMPERATURE: "granular_temperature", "m^2/s^2", "granular temperature at the end", "/temperature: <(v - <v>)^2> / 2, last frame", [], 0.0;
    GRANULAR_TEMPERATURE_START: "granular_temperature.start", "m^2/s^2", "granular temperature at the start", "/temperature: <(v - <v>)^2> / 2, first frame; error of drawn velocities by their chi-square distribution", [law::DRAWN_TEMPERATURE], 0.0;
    PACKING_FRACTION: "packing_fraction", "1", "packing fraction of the box", "/state: discs' area over the box's", [], 0.0;
    BED_HEIGHT: "bed.height", "m", "height of the bed", "/state: twice the height of the discs' center of area over the floor, last frame", [], 0.0;
    BED_PACKING_FRACTION: "bed.packing_fraction", "1", "packing fraction of the bed", "/state: discs' area over box width times bed.height, last frame", [], 0.0;
    WEIGHT: "bed.weight", "N", "weight of the bed", "/state: sum of the weights of the discs, last frame", [], 0.0;
    FLOOR_FORCE: "floor.force", "N", "force on the floor", "/state: sum of k_n times overlap with the floor, less cohesion, last frame", [law::WEIGHT], 0.0;
    FLOOR_STRESS: "floor.stress", "N/m", "stress on the floor", "/state: floor.force over the box's width", [law::WEIGHT_PER_WIDTH], 0.0;
    SIDE_WALL_STRESS: "side_wall.stress", "N/m", "stress on the side walls", "/state: sum of k_n times overlap with both side walls, less cohesion, over twice bed.height, last frame", [], 0.0;
    STRESS_AT_FLOOR: "stress.vertical_at_floor", "N/m", "vertical stress at the floor", "/contact_forces and /state: S_yy = (sum of F_y l_y + sum of m u_y u_y)/A (Love 1927, Weber 1966; kinetic part Goldhirsch 2010) in the lowest layer, a mean diameter thick, with the branches l of the contacts as far as they lie in it; mean over the frames of the last tenth of the run; conditional error from 64 frames by the vertical momentum above at both ends of that time", [law::WEIGHT_ABOVE], 0.0;
    STRESS_AT_MID_HEIGHT: "stress.vertical_at_mid_height", "N/m", "vertical stress at half the weight", "the same in the lowest layer that has at most half of the weight above it", [law::WEIGHT_ABOVE], 0.0;
    LATERAL_STRESS_RATIO: "stress.lateral_ratio", "1", "ratio of horizontal to vertical stress", "the same: sum of S_xx over sum of S_yy of all layers", [], 0.0;
    OVERBURDEN_DEVIATION: "stress.overburden_deviation", "1", "largest difference between vertical stress and weight above", "the same: max |S_yy - weight above/width| of a layer, over the weight of all discs/width: what walls carry, or what still moves", [], 0.0;
    PISTON_FORCE: "piston.force", "N", "force on the moving floor", "/wall_forces: mean upward force of the first level wall that moves, over the last tenth of the run", [law::WEIGHT], 0.0;
    ORIFICE_WIDTH: "outlet.width", "m", "width of the orifice", "manifest: width of the opening between two level walls at rest", [], 0.0;
    EFFECTIVE_WIDTH: "outlet.effective_width", "m", "width of the orifice less 1.4 diameters", "manifest: outlet.width less 1.4 mean diameters, Beverloo's empty annulus", [], 0.0;
    DISCHARGE_RATE: "outlet.discharge_rate", "1/s", "discharge rate", "/wall_forces: slope of the number of removed discs between a tenth and six tenths of the last; error by blocking of the numbers between frames", [], 0.0;
    COOLING_RATE: "cooling.rate", "1/s", "cooling rate", "/temperature: slope of sqrt(T_0/T) - 1 over time, through the origin", [law::HAFF], 0.0;
    VELOCITY_TRANSMISSION: "row.velocity_transmission", "1", "fraction of the velocity that reaches the last disc", "/state: final velocity of a row's last disc over the initial velocity of its first", [law::ROW_OF_DISCS], 0.0;
    SURFACE_ANGLE: "bed.surface_angle", "degrees", "angle of the surface", "/state: mean slope of the surface on both sides of the bed's middle, between 15 and 85 percent of its height, last frame; none of flying discs, whose contacts do not carry them", [], 0.0;
    DEPOSIT_LENGTH: "bed.deposit_length", "m", "length of the deposit", "/state: distance from the left wall up to which discs lie without a gap of two diameters, last frame", [], 0.0;
    RUNOUT: "bed.normalized_runout", "1", "runout in units of the initial length", "/state: bed.deposit_length over its initial value, minus 1", [], 0.0;
    SETTLING_TIME: "settling_time", "s", "time until the discs are at rest", "/energy: time of the last frame whose kinetic energy is above a thousandth of the mechanical energy at the start; none where it is the last of all", [], 0.0;
    LYAPUNOV: "lyapunov.exponent", "1/s", "largest Lyapunov exponent", "/divergence: mean growth rate of the logarithm of the distance to a twin (Benettin, Galgani and Strelcyn 1976), after the first quarter of the run; error by 8 blocks or more and ln(4) over the time", [], 0.0;
    DIVERGENCE_TIME: "lyapunov.divergence_time", "s", "time after which two runs that differ by a rounding error are unrelated", "ln(2^53) over lyapunov.exponent; none where the exponent is compatible with 0", [], 0.0;
    TIME_STEP: "time_step", "s", "time step", "/frame: time over the number of steps, last frame", [], 0.0;
}

/// Metrics of one bed, which differ from bed to bed by an amount that one of them does not tell.
pub(super) const NEED_REPLICATES: &[&Definition] = &[
    KINETIC,
    GRAVITATIONAL,
    ELASTIC,
    DISSIPATED,
    FRICTION,
    FRICTION_FRACTION,
    ROLLING,
    ROTATIONAL,
    WALL_WORK,
    DISCS_REMOVED,
    MAX_OVERLAP,
    COORDINATION_NUMBER,
    PAIR_COORDINATION_NUMBER,
    GRANULAR_TEMPERATURE,
    BED_HEIGHT,
    BED_PACKING_FRACTION,
    FLOOR_FORCE,
    FLOOR_STRESS,
    SIDE_WALL_STRESS,
    LATERAL_STRESS_RATIO,
    OVERBURDEN_DEVIATION,
    PISTON_FORCE,
    COOLING_RATE,
    SURFACE_ANGLE,
    DEPOSIT_LENGTH,
    RUNOUT,
    SETTLING_TIME,
];

/// Metrics that follow from the states of all frames.
pub(super) const NEED_ALL_STATES: &[&Definition] = &[
    RESIDUAL_PER_REBOUND,
    KINETIC_DISAGREEMENT,
    RESTITUTION,
    CONTACT_DURATION,
    IMPACT_VELOCITY,
    STRESS_AT_FLOOR,
    STRESS_AT_MID_HEIGHT,
    LATERAL_STRESS_RATIO,
    OVERBURDEN_DEVIATION,
];

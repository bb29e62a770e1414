//! Metrics of a gas run.

use super::kinetics_laws as kinetics;
use super::laws as law;
use crate::metric::definition::definitions;

definitions! {
    PRESSURE_MEASURED: "pressure.measured", "N/m", "pressure on the wall", "/pressure: impulse on the wall since the start; conditional error sqrt(N) m v_rms/(sqrt(8) pi R t), the momentum in transit at given <v^2> and W; other seeds differ in <v^2> unless it is given, and discs in W, by blocking and by the energy of rotation, which is conserved", [law::KINETIC_PRESSURE, kinetics::CLAUSIUS], 0.0;
    PRESSURE_MEAN_SPEED: "pressure.mean_speed_formula", "N/m", "pressure by the mean speed", "/pressure: N m <v>^2 / (2A), the gas exercise's formula (12); error of drawn speeds", [law::SPEED_LAW], 0.0;
    PRESSURE_MEAN_SQUARE: "pressure.mean_square_formula", "N/m", "pressure by the mean square speed", "/pressure: N m <v^2> / (2A); error of drawn speeds", [law::SPEED_LAW], 0.0;
    PRESSURE_IDEAL: "pressure.ideal_gas", "N/m", "pressure of an ideal gas", "/pressure: N k_B T / A, T by <v^2>; not in gravity, where the pressure depends on the height", [], 0.0;
    TEMPERATURE_MEAN_SQUARE: "temperature.mean_square", "K", "temperature", "speeds of the last frame: m <v^2> / (2 k_B); error of drawn speeds, in barometric equilibrium T/sqrt(N), reduced by the correlation of v^2 in the first and the last frame", [law::SPEED_LAW, law::BAROMETRIC_TEMPERATURE], 0.0;
    TEMPERATURE_MEAN_SPEED: "temperature.mean_speed", "K", "temperature by the mean speed", "speeds of the last frame: m <v>^2 / (2 k_B), the gas exercise's equation (13); error of drawn speeds", [law::SPEED_LAW], 0.0;
    TEMPERATURE_START: "temperature.start", "K", "temperature at the start", "/temperature, first frame: by the mean square or the mean speed, as the manifest defines it; error of drawn speeds that are not scaled", [law::GIVEN_TEMPERATURE], 0.0;
    CONTAINER_RADIUS: "container_radius", "m", "radius of the container", "/energy_balance, last frame", [], 0.0;
    MEAN_SPEED: "mean_speed", "m/s", "mean speed", "mean |v|, last frame; error of drawn speeds", [law::SPEED_LAW], 0.0;
    RMS_SPEED: "rms_speed", "m/s", "root of the mean square speed", "sqrt <v^2>, last frame; error of drawn speeds", [law::SPEED_LAW], 0.0;
    MEAN_VELOCITY: "mean_velocity", "m/s", "length of the mean velocity", "|mean v|, last frame", [], 0.0;
    WALL_COLLISION_RATE: "wall_collision_rate", "1/s", "rate of collisions with the wall", "/collisions: wall collisions of all particles over time; conditional error at given speeds, by the chords of the particles and their phases, to which the scatter of <v> between seeds is added; of discs by blocking", [law::WALL_COLLISION_RATE], 0.0;
    ENERGY_DRIFT: "energy.drift_relative", "1", "change of the kinetic energy", "/energy: kinetic energy, last frame against the first; not in gravity, see energy.residual_relative", [law::INVARIANTS], 1e-9;
    MAX_SPEED_CHANGE: "max_speed_change_relative", "1", "largest change of the speed of any particle", "/energy: largest of any particle and frame; with a moving wall, after the motion of the wall is subtracted", [law::INVARIANTS], 1e-9;
    MAX_ANGULAR_MOMENTUM_CHANGE: "max_angular_momentum_change_relative", "1", "largest change of the angular momentum of any particle", "/energy: largest of any particle and frame, over m R v", [law::INVARIANTS], 1e-9;
    PARTICLES_OUTSIDE: "particles_outside", "1", "number of particles outside of the container", "/energy: most of any frame", [law::INVARIANTS], 0.0;
    RESIDUAL: "energy.residual_relative", "1", "error of the energy balance", "/energy_balance: energy-balance error over the initial energy", [law::ENERGY_BALANCE], 1e-9;
    EFFUSION_RATE: "effusion_rate", "1/s", "mean rate of escape", "/energy_balance: escaped particles over time; error sqrt of their number", [law::EFFUSION], 0.0;
    ADIABATIC_INVARIANT: "adiabatic_invariant", "1", "product of energy and area relative to its start", "/energy_balance: energy times area, last frame over the first", [law::ADIABATIC], 0.0;
    THERMALIZED_TEMPERATURE: "temperature.thermalized", "K", "temperature at the end", "speeds of the last frame; error T / sqrt(N)", [law::THERMALIZATION], 0.0;
    RELATIVE_ENTROPY: "relative_entropy", "1", "distance of the speeds from Maxwell's distribution as relative entropy", "/energy_balance: H above Maxwell's, last frame; error of discs that have collided, that of Poisson counts with given N and <v^2>", [kinetics::MIN_H], 0.0;
    RELATIVE_ENTROPY_AT_START: "relative_entropy.start", "1", "distance of the speeds from Maxwell's distribution at the start as relative entropy", "/energy_balance: H above Maxwell's, first frame", [], 0.0;
    H_FUNCTION: "h_function", "1", "Boltzmann's H function", "/energy_balance and speeds, last frame: H above Maxwell's and -ln(pi <v^2>) - 1, with v in meters per second; error as of relative_entropy", [kinetics::MIN_H], 0.0;
    MEAN_OVER_RMS: "mean_speed_over_rms", "1", "ratio of the mean speed to the root of the mean square", "speeds of the last frame: <v>/sqrt(<v^2>); error of discs 0.135/sqrt(N)", [kinetics::MAXWELL_MEAN], 0.0;
    A2: "a2", "1", "excess of the fourth moment of the velocities", "speeds of the last frame: <v^4>/(2 <v^2>^2) - 1; error of discs about 1/sqrt(N), by Dirichlet's distribution", [kinetics::MAXWELL_A2], 0.0;
    PAIR_COLLISION_RATE: "pair_collision_rate_per_disc", "1/s", "rate of collisions between discs, per disc", "/collisions: collisions of two discs per disc over the second half of the run; error by blocking, and of the energy of rotation, which is conserved", [kinetics::ENSKOG_RATE], 0.0;
    COMPRESSIBILITY: "compressibility_factor", "1", "ratio of the pressure to that of an ideal gas", "/collisions, /energy: 1 + W/(2 E t) since the start; error by blocking, and of the energy of rotation, which is conserved", [kinetics::CONFINED_DISCS], 0.0;
    PRESSURE_DRIFT: "pressure.second_half_over_first", "1", "ratio of the pressure in the second half of the run to that in the first", "/pressure: mean over the second half of the run over that of the first; error sqrt(3) times the conditional one of pressure.measured in a half", [kinetics::STATIONARY], 0.0;
    WITHIN_HALF_RADIUS: "fraction_within_half_radius", "1", "fraction of the particles within half of the radius", "/state, last frame: fraction of the particles within R/2; error sqrt(p (1 - p)/N)", [kinetics::FRACTION_WITHIN], 0.0;
    WITHIN_HALF_RADIUS_AT_START: "fraction_within_half_radius.start", "1", "fraction of the particles within half of the radius at the start", "/state, first frame: the same", [kinetics::FRACTION_WITHIN], 0.0;
    HISTOGRAM_CHI_SQUARE: "speed_histogram.chi_square_per_bin", "1", "chi-square per bin of the speeds", "/speeds, last frame: mean over bins of (count - expected)^2 / expected against the law of the start, bins merged until 5 or more are expected; error sqrt(2 (bins - constraints))/bins", [law::HISTOGRAM], 0.0;
    LAYERS_CHI_SQUARE: "layers.chi_square_per_layer", "1", "chi-square per layer of the density", "/state, last frame: mean over 20 layers of equal height of (count - expected)^2 / expected, layers merged until 5 or more are expected; error sqrt(2 (layers - 1))/layers, outside the law's range by the scatter of the counts", [law::BAROMETRIC_CHI, law::BAROMETRIC_CHI_OF_WALL], 0.0;
    MEAN_HEIGHT: "layers.mean_height", "m", "mean height of the particles above the center", "/state, last frame: <y> above the center; error by the scatter of y", [law::BAROMETRIC_HEIGHT, law::BAROMETRIC_HEIGHT_OF_WALL], 0.0;
    TEMPERATURE_MAX_CHANGE: "temperature.max_change_relative", "1", "largest change of the temperature", "/temperature: largest change of m <v^2> / (2 k_B) of any frame", [law::TEMPERATURE_CONSTANT], 1e-12;
    BOX_ENTROPY_AT_START: "box_entropy.start", "1", "entropy per particle at the start, relative to a uniform gas, in units of the Boltzmann constant", "/state, first frame: entropy per particle over k_B by 20 vertical strips, 0 for a uniform gas; error sqrt((B - 1)/2)/N per species", [law::BOX_ENTROPY_START], 0.0;
    BOX_ENTROPY_CHANGE: "box_entropy.change", "1", "increase of the entropy per particle, in units of the Boltzmann constant", "/state: entropy by strips, last frame minus first; error sqrt((3 B - 2)/2)/N per species", [law::BOX_ENTROPY_CHANGE], 0.0;
    TOTAL_VARIATION_DISTANCE: "speed_histogram.total_variation_distance", "1", "distance of the speeds from Maxwell's distribution", "/speeds, last frame: half of the integral of |density - Maxwell's at the same <v^2>|", [], 0.0;
}

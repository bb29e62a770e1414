//! The messages of Kinetoscope: topic, schema, and fields with their units. Writer, reader, schema and documentation are derived
//! from this file. Tags are never reused: a changed meaning takes a new tag and a new [`SCHEMA_VERSION`].

use crate::channel::channels;
pub use crate::channel::{Channel, ChannelDeclaration};
pub use crate::channel_field::Field;
use crate::column::Column as _;
pub use crate::topics::{
    DISCS, FORCE_CHAINS, LEGEND, LOG, PARTICLES, STATE, TRAIL, VELOCITY, WALLS,
};

/// Version of the recording's layout; part of the run key.
pub const SCHEMA_VERSION: u32 = 5;

channels! {
    /// The clock of a frame: other messages join on `log_time`.
    FrameClock on "/frame" {
        /// Index of the frame; 0 is the start.
        frame: u64 [uint64] = "1",
        /// Steps or events since the start.
        step_or_event_count: u64 [uint64] = "2",
        /// Simulated time in `time_unit`.
        time: f64 [double] = "3",
        /// "s", "d", or "" for a dimensionless model.
        time_unit: String [string] = "4",
    }

    /// DEM: where the energy is. kinetic + gravitational + elastic + dissipated + removed - entered - wall_work
    /// = total at the start + residual.
    DemEnergy on "/energy" {
        /// Sum of m v^2 / 2 + I w^2 / 2 with I = m r^2 / 2, from the velocities at the positions' time, J.
        kinetic_j: f64 [double] = "1",
        /// Sum of -m g . x, J; zero at the origin.
        gravitational_j: f64 [double] = "2",
        /// Sum of k delta^2 / 2 over contacts, and the tangential springs, J.
        elastic_j: f64 [double] = "3",
        /// Energy dissipated by dashpots, friction and rolling friction since the start, J.
        dissipated_j: f64 [double] = "4",
        /// Work done by the walls on the discs since the start, J; 0 for walls at rest.
        wall_work_j: f64 [double] = "5",
        /// kinetic + gravitational + elastic, J.
        total_j: f64 [double] = "6",
        /// total + dissipated + removed - entered - wall work - total at the start: the integrator's error, J.
        residual_j: f64 [double] = "7",
        /// Part of `elastic_j`: tangential and rolling springs, J.
        elastic_tangential_j: f64 [double] = "8",
        /// Part of `dissipated_j`: dissipated by friction, J.
        friction_j: f64 [double] = "9",
        /// Part of `dissipated_j`: dissipated by rolling friction, J.
        rolling_j: f64 [double] = "10",
        /// Energy of the removed discs, J.
        removed_j: f64 [double] = "11",
        /// Energy of the inserted discs, J.
        entered_j: f64 [double] = "12",
    }

    /// DEM: the energy balance in percent of the initial and inserted energy, for plots.
    DemEnergyPercent on "/energy_percent" {
        /// Percent of the initial and inserted energy.
        kinetic_percent: f64 [double] = "1",
        /// Percent of the initial and inserted energy.
        gravitational_percent: f64 [double] = "2",
        /// Percent of the initial and inserted energy.
        elastic_percent: f64 [double] = "3",
        /// Percent of the initial and inserted energy.
        dissipated_percent: f64 [double] = "4",
        /// Energy-balance error, parts per million of the initial and inserted energy.
        residual_ppm: f64 [double] = "5",
        /// Work done by the walls on the discs since the start, percent of the initial and inserted energy.
        wall_work_percent: f64 [double] = "6",
        /// Energy of the removed discs, percent of the initial and inserted energy.
        removed_percent: f64 [double] = "7",
        /// Absolute value of the initial and inserted energy, which is 100 percent, in microjoules.
        reference_energy_uj: f64 [double] = "8",
    }

    /// DEM and several bodies: growth of the distance between this run and a twin, which is reduced at fixed steps.
    Divergence on "/divergence" {
        /// Logarithm of its growth since the start.
        logarithm: f64 [double] = "1",
    }

    /// DEM: number of contacts, and the maximum overlap since the last frame.
    DemContactStatistics on "/contact_statistics" {
        /// Touching pairs of discs.
        pair_contacts: u64 [uint64] = "1",
        /// Touching pairs of disc and wall.
        wall_contacts: u64 [uint64] = "2",
        /// Mean number of contacts per disc, with discs and walls: (2 pair_contacts + wall_contacts) / N.
        coordination_number: f64 [double] = "3",
        /// Maximum overlap since the last frame, over the smaller radius of the pair.
        max_overlap_over_radius: f64 [double] = "4",
    }

    /// DEM: the force of every contact, including friction, as columns of equal length: pairs of discs and contacts with walls,
    /// block by block, in a fixed order; with cohesion, also the pairs that it attracts in the first step after their contact.
    DemContactForces on "/contact_forces" {
        /// Center of a disc, x, m.
        from_x_m: Vec<f64> [double, repeated] = "1",
        /// Center of a disc, y, m.
        from_y_m: Vec<f64> [double, repeated] = "2",
        /// Center of the touching disc or of its periodic image; for a wall, its nearest point; x, m.
        to_x_m: Vec<f64> [double, repeated] = "3",
        /// The same, y, m.
        to_y_m: Vec<f64> [double, repeated] = "4",
        /// Force on the first disc, x, N: the force that moves it in the next step.
        force_x_n: Vec<f64> [double, repeated] = "5",
        /// Force on the first disc, y, N.
        force_y_n: Vec<f64> [double, repeated] = "6",
        /// The number of the first disc, `id` of `/particles`.
        first_id: Vec<u64> [uint64, repeated] = "7",
        /// The number of the touching disc; for a wall, that of the first disc.
        second_id: Vec<u64> [uint64, repeated] = "8",
    }

    /// DEM: the sum of the contact forces on each disc, m (a - g), as columns of equal length in the order of `/state`: the
    /// forces that accelerate the discs in the next step, friction and walls included, gravity not.
    DemDiscForces on "/disc_forces" {
        /// Sum of the contact forces, x, N.
        force_x_n: Vec<f64> [double, repeated] = "1",
        /// Sum of the contact forces, y, N.
        force_y_n: Vec<f64> [double, repeated] = "2",
    }

    /// DEM: forces of the walls on the discs, one entry per wall: left, right, floor and ceiling of the box (unless
    /// periodic), then the walls of the manifest.
    DemWalls on "/wall_forces" {
        /// Mean force since the last frame, x, N; NaN in frame 0.
        mean_force_x_n: Vec<f64> [double, repeated] = "1",
        /// Mean force since the last frame, y, N; NaN in frame 0.
        mean_force_y_n: Vec<f64> [double, repeated] = "2",
        /// Work done on the discs since the start, J.
        work_j: Vec<f64> [double, repeated] = "3",
        /// Discs removed since the start.
        discs_removed: u64 [uint64] = "4",
        /// Discs inserted since the start.
        discs_entered: u64 [uint64] = "5",
    }

    /// DEM: fluctuation of the velocities about their mean.
    DemTemperature on "/temperature" {
        /// Half of the mean square of v - `<v>`, m^2/s^2.
        granular_temperature_m2_per_s2: f64 [double] = "1",
        /// Square root of the granular temperature, m/s.
        thermal_speed_m_per_s: f64 [double] = "2",
    }

    /// Gas: pressure on the wall, measured and by formula, N/m.
    GasPressure on "/pressure" {
        /// Normal impulse on the wall since the last frame over perimeter and time; NaN in frame 0.
        measured_n_per_m: f64 [double] = "1",
        /// The same since the start; NaN in frame 0.
        measured_since_start_n_per_m: f64 [double] = "2",
        /// Formula (12) of the gas exercise: N m `<v>^2` / (2A).
        mean_speed_formula_n_per_m: f64 [double] = "3",
        /// N m `<v^2>` / (2A).
        mean_square_formula_n_per_m: f64 [double] = "4",
        /// Ideal gas law N k_B T / A with the temperature by the definition in use.
        ideal_gas_n_per_m: f64 [double] = "5",
        /// Measured since the start over the mean-square formula; NaN in frame 0, for a gas at rest and
        /// for a moving wall.
        pressure_over_mean_square_formula: f64 [double] = "6",
        /// Normal impulse on the wall since the last frame, N s.
        wall_impulse_n_s: f64 [double] = "7",
        /// Time since the last frame, s.
        window_s: f64 [double] = "8",
        /// Measured since the last frame over the mean-square formula; NaN in frame 0 and for a gas at rest.
        window_pressure_over_mean_square_formula: f64 [double] = "9",
    }

    /// Gas: temperature by both definitions, and the moments of the speed.
    GasTemperature on "/temperature" {
        /// m `<v>^2` / (2 k_B), K: the gas exercise's equation (13).
        mean_speed_temperature_k: f64 [double] = "1",
        /// m `<v^2>` / (2 k_B), K.
        mean_square_temperature_k: f64 [double] = "2",
        /// Mean of |v|, m/s.
        mean_speed_m_per_s: f64 [double] = "3",
        /// |mean of v|, m/s: near zero; not the mean speed.
        mean_velocity_m_per_s: f64 [double] = "4",
        /// Square root of the mean of v^2, m/s.
        rms_speed_m_per_s: f64 [double] = "5",
    }

    /// Gas: conserved quantities, of the particles inside.
    GasInvariants on "/energy" {
        /// Sum of m v^2 / 2, J.
        kinetic_j: f64 [double] = "1",
        /// Sum of m (x vy - y vx) about the center, J s.
        angular_momentum_j_s: f64 [double] = "2",
        /// Maximum relative change of one particle's speed since the start.
        max_speed_change_relative: f64 [double] = "3",
        /// Maximum change of one particle's angular momentum since the start, over m r v of that particle.
        max_angular_momentum_change_relative: f64 [double] = "4",
        /// Particles outside the wall.
        particles_outside: u64 [uint64] = "5",
    }

    /// Gas: contributions to the energy of the particles inside, each since the start.
    /// energy = energy at the start + work + heat + rescaling - escaped + residual, kinetic and in gravity.
    GasEnergyBalance on "/energy_balance" {
        /// Work that the moving wall has done on the gas, J: -u times the impulse on it.
        wall_work_j: f64 [double] = "1",
        /// Heat from a thermal wall, J.
        wall_heat_j: f64 [double] = "2",
        /// Energy added by setting temperatures on a schedule, J.
        rescaling_j: f64 [double] = "3",
        /// Energy carried away through the opening, J.
        escaped_j: f64 [double] = "4",
        /// Energy-balance error over the initial energy.
        residual_relative: f64 [double] = "5",
        /// Radius of the container now, m.
        radius_m: f64 [double] = "6",
        /// Particles that have left through the opening.
        particles_escaped: u64 [uint64] = "7",
        /// Energy of the particles inside, kinetic and in gravity, times area, over its value at the start: 1 for slow compression in two
        /// dimensions without gravity.
        energy_times_area_over_initial: f64 [double] = "8",
        /// Mean of ln(f/f_Maxwell) over the histogram of the speeds, with f_Maxwell of the same mean square: 0 for Maxwell's
        /// distribution and positive for all others; Boltzmann's H minus its minimum.
        relative_entropy: f64 [double] = "9",
    }

    /// Gas: collisions with the wall and between discs.
    GasCollisions on "/collisions" {
        /// Wall collisions since the start.
        wall_collisions: u64 [uint64] = "1",
        /// Wall collisions since the last frame.
        wall_collisions_since_last_frame: u64 [uint64] = "2",
        /// Collisions of two discs since the start; 0 for points.
        pair_collisions: u64 [uint64] = "3",
        /// Collisions of two discs since the last frame.
        pair_collisions_since_last_frame: u64 [uint64] = "4",
        /// Sum over pair collisions of distance times transferred momentum since the start, J s: the pair part of Clausius's virial.
        pair_virial_sum_j_s: f64 [double] = "5",
    }

    /// Gas: histogram of the speeds, with their initial distribution and Maxwell's.
    GasSpeeds on "/speeds" {
        /// Centers of the bins, m/s.
        speed_m_per_s: Vec<f64> [double, repeated] = "1",
        /// Measured density, s/m.
        density: Vec<f64> [double, repeated] = "2",
        /// Density of the initial speed distribution, s/m; 0 if it is a single speed.
        initial_distribution: Vec<f64> [double, repeated] = "3",
        /// Maxwell's density at the same mean square, s/m.
        maxwell: Vec<f64> [double, repeated] = "4",
        /// Centers of the bins over the rms speed, for plots: viewers' ticks have three decimals.
        speed_over_rms: Vec<f64> [double, repeated] = "5",
        /// Measured density times the rms speed.
        density_times_rms: Vec<f64> [double, repeated] = "6",
        /// Density of the initial speed distribution times the rms speed.
        initial_distribution_times_rms: Vec<f64> [double, repeated] = "7",
        /// Maxwell's density times the rms speed.
        maxwell_times_rms: Vec<f64> [double, repeated] = "8",
    }

    /// Packing: moments of the velocities.
    PackingTemperature on "/temperature" {
        /// `<v^2>` = 2 kT/m: the quantity that the packing exercise calls temperature.
        mean_square_velocity: f64 [double] = "1",
        /// `<v^2>`/2 = kT/m.
        temperature: f64 [double] = "2",
        /// `<v^4>`/(2 `<v^2>^2`) - 1: 0 for a Maxwell distribution.
        a2: f64 [double] = "3",
        /// Temperature over its initial value.
        temperature_over_initial: f64 [double] = "4",
        /// Sum of v^2 / 2.
        kinetic_energy: f64 [double] = "5",
        /// Time integral of a2 since the start, exact between collisions, in gravity by Simpson's rule.
        a2_time_integral: f64 [double] = "6",
        /// Sum of a2 after each collision since the start.
        a2_event_sum: f64 [double] = "7",
    }

    /// Packing: number and rate of collisions.
    PackingCollisions on "/collisions" {
        /// Pair collisions since the start.
        pair_collisions: u64 [uint64] = "1",
        /// Wall collisions since the start.
        wall_collisions: u64 [uint64] = "2",
        /// Pair collisions per disc (2 pair_collisions / n) and unit of time since the start; NaN at time 0.
        pair_collision_rate_per_disc: f64 [double] = "3",
        /// Wall collisions per disc and unit of time since the start; NaN at time 0.
        wall_collision_rate_per_disc: f64 [double] = "4",
    }

    /// Packing: pressure since the start. Means over time are NaN at time 0. The area A and the perimeter are those of the rectangle
    /// accessible to the centers: in a box with walls, less than the box by the diameter of the largest disc in each direction; if
    /// radii are drawn at random, of the largest that can be drawn. In gravity, means over the area and over the walls.
    PackingPressure on "/pressure" {
        /// By the collision virial: [sum of v^2 averaged over time + virial rate] / (2A).
        virial: f64 [double] = "1",
        /// Normal impulse on the walls over perimeter and time.
        wall: f64 [double] = "2",
        /// P A / (N kT) by the virial, T averaged over time; NaN for discs at rest.
        compressibility_factor: f64 [double] = "3",
        /// Time integral of the kinetic energy since the start.
        kinetic_energy_time_integral: f64 [double] = "4",
        /// Sum over pair collisions of the distance times the normal impulse, since the start.
        collision_virial_sum: f64 [double] = "5",
        /// Normal impulse on all walls since the start.
        wall_impulse: f64 [double] = "6",
    }

    /// Packing: one entry per collision since the last frame, as columns of equal length.
    PerCollision on "/per_collision" {
        /// Number of the event, pair or wall, from 1; the entry with number 0 is the start.
        event: Vec<u64> [uint64, repeated] = "1",
        /// Time of the event.
        time: Vec<f64> [double, repeated] = "2",
        /// `<v^2>` after the event.
        mean_square_velocity: Vec<f64> [double, repeated] = "3",
        /// a2 after the event.
        a2: Vec<f64> [double, repeated] = "4",
    }

    /// Gas of colliding discs: the collisions since the last frame, as columns of equal length. From the positions and velocities of a frame,
    /// they give those at every later time until the schedule sets a temperature: a disc flies straight between its collisions.
    GasEvents on "/events" {
        /// Number of the event, pair or wall, from 1.
        event: Vec<u64> [uint64, repeated] = "1",
        /// Time of the event, s.
        time_s: Vec<f64> [double, repeated] = "2",
        /// The number of a disc, `id` of `/particles`.
        first_id: Vec<u64> [uint64, repeated] = "3",
        /// The number of the other disc; for the wall, that of the first disc.
        second_id: Vec<u64> [uint64, repeated] = "4",
        /// Impulse on the first disc, x, N s. Another disc has the opposite one.
        impulse_x_n_s: Vec<f64> [double, repeated] = "5",
        /// The same, y, N s.
        impulse_y_n_s: Vec<f64> [double, repeated] = "6",
        /// Unit vector from the first disc to the other one or out of the container, x.
        normal_x: Vec<f64> [double, repeated] = "7",
        /// The same, y.
        normal_y: Vec<f64> [double, repeated] = "8",
    }

    /// Packing: the collisions since the last frame, as columns of equal length. From the positions and velocities of a frame, they give
    /// those at every later time: a disc flies straight between its collisions, in gravity on a parabola.
    PackingEvents on "/events" {
        /// Number of the event, pair or wall, from 1.
        event: Vec<u64> [uint64, repeated] = "1",
        /// Time of the event.
        time: Vec<f64> [double, repeated] = "2",
        /// The number of the disc, `id` of `/particles`; of two discs, the lower one.
        first_id: Vec<u64> [uint64, repeated] = "3",
        /// The number of the other disc; for a wall, that of the first disc.
        second_id: Vec<u64> [uint64, repeated] = "4",
        /// Impulse on the first disc, x: the change of its velocity, because the mass of a disc is 1. Another disc has the opposite one.
        impulse_x: Vec<f64> [double, repeated] = "5",
        /// The same, y.
        impulse_y: Vec<f64> [double, repeated] = "6",
        /// Unit vector from the first disc to the other one or out of the box, x.
        normal_x: Vec<f64> [double, repeated] = "7",
        /// The same, y.
        normal_y: Vec<f64> [double, repeated] = "8",
    }

    /// Packing in gravity: where the energy is. kinetic + potential = total; total + dissipated - from_floor = total at the start +
    /// residual.
    PackingEnergy on "/energy" {
        /// Sum of v^2 / 2.
        kinetic: f64 [double] = "1",
        /// Sum of g times the height of a disc's center above the bottom of the box.
        potential: f64 [double] = "2",
        /// kinetic + potential.
        total: f64 [double] = "3",
        /// Energy gained from the floor since the start: the work of a shaken one, or the heat of one with a temperature.
        from_floor: f64 [double] = "4",
        /// Energy lost in collisions with restitution since the start.
        dissipated: f64 [double] = "5",
        /// The rounding of the motion: what the balance lacks.
        residual: f64 [double] = "6",
    }

    /// Orbit: energy per unit mass, AU^2/day^2, and its drift. For several bodies, the total energy over the total mass.
    OrbitEnergy on "/energy" {
        /// v^2 / 2.
        specific_kinetic_energy_au2_per_day2: f64 [double] = "1",
        /// -GM / r.
        specific_potential_energy_au2_per_day2: f64 [double] = "2",
        /// kinetic + potential.
        specific_total_energy_au2_per_day2: f64 [double] = "3",
        /// (total - total at the start) / |total at the start|, parts per million.
        drift_ppm: f64 [double] = "4",
        /// log10 of |total - total at the start| / |total at the start|, for plots; NaN where they are equal.
        drift_log10: f64 [double] = "5",
    }

    /// Orbit: elements and errors against the exact solution.
    OrbitElements on "/orbit" {
        /// Distance from the Sun, AU.
        radius_au: f64 [double] = "1",
        /// Osculating semi-major axis, AU.
        semi_major_axis_au: f64 [double] = "2",
        /// Osculating eccentricity.
        eccentricity: f64 [double] = "3",
        /// |r x v|, AU^2/day.
        specific_angular_momentum_au2_per_day: f64 [double] = "4",
        /// Change of |r x v| since the start over its value there, parts per million.
        specific_angular_momentum_drift_ppm: f64 [double] = "5",
        /// Distance from the exact Kepler position at the same time, AU.
        position_error_au: f64 [double] = "6",
        /// Angle about the Sun in the plane of the start, unwrapped, minus the exact one, rad.
        phase_error_rad: f64 [double] = "7",
        /// Revolutions done, by the unwrapped angle.
        revolutions: f64 [double] = "8",
        /// Osculating inclination against the plane z = 0, rad.
        inclination_rad: f64 [double] = "9",
        /// Angle from the x axis to the ascending node, rad, in (-pi, pi]; 0 where the orbit lies in the plane z = 0.
        longitude_of_ascending_node_rad: f64 [double] = "10",
        /// Angle from the ascending node to the perihelion, rad, in [-pi, pi].
        argument_of_perihelion_rad: f64 [double] = "11",
        /// Angle from the perihelion to the body, rad, in (-pi, pi].
        true_anomaly_rad: f64 [double] = "12",
        /// E - e sin E, rad; NaN on an open orbit.
        mean_anomaly_rad: f64 [double] = "13",
        /// Osculating distance of the perihelion, AU.
        perihelion_distance_au: f64 [double] = "14",
        /// Osculating distance of the aphelion, AU; NaN on an open orbit.
        aphelion_distance_au: f64 [double] = "15",
        /// Osculating period, days; NaN on an open orbit.
        period_days: f64 [double] = "16",
        /// Number of force evaluations since the start.
        force_evaluations: u64 [uint64] = "17",
        /// Passes of the direction of the start, counted at every step.
        completed_revolutions: u64 [uint64] = "18",
        /// Time of the last pass of the direction of the start, found within its step, d; NaN before the first.
        last_revolution_end_days: f64 [double] = "19",
        /// Minimum distance from the Sun since the start, found within its step, AU.
        min_radius_au: f64 [double] = "20",
        /// Maximum distance from the Sun since the start, found within its step, AU.
        max_radius_au: f64 [double] = "21",
        /// log10 of |change of |r x v| since the start| over its value there, for plots; NaN where they are equal.
        specific_angular_momentum_drift_log10: f64 [double] = "22",
    }

    /// Orbit of several bodies: conserved quantities in addition to the energy, over the total mass.
    OrbitConserved on "/conserved" {
        /// x component of sum m r x v / sum m, AU^2/day.
        specific_angular_momentum_x_au2_per_day: f64 [double] = "1",
        /// y component of it.
        specific_angular_momentum_y_au2_per_day: f64 [double] = "2",
        /// z component of it.
        specific_angular_momentum_z_au2_per_day: f64 [double] = "3",
        /// Length of its change since the start over sum m |r| |v| / sum m there, parts per million.
        specific_angular_momentum_change_ppm: f64 [double] = "4",
        /// |sum m v| / sum m, AU/day: zero except for rounding.
        specific_momentum_au_per_day: f64 [double] = "5",
        /// Distance of the center of mass from the origin, AU: zero except for rounding.
        center_of_mass_au: f64 [double] = "6",
        /// Minimum separation of two bodies in this frame, AU; pairs of test particles do not count.
        min_separation_au: f64 [double] = "7",
        /// Number of force evaluations since the start.
        force_evaluations: u64 [uint64] = "8",
        /// log10 of `specific_angular_momentum_change_ppm` / 1e6, for plots; NaN without a change.
        specific_angular_momentum_change_log10: f64 [double] = "9",
    }

    /// Orbit of several bodies: the closest approach since the start, found at every step. Pairs with the central body, which has more
    /// than half of the mass, count only if nothing else attracts.
    OrbitClosestApproach on "/closest_approach" {
        /// Number of the first body, from 0.
        first_body: u64 [uint64] = "1",
        /// Number of the second body.
        second_body: u64 [uint64] = "2",
        /// Its time, d.
        time_d: f64 [double] = "3",
        /// Least separation, AU.
        separation_au: f64 [double] = "4",
        /// Relative speed there, AU/day.
        relative_speed_au_per_day: f64 [double] = "5",
        /// Separation over the mutual Hill radius there; NaN without a central body, or for a pair with it.
        separation_over_hill_radius: f64 [double] = "6",
        /// Least value of `separation_over_hill_radius` since the start, of any pair; NaN without.
        min_separation_over_hill_radius: f64 [double] = "7",
    }
}

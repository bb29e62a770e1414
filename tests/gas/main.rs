//! Laws of the gas in a circular container: exact motion, wall pressure, temperatures, speed distributions, walls,
//! collisions.
//!
//! A test belongs here if it compares a gas run with a closed form, kinetic theory, the scheme printed in the gas
//! exercise, or a second run in memory.

// Configurations, propagation and frame readers that the tests share.
mod runs;

// A particle follows the chords of the circular billiard.
mod exact_motion_equals_50_digit_reference;
// Registers of every width give the same bits.
mod every_width_gives_the_same_bits;
// The nine defects of the scheme printed in the gas exercise are shown and detected.
mod exercise_defects_are_detected;
// Invariants and pressure hold after a million wall collisions, on any number of threads.
mod million_wall_collisions_conserve_invariants;
// Time steps of any length follow the exact path.
mod stepped_agrees_with_exact;
// The wall conserves speed and angular momentum of every particle.
mod wall_conserves_speed_and_angular_momentum;

// Moving walls do work, thermal walls exchange heat, openings release particles.
mod moving_thermal_and_open_walls_follow_kinetic_theory;
// The temperature set holds exactly in the definition in use.
mod set_temperature_follows_its_definition;
// Speeds follow the distribution from which they were drawn.
mod speed_histogram_follows_distribution;
// Angles, chords and rate of wall collisions follow the uniform isotropic state.
mod wall_collision_rate_follows_kinetic_theory;
// The wall pressure is N m <v^2> / (2 A).
mod wall_pressure_follows_mean_square_speed;

// Colliding discs conserve energy and angular momentum and collide at Enskog's rate.
mod colliding_discs_conserve_energy_and_momentum;
// Pressure and collision rate of discs follow the equation of state with the correction for the wall.
mod pressure_of_discs_agrees_with_theory;
// A frame and the recorded collisions after it give all positions at any later time.
mod recorded_events_rebuild_positions;
// Elastic collisions relax speeds to Maxwell's distribution.
mod collisions_relax_speeds_to_maxwell;

// Density in gravity follows the barometric law, and particles keep their energy.
mod gravity_gives_the_barometric_law;
// A thermal wall, an opening and a partition keep their laws in gravity and next to one another.
mod gravity_walls_and_partition_combine;
// A removed partition keeps the temperature and raises the entropy.
mod removed_partition_raises_the_entropy;

// Initial states, rejected configurations, frames and checkpoints of the gas.
mod initial_state_and_frames_follow_configuration;

//! Laws of hard discs: collisions, walls, velocity distributions, pressure, order, and dense initial states.
//!
//! A test belongs here if it compares a packing run with a closed form, Enskog's theory, the plain reference program
//! below, or published values.

// Periodic boxes: minimum-image distances, Z and psi6.
mod periodic_states;
// Configurations, functions that advance a run, and frame readers that the tests share.
mod runs;

// The engine finds the same collisions at the same times as the plain reference program.
mod events_agree_with_plain_reference;
// A pair collision reverses the normal relative velocity and scales it by the restitution.
mod pair_collision_follows_restitution;
// Few periodic discs collide with the image that they touch, in boxes of any shape.
mod few_discs_collide_with_the_right_image;
// A frame and the recorded collisions after it give all positions at any later time.
mod recorded_events_rebuild_positions;
// Discs in gravity fly on parabolas, and their energy is that of the start and of the floor.
mod discs_in_gravity_fly_on_parabolas;
// The density in gravity follows the barometric law, with the pressure of the discs.
mod discs_in_gravity_follow_the_barometric_law;
// Discs among fixed obstacles fly, collide, keep their energy and stay apart from them.
mod discs_fly_among_obstacles;
// A gas leaves through a gap between obstacles at the rate of kinetic theory.
mod gas_leaves_through_a_gap_between_obstacles;
// The time to contact is exact for distant, grazing and nearly touching discs.
mod time_to_contact_is_exact;
// A single disc follows its unfolded straight path.
mod single_disc_follows_unfolded_path;
// A noisy wall rotates the outgoing direction by a normally distributed angle and conserves the speed.
mod wall_noise_conserves_speed;

// No two discs overlap and no disc leaves the box, in any frame.
mod discs_never_overlap;
// Elastic discs conserve energy, noisy walls included.
mod elastic_discs_conserve_energy;
// Inelastic discs cool by Haff's law; three discs on a line collapse.
mod inelastic_discs_follow_haffs_law;
// Inelastic discs that have come to rest, or move in parallel, end the run with a fault.
mod cooled_discs_come_to_rest;
// Registers of every width of this processor give the same run.
mod every_width_gives_the_same_bits;
// Runs end as configured, and times between events change no bit.
mod runs_end_where_configured;

// Initial states have no overlap; those that cannot be built are rejected.
mod initial_states_have_no_overlap;
// Initial velocities are normal; the two variances differ only by a scale of time.
mod initial_velocities_follow_their_distribution;
// Z, a2, psi6 and distances at the accuracy of published references.
mod many_discs_reproduce_reference_values;
// Density waves, pairs at contact and hexagonal order follow their theory.
mod long_range_order_follows_theory;
// Means over a run do not depend on the number of frames.
mod metrics_do_not_depend_on_the_frame_interval;
// The mean of a2 for n elastic discs is -1/(n + 1).
mod mean_a2_equals_constant_energy_value;
// Mixtures of diameters collide at the rates of their contact values.
mod mixtures_follow_their_contact_values;
// Compressibility factor of the periodic fluid, and compression to dense states.
mod periodic_and_compressed_states_match_references;
// The compressibility factor follows the equation of state, with and without walls.
mod pressure_agrees_with_theory;
// The pressure at freezing is that of event-chain simulations of as many discs.
mod pressure_at_freezing_agrees_with_event_chains;
// Collision rate and pressure of elastic discs between walls follow Enskog's theory.
mod pressure_and_rate_follow_enskog;
// The largest Lyapunov exponent is that of an independent program, and that of Sinai's billiard for two discs.
mod lyapunov_exponent_agrees_with_twins;
// Elastic discs diffuse at Enskog's rate, by velocities and by displacements.
mod self_diffusion_follows_enskog;
// Times and paths between two collisions follow Enskog's theory, and their distributions the rates of the speeds.
mod free_flights_follow_enskog;
// Discs that flow together cool as 1/t in a large box, and by Haff's law in a small one.
mod late_cooling_follows_its_power_of_time;

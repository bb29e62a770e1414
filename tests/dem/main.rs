//! Laws of the discrete element method: contacts, friction, walls, initial states, and beds of many discs.
//!
//! A test belongs here if it compares a DEM run with a closed form, an independent program, or a second run in memory. Each
//! file states its law or guarantee in the header.

// Scenes, initial states and frame readers that the tests share.
mod scene;

// A frictional collision conserves spin plus orbital angular momentum.
mod angular_momentum_is_conserved_with_friction;
// Recorded contact forces equal mass times acceleration for every disc.
mod contact_forces_equal_mass_times_acceleration;
// Duration and largest overlap of a contact follow the damped oscillator.
mod contact_duration_follows_damped_oscillator;
// A disc on an incline rolls or slides, depending on the friction coefficient.
mod disc_on_incline_slides_or_rolls;
// A dropped disc rebounds to the height of the exact solution.
mod dropped_disc_rebounds_to_exact_height;
// Between contacts, discs follow a parabola at constant energy.
mod free_flight_follows_parabola;
// With Young's modulus, contacts follow the closed forms of elastic spheres.
mod hertz_contacts_follow_closed_forms;
// The implicit dashpot is stable for any damping.
mod implicit_dashpot_is_stable;
// Mindlin's tangential springs follow the incremental law.
mod mindlin_springs_follow_incremental_law;
// A pair of materials determines restitution and friction.
mod material_pairs_determine_restitution_and_friction;
// Materials of unequal stiffness collide as on springs in series.
mod unequal_stiffness_follows_series_springs;
// Cohesion holds, slows and presses surfaces by closed forms.
mod cohesion_follows_closed_forms;
// The restitution obtained equals the requested value at every phase of the step.
mod restitution_equals_requested_value;
// Restitution follows from the damping ratio, and the damping ratio from the restitution.
mod restitution_follows_from_damping_ratio;
// The restitution is correct for 50 random stiffnesses, masses, radii and time steps.
mod restitution_is_correct_for_random_parameters;
// The velocity transmitted through a row of discs follows from their restitution.
mod row_transmission_follows_restitution;
// At rest, the overlap of a disc carries the weight above it.
mod static_load_equals_weight;
// Every step agrees with a reference that compares all pairs.
mod steps_agree_with_plain_reference;
// The mirror image of an initial state moves as the mirror image.
mod trajectory_is_mirror_symmetric;
// Velocity Verlet equals half kick, drift, half kick.
mod velocity_verlet_equals_kick_drift_kick;

// The energy balance closes with friction, moving walls and discs that leave.
mod energy_balance_closes_with_friction;
// The energy-balance error decreases with the square of the time step.
mod energy_balance_error_is_second_order;
// Energies of a bed of two materials with cohesion and friction agree with a reference.
mod mixed_bed_balances_energy;
// Kinetic energy changes by the work of all forces.
mod work_equals_kinetic_energy_change;

// The angle of repose lies within the bounds of the friction coefficients.
mod angle_of_repose_is_within_bounds;
// The runout of a collapsing column grows with its aspect ratio.
mod column_runout_grows_with_aspect_ratio;
// The discharge rate of a silo follows Beverloo's law.
mod discharge_follows_beverloo;
// A gas of dissipative discs cools by Haff's law.
mod granular_gas_follows_haffs_law;
// The load on a silo's floor follows Janssen's law.
mod silo_follows_janssen;

// No run starts with overlapping discs or with discs outside the box.
mod initial_states_have_no_overlap;
// Inserted discs enter in order, at their rate, without overlap.
mod inserted_discs_enter_in_order;
// Moving walls are drawn at their position in every frame.
mod moving_walls_are_drawn_at_their_position;
// How often the neighbor lists are rebuilt does not affect the trajectory.
mod rebuilt_lists_do_not_affect_the_trajectory;
// Number of threads, SIMD, observation and storage change no bit.
mod threads_and_simd_do_not_affect_results;
// A disc whose center leaves the box ends the run.
mod disc_outside_the_box_is_a_fault;
// Unstable time steps are rejected with values that are accepted.
mod unstable_time_step_is_rejected;
// Stiff elastic discs have the Lyapunov exponent of hard discs.
mod lyapunov_exponent_is_that_of_hard_discs;

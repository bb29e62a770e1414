//! Laws of the discrete element method: contacts, friction, walls, starts, and beds of many discs.
//!
//! A test belongs here if it compares a DEM run with a closed form, an independent program or itself in memory. Each file
//! states its law or guarantee in the header.

// Scenes, starts and readings of frames that the tests share.
mod scene;

// Recorded contact forces equal mass times acceleration for every disc.
mod contact_forces_move_the_discs;
// Duration and largest overlap of a contact follow the damped oscillator.
mod contact_lasts_half_a_period;
// The overlap of a disc at rest carries the weight above it.
mod disc_at_rest_weighs;
// A dropped disc rebounds to the height that its dashpot leaves.
mod drop_rebounds_to_its_height;
// Between contacts, discs follow a parabola at constant energy.
mod free_flight_is_a_parabola;
// The implicit dashpot is stable for any damping.
mod implicit_dashpot_holds;
// A disc on an incline rolls or slides as the friction coefficient decides.
mod incline_slides_or_rolls;
// A pair of materials determines restitution and friction.
mod materials_give_their_constants;
// The mirror image of a start moves as the mirror image.
mod mirrored_start_moves_mirrored;
// A push passes through a row of discs with the transmission of its restitution.
mod push_passes_through_a_row;
// The restitution obtained is the one requested, at every phase of the step.
mod restitution_is_the_one_wanted;
// Restitution follows from the damping ratio, and back.
mod restitution_of_damping_ratio;
// The same for 50 random stiffnesses, masses, radii and time steps.
mod restitution_of_fifty_draws;
// Velocity Verlet is half kick, drift, half kick.
mod velocity_verlet_is_half_kicks;

// The energy balance closes with friction, moving walls and discs that leave.
mod friction_ledger_closes;
// The energy-balance error falls with the square of the time step.
mod ledger_residual_order;
// Kinetic energy changes by the work of all forces.
mod work_is_energy;

// The runout of a collapsing column grows as a power of its aspect ratio.
mod column_runs_out;
// The discharge rate of a silo follows Beverloo's law.
mod discharge_follows_beverloo;
// A gas of dissipative discs cools by Haff's law.
mod gas_cools_by_haffs_law;
// The angle of repose lies within the bounds of the friction coefficients.
mod heap_has_its_slope;
// The load on a silo's floor follows Janssen's law.
mod silo_walls_carry_weight;

// Threads, SIMD width, observation and storage change no bit.
mod bits_are_the_same_everywhere;
// Unstable time steps are rejected with values that work.
mod document_values_are_diagnosed;
// Observation, work budget and resuming change no bit.
mod looking_and_cutting_change_nothing;
// Moving walls are drawn at their position in every frame.
mod moving_walls_are_drawn;
// Inserted discs enter in order, at their rate, without overlap.
mod rain_falls_in_order;
// No run starts with overlapping discs or with discs outside the box.
mod starts_are_sound;

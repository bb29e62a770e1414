//! Laws of the orbit model: the two-body problem, several bodies, and the errors of each integrator.
//!
//! A test belongs here if it compares an orbit run with a closed form, an independent program, an order of convergence, or a
//! second run in memory.

// Functions that prepare, advance and read an orbit run.
mod run;

// The adaptive method of order 8 keeps its tolerance at any eccentricity.
mod adaptive_method_keeps_its_tolerance;
// Three bodies follow their known solutions and conserve their integrals.
mod bodies_follow_exact_solutions;
// The least separation of two bodies is found within its step.
mod close_encounters_are_found_within_their_step;
// Elements and vectors are those of REBOUND, in both directions.
mod elements_agree_with_rebound;
// Explicit Euler gains energy and angular momentum at the predicted rate.
mod euler_drift_follows_its_closed_form;
// Explicit Euler gives the numbers of an independent program.
mod euler_matches_independent_program;
// Halving the time step divides the error by 2^p for each integrator.
mod integrators_have_their_order;
// Kepler's three laws hold at any time, forward and backward.
mod kepler_motion_equals_50_digit_reference;
// Symplectic methods keep their energy error bounded.
mod symplectic_methods_do_not_drift;
// Massive bodies move as if test particles were absent.
mod test_particles_change_no_bit;

// Frames, log and drawings describe the run; invalid initial states are rejected.
mod frames_and_drawings_describe_the_run;
// Period, distances and phase do not depend on the number of frames.
mod metrics_do_not_depend_on_the_frame_interval;
// The angle around the Sun is continuous through whole revolutions.
mod phase_is_unwrapped;
// Two runs separate exponentially where the motion is chaotic, and else in proportion to time.
mod lyapunov_exponent_is_positive_only_for_chaotic_orbits;

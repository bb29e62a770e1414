//! Laws of the orbit model: the two-body problem, several bodies, and the errors of each integrator.
//!
//! A test belongs here if it compares an orbit run with a closed form, an independent program, an order of convergence or
//! itself in memory.

// Preparing, advancing and reading an orbit run.
mod run;

// The adaptive method of order 8 keeps its tolerance at any eccentricity.
mod adaptive_method_is_exact;
// Three bodies follow their known solutions and conserve their integrals.
mod bodies_follow_exact_solutions;
// Explicit Euler gains energy and angular momentum at the predicted rate.
mod euler_energy_drift;
// Explicit Euler gives the numbers of an independent program.
mod euler_matches_independent_program;
// Halving the time step divides the error by 2^p for each integrator.
mod integrator_orders;
// Kepler's three laws, at any time, forward and backward.
mod kepler_reference;
// Symplectic methods keep their energy error bounded.
mod symplectic_methods_do_not_drift;

// Work budget, observation and resuming change no bit; invalid starts are rejected.
mod looking_changes_nothing;
// The angle around the Sun is continuous through whole turns.
mod phase_is_unwrapped;

//! Laws of hard discs: collisions, walls, velocity distributions, pressure, order, and dense starts.
//!
//! A test belongs here if it compares a packing run with a closed form, Enskog's theory, the plain reference program below
//! or published values.

// Configurations, advancing and readings of frames that the tests share.
mod bench;
// Periodic starts, minimum-image distances, Z and psi6.
mod without_walls;

// The engine finds the same collisions at the same times as the plainest program.
mod agrees_with_reference;
// A pair collision reverses the normal relative velocity and scales it by the restitution.
mod pair_collision;
// A single disc follows its unfolded straight path.
mod single_disc_billiard;
// A noisy wall turns the outgoing direction by a normal angle and keeps the speed.
mod wall_noise;

// Inelastic discs cool by Haff's law; three discs on a line collapse.
mod cooling;
// No two discs overlap and no disc leaves the box, in any frame.
mod discs_never_overlap;
// Elastic discs conserve energy, noisy walls included.
mod energy_is_constant;
// Work budget, observation and resuming change no bit; runs end where asked.
mod looking_is_passive;

// The mean of a2 for n elastic discs is -1/(n + 1).
mod a2_of_few_discs;
// Mixtures of diameters collide at the rates of their contact values.
mod mixtures_follow_their_contact_values;
// Compressibility of the periodic fluid, and compression to dense states.
mod periodic_and_dense;
// Collision rate and pressure of elastic discs between walls follow Enskog.
mod pressure_and_rate;
// Z, a2, psi6 and distances at the accuracy of published references.
mod reference_values;
// Starts are inside and apart; those that cannot be built are rejected.
mod starts;
// Initial velocities are normal; the two variances differ by a scale of time only.
mod velocity_laws;

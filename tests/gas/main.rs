//! Laws of the gas in a circular container: exact motion, wall pressure, temperatures, speed distributions, walls, collisions.
//!
//! A test belongs here if it compares a gas run with a closed form, kinetic theory, the printed scheme or itself in memory.

// Configurations, propagation and readings of frames that the tests share.
mod runs;

// A particle follows the chords of the circular billiard.
mod exact_motion;
// The wall keeps speed and angular momentum of every particle.
mod invariants;
// Invariants and pressure hold after a million wall collisions, on any number of threads.
mod million_hits;
// Time steps of any length lead along the exact path.
mod stepped_agrees_with_exact;
// The nine defects of the printed scheme are shown and detected.
mod document_defects;

// Angles, chords and rate of wall collisions follow the uniform isotropic state.
mod hits_of_the_wall;
// The wall pressure is N m <v^2> / (2 A).
mod pressure_of_the_wall;
// Speeds follow the distribution from which they were drawn.
mod speed_histogram;
// The temperature set holds exactly by the definition in use.
mod temperature_definitions;
// Moving walls do work, thermal walls exchange heat, openings release particles.
mod walls_that_do_more_than_mirror;

// Elastic collisions relax speeds to Maxwell's distribution.
mod collisions_make_maxwell;
// Colliding discs conserve energy and angular momentum and collide at Enskog's rate.
mod discs_keep_what_they_must;

// Starts, rejected configurations, frames and checkpoints of the gas.
mod start_and_frames;

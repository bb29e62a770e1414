//! Topics of the channels whose messages are not ours but those of Foxglove.

/// Topic of the constants of all particles: the columns of the state that a particle keeps. Written when they change.
pub const PARTICLES: &str = "/particles";
/// Topic of the exact state of all particles, without their constants.
pub const STATE: &str = "/state";
/// Topic of the discs drawn to scale.
pub const DISCS: &str = "/discs";
/// Topic of the container: written once, or with every frame where it moves.
pub const WALLS: &str = "/walls";
/// Topic of the color bar, written once.
pub const LEGEND: &str = "/legend";
/// Topic of the velocity arrows.
pub const VELOCITY: &str = "/velocity";
/// Topic of the force chains.
pub const FORCE_CHAINS: &str = "/force_chains";
/// Topic of the paths so far.
pub const TRAIL: &str = "/trail";
/// Topic of what happened and when.
pub const LOG: &str = "/log";

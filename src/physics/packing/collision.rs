//! A collision that has been executed, as the engine reports it.

use super::motion::Vector;

/// A collision that has been executed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Collision {
    /// The first participant: of two discs, the one with the lower number.
    pub(super) disc: u32,
    /// The other participant.
    pub(super) partner: CollisionPartner,
    /// Center of the other disc, or of the obstacle, relative to that of the first; for a wall, its normal out of the box.
    pub(super) separation: Vector,
    /// Velocities before and after, for each disc that took part.
    pub(super) velocity_changes: VelocityChanges,
    /// Magnitude of the momentum transferred along the normal.
    pub(super) normal_impulse: f64,
    /// Kinetic energy that the discs gain from the floor, or, below 0, lose in a collision with restitution. Known in gravity only.
    pub(super) energy_gain: f64,
    /// Time since the previous collision in the system, or since the start.
    pub(super) time_since_previous: f64,
}

/// The object with which a disc collides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CollisionPartner {
    /// Another disc.
    Disc {
        /// Its number.
        id: u32,
        /// The sum of the full radii.
        contact_distance: f64,
    },
    /// A fixed obstacle.
    Obstacle,
    /// A wall.
    Wall,
}

/// Velocities before and after a collision, of two discs. For a collision with a wall or an obstacle, the second entry is zero.
pub(super) type VelocityChanges = [[Vector; 2]; 2];

//! `[model.gas]`: a wall with a temperature.

use crate::keys::{HasKeys, Keys};
use crate::quantity::{Positive, Share};
use crate::table::table;

/// A wall with a temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThermalWall {
    /// Temperature of the wall, K, by the mean square.
    pub temperature_k: Positive,
    /// Fraction of the wall collisions after which a particle leaves with the wall's temperature; in the others it is
    /// specularly reflected.
    pub accommodation: Share,
}

table! {
    /// The keys of a [`ThermalWall`].
    struct ThermalWallKeys {
        /// Temperature of a wall that re-emits particles with Maxwell's velocities. Needs exact propagation.
        wall_temperature_k: Option<Positive> ["K", optional],
        /// Fraction of the wall collisions after which a particle leaves with the wall's temperature, the others being
        /// specular reflections; 1 where it is left out. Needs `wall_temperature_k`.
        wall_accommodation: Option<Share> ["1", optional],
    }
}

impl HasKeys for Option<ThermalWall> {
    fn keys(&mut self, keys: &mut impl Keys) {
        let mut own = ThermalWallKeys {
            wall_temperature_k: self.map(|wall| wall.temperature_k),
            wall_accommodation: self.map(|wall| wall.accommodation),
        };
        own.keys(keys);
        *self = own.wall_temperature_k.map(|temperature_k| ThermalWall {
            temperature_k,
            accommodation: own.wall_accommodation.unwrap_or(const { Share::literal(1.0) }),
        });
    }
}

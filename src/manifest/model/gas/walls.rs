//! `[model.gas]`: a wall with a temperature.

use crate::keys::{HasKeys, Keys};
use crate::quantity::{Fraction, Positive};
use crate::table::table;

/// A wall with a temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThermalWall {
    /// Temperature of the wall, K, by the mean square.
    pub temperature_k: Positive,
    /// Fraction of the wall collisions after which a particle leaves with the wall's temperature; in the others it is
    /// specularly reflected.
    pub accommodation: Fraction,
}

table! {
    /// The keys of a [`ThermalWall`].
    struct ThermalWallKeys {
        /// Temperature of a wall that re-emits particles with Maxwell's velocities. Needs exact propagation.
        wall_temperature_k: Option<Positive> ["K", optional],
        /// Fraction of the wall collisions after which a particle leaves with the wall's temperature, the others being
        /// specular reflections; 1 where it is left out. Needs `wall_temperature_k`.
        accommodation_coefficient: Option<Fraction> ["1", optional],
    }
}

impl HasKeys for Option<ThermalWall> {
    fn keys(&mut self, keys: &mut impl Keys) {
        let mut own = ThermalWallKeys {
            wall_temperature_k: self.map(|wall| wall.temperature_k),
            accommodation_coefficient: self.map(|wall| wall.accommodation),
        };
        own.keys(keys);
        *self = own.wall_temperature_k.map(|temperature_k| ThermalWall {
            temperature_k,
            accommodation: own
                .accommodation_coefficient
                .unwrap_or(const { Fraction::literal(1.0) }),
        });
    }
}

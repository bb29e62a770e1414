//! `[model.packing]`: a floor that is shaken.

use crate::keys::{HasKeys, Keys};
use crate::quantity::Positive;
use crate::table::table;

/// A floor that is shaken on parabolas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaking {
    /// Distance between its lowest position, where it starts, and its highest one.
    pub stroke: Positive,
    /// Period.
    pub period: Positive,
}

table! {
    /// The keys of a [`Shaking`].
    struct ShakingKeys {
        /// Distance by which the floor is shaken up from the bottom of the box, on parabolas. Needs `floor_period`.
        floor_stroke: Option<Positive> ["1", optional],
        /// Period of the shaken floor. Needs `floor_stroke`.
        floor_period: Option<Positive> ["1", optional],
    }
}

impl HasKeys for Option<Shaking> {
    fn keys(&mut self, keys: &mut impl Keys) {
        let mut own = ShakingKeys {
            floor_stroke: self.map(|floor| floor.stroke),
            floor_period: self.map(|floor| floor.period),
        };
        own.keys(keys);
        let both = own.floor_stroke.zip(own.floor_period);
        *self = both.map(|(stroke, period)| Shaking { stroke, period });
    }
}

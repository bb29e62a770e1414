//! `[model.gas]`: a partition that is removed.

use crate::keys::{HasKeys, Keys};
use crate::quantity::{Finite, Positive};
use crate::table::table;
use crate::value::words;

words! {
    /// What the partition separates.
    pub enum PartitionSide {
        /// All particles start to the left of the partition.
        Left = "left",
        /// Particles of `mass_kg` start to its left, those of `additional_masses_kg` to its right.
        ByMass = "by-mass",
    }
}

/// A straight vertical partition that is removed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Partition {
    /// Its x coordinate, m.
    pub x_m: Finite,
    /// When it is removed, s; it stays if this is left out.
    pub opens_s: Option<Positive>,
    /// What it separates; `None` for a given start, whose positions say it.
    pub side: Option<PartitionSide>,
}

table! {
    /// The keys of a [`Partition`].
    struct PartitionKeys {
        /// x coordinate of a straight vertical partition across the container. Needs exact propagation, points and a wall at
        /// rest.
        partition_x_m: Option<Finite> ["m", optional],
        /// Time at which the partition is removed; it stays if this is left out. Needs `partition_x_m`.
        partition_opens_s: Option<Positive> ["s", optional],
        /// left: all particles start to the left of the partition (default). by-mass: particles of `mass_kg` start to its left,
        /// those of `additional_masses_kg` to its right. Needs `partition_x_m`.
        partition_side: Option<PartitionSide> ["", optional],
    }
}

impl HasKeys for Option<Partition> {
    fn keys(&mut self, keys: &mut impl Keys) {
        let mut own = PartitionKeys {
            partition_x_m: self.map(|partition| partition.x_m),
            partition_opens_s: self.and_then(|partition| partition.opens_s),
            partition_side: self.and_then(|partition| partition.side),
        };
        own.keys(keys);
        let (opens_s, side) = (own.partition_opens_s, own.partition_side);
        *self = own.partition_x_m.map(|x_m| Partition { x_m, opens_s, side });
    }
}

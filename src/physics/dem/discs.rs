//! The discs in memory, in the order of their cells when the neighbor lists were built.

use super::block::{BLOCK, BlockDiscs, BlockView};
use serde::{Deserialize, Serialize};

/// The discs, column by column. All columns have one length and one order, which `ids` records.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Discs {
    /// A disc's number, from 0.
    pub(super) ids: Vec<u32>,
    /// Centers, m.
    pub(super) positions: Vec<[f64; 2]>,
    /// The integrator's velocities, half a step behind the centers, m/s. They have a column of their own, because most
    /// comparisons need positions only.
    pub(super) velocities: Vec<[f64; 2]>,
    /// The integrator's angular velocities, half a step behind, rad/s.
    pub(super) spins: Vec<f64>,
    /// Radii, m.
    pub(super) radii: Vec<f64>,
    /// Masses, kg.
    pub(super) masses: Vec<f64>,
    /// Inverse masses, 1/kg: they save one division per disc and step.
    pub(super) inverse_masses: Vec<f64>,
    /// Material numbers.
    pub(super) materials: Vec<u8>,
}

/// One disc.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Disc {
    pub(super) id: u32,
    /// Center, m.
    pub(super) position: [f64; 2],
    /// The integrator's velocity, m/s.
    pub(super) velocity: [f64; 2],
    /// m
    pub(super) radius: f64,
    /// kg
    pub(super) mass: f64,
    pub(super) material: u8,
}

/// No index.
const NONE: u32 = u32::MAX;

impl Discs {
    /// Number of discs.
    pub(super) fn len(&self) -> usize {
        self.positions.len()
    }

    /// Reorders the discs; `order` holds the old index for each new one and may omit discs.
    pub(super) fn reorder(&mut self, order: &[u32]) {
        fn sort<T: Copy>(column: &mut Vec<T>, order: &[u32]) {
            let values = column.as_slice();
            *column = order.iter().map(|&disc| values[disc as usize]).collect();
        }
        /// Skips a column of bitwise identical values.
        fn sort_if_needed<T: Copy, Bits: PartialEq>(
            column: &mut Vec<T>,
            order: &[u32],
            bits: impl Fn(T) -> Bits,
        ) {
            match column.first().map(|&first| bits(first)) {
                Some(first) if column.iter().all(|&value| bits(value) == first) => {
                    column.truncate(order.len());
                }
                _ => sort(column, order),
            }
        }
        sort(&mut self.ids, order);
        sort(&mut self.positions, order);
        sort(&mut self.velocities, order);
        sort_if_needed(&mut self.spins, order, f64::to_bits);
        sort_if_needed(&mut self.radii, order, f64::to_bits);
        sort_if_needed(&mut self.masses, order, f64::to_bits);
        sort_if_needed(&mut self.inverse_masses, order, f64::to_bits);
        sort_if_needed(&mut self.materials, order, |material| material);
    }

    /// Adds a disc without spin.
    pub(super) fn push(&mut self, disc: &Disc) {
        self.ids.push(disc.id);
        self.positions.push(disc.position);
        self.velocities.push(disc.velocity);
        self.spins.push(0.0);
        self.radii.push(disc.radius);
        self.masses.push(disc.mass);
        self.inverse_masses.push(1.0 / disc.mass);
        self.materials.push(disc.material);
    }

    /// All discs as one block.
    pub(super) fn as_block(&mut self) -> BlockDiscs<'_> {
        let Self { positions, velocities, spins, radii, masses, inverse_masses, materials, .. } =
            self;
        BlockDiscs { positions, velocities, spins, radii, masses, inverse_masses, materials }
    }

    /// The columns of a block's discs that contact forces depend on.
    pub(super) fn view(&self, start: usize) -> BlockView<'_> {
        let block = start..Ord::min(start + BLOCK, self.len());
        BlockView {
            start,
            positions: &self.positions[block.clone()],
            velocities: &self.velocities[block.clone()],
            spins: &self.spins[block.clone()],
            radii: &self.radii[block.clone()],
            materials: &self.materials[block],
        }
    }

    /// The discs of each block.
    pub(super) fn blocks(&mut self) -> Vec<BlockDiscs<'_>> {
        let states = self.positions.chunks_mut(BLOCK).zip(self.velocities.chunks_mut(BLOCK));
        let moving = states.zip(self.spins.chunks_mut(BLOCK));
        let masses = self.masses.chunks(BLOCK).zip(self.inverse_masses.chunks(BLOCK));
        let bodies = self.radii.chunks(BLOCK).zip(masses).zip(self.materials.chunks(BLOCK));
        let own =
            |(((positions, velocities), spins), ((radii, (masses, inverse_masses)), materials))| {
                BlockDiscs {
                    positions,
                    velocities,
                    spins,
                    radii,
                    masses,
                    inverse_masses,
                    materials,
                }
            };
        moving.zip(bodies).map(own).collect()
    }

    /// The index of each disc, in the order of the ids.
    pub(super) fn by_id(&self) -> impl Iterator<Item = usize> {
        // Few ids are missing, so no sort is needed.
        let most = self.ids.iter().fold(0, |most, &id| Ord::max(most, id as usize + 1));
        let mut places = vec![NONE; most];
        for (place, &id) in (0..).zip(&self.ids) {
            places[id as usize] = place;
        }
        places.into_iter().filter(|&place| place != NONE).map(|place| place as usize)
    }
}

//! The discs in memory, in the order of their cells when the neighbor lists were built, and scans of all positions.
//!
//! The scans use SIMD instructions. Maxima and minima do not depend on the width; they ignore a position that is not a number.

use super::block::{BLOCK, BlockDiscs, Partner};
use super::motion;
use crate::simd::registers::{Register as _, each, vectorized};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::ops::Range;

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

    /// Whether all columns have one length, numbers are finite, materials exist, and ids are different numbers below `total`.
    pub(super) fn is_valid(&self, total: u64, materials: usize) -> bool {
        let count = self.len();
        let lengths = [
            self.ids.len(),
            self.velocities.len(),
            self.spins.len(),
            self.radii.len(),
            self.masses.len(),
            self.inverse_masses.len(),
            self.materials.len(),
        ];
        let sizes = self.radii.iter().chain(&self.masses).chain(&self.inverse_masses);
        let mut ids = self.ids.clone();
        ids.sort_unstable();
        lengths.iter().all(|length| *length == count)
            && self.positions.iter().chain(&self.velocities).flatten().all(|part| part.is_finite())
            && self.spins.iter().all(|spin| spin.is_finite())
            && sizes.into_iter().all(|size| size.is_finite() && *size > 0.0)
            && self.materials.iter().all(|&material| usize::from(material) < materials)
            && ids.is_sorted_by(|one, other| one < other)
            && ids.last().is_none_or(|last| u64::from(*last) < total)
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

    /// Effective mass of a disc and its partner, kg.
    pub(super) fn effective_mass(&self, disc: usize, partner: Partner) -> f64 {
        let mass = self.masses[disc];
        match partner {
            Partner::Disc(other) => motion::effective_mass(mass, self.masses[other as usize]),
            Partner::Wall(_) => mass,
        }
    }

    /// R of a disc and its partner, m: 1/R is the sum of their inverse radii, 1/r with a wall.
    pub(super) fn reduced_radius(&self, disc: usize, partner: Partner) -> f64 {
        let radius = self.radii[disc];
        match partner {
            Partner::Disc(other) => motion::reduced_radius(radius, self.radii[other as usize]),
            Partner::Wall(_) => radius,
        }
    }

    /// Adds discs without spin.
    pub(super) fn extend(&mut self, discs: &[Disc]) {
        discs.iter().for_each(|disc| self.push(disc));
    }

    /// The discs of each block.
    pub(super) fn blocks(&mut self) -> Vec<BlockDiscs<'_>> {
        let Self { positions, velocities, spins, .. } = self;
        let states = positions.chunks_mut(BLOCK).zip(velocities.chunks_mut(BLOCK));
        let states = (0..).step_by(BLOCK).zip(states.zip(spins.chunks_mut(BLOCK)));
        let blocks = states.map(|(start, ((positions, velocities), spins))| {
            let own = start..start + spins.len();
            BlockDiscs {
                start,
                positions,
                velocities,
                spins,
                radii: &self.radii[own.clone()],
                masses: &self.masses[own.clone()],
                inverse_masses: &self.inverse_masses[own.clone()],
                materials: &self.materials[own],
            }
        });
        blocks.collect()
    }

    /// The index of each disc, in the order of the ids.
    pub(super) fn by_id(&self) -> impl Iterator<Item = usize> {
        // Few ids are missing, so no sort is needed.
        let mut places = vec![NONE; self.id_end()];
        for (place, &id) in (0..).zip(&self.ids) {
            places[id as usize] = place;
        }
        places.into_iter().filter(|&place| place != NONE).map(|place| place as usize)
    }

    /// The inverse of [`Discs::by_id`]: the number of smaller ids, for each disc.
    pub(super) fn rows_by_id(&self) -> Cow<'_, [u32]> {
        let end = self.id_end();
        if end == self.ids.len() {
            // No id is missing.
            return Cow::Borrowed(&self.ids);
        }
        let mut rows = vec![0; end];
        self.ids.iter().for_each(|&id| rows[id as usize] = 1);
        let mut next = 0;
        for row in &mut rows {
            next += std::mem::replace(row, next);
        }
        Cow::Owned(self.ids.iter().map(|&id| rows[id as usize]).collect())
    }

    /// Whether a disc has a spin.
    pub(super) fn have_spin(&self) -> bool {
        self.spins.iter().any(|spin| spin.to_bits() != 0)
    }

    /// The number above all ids.
    fn id_end(&self) -> usize {
        self.ids.iter().fold(0, |end, &id| Ord::max(end, id as usize + 1))
    }
}

/// Discs per group. A group without a disc that left is scanned once.
const GROUP: usize = 64;

/// The largest displacement of a disc, m.
pub(super) fn max_displacement(from: &[[f64; 2]], positions: &[[f64; 2]]) -> f64 {
    max_displacement_squared(from, positions).sqrt()
}

/// Distance of the nearest center to a closed side of the box, m.
pub(super) fn clearance(positions: &[[f64; 2]], sides: [f64; 2], periodic: [bool; 2]) -> f64 {
    if periodic == [true, true] {
        return f64::INFINITY;
    }
    let least = least_distances(positions, sides);
    let closed = (0..2).filter(|&axis| !periodic[axis]);
    closed.fold(f64::INFINITY, |nearest, axis| smaller(least[axis], nearest))
}

/// Ranges of adjacent discs that contain all discs outside a periodic side.
pub(super) fn groups_that_left(
    positions: &[[f64; 2]],
    sides: [f64; 2],
    periodic: [bool; 2],
) -> Vec<Range<usize>> {
    let range = |axis: usize| {
        if periodic[axis] { (0.0, sides[axis]) } else { (f64::NEG_INFINITY, f64::INFINITY) }
    };
    let ((left, right), (bottom, top)) = (range(0), range(1));
    let groups = positions.chunks(GROUP).enumerate();
    groups
        .filter(|(_, positions)| some_are_outside(positions, [left, bottom], [right, top]))
        .map(|(number, positions)| number * GROUP..number * GROUP + positions.len())
        .collect()
}

#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

vectorized! {
    fn max_displacement_squared(from: &[[f64; 2]], positions: &[[f64; 2]]) -> f64 {
        let squared = |then: [f64; 2], now: [f64; 2]| {
            motion::distance_squared([now[0] - then[0], now[1] - then[1]])
        };
        let (from, last_from) = from.as_chunks::<4>();
        let (positions, last_positions) = positions.as_chunks::<4>();
        let mut longest = [0.0; 4];
        for (then, now) in from.iter().zip(positions) {
            let squared = each(|disc| squared(then[disc], now[disc]));
            longest = each(|disc| squared[disc].larger(longest[disc]));
        }
        for (&then, &now) in last_from.iter().zip(last_positions) {
            longest[0] = squared(then, now).larger(longest[0]);
        }
        longest[0].larger(longest[1]).larger(longest[2].larger(longest[3]))
    }

    /// The least distance from the sides across each axis, m.
    fn least_distances(positions: &[[f64; 2]], sides: [f64; 2]) -> [f64; 2] {
        let mut least = [f64::INFINITY; 4];
        for &[x, y] in positions {
            let distances = [x, y, sides[0] - x, sides[1] - y];
            least = each(|side| smaller(distances[side], least[side]));
        }
        [smaller(least[0], least[2]), smaller(least[1], least[3])]
    }

    /// A position that is not a number is outside.
    fn some_are_outside(positions: &[[f64; 2]], low: [f64; 2], high: [f64; 2]) -> bool {
        positions.iter().fold(false, |some, &[x, y]| {
            let is_inside = (x >= low[0]) & (x < high[0]) & (y >= low[1]) & (y < high[1]);
            some | !is_inside
        })
    }
}

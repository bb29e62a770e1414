//! Displaced discs, for a twin of a run.

use super::Dem;
use crate::twins::{Displaceable, Offset};

impl Displaceable for Dem {
    /// Positions and velocities of the discs, each x and y, then the spins with the velocities.
    fn offset_from(&self, other: &Self) -> Offset {
        let pairs: Vec<(usize, usize)> = self.discs.by_id().zip(other.discs.by_id()).collect();
        let (discs, others) = (&self.discs, &other.discs);
        let way = |(one, other): &(usize, usize)| {
            [0, 1].map(|axis: usize| {
                let way = discs.positions[*one][axis] - others.positions[*other][axis];
                let side = self.parameters.sides[axis];
                way - if self.parameters.periodic[axis] {
                    side * libm::round(way / side)
                } else {
                    0.0
                }
            })
        };
        let velocity = |(one, other): &(usize, usize)| {
            [0, 1].map(|axis: usize| discs.velocities[*one][axis] - others.velocities[*other][axis])
        };
        let spins = pairs.iter().map(|(one, other)| discs.spins[*one] - others.spins[*other]);
        [
            pairs.iter().flat_map(way).collect(),
            pairs.iter().flat_map(velocity).chain(spins).collect(),
        ]
    }

    fn displace(&mut self, by: &Offset) {
        let places: Vec<usize> = self.discs.by_id().collect();
        let [(ways, _), (changes, spins)] = by.each_ref().map(|of| {
            let (pairs, rest) = of.split_at(2 * places.len());
            (pairs.as_chunks::<2>().0, rest)
        });
        let discs = &mut self.discs;
        for (number, disc) in places.into_iter().enumerate() {
            for axis in 0..2 {
                discs.positions[disc][axis] += ways[number][axis];
                discs.velocities[disc][axis] += changes[number][axis];
            }
            discs.spins[disc] += spins.get(number).copied().unwrap_or(0.0);
        }
    }

    fn size(&self) -> f64 {
        let [width, height] = self.parameters.sides;
        if width > height { width } else { height }
    }
}

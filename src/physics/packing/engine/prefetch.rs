//! Memory is asked for before it is needed: what the coming events will look at.

use super::Engine;
use crate::cell_grid::Cell;
use crate::cell_lists::CellLists;
use crate::packing::disc::DiscRecord;
use crate::packing::event_queue::Ahead;
use crate::packing::events::{EventCode, EventKind};
use crate::simd::prefetch::prefetch;

/// So many events lie between two stages: time enough for memory to answer.
const STAGE: usize = 2;

/// Of a cell's places the first ones are looked at ahead: few cells have more discs.
const PLACES: usize = 2;

impl Engine {
    /// The disc whose event comes first.
    #[inline(always)]
    pub(super) fn next(&mut self) -> Option<u32> {
        let (discs, cells) = (&self.state.discs, &self.cells);
        let prefetches = self.prefetches;
        self.event_queue.first(discs, |ahead| {
            if prefetches {
                fetch(discs, cells, ahead);
            }
        })
    }
}

/// Asks for what the coming events will look at: the discs first, when these are there the cells around, and then
/// whoever stands in them.
#[inline(never)]
fn fetch(discs: &[DiscRecord], cells: &CellLists, ahead: Ahead<'_>) {
    if let Some((disc, event)) = ahead.after(3 * STAGE) {
        prefetch(discs, disc as usize);
        // The partner, if there is one.
        prefetch(discs, event.bits() as usize);
    }
    if let Some((disc, event)) = ahead.after(2 * STAGE) {
        for_each_center(discs, cells, disc, event, |cell| {
            let (slots, rows, columns) = cells.block_indices(cell);
            for row in rows {
                prefetch(slots, row + columns[0]);
                prefetch(slots, row + columns[2]);
            }
        });
    }
    if let Some((disc, event)) = ahead.after(STAGE) {
        for_each_center(discs, cells, disc, event, |cell| {
            for slots in cells.block_slots(cell) {
                for &other in &slots[..PLACES] {
                    prefetch(discs, other as usize);
                }
            }
        });
    }
}

/// The cells around which an event will search.
#[inline(always)]
fn for_each_center(
    discs: &[DiscRecord],
    cells: &CellLists,
    disc: u32,
    event: EventCode,
    visit: impl Fn(Cell),
) {
    let record = &discs[disc as usize];
    if record.event != event {
        // It has another event by now, and this one will be passed over.
        return;
    }
    match event.kind() {
        EventKind::Pair(partner) => {
            visit(record.cell);
            visit(discs[partner as usize].cell);
        }
        EventKind::CellCrossing(side) => visit(cells.grid.neighbor(record.cell, side)),
        EventKind::Wall(_) | EventKind::None => visit(record.cell),
    }
}

#[cfg(test)]
mod tests {
    use crate::packing::domain::{Domain, ElasticThreshold};
    use crate::packing::engine::Engine;
    use crate::random::{Seed, Stream};

    /// Promise: fetching ahead changes no bit. Setup: 400 discs on a square lattice, within walls with noise and periodic, once
    /// with fetching ahead and once without; 40,000 events, crossings and void ones among them.
    #[test]
    fn fetching_ahead_changes_no_bit() {
        let seed = Seed { seed: 4, replicate: 0 };
        for has_walls in [true, false] {
            let wall_noise_rad = if has_walls { 0.1 } else { 0.0 };
            let (restitution, elastic_threshold) = (1.0, ElasticThreshold::Off);
            let sides = [60.0; 2];
            let domain = Domain {
                sides,
                has_walls,
                max_radius: 1.0,
                restitution,
                elastic_threshold,
                wall_noise_rad,
            };
            let engine_that = |prefetches| {
                let positions = (0..400).map(|disc| {
                    [disc % 20, disc / 20].map(|place: u32| 3.0 * f64::from(place) - 28.5)
                });
                let mut generator = seed.stream(Stream::Velocities);
                let velocities = (0..400).map(|_| generator.normal_pair()).collect();
                let noise = seed.stream(Stream::WallNoise);
                let (positions, radii) = (positions.collect(), Vec::new());
                let mut engine = Engine::new(domain, positions, velocities, radii, 2.0, noise);
                engine.prefetches = prefetches;
                for _ in 0..40_000 {
                    engine.step::<false>(f64::INFINITY).unwrap();
                }
                engine
            };
            assert!(engine_that(true) == engine_that(false), "has_walls = {has_walls}");
        }
    }
}

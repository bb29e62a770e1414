//! Prefetches the memory that the next events will read.

use super::state::Engine;
use crate::cell_grid::Cell;
use crate::cell_lists::CellLists;
use crate::packing::disc::DiscRecord;
use crate::packing::event_queue::UpcomingEvents;
use crate::packing::events::{EventCode, EventKind};
use crate::simd::prefetch::prefetch;

/// Number of events between two stages: memory needs this time to respond.
const STAGE: usize = 2;

/// Number of slots per cell whose discs are prefetched: few cells have more discs.
const SLOTS: usize = 2;

impl Engine {
    /// The disc whose event is the earliest.
    #[inline(always)]
    pub(super) fn first_scheduled(&mut self) -> Option<u32> {
        let (discs, cells) = (&self.state.discs, &self.cells);
        let prefetches = self.prefetches;
        self.event_queue.first(discs, |upcoming| {
            if prefetches {
                prefetch_events(discs, cells, upcoming);
            }
        })
    }
}

/// Prefetches what the upcoming events will read, in three stages: first the discs of the event, then the cells around
/// them, then the discs in these cells.
#[inline(never)]
fn prefetch_events(discs: &[DiscRecord], cells: &CellLists, upcoming: UpcomingEvents<'_>) {
    if let Some((disc, event)) = upcoming.get(3 * STAGE) {
        prefetch(discs, disc as usize);
        // The partner, if the event is a pair collision.
        prefetch(discs, event.0 as usize);
    }
    if let Some((disc, event)) = upcoming.get(2 * STAGE) {
        for_each_scanned_block(discs, cells, disc, event, |cell| {
            let (slots, rows, columns) = cells.block_indices(cell);
            for row in rows {
                prefetch(slots, row + columns[0]);
                prefetch(slots, row + columns[2]);
            }
        });
    }
    if let Some((disc, event)) = upcoming.get(STAGE) {
        for_each_scanned_block(discs, cells, disc, event, |cell| {
            for slots in cells.block_slots(cell) {
                for &other in &slots[..SLOTS] {
                    prefetch(discs, other as usize);
                }
            }
        });
    }
}

/// Calls `visit` with the central cell of each block that the predictions after an event will scan.
#[inline(always)]
fn for_each_scanned_block(
    discs: &[DiscRecord],
    cells: &CellLists,
    disc: u32,
    event: EventCode,
    visit: impl Fn(Cell),
) {
    let record = &discs[disc as usize];
    if record.event != event {
        // The disc has another event, and this entry will be skipped.
        return;
    }
    match event.kind() {
        EventKind::Pair(partner) => {
            visit(record.cell);
            visit(discs[partner as usize].cell);
        }
        EventKind::CellCrossing(side) => visit(cells.grid.neighbor(record.cell, side)),
        EventKind::Obstacle | EventKind::Wall(_) | EventKind::None => visit(record.cell),
    }
}

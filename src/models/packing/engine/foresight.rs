//! Memory is asked for before it is needed: what the coming events will look at.

use super::Engine;
use crate::models::packing::calendar::Ahead;
use crate::models::packing::cells::Cells;
use crate::models::packing::disc::Disc;
use crate::models::packing::events::{EventCode, EventKind};
use crate::models::packing::processor::fetch_ahead;

/// So few discs stay in the processor's caches: fetching ahead would only cost.
const FETCHED_AHEAD_FROM: usize = 20_000;

/// So many events lie between two stages: time enough for memory to answer.
const STAGE: usize = 2;

/// Of a cell's places the first ones are looked at ahead: few cells have more discs.
const PLACES: usize = 2;

impl Engine {
    /// The disc whose event comes first.
    #[inline(always)]
    pub(super) fn next(&mut self) -> Option<u32> {
        let (discs, cells) = (&self.state.discs, &self.cells);
        let is_large = discs.len() >= FETCHED_AHEAD_FROM;
        self.calendar.first(discs, |ahead| {
            if is_large {
                fetch(discs, cells, ahead);
            }
        })
    }
}

/// Asks for what the coming events will look at: the discs first, when these are there the cells around, and then
/// whoever stands in them.
#[inline(never)]
fn fetch(discs: &[Disc], cells: &Cells, ahead: Ahead<'_>) {
    if let Some((disc, event)) = ahead.after(3 * STAGE) {
        fetch_ahead(discs, disc as usize);
        // The partner, if there is one.
        fetch_ahead(discs, event.word() as usize);
    }
    if let Some((disc, event)) = ahead.after(2 * STAGE) {
        for_each_centre(discs, cells, disc, event, |cell| {
            let (slots, rows, columns) = cells.block(cell);
            for row in rows {
                fetch_ahead(slots, row + columns[0]);
                fetch_ahead(slots, row + columns[2]);
            }
        });
    }
    if let Some((disc, event)) = ahead.after(STAGE) {
        for_each_centre(discs, cells, disc, event, |cell| {
            for slots in cells.around(cell) {
                for &other in &slots[..PLACES] {
                    fetch_ahead(discs, other as usize);
                }
            }
        });
    }
}

/// The cells around which an event will search.
#[inline(always)]
fn for_each_centre(
    discs: &[Disc],
    cells: &Cells,
    disc: u32,
    event: EventCode,
    visit: impl Fn([u16; 2]),
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
        EventKind::Crossing(side) => visit(cells.grid.beyond(record.cell, side)),
        EventKind::Wall(_) | EventKind::Nothing => visit(record.cell),
    }
}

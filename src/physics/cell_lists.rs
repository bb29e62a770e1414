//! The discs of each cell of a grid, inserted and removed one at a time: shared by the packing, the gas and random
//! placement.
//!
//! Invariant: the order of the discs of a cell influences no result.

use crate::cell_grid::{Cell, CellGrid};
use crate::memory::with_large_pages;

/// The content of an empty slot.
pub(crate) const NO_DISC: u32 = u32::MAX;

/// The slots of an empty cell.
const EMPTY: [u32; 4] = [NO_DISC; 4];

/// Number of occupied slots of a cell.
#[inline(always)]
fn occupied(slots: &[u32; 4]) -> usize {
    slots.iter().map(|&slot| usize::from(slot != NO_DISC)).sum()
}

/// Cells with four slots each, filled from the first. If a cell has more than four discs, its last slot is the head of a
/// linked list.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CellLists {
    /// The division into cells.
    pub(crate) grid: CellGrid,
    slots: Vec<[u32; 4]>,
    /// The next disc in the linked list of each disc. Empty until a cell has five discs.
    next: Vec<u32>,
    /// Number of discs that are not in a slot.
    overflow: usize,
}

impl CellLists {
    /// Empty cells.
    pub(crate) fn new(grid: CellGrid) -> Self {
        let size = grid.table_size();
        let mut slots = with_large_pages(size);
        slots.resize(size, EMPTY);
        Self { grid, slots, next: Vec::new(), overflow: 0 }
    }

    /// Whether any cell has more than four discs.
    #[inline(always)]
    pub(crate) fn has_overflow(&self) -> bool {
        self.overflow > 0
    }

    /// The slots of each cell of the block around a cell, row by row.
    #[inline(always)]
    pub(crate) fn block_slots(&self, cell: Cell) -> [&[u32; 4]; 9] {
        let (columns, rows) = self.grid.block(cell);
        let mut block = [&EMPTY; 9];
        for (index, slots) in block.iter_mut().enumerate() {
            *slots = &self.slots[rows[index / 3] + columns[index % 3]];
        }
        block
    }

    /// The slots of all cells, and the beginnings of the rows and the columns of the block around a cell. The sum of one of
    /// each is the index of a cell.
    #[inline(always)]
    pub(crate) fn block_indices(&self, cell: Cell) -> (&[[u32; 4]], [usize; 3], [usize; 3]) {
        let (columns, rows) = self.grid.block(cell);
        (&self.slots, rows, columns)
    }

    /// The disc that follows a disc in the linked list of its cell, or [`NO_DISC`].
    #[inline(always)]
    pub(crate) fn next_in_list(&self, disc: u32) -> u32 {
        if self.next.is_empty() { NO_DISC } else { self.next[disc as usize] }
    }

    /// All discs of the block around a cell. In a periodic grid of fewer than three columns or rows, discs are repeated.
    pub(crate) fn discs_around(&self, cell: Cell) -> impl Iterator<Item = u32> {
        let is_disc = |disc: &u32| *disc != NO_DISC;
        self.block_slots(cell).into_iter().flatten().copied().filter(is_disc).flat_map(
            move |first| {
                let next = move |disc: &u32| Some(self.next_in_list(*disc)).filter(is_disc);
                std::iter::successors(Some(first), next)
            },
        )
    }

    /// Inserts a disc into a cell; `discs` is the number of all discs.
    #[inline(always)]
    pub(crate) fn insert(&mut self, disc: u32, cell: Cell, discs: usize) {
        let index = self.grid.index(cell);
        let slots = &mut self.slots[index];
        let occupied = occupied(slots);
        if let Some(free) = slots.get_mut(occupied) {
            *free = disc;
        } else {
            self.insert_into_list(disc, index, discs);
        }
    }

    #[inline(never)]
    fn insert_into_list(&mut self, disc: u32, index: usize, discs: usize) {
        if self.next.is_empty() {
            self.next = vec![NO_DISC; discs];
        }
        let last = &mut self.slots[index][3];
        self.next[disc as usize] = *last;
        *last = disc;
        self.overflow += 1;
    }

    /// Removes a disc from its cell.
    #[inline(always)]
    pub(crate) fn remove(&mut self, disc: u32, cell: Cell) {
        let index = self.grid.index(cell);
        if self.has_overflow() {
            self.remove_with_lists(disc, index);
            return;
        }
        let slots = &mut self.slots[index];
        // The disc is in one of the four slots. Written without branches: which one cannot be predicted.
        let own = usize::from(slots[1] == disc)
            + 2 * usize::from(slots[2] == disc)
            + 3 * usize::from(slots[3] == disc);
        let last = (occupied(slots) + 3) % 4;
        slots[own] = slots[last];
        slots[last] = NO_DISC;
    }

    #[inline(never)]
    fn remove_with_lists(&mut self, disc: u32, index: usize) {
        let mut slots = self.slots[index];
        let last = (occupied(&slots) + 3) % 4;
        match slots.iter().position(|&other| other == disc) {
            Some(own) => {
                let moved = slots[last];
                slots[last] = self.next_in_list(moved);
                if own != last {
                    slots[own] = moved;
                }
                if slots[last] != NO_DISC {
                    self.next[moved as usize] = NO_DISC;
                    self.overflow -= 1;
                }
            }
            None => self.unlink(disc, slots[3]),
        }
        self.slots[index] = slots;
    }

    /// Removes a disc from the linked list that begins with `head`.
    fn unlink(&mut self, disc: u32, head: u32) {
        let mut before = head;
        while before != NO_DISC {
            let next = self.next_in_list(before);
            if next == disc {
                self.next[before as usize] = self.next[disc as usize];
                self.next[disc as usize] = NO_DISC;
                self.overflow -= 1;
                return;
            }
            before = next;
        }
    }
}

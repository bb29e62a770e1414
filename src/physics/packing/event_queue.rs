//! Which disc comes next: a calendar with one page for each short span of time.
//!
//! Events are thrown onto their page unsorted; a page is sorted when its time comes. So filing and taking an event cost
//! the same however many there are (Paul, J. Comput. Phys. 221, 615, 2007). Nothing is ever taken off a page early: an
//! entry whose disc has another event by now is passed over.
//!
//! What comes next depends on the discs' events alone: they are in a total order by time, kind, partner and disc. The
//! calendar is no part of the state, and its spans are chosen for speed.

use super::disc::DiscRecord;
use super::events::{EventCode, NEVER};
use crate::memory::with_large_pages;
use crate::simd::prefetch::prefetch;

/// Entries of a sheet: two cache lines.
const ENTRIES_OF_SHEET: usize = 8;

/// No sheet.
const NONE: u32 = u32::MAX;

/// At least so many events are meant to stand on a page, and this share of all.
const LEAST_ON_PAGE: f64 = 8.0;
const SHARE_ON_PAGE: f64 = 1.0 / 500.0;

/// The calendar goes on for so many mean waits of a disc; what comes later is filed again when the last page is turned.
const WAITS_AHEAD: f64 = 4.0;

/// An event of a disc: time, kind and partner, and disc in one number whose order is the order of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry(u128);

impl Entry {
    /// Times on the engine's clock are not negative: their bits are ordered as they are.
    #[inline(always)]
    fn new(time: f64, event: EventCode, disc: u32) -> Self {
        Self(u128::from(time.to_bits()) << 64 | u128::from(event.bits()) << 32 | u128::from(disc))
    }

    #[inline(always)]
    fn time(self) -> f64 {
        f64::from_bits((self.0 >> 64) as u64)
    }

    #[inline(always)]
    fn event(self) -> EventCode {
        EventCode::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn disc(self) -> u32 {
        self.0 as u32
    }

    /// Whether this still is the event of its disc.
    #[inline(always)]
    fn is_current(self, discs: &[DiscRecord]) -> bool {
        let disc = &discs[self.disc() as usize];
        self == Self::new(disc.event_time, disc.event, self.disc())
    }
}

/// The entries that come next on the open page.
pub(super) struct Ahead<'a>(&'a [Entry]);

impl Ahead<'_> {
    /// The disc and the event of the one that comes after so many others.
    #[inline(always)]
    pub(super) fn after(&self, others: usize) -> Option<(u32, EventCode)> {
        self.0.get(others).map(|entry| (entry.disc(), entry.event()))
    }
}

/// Some entries of one page.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Sheet([Entry; ENTRIES_OF_SHEET]);

/// Where a page ends: its entries fill a list of sheets.
#[derive(Clone, Copy, Debug)]
struct Page {
    /// The sheet that is being filled, or [`NONE`]; those behind it are full.
    sheet: u32,
    /// Entries on it.
    filled: u32,
}

const BLANK: Page = Page { sheet: NONE, filled: 0 };

/// All events that are to come, one a disc.
#[derive(Clone, Debug)]
pub(super) struct EventQueue {
    /// The open page, sorted; those before `turned` are done.
    today: Vec<Entry>,
    turned: usize,
    /// Number of the open page since the clock's zero.
    page: u64,
    /// Pages for each unit of time.
    pages_per_time: f64,
    /// The pages that follow, in a ring whose length is a power of two. What filing reads is all here, in few cache lines:
    /// nobody waits for the line of the sheet that is written.
    pages: Vec<Page>,
    /// Entries on them.
    on_pages: usize,
    sheets: Vec<Sheet>,
    /// The sheet behind each one.
    behind: Vec<u32>,
    /// Sheets that are free, in a list.
    free: u32,
    /// What comes after the last page of the ring.
    later: Vec<Entry>,
}

impl EventQueue {
    /// A calendar of the discs' events. `wait` is about how long a disc waits for its event.
    pub(super) fn new(discs: &[DiscRecord], wait: f64) -> Self {
        let count = discs.len() as f64;
        let share = SHARE_ON_PAGE * count;
        let on_page = if share > LEAST_ON_PAGE { share } else { LEAST_ON_PAGE };
        let pages = (WAITS_AHEAD * count / on_page) as usize;
        let mut event_queue = Self {
            today: Vec::new(),
            turned: 0,
            page: 0,
            pages_per_time: 0.0,
            pages: vec![BLANK; pages.next_power_of_two()],
            on_pages: 0,
            sheets: with_large_pages(discs.len() / 4),
            behind: Vec::new(),
            free: NONE,
            later: Vec::new(),
        };
        event_queue.rebuild(discs, wait);
        event_queue
    }

    /// Files all events anew from a new zero of the clock, on pages that suit the present wait.
    pub(super) fn rebuild(&mut self, discs: &[DiscRecord], wait: f64) {
        let span = wait * WAITS_AHEAD / self.pages.len() as f64;
        let pages_per_time = 1.0 / span;
        self.pages_per_time = if pages_per_time.is_finite() { pages_per_time } else { 0.0 };
        self.today.clear();
        self.turned = 0;
        self.page = 0;
        self.pages.fill(BLANK);
        self.on_pages = 0;
        self.sheets.clear();
        self.behind.clear();
        self.free = NONE;
        self.later.clear();
        for (disc, record) in discs.iter().enumerate() {
            if record.event_time < NEVER {
                let entry = Entry::new(record.event_time, record.event, disc as u32);
                match self.place_of(entry) {
                    Place::Today => self.today.push(entry),
                    Place::Page(page) => self.put_onto(page, entry),
                    Place::Later => self.later.push(entry),
                }
            }
        }
        self.today.sort_unstable();
    }

    /// Files the event of a disc.
    #[inline(always)]
    pub(super) fn schedule(&mut self, disc: u32, time: f64, event: EventCode) {
        if time == NEVER {
            return;
        }
        let entry = Entry::new(time, event, disc);
        match self.place_of(entry) {
            Place::Today => {
                let place =
                    self.turned + self.today[self.turned..].partition_point(|other| *other < entry);
                self.today.insert(place, entry);
            }
            Place::Page(page) => self.put_onto(page, entry),
            Place::Later => self.later.push(entry),
        }
    }

    /// The disc whose event comes first; `None` if nothing ever happens. It stays first until it has another event.
    /// `passing` is called for each entry that is passed over, and looks at those that come after it.
    #[inline(always)]
    pub(super) fn first(
        &mut self,
        discs: &[DiscRecord],
        passing: impl Fn(Ahead<'_>),
    ) -> Option<u32> {
        loop {
            while let Some(&entry) = self.today.get(self.turned) {
                if entry.is_current(discs) {
                    return Some(entry.disc());
                }
                self.turned += 1;
                passing(Ahead(&self.today[self.turned..]));
            }
            if !self.turn_page(discs) {
                return None;
            }
        }
    }

    #[inline(always)]
    fn place_of(&self, entry: Entry) -> Place {
        let page = (entry.time() * self.pages_per_time) as u64;
        if page <= self.page {
            Place::Today
        } else if page - self.page < self.pages.len() as u64 {
            Place::Page(page as usize & (self.pages.len() - 1))
        } else {
            Place::Later
        }
    }

    #[inline(always)]
    fn put_onto(&mut self, page: usize, entry: Entry) {
        self.on_pages += 1;
        let Page { sheet, filled } = &mut self.pages[page];
        if let Some(Sheet(entries)) = self.sheets.get_mut(*sheet as usize)
            && let Some(line) = entries.get_mut(*filled as usize)
        {
            *line = entry;
            *filled += 1;
        } else {
            self.put_onto_new_sheet(page, entry);
        }
    }

    #[inline(never)]
    fn put_onto_new_sheet(&mut self, page: usize, entry: Entry) {
        if self.free == NONE {
            self.free = self.sheets.len() as u32;
            self.sheets.push(Sheet([entry; ENTRIES_OF_SHEET]));
            self.behind.push(NONE);
        }
        let sheet = self.free;
        let before = std::mem::replace(&mut self.pages[page], Page { sheet, filled: 1 });
        self.sheets[sheet as usize].0[0] = entry;
        self.free = std::mem::replace(&mut self.behind[sheet as usize], before.sheet);
    }

    /// Opens the next page that has entries; returns whether there is one.
    fn turn_page(&mut self, discs: &[DiscRecord]) -> bool {
        self.today.clear();
        self.turned = 0;
        let mask = self.pages.len() - 1;
        while self.on_pages > 0 {
            self.page = self.page.saturating_add(1);
            let place = self.page as usize & mask;
            if place == 0 && !self.later.is_empty() {
                self.file_later(discs);
            }
            if self.pages[place].sheet != NONE {
                self.open(place);
            }
            if !self.today.is_empty() {
                self.fetch_sheets((place + 1) & mask);
                return true;
            }
        }
        self.skip_to_later(discs)
    }

    /// Asks for the sheets of a page that will be opened.
    fn fetch_sheets(&self, place: usize) {
        let mut sheet = self.pages[place].sheet;
        while let Some(Sheet(entries)) = self.sheets.get(sheet as usize) {
            prefetch(entries, 0);
            prefetch(entries, ENTRIES_OF_SHEET / 2);
            sheet = self.behind[sheet as usize];
        }
    }

    fn open(&mut self, place: usize) {
        let filed = self.today.len();
        let Page { mut sheet, filled } = std::mem::replace(&mut self.pages[place], BLANK);
        let mut count = filled as usize;
        while sheet != NONE {
            self.today.extend_from_slice(&self.sheets[sheet as usize].0[..count]);
            count = ENTRIES_OF_SHEET;
            let following = std::mem::replace(&mut self.behind[sheet as usize], self.free);
            self.free = sheet;
            sheet = following;
        }
        self.on_pages -= self.today.len() - filed;
        self.today.sort_unstable();
    }

    /// Files what came after the last page, now that the ring has gone round.
    fn file_later(&mut self, discs: &[DiscRecord]) {
        let later = std::mem::take(&mut self.later);
        for entry in later {
            if entry.is_current(discs) {
                match self.place_of(entry) {
                    Place::Today => self.today.push(entry),
                    Place::Page(page) => self.put_onto(page, entry),
                    Place::Later => self.later.push(entry),
                }
            }
        }
        self.today.sort_unstable();
    }

    /// No page of the ring has entries: goes to the first page of what comes later.
    fn skip_to_later(&mut self, discs: &[DiscRecord]) -> bool {
        let Some(first) = self.later.iter().filter(|entry| entry.is_current(discs)).min() else {
            return false;
        };
        self.page = (first.time() * self.pages_per_time) as u64;
        self.file_later(discs);
        !self.today.is_empty()
    }
}

/// Where an event is filed.
enum Place {
    Today,
    Page(usize),
    Later,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Seed, Stream};

    fn at_rest() -> DiscRecord {
        DiscRecord {
            position: [0.0; 2],
            velocity: [0.0; 2],
            time: 0.0,
            event_time: NEVER,
            event: EventCode::NONE,
            partner_collisions: 0,
            collisions: 0,
            cell: [0; 2],
        }
    }

    /// Law: the first is the least by (time, kind, partner, disc) of all events, after any changes and moves of the clock.
    /// Reference: a scan of all events. Waits from 1e-3 to 1e3 mean ones; times are multiples of 1/64, so that many are equal.
    #[test]
    fn the_first_is_the_least_of_all() {
        for count in [1_usize, 5, 37, 3000] {
            let mut generator = Seed { seed: 3, replicate: 0 }.stream(Stream::Positions);
            let mut discs = vec![at_rest(); count];
            let mut event_queue = EventQueue::new(&discs, 1.0);
            let mut now = 0.0;
            for round in 0..20_000 {
                let disc = (generator.uniform() * count as f64) as usize;
                let disc = if round % 2 == 0 {
                    event_queue.first(&discs, |_| ()).map_or(disc, |first| first as usize)
                } else {
                    disc
                };
                if discs[disc].event_time < NEVER && round % 2 == 0 {
                    now = discs[disc].event_time;
                }
                let scale = [1e-3, 1.0, 1.0, 1.0, 30.0, 1e3][(generator.uniform() * 6.0) as usize];
                let wait = (scale * generator.uniform() * 64.0).floor() / 64.0;
                discs[disc].event_time = now + wait;
                discs[disc].event = EventCode::pair((generator.uniform() * 3.0) as u32);
                if generator.uniform() < 0.01 {
                    (discs[disc].event_time, discs[disc].event) = (NEVER, EventCode::NONE);
                }
                event_queue.schedule(disc as u32, discs[disc].event_time, discs[disc].event);
                if round % 1000 == 999 {
                    let shift = now.floor();
                    now -= shift;
                    for disc in discs.iter_mut().filter(|disc| disc.event_time < NEVER) {
                        disc.event_time -= shift;
                    }
                    event_queue.rebuild(&discs, 1.0);
                }
                let waiting =
                    (0..count as u32).filter(|&disc| discs[disc as usize].event_time < NEVER);
                let least = waiting.min_by_key(|&disc| {
                    let record = &discs[disc as usize];
                    Entry::new(record.event_time, record.event, disc)
                });
                assert_eq!(
                    event_queue.first(&discs, |_| ()),
                    least,
                    "{count} discs, round {round}"
                );
            }
        }
    }
}

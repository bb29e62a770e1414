//! The event queue: one event per disc, in buckets of equal spans of time.
//!
//! Events are appended to their bucket unsorted; a bucket is sorted when its time comes. Therefore, scheduling and taking
//! an event have a cost that does not depend on the number of events (Paul, J. Comput. Phys. 221 (2007) 615). No event is
//! removed early: an entry that is no longer the event of its disc is skipped (lazy invalidation).
//!
//! Invariant: the next event depends only on the discs' events, which are in a total order by time, kind, partner and disc.
//! The queue is not part of the state, and its buckets are chosen for speed only.

use super::disc::DiscRecord;
use super::events::{EventCode, NEVER};
use crate::memory::with_large_pages;
use crate::simd::prefetch::prefetch;

/// Events per chunk: two cache lines.
const CHUNK_SIZE: usize = 8;

/// The end of a list of chunks.
const NO_CHUNK: u32 = u32::MAX;

/// Intended number of events per bucket: at least this number, and this fraction of all events.
const MIN_PER_BUCKET: f64 = 8.0;
const FRACTION_PER_BUCKET: f64 = 1.0 / 500.0;

/// The buckets span this multiple of the mean time to a disc's event. Later events are in the overflow list, which is
/// scheduled again after the last bucket.
const SPAN_OVER_MEAN_TIME: f64 = 4.0;

/// An event of a disc: time, event code and disc in one number, whose order is the order of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct QueuedEvent(u128);

impl QueuedEvent {
    /// Times on the engine's clock are not negative; therefore, their bits have the order of the times.
    #[inline(always)]
    fn new(time: f64, event: EventCode, disc: u32) -> Self {
        Self(u128::from(time.to_bits()) << 64 | u128::from(event.0) << 32 | u128::from(disc))
    }

    #[inline(always)]
    fn time(self) -> f64 {
        f64::from_bits((self.0 >> 64) as u64)
    }

    #[inline(always)]
    fn event(self) -> EventCode {
        EventCode((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn disc(self) -> u32 {
        self.0 as u32
    }

    /// Whether this is still the event of its disc.
    #[inline(always)]
    fn is_valid(self, discs: &[DiscRecord]) -> bool {
        let disc = &discs[self.disc() as usize];
        self == Self::new(disc.event_time, disc.event, self.disc())
    }
}

/// The events that follow in the current bucket.
pub(super) struct UpcomingEvents<'a>(&'a [QueuedEvent]);

impl UpcomingEvents<'_> {
    /// The disc and the event after this number of other events.
    #[inline(always)]
    pub(super) fn get(&self, index: usize) -> Option<(u32, EventCode)> {
        self.0.get(index).map(|entry| (entry.disc(), entry.event()))
    }
}

/// Some events of one bucket.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Chunk([QueuedEvent; CHUNK_SIZE]);

/// The end of a bucket, whose events fill a linked list of chunks.
#[derive(Clone, Copy, Debug)]
struct Bucket {
    /// The chunk that is being filled, or [`NO_CHUNK`]; those that follow in the list are full.
    chunk: u32,
    /// Number of events in it.
    filled: u32,
}

const EMPTY_BUCKET: Bucket = Bucket { chunk: NO_CHUNK, filled: 0 };

/// The next events of all discs.
#[derive(Clone, Debug)]
pub(super) struct EventQueue {
    /// The events of the current bucket, sorted; those before `next` are done.
    current: Vec<QueuedEvent>,
    next: usize,
    /// Number of the current bucket since the clock's origin.
    bucket: u64,
    /// Buckets per unit of time.
    buckets_per_time: f64,
    /// The buckets that follow, in a ring whose length is a power of two. Scheduling reads only these few cache lines and
    /// does not wait for the line of the chunk to which it writes.
    buckets: Vec<Bucket>,
    /// Number of events in them.
    in_buckets: usize,
    chunks: Vec<Chunk>,
    /// The next chunk in the list of each chunk.
    next_chunk: Vec<u32>,
    /// Head of the list of free chunks.
    free: u32,
    /// Events after the last bucket of the ring.
    overflow: Vec<QueuedEvent>,
}

impl EventQueue {
    /// A queue of the discs' events. `mean_time` is the mean time until a disc's event.
    pub(super) fn new(discs: &[DiscRecord], mean_time: f64) -> Self {
        let count = discs.len() as f64;
        let fraction = FRACTION_PER_BUCKET * count;
        let per_bucket = if fraction > MIN_PER_BUCKET { fraction } else { MIN_PER_BUCKET };
        let buckets = (SPAN_OVER_MEAN_TIME * count / per_bucket) as usize;
        let mut queue = Self {
            current: Vec::new(),
            next: 0,
            bucket: 0,
            buckets_per_time: 0.0,
            buckets: vec![EMPTY_BUCKET; buckets.next_power_of_two()],
            in_buckets: 0,
            chunks: with_large_pages(discs.len() / 4),
            next_chunk: Vec::new(),
            free: NO_CHUNK,
            overflow: Vec::new(),
        };
        queue.rebuild(discs, mean_time);
        queue
    }

    /// Schedules all events again after a shift of the clock's origin, in buckets that suit the present mean time.
    pub(super) fn rebuild(&mut self, discs: &[DiscRecord], mean_time: f64) {
        let span = mean_time * SPAN_OVER_MEAN_TIME / self.buckets.len() as f64;
        let buckets_per_time = 1.0 / span;
        self.buckets_per_time = if buckets_per_time.is_finite() { buckets_per_time } else { 0.0 };
        self.current.clear();
        self.next = 0;
        self.bucket = 0;
        self.buckets.fill(EMPTY_BUCKET);
        self.in_buckets = 0;
        self.chunks.clear();
        self.next_chunk.clear();
        self.free = NO_CHUNK;
        self.overflow.clear();
        for (disc, record) in discs.iter().enumerate() {
            if record.event_time < NEVER {
                let entry = QueuedEvent::new(record.event_time, record.event, disc as u32);
                self.append(entry);
            }
        }
        self.current.sort_unstable();
    }

    /// Schedules the event of a disc.
    #[inline(always)]
    pub(super) fn schedule(&mut self, disc: u32, time: f64, event: EventCode) {
        if time == NEVER {
            return;
        }
        let entry = QueuedEvent::new(time, event, disc);
        match self.span_of(entry) {
            Span::Current => {
                let following = &self.current[self.next..];
                let index = self.next + following.partition_point(|other| *other < entry);
                self.current.insert(index, entry);
            }
            Span::Bucket(bucket) => self.append_to_bucket(bucket, entry),
            Span::Overflow => self.overflow.push(entry),
        }
    }

    /// The disc whose event is the earliest; `None` if there is no event. It stays the first until it has another event.
    /// `on_skip` is called for each invalid entry that is skipped, with the events that follow.
    #[inline(always)]
    pub(super) fn first(
        &mut self,
        discs: &[DiscRecord],
        on_skip: impl Fn(UpcomingEvents<'_>),
    ) -> Option<u32> {
        loop {
            while let Some(&entry) = self.current.get(self.next) {
                if entry.is_valid(discs) {
                    return Some(entry.disc());
                }
                self.next += 1;
                on_skip(UpcomingEvents(&self.current[self.next..]));
            }
            if !self.open_next_bucket(discs) {
                return None;
            }
        }
    }

    #[inline(always)]
    fn span_of(&self, entry: QueuedEvent) -> Span {
        let bucket = (entry.time() * self.buckets_per_time) as u64;
        if bucket <= self.bucket {
            Span::Current
        } else if bucket - self.bucket < self.buckets.len() as u64 {
            Span::Bucket(bucket as usize & (self.buckets.len() - 1))
        } else {
            Span::Overflow
        }
    }

    /// Appends an event to its bucket; the current one must be sorted afterward.
    fn append(&mut self, entry: QueuedEvent) {
        match self.span_of(entry) {
            Span::Current => self.current.push(entry),
            Span::Bucket(bucket) => self.append_to_bucket(bucket, entry),
            Span::Overflow => self.overflow.push(entry),
        }
    }

    #[inline(always)]
    fn append_to_bucket(&mut self, bucket: usize, entry: QueuedEvent) {
        self.in_buckets += 1;
        let Bucket { chunk, filled } = &mut self.buckets[bucket];
        if let Some(Chunk(entries)) = self.chunks.get_mut(*chunk as usize)
            && let Some(free) = entries.get_mut(*filled as usize)
        {
            *free = entry;
            *filled += 1;
        } else {
            self.append_new_chunk(bucket, entry);
        }
    }

    #[inline(never)]
    fn append_new_chunk(&mut self, bucket: usize, entry: QueuedEvent) {
        if self.free == NO_CHUNK {
            self.free = self.chunks.len() as u32;
            self.chunks.push(Chunk([entry; CHUNK_SIZE]));
            self.next_chunk.push(NO_CHUNK);
        }
        let chunk = self.free;
        let before = std::mem::replace(&mut self.buckets[bucket], Bucket { chunk, filled: 1 });
        self.chunks[chunk as usize].0[0] = entry;
        self.free = std::mem::replace(&mut self.next_chunk[chunk as usize], before.chunk);
    }

    /// Opens the next bucket that has events; returns whether there is one.
    fn open_next_bucket(&mut self, discs: &[DiscRecord]) -> bool {
        self.current.clear();
        self.next = 0;
        let mask = self.buckets.len() - 1;
        while self.in_buckets > 0 {
            self.bucket = self.bucket.saturating_add(1);
            let index = self.bucket as usize & mask;
            if index == 0 && !self.overflow.is_empty() {
                self.schedule_overflow(discs);
            }
            if self.buckets[index].chunk != NO_CHUNK {
                self.open(index);
            }
            if !self.current.is_empty() {
                self.prefetch_bucket((index + 1) & mask);
                return true;
            }
        }
        self.skip_to_overflow(discs)
    }

    /// Prefetches the chunks of a bucket that will be opened.
    fn prefetch_bucket(&self, bucket: usize) {
        let mut chunk = self.buckets[bucket].chunk;
        while let Some(Chunk(entries)) = self.chunks.get(chunk as usize) {
            prefetch(entries, 0);
            prefetch(entries, CHUNK_SIZE / 2);
            chunk = self.next_chunk[chunk as usize];
        }
    }

    /// Moves the events of a bucket to the current ones and sorts them.
    fn open(&mut self, bucket: usize) {
        let before = self.current.len();
        let Bucket { mut chunk, filled } =
            std::mem::replace(&mut self.buckets[bucket], EMPTY_BUCKET);
        let mut count = filled as usize;
        while chunk != NO_CHUNK {
            self.current.extend_from_slice(&self.chunks[chunk as usize].0[..count]);
            count = CHUNK_SIZE;
            let following = std::mem::replace(&mut self.next_chunk[chunk as usize], self.free);
            self.free = chunk;
            chunk = following;
        }
        self.in_buckets -= self.current.len() - before;
        self.current.sort_unstable();
    }

    /// Schedules the overflow list again, after one turn of the ring.
    fn schedule_overflow(&mut self, discs: &[DiscRecord]) {
        let overflow = std::mem::take(&mut self.overflow);
        for entry in overflow {
            if entry.is_valid(discs) {
                self.append(entry);
            }
        }
        self.current.sort_unstable();
    }

    /// All buckets are empty: skips to the bucket of the first event of the overflow list.
    fn skip_to_overflow(&mut self, discs: &[DiscRecord]) -> bool {
        let Some(first) = self.overflow.iter().filter(|entry| entry.is_valid(discs)).min() else {
            return false;
        };
        self.bucket = (first.time() * self.buckets_per_time) as u64;
        self.schedule_overflow(discs);
        !self.current.is_empty()
    }
}

/// The part of the queue to which an event belongs.
enum Span {
    Current,
    Bucket(usize),
    Overflow,
}

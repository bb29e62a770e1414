//! Which disc comes next. The rest of the engine knows only `schedule`, `soonest` and `shift`, so that another queue
//! can take this one's place.

use super::events::{Event, NEVER};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// One event a disc, in a binary heap that knows where each disc stands. Events are in a total order
/// (time, kind, partner, disc): what comes next depends on the events alone and not on how the heap came about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct EventQueue {
    /// The event of each disc.
    events: Vec<Event>,
    /// The heap. The time stands here too: most comparisons need nothing else.
    heap: Vec<Entry>,
    /// Where in the heap each disc stands.
    places: Vec<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Entry {
    time: f64,
    disc: u32,
}

impl EventQueue {
    /// A queue of the given number of discs, at least one, to none of which anything happens.
    pub(super) fn new(discs: u32) -> Self {
        Self {
            events: vec![Event::NOTHING; discs as usize],
            heap: (0..discs).map(|disc| Entry { time: NEVER, disc }).collect(),
            places: (0..discs).collect(),
        }
    }

    /// Replaces the event of a disc. Cost: O(log n).
    pub(super) fn schedule(&mut self, disc: u32, event: Event) {
        self.events[disc as usize] = event;
        let place = self.places[disc as usize] as usize;
        self.heap[place].time = event.time;
        let place = self.rise(place);
        self.sink(place);
    }

    /// The disc whose event comes first, and that event; the event stays until it is replaced.
    pub(super) fn soonest(&self) -> (u32, Event) {
        let disc = self.heap[0].disc;
        (disc, self.events[disc as usize])
    }

    /// Moves the zero of the clock later by `duration`. Different times stay different and in order: no time lies before
    /// the new zero, so a difference has at least as fine a grain as the time had.
    pub(super) fn shift(&mut self, duration: f64) {
        for event in &mut self.events {
            if event.time < NEVER {
                event.time -= duration;
            }
        }
        for entry in &mut self.heap {
            entry.time = self.events[entry.disc as usize].time;
        }
    }

    fn precedes(&self, first: Entry, second: Entry) -> bool {
        match first.time.total_cmp(&second.time) {
            Ordering::Less => true,
            Ordering::Greater => false,
            Ordering::Equal => {
                let [one, other] = [first, second].map(|entry| &self.events[entry.disc as usize]);
                one.order(other).then(first.disc.cmp(&second.disc)) == Ordering::Less
            }
        }
    }

    fn set(&mut self, place: usize, entry: Entry) {
        self.heap[place] = entry;
        self.places[entry.disc as usize] = place as u32;
    }

    fn rise(&mut self, mut place: usize) -> usize {
        let entry = self.heap[place];
        while place > 0 {
            let parent = (place - 1) / 2;
            if !self.precedes(entry, self.heap[parent]) {
                break;
            }
            self.set(place, self.heap[parent]);
            place = parent;
        }
        self.set(place, entry);
        place
    }

    fn sink(&mut self, mut place: usize) {
        let entry = self.heap[place];
        loop {
            let mut child = 2 * place + 1;
            if child >= self.heap.len() {
                break;
            }
            let sibling = child + 1;
            if sibling < self.heap.len() && self.precedes(self.heap[sibling], self.heap[child]) {
                child = sibling;
            }
            if !self.precedes(self.heap[child], entry) {
                break;
            }
            self.set(place, self.heap[child]);
            place = child;
        }
        self.set(place, entry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::packing::events::{EventKind, Side};

    /// Law: the queue's first is the least by (time, kind, partner, disc) of all events, after any changes and shifts.
    /// Reference: a scan of all events. Times are multiples of 1/4 below 4, so that many are equal.
    #[test]
    fn soonest_is_the_least_of_all() {
        let kinds = [
            EventKind::Pair { partner: 3, partner_collisions: 0 },
            EventKind::Pair { partner: 1, partner_collisions: 9 },
            EventKind::Wall(Side::Right),
            EventKind::Crossing(Side::Bottom),
        ];
        let mut queue = EventQueue::new(37);
        let mut number = 12_345_u32;
        for round in 0..5000 {
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let disc = (number >> 8) % 37;
            let time = 1.0 + f64::from((number >> 16) % 16) / 4.0;
            let event = Event { time, kind: kinds[(number >> 24) as usize % 4] };
            queue.schedule(disc, event);
            if round % 1000 == 500 {
                queue.shift(0.75);
            }
            let least = (0..37_u32)
                .min_by(|&one, &other| {
                    let [first, second] = [one, other].map(|disc| queue.events[disc as usize]);
                    first.order(&second).then(one.cmp(&other))
                })
                .unwrap();
            assert_eq!(queue.soonest(), (least, queue.events[least as usize]));
        }
    }
}

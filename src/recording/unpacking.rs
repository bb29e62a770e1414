//! Parallel decompression of chunks: threads take chunks in order of arrival, and each result is collected by its ticket.

use crate::container::{Broken, Unpacked, Unpacker, is_packed};
use std::io;
use std::num::NonZeroUsize;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};

/// A chunk's content, and the checksum of its record's body as it stands in the file.
type Outcome = Result<(Unpacked, crc32fast::Hasher), Broken>;

/// A chunk on its way to a thread.
struct Job {
    body: Vec<u8>,
    outcome: SyncSender<Outcome>,
}

/// A chunk that was handed in.
pub(crate) enum Ticket {
    /// To be unpacked by the thread that asks for it.
    InPlace(Vec<u8>),
    /// A thread has it.
    OnThread(Receiver<Outcome>),
}

/// The threads. They end, and are waited for, when this value is dropped.
pub(crate) struct Unpackers {
    limit: NonZeroUsize,
    /// For what is unpacked in place.
    own: Unpacker,
    threads: Vec<JoinHandle<()>>,
    // Empty only while being dropped: its end is what ends the threads.
    jobs: Option<Sender<Job>>,
    queue: Arc<Mutex<Receiver<Job>>>,
}

impl Unpackers {
    /// Up to `limit` threads; with 1, none: the thread that takes a ticket does the work.
    pub(crate) fn new(limit: NonZeroUsize) -> Self {
        let (jobs, queue) = channel();
        let queue = Arc::new(Mutex::new(queue));
        Self { limit, own: Unpacker::new(), threads: Vec::new(), jobs: Some(jobs), queue }
    }

    /// Chunks that should be handed in and not taken yet: one under way and one next for each thread.
    pub(crate) fn look_ahead(&self) -> usize {
        if self.threads.is_empty() { 1 } else { 2 * self.limit.get() }
    }

    /// Hands in the body of a chunk's record. A thread is started for it as long as there are fewer than the limit, so that
    /// a short file starts few. A chunk that is stored as it is stays here: its checksum takes less time than its way to
    /// another core and back.
    pub(crate) fn hand_in(&mut self, body: Vec<u8>) -> Ticket {
        if self.limit == NonZeroUsize::MIN || !is_packed(&body) {
            return Ticket::InPlace(body);
        }
        if self.threads.len() < self.limit.get() {
            let queue = Arc::clone(&self.queue);
            let started = Builder::new().name("unpack".to_owned()).spawn(move || work(&queue));
            // A machine that gives no thread is served by those that there are.
            self.threads.extend(started);
        }
        let Some(jobs) = self.jobs.as_ref().filter(|_| !self.threads.is_empty()) else {
            return Ticket::InPlace(body);
        };
        let (outcome, ticket) = sync_channel(1);
        match jobs.send(Job { body, outcome }) {
            Ok(()) => Ticket::OnThread(ticket),
            Err(unsent) => Ticket::InPlace(unsent.0.body),
        }
    }

    /// The chunk of a ticket, waited for.
    pub(crate) fn take(&mut self, ticket: Ticket) -> Outcome {
        match ticket {
            Ticket::InPlace(body) => unpack(&mut self.own, body),
            Ticket::OnThread(outcome) => outcome.recv().unwrap_or_else(|_| {
                Err(Broken::Io(io::Error::other("a thread that unpacks chunks has stopped")))
            }),
        }
    }
}

impl Drop for Unpackers {
    fn drop(&mut self) {
        self.jobs = None;
        for thread in self.threads.drain(..) {
            // A panic of the thread was reported by it, and met by its ticket.
            drop(thread.join());
        }
    }
}

/// One thread: chunk after chunk, until no more can come.
fn work(queue: &Mutex<Receiver<Job>>) {
    let mut unpacker = Unpacker::new();
    loop {
        let job = queue.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok(Job { body, outcome }) = job else { return };
        // Nobody waits any more where the reader was dropped.
        drop(outcome.send(unpack(&mut unpacker, body)));
    }
}

fn unpack(unpacker: &mut Unpacker, body: Vec<u8>) -> Outcome {
    let mut checksum = crc32fast::Hasher::new();
    checksum.update(&body);
    Ok((unpacker.unpack(body)?, checksum))
}

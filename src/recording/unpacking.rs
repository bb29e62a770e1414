//! Parallel decompression of chunks: threads take chunks in order of arrival, and each result is collected by its ticket.

use crate::container::{Broken, Unpacked, Unpacker, is_packed};
use crate::limits::ChunkLimits;
use crate::spare_memory::SpareMemory;
use std::io;
use std::num::NonZeroUsize;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};

/// The content of a chunk, and the checksum of its record's body in the file.
type Outcome = Result<(Unpacked, crc32fast::Hasher), Broken>;

/// A chunk queued for a thread.
struct Job {
    body: Vec<u8>,
    outcome: SyncSender<Outcome>,
}

/// A chunk that was submitted.
pub(crate) enum Ticket {
    /// Decompressed by the thread that takes the ticket.
    InPlace(Vec<u8>),
    /// Decompressed by another thread.
    OnThread(Receiver<Outcome>),
}

/// The threads that decompress chunks. When this value is dropped, it joins them.
pub(crate) struct Unpackers {
    limit: NonZeroUsize,
    chunks: ChunkLimits,
    /// Decompresses in place.
    own: Unpacker,
    /// Memory of contents that were dropped.
    spare: SpareMemory<u8>,
    threads: Vec<JoinHandle<()>>,
    // Empty only while being dropped: the threads end when the channel is closed.
    jobs: Option<Sender<Job>>,
    queue: Arc<Mutex<Receiver<Job>>>,
}

impl Unpackers {
    /// Starts up to `limit` threads; with 1, none, and the thread that takes a ticket decompresses.
    pub(crate) fn new(limit: NonZeroUsize, chunks: ChunkLimits) -> Self {
        let (jobs, queue) = channel();
        let (queue, spare) = (Arc::new(Mutex::new(queue)), SpareMemory::new());
        let own = Unpacker::new(spare.clone());
        Self { limit, chunks, own, spare, threads: Vec::new(), jobs: Some(jobs), queue }
    }

    /// Maximum number of chunks to submit ahead: for each thread, one in progress and one queued.
    pub(crate) fn look_ahead(&self) -> usize {
        if self.threads.is_empty() { 1 } else { 2 * self.limit.get() }
    }

    /// Submits the body of a chunk's record. A thread is started for it below the limit, so that a short file starts few
    /// threads. An uncompressed chunk is not passed to a thread, because that takes longer than its checksum.
    pub(crate) fn submit(&mut self, body: Vec<u8>) -> Ticket {
        if self.limit == NonZeroUsize::MIN || !is_packed(&body) {
            return Ticket::InPlace(body);
        }
        if self.threads.len() < self.limit.get() {
            let (queue, chunks) = (Arc::clone(&self.queue), self.chunks);
            let unpacker = Unpacker::new(self.spare.clone());
            let name = "unpack".to_owned();
            let started = Builder::new().name(name).spawn(move || work(&queue, unpacker, chunks));
            // If no thread can be started, the existing ones are used.
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

    /// Waits for the chunk of a ticket and returns it.
    pub(crate) fn take(&mut self, ticket: Ticket) -> Outcome {
        match ticket {
            Ticket::InPlace(body) => unpack(&mut self.own, body, self.chunks),
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
            // A panic of the thread has been reported, and its ticket is an error.
            drop(thread.join());
        }
    }
}

/// Decompresses chunks until the channel is closed.
fn work(queue: &Mutex<Receiver<Job>>, mut unpacker: Unpacker, chunks: ChunkLimits) {
    loop {
        let job = queue.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok(Job { body, outcome }) = job else { return };
        // An error means that the reader was dropped.
        drop(outcome.send(unpack(&mut unpacker, body, chunks)));
    }
}

fn unpack(unpacker: &mut Unpacker, body: Vec<u8>, chunks: ChunkLimits) -> Outcome {
    let mut checksum = crc32fast::Hasher::new();
    checksum.update(&body);
    Ok((unpacker.unpack(body, chunks)?, checksum))
}

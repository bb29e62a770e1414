//! Compression of chunks on whichever thread is free, in a bounded pipeline. Chunks leave it in the order in which they entered;
//! therefore, the bytes of a file do not depend on the threads.

use crate::header::Compression;
use crate::open_chunk::ClosedChunk;
use crate::payload::Payload;
use crate::record_bytes::PutFields as _;
use crate::record_kind as kind;
use std::collections::VecDeque;
use std::io;
#[cfg(not(target_os = "unknown"))]
use std::io::Write as _;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// Time from the start of a recording until threads are started for it. Frames before are written on the caller's thread: where thousands of
/// tiny runs occupy all processors, a thread for each of them takes more time than it saves.
pub(crate) const WITHOUT_THREAD: Duration = Duration::from_millis(10);
/// Size of the contents in the pipeline above which a chunk leaves it before another one enters.
const MAX_BYTES: usize = 8 << 20;
/// Size of a chunk below which no thread is started for it: its compression takes less time than the start of a thread.
const THREAD_BYTES: usize = 128 << 10;

/// Bytes of a large message that are compressed before their place is used.
#[cfg(not(target_os = "unknown"))]
const PIECE_BYTES: usize = 256 << 10;

/// The record of a compressed chunk.
pub(crate) struct PackedChunk {
    /// Its bytes before the compressed content.
    pub(crate) head: Vec<u8>,
    /// The compressed content; `None` if the content is not compressed.
    pub(crate) body: Option<Vec<u8>>,
    /// Size of the start of the compressed content, which is in the memory of the message.
    pub(crate) in_place: usize,
    /// Checksum of all.
    pub(crate) checksum: crc32fast::Hasher,
    /// Name of the compression.
    pub(crate) compression: &'static str,
    /// Size of the content.
    pub(crate) content_bytes: usize,
}

type Outcome = io::Result<PackedChunk>;

/// A chunk whose compression has not begun.
struct Job {
    chunk: ClosedChunk,
    outcome: SyncSender<Outcome>,
}

/// The chunks that wait for a thread.
#[derive(Default)]
struct Queue {
    jobs: VecDeque<Job>,
    is_closed: bool,
}

#[derive(Default)]
struct SharedQueue {
    queue: Mutex<Queue>,
    changed: Condvar,
}

impl SharedQueue {
    fn change<T>(&self, change: impl FnOnce(&mut Queue) -> T) -> T {
        let changed = change(&mut self.queue.lock().unwrap_or_else(PoisonError::into_inner));
        self.changed.notify_one();
        changed
    }

    /// Waits for a chunk; `None` once the queue is closed.
    fn next(&self) -> Option<Job> {
        let mut queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(job) = queue.jobs.pop_front() {
                return Some(job);
            }
            if queue.is_closed {
                return None;
            }
            queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// The pipeline, with one thread in addition to the one that writes the chunks.
pub(crate) struct Packing {
    own: Packer,
    shared: Arc<SharedQueue>,
    thread: Option<JoinHandle<()>>,
    /// When the first chunk came.
    started: Option<Instant>,
    /// The chunks in the pipeline, in order.
    under_way: VecDeque<(ClosedChunk, Receiver<Outcome>)>,
    bytes: usize,
}

impl Packing {
    pub(crate) fn new(compression: Compression) -> Self {
        Self {
            own: Packer::new(compression),
            shared: Arc::default(),
            thread: None,
            started: None,
            under_way: VecDeque::new(),
            bytes: 0,
        }
    }

    /// Adds a chunk. It may leave the pipeline at once.
    pub(crate) fn push(&mut self, chunk: ClosedChunk) {
        self.bytes += chunk.content.len();
        let (outcome, ticket) = sync_channel(1);
        if !self.has_thread_for(&chunk) {
            // The receiver exists, and has room for one value.
            let _ = outcome.send(self.own.pack_chunk(&chunk));
        } else {
            let job = Job { chunk: chunk.clone(), outcome };
            self.shared.change(|queue| queue.jobs.push_back(job));
        }
        self.under_way.push_back((chunk, ticket));
    }

    /// Compresses a chunk of one large message here and now: what is before its payload and the payload are not copied into one.
    pub(crate) fn pack_now(
        &mut self,
        times: [u64; 2],
        before: &[u8],
        payload: &mut Payload<'_>,
    ) -> Outcome {
        let level = match self.own.compression {
            Compression::Zstd => 1,
            Compression::Zstd3 => 3,
            Compression::Lz4 | Compression::None => {
                return self.own.pack(times, &[before, payload], 1);
            }
        };
        #[cfg(not(target_os = "unknown"))]
        if let Payload::Used(payload) = payload {
            return pack_in_place(times, before, payload, level);
        }
        self.own.pack(times, &[before, payload], level)
    }

    /// The first chunk, if it is compressed or the pipeline is full; with `all`, until the pipeline is empty.
    pub(crate) fn pop(&mut self, all: bool) -> io::Result<Option<(ClosedChunk, PackedChunk)>> {
        let Some((chunk, ticket)) = self.under_way.pop_front() else { return Ok(None) };
        let packed = match ticket.try_recv() {
            Ok(packed) => packed?,
            Err(_) if !all && self.bytes <= MAX_BYTES => {
                self.under_way.push_front((chunk, ticket));
                return Ok(None);
            }
            Err(_) => self.wait_for(&ticket)?,
        };
        self.bytes -= chunk.content.len();
        Ok(Some((chunk, packed)))
    }

    /// Compresses the chunks that wait while the thread compresses another one.
    fn wait_for(&mut self, ticket: &Receiver<Outcome>) -> Outcome {
        loop {
            if let Ok(packed) = ticket.try_recv() {
                return packed;
            }
            let Some(job) = self.shared.change(|queue| queue.jobs.pop_front()) else {
                let stopped = |_| Err(io::Error::other("a thread that packs chunks has stopped"));
                return ticket.recv().unwrap_or_else(stopped);
            };
            let _ = job.outcome.send(self.own.pack_chunk(&job.chunk));
        }
    }

    /// Whether the thread compresses a chunk. It is started with the first large one that comes
    /// [`WITHOUT_THREAD`] after the first one.
    fn has_thread_for(&mut self, chunk: &ClosedChunk) -> bool {
        if self.own.compression == Compression::None || cfg!(target_family = "wasm") {
            return false;
        }
        let started = *self.started.get_or_insert_with(Instant::now);
        let is_due = || started.elapsed() >= WITHOUT_THREAD;
        if self.thread.is_none() && chunk.content.len() >= THREAD_BYTES && is_due() {
            let shared = Arc::clone(&self.shared);
            let mut packer = Packer::new(self.own.compression);
            let work = move || {
                while let Some(job) = shared.next() {
                    // An error means that the recorder was dropped.
                    let _ = job.outcome.send(packer.pack_chunk(&job.chunk));
                }
            };
            // Without the thread, chunks are compressed here.
            self.thread = Builder::new().name("pack".to_owned()).spawn(work).ok();
        }
        self.thread.is_some()
    }
}

impl Drop for Packing {
    fn drop(&mut self) {
        self.shared.change(|queue| {
            queue.is_closed = true;
            queue.jobs.clear();
        });
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been reported.
            drop(thread.join());
        }
    }
}

/// Compresses chunks one after the other.
struct Packer {
    compression: Compression,
    /// From the first compressed chunk on: its tables are reused.
    #[cfg(not(target_os = "unknown"))]
    zstd: Option<zstd::bulk::Compressor<'static>>,
    /// Memory for the largest compressed content. A copy takes what it needs, so that few chunks that wait reserve so much.
    #[cfg(not(target_os = "unknown"))]
    room: Vec<u8>,
}

impl Packer {
    fn new(compression: Compression) -> Self {
        Self {
            compression,
            #[cfg(not(target_os = "unknown"))]
            zstd: None,
            #[cfg(not(target_os = "unknown"))]
            room: Vec::new(),
        }
    }

    fn pack_chunk(&mut self, chunk: &ClosedChunk) -> Outcome {
        self.pack(chunk.times, &[&chunk.content], level_of(chunk))
    }

    /// Compresses the parts of a content, with `level` where zstd has no fixed one.
    fn pack(&mut self, [start, end]: [u64; 2], parts: &[&[u8]], level: i32) -> Outcome {
        let (name, body): (_, Option<Vec<u8>>) = match self.compression {
            #[cfg(not(target_os = "unknown"))]
            Compression::Zstd => ("zstd", Some(self.zstd(parts, level)?)),
            #[cfg(not(target_os = "unknown"))]
            Compression::Zstd3 => ("zstd", Some(self.zstd(parts, 3)?)),
            #[cfg(not(target_os = "unknown"))]
            Compression::Lz4 => ("lz4", Some(Self::lz4(parts)?)),
            Compression::None => ("", None),
            #[cfg(target_os = "unknown")]
            _ => {
                let what =
                    format!("no zstd of level {level} and no lz4 in this build of the program");
                return Err(io::Error::new(io::ErrorKind::Unsupported, what));
            }
        };
        let content = Content::of(parts);
        let packed_bytes = body.as_ref().map_or(content.bytes, |body| body.len());
        let (head, mut checksum) = content.head([start, end], name, packed_bytes);
        match &body {
            Some(body) => checksum.update(body),
            None => checksum.combine(&content.checksum),
        }
        Ok(PackedChunk {
            head,
            body,
            in_place: 0,
            checksum,
            compression: name,
            content_bytes: content.bytes,
        })
    }

    /// One part is compressed by one call, which is faster.
    #[cfg(not(target_os = "unknown"))]
    fn zstd(&mut self, parts: &[&[u8]], level: i32) -> io::Result<Vec<u8>> {
        let [content] = parts else {
            let mut encoder = zstd::Encoder::new(half_of(parts), level)?;
            parts.iter().try_for_each(|part| encoder.write_all(part))?;
            return encoder.finish();
        };
        self.room.clear();
        self.room.reserve(zstd::zstd_safe::compress_bound(content.len()));
        let zstd = self.zstd.get_or_insert_default();
        zstd.set_compression_level(level)?;
        zstd.compress_to_buffer(content, &mut self.room)?;
        Ok(self.room.clone())
    }

    #[cfg(not(target_os = "unknown"))]
    fn lz4(parts: &[&[u8]]) -> io::Result<Vec<u8>> {
        let mut encoder = lz4::EncoderBuilder::new()
            .level(1)
            // Some programs compute it wrongly; the chunk has a checksum of its own.
            .block_checksum(lz4::liblz4::BlockChecksum::NoBlockChecksum)
            .build(half_of(parts))?;
        parts.iter().try_for_each(|part| encoder.write_all(part))?;
        let (packed, ended) = encoder.finish();
        ended.map(|()| packed)
    }
}

/// Compresses a content whose end is the payload of a large message into the memory of that payload.
#[cfg(not(target_os = "unknown"))]
fn pack_in_place(times: [u64; 2], before: &[u8], payload: &mut [u8], level: i32) -> Outcome {
    let content = Content::of(&[before, payload]);
    let mut encoder = zstd::Encoder::new(Vec::with_capacity(2 * PIECE_BYTES), level)?;
    encoder.write_all(before)?;
    let mut in_place = 0;
    for start in (0..payload.len()).step_by(PIECE_BYTES) {
        let end = Ord::min(start + PIECE_BYTES, payload.len());
        encoder.write_all(&payload[start..end])?;
        // What cannot be compressed is larger than its own memory, so that the rest may have to wait.
        let packed = encoder.get_mut();
        let fits = Ord::min(packed.len(), end - in_place);
        payload[in_place..in_place + fits].copy_from_slice(&packed[..fits]);
        packed.drain(..fits);
        in_place += fits;
    }
    let rest = encoder.finish()?;
    let compression = "zstd";
    let (head, mut checksum) = content.head(times, compression, in_place + rest.len());
    checksum.update(&payload[..in_place]);
    checksum.update(&rest);
    Ok(PackedChunk {
        head,
        body: Some(rest),
        in_place,
        checksum,
        compression,
        content_bytes: content.bytes,
    })
}

/// What the head of a chunk states of its content.
struct Content {
    checksum: crc32fast::Hasher,
    bytes: usize,
}

impl Content {
    fn of(parts: &[&[u8]]) -> Self {
        let mut checksum = crc32fast::Hasher::new();
        parts.iter().for_each(|part| checksum.update(part));
        Self { checksum, bytes: parts.iter().map(|part| part.len()).sum() }
    }

    /// The record up to its compressed content of this size, and its checksum.
    fn head(
        &self,
        [start, end]: [u64; 2],
        compression: &str,
        packed_bytes: usize,
    ) -> (Vec<u8>, crc32fast::Hasher) {
        let mut head = Vec::new();
        head.put_record(kind::CHUNK, |head| {
            head.put_u64(start);
            head.put_u64(end);
            head.put_u64(self.bytes as u64);
            head.put_u32(self.checksum.clone().finalize());
            head.put_bytes(compression.as_bytes());
            head.put_u64(packed_bytes as u64);
        });
        // The length of the record includes the content behind the head.
        let length = (head.len() - 9 + packed_bytes) as u64;
        head[1..9].copy_from_slice(&length.to_le_bytes());
        let mut checksum = crc32fast::Hasher::new();
        checksum.update(&head);
        (head, checksum)
    }
}

/// Memory for half of the bytes of these parts, which grows if they are less compressible.
#[cfg(not(target_os = "unknown"))]
fn half_of(parts: &[&[u8]]) -> Vec<u8> {
    Vec::with_capacity(parts.iter().map(|part| part.len()).sum::<usize>() / 2)
}

/// The level of zstd for `compression = "zstd"`. At level 2, repetitions are found in a window of 1 MiB instead of 512 KiB, at the
/// same speed: the rows of the frame before are part of it, so that states of several frames take 0.43 to 0.96 of the space
/// (`cargo bench -p kinetoscope-recording --bench chunk_compression`). A single frame repeats nothing so far away.
fn level_of(chunk: &ClosedChunk) -> i32 {
    if chunk.frames > 1 { 2 } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::open_chunk::OpenChunk;

    /// Chunks of many sizes and compressibilities, below and above the size for which a thread is started.
    fn chunks() -> Vec<ClosedChunk> {
        let mut open = OpenChunk::new();
        let chunk = |index: usize| {
            for frame in 0..1 + index % 3 {
                let payload: Vec<u8> =
                    (0..(index * 7919) % 400_000).map(|i| (i * i / 97) as u8).collect();
                open.push(1, frame as u32, 40 * frame as u64, &payload);
            }
            open.close().unwrap()
        };
        (0..40).map(chunk).collect()
    }

    fn bytes((chunk, packed): (ClosedChunk, PackedChunk)) -> Vec<u8> {
        [&packed.head[..], packed.body.as_deref().unwrap_or(&chunk.content)].concat()
    }

    /// Guarantee: chunks leave the pipeline in order, with the bytes that each has alone, whenever they are taken.
    /// Control: another level gives other bytes.
    #[test]
    fn pipeline_gives_the_bytes_of_chunks_compressed_alone() {
        for compression in
            [Compression::Zstd, Compression::Zstd3, Compression::Lz4, Compression::None]
        {
            let alone = |chunk: ClosedChunk| {
                let packed = Packer::new(compression).pack_chunk(&chunk).unwrap();
                bytes((chunk, packed))
            };
            let expected: Vec<_> = chunks().into_iter().map(alone).collect();
            for taken_after in [1, 2, 5, 40] {
                let (mut packing, mut found) = (Packing::new(compression), Vec::new());
                for (index, chunk) in chunks().into_iter().enumerate() {
                    packing.push(chunk);
                    while index % taken_after == 0
                        && let Some(chunk) = packing.pop(false).unwrap()
                    {
                        found.push(bytes(chunk));
                    }
                }
                while let Some(chunk) = packing.pop(true).unwrap() {
                    found.push(bytes(chunk));
                }
                assert!(found == expected, "{compression:?}, taken after {taken_after}");
            }
        }
        let [one, other] = [Compression::Zstd, Compression::Zstd3]
            .map(|compression| Packer::new(compression).pack_chunk(&chunks()[39]).unwrap().head);
        assert_ne!(one, other);
    }

    /// Guarantee: a large message has the same chunk if it is compressed into its own memory, even where compression makes it larger.
    /// Control: another byte gives another chunk.
    #[test]
    fn chunk_of_a_large_message_is_the_same_in_its_own_memory() {
        let mut random = 1_u64;
        let mut noise = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (random >> 56) as u8
        };
        let incompressible: Vec<u8> = (0..3_000_000).map(|_| noise()).collect();
        let rows = (0..3_000_000_u32).map(|i| (i % 251 * (i / 4096)) as u8).collect();
        let chunk = |compression, payload: &mut Payload<'_>| {
            let before = b"schemas and channels";
            let packed = Packing::new(compression).pack_now([40; 2], before, payload).unwrap();
            let parts = match &packed.body {
                Some(rest) => [&packed.head[..], &payload[..packed.in_place], rest],
                None => [&packed.head[..], before, payload],
            };
            (parts.concat(), packed.checksum.finalize())
        };
        for payload in [incompressible, rows, Vec::new()] {
            for compression in
                [Compression::Zstd, Compression::Zstd3, Compression::Lz4, Compression::None]
            {
                let kept = chunk(compression, &mut Payload::Kept(&payload));
                let used = chunk(compression, &mut Payload::Used(&mut payload.clone()));
                assert!(kept == used, "{compression:?}, {} bytes", payload.len());
                assert_eq!(crc32fast::hash(&kept.0), kept.1);
                let mut other = payload.clone();
                other.push(7);
                assert!(kept != chunk(compression, &mut Payload::Used(&mut other)));
            }
        }
    }
}

//! The data section of a file: its records in order. Chunks are read ahead, so that threads can decompress them.

use crate::channels::STATE;
use crate::container::{Broken, Fields, MAGIC, Prefix, Records, claimed_bytes, damaged, metadata};
use crate::limits::{ChunkLimits, MAX_AHEAD_BYTES};
use crate::record_kind as kind;
use crate::storage::Input;
use crate::unpacking::{Ticket, Unpackers};
use prost::bytes::Bytes;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io::BufReader;
use std::num::NonZeroUsize;

/// A record with data of frames.
pub(crate) enum DataRecord {
    /// The records of a chunk, and the first channel in the indexes behind it.
    Chunk(Bytes, Option<u16>),
    /// A metadata record's name and entries.
    Metadata(String, BTreeMap<String, String>),
    /// The end of the file; all checksums are correct. The number of messages of each channel that has any or is that of the
    /// states, as the summary states it.
    End(BTreeMap<u16, u64>),
}

/// The start of a record: its position, the checksum of the bytes between the last chunk's body and it, and its prefix.
type RecordStart = (u64, Result<(crc32fast::Hasher, Prefix), Broken>);

/// A record that is read but not checked yet.
enum Ahead {
    Chunk {
        /// Checksum of the bytes between the last chunk's body and this one's.
        before: crc32fast::Hasher,
        ticket: Ticket,
        /// Its size and the size that it claims for its content.
        bytes: u64,
        /// The first channel in the indexes behind it.
        channel: Option<u16>,
    },
    Metadata(Vec<u8>),
    DataEnd {
        /// Checksum of the bytes between the last chunk's body and this record.
        before: crc32fast::Hasher,
        body: Vec<u8>,
    },
}

/// Reads a file from its first byte to its last. Records and errors do not depend on the number of threads, because records are
/// checked in order.
pub(crate) struct DataSection {
    records: Records<BufReader<Box<dyn Input>>>,
    chunks: ChunkLimits,
    unpackers: Unpackers,
    /// The records read ahead, each with its position; the last one may be an error or the end of the data.
    ahead: VecDeque<(u64, Result<Ahead, Broken>)>,
    /// Size of the chunks among them, with the sizes that they claim.
    ahead_bytes: u64,
    all_read: bool,
    /// The start of the next record, which was read with the last chunk.
    next: Option<RecordStart>,
    /// Channels whose chunks are not decompressed.
    left_out: BTreeSet<u16>,
    /// Memory of delivered chunks, for reuse.
    spare: Vec<Vec<u8>>,
    /// Checksum of the bytes before the current record.
    checksum: crc32fast::Hasher,
    /// Start of the current record.
    byte: u64,
}

impl DataSection {
    /// `records` is at the start of the file.
    pub(crate) fn new(
        records: Records<BufReader<Box<dyn Input>>>,
        threads: NonZeroUsize,
        chunks: ChunkLimits,
    ) -> Self {
        Self {
            records,
            chunks,
            unpackers: Unpackers::new(threads, chunks),
            ahead: VecDeque::new(),
            ahead_bytes: 0,
            all_read: false,
            next: None,
            left_out: BTreeSet::new(),
            spare: Vec::new(),
            checksum: crc32fast::Hasher::new(),
            byte: 0,
        }
    }

    /// Start of the current record.
    pub(crate) fn byte(&self) -> u64 {
        self.byte
    }

    /// Decompresses no chunk of these channels from now on. Its bytes are part of the checksum of the file all the same.
    pub(crate) fn leave_out(&mut self, channels: impl Iterator<Item = u16>) {
        self.left_out.extend(channels);
    }

    /// The next record.
    pub(crate) fn advance(&mut self) -> Result<DataRecord, Broken> {
        self.pass_over_left_out();
        let Some((byte, record)) = self.ahead.pop_front() else {
            return Ok(DataRecord::End(BTreeMap::new()));
        };
        self.byte = byte;
        match record? {
            Ahead::Chunk { before, ticket, bytes, channel } => {
                self.ahead_bytes -= bytes;
                let (chunk, checksum) = self.unpackers.take(ticket)?;
                self.checksum.combine(&before);
                self.checksum.combine(&checksum);
                self.spare.extend(chunk.spare);
                Ok(DataRecord::Chunk(chunk.content, channel))
            }
            Ahead::Metadata(body) => {
                let (name, entries) = metadata(&body)?;
                Ok(DataRecord::Metadata(name.to_owned(), entries))
            }
            Ahead::DataEnd { before, body } => {
                self.checksum.combine(&before);
                if Fields(&body).u32()? != self.checksum.clone().finalize() {
                    return Err(damaged(
                        "the bytes outside the chunks do not match their checksum",
                    ));
                }
                self.summary().map(DataRecord::End)
            }
        }
    }

    fn is_left_out(&self, channel: Option<u16>) -> bool {
        channel.is_some_and(|channel| self.left_out.contains(&channel))
    }

    /// Reads up to a record that is not a chunk to be left out.
    fn pass_over_left_out(&mut self) {
        loop {
            self.read_ahead();
            let Some((_, Ok(Ahead::Chunk { ticket, channel, .. }))) = self.ahead.front() else {
                return;
            };
            let Ticket::InPlace(body) = ticket else { return };
            if !self.is_left_out(*channel) {
                return;
            }
            let mut checksum = crc32fast::Hasher::new();
            checksum.update(body);
            let body = self.take_packed(&checksum);
            self.spare.extend(body);
        }
    }

    /// The next record if it is a chunk that was read but not decompressed, with the first channel in its indexes.
    pub(crate) fn packed_chunk(&mut self) -> Option<(&[u8], Option<u16>)> {
        self.read_ahead();
        match self.ahead.front() {
            Some((_, Ok(Ahead::Chunk { ticket: Ticket::InPlace(body), channel, .. }))) => {
                Some((body, *channel))
            }
            _ => None,
        }
    }

    /// Takes the chunk of [`DataSection::packed_chunk`], whose body has this checksum.
    pub(crate) fn take_packed(&mut self, checksum: &crc32fast::Hasher) -> Option<Vec<u8>> {
        let (byte, record) = self.ahead.pop_front()?;
        match record {
            Ok(Ahead::Chunk { before, ticket: Ticket::InPlace(body), bytes, .. }) => {
                self.byte = byte;
                self.ahead_bytes -= bytes;
                self.checksum.combine(&before);
                self.checksum.combine(checksum);
                Some(body)
            }
            record => {
                self.ahead.push_front((byte, record));
                None
            }
        }
    }

    /// Keeps memory for the next chunk.
    pub(crate) fn reuse(&mut self, body: Vec<u8>) {
        self.spare.push(body);
    }

    /// The records of a chunk that was taken.
    pub(crate) fn unpack(&mut self, body: Vec<u8>) -> Result<Bytes, Broken> {
        let (chunk, _) = self.unpackers.take(Ticket::InPlace(body))?;
        self.spare.extend(chunk.spare);
        Ok(chunk.content)
    }

    /// Reads ahead until enough chunks, or enough bytes, are being decompressed.
    fn read_ahead(&mut self) {
        self.submit_waiting();
        while !self.all_read
            && self.ahead.len() < self.unpackers.look_ahead()
            && self.ahead_bytes <= MAX_AHEAD_BYTES
        {
            let mut byte = self.records.position();
            let record = self.read(&mut byte);
            self.all_read = matches!(record, Err(_) | Ok(Ahead::DataEnd { .. }));
            self.ahead.push_back((byte, record));
        }
    }

    /// Reads up to the end of the next record with data of frames; sets `byte` to the start of the last record.
    fn read(&mut self, byte: &mut u64) -> Result<Ahead, Broken> {
        if self.records.position() == 0 {
            self.records.magic()?;
        }
        let mut body = self.spare.pop().unwrap_or_default();
        loop {
            let (start, found) = match self.next.take() {
                Some(next) => next,
                None => self.record_start(),
            };
            *byte = start;
            let (before, prefix) = found?;
            match prefix.kind {
                kind::CHUNK => {
                    let before = self.records.checksum();
                    self.records.body_without_checksum(prefix, &mut body)?;
                    self.records.restart_checksum();
                    let channel = self.indexed_channel();
                    return Ok(self.submit(before, body, channel));
                }
                kind::METADATA => {
                    self.records.body(prefix, &mut body)?;
                    return Ok(Ahead::Metadata(body));
                }
                kind::DATA_END => {
                    self.records.body(prefix, &mut body)?;
                    return Ok(Ahead::DataEnd { before, body });
                }
                kind::MESSAGE_INDEX => {
                    self.index_channel(prefix)?;
                }
                kind::HEADER | kind::ATTACHMENT => self.records.skip(prefix)?,
                // A chunk whose kind has changed must not be skipped.
                _ => {
                    return Err(damaged("a record is at a place where no recording has one"));
                }
            }
        }
    }

    fn record_start(&mut self) -> RecordStart {
        let (byte, before) = (self.records.position(), self.records.checksum());
        let prefix = self.records.prefix_or_chunk(self.chunks.body_bytes());
        (byte, prefix.map(|prefix| (before, prefix)))
    }

    /// The first channel in the indexes behind a chunk. What is wrong with the record there is reported when it is read.
    fn indexed_channel(&mut self) -> Option<u16> {
        let (byte, found) = self.record_start();
        match found {
            Ok((_, prefix)) if prefix.kind == kind::MESSAGE_INDEX => {
                let channel = self.index_channel(prefix);
                channel.map_err(|broken| self.next = Some((byte, Err(broken)))).ok()
            }
            found => {
                self.next = Some((byte, found));
                None
            }
        }
    }

    /// The channel of an index of messages, which is read to its end.
    fn index_channel(&mut self, prefix: Prefix) -> Result<u16, Broken> {
        let (channel, size) = (self.records.array()?, u32::from_le_bytes(self.records.array()?));
        if prefix.length != 6 + u64::from(size) {
            return Err(damaged("the size of an index does not match its record"));
        }
        self.records.skip(Prefix { length: size.into(), ..prefix })?;
        Ok(u16::from_le_bytes(channel))
    }

    /// Submits a chunk. If it exceeds the memory of the chunks ahead together with others, it waits, and no other is read.
    fn submit(&mut self, before: crc32fast::Hasher, body: Vec<u8>, channel: Option<u16>) -> Ahead {
        let bytes = claimed_bytes(&body).saturating_add(body.len() as u64);
        // A larger claim is rejected when it is decompressed; the sum of one and the others does not overflow.
        let bytes = bytes.min(u64::MAX / 2);
        let is_alone = self.ahead_bytes == 0;
        self.ahead_bytes += bytes;
        let has_memory = is_alone || self.ahead_bytes <= MAX_AHEAD_BYTES;
        let ticket = if has_memory && !self.is_left_out(channel) {
            self.unpackers.submit(body)
        } else {
            Ticket::InPlace(body)
        };
        Ahead::Chunk { before, ticket, bytes, channel }
    }

    /// Submits the chunk that waits, if the memory of the chunks ahead suffices now.
    fn submit_waiting(&mut self) {
        if self.ahead_bytes > MAX_AHEAD_BYTES {
            return;
        }
        if let Some((_, Ok(Ahead::Chunk { ticket, channel, .. }))) = self.ahead.back_mut()
            && !channel.is_some_and(|channel| self.left_out.contains(&channel))
            && let Ticket::InPlace(body) = ticket
        {
            *ticket = self.unpackers.submit(std::mem::take(body));
        }
    }

    /// Checks the summary after the data, which viewers use, and returns the number of messages of each channel.
    fn summary(&mut self) -> Result<BTreeMap<u16, u64>, Broken> {
        self.records.restart_checksum();
        let mut counts = BTreeMap::new();
        loop {
            self.byte = self.records.position();
            let prefix = self.records.prefix()?;
            if prefix.kind == kind::STATISTICS {
                let mut body = Vec::new();
                self.records.body(prefix, &mut body)?;
                counts.extend(message_counts(&body)?);
                continue;
            }
            if prefix.kind == kind::CHANNEL {
                let mut body = Vec::new();
                self.records.body(prefix, &mut body)?;
                let mut fields = Fields(&body);
                let (id, _schema) = (fields.u16()?, fields.u16()?);
                // Other channels may have no message.
                if fields.string()? == STATE {
                    counts.entry(id).or_default();
                }
                continue;
            }
            if prefix.kind != kind::FOOTER {
                self.records.skip(prefix)?;
                continue;
            }
            if prefix != (Prefix { kind: kind::FOOTER, length: 20 }) {
                return Err(damaged("the footer has a wrong length"));
            }
            let _starts: [u8; 16] = self.records.array()?;
            let checksum = self.records.checksum().finalize();
            if u32::from_le_bytes(self.records.array()?) != checksum {
                return Err(damaged("the summary does not match its checksum"));
            }
            if self.records.array()? != MAGIC || !self.records.at_end() {
                return Err(damaged("the file does not end like an MCAP file"));
            }
            return Ok(counts);
        }
    }
}

/// The number of messages of each channel in the body of a statistics record.
fn message_counts(body: &[u8]) -> Result<BTreeMap<u16, u64>, Broken> {
    let mut fields = Fields(body);
    // The sums of messages, schemas, channels, attachments, metadata and chunks, and two times.
    fields.bytes(8 + 2 + 4 * 4 + 2 * 8)?;
    let size = fields.u32()?;
    let mut entries = Fields(fields.bytes(size as usize)?);
    let mut counts = BTreeMap::new();
    while !entries.0.is_empty() {
        counts.insert(entries.u16()?, entries.u64()?);
    }
    Ok(counts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// A file of a hundred chunks without content, written by hand after the container's specification.
    fn data(claimed: u64, threads: usize) -> DataSection {
        let packed = zstd::bulk::compress(&[], 1).unwrap();
        // Start time and end time are zero.
        let mut chunk = vec![0; 16];
        chunk.extend(claimed.to_le_bytes());
        chunk.extend([0; 4]);
        chunk.extend(4_u32.to_le_bytes());
        chunk.extend(b"zstd");
        chunk.extend((packed.len() as u64).to_le_bytes());
        chunk.extend(packed);
        let mut bytes = MAGIC.to_vec();
        for _ in 0..100 {
            bytes.push(kind::CHUNK);
            bytes.extend((chunk.len() as u64).to_le_bytes());
            bytes.extend(&chunk);
        }
        let length = bytes.len() as u64;
        let input: Box<dyn Input> = Box::new(Cursor::new(bytes));
        let records = Records::new(BufReader::new(input), 0, length);
        let threads = NonZeroUsize::new(threads).unwrap();
        DataSection::new(records, threads, ChunkLimits::new(None, 0))
    }

    /// The bound that `Frames` documents.
    #[test]
    fn at_most_two_chunks_per_thread_are_in_progress() {
        for (threads, bound) in [(1, 1), (2, 4), (4, 8)] {
            let mut data = data(0, threads);
            for chunk in 0..100 {
                assert!(
                    matches!(data.advance(), Ok(DataRecord::Chunk(content, _)) if content.is_empty())
                );
                // The chunk just delivered counts as well; the truncated end follows the last chunk.
                assert_eq!(data.ahead.len() + 1, bound.min(101 - chunk));
            }
            assert!(matches!(data.advance(), Err(Broken::Torn)));
        }
    }

    #[test]
    fn chunks_ahead_claim_a_bounded_size_together() {
        let in_progress = |claimed: u64| {
            let mut data = data(claimed, 4);
            data.read_ahead();
            let is_submitted = |ahead: &(u64, Result<Ahead, Broken>)| {
                matches!(ahead.1, Ok(Ahead::Chunk { ticket: Ticket::OnThread(_), .. }))
            };
            data.ahead.iter().filter(|ahead| is_submitted(ahead)).count()
        };
        assert_eq!(in_progress(MAX_AHEAD_BYTES / 64), 8);
        assert_eq!(in_progress(MAX_AHEAD_BYTES * 2 / 5), 2);
        // One chunk of any size is delivered.
        assert_eq!(in_progress(MAX_AHEAD_BYTES * 6), 1);
        assert_eq!(in_progress(u64::MAX), 1);
    }
}

//! The data section of a file: its records in order. Chunks are read ahead, so that threads can decompress them.

use crate::container::{Broken, Fields, MAGIC, Prefix, Records, damaged, metadata};
use crate::limits::ChunkLimits;
use crate::record_kind as kind;
use crate::storage::Input;
use crate::unpacking::{Ticket, Unpackers};
use prost::bytes::Bytes;
use std::collections::{BTreeMap, VecDeque};
use std::io::BufReader;
use std::num::NonZeroUsize;

/// A record with data of frames.
pub(crate) enum DataRecord {
    /// The records of a chunk.
    Chunk(Bytes),
    /// A metadata record's name and entries.
    Metadata(String, BTreeMap<String, String>),
    /// The end of the file; all checksums are correct.
    End,
}

/// A record that is read but not checked yet.
enum Ahead {
    Chunk {
        /// Checksum of the bytes between the last chunk's body and this one's.
        before: crc32fast::Hasher,
        ticket: Ticket,
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
    all_read: bool,
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
            all_read: false,
            spare: Vec::new(),
            checksum: crc32fast::Hasher::new(),
            byte: 0,
        }
    }

    /// Start of the current record.
    pub(crate) fn byte(&self) -> u64 {
        self.byte
    }

    /// The next record.
    pub(crate) fn advance(&mut self) -> Result<DataRecord, Broken> {
        self.read_ahead();
        let Some((byte, record)) = self.ahead.pop_front() else { return Ok(DataRecord::End) };
        self.byte = byte;
        match record? {
            Ahead::Chunk { before, ticket } => {
                let (chunk, checksum) = self.unpackers.take(ticket)?;
                self.checksum.combine(&before);
                self.checksum.combine(&checksum);
                self.spare.extend(chunk.spare);
                Ok(DataRecord::Chunk(chunk.content))
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
                self.summary()?;
                Ok(DataRecord::End)
            }
        }
    }

    /// Reads ahead until enough chunks are being decompressed.
    fn read_ahead(&mut self) {
        while !self.all_read && self.ahead.len() < self.unpackers.look_ahead() {
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
            *byte = self.records.position();
            let before = self.records.checksum();
            let prefix = self.records.prefix_or_chunk(self.chunks.body_bytes())?;
            match prefix.kind {
                kind::CHUNK => {
                    let before = self.records.checksum();
                    self.records.body_without_checksum(prefix, &mut body)?;
                    self.records.restart_checksum();
                    let ticket = self.unpackers.submit(body);
                    return Ok(Ahead::Chunk { before, ticket });
                }
                kind::METADATA => {
                    self.records.body(prefix, &mut body)?;
                    return Ok(Ahead::Metadata(body));
                }
                kind::FOOTER => {
                    return Err(damaged("a record is at a place where no recording has one"));
                }
                kind::DATA_END => {
                    self.records.body(prefix, &mut body)?;
                    return Ok(Ahead::DataEnd { before, body });
                }
                _ => self.records.skip(prefix)?,
            }
        }
    }

    /// Checks the summary after the data, which viewers use.
    fn summary(&mut self) -> Result<(), Broken> {
        self.records.restart_checksum();
        loop {
            self.byte = self.records.position();
            let prefix = self.records.prefix()?;
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
            return Ok(());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// The bound that `Frames` documents. Chunks without content, written by hand after the container's specification.
    #[test]
    fn at_most_two_chunks_per_thread_are_in_progress() {
        let packed = zstd::bulk::compress(&[], 1).unwrap();
        // Start time, end time, size and checksum are zero.
        let mut chunk = vec![0; 28];
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
        for (threads, bound) in [(1, 1), (2, 4), (4, 8)] {
            let input: Box<dyn Input> = Box::new(Cursor::new(bytes.clone()));
            let records = Records::new(BufReader::new(input), 0, bytes.len() as u64);
            let threads = NonZeroUsize::new(threads).unwrap();
            let mut data = DataSection::new(records, threads, ChunkLimits::new(None, 0));
            for chunk in 0..100 {
                assert!(
                    matches!(data.advance(), Ok(DataRecord::Chunk(content)) if content.is_empty())
                );
                // The chunk just delivered counts as well; the truncated end follows the last chunk.
                assert_eq!(data.ahead.len() + 1, bound.min(101 - chunk));
            }
            assert!(matches!(data.advance(), Err(Broken::Torn)));
        }
    }
}

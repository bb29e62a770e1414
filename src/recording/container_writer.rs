//! Writer of the container: records outside the chunks, compressed chunks with their indexes, and the summary.
//!
//! The writer of the `mcap` crate compresses a chunk while its messages arrive, on the thread that writes them. This one receives
//! chunks that were compressed on any thread. Layout of the records: `<https://mcap.dev/spec>`.

use crate::container::MAGIC;
use crate::open_chunk::ClosedChunk;
use crate::packing::PackedChunk;
use crate::provenance::LIBRARY;
use crate::record_bytes::PutFields as _;
use crate::record_kind as kind;
use crate::sink::CountingSink;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Writes a file from its first byte to its last.
pub(crate) struct ContainerWriter<W: Write> {
    sink: CountingSink<W>,
    position: u64,
    /// Checksum of all bytes so far.
    checksum: crc32fast::Hasher,
    /// The records of the summary.
    schemas: Vec<u8>,
    channels: Vec<u8>,
    chunk_indexes: Vec<u8>,
    attachment_indexes: Vec<u8>,
    metadata_indexes: Vec<u8>,
    /// Their numbers.
    schema_count: u16,
    channel_count: u32,
    chunk_count: u32,
    attachment_count: u32,
    metadata_count: u32,
    /// Number of messages of each channel, and the log times of the first and the last message.
    message_counts: BTreeMap<u16, u64>,
    times: Option<[u64; 2]>,
}

impl<W: Write> ContainerWriter<W> {
    /// Starts a file.
    pub(crate) fn create(sink: CountingSink<W>) -> io::Result<Self> {
        let mut writer = Self {
            sink,
            position: 0,
            checksum: crc32fast::Hasher::new(),
            schemas: Vec::new(),
            channels: Vec::new(),
            chunk_indexes: Vec::new(),
            attachment_indexes: Vec::new(),
            metadata_indexes: Vec::new(),
            schema_count: 0,
            channel_count: 0,
            chunk_count: 0,
            attachment_count: 0,
            metadata_count: 0,
            message_counts: BTreeMap::new(),
            times: None,
        };
        let mut start = MAGIC.to_vec();
        start.put_record(kind::HEADER, |body| {
            body.put_bytes(&[]);
            body.put_bytes(LIBRARY.as_bytes());
        });
        writer.write(&start)?;
        Ok(writer)
    }

    /// Writes an attachment.
    pub(crate) fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> io::Result<()> {
        let offset = self.position;
        let mut record = Vec::new();
        record.put_record(kind::ATTACHMENT, |body| {
            let start = body.len();
            // Log time and time of creation.
            body.put_u64(0);
            body.put_u64(0);
            body.put_bytes(name.as_bytes());
            body.put_bytes(media_type.as_bytes());
            body.put_u64(data.len() as u64);
            body.extend_from_slice(data);
            body.put_u32(crc32fast::hash(&body[start..]));
        });
        self.write(&record)?;
        self.attachment_count += 1;
        self.attachment_indexes.put_record(kind::ATTACHMENT_INDEX, |body| {
            body.put_u64(offset);
            body.put_u64(record.len() as u64);
            body.put_u64(0);
            body.put_u64(0);
            body.put_u64(data.len() as u64);
            body.put_bytes(name.as_bytes());
            body.put_bytes(media_type.as_bytes());
        });
        Ok(())
    }

    /// Writes a metadata record.
    pub(crate) fn metadata(
        &mut self,
        name: &str,
        entries: &BTreeMap<String, String>,
    ) -> io::Result<()> {
        let offset = self.position;
        let mut record = Vec::new();
        record.put_record(kind::METADATA, |body| {
            body.put_bytes(name.as_bytes());
            body.put_map(entries);
        });
        self.write(&record)?;
        self.metadata_count += 1;
        self.metadata_indexes.put_record(kind::METADATA_INDEX, |body| {
            body.put_u64(offset);
            body.put_u64(record.len() as u64);
            body.put_bytes(name.as_bytes());
        });
        Ok(())
    }

    /// Adds a schema to the summary. Returns its number, and its record for the chunk in which it is needed first.
    pub(crate) fn add_schema(&mut self, name: &str, encoding: &str, data: &[u8]) -> (u16, Vec<u8>) {
        self.schema_count += 1;
        let (id, mut record) = (self.schema_count, Vec::new());
        record.put_record(kind::SCHEMA, |body| {
            body.put_u16(id);
            body.put_bytes(name.as_bytes());
            body.put_bytes(encoding.as_bytes());
            body.put_bytes(data);
        });
        self.schemas.extend_from_slice(&record);
        (id, record)
    }

    /// Adds a channel to the summary. Returns its number, and its record for the first chunk with its messages.
    pub(crate) fn add_channel(&mut self, schema: u16, topic: &str) -> (u16, Vec<u8>) {
        self.channel_count += 1;
        let (id, mut record) = (self.channel_count as u16, Vec::new());
        record.put_record(kind::CHANNEL, |body| {
            body.put_u16(id);
            body.put_u16(schema);
            body.put_bytes(topic.as_bytes());
            body.put_bytes(b"protobuf");
            body.put_map(&BTreeMap::new());
        });
        self.channels.extend_from_slice(&record);
        (id, record)
    }

    /// Writes a compressed chunk with the indexes of its messages; `body` are the parts of its compressed content.
    pub(crate) fn chunk(
        &mut self,
        index: &BTreeMap<u16, Vec<u8>>,
        [start, end]: [u64; 2],
        packed: &PackedChunk,
        body: &[&[u8]],
    ) -> io::Result<()> {
        let offset = self.position;
        self.sink.write_all(&packed.head)?;
        body.iter().try_for_each(|part| self.sink.write_all(part))?;
        let body_bytes = body.iter().map(|part| part.len() as u64).sum::<u64>();
        self.position += packed.head.len() as u64 + body_bytes;
        self.checksum.combine(&packed.checksum);
        let length = self.position - offset;
        let (mut indexes, mut offsets) = (Vec::new(), BTreeMap::new());
        for (channel, messages) in index {
            offsets.insert(*channel, self.position + indexes.len() as u64);
            indexes.put_record(kind::MESSAGE_INDEX, |body| {
                body.put_u16(*channel);
                body.put_bytes(messages);
            });
            let count = messages.len() / ClosedChunk::INDEX_ENTRY_BYTES;
            *self.message_counts.entry(*channel).or_default() += count as u64;
        }
        self.write(&indexes)?;
        self.chunk_count += 1;
        let [first, last] = self.times.unwrap_or([start, end]);
        self.times = Some([first.min(start), last.max(end)]);
        self.chunk_indexes.put_record(kind::CHUNK_INDEX, |index| {
            index.put_u64(start);
            index.put_u64(end);
            index.put_u64(offset);
            index.put_u64(length);
            index.put_numbers(&offsets);
            index.put_u64(indexes.len() as u64);
            index.put_bytes(packed.compression.as_bytes());
            index.put_u64(body_bytes);
            index.put_u64(packed.content_bytes as u64);
        });
        Ok(())
    }

    /// Ends the file with its summary and returns the sink, flushed.
    pub(crate) fn finish(mut self) -> io::Result<W> {
        let mut data_end = Vec::new();
        let checksum = self.checksum.clone().finalize();
        data_end.put_record(kind::DATA_END, |body| body.put_u32(checksum));
        self.write(&data_end)?;
        let mut statistics = Vec::new();
        statistics.put_record(kind::STATISTICS, |body| {
            let [start, end] = self.times.unwrap_or_default();
            body.put_u64(self.message_counts.values().sum());
            body.put_u16(self.schema_count);
            body.put_u32(self.channel_count);
            body.put_u32(self.attachment_count);
            body.put_u32(self.metadata_count);
            body.put_u32(self.chunk_count);
            body.put_u64(start);
            body.put_u64(end);
            body.put_numbers(&self.message_counts);
        });
        let start = self.position;
        let (mut summary, mut offsets) = (Vec::new(), Vec::new());
        for (kind, records) in [
            (kind::SCHEMA, &self.schemas),
            (kind::CHANNEL, &self.channels),
            (kind::STATISTICS, &statistics),
            (kind::CHUNK_INDEX, &self.chunk_indexes),
            (kind::ATTACHMENT_INDEX, &self.attachment_indexes),
            (kind::METADATA_INDEX, &self.metadata_indexes),
        ] {
            if !records.is_empty() {
                offsets.put_record(kind::SUMMARY_OFFSET, |body| {
                    body.push(kind);
                    body.put_u64(start + summary.len() as u64);
                    body.put_u64(records.len() as u64);
                });
                summary.extend_from_slice(records);
            }
        }
        let offset_start = start + summary.len() as u64;
        summary.extend_from_slice(&offsets);
        summary.put_record(kind::FOOTER, |body| {
            body.put_u64(start);
            body.put_u64(offset_start);
            body.put_u32(0);
        });
        let checked = summary.len() - size_of::<u32>();
        let checksum = crc32fast::hash(&summary[..checked]);
        summary[checked..].copy_from_slice(&checksum.to_le_bytes());
        summary.extend_from_slice(&MAGIC);
        self.sink.write_all(&summary)?;
        self.sink.into_inner()
    }

    /// Passes all bytes to the sink.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.checksum.update(bytes);
        self.position += bytes.len() as u64;
        self.sink.write_all(bytes)
    }
}

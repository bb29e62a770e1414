//! Writer of blocks: the frames of a block are divided into chunks of three groups of channels, so that a reader of one group
//! decompresses no other.
//!
//! The chunks of a block follow each other in the file: drawings and states, each in order of time, and one chunk of scalars, with
//! the clocks of all its frames, which ends the block. All bounds follow from frames and from the sizes of their messages, never
//! from the time that something takes.

use crate::channels::{self, ChannelDeclaration};
use crate::container_writer::ContainerWriter;
use crate::error::RecordError;
use crate::header::Compression;
use crate::keyframe::KEYFRAME;
use crate::open_chunk::{OpenChunk, put_message_head};
use crate::packing::Packing;
use crate::payload::Payload;
use crate::sink::CountingSink;
use crate::spare_memory::Lent;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::Arc;

/// Size at which a chunk of drawings is closed, at the next end of a frame. A viewer that jumps decompresses one.
const DRAWINGS_BYTES: usize = 1 << 20;
/// Size at which a chunk of states is closed, and with it the block. Values that do not change from frame to frame take space once
/// per chunk.
const STATE_BYTES: usize = 4 << 20;
/// Size of the scalars at which a block ends.
const SCALARS_BYTES: usize = 1 << 20;
/// Size of the drawings at which a block ends: a reader has a block in memory.
const DRAWINGS_OF_BLOCK_BYTES: usize = 8 << 20;
/// Size of a message that is compressed without a copy, in a chunk of its own. The block ends with its frame.
pub(crate) const LARGE_MESSAGE_BYTES: usize = 16 << 20;

/// A group of channels with chunks of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Group {
    /// What viewers draw.
    Drawings,
    /// What has values for each particle, contact or collision, the container, and keyframes.
    State,
    /// The clock, and what has a few values per frame.
    Scalars,
}

impl Group {
    /// The group of a topic.
    pub(crate) fn of(topic: &str, declared: &[ChannelDeclaration]) -> Self {
        match topic {
            // An analysis reads the walls as well.
            channels::PARTICLES | channels::STATE | channels::WALLS | KEYFRAME => Self::State,
            channels::DISCS
            | channels::VELOCITY
            | channels::FORCE_CHAINS
            | channels::TRAIL
            | channels::LEGEND => Self::Drawings,
            // Channels that are recorded only on request are long columns.
            _ if declared.iter().any(|channel| channel.topic == topic && channel.opt_in) => {
                Self::State
            }
            _ => Self::Scalars,
        }
    }
}

/// A message and its place in time.
#[derive(Clone, Copy)]
pub(crate) struct MessageHead {
    pub(crate) channel: u16,
    /// The index of the frame; MCAP has 32 bits for it, and readers go by `/frame`.
    pub(crate) sequence: u32,
    pub(crate) log_time: u64,
}

/// Writes the blocks of a recording, and what is before and after them.
pub(crate) struct BlockWriter<W: Write> {
    container: ContainerWriter<W>,
    packing: Packing,
    /// The open chunks, in the order of [`Group`].
    open: [OpenChunk; 3],
    /// Size of the drawings in closed chunks of the open block.
    closed_drawings: usize,
    /// Whether the open block has a large message.
    is_large: bool,
    /// Contents of closed chunks of the open block, if a checkpoint needs them.
    closed: Option<Vec<Arc<Lent<u8>>>>,
    /// For each schema, its number, its record, and the groups that have declared it.
    schemas: BTreeMap<String, (u16, Vec<u8>, Vec<Group>)>,
}

impl<W: Write> BlockWriter<W> {
    pub(crate) fn create(sink: CountingSink<W>, compression: Compression) -> io::Result<Self> {
        Ok(Self {
            container: ContainerWriter::create(sink)?,
            packing: Packing::new(compression),
            open: [OpenChunk::new(), OpenChunk::new(), OpenChunk::new()],
            closed_drawings: 0,
            is_large: false,
            closed: None,
            schemas: BTreeMap::new(),
        })
    }

    /// Keeps the contents of the open block for [`BlockWriter::open_block`].
    pub(crate) fn keep_open_block(&mut self) {
        self.closed = Some(Vec::new());
    }

    /// The contents of the chunks of the open block.
    pub(crate) fn open_block(&self) -> Vec<Vec<u8>> {
        let closed = self.closed.iter().flatten().map(|content| content.to_vec());
        closed.chain(self.open.iter().map(|chunk| chunk.content().to_vec())).collect()
    }

    /// Writes an attachment before the first frame.
    pub(crate) fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> io::Result<()> {
        self.container.attach(name, media_type, data)
    }

    /// Writes a metadata record, after the block that it ends.
    pub(crate) fn metadata(
        &mut self,
        name: &str,
        entries: &BTreeMap<String, String>,
    ) -> io::Result<()> {
        self.end_block()?;
        self.write_packed(true)?;
        self.container.metadata(name, entries)
    }

    /// Declares a channel. The first chunk of its group begins with its declaration.
    pub(crate) fn declare(&mut self, group: Group, topic: &str, schema: &foxglove::Schema) -> u16 {
        let Self { container, schemas, open, .. } = self;
        let chunk = &mut open[group as usize];
        let (schema, record, groups) = schemas.entry(schema.name.clone()).or_insert_with(|| {
            let (id, record) = container.add_schema(&schema.name, &schema.encoding, &schema.data);
            (id, record, Vec::new())
        });
        // Each group that has channels with a schema declares it.
        if !groups.contains(&group) {
            groups.push(group);
            chunk.declare(record);
        }
        let (id, record) = container.add_channel(*schema, topic);
        chunk.declare(&record);
        id
    }

    /// Adds a message to the chunk of a group.
    pub(crate) fn message(
        &mut self,
        group: Group,
        head: MessageHead,
        payload: Payload<'_>,
    ) -> io::Result<()> {
        if payload.len() >= LARGE_MESSAGE_BYTES {
            return self.large_message(group, head, payload);
        }
        let MessageHead { channel, sequence, log_time } = head;
        self.open[group as usize].push(channel, sequence, log_time, &payload);
        Ok(())
    }

    /// Writes a chunk with one message, after those that are closed.
    fn large_message(
        &mut self,
        group: Group,
        head: MessageHead,
        mut payload: Payload<'_>,
    ) -> io::Result<()> {
        if !self.open[group as usize].has_no_message() {
            self.close(group)?;
        }
        self.write_packed(true)?;
        self.is_large = true;
        let mut before = self.open[group as usize].take_declarations();
        let MessageHead { channel, sequence, log_time } = head;
        let entry = [log_time.to_le_bytes(), (before.len() as u64).to_le_bytes()].concat();
        put_message_head(&mut before.vector, channel, sequence, log_time, payload.len());
        let (index, times) = (BTreeMap::from([(channel, entry)]), [log_time; 2]);
        let packed = self.packing.pack_now(times, &before, &mut payload)?;
        let body = match &packed.body {
            Some(rest) => [&payload[..packed.in_place], rest],
            None => [&before[..], &payload],
        };
        self.container.chunk(&index, times, &packed, &body)
    }

    /// Ends a frame, and with it the block if it is large enough or `ends_block`. Returns whether the block has ended.
    pub(crate) fn end_frame(&mut self, ends_block: bool) -> Result<bool, RecordError> {
        let [drawings, state, scalars] = self.open.each_ref().map(OpenChunk::bytes);
        let is_full = state >= STATE_BYTES
            || scalars >= SCALARS_BYTES
            || self.closed_drawings + drawings >= DRAWINGS_OF_BLOCK_BYTES;
        if ends_block || is_full || self.is_large {
            self.end_block()?;
            return Ok(true);
        }
        if drawings >= DRAWINGS_BYTES {
            self.closed_drawings += drawings;
            self.close(Group::Drawings)?;
        }
        Ok(false)
    }

    fn end_block(&mut self) -> io::Result<()> {
        for group in [Group::Drawings, Group::State, Group::Scalars] {
            self.close(group)?;
        }
        self.closed_drawings = 0;
        self.is_large = false;
        if let Some(closed) = &mut self.closed {
            closed.clear();
        }
        Ok(())
    }

    fn close(&mut self, group: Group) -> io::Result<()> {
        let Some(chunk) = self.open[group as usize].close() else { return Ok(()) };
        if let Some(closed) = &mut self.closed {
            closed.push(Arc::clone(&chunk.content));
        }
        self.packing.push(chunk);
        self.write_packed(false)
    }

    /// Writes the chunks that are compressed; with `all`, waits for the others.
    fn write_packed(&mut self, all: bool) -> io::Result<()> {
        while let Some((chunk, packed)) = self.packing.pop(all)? {
            let body = packed.body.as_deref().unwrap_or(&chunk.content);
            self.container.chunk(&chunk.index, chunk.times, &packed, &[body])?;
        }
        Ok(())
    }

    /// Passes all closed chunks to the sink.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.write_packed(true)?;
        self.container.flush()
    }

    /// Ends the last block and the file; returns the sink, flushed.
    pub(crate) fn finish(mut self) -> io::Result<W> {
        self.end_block()?;
        self.write_packed(true)?;
        self.container.finish()
    }
}

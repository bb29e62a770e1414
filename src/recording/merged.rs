//! One recording of several runs: the messages of run k under `/run_k`, the later runs drawn as ghosts over the first one, and
//! their distances from it.

use crate::channels::{self, ALL, Channel, ChannelDeclaration};
use crate::container::Broken;
use crate::error::{ReadError, RecordError};
use crate::frames::Frames;
use crate::ghosts;
use crate::provenance::{LIBRARY, MERGED_RECORD, Outcome};
use crate::reader::Recording;
use crate::recorded_frame::{RecordedFrame, RecordedMessage};
use crate::schema::schema_of;
use crate::sink::CountingSink;
use crate::table::StateTable;
use kinetoscope_console::Explained;
use mcap::records::{MessageHeader, Metadata};
use prost::Message as _;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;
use std::iter::Peekable;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use thiserror::Error;

/// Maximum number of runs in one recording: the number of colors of ghosts that can be told apart, and one.
pub const MAX_RUNS: usize = ghosts::COLORS.len() + 1;
/// Size at which a chunk is closed, at the next end of a frame.
const CHUNK_PAYLOAD: u64 = 1 << 20;

/// Distance between the particles of a run and those of the first run.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Separation {
    /// Largest distance of a particle from its position in the first run.
    #[prost(double, tag = "1")]
    pub max_distance: f64,
    /// Root of the mean square of these distances.
    #[prost(double, tag = "2")]
    pub rms_distance: f64,
    /// Decimal logarithm of `max_distance`; not a number where it is zero.
    #[prost(double, tag = "3")]
    pub log10_max_distance: f64,
    /// Unit of the distances; empty where positions have none.
    #[prost(string, tag = "4")]
    pub length_unit: String,
}

impl Channel for Separation {
    const TOPIC: &'static str = "/separation";
    const SCHEMA: &'static str = "kinetoscope.Separation";
    const FIELDS: &'static [channels::Field] = &[
        channels::Field { name: "max_distance", kind: "double", tag: "1" },
        channels::Field { name: "rms_distance", kind: "double", tag: "2" },
        channels::Field { name: "log10_max_distance", kind: "double", tag: "3" },
        channels::Field { name: "length_unit", kind: "string", tag: "4" },
    ];

    fn has_equal_columns(&self) -> bool {
        true
    }

    // Its distances are those of finite positions.
    fn with_canonical_nan(&self) -> Option<Self> {
        None
    }
}

impl Separation {
    /// Of two states with the same particles; `None` if they have not.
    fn between(state: &StateTable, first: &StateTable, length_unit: &str) -> Option<Self> {
        let [x, y] = ["x", "y"].map(|name| state.index(name));
        let (x, y) = (x?, y?);
        if state.rows() != first.rows() || state.columns() != first.columns() || state.rows() == 0 {
            return None;
        }
        let (mut largest, mut sum) = (0.0, 0.0);
        for row in 0..state.rows() {
            let [dx, dy] = [x, y].map(|column| state.row(row)[column] - first.row(row)[column]);
            let distance = libm::hypot(dx, dy);
            if distance > largest {
                largest = distance;
            }
            sum += distance * distance;
        }
        Some(Self {
            max_distance: largest,
            rms_distance: (sum / state.rows() as f64).sqrt(),
            log10_max_distance: if largest > 0.0 { libm::log10(largest) } else { f64::NAN },
            length_unit: length_unit.to_owned(),
        })
    }
}

/// A run of a merged recording.
#[derive(Clone, Copy, Debug)]
pub struct MergedRun<'a> {
    /// Its recording.
    pub recording: &'a Recording,
    /// What tells it from the others.
    pub label: &'a str,
}

/// The reason why recordings cannot be merged.
#[derive(Debug, Error)]
pub enum MergeError {
    /// One of them cannot be read to its end.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The new recording cannot be written.
    #[error(transparent)]
    Write(#[from] RecordError),
}

impl Explained for MergeError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Read(error) => error.help(),
            Self::Write(error) => error.help(),
        }
    }
}

/// The prefix of the topics of a run; the first run has index 0.
#[must_use]
pub fn prefix_of_run(index: usize) -> String {
    format!("/run_{}", index + 1)
}

/// Merges recordings of one model into a sink: of the first one all messages as they are, of the others the drawings in one color
/// each and half transparent. Equal simulated times have equal log times, those of the first run. Memory: a frame of each.
///
/// # Errors
/// A recording that cannot be read to its end, or a sink that fails.
pub fn merge<W: Write>(runs: &[MergedRun<'_>], sink: W) -> Result<W, MergeError> {
    let mut merger = Merger::create(runs, sink)?;
    let mut sources = runs
        .iter()
        .enumerate()
        .map(|(index, run)| Source::open(index, run.recording))
        .collect::<Result<Vec<_>, _>>()?;
    while let Some(index) = earliest(&mut sources) {
        let following = match sources.first_mut().and_then(|first| first.frames.peek()) {
            Some(Ok(next)) if index > 0 => Some(Instant::of(next)),
            _ => None,
        };
        let Some(frame) = sources.get_mut(index).and_then(|source| source.frames.next()) else {
            break;
        };
        let frame = frame?;
        if let Some(source) = sources.get_mut(index) {
            merger.write(source, frame, following)?;
        }
    }
    merger.finish()
}

/// A recording that is being merged.
struct Source {
    index: usize,
    frames: Peekable<Frames>,
    length_unit: String,
}

impl Source {
    fn open(index: usize, recording: &Recording) -> Result<Self, ReadError> {
        let provenance = recording.provenance();
        let column = provenance.state_columns.iter().position(|name| name == "x");
        let unit = column.and_then(|column| provenance.state_units.get(column));
        Ok(Self {
            index,
            frames: recording.frames()?.with_scalar_frames().peekable(),
            length_unit: unit.cloned().unwrap_or_default(),
        })
    }
}

/// Index of the recording whose next frame is the earliest, and of several the first one. A damaged recording comes first, so
/// that its error ends the merge.
fn earliest(sources: &mut [Source]) -> Option<usize> {
    let mut found: Option<(usize, f64)> = None;
    for (index, source) in sources.iter_mut().enumerate() {
        let time = match source.frames.peek() {
            None => continue,
            Some(Err(_)) => return Some(index),
            Some(Ok(frame)) => frame.clock.time,
        };
        if found.is_none_or(|(_, earliest)| time.total_cmp(&earliest).is_lt()) {
            found = Some((index, time));
        }
    }
    found.map(|(index, _)| index)
}

/// Simulated time and log time of a frame.
#[derive(Clone, Copy)]
struct Instant {
    time: f64,
    log_time_ns: u64,
}

impl Instant {
    fn of(frame: &RecordedFrame) -> Self {
        let log_time_ns = frame.messages().first().map_or(0, RecordedMessage::log_time_ns);
        Self { time: frame.clock.time, log_time_ns }
    }

    /// The log time at a simulated time by the scale between this frame and a later one.
    fn log_time_at(self, time: f64, later: Self) -> u64 {
        let share = (time - self.time) / (later.time - self.time);
        let span = later.log_time_ns.saturating_sub(self.log_time_ns) as f64;
        // The cast saturates, and gives 0 for what is not a number.
        self.log_time_ns.saturating_add((share * span) as u64)
    }
}

/// Writer of the merged recording.
struct Merger<W: Write> {
    writer: mcap::Writer<CountingSink<W>>,
    channel_ids: BTreeMap<String, u16>,
    payload_in_chunk: u64,
    // The last two frames of the first run: the scale of the playback.
    first_run: [Option<Instant>; 2],
    first_state: Option<StateTable>,
    first_walls: Vec<u8>,
    last_log_time: u64,
}

impl<W: Write> Merger<W> {
    fn create(runs: &[MergedRun<'_>], sink: W) -> Result<Self, RecordError> {
        let sink = CountingSink::new(sink, Arc::new(AtomicU64::new(0)));
        let mut writer = write_options().create(sink)?;
        let mut entries = BTreeMap::from([("runs".to_owned(), runs.len().to_string())]);
        for (index, MergedRun { recording, label }) in runs.iter().enumerate() {
            let name = format!("run_{}", index + 1);
            writer.attach(&mcap::Attachment {
                log_time: 0,
                create_time: 0,
                name: format!("{name}.toml"),
                media_type: "application/toml".to_owned(),
                data: Cow::Borrowed(recording.manifest().as_bytes()),
            })?;
            let provenance = recording.provenance();
            entries.insert(format!("{name}.label"), (*label).to_owned());
            let outcome = provenance.outcome.as_ref().map(Outcome::to_metadata).unwrap_or_default();
            let described = provenance.to_metadata().into_iter().chain(outcome);
            entries.extend(described.map(|(key, value)| (format!("{name}.{key}"), value)));
        }
        let name = MERGED_RECORD.to_owned();
        writer.write_metadata(&Metadata { name, metadata: entries })?;
        Ok(Self {
            writer,
            channel_ids: BTreeMap::new(),
            payload_in_chunk: 0,
            first_run: [None; 2],
            first_state: None,
            first_walls: Vec::new(),
            last_log_time: 0,
        })
    }

    /// Writes a frame; `following` is the next frame of the first run, where the frame is of another run.
    fn write(
        &mut self,
        source: &Source,
        mut frame: RecordedFrame,
        following: Option<Instant>,
    ) -> Result<(), MergeError> {
        let own = Instant::of(&frame);
        let log_time = match (self.first_run, following) {
            _ if source.index == 0 => own.log_time_ns,
            ([_, Some(last)], _) if last.time.to_bits() == own.time.to_bits() => last.log_time_ns,
            ([_, Some(last)], Some(next)) => last.log_time_at(own.time, next),
            ([Some(before), Some(last)], None) => before.log_time_at(own.time, last),
            _ => own.log_time_ns,
        };
        let log_time = log_time.max(self.last_log_time);
        self.last_log_time = log_time;
        let sequence = frame.clock.frame as u32;
        let place = Place { prefix: prefix_of_run(source.index), log_time, sequence };
        for message in frame.messages() {
            self.copy(source, &frame, message, &place)?;
        }
        let state = frame.take_state();
        if source.index == 0 {
            self.first_run = [self.first_run[1], Some(own)];
            self.first_state = state;
        } else if let (Some(state), Some(first), [_, Some(last)]) =
            (&state, &self.first_state, self.first_run)
            && last.time.to_bits() == own.time.to_bits()
            && let Some(separation) = Separation::between(state, first, &source.length_unit)
        {
            let payload = separation.encode_to_vec();
            self.payload(&place, Separation::TOPIC, Separation::SCHEMA, &payload)?;
        }
        if self.payload_in_chunk >= CHUNK_PAYLOAD {
            self.writer.flush().map_err(RecordError::from)?;
            self.payload_in_chunk = 0;
        }
        Ok(())
    }

    /// Copies a message, as a ghost where it is a drawing of a later run. The container and the color bar are drawn once.
    fn copy(
        &mut self,
        source: &Source,
        frame: &RecordedFrame,
        message: &RecordedMessage,
        place: &Place,
    ) -> Result<(), MergeError> {
        let (topic, schema, payload) = (message.topic(), message.schema(), message.payload());
        if source.index == 0 {
            if topic == channels::WALLS {
                payload.clone_into(&mut self.first_walls);
            }
            return Ok(self.payload(place, topic, schema, payload)?);
        }
        if topic == channels::LEGEND || (topic == channels::WALLS && *payload == self.first_walls) {
            return Ok(());
        }
        if schema != "foxglove.SceneUpdate" {
            return Ok(self.payload(place, topic, schema, payload)?);
        }
        let ghost = ghosts::ghost(payload, source.index - 1, place.log_time).map_err(|error| {
            frame.read_error(Broken::Damaged(format!("a drawing is not valid protobuf ({error})")))
        })?;
        Ok(self.payload(place, topic, schema, &ghost)?)
    }

    fn payload(
        &mut self,
        place: &Place,
        topic: &str,
        schema: &str,
        payload: &[u8],
    ) -> Result<(), RecordError> {
        let channel_id = self.channel(&format!("{}{topic}", place.prefix), topic, schema)?;
        let header = MessageHeader {
            channel_id,
            sequence: place.sequence,
            log_time: place.log_time,
            publish_time: place.log_time,
        };
        self.writer.write_to_known_channel(&header, payload)?;
        self.payload_in_chunk += payload.len() as u64;
        Ok(())
    }

    /// The channel of a topic, which is declared before its first message.
    fn channel(&mut self, name: &str, topic: &str, schema: &str) -> Result<u16, RecordError> {
        if let Some(&id) = self.channel_ids.get(name) {
            return Ok(id);
        }
        let separation = ChannelDeclaration::of::<Separation>();
        let declared = ALL.iter().chain([&separation]).find(|channel| channel.schema == schema);
        let schema = schema_of(topic, declared.map_or(&[], std::slice::from_ref))?;
        let schema = self.writer.add_schema(&schema.name, &schema.encoding, &schema.data)?;
        let id = self.writer.add_channel(schema, name, "protobuf", &BTreeMap::new())?;
        self.channel_ids.insert(name.to_owned(), id);
        Ok(id)
    }

    fn finish(mut self) -> Result<W, MergeError> {
        self.writer.finish().map_err(RecordError::from)?;
        Ok(self.writer.into_inner().into_inner().map_err(RecordError::from)?)
    }
}

/// Sets every option, so that the bytes do not depend on defaults of a release or of the machine.
fn write_options() -> mcap::WriteOptions {
    let options = mcap::WriteOptions::new();
    #[cfg(not(target_os = "unknown"))]
    let options = options
        .compression(Some(mcap::Compression::Zstd))
        .compression_level(1)
        .compression_threads(0);
    options
        .profile("")
        .library(LIBRARY)
        .chunk_size(None)
        .use_chunks(true)
        // Chunks are packed in memory and go out whole: the sink only ever grows at its end.
        .disable_seeking(true)
        .emit_summary_records(true)
        .emit_summary_offsets(true)
        .emit_message_indexes(true)
        .calculate_chunk_crcs(true)
        .calculate_data_section_crc(true)
        .calculate_summary_section_crc(true)
        .calculate_attachment_crcs(true)
}

/// Where a frame's messages go.
struct Place {
    prefix: String,
    log_time: u64,
    sequence: u32,
}

//! Two recordings, message by message: the first difference by its name.

use kinetoscope_recording::channels::{self, FrameClock};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::fields::{FieldValue, FieldValues, read_fields};
use kinetoscope_recording::reader::{Outcome, RecordedFrame, RecordedMessage, Recording};
use std::fmt;

/// What came of comparing two recordings frame by frame, in the memory of two frames.
#[derive(Debug)]
pub struct Comparison {
    /// Frames from the start that are equal.
    pub equal_frames: u64,
    /// The first difference.
    pub difference: Option<Difference>,
    /// What ended the comparison before the recordings ended.
    pub unreadable: Option<ReadError>,
}

/// The first thing in which two recordings differ, the left one before the right one.
#[derive(Clone, Debug, PartialEq)]
pub enum Difference {
    /// What stands at the start of the file and gives the messages their meaning.
    Meaning {
        /// What of it.
        what: &'static str,
        /// Both texts.
        values: [String; 2],
    },
    /// One recording has fewer frames.
    Frames {
        /// Frames that both have.
        common: u64,
        /// How each of them ended.
        outcomes: [Option<Outcome>; 2],
        /// Whether it is the left one that ends.
        left_ends: bool,
    },
    /// All frames are equal, and the endings are not.
    Outcome([Option<Outcome>; 2]),
    /// A message.
    Message {
        /// Its topic.
        topic: String,
        /// Index and simulated time of its frame.
        clock: FrameClock,
        /// What of it differs.
        what: Mismatch,
    },
}

/// What of a message differs, the left one before the right one.
#[derive(Clone, Debug, PartialEq)]
pub enum Mismatch {
    /// Only one of the frames has this message.
    Missing {
        /// Whether it is the left frame that lacks it.
        in_left: bool,
    },
    /// The messages of the frame are the same and in another order.
    Order,
    /// Names of the schemas.
    Schema([String; 2]),
    /// Log times, ns.
    LogTime([u64; 2]),
    /// Numbers of particles.
    Particles([usize; 2]),
    /// One quantity of one particle.
    State {
        /// Index of the particle, from 0.
        particle: usize,
        /// Name of the column.
        column: String,
        /// Both values.
        values: [f64; 2],
    },
    /// Lengths of a series.
    Length {
        /// Name of the field.
        field: &'static str,
        /// Both lengths.
        lengths: [usize; 2],
    },
    /// One value of a field.
    Field {
        /// Name of the field.
        field: &'static str,
        /// Place in a series, from 0.
        index: Option<usize>,
        /// Both values.
        values: [FieldValue; 2],
    },
    /// Texts of the log.
    Text([String; 2]),
    /// Bytes that have no name of ours: those of a drawing, say.
    Bytes {
        /// The first byte that differs.
        offset: usize,
    },
}

/// Compares what two recordings say, not the bytes that they say it in. Versions and run keys are no part of it.
///
/// # Errors
/// A file that can't be opened. What can't be read of it ends the comparison and is part of the answer.
pub fn compare_messages(left: &Recording, right: &Recording) -> Result<Comparison, ReadError> {
    let mut comparison =
        Comparison { equal_frames: 0, difference: meaning(left, right), unreadable: None };
    let (mut left_frames, mut right_frames) = (left.frames()?, right.frames()?);
    while comparison.difference.is_none() {
        let pair = match (left_frames.next().transpose(), right_frames.next().transpose()) {
            (Ok(left), Ok(right)) => (left, right),
            (Err(error), _) | (_, Err(error)) => {
                comparison.unreadable = Some(error);
                break;
            }
        };
        let outcomes = || [left.provenance().outcome.clone(), right.provenance().outcome.clone()];
        match pair {
            (Some(left), Some(right)) => {
                comparison.difference = between_frames(&left, &right);
                comparison.equal_frames += u64::from(comparison.difference.is_none());
            }
            (None, None) => {
                let [one, other] = outcomes();
                comparison.difference = (one != other).then_some(Difference::Outcome([one, other]));
                break;
            }
            (left, _) => {
                comparison.difference = Some(Difference::Frames {
                    common: comparison.equal_frames,
                    outcomes: outcomes(),
                    left_ends: left.is_none(),
                });
            }
        }
    }
    Ok(comparison)
}

fn meaning(left: &Recording, right: &Recording) -> Option<Difference> {
    let entries = |recording: &Recording| {
        let provenance = recording.provenance();
        [
            ("model", provenance.model.clone()),
            ("time unit", provenance.time_unit.clone()),
            ("state columns", provenance.state_columns.join(",")),
            ("state units", provenance.state_units.join(",")),
            ("playback rate", provenance.playback_fps.to_string()),
        ]
    };
    entries(left)
        .into_iter()
        .zip(entries(right))
        .find(|(one, other)| one != other)
        .map(|((what, one), (_, other))| Difference::Meaning { what, values: [one, other] })
}

fn between_frames(left: &RecordedFrame, right: &RecordedFrame) -> Option<Difference> {
    let (ours, theirs) = (left.messages(), right.messages());
    let at = |message: &RecordedMessage, what| {
        let (topic, clock) = (message.topic().to_owned(), left.clock.clone());
        Some(Difference::Message { topic, clock, what })
    };
    let has = |messages: &[RecordedMessage], topic| {
        messages.iter().any(|message| message.topic() == topic)
    };
    for index in 0.. {
        match (ours.get(index), theirs.get(index)) {
            (None, None) => break,
            (Some(one), None) => return at(one, Mismatch::Missing { in_left: false }),
            (None, Some(other)) => return at(other, Mismatch::Missing { in_left: true }),
            (Some(one), Some(other)) if one.topic() == other.topic() => {
                if let Some(what) = between_messages(left, right, index) {
                    return at(one, what);
                }
            }
            (Some(one), Some(other)) => {
                return if !has(theirs, one.topic()) {
                    at(one, Mismatch::Missing { in_left: false })
                } else if !has(ours, other.topic()) {
                    at(other, Mismatch::Missing { in_left: true })
                } else {
                    at(one, Mismatch::Order)
                };
            }
        }
    }
    None
}

/// The messages of two frames at the same place, which have the same topic.
fn between_messages(left: &RecordedFrame, right: &RecordedFrame, index: usize) -> Option<Mismatch> {
    let (one, other) = (&left.messages()[index], &right.messages()[index]);
    if one.schema() != other.schema() {
        return Some(Mismatch::Schema([one.schema().to_owned(), other.schema().to_owned()]));
    }
    if one.log_time_ns() != other.log_time_ns() {
        return Some(Mismatch::LogTime([one.log_time_ns(), other.log_time_ns()]));
    }
    let (one_bytes, other_bytes) = (one.payload(), other.payload());
    if one_bytes == other_bytes {
        return None;
    }
    let named = match one.topic() {
        channels::STATE => between_states(left, right),
        channels::LOG => between_logs(left, right, index),
        _ => between_fields(one, other),
    };
    Some(named.unwrap_or_else(|| Mismatch::Bytes {
        offset: one_bytes.iter().zip(other_bytes).take_while(|(one, other)| one == other).count(),
    }))
}

fn between_states(left: &RecordedFrame, right: &RecordedFrame) -> Option<Mismatch> {
    let (one, other) = (left.state()?, right.state()?);
    for particle in 0..one.rows().min(other.rows()) {
        for (column, (a, b)) in one.row(particle).iter().zip(other.row(particle)).enumerate() {
            if a.to_bits() != b.to_bits() {
                let column = one.columns()[column].clone();
                return Some(Mismatch::State { particle, column, values: [*a, *b] });
            }
        }
    }
    (one.rows() != other.rows()).then(|| Mismatch::Particles([one.rows(), other.rows()]))
}

fn between_logs(left: &RecordedFrame, right: &RecordedFrame, index: usize) -> Option<Mismatch> {
    let text = |frame: &RecordedFrame| {
        let earlier = frame.messages()[..index].iter();
        let line = earlier.filter(|message| message.topic() == channels::LOG).count();
        frame.log_lines().get(line).map(|line| line.text.clone())
    };
    let (one, other) = (text(left)?, text(right)?);
    (one != other).then_some(Mismatch::Text([one, other]))
}

fn between_fields(one: &RecordedMessage, other: &RecordedMessage) -> Option<Mismatch> {
    let channel = channels::ALL.iter().find(|channel| channel.schema == one.schema())?;
    let (one, other) =
        (read_fields(channel, one.payload())?, read_fields(channel, other.payload())?);
    one.iter().zip(&other).find_map(|(one, other)| between_values(one, other))
}

fn between_values(one: &FieldValues, other: &FieldValues) -> Option<Mismatch> {
    let field = one.name;
    for (index, (a, b)) in one.values.iter().zip(&other.values).enumerate() {
        let equal = match (a, b) {
            (FieldValue::Number(a), FieldValue::Number(b)) => a.to_bits() == b.to_bits(),
            _ => a == b,
        };
        if !equal {
            let index = one.series.then_some(index);
            return Some(Mismatch::Field { field, index, values: [a.clone(), b.clone()] });
        }
    }
    let lengths = [one.values.len(), other.values.len()];
    (lengths[0] != lengths[1]).then_some(Mismatch::Length { field, lengths })
}

impl Difference {
    /// The difference in words, with the names that the two recordings go by.
    #[must_use]
    pub fn describe(&self, left: &str, right: &str) -> String {
        let both = |one: &dyn fmt::Display, other: &dyn fmt::Display| {
            format!("{one} in {left}, {other} in {right}")
        };
        match self {
            Self::Meaning { what, values: [one, other] } => format!(
                "{what}: {}",
                both(&format_args!("\"{one}\""), &format_args!("\"{other}\""))
            ),
            Self::Frames { common, outcomes: [one, other], left_ends } => {
                let (shorter, outcome) = if *left_ends { (left, one) } else { (right, other) };
                format!(
                    "number of frames: {shorter} has only {common} ({}), all of them equal",
                    ending(outcome.as_ref())
                )
            }
            Self::Outcome([one, other]) => {
                format!("outcome: {}", both(&ending(one.as_ref()), &ending(other.as_ref())))
            }
            Self::Message { topic, clock, what } => {
                let unit = if clock.time_unit.is_empty() { "" } else { " " };
                let (frame, time) = (clock.frame, clock.time);
                let place =
                    format!("{topic}, frame {frame} (time {time:?}{unit}{})", clock.time_unit);
                format!("{place}{}", what.describe(left, right))
            }
        }
    }
}

impl Mismatch {
    fn describe(&self, left: &str, right: &str) -> String {
        let both = |one: &dyn fmt::Display, other: &dyn fmt::Display| {
            format!("{one} in {left}, {other} in {right}")
        };
        match self {
            Self::Missing { in_left } => {
                format!(": there is none in {}", if *in_left { left } else { right })
            }
            Self::Order => ": the frame's messages are in another order".to_owned(),
            Self::Schema([one, other]) => format!(": schema {}", both(one, other)),
            Self::LogTime([one, other]) => format!(", log time in ns: {}", both(one, other)),
            Self::Particles([one, other]) => format!(", particles: {}", both(one, other)),
            Self::State { particle, column, values: [one, other] } => {
                let (one, other) = numbers(*one, *other);
                format!(", particle {particle}, {column}: {}", both(&one, &other))
            }
            Self::Length { field, lengths: [one, other] } => {
                format!(", {field}, number of values: {}", both(one, other))
            }
            Self::Field { field, index, values: [one, other] } => {
                let (one, other) = match (one, other) {
                    (FieldValue::Number(one), FieldValue::Number(other)) => numbers(*one, *other),
                    _ => (value(one), value(other)),
                };
                let index = index.map(|index| format!("[{index}]")).unwrap_or_default();
                format!(", {field}{index}: {}", both(&one, &other))
            }
            Self::Text([one, other]) => {
                format!(": {}", both(&format_args!("\"{one}\""), &format_args!("\"{other}\"")))
            }
            Self::Bytes { offset } => format!(": the messages differ from byte {offset} on"),
        }
    }
}

fn value(value: &FieldValue) -> String {
    match value {
        FieldValue::Number(number) => format!("{number:?}"),
        FieldValue::Count(count) => count.to_string(),
        FieldValue::Text(text) => format!("\"{text}\""),
    }
}

/// Two numbers in the shortest texts that give them back, and their bits where these texts are the same (not a number).
fn numbers(one: f64, other: f64) -> (String, String) {
    let plain = (format!("{one:?}"), format!("{other:?}"));
    if plain.0 != plain.1 {
        return plain;
    }
    let with_bits = |number: f64| format!("{number:?} (bits {:#018x})", number.to_bits());
    (with_bits(one), with_bits(other))
}

fn ending(outcome: Option<&Outcome>) -> String {
    match outcome {
        Some(Outcome::Complete) => "complete".to_owned(),
        Some(Outcome::Fault(fault)) => format!("ended in a fault: {fault}"),
        Some(Outcome::Interrupted) => "interrupted".to_owned(),
        None => "no end".to_owned(),
    }
}

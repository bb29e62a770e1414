//! Comparison of two recordings message by message, up to the first difference.

use kinetoscope_console::text::{one_line, shortened};
use kinetoscope_recording::channels::{self, FrameClock};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::fields::{FieldValue, FieldValues, read_fields};
use kinetoscope_recording::paired_frames::PairedFrames;
use kinetoscope_recording::reader::{
    Outcome, RecordedFrame, RecordedMessage, Recording, StoredFrames,
};
use std::collections::BTreeSet;

/// Length up to which a value is shown.
const LONGEST_VALUE: usize = 2000;

/// Result of a comparison frame by frame, which takes the memory of two frames.
#[derive(Debug)]
pub struct Comparison {
    /// Number of equal frames from the start.
    pub equal_frames: u64,
    /// The first difference; one of the log only if no later frame differs elsewhere.
    pub difference: Option<Difference>,
    /// The channels of which messages were not compared, because only one of the recordings keeps all frames.
    pub not_compared: BTreeSet<String>,
    /// The error that ended the comparison before the end of the recordings.
    pub unreadable: Option<ReadError>,
}

/// The first difference between a left and a right recording: its place and what was found there.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    place: String,
    found: Found,
}

#[derive(Clone, Debug, PartialEq)]
enum Found {
    /// The value in each recording.
    Values([String; 2]),
    /// What only one recording has or lacks: a verb and its object.
    OfOne { is_left: bool, what: String },
    /// A difference that has no values.
    Text(String),
}

/// Part of a message that differs, as the end of the place, and what was found there.
type Mismatch = (String, Found);

/// Compares the messages of two recordings, not their bytes. Versions and run keys are not compared. Parts of the files with the
/// same bytes are not decoded. If the recordings store different frames in full, the messages that both have are compared.
///
/// # Errors
/// A file that cannot be opened. Damage after its start ends the comparison and is part of the result.
pub fn compare_messages(left: &Recording, right: &Recording) -> Result<Comparison, ReadError> {
    let pairs = PairedFrames::that_can_differ(left, right)?;
    let comparison = compare_pairs(left, right, pairs);
    if comparison.unreadable.is_none() {
        return Ok(comparison);
    }
    // Damage that both files share is reported where it is.
    Ok(compare_pairs(left, right, PairedFrames::all(left, right)?))
}

fn compare_pairs(left: &Recording, right: &Recording, mut pairs: PairedFrames) -> Comparison {
    let mut comparison = Comparison {
        equal_frames: 0,
        difference: between_headers(left, right),
        not_compared: BTreeSet::new(),
        unreadable: None,
    };
    let has_same_frames = left.provenance().stored == right.provenance().stored;
    let mut in_log = None;
    while comparison.difference.is_none() {
        let pair = match pairs.advance() {
            Ok(pair) => pair,
            Err(error) => {
                comparison.unreadable = Some(error);
                break;
            }
        };
        match pair {
            [Some(one), Some(other)] => {
                let before = left.provenance().stored.count_before(one.clock.frame);
                let difference = if has_same_frames {
                    between_frames(&one, &other)
                } else {
                    between_common_messages(&one, &other, &mut comparison.not_compared)
                };
                if in_log.is_none() {
                    let is_equal = difference.is_none() && one.is_complete();
                    comparison.equal_frames = before + u64::from(is_equal);
                }
                match difference {
                    Some(of_log) if of_log.is_in_log() => _ = in_log.get_or_insert(of_log),
                    elsewhere => comparison.difference = elsewhere,
                }
            }
            [_, _] if in_log.is_some() => break,
            [None, None] => {
                match between_ends(left, right) {
                    Ok(difference) => comparison.difference = difference,
                    Err(error) => comparison.unreadable = Some(error),
                }
                break;
            }
            [rest, _] => {
                let is_left = rest.is_none();
                let (frames, outcome) =
                    (comparison.equal_frames, outcome(if is_left { left } else { right }));
                let what = format!("has only {frames} ({outcome}), all of them equal");
                let found = Found::OfOne { is_left, what };
                comparison.difference =
                    Some(Difference { place: "number of frames".to_owned(), found });
            }
        }
    }
    comparison.difference = comparison.difference.or(in_log);
    comparison
}

/// Compares the properties that give the messages their meaning.
fn between_headers(left: &Recording, right: &Recording) -> Option<Difference> {
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
    let mut pairs = entries(left).into_iter().zip(entries(right));
    pairs.find(|(one, other)| one != other).map(|((place, one), (_, other))| Difference {
        place: place.to_owned(),
        found: values(quoted(&one), quoted(&other)),
    })
}

/// Compares what follows the last frame: the outcome, and the hashes of the frames after the last keyframe of a run that failed.
fn between_ends(left: &Recording, right: &Recording) -> Result<Option<Difference>, ReadError> {
    let [one, other] = [left, right].map(outcome);
    if one != other {
        return Ok(Some(Difference { place: "outcome".to_owned(), found: values(one, other) }));
    }
    if !matches!(left.provenance().outcome, Some(Outcome::Fault(_)))
        || remaining_hashes(left)? == remaining_hashes(right)?
    {
        return Ok(None);
    }
    let place = "frames after the last keyframe".to_owned();
    Ok(Some(Difference { place, found: Found::Text("their hashes differ".to_owned()) }))
}

/// The hashes of the frames that are not stored after the last keyframe.
fn remaining_hashes(recording: &Recording) -> Result<Vec<u8>, ReadError> {
    if !matches!(recording.provenance().stored, StoredFrames::Keyframes(_)) {
        return Ok(Vec::new());
    }
    let mut frames = recording.frames()?;
    frames.by_ref().try_for_each(|frame| frame.map(drop))?;
    Ok(frames.remaining_hashes().to_vec())
}

fn between_frames(left: &RecordedFrame, right: &RecordedFrame) -> Option<Difference> {
    let (ours, theirs) = (left.messages(), right.messages());
    let at = |message: &RecordedMessage, mismatch: Mismatch| {
        Some(difference_at(&left.clock, message.topic(), mismatch))
    };
    let missing =
        |is_left| (String::new(), Found::OfOne { is_left, what: "has no such message".to_owned() });
    let has = |messages: &[RecordedMessage], topic| {
        messages.iter().any(|message| message.topic() == topic)
    };
    // The state explains more than what follows from it, and the log less.
    let common = 0..ours.len().min(theirs.len());
    let in_state = common.clone().filter(|&index| ours[index].topic() == channels::STATE);
    let in_others =
        common.filter(|&index| !matches!(ours[index].topic(), channels::STATE | channels::LOG));
    for index in in_state.chain(in_others) {
        if ours[index].topic() == theirs[index].topic()
            && let Some(mismatch) = between_messages(left, right, [index; 2])
        {
            return at(&ours[index], mismatch);
        }
    }
    for index in 0..ours.len().max(theirs.len()) {
        match (ours.get(index), theirs.get(index)) {
            (Some(one), Some(other)) if one.topic() == other.topic() => {
                if let Some(mismatch) = between_messages(left, right, [index; 2]) {
                    return at(one, mismatch);
                }
            }
            (Some(one), other) if other.is_none() || !has(theirs, one.topic()) => {
                return at(one, missing(false));
            }
            (one, Some(other)) if one.is_none() || !has(ours, other.topic()) => {
                return at(other, missing(true));
            }
            (one, _) => {
                let order =
                    Found::Text("the messages of the frame are in another order".to_owned());
                return at(one?, (String::new(), order));
            }
        }
    }
    None
}

/// Compares the messages that two frames have in common, of which one may be without its state. Adds the channels of all others, and the
/// log, which states what is stored.
fn between_common_messages(
    left: &RecordedFrame,
    right: &RecordedFrame,
    not_compared: &mut BTreeSet<String>,
) -> Option<Difference> {
    let place = |frame: &RecordedFrame, topic: &str| {
        frame.messages().iter().position(|message| message.topic() == topic)
    };
    let messages = left.messages().iter().chain(right.messages());
    let topics: BTreeSet<&str> = messages.map(RecordedMessage::topic).collect();
    // The state explains more than what follows from it.
    let (state, others): (Vec<_>, Vec<_>) =
        topics.into_iter().partition(|topic| *topic == channels::STATE);
    for topic in state.into_iter().chain(others) {
        match (place(left, topic), place(right, topic)) {
            (Some(one), Some(other)) if topic != channels::LOG => {
                if let Some(mismatch) = between_messages(left, right, [one, other]) {
                    return Some(difference_at(&left.clock, topic, mismatch));
                }
            }
            _ => {
                not_compared.insert(topic.to_owned());
            }
        }
    }
    None
}

fn difference_at(clock: &FrameClock, topic: &str, (part, found): Mismatch) -> Difference {
    let FrameClock { frame, time, time_unit, .. } = clock;
    let space = if time_unit.is_empty() { "" } else { " " };
    let place = format!("{topic}, frame {frame} (time {time:?}{space}{time_unit}){part}");
    Difference { place, found }
}

/// Two messages of the same topic, at their indices in their frames.
fn between_messages(
    left: &RecordedFrame,
    right: &RecordedFrame,
    index: [usize; 2],
) -> Option<Mismatch> {
    let (one, other) = (&left.messages()[index[0]], &right.messages()[index[1]]);
    if one.schema() != other.schema() {
        return Some((", schema".to_owned(), values(one.schema(), other.schema())));
    }
    if one.log_time_ns() != other.log_time_ns() {
        let times = values(one.log_time_ns(), other.log_time_ns());
        return Some((", log time in ns".to_owned(), times));
    }
    let (one_bytes, other_bytes) = (one.payload(), other.payload());
    if one_bytes == other_bytes {
        return None;
    }
    let named = match one.topic() {
        channels::PARTICLES | channels::STATE => between_states(left, right),
        channels::LOG => between_logs(left, right, index[0]),
        _ => between_fields(one, other),
    };
    Some(named.unwrap_or_else(|| {
        let mut pairs = one_bytes.iter().zip(other_bytes);
        let equal = pairs.position(|(one, other)| one != other);
        let offset = equal.unwrap_or(one_bytes.len().min(other_bytes.len()));
        (String::new(), Found::Text(format!("the messages differ from byte {offset} on")))
    }))
}

fn between_states(left: &RecordedFrame, right: &RecordedFrame) -> Option<Mismatch> {
    let (one, other) = (left.state()?, right.state()?);
    for particle in 0..one.rows().min(other.rows()) {
        for (column, (a, b)) in one.row(particle).iter().zip(other.row(particle)).enumerate() {
            if a.to_bits() != b.to_bits() {
                let part = format!(", particle {particle}, {}", one.columns()[column]);
                return Some((part, numbers(*a, *b)));
            }
        }
    }
    let (one, other) = (one.rows(), other.rows());
    (one != other).then(|| (", particles".to_owned(), values(one, other)))
}

fn between_logs(left: &RecordedFrame, right: &RecordedFrame, index: usize) -> Option<Mismatch> {
    let text = |frame: &RecordedFrame| {
        let earlier = frame.messages()[..index].iter();
        let line = earlier.filter(|message| message.topic() == channels::LOG).count();
        frame.log_lines().get(line).map(|line| line.text.clone())
    };
    let (one, other) = (text(left)?, text(right)?);
    (one != other).then(|| (String::new(), values(quoted(&one), quoted(&other))))
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
            let index = if one.series { format!("[{index}]") } else { String::new() };
            let found = match (a, b) {
                (FieldValue::Number(a), FieldValue::Number(b)) => numbers(*a, *b),
                _ => values(text_of(a), text_of(b)),
            };
            return Some((format!(", {field}{index}"), found));
        }
    }
    let (one, other) = (one.values.len(), other.values.len());
    (one != other).then(|| (format!(", {field}, number of values"), values(one, other)))
}

impl Difference {
    /// Whether only the log differs in its frame.
    fn is_in_log(&self) -> bool {
        self.place.split(',').next() == Some(channels::LOG)
    }

    /// Describes the difference in one line, with the given names of the two recordings.
    #[must_use]
    pub fn describe(&self, left: &str, right: &str) -> String {
        one_line(&self.text(left, right)).into_owned()
    }

    fn text(&self, left: &str, right: &str) -> String {
        let place = &self.place;
        match &self.found {
            Found::Values(both) => {
                let [one, other] = both.each_ref().map(|value| shortened(value, LONGEST_VALUE));
                format!("{place}: {one} in {left}, {other} in {right}")
            }
            Found::OfOne { is_left, what } => {
                format!("{place}: {} {what}", if *is_left { left } else { right })
            }
            Found::Text(text) => format!("{place}: {text}"),
        }
    }
}

fn values(one: impl ToString, other: impl ToString) -> Found {
    Found::Values([one.to_string(), other.to_string()])
}

/// Two numbers in their shortest exact texts, with their bits where these texts are equal (NaN).
fn numbers(one: f64, other: f64) -> Found {
    let (plain, other_plain) = (format!("{one:?}"), format!("{other:?}"));
    if plain != other_plain {
        return values(plain, other_plain);
    }
    let with_bits = |number: f64| format!("{number:?} (bits {:#018x})", number.to_bits());
    values(with_bits(one), with_bits(other))
}

fn text_of(value: &FieldValue) -> String {
    match value {
        FieldValue::Number(number) => format!("{number:?}"),
        FieldValue::Count(count) => count.to_string(),
        FieldValue::Text(text) => quoted(text),
    }
}

fn quoted(text: &str) -> String {
    format!("\"{text}\"")
}

fn outcome(recording: &Recording) -> String {
    match &recording.provenance().outcome {
        Some(Outcome::Complete) => "complete".to_owned(),
        Some(Outcome::Fault(fault)) => format!("failed: {fault}"),
        Some(Outcome::Interrupted) => "interrupted".to_owned(),
        None => "unfinished".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guarantee: what a recording contains is one line of bounded length. Control: a short value is whole.
    #[test]
    fn difference_is_one_short_line() {
        let describe = |one: &str| {
            let found = values(one, "complete");
            Difference { place: "outcome".to_owned(), found }.describe("the file", "the rerun")
        };
        assert_eq!(describe("a\nb"), "outcome: a\\nb in the file, complete in the rerun");
        assert!(describe(&"x".repeat(100_000)).len() < 2100);
    }
}

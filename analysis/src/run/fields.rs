//! Fields of recorded channels over time, for the plots that a manifest or a command line requests.

use crate::models::series::Series;
use kinetoscope_recording::channels;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::fields::{FieldValue, read_fields};
use kinetoscope_recording::reader::{RecordedFrame, RecordedMessage, Recording};
use serde::{Deserialize, Serialize};

/// A field of a channel over time, thinned to a bounded number of frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RecordedField {
    /// The field's name, such as `/energy.kinetic_j`.
    pub(crate) name: String,
    /// Time and value per frame; the value may be NaN.
    pub(crate) points: Vec<(f64, f64)>,
}

/// Collects fields from the frames of a run.
#[derive(Debug)]
pub(crate) struct FieldCollector(Vec<(String, Series<(f64, f64)>)>);

impl FieldCollector {
    /// A collector of the fields with these names.
    pub(crate) fn new(names: &[String]) -> Self {
        Self(names.iter().map(|name| (name.clone(), Series::default())).collect())
    }

    /// Takes in the next frame.
    pub(crate) fn observe(&mut self, frame: &RecordedFrame) {
        for (name, series) in &mut self.0 {
            let Some((topic, field)) = name.split_once('.') else { continue };
            let mut messages = frame.messages().iter().filter(|message| message.topic() == topic);
            let value = messages.find_map(|message| {
                let mut fields = numbers(message);
                fields.find_map(|(name, value)| (name == field).then_some(value))
            });
            if let Some(value) = value {
                series.add((frame.clock.time, value));
            }
        }
    }

    /// The fields that occurred, in the order of their names in [`Self::new`]; those that did not have no points.
    pub(crate) fn finish(self) -> Vec<RecordedField> {
        let field = |(name, series): (String, Series<(f64, f64)>)| RecordedField {
            name,
            points: series.iter().copied().collect(),
        };
        self.0.into_iter().map(field).collect()
    }
}

/// The fields of a message that are one number per frame.
fn numbers(message: &RecordedMessage) -> impl Iterator<Item = (&'static str, f64)> {
    let declared = channels::ALL
        .iter()
        .find(|channel| channel.topic == message.topic() && channel.schema == message.schema());
    let fields = declared.and_then(|channel| read_fields(channel, message.payload()));
    fields.unwrap_or_default().into_iter().filter(|field| !field.series).filter_map(|field| {
        match field.values.first()? {
            FieldValue::Number(number) => Some((field.name, *number)),
            // Counts above 2^53 are rounded, which no plot shows.
            FieldValue::Count(count) => Some((field.name, *count as f64)),
            FieldValue::Text(_) => None,
        }
    })
}

/// Number of frames that are searched for names: every channel with fields is in each of them.
const SEARCHED_FRAMES: usize = 2;

/// The names of all fields of a recording that are one number per frame.
///
/// # Errors
/// A recording whose first frame cannot be read.
pub(crate) fn names(recording: &Recording) -> Result<Vec<String>, ReadError> {
    let mut found = Vec::new();
    for frame in recording.frames()?.with_scalar_frames().take(SEARCHED_FRAMES) {
        let frame = match frame {
            Ok(frame) => frame,
            Err(_) if !found.is_empty() => break,
            Err(error) => return Err(error),
        };
        for message in frame.messages() {
            for (field, _) in numbers(message) {
                let name = format!("{}.{field}", message.topic());
                if !found.contains(&name) {
                    found.push(name);
                }
            }
        }
    }
    Ok(found)
}

//! Provenance and outcome of a recording: two metadata records, defined once for writer and reader.

use crate::channels::SCHEMA_VERSION;
use crate::limits::MAX_STATE_COLUMNS;
use crate::stored_frames::StoredFrames;
use kinetoscope_console::text::shortened;
use std::collections::BTreeMap;

/// The writer that the file's first record names.
pub(crate) const LIBRARY: &str = "kinetoscope";
/// Name of the attachment that holds the canonical manifest.
pub const MANIFEST_ATTACHMENT: &str = "manifest.toml";
/// Name of the metadata record at the start.
pub(crate) const PROVENANCE_RECORD: &str = "kinetoscope";
/// Name of the metadata record at the end.
pub(crate) const OUTCOME_RECORD: &str = "kinetoscope.outcome";
/// Name of the metadata records with the hashes after the last keyframe of a run that failed.
pub(crate) const HASHES_RECORD: &str = "kinetoscope.hashes";
/// Name of the metadata record at the start of a recording of several runs.
pub(crate) const MERGED_RECORD: &str = "kinetoscope.merged";
/// Maximum length of the name of a column, and of a unit.
const MAX_NAME_BYTES: usize = 64;
/// Length up to which the reason of a failure is shown.
const MAX_DETAIL_CHARACTERS: usize = 4000;

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The run reached its end.
    Complete,
    /// The simulation failed, for this reason.
    Fault(String),
    /// The run was interrupted in order and can resume.
    Interrupted,
}

impl Outcome {
    pub(crate) fn to_metadata(&self) -> BTreeMap<String, String> {
        let (outcome, detail) = match self {
            Self::Complete => ("complete", ""),
            Self::Fault(detail) => ("fault", detail.as_str()),
            Self::Interrupted => ("interrupted", ""),
        };
        BTreeMap::from([
            ("outcome".to_owned(), outcome.to_owned()),
            ("outcome_detail".to_owned(), detail.to_owned()),
        ])
    }

    pub(crate) fn from_metadata(metadata: &BTreeMap<String, String>) -> Option<Self> {
        match metadata.get("outcome")?.as_str() {
            "complete" => Some(Self::Complete),
            "fault" => {
                let detail = metadata.get("outcome_detail")?;
                Some(Self::Fault(shortened(detail, MAX_DETAIL_CHARACTERS).into_owned()))
            }
            "interrupted" => Some(Self::Interrupted),
            _ => None,
        }
    }
}

/// Origin of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Provenance {
    /// Version of the program.
    pub program_version: String,
    /// Name of the model.
    pub model: String,
    /// Version of the model's physics.
    pub physics_version: u32,
    /// Version of the recording's layout.
    pub schema_version: u32,
    /// The run key.
    pub run_key: String,
    /// "s", "d", or "" for dimensionless time.
    pub time_unit: String,
    /// Frames per second of playback.
    pub playback_fps: f64,
    /// Names of the state's columns.
    pub state_columns: Vec<String>,
    /// Units of the state's columns; empty for dimensionless ones.
    pub state_units: Vec<String>,
    /// Which frames of the run the file holds.
    pub stored: StoredFrames,
    /// How the run ended; `None` for a recording without its end.
    pub outcome: Option<Outcome>,
}

impl Provenance {
    pub(crate) fn to_metadata(&self) -> BTreeMap<String, String> {
        let mut entries = BTreeMap::from([
            ("program".to_owned(), PROVENANCE_RECORD.to_owned()),
            ("program_version".to_owned(), self.program_version.clone()),
            ("model".to_owned(), self.model.clone()),
            ("physics_version".to_owned(), self.physics_version.to_string()),
            ("schema_version".to_owned(), self.schema_version.to_string()),
            ("run_key".to_owned(), self.run_key.clone()),
            ("time_unit".to_owned(), self.time_unit.clone()),
            ("playback_fps".to_owned(), self.playback_fps.to_string()),
            ("state_columns".to_owned(), self.state_columns.join(",")),
            ("state_units".to_owned(), self.state_units.join(",")),
        ]);
        let stored = self.stored.to_text();
        entries.extend(stored.map(|stored| ("stored_frames".to_owned(), stored)));
        entries
    }

    /// Decodes the record; `None` if a value is missing or is not a number. For another schema version, only the version is
    /// required, because its other values may have other names.
    pub(crate) fn from_metadata(metadata: &BTreeMap<String, String>) -> Option<Self> {
        let schema_version = metadata.get("schema_version")?.parse().ok()?;
        let is_current = schema_version == SCHEMA_VERSION;
        let text = |key: &str| match metadata.get(key) {
            None if !is_current => Some(String::new()),
            value => value.cloned(),
        };
        Some(Self {
            program_version: text("program_version")?,
            model: text("model")?,
            physics_version: metadata.get("physics_version")?.parse().ok()?,
            schema_version,
            run_key: text("run_key")?,
            time_unit: text("time_unit")?,
            playback_fps: match text("playback_fps")?.parse() {
                Err(_) if !is_current => 1.0,
                parsed => parsed.ok()?,
            },
            state_columns: words(&text("state_columns")?),
            state_units: words(&text("state_units")?),
            stored: StoredFrames::from_text(metadata.get("stored_frames").map(String::as_str))?,
            outcome: None,
        })
    }
}

impl Provenance {
    /// What contradicts the form of every recording in its names, its playback, and the columns and units of the state, which become
    /// headers of tables, labels of plots and parts of scripts.
    pub(crate) fn defect(&self) -> Option<String> {
        let texts = [
            ("program version", &self.program_version),
            ("model", &self.model),
            ("run key", &self.run_key),
        ];
        if let Some((what, _)) = texts.iter().find(|(_, text)| text.len() > MAX_NAME_BYTES) {
            return Some(format!("the {what} has more than {MAX_NAME_BYTES} bytes"));
        }
        let (columns, units) = (self.state_columns.len(), self.state_units.len());
        if columns > MAX_STATE_COLUMNS {
            return Some(format!(
                "the state has {columns} columns, at most {MAX_STATE_COLUMNS} are possible"
            ));
        }
        if columns != units {
            return Some(format!("the state has {columns} columns and {units} units"));
        }
        let has_form = |text: &str, others: &str| {
            text.len() <= MAX_NAME_BYTES
                && text.chars().all(|part| part.is_ascii_alphanumeric() || others.contains(part))
        };
        let is_unit = |unit: &str| has_form(unit, "/^*.-");
        for (index, (name, unit)) in self.state_columns.iter().zip(&self.state_units).enumerate() {
            if name.is_empty() || !has_form(name, "_") {
                return Some(format!("column {index} of the state has a name of other characters"));
            }
            if self.state_columns[..index].contains(name) {
                return Some(format!("the state has two columns {name}"));
            }
            if !is_unit(unit) {
                return Some(format!("the unit of the column {name} is not a unit"));
            }
        }
        if !is_unit(&self.time_unit) {
            return Some("the unit of time is not a unit".to_owned());
        }
        let is_rate = self.playback_fps.is_finite() && self.playback_fps > 0.0;
        (!is_rate).then(|| format!("playback of {:?} frames per second", self.playback_fps))
    }
}

fn words(list: &str) -> Vec<String> {
    list.split(',').map(str::to_owned).collect()
}

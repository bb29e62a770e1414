//! `start_from`: a run that begins where the run of a recording ended.

use crate::diagnostics::Errors;
use crate::keys::{Key, Keys};
use crate::tree::{Node, Value};
use crate::value::{TomlValue, quoted, refuse_type};
use serde_json::{Value as Json, json};
use sha2::{Digest, Sha256};
use std::sync::Arc;

/// The recording that a run begins with.
#[derive(Clone, Debug)]
pub enum StartFrom {
    /// Only its name: a path as written in a manifest, or its identity in a canonical manifest, see
    /// [`RecordedState::identity`].
    Named(String),
    /// Its last state.
    Read(Arc<RecordedState>),
}

/// A function that finds recordings: returns the last state of the recording of a name, or the reason why there is none, as
/// the label below the name.
pub type Recordings<'a> = &'a dyn Fn(&str) -> Result<Arc<RecordedState>, String>;

/// The state of all particles in a recording's last frame.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedState {
    model: String,
    columns: Vec<String>,
    values: Vec<f64>,
    identity: String,
}

impl RecordedState {
    /// Creates a state from its columns' names and its values, row by row, as recorded by the run of this model with this
    /// run key.
    ///
    /// # Errors
    /// A state without particles, or with a value that is not a number.
    pub fn new(
        model: &str,
        run_key: &str,
        columns: Vec<String>,
        values: Vec<f64>,
    ) -> Result<Self, String> {
        if values.is_empty() || columns.is_empty() || !values.len().is_multiple_of(columns.len()) {
            return Err("its last frame has no particles".to_owned());
        }
        if values.iter().any(|value| !value.is_finite()) {
            return Err("a value of its last frame is not a number".to_owned());
        }
        let mut hash = Sha256::new();
        // One column per line, so that no two lists give the same bytes.
        hash.update(format!("{model}\n{}\n\n", columns.join("\n")));
        for value in &values {
            hash.update(value.to_le_bytes());
        }
        let digest: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        let identity = format!("content-key:{run_key} state:{digest}");
        Ok(Self { model: model.to_owned(), columns, values, identity })
    }

    /// The recording's identity in a canonical manifest, and so in the run key of a run that begins with it: the
    /// recording's own run key, and the SHA-256 of the state that is taken over. No path.
    #[must_use]
    pub fn identity(&self) -> &str {
        &self.identity
    }

    /// The run key in an [`RecordedState::identity`]; `None` if the text is not an identity.
    #[must_use]
    pub fn run_key_of(identity: &str) -> Option<&str> {
        let (key, _) = identity.strip_prefix("content-key:")?.split_once(" state:")?;
        Some(key)
    }

    /// Number of particles.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.len() / self.columns.len()
    }

    /// Some columns of all particles, in the order of the names; `None` if one is missing.
    #[must_use]
    pub fn columns<const N: usize>(&self, names: [&str; N]) -> Option<Vec<[f64; N]>> {
        let mut places = [0; N];
        for (place, name) in places.iter_mut().zip(names) {
            *place = self.columns.iter().position(|column| column == name)?;
        }
        let rows = self.values.chunks_exact(self.columns.len());
        Some(rows.map(|row| places.map(|place| row[place])).collect())
    }
}

impl StartFrom {
    /// Its text in a manifest: a path until the recording is read.
    fn text(&self) -> &str {
        match self {
            Self::Named(name) => name,
            Self::Read(state) => state.identity(),
        }
    }

    /// Reads the recording of a name.
    pub(super) fn read_by(
        &mut self,
        recordings: Recordings<'_>,
        model: &str,
    ) -> Result<(), String> {
        if let Self::Named(name) = self {
            let state = recordings(name)?;
            if state.model != model {
                return Err(format!("this is a recording of model {}, not {model}", state.model));
            }
            *self = Self::Read(state);
        }
        Ok(())
    }

    /// Number of particles; `None` for a name.
    pub(super) fn particles(&self) -> Option<usize> {
        match self {
            Self::Named(_) => None,
            Self::Read(state) => Some(state.rows()),
        }
    }
}

/// Starts with equal texts are equal: the text of one that was read contains the hash of its values.
impl PartialEq for StartFrom {
    fn eq(&self, other: &Self) -> bool {
        self.text() == other.text()
    }
}

/// A start that may be a recording. The macro `starts` implements it.
pub(crate) trait MayBeRecorded: TomlValue {
    /// The start from this recording.
    fn from_recorded(start: StartFrom) -> Self;
    /// The recording, if the start is one.
    fn recorded(&self) -> Option<&StartFrom>;
    /// The same, to be read.
    fn recorded_mut(&mut self) -> Option<&mut StartFrom>;
}

const START_FROM: Key = Key {
    name: "start_from",
    unit: "",
    about: "A recording whose last frame is the start, or the manifest of an experiment with one run, which runs first if its \
        recording is missing. The path is relative to the manifest's folder. Time and counts \
        begin at zero, and random streams with the run's own seed.",
};

/// Visits the key of a start and `start_from`. At most one of the keys `exclusive` may be present.
pub(crate) fn visit<S: MayBeRecorded>(
    start: &mut S,
    key: &Key,
    exclusive: &'static [&'static str],
    keys: &mut impl Keys,
) {
    let recorded = start.recorded().cloned();
    if recorded.is_none() {
        keys.key(key, start);
    }
    if let Some(recorded) = keys.optional(&START_FROM, recorded) {
        *start = S::from_recorded(recorded);
    }
    keys.exclusive(exclusive);
}

impl TomlValue for StartFrom {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
        match &node.value {
            Value::Text(text) if !text.is_empty() => Some(Self::Named(text.clone())),
            _ => refuse_type(node, name, "the path of a recording", errors),
        }
    }

    fn write(&self) -> String {
        quoted(self.text())
    }

    fn schema() -> Json {
        json!({ "type": "string", "minLength": 1 })
    }
}

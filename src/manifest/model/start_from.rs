//! `start_from`: a run that begins where the run of a recording ended.

use super::{OrbitStart, PackingPlacement, Placement};
use crate::diagnostics::Diagnostic;
use crate::keys::{Keys, Reader};
use crate::tree::{Node, Value};
use crate::value::{TomlValue, quoted, refuse};
use serde_json::{Value as Json, json};
use sha2::{Digest, Sha256};
use std::num::NonZeroU32;
use std::sync::Arc;

/// The recording that a run begins with.
#[derive(Clone, Debug)]
pub enum StartFrom {
    /// Its name alone: a path as a manifest writes it, or what a canonical manifest has in its place, see
    /// [`RecordedState::identity`].
    Named(String),
    /// Its last state.
    Read(Arc<RecordedState>),
}

/// Where recordings are found: gives the last state of the recording of a name, or says why there is none, in words that
/// stand below the name.
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
    /// A state of so many columns, row by row, recorded by the run of this model with this content key.
    ///
    /// # Errors
    /// What is wrong with the state: no particle, or a value that is no number.
    pub fn new(
        model: &str,
        content_key: &str,
        columns: Vec<String>,
        values: Vec<f64>,
    ) -> Result<Self, String> {
        if values.is_empty() || columns.is_empty() || !values.len().is_multiple_of(columns.len()) {
            return Err("its last frame has no particles".to_owned());
        }
        if values.iter().any(|value| !value.is_finite()) {
            return Err("a value of its last frame is no number".to_owned());
        }
        let mut hash = Sha256::new();
        // One column a line, so that no two lists run into the same bytes.
        hash.update(format!("{model}\n{}\n\n", columns.join("\n")));
        for value in &values {
            hash.update(value.to_le_bytes());
        }
        let digest: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        let identity = format!("content-key:{content_key} state:{digest}");
        Ok(Self { model: model.to_owned(), columns, values, identity })
    }

    /// What stands for the recording in a canonical manifest, and so in the content key of a run that begins with it: the
    /// recording's own content key, and the SHA-256 of the state that is taken over. No path.
    #[must_use]
    pub fn identity(&self) -> &str {
        &self.identity
    }

    /// The content key in an [`RecordedState::identity`]; `None` where the text is none.
    #[must_use]
    pub fn content_key_of(identity: &str) -> Option<&str> {
        let (key, _) = identity.strip_prefix("content-key:")?.split_once(" state:")?;
        Some(key)
    }

    /// Number of particles.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.len() / self.columns.len()
    }

    /// Some columns of all particles, in the order of the names; `None` where one is missing.
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
    /// The text that stands for it: a path only as long as the recording was not looked for.
    fn text(&self) -> &str {
        match self {
            Self::Named(name) => name,
            Self::Read(state) => state.identity(),
        }
    }

    /// Looks for the recording of a name.
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

    /// Number of particles; `None` of a name.
    pub(super) fn particles(&self) -> Option<usize> {
        match self {
            Self::Named(_) => None,
            Self::Read(state) => Some(state.rows()),
        }
    }

    /// The number of particles, which the key `counter` may repeat but not contradict.
    pub(super) fn count(
        &self,
        table: &mut Reader<'_>,
        counter: &str,
        stated: NonZeroU32,
    ) -> NonZeroU32 {
        let Some(particles) = self.particles() else { return stated };
        let recorded = u32::try_from(particles).ok().and_then(NonZeroU32::new);
        if table.has(counter) && recorded != Some(stated) {
            let title = format!("`{counter}` is {stated}, but the recording ends with {particles}");
            let label = format!("must be {particles}, or be left out");
            table.refuse(&["start_from", counter], &title, &label);
        }
        recorded.unwrap_or(stated)
    }
}

/// Equal texts, equal starts: the text of one that was read holds the hash of its values.
impl PartialEq for StartFrom {
    fn eq(&self, other: &Self) -> bool {
        self.text() == other.text()
    }
}

/// A start of which a recording is one kind.
pub(super) trait MayBeRecorded: TomlValue + From<StartFrom> {
    /// The recording, where it is one.
    fn recorded(&self) -> Option<&StartFrom>;
    /// The same, to be looked for.
    fn recorded_mut(&mut self) -> Option<&mut StartFrom>;
}

macro_rules! may_be_recorded {
    ($($start:ident),*) => {$(
        impl From<StartFrom> for $start {
            fn from(start: StartFrom) -> Self {
                Self::Recorded(start)
            }
        }

        impl MayBeRecorded for $start {
            fn recorded(&self) -> Option<&StartFrom> {
                match self {
                    Self::Recorded(start) => Some(start),
                    _ => None,
                }
            }

            fn recorded_mut(&mut self) -> Option<&mut StartFrom> {
                match self {
                    Self::Recorded(start) => Some(start),
                    _ => None,
                }
            }
        }
    )*};
}
may_be_recorded!(Placement, PackingPlacement, OrbitStart);

/// The key of a start, and `start_from` in its place.
pub(super) fn start_keys<T: MayBeRecorded>(
    name: &'static str,
    about: &'static str,
    exclusive: &'static [&'static str],
    start: &mut T,
    keys: &mut impl Keys,
) {
    let recorded = start.recorded().cloned();
    if recorded.is_none() {
        keys.key(name, "", about, start);
    }
    if let Some(recorded) = keys.optional(
        "start_from",
        "",
        "A recording whose last frame is the start, or the manifest of an experiment with one run, which runs first if its \
        recording is missing. The path is relative to the manifest's folder. Time and counts begin \
        at zero, and random streams with the run's own seed.",
        recorded,
    ) {
        *start = recorded.into();
    }
    keys.exclusive(exclusive);
}

impl TomlValue for StartFrom {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        match &node.value {
            Value::Text(text) if !text.is_empty() => Some(Self::Named(text.clone())),
            _ => {
                refuse(node, name, "the path of a recording", errors);
                None
            }
        }
    }

    fn write(&self) -> String {
        quoted(self.text())
    }

    fn schema() -> Json {
        json!({ "type": "string", "minLength": 1 })
    }
}

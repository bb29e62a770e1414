//! What differs from an entry of a lock file.

use crate::locking::moved::{Movement, lines as lines_of};
use kinetoscope_analysis::CheckedExperiment;
use kinetoscope_console::text::one_line;

/// What differs from an entry.
#[derive(Default)]
pub(crate) struct Findings {
    /// The keys that changed, or the first difference.
    pub(crate) lines: Vec<String>,
    /// The checked metrics that moved.
    pub(crate) movements: Vec<Movement>,
    /// The experiment as it is now.
    pub(crate) checked: CheckedExperiment,
}

impl Findings {
    /// All findings as text, without line breaks.
    pub(crate) fn text(&self) -> Vec<String> {
        let lines = self.lines.iter().map(|line| one_line(line).into_owned());
        let none = self.has_no_movement().then(|| "no checked metric moved".to_owned());
        lines.chain(lines_of(&self.movements)).chain(none).collect()
    }

    /// Whether metrics were compared, and none moved: a manifest that no longer exists, or was not run, has none.
    pub(crate) fn has_no_movement(&self) -> bool {
        self.movements.is_empty() && !self.checked.values.is_empty()
    }
}

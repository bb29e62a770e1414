//! The keys of a manifest before its first table.

use crate::answer::AnswerTemplate;
use crate::keys::Reader;
use crate::sentence::Question;
use crate::table::table;
use crate::value::{ReplicateCount, words};

words! {
    /// How the runs of an experiment are expected to end.
    pub enum ExpectedOutcome {
        /// They reach their end.
        Complete = "complete",
        /// They fail, as a numerical blow-up does.
        Fault = "fault",
    }
}

table! {
    /// The keys before the first table.
    pub(crate) struct Head at most one of [replicates, replicate] {
        /// Name of the experiment and of its folder, [A-Za-z0-9_][A-Za-z0-9_-]*; by default the file's stem.
        name: Option<String> ["", optional],
        /// What the experiment asks, in a sentence that ends with a question mark; by default the first comment up to "Expected:", if that
        /// is a question.
        question: Option<Question> ["", optional],
        /// The sentence that answers the question, with numbers from metrics: `"The heap has {bed.surface_angle @ friction = 0.5}."`
        /// The words `theory`, `size` (without the sign), `in percent` and `to 6 digits` after the metric set the form of the number. By
        /// default, the answer follows from the checks.
        answer: Option<AnswerTemplate> ["", optional],
        /// What is run, in a sentence.
        description: Option<String> ["", optional],
        /// Seed of all random streams.
        seed: u64 ["1"] = 0,
        /// Number of runs at each point of the sweep, each with its own random streams; by default 1.
        replicates: Option<ReplicateCount> ["1", optional],
        /// How the runs are expected to end; by default complete. fault: a run that completes is a failure.
        expected_outcome: Option<ExpectedOutcome> ["", optional],
        /// In place of `replicates`: only this one, counted from 0.
        replicate: Option<u32> ["1", optional],
    }
}

impl Head {
    /// The head of a canonical manifest: without a name and a description, which do not affect the run.
    pub(crate) fn of_run(seed: u64, replicate: u32) -> Self {
        Self { seed, replicate: Some(replicate), ..Self::default() }
    }

    /// Reports a name that cannot name a folder.
    pub(crate) fn check(&self, table: &mut Reader<'_>) {
        if let Some(name) = self.name.as_ref().filter(|name| !is_name(name)) {
            let title = format!("`name` is {name:?}; must be {NAME_RULE}");
            table.refuse(&["name"], &title, "it names a folder");
        }
    }

    /// The numbers of the replicates to run.
    pub(crate) fn replicate_numbers(&self) -> std::ops::Range<u32> {
        match (self.replicate, self.replicates) {
            (Some(number), _) => number..number.saturating_add(1),
            (None, Some(count)) => 0..count.get(),
            (None, None) => 0..1,
        }
    }
}

/// What can name an experiment.
pub(crate) const NAME_RULE: &str = "1 to 80 letters, digits, _ and -, without - at the start, and no device of Windows such as CON";

/// Whether a text can name an experiment and its folder: on every system, and as an argument of any command.
pub(crate) fn is_name(name: &str) -> bool {
    let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    (1..=80).contains(&name.len())
        && name.chars().all(fits)
        && !name.starts_with('-')
        && !is_device(name)
}

/// Whether Windows reserves a name for a device, in any folder and any case.
fn is_device(name: &str) -> bool {
    let name = name.to_ascii_uppercase();
    let port = name.strip_prefix("COM").or_else(|| name.strip_prefix("LPT"));
    let is_port = port.is_some_and(|number| matches!(number.as_bytes(), [b'0'..=b'9']));
    is_port || matches!(name.as_str(), "CON" | "PRN" | "AUX" | "NUL")
}

#[cfg(test)]
mod tests {
    use super::is_name;

    #[test]
    fn name_is_a_folder_on_every_system_and_no_option() {
        for name in ["a", "first_run", "2-discs", "_", "console", "COM10", "nul_", "x-rf"] {
            assert!(is_name(name), "{name}");
        }
        let rejected =
            ["", "-rf", "--help", "-", "CON", "con", "Nul", "aux", "prn", "com1", "LPT9"];
        for name in rejected.into_iter().chain(["a b", "a/b", "..", "a.b", "\u{e4}", "a\n"]) {
            assert!(!is_name(name), "{name:?}");
        }
        assert!(is_name(&"a".repeat(80)) && !is_name(&"a".repeat(81)));
    }
}

//! The result of `check --locked` as Markdown, for the summary of a CI job or a comment.

use crate::locking::findings::Findings;
use crate::locking::moved::{Distance, Movement};
use crate::messages::plural;
use kinetoscope_analysis::markdown_text;
use std::fmt::Write as _;

/// Longest summary, bytes. CI systems reject more than 1 MiB per step; other steps of the job may write before.
const LONGEST: usize = 500_000;

/// Manifests that differ, each with its findings, and the number of those that are equal. One line if none differs.
pub(crate) fn markdown(equal: usize, unchecked: usize, differing: &[(&str, Findings)]) -> String {
    let all = equal + unchecked + differing.len();
    if differing.is_empty() && unchecked == 0 {
        let are = if all == 1 { "is" } else { "are" };
        return format!(
            "**{} {are} equal to the lock file**, in every message.\n",
            plural(all as u64, "experiment")
        );
    }
    let differ = if differing.len() == 1 || all == 1 { "differs" } else { "differ" };
    let mut text = format!(
        "**{} of {} {differ} from the lock file.**\n",
        differing.len(),
        plural(all as u64, "experiment")
    );
    if unchecked > 0 {
        let _ = writeln!(
            text,
            "\n{} could not be compared; see the messages of the step.",
            plural(unchecked as u64, "experiment")
        );
    }
    for (number, (manifest, findings)) in differing.iter().enumerate() {
        let section = section(manifest, findings);
        if text.len() + section.len() > LONGEST {
            let rest = plural((differing.len() - number) as u64, "experiment");
            let _ = writeln!(
                text,
                "\n{rest} more: the summary would be too long. `kinetoscope check --locked` prints all."
            );
            break;
        }
        text += &section;
    }
    text
}

fn section(manifest: &str, findings: &Findings) -> String {
    let mut text = format!("\n### {}\n\n", markdown_text(manifest));
    let answer = &findings.checked.answer;
    if !answer.is_empty() {
        let _ = writeln!(text, "{}\n", markdown_text(answer));
    }
    for line in &findings.lines {
        let _ = writeln!(text, "- {}", markdown_text(line));
    }
    let is_shown = |movement: &&Movement| movement.distance() != Distance::Rounding;
    let shown: Vec<&Movement> = findings.movements.iter().filter(is_shown).collect();
    let rounding = findings.movements.len() - shown.len();
    if !shown.is_empty() {
        text += "\n| checked metric | locked | now | difference | check |\n|---|---|---|---|---|\n";
    }
    for movement in shown {
        let check = match movement.passes() {
            Some(true) => "passes",
            Some(false) => "**fails**",
            None => "",
        };
        let [before, after, distance] = movement.cells().map(|cell| markdown_text(&cell));
        let name = markdown_text(&movement.name);
        let _ = writeln!(text, "| {name} | {before} | {after} | {distance} | {check} |");
    }
    if rounding > 0 {
        let _ =
            writeln!(text, "\n{} moved within rounding errors.", plural(rounding as u64, "metric"));
    } else if findings.has_no_movement() {
        text += "\nNo checked metric moved.\n";
    }
    for failed in &findings.checked.failed_checks {
        let _ = writeln!(text, "\n**Failed check:** {}", markdown_text(failed));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guarantee: subject and verb of the first line agree for every number of manifests that differ.
    #[test]
    fn summary_is_grammatical_for_all_counts() {
        let first_line = |equal: usize, unchecked: usize, differing: usize| {
            let differing: Vec<_> =
                (0..differing).map(|_| ("a.toml", Findings::default())).collect();
            let text = markdown(equal, unchecked, &differing);
            text.lines().next().unwrap_or_default().to_owned()
        };
        for (counts, line) in [
            ((1, 0, 0), "**1 experiment is equal to the lock file**, in every message."),
            ((2, 0, 0), "**2 experiments are equal to the lock file**, in every message."),
            ((0, 0, 1), "**1 of 1 experiment differs from the lock file.**"),
            ((3, 0, 1), "**1 of 4 experiments differs from the lock file.**"),
            ((2, 0, 2), "**2 of 4 experiments differ from the lock file.**"),
            ((1, 2, 0), "**0 of 3 experiments differ from the lock file.**"),
            ((0, 1, 0), "**0 of 1 experiment differs from the lock file.**"),
        ] {
            assert_eq!(first_line(counts.0, counts.1, counts.2), line);
        }
    }
}

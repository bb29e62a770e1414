//! Guarantee: texts for users contain only current terms and American spelling.
//!
//! Setup: the documents, the experiments, the starter manifests, the help texts, the layouts and the strings of plots and report
//! are searched for the replaced terms, as whole words and in any case. CHANGELOG.md is exempt, because it
//! maps old to new terms.
//! Control: planted terms are found, also across a line break, and longer words that contain a term are not.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Replaced terms and what to write. A `*` at the end accepts any ending.
const TERMS: &[(&str, &str)] = &[
    // Prose.
    ("anew", "from scratch, again"),
    ("whoever", "no thread, no disc, the user"),
    ("nobody", "no thread, no disc, no user"),
    ("somebody", "a user, a program"),
    ("soonest", "earliest"),
    ("rub", "frictional, sliding"),
    ("rubbing", "frictional, sliding"),
    ("one by one", "scalar, in order"),
    ("four at a time", "SIMD"),
    ("side by side", "in parallel, adjacent"),
    ("side-by-side", "in parallel, adjacent"),
    ("beside", "next to, in addition to"),
    ("besides", "in addition"),
    ("the document", "the DEM (gas, orbit, packing) exercise"),
    ("ledger", "energy balance"),
    ("tells", "reports, gives, records"),
    ("told", "reported, recorded"),
    ("looks at", "checks, scans"),
    ("looked at", "checked, scanned"),
    ("content key", "run key"),
    ("goes on", "resumes, continues"),
    ("gone on", "resumed, continued"),
    ("went on", "resumed, continued"),
    ("done again", "rerun"),
    ("the same bits", "bitwise identical"),
    ("from the fewest to the most", "between A and B"),
    ("promise*", "guarantee"),
    ("verdict*", "result, check"),
    ("judge*", "result, check"),
    ("refused", "rejected, not supported"),
    ("mirrored", "specularly reflected"),
    ("warm wall", "thermal wall"),
    ("hit of the wall", "wall collision"),
    ("hits of the wall", "wall collisions"),
    ("law of speeds", "speed distribution"),
    ("common standard error*", "combined standard error"),
    ("law at the start", "initial distribution"),
    ("over the ideal gas", "over the mean-square formula"),
    ("how far the discs", "mean square displacement"),
    ("forgotten", "uncorrelated"),
    ("checks hold", "checks pass"),
    // British spelling.
    ("analyse*", "analyze"),
    ("behaviour*", "behavior"),
    ("catalogue*", "catalog"),
    ("centre*", "center"),
    ("colour*", "color"),
    ("favour*", "favor"),
    ("grey", "gray"),
    ("labelled", "labeled"),
    ("metre*", "meter"),
    ("millimetre*", "millimeter"),
    ("kilometre*", "kilometer"),
    ("modelled", "modeled"),
    ("modelling", "modeling"),
    ("neighbour*", "neighbor"),
    ("travelled", "traveled"),
];
/// A rate without "per": one of the first, `a` or `an`, one of the second.
const COUNTED: &[&str] =
    &["one", "number", "bytes", "events", "collisions", "frames", "contacts", "file", "files"];
const UNITS: &[&str] = &["run", "disc", "second", "frame", "step", "thread", "core", "task"];
/// A file and a term that it may contain; a comment gives the reason.
const EXCEPTIONS: &[(&str, &str)] = &[];
/// Folders whose strings are titles and labels of plots, and the text of the report.
const LITERALS: &[&str] = &[
    "analysis/src/models/dem",
    "analysis/src/models/gas",
    "analysis/src/models/orbit",
    "analysis/src/models/packing",
    "analysis/src/report",
    "analysis/src/sweep",
];
/// Folders whose `clap` types become help texts.
const HELP: &[&str] = &[
    "src/program",
    "src/program/comparison",
    "src/program/locking",
    "src/program/manifests",
    "src/program/running",
    "src/program/planning",
    "analysis/src/cli",
    "analysis/src/export",
];

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The files of a folder with an extension, in order.
fn files(folder: &str, extension: &str) -> Vec<String> {
    let entries = fs::read_dir(root().join(folder)).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|end| end == extension));
    paths.sort();
    let name = |path: PathBuf| path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned();
    let names: Vec<String> = paths.into_iter().map(name).collect();
    assert!(!names.is_empty(), "{folder} contains no .{extension} file");
    names
}

/// Lower-case text with single spaces, and the line of each of its characters.
#[derive(Default)]
struct Text {
    letters: Vec<char>,
    lines: Vec<usize>,
}

impl Text {
    /// The text of numbered lines; comment signs at their starts are dropped.
    fn new<'a>(lines: impl Iterator<Item = (usize, &'a str)>) -> Self {
        let mut text = Self::default();
        for (number, line) in lines {
            let line = line.trim_start().trim_start_matches(['#', '/', '!']);
            for word in line.split_whitespace() {
                text.letters.extend(word.to_lowercase().chars().chain([' ']));
                text.lines.resize(text.letters.len(), number);
            }
        }
        text
    }

    fn of_document(document: &str) -> Self {
        Self::new(document.lines().enumerate().map(|(index, line)| (index + 1, line)))
    }

    /// The doc comments inside and above the `clap` types of a source.
    fn of_help(source: &str) -> Self {
        let lines: Vec<&str> = source.lines().collect();
        let is_clap = |line: &str| {
            let derives = ["Args", "Parser", "Subcommand", "ValueEnum"];
            line.starts_with("#[derive(") && derives.iter().any(|name| line.contains(name))
        };
        let mut help = Vec::new();
        for (index, _) in lines.iter().enumerate().filter(|(_, line)| is_clap(line)) {
            let above = lines[..index].iter().rev().take_while(|line| line.starts_with("///"));
            let first = index - above.count();
            let end = lines[index..].iter().position(|line| *line == "}");
            let last = end.map_or(lines.len(), |length| index + length);
            let is_doc = |number: &usize| lines[*number].trim_start().starts_with("///");
            help.extend((first..last).filter(is_doc));
        }
        Self::new(help.into_iter().map(|index| (index + 1, lines[index])))
    }

    /// The strings of a source.
    fn of_literals(source: &str) -> Self {
        let lines = source.lines().enumerate();
        let lines = lines.filter(|(_, line)| !line.trim_start().starts_with("//"));
        let strings = lines.flat_map(|(index, line)| {
            line.split('"').skip(1).step_by(2).map(move |string| (index + 1, string))
        });
        Self::new(strings)
    }

    /// The lines in which a term is a whole word.
    fn lines_with(&self, term: &str) -> Vec<usize> {
        let (word, is_prefix) = term.strip_suffix('*').map_or((term, false), |word| (word, true));
        let word: Vec<char> = word.chars().collect();
        let is_inside = |letter: char| letter.is_alphanumeric() || letter == '_';
        let is_word_start = |at: usize| {
            let before = at.checked_sub(1).map(|before| self.letters[before]);
            !is_inside(word[0]) || before.is_none_or(|letter| !is_inside(letter))
        };
        let is_word_end = |at: usize| {
            let after = self.letters.get(at + word.len()).copied();
            let last = word[word.len() - 1];
            is_prefix || !is_inside(last) || after.is_none_or(|letter| !is_inside(letter))
        };
        let starts = self.letters.windows(word.len()).enumerate();
        starts
            .filter(|(at, window)| *window == word && is_word_start(*at) && is_word_end(*at))
            .map(|(at, _)| self.lines[at])
            .collect()
    }

    /// All findings: line and message.
    fn findings(&self) -> Vec<(usize, String)> {
        let mut findings = Vec::new();
        for (term, replacement) in TERMS {
            let message = format!("`{term}`; write {replacement}");
            findings.extend(self.lines_with(term).into_iter().map(|line| (line, message.clone())));
        }
        for (counted, unit) in
            COUNTED.iter().flat_map(|counted| UNITS.iter().map(move |unit| (counted, unit)))
        {
            let message = format!("`{counted} a {unit}`; write {counted} per {unit}");
            let lines = self.lines_with(&format!("{counted} a {unit}"));
            findings.extend(lines.into_iter().map(|line| (line, message.clone())));
        }
        findings.sort();
        findings
    }
}

/// All texts for users, by file.
fn texts() -> BTreeMap<String, Text> {
    let documents = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "recordings/README.md"];
    let documents = documents.into_iter().map(str::to_owned);
    let named = [
        ("docs", "md"),
        ("book/src", "md"),
        ("book/src/tutorials", "md"),
        ("book/src/use", "md"),
        ("book/src/physics", "md"),
        ("experiments", "toml"),
        ("src/manifest/model/dem", "toml"),
        ("src/manifest/model/gas", "toml"),
        ("src/manifest/model/orbit", "toml"),
        ("src/manifest/model/packing", "toml"),
    ];
    let named = named.into_iter().chain([("src/recording/layouts", "json")]);
    let others = named.flat_map(|(folder, extension)| files(folder, extension));
    let read = |name: &str| fs::read_to_string(root().join(name)).unwrap();
    let mut texts: BTreeMap<String, Text> = documents
        .chain(others)
        .map(|name| {
            let text = Text::of_document(&format!("{}\n{name}\n", read(&name)));
            (name, text)
        })
        .collect();
    for name in HELP.iter().flat_map(|folder| files(folder, "rs")) {
        let text = Text::of_help(&read(&name));
        texts.insert(name, text);
    }
    for name in LITERALS.iter().flat_map(|folder| files(folder, "rs")) {
        let text = Text::of_literals(&read(&name));
        texts.insert(name, text);
    }
    texts
}

#[test]
fn texts_for_users_contain_only_current_terms() {
    let mut report = Vec::new();
    for (name, text) in texts() {
        let mut findings = text.findings();
        findings.retain(|(_, message)| {
            !EXCEPTIONS
                .iter()
                .any(|(file, term)| *file == name && message.starts_with(&format!("`{term}`")))
        });
        if !findings.is_empty() {
            println!("{:4} {name}", findings.len());
        }
        report.extend(findings.iter().map(|(line, message)| format!("{name}:{line}: {message}")));
    }
    assert!(report.is_empty(), "{} findings:\n{}", report.len(), report.join("\n"));
}

#[test]
fn control_replaced_terms_are_found() {
    let found = |document: &str| Text::of_document(document).findings();
    let lines =
        |document: &str| found(document).into_iter().map(|(line, _)| line).collect::<Vec<_>>();
    assert_eq!(lines("Discs are sorted\nAnew.\n"), [2]);
    assert_eq!(lines("# runs side\n# by side, 7 bytes a\n# disc\n"), [1, 2]);
    assert_eq!(lines("neighbours of the centre"), [1, 1]);
    let current = "newer, rubber, one run, a disc, central, frames per second, bedside";
    assert_eq!(found(current), []);
    let help = "/// Not help: anew.\nfn f() {}\n\n/// Told.\n#[derive(Debug, Args)]\nstruct A {\n    \
                /// A colour.\n    a: u32, // anew\n}\n\n/// Nobody.\nstruct B;\n";
    let found: Vec<usize> =
        Text::of_help(help).findings().into_iter().map(|(line, _)| line).collect();
    assert_eq!(found, [4, 7]);
    let literals = Text::of_literals("// \"anew\"\nlet a = \"colour\"; // \"x\"\n");
    assert_eq!(literals.findings().len(), 1);
    let named = texts();
    for help in ["src/program/lib.rs", "analysis/src/cli/arguments.rs"] {
        assert!(!named[help].letters.is_empty(), "{help} contains no help text");
    }
}

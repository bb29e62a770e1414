//! Guarantee: text that a file contains reaches the terminal, the files of CI systems, SVG and HTML without control and
//! bidirectional characters, and no line of the output is a command of a CI system. XML and SVG files are well-formed.

use crate::subcommand_bench::{Bench, Called};
use std::fs;
use std::path::Path;

/// Escape sequences of a terminal, a bell, a carriage return, marks that reverse text (Unicode Technical Report 36), a
/// character that XML 1.0 does not allow, and workflow commands at the start of a line.
const HOSTILE: &str = r"::error::forged\u001b[2J\u0007\r\u202E\u2066\uFFFE\u009b<&>\n::stop-commands::x\n##[error]forged";

/// Two variants with hostile names; the check fails, and with `is_faulty` each run fails as well.
fn manifest(is_faulty: bool) -> String {
    // A disc that leaves the range of numbers ends a run with a fault.
    let (speed, reaction) = if is_faulty { ("1e307", "warn") } else { ("1.0", "error") };
    format!(
        "description = \"{HOSTILE}\"\nseed = 1\n[model.dem]\nwidth_m = 1.0\nheight_m = 1.0\ndiscs = 1\nradius_m = 0.1\n\
         duration_s = 0.01\non_unstable_time_step = \"{reaction}\"\nplacement = {{ positions_m = [[0.5, 0.5]], velocities_m_per_s = [[{speed}, 0.0]] }}\n\
         [record]\nframes = 4\n[[sweep.variants]]\nname = \"{HOSTILE}\"\n\"model.dem.gravity_m_per_s2\" = [0.0, -9.0]\n\
         [[sweep.variants]]\nname = \"{HOSTILE} b\"\n\"model.dem.gravity_m_per_s2\" = [0.0, -8.0]\n\
         [[checks]]\nmetric = \"energy.kinetic\"\nminimum = 1e300\n"
    )
}

fn is_hostile(character: char) -> bool {
    let is_layout = matches!(character, '\n' | '\t');
    character.is_control() && !is_layout
        || matches!(character, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{fffe}' | '\u{ffff}')
}

fn assert_visible(text: &str, what: &str) {
    let found: Vec<char> = text.chars().filter(|character| is_hostile(*character)).collect();
    assert!(found.is_empty(), "{what} contains {found:?}");
}

/// Asserts that a text has no hostile character and that no line is a workflow command.
fn assert_safe(text: &str, what: &str) {
    assert_visible(text, what);
    for line in text.lines() {
        assert!(!line.trim_start().starts_with("::"), "{what}: {line}");
    }
}

fn assert_output_is_safe(called: &Called, what: &str) {
    for text in [&called.out, &called.err] {
        assert_safe(text, what);
        assert!(!text.contains("##["), "{what}: {text}");
    }
}

/// The files of a folder and its subfolders with this ending.
fn files(folder: &Path, end: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path, end));
        } else if path.extension().is_some_and(|extension| extension == end) {
            found.push((path.display().to_string(), fs::read_to_string(&path).unwrap()));
        }
    }
    found
}

/// Asserts that a document is well-formed: tags are closed in order, and no markup is left in texts and attributes.
fn assert_well_formed(xml: &str, what: &str) {
    let mut open: Vec<&str> = Vec::new();
    for piece in xml.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').unwrap_or_else(|| panic!("{what}: {piece}"));
        let name = tag.split([' ', '\n', '/']).find(|name| !name.is_empty()).unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "{what}");
        } else if !tag.starts_with('?') && !tag.starts_with('!') && !tag.ends_with('/') {
            open.push(name);
        }
        assert!(tag.matches('"').count() % 2 == 0 && !text.contains('>'), "{what}: {piece}");
        for reference in piece.split('&').skip(1) {
            let name = reference.split(';').next().unwrap();
            let is_known =
                ["amp", "lt", "gt", "quot", "apos"].contains(&name) || name.starts_with('#');
            assert!(is_known, "{what}: &{reference}");
        }
    }
    assert!(open.is_empty(), "{what}: {open:?} is not closed");
}

#[test]
fn text_of_manifests_is_escaped_in_every_command() {
    for is_faulty in [false, true] {
        let bench = Bench::new();
        bench.write("dem.toml", &manifest(is_faulty));
        for arguments in [
            &["check", "dem.toml"] as &[&str],
            &["check", "--json", "dem.toml"],
            &["run", "--verbose", "dem.toml"],
            &["run", "--json", "dem.toml"],
            &["run", "--dry-run", "dem.toml"],
            &["why", "dem.toml"],
            &["benchmark", "dem.toml"],
            &["analyze", "recordings/dem"],
            &["analyze", "--json", "recordings/dem"],
            &["analyze", "--quiet", "--junit", "checks.xml", "recordings/dem"],
        ] {
            let called = bench.call(arguments);
            assert!(matches!(called.code, Some(0 | 1 | 3)), "{arguments:?}: {}", called.err);
            assert_output_is_safe(&called, &format!("{arguments:?}"));
        }
        let junit = fs::read_to_string(bench.path("checks.xml")).unwrap();
        assert_safe(&junit, "the JUnit file");
        assert_well_formed(&junit, "the JUnit file");
    }
}

#[test]
fn text_of_manifests_is_escaped_in_every_file_of_an_analysis() {
    let bench = Bench::new();
    bench.write("dem.toml", &manifest(false));
    assert_eq!(bench.call(&["run", "--quiet", "dem.toml"]).code, Some(0));
    assert_eq!(bench.call(&["analyze", "--quiet", "recordings/dem"]).code, Some(3));
    let pictures = files(&bench.path("recordings"), "svg");
    assert!(
        pictures.iter().any(|(_, svg)| svg.contains("::error::forged")),
        "a plot names a variant"
    );
    for (name, svg) in pictures {
        assert_visible(&svg, &name);
        assert_well_formed(&svg, &name);
    }
    let pages = files(&bench.path("recordings"), "html");
    assert_eq!(pages.len(), 1);
    assert_visible(&pages[0].1, "the report");
    assert!(
        pages[0].1.contains("::error::forged") && !pages[0].1.contains("<&>"),
        "markup is escaped"
    );
}

/// Annotations are the only commands: one per failed check, each in one line.
#[test]
fn annotations_contain_no_second_command() {
    let bench = Bench::new();
    bench.write("dem.toml", &manifest(false));
    assert_eq!(bench.call(&["run", "--quiet", "dem.toml"]).code, Some(0));
    let called = bench.call(&["analyze", "--quiet", "--github-annotations", "recordings/dem"]);
    let commands: Vec<&str> =
        called.out.lines().filter(|line| line.trim_start().starts_with("::")).collect();
    assert_eq!(commands.len(), 2, "{}", called.out);
    assert!(commands.iter().all(|line| line.starts_with("::error file=")), "{commands:?}");
    assert!(!called.out.contains(is_hostile), "{}", called.out);
}

/// The same experiment in two folders: each suite of the JUnit file has its own name.
#[test]
fn suites_of_one_experiment_in_two_folders_have_different_names() {
    let bench = Bench::new();
    bench.write("gas.toml", crate::subcommand_bench::GAS);
    for output in ["one", "two"] {
        let ran = bench.call(&["run", "--quiet", "--output", output, "gas.toml"]);
        assert_eq!(ran.code, Some(0), "{}", ran.err);
    }
    let called = bench.call(&["analyze", "--quiet", "--junit", "checks.xml", "one", "two"]);
    assert_eq!(called.code, Some(0), "{}", called.err);
    let junit = fs::read_to_string(bench.path("checks.xml")).unwrap();
    for suite in ["<testsuite name=\"gas\"", "<testsuite name=\"gas (2)\""] {
        assert_eq!(junit.matches(suite).count(), 1, "{junit}");
    }
}

/// A file that cannot be exported is named, and the exit code reports it; the others are exported.
#[test]
fn export_reports_unreadable_recordings() {
    let bench = Bench::new();
    let recording = bench.recording();
    let bytes = fs::read(&recording).unwrap();
    let folder = recording.parent().unwrap();
    fs::remove_file(folder.join("experiment.toml")).unwrap();
    fs::write(folder.join("empty.mcap"), b"").unwrap();
    let called = bench.call(&["export", "--format", "csv", "recordings/gas"]);
    assert_eq!(called.code, Some(5), "{}{}", called.out, called.err);
    assert!(called.err.contains("error: ") && called.err.contains("empty.mcap"), "{}", called.err);
    let stem = recording.file_stem().unwrap().to_str().unwrap();
    assert!(bench.path("recordings/gas/export").join(stem).is_dir());
    // The intact frames of a damaged recording are exported, and its damage is reported.
    fs::remove_file(folder.join("empty.mcap")).unwrap();
    fs::write(&recording, &bytes[..bytes.len() * 3 / 4]).unwrap();
    let called = bench.call(&["export", "--format", "csv", "--json", "recordings/gas"]);
    assert_eq!((called.code, &called.json()["exit_code"]), (Some(5), &5.into()), "{}", called.err);
}

//! Guarantee: text that a file contains reaches the terminal, the files of CI systems, SVG and HTML without control and
//! bidirectional characters, and no line of the output is a command of a CI system. XML and SVG files are well-formed.

use crate::forged_recording::Forgery;
use crate::subcommand_bench::{Bench, Called};
use std::fs;
use std::ops::Range;
use std::path::Path;

/// Escape sequences of a terminal (one of them a style, which the program never uses: text that cannot be seen), a bell, a carriage
/// return, marks that reverse text (Unicode Technical Report 36), a character that XML 1.0 does not allow, and workflow commands at
/// the start of a line.
const HOSTILE: &str = r"::error::forged\u001b[8m\u001b[2J\u0007\r\u202E\u2066\uFFFE\u009b<&>\n::stop-commands::x\n##[error]forged";
/// The escape sequences in it that a terminal must not receive, whatever styles the program uses.
const SEQUENCES: [&str; 4] = ["\u{1b}[8m", "\u{1b}[2J", "\u{7}", "\u{202e}"];

/// A manifest with every kind of text: names, words of a list, metrics, and points of the sweep.
const TEXTS: &str = r#"name = "texts"
description = "about"
seed = 1
[model.dem]
discs = 3
width_m = 1.0
height_m = 1.0
radius_m = 0.1
duration_s = 0.01
placement = "lattice"
dashpot = "implicit"
on_unstable_time_step = "warn"
[record]
frames = 4
channels = ["state", "energy"]
keep = "keyframes"
compression = "zstd"
[[sweep.variants]]
name = "smooth"
"model.dem.gravity_m_per_s2" = [0.0, -9.0]
[[sweep.variants]]
name = "rough"
"model.dem.gravity_m_per_s2" = [0.0, -8.0]
[[checks]]
metric = "energy.kinetic"
minimum = 0.0
where = { variant = "smooth" }
[[plots]]
y = "energy.kinetic"
x = "variant"
title = "all"
log = ["y"]
where = { variant = "rough" }
"#;

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

fn is_control(character: char) -> bool {
    let is_layout = matches!(character, '\n' | '\t');
    character.is_control() && !is_layout
}

fn is_hostile(character: char) -> bool {
    is_control(character)
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

/// The texts between quotes, and the words before `=`: their bytes in the manifest.
fn places(manifest: &str) -> Vec<Range<usize>> {
    let mut places = Vec::new();
    let mut quotes = manifest.match_indices('"').map(|(at, _)| at);
    while let (Some(start), Some(end)) = (quotes.next(), quotes.next()) {
        places.push(start..end + 1);
    }
    for (equal, _) in manifest.match_indices(" = ") {
        let start = manifest[..equal].rfind(['\n', ' ']).map_or(0, |before| before + 1);
        if !manifest[start..equal].ends_with('"') {
            places.push(start..equal);
        }
    }
    places
}

/// Each text and each key of a manifest in turn. Control: without a change, the manifest is accepted.
#[test]
fn each_text_of_a_manifest_is_escaped_in_errors_and_results() {
    let bench = Bench::new();
    bench.write("m.toml", TEXTS);
    assert_eq!(bench.call(&["check", "m.toml"]).code, Some(0));
    let mut rejected = 0;
    for place in places(TEXTS) {
        let mut text = TEXTS.to_owned();
        text.replace_range(place.clone(), &format!("\"{HOSTILE}\""));
        bench.write("m.toml", &text);
        let what = &TEXTS[place];
        let called = bench.call(&["check", "m.toml"]);
        assert_output_is_safe(&called, what);
        if called.code != Some(0) {
            assert_eq!(called.code, Some(2), "{what}: {}", called.err);
            rejected += 1;
            continue;
        }
        for command in ["run", "why", "benchmark"] {
            assert_output_is_safe(&bench.call(&[command, "m.toml"]), what);
        }
    }
    assert!(rejected > 20, "{rejected}");
}

/// Terminals receive styles of the program, and none of a manifest.
#[cfg(target_os = "linux")]
#[test]
fn styles_of_a_manifest_reach_no_terminal() {
    let bench = Bench::new();
    let on_terminal = |arguments: &str| {
        let program = env!("CARGO_BIN_EXE_kinetoscope");
        let mut script = std::process::Command::new("script");
        script.args(["-qec", &format!("'{program}' {arguments}"), "/dev/null"]);
        script
            .current_dir(bench.path(""))
            .env_remove("NO_COLOR")
            .stdin(std::process::Stdio::null());
        let called = Called::from(script.output().unwrap());
        for sequence in SEQUENCES {
            assert!(!called.out.contains(sequence), "{arguments}: {}", called.out);
        }
        called.out
    };
    bench.write("wrong.toml", &TEXTS.replacen("\"smooth\"", &format!("\"{HOSTILE}\""), 1));
    assert!(on_terminal("check wrong.toml").contains("\u{1b}["), "errors are styled");
    bench.write("dem.toml", &manifest(false));
    for arguments in ["check dem.toml", "run dem.toml", "why dem.toml"] {
        on_terminal(arguments);
    }
    assert!(on_terminal("analyze recordings/dem").contains("\u{1b}["), "tables are styled");
}

/// Each value of the metadata in turn, and the line of the log. Control: without a change, all commands succeed.
#[test]
fn each_text_of_a_recording_is_escaped_in_every_command() {
    let bench = Bench::new();
    let recording = bench.recording();
    let plain = recording.to_str().unwrap();
    // As the manifest's text is after it was read.
    let hostile: String = toml::from_str::<toml::Table>(&format!("text = \"{HOSTILE}\"")).unwrap()
        ["text"]
        .as_str()
        .unwrap()
        .to_owned();
    let in_log = |topic: &str, _: u64, payload: &mut Vec<u8>| {
        let place = payload.windows(8).position(|part| part == b"playback");
        if let ("/log", Some(place)) = (topic, place) {
            payload[place..place + 8].copy_from_slice(b"\x1b[8m\x1b[2J");
        }
        true
    };
    let keys = [
        "program",
        "program_version",
        "model",
        "physics_version",
        "schema_version",
        "run_key",
        "time_unit",
        "playback_fps",
        "state_columns",
        "state_units",
        "outcome",
        "outcome_detail",
    ];
    let mut forgeries =
        vec![Forgery::default(), Forgery { message: Some(&in_log), ..Forgery::default() }];
    for key in keys {
        let metadata = [(key.to_owned(), hostile.clone())].into();
        forgeries.push(Forgery { metadata, ..Forgery::default() });
    }
    let fault = [("outcome", "fault"), ("outcome_detail", &hostile)];
    let metadata = fault.map(|(key, value)| (key.to_owned(), value.to_owned())).into();
    forgeries.push(Forgery { metadata, ..Forgery::default() });
    for (number, forgery) in forgeries.iter().enumerate() {
        forgery.write(&recording, &bench.path("forged.mcap"));
        let zoom = ["--from", "0", "--to", "0.001", "--every", "1e-4", "-o", "out.mcap"];
        for arguments in [
            &["info", "forged.mcap"][..],
            &["verify", "forged.mcap"],
            &["compare", plain, "forged.mcap"],
            &["compare", plain, "forged.mcap", "--mcap", "both.mcap"],
            &[&["zoom", "forged.mcap"][..], &zoom].concat(),
            &["fill", "forged.mcap", "-o", "out.mcap"],
            &["analyze", "forged.mcap"],
            &["export", "--format", "csv", "forged.mcap"],
            &["plot", "--y", "/energy.total_j", "forged.mcap"],
        ] {
            let called = bench.call(arguments);
            assert_output_is_safe(&called, &format!("{number}: {arguments:?}"));
            assert!(!called.err.contains("panicked"), "{number}: {arguments:?}: {}", called.err);
            if number == 0 && matches!(arguments[0], "info" | "compare" | "zoom" | "analyze") {
                assert_eq!(called.code, Some(0), "{arguments:?}: {}", called.err);
            }
        }
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

/// Tables and side files, which a terminal may show. Control: tables and JSON name the variants, and JSON gives the name back.
#[test]
fn text_of_manifests_is_escaped_in_every_table_and_side_file() {
    let bench = Bench::new();
    bench.write("dem.toml", &manifest(false));
    assert_eq!(bench.call(&["run", "--quiet", "dem.toml"]).code, Some(0));
    assert_eq!(bench.call(&["analyze", "--quiet", "recordings/dem"]).code, Some(3));
    let timed = bench.call(&["benchmark", "--quiet", "--output", "recordings", "dem.toml"]);
    assert_eq!(timed.code, Some(0), "{}", timed.err);
    let exported = bench.call(&["export", "--format", "csv,xyz,gnuplot", "recordings/dem"]);
    assert_eq!(exported.code, Some(0), "{}", exported.err);
    for end in ["csv", "json", "toml", "txt", "gp", "xyz"] {
        let found = files(&bench.path("recordings"), end);
        assert!(!found.is_empty(), "no file ends in {end}");
        for (name, text) in found {
            let found: Vec<char> = text.chars().filter(|it| is_control(*it)).collect();
            assert!(found.is_empty(), "{name} contains {found:?}");
        }
    }
    let read = |name| fs::read_to_string(bench.path("recordings/dem").join(name)).unwrap();
    assert!(read("metrics.csv").contains("::error::forged\\u{1b}[8m"));
    for name in ["metrics.json", "timing.json"] {
        assert!(read(name).contains("::error::forged\\u001b[8m"), "{name}");
        let document = serde_json::from_str::<serde_json::Value>(&read(name)).unwrap();
        assert!(document.to_string().contains("\\u0007\\r\u{202e}"), "{name}");
    }
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

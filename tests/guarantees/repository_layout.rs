//! Guarantee: the documents describe the repository as it is, and each package, each unsafe block and each import is where the
//! architecture allows it.
//!
//! Setup: every path in ARCHITECTURE.md, README.md and CONTRIBUTING.md must exist; the README has at most 200 lines; every experiment
//! must have a row in `book/src/use/experiments.md` with an existing test and a picture in docs/replay_gallery.md; the sources are searched for packages, `unsafe` and imports.
//! Control: a path that does not exist and a rule that omits a file are found.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The paths of this repository that a document names in backquotes.
fn paths_in(document: &str) -> Vec<String> {
    document
        .split('`')
        .skip(1)
        .step_by(2)
        .flat_map(|quoted| match quoted.split_once('{') {
            Some((before, rest)) => {
                let (names, after) = rest.split_once('}').unwrap_or((rest, ""));
                names.split(',').map(|name| format!("{before}{name}{after}")).collect()
            }
            None => vec![quoted.to_owned()],
        })
        .filter(|path| {
            [
                "src/",
                "tests/",
                "experiments/",
                "analysis/",
                "recordings/README",
                "docs/",
                "benches/",
                "examples/",
                "book/",
                "python/",
            ]
            .iter()
            .any(|top| path.starts_with(top))
                && !path.contains([' ', '*', '<'])
                && !path.contains("NAME")
        })
        .collect()
}

/// All Rust sources below a folder.
fn sources(folder: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    collect_sources(&root().join(folder), &mut files);
    assert!(!files.is_empty(), "{folder} contains no Rust source");
    files
}

fn collect_sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect_sources(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

#[test]
fn paths_named_in_documents_exist() {
    for document in [
        "ARCHITECTURE.md",
        "README.md",
        "CONTRIBUTING.md",
        "docs/threat_model.md",
        "book/src/use/experiments.md",
    ] {
        let text = read(document);
        for path in paths_in(&text) {
            assert!(root().join(&path).exists(), "{document} names {path}, which does not exist");
        }
    }
}

#[test]
fn readme_has_at_most_200_lines() {
    let lines = read("README.md").lines().count();
    assert!(lines <= 200, "README.md has {lines} lines; move details to book/src");
}

#[test]
fn findings_of_the_threat_model_name_their_tests() {
    let text = read("docs/threat_model.md");
    let (_, findings) = text.split_once("## Findings").unwrap();
    let mut tests = 0;
    for finding in findings.lines().filter(|line| line.starts_with("| ")).skip(1) {
        let cell = finding.split(" | ").nth(1).unwrap();
        for file in cell.split("; ") {
            let (path, names) = file.split_once(": ").unwrap_or((file, ""));
            for path in paths_in(path) {
                let source = read(&path);
                for name in names.split(", ").filter(|name| !name.is_empty()) {
                    let test = format!("fn {}(", name.trim_matches(['`', ' ', '|']));
                    assert!(source.contains(&test), "{path} has no {test}");
                    tests += 1;
                }
            }
        }
    }
    assert!(tests > 40, "{tests}");
}

#[test]
fn every_experiment_has_a_row_a_test_a_replay_and_a_check() {
    let table = read("book/src/use/experiments.md");
    let replays = read("docs/replay_gallery.md");
    let mut shipped = BTreeSet::new();
    for entry in fs::read_dir(root().join("experiments")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            shipped.insert(path.file_name().unwrap().to_string_lossy().into_owned());
        }
    }
    for experiment in &shipped {
        let row = table
            .lines()
            .find(|line| line.starts_with(&format!("| `experiments/{experiment}`")))
            .unwrap_or_else(|| panic!("{experiment} has no row in book/src/use/experiments.md"));
        assert!(row.contains("`tests/"), "{experiment}: the row names no test");
        let first = read(&format!("experiments/{experiment}"));
        let question = first.lines().next().unwrap_or_default();
        assert!(
            question.starts_with("# ") && question.contains("? Expected:"),
            "{experiment}: the first line must state a question and the expected answer"
        );
        let name = experiment.trim_end_matches(".toml");
        let picture = format!("replay/{name}.png");
        assert!(root().join("docs").join(&picture).exists(), "docs/{picture} does not exist");
        let replay = format!(
            "### {name}\n\n{}\n\n![{name}]({picture})\n",
            question.trim_start_matches("# ")
        );
        let shown = replays.matches(&replay).count();
        assert_eq!(
            shown, 1,
            "{experiment}: docs/replay_gallery.md must contain the question and the picture once"
        );
        assert!(first.contains("[[checks]]"), "{experiment} has no check");
    }
}

#[test]
fn external_packages_are_used_in_one_folder() {
    let homes = [
        ("mcap::", "src/recording"),
        ("rand_chacha::", "src/physics/random.rs"),
        ("indicatif::", "src/program/messages/progress.rs"),
        ("tungstenite::", "src/live"),
        ("object_store::", "src/object_storage"),
        ("axum::", "src/program/view"),
        ("csv::", "analysis"),
        ("png::", "analysis"),
        ("resvg::", "analysis/src/plot/png.rs"),
    ];
    for file in [sources("src"), sources("analysis")].concat() {
        let text = fs::read_to_string(&file).unwrap();
        let path = file.strip_prefix(root()).unwrap();
        for (package, home) in homes {
            let used = text.lines().any(|line| {
                line.trim_start().starts_with(&format!("use {package}"))
                    || line.contains(&format!(" {package}"))
            });
            assert!(!used || path.starts_with(home), "{} uses {package}", path.display());
        }
    }
}

/// A named pipe or an endless device in place of a file must not block or fill the memory, wherever the file is read.
#[test]
fn files_are_opened_for_reading_in_one_place() {
    const HOME: &str = "src/files/regular_file.rs";
    // A folder is opened to be synced, and a file of the system is none that a user could replace.
    const OTHERS: [&str; 3] = [
        "File::open(folder).and_then(|folder| folder.sync_all())",
        "File::open(folder_of(&file)).ok()",
        "fs::read_to_string(\"/proc/self/status\")",
    ];
    let opens = |text: &str| {
        let text = OTHERS.iter().fold(text.to_owned(), |text, other| text.replace(other, ""));
        let product = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
        ["File::open(", "fs::read(", "fs::read_to_string("]
            .into_iter()
            .find(|call| product.contains(call))
            .map(str::to_owned)
    };
    assert_eq!(opens("let file = File::open(path)?;"), Some("File::open(".to_owned()));
    for file in [sources("src"), sources("analysis/src")].concat() {
        let path = file.strip_prefix(root()).unwrap();
        let is_product = !path.iter().any(|part| part == "tests" || part == "benches");
        if is_product && path != Path::new(HOME) {
            let found = opens(&fs::read_to_string(&file).unwrap());
            assert_eq!(found, None, "{} opens files; {HOME} does", path.display());
        }
    }
}

/// A folder's name may contain a line feed, and after it a command of a CI system.
#[test]
fn paths_are_shown_in_one_place() {
    const HOME: &str = "src/console/text.rs";
    for file in [sources("src"), sources("analysis/src")].concat() {
        let path = file.strip_prefix(root()).unwrap();
        let is_product = !path.iter().any(|part| part == "tests" || part == "benches");
        let text = fs::read_to_string(&file).unwrap();
        let shows = text.split("\nmod tests {").next().unwrap_or_default().contains(".display()");
        if is_product {
            let is_home = path == Path::new(HOME);
            assert_eq!(shows, is_home, "{}: paths are shown by {HOME}", path.display());
        }
    }
}

/// A link in place of a file must not lead a write elsewhere, and a named pipe must not block it. `File::create_new` follows none.
#[test]
fn files_are_written_in_three_places() {
    const HOMES: [&str; 3] = ["atomic_file.rs", "output_file.rs", "regular_file.rs"];
    const CALLS: [&str; 5] =
        ["File::create(", "File::options(", "OpenOptions", "fs::write(", "fs::copy("];
    let writes = |text: &str| {
        let product = text.split("\nmod tests {").next().unwrap_or_default();
        let is_call = |call: &&str| {
            let mut places = product.match_indices(*call);
            places.any(|(place, _)| !product[..place].ends_with(|c: char| c.is_alphanumeric()))
        };
        CALLS.into_iter().find(is_call)
    };
    assert_eq!(writes("let file = File::create(path)?;"), Some("File::create("));
    assert_eq!(writes("let file = RecordingFile::create(path)?;"), None);
    for file in [sources("src"), sources("analysis/src")].concat() {
        let path = file.strip_prefix(root()).unwrap();
        let is_product = !path.iter().any(|part| part == "tests" || part == "benches");
        if is_product && !HOMES.iter().any(|home| path == Path::new("src/files").join(home)) {
            let found = writes(&fs::read_to_string(&file).unwrap());
            assert_eq!(found, None, "{} writes files; {HOMES:?} do", path.display());
        }
    }
}

/// The start of the rule that names the files with unsafe code.
const UNSAFE_RULE: &str = "\n2. `unsafe` is used in the files listed here only";
/// The start of the rule that names the files with calls that Windows does not have.
const UNIX_RULE: &str = "\n6. Calls that only Unix or Linux has are in the files listed here only";

/// The list item of ARCHITECTURE.md, section "Rules", that starts with these words.
fn rule(document: &str, start: &str) -> Option<String> {
    let (_, rules) = document.split_once("\n## Rules")?;
    let rules = rules.split("\n## ").next()?;
    let start = rules.find(start)? + 1;
    let mut lines = rules[start..].lines();
    let first = lines.next()?;
    // The item ends at the next item, at an empty line or at the end of the section.
    let rest = lines.take_while(|line| line.starts_with(' '));
    Some([first].into_iter().chain(rest).collect::<Vec<_>>().join("\n"))
}

/// Whether a source contains an unsafe block or implementation.
fn has_unsafe_code(source: &str) -> bool {
    source.contains("unsafe {") || source.contains("unsafe impl")
}

/// Whether a source contains a call that Windows does not have.
fn has_unix_call(source: &str) -> bool {
    ["std::os::", "libc::", "rustix::", "consts::SIG"].iter().any(|part| source.contains(part))
}

/// Checks that the files that a rule lists are those for which a condition holds.
fn check_listed(start: &str, holds: impl Fn(&Path, &str) -> bool) {
    let rule = rule(&read("ARCHITECTURE.md"), start)
        .unwrap_or_else(|| panic!("ARCHITECTURE.md, section Rules, must have the rule {start}"));
    let listed: BTreeSet<String> = paths_in(&rule).into_iter().collect();
    let found: BTreeSet<String> = [sources("src"), sources("analysis")]
        .concat()
        .into_iter()
        .filter(|file| {
            holds(file.strip_prefix(root()).unwrap(), &fs::read_to_string(file).unwrap())
        })
        .map(|file| file.strip_prefix(root()).unwrap().to_string_lossy().into_owned())
        .collect();
    let unlisted: Vec<_> = found.difference(&listed).collect();
    assert!(unlisted.is_empty(), "files that the rule does not list: {unlisted:?}");
    let is_source = |path: &&String| path.starts_with("src/") || path.starts_with("analysis/");
    let without: Vec<_> = listed.difference(&found).filter(is_source).collect();
    assert!(without.is_empty(), "listed files without it: {without:?}");
}

#[test]
fn unsafe_code_is_only_in_the_listed_files() {
    check_listed(UNSAFE_RULE, |_, source| has_unsafe_code(source));
}

#[test]
fn unix_calls_are_only_in_the_listed_files() {
    let is_test = |file: &Path| file.components().any(|part| part.as_os_str() == "tests");
    check_listed(UNIX_RULE, |file, source| !is_test(file) && has_unix_call(source));
}

#[test]
fn control_missing_paths_and_incomplete_rules_are_found() {
    let document = "a\n## Rules\n\n1. `src/none.rs`.\n2. `unsafe` is used in the files listed here only:\n   \
                    `src/a/{one,two}.rs`,\n   `src/b.rs`.\n3. `src/c.rs`\n\n## Next\n";
    let found = rule(document, UNSAFE_RULE).unwrap();
    assert_eq!(paths_in(&found), ["src/a/one.rs", "src/a/two.rs", "src/b.rs"]);
    assert_eq!(rule(&document.replace("\n2. ", "\n5. "), UNSAFE_RULE), None);
    assert!(!root().join("src/none.rs").exists());
    assert!(has_unsafe_code("let x = unsafe { f() };") && !has_unsafe_code("// unsafe\n"));
    assert!(has_unix_call("use std::os::unix::fs::MetadataExt as _;") && !has_unix_call("libm::"));
}

#[test]
fn physics_does_not_depend_on_its_environment() {
    let forbidden = [
        "std::fs",
        "std::io",
        "std::env",
        "std::time",
        "std::thread",
        "println!",
        "HashMap",
        "f32",
    ];
    let models = ["dem", "gas", "packing", "orbit"];
    for file in sources("src/physics") {
        let text = fs::read_to_string(&file).unwrap();
        for word in forbidden {
            assert!(!text.contains(word), "{} contains {word}", file.display());
        }
        let path = file.strip_prefix(root().join("src/physics")).unwrap();
        let own = models.iter().find(|model| path.starts_with(model));
        for other in models.iter().filter(|model| own.is_some_and(|own| own != *model)) {
            let import = format!("crate::{other}");
            assert!(!text.contains(&import), "{} imports {import}", file.display());
        }
    }
}

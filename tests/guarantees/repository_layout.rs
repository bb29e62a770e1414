//! The documents say what is there: every path that ARCHITECTURE.md and the README name exists, every experiment has its
//! row in the README with a test that exists and its picture in docs/replay.md, given packages are used in their one home, and `unsafe` where it is said.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The words in backquotes that look like paths of this repository.
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
            ]
            .iter()
            .any(|top| path.starts_with(top))
                && !path.contains([' ', '*', '<'])
                && !path.contains("NAME")
        })
        .collect()
}

fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

#[test]
fn every_path_that_a_document_names_exists() {
    for document in ["ARCHITECTURE.md", "README.md", "CONTRIBUTING.md"] {
        let text = read(document);
        for path in paths_in(&text) {
            assert!(root().join(&path).exists(), "{document} names {path}, which is not there");
        }
    }
}

#[test]
fn every_experiment_has_its_row_its_law_test_and_its_replay() {
    let readme = read("README.md");
    let replays = read("docs/replay.md");
    let mut shipped = BTreeSet::new();
    for entry in fs::read_dir(root().join("experiments")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            shipped.insert(path.file_name().unwrap().to_string_lossy().into_owned());
        }
    }
    for experiment in &shipped {
        let row = readme
            .lines()
            .find(|line| line.starts_with(&format!("| `experiments/{experiment}`")))
            .unwrap_or_else(|| panic!("{experiment} has no row in the README's table"));
        assert!(row.contains("`tests/"), "{experiment}: its row names no law test");
        let first = read(&format!("experiments/{experiment}"));
        let question = first.lines().next().unwrap_or_default();
        assert!(
            question.starts_with("# ") && question.contains("? Expected:"),
            "{experiment}: its first line asks a question and says the expected answer"
        );
        let name = experiment.trim_end_matches(".toml");
        let picture = format!("replay/{name}.png");
        assert!(root().join("docs").join(&picture).exists(), "docs/{picture} is not there");
        let replay = format!(
            "### {name}\n\n{}\n\n![{name}]({picture})\n",
            question.trim_start_matches("# ")
        );
        let shown = replays.matches(&replay).count();
        assert_eq!(shown, 1, "{experiment}: docs/replay.md has its question and picture once");
        assert!(first.contains("[[checks]]"), "{experiment} has no check");
    }
}

#[test]
fn given_packages_have_one_home() {
    let homes = [
        ("mcap::", "src/recording"),
        ("rand_chacha::", "src/random.rs"),
        ("indicatif::", "src/progress.rs"),
        ("tungstenite::", "src/live"),
        ("object_store::", "src/object_storage"),
        ("tokio::", "src/object_storage"),
        ("csv::", "analysis"),
        ("png::", "analysis"),
    ];
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    sources(&root().join("analysis"), &mut files);
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let place = file.strip_prefix(root()).unwrap();
        for (package, home) in homes {
            let used = text.lines().any(|line| {
                line.trim_start().starts_with(&format!("use {package}"))
                    || line.contains(&format!(" {package}"))
            });
            assert!(!used || place.starts_with(home), "{} uses {package}", place.display());
        }
    }
}

#[test]
fn unsafe_code_stands_where_the_architecture_says() {
    let document = read("ARCHITECTURE.md");
    let rule = document.split("6. `unsafe`").nth(1).unwrap().split("\n\n").next().unwrap();
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    sources(&root().join("analysis"), &mut files);
    for file in files {
        let place = file.strip_prefix(root()).unwrap().to_string_lossy().into_owned();
        let text = fs::read_to_string(&file).unwrap();
        let has = text.contains("unsafe {") || text.contains("unsafe impl");
        assert_eq!(has, rule.contains(&format!("`{place}`")), "{place}: unsafe code is {has}");
    }
}

#[test]
fn models_know_nothing_of_the_world() {
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
    let mut files = Vec::new();
    sources(&root().join("src/models"), &mut files);
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let models = ["dem", "gas", "packing", "orbit"];
        let own = models.iter().find(|model| file.parent().unwrap().ends_with(model));
        for word in forbidden {
            assert!(!text.contains(word), "{} says {word}", file.display());
        }
        for other in models.iter().filter(|model| own.is_some_and(|own| own != *model)) {
            let import = format!("models::{other}");
            assert!(!text.contains(&import), "{} imports {import}", file.display());
        }
    }
}

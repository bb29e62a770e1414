//! Guarantee: `kinetoscope grade` accepts the solution of each of the 36 exercises of the book, rejects the three planned errors of its
//! key with the finding that the key names, and reports an exercise without an answer as incomplete.
//!
//! Control: without the changes of its planned errors, each file is the accepted solution.

use crate::subcommand_bench::{Bench, Called, command};
use serde_json::Value as Json;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::thread;
use toml::{Table, Value};

/// Exercises of the book: three of each of twelve lessons.
const EXERCISES: usize = 36;
/// Planned errors of each.
const ERRORS: usize = 3;

fn book(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book").join(folder)
}

/// Lesson and name of all exercises with a key.
fn exercises() -> Vec<String> {
    let mut names = Vec::new();
    for lesson in fs::read_dir(book("solutions")).unwrap() {
        let lesson = lesson.unwrap();
        for file in fs::read_dir(lesson.path()).unwrap() {
            let file = file.unwrap().file_name().into_string().unwrap();
            if let Some(name) = file.strip_suffix(".key.toml") {
                names.push(format!("{}/{name}", lesson.file_name().to_string_lossy()));
            }
        }
    }
    names.sort();
    names
}

fn read(path: &Path) -> Table {
    fs::read_to_string(path).unwrap().parse().unwrap_or_else(|error| panic!("{path:?}: {error}"))
}

/// The solution with the changes of a planned error, whose keys have `/` between tables.
fn with_error(solution: &Table, error: &Value) -> Table {
    let mut changed = solution.clone();
    for (key, value) in error["set"].as_table().unwrap() {
        let mut parts: Vec<&str> = key.split('/').collect();
        let last = parts.pop().unwrap();
        let table = parts.iter().fold(&mut changed, |table, part| {
            table.get_mut(*part).and_then(Value::as_table_mut).unwrap_or_else(|| panic!("{key}"))
        });
        table.insert(last.to_owned(), value.clone());
    }
    assert_ne!(changed, *solution, "{error}");
    changed
}

fn grade(bench: &Bench, files: &[String]) -> Called {
    let mut command = command();
    command.current_dir(bench.0.path()).args(["grade", "--json", "--solutions"]);
    command.arg(book("solutions")).args(files).output().unwrap().into()
}

/// Grades the solution and the planned errors of some exercises in one process, which reruns equal manifests once.
fn check(names: &[String]) {
    let bench = Bench::new();
    let (mut files, mut expected) = (Vec::new(), Vec::new());
    for name in names {
        let solution = read(&book("solutions").join(format!("{name}.toml")));
        let key = read(&book("solutions").join(format!("{name}.key.toml")));
        let errors = key["planned_errors"].as_array().unwrap();
        assert_eq!(errors.len(), ERRORS, "{name}");
        let wrong =
            errors.iter().map(|error| (with_error(&solution, error), error["finding"].as_str()));
        for (index, (answer, finding)) in
            std::iter::once((solution.clone(), None)).chain(wrong).enumerate()
        {
            let file = format!("{}_{index}.toml", name.replace('/', "__"));
            bench.write(&file, &answer.to_string());
            files.push(file);
            expected.push(finding.map(str::to_owned));
        }
    }
    let graded = grade(&bench, &files);
    assert_eq!(graded.code, Some(4), "{}", graded.err);
    let documents = graded.json();
    for ((file, expected), document) in
        files.iter().zip(&expected).zip(documents.as_array().unwrap())
    {
        let found: Vec<&str> = document["findings"]
            .as_array()
            .unwrap_or_else(|| panic!("{file}: {document}"))
            .iter()
            .filter_map(|finding| finding["kind"].as_str())
            .collect();
        match expected {
            None => assert!(document["accepted"] == true && found.is_empty(), "{document}"),
            Some(kind) => assert!(
                document["accepted"] == false && found.contains(&kind.as_str()),
                "expected {kind}: {document}"
            ),
        }
    }
}

#[test]
fn exercises_accept_their_solutions_and_reject_planned_errors() {
    let names = exercises();
    assert_eq!(names.len(), EXERCISES);
    let lessons: BTreeSet<&str> =
        names.iter().map(|name| name.split('/').next().unwrap()).collect();
    assert_eq!(lessons.len(), EXERCISES / 3);
    // Two processes, each with half of every lesson's exercises.
    let (even, odd): (Vec<_>, Vec<_>) =
        names.iter().cloned().enumerate().partition(|(index, _)| index % 2 == 0);
    thread::scope(|scope| {
        for half in [even, odd] {
            let half: Vec<String> = half.into_iter().map(|(_, name)| name).collect();
            scope.spawn(move || check(&half));
        }
    });
}

#[test]
fn exercises_without_an_answer_are_incomplete() {
    let bench = Bench::new();
    let files: Vec<String> = exercises()
        .iter()
        .map(|name| {
            let path = book("exercises").join(format!("{name}.toml"));
            let exercise = read(&path);
            assert_eq!(exercise["exercise"]["name"].as_str(), Some(name.as_str()));
            path.to_string_lossy().into_owned()
        })
        .collect();
    let graded = grade(&bench, &files);
    assert_eq!(graded.code, Some(2), "{}", graded.err);
    for document in graded.json().as_array().unwrap() {
        let Json::String(error) = &document["error"] else { panic!("{document}") };
        assert!(error.contains("`exercise.value` is missing"), "{error}");
    }
}

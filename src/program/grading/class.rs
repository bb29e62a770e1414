//! A folder of hand-ins: each distinct manifest is rerun once, and each hand-in has one line.

use crate::grading::answer::Answer;
use crate::grading::findings::{Finding, findings};
use crate::grading::key::Key;
use crate::grading::rerun::{Rerun, rerun, run_keys};
use crate::messages::exit::unread;
use crate::messages::{Failure, bad};
use kinetoscope::interrupt::Interrupt;
use kinetoscope_console::text::{one_line, plural, shortened, shown_path};
use kinetoscope_console::without_styles;
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};
use serde_json::{Value as Json, json};
use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::hash::Hash;
use std::path::{Path, PathBuf};

/// Longest name of a file in the table, characters.
const LONGEST_NAME: usize = 40;
/// Longest reason in the table, characters.
const LONGEST_REASON: usize = 160;

/// A hand-in after grading.
#[derive(Debug)]
pub(crate) struct Graded {
    file: String,
    exercise: String,
    /// What is wrong; `Err` for a file that cannot be graded.
    result: Result<Vec<Finding>, String>,
    /// Whether it belongs to another lesson than the one that is graded.
    is_skipped: bool,
    /// The first hand-in with the same manifest and answer.
    identical_to: Option<String>,
    /// The first hand-in of the exercise with the same manifest, whatever its answer.
    same_runs_as: Option<String>,
}

impl Graded {
    /// Whether the answer is right.
    pub(crate) fn is_accepted(&self) -> bool {
        self.result.as_ref().is_ok_and(Vec::is_empty)
    }

    /// Whether it is a failure: hand-ins of other lessons are none.
    pub(crate) fn is_failure(&self) -> bool {
        !self.is_accepted() && !self.is_skipped
    }

    fn text(&self) -> String {
        let mut text = match &self.result {
            Err(reason) if self.is_skipped => format!("skipped: {reason}"),
            Err(reason) => format!("not graded: {reason}"),
            Ok(found) if found.is_empty() => "accepted".to_owned(),
            Ok(found) => found.iter().map(|it| it.text.as_str()).collect::<Vec<_>>().join("; "),
        };
        text = shortened(&text, LONGEST_REASON).into_owned();
        if let Some(other) = &self.identical_to {
            text += &format!(" (identical to {other})");
        } else if let Some(other) = &self.same_runs_as {
            text += &format!(" (same runs as {other})");
        }
        text
    }

    fn json(&self) -> Json {
        let findings: Vec<Json> = self.result.iter().flatten().map(json_of).collect();
        json!({
            "file": self.file,
            "exercise": self.exercise,
            "accepted": self.is_accepted(),
            "findings": findings,
            "not_graded": self.result.as_ref().err(),
            "skipped": self.is_skipped,
            "identical_to": self.identical_to,
            "same_runs_as": self.same_runs_as,
        })
    }
}

/// A finding as JSON.
pub(crate) fn json_of(finding: &Finding) -> Json {
    json!({ "kind": finding.kind, "text": finding.text })
}

/// The reason of a failure on one line.
fn reason(failure: &Failure) -> String {
    let text = without_styles(&failure.plain_text());
    let first = text.lines().next().unwrap_or_default();
    one_line(first.trim_start_matches("error: ")).into_owned()
}

/// Grades hand-ins; a damaged one stops no other.
pub(crate) fn grade(
    paths: &[PathBuf],
    lesson: Option<&str>,
    solutions: Option<&Path>,
    interrupt: &Interrupt,
) -> Vec<Graded> {
    let answers: Vec<Result<Answer, String>> =
        paths.iter().map(|path| read(path).map_err(|failure| reason(&failure))).collect();
    let is_skipped = |answer: &Answer| lesson.is_some_and(|lesson| lesson != answer.lesson());
    let mut distinct: BTreeMap<String, &Answer> = BTreeMap::new();
    for answer in answers.iter().flatten().filter(|answer| !is_skipped(answer)) {
        distinct.entry(run_keys(&answer.experiment)).or_insert(answer);
    }
    let distinct: Vec<(String, &Answer)> = distinct.into_iter().collect();
    let reruns: HashMap<String, Result<Rerun, String>> = distinct
        .par_iter()
        .map(|(keys, answer)| {
            let done = rerun(answer, interrupt).map_err(|failure| reason(&failure));
            (keys.clone(), done)
        })
        .collect();
    let (mut seen, mut seen_runs) = (HashMap::new(), HashMap::new());
    let graded = paths.iter().zip(&answers).map(|(path, answer)| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let file = one_line(&shortened(&name, LONGEST_NAME)).into_owned();
        let mut graded = Graded {
            file,
            exercise: String::new(),
            result: Ok(Vec::new()),
            is_skipped: false,
            identical_to: None,
            same_runs_as: None,
        };
        let answer = match answer {
            Err(reason) => {
                graded.result = Err(reason.clone());
                return graded;
            }
            Ok(answer) => answer,
        };
        let Answer { name, value, unit, standard_error, .. } = answer;
        graded.exercise.clone_from(name);
        if is_skipped(answer) {
            graded.result = Err(format!("a hand-in of the lesson {}", answer.lesson()));
            graded.is_skipped = true;
            return graded;
        }
        let keys = run_keys(&answer.experiment);
        graded.result = match &reruns[&keys] {
            Err(reason) => Err(reason.clone()),
            Ok(rerun) => match Key::of(answer, solutions) {
                Err(failure) => Err(reason(&failure)),
                Ok(key) => Ok(findings(answer, &key, rerun)),
            },
        };
        let content = format!("{name} {keys} {value:?} {unit} {standard_error:?}");
        graded.identical_to = first_of(&mut seen, content, &graded.file);
        graded.same_runs_as = first_of(&mut seen_runs, (name, keys), &graded.file);
        graded
    });
    graded.collect()
}

/// The first file with this content, if it is an earlier one.
fn first_of<K: Eq + Hash>(seen: &mut HashMap<K, String>, content: K, file: &str) -> Option<String> {
    let earlier = seen.get(&content).cloned();
    seen.entry(content).or_insert_with(|| file.to_owned());
    earlier
}

fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// The hand-ins of a folder and its other files, except hidden ones, in the order of their names.
pub(crate) fn hand_ins(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = fs::read_dir(folder).map_err(|error| {
        let what = format!("cannot read the folder {}: {error}", shown_path(folder));
        unread(&error, what, "name the folder of the hand-ins")
    })?;
    let is_hidden =
        |path: &Path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| is_toml(path) || !path.is_dir() && !is_hidden(path));
    if paths.is_empty() {
        let what = format!("the folder {} has no hand-ins (*.toml)", shown_path(folder));
        return Err(bad(what).help("copy the hand-ins of the class into it"));
    }
    paths.sort();
    Ok(paths)
}

fn read(path: &Path) -> Result<Answer, Failure> {
    if path.is_symlink() {
        return Err(bad("a symbolic link"));
    }
    if !is_toml(path) {
        return Err(bad("not a *.toml file"));
    }
    Answer::read_hand_in(path)
}

/// The table of a class.
pub(crate) fn table(graded: &[Graded]) -> String {
    let width = |text: fn(&Graded) -> &str, title: usize| {
        graded.iter().map(|one| text(one).chars().count()).fold(title, std::cmp::Ord::max)
    };
    let (file, exercise) = (width(|one| &one.file, 7), width(|one| &one.exercise, 8));
    let mut lines = vec![format!("{:file$}  {:exercise$}  result", "hand-in", "exercise")];
    for one in graded {
        lines.push(format!("{:file$}  {:exercise$}  {}", one.file, one.exercise, one.text()));
    }
    let accepted = graded.iter().filter(|one| one.is_accepted()).count();
    let identical = graded.iter().filter(|one| one.identical_to.is_some()).count();
    let graded = graded.iter().filter(|one| !one.is_skipped).count();
    let all = plural(graded as u64, "hand-in");
    lines.push(format!("{accepted} of {all} accepted, {identical} identical to an earlier one"));
    lines.join("\n")
}

/// The table as JSON.
pub(crate) fn document(graded: &[Graded]) -> Json {
    graded.iter().map(Graded::json).collect()
}

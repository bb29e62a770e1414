//! A folder of hand-ins: each distinct manifest is rerun once, and each hand-in has one line.

use crate::grading::answer::Answer;
use crate::grading::findings::{Finding, findings};
use crate::grading::key::Key;
use crate::grading::rerun::{Rerun, rerun, run_keys};
use crate::messages::Failure;
use kinetoscope::interrupt::Interrupt;
use kinetoscope_console::text::{one_line, plural, shortened};
use kinetoscope_console::without_styles;
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};
use serde_json::{Value as Json, json};
use std::collections::{BTreeMap, HashMap};
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
    /// The first hand-in with the same manifest and answer.
    identical_to: Option<String>,
}

impl Graded {
    /// Whether the answer is right.
    pub(crate) fn is_accepted(&self) -> bool {
        self.result.as_ref().is_ok_and(Vec::is_empty)
    }

    fn text(&self) -> String {
        let mut text = match &self.result {
            Err(reason) => format!("not graded: {reason}"),
            Ok(found) if found.is_empty() => "accepted".to_owned(),
            Ok(found) => found.iter().map(|it| it.text.as_str()).collect::<Vec<_>>().join("; "),
        };
        text = shortened(&text, LONGEST_REASON).into_owned();
        if let Some(other) = &self.identical_to {
            text += &format!(" (identical to {other})");
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
            "identical_to": self.identical_to,
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
        paths.iter().map(|path| read(path, lesson).map_err(|failure| reason(&failure))).collect();
    let mut distinct: BTreeMap<String, &Answer> = BTreeMap::new();
    for answer in answers.iter().flatten() {
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
    let mut seen: HashMap<String, String> = HashMap::new();
    let graded = paths.iter().zip(&answers).map(|(path, answer)| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let file = one_line(&shortened(&name, LONGEST_NAME)).into_owned();
        let Ok(answer) = answer else {
            let result = Err(answer.as_ref().err().cloned().unwrap_or_default());
            return Graded { file, exercise: String::new(), result, identical_to: None };
        };
        let keys = run_keys(&answer.experiment);
        let result = match &reruns[&keys] {
            Err(reason) => Err(reason.clone()),
            Ok(rerun) => match Key::of(answer, solutions) {
                Err(failure) => Err(reason(&failure)),
                Ok(key) => Ok(findings(answer, &key, rerun)),
            },
        };
        let Answer { name, value, unit, standard_error, .. } = answer;
        let content = format!("{name} {keys} {value:?} {unit} {standard_error:?}");
        let identical_to = seen.get(&content).cloned();
        seen.entry(content).or_insert_with(|| file.clone());
        Graded { file, exercise: name.clone(), result, identical_to }
    });
    graded.collect()
}

fn read(path: &Path, lesson: Option<&str>) -> Result<Answer, Failure> {
    let answer = Answer::read_hand_in(path)?;
    match lesson.filter(|lesson| *lesson != answer.lesson()) {
        None => Ok(answer),
        Some(_) => {
            let what = format!("a hand-in of the lesson {}", answer.lesson());
            Err(crate::messages::bad(what))
        }
    }
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
    let all = plural(graded.len() as u64, "hand-in");
    lines.push(format!("{accepted} of {all} accepted, {identical} identical to an earlier one"));
    lines.join("\n")
}

/// The table as JSON.
pub(crate) fn document(graded: &[Graded]) -> Json {
    graded.iter().map(Graded::json).collect()
}

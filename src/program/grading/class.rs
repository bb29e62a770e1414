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
use rayon::iter::{IndexedParallelIterator as _, IntoParallelIterator as _, ParallelIterator as _};
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
    /// Whether nothing shows that it was edited afterward.
    has_no_hash: bool,
    /// Whether it belongs to another lesson than the one that is graded.
    is_skipped: bool,
    /// The first hand-in with the same manifest and answer.
    identical_to: Option<String>,
    /// The first hand-in of the exercise with the same manifest, whatever its answer.
    same_runs_as: Option<String>,
}

impl Graded {
    fn of(path: &Path) -> Self {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Self {
            file: one_line(&shortened(&name, LONGEST_NAME)).into_owned(),
            exercise: String::new(),
            result: Ok(Vec::new()),
            has_no_hash: false,
            is_skipped: false,
            identical_to: None,
            same_runs_as: None,
        }
    }

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
        if self.has_no_hash {
            text += " (no hash)";
        }
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
            "has_no_hash": self.has_no_hash,
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

/// The reruns of hand-ins by exercise and run keys.
type Reruns = HashMap<(String, String), Result<Rerun, String>>;

fn rerun_key(answer: &Answer) -> (String, String) {
    (answer.name.clone(), run_keys(&answer.experiment))
}

/// Executes the distinct runs of each exercise once, if it has a key.
fn reruns<'a>(
    answers: impl Iterator<Item = &'a Answer>,
    keys: &HashMap<&str, Result<Key, String>>,
    interrupt: &Interrupt,
) -> Reruns {
    let mut distinct = BTreeMap::new();
    for answer in answers {
        if let Some(Ok(key)) = keys.get(answer.name.as_str()) {
            distinct.entry(rerun_key(answer)).or_insert((answer, key));
        }
    }
    let distinct: Vec<_> = distinct.into_iter().collect();
    let rerun_one = |((name, runs), (answer, key)): ((String, String), (&Answer, &Key))| {
        ((name, runs), rerun(answer, Some(key), interrupt).map_err(|failure| reason(&failure)))
    };
    // One at a time, because their times differ by factors of hundreds.
    distinct.into_par_iter().with_max_len(1).map(rerun_one).collect()
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
    let wanted = || answers.iter().flatten().filter(|answer| !is_skipped(answer));
    let mut keys: HashMap<&str, Result<Key, String>> = HashMap::new();
    for answer in wanted() {
        keys.entry(&answer.name)
            .or_insert_with(|| Key::of(answer, solutions).map_err(|failure| reason(&failure)));
    }
    let reruns = reruns(wanted(), &keys, interrupt);
    let (mut seen, mut seen_runs) = (HashMap::new(), HashMap::new());
    let graded = paths.iter().zip(&answers).map(|(path, answer)| {
        let mut graded = Graded::of(path);
        let answer = match answer {
            Err(reason) => {
                graded.result = Err(reason.clone());
                return graded;
            }
            Ok(answer) => answer,
        };
        let Answer { name, value, unit, standard_error, hash, .. } = answer;
        graded.exercise.clone_from(name);
        if is_skipped(answer) {
            graded.result = Err(format!("a hand-in of the lesson {}", answer.lesson()));
            graded.is_skipped = true;
            return graded;
        }
        let runs = rerun_key(answer);
        graded.has_no_hash = hash.is_none();
        graded.result = match &keys[name.as_str()] {
            Err(reason) => Err(reason.clone()),
            Ok(key) => {
                reruns[&runs].as_ref().map_err(Clone::clone).map(|it| findings(answer, key, it))
            }
        };
        let content = format!("{runs:?} {value:?} {unit} {standard_error:?}");
        graded.identical_to = first_of(&mut seen, content, &graded.file);
        graded.same_runs_as = first_of(&mut seen_runs, runs, &graded.file);
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

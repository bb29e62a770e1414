//! `grade`: compares the answers of exercises with reruns of their manifests.

mod answer;
mod class;
mod findings;
mod hand_in;
mod key;
mod limits;
mod rerun;

use crate::comparison::rerun::{listen, stop_if_interrupted};
use crate::messages::Failure;
use crate::messages::result_arguments::ResultArguments;
use answer::Answer;
use clap::Args;
use class::json_of;
use findings::{Finding, findings};
use key::{Key, check_lesson};
use kinetoscope::interrupt::Interrupt;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use rerun::{Rerun, rerun, run_keys};
use serde_json::{Value as Json, json};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// The limits, as the help states them.
const LIMITS: &str = "Limits of an answer: 64 runs, 20,000 particles per run, 64 MiB and 60 s for all runs, 30 s for others than those of the exercise, and 4 times their work and particles; a hand-in has at most 1,024 bytes.";

/// Grade answers of exercises by rerunning their manifests
#[derive(Debug, Args)]
#[command(after_long_help = LIMITS)]
pub(crate) struct GradeArguments {
    /// Completed exercises (*.toml)
    #[arg(value_name = "EXERCISE", required_unless_present = "class")]
    paths: Vec<PathBuf>,
    /// Rerun the answer and write its hand-in, at most 1,024 bytes with the hash of its runs; needs no key
    #[arg(long, value_name = "FILE", conflicts_with = "class")]
    hand_in: Option<PathBuf>,
    /// Grade a folder of hand-ins, one line each; identical ones are listed
    #[arg(long, value_name = "DIR", conflicts_with = "paths")]
    class: Option<PathBuf>,
    /// Grade only hand-ins of this lesson
    #[arg(long, requires = "class")]
    lesson: Option<String>,
    /// Folder of the keys [default: `solutions` next to a folder above the exercise]
    #[arg(long, value_name = "DIR")]
    solutions: Option<PathBuf>,
    #[command(flatten)]
    result: ResultArguments,
}

impl GradeArguments {
    /// Grades what the arguments name.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        let done = match &self.class {
            Some(folder) => self.grade_class(folder),
            None => self.grade_answers(),
        };
        self.result.concluded(done.unwrap_or_else(|failure| self.result.failed(&failure)))
    }

    fn grade_class(&self, folder: &Path) -> Result<Exit, Failure> {
        let interrupt = &listen()?;
        let paths = class::hand_ins(folder)?;
        let (lesson, solutions) = (self.lesson.as_deref(), self.solutions.as_deref());
        if let Some(lesson) = lesson {
            check_lesson(lesson, solutions, &paths)?;
        }
        let graded = class::grade(&paths, lesson, solutions, interrupt);
        stop_if_interrupted(interrupt)?;
        if self.result.json {
            self.result.print_json(&class::document(&graded));
        }
        self.result.say_commands(&class::table(&graded));
        let has_failed = graded.iter().any(class::Graded::is_failure);
        Ok(if has_failed { Exit::Differs } else { Exit::Done })
    }

    fn grade_answers(&self) -> Result<Exit, Failure> {
        let interrupt = &listen()?;
        let (mut exit, mut documents, mut reruns) = (Exit::Done, Vec::new(), HashMap::new());
        for path in &self.paths {
            match self.grade_answer(path, interrupt, &mut reruns) {
                Ok((graded, document)) => {
                    exit = exit.worst(graded);
                    documents.push(document);
                }
                Err(failure) => {
                    stop_if_interrupted(interrupt)?;
                    exit = exit.worst(failure.report());
                    documents.push(json!({ "file": path, "error": failure.plain_text() }));
                }
            }
        }
        if self.result.json {
            self.result.print_json(&Json::Array(documents));
        }
        Ok(exit)
    }

    fn grade_answer(
        &self,
        path: &Path,
        interrupt: &Interrupt,
        reruns: &mut HashMap<String, Rc<Rerun>>,
    ) -> Result<(Exit, Json), Failure> {
        let answer = Answer::read(path)?;
        if let Some(file) = &self.hand_in {
            hand_in::check(&answer, file)?;
        }
        let key = Key::of(&answer, self.solutions.as_deref());
        let keys = run_keys(&answer.experiment);
        let rerun = match reruns.get(&keys) {
            Some(rerun) => Rc::clone(rerun),
            // Without a key, the answer can be handed in.
            None if self.hand_in.is_some() => {
                Rc::new(rerun(&answer, key.as_ref().ok(), interrupt)?)
            }
            None => Rc::new(rerun(&answer, Some(key.as_ref().map_err(Clone::clone)?), interrupt)?),
        };
        reruns.insert(keys, Rc::clone(&rerun));
        if let Some(file) = &self.hand_in {
            hand_in::write(&answer, &rerun, file)?;
            self.result.say(&format!("{}: written to {}", answer.name, shown_path(file)));
            return Ok((Exit::Done, json!({ "exercise": answer.name, "hash": rerun.hash })));
        }
        let found = findings(&answer, &key?, &rerun);
        self.result.say(&text_of(&answer.name, &found));
        let listed: Vec<Json> = found.iter().map(json_of).collect();
        let document = json!({
            "file": path, "exercise": answer.name, "accepted": found.is_empty(), "findings": listed,
        });
        Ok((if found.is_empty() { Exit::Done } else { Exit::Differs }, document))
    }
}

fn text_of(exercise: &str, found: &[Finding]) -> String {
    if found.is_empty() {
        return format!("{exercise}: accepted");
    }
    let lines: Vec<String> = found.iter().map(|one| format!("\n  {}", one.text)).collect();
    format!("{exercise}: not accepted{}", lines.concat())
}

//! `why`: reports for each run whether it would be executed, and what differs from the nearest recording.

use crate::comparison::rerun::{listen, stop_if_interrupted};
use crate::manifests::pipeline;
use crate::manifests::{ManifestArguments, ManifestReader};
use crate::messages::exit;
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, bad, name_of};
use crate::output::OutputArguments;
use crate::planning::plan_report::not_planned;
use crate::planning::planner::Planner;
use clap::Args;
use kinetoscope::plan::why::{Earlier, Reason};
use kinetoscope::plan::{Plan, Status};
use kinetoscope_analysis::each_stored_outcome;
use kinetoscope_console::Exit;
use kinetoscope_console::text::{plural, shown_path};
use kinetoscope_files::output_file;
use kinetoscope_manifest::RunKey;
use serde_json::{Value as Json, json};
use std::cmp::Reverse;
use std::collections::{BTreeMap, HashSet};
use std::io;
use std::path::{Path, PathBuf};

/// Report for each run whether it is finished, and otherwise which keys differ from the nearest recording.
#[derive(Debug, Args)]
pub(crate) struct WhyArguments {
    /// Manifest (TOML file)
    #[arg(value_name = "MANIFEST")]
    path: PathBuf,
    #[command(flatten)]
    manifest: ManifestArguments,
    #[command(flatten)]
    output: OutputArguments,
    /// Write the reason for each run to a file; without it, more than 50 runs are counted by their reasons
    #[arg(long, value_name = "FILE")]
    list: Option<PathBuf>,
    #[command(flatten)]
    result: ResultArguments,
}

/// Maximum number of runs whose reasons are each printed.
const MOST_LISTED: usize = 50;

impl WhyArguments {
    /// Prints the reason for each run.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        self.result.concluded(self.explain().unwrap_or_else(|failure| self.result.failed(&failure)))
    }

    fn explain(&self) -> Result<Exit, Failure> {
        if self.output.is_remote() {
            return Err(bad("`why` needs a local folder, but the recordings go to s3://")
                .help("name a folder of recordings with --output DIR"));
        }
        if let Some(file) = &self.list {
            output_file::check(file).map_err(|error| unwritten(file, &error))?;
        }
        let interrupt = &listen()?;
        let overrides = self.manifest.overrides()?;
        let output = self.output.folder()?;
        let reader = ManifestReader::new(output, None);
        let steps = pipeline::order(std::slice::from_ref(&self.path), &overrides, &reader)?;
        let own = steps.iter().find(|step| step.is_named);
        if let Some((step, why)) = own.and_then(|step| Some((step, reader.missing_start(step)?))) {
            let text = not_planned(step, why)?;
            self.result
                .print(&text, || json!({ "manifest": step.manifest, "pending": step.starts_from }));
            return Ok(Exit::Done);
        }
        let experiment = reader.read(&self.path, &overrides)?;
        let output = &self.output;
        let planner = Planner {
            output,
            keys: None,
            force: false,
            jobs: None,
            is_outline: true,
            interrupt,
            verbosity: self.result.verbosity(),
        };
        let planned = planner.plan(&experiment)?;
        stop_if_interrupted(interrupt)?;
        let plan = &planned.plan;
        let earlier = Earlier::in_folder(&plan.folder);
        let has_row = experiment.keeps_only_metrics().then(|| runs_with_rows(plan)).transpose()?;
        let is_listed = self.list.is_some() || plan.runs.len() <= MOST_LISTED;
        let (mut lines, mut runs) = (Vec::new(), Vec::<Json>::new());
        let mut kinds: BTreeMap<String, usize> = BTreeMap::new();
        for (at, run) in plan.runs.iter().enumerate() {
            stop_if_interrupted(interrupt)?;
            let (Reason { text: reason, kind }, status) = match (&has_row, &run.status) {
                (Some(has_row), Status::Done(_) | Status::ToDo(_)) => reason_of_row(has_row[at]),
                (_, Status::Done(_)) => (earlier.reason(run, &plan.folder), "finished"),
                (_, Status::ToDo(_)) => (earlier.reason(run, &plan.folder), "to do"),
                (_, Status::Rejected(_)) => (earlier.reason(run, &plan.folder), "rejected"),
            };
            *kinds.entry(kind).or_default() += 1;
            if !is_listed && !self.result.json {
                continue;
            }
            let name = name_of(run, &experiment);
            lines.push(format!("{name}: {reason}"));
            if self.result.json {
                runs.push(json!({
                    "run": name,
                    "run_key": run.run_key.as_str(),
                    "status": status,
                    "reason": reason,
                }));
            }
        }
        let text = self.reasons(&experiment.name, plan.runs.len(), &lines, &kinds)?;
        self.result.print(
            &text,
            || json!({ "experiment": experiment.name, "folder": plan.folder, "runs": runs }),
        );
        Ok(if plan.rejected().next().is_some() { Exit::BadInput } else { Exit::Done })
    }
}

impl WhyArguments {
    /// The text to print: the reason for each run, or the number of runs by their reasons. The list is written if it is requested.
    fn reasons(
        &self,
        name: &str,
        runs: usize,
        lines: &[String],
        kinds: &BTreeMap<String, usize>,
    ) -> Result<String, Failure> {
        let text = lines.join("\n");
        if let Some(file) = &self.list {
            output_file::write(file, format!("{text}\n").as_bytes())
                .map_err(|error| unwritten(file, &error))?;
        }
        if runs <= MOST_LISTED {
            return Ok(text);
        }
        let place = match &self.list {
            Some(file) => format!("The reasons for each run are in {}", shown_path(file)),
            None => "--list FILE writes the reason for each run".to_owned(),
        };
        Ok(format!("{}\n{place}", counted(name, runs, kinds)))
    }
}

/// For each run of a plan, whether the table in its folder has a row of it.
fn runs_with_rows(plan: &Plan) -> Result<Vec<bool>, Failure> {
    let (mut found, mut others, mut next) = (vec![false; plan.runs.len()], HashSet::new(), 0);
    each_stored_outcome(&plan.folder, |row| {
        // A finished sweep has its rows in the order of the plan, and no key of it is kept in memory.
        match plan.runs.get(next) {
            Some(run) if run.run_key.as_str() == row.run_key => found[next] = true,
            _ => others.extend(RunKey::from_hex(&row.run_key)),
        }
        next += 1;
    })
    .map_err(|error| Failure::of(Exit::Unreadable, error.message))?;
    for (found, run) in found.iter_mut().zip(&plan.runs) {
        *found |= others.contains(&run.run_key);
    }
    Ok(found)
}

/// The reason and the status of a run of which only the metrics are kept.
fn reason_of_row(has_row: bool) -> (Reason, &'static str) {
    let (text, status) = match has_row {
        true => ("finished", "finished"),
        false => ("to do: no row in runs.parquet", "to do"),
    };
    (Reason { text: text.to_owned(), kind: text.to_owned() }, status)
}

/// The number of runs by their reasons, the most frequent first.
fn counted(name: &str, runs: usize, kinds: &BTreeMap<String, usize>) -> String {
    let mut kinds: Vec<(&String, &usize)> = kinds.iter().collect();
    kinds.sort_by_key(|(_, count)| Reverse(**count));
    let lines = kinds.iter().map(|(kind, count)| format!("\n  {count} {kind}"));
    format!("{name}: {}{}", plural(runs as u64, "run"), lines.collect::<String>())
}

fn unwritten(file: &Path, error: &io::Error) -> Failure {
    let what = format!("cannot write {}: {error}", shown_path(file));
    Failure::new(exit::of_output(error), what).help("choose another file with --list FILE")
}

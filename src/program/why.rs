//! `why`: reports for each run whether it would be executed, and what differs from the nearest recording.

use crate::comparison::rerun::{listen, stop_if_interrupted};
use crate::manifests::pipeline;
use crate::manifests::{ManifestArguments, ManifestReader};
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, bad, name_of};
use crate::output::OutputArguments;
use crate::planning::plan_report::not_planned;
use crate::planning::planner::Planner;
use clap::Args;
use kinetoscope::plan::Status;
use kinetoscope::plan::why::Earlier;
use kinetoscope_console::Exit;
use serde_json::{Value as Json, json};
use std::path::PathBuf;

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
    #[command(flatten)]
    result: ResultArguments,
}

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
        let (mut lines, mut runs) = (Vec::new(), Vec::<Json>::new());
        for run in &plan.runs {
            stop_if_interrupted(interrupt)?;
            let name = name_of(run, &experiment);
            let reason = earlier.reason(run, &plan.folder);
            let status = match run.status {
                Status::Done(_) => "finished",
                Status::ToDo(_) => "to do",
                Status::Rejected(_) => "rejected",
            };
            lines.push(format!("{name}: {reason}"));
            runs.push(json!({
                "run": name,
                "run_key": run.run_key.as_str(),
                "status": status,
                "reason": reason,
            }));
        }
        self.result.print(
            &lines.join("\n"),
            || json!({ "experiment": experiment.name, "folder": plan.folder, "runs": runs }),
        );
        Ok(if plan.rejected().next().is_some() { Exit::BadInput } else { Exit::Done })
    }
}

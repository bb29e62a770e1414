//! `reproduce`: reruns the experiment of a bundle and compares every message.

use super::archive::{Archive, ArchiveError};
use super::contents::{BUNDLE, RECORDINGS, VERSION};
use super::results::{MAX_RESULT_BYTES, METRICS, REPORT, analyze, without_machine};
use crate::locking::lock::USUAL;
use crate::locking::locked_check::LockedCheck;
use crate::locking::locked_runs::{Parallel, Reruns};
use crate::messages::exit::{ON_FAILED_DISK, of_output};
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, bad};
use clap::Args;
use kinetoscope::verify::lock_file::{LockFile, RunHashes};
use kinetoscope_console::Exit;
use kinetoscope_console::text::{one_line, shown_path};
use kinetoscope_files::regular_file::{is_of_file, read, read_text};
use serde_json::Value as Json;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The folder of the rerun, below that of the bundle.
const RERUN: &str = "rerun";

/// Rerun the experiment of a bundle, and compare every message and every metric with those that were bundled
#[derive(Debug, Args)]
pub(crate) struct ReproduceArguments {
    /// The bundle, as `kinetoscope bundle` wrote it
    #[arg(value_name = "FILE")]
    bundle: PathBuf,
    /// Unpack the bundle into this new folder, and keep it [default: a temporary folder]
    #[arg(long, value_name = "DIR")]
    into: Option<PathBuf>,
    #[command(flatten)]
    parallel: Parallel,
    #[command(flatten)]
    result: ResultArguments,
}

impl ReproduceArguments {
    /// Checks the bundle, unpacks it, runs its manifest and compares.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        self.result
            .concluded(self.reproduce().unwrap_or_else(|failure| self.result.failed(&failure)))
    }

    fn reproduce(&self) -> Result<Exit, Failure> {
        let mut archive = Archive::open(&self.bundle).map_err(|error| self.unusable(error))?;
        let text = archive.text(BUNDLE).map_err(|error| self.unusable(error))?;
        let bundle: Json = serde_json::from_str(&text).unwrap_or_default();
        self.reject_other_version(&bundle)?;
        let temporary;
        let folder = match &self.into {
            Some(folder) => {
                fs::create_dir(folder).map_err(|error| unwritten(folder, &error))?;
                folder.as_path()
            }
            None => {
                temporary = tempfile::Builder::new()
                    .prefix("kinetoscope-")
                    .tempdir()
                    .map_err(|error| unwritten(&std::env::temp_dir(), &error))?;
                temporary.path()
            }
        };
        archive.unpack(folder).map_err(|error| match error {
            ArchiveError::Io(error) => unwritten(folder, &error),
            damaged @ ArchiveError::Damaged(_) => self.unusable(damaged),
        })?;
        let experiment = self.own_experiment(&bundle, folder)?;
        let rerun = folder.join(RERUN);
        Reruns::recorded(rerun.clone(), self.parallel)?
            .execute(&folder.join(format!("{experiment}.toml")))?;
        let bundled = folder.join(RECORDINGS);
        let check = LockedCheck {
            lock_file: &folder.join(USUAL),
            bundle: Some(&self.bundle),
            manifests: &[],
            all: true,
            quick: false,
            recordings: rerun.clone(),
            earlier: bundled.clone(),
            summary: None,
            recorded: true,
            parallel: self.parallel,
            result: &self.result,
        };
        let exit = check.execute()?;
        if exit != Exit::Done {
            return Ok(exit);
        }
        let (bundled, rerun) = (bundled.join(&experiment), rerun.join(&experiment));
        self.compare_results(&bundle, &bundled, &rerun)?;
        let text = |key: &str| one_line(bundle[key].as_str().unwrap_or_default()).into_owned();
        let said = ["question", "answer"].map(text).into_iter().filter(|line| !line.is_empty());
        self.result.say(&said.collect::<Vec<_>>().join("\n"));
        let shown = shown_path(&self.bundle);
        self.result.say(&format!(
            "{shown} is reproduced: every message, every metric, the plots and the report"
        ));
        Ok(exit)
    }

    /// The name of the experiment, if the bundle's parts are about the same one.
    fn own_experiment(&self, bundle: &Json, folder: &Path) -> Result<String, Failure> {
        let lock_file = folder.join(USUAL);
        let lock = LockFile::read(&lock_file).map_err(|error| {
            self.unusable(ArchiveError::Damaged(format!("its {USUAL} cannot be used: {error}")))
        })?;
        let named = bundle["experiment"].as_str().unwrap_or_default();
        let manifest = format!("{named}.toml");
        let keys = bundle["runs"].as_array().into_iter().flatten().filter_map(Json::as_str);
        let keys: Vec<String> = keys.map(str::to_owned).collect();
        let is_own = matches!(lock.experiments.as_slice(), [only]
            if only.manifest == manifest && RunHashes::new(&keys, &[]).keys == only.keys);
        if is_own && bundle["manifest"] == manifest.as_str() && !named.contains('/') {
            return Ok(named.to_owned());
        }
        let what = format!("{BUNDLE} and {USUAL} are about different experiments");
        Err(self.unusable(ArchiveError::Damaged(what)))
    }

    /// Compares the bundled results with those of the rerun.
    fn compare_results(&self, bundle: &Json, bundled: &Path, rerun: &Path) -> Result<(), Failure> {
        let differs = |what: String| {
            let program =
                one_line(bundle["program"]["version"].as_str().unwrap_or("unknown")).into_owned();
            Failure::new(Exit::Differs, what).help(format!(
                "the messages are equal; version {program} of the program analyzed them, this is {}",
                env!("CARGO_PKG_VERSION")
            ))
        };
        for name in analyze(rerun)? {
            let [one, other] = [bundled, rerun].map(|folder| {
                let bytes = read(&folder.join(&name), MAX_RESULT_BYTES).ok()?;
                let report = || without_machine(&String::from_utf8_lossy(&bytes)).into_bytes();
                Some(if name == REPORT { report() } else { bytes })
            });
            if one.is_none() || one != other {
                return Err(differs(format!("the bundled {name} is not that of the rerun")));
            }
        }
        let text = read_text(&rerun.join(METRICS), MAX_RESULT_BYTES).unwrap_or_default();
        let metrics: Json = serde_json::from_str(&text).unwrap_or_default();
        if metrics["question"] != bundle["question"]
            || metrics["answer"]["text"] != bundle["answer"]
        {
            return Err(differs(format!(
                "the question or the answer in {BUNDLE} is not that of the rerun"
            )));
        }
        Ok(())
    }

    fn reject_other_version(&self, bundle: &Json) -> Result<(), Failure> {
        match bundle["bundle"].as_u64() {
            Some(VERSION) => Ok(()),
            Some(version) => {
                let what = format!(
                    "{} has version {version} of the layout; this program reads version {VERSION}",
                    shown_path(&self.bundle)
                );
                let program = one_line(bundle["program"]["version"].as_str().unwrap_or("unknown"))
                    .into_owned();
                Err(Failure::new(Exit::Differs, what)
                    .help(format!("use the program that wrote it (version {program})")))
            }
            None => Err(self.unusable(ArchiveError::Damaged(format!("{BUNDLE} has no version")))),
        }
    }

    /// The error of a bundle that cannot be used.
    fn unusable(&self, error: ArchiveError) -> Failure {
        let shown = shown_path(&self.bundle);
        let what = format!("cannot use the bundle {shown}: {error}");
        match &error {
            ArchiveError::Io(io) if !is_of_file(io) => {
                Failure::new(Exit::Retryable, what).help(ON_FAILED_DISK)
            }
            ArchiveError::Io(io) if io.kind() == io::ErrorKind::NotFound => {
                bad(what).help("check the path")
            }
            ArchiveError::Io(_) | ArchiveError::Damaged(_) => Failure::new(Exit::Unreadable, what)
                .help("copy the file again from where it was published"),
        }
    }
}

/// The error of a folder for the bundle's files.
fn unwritten(folder: &Path, error: &io::Error) -> Failure {
    let what = format!("cannot write to {}: {error}", shown_path(folder));
    Failure::new(of_output(error), what).help("name a new folder with --into")
}

//! `reproduce`: reruns the experiment of a bundle and compares every message.

use super::archive::{Archive, ArchiveError, BUNDLE, Content, PACKAGES, RECORDINGS, hash_of};
use super::contents::{Claims, VERSION, files};
use super::description::Description;
use super::results::{MAX_RESULT_BYTES, REPORT, engine_in};
use super::starts::starts;
use crate::engine::ENGINE;
use crate::locking::lock::USUAL;
use crate::locking::locked_check::{COPY_AGAIN, LockedCheck};
use crate::locking::locked_runs::{Parallel, RerunExperiment, Reruns};
use crate::messages::exit::{ON_FAILED_DISK, of_output};
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, bad, plural};
use clap::Args;
use kinetoscope::verify::lock_file::{LockError, LockFile, LockedExperiment, RunHashes};
use kinetoscope_console::Exit;
use kinetoscope_console::text::{one_line, shown_path};
use kinetoscope_files::regular_file::{is_of_file, read_text};
use kinetoscope_recording::channels::SCHEMA_VERSION;
use serde_json::Value as Json;
use std::collections::BTreeMap;
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
    /// Run nothing: unpack the bundle, and name its page, which repeats the runs in a browser
    #[arg(long, requires = "into")]
    in_browser: bool,
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
        let entry = self.own_experiment(&bundle, folder)?;
        let experiment = entry.manifest.strip_suffix(".toml").unwrap_or_default();
        let report = folder.join(RECORDINGS).join(experiment).join(REPORT);
        let text = read_text(&report, MAX_RESULT_BYTES).unwrap_or_default();
        let engine: &'static [u8] = engine_in(&text).leak();
        if self.in_browser {
            return self.name_page(&report, engine);
        }
        let manifest = folder.join(&entry.manifest);
        let starts = self.own_starts(&manifest, &archive)?;
        let claims = self.claims(&bundle, &archive, folder, engine)?;
        let (runs, seconds) = (plural(entry.runs as u64, "run"), entry.at_most_s);
        self.result.say(&format!("{experiment}: {runs}, some {seconds} s by their steps"));
        let (repeated, exit) = self.repeat(&manifest, folder)?;
        if exit != Exit::Done {
            return Ok(exit);
        }
        self.compare(&bundle, &archive, &files(&manifest, &repeated, &claims)?)?;
        let text = |key: &str| one_line(bundle[key].as_str().unwrap_or_default()).into_owned();
        let said = ["question", "answer"].map(text).into_iter().filter(|line| !line.is_empty());
        self.result.say(&said.collect::<Vec<_>>().join("\n"));
        let shown = shown_path(&self.bundle);
        self.result.say(&format!(
            "{shown} is reproduced: every message, every metric, the plots and the report"
        ));
        for start in starts.keys().filter(|name| name.ends_with(".mcap")) {
            self.result.say(&format!(
                "The runs start from {start}, which was not repeated; `kinetoscope verify` repeats it"
            ));
        }
        if !engine.is_empty() && engine != ENGINE {
            self.result
                .say("The engine in the report is that of another program, and was not checked");
        }
        Ok(exit)
    }

    /// Runs the manifest and compares the messages with the lock file of the bundle.
    fn repeat(&self, manifest: &Path, folder: &Path) -> Result<(RerunExperiment, Exit), Failure> {
        // A folder of the bundle with this name would contain finished runs, which are not repeated.
        let rerun = folder.join(RERUN);
        fs::create_dir(&rerun).map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => {
                let what = format!("it contains \"{RERUN}\", which is the folder of the rerun");
                self.unusable(ArchiveError::Damaged(what))
            }
            _ => unwritten(&rerun, &error),
        })?;
        let reruns = Reruns::recorded(rerun.clone(), self.parallel)?;
        let repeated = reruns.execute(manifest)?;
        let check = LockedCheck {
            lock_file: &folder.join(USUAL),
            bundle: Some(&self.bundle),
            manifests: &[],
            all: true,
            quick: false,
            recordings: rerun,
            earlier: folder.join(RECORDINGS),
            summary: None,
            recorded: true,
            parallel: self.parallel,
            result: &self.result,
        };
        Ok((repeated, check.execute()?))
    }

    /// Names the page that repeats the runs.
    fn name_page(&self, report: &Path, engine: &[u8]) -> Result<Exit, Failure> {
        if engine.is_empty() {
            let what = format!(
                "the report in {} has no engine for browsers: the program that wrote it was built without one",
                shown_path(&self.bundle)
            );
            return Err(bad(what).help("leave --in-browser out"));
        }
        self.result.say(&format!(
            "Open {} in a browser, and choose \"Verify in this browser\"",
            shown_path(report)
        ));
        Ok(Exit::Done)
    }

    /// What the bundle says beyond what its manifest determines.
    fn claims(
        &self,
        bundle: &Json,
        archive: &Archive,
        folder: &Path,
        engine: &'static [u8],
    ) -> Result<Claims, Failure> {
        let description = Description::of_bundle(bundle).map_err(|_| {
            let what = format!("{BUNDLE} names no author or no license");
            self.unusable(ArchiveError::Damaged(what))
        })?;
        let name = bundle["experiment"].as_str().unwrap_or_default();
        let results = format!("{RECORDINGS}/{name}/");
        let is_recording = |file: &String| file.starts_with(&results) && file.ends_with(".mcap");
        let packages = archive.hashes.contains_key(PACKAGES);
        Ok(Claims {
            description,
            program: bundle["program"].clone(),
            packages: packages.then(|| Content::File(folder.join(PACKAGES))),
            engine,
            finished: bundle["finished"].as_str().unwrap_or_default().to_owned(),
            with_recordings: archive.hashes.keys().any(is_recording),
        })
    }

    /// The files that the manifest starts from, all of which are in the bundle.
    fn own_starts(
        &self,
        manifest: &Path,
        archive: &Archive,
    ) -> Result<BTreeMap<String, PathBuf>, Failure> {
        let starts = starts(manifest)?;
        match starts.keys().find(|name| !archive.hashes.contains_key(*name)) {
            None => Ok(starts),
            Some(name) => {
                let what = format!(
                    "its manifest starts from {}, which it does not contain",
                    one_line(name)
                );
                Err(self.unusable(ArchiveError::Damaged(what)))
            }
        }
    }

    /// The entry of the experiment, if the bundle's parts are about the same one.
    fn own_experiment(&self, bundle: &Json, folder: &Path) -> Result<LockedExperiment, Failure> {
        let lock_file = folder.join(USUAL);
        let lock = LockFile::read(&lock_file).map_err(|error| {
            let what = format!("its {USUAL} cannot be used: {error}");
            match error {
                LockError::OtherVersion(_) => of_other_program(bundle, what),
                _ => self.unusable(ArchiveError::Damaged(what)),
            }
        })?;
        let named = bundle["experiment"].as_str().unwrap_or_default();
        let manifest = format!("{named}.toml");
        let keys = bundle["runs"].as_array().into_iter().flatten().filter_map(Json::as_str);
        let keys: Vec<String> = keys.map(str::to_owned).collect();
        let is_named = bundle["manifest"] == manifest.as_str() && !named.contains('/');
        if let [only] = lock.experiments.as_slice()
            && is_named
            && only.manifest == manifest
            && RunHashes::new(&keys, &[]).keys == only.keys
        {
            return Ok(only.clone());
        }
        let what = format!("{BUNDLE} and {USUAL} are about different experiments");
        Err(self.unusable(ArchiveError::Damaged(what)))
    }

    /// Compares all files with those of a bundle of the rerun, first the results and then what describes them.
    fn compare(
        &self,
        bundle: &Json,
        archive: &Archive,
        expected: &BTreeMap<String, Content>,
    ) -> Result<(), Failure> {
        let program =
            one_line(bundle["program"]["version"].as_str().unwrap_or("unknown")).into_owned();
        let differs = |what: String| {
            Failure::new(Exit::Differs, what).help(format!(
                "the messages are equal; version {program} of the program wrote the bundle, this is {}",
                env!("CARGO_PKG_VERSION")
            ))
        };
        let is_result = |name: &String| name.starts_with(RECORDINGS);
        let (results, others): (Vec<_>, Vec<_>) =
            expected.iter().partition(|(name, _)| is_result(name));
        for (name, content) in results.into_iter().chain(others) {
            let shown = one_line(name);
            let Some(bundled) = archive.hashes.get(name) else {
                return Err(differs(format!("the bundle has no {shown}, which the rerun has")));
            };
            let hash = hash_of(content)
                .map_err(|error| Failure::new(Exit::Retryable, error).help(ON_FAILED_DISK))?;
            if *bundled != hash {
                let keys = match (name.as_str(), content) {
                    (BUNDLE, Content::Text(text)) => different_keys(bundle, text),
                    _ => String::new(),
                };
                return Err(differs(format!("the bundled {shown} is not that of the rerun{keys}")));
            }
        }
        match archive.hashes.keys().find(|name| !expected.contains_key(*name)) {
            None => Ok(()),
            Some(name) => Err(differs(format!("{} is not a result of the rerun", one_line(name)))),
        }
    }

    /// Rejects a bundle of another layout, or of other recordings.
    fn reject_other_version(&self, bundle: &Json) -> Result<(), Failure> {
        let shown = shown_path(&self.bundle);
        let what = match (bundle["bundle"].as_u64(), bundle["schema_version"].as_u64()) {
            (Some(VERSION), Some(schema)) if schema != u64::from(SCHEMA_VERSION) => format!(
                "{shown} was written for recording schema {schema}; this program records schema {SCHEMA_VERSION}"
            ),
            (Some(VERSION), Some(_)) => return Ok(()),
            (Some(version), _) if version != VERSION => format!(
                "{shown} has version {version} of the layout; this program reads version {VERSION}"
            ),
            _ => {
                let what = format!("{BUNDLE} has no version");
                return Err(self.unusable(ArchiveError::Damaged(what)));
            }
        };
        Err(of_other_program(bundle, what))
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
            ArchiveError::Io(_) | ArchiveError::Damaged(_) => {
                Failure::new(Exit::Unreadable, what).help(COPY_AGAIN)
            }
        }
    }
}

/// The error of a bundle that only another program can read.
fn of_other_program(bundle: &Json, what: String) -> Failure {
    let program = one_line(bundle["program"]["version"].as_str().unwrap_or("unknown")).into_owned();
    Failure::new(Exit::Differs, what)
        .help(format!("use the program that wrote it (version {program})"))
}

/// The keys of a bundle's summary that are not those of the rerun, as the end of a sentence.
fn different_keys(bundle: &Json, rerun: &str) -> String {
    let rerun: Json = serde_json::from_str(rerun).unwrap_or_default();
    let keys = bundle.as_object().into_iter().flat_map(|keys| keys.iter());
    let others: Vec<_> = keys
        .filter(|(key, value)| rerun.get(key.as_str()) != Some(*value))
        .map(|(key, _)| one_line(key).into_owned())
        .collect();
    match others.as_slice() {
        [] => ": its values are equal, but it is written differently".to_owned(),
        _ => format!(": {}", others.join(", ")),
    }
}

/// The error of a folder for the bundle's files.
fn unwritten(folder: &Path, error: &io::Error) -> Failure {
    let what = format!("cannot write to {}: {error}", shown_path(folder));
    Failure::new(of_output(error), what).help("name a new folder with --into")
}

//! Reads the manifests of the command line: files, folders, and the manifests that `start_from` names.

pub(crate) mod pipeline;
mod plotted_fields;
pub(crate) mod starter;
pub(crate) mod step;

use crate::manifests::step::Step;
use crate::messages::exit::unread;
use crate::messages::{Failure, bad, has_colors};
use crate::shipped::Shipped;
use clap::Args;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::plan::{Plan, Status};
use kinetoscope::run::restart_files::StartFiles;
use kinetoscope_analysis::{figure_names, fitted_along, metric_names, unit_of};
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::folder::folder_of;
use kinetoscope_files::regular_file::{self, MAX_MANIFEST_BYTES, read_text};
use kinetoscope_manifest::{
    Experiment, ExperimentRecord, Lookup, Override, is_manifest_name, nearest, parse_with,
};
use kinetoscope_recording::recorder::Outcome;
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

/// Changes to the manifests of the command line.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Manifest")]
pub(crate) struct ManifestArguments {
    /// Override a key of the manifest, such as model.gas.particles=5000
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

impl ManifestArguments {
    /// The overrides as the manifest takes them.
    pub(crate) fn overrides(&self) -> Result<Vec<Override>, Failure> {
        let read =
            |text: &String| match text.split_once('=') {
                Some((key, value)) => {
                    Ok(Override { key: key.trim().to_owned(), value: value.trim().to_owned() })
                }
                None => Err(bad(format!("`--set {text}` has no value"))
                    .help("write KEY=VALUE, such as seed=7")),
            };
        self.set.iter().map(read).collect()
    }
}

/// Replaces folders by the manifests in them, sorted by name; a manifest that is listed twice is kept once.
pub(crate) fn expand(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut manifests = Vec::new();
    for path in paths {
        if !path.is_dir() {
            manifests.push(path.clone());
            continue;
        }
        let entries = fs::read_dir(path).map_err(|error| {
            let what = format!("cannot read the folder {}: {error}", shown_path(path));
            unread(&error, what, "name a manifest, or a folder that you may list")
        })?;
        let mut found: Vec<PathBuf> = entries
            .flatten()
            .map(|entry| entry.path())
            .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
            .collect();
        if found.is_empty() {
            let what = format!("the folder {} has no manifest (*.toml)", shown_path(path));
            return Err(bad(what).help(CREATE_ONE));
        }
        found.sort();
        manifests.append(&mut found);
    }
    let mut seen = BTreeSet::new();
    manifests.retain(|path| seen.insert(canonical(path)));
    Ok(manifests)
}

/// The path that identifies a file, whatever the working folder.
pub(crate) fn canonical(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// The path that identifies a manifest with the folder of its `start_from`: of a symbolic link, that of the link.
fn location(manifest: &Path) -> PathBuf {
    match manifest.file_name() {
        Some(name) => canonical(folder_of(manifest)).join(name),
        None => canonical(Path::new(".")).join(manifest),
    }
}

/// The folder that the names in a manifest are relative to: an empty path for a bare name, not `.`, so that messages show the names
/// as the manifest has them.
pub(crate) fn base_of(manifest: &Path) -> &Path {
    manifest.parent().unwrap_or(Path::new(""))
}

/// Whether a file that is not text is an MCAP file.
fn is_recording(path: &Path, error: &io::Error) -> bool {
    const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
    let mut start = [0; MAGIC.len()];
    let is_binary = error.kind() == io::ErrorKind::InvalidData;
    let opened = regular_file::open(path).ok().filter(|_| is_binary);
    opened.is_some_and(|(mut file, _)| file.read_exact(&mut start).is_ok()) && start == MAGIC
}

const CREATE_ONE: &str = "`kinetoscope new gas --output gas.toml` writes a manifest in UTF-8; `kinetoscope new --list` names examples";

/// How to create a manifest: that of a shipped experiment, if a missing one has its name.
fn how_to_create(missing: &Path) -> String {
    let stem = missing.file_stem().unwrap_or_default().to_string_lossy();
    Shipped::named(&stem).map_or_else(
        || CREATE_ONE.to_owned(),
        |Shipped { name, .. }| {
            format!("`kinetoscope new {name} --output {name}.toml` writes this example")
        },
    )
}

/// The manifest with the name nearest to that of a missing one, in the same folder or in `experiments`; an exact name first.
fn nearest_manifest(missing: &Path) -> Option<PathBuf> {
    let wanted = missing.file_stem()?.to_string_lossy();
    let here = base_of(missing);
    let folders = [here.to_owned(), here.join("experiments"), PathBuf::from("experiments")];
    let found: Vec<PathBuf> = folders.iter().flat_map(|folder| manifests_in(folder)).collect();
    let stem = |path: &Path| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let names: Vec<String> = found.iter().filter_map(|path| stem(path)).collect();
    let exact = names.iter().find(|name| **name == *wanted).map(String::as_str);
    let near = exact.or_else(|| nearest(&wanted, names.iter().map(String::as_str)))?;
    found.into_iter().find(|path| stem(path).as_deref() == Some(near))
}

/// The manifests of a folder, sorted by name; none if it cannot be read.
fn manifests_in(folder: &Path) -> Vec<PathBuf> {
    let read = if folder == Path::new("") { Path::new(".") } else { folder };
    let entries = fs::read_dir(read).into_iter().flatten().flatten();
    let mut names: Vec<PathBuf> = entries.map(|entry| folder.join(entry.file_name())).collect();
    names.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    names.sort();
    names
}

/// Reads manifests. The recordings of manifests that `start_from` names are expected below `output`.
#[derive(Debug)]
pub(crate) struct ManifestReader<'a> {
    /// Folder of all recordings.
    pub(crate) output: PathBuf,
    /// Folder of the paths of `start_from`, if it is not that of the manifest.
    pub(crate) start_from_dir: Option<&'a Path>,
    /// The recordings of manifests that were searched, or why there is none.
    found: RefCell<BTreeMap<PathBuf, Result<PathBuf, NoRecording>>>,
    /// Number of manifests that are being searched, each because the previous one starts from it.
    depth: Cell<usize>,
}

/// Why a manifest that others start from has no recording.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum NoRecording {
    /// The run has not been executed or is unfinished.
    #[error("{0}")]
    Missing(String),
    /// The run failed, and would fail again.
    #[error("{0}")]
    Failed(String),
    /// The manifest cannot be started from.
    #[error("{0}")]
    Invalid(String),
}

/// Maximum number of manifests of which each starts from the next.
pub(crate) const MAX_STARTS: usize = 64;

impl<'a> ManifestReader<'a> {
    /// A reader of manifests whose recordings are below `output`.
    pub(crate) fn new(output: PathBuf, start_from_dir: Option<&'a Path>) -> Self {
        Self { output, start_from_dir, found: RefCell::default(), depth: Cell::new(0) }
    }

    /// Forgets which manifests have no recording, because a run may have recorded it.
    pub(crate) fn forget_missing(&self) {
        self.found.borrow_mut().retain(|_, found| found.is_ok());
    }

    /// Folder that the paths of `start_from` in a manifest are relative to.
    pub(crate) fn start_folder<'b>(&'b self, manifest: &'b Path) -> &'b Path {
        self.start_from_dir.unwrap_or_else(|| base_of(manifest))
    }

    /// Reads a manifest of the command line.
    pub(crate) fn read(
        &self,
        manifest: &Path,
        overrides: &[Override],
    ) -> Result<Experiment, Failure> {
        let source = read_text(manifest, MAX_MANIFEST_BYTES).map_err(|error| {
            if is_recording(manifest, &error) {
                let what = format!("{} is a recording, not a manifest", shown_path(manifest));
                return bad(what).help(
                    "`kinetoscope info` reports what it contains; `kinetoscope verify` reruns it",
                );
            }
            let what = format!("cannot read the manifest {}: {error}", shown_path(manifest));
            match nearest_manifest(manifest).filter(|_| error.kind() == io::ErrorKind::NotFound) {
                Some(near) => bad(what).help(format!("did you mean `{}`?", shown_path(&near))),
                None => unread(&error, what, &how_to_create(manifest)),
            }
        })?;
        if source.starts_with(ExperimentRecord::FIRST_LINE) {
            let folder = shown_path(folder_of(manifest));
            let what =
                format!("{} describes recordings; it is not a manifest", shown_path(manifest));
            return Err(bad(what).help(format!(
                "name the manifest that was run, or use `kinetoscope analyze {folder}`"
            )));
        }
        let start_folder = self.start_folder(manifest);
        let parsed = self.parse(&source, manifest, overrides, start_folder, &Cell::new(None));
        let experiment = parsed.map_err(|diagnostics| {
            Failure::rendered(Exit::BadInput, diagnostics.render(has_colors()))
        })?;
        plotted_fields::reject_unknown(&experiment)?;
        Ok(experiment)
    }

    /// Parses a manifest; `missing` receives why a manifest that it starts from has no recording.
    fn parse(
        &self,
        source: &str,
        manifest: &Path,
        overrides: &[Override],
        start_folder: &Path,
        missing: &Cell<Option<NoRecording>>,
    ) -> Result<Experiment, kinetoscope_manifest::Diagnostics> {
        let starts = StartFiles::relative_to(start_folder);
        let origin = manifest.to_string_lossy();
        let recordings = |name: &str| {
            if !is_manifest_name(name) {
                return starts.read(name);
            }
            let recording = self.recording_of(&start_folder.join(name)).map_err(|why| {
                let text = self.nested(why.to_string());
                missing.set(Some(why));
                text
            })?;
            starts.read(&canonical(&recording).to_string_lossy())
        };
        let lookup = Lookup {
            recordings: Some(&recordings),
            metrics: Some(metric_names),
            figures: Some(figure_names),
            fitted_along: Some(fitted_along),
            unit_of: Some(unit_of),
        };
        parse_with(source, &origin, overrides, lookup)
    }

    /// Why a run that a step starts from has no recording; `None` if all have one.
    pub(crate) fn missing_start(&self, step: &Step) -> Option<NoRecording> {
        step.starts_from.iter().find_map(|manifest| self.recording_of(manifest).err())
    }

    /// The finished recording of a manifest with one run. Each manifest is searched once, although many may start from it.
    ///
    /// # Errors
    /// Why there is none.
    pub(crate) fn recording_of(&self, manifest: &Path) -> Result<PathBuf, NoRecording> {
        let key = location(manifest);
        if let Some(found) = self.found.borrow().get(&key) {
            return found.clone();
        }
        let depth = self.depth.get();
        if depth == MAX_STARTS {
            let shown = shown_path(manifest);
            return Err(NoRecording::Invalid(format!(
                "{shown} is after more than {MAX_STARTS} manifests of which each starts from the next"
            )));
        }
        self.depth.set(depth + 1);
        let found = self.search(manifest);
        self.depth.set(depth);
        self.found.borrow_mut().insert(key, found.clone());
        found
    }

    /// Why a manifest has no recording, for the error of the manifest that starts from it. Of a manifest that is itself a start,
    /// only the first line is kept: a text with the errors of all starts grows exponentially with their number.
    fn nested(&self, why: String) -> String {
        match why.split_once('\n') {
            Some((first, _)) if self.depth.get() > 0 => first.trim_end_matches(':').to_owned(),
            _ => why,
        }
    }

    fn search(&self, manifest: &Path) -> Result<PathBuf, NoRecording> {
        let shown = shown_path(manifest);
        let source = read_text(manifest, MAX_MANIFEST_BYTES)
            .map_err(|error| NoRecording::Invalid(format!("cannot read {shown}: {error}")))?;
        let start_folder = base_of(manifest);
        let missing = Cell::new(None);
        let parsed = self.parse(&source, manifest, &[], start_folder, &missing);
        let experiment = parsed.map_err(|diagnostics| {
            missing.take().unwrap_or_else(|| {
                let errors = diagnostics.render(false);
                NoRecording::Invalid(format!("{shown} has errors:\n{errors}"))
            })
        })?;
        // No start is needed to find a recording.
        let without_starts = Interrupt::default();
        without_starts.stop();
        let plan = Plan::outline(&experiment, &self.output, false, &without_starts);
        let [run] = plan.runs.as_slice() else {
            let what = format!("{shown} has {} runs; must have 1", plan.runs.len());
            return Err(NoRecording::Invalid(what));
        };
        match &run.status {
            Status::Done(Outcome::Complete) => Ok(plan.folder.join(run.file_name())),
            Status::Done(_) => Err(NoRecording::Failed(format!("the run of {shown} failed"))),
            Status::ToDo(_) | Status::Rejected(_) => {
                let what = format!("{shown} has no recording in {}", shown_path(&plan.folder));
                Err(NoRecording::Missing(what))
            }
        }
    }
}

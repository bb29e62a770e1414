//! Pipelines of experiments: a manifest that `start_from` names runs before the manifest that names it.

use crate::manifests::step::Step;
use crate::manifests::{MAX_STARTS, ManifestReader, base_of, canonical};
use crate::messages::exit::unread;
use crate::messages::{Failure, bad};
use kinetoscope_console::text::shown_path;
use kinetoscope_files::regular_file::{MAX_MANIFEST_BYTES, read_text};
use kinetoscope_manifest::{NamedStart, Override, is_manifest_name, start_manifests};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Orders the manifests of the command line and those that they start from: each after those that it starts from.
/// `overrides` belong to the manifests of the command line.
pub(crate) fn order(
    named: &[PathBuf],
    overrides: &[Override],
    reader: &ManifestReader<'_>,
) -> Result<Vec<Step>, Failure> {
    let mut search = Search {
        named: named.iter().map(|path| canonical(path)).collect(),
        overrides,
        reader,
        trail: Vec::new(),
        visited: BTreeSet::new(),
        steps: Vec::new(),
    };
    for manifest in named {
        search.visit(manifest)?;
    }
    Ok(search.steps)
}

/// A manifest on the way from the command line, and where it names the next one.
struct Link {
    manifest: PathBuf,
    /// The canonical path of the manifest.
    identity: PathBuf,
    start: NamedStart,
}

impl Link {
    fn place(&self) -> String {
        match self.start.line {
            0 => format!("--set: start_from = {:?}", self.start.name),
            line => {
                format!("{}:{line}: start_from = {:?}", shown_path(&self.manifest), self.start.name)
            }
        }
    }
}

struct Search<'a> {
    /// The canonical paths of the manifests of the command line.
    named: BTreeSet<PathBuf>,
    overrides: &'a [Override],
    reader: &'a ManifestReader<'a>,
    trail: Vec<Link>,
    /// The canonical paths of the manifests among the steps.
    visited: BTreeSet<PathBuf>,
    steps: Vec<Step>,
}

impl Search<'_> {
    fn visit(&mut self, manifest: &Path) -> Result<(), Failure> {
        let identity = canonical(manifest);
        if let Some(first) = self.trail.iter().position(|link| link.identity == identity) {
            let lines: Vec<String> = self.trail[first..].iter().map(Link::place).collect();
            let what = format!("the manifests start from each other\n  {}", lines.join("\n  "));
            return Err(bad(what).help("name a recording (*.mcap) in one of these lines"));
        }
        if self.visited.contains(&identity) {
            return Ok(());
        }
        if let Some(link) = self.trail.last().filter(|_| self.trail.len() >= MAX_STARTS) {
            let what = format!(
                "more than {MAX_STARTS} manifests, of which each starts from the next\n  {}",
                link.place()
            );
            return Err(bad(what).help(
                "run the manifest that this line names first, and name its recording (*.mcap) here",
            ));
        }
        let is_named = self.named.contains(&identity);
        let mut starts_from = Vec::new();
        for start in self.starts(manifest, is_named)? {
            let folder = match is_named {
                true => self.reader.start_folder(manifest),
                false => base_of(manifest),
            };
            let next = folder.join(&start.name);
            let identity = identity.clone();
            self.trail.push(Link { manifest: manifest.to_owned(), identity, start });
            self.visit(&next)?;
            self.trail.pop();
            starts_from.push(next);
        }
        self.visited.insert(identity);
        self.steps.push(Step { manifest: manifest.to_owned(), is_named, starts_from });
        Ok(())
    }

    /// The manifests that a manifest starts from. An override replaces the values of the file.
    fn starts(&self, manifest: &Path, is_named: bool) -> Result<Vec<NamedStart>, Failure> {
        let source = match (read_text(manifest, MAX_MANIFEST_BYTES), self.trail.last()) {
            (Ok(source), _) => source,
            // Reading a manifest of the command line reports the error.
            (Err(_), None) => return Ok(Vec::new()),
            (Err(error), Some(link)) => {
                let what = format!(
                    "cannot read the manifest {}: {error}\n  {}",
                    shown_path(manifest),
                    link.place()
                );
                let help = "paths of start_from are relative to the folder of the manifest";
                return Err(unread(&error, what, help));
            }
        };
        let is_start =
            |change: &&Override| is_named && change.key.rsplit('.').next() == Some("start_from");
        Ok(match self.overrides.iter().find(is_start) {
            None => start_manifests(&source),
            Some(change) => {
                let name = change.value.trim_matches(['"', '\'']).to_owned();
                let start = NamedStart { name, line: 0 };
                Some(start).filter(|start| is_manifest_name(&start.name)).into_iter().collect()
            }
        })
    }
}

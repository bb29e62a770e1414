//! Adds a model, a metric, an integrator and a contact law to a copy of Kinetoscope.
//!
//!     cargo run --example extend -- FOLDER
//!
//! Each extension has a list of every line that existing files need, next to this file, and a folder in `examples/extend/files` with
//! its new files, one of which is an experiment that checks it. Afterward, in FOLDER:
//!
//!     cargo run --release -- experiments/oscillator.toml
//!     cargo run --release --bin analyze-recordings -- recordings/oscillator

mod contact_law;
mod integrator;
mod metric;
mod model;

use std::collections::BTreeSet;
use std::error::Error;
use std::path::Path;
use std::{env, fs};

/// The extensions, each with its additions to existing files.
const EXTENSIONS: &[(&str, &[Edit])] = &[
    ("model", model::EDITS),
    ("metric", metric::EDITS),
    ("integrator", integrator::EDITS),
    ("contact_law", contact_law::EDITS),
];

/// An addition: the file, a text that occurs once in it, and the text to insert after it.
type Edit = (&'static str, &'static str, &'static str);

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = env::args().nth(1) else { return Err("usage: extend FOLDER".into()) };
    let (root, copy) = (Path::new(env!("CARGO_MANIFEST_DIR")), Path::new(&folder));
    if copy.exists() {
        return Err(format!("{folder} already exists; name a folder that does not exist").into());
    }
    fs::create_dir_all(copy)?;
    if copy.canonicalize()?.starts_with(root.canonicalize()?) {
        fs::remove_dir(copy)?;
        return Err(format!("{folder} is inside the sources; name a folder outside").into());
    }
    copy_folder(root, copy, &["target", "recordings", ".git"])?;
    for (name, edits) in EXTENSIONS {
        copy_folder(&root.join("examples/extend/files").join(name), copy, &[])?;
        for (file, anchor, addition) in *edits {
            let path = copy.join(file);
            let text = fs::read_to_string(&path)?;
            if text.matches(anchor).count() != 1 {
                return Err(format!("{file} must contain {anchor:?} once").into());
            }
            fs::write(path, text.replace(anchor, &format!("{anchor}{addition}")))?;
        }
        let changed: BTreeSet<&str> = edits.iter().map(|(file, ..)| *file).collect();
        println!("{name}: {} existing files changed", changed.len());
        changed.iter().for_each(|file| println!("  {file}"));
    }
    Ok(())
}

/// Copies a folder and everything in it, except the entries with these names.
fn copy_folder(from: &Path, to: &Path, except: &[&str]) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let (name, kind) = (entry.file_name(), entry.file_type()?);
        if except.iter().any(|except| name == *except) {
            continue;
        }
        if kind.is_dir() {
            copy_folder(&entry.path(), &to.join(name), except)?;
        } else if kind.is_file() {
            fs::copy(entry.path(), to.join(name))?;
        }
    }
    Ok(())
}

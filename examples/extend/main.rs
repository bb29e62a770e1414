//! Adds a model, a body on a spring, to a copy of Kinetoscope.
//!
//!     cargo run --example add_a_model -- FOLDER
//!
//! The files of the new model are in `examples/add_a_model/files`: a folder each in physics, in the analysis and in the manifest
//! (its table and its starter), and an experiment. [`EDITS`] lists every line that existing files need. Afterward, in FOLDER:
//!
//!     cargo run --release -- experiments/oscillator.toml
//!     cargo run --release --bin analyze-recordings -- recordings/oscillator

use std::collections::BTreeSet;
use std::error::Error;
use std::path::Path;
use std::{env, fs};

/// The additions to existing files: the file, a text that occurs once in it, and the text to insert after it.
const EDITS: &[(&str, &str, &str)] = &[
    ("src/manifest/model/mod.rs", "\nmod orbit;", "\nmod oscillator;"),
    ("src/manifest/model/mod.rs", "\npub use orbit::*;", "\npub use oscillator::*;"),
    (
        "src/manifest/model/mod.rs",
        "\n        state discs walls legend velocity trail energy orbit conserved closest_approach log\n    ],",
        "\n    /// A body on a spring.\n    oscillator: Oscillator(OscillatorConfig) every every_s [\
         \n        state discs walls legend velocity trail energy log\n    ],",
    ),
    ("src/physics/lib.rs", "\npub mod orbit;", "\npub mod oscillator;"),
    (
        "src/physics/lib.rs",
        "\n    Orbit => orbit::Orbit,",
        "\n    Oscillator => oscillator::Oscillator,",
    ),
    (
        "src/recording/channels.rs",
        "\nchannels! {",
        "\n    /// Oscillator: energy per unit mass.\n    OscillatorEnergy on \"/energy\" {\
         \n        /// v^2/2 + omega^2 x^2/2, J/kg.\n        specific_energy_j_per_kg: f64 [double] = \"1\",\n    }\n",
    ),
    ("analysis/src/models/mod.rs", "\nmod orbit;", "\nmod oscillator;"),
    ("analysis/src/models/mod.rs", "\n    Orbit => orbit,", "\n    Oscillator => oscillator,"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = env::args().nth(1) else { return Err("usage: add_a_model FOLDER".into()) };
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
    copy_folder(&root.join("examples/add_a_model/files"), copy, &[])?;
    for (file, anchor, addition) in EDITS {
        let path = copy.join(file);
        let text = fs::read_to_string(&path)?;
        if text.matches(anchor).count() != 1 {
            return Err(format!("{file} must contain {anchor:?} once").into());
        }
        fs::write(path, text.replace(anchor, &format!("{anchor}{addition}")))?;
    }
    let changed: BTreeSet<&str> = EDITS.iter().map(|(file, ..)| *file).collect();
    println!("{} existing files changed:", changed.len());
    changed.iter().for_each(|file| println!("  {file}"));
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

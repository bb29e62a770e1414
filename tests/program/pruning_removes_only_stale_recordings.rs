//! Guarantee: `--prune` removes recordings and partial files that the manifest no longer requests, with the files that belong to
//! them and the plots that show them, temporary files of killed processes, and nothing else.
//!
//! Control: a dry run removes nothing; files that are not recordings of the experiment stay.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, SystemTime};

const MANIFEST: &str = "[model.orbit]\nduration_days = 3.0\n[record]\nframes = 2\n";

fn run(folder: &Path, arguments: &[&str]) {
    let ended = Command::new(env!("CARGO_BIN_EXE_run-experiment"))
        .current_dir(folder)
        .args(["orbit.toml", "--output", "recordings"])
        .args(arguments)
        .output()
        .unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
}

fn files(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder.join("recordings/orbit")).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn pruning_removes_only_what_is_stale() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("orbit.toml"), MANIFEST).unwrap();
    run(folder.path(), &[]);
    let wanted = files(folder.path());
    run(folder.path(), &["--set", "model.orbit.time_step_days=0.5"]);
    // Foreign files: one is not a recording; the name of the other does not end in its key.
    let recordings = folder.path().join("recordings/orbit");
    let ours = wanted.iter().find(|name| name.ends_with(".mcap")).unwrap();
    fs::write(recordings.join("notes__00000000.mcap"), "a diary").unwrap();
    fs::copy(recordings.join(ours), recordings.join("the_best_one.mcap")).unwrap();
    // Copies whose names have no key, its first digit only, or the name of another experiment.
    let key = ours.trim_end_matches(".mcap").rsplit_once("__").unwrap().1;
    let copies =
        ["orbit__.mcap".to_owned(), format!("orbit__{}.mcap", &key[..1]), format!("b__{key}.mcap")];
    for copy in &copies {
        fs::copy(recordings.join(ours), recordings.join(copy)).unwrap();
    }
    // Temporary files of a process that was killed, and of one that writes.
    fs::create_dir(recordings.join(".analysis-cache")).unwrap();
    let temporary = |name: &str, age_h: u64| {
        let file = fs::File::create(recordings.join(name)).unwrap();
        file.set_modified(SystemTime::now() - Duration::from_hours(age_h)).unwrap();
    };
    temporary(".kinetoscope-a1b2c3.tmp", 25);
    temporary(".analysis-cache/.kinetoscope-d4e5f6.tmp", 25);
    temporary(".kinetoscope-a7b8c9.tmp", 1);
    temporary("notes.tmp", 25);
    // An unfinished run of an earlier manifest, a plot that shows it, and files that only resemble them.
    let add = |name: &str, text: &str| fs::write(recordings.join(name), text).unwrap();
    add("orbit__time_step_days=2__0123abcd.partial.mcap", "");
    add("orbit__time_step_days=2__0123abcd.checkpoint", "");
    add(
        ".analysis-plots",
        "energy_2.svg\n../../kept.svg\norbit__time_step_days=2__0123abcd.partial.mcap\n",
    );
    add("energy_2.svg", "<svg/>");
    for (name, text) in
        [("orbit__draft.partial.mcap", ""), ("other__0123abcd.partial.mcap", ""), ("own.svg", "")]
    {
        add(name, text);
    }
    fs::write(folder.path().join("kept.svg"), "<svg/>").unwrap();
    let mut kept = wanted.clone();
    for name in ["orbit__draft.partial.mcap", "other__0123abcd.partial.mcap", "own.svg"] {
        kept.insert(name.to_owned());
    }
    kept.extend(copies);
    for name in [".analysis-plots", ".analysis-cache", ".kinetoscope-a7b8c9.tmp", "notes.tmp"] {
        kept.insert(name.to_owned());
    }
    kept.extend(["notes__00000000.mcap".to_owned(), "the_best_one.mcap".to_owned()]);

    let before = files(folder.path());
    assert!(before.len() > kept.len(), "some recordings must be stale");
    run(folder.path(), &["--prune", "--dry-run"]);
    assert_eq!(files(folder.path()), before, "a dry run must not remove a file");
    run(folder.path(), &["--prune"]);
    assert_eq!(files(folder.path()), kept);
    let cached = fs::read_dir(recordings.join(".analysis-cache")).unwrap().count();
    assert_eq!(cached, 0, "the cache contains a temporary file");
    assert!(folder.path().join("kept.svg").exists(), "a plot list names only files of its folder");
}

/// Control: plots of the recordings that stay.
#[test]
fn plots_of_current_recordings_stay() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("orbit.toml"), MANIFEST).unwrap();
    run(folder.path(), &[]);
    let recordings = folder.path().join("recordings/orbit");
    let ours = files(folder.path()).into_iter().find(|name| name.ends_with(".mcap")).unwrap();
    fs::write(recordings.join(".analysis-plots"), format!("energy.svg\n{ours}\n")).unwrap();
    fs::write(recordings.join("energy.svg"), "<svg/>").unwrap();
    let kept = files(folder.path());
    run(folder.path(), &["--set", "model.orbit.time_step_days=0.5"]);
    run(folder.path(), &["--prune"]);
    assert_eq!(files(folder.path()), kept);
}

//! Guarantee: names of a recording are short; columns and units of the state, which become headers of tables, labels of plots and parts of gnuplot scripts, have the form
//! of those of the models, and the playback has a speed; a recording with others is damaged.
//!
//! Control: a unit that no model has, in the same form.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::forged_recording::{Forgery, kinetoscope, record, stderr};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const DISCS: &str = "seed = 1\n[model.dem]\ndiscs = 4\nduration_s = 0.01\n[record]\nframes = 4\n";
const COLUMNS: &str = "x,y,vx,vy,vx_step,vy_step,radius,spin,id,mass";
const UNITS: &str = "m,m,m/s,m/s,m/s,m/s,m,rad/s,,kg";

/// A recording in a folder of its own, with another value in its provenance.
fn forged(original: &Path, folder: &Path, key: &str, value: &str) -> PathBuf {
    fs::create_dir_all(folder).unwrap();
    let path = folder.join("forged.mcap");
    let metadata = [(key.to_owned(), value.to_owned())].into();
    Forgery { metadata, ..Forgery::default() }.write(original, &path);
    path
}

#[test]
fn columns_and_units_of_another_form_are_damage() {
    let folder = tempfile::tempdir().unwrap();
    let original = record(folder.path(), "discs", DISCS);
    let info = |key: &str, value: &str| {
        let path = forged(&original, &folder.path().join("forged"), key, value);
        let called = kinetoscope(["info".as_ref(), path.as_os_str()]);
        (called.status.code(), stderr(&called))
    };
    let (code, error) = info("state_units", &UNITS.replace("kg", "kg*m^2.s-1"));
    assert_eq!(code, Some(0), "control: {error}");
    let many = (0..100).map(|index| format!("c{index}")).collect::<Vec<_>>().join(",");
    for (key, value, what) in [
        ("state_units", "m", "the state has 10 columns and 1 units"),
        ("state_units", "", "the state has 10 columns and 1 units"),
        ("state_columns", "x", "the state has 1 columns and 10 units"),
        ("state_columns", &many, "the state has 100 columns"),
        ("state_columns", &COLUMNS.replace("mass", "x"), "the state has two columns x"),
        ("state_columns", &COLUMNS.replace("mass", ""), "column 9 of the state"),
        ("state_columns", &COLUMNS.replace("mass", "=cmd()"), "column 9 of the state"),
        ("state_columns", &COLUMNS.replace("mass", &"x".repeat(65)), "column 9 of the state"),
        ("state_units", &UNITS.replace("kg", "`id`"), "the unit of the column mass"),
        ("state_units", &UNITS.replace("kg", "\u{1b}[31m"), "the unit of the column mass"),
        ("time_unit", "\n::error::x", "the unit of time"),
        ("program_version", &"1".repeat(65), "the program version has more than 64 bytes"),
        ("model", &"m".repeat(65), "the model has more than 64 bytes"),
        ("run_key", &"0".repeat(65), "the run key has more than 64 bytes"),
        ("playback_fps", "0", "playback of 0.0 frames per second"),
        ("playback_fps", "-1e300", "playback of -1e300 frames per second"),
        ("playback_fps", "NaN", "playback of NaN frames per second"),
        ("playback_fps", "inf", "playback of inf frames per second"),
    ] {
        let (code, error) = info(key, value);
        assert_eq!(code, Some(5), "{key} = {value}: {error}");
        let words = error.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("is damaged at byte") && words.contains(what), "{value}: {error}");
    }
}

/// If gnuplot is installed, it executes the scripts that were written.
#[test]
fn hostile_unit_executes_no_command_in_gnuplot() {
    let folder = tempfile::tempdir().unwrap();
    let original = record(folder.path(), "discs", DISCS);
    for (index, unit) in ["\"\n!touch PWNED\n#", "\".system(\"touch PWNED\").\"", "`touch PWNED`"]
        .into_iter()
        .enumerate()
    {
        let below = folder.path().join(index.to_string());
        let units = UNITS.replacen("m/s", unit, 1);
        let path = forged(&original, &below, "state_units", &units);
        let output = below.join("export");
        let called = kinetoscope([
            "export".as_ref(),
            "--format".as_ref(),
            "gnuplot".as_ref(),
            "--output".as_ref(),
            output.as_os_str(),
            path.as_os_str(),
        ]);
        let error = stderr(&called);
        assert!(matches!(called.status.code(), Some(0 | 5)), "{unit:?}: {error}");
        assert!(!error.contains("panicked"), "{unit:?}: {error}");
        // None, unless the unit is omitted.
        let scripts = fs::read_dir(output.join("forged/gnuplot")).into_iter().flatten();
        let scripts: Vec<PathBuf> = scripts.map(|entry| entry.unwrap().path()).collect();
        assert_eq!(scripts.is_empty(), called.status.code() == Some(5), "{unit:?}: {error}");
        for script in scripts.iter().filter(|path| path.extension().is_some_and(|it| it == "gp")) {
            // It may end with an error; what counts is what it executed.
            let _ = Command::new("gnuplot").arg(script).current_dir(&below).output();
            let text = fs::read_to_string(script).unwrap();
            assert!(!text.contains("PWNED"), "{text}");
        }
        assert!(!below.join("PWNED").exists(), "{unit:?}");
    }
}

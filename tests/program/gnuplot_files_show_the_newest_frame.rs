//! Guarantee: `run --gnuplot DIR` writes the newest frame as `x y r` lines, the borders, and a script that ends with the run. It
//! changes no byte of the recording.
//!
//! Setup: three discs fall for 10 ms; the files after the run are those of its last frame.
//! Control: a run without the option writes no such files.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::forged_recording::{recordings, run_experiment, stderr};
use kinetoscope_recording::reader::Recording;
use std::fs;
use std::path::PathBuf;

const MANIFEST: &str = "name = \"falling\"\nseed = 1\n[model.dem]\ndiscs = 3\nduration_s = 0.01\n\
                        radius_m = { min = 4e-4, max = 5e-4 }\n[record]\nframes = 4\n";

#[test]
fn gnuplot_files_contain_the_last_frame_and_change_no_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("falling.toml");
    fs::write(&path, MANIFEST).unwrap();
    let run = |output: &str, more: &[PathBuf]| {
        let output = folder.path().join(output);
        let first = [path.clone(), PathBuf::from("--output"), output.clone()];
        let ran = run_experiment([first.as_slice(), more].concat());
        assert_eq!(ran.status.code(), Some(0), "{}", stderr(&ran));
        recordings(&output.join("falling")).remove(0)
    };
    let shown = folder.path().join("newest");
    let recording = run("shown", &[PathBuf::from("--gnuplot"), shown.clone()]);
    let without = run("plain", &[]);
    assert_eq!(fs::read(&recording).unwrap(), fs::read(&without).unwrap());
    assert_eq!(fs::read_dir(&shown).unwrap().count(), 4);

    let stem = recording.file_stem().unwrap().to_str().unwrap();
    let read = |ending: &str| fs::read_to_string(shown.join(format!("{stem}{ending}"))).unwrap();
    let recording = Recording::open(&recording).unwrap();
    let last = recording.frames().unwrap().last().unwrap().unwrap();
    let state = last.state().unwrap();
    let [x, y, radius] = ["x", "y", "radius"].map(|name| state.index(name).unwrap());
    let expected: String = (0..3)
        .map(|disc| state.row(disc))
        .map(|row| format!("{:?} {:?} {:?}\n", row[x], row[y], row[radius]))
        .collect();
    assert_eq!(read(".txt"), expected);
    assert!(read(".borders.txt").starts_with("0.0 0.0\n0.04 0.0\n0.04 0.04\n"));
    let time = format!("set title \"t = {:.6}\"\nrunning = 0\n", last.clock.time);
    assert_eq!(read(".time.gp"), time);
    let script = read(".gp");
    assert!(script.contains("while (running)") && script.contains("with circles"), "{script}");
}

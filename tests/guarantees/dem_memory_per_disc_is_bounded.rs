//! Promise: a large bed and its recorder take at most 400 bytes a disc, program included, from the start to the last byte of the
//! recording; with friction, whose springs come on top, at most 450.
//!
//! Set-up: the bed of `src/allocation.rs` with fewer discs: a lattice with random velocities, some of whose discs touch at any
//! time, recorded twice. Its frames of 56 MB are one at a time in memory, as those of 10^6 discs are. The lists are built anew several
//! times: what is left of the old ones counts. The judge is the peak that the operating system keeps, as `STEM.host.json` tells it. It
//! must be above what has to be there, 69 bytes of a disc's columns and 80 of its row in a frame: a peak that is none would be
//! below.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]
#![cfg(target_os = "linux")]

use crate::forged_recording::{run_experiment, stderr};
use std::fs;
use std::path::PathBuf;

const DISCS: u64 = 700_000;
const COLUMNS_AND_ROW: u64 = 69 + 80;

/// Peak memory of a run of the bed, bytes a disc.
fn bytes_a_disc(more: &str) -> u64 {
    // The box of 10^6 discs is 1.03 m wide.
    let side = 1.03 * (DISCS as f64 / 1e6).sqrt();
    let manifest = format!(
        "seed = 5\n[model.dem]\ndiscs = {DISCS}\nwidth_m = {side}\nheight_m = {side}\nduration_s = 0.001\n\
         stiffness_n_per_m = 4e5\nplacement = \"lattice\"\nvelocity_deviation_m_per_s = 0.3\n{more}\n[record]\nevery_steps = 70\n"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bed.toml");
    let output = folder.path().join("recordings");
    fs::write(&path, manifest).unwrap();
    let ran = run_experiment(&[path, PathBuf::from("--output"), output.clone()]);
    assert!(ran.status.success(), "{}", stderr(&ran));
    let files = fs::read_dir(output.join("bed")).unwrap().map(|entry| entry.unwrap().path());
    let mut hosts = files.filter(|path| path.to_string_lossy().ends_with(".host.json"));
    let host = fs::read_to_string(hosts.next().unwrap()).unwrap();
    let host: serde_json::Value = serde_json::from_str(&host).unwrap();
    assert!(host["frames"].as_u64().unwrap() >= 2, "{host}");
    host["peak_memory_of_the_program_bytes"].as_u64().unwrap() / DISCS
}

#[test]
fn a_large_recorded_bed_has_its_bytes_a_disc() {
    for (name, more, at_most) in
        [("frictionless", "", 400), ("with friction", "friction = 0.5", 450)]
    {
        let bytes = bytes_a_disc(more);
        println!("{name}: {bytes} bytes a disc");
        assert!((COLUMNS_AND_ROW..=at_most).contains(&bytes), "{name}: {bytes} bytes a disc");
    }
}

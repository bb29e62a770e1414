//! Guarantee: `kinetoscope benchmark` prints one line per sweep point, the ratio of two velocity distributions with its error, and the machine. It writes
//! no file except `timing.json` if a folder is given, and it rejects a manifest that cannot be run.
//!
//! The times themselves are not checked.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::forged_recording::{kinetoscope, stderr, stdout};
use kinetoscope_manifest::TimingTable;
use std::fs;
use std::path::PathBuf;

const MANIFEST: &str = "name = \"timed\"\nseed = 1\nreplicates = 3\n[model.packing]\nwidth = 40.0\nheight = 40.0\n\
                        events_per_disc = 5\n[record]\nframes = 1\n[sweep]\n\"model.packing.discs\" = [5, 10]\n\
                        [[sweep.variants]]\nname = \"unmodified\"\n\"model.packing.initial_velocities\" = \"unit-variance\"\n\
                        [[sweep.variants]]\nname = \"modified\"\n\"model.packing.initial_velocities\" = \"variance-1-over-n\"\n";

#[test]
fn timing_prints_a_table_and_writes_no_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("timed.toml");
    fs::write(&path, MANIFEST).unwrap();
    let arguments = vec![PathBuf::from("benchmark"), path.clone()];
    let asked = kinetoscope(&arguments);
    let table = stdout(&asked);
    assert_eq!(asked.status.code(), Some(0), "{}", stderr(&asked));
    for line in ["discs = 5, variant = unmodified", "discs = 10, variant = modified", "processors"]
    {
        assert!(table.contains(line), "{table}");
    }
    assert!(table.contains("Time of modified over time of unmodified"), "{table}");
    assert!(
        table.lines().any(|line| line.starts_with("all: ") && line.contains(" +- ")),
        "{table}"
    );
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        1,
        "the folder must contain only the manifest"
    );

    // If a folder is given, it receives the table and nothing else.
    let output = folder.path().join("out");
    let named = [arguments.clone(), vec![PathBuf::from("--output"), output.clone()]].concat();
    let asked = kinetoscope(&named);
    assert_eq!(asked.status.code(), Some(0), "{}", stderr(&asked));
    assert_eq!(fs::read_dir(output.join("timed")).unwrap().count(), 1);
    let written = fs::read_to_string(output.join("timed").join("timing.json")).unwrap();
    let table = TimingTable::from_json(&written).unwrap();
    assert_eq!((table.schema, table.experiment.as_str(), table.points.len()), (1, "timed", 4));
    assert!(table.points.iter().all(|point| point.runs == 3 && point.mean_s > 0.0));
    let comparison = table.comparison.unwrap();
    assert_eq!((comparison.of.as_str(), comparison.over.as_str()), ("modified", "unmodified"));
    assert_eq!(comparison.ratios.len(), 2);

    fs::write(&path, MANIFEST.replace("width = 40.0", "width = 10.0\nradius = 4.9")).unwrap();
    let refused = kinetoscope(&arguments);
    assert_eq!(refused.status.code(), Some(2), "{}", stdout(&refused));
    assert!(stderr(&refused).contains("random placement"), "{}", stderr(&refused));
}

#[test]
fn destination_is_checked_before_the_first_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("timed.toml");
    fs::write(&path, MANIFEST).unwrap();
    let arguments = ["benchmark", "--output"].map(PathBuf::from).to_vec();
    let refused = kinetoscope([arguments, vec![path.clone(), path]].concat());
    assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
    assert_eq!(stdout(&refused), "", "runs were measured whose table has no destination");
    assert!(stderr(&refused).contains("--output DIR"), "{}", stderr(&refused));
}

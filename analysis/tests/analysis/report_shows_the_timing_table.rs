//! Guarantee: a timing table next to the recordings is shown in the report and changes no number of `metrics.json`. A table of another
//! experiment, or a file that is not a timing table, is named in a note and not shown.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's own failure")]

use crate::synthetic::{Folder, analyze, flat, two_frames};
use kinetoscope_manifest::{Coordinate, TimingComparison, TimingPoint, TimingRatio, TimingTable};
use kinetoscope_recording::channels::GasPressure;
use std::fs;

const MANIFEST: &str =
    "name = \"timed\"\n[model.gas]\nparticles = 1\nduration_s = 1.0\n[record]\nframes = 1\n";

/// A timing table in which each number has distinct digits.
fn table() -> TimingTable {
    let place = |discs: &str, law: Option<&str>| {
        let coordinate =
            |key: &str, value: &str| Coordinate { key: key.to_owned(), value: value.to_owned() };
        let of_law = law.map(|law| coordinate("variant", law));
        [coordinate("model.packing.discs", discs)].into_iter().chain(of_law).collect::<Vec<_>>()
    };
    let ratio = |coordinates: Vec<Coordinate>| TimingRatio {
        coordinates,
        median: 1.0016,
        mean: 1.01234,
        standard_error: 0.0021,
    };
    TimingTable {
        schema: TimingTable::SCHEMA,
        experiment: "timed".to_owned(),
        machine: "on a <slow> machine".to_owned(),
        points: vec![TimingPoint {
            coordinates: place("25", Some("modified")),
            runs: 100,
            median_s: 0.001_234_56,
            mean_s: 0.001_357_92,
            standard_deviation_s: 4.567_89e-5,
            quartile_distance_s: 1e-5,
            steps_or_events_per_s: 3_210_987.0,
            published_s: Some(0.9018),
        }],
        comparison: Some(TimingComparison {
            of: "modified".to_owned(),
            over: "unmodified".to_owned(),
            ratios: vec![ratio(place("25", None))],
            all: ratio(Vec::new()),
        }),
    }
}

#[test]
fn timing_table_is_shown_and_changes_no_metric() {
    let folder = Folder::write(MANIFEST, |_| two_frames(&GasPressure::default()));
    // If there is an `experiment.toml`, the folder has the name of the experiment.
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let put = |text: &str| fs::write(folder.path().join(TimingTable::FILE), text).unwrap();
    assert_eq!(analyze(&[folder.name()]).code, 0);
    let numbers = read("metrics.json");
    assert!(!read("report.html").contains("<h2>Timing</h2>"));

    put(&table().to_json().unwrap());
    assert_eq!(analyze(&[folder.name()]).code, 0);
    let report = read("report.html");
    for shown in [
        "<h2>Timing</h2>",
        "on a &lt;slow&gt; machine",
        "discs = 25, modified (100)",
        "0.001358",
        "4.568·10⁻⁵",
        "0.001235",
        "3.211·10⁶",
        "Published times over these",
        "Python 3.11",
        "0.9018",
        "664.1",
        "Time of modified over time of unmodified",
        "1.0123(21)",
        "The runs of modified take 1.0123 ± 0.0021 times as long as those of unmodified.",
    ] {
        assert!(report.contains(shown), "the report lacks {shown}");
    }
    assert_eq!(read("metrics.json"), numbers);

    for (wrong, why) in [
        (
            TimingTable { experiment: "other".to_owned(), ..table() },
            "is about the experiment other",
        ),
        (TimingTable { schema: 99, ..table() }, "has the layout 99, this version reads 1"),
    ] {
        put(&wrong.to_json().unwrap());
        let output = analyze(&[folder.name()]);
        assert!(output.code == 0 && flat(&output.text).contains(why), "{}", output.text);
        assert!(!read("report.html").contains("<h2>Timing</h2>"));
    }
    put("{");
    assert!(flat(&analyze(&[folder.name()]).text).contains("is no timing table"));
    assert_eq!(read("metrics.json"), numbers);
}

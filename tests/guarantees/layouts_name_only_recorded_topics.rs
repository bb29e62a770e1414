//! Guarantee: a viewer layout names only topics and fields that the recording contains, and states a time scale only if all runs have it.
//!
//! Setup: each small experiment is run. Every topic and field that its `NAME.layout.json` names (drawing, plots, log, values) is looked up
//! in the recording, frame by frame.
//! Control: a topic that the manifest omits is found missing.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::small_experiments::MANIFESTS;
use kinetoscope_recording::channels::{self, ALL};
use kinetoscope_recording::fields::read_fields;
use kinetoscope_recording::reader::{RecordedFrame, Recording};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Topics that are written only once, at the start.
const ONCE: [&str; 3] = [channels::WALLS, channels::LEGEND, channels::LOG];

/// Runs an experiment and returns its layout and the frames of a recording.
fn replay(name: &str, manifest: &str, folder: &Path) -> (Value, Vec<RecordedFrame>) {
    let path = folder.join(format!("{name}.toml"));
    fs::write(&path, manifest).unwrap();
    let ran = Command::new(env!("CARGO_BIN_EXE_run-experiment"))
        .args(["--quiet", "--output"])
        .args([folder, &path])
        .output()
        .unwrap();
    assert!(ran.status.success(), "{name}: {}", String::from_utf8_lossy(&ran.stderr));
    let files = fs::read_dir(folder.join(name)).unwrap().map(|entry| entry.unwrap().path());
    let is_recording = |path: &std::path::PathBuf| path.extension().is_some_and(|e| e == "mcap");
    let recordings: Vec<_> = files.filter(is_recording).collect();
    let frames = Recording::open(&recordings[0]).unwrap().frames().unwrap();
    let layout = fs::read_to_string(folder.join(name).join(format!("{name}.layout.json"))).unwrap();
    (serde_json::from_str(&layout).unwrap(), frames.map(Result::unwrap).collect())
}

/// The topics and paths that a panel names, such as "/speeds.density[:]". A bare number is a reference line.
fn named(panel: &Value) -> Vec<String> {
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let mut named: Vec<String> = Vec::new();
    named.extend(panel["topics"].as_object().into_iter().flat_map(|topics| topics.keys().cloned()));
    named.extend(panel["paths"].as_array().into_iter().flatten().map(|path| text(&path["value"])));
    named.extend(panel.get("xAxisPath").map(|path| text(&path["value"])));
    named.extend(panel.get("topicToRender").or_else(|| panel.get("topicPath")).map(text));
    named.retain(|name| name.parse::<f64>().is_err());
    named
}

/// Whether a frame contains a topic or the field of a path.
fn is_there(name: &str, frame: &RecordedFrame) -> bool {
    let (topic, field) = name.split_once('.').map_or((name, None), |(t, f)| (t, Some(f)));
    if topic == channels::STATE {
        return frame.state().is_some();
    }
    if topic == channels::LOG {
        return !frame.log_lines().is_empty();
    }
    let Some(message) = frame.messages().iter().find(|message| message.topic() == topic) else {
        return false;
    };
    let Some(field) = field else { return true };
    let declared = ALL.iter().find(|channel| channel.schema == message.schema()).unwrap();
    let fields = read_fields(declared, message.payload()).unwrap();
    let found = fields.iter().find(|known| known.name == field.trim_end_matches("[:]"));
    found.is_some_and(|found| found.series == field.ends_with("[:]") && !found.values.is_empty())
}

#[test]
fn every_topic_and_field_of_a_layout_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let mut checked = BTreeMap::new();
    for (name, manifest) in MANIFESTS {
        let (layout, frames) = replay(name, manifest, folder.path());
        for (id, panel) in layout["configById"].as_object().unwrap() {
            let names = named(panel);
            assert!(!names.is_empty(), "{name}: {id} names no topic");
            for path in names {
                let once = ONCE.contains(&path.as_str());
                let frames = if once { &frames[..1] } else { &frames[..] };
                let missing = frames.iter().position(|frame| !is_there(&path, frame));
                assert_eq!(missing, None, "{name}, {id}: a frame lacks {path}");
                *checked.entry(path).or_insert(0) += frames.len();
            }
        }
    }
    println!("{} paths in {} experiments: {checked:?}", checked.len(), MANIFESTS.len());
}

#[test]
fn channels_omitted_by_the_manifest_are_not_in_the_layout() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = "[model.gas]\nparticles = 9\nduration_s = 0.01\n[record]\nframes = 2\nchannels = [\"state\", \"pressure\"]\n";
    let (layout, frames) = replay("few_channels", manifest, folder.path());
    let mut names: Vec<String> =
        layout["configById"].as_object().unwrap().values().flat_map(named).collect();
    names.sort();
    let expected = [
        "/log",
        "/pressure",
        "/pressure.pressure_over_mean_square_formula",
        "/pressure.window_pressure_over_mean_square_formula",
        "/state",
    ];
    assert_eq!(names, expected);
    assert!(names.iter().filter(|name| *name != "/log").all(|name| is_there(name, &frames[1])));
    // Control: the check finds the missing topic.
    assert!(!is_there("/discs", &frames[1]));
    assert!(!is_there("/pressure.pressure_over_idol", &frames[1]));
    assert!(!is_there("/pressure.pressure_over_mean_square_formula[:]", &frames[1]));
}

/// Runs a sweep of a gas with four intervals of playback in 0.16 s, and returns the label of its time axis.
fn time_label(sweep: &str, folder: &Path) -> String {
    let rest = "[model.gas]\nparticles = 9\nduration_s = 0.008\n[record]\nframes = 4\n[sweep]\n";
    let (layout, _) = replay("sweep", &format!("{rest}{sweep}"), folder);
    layout["configById"]["Plot!temperature"]["xAxisLabel"].as_str().unwrap().to_owned()
}

#[test]
fn time_scale_is_stated_only_if_all_runs_have_it() {
    let (of_one, of_none) =
        ("playback time (s), 1 s = 50 ms simulated", "playback time (s), scale in the log");
    let folder = tempfile::tempdir().unwrap();
    let label = |sweep: &str| time_label(sweep, folder.path());
    assert_eq!(label("\"model.gas.temperature_k\" = [200.0, 300.0]\n"), of_one);
    // Runs that are finished have the scale of the layout that is replaced.
    assert_eq!(label("\"model.gas.temperature_k\" = [200.0, 300.0, 400.0]\n"), of_one);
    let durations = |values: &str| {
        format!("\"model.gas.temperature_k\" = [200.0]\n\"model.gas.duration_s\" = [{values}]\n")
    };
    assert_eq!(label(&durations("0.008, 0.016")), of_none);
    assert_eq!(label(&durations("0.008, 0.016, 0.032")), of_none);
    let other = tempfile::tempdir().unwrap();
    assert_eq!(time_label(&durations("0.016, 0.032"), other.path()), of_none);
    // The log of each run has its scale.
    let name = "one";
    let manifest = "[model.gas]\nparticles = 9\nduration_s = 0.008\n[record]\nframes = 4\n";
    let (_, frames) = replay(name, manifest, other.path());
    let lines = frames[0].log_lines();
    assert!(lines.iter().any(|line| line.text.contains("1 s of playback = 50 ms simulated")));
}

/// At 0.004 frames per second, 36525 frames play for 105 days, which viewers do not support; at 25 frames per second they play for
/// 24 minutes.
#[test]
fn playback_longer_than_viewers_support_is_rejected_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("century.toml");
    let plan = |rate: &str| {
        let manifest = format!(
            "[model.orbit]\nduration_days = 36525.0\n[record]\nframes = 36525\nplayback_fps = {rate}\n"
        );
        fs::write(&path, manifest).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_run-experiment"));
        command.args(["--dry-run", "--output"]).args([folder.path(), &path]).output().unwrap()
    };
    let refused = plan("0.004");
    assert_eq!(refused.status.code(), Some(2));
    let words = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(words.contains("93 days") && words.contains("playback_fps"), "{words}");
    assert_eq!(plan("25.0").status.code(), Some(0));
}

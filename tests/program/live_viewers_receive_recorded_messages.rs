//! Promise: viewers of a run under way receive the messages that are recorded, byte for byte and in whole frames, and nothing
//! that they do, or fail to do, changes a byte of the recording.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::live_viewer::{Experiment, FRAME_NS, Heard, Recorded, Viewer, bytes, data, messages};
use std::collections::{BTreeMap, BTreeSet};
use std::net::TcpListener;
use std::process::Command;

const FRAMES: u64 = 8;

/// A run of each model with 8 frames after the start.
const RUNS: [&str; 4] = [
    "seed = 3\n[model.dem]\ndiscs = 30\nwidth_m = 0.01\nheight_m = 0.01\nduration_s = 0.02\n[record]\nframes = 8\n",
    "seed = 6\n[model.gas]\nparticles = 50\nduration_s = 0.01\n[record]\nframes = 8\n",
    "seed = 8\n[model.packing]\ndiscs = 40\n[record]\nframes = 8\n",
    "[model.orbit]\nduration_days = 100.0\n[record]\nframes = 8\n",
];

/// Steps a paused run from frame to frame and returns all that was heard of them.
fn step_through(viewer: &mut Viewer) -> Vec<Heard> {
    viewer.hear_the_announcement();
    viewer.ask(true, 1.0, 0, "pause");
    viewer.hear_until(|heard| matches!(heard, Heard::Playback(true, 0, id) if id == "pause"));
    viewer.subscribe_to_all();
    let mut heard = Vec::new();
    for frame in 0..=FRAMES {
        if frame > 0 {
            viewer.ask(true, 1.0, frame * FRAME_NS, "step");
        }
        // The last channel that every frame has.
        let is_last = |heard: &Heard| matches!(heard, Heard::Data((topic, time, _)) if topic == "/velocity" && *time == frame * FRAME_NS);
        heard.extend(viewer.hear_until(is_last));
    }
    viewer.ask(false, 100.0, 0, "play");
    heard.extend(viewer.hear_until(|heard| *heard == Heard::Closed));
    heard
}

#[test]
fn a_viewer_that_steps_receives_every_recorded_message() {
    for run in RUNS {
        let run =
            run.replace("[record]", "[record]\nchannels = [\"state\", \"discs\", \"velocity\"]");
        let experiment = Experiment::new(&run);
        let (mut program, address) = experiment.start("watched", &["--live-speed", "1"]);
        let heard = step_through(&mut Viewer::connect(&address));
        assert!(program.wait().unwrap().success());
        let recordings = experiment.recordings("watched");
        let mut received = data(&heard);
        // What waits for a late viewer comes in the order of the channels: `/walls` after `/velocity`, as it is recorded.
        let recorded = messages(&recordings[0]);
        received.sort_by_key(|(_, time, _)| *time);
        assert!(received == recorded, "{run}: {} messages of {}", received.len(), recorded.len());
        assert_eq!(
            recorded.iter().filter(|(topic, ..)| topic == "/frame").count() as u64,
            FRAMES + 1
        );
        assert!(bytes(&recordings) == experiment.unwatched(), "{run}: other bytes");
    }
}

/// The topics of each frame among messages.
fn frames(messages: &[Recorded]) -> BTreeMap<u64, BTreeSet<&str>> {
    let mut frames: BTreeMap<u64, BTreeSet<&str>> = BTreeMap::new();
    for (topic, time, _) in messages {
        frames.entry(*time).or_default().insert(topic);
    }
    frames
}

#[test]
fn a_viewer_that_does_not_read_misses_whole_frames_and_stops_nobody() {
    // 30 MB: more than the buffers of the connection hold.
    let run =
        "seed = 6\n[model.gas]\nparticles = 10000\nduration_s = 0.01\n[record]\nframes = 20\n";
    let experiment = Experiment::new(run);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "100"]);
    let mut asleep = Viewer::connect(&address);
    asleep.hear_the_announcement();
    asleep.subscribe_to_all();
    assert!(program.wait().unwrap().success());
    let recordings = experiment.recordings("watched");
    assert!(bytes(&recordings) == experiment.unwatched());
    // Whatever had come through by then are whole frames as recorded, but for the last, where the connection broke.
    let recorded = messages(&recordings[0]);
    let mut heard = Vec::new();
    while let Ok(message) = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| asleep.hear()))
    {
        if message == Heard::Closed {
            break;
        }
        heard.push(message);
    }
    let heard = data(&heard);
    assert!(heard.iter().all(|message| recorded.contains(message)));
    let (heard, recorded) = (frames(&heard), frames(&recorded));
    for (time, topics) in heard.iter().take(heard.len().saturating_sub(1)) {
        assert_eq!(recorded[time], *topics, "{time} ns");
    }
}

#[test]
fn a_late_viewer_sees_what_was_drawn_once_and_the_last_frame() {
    let experiment = Experiment::new(RUNS[0]);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "1"]);
    let mut first = Viewer::connect(&address);
    let announced = first.hear_the_announcement();
    let Heard::Text(info) = &announced[announced.len() - 2] else { panic!("{announced:?}") };
    assert_eq!(info["capabilities"], serde_json::json!(["time", "playbackControl"]));
    assert_eq!(info["dataEndTime"], serde_json::json!({ "sec": 0, "nsec": FRAMES * FRAME_NS }));
    first.ask(true, 1.0, 5 * FRAME_NS, "step");
    first.subscribe_to_all();
    let fifth = |heard: &Heard| matches!(heard, Heard::Data((topic, time, _)) if topic == "/contacts" && *time == 5 * FRAME_NS);
    first.hear_until(fifth);
    let mut late = Viewer::connect(&address);
    late.hear_the_announcement();
    late.subscribe_to_all();
    let seen =
        late.hear_until(|heard| matches!(heard, Heard::Data((topic, ..)) if topic == "/legend"));
    let seen: BTreeMap<String, u64> =
        data(&seen).into_iter().map(|(topic, time, _)| (topic, time)).collect();
    assert_eq!(seen["/walls"], 0);
    assert_eq!(seen["/legend"], 0);
    for topic in ["/frame", "/state", "/discs", "/energy", "/contacts"] {
        assert_eq!(seen[topic], 5 * FRAME_NS, "{topic}");
    }
    // A viewer that goes while it holds the run lets it go, once no other one is there.
    drop(first);
    late.ask(false, 100.0, 0, "play");
    late.hear_until(|heard| *heard == Heard::Closed);
    assert!(program.wait().unwrap().success());
    assert!(bytes(&experiment.recordings("watched")) == experiment.unwatched());
}

#[test]
fn a_pause_ends_with_its_viewer() {
    let experiment = Experiment::new(RUNS[2]);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "100"]);
    let mut viewer = Viewer::connect(&address);
    viewer.hear_the_announcement();
    viewer.ask(true, 1.0, 0, "pause");
    viewer.subscribe_to_all();
    viewer.hear_until(|heard| matches!(heard, Heard::Data(_)));
    drop(viewer);
    assert!(program.wait().unwrap().success());
    assert!(bytes(&experiment.recordings("watched")) == experiment.unwatched());
}

#[test]
fn ctrl_c_ends_a_paused_run_and_the_same_command_goes_on() {
    let experiment = Experiment::new(RUNS[3]);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "1"]);
    let mut viewer = Viewer::connect(&address);
    viewer.hear_the_announcement();
    viewer.ask(true, 1.0, 3 * FRAME_NS, "step");
    viewer.subscribe_to_all();
    let third = |heard: &Heard| matches!(heard, Heard::Data((topic, time, _)) if topic == "/frame" && *time == 3 * FRAME_NS);
    viewer.hear_until(third);
    let kill = Command::new("kill").args(["-INT", &program.id().to_string()]).status().unwrap();
    assert!(kill.success());
    viewer.hear_until(|heard| *heard == Heard::Closed);
    assert_eq!(program.wait().unwrap().code(), Some(130));
    // Going on, the run still shows what was drawn at its start.
    let (mut program, address) = experiment.start("watched", &["--live-speed", "100"]);
    let mut viewer = Viewer::connect(&address);
    viewer.hear_the_announcement();
    viewer.subscribe_to_all();
    let seen = data(&viewer.hear_until(|heard| *heard == Heard::Closed));
    assert!(program.wait().unwrap().success());
    let recordings = experiment.recordings("watched");
    assert!(bytes(&recordings) == experiment.unwatched());
    let recorded = messages(&recordings[0]);
    assert!(seen.iter().all(|message| recorded.contains(message)));
    assert!(seen.iter().any(|(topic, time, _)| topic == "/walls" && *time == 0));
    assert!(seen.iter().any(|(topic, time, _)| topic == "/frame" && *time == FRAMES * FRAME_NS));
}

#[test]
fn the_runs_of_a_sweep_are_shown_one_after_the_other() {
    let sweep = format!("{}[sweep]\n\"model.packing.discs\" = [30, 40]\n", RUNS[2]);
    let experiment = Experiment::new(&sweep);
    let (mut program, address) =
        experiment.start("watched", &["--live-speed", "100", "--jobs", "1"]);
    let mut viewer = Viewer::connect(&address);
    viewer.hear_the_announcement();
    let first: Vec<u64> = viewer.topics.keys().copied().collect();
    viewer.ask(true, 1.0, 0, "pause");
    viewer.subscribe_to_all();
    viewer.hear_until(|heard| matches!(heard, Heard::Data(_)));
    viewer.ask(true, 1.0, FRAMES * FRAME_NS, "to the end");
    viewer.ask(false, 100.0, 0, "play");
    let between = viewer.hear_the_announcement();
    assert!(
        between
            .iter()
            .any(|heard| matches!(heard, Heard::Text(said) if said["op"] == "unadvertise"))
    );
    assert!(viewer.topics.keys().all(|id| !first.contains(id)), "a channel's id is used once");
    viewer.subscribe_to_all();
    viewer.hear_until(|heard| *heard == Heard::Closed);
    assert!(program.wait().unwrap().success());
    assert!(bytes(&experiment.recordings("watched")) == experiment.unwatched());
}

#[test]
fn a_run_without_a_pace_cannot_be_held() {
    // About a second.
    let run = "seed = 6\n[model.gas]\nparticles = 2000\nduration_s = 1.0\n[record]\nframes = 2000\nchannels = [\"state\"]\n";
    let experiment = Experiment::new(run);
    let (mut program, address) = experiment.start("watched", &[]);
    let mut viewer = Viewer::connect(&address);
    let announced = viewer.hear_the_announcement();
    let Heard::Text(info) = &announced[announced.len() - 2] else { panic!("{announced:?}") };
    assert_eq!(info["capabilities"], serde_json::json!(["time"]));
    viewer.subscribe_to_all();
    viewer.ask(true, 1.0, 0, "pause");
    let heard = viewer.hear_until(|heard| *heard == Heard::Closed);
    assert!(heard.iter().any(|heard| matches!(heard, Heard::Text(said) if said["op"] == "status")));
    assert!(program.wait().unwrap().success());
    let recordings = experiment.recordings("watched");
    let recorded: BTreeSet<Recorded> = messages(&recordings[0]).into_iter().collect();
    let received = data(&heard);
    assert!(received.iter().all(|message| recorded.contains(message)));
    assert!(received.iter().any(|(topic, time, _)| topic == "/frame" && *time == 2000 * FRAME_NS));
    assert!(bytes(&recordings) == experiment.unwatched());
}

#[test]
fn a_port_in_use_is_named_and_nothing_is_run() {
    let occupied = TcpListener::bind("127.0.0.1:0").unwrap();
    let live = format!("--live={}", occupied.local_addr().unwrap().port());
    let experiment = Experiment::new(RUNS[2]);
    let output = experiment.command("watched", &[&live]).output().unwrap();
    assert_eq!(output.status.code(), Some(75));
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(complaint.contains(&occupied.local_addr().unwrap().to_string()), "{complaint}");
    assert!(experiment.recordings("watched").is_empty());
}

#[test]
#[ignore = "needs python3 with the packages of tests/interop/requirements.txt"]
fn a_foreign_client_receives_the_recorded_frames() {
    let run = "seed = 3\n[model.dem]\ndiscs = 200\nduration_s = 0.2\n[record]\nframes = 50\n";
    let experiment = Experiment::new(run);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "1"]);
    let output = Command::new("python3")
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/interop/live_viewer.py"))
        .arg(address)
        .arg(experiment.folder.path().join("watched/watched"))
        .output()
        .expect("python3 can be started");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(program.wait().unwrap().success());
    assert!(bytes(&experiment.recordings("watched")) == experiment.unwatched());
    println!("{said}");
}

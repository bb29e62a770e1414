//! Guarantee: viewers of a run in progress receive the recorded messages, byte for byte and in whole frames, and no viewer can change a
//! byte of the recording, whatever it sends or fails to read.
//!
//! Setup: viewers that step, pause, connect late, do not read, or disconnect, at runs of each model and at a sweep.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::live_viewer::{Experiment, FRAME_NS, Received, Recorded, Viewer, bytes, data, messages};
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

/// Steps a paused run from frame to frame and returns all received messages.
fn step_through(viewer: &mut Viewer) -> Vec<Received> {
    viewer.receive_the_announcement();
    viewer.ask(true, 1.0, 0, "pause");
    viewer.receive_until(|event| matches!(event, Received::Playback(true, 0, id) if id == "pause"));
    viewer.subscribe_to_all();
    let mut events = Vec::new();
    for frame in 0..=FRAMES {
        if frame > 0 {
            viewer.ask(true, 1.0, frame * FRAME_NS, "step");
        }
        // The last channel of every frame.
        let is_last = |event: &Received| matches!(event, Received::Data((topic, time, _)) if topic == "/velocity" && *time == frame * FRAME_NS);
        events.extend(viewer.receive_until(is_last));
    }
    viewer.ask(false, 100.0, 0, "play");
    events.extend(viewer.receive_until(|event| *event == Received::Closed));
    events
}

#[test]
fn stepping_viewer_receives_every_recorded_message() {
    for run in RUNS {
        let run =
            run.replace("[record]", "[record]\nchannels = [\"state\", \"discs\", \"velocity\"]");
        let experiment = Experiment::new(&run);
        let (mut program, address) = experiment.start("watched", &["--live-speed", "1"]);
        let events = step_through(&mut Viewer::connect(&address));
        assert_eq!(Experiment::end_of(&mut program), Some(0));
        let recordings = experiment.recordings("watched");
        let mut received = data(&events);
        // A late viewer receives stored messages in the order of the channels: `/walls` after `/velocity`, as recorded.
        let recorded = messages(&recordings[0]);
        received.sort_by_key(|(_, time, _)| *time);
        assert!(received == recorded, "{run}: {} messages of {}", received.len(), recorded.len());
        assert_eq!(
            recorded.iter().filter(|(topic, ..)| topic == "/frame").count() as u64,
            FRAMES + 1
        );
        assert!(
            bytes(&recordings) == experiment.recorded_without_viewer(),
            "{run}: the bytes differ"
        );
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
fn viewer_that_does_not_read_misses_whole_frames_and_does_not_delay_the_run() {
    // 30 MB: more than the buffers of the connection hold.
    let run =
        "seed = 6\n[model.gas]\nparticles = 10000\nduration_s = 0.01\n[record]\nframes = 20\n";
    let experiment = Experiment::new(run);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "100"]);
    let mut asleep = Viewer::connect(&address);
    asleep.receive_the_announcement();
    asleep.subscribe_to_all();
    assert_eq!(Experiment::end_of(&mut program), Some(0));
    let recordings = experiment.recordings("watched");
    assert!(bytes(&recordings) == experiment.recorded_without_viewer());
    // The frames received until then are complete and as recorded, except for the last one, where the connection broke.
    let recorded = messages(&recordings[0]);
    let mut events = Vec::new();
    loop {
        match asleep.receive() {
            Received::Closed => break,
            message => events.push(message),
        }
    }
    let events = data(&events);
    assert!(events.iter().all(|message| recorded.contains(message)));
    let (events, recorded) = (frames(&events), frames(&recorded));
    for (time, topics) in events.iter().take(events.len().saturating_sub(1)) {
        assert_eq!(recorded[time], *topics, "{time} ns");
    }
}

#[test]
fn late_viewer_receives_static_drawings_and_the_last_frame() {
    let experiment = Experiment::new(RUNS[0]);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "1"]);
    let mut first = Viewer::connect(&address);
    let announced = first.receive_the_announcement();
    let Received::Text(info) = &announced[announced.len() - 2] else { panic!("{announced:?}") };
    assert_eq!(info["capabilities"], serde_json::json!(["time", "playbackControl"]));
    assert_eq!(info["dataEndTime"], serde_json::json!({ "sec": 0, "nsec": FRAMES * FRAME_NS }));
    first.ask(true, 1.0, 5 * FRAME_NS, "step");
    first.subscribe_to_all();
    let fifth = |event: &Received| matches!(event, Received::Data((topic, time, _)) if topic == "/force_chains" && *time == 5 * FRAME_NS);
    first.receive_until(fifth);
    let mut late = Viewer::connect(&address);
    late.receive_the_announcement();
    late.subscribe_to_all();
    let seen =
        late.receive_until(|event| matches!(event, Received::Data((topic, ..)) if topic == "/log"));
    let seen: BTreeMap<String, u64> =
        data(&seen).into_iter().map(|(topic, time, _)| (topic, time)).collect();
    for topic in ["/particles", "/walls", "/legend", "/log"] {
        assert_eq!(seen[topic], 0, "{topic}");
    }
    for topic in ["/frame", "/state", "/discs", "/energy", "/force_chains"] {
        assert_eq!(seen[topic], 5 * FRAME_NS, "{topic}");
    }
    // The run continues when the last viewer that paused it disconnects.
    drop(first);
    late.ask(false, 100.0, 0, "play");
    late.receive_until(|event| *event == Received::Closed);
    assert_eq!(Experiment::end_of(&mut program), Some(0));
    assert!(bytes(&experiment.recordings("watched")) == experiment.recorded_without_viewer());
}

#[test]
fn pause_ends_when_its_viewer_disconnects() {
    let experiment = Experiment::new(RUNS[2]);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "100"]);
    let mut viewer = Viewer::connect(&address);
    viewer.receive_the_announcement();
    viewer.ask(true, 1.0, 0, "pause");
    viewer.subscribe_to_all();
    viewer.receive_until(|event| matches!(event, Received::Data(_)));
    drop(viewer);
    assert_eq!(Experiment::end_of(&mut program), Some(0));
    assert!(bytes(&experiment.recordings("watched")) == experiment.recorded_without_viewer());
}

#[test]
fn paused_run_can_be_interrupted_and_resumed() {
    let experiment = Experiment::new(RUNS[2]);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "1"]);
    let mut viewer = Viewer::connect(&address);
    viewer.receive_the_announcement();
    viewer.ask(true, 1.0, 3 * FRAME_NS, "step");
    viewer.subscribe_to_all();
    let third = |event: &Received| matches!(event, Received::Data((topic, time, _)) if topic == "/frame" && *time == 3 * FRAME_NS);
    viewer.receive_until(third);
    let kill = Command::new("kill").args(["-INT", &program.id().to_string()]).status().unwrap();
    assert!(kill.success());
    viewer.receive_until(|event| *event == Received::Closed);
    assert_eq!(Experiment::end_of(&mut program), Some(130));
    // After resuming, the run still sends the particles, the drawings and the log of its start.
    let (mut program, address) = experiment.start("watched", &["--live-speed", "100"]);
    let mut viewer = Viewer::connect(&address);
    viewer.receive_the_announcement();
    viewer.subscribe_to_all();
    let seen = data(&viewer.receive_until(|event| *event == Received::Closed));
    assert_eq!(Experiment::end_of(&mut program), Some(0));
    let recordings = experiment.recordings("watched");
    assert!(bytes(&recordings) == experiment.recorded_without_viewer());
    let recorded = messages(&recordings[0]);
    assert!(seen.iter().all(|message| recorded.contains(message)));
    for wanted in ["/particles", "/walls", "/legend", "/log"] {
        assert!(seen.iter().any(|(topic, time, _)| topic == wanted && *time == 0), "{wanted}");
    }
    assert!(seen.iter().any(|(topic, time, _)| topic == "/frame" && *time == FRAMES * FRAME_NS));
}

#[test]
fn runs_of_a_sweep_are_shown_in_order() {
    let sweep = format!("{}[sweep]\n\"model.packing.discs\" = [30, 40]\n", RUNS[2]);
    let experiment = Experiment::new(&sweep);
    let (mut program, address) =
        experiment.start("watched", &["--live-speed", "100", "--jobs", "1"]);
    let mut viewer = Viewer::connect(&address);
    viewer.receive_the_announcement();
    let first: Vec<u64> = viewer.topics.keys().copied().collect();
    viewer.ask(true, 1.0, 0, "pause");
    viewer.subscribe_to_all();
    viewer.receive_until(|event| matches!(event, Received::Data(_)));
    viewer.ask(true, 1.0, FRAMES * FRAME_NS, "to the end");
    viewer.ask(false, 100.0, 0, "play");
    let between = viewer.receive_the_announcement();
    assert!(
        between
            .iter()
            .any(|event| matches!(event, Received::Text(said) if said["op"] == "unadvertise"))
    );
    assert!(
        viewer.topics.keys().all(|id| !first.contains(id)),
        "a channel id must be used only once"
    );
    viewer.subscribe_to_all();
    viewer.receive_until(|event| *event == Received::Closed);
    assert_eq!(Experiment::end_of(&mut program), Some(0));
    assert!(bytes(&experiment.recordings("watched")) == experiment.recorded_without_viewer());
}

/// What a viewer receives from a run at full speed that it tries to pause; `None` if the run ended before the viewer had subscribed,
/// as it can on a busy machine.
fn try_to_pause(address: &str) -> Option<Vec<Received>> {
    let mut viewer = Viewer::try_connect(address).ok()?;
    let mut announced = Vec::new();
    while !matches!(announced.last(), Some(Received::Text(said)) if said["op"] == "advertise") {
        announced.push(viewer.receive());
        if announced.ends_with(&[Received::Closed]) {
            return None;
        }
    }
    let Received::Text(info) = &announced[announced.len() - 2] else { panic!("{announced:?}") };
    assert_eq!(info["capabilities"], serde_json::json!(["time"]));
    viewer.subscribe_to_all();
    viewer.ask(true, 1.0, 0, "pause");
    let events = viewer.receive_until(|event| *event == Received::Closed);
    (!data(&events).is_empty()).then_some(events)
}

#[test]
fn run_without_a_playback_speed_cannot_be_paused() {
    // The run takes about a second.
    let run = "seed = 6\n[model.gas]\nparticles = 2000\nduration_s = 1.0\n[record]\nframes = 2000\nchannels = [\"state\"]\n";
    let experiment = Experiment::new(run);
    let events = loop {
        let (mut program, address) = experiment.start("watched", &["--force"]);
        let events = try_to_pause(&address);
        assert_eq!(Experiment::end_of(&mut program), Some(0));
        if let Some(events) = events {
            break events;
        }
    };
    assert!(
        events.iter().any(|event| matches!(event, Received::Text(said) if said["op"] == "status"))
    );
    let recordings = experiment.recordings("watched");
    let recorded: BTreeSet<Recorded> = messages(&recordings[0]).into_iter().collect();
    let received = data(&events);
    assert!(received.iter().all(|message| recorded.contains(message)));
    assert!(received.iter().any(|(topic, time, _)| topic == "/frame" && *time == 2000 * FRAME_NS));
    assert!(bytes(&recordings) == experiment.recorded_without_viewer());
}

/// The times among received messages, ns.
fn times(events: &[Received]) -> Vec<u64> {
    let time = |event: &Received| match event {
        Received::Time(time) => Some(*time),
        _ => None,
    };
    events.iter().filter_map(time).collect()
}

/// A viewer drops everything drawn when its clock goes back, and subtracts the first time that it receives from the times of its
/// plots (Lichtblick 1.28.1, `FoxgloveWebSocketPlayer`: the first `time` of a session is `startTime`).
#[test]
fn clock_of_a_late_viewer_begins_at_the_start_of_the_run_and_only_advances() {
    let experiment = Experiment::new(RUNS[0]);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "1"]);
    let is_time = |event: &Received| matches!(event, Received::Time(_));
    let is_of = |wanted: &'static str| move |event: &Received| matches!(event, Received::Data((topic, ..)) if topic == wanted);
    let mut first = Viewer::connect(&address);
    let mut from_start = first.receive_the_announcement();
    from_start.extend(first.receive_until(is_time));
    assert_eq!(times(&from_start), [1], "the clock of a run that has not begun");
    first.ask(true, 1.0, 5 * FRAME_NS, "step");
    first.subscribe_to_all();
    let is_fifth = |event: &Received| matches!(event, Received::Data((topic, time, _)) if topic == "/force_chains" && *time == 5 * FRAME_NS);
    from_start.extend(first.receive_until(is_fifth));

    let mut late = Viewer::connect(&address);
    let mut events = late.receive_the_announcement();
    events.extend(late.receive_until(|event| *event == Received::Time(5 * FRAME_NS)));
    // Topic by topic, as panels do; the walls were drawn at time 0.
    for topic in ["/frame", "/walls", "/energy", "/legend", "/discs"] {
        late.subscribe(&[topic]);
        events.extend(late.receive_until(is_of(topic)));
    }
    assert_eq!(times(&events), [1, 5 * FRAME_NS], "the clock of a run in progress");

    first.ask(false, 100.0, 0, "play");
    events.extend(late.receive_until(|event| *event == Received::Closed));
    from_start.extend(first.receive_until(|event| *event == Received::Closed));
    for events in [from_start, events] {
        let times = times(&events);
        assert!(times.is_sorted_by(|one, next| one < next), "{times:?}");
        assert_eq!(times.last(), Some(&(FRAMES * FRAME_NS)));
    }
    assert_eq!(Experiment::end_of(&mut program), Some(0));
}

#[test]
fn port_in_use_is_named_and_no_run_starts() {
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
fn other_client_receives_the_recorded_frames() {
    let run = "seed = 3\n[model.dem]\ndiscs = 200\nduration_s = 0.2\n[record]\nframes = 50\n";
    let experiment = Experiment::new(run);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "1"]);
    let output = Command::new("python3")
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/interop/live_viewer.py"))
        .arg(address)
        .arg(experiment.folder.path().join("watched/watched"))
        .output()
        .expect("python3 must be on the PATH");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(Experiment::end_of(&mut program), Some(0));
    assert!(bytes(&experiment.recordings("watched")) == experiment.recorded_without_viewer());
    println!("{said}");
}

//! Guarantee: `compare --mcap` copies the first run bit for bit, places the others at the same simulated times, and states their
//! true distance.

use crate::subcommand_bench::{Bench, Called, recordings};
use kinetoscope_recording::reader::Recording;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// An orbit by three integrators, one of them with other frames.
const ORBIT: &str = "name = \"orbit\"\nseed = 1\n[model.orbit]\ntime_step_days = 2.0\nduration_days = 200.0\n[record]\nframes = 20\n[[sweep.variants]]\nname = \"1-euler\"\n\"model.orbit.integrator\" = \"explicit-euler\"\n[[sweep.variants]]\nname = \"2-verlet\"\n\"model.orbit.integrator\" = \"velocity-verlet\"\n[[sweep.variants]]\nname = \"3-rk4\"\n\"model.orbit.integrator\" = \"rk4\"\n\"record.frames\" = 50\n";

fn expect(called: &Called, code: i32) {
    assert_eq!(called.code, Some(code), "{}{}", called.out, called.err);
}

fn orbits() -> (Bench, Vec<PathBuf>) {
    let bench = Bench::new();
    bench.write("orbit.toml", ORBIT);
    expect(&bench.call(&["run", "--quiet", "orbit.toml"]), 0);
    let found = recordings(&bench.path("recordings/orbit"));
    assert_eq!(found.len(), 3);
    (bench, found)
}

fn merge(bench: &Bench, recordings: &[PathBuf], file: &str) -> Called {
    let paths = recordings.iter().map(|path| path.to_str().unwrap());
    bench.call(&["compare"].into_iter().chain(paths).chain(["--mcap", file]).collect::<Vec<_>>())
}

/// Log time and payload of every message by topic, as the container's own reader gives them.
fn messages(path: &Path) -> BTreeMap<String, Vec<(u64, Vec<u8>)>> {
    let bytes = fs::read(path).unwrap();
    let mut found: BTreeMap<String, Vec<(u64, Vec<u8>)>> = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let of_topic = found.entry(message.channel.topic.clone()).or_default();
        of_topic.push((message.log_time, message.data.into_owned()));
    }
    found
}

/// Simulated time and position of the first particle in every frame.
fn positions(path: &Path) -> Vec<(f64, [f64; 2])> {
    let frames = Recording::open(path).unwrap().frames().unwrap();
    let position = |frame: kinetoscope_recording::reader::RecordedFrame| {
        let state = frame.state().unwrap();
        (frame.clock.time, ["x", "y"].map(|name| state.value(0, name).unwrap()))
    };
    frames.map(|frame| position(frame.unwrap())).collect()
}

#[test]
fn first_run_is_copied_and_the_others_have_its_clock() {
    let (bench, found) = orbits();
    expect(&merge(&bench, &found, "all.mcap"), 4);
    let merged = messages(&bench.path("all.mcap"));
    for (topic, copied) in messages(&found[0]) {
        assert_eq!(merged[&format!("/run_1{topic}")], copied, "{topic}");
    }
    // The scale is that of the first run, although the third one has 50 frames in place of 20.
    let first = &messages(&found[0])["/frame"];
    let step = (first[1].0 - first[0].0) as f64 / positions(&found[0])[1].0;
    for (run, path) in found.iter().enumerate() {
        let times = merged[&format!("/run_{}/frame", run + 1)].iter().map(|message| message.0);
        for (log_time, (time, _)) in times.zip(positions(path)) {
            assert!((log_time as f64 - time * step).abs() <= 2.0, "run {run}, time {time}");
        }
    }
    // The exact state of every run, and the container again only where it is another one.
    for (run, path) in found.iter().enumerate() {
        let payloads = |messages: &[(u64, Vec<u8>)]| -> Vec<Vec<u8>> {
            messages.iter().map(|message| message.1.clone()).collect()
        };
        let copied = payloads(&merged[&format!("/run_{}/state", run + 1)]);
        assert_eq!(copied, payloads(&messages(path)["/state"]));
    }
    let walls = |run: usize| messages(&found[run]).remove("/walls");
    for (run, topic) in [(1, "/run_2/walls"), (2, "/run_3/walls")] {
        assert_eq!(merged.contains_key(topic), walls(run) != walls(0), "{topic}");
    }
    assert!(!merged.contains_key("/run_2/legend"));
    // The drawings of the others are ghosts. Control: those of the first run are not.
    let drawings = messages(&found[1]);
    assert_ne!(merged["/run_2/discs"][3].1, drawings["/discs"][3].1);
}

/// Reference: hypot of the differences of the recorded coordinates.
#[test]
fn separation_is_the_distance_of_the_particles() {
    let (bench, found) = orbits();
    expect(&merge(&bench, &found[..2], "two.mcap"), 4);
    let separations = &messages(&bench.path("two.mcap"))["/run_2/separation"];
    let (first, other) = (positions(&found[0]), positions(&found[1]));
    assert_eq!(separations.len(), first.len());
    for ((_, payload), ((_, a), (_, b))) in separations.iter().zip(first.iter().zip(&other)) {
        let distance = libm::hypot(a[0] - b[0], a[1] - b[1]);
        // A protobuf field of type double with tag 1 follows the byte 9; zero is left out.
        let stated = match payload[0] {
            9 => f64::from_le_bytes(payload[1..9].try_into().unwrap()),
            _ => 0.0,
        };
        assert_eq!(stated.to_bits(), distance.to_bits());
    }
    // Two runs of the same manifest are nowhere apart.
    fs::copy(&found[0], bench.path("copy.mcap")).unwrap();
    expect(&merge(&bench, &[found[0].clone(), bench.path("copy.mcap")], "same.mcap"), 0);
    let same = messages(&bench.path("same.mcap"));
    assert!(same["/run_2/separation"].iter().all(|(_, payload)| payload[0] != 9));
    assert!(!same.contains_key("/run_2/walls"), "the container is drawn once");
}

#[test]
fn layout_names_only_topics_of_the_merged_recording() {
    let (bench, found) = orbits();
    expect(&merge(&bench, &found, "all.mcap"), 4);
    let topics: BTreeSet<String> = messages(&bench.path("all.mcap")).into_keys().collect();
    let layout = fs::read_to_string(bench.path("all.layout.json")).unwrap();
    let named: BTreeSet<String> = layout
        .split('"')
        .filter(|text| text.starts_with("/run_"))
        .map(|text| text.split('.').next().unwrap().to_owned())
        .collect();
    let unused: Vec<_> = named.difference(&topics).collect();
    // Walls that are equal to those of the first run are not copied.
    assert!(unused.iter().all(|topic| topic.ends_with("/walls")), "{unused:?}");
    for topic in ["/run_1/discs", "/run_3/discs", "/run_2/orbit", "/run_3/separation"] {
        assert!(named.contains(topic), "{topic}: {named:?}");
    }
    assert!(layout.contains("integrator rk4"));
}

#[test]
fn merged_recording_is_reproducible_and_never_overwrites() {
    let (bench, found) = orbits();
    expect(&merge(&bench, &found, "all.mcap"), 4);
    let before = fs::read(bench.path("all.mcap")).unwrap();
    let again = merge(&bench, &found, "all.mcap");
    assert!(again.err.contains("already exists"), "{}", again.err);
    expect(&merge(&bench, &found, "again.mcap"), 4);
    assert_eq!(fs::read(bench.path("again.mcap")).unwrap(), before);
    // A layout of another program is kept as well, and nothing is compared.
    bench.write("other.layout.json", "other");
    for (file, part) in [("other.mcap", "other.layout.json already exists"), ("x.txt", ".mcap")] {
        let rejected = merge(&bench, &found, file);
        expect(&rejected, 2);
        assert!(rejected.err.contains(part) && rejected.out.is_empty(), "{}", rejected.err);
    }
    assert_eq!(fs::read(bench.path("other.layout.json")).unwrap(), b"other");
    let analyzed = bench.call(&["info", "all.mcap"]);
    assert!(analyzed.err.contains("holds several runs"), "{}{}", analyzed.out, analyzed.err);
}

#[test]
fn recordings_that_cannot_be_merged_are_rejected_and_leave_no_file() {
    let (bench, found) = orbits();
    bench.write("gas.toml", "name = \"gas\"\nseed = 1\n[model.gas]\nparticles = 5\nduration_s = 0.1\n[record]\nframes = 4\n");
    expect(&bench.call(&["run", "--quiet", "gas.toml"]), 0);
    let gas = recordings(&bench.path("recordings/gas")).remove(0);
    let other = merge(&bench, &[found[0].clone(), gas], "x.mcap");
    assert!(other.err.contains("different models: orbit and gas"), "{}", other.err);
    let many = merge(&bench, &vec![found[0].clone(); 8], "x.mcap");
    expect(&many, 2);
    assert!(many.err.contains("at most 7"), "{}", many.err);
    let bytes = fs::read(&found[1]).unwrap();
    fs::write(bench.path("torn.mcap"), &bytes[..bytes.len() / 2]).unwrap();
    expect(&merge(&bench, &[found[0].clone(), bench.path("torn.mcap")], "x.mcap"), 5);
    let left: Vec<_> = fs::read_dir(bench.path(""))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.starts_with("x.") || name.starts_with(".kinetoscope"))
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

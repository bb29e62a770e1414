//! Guarantee: a recording that keeps only keyframes is filled to the bytes of the full one, and an interval of it is recomputed to the
//! frames of a run that is recorded at that resolution; the original is never changed.

use crate::subcommand_bench::{Bench, Called, command, recordings};
use kinetoscope::Recording;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

/// Each model, and an interval to recompute: its start, end and distance of frames, and the key of that distance.
pub(super) const MODELS: [(&str, &str, [&str; 4]); 4] = [
    (
        "dem",
        "[model.dem]\ndiscs = 60\nwidth_m = 0.016\nheight_m = 0.016\nfriction = 0.5\nrolling_friction = 0.05\nduration_s = 0.03\n",
        ["0.0101", "0.0111", "1e-4", "every_s"],
    ),
    (
        "gas",
        "[model.gas]\nparticles = 50\nduration_s = 0.02\n",
        ["0.0101", "0.0111", "1e-4", "every_s"],
    ),
    (
        "packing",
        "[model.packing]\ndiscs = 40\nwall_noise_variance_rad2 = 0.003\n",
        ["2010", "2020", "1", "every_collisions"],
    ),
    ("orbit", "[model.orbit]\nduration_days = 100.0\n", ["31", "37", "0.5", "every_days"]),
];

/// Records an experiment in a folder of its own and returns the recording.
pub(super) fn recorded(bench: &Bench, folder: &str, model: &str, record: &str) -> PathBuf {
    bench.write("m.toml", &format!("name = \"m\"\nseed = 8\n{model}[record]\n{record}\n"));
    expect(&bench.call(&["run", "--quiet", "--output", folder, "m.toml"]), 0);
    recordings(&bench.path(folder).join("m")).remove(0)
}

pub(super) fn keyframes(bench: &Bench, model: &str) -> PathBuf {
    recorded(bench, "keys", model, "frames = 40\nkeep = \"keyframes\"\nkeyframe_distance = 7")
}

pub(super) fn expect(called: &Called, code: i32) {
    assert_eq!(called.code, Some(code), "{}{}", called.out, called.err);
}

pub(super) fn zoom(
    bench: &Bench,
    recording: &Path,
    [from, to, every]: [&str; 3],
    output: &str,
) -> Called {
    let recording = recording.to_str().unwrap();
    let interval = ["--from", from, "--to", to, "--every", every, "-o", output];
    bench.call(&[&["zoom", recording][..], &interval].concat())
}

/// The messages of each frame, by topic and log time.
fn messages(path: &Path) -> BTreeMap<u64, Vec<(String, u64, Vec<u8>)>> {
    let frames = Recording::open(path).unwrap().frames().unwrap().map(Result::unwrap);
    let of_frame = |frame: &kinetoscope_recording::reader::RecordedFrame| {
        // Drawn once, at the first frame of a file; the paths begin there.
        let once = ["/walls", "/legend", "/log", "/trail"];
        let messages = frame.messages().iter().filter(|message| !once.contains(&message.topic()));
        let parts = messages.map(|message| {
            (message.topic().to_owned(), message.log_time_ns(), message.payload().to_vec())
        });
        (frame.clock.frame, parts.collect())
    };
    frames.map(|frame| of_frame(&frame)).collect()
}

/// Control: the recording of the keyframes has other bytes, and fewer.
#[test]
fn filled_recording_has_the_bytes_of_the_full_one() {
    for (name, model, _) in MODELS {
        let bench = Bench::new();
        // Some keyframes are not drawn.
        let record = "frames = 40\ndraw_every = 3\n";
        let full = recorded(&bench, "full", model, record);
        let info = bench.call(&["info", full.to_str().unwrap()]).out;
        // 0, 3, …, 39 and 40.
        assert!(info.contains(", 15 of them drawn"), "{info}");
        let distance = "keep = \"keyframes\"\nkeyframe_distance = 7";
        let keys = recorded(&bench, "keys", model, &format!("{record}{distance}"));
        let original = fs::read(&keys).unwrap();
        expect(&bench.call(&["fill", keys.to_str().unwrap()]), 0);
        let filled = keys.with_file_name(full.file_name().unwrap());
        let expected = fs::read(&full).unwrap();
        assert!(fs::read(&filled).unwrap() == expected, "{name}");
        assert!(fs::read(&keys).unwrap() == original && original != expected, "{name}");
        // Of few particles, the scalars take most of the space.
        let is_small = matches!(name, "gas" | "orbit");
        assert!(is_small || original.len() < expected.len(), "{name}");
        expect(&bench.call(&["verify", keys.to_str().unwrap()]), 0);
        // There is nothing to fill in a full recording.
        expect(&bench.call(&["fill", filled.to_str().unwrap()]), 2);
    }
}

/// Control: frames of a run with another seed differ.
#[test]
fn zoomed_frames_are_those_of_a_run_at_that_resolution() {
    for (name, model, [from, to, every, key]) in MODELS {
        let bench = Bench::new();
        let interval = [from, to, every];
        let keys = keyframes(&bench, model);
        expect(&zoom(&bench, &keys, interval, "of_keys.mcap"), 0);
        let full = recorded(&bench, "full", model, "frames = 40");
        expect(&zoom(&bench, &full, interval, "of_full.mcap"), 0);
        let of_keys = messages(&bench.path("of_keys.mcap"));
        assert!(of_keys == messages(&bench.path("of_full.mcap")), "{name}");
        let fine = messages(&recorded(&bench, "fine", model, &format!("{key} = {every}")));
        assert!((10..=13).contains(&of_keys.len()), "{name}: {}", of_keys.len());
        for (frame, messages) in &of_keys {
            let mut expected = fine[frame].clone();
            if messages.iter().any(|(topic, ..)| topic == "/particles") {
                // Those of the start of the run.
                let start = fine[&0].iter().find(|(topic, ..)| topic == "/particles").unwrap();
                expected.insert(1, (start.0.clone(), expected[0].1, start.2.clone()));
                assert_eq!(of_keys.keys().next(), Some(frame), "{name}");
            }
            let topics = messages.iter().map(|(topic, ..)| topic);
            assert!(topics.eq(expected.iter().map(|(topic, ..)| topic)), "{name}");
            for (one, other) in messages.iter().zip(&expected) {
                assert!(one == other, "{name}: frame {frame}, {}", one.0);
            }
        }
        assert!(of_keys.values().next() != fine.values().next(), "{name}");
        expect(&bench.call(&["verify", "of_keys.mcap"]), 5);
        expect(&bench.call(&["analyze", "of_keys.mcap"]), 5);
    }
}

/// The last frame is a keyframe, so its picture is that of the full recording; each exported row is one of its rows.
#[test]
fn keyframes_and_parts_of_runs_are_drawn_and_exported() {
    for (name, model, [from, to, every, _]) in MODELS {
        let bench = Bench::new();
        let full = recorded(&bench, "full", model, "frames = 40");
        let keys = keyframes(&bench, model);
        expect(&zoom(&bench, &keys, [from, to, every], "part.mcap"), 0);
        let part = bench.path("part.mcap");
        let [of_full, of_keys, of_part] = [&full, &keys, &part].map(|recording| {
            let recording = recording.to_str().unwrap();
            for arguments in [["--thumbnail", "still.svg"], ["--format", "csv,xyz,gnuplot"]] {
                let output =
                    if arguments[0] == "--format" { &["--output", "out"][..] } else { &[] };
                expect(&bench.call(&[&["export", recording][..], &arguments, output].concat()), 0);
            }
            let animated = ["--thumbnail", "moving.png", "--thumbnail-frames", "3"];
            expect(&bench.call(&[&["export", recording][..], &animated].concat()), 0);
            fs::read(bench.path("still.svg")).unwrap()
        });
        assert!(of_keys == of_full && of_part != of_full, "{name}");
        let exported = |recording: &Path| bench.path("out").join(recording.file_stem().unwrap());
        let table =
            |recording: &Path| fs::read_to_string(exported(recording).join("state.csv")).unwrap();
        let (all, some) = (table(&full), table(&keys));
        let all: std::collections::BTreeSet<&str> = all.lines().collect();
        assert!(some.lines().all(|row| all.contains(row)) && some.lines().count() < all.len());
        for recording in [&full, &keys, &part] {
            let folder = exported(recording).join("gnuplot");
            let script = fs::read_to_string(folder.join("play.gp")).unwrap();
            let (_, frames) = script.split_once("for [frame ").unwrap();
            let frames = frames.split(']').next().unwrap();
            let frames: Vec<u64> = match frames.trim_start_matches("= ").split_once(':') {
                Some((first, last)) => (first.parse().unwrap()..=last.parse().unwrap()).collect(),
                None => frames.split(['"', ' ']).filter_map(|word| word.parse().ok()).collect(),
            };
            let files = frames.iter().map(|frame| folder.join(format!("frame_{frame:06}.txt")));
            let files: Vec<PathBuf> = files.collect();
            assert!(files.len() > 3 && files.iter().all(|file| file.exists()), "{name}: {script}");
        }
    }
}

#[test]
fn zoom_outside_the_run_or_below_a_step_is_rejected() {
    let bench = Bench::new();
    let keys = keyframes(&bench, MODELS[0].1);
    for (interval, part) in [
        (["0.01", "0.5", "1e-4"], "the run lasts from 0 to 0.0299"),
        (["0.02", "0.01", "1e-4"], "the run lasts from 0 to 0.0299"),
        (["-0.01", "0.01", "1e-4"], "the run lasts from 0 to 0.0299"),
        (["0.01", "0.02", "1e-9"], "less than one time step"),
        (["0.01", "0.02", "0"], "must be above 0"),
        (["0.01", "0.02", "nan"], "must be above 0"),
        (["nan", "0.02", "1e-4"], "is not an interval of the run"),
        (["0.0101", "0.0102", "0.01"], "no multiple of 0.01 s"),
        (["0.01", "0.02", "1e9"], "no multiple of 1000000000 s"),
    ] {
        let called = zoom(&bench, &keys, interval, "out.mcap");
        expect(&called, 2);
        assert!(called.err.contains(part), "{}", called.err);
        assert!(called.err.contains("\nhelp: "), "{}", called.err);
        assert!(!bench.path("out.mcap").exists());
    }
}

/// The last whole step is before the duration of 0.03 s. Control: `zoom_outside_the_run_or_below_a_step_is_rejected`.
#[test]
fn zoom_accepts_the_duration_of_the_manifest_as_the_end() {
    let bench = Bench::new();
    let full = recorded(&bench, "full", MODELS[0].1, "frames = 40");
    let last = |path: &Path| {
        let frames = Recording::open(path).unwrap().frames().unwrap().map(Result::unwrap);
        frames.map(|frame| frame.clock.time).last().unwrap()
    };
    assert!(last(&full) < 0.03);
    expect(&zoom(&bench, &full, ["0.0295", "0.03", "1e-4"], "end.mcap"), 0);
    assert_eq!(last(&bench.path("end.mcap")), last(&full));
    expect(&zoom(&bench, &full, ["0.0295", "0.0302", "1e-4"], "after.mcap"), 2);
}

/// A recording, its keyframes and an interval of it are one run. Control: `tests/guarantees/causes_of_differences.rs`.
#[test]
fn frames_of_other_times_are_not_compared_as_physics() {
    let bench = Bench::new();
    let keys = keyframes(&bench, MODELS[0].1);
    let path = keys.to_str().unwrap();
    expect(&bench.call(&["fill", path, "-o", "full.mcap"]), 0);
    expect(&zoom(&bench, &keys, ["0.01", "0.011", "1e-4"], "fine.mcap"), 0);
    for other in [path, "fine.mcap"] {
        let called = bench.call(&["compare", "full.mcap", other]);
        expect(&called, 4);
        let text = called.out + &called.err;
        assert!(!text.contains("states differ") && !text.contains("cause: "), "{text}");
    }
}

/// Before the run is executed. Control: the result of an earlier call is kept.
#[test]
fn existing_files_are_never_replaced() {
    let bench = Bench::new();
    let keys = keyframes(&bench, MODELS[0].1);
    let path = keys.to_str().unwrap();
    let original = fs::read(&keys).unwrap();
    bench.write("other.mcap", "not a recording");
    for (output, part) in [(path, "is the recording itself"), ("other.mcap", "is another file")] {
        for called in [
            bench.call(&["fill", path, "-o", output]),
            zoom(&bench, &keys, ["0.01", "0.011", "1e-4"], output),
        ] {
            expect(&called, 2);
            assert!(called.err.contains(part), "{}", called.err);
        }
    }
    let is_partial = |entry: fs::DirEntry| entry.file_name().to_string_lossy().contains("partial");
    let mut files = fs::read_dir(keys.parent().unwrap()).unwrap().map(Result::unwrap);
    assert!(!files.any(is_partial));
    assert!(fs::read(&keys).unwrap() == original);
    for _ in 0..2 {
        expect(&bench.call(&["fill", path, "-o", "full.mcap"]), 0);
        expect(&zoom(&bench, &keys, ["0.01", "0.011", "1e-4"], "fine.mcap"), 0);
    }
    // The result of another call.
    expect(&zoom(&bench, &keys, ["0.01", "0.011", "1e-4"], "full.mcap"), 2);
}

/// Control: a hundred times fewer frames than a viewer can play are accepted.
#[test]
fn zoom_of_more_frames_than_can_be_played_is_rejected_and_leaves_no_file() {
    let bench = Bench::new();
    let recording = bench.recording();
    let called = zoom(&bench, &recording, ["0", "0.0005", "1e-14"], "out.mcap");
    expect(&called, 2);
    assert!(called.err.contains("more than a viewer can play"), "{}", called.err);
    for name in ["out.mcap", "out.partial.mcap"] {
        assert!(!bench.path(name).exists(), "{name}");
    }
    expect(&zoom(&bench, &recording, ["0.0004", "0.0004", "1e-9"], "out.mcap"), 0);
}

/// Signal 9 at several instants: the original keeps its bytes, and the next call gives the right file.
#[test]
fn killed_fill_and_zoom_lose_nothing() {
    let bench = Bench::new();
    let model = "[model.dem]\ndiscs = 200\nduration_s = 0.05\nfriction = 0.5\n";
    let keys = keyframes(&bench, model);
    let original = fs::read(&keys).unwrap();
    let path = keys.to_str().unwrap();
    let calls = [
        vec!["fill", path, "-o", "out.mcap"],
        vec!["zoom", path, "--from", "0.01", "--to", "0.04", "--every", "5e-5", "-o", "out.mcap"],
    ];
    for arguments in calls {
        let once = |output: &str| {
            let mut arguments = arguments.clone();
            *arguments.last_mut().unwrap() = output;
            expect(&bench.call(&arguments), 0);
            fs::read(bench.path(output)).unwrap()
        };
        let expected = once(&format!("{}-expected.mcap", arguments[0]));
        for milliseconds in [5, 40, 100, 200] {
            let mut child = command();
            child.current_dir(bench.path("")).args(&arguments);
            let mut child = child.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            sleep(Duration::from_millis(milliseconds));
            child.kill().unwrap();
            child.wait().unwrap();
            if let Ok(found) = fs::read(bench.path("out.mcap")) {
                assert!(found == expected, "a file with this name is complete");
                fs::remove_file(bench.path("out.mcap")).unwrap();
            }
            assert!(fs::read(&keys).unwrap() == original);
        }
        assert!(once("out.mcap") == expected);
        fs::remove_file(bench.path("out.mcap")).unwrap();
    }
}

/// A killed run with keyframes resumes to the same bytes.
#[test]
fn killed_run_with_keyframes_resumes_to_the_same_bytes() {
    let bench = Bench::new();
    let model = "[model.dem]\ndiscs = 200\nduration_s = 0.05\nfriction = 0.5\n";
    let expected = fs::read(keyframes(&bench, model)).unwrap();
    let arguments = ["run", "--quiet", "--checkpoint-every", "0", "--output", "killed", "m.toml"];
    for milliseconds in [40, 100, 60, 150] {
        let mut child = command();
        child.current_dir(bench.path("")).args(arguments);
        let mut child = child.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        sleep(Duration::from_millis(milliseconds));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    expect(&bench.call(&arguments), 0);
    let found = recordings(&bench.path("killed/m")).remove(0);
    assert!(fs::read(found).unwrap() == expected);
}

//! Guarantee: what `fill` and `zoom` write takes the place of no other file, and the run that `fill` restored takes that of its keyframes:
//! it is analyzed, and `--prune` keeps it.

use crate::forged_recording::Forgery;
use crate::keyframes::{MODELS, expect, keyframes, recorded, zoom};
use crate::subcommand_bench::{Bench, recordings};
use std::fs;
use std::path::Path;

#[test]
fn result_that_cannot_be_written_is_rejected_by_its_path() {
    let bench = Bench::new();
    let keys = keyframes(&bench, MODELS[0].1);
    for output in ["", ".", "no/out.mcap", "m.toml/out.mcap", "out"] {
        for called in [
            bench.call(&["fill", keys.to_str().unwrap(), "-o", output]),
            zoom(&bench, &keys, ["0.01", "0.011", "1e-4"], output),
        ] {
            expect(&called, 2);
            let first = called.err.lines().next().unwrap();
            let named = if output.is_empty() { "`--output` is empty" } else { output };
            assert!(first.starts_with("error: ") && first.contains(named), "{}", called.err);
            assert!(called.err.contains("\nhelp: ") && !called.err.contains("partial"));
        }
    }
}

/// A file that another program wrote stays; what a killed call left is continued. Control: the same name without such a file.
#[test]
fn partial_files_of_others_are_kept() {
    let bench = Bench::new();
    let keys = keyframes(&bench, MODELS[0].1);
    let path = keys.to_str().unwrap();
    let fill = || bench.call(&["fill", path, "-o", "out.mcap"]);
    expect(&fill(), 0);
    let whole = fs::read(bench.path("out.mcap")).unwrap();
    let longer = [&whole[..], b"more"].concat();
    let foreign = [b"a diary".to_vec(), fs::read(&keys).unwrap(), longer];
    for content in &foreign {
        fs::remove_file(bench.path("out.mcap")).ok();
        fs::write(bench.path("out.partial.mcap"), content).unwrap();
        for called in [fill(), zoom(&bench, &keys, ["0.01", "0.011", "1e-4"], "out.mcap")] {
            expect(&called, 2);
            assert!(called.err.contains("out.partial.mcap exists"), "{}", called.err);
            assert!(called.err.contains("\nhelp: remove it"), "{}", called.err);
            assert!(fs::read(bench.path("out.partial.mcap")).unwrap() == *content);
        }
    }
    for left in [0, 5, 5000, whole.len()] {
        fs::write(bench.path("out.partial.mcap"), &whole[..left]).unwrap();
        expect(&fill(), 0);
        assert!(fs::read(bench.path("out.mcap")).unwrap() == whole);
        assert!(!bench.path("out.partial.mcap").exists());
        fs::remove_file(bench.path("out.mcap")).unwrap();
    }
}

/// A run that fails after its last keyframe, by inelastic collapse, is filled and recomputed up to the failure. Control: a changed hash of
/// the frames after the last keyframe, or one more frame, is found by every command that compares them, and a changed line about the failure by `zoom`.
#[test]
fn failed_run_is_restored_and_compared_to_its_end() {
    let bench = Bench::new();
    let model = "[model.packing]\ndiscs = 40\nrestitution = 0.5\nevents_per_disc = 2000\n";
    let record = "frames = 40\nkeep = \"keyframes\"\nkeyframe_distance = 7\n";
    bench.write("m.toml", &format!("name = \"m\"\nseed = 1\n{model}[record]\n{record}"));
    expect(&bench.call(&["run", "--quiet", "--output", "keys", "m.toml"]), 1);
    let keys = recordings(&bench.path("keys/m")).remove(0);
    let path = keys.to_str().unwrap();
    expect(&bench.call(&["fill", path, "-o", "full.mcap"]), 0);
    let interval = ["20000", "79990", "100"];
    let full = bench.path("full.mcap");
    for recording in [&keys, &full] {
        let zoomed = zoom(&bench, recording, interval, "fine.mcap");
        expect(&zoomed, 0);
        assert!(zoomed.out.contains("the run failed in this interval"), "{}", zoomed.out);
    }
    let hashes = hashes_after_the_last_keyframe(&keys);
    let digit = if hashes.ends_with("0ff") { "1ff" } else { "0ff" };
    // Of the last message, and of a frame that follows, whose scalars are missing: damage for a command that needs them.
    for (changed, code) in
        [(hashes[..hashes.len() - 3].to_owned() + digit, 4), (hashes.clone() + "ff", 5)]
    {
        let metadata = [("hashes".to_owned(), changed)].into();
        Forgery { metadata, ..Forgery::default() }.write(&keys, &bench.path("forged.mcap"));
        for (arguments, code) in [
            (&["fill", "forged.mcap", "-o", "out.mcap"][..], code),
            (&["verify", "forged.mcap"], 4),
            (&["compare", path, "forged.mcap"], 4),
        ] {
            expect(&bench.call(arguments), code);
        }
    }
    let other_line = |topic: &str, _: u64, payload: &mut Vec<u8>| {
        let place = payload.windows(12).position(|part| part == b"come to rest");
        if let ("/log", Some(place)) = (topic, place) {
            payload[place] = b'C';
        }
        true
    };
    let forgery = Forgery { message: Some(&other_line), ..Forgery::default() };
    forgery.write(&full, &bench.path("forged.mcap"));
    expect(&zoom(&bench, &bench.path("forged.mcap"), interval, "out.mcap"), 4);
}

/// The hashes of the frames after the last keyframe, in hexadecimal digits. Each frame ends with `ff`.
fn hashes_after_the_last_keyframe(recording: &Path) -> String {
    let bytes = fs::read(recording).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let mut records = summary.metadata_indexes.iter();
    let found = records.find_map(|index| {
        mcap::read::metadata(&bytes, index).unwrap().metadata.get("hashes").cloned()
    });
    found.unwrap()
}

/// Control: without `fill`, the analysis names it.
#[test]
fn restored_run_takes_the_place_of_its_keyframes_and_is_kept() {
    let bench = Bench::new();
    let keys = keyframes(&bench, MODELS[1].1);
    let ran = bench.call(&["run", "--output", "keys", "m.toml"]);
    let relative = |path: &Path| path.strip_prefix(bench.path("")).unwrap().to_owned();
    let fill = format!(" fill {}\n", relative(&keys).to_str().unwrap());
    assert!(ran.out.contains(&fill), "{}", ran.out);
    let of_keys = bench.call(&["analyze", "keys"]);
    expect(&of_keys, 0);
    assert!(of_keys.out.contains("kinetoscope fill"), "{}", of_keys.out);
    expect(&bench.call(&["fill", keys.to_str().unwrap()]), 0);
    let restored = recordings(&bench.path("keys/m"));
    assert_eq!(restored.len(), 2);
    let analyzed = bench.call(&["analyze", "keys"]);
    expect(&analyzed, 0);
    let text = &analyzed.out;
    assert!(!text.contains("stale") && !text.contains("kinetoscope fill"), "{text}");
    let ran = bench.call(&["run", "--prune", "--output", "keys", "m.toml"]);
    expect(&ran, 0);
    assert!(!ran.out.contains(" fill "), "{}", ran.out);
    assert_eq!(recordings(&bench.path("keys/m")), restored);
    // A restored run of another manifest is stale as its keyframes are.
    bench.write(
        "m.toml",
        &format!("name = \"m\"\nseed = 9\n{}[record]\nframes = 40\n", MODELS[1].1),
    );
    expect(&bench.call(&["run", "--quiet", "--prune", "--output", "keys", "m.toml"]), 0);
    assert!(recordings(&bench.path("keys/m")).iter().all(|path| !restored.contains(path)));
}

/// With and without `experiment.toml`. Control: the part alone is an error that names the recording of the whole run.
#[test]
fn interval_next_to_its_recording_is_left_out_of_the_analysis() {
    let bench = Bench::new();
    let full = recorded(&bench, "full", MODELS[1].1, "frames = 40");
    let interval = ["--from", "0.0101", "--to", "0.0111", "--every", "1e-4"];
    expect(&bench.call(&[&["zoom", full.to_str().unwrap()][..], &interval].concat()), 0);
    let files = recordings(&bench.path("full/m"));
    assert_eq!(files.len(), 2);
    for has_record in [true, false] {
        if !has_record {
            fs::remove_file(bench.path("full/m/experiment.toml")).unwrap();
        }
        let analyzed = bench.call(&["analyze", "full"]);
        expect(&analyzed, 0);
        let text = (analyzed.out + &analyzed.err).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains("is a part of a run, and only whole runs are analyzed"), "{text}");
        assert!(text.contains("1 run") && !text.contains("stale"), "{text}");
    }
    let part = files.iter().find(|path| **path != full).unwrap();
    let alone = bench.call(&["analyze", part.to_str().unwrap()]);
    expect(&alone, 5);
    assert!(alone.err.contains("help: name the recording of the whole run"), "{}", alone.err);
}

/// What a rerun does not read: the index at the end, of which viewers make use.
#[test]
fn fill_rejects_a_damaged_summary_before_the_run() {
    let bench = Bench::new();
    let keys = keyframes(&bench, MODELS[0].1);
    let mut bytes = fs::read(&keys).unwrap();
    // The last byte before the footer, its length of 29 and the magic of 8 bytes.
    let last = bytes.len() - 38;
    bytes[last] ^= 1;
    let copy = keys.with_file_name("damaged.mcap");
    fs::write(&copy, bytes).unwrap();
    let called = bench.call(&["fill", copy.to_str().unwrap(), "-o", "out.mcap"]);
    expect(&called, 5);
    assert!(called.err.contains("the summary does not match"), "{}", called.err);
    assert!(called.err.contains("\nhelp: copy the file again"), "{}", called.err);
    assert!(!bench.path("out.mcap").exists());
}

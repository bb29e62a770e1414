//! Guarantee: a size that a file or a manifest claims is compared with what a recording can have before memory is used. The whole
//! program needs less than 2 GiB of address space for any of these files, and no named pipe or device blocks it.

#![cfg(target_os = "linux")]

use crate::subcommand_bench::{Bench, Called, GAS};
use std::fs::{self, File};
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _, symlink};
use std::path::Path;
use std::process::Command;

/// Bytes that the sparse files claim.
const CLAIMED: u64 = 60_000_000_000;
const MAGIC: &[u8] = b"\x89MCAP0\r\n";
const ATTACHMENT: u8 = 0x09;
const CHUNK: u8 = 0x06;
const METADATA: u8 = 12;

/// Calls `kinetoscope` with 2 GiB of address space. A call that blocks is ended after two minutes.
fn call(bench: &Bench, arguments: &[&str]) -> Called {
    Command::new("timeout")
        .args(["--kill-after=5", "120", "sh", "-c", "ulimit -v 2097152; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_kinetoscope"))
        .args(arguments)
        .current_dir(bench.path("."))
        .env_remove("GITHUB_STEP_SUMMARY")
        .output()
        .unwrap()
        .into()
}

fn assert_error(called: &Called, code: i32, what: &str, case: &str) {
    assert_eq!(called.code, Some(code), "{case}: {}{}", called.out, called.err);
    let text = format!("{}{}", called.out, called.err);
    assert!(text.split_whitespace().collect::<Vec<_>>().join(" ").contains(what), "{case}: {text}");
    assert!(!text.contains("panicked"), "{case}: {text}");
}

/// Writes a file that ends in a record of this kind with a claimed length; its body is a hole.
fn write_claim(path: &Path, start: &[u8], kind: u8) {
    let claim = [start, &[kind], &CLAIMED.to_le_bytes()].concat();
    fs::write(path, &claim).unwrap();
    File::options().write(true).open(path).unwrap().set_len(claim.len() as u64 + CLAIMED).unwrap();
}

/// Position of the first record of a kind.
fn position_of(bytes: &[u8], kind: u8) -> usize {
    position_from(MAGIC.len(), bytes, kind)
}

/// Position of the first record of a kind at or behind another one.
fn position_from(mut position: usize, bytes: &[u8], kind: u8) -> usize {
    while bytes[position] != kind {
        let length: [u8; 8] = bytes[position + 1..position + 9].try_into().unwrap();
        position += 9 + u64::from_le_bytes(length) as usize;
    }
    position
}

fn start_from(bench: &Bench, recording: &str) {
    let text = format!(
        "seed = 1\n[model.gas]\nstart_from = \"{recording}\"\nduration_s = 0.001\n[record]\nframes = 4\n"
    );
    bench.write("next.toml", &text);
}

#[test]
fn claimed_size_of_a_record_is_rejected_before_it_is_read() {
    let bench = Bench::new();
    let recording = bench.recording();
    let bytes = fs::read(&recording).unwrap();
    let good = recording.to_str().unwrap();
    let chunk = position_of(&bytes, CHUNK);
    for (name, start, kind) in [
        ("attachment.mcap", &bytes[..position_of(&bytes, ATTACHMENT)], ATTACHMENT),
        ("chunk.mcap", &bytes[..chunk], CHUNK),
        // A hole reads as records of kind 0 and length 0.
        ("zeros.mcap", &bytes[..chunk], 0),
    ] {
        write_claim(&bench.path(name), start, kind);
        start_from(&bench, name);
        for (arguments, code) in [
            (&["info", name][..], 5),
            (&["verify", name], 5),
            (&["compare", good, name], 5),
            (&["analyze", name], 5),
            (&["export", "--thumbnail", "picture.png", name], 5),
            (&["check", "next.toml"], 2),
            (&["run", "--dry-run", "next.toml"], 2),
        ] {
            let called = call(&bench, arguments);
            let text = format!("{}{}", called.out, called.err);
            assert_eq!(called.code, Some(code), "{arguments:?}: {text}");
            // A start is rejected first because its recording has no end.
            let what = if code == 2 { "next.toml:3" } else { "damaged" };
            assert!(text.contains(what), "{arguments:?}: {text}");
            assert!(!text.contains("panicked"), "{arguments:?}: {text}");
        }
    }
}

#[test]
fn side_file_without_end_is_rejected() {
    let bench = Bench::new();
    let recording = bench.recording();
    let folder = recording.parent().unwrap();
    let place = folder.join("experiment.toml");
    fs::remove_file(&place).unwrap();
    symlink("/dev/zero", &place).unwrap();
    let called = call(&bench, &["analyze", folder.to_str().unwrap()]);
    assert_error(&called, 5, "a device, not a regular file", "/dev/zero");
    fs::remove_file(&place).unwrap();
    File::create(&place).unwrap().set_len(CLAIMED).unwrap();
    let called = call(&bench, &["analyze", folder.to_str().unwrap()]);
    assert_error(&called, 5, "it is larger than 64 MiB", "a sparse file");
}

/// Two files with the same frames before a hole. Control: the recording without a hole has the same bytes as itself.
#[test]
fn recordings_are_not_compared_behind_their_damage() {
    let bench = Bench::new();
    let recording = bench.recording();
    let bytes = fs::read(&recording).unwrap();
    // The outcome follows the chunks.
    let frames = &bytes[..position_from(position_of(&bytes, CHUNK), &bytes, METADATA)];
    write_claim(&bench.path("zeros.mcap"), frames, 0);
    let called = call(&bench, &["compare", "zeros.mcap", "zeros.mcap"]);
    assert_error(&called, 5, "5 frames: equal in every message", "two sparse files");
    assert!(!called.out.contains("byte"), "{}", called.out);
    assert!(called.err.contains("is damaged at byte"), "{}", called.err);
    let whole = recording.to_str().unwrap();
    assert_error(&call(&bench, &["compare", whole, whole]), 0, "equal in every byte", "no hole");
}

#[test]
fn manifest_above_16_mib_is_rejected() {
    let bench = Bench::new();
    let keys: String = (0..).map(|key| format!("k{key} = 1\n")).take(2_000_000).collect();
    bench.write("large.toml", &keys);
    assert!(keys.len() > 16 << 20);
    for arguments in [&["check", "large.toml"][..], &["run", "large.toml"]] {
        assert_error(&call(&bench, arguments), 2, "it is larger than 16 MiB", "check");
    }
}

#[test]
fn memory_is_compared_with_the_estimate_before_the_start_is_built() {
    let bench = Bench::new();
    for (model, extra) in [
        ("gas", "particles = 4294967295\nduration_s = 0.001"),
        ("dem", "discs = 4294967295\nradius_m = 1e-9\nplacement = \"lattice\"\nduration_s = 0.001"),
        ("packing", "discs = 4000000000\nradius = 1e-9\nplacement = \"lattice\"\nduration = 1.0"),
    ] {
        bench.write("huge.toml", &format!("seed = 1\n[model.{model}]\n{extra}\n"));
        for arguments in
            [&["check", "huge.toml"][..], &["run", "--dry-run", "huge.toml"], &["run", "huge.toml"]]
        {
            let called = call(&bench, arguments);
            assert_error(&called, 2, "GB of memory for its 4", model);
            assert!(called.err.contains("this machine has"), "{}", called.err);
        }
        assert!(!bench.path("recordings/huge").exists(), "{model}: a folder was created");
    }
}

#[test]
fn number_of_frames_near_the_largest_integer_is_rejected() {
    let bench = Bench::new();
    for (key, value) in [
        ("frames", "18446744073709551615"),
        ("frames", "9223372036854775807"),
        ("every_s", "1e-300"),
        ("frames", "4000000000"),
    ] {
        let text = format!("seed = 1\n[model.gas]\nparticles = 2\n[record]\n{key} = {value}\n");
        bench.write("long.toml", &text);
        let called = call(&bench, &["check", "long.toml"]);
        assert_eq!(called.code, Some(2), "{key} = {value}: {}{}", called.out, called.err);
        assert!(!called.err.contains("panicked"), "{}", called.err);
    }
}

/// The number of discs bounds the cells and columns of the analysis. Capacities of these boxes in cells: 1e16 and 1e32.
#[test]
fn memory_of_the_analysis_depends_on_the_discs_and_not_on_the_box() {
    let bench = Bench::new();
    let dem = "seed = 1\n[model.dem]\ndiscs = 2\nwidth_m = 1e9\nduration_s = 0.001\n\
               [record]\nframes = 2\n";
    let packing = "seed = 1\n[model.packing]\ndiscs = 5\nwidth = 1e5\nheight = 1e5\nradius = 1e-12\n\
                   events_per_disc = 2\n[record]\nframes = 2\n";
    for (name, text) in [("dem", dem), ("packing", packing)] {
        let manifest = format!("{name}.toml");
        bench.write(&manifest, text);
        let ran = call(&bench, &["run", "--quiet", &manifest]);
        assert_eq!(ran.code, Some(0), "{name}: {}", ran.err);
        let folder = format!("recordings/{name}");
        let called = call(&bench, &["analyze", &folder]);
        assert_eq!(called.code, Some(0), "{name}: {}{}", called.out, called.err);
    }
}

#[test]
fn named_pipes_block_no_subcommand() {
    let bench = Bench::new();
    let recording = bench.recording();
    let good = recording.to_str().unwrap().to_owned();
    let folder = recording.parent().unwrap().to_owned();
    let make = |path: &Path| {
        assert!(Command::new("mkfifo").arg(path).status().unwrap().success(), "{path:?}");
    };
    for name in ["fifo.mcap", "fifo.toml"] {
        make(&bench.path(name));
    }
    start_from(&bench, "fifo.mcap");
    let what = "a named pipe (FIFO)";
    for (arguments, code) in [
        (&["info", "fifo.mcap"][..], 5),
        (&["verify", "fifo.mcap"], 5),
        (&["compare", &good, "fifo.mcap"], 5),
        (&["compare", "fifo.mcap", &good], 5),
        (&["analyze", "fifo.mcap"], 5),
        (&["analyze", "--checks", "fifo.toml", &good], 2),
        (&["analyze", "--baseline", "fifo.toml", &good], 2),
        (&["export", "--thumbnail", "picture.png", "fifo.mcap"], 5),
        (&["check", "fifo.toml"], 2),
        (&["run", "fifo.toml"], 2),
        (&["benchmark", "fifo.toml"], 2),
        (&["why", "fifo.toml"], 2),
        (&["check", "next.toml"], 2),
        (&["run", "next.toml"], 2),
    ] {
        assert_error(&call(&bench, arguments), code, what, &format!("{arguments:?}"));
    }
    fs::remove_file(folder.join("experiment.toml")).unwrap();
    make(&folder.join("experiment.toml"));
    assert_error(&call(&bench, &["analyze", folder.to_str().unwrap()]), 5, what, "side file");
    // A start replaces it.
    assert_eq!(call(&bench, &["run", "gas.toml"]).code, Some(0));
    assert!(fs::metadata(folder.join("experiment.toml")).unwrap().is_file());
    make(&folder.join("timing.json"));
    assert_error(&call(&bench, &["analyze", folder.to_str().unwrap()]), 0, what, "timing table");
}

/// The files of an unfinished run: a pipe in place of the checkpoint or of the partial recording.
#[test]
fn named_pipe_in_place_of_an_unfinished_run_does_not_block_the_next_start() {
    let bench = Bench::new();
    let recording = bench.recording();
    fs::remove_file(&recording).unwrap();
    for (extension, code) in [("checkpoint", 0), ("partial.mcap", 75)] {
        let path = recording.with_extension(extension);
        assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
        let called = call(&bench, &["run", "gas.toml"]);
        assert_eq!(called.code, Some(code), "{extension}: {}{}", called.out, called.err);
        if code == 0 {
            assert!(!path.exists(), "{extension} is removed with the finished run");
            fs::remove_file(&recording).unwrap();
        } else {
            assert!(called.err.contains("a named pipe (FIFO)"), "{}", called.err);
        }
    }
}

#[test]
fn symbolic_link_in_place_of_a_file_of_the_run_is_not_followed() {
    let bench = Bench::new();
    let recording = bench.recording();
    let target = bench.write("precious", "keep me");
    fs::remove_file(&recording).unwrap();
    let partial = recording.with_extension("partial.mcap");
    symlink(&target, &partial).unwrap();
    let called = call(&bench, &["run", "gas.toml"]);
    assert_error(&called, 75, "it is a symbolic link", "partial");
    fs::remove_file(&partial).unwrap();
    for extension in ["host.json", "checkpoint.tmp", "checkpoint"] {
        let link = recording.with_extension(extension);
        drop(fs::remove_file(&link));
        symlink(&target, &link).unwrap();
    }
    let called = call(&bench, &["run", "--checkpoint-every", "0", "gas.toml"]);
    assert_eq!(called.code, Some(0), "{}", called.err);
    assert_eq!(fs::read_to_string(&target).unwrap(), "keep me");
}

#[test]
fn file_in_the_folder_that_is_not_a_recording_is_unreadable_and_not_stale() {
    let bench = Bench::new();
    let recording = bench.recording();
    let folder = recording.parent().unwrap();
    fs::write(folder.join("junk.mcap"), "junk").unwrap();
    let called = call(&bench, &["analyze", folder.to_str().unwrap()]);
    assert_error(&called, 5, "junk.mcap is not an MCAP file", "junk");
    assert!(!called.out.contains("stale"), "{}", called.out);
    fs::remove_file(folder.join("junk.mcap")).unwrap();
    fs::copy(&recording, folder.join("gas__00000000.mcap")).unwrap();
    assert_error(&call(&bench, &["analyze", folder.to_str().unwrap()]), 0, "is stale", "a copy");
}

#[test]
fn named_destination_is_written_and_not_replaced_by_another_kind_of_file() {
    let bench = Bench::new();
    let recording = bench.recording();
    let folder = recording.parent().unwrap().to_str().unwrap().to_owned();
    let target = bench.write("target.xml", "old");
    symlink(&target, bench.path("link.xml")).unwrap();
    // A link, so that a program that replaces its destination does not replace the device.
    symlink("/dev/full", bench.path("full.xml")).unwrap();
    assert!(Command::new("mkfifo").arg(bench.path("pipe")).status().unwrap().success());
    bench.write("other.toml", GAS);
    for (subcommand, option, input, written) in [
        ("analyze", "--junit", folder.as_str(), "<testsuite"),
        ("run", "--export-commands", "other.toml", "--only-keys"),
    ] {
        let called = call(&bench, &[subcommand, option, "link.xml", input]);
        assert_eq!(called.code, Some(0), "{}", called.err);
        assert!(fs::symlink_metadata(bench.path("link.xml")).unwrap().is_symlink(), "{option}");
        assert!(fs::read_to_string(&target).unwrap().contains(written), "{option}");
        let called = call(&bench, &[subcommand, option, "full.xml", input]);
        assert_eq!(called.code, Some(75), "{}{}", called.out, called.err);
        let device = fs::metadata(bench.path("full.xml")).unwrap();
        assert!(device.file_type().is_char_device(), "{option}");
        let called = call(&bench, &[subcommand, option, "pipe", input]);
        assert_error(&called, 75, "it is a named pipe that no program reads", option);
    }
    let called: Called = Command::new("timeout")
        .args(["--kill-after=5", "120", env!("CARGO_BIN_EXE_kinetoscope"), "analyze"])
        .args(["--github-annotations", &folder])
        .env("GITHUB_STEP_SUMMARY", bench.path("pipe"))
        .output()
        .unwrap()
        .into();
    assert_error(&called, 75, "it is a named pipe that no program reads", "step summary");
}

/// Side files are replaced through temporary files of their own; a start that has nothing to do writes nothing.
#[test]
fn concurrent_starts_of_a_finished_sweep_succeed_and_write_nothing() {
    const STARTS: usize = 5;
    const ROUNDS: usize = 8;
    let bench = Bench::new();
    let sweep = GAS.to_owned() + "[sweep]\nmodel.gas.particles = [2, 3, 4, 5]\n";
    bench.write("sweep.toml", &sweep);
    assert_eq!(bench.call(&["run", "--quiet", "sweep.toml"]).code, Some(0));
    let folder = bench.path("recordings/sweep");
    let record = folder.join("experiment.toml");
    let whole = fs::read(&record).unwrap();
    let state = || {
        let entries = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap());
        let mut files: Vec<_> = entries
            .map(|entry| {
                let file = entry.metadata().unwrap();
                (entry.file_name(), file.ino(), file.mtime(), file.mtime_nsec())
            })
            .collect();
        files.sort();
        files
    };
    let before = state();
    for round in 0..ROUNDS {
        // Half of the rounds begin without the side file, so that all starts replace it at once.
        if round % 2 == 1 {
            fs::remove_file(&record).unwrap();
        }
        let starts: Vec<_> = (0..STARTS)
            .map(|_| {
                let mut command = crate::subcommand_bench::command();
                command.current_dir(bench.path(".")).args(["run", "--quiet", "sweep.toml"]);
                command.stderr(std::process::Stdio::piped()).spawn().unwrap()
            })
            .collect();
        let mut running = starts;
        while !running.is_empty() {
            if let Ok(read) = fs::read(&record) {
                assert!(read == whole, "a reader saw a part of the file");
            }
            let mut index = 0;
            while index < running.len() {
                if running[index].try_wait().unwrap().is_some() {
                    let ended: Called = running.remove(index).wait_with_output().unwrap().into();
                    assert_eq!(ended.code, Some(0), "{}", ended.err);
                } else {
                    index += 1;
                }
            }
        }
        assert_eq!(fs::read(&record).unwrap(), whole);
        if round == 0 {
            assert_eq!(state(), before, "a start that had nothing to do wrote");
        }
    }
    let leftover =
        |(name, ..): &(std::ffi::OsString, u64, i64, i64)| name.to_string_lossy().ends_with(".tmp");
    assert!(!state().iter().any(leftover), "{:?}", state());
}

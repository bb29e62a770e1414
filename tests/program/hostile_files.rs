//! Guarantee: `info` reports what any file is, ends with exit code 5 unless it is a finished recording, and never panics; `analyze` names
//! what it cannot read.

use crate::subcommand_bench::{Bench, Called};
use std::fs;
use std::process::Command;

fn assert_reported(called: &Called, what: &str) {
    assert_eq!(called.code, Some(5), "{what}: {}{}", called.out, called.err);
    assert!(
        called.err.starts_with("error: ") && called.err.contains(what),
        "{what}: {}",
        called.err
    );
    assert!(!called.err.contains("panicked"), "{}", called.err);
}

#[test]
fn files_that_are_not_recordings_are_named() {
    let bench = Bench::new();
    let files: [(&str, &[u8], &str); 9] = [
        ("empty", b"", "an empty file"),
        ("text.mcap", b"hello", "a text file"),
        ("manifest.toml", b"seed = 1\n", "a TOML file"),
        ("table.json", b"{}", "a JSON file"),
        ("picture.png", b"\x89PNG\r\n\x1a\n", "a PNG image"),
        ("packed.gz", b"\x1f\x8b\x08", "gzip data"),
        ("bytes", b"\0\x01\x02\xff", "a file of unknown bytes"),
        ("magic.mcap", b"\x89MCAP0\r\n", "is cut off"),
        ("half.mcap", b"\x89MCAP0\r\n\x01\xff\xff\xff\xff\xff\xff\xff\xff", "error: "),
    ];
    for (name, bytes, what) in files {
        fs::write(bench.path(name), bytes).unwrap();
        assert_reported(&bench.call(&["info", name]), what);
        let json = bench.call(&["info", "--json", name]);
        assert!(json.json()["error"].as_str().unwrap().starts_with("error: "), "{}", json.out);
    }
    let expected = "error: bytes is not an MCAP file\nhelp: name a recording (*.mcap)\n";
    for option in ["--no-replay", "--quiet", "--json"] {
        let called = bench.call(&["analyze", option, "bytes"]);
        assert_eq!((called.code, called.err.as_str()), (Some(5), expected), "{option}");
    }
    fs::create_dir(bench.path("folder")).unwrap();
    assert_reported(&bench.call(&["info", "folder"]), "is a folder with 0 recordings");
    assert_reported(&bench.call(&["info", "missing"]), "cannot be read");
}

#[cfg(unix)]
#[test]
fn special_files_are_named_without_waiting() {
    let bench = Bench::new();
    assert!(Command::new("mkfifo").arg(bench.path("fifo")).status().unwrap().success());
    assert_reported(&bench.call(&["info", "fifo"]), "a named pipe (FIFO)");
    assert_reported(&bench.call(&["info", "/dev/zero"]), "a device");
}

#[test]
fn damaged_recordings_are_described_as_far_as_they_are_intact() {
    let bench = Bench::new();
    let recording = bench.recording();
    let bytes = fs::read(&recording).unwrap();
    for length in (0..bytes.len()).step_by(bytes.len() / 40) {
        fs::write(bench.path("cut.mcap"), &bytes[..length]).unwrap();
        assert_reported(&bench.call(&["info", "cut.mcap"]), "cut.mcap");
    }
    for place in (0..bytes.len()).step_by(bytes.len() / 40) {
        let mut flipped = bytes.clone();
        flipped[place] ^= 0xff;
        fs::write(bench.path("flipped.mcap"), flipped).unwrap();
        let called = bench.call(&["info", "flipped.mcap"]);
        assert!(matches!(called.code, Some(0 | 5)), "{place}: {}", called.err);
        assert!(!called.err.contains("panicked"), "{place}: {}", called.err);
    }
}

/// Both names are shown as the name that the side file gives its only run.
#[cfg(target_os = "linux")]
#[test]
fn names_that_are_not_utf_8_are_no_names_of_runs() {
    use std::os::unix::ffi::OsStrExt as _;
    let bench = Bench::new();
    let recording = bench.recording();
    let folder = recording.parent().unwrap();
    let name = recording.file_name().unwrap().to_str().unwrap();
    let record = folder.join("experiment.toml");
    let forged = fs::read_to_string(&record).unwrap().replace(name, "gas\u{fffd}.mcap");
    assert!(forged.contains('\u{fffd}'), "{forged}");
    fs::write(&record, forged).unwrap();
    for other in [b"gas\xff.mcap", b"gas\xfe.mcap"] {
        fs::copy(&recording, folder.join(std::ffi::OsStr::from_bytes(other))).unwrap();
    }
    fs::remove_file(&recording).unwrap();
    let called = bench.call(&["analyze", folder.to_str().unwrap()]);
    let text = format!("{}{}", called.out, called.err);
    assert_eq!(called.code, Some(0), "{text}");
    assert!(!text.contains("have no finished recording") && !text.contains("panicked"), "{text}");
    assert!(text.contains("not all of these recordings belong to the experiment"), "{text}");
}

/// As `info` and `analyze`: what could be read was used, and the damage is an error. Control: the intact recordings.
#[test]
fn damaged_recording_is_reported_by_every_command_that_reads_frames() {
    let bench = Bench::new();
    let gas = "name = \"gas\"\nseed = 1\n[model.gas]\nparticles = 20\nduration_s = 0.001\n[record]\nframes = 40\n";
    bench.write("gas.toml", gas);
    assert_eq!(bench.call(&["run", "--quiet", "gas.toml"]).code, Some(0));
    let recording = crate::subcommand_bench::recordings(&bench.path("recordings/gas")).remove(0);
    let mut bytes = fs::read(&recording).unwrap();
    fs::write(bench.path("intact.mcap"), &bytes).unwrap();
    // The last chunks, which `zoom` does not need.
    let chunks = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes;
    let chunk = chunks.last().unwrap();
    let middle = usize::try_from(chunk.chunk_start_offset + chunk.chunk_length / 2).unwrap();
    bytes[middle] ^= 1;
    fs::write(bench.path("damaged.mcap"), bytes).unwrap();
    let zoom = ["--from", "1e-4", "--to", "2e-4", "--every", "1e-5", "--output"];
    let commands: [(&[&str], &[&str], i32); 5] = [
        (&["info"], &[], 0),
        (&["analyze"], &[], 0),
        // A full recording cannot be filled.
        (&["fill"], &[], 2),
        (&["plot"], &["--y", "/energy.kinetic_j", "--output", "p.svg"], 0),
        (&["zoom"], &zoom, 0),
    ];
    for (command, options, code) in commands {
        for (file, code) in [("intact.mcap", code), ("damaged.mcap", 5)] {
            let output = format!("zoom_of_{file}");
            let mut arguments = [command, &[file], options].concat();
            if command == ["zoom"] {
                arguments.push(&output);
            }
            let called = bench.call(&arguments);
            assert_eq!(called.code, Some(code), "{arguments:?}: {}{}", called.out, called.err);
            if file == "damaged.mcap" {
                assert_reported(&called, "damaged.mcap is damaged at byte");
                assert!(called.err.contains("\nhelp: copy the file again"), "{}", called.err);
            }
        }
    }
    let [intact, damaged] = ["intact", "damaged"]
        .map(|name| fs::read(bench.path(&format!("zoom_of_{name}.mcap"))).unwrap());
    assert!(intact == damaged);
    let arguments = ["zoom", "--json", "damaged.mcap"];
    let json = bench.call(&[&arguments[..], &zoom, &["z.mcap"]].concat()).json();
    assert_eq!(
        (json["exit_code"].as_u64(), json["errors"].as_array().unwrap().len()),
        (Some(5), 1)
    );
}

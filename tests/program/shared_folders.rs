//! Guarantee: whatever other users and other processes put into a folder of recordings, no command destroys the run of another
//! process, writes outside of the folder, or blocks.

#![cfg(target_os = "linux")]

use crate::keyframes::{MODELS, keyframes};
use crate::subcommand_bench::{Bench, Called, recordings};
use std::fs::{self, File};
use std::os::unix::fs::{PermissionsExt as _, chown, symlink};
use std::path::Path;
use std::process::Command;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Calls `kinetoscope` in the folder of the bench. A call that blocks is ended after two minutes.
fn call(bench: &Bench, arguments: &[&str]) -> Called {
    Command::new("timeout")
        .args(["--kill-after=5", "120", env!("CARGO_BIN_EXE_kinetoscope")])
        .args(arguments)
        .current_dir(bench.path("."))
        .output()
        .unwrap()
        .into()
}

fn make_pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success(), "{path:?}");
}

/// The lock stands for a process that runs an earlier manifest again (`--force`).
#[test]
fn pruning_keeps_all_files_of_a_run_that_another_process_writes() {
    let bench = Bench::new();
    let old = bench.recording();
    bench.write("gas.toml", &crate::subcommand_bench::GAS.replace("seed = 1", "seed = 2"));
    assert_eq!(bench.call(&["run", "--quiet", "gas.toml"]).code, Some(0));
    let folder = bench.path("recordings/gas");
    fs::write(old.with_extension("checkpoint"), "state").unwrap();
    let partial = File::create(old.with_extension("partial.mcap")).unwrap();
    partial.try_lock().unwrap();
    let before = names(&folder);
    let pruned = bench.call(&["run", "--prune", "gas.toml"]);
    assert_eq!(pruned.code, Some(0), "{}", pruned.err);
    assert_eq!(names(&folder), before);
    assert!(!pruned.out.contains("stale, removed"), "{}", pruned.out);
    assert!(pruned.out.contains("another process is writing this run"), "{}", pruned.out);
    drop(partial);
    let pruned = bench.call(&["run", "--prune", "gas.toml"]);
    assert_eq!(pruned.code, Some(0), "{}", pruned.err);
    assert!(pruned.out.contains("stale, removed"), "{}", pruned.out);
    assert_eq!(recordings(&folder).len(), 1);
    let stem = old.file_stem().unwrap().to_str().unwrap();
    assert!(!names(&folder).iter().any(|name| name.starts_with(stem)), "{:?}", names(&folder));
}

/// The lock stands for a process that writes the recording. Control: without it, the recording is cut off.
#[test]
fn recording_that_another_process_writes_is_not_compared_with_its_run() {
    let bench = Bench::new();
    let keys = keyframes(&bench, MODELS[0].1);
    let bytes = fs::read(&keys).unwrap();
    let place = bench.write("growing.partial.mcap", "");
    fs::write(&place, &bytes[..bytes.len() * 3 / 4]).unwrap();
    let interval = ["--from", "0.001", "--to", "0.002", "--every", "1e-4", "-o", "out.mcap"];
    let verify = ["verify", "growing.partial.mcap"];
    let fill = ["fill", "growing.partial.mcap", "-o", "out.mcap"];
    let zoom = [&["zoom", "growing.partial.mcap"], &interval[..]].concat();
    let writer = File::open(&place).unwrap();
    writer.try_lock().unwrap();
    for arguments in [&verify[..], &fill, &zoom] {
        let called = call(&bench, arguments);
        assert_eq!(called.code, Some(5), "{arguments:?}: {}{}", called.out, called.err);
        let expected = "is being written by another process\nhelp: wait for the end of its run";
        assert!(called.err.contains(expected), "{arguments:?}: {}", called.err);
    }
    drop(writer);
    let called = call(&bench, &verify);
    assert_eq!(called.code, Some(5), "{}{}", called.out, called.err);
    assert!(called.err.contains("is cut off"), "{}", called.err);
}

#[test]
fn export_replaces_links_and_pipes_in_place_of_its_files() {
    let bench = Bench::new();
    let recording = bench.recording();
    let precious = bench.write("precious", "keep me");
    let folder = bench.path("recordings/gas/export").join(recording.file_stem().unwrap());
    let arguments =
        ["export", "--format", "csv", "--format", "xyz", "--format", "gnuplot", "recordings/gas"];
    assert_eq!(call(&bench, &arguments).code, Some(0));
    let files = ["state.csv", "state.xyz", "gnuplot/play.gp", "gnuplot/frame_000001.txt"];
    let exported = files.map(|name| fs::read(folder.join(name)).unwrap());
    let plant: [&dyn Fn(&Path); 2] = [&|path| symlink(&precious, path).unwrap(), &make_pipe];
    for plant in plant {
        for name in files {
            fs::remove_file(folder.join(name)).unwrap();
            plant(&folder.join(name));
        }
        let called = call(&bench, &arguments);
        assert_eq!(called.code, Some(0), "{}", called.err);
        assert_eq!(fs::read_to_string(&precious).unwrap(), "keep me");
        for (name, bytes) in files.iter().zip(&exported) {
            let path = folder.join(name);
            assert!(fs::symlink_metadata(&path).unwrap().is_file(), "{name}");
            assert!(fs::read(&path).unwrap() == *bytes, "{name} differs");
        }
        let leftover = |name: &String| name.ends_with(".tmp");
        assert!(!names(&folder).iter().any(leftover), "{:?}", names(&folder));
    }
}

#[test]
fn planted_leftovers_of_a_finished_run_are_a_warning() {
    let bench = Bench::new();
    let recording = bench.recording();
    let precious = bench.write("precious", "keep me");
    let make_link = |path: &Path| symlink(&precious, path).unwrap();
    let make_folder = |path: &Path| fs::create_dir(path).unwrap();
    type Plant<'a> = &'a dyn Fn(&Path);
    let cases: [(&str, Plant<'_>); 4] = [
        ("partial.mcap", &make_link),
        ("partial.mcap", &make_pipe),
        ("partial.mcap", &make_folder),
        ("checkpoint", &make_folder),
    ];
    let folder = recording.parent().unwrap();
    for (extension, plant) in cases {
        let planted = recording.with_extension(extension);
        plant(&planted);
        let before = names(folder);
        let called = call(&bench, &["run", "gas.toml"]);
        assert_eq!(called.code, Some(0), "{extension}: {}", called.err);
        assert!(called.err.contains("warning: a leftover of a finished run"), "{}", called.err);
        assert!(called.err.contains(extension), "{}", called.err);
        assert!(called.out.contains("Nothing to do"), "{}", called.out);
        assert_eq!(names(folder), before, "{extension}");
        fs::remove_file(&planted).or_else(|_| fs::remove_dir(&planted)).unwrap();
    }
    assert_eq!(fs::read_to_string(&precious).unwrap(), "keep me");
}

/// The stem of a plot of the analysis of [`Bench::recording`].
const STEM: &str = "state_at_start";

/// Replaces the stem of a plot in the cached analysis.
fn forge_stem(cache: &Path, forged: &str) {
    assert_eq!(forged.len(), STEM.len());
    let mut bytes = fs::read(cache).unwrap();
    let place = bytes.windows(STEM.len()).position(|part| part == STEM.as_bytes());
    let place = place.expect("the cache contains the plot");
    bytes[place..place + STEM.len()].copy_from_slice(forged.as_bytes());
    fs::write(cache, bytes).unwrap();
}

fn cache_of(recording: &Path) -> std::path::PathBuf {
    let name = recording.file_name().unwrap().to_str().unwrap();
    recording.with_file_name(".analysis-cache").join(format!("{name}.numbers"))
}

#[test]
fn forged_cache_names_no_file_elsewhere() {
    let bench = Bench::new();
    let recording = bench.recording();
    let plot = recording.with_file_name(format!("{STEM}.svg"));
    for (forged, target) in [("../../overhere", "overhere.svg"), (".hidden_so_far", "")] {
        assert_eq!(call(&bench, &["analyze", "recordings/gas"]).code, Some(0));
        forge_stem(&cache_of(&recording), forged);
        fs::remove_file(&plot).unwrap();
        let called = call(&bench, &["analyze", "recordings/gas"]);
        assert_eq!(called.code, Some(0), "{}", called.err);
        assert!(target.is_empty() || !bench.path(target).exists(), "a file was written elsewhere");
        assert!(plot.exists(), "the recording was not read again");
        let written = names(&bench.path("recordings/gas"));
        assert!(!written.contains(&format!("{forged}.svg")), "{written:?}");
    }
}

#[test]
fn cache_that_another_user_can_have_written_is_not_read() {
    let bench = Bench::new();
    let recording = bench.recording();
    let cache = cache_of(&recording);
    let forged = "state_at_a_lie";
    let is_believed = |change: &dyn Fn()| {
        let written = recording.with_file_name(format!("{forged}.svg"));
        assert_eq!(call(&bench, &["analyze", "--no-cache", "recordings/gas"]).code, Some(0));
        drop(fs::remove_file(&cache));
        assert_eq!(call(&bench, &["analyze", "recordings/gas"]).code, Some(0));
        forge_stem(&cache, forged);
        change();
        assert_eq!(call(&bench, &["analyze", "recordings/gas"]).code, Some(0));
        written.exists()
    };
    let allow = |mode| fs::set_permissions(&cache, fs::Permissions::from_mode(mode)).unwrap();
    assert!(is_believed(&|| ()), "control: a cache of this user is read");
    assert!(!is_believed(&|| allow(0o664)), "the group can write it");
    assert!(!is_believed(&|| allow(0o646)), "others can write it");
    // Only root can give a file away.
    if chown(&cache, Some(12_345), None).is_ok() {
        fs::remove_file(&cache).unwrap();
        assert!(!is_believed(&|| chown(&cache, Some(12_345), None).unwrap()), "another user's");
    }
    // A mask that lets the group write does not make the cache useless.
    fs::remove_file(&cache).unwrap();
    let analyze =
        format!("umask 002; exec {} analyze recordings/gas", env!("CARGO_BIN_EXE_kinetoscope"));
    let analyzed =
        Command::new("sh").args(["-c", &analyze]).current_dir(bench.path(".")).status().unwrap();
    assert!(analyzed.success());
    assert_eq!(fs::metadata(&cache).unwrap().permissions().mode() & 0o777, 0o644);
}

/// Root lists any folder, unless the program lacks the capabilities for it.
fn call_without_capabilities(bench: &Bench, arguments: &[&str]) -> Called {
    let mut command = if may_list_any_folder() {
        let mut command = Command::new("setpriv");
        command.args(["--bounding-set=-dac_override,-dac_read_search"]);
        command.arg(env!("CARGO_BIN_EXE_kinetoscope"));
        command
    } else {
        crate::subcommand_bench::command()
    };
    command.args(arguments).current_dir(bench.path(".")).output().unwrap().into()
}

/// Whether this process may list a folder without permissions.
fn may_list_any_folder() -> bool {
    let folder = tempfile::tempdir().unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o0)).unwrap();
    fs::read_dir(folder.path()).is_ok()
}

#[test]
fn folder_that_cannot_be_listed_ends_no_command_for_the_others() {
    let bench = Bench::new();
    let recording = bench.recording();
    let closed = bench.path("recordings/a_closed_one");
    fs::create_dir(&closed).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o0)).unwrap();
    let y = ["--y", "/energy.kinetic_j", "--output", "p.svg"];
    for (arguments, written) in [
        (&["analyze", "recordings", "--junit", "checks.xml"][..], "recordings/gas/report.html"),
        (&["analyze", "recordings", "--output", "results"], "results/report.html"),
        (&["export", "--format", "csv", "recordings"], "recordings/gas/export"),
        (&[&["plot", "recordings"][..], &y].concat(), "p.svg"),
    ] {
        let called = call_without_capabilities(&bench, arguments);
        assert_eq!(called.code, Some(5), "{arguments:?}: {}{}", called.out, called.err);
        let what = "recordings/a_closed_one cannot be listed: Permission denied";
        assert!(called.err.contains(what), "{arguments:?}: {}", called.err);
        assert!(called.err.contains("\nhelp: check its permissions"), "{}", called.err);
        assert!(bench.path(written).exists(), "{arguments:?}");
    }
    assert!(fs::read_to_string(bench.path("checks.xml")).unwrap().contains("a_closed_one"));
    // Nothing else: the error is that of the folder.
    fs::remove_dir_all(recording.parent().unwrap()).unwrap();
    for arguments in [&["analyze", "recordings"][..], &[&["plot", "recordings"][..], &y].concat()] {
        let called = call_without_capabilities(&bench, arguments);
        assert_eq!(called.code, Some(5), "{arguments:?}: {}{}", called.out, called.err);
        assert!(called.err.contains("cannot be listed"), "{arguments:?}: {}", called.err);
    }
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o700)).unwrap();
}

#[test]
fn folder_in_place_of_a_side_file_is_named() {
    let bench = Bench::new();
    let folder = bench.recording().parent().unwrap().to_owned();
    for name in ["experiment.toml", "gas.layout.json"] {
        let path = folder.join(name);
        fs::remove_file(&path).unwrap();
        fs::create_dir(&path).unwrap();
        let called = bench.call(&["run", "--quiet", "--force", "gas.toml"]);
        assert_eq!(called.code, Some(2), "{name}: {}", called.err);
        assert!(called.err.contains(&format!("{name}: Is a directory")), "{name}: {}", called.err);
        fs::remove_dir(&path).unwrap();
    }
}

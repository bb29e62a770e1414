//! Guarantee: `reproduce` accepts a bundle only if every file is the one that its own rerun gives, whatever an author who knows the layout
//! puts into it. What no rerun can confirm is named.

use crate::bundles::{BY, GAS, analyzed, bundle, contents, expect, forged, packed, sealed};
use crate::subcommand_bench::{Bench, Called, recordings};
use std::fs;
use std::io::{Cursor, Write as _};
use std::path::Path;
use std::process::Command;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

type Files = Vec<(String, Vec<u8>)>;

/// The files of a bundle with recordings.
fn original(bench: &Bench) -> Files {
    expect(&bundle(bench, &["--recordings"]), 0);
    contents(&fs::read(bench.path("gas.zip")).unwrap())
}

/// Calls `reproduce` with a forged bundle of these files.
fn reproduce(bench: &Bench, files: &Files) -> Called {
    fs::write(bench.path("forged.zip"), forged(files)).unwrap();
    bench.call(&["reproduce", "forged.zip"])
}

fn file<'a>(files: &'a mut Files, end: &str) -> &'a mut Vec<u8> {
    &mut files.iter_mut().find(|(name, _)| name.ends_with(end)).unwrap().1
}

/// Replaces a part of a text once.
fn edit(files: &mut Files, end: &str, from: &str, to: &str) {
    let bytes = file(files, end);
    let text = String::from_utf8(bytes.clone()).unwrap();
    assert!(text.contains(from), "{from}: {text}");
    *bytes = text.replacen(from, to, 1).into_bytes();
}

/// A sentence in the paragraph of the machine, which the rerun has as well. Control: the untouched files are reproduced.
#[test]
fn every_file_is_compared_with_that_of_the_rerun() {
    let bench = analyzed();
    let original = original(&bench);
    expect(&reproduce(&bench, &original), 0);
    let differs = |change: &dyn Fn(&mut Files), part: &str| {
        let mut files = original.clone();
        change(&mut files);
        let called = reproduce(&bench, &files);
        expect(&called, 4);
        assert!(called.err.contains(part), "{part}: {}", called.err);
        assert!(!called.out.contains("is reproduced"), "{}", called.out);
    };
    let hidden = "<p class=\"machine\">The drift is 7.</p></body>";
    differs(&|files| edit(files, "report.html", "</body>", hidden), "report.html is not");
    differs(&|files| edit(files, "CITATION.cff", "Its drift", "Its rise"), "CITATION.cff is not");
    differs(&|files| edit(files, ".zenodo.json", "Its drift", "Its rise"), ".zenodo.json is not");
    differs(&|files| edit(files, "ro-crate-metadata.json", "Its drift", "Its rise"), "ro-crate");
    differs(
        &|files| edit(files, "bundle.json", "CC-BY-4.0", "CC0-1.0"),
        "is not that of the rerun",
    );
    differs(&|files| file(files, "bundle.json").push(b' '), "its values are equal");
    differs(&|files| files.push(("recordings/gas/more.svg".to_owned(), Vec::new())), "more.svg");
    differs(
        &|files| files.retain(|(name, _)| !name.ends_with("metrics.csv")),
        "has no recordings/gas/metrics.csv",
    );
    // The recording of another run under the name of this one.
    let other = Bench::new();
    other.write("gas.toml", &GAS.replace("seed = 1", "seed = 2"));
    expect(&other.call(&["run", "--quiet", "gas.toml"]), 0);
    let foreign = fs::read(&recordings(&other.path("recordings/gas"))[0]).unwrap();
    differs(&|files| file(files, ".mcap").clone_from(&foreign), ".mcap is not");
}

/// A file that is not in the directory at the end of the ZIP file, and bytes before its first file: programs that read it from its start
/// would unpack others. Control: the same bytes with neither.
#[test]
fn files_outside_of_the_directory_are_refused() {
    let bench = analyzed();
    let original = original(&bench);
    let plain = packed(&original);
    fs::write(bench.path("forged.zip"), sealed(plain.clone())).unwrap();
    expect(&bench.call(&["reproduce", "forged.zip"]), 0);
    let mut files = original;
    files.push(("hidden.html".to_owned(), b"text".to_vec()));
    let mut hidden = packed(&files);
    // Without its entry: the end of the file states the number and the bytes of the entries (APPNOTE.TXT 4.3.16).
    let last = hidden.windows(4).rposition(|bytes| bytes == b"PK\x01\x02").unwrap();
    let end = hidden.windows(4).rposition(|bytes| bytes == b"PK\x05\x06").unwrap();
    let mut tail = hidden[end..].to_vec();
    for count in [8, 10] {
        tail[count] -= 1;
    }
    let bytes = u32::from_le_bytes(tail[12..16].try_into().unwrap());
    let removed = u32::try_from(end - last).unwrap();
    tail[12..16].copy_from_slice(&(bytes - removed).to_le_bytes());
    hidden.truncate(last);
    hidden.extend_from_slice(&tail);
    let before = [b"#!/bin/sh\n".to_vec(), plain].concat();
    for (zip, part) in [(hidden, "missing from central directory"), (before, "")] {
        fs::write(bench.path("forged.zip"), sealed(zip)).unwrap();
        let called = bench.call(&["reproduce", "forged.zip"]);
        expect(&called, 5);
        assert!(called.err.contains(part), "{}", called.err);
    }
}

/// The readable texts of the lock file, with the hash that belongs to them.
#[test]
fn forged_texts_of_the_lock_file_are_found() {
    let bench = analyzed();
    let mut files = original(&bench);
    bench.write("gas.toml", &GAS.replace("tolerance = 1e-9", "tolerance = 1e-8"));
    expect(&bench.call(&["lock", "gas.toml"]), 0);
    let other = fs::read(bench.path("kinetoscope.lock")).unwrap();
    // The checks of another manifest: the messages are the same.
    *file(&mut files, "kinetoscope.lock") = other;
    expect(&reproduce(&bench, &files), 4);
}

/// Finished runs in the folder of the rerun would be compared in place of the rerun. Control: the same bundle without them has the messages
/// of another run, and is refused for that reason.
#[test]
fn finished_runs_in_the_folder_of_the_rerun_are_refused() {
    let other = Bench::new();
    other.write("gas.toml", &GAS.replace("seed = 1", "seed = 2"));
    let mut files = original(&other);
    edit(&mut files, "gas.toml", "seed = 2", "seed = 1");
    let control = reproduce(&other, &files);
    expect(&control, 4);
    let prepared: Files = files
        .iter()
        .filter(|(name, _)| name.starts_with("recordings/"))
        .map(|(name, bytes)| (name.replace("recordings/", "rerun/"), bytes.clone()))
        .collect();
    files.extend(prepared);
    let called = reproduce(&other, &files);
    expect(&called, 5);
    assert!(!called.out.contains("is reproduced"), "{}", called.out);
    assert!(called.err.contains("it contains \"rerun\""), "{}", called.err);
}

const BED: &str = "seed = 1\n[model.dem]\nduration_s = 0.002\n[record]\nframes = 2\n";

/// A manifest that starts from another one, which starts from a recording.
#[test]
fn bundle_contains_what_its_experiment_starts_from() {
    let bench = Bench::new();
    fs::create_dir(bench.path("beds")).unwrap();
    let start = |name: &str| {
        format!(
            "seed = 2\n[model.dem]\nstart_from = \"{name}\"\nduration_s = 0.002\n[record]\nframes = 2\n"
        )
    };
    bench.write("first.toml", BED);
    expect(&bench.call(&["run", "--quiet", "first.toml"]), 0);
    fs::copy(&recordings(&bench.path("recordings/first"))[0], bench.path("beds/first.mcap"))
        .unwrap();
    bench.write("beds/bed.toml", &start("./first.mcap"));
    bench.write("last.toml", &start("beds/bed.toml"));
    let bundled = |name: &str| {
        let arguments: Vec<&str> = ["bundle", name].iter().chain(&BY).copied().collect();
        bench.call(&arguments)
    };
    expect(&bundled("last.toml"), 0);
    let files = contents(&fs::read(bench.path("last.zip")).unwrap());
    for expected in ["beds/bed.toml", "beds/first.mcap"] {
        assert!(files.iter().any(|(name, _)| name == expected), "{expected}");
    }
    let elsewhere = Bench::new();
    fs::copy(bench.path("last.zip"), elsewhere.path("last.zip")).unwrap();
    let called = elsewhere.call(&["reproduce", "last.zip"]);
    expect(&called, 0);
    let taken = "The runs start from beds/first.mcap, which was not repeated";
    assert!(called.out.contains(taken), "{}", called.out);
    // Without it, the bundle is incomplete, and nothing is run.
    let incomplete: Files =
        files.iter().filter(|(name, _)| name != "beds/first.mcap").cloned().collect();
    let called = reproduce(&elsewhere, &incomplete);
    expect(&called, 5);
    assert!(called.err.contains("starts from beds/first.mcap"), "{}", called.err);
    // A file elsewhere is neither bundled, nor read by a bundle.
    let outside = bench.path("beds/first.mcap");
    for name in ["../first.mcap", outside.to_str().unwrap(), "first.txt"] {
        bench.write("last.toml", &start(name));
        let called = bundled("last.toml");
        expect(&called, 2);
        assert!(called.err.contains("below the folder of the manifest"), "{}", called.err);
        let mut hostile = files.clone();
        *file(&mut hostile, "last.toml") = start(name).into_bytes();
        let called = reproduce(&elsewhere, &hostile);
        assert!(called.err.contains("below the folder of the manifest"), "{}", called.err);
    }
}

/// A ZIP file of 70,000 empty files, and one of 3 GB in 3 MB. Control: 60,000 files are only a bundle without a list.
#[test]
fn bundles_of_many_files_or_bytes_are_refused_at_once() {
    let bench = Bench::new();
    let refused = |count: usize, bytes: usize, part: &str| {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for number in 0..count {
            zip.start_file(format!("{number}"), SimpleFileOptions::default()).unwrap();
            zip.write_all(&vec![0; bytes]).unwrap();
        }
        fs::write(bench.path("large.zip"), zip.finish().unwrap().into_inner()).unwrap();
        let called = bench.call(&["reproduce", "large.zip", "--into", "unpacked"]);
        expect(&called, 5);
        assert!(called.err.contains(part), "{}", called.err);
        assert!(!bench.path("unpacked").exists());
    };
    refused(70_000, 0, "more than 65535 files");
    refused(60_000, 0, "it has no SHA256SUMS");
    refused(3, 40_000_000, "times as large as the file");
}

#[test]
fn page_of_a_bundle_without_an_engine_is_not_named() {
    let bench = analyzed();
    expect(&bundle(&bench, &[]), 0);
    let called = bench.call(&["reproduce", "gas.zip", "--in-browser", "--into", "kept"]);
    let is_built_with_engine = cfg!(feature = "engine");
    expect(&called, if is_built_with_engine { 0 } else { 2 });
    assert!(is_built_with_engine || called.err.contains("has no engine"), "{}", called.err);
}

/// The engine of another program is accepted, and named: no rerun can tell what a page does.
#[test]
fn engine_of_another_program_is_named() {
    let bench = analyzed();
    let mut files = original(&bench);
    let module = "self.kinetoscopeEngine=\"AAAA\";";
    edit(&mut files, "report.html", "</body>", &format!("<script>{module}</script></body>"));
    // A page that only has the module is not that of an analysis with this engine.
    expect(&reproduce(&bench, &files), 4);
    fs::write(bench.path("forged.zip"), forged(&files)).unwrap();
    let called = bench.call(&["reproduce", "forged.zip", "--in-browser", "--into", "page"]);
    expect(&called, 0);
    assert!(called.out.contains("page/recordings/gas/report.html"), "{}", called.out);
}

/// A wheel with this program gives its hash and its list of packages. Control: a wheel with another program.
#[test]
fn wheel_of_the_program_is_stated_if_it_contains_it() {
    let bench = analyzed();
    let wheel = |name: &str, program: &[u8]| {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for (file, bytes) in [
            ("kinetoscope-1.data/scripts/kinetoscope", program),
            ("kinetoscope-1.dist-info/sboms/kinetoscope.cdx.json", b"{}\n".as_slice()),
        ] {
            zip.start_file(file, SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes).unwrap();
        }
        fs::write(bench.path(name), zip.finish().unwrap().into_inner()).unwrap();
    };
    wheel("own.whl", &fs::read(env!("CARGO_BIN_EXE_kinetoscope")).unwrap());
    wheel("other.whl", b"another");
    expect(&bundle(&bench, &["--wheel", "own.whl"]), 0);
    let mut files = contents(&fs::read(bench.path("gas.zip")).unwrap());
    assert_eq!(file(&mut files, "kinetoscope.cdx.json").as_slice(), b"{}\n");
    let about: serde_json::Value = serde_json::from_slice(file(&mut files, "bundle.json")).unwrap();
    assert_eq!(about["program"]["wheel"]["name"], "own.whl");
    assert_eq!(about["program"]["wheel"]["sha256"].as_str().unwrap().len(), 64);
    expect(&bench.call(&["reproduce", "gas.zip"]), 0);
    let other = bundle(&bench, &["--wheel", "other.whl"]);
    expect(&other, 2);
    assert!(other.err.contains("does not contain this program"), "{}", other.err);
    expect(&bundle(&bench, &["--wheel", "gas.toml"]), 2);
    expect(&bundle(&bench, &["--wheel", "none.whl"]), 2);
}

#[test]
#[ignore = "needs root and setpriv, to become another user"]
fn another_user_reproduces_a_bundle_in_another_folder() {
    let bench = analyzed();
    expect(&bundle(&bench, &["--recordings"]), 0);
    let place = Bench::new();
    let program = place.path("kinetoscope");
    // Another process copies it, because a child that another test starts at the same time would keep the open file busy.
    let copied = Command::new("cp").arg(env!("CARGO_BIN_EXE_kinetoscope")).arg(&program).status();
    assert!(copied.unwrap().success());
    fs::copy(bench.path("gas.zip"), place.path("gas.zip")).unwrap();
    open_to_all(&place.path(""));
    let called: Called = Command::new("setpriv")
        .args(["--reuid=65534", "--regid=65534", "--clear-groups", "env", "-i"])
        .arg(format!("TMPDIR={}", place.path("").display()))
        .arg(&program)
        .args(["reproduce", "gas.zip"])
        .current_dir(place.path(""))
        .output()
        .unwrap()
        .into();
    expect(&called, 0);
    assert!(called.out.contains("gas.zip is reproduced"), "{}", called.out);
}

#[cfg(unix)]
fn open_to_all(path: &Path) {
    use std::os::unix::fs::PermissionsExt as _;
    fs::set_permissions(path, fs::Permissions::from_mode(0o777)).unwrap();
}

#[cfg(not(unix))]
fn open_to_all(_: &Path) {}

//! Guarantee: a bundle has the same bytes for the same results, and reproduces them in another folder; one that is not what was written
//! is refused before anything is written.

use crate::subcommand_bench::{Bench, Called};
use data_encoding::HEXLOWER;
use sha2::{Digest as _, Sha256};
use std::fs;
use std::io::{Cursor, Read as _, Write as _};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

/// A short experiment with a sweep, an answer and a check.
pub(crate) const GAS: &str = "name = \"gas\"\nquestion = \"Is the energy constant?\"\nanswer = \"Its drift is {energy.drift_relative @ temperature_k = 300}.\"\nseed = 1\n\
    [model.gas]\nparticles = 20\nduration_s = 0.001\n[record]\nframes = 4\n[sweep.model.gas]\ntemperature_k = [200, 300]\n\
    [[checks]]\nmetric = \"energy.drift_relative\"\nexpected = 0.0\ntolerance = 1e-9\n";

pub(crate) const BY: [&str; 6] = [
    "--author",
    "A. Author <https://orcid.org/0000-0002-1825-0097>",
    "--affiliation",
    "The Institute <https://institute.example>",
    "--license",
    "CC-BY-4.0",
];

pub(crate) fn expect(called: &Called, code: i32) {
    assert_eq!(called.code, Some(code), "{}{}", called.out, called.err);
}

/// A folder with a recorded and analyzed experiment.
pub(crate) fn analyzed() -> Bench {
    let bench = Bench::new();
    bench.write("gas.toml", GAS);
    expect(&bench.call(&["run", "--quiet", "gas.toml"]), 0);
    expect(&bench.call(&["analyze", "--quiet", "recordings/gas"]), 0);
    bench
}

pub(crate) fn bundle(bench: &Bench, further: &[&str]) -> Called {
    let arguments: Vec<&str> =
        ["bundle", "gas.toml"].iter().chain(&BY).chain(further).copied().collect();
    bench.call(&arguments)
}

/// The files of a bundle by name.
pub(crate) fn contents(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut zip = ZipArchive::new(Cursor::new(bytes)).unwrap();
    let entries = (0..zip.len()).map(|index| {
        let mut entry = zip.by_index(index).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        (entry.name().unwrap().into_owned(), bytes)
    });
    entries.collect()
}

/// The bytes of a ZIP file with these files.
pub(crate) fn packed(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn bundle_has_the_same_bytes_and_reproduces_in_another_folder() {
    let bench = analyzed();
    let called = bundle(&bench, &[]);
    expect(&called, 0);
    assert!(called.out.contains("kinetoscope reproduce gas.zip"), "{}", called.out);
    let first = fs::read(bench.path("gas.zip")).unwrap();
    expect(&bundle(&bench, &["--file", "other.zip"]), 0);
    assert!(first == fs::read(bench.path("other.zip")).unwrap(), "two bundles differ");
    // The bar of a bundle without recordings is 2 MB.
    assert!(first.len() < 2_000_000, "{} bytes", first.len());
    let names: Vec<String> = contents(&first).into_iter().map(|(name, _)| name).collect();
    for expected in [
        "gas.toml",
        "kinetoscope.lock",
        "bundle.json",
        "SHA256SUMS",
        "CITATION.cff",
        "codemeta.json",
        ".zenodo.json",
        "ro-crate-metadata.json",
        "recordings/gas/metrics.json",
        "recordings/gas/report.html",
    ] {
        assert!(names.iter().any(|name| name == expected), "{expected} is not in {names:?}");
    }
    // A recommendation of RO-Crate 1.1 that its validator checks: every file has a format.
    let crate_json = contents(&first)
        .into_iter()
        .find_map(|(name, bytes)| (name == "ro-crate-metadata.json").then_some(bytes));
    let described: serde_json::Value = serde_json::from_slice(&crate_json.unwrap()).unwrap();
    let entities = described["@graph"].as_array().unwrap();
    let is_file = |entity: &&serde_json::Value| entity["@type"] == "File";
    for entity in entities.iter().filter(is_file) {
        assert!(entity["encodingFormat"].is_array(), "no format: {entity}");
    }
    // The descriptions, the list of hashes and the results: each is described or describes.
    assert_eq!(entities.iter().filter(is_file).count() + 5, names.len(), "{names:?}");
    assert!(
        !names.iter().any(|name| name.ends_with(".mcap") || name.contains("host.json")),
        "{names:?}"
    );
    let elsewhere = Bench::new();
    fs::copy(bench.path("gas.zip"), elsewhere.path("given.zip")).unwrap();
    let called = elsewhere.call(&["reproduce", "given.zip"]);
    expect(&called, 0);
    for part in ["Is the energy constant?", "gas.toml: 2 runs equal", "given.zip is reproduced"] {
        assert!(called.out.contains(part), "{part} is not in {}", called.out);
    }
    expect(&elsewhere.call(&["reproduce", "given.zip", "--into", "kept"]), 0);
    assert!(elsewhere.path("kept/recordings/gas/report.html").exists());
}

/// The bytes of a bundle with these files, as one who knows its layout would forge it.
pub(crate) fn forged(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let hash = |bytes: &[u8]| HEXLOWER.encode(&Sha256::digest(bytes));
    let mut files: Vec<_> =
        files.iter().filter(|(name, _)| name != "SHA256SUMS").cloned().collect();
    let sums: String =
        files.iter().map(|(name, bytes)| format!("{}  {name}\n", hash(bytes))).collect();
    files.push(("SHA256SUMS".to_owned(), sums.into_bytes()));
    sealed(packed(&files))
}

/// A ZIP file without a comment, with the seal of a bundle.
pub(crate) fn sealed(mut zip: Vec<u8>) -> Vec<u8> {
    // The length of the comment is the last field of the file.
    let length = zip.len() - 2;
    zip[length] = 64;
    let seal = HEXLOWER.encode(&Sha256::digest(&zip));
    zip.extend_from_slice(seal.as_bytes());
    zip
}

/// An honest bundle of a program that gave other messages. Control: the same bundle with the messages of this program.
#[test]
fn first_difference_of_other_results_is_named() {
    let bench = analyzed();
    expect(&bundle(&bench, &["--recordings"]), 0);
    let mut files = contents(&fs::read(bench.path("gas.zip")).unwrap());
    assert_eq!(files.iter().filter(|(name, _)| name.ends_with(".mcap")).count(), 2);
    fs::write(bench.path("forged.zip"), forged(&files)).unwrap();
    expect(&bench.call(&["reproduce", "forged.zip"]), 0);
    let other = Bench::new();
    other.write("gas.toml", &GAS.replace("seed = 1", "seed = 2"));
    expect(&other.call(&["lock", "--quiet", "gas.toml"]), 0);
    let line = |text: &str, start: &str| {
        text.lines().find(|line| line.starts_with(start)).unwrap().to_owned()
    };
    let foreign = fs::read_to_string(other.path("kinetoscope.lock")).unwrap();
    let (_, lock) = files.iter_mut().find(|(name, _)| name == "kinetoscope.lock").unwrap();
    let mut text = String::from_utf8(lock.clone()).unwrap();
    for start in ["messages = ", "groups = ", "tags = "] {
        text = text.replace(&line(&text, start), &line(&foreign, start));
    }
    *lock = text.into_bytes();
    fs::write(bench.path("forged.zip"), forged(&files)).unwrap();
    let called = bench.call(&["reproduce", "forged.zip"]);
    expect(&called, 4);
    assert!(called.out.contains("first difference in frame 0"), "{}", called.out);
    assert!(!called.out.contains("is reproduced"), "{}", called.out);
    assert!(called.err.contains("the runs are not those of forged.zip"), "{}", called.err);
    assert!(!called.err.contains("kinetoscope lock"), "{}", called.err);
}

#[test]
fn bundle_of_a_newer_program_is_named() {
    let bench = analyzed();
    expect(&bundle(&bench, &[]), 0);
    let mut files = contents(&fs::read(bench.path("gas.zip")).unwrap());
    let (_, text) = files.iter_mut().find(|(name, _)| name == "bundle.json").unwrap();
    *text = String::from_utf8(text.clone())
        .unwrap()
        .replace("\"bundle\": 2", "\"bundle\": 3")
        .into_bytes();
    fs::write(bench.path("newer.zip"), forged(&files)).unwrap();
    let called = bench.call(&["reproduce", "newer.zip"]);
    expect(&called, 4);
    assert!(called.err.contains("version 3 of the layout"), "{}", called.err);
}

#[test]
fn changed_added_missing_and_renamed_files_are_named() {
    let bench = analyzed();
    expect(&bundle(&bench, &[]), 0);
    let original = contents(&fs::read(bench.path("gas.zip")).unwrap());
    let at = |name: &str| original.iter().position(|(other, _)| other == name).unwrap();
    let refused = |files: &[(String, Vec<u8>)], part: &str| {
        fs::write(bench.path("changed.zip"), packed(files)).unwrap();
        let called = bench.call(&["reproduce", "changed.zip", "--into", "unpacked"]);
        expect(&called, 5);
        assert!(called.err.contains(part), "{part} is not in {}", called.err);
        assert!(!bench.path("unpacked").exists(), "{part}: something was written");
    };
    let mut changed = original.clone();
    changed[at("gas.toml")].1.push(b'\n');
    refused(&changed, "gas.toml was changed");
    let mut added = original.clone();
    added.push(("run-me.sh".to_owned(), b"#!/bin/sh\n".to_vec()));
    refused(&added, "run-me.sh was added");
    let mut missing = original.clone();
    missing.remove(at("recordings/gas/metrics.json"));
    refused(&missing, "recordings/gas/metrics.json is missing");
    for name in [
        "con.txt",
        "a/LPT1",
        "../gas.toml",
        "/tmp/gas.toml",
        "a/../../gas.toml",
        "C:\\gas.toml",
        "a//b",
        "nul\u{1b}",
        "x.",
    ] {
        let mut escaping = original.clone();
        escaping.push((name.to_owned(), Vec::new()));
        refused(&escaping, "is not a file below its own folder");
    }
    let mut below = original.clone();
    below.push(("gas.toml/inside".to_owned(), Vec::new()));
    refused(&below, "is a file");
    let mut twice = original.clone();
    twice.push(("GAS.toml".to_owned(), Vec::new()));
    refused(&twice, "differ only in case");
    // Control: packed again without a change, all files are those that were written.
    refused(&original, "it was packed again");
    let mut bomb = original.clone();
    bomb.push(("zeros".to_owned(), vec![0; 200_000_000]));
    refused(&bomb, "times as large as the file");
    fs::write(bench.path("changed.zip"), "text").unwrap();
    expect(&bench.call(&["reproduce", "changed.zip"]), 5);
    expect(&bench.call(&["reproduce", "none.zip"]), 2);
}

/// A symbolic link in a bundle is refused.
#[test]
fn link_in_a_bundle_is_refused() {
    let bench = analyzed();
    expect(&bundle(&bench, &[]), 0);
    let mut zip =
        ZipWriter::new_append(Cursor::new(fs::read(bench.path("gas.zip")).unwrap())).unwrap();
    zip.add_symlink("link", "/etc/passwd", SimpleFileOptions::default()).unwrap();
    fs::write(bench.path("link.zip"), zip.finish().unwrap().into_inner()).unwrap();
    let called = bench.call(&["reproduce", "link.zip"]);
    expect(&called, 5);
    assert!(called.err.contains("\"link\", which is not a file"), "{}", called.err);
}

/// Every bundle with a flipped bit, a cut or an addition is refused.
#[test]
fn five_hundred_damaged_bundles_are_refused() {
    let bench = analyzed();
    expect(&bundle(&bench, &[]), 0);
    let original = fs::read(bench.path("gas.zip")).unwrap();
    let mut state = 1_u64;
    let mut next = |below: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(state >> 33).unwrap() % below
    };
    for number in 0..500 {
        let mut bytes = original.clone();
        let place = match number % 4 {
            // The directory at the end of the file is a small part of it.
            0 | 1 => original.len() - 1 - next(4_000.min(original.len())),
            _ => next(original.len()),
        };
        match number % 10 {
            9 => bytes.truncate(place),
            8 => bytes.insert(place, 0),
            _ => bytes[place] ^= 1 << next(8),
        }
        fs::write(bench.path("damaged.zip"), &bytes).unwrap();
        let called = bench.call(&["reproduce", "damaged.zip", "--into", "unpacked"]);
        assert_eq!(called.code, Some(5), "{number} at {place}: {}{}", called.out, called.err);
        assert!(called.err.contains("\nhelp: "), "{}", called.err);
        assert!(!bench.path("unpacked").exists(), "{number} at {place}");
    }
}

/// Control: the same forged bundle without a change reproduces, see above.
#[test]
fn results_that_are_not_those_of_the_rerun_are_found() {
    let bench = analyzed();
    expect(&bundle(&bench, &[]), 0);
    let original = contents(&fs::read(bench.path("gas.zip")).unwrap());
    let edited = |name: &str, from: &str, to: &str, code: i32, part: &str| {
        let mut files = original.clone();
        let (_, bytes) = files.iter_mut().find(|(other, _)| other == name).unwrap();
        let text = String::from_utf8(bytes.clone()).unwrap();
        assert!(text.contains(from), "{from}: {text}");
        *bytes = text.replacen(from, to, 1).into_bytes();
        fs::write(bench.path("edited.zip"), forged(&files)).unwrap();
        let called = bench.call(&["reproduce", "edited.zip"]);
        expect(&called, code);
        assert!(called.err.contains(part), "{part}: {}", called.err);
        assert!(!called.out.contains("is reproduced"), "{}", called.out);
    };
    edited("bundle.json", "Its drift is", "Its rise is", 4, "that of the rerun: answer");
    edited("recordings/gas/metrics.json", "\"value\":", "\"value\": 1", 4, "metrics.json");
    edited("recordings/gas/report.html", "</body>", "<p>more</p></body>", 4, "report.html");
    edited(
        "bundle.json",
        "\"experiment\": \"gas\"",
        "\"experiment\": \"other\"",
        5,
        "different experiments",
    );
    edited("bundle.json", "\"runs\": [", "\"runs\": [\n    \"0\",", 5, "different experiments");
}

/// What the user edits between run and bundle is not bundled: neither a changed number nor files that are not results.
#[test]
fn bundle_has_the_results_of_its_recordings_and_manifest() {
    let bench = Bench::new();
    bench.write("gas.toml", GAS);
    expect(&bundle(&bench, &[]), 0);
    let first = fs::read(bench.path("gas.zip")).unwrap();
    let metrics = fs::read_to_string(bench.path("recordings/gas/metrics.json")).unwrap();
    bench.write("recordings/gas/metrics.json", &metrics.replace("\"value\":", "\"value\": 1"));
    bench.write("recordings/gas/private.json", "{}");
    bench.write("recordings/gas/old.svg", "<svg/>");
    let manifest = bench.path("gas.toml");
    let arguments: Vec<&str> =
        ["bundle", manifest.to_str().unwrap()].into_iter().chain(BY).collect();
    expect(&bench.call(&arguments), 0);
    assert!(first == fs::read(bench.path("gas.zip")).unwrap(), "the bundles differ");
    bench.write("gas.toml", &GAS.replace("Is the energy constant?", "Is it so?"));
    expect(&bundle(&bench, &[]), 0);
    expect(&bench.call(&["reproduce", "gas.zip"]), 0);
    let called = bench.call(&["bundle", "gas.toml", "--author", "A <x>", "--license", "CC0-1.0"]);
    expect(&called, 2);
    for license in ["my own", "NOPE", ""] {
        let called = bench.call(&["bundle", "gas.toml", "--author", "A", "--license", license]);
        expect(&called, 2);
        assert!(called.err.contains("SPDX"), "{license}: {}", called.err);
    }
}

/// Runs of which only the metrics are kept: the bundle contains their rows, and the hash of their messages is that of the rows.
/// Control: the same runs with their recordings have the same hashes.
#[test]
fn bundle_of_rows_reproduces_without_recordings() {
    let bench = Bench::new();
    let hashes = |bench: &Bench| {
        let lock = fs::read_to_string(bench.path("kinetoscope.lock")).unwrap();
        let line =
            |start: &str| lock.lines().find(|line| line.starts_with(start)).unwrap().to_owned();
        ["messages = ", "groups = ", "tags = "].map(line)
    };
    bench.write("gas.toml", GAS);
    expect(&bench.call(&["lock", "gas.toml"]), 0);
    let recorded = hashes(&bench);
    bench.write("gas.toml", &GAS.replace("frames = 4\n", "frames = 4\nkeep = \"metrics\"\n"));
    expect(&bench.call(&["lock", "gas.toml"]), 0);
    assert_eq!(hashes(&bench), recorded);
    expect(&bench.call(&["check", "--locked", "gas.toml"]), 0);
    expect(&bundle(&bench, &["--recordings"]), 0);
    expect(&bundle(&bench, &["--file", "again.zip"]), 0);
    let bytes = fs::read(bench.path("gas.zip")).unwrap();
    assert!(bytes == fs::read(bench.path("again.zip")).unwrap(), "two bundles differ");
    let names: Vec<String> = contents(&bytes).into_iter().map(|(name, _)| name).collect();
    assert!(names.iter().any(|name| name == "recordings/gas/runs.parquet"), "{names:?}");
    assert!(!names.iter().any(|name| name.ends_with(".mcap")), "{names:?}");
    let elsewhere = Bench::new();
    fs::copy(bench.path("gas.zip"), elsewhere.path("gas.zip")).unwrap();
    expect(&elsewhere.call(&["reproduce", "gas.zip"]), 0);
}

//! Promise: an attestation is written by a successful `kinetoscope verify` alone, names nothing of the host but its kind, and holds for the
//! bytes that were verified and no others.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

mod forged_recording;

use forged_recording::{Forgery, kinetoscope, record, stderr, stdout};
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Output;

const ORBIT: &str = "[model.orbit]\nduration_days = 100.0\n[record]\nframes = 20\n";

const ATTESTATION: &[&str] = &["verify", "--check-attestation"];

fn call(what: &[&str], recording: &Path) -> Output {
    let mut arguments: Vec<&OsStr> = what.iter().map(AsRef::as_ref).collect();
    arguments.push(recording.as_os_str());
    kinetoscope(arguments)
}

#[test]
fn it_holds_until_the_file_changes() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "orbit", ORBIT);
    let before = call(ATTESTATION, &recording);
    assert_eq!(before.status.code(), Some(5), "nobody has verified it");
    assert!(stderr(&before).contains("kinetoscope verify"), "{}", stderr(&before));

    assert_eq!(call(&["verify"], &recording).status.code(), Some(0));
    let attested = call(ATTESTATION, &recording);
    assert_eq!(attested.status.code(), Some(0), "{}", stderr(&attested));
    assert!(stdout(&attested).contains("equal in every byte"));

    let bytes = fs::read(&recording).unwrap();
    let mut flipped = bytes.clone();
    flipped[bytes.len() / 2] ^= 1;
    fs::write(&recording, &flipped).unwrap();
    let changed = call(ATTESTATION, &recording);
    assert_eq!(changed.status.code(), Some(4));
    assert!(stderr(&changed).contains("the SHA-256 differs"), "{}", stderr(&changed));

    fs::write(&recording, &bytes[..bytes.len() - 1]).unwrap();
    let shorter = call(ATTESTATION, &recording);
    assert_eq!(shorter.status.code(), Some(4));
    assert!(stderr(&shorter).contains("the size differs"), "{}", stderr(&shorter));

    fs::write(&recording, &bytes).unwrap();
    assert_eq!(call(ATTESTATION, &recording).status.code(), Some(0));
}

#[test]
fn it_says_these_things_and_no_more() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "orbit", ORBIT);
    call(&["verify"], &recording);
    let text = fs::read_to_string(recording.with_extension("verified.json")).unwrap();
    let keys: Vec<&str> = text.lines().filter_map(|line| line.split('"').nth(1)).collect();
    let expected = [
        "attestation_version",
        "sha256",
        "bytes",
        "content_key",
        "verified_by_program_version",
        "verified_by_physics_version",
        "verdict",
        "operating_system",
        "architecture",
    ];
    assert_eq!(keys, expected);
    assert!(!text.contains(&folder.path().display().to_string()));
}

#[test]
fn a_verdict_on_messages_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "orbit", ORBIT);
    let other = folder.path().join("other.mcap");
    Forgery::default().write(&recording, &other);
    call(&["verify"], &other);
    let attested = call(ATTESTATION, &other);
    assert_eq!(attested.status.code(), Some(0), "{}", stderr(&attested));
    assert!(stdout(&attested).contains("equal in every message"));
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_is_no_failure() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(folder.path(), "orbit", ORBIT);
    // A folder under the attestation's name refuses the file, for every user.
    fs::create_dir_all(recording.with_extension("verified.json").join("taken")).unwrap();
    let verified = call(&["verify"], &recording);
    assert_eq!(verified.status.code(), Some(0), "{}", stderr(&verified));
    let text = stdout(&verified);
    assert!(text.contains("equal in every byte"), "{text}");
    assert!(text.contains("the attestation cannot be written to "), "{text}");
}

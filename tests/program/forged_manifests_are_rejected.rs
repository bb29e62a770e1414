//! Guarantee: `verify` rejects a recording whose manifest asks for more memory than any machine has, or that has no frame, as
//! unreadable (exit code 5), before the start of its run is built.
//!
//! Setup: a recording rewritten with one change and correct checksums.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::forged_recording::{Forgery, kinetoscope, record, stderr};

const GAS: &str =
    "seed = 1\n[model.gas]\nparticles = 20\nduration_s = 0.001\n[record]\nframes = 4\n";

#[test]
fn verification_compares_the_memory_of_the_rerun_with_that_of_the_machine() {
    let folder = tempfile::tempdir().unwrap();
    let original = record(folder.path(), "gas", GAS);
    let forged = folder.path().join("forged.mcap");
    let change = |text: &str| text.replace("particles = 20\n", "particles = 4294967295\n");
    Forgery { manifest: Some(&change), ..Forgery::default() }.write(&original, &forged);
    let verified = kinetoscope(["verify".as_ref(), forged.as_os_str()]);
    assert_eq!(verified.status.code(), Some(5), "{}", stderr(&verified));
    assert!(stderr(&verified).contains("GB of memory"), "{}", stderr(&verified));
}

#[test]
fn recording_without_a_frame_is_unreadable() {
    let folder = tempfile::tempdir().unwrap();
    let original = record(folder.path(), "gas", GAS);
    let forged = folder.path().join("forged.mcap");
    let omit = |_: &str, _: u64, _: &mut Vec<u8>| false;
    Forgery { message: Some(&omit), ..Forgery::default() }.write(&original, &forged);
    let verified = kinetoscope(["verify".as_ref(), forged.as_os_str()]);
    assert_eq!(verified.status.code(), Some(5), "{}", stderr(&verified));
    assert!(stderr(&verified).contains("it has no frame"), "{}", stderr(&verified));
}

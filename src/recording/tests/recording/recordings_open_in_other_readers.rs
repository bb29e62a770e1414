//! Guarantee: other MCAP programs can read a recording.
//!
//! Setup: the PyPI packages `mcap` (all checksums) and `mcap-protobuf-support` (every message, by the schemas in the file), and Rerun's
//! `mcap check`.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::sample::{header, record, record_with_outcome};
use kinetoscope_recording::recorder::{Compression, Outcome};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Recordings with every compression, with one chunk and with several, and with every outcome.
fn recordings(folder: &Path) -> Vec<PathBuf> {
    let mut paths = Vec::new();
    let mut put = |name: &str, bytes: Vec<u8>| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        paths.push(path);
    };
    put("zstd.mcap", record(&header(Compression::Zstd), 60, 500));
    put("zstd_3.mcap", record(&header(Compression::Zstd3), 60, 500));
    put("lz4.mcap", record(&header(Compression::Lz4), 60, 500));
    put("none.mcap", record(&header(Compression::None), 60, 500));
    put("one_frame.mcap", record(&header(Compression::Zstd), 1, 1));
    let fault = Outcome::Fault("a disc left the box".to_owned());
    let stopped = record_with_outcome(&header(Compression::Zstd), 2, 2, &fault).unwrap();
    put("fault.mcap", stopped);
    paths
}

fn run(command: &mut Command) {
    let output = command.output().unwrap();
    let text =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    assert!(output.status.success(), "{command:?}\n{}\n{}", text[0], text[1]);
    print!("{}", text[0]);
}

#[test]
#[ignore = "needs Python with tests/interop/requirements.txt; KINETOSCOPE_PYTHON names the interpreter"]
fn python_validates_and_decodes_every_message() {
    let folder = tempfile::tempdir().unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/interop/check_recording.py");
    let python = std::env::var_os("KINETOSCOPE_PYTHON").unwrap_or("python3".into());
    run(Command::new(&python).arg(script).args(recordings(folder.path())));
}

#[test]
#[ignore = "needs the rerun program of PyPI's rerun-sdk; KINETOSCOPE_RERUN names it"]
fn rerun_checks_the_container() {
    let folder = tempfile::tempdir().unwrap();
    let rerun = std::env::var_os("KINETOSCOPE_RERUN").unwrap_or("rerun".into());
    for path in recordings(folder.path()) {
        run(Command::new(&rerun).args(["mcap", "check"]).arg(path));
    }
}

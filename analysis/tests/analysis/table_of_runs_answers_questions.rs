//! Guarantee: `runs.parquet` has one row per run with its metrics, and `kinetoscope table` returns its rows, and means that equal those of
//! `metrics.json` to the last digit. Equal recordings give equal bytes. A condition that does not parse is shown with carets.
//!
//! Setup: a gas at two temperatures and two kinds of propagation with three replicates each; the pressure depends on all of them.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::synthetic::{Folder, Frames, analyze, two_frames};
use kinetoscope_analysis::stored_rows;
use kinetoscope_manifest::RunManifest;
use kinetoscope_manifest::model::{ModelConfig, SpeedScale};
use kinetoscope_recording::channels::GasPressure;
use serde_json::{Value, json};
use std::fs::{self, OpenOptions};
use std::io::{Seek as _, SeekFrom, Write as _};
use std::process::Command;

const MANIFEST: &str = "name = \"gas\"\nreplicates = 3\nseed = 7\n[model.gas]\nparticles = 1\nduration_s = 1.0\n\
    [record]\nframes = 1\nchannels = [\"pressure\"]\n[sweep]\n\"model.gas.temperature_k\" = [100.5, 300.0]\n\
    \"model.gas.speed_distribution\" = [\"maxwell\", \"equal\"]\n";

fn frames(run: &RunManifest) -> Frames {
    let ModelConfig::Gas(gas) = &*run.model else { panic!("a gas") };
    let SpeedScale::Temperature(kelvin) = gas.speed_scale else { panic!("a temperature") };
    two_frames(&GasPressure {
        ideal_gas_n_per_m: kelvin.get() / 3.0 + f64::from(run.replicate * run.replicate),
        ..GasPressure::default()
    })
}

/// Exit code, standard output, and errors of `kinetoscope table`.
fn table(folder: &Folder, arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_kinetoscope"))
        .args([&["table", folder.name()], arguments].concat())
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

fn answered(folder: &Folder, arguments: &[&str]) -> Value {
    let (code, text, errors) = table(folder, &[arguments, &["--format", "json"]].concat());
    assert_eq!(code, 0, "{errors}");
    serde_json::from_str(&text).unwrap()
}

#[test]
fn rows_and_means_of_the_table_equal_the_metrics() {
    let folder = Folder::write(MANIFEST, frames);
    let metrics = folder.metrics();
    let columns = "temperature_k,speed_distribution,replicate,seed,outcome,pressure.ideal_gas";
    let rows = answered(&folder, &["--columns", columns]);
    let rows = rows.as_array().unwrap();
    assert_eq!(rows.len(), 12);
    let of_runs =
        metrics.all("pressure.ideal_gas").into_iter().filter(|it| it.get("run").is_some());
    for (row, metric) in rows.iter().zip(of_runs) {
        let place = &metric["run"]["coordinates"];
        let expected = json!({
            "temperature_k": place["temperature_k"]["value"].as_f64(),
            "speed_distribution": place["speed_distribution"]["value"],
            "replicate": metric["run"]["replicate"],
            "seed": 7,
            "outcome": "complete",
            "pressure.ideal_gas": metric["value"],
        });
        assert_eq!(*row, expected);
    }
    let keys = ["--group", "temperature_k,speed_distribution", "--columns", "pressure.ideal_gas"];
    let groups = answered(&folder, &keys);
    let means =
        metrics.all("pressure.ideal_gas").into_iter().filter(|it| it.get("sweep").is_some());
    let mut compared = 0;
    for (group, mean) in groups.as_array().unwrap().iter().zip(means) {
        assert_eq!(group["pressure.ideal_gas"], mean["value"]);
        assert_eq!(group["pressure.ideal_gas.standard_error"], mean["standard_error"]);
        assert_eq!(group["runs"], 3);
        compared += 1;
    }
    assert_eq!(compared, 4);
    // All six runs of a temperature: the mean of T/3 + (0 + 1 + 4)/3, and the error of 0, 1, 4, 0, 1, 4, by the definition.
    let warm = answered(
        &folder,
        &[
            "--group",
            "temperature_k",
            "--where",
            "temperature_k>200",
            "--columns",
            "pressure.ideal_gas",
        ],
    );
    let error = (13.0_f64 / 3.0 * 2.0 / 5.0 / 6.0 * 2.0).sqrt();
    assert_eq!(warm.as_array().unwrap().len(), 1);
    assert_eq!(warm[0]["runs"], 6);
    assert!((warm[0]["pressure.ideal_gas"].as_f64().unwrap() - (100.0 + 5.0 / 3.0)).abs() < 1e-12);
    let found = warm[0]["pressure.ideal_gas.standard_error"].as_f64().unwrap();
    assert!((found - error).abs() < 1e-12, "{found}, not {error}");
    // The hash of all messages is that of a lock file: 32 digits, another one for each run that differs.
    let hashes = answered(&folder, &["--columns", "messages", "--where", "replicate=1"]);
    let mut hashes: Vec<&str> =
        hashes.as_array().unwrap().iter().map(|row| row["messages"].as_str().unwrap()).collect();
    hashes.dedup();
    assert!(hashes.iter().all(|hash| hash.len() == 32) && hashes.len() == 2, "{hashes:?}");
}

#[test]
fn table_has_the_same_bytes_from_recordings_and_from_the_cache() {
    let folder = Folder::write(MANIFEST, frames);
    let written = || fs::read(folder.path().join("runs.parquet")).unwrap();
    folder.metrics();
    let first = written();
    folder.metrics();
    assert!(first == written(), "from the cache");
    analyze(&["--no-cache", folder.name()]).exited_with(0);
    assert!(first == written(), "from the recordings");
    // A table of a table can be asked again.
    let part = folder.path().join("part.parquet");
    let part = part.to_str().unwrap();
    let written = table(&folder, &["--where", "replicate=2", "--format", "parquet", "-o", part]);
    assert_eq!(written.0, 0, "{}", written.2);
    let output = Command::new(env!("CARGO_BIN_EXE_kinetoscope"))
        .args(["table", part, "--columns", "replicate", "--format", "csv"])
        .output()
        .unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap(), "replicate\n2\n2\n2\n2\n");
}

#[test]
fn wrong_questions_and_damaged_tables_are_explained() {
    let folder = Folder::write(MANIFEST, frames);
    folder.metrics();
    let (code, text, _) = table(&folder, &["--where", "temperature_k<0", "--columns", "seed"]);
    assert_eq!((code, text.as_str()), (0, "seed\n0 rows\n"));
    for (arguments, expected) in [
        (["--where", "temperature_k >"], "  | temperature_k >\n  |                ^"),
        (["--where", "temprature_k = 1"], "  | temprature_k = 1\n  | ^^^^^^^^^^^^"),
        (["--columns", "pressure.idealgas"], "help: did you mean `pressure.ideal_gas`?"),
        (["--group", "replicates"], "help: did you mean `replicate`?"),
    ] {
        let (code, _, errors) = table(&folder, &arguments);
        assert_eq!(code, 2, "{errors}");
        assert!(errors.contains(expected), "{expected} in {errors}");
    }
    let path = folder.path().join("runs.parquet");
    let whole = fs::read(&path).unwrap();
    for part in [&whole[..whole.len() / 2], b"", b"PAR1PAR1"] {
        fs::write(&path, part).unwrap();
        let (code, _, errors) = table(&folder, &[]);
        assert_eq!(code, 5, "{errors}");
        assert!(errors.contains("not a whole table") && errors.contains("analyze"), "{errors}");
    }
    fs::copy(folder.path().join("metrics.parquet"), &path).unwrap();
    let (code, _, errors) = table(&folder, &[]);
    assert_eq!(code, 5);
    assert!(errors.contains("not a whole table of runs: its checksum is wrong"), "{errors}");
}

/// Guarantee: a table of which any bit has changed gives no number at all. Setup: every 7th bit, and every 7th length. Control: the
/// whole table before and after that.
#[test]
fn every_flipped_bit_of_a_table_is_found() {
    let folder = Folder::write(MANIFEST, frames);
    folder.metrics();
    let path = folder.path().join("runs.parquet");
    let whole = fs::read(&path).unwrap();
    let rows = || match stored_rows(folder.path()) {
        Ok(rows) => Some(rows.len()),
        Err(error) => {
            assert!(error.is_of_damage, "{}", error.message);
            None
        }
    };
    assert_eq!(rows(), Some(12));
    let mut file = OpenOptions::new().write(true).open(&path).unwrap();
    let mut write = |at: usize, byte: u8| {
        file.seek(SeekFrom::Start(at as u64)).unwrap();
        file.write_all(&[byte]).unwrap();
    };
    for bit in (0..8 * whole.len()).step_by(7) {
        let (at, flip) = (bit / 8, 1 << (bit % 8));
        write(at, whole[at] ^ flip);
        assert_eq!(rows(), None, "bit {bit} of {}", 8 * whole.len());
        write(at, whole[at]);
    }
    assert_eq!(rows(), Some(12));
    let file = OpenOptions::new().write(true).open(&path).unwrap();
    for length in (0..whole.len()).rev().step_by(7) {
        file.set_len(length as u64).unwrap();
        assert_eq!(rows(), None, "{length} bytes");
    }
}

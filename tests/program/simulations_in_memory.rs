//! Guarantee: `simulate` answers each line of its input with the recording and the metrics of `run` and `analyze`, or with an error, and
//! leaves no file.

use crate::kinetoscope_program::kinetoscope;
use serde_json::Value;
use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};

fn succeeded(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    text
}

/// The values of the metrics of runs, by name.
fn values(metrics: &Value) -> Vec<(String, f64)> {
    let entries = metrics["metrics"].as_array().unwrap().iter();
    let runs = entries.filter(|entry| entry["scope"] == "run" || entry["scope"].is_null());
    let value =
        |entry: &Value| Some((entry["name"].as_str()?.to_owned(), entry["value"].as_f64()?));
    runs.filter_map(value).collect()
}

#[test]
fn requests_are_answered_with_the_recording_and_its_metrics() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = "seed = 3\n[model.gas]\nparticles = 50\n[record]\nframes = 5\n";
    fs::write(folder.path().join("gas.toml"), manifest).unwrap();
    let mut simulate = kinetoscope()
        .arg("simulate")
        .current_dir(folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = simulate.stdin.take().unwrap();
    let mut output = BufReader::new(simulate.stdout.take().unwrap());
    let mut answer = |request: &[u8]| -> (Value, Vec<u8>) {
        input.write_all(&[request, b"\n"].concat()).unwrap();
        let mut line = String::new();
        output.read_line(&mut line).unwrap();
        let answer: Value = serde_json::from_str(&line).unwrap();
        let mut recording = vec![0; answer["recording_bytes"].as_u64().unwrap_or(0) as usize];
        output.read_exact(&mut recording).unwrap();
        (answer, recording)
    };
    let wrong: [&[u8]; 6] = [
        b"",
        b"[1]",
        b"{}",
        b"[\"\xff.toml\", \"recordings\"]",
        br#"["missing.toml", "recordings"]"#,
        br#"["gas.toml", "recordings", "seed=x"]"#,
    ];
    for request in wrong {
        let (rejected, recording) = answer(request);
        assert!(rejected["exit_code"] != 0 && rejected["error"].is_string(), "{rejected}");
        assert!(recording.is_empty());
    }
    let (changed, _) = answer(br#"["gas.toml", "recordings", "seed=4"]"#);
    let (found, recording) = answer(br#"["gas.toml", "recordings"]"#);
    assert_eq!(found["exit_code"], 0, "{found}");
    assert!(!folder.path().join("recordings").exists());
    let call = |words: &[&str]| succeeded(kinetoscope().args(words).current_dir(folder.path()));
    call(&["run", "--quiet", "gas.toml"]);
    fs::write(folder.path().join("simulated.mcap"), recording).unwrap();
    let recorded = fs::read_dir(folder.path().join("recordings/gas")).unwrap();
    let is_recording = |path: &Path| path.extension().is_some_and(|end| end == "mcap");
    let recorded =
        recorded.map(|entry| entry.unwrap().path()).find(|path| is_recording(path)).unwrap();
    let compared = call(&["compare", "simulated.mcap", recorded.to_str().unwrap()]);
    assert!(compared.contains("equal in every message"), "{compared}");
    call(&["analyze", "--quiet", "recordings/gas"]);
    let written = fs::read(folder.path().join("recordings/gas/metrics.json")).unwrap();
    let analyzed = values(&serde_json::from_slice(&written).unwrap());
    assert!(analyzed.len() > 5, "{analyzed:?}");
    assert_eq!(values(&found["metrics"]), analyzed);
    assert_ne!(values(&changed["metrics"]), analyzed);
    drop(input);
    assert!(simulate.wait().unwrap().success());
}

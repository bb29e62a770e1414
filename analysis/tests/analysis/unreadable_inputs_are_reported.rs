//! Guarantee: an unreadable input is named with the reason and with the part that was read; the remaining inputs are analyzed, and the exit
//! code reports the failure.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::synthetic::{Folder, Frames, analyze, flat, write_run};
use kinetoscope_manifest::{RunManifest, parse};
use kinetoscope_recording::channels::{DemContactForces, GasPressure};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::{Clock, Outcome};
use std::fs;

const MANIFEST: &str = r#"
name = "gas"
replicates = 3
[model.gas]
particles = 400
duration_s = 1.0
[record]
channels = ["state", "pressure"]
[[checks]]
metric = "pressure.measured"
minimum = 0.5
"#;

fn frames(run: &RunManifest) -> Frames {
    (0..=200_u64)
        .map(|index| {
            let time = index as f64 / 200.0;
            let mut frame = Frame::new();
            for particle in 0..400 {
                // The bits do not compress, so that the file has many chunks.
                let noise = ((index * 400 + particle) as f64 * 0.618_033_988_749_895).fract();
                frame.push_state(&[noise * 0.5, noise * noise, 1.0 - noise, 1.0 + noise]);
            }
            frame.push(&GasPressure {
                measured_since_start_n_per_m: 1.0 + f64::from(run.replicate),
                ..GasPressure::default()
            });
            (Clock { count: index, time }, frame)
        })
        .collect()
}

#[test]
fn foreign_and_empty_files_are_named_and_the_rest_is_analyzed() {
    let folder = Folder::write(MANIFEST, frames);
    fs::write(folder.file(0), b"not a recording").unwrap();
    fs::write(folder.file(1), b"").unwrap();
    let output = analyze(&[folder.name()]).exited_with(5);
    for index in [0, 1] {
        assert!(flat(&output.text).contains(&folder.files[index]), "{}", output.text);
    }
    let error = "is not an MCAP file\nhelp: name a recording (*.mcap)\n";
    assert!(output.text.contains(error), "{}", output.text);
    let page = folder.page();
    let (head, _) = page.split_once("</header>").unwrap();
    assert!(head.contains("<strong class=\"bad\">2 files unreadable</strong>"), "{head}");
    let metrics = folder.written();
    assert_eq!(metrics.all("pressure.measured").len(), 1);
    metrics.assert_near("pressure.measured", 3.0, 0.0);
}

/// Data stores replace files by links, and a copy may lack what they lead to.
#[cfg(unix)]
#[test]
fn links_to_missing_recordings_are_named() {
    let folder = Folder::write(MANIFEST, frames);
    fs::remove_file(folder.path().join("experiment.toml")).unwrap();
    fs::remove_file(folder.file(1)).unwrap();
    assert_eq!(analyze(&[folder.name()]).code, 0);
    std::os::unix::fs::symlink("missing", folder.file(1)).unwrap();
    let output = analyze(&[folder.name()]).exited_with(5);
    assert!(flat(&output.text).contains(&folder.files[1]), "{}", output.text);
}

/// The recording up to the record of its outcome, which follows the last block of frames.
fn without_end(bytes: &[u8]) -> &[u8] {
    let name = b"kinetoscope.outcome";
    let end = bytes.windows(name.len()).position(|part| part == name);
    &bytes[..end.unwrap()]
}

#[test]
fn intact_part_of_a_torn_recording_is_analyzed_without_means() {
    let folder = Folder::write(MANIFEST, frames);
    let bytes = fs::read(folder.file(1)).unwrap();
    fs::write(folder.file(1), without_end(&bytes)).unwrap();
    let output = analyze(&[folder.name()]).exited_with(5);
    assert!(flat(&output.text).contains("are intact"), "{}", output.text);
    let metrics = folder.written();
    let found = metrics.all("pressure.measured");
    // A mean of the two complete replicates, and three runs, one of which is marked.
    assert_eq!(found.len(), 4);
    assert_eq!(found[0]["sweep"]["replicates"], 2);
    assert_eq!(found[0]["value"], 2.0);
    assert_eq!(found[2]["run"]["outcome"], "damaged");
}

#[test]
fn no_readable_input_is_an_error_without_output() {
    let folder = Folder::write(MANIFEST, frames);
    for index in 0..3 {
        fs::write(folder.file(index), b"\x89MCAP0\r\n").unwrap();
    }
    analyze(&[folder.file(0).to_str().unwrap()]).exited_with(5);
    assert!(!folder.path().join("metrics.json").exists());
    // For the whole folder, the check fails because its metric is missing.
    assert_eq!(analyze(&[folder.name()]).code, 3);
}

#[test]
fn folder_of_results_is_checked_before_the_analysis() {
    let folder = Folder::write(MANIFEST, frames);
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    for destination in [file.clone(), file.join("below")] {
        let output =
            analyze(&["--output", destination.to_str().unwrap(), folder.name()]).exited_with(2);
        assert!(flat(&output.text).contains("remove the file in the way"), "{}", output.text);
        assert!(!output.text.contains("pressure"), "analyzed in vain: {}", output.text);
    }
}

#[test]
fn partial_files_are_read_only_when_named() {
    let folder = Folder::write(MANIFEST, frames);
    let bytes = fs::read(folder.file(2)).unwrap();
    let partial = folder.path().join(folder.files[2].replace(".mcap", ".partial.mcap"));
    fs::write(&partial, without_end(&bytes)).unwrap();
    fs::remove_file(folder.file(2)).unwrap();
    let output = analyze(&[folder.name()]).exited_with(0);
    assert!(
        flat(&output.text).contains("1 of 3 runs have no finished recording yet"),
        "{}",
        output.text
    );
    assert_eq!(folder.written().all("pressure.measured").len(), 3);
    // The run that is named is not complete, so a CI system must not see success.
    let file = folder.path().join("results.xml");
    let output =
        analyze(&["--junit", file.to_str().unwrap(), partial.to_str().unwrap()]).exited_with(3);
    assert!(flat(&output.text).contains("FAILED: 1 of 1 run unfinished"), "{}", output.text);
    assert!(flat(&output.text).contains(" s; not part of means and fits"), "{}", output.text);
    let xml = fs::read_to_string(file).unwrap();
    assert!(xml.contains("tests=\"1\" failures=\"0\" errors=\"1\""), "{xml}");
    assert!(xml.contains("<error message=\"unfinished: "), "{xml}");
    let metrics = folder.written();
    assert_eq!(metrics.first("pressure.measured")["run"]["outcome"], "unfinished");
}

/// A recording that an interrupted run left under its final name is part of the experiment, with any expected outcome.
#[test]
fn interrupted_runs_fail_and_are_excluded_from_means() {
    for expectation in ["", "expected_outcome = \"fault\"\n"] {
        let manifest = format!("{expectation}{MANIFEST}");
        let folder = Folder::write(&manifest, frames);
        let experiment = parse(&manifest, "gas.toml", &[]).unwrap();
        let run = &experiment.runs[1];
        write_run(&folder.file(1), run, &frames(&run.manifest), &Outcome::Interrupted);
        let output = analyze(&[folder.name()]).exited_with(3);
        assert!(flat(&output.text).contains("1 of 3 runs unfinished"), "{}", output.text);
        assert_eq!(folder.written().first("pressure.measured")["sweep"]["replicates"], 2);
    }
}

#[test]
fn stale_recordings_are_omitted_and_named() {
    let folder = Folder::write(MANIFEST, frames);
    fs::copy(folder.file(0), folder.path().join("old.mcap")).unwrap();
    // The file has a listed name, but its run key belongs to another run.
    fs::copy(folder.file(0), folder.file(1)).unwrap();
    let output = analyze(&[folder.name()]).exited_with(0);
    assert!(flat(&output.text).contains("old.mcap is stale"), "{}", output.text);
    assert!(
        flat(&output.text).contains(&format!("{} is stale", folder.files[1])),
        "{}",
        output.text
    );
    let metrics = folder.written();
    metrics.assert_near("pressure.measured", 2.0, 0.0);
    assert_eq!(metrics.first("pressure.measured")["sweep"]["replicates"], 2);
}

#[test]
fn recordings_without_sidecars_are_analyzed() {
    let folder = Folder::write(MANIFEST, frames);
    fs::remove_file(folder.path().join("experiment.toml")).unwrap();
    // A copy is no further replicate.
    fs::copy(folder.file(0), folder.path().join("a_copy.mcap")).unwrap();
    let output = analyze(&[folder.name()]).exited_with(0);
    let note = format!("{} is of the same run as a_copy.mcap; left out", folder.files[0]);
    assert!(flat(&output.text).contains(&note), "{}", output.text);
    let metrics = folder.written();
    assert_eq!(metrics.first("pressure.measured")["sweep"]["replicates"], 3);
    metrics.assert_near("pressure.measured", 2.0, 0.0);
}

#[test]
fn damaged_sidecar_is_named_and_the_recordings_are_read() {
    let folder = Folder::write(MANIFEST, frames);
    fs::write(folder.path().join("experiment.toml"), "name = ").unwrap();
    let output = analyze(&[folder.name()]).exited_with(5);
    assert!(output.text.contains("experiment.toml"), "{}", output.text);
    folder.written().assert_near("pressure.measured", 2.0, 0.0);
}

#[test]
fn mixed_models_are_analyzed_separately() {
    let folder = Folder::write(MANIFEST, frames);
    let orbit = parse("name = \"orbit\"\n[model.orbit]\n", "orbit.toml", &[]).unwrap();
    let mut frame = Frame::new();
    frame.push_state(&[1.0, 0.0, 0.0, 0.0, 0.017, 0.0]);
    let start = vec![(Clock { count: 0, time: 0.0 }, frame)];
    let file = folder.path().join("orbit.mcap");
    write_run(&file, &orbit.runs[0], &start, &Outcome::Complete);
    fs::remove_file(folder.path().join("experiment.toml")).unwrap();
    analyze(&[folder.name()]).exited_with(0);
    let metrics = folder.written();
    assert_eq!(metrics.all("radius.min").len(), 1);
    assert_eq!(metrics.first("pressure.measured")["sweep"]["replicates"], 3);
}

#[test]
fn fault_is_reported_and_excluded_from_means() {
    let folder = Folder::write(MANIFEST, frames);
    let experiment = parse(MANIFEST, "gas.toml", &[]).unwrap();
    let outcome = Outcome::Fault("the gas blew up".to_owned());
    let run = &experiment.runs[1];
    write_run(&folder.file(1), run, &frames(&run.manifest), &outcome);
    let output = analyze(&[folder.name()]).exited_with(3);
    let headline =
        "FAILED: 1 of 3 runs without the expected outcome: gas__001.mcap: failed: the gas blew up";
    assert!(flat(&output.text).contains(headline), "{}", output.text);
    assert_eq!(folder.written().first("pressure.measured")["sweep"]["replicates"], 2);
    let report = folder.page();
    assert!(report.contains(headline), "{report}");
}

/// A run that fails is what `expected_outcome = "fault"` asks for; a run that completes is then a failure.
#[test]
fn expected_fault_passes_and_completion_fails() {
    let expecting = format!("expected_outcome = \"fault\"\n{MANIFEST}");
    let folder = Folder::write(&expecting, frames);
    let experiment = parse(&expecting, "gas.toml", &[]).unwrap();
    let output = analyze(&[folder.name()]).exited_with(3);
    assert!(flat(&output.text).contains("the manifest expects a fault"), "{}", output.text);
    for (index, run) in experiment.runs.iter().enumerate() {
        let outcome = Outcome::Fault("numerical blow-up".to_owned());
        write_run(&folder.file(index), run, &frames(&run.manifest), &outcome);
    }
    analyze(&["--no-cache", folder.name()]).exited_with(0);
}

/// A CI system finds a JUnit file with an error where there is nothing to analyze.
#[test]
fn junit_reports_missing_recordings() {
    let empty = tempfile::TempDir::new().unwrap();
    let file = empty.path().join("results.xml");
    analyze(&["--junit", file.to_str().unwrap(), empty.path().join("none").to_str().unwrap()])
        .exited_with(2);
    let xml = fs::read_to_string(file).unwrap();
    assert!(xml.contains("errors=\"1\"") && xml.contains("does not exist"), "{xml}");
}

#[test]
fn missing_paths_are_rejected_as_arguments() {
    let empty = tempfile::TempDir::new().unwrap();
    let missing = empty.path().join("nothing");
    for path in [empty.path(), missing.as_path()] {
        let output = analyze(&[path.to_str().unwrap()]).exited_with(2);
        assert!(output.text.starts_with("error: "), "{}", output.text);
    }
    assert_eq!(analyze(&[]).code, 2);
    assert_eq!(analyze(&["--nonsense", "."]).code, 2);
}

/// No line of the table is longer than the width of the terminal, for any names; a pipe receives no escape codes.
#[test]
fn table_fits_sixty_columns() {
    let folder = Folder::write(MANIFEST, frames);
    let output = analyze(&[folder.name()]);
    for line in output.text.lines().filter(|line| !line.contains(folder.name())) {
        assert!(line.chars().count() <= 60, "{line}");
    }
    assert!(!output.text.contains('\x1b'));
    let written = "/report.html, with metrics.json, metrics.csv and";
    assert!(flat(&output.text).contains(written), "{}", output.text);
}

#[test]
fn contact_forces_with_unequal_columns_are_damage_and_the_rest_is_analyzed() {
    let manifest = "name = \"bed\"\nreplicates = 2\n[model.dem]\ndiscs = 2\n\
                    [record]\nchannels = [\"state\", \"contact_forces\"]\n";
    let folder = Folder::write(manifest, |run| {
        let mut frame = Frame::new();
        frame.push_state(&[0.01, 5e-4, 0.0, 0.0]);
        frame.push_state(&[0.02, 5e-4, 0.0, 0.0]);
        let lost = usize::from(run.replicate == 0);
        frame.push(&DemContactForces {
            from_x_m: vec![0.01; 2],
            from_y_m: vec![5e-4; 2],
            to_x_m: vec![0.01; 2],
            to_y_m: vec![0.0; 2],
            force_x_n: vec![0.0; 2 - lost],
            force_y_n: vec![1e-3; 2 - lost],
            first_id: vec![0, 1],
            second_id: vec![0, 1],
        });
        vec![(Clock { count: 1, time: 1.0 }, frame)]
    });
    let output = analyze(&[folder.name()]).exited_with(5);
    let text = flat(&output.text);
    assert!(text.contains("/contact_forces: its columns have different lengths"), "{text}");
    assert!(!folder.written().all("bed.packing_fraction").is_empty());
}

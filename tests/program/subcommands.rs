//! Guarantee: each subcommand does its work, prints JSON on request, and is silent with `--quiet`.

use crate::subcommand_bench::{Bench, GAS, call, recordings};
use std::fs;
use std::path::Path;

#[test]
fn run_reports_written_and_finished_runs() {
    let bench = Bench::new();
    bench.write("sweep.toml", &format!("replicates = 3\n{GAS}"));
    let first = bench.call(&["run", "--json", "sweep.toml"]);
    assert_eq!(first.code, Some(0), "{}", first.err);
    let json = first.json();
    assert_eq!(json["exit_code"], 0);
    let runs = json["experiments"][0]["runs"].as_array().unwrap().clone();
    assert_eq!(runs.len(), 3);
    assert!(runs.iter().all(|run| run["status"] == "written" && run["bytes"].as_u64() > Some(0)));
    fs::remove_file(bench.path(runs[0]["recording"].as_str().unwrap())).unwrap();

    let second = bench.call(&["run", "sweep.toml"]);
    let expected = "2 of 3 runs already finished (use --force to rerun them)";
    assert!(second.out.contains(expected), "{}", second.out);
    assert!(second.out.contains("kinetoscope -- analyze recordings/sweep"), "{}", second.out);
    let third = bench.call(&["run", "--json", "sweep.toml"]).json();
    assert_eq!(third["experiments"][0]["runs"][2]["status"], "finished earlier");
    let quiet = bench.call(&["run", "--quiet", "--force", "sweep.toml"]);
    assert_eq!((quiet.code, quiet.out.as_str(), quiet.err.as_str()), (Some(0), "", ""));
}

#[test]
fn run_analyzes_with_the_linked_analysis() {
    let bench = Bench::new();
    bench.write("gas.toml", GAS);
    let ran = bench.call(&["run", "--analyze", "--quiet", "gas.toml"]);
    assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""));
    let cached = fs::read_dir(bench.path("recordings/gas/.analysis-cache")).unwrap().count();
    assert_eq!(cached, 1);
}

#[test]
fn exported_commands_call_the_subcommand_run() {
    let bench = Bench::new();
    bench.write("gas.toml", GAS);
    let exported = bench.call(&["run", "--export-commands", "list", "gas.toml"]);
    assert_eq!(exported.code, Some(0), "{}", exported.err);
    let line = fs::read_to_string(bench.path("list")).unwrap();
    let status = std::process::Command::new("sh").args(["-c", line.trim()]).status().unwrap();
    assert!(status.success(), "{line}");
    assert_eq!(recordings(&bench.path("recordings/gas")).len(), 1, "{line}");
}

#[test]
fn check_reports_steps_memory_time_and_unknown_metrics() {
    let bench = Bench::new();
    let checks = "[[checks]]\nmetric = \"pressure.ideal_gas\"\nminimum = 0.0\n";
    let dem = "[model.dem]\ndiscs = 20\nduration_s = 0.01\n[record]\nframes = 2\n";
    bench.write("gas.toml", &format!("{GAS}{checks}"));
    bench.write("dem.toml", dem);
    let gas = bench.call(&["check", "gas.toml"]);
    assert_eq!(gas.code, Some(0), "{}", gas.err);
    for part in [
        "gas: gas, 1 run",
        "20 particles, 5 frames, at most",
        "memory: at most",
        "time: ",
        "1 check",
    ] {
        assert!(gas.out.contains(part), "{part} in {}", gas.out);
    }
    assert_eq!(gas.err, "");
    let json = bench.call(&["check", "--json", "dem.toml"]).json();
    let experiment = &json["experiments"][0];
    assert!(experiment["steps"]["min"].as_u64() > Some(0), "{json}");
    assert!(experiment["memory_bytes"].as_u64() > Some(0) && experiment["expected_s"].is_number());
    let [all, start] = ["expected_s", "preparation_s"].map(|key| experiment[key].as_f64().unwrap());
    assert!(all > start && start > 0.0, "the start is a part of the expected time: {json}");
    assert!(!bench.path("recordings").exists(), "nothing is written");

    let dry = bench.call(&["run", "--dry-run", "gas.toml"]);
    let without_time = |text: &str| {
        text.lines().filter(|line| !line.contains("time:")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(without_time(&dry.out), without_time(&gas.out));
    assert_eq!((dry.code, dry.err.as_str()), (Some(0), ""));
    bench.write("typo.toml", &format!("{GAS}{}", checks.replace("ideal_gas", "ideal_ga")));
    for command in ["check", "run"] {
        let typo = bench.call(&[command, "typo.toml"]);
        assert_eq!(typo.code, Some(2), "{}", typo.err);
        assert!(typo.err.contains("`pressure.ideal_ga` is not a metric"), "{}", typo.err);
        assert!(typo.err.contains("did you mean `pressure.ideal_gas`?"), "{}", typo.err);
        let line = 2 + GAS.lines().count();
        assert!(typo.err.contains(&format!(" --> typo.toml:{line}:10")), "{}", typo.err);
    }
    assert!(!bench.path("recordings").exists(), "nothing is written");
}

#[test]
fn check_of_a_finished_experiment_reports_the_resources_of_a_rerun() {
    let bench = Bench::new();
    bench.write("dem.toml", "[model.dem]\ndiscs = 20\nduration_s = 0.01\n[record]\nframes = 2\n");
    assert_eq!(bench.call(&["run", "--quiet", "dem.toml"]).code, Some(0));
    let checked = bench.call(&["check", "dem.toml"]);
    for part in ["1 of 1 run already finished", " steps per run", "memory: at most", " for a rerun"]
    {
        assert!(checked.out.contains(part), "{part} in {}", checked.out);
    }
    let json = &bench.call(&["check", "--json", "dem.toml"]).json()["experiments"][0];
    assert_eq!((json["to_do"].as_u64(), json["bytes"].as_u64()), (Some(0), Some(0)));
    assert!(json["steps"]["min"].as_u64() > Some(0) && json["expected_s"].is_number(), "{json}");
}

#[test]
fn info_names_the_experiment_of_a_renamed_file() {
    let bench = Bench::new();
    let recording = bench.recording();
    let folder = recording.parent().unwrap();
    let name = |path: &Path| {
        let json = bench.call(&["info", "--json", path.to_str().unwrap()]).json();
        json["experiment"].as_str().map(str::to_owned)
    };
    let renamed = folder.join("other.mcap");
    fs::copy(&recording, &renamed).unwrap();
    assert_eq!(name(&renamed).as_deref(), Some("gas"), "listed in experiment.toml");
    let apart = bench.path(recording.file_name().unwrap().to_str().unwrap());
    fs::copy(&recording, &apart).unwrap();
    assert_eq!(name(&apart).as_deref(), Some("gas"), "the file name belongs to the run key");
    let unknown = bench.path("notes__01234567.mcap");
    fs::copy(&recording, &unknown).unwrap();
    assert_eq!(name(&unknown), None, "neither");
}

/// Control: before, each of these errors was one line.
#[test]
fn errors_of_runs_and_recordings_end_with_a_remedy() {
    let bench = Bench::new();
    let dem = "[model.dem]\ndiscs = 20\nduration_s = 0.01\n";
    bench.write("unstable.toml", &format!("{dem}time_step_s = 1e-3\n"));
    let soft = "gravity_m_per_s2 = [0.0, -1e6]\nstiffness_n_per_m = 10.0\n";
    let warn = "on_unstable_time_step = \"warn\"\ntime_step_s = 1e-5\n[record]\nframes = 2\n";
    bench.write("blow_up.toml", &format!("{dem}{soft}{warn}"));
    let recording = bench.recording();
    let bytes = fs::read(&recording).unwrap();
    fs::write(bench.path("cut.mcap"), &bytes[..bytes.len() / 2]).unwrap();
    for (arguments, what, help) in [
        (&["run", "unstable.toml"] as &[&str], "the time step is unstable", "the nearest accepted"),
        (&["check", "unstable.toml"], "the time step is unstable", "the nearest accepted"),
        (&["run", "blow_up.toml"], "Blow-up at step", "the contacts are too soft"),
        (&["benchmark", "blow_up.toml"], "Blow-up at step", "the contacts are too soft"),
        (&["info", "cut.mcap"], "cut.mcap is cut off", "run its manifest again"),
        (&["verify", "cut.mcap"], "cut off", "run its manifest again"),
        (&["compare", "cut.mcap", "cut.mcap"], "cut off", "run its manifest again"),
        (&["info", "missing.mcap"], "missing.mcap cannot be read", "check the path"),
        (&["verify", "missing.mcap"], "missing.mcap", "check that the file exists"),
        (&["compare", "missing.mcap", "cut.mcap"], "missing.mcap", "check that the file exists"),
        (&["analyze", "missing"], "missing does not exist", "check the path"),
        (&["run", "missing.toml"], "missing.toml", "`kinetoscope new gas"),
        (&["run", "unstable2.toml"], "unstable2.toml", "did you mean `unstable.toml`?"),
        (&["run", "blow_up"], "blow_up", "did you mean `blow_up.toml`?"),
    ] {
        let called = bench.call(arguments);
        let (error, remedy) = called
            .err
            .split_once("\nhelp: ")
            .unwrap_or_else(|| panic!("{arguments:?} has no help: {}{}", called.out, called.err));
        assert!(error.contains("error: ") && error.contains(what), "{arguments:?}: {error}");
        assert!(remedy.to_lowercase().starts_with(help), "{arguments:?}: {remedy}");
        assert_ne!(called.code, Some(0), "{arguments:?}");
    }
}

#[test]
fn shipped_experiments_check_without_warnings() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/first_run.toml");
    let bench = Bench::new();
    let checked = bench.call(&["check", "--quiet", folder]);
    assert_eq!((checked.code, checked.err.as_str()), (Some(0), ""));
}

#[test]
fn recordings_are_described_verified_and_compared() {
    let bench = Bench::new();
    let recording = bench.recording();
    let recording = recording.to_str().unwrap();
    let info = bench.call(&["info", recording]);
    assert_eq!((info.code, info.err.as_str()), (Some(0), ""));
    for part in [
        "experiment  gas",
        "run key",
        "seed        1",
        "complete",
        "frames      5",
        "/state (5 messages)",
    ] {
        assert!(info.out.contains(part), "{part} in {}", info.out);
    }
    let json = bench.call(&["info", "--json", recording]).json();
    assert_eq!((json["frames"].as_u64(), json["outcome"].as_str()), (Some(5), Some("complete")));
    assert_eq!(json["channels"]["/state"], 5);

    let verified = bench.call(&["verify", "--json", recording]);
    assert_eq!(verified.code, Some(0), "{}", verified.err);
    assert_eq!(verified.json()["equal"], true);
    let compared = bench.call(&["compare", "--json", recording, recording]);
    assert_eq!((compared.code, compared.json()["exit_code"].as_u64()), (Some(0), Some(0)));

    let other = bench.call(&["run", "--quiet", "gas.toml", "--set", "seed=2", "--output", "other"]);
    assert_eq!(other.code, Some(0), "{}", other.err);
    let other = recordings(&bench.path("other/gas")).remove(0);
    let differs = bench.call(&["compare", recording, other.to_str().unwrap()]);
    assert_eq!(differs.code, Some(4));
    assert!(differs.out.contains("  seed: 1 → 2"), "{}", differs.out);
    assert!(differs.err.starts_with("error: first difference: "), "{}", differs.err);
}

#[test]
fn why_names_the_changed_key() {
    let bench = Bench::new();
    bench.recording();
    let done = bench.call(&["why", "gas.toml"]);
    assert_eq!((done.code, done.out.as_str()), (Some(0), "gas: finished\n"));
    let changed = bench.call(&["why", "--json", "gas.toml", "--set", "seed=7"]).json();
    assert_eq!(changed["runs"][0]["status"], "to do");
    assert!(changed["runs"][0]["reason"].as_str().unwrap().contains("seed: 1 → 7"));
}

#[test]
fn benchmark_measures_every_run() {
    let bench = Bench::new();
    bench.write("gas.toml", GAS);
    let table = bench.call(&["benchmark", "--json", "gas.toml"]);
    assert_eq!(table.code, Some(0), "{}", table.err);
    assert!(table.json()["points"][0]["median_s"].as_f64() > Some(0.0));
}

#[test]
fn recordings_are_analyzed_and_exported() {
    let bench = Bench::new();
    bench.recording();
    let analyzed = bench.call(&["analyze", "--json", "recordings/gas"]);
    assert_eq!(analyzed.code, Some(0), "{}", analyzed.err);
    let json = analyzed.json();
    assert!(!json["experiments"][0]["analysis"]["metrics"].as_array().unwrap().is_empty());
    let quiet = bench.call(&["analyze", "--quiet", "recordings/gas"]);
    assert_eq!((quiet.code, quiet.out.as_str()), (Some(0), ""));
    assert!(bench.call(&["analyze", "--list-metrics"]).out.contains("pressure.ideal_gas"));

    let exported =
        bench.call(&["export", "--format", "csv,xyz", "recordings/gas", "--output", "tables"]);
    assert_eq!(exported.code, Some(0), "{}", exported.err);
    assert_eq!(fs::read_dir(bench.path("tables")).unwrap().count(), 1, "one folder per recording");
    let json = bench.call(&["export", "--json", "--format", "csv,xyz", "recordings/gas"]).json();
    assert_eq!(json["exit_code"], 0);
    let exports = json["exports"].as_array().unwrap();
    assert_eq!(exports.iter().map(|export| &export["format"]).collect::<Vec<_>>(), ["csv", "xyz"]);
    for export in exports {
        assert!(bench.path(export["recording"].as_str().unwrap()).exists());
        let files = export["files"].as_array().unwrap();
        assert!(!files.is_empty());
        for file in files {
            let text = fs::read_to_string(bench.path(file["path"].as_str().unwrap())).unwrap();
            assert_eq!(file["bytes"], text.len());
            // A table has a header; extended XYZ has two lines per frame before the particles.
            let frames = text.lines().filter(|line| line.contains("Properties=")).count();
            let others = if export["format"] == "csv" { 1 } else { 2 * frames };
            assert_eq!(file["rows"], text.lines().count() - others, "{file}");
        }
    }
    let drawn = bench.call(&["export", "--json", "--thumbnail", "t.svg", "recordings/gas"]).json();
    let file = &drawn["exports"][0]["files"][0];
    assert_eq!(file["bytes"], fs::metadata(bench.path("t.svg")).unwrap().len());
    let drawn = bench.call(&["export", "--thumbnail", "gas.png", "recordings/gas"]);
    assert_eq!(drawn.code, Some(0), "{}", drawn.err);
    assert!(fs::read(bench.path("gas.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn starter_schema_and_completions_are_printed() {
    let bench = Bench::new();
    for model in ["dem", "gas", "packing", "orbit"] {
        let starter = call(["new", model]);
        assert_eq!(starter.code, Some(0));
        bench.write("new.toml", &starter.out);
        let checked = bench.call(&["check", "--quiet", "new.toml"]);
        assert_eq!((checked.code, checked.err.as_str()), (Some(0), ""), "{model}");
    }
    assert!(call(["schema"]).json()["properties"]["model"].is_object());
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let completions = call(["completions", shell]);
        assert!(completions.code == Some(0) && completions.out.contains("find-step"), "{shell}");
        for (program, subcommand) in [("run-experiment", "run"), ("analyze-recordings", "analyze")]
        {
            let own = call(["completions", shell, program]);
            assert!(own.code == Some(0) && own.out.contains(program), "{shell} {program}");
            let help = call([subcommand, "--help"]).out;
            let flags = help.split_whitespace().filter_map(|word| word.strip_prefix("--"));
            let names = flags.map(|flag| flag.split(['[', ',']).next().unwrap());
            let missing: Vec<&str> = names.filter(|&name| !own.out.contains(name)).collect();
            assert!(missing.is_empty(), "{shell} {program}: {missing:?}");
            assert!(!own.out.contains("find-step"), "{shell} {program}");
        }
    }
}

#[test]
fn doctor_reports_the_machine_and_problems_with_a_remedy() {
    let bench = Bench::new();
    let healthy = bench.call(&["doctor", "--json"]).json();
    for key in ["version", "physics", "SIMD", "threads", "memory", "disk", "features", "cluster"] {
        assert!(!healthy[key].is_null(), "{key} in {healthy}");
    }
    bench.write("file", "");
    let ill = bench.call(&["doctor", "--output", "file"]);
    assert_eq!(ill.code, Some(1), "{}", ill.out);
    assert!(ill.err.contains("error: no recording can be written to file\nhelp: "), "{}", ill.err);
}

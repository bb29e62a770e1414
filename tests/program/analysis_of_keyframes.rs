//! Guarantee: every number and every chart that `analyze`, `plot` and `export` make of a recording of keyframes equals that of the
//! recording of all frames; what needs the states between keyframes is left out, with the command that restores them.
//!
//! Control: of each model, both kinds of metrics occur, and the restored recording has all of them.

use crate::keyframes::{MODELS, expect, keyframes, recorded};
use crate::subcommand_bench::{Bench, command, recordings};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

const ALL: &str = "frames = 40";
const KEYS: &str = "frames = 40\nkeep = \"keyframes\"\nkeyframe_distance = 7";

/// Scenes whose metrics follow from states in other ways than those of [`MODELS`], each with further keys of `[record]`.
const SCENES: [(&str, &str, &str); 9] = [
    (
        "a disc that rebounds",
        "[model.dem]\nradius_m = 5e-4\nwidth_m = 0.04\nheight_m = 0.2\nduration_s = 0.2\nplacement = { positions_m = [[0.02, 0.02]], velocities_m_per_s = [[0.0, 0.0]] }\n",
        "",
    ),
    (
        "a bed with its stress",
        "[model.dem]\ndiscs = 40\nwidth_m = 0.008\nheight_m = 0.02\nrestitution = 0.3\nduration_s = 0.1\n",
        "\nchannels = [\"state\", \"energy\", \"contact_statistics\", \"wall_forces\", \"contact_forces\"]",
    ),
    (
        "a granular gas",
        "[model.dem]\ndiscs = 150\nwidth_m = 0.03\nheight_m = 0.03\nperiodic = \"both\"\ngravity_m_per_s2 = [0.0, 0.0]\nvelocity_std_m_per_s = 0.05\nrestitution = 0.95\nduration_s = 0.05\n",
        "",
    ),
    (
        "single collisions",
        "[model.packing]\ndiscs = 30\nwall_noise_variance_rad2 = 0.003\n",
        "\nchannels = [\"state\", \"temperature\", \"collisions\", \"pressure\", \"per_collision\"]",
    ),
    (
        "cooling discs",
        "[model.packing]\ndiscs = 150\nradius = 0.5\nrestitution = 0.9\nremove_mean_velocity = true\nevents_per_disc = 20\n",
        "",
    ),
    (
        "diffusing discs",
        "[model.packing]\ndiscs = 60\nradius = 2.0\nboundary = \"periodic\"\nremove_mean_velocity = true\nevents_per_disc = 60\n",
        "",
    ),
    (
        "a gas that expands",
        "[model.gas]\nparticles = 400\ntemperature_k = 300.0\npartition_x_m = 0.0\npartition_opens_s = 0.001\nduration_s = 0.01\n",
        "",
    ),
    (
        "a gas of discs",
        "[model.gas]\nparticles = 100\ntemperature_k = 300.0\ndisc_radius_m = 0.004\nduration_s = 0.01\n",
        "",
    ),
    (
        "three bodies",
        "[model.orbit]\nintegrator = \"dop853\"\ntime_step_days = 0.03\nduration_days = 6.0\nbodies = [\n  { gm_au3_per_day2 = 1.0, position_au = [0.97, -0.243, 0.0], velocity_au_per_day = [0.466, 0.432, 0.0] },\n  { gm_au3_per_day2 = 1.0, position_au = [-0.97, 0.243, 0.0], velocity_au_per_day = [0.466, 0.432, 0.0] },\n  { gm_au3_per_day2 = 1.0, position_au = [0.0, 0.0, 0.0], velocity_au_per_day = [-0.932, -0.864, 0.0] },\n]\n",
        "",
    ),
];

/// The results of an analysis: the rows of each metric by its run and its name, without the name of the file, and the charts.
struct Results {
    rows: BTreeMap<String, Value>,
    charts: BTreeMap<String, String>,
}

fn analyzed(bench: &Bench, recording: &Path) -> Results {
    let output = format!("results-{}", recording.file_stem().unwrap().to_string_lossy());
    let arguments = ["analyze", "--quiet", "--output", &output, recording.to_str().unwrap()];
    expect(&bench.call(&arguments), 0);
    results(&bench.path(&output))
}

fn results(folder: &Path) -> Results {
    let text = fs::read_to_string(folder.join("metrics.json")).unwrap();
    let mut parsed: Value = serde_json::from_str(&text).unwrap();
    let mut rows = BTreeMap::new();
    for row in parsed["metrics"].as_array_mut().unwrap() {
        if let Some(run) = row.get_mut("run").and_then(Value::as_object_mut) {
            run.remove("file");
        }
        let place = format!("{} {} {}", row["name"], row["run"], row["sweep"]);
        rows.insert(place, row.clone());
    }
    let charts = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let charts = charts.filter(|path| path.extension().is_some_and(|end| end == "svg"));
    let charts = charts.map(|path| {
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        (stem, fs::read_to_string(&path).unwrap())
    });
    Results { rows, charts: charts.collect() }
}

fn reason(row: &Value) -> &str {
    row["reason"].as_str().unwrap_or_default()
}

/// Compares the results of all frames with those of the keyframes; returns the numbers of equal and of withheld metrics.
fn compare(name: &str, full: &Results, keys: &Results) -> (usize, usize) {
    let (mut equal, mut withheld) = (0, 0);
    for (place, row) in &keys.rows {
        if reason(row).contains("kinetoscope fill") {
            withheld += 1;
            let has_law_only = !row["value"].is_null();
            if let Some(other) = full.rows.get(place).filter(|_| has_law_only) {
                // Only the range of its law needs all states.
                assert_eq!(row["value"], other["value"], "{name}: {place}");
                assert_eq!(row["standard_error"], other["standard_error"], "{name}: {place}");
                assert!(row["deviation_sigma"].is_null(), "{name}: {place}");
            }
            continue;
        }
        let other = full.rows.get(place);
        assert_eq!(Some(row), other, "{name}: {place}");
        equal += 1;
    }
    for (place, row) in &full.rows {
        // A mean over replicates, or a fit along a sweep, has no row if no run has a value; each run states why.
        let is_of_withheld = row["run"].is_null() && withheld > 0;
        assert!(keys.rows.contains_key(place) || is_of_withheld, "{name}: {place} is missing");
    }
    // Single collisions are stored with the keyframes, so that these charts show the moments of the frames.
    let has_collisions = ["single collisions", "packing_fifty_discs"].contains(&name);
    let of_collisions: &[&str] = if has_collisions { &["a2", "temperature"] } else { &[] };
    let charts = keys.charts.iter().filter(|(stem, _)| !of_collisions.contains(&stem.as_str()));
    for (stem, chart) in charts {
        assert!(full.charts.get(stem) == Some(chart), "{name}: chart {stem}");
    }
    (equal, withheld)
}

/// The recordings of all frames and of the keyframes.
fn both(bench: &Bench, model: &str, record: &str) -> [PathBuf; 2] {
    [("full", ALL), ("keys", KEYS)]
        .map(|(folder, frames)| recorded(bench, folder, model, &format!("{frames}{record}")))
}

#[test]
fn metrics_and_charts_of_keyframes_equal_those_of_all_frames_or_name_fill() {
    let models = MODELS.iter().map(|(name, model, _)| (*name, *model, ""));
    for (name, model, record) in models.chain(SCENES) {
        let bench = Bench::new();
        let [full, keys] = both(&bench, model, record);
        let [of_all, of_keys] = [&full, &keys].map(|path| analyzed(&bench, path));
        let (equal, withheld) = compare(name, &of_all, &of_keys);
        assert!(equal >= 4, "{name}: {equal} equal");
        // All metrics of a gas follow from scalars and from the first and the last state.
        let is_gas = model.contains("[model.gas]");
        assert!(is_gas == (withheld == 0), "{name}: {withheld} withheld");
        assert!(of_keys.charts.len() <= of_all.charts.len(), "{name}");
        assert!(name == "orbit" || name == "three bodies" || !of_keys.charts.is_empty(), "{name}");
    }
}

/// Control: the restored recording has the metrics.
#[test]
fn analysis_names_the_command_that_restores_all_frames() {
    let bench = Bench::new();
    let keys = keyframes(&bench, MODELS[3].1);
    let called = bench.call(&["analyze", keys.to_str().unwrap()]);
    let text = called.out.clone() + &called.err;
    assert!(text.contains("keyframes (every 7th frame)"), "{text}");
    assert!(text.contains("kinetoscope fill"), "{text}");
    expect(&called, 0);
    let info = bench.call(&["info", keys.to_str().unwrap()]);
    assert!(info.out.contains("every 7th frame"), "{}", info.out);
    let of_keys = analyzed(&bench, &keys);
    let is_max = |place: &&String| place.contains("\"energy.max_error_relative\"");
    let place = of_keys.rows.keys().find(is_max).unwrap();
    let command = format!("kinetoscope fill {}", keys.display());
    assert!(reason(&of_keys.rows[place]).contains(&command), "{}", of_keys.rows[place]);
    expect(&bench.call(&["fill", keys.to_str().unwrap(), "-o", "filled.mcap"]), 0);
    let filled = analyzed(&bench, &bench.path("filled.mcap"));
    assert!(filled.rows[place]["value"].is_f64(), "{}", filled.rows[place]);
}

/// Control: a chart of states between keyframes is rejected with the command, and drawn of all frames.
#[test]
fn plots_of_scalars_have_all_frames() {
    let bench = Bench::new();
    let [full, keys] = both(&bench, MODELS[0].1, "");
    let plot = |bench: &Bench, recording: &Path, arguments: &[&str]| {
        let ends = ["--output", "plot.svg", recording.to_str().unwrap()];
        let called = bench.call(&[&["plot", "--quiet"], arguments, &ends].concat());
        let drawn = fs::read(bench.path("plot.svg"));
        let _ = fs::remove_file(bench.path("plot.svg"));
        (called, drawn.unwrap_or_default())
    };
    for arguments in [&["--y", "/energy.kinetic_j"][..], &["--figure", "energy_balance"]] {
        let [(of_all, drawn), (of_keys, same)] =
            [&full, &keys].map(|recording| plot(&bench, recording, arguments));
        expect(&of_all, 0);
        expect(&of_keys, 0);
        assert!(drawn == same && !drawn.is_empty(), "{arguments:?}");
    }
    let bench = Bench::new();
    let [full, keys] = both(&bench, MODELS[3].1, "");
    let (called, drawn) = plot(&bench, &keys, &["--figure", "path"]);
    assert!(drawn.is_empty() && called.err.contains("kinetoscope fill"), "{}", called.err);
    expect(&called, 2);
    expect(&plot(&bench, &full, &["--figure", "path"]).0, 0);
}

#[test]
fn exported_scalars_have_all_frames() {
    for (name, model, _) in MODELS {
        let bench = Bench::new();
        let [of_all, of_keys] = both(&bench, model, "").map(|recording| {
            let recording = recording.to_str().unwrap();
            expect(&bench.call(&["export", recording, "--format", "csv", "--output", "out"]), 0);
            bench.path("out").join(Path::new(recording).file_stem().unwrap())
        });
        let table = |folder: &Path, file: &str| fs::read_to_string(folder.join(file)).unwrap();
        let mut equal = 0;
        for entry in fs::read_dir(&of_keys).unwrap() {
            let file = entry.unwrap().file_name().into_string().unwrap();
            let (some, all) = (table(&of_keys, &file), table(&of_all, &file));
            if file == "state.csv" {
                assert!(some.lines().count() < all.lines().count(), "{name}: {file}");
            } else {
                assert!(some == all, "{name}: {file}");
                equal += 1;
            }
        }
        assert!(equal > 0, "{name}");
    }
}

/// A run that fails between two keyframes has no state of its end, so that its metrics need all frames. Control: the failed run with
/// all frames is analyzed.
#[test]
fn failed_run_between_two_keyframes_names_fill() {
    let bench = Bench::new();
    let model = "[model.packing]\ndiscs = 40\nrestitution = 0.5\nevents_per_disc = 2000\n";
    bench.write("m.toml", &format!("name = \"m\"\nseed = 1\n{model}[record]\n{KEYS}\n"));
    expect(&bench.call(&["run", "--quiet", "--output", "keys", "m.toml"]), 1);
    let keys = recordings(&bench.path("keys/m")).remove(0);
    let called = bench.call(&["analyze", keys.to_str().unwrap()]);
    assert!(called.err.contains("ends between two of them"), "{}{}", called.out, called.err);
    assert!(called.err.contains("kinetoscope fill"), "{}", called.err);
    expect(&called, 5);
    expect(&bench.call(&["fill", keys.to_str().unwrap(), "-o", "full.mcap"]), 0);
    let called = bench.call(&["analyze", "full.mcap"]);
    assert!(called.out.contains("come to rest"), "{}{}", called.out, called.err);
}

/// The same for all shipped experiments, which have sweeps, replicates and setups that no scene above has.
#[test]
#[ignore = "records all shipped experiments twice, for some minutes"]
fn metrics_of_keyframes_of_shipped_experiments_equal_those_of_all_frames_or_name_fill() {
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    let (mut equal, mut withheld) = (0, 0);
    for entry in fs::read_dir(experiments).unwrap() {
        let manifest = entry.unwrap().path();
        if manifest.extension().is_none_or(|end| end != "toml") {
            continue;
        }
        let name = manifest.file_stem().unwrap().to_string_lossy().into_owned();
        let bench = Bench::new();
        let [of_all, of_keys] = ["all", "keyframes"].map(|keep| {
            let mut run = command();
            run.current_dir(bench.0.path()).args(["run", "--quiet", "--output", keep]);
            if keep == "keyframes" {
                run.args(["--set", "record.keep=\"keyframes\""]);
                run.args(["--set", "record.keyframe_distance=7"]);
            }
            assert!(run.arg(&manifest).status().unwrap().code().is_some(), "{name}");
            let folder = bench.path(keep).join(&name);
            assert!(!recordings(&folder).is_empty(), "{name}");
            let analyze = ["analyze", "--quiet", "--output", "results"];
            let results_folder = bench.path("results");
            let called = bench.call(&[&analyze[..], &[folder.to_str().unwrap()]].concat());
            if called.code == Some(5) && keep == "keyframes" {
                assert!(called.err.contains("kinetoscope fill"), "{name}: {}", called.err);
                return None;
            }
            let found = results(&results_folder);
            fs::remove_dir_all(results_folder).unwrap();
            Some(found)
        });
        let (Some(of_all), Some(of_keys)) = (of_all, of_keys) else { continue };
        let numbers = compare(&name, &of_all, &of_keys);
        println!("{name}: {} equal, {} need fill", numbers.0, numbers.1);
        (equal, withheld) = (equal + numbers.0, withheld + numbers.1);
    }
    println!("together: {equal} equal, {withheld} need fill");
    assert!(equal > withheld && withheld > 0);
}

//! Guarantee: a baseline is compared run by run. The same run has the same values, other versions have the same values within
//! rounding, other seeds have no significant difference, and any other key that differs is named.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::synthetic::{AnalysisOutput, Folder, Frames, analyze, flat, two_frames};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::GasPressure;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;

/// Four replicates of a gas; the rest of the manifest follows `seed`.
pub(crate) fn manifest(seed: u32, rest: &str) -> String {
    format!(
        "name = \"gas\"\nreplicates = 4\nseed = {seed}\n[model.gas]\nparticles = 1\nduration_s = 1.0\n{rest}\n\
         [record]\nframes = 1\nchannels = [\"state\", \"pressure\"]\n"
    )
}

/// Ideal-gas pressure `center` + 0, 1, 2, 3 by replicate: mean center + 1.5, standard error sqrt(5/3)/2 = 0.645.
pub(crate) fn frames(center: f64) -> impl Fn(&RunManifest) -> Frames {
    move |run| {
        two_frames(&GasPressure {
            ideal_gas_n_per_m: center + f64::from(run.replicate),
            mean_square_formula_n_per_m: 2.0,
            ..GasPressure::default()
        })
    }
}

/// An earlier analysis: seed 1, center 10.
pub(crate) struct Earlier {
    folder: Folder,
    file: PathBuf,
}

impl Earlier {
    pub(crate) fn new(rest: &str) -> Self {
        Self::of(Folder::write(&manifest(1, rest), frames(10.0)))
    }

    /// The analysis of these recordings.
    pub(crate) fn of(folder: Folder) -> Self {
        let file = folder.baseline();
        Self { folder, file }
    }

    /// Changes the file of the baseline.
    pub(crate) fn edit(&self, change: impl Fn(&mut Value)) {
        let mut document: Value =
            serde_json::from_str(&fs::read_to_string(&self.file).unwrap()).unwrap();
        change(&mut document);
        fs::write(&self.file, document.to_string()).unwrap();
    }

    /// Compares other recordings with the baseline.
    pub(crate) fn compare(&self, manifest: &str, center: f64, more: &[&str]) -> AnalysisOutput {
        self.compare_folder(&Folder::write(manifest, frames(center)), more)
    }

    pub(crate) fn compare_folder(&self, now: &Folder, more: &[&str]) -> AnalysisOutput {
        let arguments = ["--baseline", self.file.to_str().unwrap(), now.name()];
        let output = analyze(&[&arguments, more].concat());
        assert!(!output.text.contains("combined standard errors"), "{}", output.text);
        output
    }
}

/// The first entry of a metric in a document.
pub(crate) fn first<'a>(document: &'a mut Value, name: &str) -> &'a mut Value {
    let metrics = document["metrics"].as_array_mut().unwrap();
    metrics.iter_mut().find(|metric| metric["name"] == name).unwrap()
}

#[test]
fn same_run_is_equal_to_the_last_digit() {
    let earlier = Earlier::new("");
    let same = earlier.compare_folder(&earlier.folder, &[]);
    assert_eq!(same.code, 0, "{}", same.text);
    assert!(flat(&same.text).contains("same run key and versions: equal to the last digit"));
    // Control: one bit.
    earlier.edit(|document| {
        first(document, "pressure.ideal_gas")["value"] = json!(11.500_000_000_000_002)
    });
    let other = earlier.compare_folder(&earlier.folder, &[]);
    assert_eq!(other.code, 3, "{}", other.text);
    let finding = "FAILED pressure.ideal_gas: 11.5 N/m, baseline 11.5 N/m, difference -1.776357e-15 N/m: \
        not equal, although the run is the same";
    assert!(flat(&other.text).contains(finding), "{}", other.text);
}

#[test]
fn other_versions_are_equal_within_rounding() {
    let earlier = Earlier::new("");
    let with_value = |value: f64| {
        earlier.edit(|document| {
            for run in document["runs"].as_array_mut().unwrap() {
                run["program_version"] = json!("0.0.9");
                run["physics_version"] = json!(7);
            }
            first(document, "pressure.ideal_gas")["value"] = json!(value);
        });
        earlier.compare_folder(&earlier.folder, &[])
    };
    let rounded = with_value(11.5 * (1.0 + 0.9e-9));
    assert_eq!(rounded.code, 0, "{}", rounded.text);
    let beyond = with_value(11.5 * (1.0 + 1.1e-9));
    assert_eq!(beyond.code, 3, "{}", beyond.text);
    let versions = "beyond rounding (program version: 0.0.9 → 0, physics version: 7 → 1)";
    assert!(flat(&beyond.text).contains(versions), "{}", beyond.text);
}

/// The means 11.5(6) and 12.5(6) agree, 11.5(6) and 111.5(6) do not. Metrics without an error are not compared.
#[test]
fn other_seeds_have_no_significant_difference() {
    let earlier = Earlier::new("");
    let near = earlier.compare(&manifest(2, ""), 11.0, &[]);
    assert_eq!(near.code, 0, "{}", near.text);
    let text = flat(&near.text);
    assert!(text.contains("4 runs, seed: 1 → 2: differences by Student's t"), "{text}");
    assert!(
        text.contains("ok pressure.ideal_gas: 12.5 N/m, baseline 11.5 N/m, difference 1 N/m, "),
        "{text}"
    );
    assert!(text.contains("within the scatter of seeds"), "{text}");
    assert!(text.contains("0 fail, ") && !text.contains(" 0 are not compared"), "{text}");
    let far = earlier.compare(&manifest(2, ""), 110.0, &[]);
    assert_eq!(far.code, 3, "{}", far.text);
    assert!(flat(&far.text).contains("beyond the scatter of seeds"), "{}", far.text);
}

/// Control: a comparison by standard errors alone passes, because the values are near.
#[test]
fn other_keys_fail_and_are_named() {
    let earlier = Earlier::new("temperature_k = 300\nradius_m = 1");
    // The law of the speeds follows from the temperature, and that of the pressure from the radius as well. None depends on the center.
    for (key, rest, code) in [
        ("model.gas.temperature_k: 300.0 → 303.0", "temperature_k = 303\nradius_m = 1", 3),
        ("model.gas.radius_m: 1.0 → 1.01", "temperature_k = 300\nradius_m = 1.01", 3),
        (
            "model.gas.center_m: [0.0, 0.0] → [0.1, 0.0]",
            "temperature_k = 300\nradius_m = 1\ncenter_m = [0.1, 0.0]",
            0,
        ),
    ] {
        let name = key.split(':').next().unwrap();
        for seed in [1, 2] {
            let changed = manifest(seed, rest);
            let other = earlier.compare(&changed, 10.5, &[]);
            assert_eq!(other.code, 3, "{}", other.text);
            let finding =
                format!("FAILED keys of 4 runs: {key}; allow a change with --allow-changed");
            assert!(flat(&other.text).contains(&finding), "{}", other.text);
            let last = name.rsplit('.').next().unwrap();
            for allowed in [name, last] {
                let output = earlier.compare(&changed, 10.5, &["--allow-changed", allowed]);
                assert_eq!(output.code, code, "{}", output.text);
                let is_by_law = flat(&output.text)
                    .contains("its exact law, which follows from the manifest, gives");
                assert_eq!(is_by_law, code == 3, "{}", output.text);
            }
            let far = earlier.compare(&changed, 110.0, &["--allow-changed", name]);
            assert_eq!(far.code, 3, "{}", far.text);
        }
    }
}

/// A comparison of no run or of no metric is not a success. Control: a metric with a tolerance is compared.
#[test]
fn comparison_of_nothing_fails() {
    let one = |seed: u32, rest: &str| {
        let manifest = format!(
            "name = \"bed\"\nseed = {seed}\n{rest}[model.dem]\ndiscs = 2\n[record]\nchannels = [\"state\"]\n"
        );
        Folder::write(&manifest, |_| {
            let mut frame = Frame::new();
            frame.push_state(&[0.01, 5e-4, 0.0, 0.0]);
            frame.push_state(&[0.02, 5e-4, 0.0, 0.0]);
            vec![(Clock { count: 0, time: 0.0 }, frame)]
        })
    };
    let folder = one(1, "");
    let single = Earlier::of(folder);
    // Neither seed has an error, and no metric of these frames has an exact law.
    let other = single.compare_folder(&one(2, ""), &[]);
    assert_eq!(other.code, 3, "{}", other.text);
    let text = flat(&other.text);
    assert!(text.contains("nothing could be compared"), "{text}");
    assert!(text.contains("use replicates") && text.contains("relative_tolerance"), "{text}");
    // What the manifest sets is compared, but its equality shows nothing.
    assert!(text.contains("ok packing_fraction"), "{text}");

    let tolerance = "[[baseline]]\nmetric = \"bed.height\"\nrelative_tolerance = 0.1\n";
    let decided = single.compare_folder(&one(2, tolerance), &[]);
    assert_eq!(decided.code, 0, "{}", decided.text);
    let empty = Earlier::new("");
    empty.edit(|document| {
        document["runs"] = json!([]);
        document["metrics"] = json!([]);
    });
    let nothing = empty.compare_folder(&empty.folder, &[]);
    assert_eq!(nothing.code, 3, "{}", nothing.text);
    assert!(flat(&nothing.text).contains("no run is in both analyses"), "{}", nothing.text);
}

/// A run with another seed that loses energy differs from one that conserved it, although neither value has an error.
#[test]
fn lost_conservation_fails_for_another_seed() {
    let manifest = |seed: u32| {
        format!(
            "name = \"packing\"\nseed = {seed}\n[model.packing]\ndiscs = 1\nwidth = 20.0\nheight = 20.0\n"
        )
    };
    let with_final_speed = |seed: u32, speed: f64| {
        Folder::write(&manifest(seed), |_| {
            let moving = [1.0, speed].map(|speed| {
                let mut frame = Frame::new();
                frame.push_state(&[0.0, 0.0, speed, 0.0]);
                frame
            });
            let clocks = (0..2_u32).map(|at| Clock { count: at.into(), time: at.into() });
            clocks.zip(moving).collect()
        })
    };
    let folder = with_final_speed(1, 1.0);
    let earlier = Earlier::of(folder);
    // A law that holds for any size of what it conserves does not show that nothing else has changed.
    let kept = earlier.compare_folder(&with_final_speed(2, 1.0), &[]);
    assert_eq!(kept.code, 3, "{}", kept.text);
    let text = flat(&kept.text);
    assert!(text.contains("FAILED the comparison: this comparison is insensitive"), "{text}");
    assert!(text.contains("use replicates"), "{text}");
    assert!(text.contains("ok energy.drift_relative"), "{text}");
    let lost = earlier.compare_folder(&with_final_speed(2, 0.99), &[]);
    assert_eq!(lost.code, 3, "{}", lost.text);
    let text = flat(&lost.text);
    assert!(text.contains("no longer equal to its exact law up to rounding"), "{text}");
}

#[test]
fn tolerances_of_the_manifest_replace_the_standard_error() {
    let earlier = Earlier::new("");
    let tolerance = |value: f64| {
        format!("[[baseline]]\nmetric = \"pressure.ideal_gas\"\nrelative_tolerance = {value}\n")
    };
    let compare = |value| earlier.compare(&(manifest(2, "") + &tolerance(value)), 11.0, &[]);
    // The replicates differ by 1 of 10 to 13, the means by 1 of 11.5.
    assert_eq!(compare(0.1).code, 0, "{}", compare(0.1).text);
    let tight = compare(0.08);
    assert_eq!(tight.code, 3, "{}", tight.text);
    assert!(flat(&tight.text).contains("tolerance 0.08 of the baseline"), "{}", tight.text);
}

/// Runs that one analysis does not have, and metrics that are gone, fail.
#[test]
fn missing_runs_and_metrics_fail() {
    let earlier = Earlier::new("");
    let fewer = manifest(1, "").replace("replicates = 4", "replicates = 3");
    let output = earlier.compare(&fewer, 10.0, &[]);
    assert_eq!(output.code, 3, "{}", output.text);
    assert!(flat(&output.text).contains("FAILED the run at replicate = 3"), "{}", output.text);
    earlier.edit(|document| first(document, "pressure.ideal_gas")["name"] = json!("lost"));
    let lost = earlier.compare_folder(&earlier.folder, &[]);
    assert_eq!(lost.code, 3);
    assert!(flat(&lost.text).contains("FAILED lost: none, baseline 11.5 N/m"), "{}", lost.text);
    assert_eq!(earlier.compare(&manifest(2, ""), 11.0, &[]).code, 3, "with another seed as well");
    // Whether a metric applies may depend on the seed, if it has no error; the same run has it.
    earlier.edit(|document| first(document, "lost")["name"] = json!("effusion_rate"));
    assert_eq!(earlier.compare(&manifest(2, ""), 11.0, &[]).code, 3, "it had an error");
    earlier.edit(|document| first(document, "effusion_rate")["standard_error"] = Value::Null);
    assert_eq!(earlier.compare(&manifest(2, ""), 11.0, &[]).code, 0);
    assert_eq!(earlier.compare_folder(&earlier.folder, &[]).code, 3);
}

#[test]
fn unusable_baselines_are_rejected_before_the_analysis() {
    let earlier = Earlier::new("");
    let text = fs::read_to_string(&earlier.file).unwrap();
    let rejected = |text: &str, expected: &str| {
        fs::write(&earlier.file, text).unwrap();
        let output = earlier.compare_folder(&earlier.folder, &[]);
        assert_eq!(output.code, 2, "{}", output.text);
        assert!(flat(&output.text).contains(expected), "{expected} in {}", output.text);
        assert!(!output.text.contains("against the baseline"), "{}", output.text);
    };
    rejected("{}", "is not a metrics.json");
    rejected("", "is not a complete metrics.json");
    rejected(&text[..text.len() / 2], "is not a complete metrics.json");
    rejected(&text.replacen("\"gas\"", "\"other\"", 1), "the baseline is of the experiment other");
    rejected(
        &text.replacen("\"schema\": 3", "\"schema\": 1", 1),
        "has schema 1, this version reads 3",
    );
    fs::write(&earlier.file, &text).unwrap();
    let unknown = earlier.compare_folder(&earlier.folder, &["--allow-changed", "temprature_k"]);
    assert_eq!(unknown.code, 2, "{}", unknown.text);
    assert!(flat(&unknown.text).contains("has this key"), "{}", unknown.text);
}

/// The report lists every metric of both analyses, the worst first.
#[test]
fn report_lists_all_metrics_worst_first() {
    let earlier = Earlier::new("");
    let now = Folder::write(&manifest(2, ""), frames(110.0));
    let output = earlier.compare_folder(&now, &[]);
    assert_eq!(output.code, 3, "{}", output.text);
    let report = now.page();
    let section =
        report.split("Against the baseline").nth(1).unwrap().split("</section>").next().unwrap();
    let rows: Vec<&str> = section.split("<tr>").skip(2).collect();
    let documents = now.written();
    assert_eq!(rows.len(), documents.len(), "{section}");
    assert!(
        rows[0].contains("<strong class=\"bad\">failed</strong>: beyond the scatter of seeds"),
        "{}",
        rows[0]
    );
    let first_uncompared = rows.iter().position(|row| row.contains("not compared")).unwrap();
    assert!(rows[first_uncompared..].iter().all(|row| row.contains("not compared")));
    let output = earlier.compare_folder(&now, &["--json"]);
    let mut documents = serde_json::Deserializer::from_str(&output.text).into_iter::<Value>();
    let printed = documents.next().unwrap().unwrap();
    let printed = &printed["experiments"][0]["baseline"]["rows"];
    assert_eq!(printed.as_array().unwrap().len(), rows.len());
    assert_eq!(printed[0]["passed"], false, "{printed}");
}

/// A run with other sizes of the same discs differs, although no value has an error.
#[test]
fn values_that_the_manifest_sets_are_equal() {
    let bed = |seed: u32, width: f64| {
        let manifest = format!(
            "name = \"bed\"\nseed = {seed}\n[model.dem]\ndiscs = 2\nwidth_m = {width}\n[record]\nchannels = [\"state\"]\n"
        );
        Folder::write(&manifest, |_| {
            let mut frame = Frame::new();
            frame.push_state(&[0.01, 5e-4, 0.0, 0.0]);
            frame.push_state(&[0.02, 5e-4, 0.0, 0.0]);
            vec![(Clock { count: 0, time: 0.0 }, frame)]
        })
    };
    let folder = bed(1, 0.04);
    let earlier = Earlier::of(folder);
    let wider = earlier.compare_folder(&bed(2, 0.05), &["--allow-changed", "width_m"]);
    assert_eq!(wider.code, 3, "{}", wider.text);
    let text = flat(&wider.text);
    assert!(text.contains("FAILED packing_fraction: 7.853982e-4, baseline 9.817477e-4"), "{text}");
    assert!(text.contains("set by the manifest, and differs"), "{text}");
}

/// A metric that had an error and has none now is a difference: what the run does has changed. Setup: a baseline whose metric is
/// given an error by hand. Control: a baseline without it passes.
#[test]
fn lost_standard_error_fails() {
    let gas = |seed: u32| {
        Folder::write(&manifest(seed, "").replace("replicates = 4", "replicates = 1"), frames(10.0))
    };
    let folder = gas(1);
    let earlier = Earlier::of(folder);
    let compared = earlier.compare_folder(&gas(2), &["--json"]);
    let row = row_of(&compared, "pressure.ideal_gas");
    assert!(row["passed"].is_null(), "control: {row}");
    earlier.edit(|document| first(document, "pressure.ideal_gas")["standard_error"] = json!(1e9));
    let compared = earlier.compare_folder(&gas(2), &["--json"]);
    assert_eq!(compared.code, 3, "{}", compared.text);
    let row = row_of(&compared, "pressure.ideal_gas");
    assert_eq!(row["passed"], false, "{row}");
    assert!(row["reason"].as_str().unwrap().contains("had a standard error"), "{row}");
}

/// A value that neither analysis has does not pass.
#[test]
fn missing_values_of_both_analyses_are_not_compared() {
    let earlier = Earlier::new("");
    earlier.edit(|document| first(document, "pressure.ideal_gas")["value"] = Value::Null);
    let other = Folder::write(&manifest(2, ""), frames(10.0));
    let before = row_of(&earlier.compare_folder(&other, &["--json"]), "pressure.ideal_gas");
    assert!(before["passed"].is_null(), "only now: {before}");
    let packing = |seed: u32| {
        let manifest = format!(
            "name = \"packing\"\nseed = {seed}\n[model.packing]\ndiscs = 1\nwidth = 20.0\nheight = 20.0\n"
        );
        Folder::write(&manifest, |_| {
            let mut frame = Frame::new();
            frame.push_state(&[0.0, 0.0, 1.0, 0.0]);
            vec![(Clock { count: 0, time: 0.0 }, frame)]
        })
    };
    let folder = packing(1);
    let earlier = Earlier::of(folder);
    for seed in [1, 2] {
        let compared = earlier.compare_folder(&packing(seed), &["--json"]);
        let row = row_of(&compared, "self_diffusion.from_velocities");
        assert!(row["baseline"].is_null() && row["now"].is_null(), "{row}");
        assert!(row["passed"].is_null() && row["reason"].is_string(), "{row}");
    }
}

/// Runs that draw no random numbers are equal for every seed. Setup: an orbit. Control: another trajectory is found.
#[test]
fn runs_without_random_numbers_are_equal_for_every_seed() {
    let orbit = |seed: u32, end_au: f64| {
        let manifest = format!("name = \"orbit\"\nseed = {seed}\n[model.orbit]\n");
        Folder::write(&manifest, |_| {
            let at = |(count, x): (u32, f64)| {
                let mut frame = Frame::new();
                frame.push_state(&[x, 0.0, 0.0, 0.0, 0.0172, 0.0]);
                (Clock { count: count.into(), time: count.into() }, frame)
            };
            [(0, 1.0), (1, end_au)].map(at).to_vec()
        })
    };
    let folder = orbit(1, 1.0);
    let earlier = Earlier::of(folder);
    let same = earlier.compare_folder(&orbit(2, 1.0), &[]);
    assert_eq!(same.code, 0, "{}", same.text);
    let text = flat(&same.text);
    assert!(
        text.contains("1 run without random numbers, seed: 1 → 2: equal within rounding"),
        "{text}"
    );
    let other = earlier.compare_folder(&orbit(2, 0.99), &[]);
    assert_eq!(other.code, 3, "{}", other.text);
    assert!(
        flat(&other.text).contains("although the runs draw no random numbers"),
        "{}",
        other.text
    );
}

/// The row of a metric in the printed comparison.
pub(crate) fn row_of(output: &AnalysisOutput, name: &str) -> Value {
    let mut documents = serde_json::Deserializer::from_str(&output.text).into_iter::<Value>();
    let printed = documents.next().unwrap().unwrap();
    let rows = printed["experiments"][0]["baseline"]["rows"].as_array().unwrap().clone();
    rows.into_iter().find(|row| row["subject"] == name).unwrap()
}

/// Guarantee: the violation of a conservation law is an error of the method, which differs from seed to seed as any other value: means over
/// replicates are compared by their scatter, although its deviation from 0 has no meaning.
/// Controls: a single run has no scatter and is not compared, a tolerance decides, and a law that held up to rounding must still hold.
#[test]
fn violations_of_conservation_laws_are_compared_between_seeds() {
    let write = |seed: u32, replicates: u32, loss: f64, rest: &str| {
        let manifest = format!(
            "name = \"packing\"\nseed = {seed}\nreplicates = {replicates}\n[model.packing]\ndiscs = 1\nwidth = 20.0\nheight = 20.0\n{rest}"
        );
        Folder::write(&manifest, |run| {
            let last = 1.0 - loss * (1.0 + f64::from(run.replicate) / 100.0);
            let at = |(count, speed): (u32, f64)| {
                let mut frame = Frame::new();
                frame.push_state(&[0.0, 0.0, speed, 0.0]);
                (Clock { count: count.into(), time: count.into() }, frame)
            };
            [(0, 1.0), (1, last)].map(at).to_vec()
        })
    };
    let earlier = |replicates: u32, loss: f64| {
        let folder = write(1, replicates, loss, "");
        Earlier::of(folder)
    };
    let drift = |earlier: &Earlier, now: &Folder| {
        row_of(&earlier.compare_folder(now, &["--json"]), "energy.drift_relative")
    };
    let lossy = earlier(4, 0.01);
    let near = drift(&lossy, &write(2, 4, 0.0101, ""));
    assert_eq!(near["passed"], true, "{near}");
    assert!(near["deviation_sigma"].as_f64().unwrap() > 0.0, "{near}");
    let far = drift(&lossy, &write(2, 4, 0.05, ""));
    assert_eq!(far["passed"], false, "{far}");
    let single = drift(&earlier(1, 0.01), &write(2, 1, 0.05, ""));
    assert!(single["passed"].is_null() && single["deviation_sigma"].is_null(), "{single}");
    assert!(single["reason"].as_str().unwrap().contains("conservation law"), "{single}");
    let same = drift(&lossy, &lossy.folder);
    assert_eq!((&same["passed"], &same["reason"]), (&json!(true), &json!("equal")));
    let tolerance = "[[baseline]]\nmetric = \"energy.drift_relative\"\nrelative_tolerance = 0.1\n";
    let decided = drift(&lossy, &write(2, 4, 0.05, tolerance));
    assert_eq!(decided["passed"], false, "{decided}");
    let lost = drift(&earlier(4, 0.0), &write(2, 4, 0.05, ""));
    assert_eq!(lost["passed"], false, "{lost}");
}

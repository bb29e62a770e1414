//! Guarantee: what cannot differ is no evidence: a comparison with a baseline that consists of it fails, or is called insensitive.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::baselines_are_compared_run_by_run::{Earlier, first, frames, manifest, row_of};
use crate::synthetic::{AnalysisOutput, Folder, flat, two_frames};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::{GasCollisions, GasInvariants, GasPressure};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;
use serde_json::{Value, json};

/// A row of `discs` discs on the floor of a box that is 4 mm wide, in four replicates that differ by `shift` in the last disc's place and by
/// `rise` in the heights.
fn row_of_discs(seed: u32, discs: u32, shift: f64, rise: f64) -> Folder {
    row_of_discs_with(seed, discs, shift, rise, "")
}

/// The same with more tables of the manifest.
fn row_of_discs_with(seed: u32, discs: u32, shift: f64, rise: f64, rest: &str) -> Folder {
    let manifest = format!(
        "name = \"bed\"\nseed = {seed}\nreplicates = 4\n[model.dem]\ndiscs = {discs}\nwidth_m = 0.004\nheight_m = 0.02\n\
         [record]\nchannels = [\"state\"]\n{rest}"
    );
    Folder::write(&manifest, move |run| {
        let number = f64::from(run.replicate) + 0.1 * f64::from(seed);
        let mut frame = Frame::new();
        for disc in 0..discs {
            let last = f64::from(u8::from(disc + 1 == discs));
            let x = 1e-3 * (f64::from(disc) + 0.5) - last * shift * number;
            frame.push_state(&[x, 5e-4 * (1.0 + rise * number), 0.0, 0.0]);
        }
        vec![(Clock { count: 0, time: 0.0 }, frame)]
    })
}

/// Guarantee: a deposit that reaches both walls is no evidence, because the container sets its length. Setup: lengths of 4 mm that differ by
/// micrometers, and heights that differ by half of themselves. Control: the same deviations of a shorter deposit.
#[test]
fn deposit_as_long_as_its_container_has_no_power() {
    for (discs, is_insensitive) in [(4, true), (2, false)] {
        let folder = row_of_discs(1, discs, 1e-6, 1.0);
        let earlier = Earlier::of(folder);
        let other = earlier.compare_folder(&row_of_discs(2, discs, 1e-6, 1.0), &["--json"]);
        assert_eq!(other.code, 0, "{}", other.text);
        assert_eq!(other.text.contains("insensitive"), is_insensitive, "{}", other.text);
        let is_listed = other.text.contains(" % of bed.deposit_length");
        assert_eq!(is_listed, !is_insensitive, "{}", other.text);
        let reason = row_of(&other, "bed.deposit_length")["reason"].to_string();
        assert_eq!(reason.contains("as large as the container"), is_insensitive, "{reason}");
    }
}

/// Guarantee: values that are equal in all runs are no evidence, because they do not tell by how much they could have differed. Control: a
/// value that differs from them fails.
#[test]
fn values_that_are_equal_in_all_runs_have_no_power() {
    let folder = row_of_discs(1, 2, 0.0, 0.0);
    let earlier = Earlier::of(folder);
    let same = earlier.compare_folder(&row_of_discs(2, 2, 0.0, 0.0), &[]);
    assert_eq!(same.code, 3, "{}", same.text);
    assert!(flat(&same.text).contains("nothing could be compared"), "{}", same.text);
    earlier.edit(|document| first(document, "bed.deposit_length")["value"] = json!(0.0021));
    let other = earlier.compare_folder(&row_of_discs(2, 2, 0.0, 0.0), &["--json"]);
    let row = row_of(&other, "bed.deposit_length");
    assert_eq!(row["passed"], false, "control: {row}");
}

/// Guarantee: a tolerance is evidence only for a metric that could differ, and only if it is not larger than the changes that a comparison must find.
/// Setup: single runs whose discs lie on the floor, with one `[[baseline]]` entry each. Control: a tolerance of a tenth for the height.
#[test]
fn tolerance_is_evidence_of_what_could_differ() {
    let run = |seed: u32, rest: &str| {
        let manifest = format!(
            "name = \"bed\"\nseed = {seed}\n[model.dem]\ndiscs = 2\n[record]\nchannels = [\"state\"]\n{rest}"
        );
        Folder::write(&manifest, |_| {
            let mut frame = Frame::new();
            frame.push_state(&[0.01, 5e-4, 0.0, 0.0]);
            frame.push_state(&[0.02, 5e-4, 0.0, 0.0]);
            vec![(Clock { count: 0, time: 0.0 }, frame)]
        })
    };
    let folder = run(1, "");
    let earlier = Earlier::of(folder);
    for (metric, tolerance, result) in [
        ("packing_fraction", 0.01, "nothing could be compared"),
        ("bed.weight", 1e-6, "nothing could be compared"),
        ("bed.height", 1e9, "nothing could be compared"),
        ("energy.rotational", 0.1, "nothing could be compared"),
        ("bed.height", 0.5, "insensitive"),
        ("bed.height", 0.1, ""),
    ] {
        let entry =
            format!("[[baseline]]\nmetric = \"{metric}\"\nrelative_tolerance = {tolerance}\n");
        let compared = earlier.compare_folder(&run(2, &entry), &[]);
        let text = flat(&compared.text);
        assert!(text.contains(&format!("ok {metric}")), "{metric}: {text}");
        assert_eq!(compared.code, if result.is_empty() { 0 } else { 3 }, "{metric}: {text}");
        assert!(text.contains(result), "{metric}, {tolerance}: {text}");
    }
    // The same entry does not make replicates sensitive either.
    let beds = |seed: u32| row_of_discs(seed, 4, 1e-6, 1.0);
    let folder = beds(1);
    let earlier = Earlier::of(folder);
    let entry = "[[baseline]]\nmetric = \"packing_fraction\"\nrelative_tolerance = 0.01\n";
    let now = row_of_discs_with(2, 4, 1e-6, 1.0, entry);
    let compared = earlier.compare_folder(&now, &[]);
    assert_eq!(compared.code, 0, "{}", compared.text);
    assert!(compared.text.contains("insensitive"), "{}", compared.text);
}

/// Four replicates of discs whose compressibility factor is 1 + `excess` (1 + 0.1 times the replicate).
fn dilute_discs(seed: u32, excess: f64, rest: &str) -> Folder {
    let manifest = format!(
        "name = \"dilute\"\nseed = {seed}\nreplicates = 4\n[model.gas]\nparticles = 2\ndisc_radius_m = 0.01\nduration_s = 1.0\n\
         [record]\nframes = 1\nchannels = [\"collisions\", \"energy\"]\n{rest}"
    );
    Folder::write(&manifest, move |run| {
        let at = |time: u32| {
            let mut frame = Frame::new();
            let excess = excess * (1.0 + 0.1 * f64::from(run.replicate));
            let pair_virial_sum_j_s = 2.0 * excess * f64::from(time);
            frame.push(&GasCollisions { pair_virial_sum_j_s, ..GasCollisions::default() });
            frame.push(&GasInvariants { kinetic_j: 1.0, ..GasInvariants::default() });
            (Clock { count: time.into(), time: time.into() }, frame)
        };
        (0..2).map(at).collect()
    })
}

/// Law: Z - 1 of a dilute gas is proportional to the area of the discs, and Z is about 1 by construction. Guarantee: a comparison counts changes of Z - 1: Z
/// of 1.02 with an error of 0.1 % does not make it sensitive, nor does a tolerance of 5 %. Control: a tolerance of 0.1 %.
#[test]
fn compressibility_of_a_dilute_gas_has_no_power() {
    let is_insensitive = |excess: f64, rest: &str| {
        let folder = dilute_discs(1, excess, "");
        let output =
            Earlier::of(folder).compare_folder(&dilute_discs(2, excess, rest), &["--json"]);
        assert_eq!(output.code, 0, "{}", output.text);
        let row = row_of(&output, "compressibility_factor");
        assert_eq!(row["passed"], true, "{row}");
        output.text.contains("insensitive")
    };
    let tolerance = |value: f64| {
        format!("[[baseline]]\nmetric = \"compressibility_factor\"\nrelative_tolerance = {value}\n")
    };
    assert!(is_insensitive(0.02, ""));
    assert!(is_insensitive(0.02, &tolerance(0.05)));
    assert!(!is_insensitive(0.02, &tolerance(0.001)), "control");
    let folder = dilute_discs(1, 0.02, "");
    let output = Earlier::of(folder).compare_folder(&dilute_discs(2, 0.02, ""), &[]);
    let text = flat(&output.text);
    assert!(text.contains("% of compressibility_factor - 1"), "{text}");
}

/// Guarantee: a least change of rounding size is not stated. Setup: replicates whose values differ by 1e-13 of themselves. Control: replicates that
/// differ.
#[test]
fn values_that_are_equal_up_to_rounding_have_no_least_change() {
    let row = |spread: f64| {
        let gas = |seed: u32| {
            let write = move |run: &RunManifest| {
                two_frames(&GasPressure {
                    ideal_gas_n_per_m: 10.0 + spread * f64::from(run.replicate),
                    ..GasPressure::default()
                })
            };
            Folder::write(&manifest(seed, ""), write)
        };
        let folder = gas(1);
        let output = Earlier::of(folder).compare_folder(&gas(2), &["--json"]);
        row_of(&output, "pressure.ideal_gas")
    };
    let equal = row(1e-12);
    assert_eq!(equal["passed"], true, "{equal}");
    assert!(equal["least_detectable_change"].is_null(), "{equal}");
    let different = row(1.0);
    assert!(different["least_detectable_change"].as_f64().unwrap() > 1.0, "control: {different}");
}

/// Guarantee: each row of a comparison has a name of its own. Control: one run without replicates is not numbered.
#[test]
fn subjects_of_replicates_and_of_their_mean_differ() {
    let subjects = |output: &AnalysisOutput| -> Vec<String> {
        let mut documents = serde_json::Deserializer::from_str(&output.text).into_iter::<Value>();
        let printed = documents.next().unwrap().unwrap();
        let rows = printed["experiments"][0]["baseline"]["rows"].as_array().unwrap().clone();
        rows.iter().map(|row| row["subject"].as_str().unwrap().to_owned()).collect()
    };
    let earlier = Earlier::new("");
    let mut several = subjects(&earlier.compare(&manifest(2, ""), 10.5, &["--json"]));
    let all = several.len();
    assert!(several.iter().any(|subject| subject.ends_with(" at replicate = 0")), "{several:?}");
    several.sort();
    several.dedup();
    assert_eq!(several.len(), all, "{several:?}");
    let one = |seed| manifest(seed, "").replace("replicates = 4", "replicates = 1");
    let folder = Folder::write(&one(1), frames(10.0));
    let single = subjects(&Earlier::of(folder).compare(&one(2), 10.5, &["--json"]));
    assert!(single.iter().all(|subject| !subject.contains("replicate")), "{single:?}");
}

//! Guarantee: what cannot differ is no evidence: a comparison with a baseline that consists of it fails, or is called insensitive.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::baselines_are_compared_run_by_run::{Earlier, first, frames, manifest, row_of};
use crate::synthetic::{AnalysisOutput, Folder, flat};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;
use serde_json::{Value, json};

/// A row of `discs` discs on the floor of a box that is 4 mm wide, in four replicates that differ by `shift` in the last disc's place and by
/// `rise` in the heights.
fn row_of_discs(seed: u32, discs: u32, shift: f64, rise: f64) -> Folder {
    let manifest = format!(
        "name = \"bed\"\nseed = {seed}\nreplicates = 4\n[model.dem]\ndiscs = {discs}\nwidth_m = 0.004\nheight_m = 0.02\n\
         [record]\nchannels = [\"state\"]\n"
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

//! Guarantee: the head of the report answers in sentences: the failed checks with their reasons, then the manifest's answer with its
//! numbers, else what the requested plots and the checks state, else the main results of the model, conservation laws last. No sentence of the program contains the
//! name of a metric, and no number is invented: a missing one is explained.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::gas_and_dem_metrics_equal_closed_forms::{DROP, drop_frames};
use crate::synthetic::{Folder, analyze, flat, write_run};
use kinetoscope_manifest::parse;
use kinetoscope_recording::reader::Outcome;
use serde_json::Value;

/// The report of falling discs.
fn page(manifest: &str) -> String {
    let folder = Folder::write(manifest, drop_frames);
    let output = analyze(&[folder.name()]);
    assert!([0, 3].contains(&output.code), "{}", output.text);
    folder.page()
}

/// The sentences of the answer with their markup.
fn marked(page: &str) -> &str {
    let (_, answer) = page.split_once("<p class=\"result\">").unwrap();
    answer.split("</p>").next().unwrap()
}

/// The sentences of the answer without markup.
fn answer(manifest: &str) -> String {
    let page = page(manifest);
    let parts = marked(&page).split('<');
    let text: String = parts.map(|part| part.split_once('>').map_or(part, |it| it.1)).collect();
    text.replace("\u{a0}✓", "")
}

fn check(metric: &str, bound: &str) -> String {
    format!("[[checks]]\nmetric = \"{metric}\"\n{bound}\n")
}

/// Before the tables of the manifest.
fn with_answer(answer: &str) -> String {
    format!("answer = '{answer}'\n{DROP}")
}

#[test]
fn answer_of_the_manifest_has_its_numbers_in_bold_with_a_badge() {
    let checked = check("restitution.measured", "tolerance = 0.01");
    let text = "It is {restitution.measured} <i>, {energy.residual_relative size in percent}.";
    let page = page(&format!("{}{checked}", with_answer(text)));
    let expected = "It is <strong>0.8</strong><span class=\"good\" title=\"the check passes\">\u{a0}✓</span> &lt;i&gt;, <strong>0.0609 %</strong>.";
    assert_eq!(marked(&page), expected);
}

#[test]
fn failed_check_comes_first_with_its_reason_in_words() {
    let failing = check("restitution.measured", "minimum = 0.9");
    let text = answer(&format!("{}{failing}", with_answer("It is {restitution.measured}.")));
    let expected = "A check fails: the measured restitution is 0.8, where at least 0.9 is required. It is 0.8 (its check fails).";
    assert_eq!(text, expected);
    let many: String =
        (1..=4).map(|bound| check("bed.weight", &format!("minimum = {bound}"))).collect();
    let text = answer(&format!("{DROP}{many}"));
    assert!(text.contains(" 2 further checks fail. The relative change"), "{text}");
}

#[test]
fn check_that_fails_at_several_points_has_one_sentence() {
    let sweep = format!("{DROP}[sweep]\n\"model.dem.friction\" = [0.1, 0.2]\n");
    let failing = check("restitution.measured", "minimum = 0.9");
    let expected = "A check fails at both points of the sweep: the measured restitution is 0.8 at friction 0.1 and 0.8 at friction 0.2, where at least 0.9 is required.";
    let text = answer(&format!("{sweep}{failing}"));
    assert!(text.starts_with(expected), "{text}");
    let same = check("restitution.measured", "expected = 0.7\nrelative_tolerance = 1e-12");
    let text = answer(&format!("{DROP}{same}"));
    assert!(text.contains("is 0.8, not equal to the expected 0.7."), "{text}");
}

#[test]
fn sentences_follow_from_the_checks_and_name_no_metric() {
    let checks = [
        check("energy.residual_relative", "maximum = 1"),
        check("restitution.measured", "tolerance = 0.01"),
    ];
    let text = answer(&format!("{DROP}{}", checks.concat()));
    let expected = "The measured restitution is 0.8, equal to the theoretical 0.8. The sum of all energies is conserved to 6.1·10⁻⁴.";
    assert_eq!(text, expected);
    let given = check("restitution.measured", "expected = 0.79\ntolerance = 0.1");
    let expected = "The measured restitution is 0.8, 1.3 % above the expected 0.79.";
    assert_eq!(answer(&format!("{DROP}{given}")), expected);
}

/// Control: a plot over the sweep that the manifest requests is the only one.
#[test]
fn experiment_without_checks_and_plots_has_the_main_results_and_their_plot() {
    let text = answer(DROP);
    assert!(text.starts_with("The relative change of the mechanical energy is −"), "{text}");
    assert!(text.contains(" %."), "{text}");
    let sweep = format!("{DROP}[sweep]\n\"model.dem.friction\" = [0.1, 0.2]\n");
    let text = page(&sweep);
    let plot = "title=\"Relative change of the mechanical energy against friction\">Plot</a>";
    assert!(marked(&text).contains(plot), "{}", marked(&text));
    let requested = "[[plots]]\ny = \"restitution.measured\"\n";
    assert!(!marked(&page(&format!("{sweep}{requested}"))).contains(plot));
}

/// Setup: a sweep with one value at all points. Control: without the check, the plot alone gives the range.
#[test]
fn sentences_cover_all_points_of_a_sweep() {
    let sweep = format!("{DROP}[sweep]\n\"model.dem.friction\" = [0.1, 0.2]\n");
    let checked = check("restitution.measured", "tolerance = 0.01");
    let expected = "The measured restitution is 0.8 at both points of the sweep, equal to theory.";
    assert_eq!(answer(&format!("{sweep}{checked}")), expected);
    let places: String = ["0.1", "0.2"]
        .map(|friction| {
            let place = format!("where = {{ friction = {friction} }}\ntolerance = 0.01");
            check("restitution.measured", &place)
        })
        .concat();
    let expected = "The measured restitution is 0.8 at friction 0.1 and 0.8 at friction 0.2.";
    assert_eq!(answer(&format!("{sweep}{places}")), expected);
    let plot = "[[plots]]\ny = \"restitution.measured\"\ntitle = \"A plot\"\n";
    let page = page(&format!("{sweep}{plot}"));
    let expected = "The measured restitution is <strong>0.8</strong> at both points of the sweep, equal to theory.";
    assert!(marked(&page).starts_with(expected), "{}", marked(&page));
    // The plot itself is on the first screen; only other pages lead to it.
    assert!(!marked(&page).contains("Plot</a>"), "{}", marked(&page));
    assert!(page.contains("id=\"plot-restitution"));
}

#[test]
fn missing_value_is_explained() {
    let manifest = with_answer("It is {restitution.measured}, high {bed.surface_angle}.");
    let text = answer(&manifest);
    assert!(text.starts_with("It is 0.8, high (no value: "), "{text}");
    let folder = Folder::write(&manifest, drop_frames);
    let experiment = parse(&manifest, "m.toml", &[]).unwrap();
    let run = &experiment.runs[0];
    let fault = Outcome::Fault("the discs are too fast".to_owned());
    write_run(&folder.file(0), run, &drop_frames(&run.manifest), &fault);
    analyze(&[folder.name()]).exited_with(3);
    let page = folder.page();
    let reason =
        "It is <em>(no value: the run failed at 0.6 s: the discs are too fast)</em>, high <em>(no";
    assert!(marked(&page).contains(reason), "{}", marked(&page));
    assert!(!marked(&page).contains("<strong></strong>"));
    let sweep = "[sweep]\n\"model.dem.friction\" = [0.1, 0.2]\n";
    let manifest = with_answer("It is {restitution.measured @ friction = 0.2}.") + sweep;
    let other = Folder::write(&manifest, drop_frames);
    std::fs::remove_file(other.file(1)).unwrap();
    analyze(&[other.name()]).exited_with(0);
    assert!(marked(&other.page()).contains("(no value: the run is not among the recordings)"));
}

#[test]
fn same_sentence_is_in_every_output() {
    let manifest =
        format!("question = 'How high?'\n{}", with_answer("It is {restitution.measured}."));
    let folder = Folder::write(&manifest, drop_frames);
    let junit = folder.path().join("junit.xml");
    let output = analyze(&["--junit", junit.to_str().unwrap(), folder.name()]).exited_with(0).text;
    assert!(flat(&output).contains("How high? It is 0.8."), "{output}");
    let xml = std::fs::read_to_string(junit).unwrap();
    assert!(xml.contains("<property name=\"answer\" value=\"It is 0.8.\"/>"), "{xml}");
    let metrics = std::fs::read_to_string(folder.path().join("metrics.json")).unwrap();
    let metrics: Value = serde_json::from_str(&metrics).unwrap();
    assert_eq!(metrics["question"], "How high?");
    assert_eq!(metrics["answer"]["text"], "It is 0.8.");
    assert_eq!(metrics["answer"]["numbers"][0]["metric"], "restitution.measured");
    assert!(folder.page().contains("<p class=\"question\">How high?</p>"));
}

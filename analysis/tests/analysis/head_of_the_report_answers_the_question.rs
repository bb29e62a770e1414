//! Guarantee: the head of the report answers in sentences: the failed checks with their reasons, then the manifest's answer with its
//! numbers, else what the requested plots and the checks state, else the main results of the model, conservation laws last. No sentence of the program contains the
//! name of a metric, and no number is invented: a missing one is explained.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::gas_and_dem_metrics_equal_closed_forms::{DROP, drop_frames};
use crate::synthetic::{Folder, analyze, flat, two_frames, write_run};
use kinetoscope_manifest::model::{ModelConfig, SpeedScale};
use kinetoscope_manifest::{RunManifest, parse};
use kinetoscope_recording::channels::GasPressure;
use kinetoscope_recording::reader::Outcome;
use serde_json::Value;

/// The report of falling discs.
fn page(manifest: &str) -> String {
    let folder = Folder::write(manifest, drop_frames);
    let output = analyze(&[folder.name()]);
    assert!([0, 3].contains(&output.code), "{}", output.text);
    folder.page()
}

/// The sentences of the answer with their markup, and with plain spaces.
fn marked(page: &str) -> String {
    sentences(page).replace('\u{a0}', " ")
}

fn sentences(page: &str) -> &str {
    let (_, answer) = page.split_once("<p class=\"result\">").unwrap();
    answer.split("</p>").next().unwrap()
}

/// The sentences of the answer without markup.
fn answer(manifest: &str) -> String {
    let page = page(manifest);
    let marked = marked(&page);
    let parts = marked.split('<');
    let text: String = parts.map(|part| part.split_once('>').map_or(part, |it| it.1)).collect();
    text.replace(" ✓", "")
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
    let expected = "It is <strong>0.8</strong><span class=\"good\" role=\"img\" title=\"the check passes\" aria-label=\"the check passes\">\u{a0}✓</span> &lt;i&gt;, <strong>0.0609\u{a0}%</strong>.";
    assert_eq!(sentences(&page), expected);
}

/// Guarantee: no line breaks between a number and its error or its unit, in bold or not. Control: other spaces are plain.
#[test]
fn number_and_unit_are_on_one_line() {
    let text = "{energy.kinetic} of 3 ± 1 N/m or 5 % of 2 discs and (1 ± 2)·10⁻³ m²/s";
    let page = page(&with_answer(text));
    let expected =
        "of 3\u{a0}±\u{a0}1\u{a0}N/m or 5\u{a0}% of 2 discs and (1\u{a0}±\u{a0}2)·10⁻³\u{a0}m²/s";
    assert!(sentences(&page).ends_with(expected), "{}", sentences(&page));
    assert!(sentences(&page).contains("\u{a0}J</strong>"), "{}", sentences(&page));
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
    assert!(text.contains(" 2 further checks fail. The measured restitution is 0.8"), "{text}");
}

#[test]
fn check_that_fails_at_several_points_has_one_sentence() {
    let sweep = format!("{DROP}[sweep]\n\"model.dem.friction\" = [0.1, 0.2]\n");
    let failing = check("restitution.measured", "minimum = 0.9");
    let expected = "A check fails at both points of the sweep: the measured restitution is 0.8 at a friction of 0.1 and 0.8 at a friction of 0.2, where at least 0.9 is required.";
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

/// Guarantee: an answer states the setting that its question asks for; what a single run cannot show is said. Control: another question.
#[test]
fn settings_that_the_question_asks_for_are_in_the_answer() {
    let asked = |question: &str| answer(&format!("question = \"{question}\"\n{DROP}"));
    let measured = "he measured restitution is 0.8, equal to the theoretical 0.8.";
    let with = format!("With a restitution of 0.8, t{measured}");
    assert!(asked("Is the restitution the specified one?").starts_with(&with), "{with}");
    let text = asked("What does friction do?");
    let remark = "One run at a friction of 0 does not show what the friction changes: sweep friction to compare.";
    assert!(text.starts_with(&format!("{remark} T{measured}")), "{text}");
    let text = asked("How high does it bounce at a restitution of 0.5?");
    assert!(
        text.starts_with(&format!(
            "The run has a restitution of 0.8, not 0.5: set restitution. T{measured}"
        )),
        "{text}"
    );
    let unchosen = "The question names no quantity of the runs: these are main results of the model. A check, or the key answer, selects others.";
    let text = asked("How far does it fall?");
    assert!(text.starts_with(&format!("T{measured}")) && text.ends_with(unchosen), "{text}");
    let text = asked("How high does it bounce?");
    assert!(!text.contains(unchosen), "{text}");
    let text = asked("What is the cooling rate?");
    assert!(
        text.starts_with(&format!("The recordings do not give the cooling rate. T{measured}")),
        "{text}"
    );
}

/// Guarantee: a question for a kind of quantity, and one with yes or no as its answer, get it. Control: a question that the values do not decide.
#[test]
fn kind_of_the_question_selects_and_begins_the_answer() {
    let asked = |question: &str| answer(&format!("question = \"{question}\"\n{DROP}"));
    let text = asked("How long does the disc touch the floor?");
    assert!(text.starts_with("The duration of a contact is "), "{text}");
    let text = asked("Does the disc keep its energy?");
    assert!(text.starts_with("No: the mechanical energy falls by 73.4 % in 0.6 s."), "{text}");
    let text = asked("Has the disc much energy?");
    assert!(text.starts_with("The mechanical energy falls by"), "{text}");
    let text = asked("Do heavy discs rebound more often?");
    let remark = "One run at a mass of 0.001 kg does not compare heavy discs with others: sweep mass_kg to compare.";
    assert!(text.starts_with(remark), "{text}");
}

/// Setup: a disc in boxes of two widths, so that the packing fraction is inversely proportional to the swept key; the second run is shorter. Control: a
/// question that does not name it.
#[test]
fn quantity_of_the_question_is_the_variable_of_the_sentence() {
    let asked = |question: &str| {
        let sweep = "[sweep]\n\"model.dem.width_m\" = [0.01, 0.02]\n";
        let plot = "[[plots]]\ny = \"energy.total_change_relative\"\n";
        let manifest = format!("question = \"{question}\"\n{DROP}{sweep}{plot}");
        let folder = Folder::write(&manifest, |run| {
            let ModelConfig::Dem(dem) = &*run.model else { panic!("{run:?}") };
            let frames = drop_frames(run);
            let count = if dem.width_m.get() > 0.015 { 2 } else { frames.len() };
            frames.into_iter().take(count).collect()
        });
        analyze(&[folder.name()]).exited_with(0);
        marked(&folder.page())
    };
    let text = asked("What does the packing fraction of the box change in the energy?");
    assert!(text.contains(" at a packing fraction of 2.618·10⁻⁴"), "{text}");
    assert!(!text.contains("width"), "{text}");
    let text = asked("What does the box change in the energy?");
    assert!(text.contains(" at a width of 0.01 m"), "{text}");
}

/// Control: a plot over the sweep that the manifest requests is the first one.
#[test]
fn experiment_without_checks_and_plots_has_the_main_results_and_their_plot() {
    let text = answer(DROP);
    let expected = "The measured restitution is 0.8, equal to the theoretical 0.8. The mechanical energy falls by 73.4 % in 0.6 s.";
    assert_eq!(text, expected);
    let sweep = format!("{DROP}[sweep]\n\"model.dem.friction\" = [0.1, 0.2]\n");
    let first = |manifest: &str| {
        let page = page(manifest);
        let (_, plots) = page.split_once("<figure id=\"plot-").unwrap();
        plots.split('"').next().unwrap().to_owned()
    };
    assert_eq!(first(&sweep), "restitution_measured_vs_friction");
    let requested = "[[plots]]\ny = \"energy.total_change_relative\"\n";
    let plot = first(&format!("{sweep}{requested}"));
    assert_eq!(plot, "energy_total_change_relative_vs_friction");
    // Without a sweep, the chart is that of the main result.
    assert_eq!(first(DROP), "energy_balance");
}

/// Guarantee: a check of another quantity than the question asks for leaves the first sentence to the main result. Control: without the question's words
/// in the main result, the check is first.
#[test]
fn main_result_answers_where_the_check_misses_the_question() {
    let check = check("energy.kinetic", "minimum = 0");
    let asked = |question: &str| answer(&format!("question = '{question}'\n{DROP}{check}"));
    let text = asked("What restitution has the disc?");
    assert!(
        text.starts_with(
            "With a restitution of 0.8, the measured restitution is 0.8, equal to the theoretical 0.8. The kinetic energy"
        ),
        "{text}"
    );
    let text = asked("How large is the kinetic energy?");
    assert!(
        text.starts_with("The kinetic energy after 0.6 s is")
            && text.contains(" The mechanical energy falls by"),
        "{text}"
    );
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
    let expected =
        "The measured restitution is 0.8 at a friction of 0.1 and 0.8 at a friction of 0.2.";
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
    assert!(folder.page().contains("<h1 class=\"question\">How high?</h1>"));
}

/// Three runs, of which the last has no recording.
fn with_a_missing_run(manifest: &str) -> String {
    let sweep = "[sweep]\n\"model.dem.friction\" = [0.1234567890123, 0.2, 0.3]\n";
    let folder = Folder::write(&format!("{manifest}{sweep}"), drop_frames);
    std::fs::remove_file(folder.file(2)).unwrap();
    analyze(&[folder.name()]);
    flat(&marked(&folder.page()).replace("<strong>", "").replace("</strong>", ""))
}

/// Control: without a missing run, no sentence counts runs (the other tests of this file).
#[test]
fn missing_runs_of_a_sweep_are_counted_in_the_sentence() {
    let stated = with_a_missing_run(&with_answer("It is {restitution.measured @ friction = 0.2}."));
    assert_eq!(stated, "It is 0.8. This is from 2 of 3 runs.");
    let failing = check("restitution.measured", "minimum = 0.9");
    let composed = with_a_missing_run(&format!("{DROP}{failing}"));
    assert!(composed.ends_with(" This is from 2 of 3 runs."), "{composed}");
    // The numbers of coordinates have at most six digits.
    assert!(
        composed.contains("at a friction of 0.123457") && !composed.contains("0.1234567"),
        "{composed}"
    );
}

/// Setup: pressures c T of four replicates at four temperatures, c in 1e-21 N/(m K); one recording is missing. The slope is the mean of those of the three
/// replicates that have all points, 1, 2 and 3, with the error 1/sqrt(3).
#[test]
fn number_of_a_fit_is_the_same_in_the_answer_and_in_the_plot() {
    const SWEEP: &str =
        "[model.gas]\nparticles = 1\n[sweep]\nmodel.gas.temperature_k = [100, 200, 300, 400]\n";
    let answer =
        "answer = 'It grows by {pressure_vs_temperature.measured.slope}.'\nreplicates = 4\n";
    let plots = "[[plots]]\ny = 'pressure.measured'\nfit = 'linear'\nlog = []\n\
        [[plots]]\ny = 'pressure.measured'\nfit = 'power'\n";
    let frames = |exponent: fn(f64) -> f64| {
        move |run: &RunManifest| {
            let ModelConfig::Gas(gas) = &*run.model else { panic!("{run:?}") };
            let SpeedScale::Temperature(kelvin) = gas.speed_scale else { panic!("{gas:?}") };
            let c = f64::from(run.replicate + 1);
            let value = 1e-21 * c * libm::pow(kelvin.get(), exponent(c));
            two_frames(&GasPressure {
                measured_since_start_n_per_m: value,
                ..GasPressure::default()
            })
        }
    };
    let folder = Folder::write(&format!("{answer}{SWEEP}{plots}"), frames(|_| 1.0));
    std::fs::remove_file(folder.file(3)).unwrap();
    analyze(&[folder.name()]).exited_with(0);
    let page = folder.page();
    let expected = "It grows by <strong>(2.00 ± 0.58)·10⁻²¹ N/(m K)</strong> (from 12 of 16 runs).";
    assert_eq!(marked(&page), expected);
    assert!(page.contains("fit, slope (2.00 ± 0.58)·10⁻²¹"), "{}", marked(&page));
    // A fit that no metric has, from the replicates as well: exponents 1, 2, 3 and 4.
    let folder = Folder::write(&format!("{answer}{SWEEP}{plots}"), frames(|c| c));
    analyze(&[folder.name()]).exited_with(0);
    assert!(folder.page().contains("fit, exponent 2.50 ± 0.65"));
}

/// Setup: four replicates; mean 1.59155 and error 0.000065 in units of 1e-24 N/m; a particle of 1 m/s in place of all 1000 of 1e-26 kg, so that
/// N m v²/(2 A) is 1e-23/(2π) N/m.
#[test]
fn theory_has_the_digits_of_the_error_and_the_form_applies_to_a_value_with_one() {
    let answer = "{pressure.measured}; {pressure.measured theory}; {pressure.measured theory to 2 digits}; {pressure.measured to 3 digits}; {pressure.measured to 8 digits}";
    let manifest = format!("answer = '{answer}'\nreplicates = 4\n[model.gas]\nparticles = 1000\n");
    let folder = Folder::write(&manifest, |run| {
        let value = [1.5914, 1.5915, 1.5916, 1.5917][run.replicate as usize] * 1e-24;
        two_frames(&GasPressure { measured_since_start_n_per_m: value, ..GasPressure::default() })
    });
    analyze(&[folder.name()]).exited_with(0);
    let text = marked(&folder.page()).replace("<strong>", "").replace("</strong>", "");
    let expected = "(1.591550 ± 0.000065)·10⁻²⁴ N/m; 1.591549·10⁻²⁴ N/m; 1.6·10⁻²⁴ N/m; 1.59·10⁻²⁴ N/m; (1.5915500 ± 0.0000645)·10⁻²⁴ N/m";
    assert_eq!(text, expected);
}

/// Setup: four replicates with a mean of 1.59155 and an error of 0.000065 in units of 1e-24 N/m. Control: an expected value within three
/// errors.
#[test]
fn check_that_passes_by_its_tolerance_alone_states_it() {
    let passed = |expected: &str| {
        let check =
            check("pressure.measured", &format!("expected = {expected}\nrelative_tolerance = 0.1"));
        let manifest = format!(
            "answer = '{{pressure.measured}}'\nreplicates = 4\n[model.gas]\nparticles = 1000\n{check}"
        );
        let folder = Folder::write(&manifest, |run| {
            let value = [1.5914, 1.5915, 1.5916, 1.5917][run.replicate as usize] * 1e-24;
            two_frames(&GasPressure {
                measured_since_start_n_per_m: value,
                ..GasPressure::default()
            })
        });
        analyze(&[folder.name()]).exited_with(0);
        marked(&folder.page())
    };
    let (text, control) = (passed("1.5e-24"), passed("1.5915e-24"));
    assert!(
        text.ends_with("✓</span><span class=\"good\"> within 10 % of 1.5·10⁻²⁴ N/m</span>"),
        "{text}"
    );
    assert!(control.ends_with("✓</span>"), "{control}");
}

/// Setup: pressures 1, 2 and 4, 1, 3 and 2, and 1, 1.001 and 1.002 in units of 1e-24 N/m at three temperatures. The first temperature is
/// half of the second one and a quarter of the third.
#[test]
fn sentences_about_a_sweep_begin_with_the_dependence() {
    let answer = |values: [f64; 3]| {
        let sweep =
            "[model.gas]\nparticles = 1\n[sweep]\nmodel.gas.temperature_k = [100, 200, 400]\n";
        let folder = Folder::write(sweep, |run| {
            let ModelConfig::Gas(gas) = &*run.model else { panic!("{run:?}") };
            let SpeedScale::Temperature(kelvin) = gas.speed_scale else { panic!("{gas:?}") };
            let value = match kelvin.get() {
                100.0 => values[0],
                200.0 => values[1],
                _ => values[2],
            };
            two_frames(&GasPressure {
                measured_since_start_n_per_m: 1e-24 * value,
                ..GasPressure::default()
            })
        });
        analyze(&[folder.name()]).exited_with(0);
        let page = folder.page();
        // The number below the plot has its unit.
        let (_, remark) = page.split_once("\"remark\":\"fitted slope ").unwrap();
        assert!(remark.split('"').next().unwrap().ends_with(" N/(m K)"), "{remark:.40}");
        marked(&page).replace("<strong>", "").replace("</strong>", "")
    };
    let text = answer([1.0, 2.0, 4.0]);
    let proportional =
        "The pressure on the wall is proportional to the temperature, from (1.0000 ± ";
    assert!(text.starts_with(proportional), "{text}");
    let text = answer([1.0, 1.001, 1.002]);
    let small = "The pressure on the wall hardly depends on the temperature, from (1.0000 ± ";
    assert!(text.starts_with(small), "{text}");
    let text = answer([1.0, 3.0, 2.0]);
    assert!(text.starts_with("The pressure on the wall is (1.0000 ± "), "{text}");
    assert!(
        text.contains("at a temperature of 400 K, greatest at a temperature of 200 K, but"),
        "{text}"
    );
}

#[test]
fn missing_value_has_the_reason_of_its_metric() {
    // The metric's own, in several replicates.
    let text = answer(&format!("replicates = 2\n{}", with_answer("It is {bed.surface_angle}.")));
    assert!(text.contains("(no value: ") && !text.contains("which have no mean"), "{text}");
    // That of its fit.
    let answer = "answer = 'It falls with {pressure_vs_radius.measured.exponent}.'\n";
    let sweep = "[model.gas]\nparticles = 1\n[sweep]\nmodel.gas.radius_m = [1, 2]\n";
    let folder =
        Folder::write(&format!("{answer}{sweep}"), |_| two_frames(&GasPressure::default()));
    analyze(&[folder.name()]).exited_with(0);
    let reason = "(no value: no replicate has a pressure on the wall above zero at every point)";
    assert!(marked(&folder.page()).contains(reason), "{}", marked(&folder.page()));
    // That of its channel.
    let manifest = "answer = '{wall_collision_rate}'\n[model.gas]\nparticles = 1\n[record]\nchannels = [\"state\", \"pressure\"]\n";
    let folder = Folder::write(manifest, |_| two_frames(&GasPressure::default()));
    analyze(&[folder.name()]).exited_with(0);
    let reason = "(no value: the channel /collisions is not recorded)";
    assert!(marked(&folder.page()).contains(reason), "{}", marked(&folder.page()));
}

#[test]
fn failure_is_short_in_the_sentence_and_whole_in_the_table() {
    let manifest = with_answer("It is {restitution.measured}.");
    let folder = Folder::write(&manifest, drop_frames);
    let experiment = parse(&manifest, "m.toml", &[]).unwrap();
    let run = &experiment.runs[0];
    let whole = "Blow-up at step 1234567 (t = 1.2345678901234567e-3 s): disc 3 left the box, at (-1.234567890123e300, 0.5) m. The contacts are too soft.";
    let fault = Outcome::Fault(whole.to_owned());
    write_run(&folder.file(0), run, &drop_frames(&run.manifest), &fault);
    analyze(&[folder.name()]).exited_with(3);
    let page = folder.page();
    let short = "(no value: the run failed at 0.6 s: Blow-up at step 1234567 (t = 0.00123457·s): disc 3 left the box, at (-1.23457·10³⁰⁰, 0.5) m)".replace("·s", " s");
    assert!(marked(&page).contains(&short), "{}", marked(&page));
    assert!(page.contains(whole), "the whole text is on the page");
}

/// Setup: the second run ends before the rebound, so that it has no restitution.
#[test]
fn points_without_the_metric_are_counted() {
    let manifest = format!(
        "{DROP}[sweep]\n\"model.dem.friction\" = [0.1, 0.2]\n[[plots]]\ny = \"restitution.measured\"\n"
    );
    let folder = Folder::write(&manifest, |run| {
        let ModelConfig::Dem(dem) = &*run.model else { panic!("{run:?}") };
        let frames = drop_frames(run);
        let count = if dem.friction.get() > 0.15 { 2 } else { frames.len() };
        frames.into_iter().take(count).collect()
    });
    analyze(&[folder.name()]).exited_with(0);
    let page = folder.page();
    let text = marked(&page);
    assert!(text.contains(" 1 of 2 points has no value."), "{text}");
}

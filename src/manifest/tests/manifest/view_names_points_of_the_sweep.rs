//! Guarantee: `[view]` names a time, a meaning of the color, particles, and two points of the sweep that exist; a key that changes no picture is an error at
//! its line. The table does not affect the run key, and the record of the experiment contains it.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::verdicts::{errors, experiment, rejected};
use kinetoscope_manifest::{
    ExperimentRecord, Override, ViewColor, ViewFrame, ViewRequest, parse, parse_run, run_key,
};

const SWEEP: &str = "[model.gas]\n[sweep]\nmodel.gas.temperature_k = [200.0, 250.0, 300.0]\n";

/// The Sun and two test particles.
const BODIES: &str = "[model.orbit]\nbodies = [{ gm_au3_per_day2 = 3e-4, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }, \
    { gm_au3_per_day2 = 0, semi_major_axis_au = 1, eccentricity = 0 }, { gm_au3_per_day2 = 0, semi_major_axis_au = 2, eccentricity = 0 }]\n";

#[test]
fn view_is_read_and_recorded() {
    let view = "[view]\nposter = 0.5\ncolor = \"side\"\nframe = \"rotating\"\nnames = [\"Sun\", \"\"]\ncompare = [{ time_step_days = 0.2 }, { time_step_days = 0.3 }]\n";
    let experiment = experiment(&format!(
        "{BODIES}[sweep]\n\"model.orbit.time_step_days\" = [0.1, 0.2, 0.3]\n{view}"
    ));
    assert_eq!((experiment.view.poster, experiment.view.color), (Some(0.5), Some(ViewColor::Side)));
    assert_eq!(experiment.view.frame, Some(ViewFrame::Rotating));
    assert_eq!(experiment.view.names, ["Sun", ""]);
    let compared = experiment.runs.iter().map(|run| experiment.view.compared(&run.coordinates));
    assert_eq!(compared.collect::<Vec<_>>(), [None, Some(0), Some(1)]);
    let text = ExperimentRecord::new(&experiment, []).to_toml();
    let back = ExperimentRecord::from_toml(&text, "experiment.toml").unwrap();
    assert_eq!(back.view, Some(experiment.view), "{text}");
    // Without the table, there is none in the record.
    let without = ExperimentRecord::new(&crate::verdicts::experiment(SWEEP), []).to_toml();
    assert!(!without.contains("[view]"), "{without}");
    let back = ExperimentRecord::from_toml(&without, "experiment.toml").unwrap();
    assert_eq!(back.view.unwrap_or_default(), ViewRequest::default());
}

/// Guarantee: a variant that is named by a number is shown with its quantity; its place in the sweep keeps its name.
/// Bad input: a quantity of the variants that no menu can show.
#[test]
fn quantity_of_variants_is_a_short_text() {
    for quantity in ["", " ", "two\\nlines", "\\u001b[31mred", &"x".repeat(41)] {
        let text = format!(
            "[model.gas]\n[[sweep.variants]]\nname = \"1\"\nmodel.gas.radius_m = 1.0\n[view]\nvariants = \"{quantity}\"\n"
        );
        assert!(errors(&text).to_string().contains("must be 1 to 40 characters"), "{quantity:?}");
    }
}

#[test]
fn quantity_of_variants_precedes_their_names() {
    let experiment = experiment(
        "[model.gas]\n[[sweep.variants]]\nname = \"0.5\"\nmodel.gas.radius_m = 0.5\n[[sweep.variants]]\nname = \"1\"\nmodel.gas.radius_m = 1.0\n[view]\nvariants = \"radius\"\n",
    );
    let place = &experiment.runs[0].coordinates;
    assert_eq!(experiment.view.named(place)[0].value, "radius 0.5");
    assert_eq!(place[0].value, "0.5");
    assert_eq!(ViewRequest::default().named(place), **place, "control");
    let text = ExperimentRecord::new(&experiment, []).to_toml();
    let back = ExperimentRecord::from_toml(&text, "experiment.toml").unwrap();
    assert_eq!(back.view, Some(experiment.view), "{text}");
}

#[test]
fn wrong_values_are_reported() {
    for (line, message) in [
        ("poster = -1.0 # <-", "must be a number >= 0"),
        ("color = \"spedd\" # <-", "did you mean \"speed\"?"),
        ("compare = [{ temperature_k = 250 }] # <-", "does not name two points of the sweep"),
        ("frame = \"rotated\" # <-", "must be one of \"fixed\", \"rotating\""),
        ("color = \"speces\" # <-", "did you mean \"species\"?"),
        ("compare = 3 # <-", "does not name two points of the sweep"),
        ("compare = [{ temperature_k = 251 }, { temperature_k = 300 }] # <-", "has no point"),
        ("compare = [{ temprature_k = 250 }, { temperature_k = 300 }] # <-", "is not swept"),
    ] {
        rejected(&format!("{SWEEP}[view]\n{line}\n"), message);
    }
}

#[test]
fn keys_without_effect_are_rejected_at_their_place() {
    let long = format!("names = [\"{}\"] # <-", "x".repeat(5000));
    let two_species = "[model.gas]\nadditional_masses_kg = [4e-26]\n";
    for (model, line, message) in [
        // The gas runs for 0.1 s by default.
        (SWEEP, "poster = 0.2 # <-", "must be at most 0.1"),
        (SWEEP, "color = \"species\" # <-", "add `additional_masses_kg`"),
        (SWEEP, "variants = \"number density\" # <-", "leave it out, or add [[sweep.variants]]"),
        (SWEEP, "frame = \"rotating\" # <-", "more than two `bodies`"),
        ("[model.orbit]\n", "frame = \"rotating\" # <-", "more than two `bodies`"),
        (
            SWEEP,
            "compare = [{ temperature_k = 250 }, { temperature_k = 250.0 }] # <-",
            "name two different points",
        ),
        (SWEEP, &long, "must have at most 40"),
        (SWEEP, "names = [] # <-", "names no particle"),
        (SWEEP, "names = [\"\", \" \"] # <-", "names no particle"),
        (SWEEP, "names = [\"a\\u001b\"] # <-", "contains a control character"),
        (BODIES, "names = [\"Sun\", \"Earth\", \"Earth\"] # <-", "give name 3 another word"),
        (BODIES, "names = [\"a\", \"b\", \"c\", \"d\"] # <-", "4 names for 3 particles"),
        ("[model.orbit]\n", "names = [\"Sun\", \"Earth\"] # <-", "name the moving body only"),
    ] {
        rejected(&format!("{model}[view]\n{line}\n"), message);
    }
    // Controls: each key where it has an effect, and a run that ends after a number of events, at an unknown time.
    for (model, line) in [
        (SWEEP, "poster = 0.1"),
        (two_species, "color = \"species\""),
        (BODIES, "frame = \"rotating\"\nnames = [\"Sun\", \"\", \"Mars\"]"),
        ("[model.orbit]\n", "names = [\"Earth\"]"),
        ("[model.packing]\n", "poster = 1e6"),
    ] {
        experiment(&format!("{model}[view]\n{line}\n"));
    }
    // A shorter duration from the command line leaves the view of the manifest as it is.
    let shorter = [Override { key: "model.gas.duration_s".to_owned(), value: "0.01".to_owned() }];
    parse("[model.gas]\n[view]\nposter = 0.05\n", "m.toml", &shorter).unwrap();
}

#[test]
fn view_does_not_affect_the_run_key_and_cannot_be_set() {
    let key = |text: &str| run_key(&parse_run(text).unwrap().canonical(), 1, 1);
    assert_eq!(key("[model.gas]\n[view]\nposter = 0.05\n"), key("[model.gas]\n"));
    let set = [Override { key: "view.poster".to_owned(), value: "1".to_owned() }];
    let errors = parse("[model.gas]\n", "m.toml", &set).unwrap_err().to_string();
    assert!(errors.contains("`view.poster` cannot be set"), "{errors}");
}

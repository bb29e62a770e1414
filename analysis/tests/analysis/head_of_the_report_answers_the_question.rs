//! Guarantee: the sentence of the result has the failed checks with their reasons, else the first requested plot, else the metrics of the
//! first checks, each place in the sweep for itself, and conservation laws last, else there is none: no metric is chosen that the
//! manifest does not name. An experiment whose result is a table of run times says which command measures it.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::gas_and_dem_metrics_equal_closed_forms::{DROP, drop_frames};
use crate::synthetic::{Folder, analyze};

/// The clauses of the result, without markup.
fn result(manifest: &str) -> Vec<String> {
    let page = page(manifest);
    let (_, result) = page.split_once("<p class=\"result\">").unwrap();
    let result = result.split("</p>").next().unwrap().replace("<br>", "").replace("<wbr>", "");
    let text: String =
        result.split('<').map(|part| part.split_once('>').map_or(part, |it| it.1)).collect();
    text.split("; ").map(str::to_owned).collect()
}

/// The report of a falling disc.
fn page(manifest: &str) -> String {
    let folder = Folder::write(manifest, drop_frames);
    let output = analyze(&[folder.name()]);
    assert!([0, 3].contains(&output.code), "{}", output.text);
    folder.page()
}

fn check(metric: &str, place: &str) -> String {
    format!("[[checks]]\nmetric = \"{metric}\"\n{place}\nmaximum = 1e9\n")
}

#[test]
fn every_checked_place_has_a_clause_and_conservation_is_last() {
    let sweep = "[sweep]\n\"model.dem.friction\" = [0.1, 0.2, 0.3, 0.4, 0.5]\n";
    let at = |tenths: u32| format!("where = {{ friction = 0.{tenths} }}");
    let mut manifest = format!("{DROP}{sweep}{}", check("energy.residual_relative", &at(1)));
    for tenths in [1, 2, 2, 3] {
        manifest += &check("restitution.measured", &at(tenths));
    }
    let clauses = result(&manifest);
    assert_eq!(clauses.len(), 4, "{clauses:?}");
    for (clause, tenths) in clauses.iter().zip([1, 2, 3]) {
        let start = format!("restitution.measured at friction = 0.{tenths} = ");
        assert!(clause.contains(&start), "{clauses:?}");
    }
    assert!(clauses[3].starts_with("energy.residual_relative at "), "{clauses:?}");
    // At most four.
    for tenths in [4, 5] {
        manifest += &check("restitution.measured", &at(tenths));
    }
    let clauses = result(&manifest);
    assert!(clauses.len() == 4 && !clauses[3].starts_with("energy."), "{clauses:?}");
}

#[test]
fn missing_run_times_are_named_with_their_command() {
    let timed = format!("# How long? Expected: long.\n# kinetoscope benchmark gas.toml\n{DROP}");
    let clauses = result(&timed);
    assert_eq!(clauses[0], "Result: none yet");
    assert!(clauses[1].contains("kinetoscope benchmark gas.toml --output"), "{clauses:?}");
    let control = result(&format!("{DROP}{}", check("restitution.measured", "")));
    assert!(control[0].starts_with("Result: restitution.measured = "), "{control:?}");
}

/// Setup: a check that fails and one that passes, and a requested plot, which are removed one after the other.
#[test]
fn result_answers_what_the_manifest_asks() {
    let passing = check("restitution.measured", "");
    let failing = "[[checks]]\nmetric = \"energy.residual_relative\"\nminimum = 1e9\n";
    let plot = "[[plots]]\ny = \"/energy.kinetic_j\"\ntitle = \"Energy of the fall\"\n";
    let clauses = result(&format!("{DROP}{passing}{failing}{plot}"));
    assert_eq!(clauses.len(), 1, "{clauses:?}");
    assert!(
        clauses[0].starts_with("Result: energy.residual_relative fails: measured "),
        "{clauses:?}"
    );
    assert!(clauses[0].contains("expected at least "), "{clauses:?}");
    assert_eq!(result(&format!("{DROP}{passing}{plot}")), ["Result: Energy of the fall."]);
    let clauses = result(&format!("{DROP}{passing}"));
    assert!(clauses[0].starts_with("Result: restitution.measured = "), "{clauses:?}");
    assert!(
        !page(DROP).contains("class=\"result\""),
        "nothing is asked, and something is answered"
    );
}

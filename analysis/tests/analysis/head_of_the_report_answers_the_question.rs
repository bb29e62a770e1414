//! Guarantee: the sentence of the result has the metrics of the first checks, each place in the sweep for itself, and conservation laws
//! last. An experiment whose result is a table of run times says which command measures it.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::gas_and_dem_metrics_equal_closed_forms::{DROP, drop_frames};
use crate::synthetic::{Folder, analyze};

/// The clauses of the result, without markup.
fn result(manifest: &str) -> Vec<String> {
    let folder = Folder::write(manifest, drop_frames);
    let output = analyze(&[folder.name()]);
    assert!([0, 3].contains(&output.code), "{}", output.text);
    let page = folder.page();
    let (_, result) = page.split_once("<p class=\"result\">").unwrap();
    let result = result.split("</p>").next().unwrap().replace("<br>", "").replace("<wbr>", "");
    let text: String =
        result.split('<').map(|part| part.split_once('>').map_or(part, |it| it.1)).collect();
    text.split("; ").map(str::to_owned).collect()
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
    assert!(result(DROP)[0].starts_with("Result: "), "control");
}

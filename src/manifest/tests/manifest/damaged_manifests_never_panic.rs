//! Guarantee: any text gives an experiment or a list of errors that can be formatted.
//!
//! Setup: prefixes, flipped bytes, lines in wrong places, and unusual texts.

// A test may panic.
#![allow(clippy::unwrap_used)]

use crate::verdicts::{errors, experiment, metrics};
use kinetoscope_manifest::{
    ExperimentRecord, Lookup, parse_checks, parse_run, parse_with, starter,
};

const MANIFEST: &str = r#"# ü: a manifest with one of everything
name = "everything"
seed = 14
replicates = 2

[model.dem]
discs = 1e1
radius_m = { min = 4e-4, max = 6e-4 }
gravity_m_per_s2 = [0.0, -9.81]
placement = "random"

[record]
every_s = 0.01
channels = ["state", "energy"]

[sweep]
zip = [["model.dem.restitution", "model.dem.stiffness_n_per_m"]]
"model.dem.restitution" = [0.5, 0.9]
model.dem.stiffness_n_per_m = { from = 1e4, to = 1e5, count = 2, spacing = "log" }
[[sweep.variants]]
name = "Verlet – λ"
"model.dem.integrator" = "velocity-verlet"
model.dem.placement = { positions_m = [[0.01, 0.01]], velocities_m_per_s = [[0.0, 0.0]] }

[[checks]]
metric = "energy.residual_relative"
expected = 0.0
tolerance = 1e-3
where = { "model.dem.restitution" = 0.5 }

[[plots]]
y = "bed.height"
x = "restitution"
log = ["x", "y"]
where = { variant = "Verlet – λ" }

[[plots]]
y = "/energy.kinetic_j"
x = "time"
title = "λ"
"#;

/// Parses a text with every entry point, formats the errors and returns their number.
fn read(text: &str) -> usize {
    let mut length = 0;
    let lookup = Lookup { metrics: Some(metrics), ..Lookup::default() };
    if let Err(errors) = parse_with(text, "m.toml", &[], lookup) {
        assert!(!errors.is_empty(), "an error list is empty\n{text}");
        length += errors.to_string().len() + errors.render(true).len();
    }
    for errors in [
        parse_run(text).err(),
        parse_checks(text, "c.toml", Some(metrics)).err(),
        ExperimentRecord::from_toml(text, "e.toml").err(),
    ] {
        length += errors.map_or(0, |errors| errors.to_string().len());
    }
    length
}

#[test]
fn control_undamaged_manifest_has_one_known_error() {
    // `discs` of the table contradicts the given placement: a true error, and the only one.
    let errors = errors(MANIFEST);
    assert!(errors.to_string().contains("`discs` is 10, but 1 are placed"), "{errors}");
    assert_eq!(errors.len(), 1, "{errors}");
    assert_eq!(experiment(&MANIFEST.replace("discs = 1e1", "")).runs.len(), 4);
}

#[test]
fn every_prefix_is_parsed_without_panic() {
    for (end, _) in MANIFEST.char_indices() {
        read(&MANIFEST[..end]);
    }
    for model in ["dem", "gas", "packing", "orbit"] {
        let text = starter(model).unwrap();
        for (end, _) in text.char_indices().step_by(7) {
            read(&text[..end]);
        }
    }
}

#[test]
fn every_flipped_byte_is_parsed_without_panic() {
    for position in 0..MANIFEST.len() {
        for flip in if position % 2 == 0 { [0x01, 0x80] } else { [0x10, 0x20] } {
            let mut bytes = MANIFEST.as_bytes().to_vec();
            bytes[position] ^= flip;
            read(&String::from_utf8_lossy(&bytes));
        }
    }
}

#[test]
fn misplaced_lines_are_parsed_without_panic() {
    let lines: Vec<&str> = MANIFEST.lines().collect();
    for moved in 0..lines.len() {
        for to in 0..lines.len() {
            let mut shuffled = lines.clone();
            let line = shuffled.remove(moved);
            shuffled.insert(to.min(shuffled.len()), line);
            read(&shuffled.join("\n"));
        }
    }
}

#[test]
fn unusual_texts_are_parsed_without_panic() {
    let deep = format!("model = {}1{}", "[".repeat(5000), "]".repeat(5000));
    let dotted = format!("{}x = 1", "a.".repeat(5000));
    let odd = [
        "",
        "\u{feff}",
        "\u{feff}[model.gas]\nradius_m = 0",
        "\0",
        "\r\n[model.gas]\r\nradius_m = 0\r\n",
        "=",
        "[",
        "[[",
        "[]",
        "[model.gas]\nradius_m",
        "model = 1",
        "model = []",
        "model.gas = 1",
        "[[model]]",
        "[[model.gas]]",
        "[model.gas]\n[[record]]",
        "sweep = 1\n[model.gas]",
        "checks = 1\n[model.gas]",
        "checks = [1, [], {}]\n[model.gas]",
        "plots = 1\n[model.gas]",
        "plots = [1, [], {}, { y = 1 }, { y = \"/\" }, { y = \"/.\", x = 2 }, { y = \"/é.\" }]\n[model.gas]",
        "[model.gas]\n[sweep]\nvariants = 1\nzip = 1",
        "[model.gas]\n[sweep]\nvariants = [1]\nzip = [1, [2]]",
        "[model.gas]\n[sweep]\nzip = [[\"a\"], []]",
        "[model.gas]\n[sweep]\nmodel = {}",
        "[model.gas]\n[sweep]\n\"\" = [1]\n\"model.\" = [1]\n\"model..\" = [2]",
        "[model.gas]\n[sweep]\nmodel.gas.radius_m = { from = -1.7e308, to = 1.7e308, count = 3 }",
        "name = \"\u{202e}\u{7f}\"",
        "\u{1f600} = 1",
        "[model.gas]\n\"\u{1f600}\u{1f600}\" = \"\u{1f600}\" # \u{1f600}",
        "[model.gas]\nplacement = {}",
        "[model.orbit]\nstart = {}",
        "[model.dem]\nradius_m = {}",
        &deep,
        &dotted,
    ];
    for text in odd {
        read(text);
    }
}

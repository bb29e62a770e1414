//! Guarantee: parser, canonical form, schema and starter manifests have the same keys, with the same units, ranges and defaults.

// A test may panic.
#![allow(clippy::unwrap_used)]

use crate::verdicts::errors;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::record::{CHANNELS, RecordConfig};
use kinetoscope_manifest::{json_schema, parse, parse_run, starter};
use serde_json::Value as Json;
use std::collections::BTreeSet;

fn schema() -> Json {
    serde_json::from_str(&json_schema()).unwrap()
}

/// All tables of the schema whose keys have units, by dotted path.
fn tables(schema: &Json) -> Vec<(String, &Json)> {
    let mut tables: Vec<(String, &Json)> = ModelConfig::NAMES
        .iter()
        .map(|name| (format!("model.{name}"), &schema["properties"]["model"]["properties"][name]))
        .collect();
    tables.push(("record".to_owned(), &schema["properties"]["record"]));
    tables
}

fn keys(table: &Json) -> BTreeSet<String> {
    table["properties"].as_object().unwrap().keys().cloned().collect()
}

/// A manifest with one line in a table; `[record]` requires a model in addition.
fn with_line(table: &str, line: &str) -> String {
    let model = if table == "record" { "[model.dem]\n" } else { "" };
    format!("{model}[{table}]\n{line}\n")
}

/// The known keys that the parser lists for an unknown key.
fn known_keys(manifest: &str) -> BTreeSet<String> {
    let errors = errors(manifest).to_string();
    let (_, known) = errors.split_once("known keys: ").expect("the error must list the known keys");
    known.lines().next().unwrap().split(", ").map(str::to_owned).collect()
}

#[test]
fn parser_and_schema_have_the_same_keys() {
    let schema = schema();
    for (path, table) in tables(&schema) {
        assert_eq!(known_keys(&with_line(&path, "qqqqqqqqqqqqqqqq = 1")), keys(table), "{path}");
        assert_eq!(table["additionalProperties"], false, "{path}");
    }
    assert_eq!(known_keys("qqqqqqqqqqqqqqqq = 1\n[model.gas]\n"), keys(&schema));
    let check = "[model.gas]\n[[checks]]\nmetric = \"a\"\nminimum = 1\nqqqqqqqqqqqqqqqq = 1\n";
    assert_eq!(known_keys(check), keys(&schema["properties"]["checks"]["items"]));
    let plot = "[model.gas]\n[[plots]]\ny = \"/energy.kinetic_j\"\nqqqqqqqqqqqqqqqq = 1\n";
    assert_eq!(known_keys(plot), keys(&schema["properties"]["plots"]["items"]));
    let view = "[model.gas]\n[view]\nqqqqqqqqqqqqqqqq = 1\n";
    assert_eq!(known_keys(view), keys(&schema["properties"]["view"]));
    let baseline = "[model.gas]\n[[baseline]]\nmetric = \"a2\"\nrelative_tolerance = 1\nqqqqqqqqqqqqqqqq = 1\n";
    assert_eq!(known_keys(baseline), keys(&schema["properties"]["baseline"]["items"]));
    let exercise = "[model.gas]\n[exercise]\nname = \"a/b\"\nqqqqqqqqqqqqqqqq = 1\n";
    assert_eq!(known_keys(exercise), keys(&schema["properties"]["exercise"]));
}

/// Keys without a default, by name or, where another model has one, by path.
const NO_DEFAULT: &[&str] = &[
    "bodies",
    "start_from",
    "additional_masses_kg",
    "position_distribution",
    "temperature_schedule",
    "wall_speed_m_per_s",
    "wall_temperature_k",
    "accommodation_coefficient",
    "orifice_width_m",
    "model.gas.gravity_m_per_s2",
    "partition_x_m",
    "partition_opens_s",
    "partition_side",
    "disc_radius_m",
    "speeds_m_per_s",
    "damping_n_s_per_m",
    "youngs_modulus_pa",
    "poisson_ratio",
    "tangential_law",
    "remove_below_m",
    "placement_region_m",
    "materials",
    "contact_pairs",
    "cohesion_n",
    "insertion",
    "velocity_std_m_per_s",
    "contact_time",
    "cutoff_velocity",
    "target_reduced_pressure",
    "model.packing.gravity",
    "floor_temperature",
    "floor_stroke",
    "floor_period",
    "obstacles",
    "time_step_s",
    "max_speed_m_per_s",
    "duration",
    "every_s",
    "every_days",
    "every_time",
    "every_steps",
    "every_collisions",
    "frames_per_decade",
    "decades",
    "keep",
    "keyframe_distance",
    "draw_every",
    "channels",
    "name",
    "description",
    "replicates",
];

#[test]
fn every_key_has_a_description_unit_range_and_default() {
    /// Keys without a default: alternatives to another key, or optional settings.
    /// The unit that the suffix of a key states.
    const ENDS: [(&str, &str); 15] = [
        ("_pa", "Pa"),
        ("_m_per_s2", "m/s^2"),
        ("_m_per_s", "m/s"),
        ("_n_per_m", "N/m"),
        ("_n_s_per_m", "N s/m"),
        ("_kg", "kg"),
        ("_rad2", "rad^2"),
        ("_days", "d"),
        ("_k", "K"),
        ("_m", "m"),
        ("_s", "s"),
        ("discs", "none, a pure number"),
        ("particles", "none, a pure number"),
        ("restitution", "none, a pure number"),
        ("frames", "none, a pure number"),
    ];
    let schema = schema();
    for (path, table) in tables(&schema) {
        for (key, about) in table["properties"].as_object().unwrap() {
            let description = about["description"].as_str().unwrap_or_default();
            assert!(description.len() > 12, "{path}.{key} has no description");
            if let Some((_, unit)) = ENDS.iter().find(|(end, _)| key.ends_with(end)) {
                assert!(
                    description.ends_with(&format!(" Unit: {unit}.")),
                    "{path}.{key}: {description}"
                );
            }
            let says_range = ["type", "enum", "anyOf"].iter().any(|word| about.get(word).is_some());
            assert!(says_range, "{path}.{key} has no range");
            let default = about.get("default").is_some();
            let has_none = [key.as_str(), &format!("{path}.{key}")]
                .iter()
                .any(|name| NO_DEFAULT.contains(name));
            assert_eq!(default, !has_none, "{path}.{key}");
        }
    }
}

#[test]
fn parser_and_schema_have_the_same_ranges() {
    /// Above this limit, a float may not represent every integer; the rules of `seed` test the largest integers.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    let schema = schema();
    let mut tried = 0;
    for (path, table) in tables(&schema) {
        for (key, about) in table["properties"].as_object().unwrap() {
            let refuses = |value: f64, wanted: bool| {
                let manifest = with_line(&path, &format!("{key} = {value:?}"));
                let errors = parse(&manifest, "m.toml", &[]).err().map(|errors| errors.to_string());
                let text = errors.as_deref().unwrap_or("");
                let out =
                    text.contains(&format!("`{path}.{key}` is ")) && text.contains("out of range");
                assert_eq!(out, wanted, "{manifest}{errors:?}");
            };
            let mut bound = |word: &str, allowed: bool, beyond: f64| {
                if let Some(bound) = about[word].as_f64().filter(|bound| *bound <= EXACT) {
                    refuses(bound, !allowed);
                    refuses(bound + beyond * (1.0 + bound.abs()) * 1e-9, true);
                    tried += 1;
                }
            };
            bound("minimum", true, -1.0);
            bound("maximum", true, 1.0);
            bound("exclusiveMinimum", false, -1.0);
            bound("exclusiveMaximum", false, 1.0);
        }
    }
    assert!(tried > 30, "only {tried} bounds");
}

#[test]
fn parser_accepts_every_enumerated_value_of_the_schema() {
    let schema = schema();
    for (path, table) in tables(&schema) {
        for (key, about) in table["properties"].as_object().unwrap() {
            let words = about.get("enum").or_else(|| about["anyOf"][0].get("enum"));
            for word in words.and_then(Json::as_array).into_iter().flatten() {
                let manifest = with_line(&path, &format!("{key} = {word}"));
                let errors = parse(&manifest, "m.toml", &[]).err().map(|errors| errors.to_string());
                // A time step may be missing, but the value must be known.
                assert!(!errors.unwrap_or_default().contains("unknown value"), "{manifest}");
            }
        }
    }
}

#[test]
fn canonical_form_contains_every_key_of_the_schema() {
    let more = [
        "[model.dem]\ndamping_n_s_per_m = 1\ntime_step_s = 1e-6\nremove_below_m = 0\nplacement_region_m = [[0, 0], [0.01, 0.01]]\n[record]\nevery_s = 1",
        "[model.dem]\nmaterials = [{ name = \"a\" }]\ncontact_pairs = [{ between = [\"a\", \"wall\"] }]\ncohesion_n = 1\n\
         velocity_std_m_per_s = 1\ninsertion = { discs = 1, discs_per_s = 1, from_m = [0.01, 0.01], to_m = [0.02, 0.01], \
         velocity_m_per_s = [0, -1] }",
        "[model.gas]\nspeed_distribution = \"uniform\"\nmax_speed_m_per_s = 1\npropagation = \"time-stepped\"\ntime_step_s = 1e-6\n[record]\nevery_steps = 1",
        "[model.packing]\nduration = 1\n[record]\nevery_time = 1\nchannels = []",
        "[model.packing]\ncontact_time = 1\ntarget_reduced_pressure = 1\n[record]\nevery_collisions = 1",
        "[model.packing]\ngravity = 1\nfloor_temperature = 1",
        "[model.packing]\ngravity = 1\nfloor_stroke = 1\nfloor_period = 1",
        "[model.packing]\nobstacles = { positions = [[0, 0]], radius = 1 }",
        "[model.packing]\ncutoff_velocity = 1\n[record]\nframes_per_decade = 1",
        "[model.orbit]\n[record]\nevery_days = 1",
        "[model.orbit]\nbodies = [{ gm_au3_per_day2 = 1, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }, \
         { gm_au3_per_day2 = 0, position_au = [1, 0, 0], velocity_au_per_day = [0, 1, 0] }]",
        "[model.gas]\nadditional_masses_kg = [1]\nposition_distribution = \"uniform-in-radius\"\ntemperature_schedule = [[0.1, 1]]\n\
         wall_speed_m_per_s = 1\nwall_temperature_k = 1\naccommodation_coefficient = 1\norifice_width_m = 1",
        "[model.dem]\nyoungs_modulus_pa = 1e9\npoisson_ratio = 0.2\ntangential_law = \"mindlin\"",
        "[model.gas]\ngravity_m_per_s2 = 1",
        "[model.gas]\npartition_x_m = 0\npartition_opens_s = 0.01\npartition_side = \"left\"",
        "[model.dem]\nstart_from = \"bed.mcap\"",
        "[model.gas]\nstart_from = \"gas.mcap\"",
        "[model.packing]\nstart_from = \"packing.mcap\"",
        "[model.orbit]\nstart_from = \"orbit.mcap\"",
        "[model.gas]\ndisc_radius_m = 0.01\nspeeds_m_per_s = [1]",
        "[model.dem]\n[record]\nkeep = \"keyframes\"\ndraw_every = 2",
        "[model.gas]",
    ];
    let mut written = BTreeSet::new();
    for manifest in more {
        let mut table = String::new();
        for line in parse_run(manifest).unwrap().canonical().lines() {
            if let Some(header) = line.strip_prefix('[') {
                table = header.trim_end_matches(']').to_owned();
            } else if let Some((key, _)) = line.split_once(" = ").filter(|_| !table.is_empty()) {
                written.insert(format!("{table}.{key}"));
            }
        }
    }
    let schema = schema();
    let described: BTreeSet<String> = tables(&schema)
        .into_iter()
        .flat_map(|(path, table)| keys(table).into_iter().map(move |key| format!("{path}.{key}")))
        .collect();
    assert_eq!(written, described);
}

#[test]
fn starters_contain_every_key_with_its_default() {
    let schema = schema();
    for name in ModelConfig::NAMES {
        let text = starter(name).unwrap();
        let experiment =
            parse(text, "starter.toml", &[]).unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!(experiment.runs.len(), 1);
        let manifest = &experiment.runs[0].manifest;
        assert_eq!(Some(&*manifest.model), ModelConfig::with_defaults(name).as_ref());
        assert_eq!(*manifest.record, RecordConfig::default());
        let is_shown = |key: &str| {
            text.lines().any(|line| line.trim_start_matches("# ").starts_with(&format!("{key} = ")))
        };
        for key in keys(&schema["properties"]["model"]["properties"][name]) {
            assert!(is_shown(&key), "{name}: {key}");
        }
        for table in ["checks", "plots", "view", "baseline", "sweep"] {
            let table = &schema["properties"][table];
            let table = table.get("items").unwrap_or(table);
            // The tables of a sweep's keys are dotted names without quotes.
            let keys = keys(table).into_iter().filter(|key| !matches!(&**key, "model" | "record"));
            for key in keys {
                assert!(text.contains(&format!("{key} = ")), "{name}: {key}");
            }
        }
        for channel in CHANNELS.iter().find(|(model, _)| *model == name).unwrap().1 {
            assert!(text.contains(channel), "{name}: {channel}");
        }
        // The sweep and the checks in the comments must be valid.
        let (_, examples) = text.split_once("# [").unwrap();
        let uncomment = |line: &str| line.strip_prefix("# ").unwrap_or(line).to_owned();
        let lines = format!("# [{examples}");
        let examples = lines.lines().map(uncomment).collect::<Vec<_>>().join("\n");
        let whole = format!("[model.{name}]\n{examples}");
        parse(&whole, "starter.toml", &[]).unwrap_or_else(|errors| panic!("{errors}\n{whole}"));
    }
    // The keys of a state that is written out are in no table of the schema.
    for key in [
        "gm_au3_per_day2",
        "position_au",
        "velocity_au_per_day",
        "semi_major_axis_au",
        "eccentricity",
        "inclination_rad",
        "longitude_of_ascending_node_rad",
        "argument_of_perihelion_rad",
        "true_anomaly_rad",
        "mean_anomaly_rad",
        "gm_au3_per_day2 = 0: a test particle",
    ] {
        assert!(starter("orbit").unwrap().contains(key), "{key}");
    }
    assert_eq!(starter("gass"), None);
}

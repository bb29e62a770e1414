//! Guarantee: the comparison of two canonical manifests lists exactly the differing keys, with the names of their tables.

use kinetoscope_manifest::{differing_keys, parse_run};

fn canonical(manifest: &str) -> String {
    parse_run(manifest).unwrap_or_else(|errors| panic!("{errors}")).canonical()
}

#[test]
fn equal_runs_have_no_differing_key() {
    // A manifest with explicit default values describes the same run.
    let one = canonical("[model.orbit]\n");
    let other =
        canonical("seed = 0\nname = \"other\"\n[model.orbit]\nintegrator = \"velocity-verlet\"\n");
    assert_eq!(differing_keys(&one, &other), []);
}

#[test]
fn differing_keys_have_their_table_and_both_values() {
    let one = canonical("seed = 1\n[model.gas]\nradius_m = 2.0\n[record]\nframes = 10\n");
    let other = canonical("seed = 2\n[model.gas]\n[record]\nevery_s = 0.01\n");
    let differing: Vec<String> =
        differing_keys(&one, &other).iter().map(ToString::to_string).collect();
    let expected = [
        "seed: 1 → 2",
        "model.gas.radius_m: 2.0 → 1.0",
        "record.frames: 10 → (none)",
        "record.every_s: (none) → 0.01",
    ];
    assert_eq!(differing, expected);
}

#[test]
fn long_values_are_shortened_only_in_the_message() {
    let positions: Vec<String> = (0..40).map(|index| format!("[0.0{index}, 0.0]")).collect();
    let place = |positions: &str| {
        canonical(&format!(
            "[model.gas]\nparticles = 40\nplacement = {{ positions_m = [{positions}], velocities_m_per_s = [{}] }}\n",
            vec!["[1.0, 0.0]"; 40].join(", ")
        ))
    };
    let one = place(&positions.join(", "));
    let other = place(&positions.join(", ").replace("[0.039, 0.0]", "[0.038, 0.01]"));
    let differing = differing_keys(&one, &other);
    assert_eq!(differing.len(), 1);
    assert!(differing[0].key.starts_with("model.gas.placement"), "{:?}", differing[0].key);
    assert_ne!(differing[0].left, differing[0].right);
    let text = differing[0].to_string();
    assert!(text.len() < 200 && text.contains("→ … 0.038, 0.01]"), "{text}");
}

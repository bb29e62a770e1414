//! Guarantee: a sweep expands to every combination of its axes; the first axis in the file varies slowest, replicates vary fastest.

// A test may panic.
#![allow(clippy::unwrap_used)]

use crate::verdicts::{errors, experiment};
use kinetoscope_manifest::model::{ModelConfig, OrbitIntegrator};
use kinetoscope_manifest::{Axis, Experiment, run_key};

/// The values of all coordinates of each run, with the replicate.
fn points(experiment: &Experiment) -> Vec<String> {
    let place = |run: &kinetoscope_manifest::Run| {
        let values: Vec<&str> = run.coordinates.iter().map(|c| c.value.as_str()).collect();
        format!("{} r{}", values.join(" "), run.replicate)
    };
    experiment.runs.iter().map(place).collect()
}

fn temperatures(experiment: &Experiment) -> Vec<String> {
    experiment.runs.iter().map(|run| run.coordinates[0].value.clone()).collect()
}

#[test]
fn axes_are_combined_and_the_first_varies_slowest() {
    let experiment = experiment(
        "replicates = 2\nseed = 5\n[model.gas]\ntemperature_k = 1.0\n[sweep]\n\
         \"model.gas.temperature_k\" = [300.0, 3.7315e2]\nmodel.gas.particles = [10, 1e3]\n",
    );
    assert_eq!(experiment.name, "m");
    assert_eq!(
        points(&experiment),
        [
            "300 10 r0",
            "300 10 r1",
            "300 1000 r0",
            "300 1000 r1",
            "373.15 10 r0",
            "373.15 10 r1",
            "373.15 1000 r0",
            "373.15 1000 r1",
        ]
    );
    // Sweep points share the seed; replicates differ only by their number.
    assert!(experiment.runs.iter().all(|run| run.manifest.seed == 5));
    let last = experiment.runs.last().unwrap();
    assert_eq!(last.manifest.replicate, 1);
    assert!(last.manifest.canonical().contains("particles = 1000\n"));
    assert!(last.manifest.canonical().contains("temperature_k = 373.15\n"));
    let key = run_key(&last.manifest.canonical(), 1, 1);
    assert_eq!(
        last.file_stem(&experiment.name, &key, experiment.replicates),
        format!("m__temperature_k=373.15__particles=1000__r001__{}", key.short())
    );
    assert_eq!(
        last.file_stem(&"long".repeat(40), &key, experiment.replicates),
        format!("{}__{key}", "long".repeat(40))
    );
}

#[test]
fn dotted_keys_need_no_quotes() {
    let quoted = experiment(
        "[model.dem]\n[sweep]\n\"model.dem.radius_m.min\" = [1e-4]\n\"model.dem.radius_m.max\" = [2e-4]\n",
    );
    let plain = experiment(
        "[model.dem]\n[sweep]\nmodel.dem.radius_m.min = [1e-4]\nmodel.dem.radius_m.max = [2e-4]\n",
    );
    let header =
        experiment("[model.dem]\n[sweep.model.dem.radius_m]\nmin = [1e-4]\nmax = [2e-4]\n");
    assert_eq!(quoted, plain);
    assert_eq!(quoted, header);
    assert!(quoted.runs[0].manifest.canonical().contains("{ min = 0.0001, max = 0.0002 }"));
}

#[test]
fn ranges_contain_their_ends_and_decades_exactly() {
    let range = |range: &str| {
        temperatures(&experiment(&format!(
            "[model.gas]\n[sweep]\n\"model.gas.temperature_k\" = {range}\n"
        )))
    };
    assert_eq!(range("{ from = 0.1, to = 0.5, count = 5 }"), ["0.1", "0.2", "0.3", "0.4", "0.5"]);
    assert_eq!(
        range("{ from = 1e-3, to = 1e2, count = 6, spacing = \"log\" }"),
        ["0.001", "0.01", "0.1", "1", "10", "100"]
    );
    // 2^(-1/3) and 2^(1/3) to 16 digits.
    assert_eq!(
        range("{ from = 0.5, to = 2.0, count = 4, spacing = \"log\" }"),
        ["0.5", "0.7937005259840998", "1.2599210498948732", "2"]
    );
    assert_eq!(range("{ from = 300, to = 100, count = 3 }"), ["300", "200", "100"]);
}

#[test]
fn ranges_of_counts_are_rounded_to_integers() {
    let packing = experiment(
        "[model.packing]\n[sweep]\nmodel.packing.discs = { from = 5, to = 50, count = 10 }\n",
    );
    assert_eq!(temperatures(&packing), ["5", "10", "15", "20", "25", "30", "35", "40", "45", "50"]);
    let gas = experiment(
        "[model.gas]\n[sweep]\nmodel.gas.particles = { from = 10, to = 1000, count = 5, spacing = \"log\" }\n",
    );
    assert_eq!(temperatures(&gas), ["10", "32", "100", "316", "1000"]);
}

#[test]
fn zipped_axes_vary_together() {
    let experiment = experiment(
        "[model.gas]\n[sweep]\nzip = [[\"model.gas.mass_kg\", \"model.gas.temperature_k\"]]\n\
         model.gas.temperature_k = [1, 2]\nmodel.gas.radius_m = [3, 4]\nmodel.gas.mass_kg = [5, 6]\n",
    );
    assert_eq!(points(&experiment), ["5 1 3 r0", "5 1 4 r0", "6 2 3 r0", "6 2 4 r0"]);
    assert_eq!(
        experiment.axes[0],
        Axis {
            keys: vec!["model.gas.mass_kg".to_owned(), "model.gas.temperature_k".to_owned()],
            values: vec![
                vec!["5".to_owned(), "1".to_owned()],
                vec!["6".to_owned(), "2".to_owned()]
            ],
        }
    );
}

#[test]
fn variants_form_one_axis() {
    let experiment = experiment(
        "[model.orbit]\nintegrator = \"explicit-euler\"\ntime_step_days = 0.5\n[sweep]\nmodel.orbit.duration_days = [10, 20]\n\
         [[sweep.variants]]\nname = \"explicit Euler\"\n[[sweep.variants]]\nname = \"RK4\"\n\
         \"model.orbit.integrator\" = \"rk4\"\nmodel.orbit.time_step_days = 0.25\n",
    );
    assert_eq!(
        points(&experiment),
        ["10 explicit Euler r0", "10 RK4 r0", "20 explicit Euler r0", "20 RK4 r0"]
    );
    assert_eq!(experiment.runs[3].coordinates[1].key, "variant");
    let step = |run: usize| match &*experiment.runs[run].manifest.model {
        ModelConfig::Orbit(orbit) => (orbit.integrator, orbit.time_step_days.get()),
        other => panic!("{other:?}"),
    };
    assert_eq!(step(2), (OrbitIntegrator::ExplicitEuler, 0.5));
    assert_eq!(step(3), (OrbitIntegrator::Rk4, 0.25));
    let key = run_key("", 1, 1);
    let stem = experiment.runs[0].file_stem("a", &key, 1);
    assert_eq!(stem, format!("a__duration_days=10__variant=explicit-Euler__{}", key.short()));
}

#[test]
fn variants_may_choose_between_exclusive_keys() {
    let experiment = experiment(
        "[model.dem]\n[[sweep.variants]]\nname = \"e\"\nmodel.dem.restitution = 0.9\n\
         [[sweep.variants]]\nname = \"eta\"\nmodel.dem.damping_n_s_per_m = 0.1\n",
    );
    assert_eq!(points(&experiment), ["e r0", "eta r0"]);
}

#[test]
fn tables_and_long_lists_are_numbered_in_names() {
    let experiment = experiment(
        "[model.dem]\n[sweep]\nmodel.dem.gravity_m_per_s2 = [[0, -9.81], [0, 0]]\n\
         model.dem.radius_m = [5e-4, { min = 4e-4, max = 6e-4 }]\n\
         model.dem.placement = [\"random\", { positions_m = [[0.01, 0.01], [0.02, 0.02], [0.03, 0.03], [0.01, 0.03]], \
         velocities_m_per_s = [[0, 0], [0, 0], [0, 0], [0, 0]] }]\n",
    );
    let points = points(&experiment);
    assert_eq!(points[0], "0_-9.81 0.0005 random r0");
    assert_eq!(points[7], "0_0 min_0.0004_max_0.0006 value-2 r0");
}

#[test]
fn errors_name_the_position_in_the_sweep() {
    let text = errors(
        "[model.gas]\n[sweep]\nmodel.gas.temperature_k = [1, -2, 3]\nmodel.gas.tmp = [1]\nseed = [1, 2]\n",
    );
    assert_eq!(
        text.to_string(),
        "\
error: `model.gas.temperature_k` is -2; must be a number >= 0
 --> m.toml:3:31
  |
3 | model.gas.temperature_k = [1, -2, 3]
  |                               ^^ out of range

error: unknown key `tmp` in `model.gas`
 --> m.toml:4:11
  |
4 | model.gas.tmp = [1]
  |           ^^^ known keys: particles, mass_kg, radius_m, center_m, speed_distribution, temperature_k, max_speed_m_per_s, temperature_definition, boltzmann_constant, propagation, time_step_s, placement, start_from, additional_masses_kg, position_distribution, temperature_schedule, wall_speed_m_per_s, wall_temperature_k, accommodation_coefficient, orifice_width_m, disc_radius_m, speeds_m_per_s, gravity_m_per_s2, partition_x_m, partition_opens_s, partition_side, duration_s

error: `seed` cannot be swept
 --> m.toml:5:1
  |
5 | seed = [1, 2]
  | ^^^^ keys of [model.*] and [record] can be swept, by their full name"
    );
}

#[test]
fn key_without_its_table_is_named_with_it() {
    let text =
        errors("particles = 3\nframes = 4\n[model.gas]\nparticles = 2\n[record]\nframes = 5\n")
            .to_string();
    for meant in ["model.gas.particles", "record.frames"] {
        assert!(text.contains(&format!("did you mean `{meant}`?")), "{text}");
    }
    // Control: without the key in a table, the known keys are listed.
    assert!(errors("particles = 3\n[model.gas]\n").to_string().contains("known keys: "));
}

#[test]
fn invalid_sweeps_are_rejected() {
    let rejected = [
        ("[sweep]\nmodel.gas.radius_m = []", "the axis `model.gas.radius_m` is empty"),
        ("[sweep]\nmodel.gas.radius_m = 3", "must be a list [...] or a range"),
        ("[sweep]\nmodel.gas.radius_m = [1, 2, 1.0]", "1 is listed twice on the axis"),
        ("[sweep]\nmodel.gas.radius_m = { from = 1, to = 2 }", "needs `count`"),
        (
            "[sweep]\nmodel.gas.radius_m = { from = 1, to = 2, count = 1 }",
            "must be from 2 to 100000",
        ),
        ("[sweep]\nmodel.gas.radius_m = { from = 1, to = 2, cuont = 1 }", "did you mean `count`?"),
        (
            "[sweep]\nmodel.gas.radius_m = { from = 0, to = 2, count = 3, spacing = \"log\" }",
            "a logarithmic range needs bounds > 0",
        ),
        (
            "[sweep]\nzip = [[\"model.gas.radius_m\", \"model.gas.mass_kg\"]]\nmodel.gas.radius_m = [1, 2]\nmodel.gas.mass_kg = [1]",
            "`model.gas.radius_m` has 2 values, `model.gas.mass_kg` has 1",
        ),
        (
            "[sweep]\nzip = [[\"model.gas.radius\"]]\nmodel.gas.radius_m = [1, 2]",
            "did you mean \"model.gas.radius_m\"?",
        ),
        (
            "[sweep]\nmodel.gas.radius_m = [1, 2]\n[[sweep.variants]]\nname = \"a\"\nmodel.gas.radius_m = 4",
            "`model.gas.radius_m` is swept twice",
        ),
        ("[[sweep.variants]]\nmodel.gas.radius_m = 4", "a variant has no name"),
        (
            "[[sweep.variants]]\nname = \"a\"\n[[sweep.variants]]\nname = \"a\"",
            "is empty or listed twice",
        ),
        (
            "[[sweep.variants]]\nname = \"a\"\nradius_m = 3",
            "unknown key `radius_m` in `sweep.variants`",
        ),
        (
            "[sweep]\nmodel.gas.radius_m = { from = 1, to = 2, count = 1001 }\nmodel.gas.mass_kg = { from = 1, to = 2, count = 1000 }",
            "the sweep has more than 100000 runs: 1001 x 1000 points and 1 replicates; split",
        ),
        (
            "[record]\nkeep = \"metrics\"\n[sweep]\nmodel.gas.radius_m = { from = 1, to = 2, count = 1001 }\nmodel.gas.mass_kg = { from = 1, to = 2, count = 1000 }",
            "the sweep has more than 2000000 runs or 100000 points: 1001 x 1000 points and 1 replicates; split",
        ),
        (
            "[sweep]\nmodel.gas.radius_m = { from = 1, to = 2, count = 1000000 }",
            "must be from 2 to 100000",
        ),
        ("[sweep]\nmodel.dem.discs = [1]", "[model.gas] and [model.dem] cannot be used together"),
        ("[sweep]\nmodel.gas.radius_m.inner = [1]", "`model.gas.radius_m` is not a table"),
    ];
    for (sweep, message) in rejected {
        let text = errors(&format!("[model.gas]\nradius_m = 1.0\n{sweep}\n")).to_string();
        assert!(text.contains(message), "{sweep}\n{text}");
    }
    let mixed = errors(
        "[[sweep.variants]]\nname = \"a\"\nmodel.dem.discs = 2\n[[sweep.variants]]\nname = \"b\"\nmodel.gas.particles = 2\n",
    );
    assert!(mixed.to_string().contains("the sweep mixes dem and gas"), "{mixed}");
}

#[test]
fn sweep_of_more_keys_than_any_model_has_is_rejected() {
    let keys = |count: usize| -> String {
        (0..count).map(|key| format!("model.gas.k{key} = [1]\n")).collect()
    };
    let sweep = |text: String| errors(&format!("[model.gas]\n[sweep]\n{text}")).to_string();
    assert!(sweep(keys(1001)).contains("the sweep sets more than 1000 keys"));
    let of_variant = errors(&format!("[[sweep.variants]]\nname = \"a\"\n{}", keys(1001)));
    assert!(of_variant.to_string().contains("the sweep sets more than 1000 keys"), "{of_variant}");
    let fewer = sweep(keys(1000));
    assert!(!fewer.contains("more than 1000 keys") && fewer.contains("unknown key"), "{fewer}");
}

/// Guarantee: the runs of a point share their values, so that a million of them have a plan.
#[test]
fn replicates_share_the_values_of_their_point() {
    let text = "seed = 1\nreplicates = 100000\n[model.gas]\n[record]\nkeep = \"metrics\"\n[sweep]\n\"model.gas.temperature_k\" = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]\n";
    let experiment = experiment(text);
    assert_eq!(experiment.runs.len(), 1_000_000);
    let [first, last] = [&experiment.runs[900_000], &experiment.runs[999_999]];
    assert!(std::sync::Arc::ptr_eq(&first.manifest.model, &last.manifest.model));
    assert!(std::ptr::eq(&*first.coordinates, &*last.coordinates));
    assert!(size_of::<kinetoscope_manifest::Run>() <= 56);
    let shared = first.manifest.shared_text();
    assert_eq!(last.manifest.canonical_with(&shared), last.manifest.canonical());
}

//! Guarantee: every rule that holds for all models is enforced, and the message states the allowed values and the position.
//!
//! Setup: each rule is violated once.

// A test may panic.
#![allow(clippy::unwrap_used)]

use crate::verdicts::{accepted, errors, experiment, rejected};
use kinetoscope_manifest::model::{ModelConfig, PackingPlacement, SpeedScale};
use kinetoscope_manifest::{Override, parse, parse_run};

#[test]
fn numbers_outside_their_ranges_are_rejected() {
    let positive = "must be a number > 0";
    for bad in ["0", "-1.0", "nan", "inf", "-inf", "1e400", "-0.0"] {
        rejected(&format!("[model.gas]\nradius_m = {bad} # <-"), positive);
    }
    for bad in ["0", "-1e-5"] {
        let stepped =
            format!("[model.gas]\npropagation = \"time-stepped\"\ntime_step_s = {bad} # <-");
        rejected(&stepped, positive);
    }
    rejected(
        "[model.gas]\nradius_m = \"1.0\" # <-",
        "`model.gas.radius_m` is a string; must be a number > 0",
    );
    rejected(
        "[model.gas]\nradius_m = true # <-",
        "`model.gas.radius_m` is a boolean; must be a number > 0",
    );
    rejected(
        "[model.gas]\nradius_m = 1979-05-27 # <-",
        "`model.gas.radius_m` is a date; must be a number > 0",
    );
    rejected("[model.gas]\ncenter_m = [nan, 0] # <-", "must be a finite number");
    rejected("[model.gas]\ntemperature_k = -1 # <-", "must be a number >= 0");
    rejected("[model.dem]\nrestitution = 0 # <-", "must be a number in (0, 1]");
    rejected("[model.dem]\nrestitution = 1.0000000000000002 # <-", "must be a number in (0, 1]");
    rejected("[model.packing]\nwidth = 9.999 # <-", "must be a number in [10, 100000]");
    rejected("[model.orbit]\ntime_step_days = 0 # <-", "must be a number > 0");
    rejected(
        "[model.gas]\n[record]\nkeyframe_distance = 5 # <-",
        "`record.keyframe_distance` needs `keep = \"keyframes\"`",
    );
    rejected("[model.gas]\n[record]\ndraw_every = 0 # <-", "must be a whole number from 1 to");
    rejected("[model.gas]\n[record]\nplayback_fps = 50.1 # <-", "must be a number in (0, 50]");
    let whole = "must be a whole number from 1 to 4294967295";
    for bad in ["0", "-3", "1.5", "4294967296", "1e10", "1e40"] {
        rejected(&format!("[model.gas]\nparticles = {bad} # <-"), whole);
    }
    rejected("replicates = 0 # <-\n[model.gas]", "must be a whole number from 1 to 100000");
    rejected("replicates = 100001 # <-\n[model.gas]", "must be a whole number from 1 to 100000");
    rejected("seed = 18446744073709551616 # <-\n[model.gas]", "from 0 to 18446744073709551615");
    rejected(
        "seed = 99999999999999999999999999999999999999999999 # <-\n[model.gas]",
        "`seed` is 1e44; must be",
    );
    // Above 2^53, a float may represent several integers.
    rejected("seed = 1e16 # <-\n[model.gas]", "`seed` is 1e16; must be a whole number");
}

#[test]
fn unknown_names_are_rejected_with_the_nearest_known_name() {
    rejected("[model.gas]\nparticle = 3 # <-", "did you mean `particles`?");
    rejected("[model.orbit]\nintegrator = \"verlet\" # <-", "did you mean \"velocity-verlet\"?");
    rejected("[model.gas]\n[recrod] # <-", "did you mean `record`?");
    rejected(
        "[model.orbit]\nintegrator = \"heun\" # <-",
        "must be one of \"explicit-euler\", \"semi-implicit-euler\"",
    );
    rejected(
        "[model.orbit]\nintegrator = \"velocity_verlet\" # <-",
        "did you mean \"velocity-verlet\"?",
    );
    rejected(
        "[model.gas]\nplacement = \"lattice\" # <-",
        "must be one of \"random\" or { positions_m",
    );
    rejected("[model.gsa] # <-", "did you mean `gas`?");
    rejected(
        "seed = 1",
        "no model: add one of [model.dem], [model.gas], [model.packing], [model.orbit]",
    );
    rejected("[model]", "no model");
    rejected(
        "[model.gas]\n[record]\nchannels = [\"state\", \"trail\"] # <-",
        "the gas model has no channel \"trail\"",
    );
    rejected(
        "[model.gas]\n[record]\nchannels = [\"log\", \"log\"] # <-",
        "channel \"log\" is listed twice",
    );
}

#[test]
fn exclusive_keys_are_named_together() {
    let exclude = |a: &str, b: &str| format!("`{a}` and `{b}` cannot be used together");
    let dem = |a: &str, b: &str| exclude(&format!("model.dem.{a}"), &format!("model.dem.{b}"));
    rejected(
        "[model.dem]\nrestitution = 0.5\ndamping_n_s_per_m = 1 # <-",
        &dem("restitution", "damping_n_s_per_m"),
    );
    rejected(
        "[model.dem]\ntime_step_s = 1e-6\nsteps_per_wall_contact = 20 # <-",
        &dem("steps_per_wall_contact", "time_step_s"),
    );
    rejected(
        "[model.gas]\nmax_speed_m_per_s = 1\ntemperature_k = 1 # <-",
        &exclude("model.gas.temperature_k", "model.gas.max_speed_m_per_s"),
    );
    rejected(
        "[model.packing]\nevents_per_disc = 1\nduration = 1 # <-",
        &exclude("model.packing.events_per_disc", "model.packing.duration"),
    );
    rejected(
        "[model.gas]\n[record]\nframes = 1\nevery_s = 1 # <-",
        &exclude("record.frames", "record.every_s"),
    );
    rejected(
        "replicates = 3\nreplicate = 2 # <-\n[model.gas]",
        &exclude("replicates", "replicate"),
    );
    rejected(
        "[model.gas]\n[model.dem] # <-",
        "[model.gas] and [model.dem] cannot be used together",
    );
}

#[test]
fn recording_intervals_must_fit_the_model() {
    rejected("[model.gas]\n[record]\nevery_steps = 2 # <-", "must be one of frames, every_s");
    rejected(
        "[model.dem]\n[record]\nevery_days = 2 # <-",
        "must be one of frames, every_s, every_steps",
    );
    rejected(
        "[model.orbit]\n[record]\nevery_s = 2 # <-",
        "must be one of frames, every_days, every_steps",
    );
    rejected(
        "[model.packing]\n[record]\nevery_time = 2 # <-",
        "must be one of frames, every_collisions",
    );
    rejected(
        "[model.packing]\n[record]\nevery_steps = 2 # <-",
        "must be one of frames, every_collisions",
    );
    rejected(
        "[model.gas]\n[record]\nframes = 20\ndecades = 2 # <-",
        "`record.decades` needs `frames_per_decade`",
    );
    for model in ["dem", "gas", "packing", "orbit"] {
        accepted(&format!("[model.{model}]\n[record]\nframes_per_decade = 8\ndecades = 2"));
    }
    accepted("[model.packing]\nduration = 10\n[record]\nevery_time = 2");
    accepted("[model.packing]\n[record]\nevery_collisions = 2");
    accepted(
        "[model.gas]\npropagation = \"time-stepped\"\ntime_step_s = 1e-5\n[record]\nevery_steps = 2",
    );
    accepted("[model.orbit]\nintegrator = \"kepler\"\n[record]\nevery_steps = 2");
}

#[test]
fn given_states_determine_the_number_of_particles() {
    let start =
        "placement = { positions_m = [[0, 0.5], [0.1, 0]], velocities_m_per_s = [[1, 2], [3, 4]] }";
    let ModelConfig::Gas(gas) = accepted(&format!("[model.gas]\n{start}")) else {
        panic!("expected the gas model")
    };
    assert_eq!(gas.particles.get(), 2);
    assert_eq!(gas.speed_scale, SpeedScale::Given);
    let ModelConfig::Gas(gas) = accepted(&format!("[model.gas]\ntemperature_k = 9\n{start}"))
    else {
        panic!("expected the gas model")
    };
    assert!(matches!(gas.speed_scale, SpeedScale::Temperature(_)));
    accepted(&format!("[model.gas]\nparticles = 2\n{start}"));
    rejected(
        &format!("[model.gas]\nparticles = 3\n{start} # <-"),
        "`particles` is 3, but 2 are placed",
    );
    rejected(
        &format!("[model.gas]\nmax_speed_m_per_s = 3\n{start} # <-"),
        "`max_speed_m_per_s` cannot be used with a given start",
    );
    rejected(
        "[model.dem]\nplacement = { positions_m = [[1, 1]], velocities_m_per_s = [] } # <-",
        "1 positions but 0 velocities",
    );
    rejected(
        "[model.dem]\nplacement = { positions_m = [], velocities_m_per_s = [] } # <-",
        "needs at least one particle",
    );
    rejected(
        "[model.dem]\nplacement = { positions_m = [[1, 1]] } # <-",
        "needs `velocities_m_per_s`",
    );
    rejected(
        "[model.dem]\nplacement = { positions_m = [[1]], velocities_m_per_s = [[0, 0]] } # <-",
        "must be an array of 2 numbers",
    );
    rejected(
        "[model.packing]\nplacement = { positions_m = [[1, 1]], velocities = [[0, 0]], positions = [[1, 1]] } # <-",
        "did you mean `positions`?",
    );
    let ModelConfig::Packing(packing) =
        accepted("[model.packing]\nplacement = { positions = [[1, 1]], velocities = [[0, 0]] }")
    else {
        panic!("expected the packing model")
    };
    assert!(matches!(packing.placement, PackingPlacement::Given(_)) && packing.discs.get() == 1);
}

#[test]
fn experiment_names_must_be_valid_folder_names() {
    rejected("name = \"a b\" # <-\n[model.gas]", "it names a folder");
    rejected("name = \"\" # <-\n[model.gas]", "it names a folder");
    rejected("name = \"../up\" # <-\n[model.gas]", "it names a folder");
    let errors = parse("[model.gas]", "my experiment.toml", &[]).unwrap_err().to_string();
    assert!(errors.contains("cannot name the experiment; add name ="), "{errors}");
    assert_eq!(parse("[model.gas]", "a/b-c_1.toml", &[]).unwrap().name, "b-c_1");
}

#[test]
fn checks_must_have_exactly_one_criterion() {
    let check = |check: &str| {
        format!("[model.gas]\n[sweep]\nmodel.gas.radius_m = [1.0, 2.5]\n[[checks]] {check}")
    };
    rejected(&check("# <-\nexpected = 1\ntolerance = 1"), "needs `metric`");
    rejected(&check("# <-\nmetric = \"a2\"\nexpected = 1"), "needs `tolerance`");
    rejected(
        &check("\nmetric = \"a2\"\ntolerance = 1\nrelative_tolerance = 1 # <-"),
        "cannot be used together",
    );
    rejected(&check("\nmetric = \"a2\"\ntolerance = -1 # <-"), "must be a number >= 0");
    rejected(&check("\nmetric = \"a2\"\nminimum = 3\nmaximum = 1 # <-"), "minimum <= maximum");
    rejected(&check("\nmetric = \"a2\"\nminimum = 3\ntolerance = 1 # <-"), "write two checks");
    rejected(&check("\nmetric = \"a2\"\ntolerence = 3\nminimum = 1"), "did you mean `tolerance`?");
    rejected(
        &check("\nmetric = \"a2\"\nminimum = 1\nwhere = { radius_m = 3 } # <-"),
        "values: 1, 2.5",
    );
    rejected(
        &check("\nmetric = \"a2\"\nminimum = 1\nwhere = { mass_kg = 3 } # <-"),
        "`mass_kg` is not swept",
    );
    accepted(&check("\nmetric = \"a2\"\nminimum = 1\nwhere = { model.gas.radius_m = 1 }"));
    accepted(&check("\nmetric = \"a2\"\nminimum = 1\nwhere = { radius_m = 2.50 }"));
}

#[test]
fn values_from_the_command_line_override_the_file() {
    let set = |key: &str, value: &str| Override { key: key.to_owned(), value: value.to_owned() };
    let text = "[model.gas]\nparticles = 5\n[sweep]\nmodel.gas.radius_m = [1, 2]\n";
    let experiment = parse(
        text,
        "m.toml",
        &[
            set("model.gas.particles", "7"),
            set("model.gas.temperature_definition", "mean-square"),
            set("seed", "3"),
            set("name", "other-name"),
            set("record.channels", "['state']"),
        ],
    )
    .unwrap();
    assert_eq!(experiment.name, "other-name");
    let canonical = experiment.runs[0].manifest.canonical();
    for line in [
        "seed = 3",
        "particles = 7",
        "temperature_definition = \"mean-square\"",
        "channels = [\"state\"]",
    ] {
        assert!(canonical.contains(line), "{canonical}");
    }
    let rejected = |key: &str, value: &str, message: &str| {
        let errors = parse(text, "m.toml", &[set(key, value)]).unwrap_err().to_string();
        assert!(errors.contains(message) && errors.contains("--> --set:1:"), "{message}\n{errors}");
    };
    rejected("model.gas.radius_m", "3", "`model.gas.radius_m` is swept and cannot be set");
    rejected("model.gas", "3", "is swept and cannot be set");
    rejected("model.gas.particels", "3", "did you mean `particles`?");
    rejected("model.gas.particles", "0", "must be a whole number from 1");
    rejected("model.gas.particles", "1 2", "is not TOML");
    rejected("model.gas.particles", "", "is not TOML");
    rejected("sweep.model.gas.mass_kg", "[1]", "`sweep.model.gas.mass_kg` cannot be set");
    rejected("model.dem.discs", "3", "[model.gas] and [model.dem] cannot be used together");
    rejected("model.gas.particles.x", "3", "`model.gas.particles` is not a table");
}

#[test]
fn run_manifest_must_describe_one_run() {
    let errors = parse_run("replicates = 3\n[model.gas]").unwrap_err().to_string();
    assert!(errors.contains("expected one run, found an experiment of 3"), "{errors}");
    assert_eq!(parse_run("replicate = 3\n[model.gas]").unwrap().replicate, 3);
}

#[test]
fn invalid_toml_line_hides_only_itself() {
    let errors = errors("[model.gas]\nparticles = \nradius_m = -1\nmass_kg = -1\nmass_kg = 3\n");
    let text = errors.to_string();
    assert!(
        text.contains("m.toml:2:13")
            && text.contains("m.toml:3:12")
            && text.contains("m.toml:4:11"),
        "{text}"
    );
    assert!(text.contains("duplicate key"), "{text}");
    assert_eq!(errors.len(), 4, "{text}");
    // After an invalid header, the table of the following keys is unknown.
    rejected("[model.gas\nparticles = 0\n", "");
}

#[test]
fn long_error_list_is_truncated() {
    let wrong = vec!["[nan, 0]"; 1000].join(", ");
    let text =
        format!("[model.packing]\nplacement = {{ positions = [{wrong}], velocities = [{wrong}] }}");
    let many = errors(&text);
    assert_eq!(many.len(), 2000);
    assert!(many.to_string().ends_with("error: and 1900 more errors"));
    let prose = errors(&"These words are no TOML.\n".repeat(3000)).to_string();
    assert!(prose.contains("2990 more places are not TOML: is this file a manifest?"), "{prose}");
    let wide: String = "[model.gas]".chars().flat_map(|sign| [sign, '\0']).collect();
    rejected(&wide, "save it as UTF-8");
    let unknown: String = (0..3000).map(|key| format!("k{key} = 1\n")).collect();
    let many = errors(&unknown);
    // The last one is the missing model.
    assert_eq!(many.len(), 3001);
    assert!(many.to_string().ends_with("error: and 2901 more errors"));
}

#[test]
fn lines_of_many_checks_are_exact() {
    let check = "[[checks]]\nmetric = \"mean_speed\"\nminimum = 0\n# a line\n";
    let text = format!("[model.gas]\n{}", check.repeat(200));
    let checks = experiment(&text).checks;
    let lines: Vec<u32> = checks.iter().map(|check| check.line).collect();
    assert_eq!(lines, (0..200).map(|number| 2 + 4 * number).collect::<Vec<_>>());
}

/// 2,010,000 particles are drawn at most, 10,000 in each of 201 frames; a run of more draws one frame in as few of 1, 2, 5, 10, … as suffice,
/// whatever the sizes. Its drawings take at most 15 % of the time of its states and steps: a drawn particle takes the time of 60 steps, and so does its
/// state.
#[test]
fn drawings_of_large_runs_are_within_a_budget() {
    let distance_of = |record: &str, particles, frames, steps| {
        let gas = experiment(&format!("seed = 1\n[model.gas]\n[record]\n{record}"));
        gas.runs[0].manifest.record.distance_of_drawings(particles, frames, steps).get()
    };
    let distance =
        |record: &str, particles, frames| distance_of(record, particles, frames, u64::MAX);
    for (particles, frames, expected) in [
        (1, 1, 1),
        (10_000, 201, 1),
        (10_000, 202, 2),
        (10_000, 401, 2),
        (10_000, 403, 5),
        (1_000_000, 2_010, 10),
        (1_000_000, 2_011, 20),
        (100, 20_100, 1),
        // 10^4 (2^64 - 1) particles are more than a number holds: 2^64 - 1 over 2,010,000 is 9.2e12.
        (u64::MAX, u64::MAX, 10_000_000_000_000),
    ] {
        assert_eq!(distance("", particles, frames), expected, "{particles}, {frames}");
        for every in [1, 7, u64::MAX >> 1] {
            let record = format!("draw_every = {every}\n");
            assert_eq!(distance(&record, particles, frames), every);
        }
    }
    assert_eq!(distance("max_drawn_particles = 100\n", 10_000, 20_100), 1);
    // Steps per particle and frame. 60 / 10 = 0.1 (60 + 0), and 60 / 5 = 0.15 (60 + 20); of 340 on, 60 = 0.15 (60 + 340).
    for (steps, expected) in [(0, 10), (19, 10), (20, 5), (139, 5), (140, 2), (400, 2)] {
        assert_eq!(distance_of("", 10_000, 401, steps * 4_010_000), expected, "{steps}");
        assert_eq!(distance_of("", 10_000, 201, steps * 2_010_000), 1, "{steps}");
        // Of 10^6 particles, 10^4 are drawn: the states of all take 100 times as long.
        assert_eq!(distance_of("", 1_000_000, 401, steps), 2, "{steps}");
    }
    assert_eq!(distance_of("", u64::MAX, u64::MAX, 0), 10_000_000_000_000);
}

/// What new users write, each with what they meant.
#[test]
fn usual_mistakes_name_their_remedy() {
    for (line, remedy) in [
        ("particles = 20 20 # <-", "one number has no spaces; several numbers are a list"),
        ("temperature_k = 300 K # <-", "a number stands without a unit"),
        ("mass_kg = 3e-26kg # <-", "a number stands without a unit"),
        ("radius_m = 0,1 # <-", "a number has a decimal point, no comma"),
        ("temperature_k = 3*10^2 # <-", "a number stands alone, computed: 3e2"),
        ("temperature_k = 273.15 + 20 # <-", "a number stands alone, computed"),
        ("radius_m = wide # <-", "this is not TOML"),
        ("frames = 10 # <-", "write `frames` below [record]"),
        ("every_s = 0.1 # <-", "write `every_s` below [record]"),
        ("seed = 3 # <-", "write `seed` above the first table, as it belongs to all runs"),
        ("replicates = 3 # <-", "write `replicates` above the first table"),
    ] {
        rejected(&format!("[model.gas]\n{line}"), remedy);
    }
    rejected("[model.gas]\n[record]\nduration_s = 1 # <-", "write `duration_s` below [model.gas]");
    rejected("[gas] # <-\nparticles = 7", "write [model.gas]");
    rejected("[model]\nname = \"gas\" # <-\nparticles = 7", "such as [model.gas]");
    rejected("[model.gas]\n[sweep]\ngas.temperature_k = [1, 2] # <-", "`model.gas.temperature_k`");
    let euler = "did you mean \"explicit-euler\"?";
    rejected("[model.orbit]\nintegrator = \"euler\" # <-", euler);
    let leapfrog = "did you mean \"velocity-verlet\"?";
    rejected("[model.orbit]\nintegrator = \"leapfrog\" # <-", leapfrog);
    let fraction = "set `radius`, `width` and `height`: the fraction of N discs";
    rejected("[model.packing]\npacking_fraction = 0.5 # <-", fraction);
    let sweep = |key: &str| format!("[model.packing]\n[sweep]\n{key} = [0.1, 0.2] # <-");
    rejected(&sweep("restitution"), "did you mean `model.packing.restitution`?");
    rejected(&sweep("frames"), "did you mean `record.frames`?");
    rejected(&sweep("qqqq"), "keys of [model.*] and [record] can be swept, by their full name");
}

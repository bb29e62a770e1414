//! Guarantee: all errors of a manifest are reported at once. Each error has its line, its column, the underlined text, and the allowed
//! range or the nearest known name.
//!
//! Setup: one manifest with twelve errors; serde alone would stop at the first one.

use crate::forged_recording::{run_experiment, stderr};
use kinetoscope_manifest::{Override, parse};

/// Twelve errors of different kinds: names, ranges, types, values, exclusive keys, rules between tables, a sweep, a check.
const PLANTED: &str = r#"nmae = "planted"
seed = -1

[model.dem]
discs = 20
radius_m = { min = 6e-4, max = 4e-4 }
gravity_m_per_s2 = [0.0, -inf]
stifness_n_per_m = 5e4
restitution = 0.5
damping_n_s_per_m = 1.5e3
integrator = "verlet"
width_m = "0.04"

[record]
every_days = 0.25
channels = ["state", "energi"]

[sweep]
model.dem.duration_s = [1.0, 0.0]

[[checks]]
metric = "energy.residual_relative"
expected = 0.0
"#;

const RENDERED: &str = r#"error: unknown key `nmae`
 --> planted.toml:1:1
  |
1 | nmae = "planted"
  | ^^^^ did you mean `name`?

error: `seed` is -1; must be a whole number from 0 to 18446744073709551615
 --> planted.toml:2:8
  |
2 | seed = -1
  |        ^^ out of range

error: `model.dem.radius_m` has `min` above `max`
 --> planted.toml:6:32
  |
6 | radius_m = { min = 6e-4, max = 4e-4 }
  |                    ----        ^^^^ min must be <= max

error: `model.dem.gravity_m_per_s2` is -inf; must be a finite number
 --> planted.toml:7:26
  |
7 | gravity_m_per_s2 = [0.0, -inf]
  |                          ^^^^ out of range

error: unknown key `stifness_n_per_m` in `model.dem`
 --> planted.toml:8:1
  |
8 | stifness_n_per_m = 5e4
  | ^^^^^^^^^^^^^^^^ did you mean `stiffness_n_per_m`?

error: `model.dem.restitution` and `model.dem.damping_n_s_per_m` cannot be used together
  --> planted.toml:10:1
   |
 9 | restitution = 0.5
   | -----------
10 | damping_n_s_per_m = 1.5e3
   | ^^^^^^^^^^^^^^^^^ keep one of them

error: unknown value "verlet" for `model.dem.integrator`
  --> planted.toml:11:14
   |
11 | integrator = "verlet"
   |              ^^^^^^^^ did you mean "velocity-verlet"? Must be one of "semi-implicit-euler", "velocity-verlet"

error: `model.dem.width_m` is a string; must be a number > 0
  --> planted.toml:12:11
   |
12 | width_m = "0.04"
   |           ^^^^^^ wrong type

error: `record.every_days` cannot be used with this dem experiment
  --> planted.toml:15:14
   |
15 | every_days = 0.25
   |              ^^^^ must be one of frames, every_s, every_steps, frames_per_decade

error: the dem model has no channel "energi"
  --> planted.toml:16:22
   |
16 | channels = ["state", "energi"]
   |                      ^^^^^^^^ did you mean "energy"?

error: `model.dem.duration_s` is 0.0; must be a number > 0
  --> planted.toml:19:30
   |
19 | model.dem.duration_s = [1.0, 0.0]
   |                              ^^^ out of range

error: a check has nothing to compare with
  --> planted.toml:21:1
   |
21 | [[checks]]
   | ^^^^^^^^^^ needs `tolerance`, `relative_tolerance`, `standard_errors`, `max_deviation_sigma`, `minimum` or `maximum`"#;

#[test]
fn all_planted_errors_are_reported() {
    let errors = parse(PLANTED, "planted.toml", &[]).unwrap_err();
    assert_eq!(errors.to_string(), RENDERED);
    assert_eq!(errors.len(), 12);
}

#[test]
fn error_in_an_override_is_shown_separately() {
    let manifest = "[model.dem]\ndamping_n_s_per_m = 0.1\n";
    let set = Override { key: "model.dem.restitution".to_owned(), value: "0.9".to_owned() };
    let errors = parse(manifest, "m.toml", &[set]).unwrap_err();
    assert_eq!(
        errors.to_string(),
        "\
error: `model.dem.restitution` and `model.dem.damping_n_s_per_m` cannot be used together
 --> --set:1:1
  |
1 | model.dem.restitution=0.9
  | ^^^^^^^^^^^^^^^^^^^^^ keep one of them
  |
 ::: m.toml:2:1
  |
2 | damping_n_s_per_m = 0.1
  | -----------------"
    );
}

#[test]
fn color_is_used_only_on_request() {
    let errors = parse(PLANTED, "planted.toml", &[]).unwrap_err();
    assert!(!errors.to_string().contains('\u{1b}'));
    assert!(errors.render(true).contains('\u{1b}'));
}

/// Control: before, a number where a string belongs was "out of range", as if another number could be right.
#[test]
fn number_in_place_of_another_type_is_a_wrong_type() {
    for (manifest, what) in [
        ("name = 5\n[model.gas]\n", "`name` is 5; must be a string"),
        ("[model.gas]\npropagation = 5\n", "`model.gas.propagation` is 5; must be one of"),
        ("[model.gas]\n[record]\nchannels = 5\n", "`record.channels` is 5; must be"),
        ("model = 5\n", "`model` is 5; must be a table"),
    ] {
        let text = parse(manifest, "m.toml", &[]).unwrap_err().to_string();
        assert!(text.contains(what) && text.contains("^ wrong type"), "{text}");
        assert!(!text.contains("out of range"), "{text}");
    }
}

/// A reason that names no key of the manifest has the line of the model's table.
#[test]
fn error_of_a_run_that_cannot_be_prepared_names_the_line_of_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("coarse.toml");
    let planned = |text: &str| {
        std::fs::write(&manifest, text).unwrap();
        stderr(&run_experiment([manifest.as_os_str(), "--dry-run".as_ref()]))
    };
    let orbit = "[model.orbit]\ntime_step_days = 100\n";
    let text = planned(&format!("{orbit}[record]\nframes = 50\n"));
    assert!(text.contains("coarse.toml:4\nhelp: set frames to at most 3"), "{text}");
    let text = planned(&format!("seed = 1\n{orbit}"));
    assert!(text.contains("coarse.toml:2\nhelp: set frames to at most 3"), "{text}");
    let dem = "[model.dem]\nduration_s = 1e-4\n[record]\nframes = 50\n";
    let text = planned(dem);
    assert!(text.contains("coarse.toml:4\nhelp: set frames to at most 4"), "{text}");
}

/// Law: the values that an error suggests are accepted, though the shortest step depends on the positions as well as on the duration.
/// Control: before, the nearest step of a run below 20.9 days was rejected, and a duration of 1e-300 was a dead end.
#[test]
fn suggested_steps_and_durations_of_an_orbit_work() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("orbit.toml");
    let planned = |step: &str, duration: &str| {
        let text = format!(
            "[model.orbit]\ntime_step_days = {step}\nduration_days = {duration}\n[record]\nframes = 1\n"
        );
        std::fs::write(&manifest, text).unwrap();
        stderr(&run_experiment([manifest.as_os_str(), "--dry-run".as_ref()]))
    };
    let values = |text: &str| -> Vec<String> {
        let after = text.split("at least ").skip(1);
        after.map(|rest| rest.split([',', '\n']).next().unwrap().trim().to_owned()).collect()
    };
    for duration in ["1e-3", "10", "20.8", "21", "365.25", "1e6"] {
        let text = planned("1e-300", duration);
        let [step] = &values(&text)[..] else { panic!("{text}") };
        let text = planned(step, duration);
        assert!(!text.contains("error"), "{duration}: {text}");
    }
    let text = planned("1e-301", "1e-300");
    let [duration, step] = &values(&text)[..] else { panic!("{text}") };
    let text = planned(step, duration);
    assert!(!text.contains("error"), "{text}");
    let text = planned("0.25", "1e-300");
    let [duration] = &values(&text)[..] else { panic!("{text}") };
    let text = planned("0.25", duration);
    assert!(!text.contains("error"), "{text}");
}

/// Whether the manifest states them or not. Control: another number is not called the default.
#[test]
fn default_frames_of_a_short_run_are_called_default() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("short.toml");
    for (record, frames) in [
        ("", "200, the default"),
        ("[record]\nframes = 200\n", "200, the default"),
        ("[record]\nframes = 300\n", "300"),
    ] {
        std::fs::write(&manifest, format!("[model.orbit]\nduration_days = 10\n{record}")).unwrap();
        let text = stderr(&run_experiment([manifest.as_os_str(), "--dry-run".as_ref()]));
        let expected = format!("[record] frames is {frames}, but the run has only 40 steps\n");
        assert!(text.contains(&expected), "{text}");
        assert!(
            text.contains("help: set frames to at most 40 in [record], or make the run longer"),
            "{text}"
        );
    }
}

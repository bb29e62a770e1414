//! Guarantee: every small valid manifest, with whatever extreme values, ends: with its last frame, a fault or an error of the start, each
//! with its reason, or soon after a signal; what is recorded verifies and can be analyzed.
//!
//! Setup: random manifests of each model with the limits of their keys: restitutions near 0 and 1, noisy walls, denormal speeds, ratios of
//! masses, radii and stiffnesses of up to 1e30, times that are far too short or too long. A run is interrupted after two seconds of processor
//! time, in the campaign one in a hundred after twenty, and then must end within one; the campaign prints how often each outcome was seen, and the
//! longest time from the signal to the end.
//! Control: complete runs, faults and errors of the start are all among the outcomes.

#![allow(clippy::unwrap_used, reason = "a test may panic")]
#![cfg(unix)]

use crate::mutated_recording::Numbers;
use crate::mutated_recordings_are_reported::{
    BATCH, Findings, LONGEST_RUN, assert_none, execute, execute_for, mutations,
};
use kinetoscope::Experiment;
use kinetoscope::run::RunError;
use kinetoscope::run::in_memory::run_interruptibly;
use kinetoscope::verify::verify;
use kinetoscope_recording::provenance::Outcome;
use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::path::Path;
use std::time::Duration;

/// Keys, each with values that are used in turn with the default.
type Keys = &'static [(&'static str, &'static [&'static str])];

/// The keys of each model.
const KEYS: [(&str, Keys); 4] =
    [("dem", DEM), ("gas", GAS), ("packing", PACKING), ("orbit", ORBIT)];

const DEM: Keys = &[
    ("discs", &["1", "2", "5", "17"]),
    ("mass_kg", &["1e-30", "1e-3", "1e6"]),
    ("width_m", &["0.003", "0.01", "1.0", "1e9"]),
    ("height_m", &["0.003", "0.01", "1.0", "1e9"]),
    ("radius_m", &["1e-4", "{ small = 1e-4, large = 1e-3, small_fraction = 0.5 }", "1e-9", "0.2"]),
    ("stiffness_n_per_m", &["1e-9", "5e4", "1e15"]),
    ("youngs_modulus_pa", &["1e-9", "1e9", "1e300"]),
    ("restitution", &["1e-300", "1e-6", "0.999999999999", "1.0"]),
    ("limit_damping", &["true", "false"]),
    ("friction", &["0.0", "1e-300", "0.5", "1e6"]),
    ("rolling_friction", &["0.0", "0.1", "1e6"]),
    ("cohesion_n", &["1e-300", "1e-3", "1e300"]),
    ("tangential_to_normal_stiffness", &["1e-12", "0.3", "1e3"]),
    ("tangential_law", &["\"mindlin\""]),
    ("poisson_ratio", &["0.0", "0.3", "0.5"]),
    ("periodic", &["\"x\"", "\"y\"", "\"both\"", "\"none\""]),
    ("integrator", &["\"velocity-verlet\"", "\"semi-implicit-euler\""]),
    ("dashpot", &["\"implicit\"", "\"explicit\""]),
    ("gravity_m_per_s2", &["[0.0, -5e-324]", "[0.0, 0.0]", "[1e3, 1e3]", "[0.0, -1e300]"]),
    ("on_unstable_time_step", &["\"warn\"", "\"error\""]),
    ("velocity_std_m_per_s", &["5e-324", "0.1", "1e4", "1e150"]),
    ("time_step_s", &["\"automatic\"", "1e-7", "1e-300"]),
    ("remove_below_m", &["0.001", "1e3"]),
    (
        "insertion",
        &[
            "{ discs = 3, discs_per_s = 1e300, from_m = [0.001, 0.002], to_m = [0.002, 0.002], velocity_m_per_s = [0.0, -0.5] }",
            "{ discs = 3, discs_per_s = 5e-324, from_m = [0.001, 0.002], to_m = [0.002, 0.002], velocity_m_per_s = [0.0, -5e-324] }",
        ],
    ),
    (
        "materials",
        &[
            "[{ name = \"a\", fraction = 0.5, density_ratio = 1e-12 }, { name = \"b\", restitution = 1e-12 }]",
            "[{ name = \"a\", stiffness_ratio = 1e-300, cohesion_n = 1.0 }, { name = \"b\", stiffness_ratio = 1e300 }]",
            "[{ name = \"a\", stiffness_ratio = 0.2 }, { name = \"b\", stiffness_ratio = 5.0, cohesion_n = 1e-3 }]",
        ],
    ),
    ("duration_s", &["1e-300", "1e-6", "0.001", "1e6"]),
];

const GAS: Keys = &[
    ("particles", &["1", "2", "7", "30"]),
    ("mass_kg", &["1e-300", "1e-26", "1.0", "1e30"]),
    ("additional_masses_kg", &["[1e-26, 1.0]", "[1e-40]"]),
    ("radius_m", &["1e-9", "0.05", "0.5", "1e6"]),
    ("temperature_k", &["0.0", "5e-324", "300.0", "1e12"]),
    ("speeds_m_per_s", &["[0.0, 5e-324, 1e-160]", "[1e-9, 1e9]"]),
    ("temperature_schedule", &["[[1e-9, 5e-324], [2e-9, 300.0]]", "[[1e-12, 0.0]]"]),
    ("disc_radius_m", &["1e-9", "0.01", "0.2"]),
    ("wall_speed_m_per_s", &["5e-324", "5.0", "-5.0", "-1e9"]),
    ("orifice_width_m", &["1e-300", "0.01", "0.5"]),
    ("wall_temperature_k", &["5e-324", "1.0", "1e12"]),
    ("accommodation_coefficient", &["1e-12", "0.5"]),
    ("gravity_m_per_s2", &["5e-324", "9.81", "1e12"]),
    ("partition_x_m", &["0.0", "0.01"]),
    ("speed_distribution", &["\"maxwell\"", "\"uniform\"", "\"equal\""]),
    ("position_distribution", &["\"uniform-in-radius\"", "\"barometric\""]),
    ("propagation", &["\"exact\"", "\"time-stepped\"", "\"as-printed\""]),
    ("time_step_s", &["1e-300", "1e-9", "1e-5", "1e-4"]),
    ("duration_s", &["1e-300", "1e-6", "0.001", "1e9"]),
];

const PACKING: Keys = &[
    ("discs", &["1", "2", "5", "20"]),
    ("width", &["10.0", "15.0", "1e5"]),
    ("height", &["10.0", "15.0", "1e5"]),
    ("boundary", &["\"walls\"", "\"periodic\""]),
    ("radius", &["1.0", "0.5", "1e-12", "1e-300"]),
    ("radius_half_width", &["0.0", "0.3", "0.999999999999"]),
    ("restitution", &["1e-300", "1e-6", "0.1", "0.9", "0.999999999999", "1.0"]),
    ("contact_time", &["1e-300", "1e-4", "1e300"]),
    ("cutoff_velocity", &["5e-324", "1e-3", "1e300"]),
    ("wall_noise_variance_rad2", &["5e-324", "0.003", "0.1", "1e300"]),
    ("initial_velocities", &["\"unit-variance\"", "\"variance-1-over-n\""]),
    ("remove_mean_velocity", &["true", "false"]),
    (
        "placement",
        &[
            "\"lattice\"",
            "\"compressed\"",
            "{ positions = [[-2.0, 0.1], [2.0, 0.0]], velocities = [[5e-324, 0.0], [0.0, 1e-310]] }",
            "{ positions = [[-2.0, 0.1], [2.0, 0.0]], velocities = [[1e-150, 0.0], [-1e150, 1.0]] }",
        ],
    ),
    ("compression_rate", &["1e-9", "0.1", "1e9"]),
    ("target_reduced_pressure", &["1e-300", "20.0", "1e300"]),
    ("gravity", &["5e-324", "0.1", "1e6"]),
    ("floor_temperature", &["1e-300", "1.0", "1e12"]),
    ("floor_stroke", &["1e-6", "0.3"]),
    ("floor_period", &["1e-3", "1.0", "1e300"]),
    ("events_per_disc", &["1", "20", "10000", "4000000000"]),
    ("duration", &["1e-300", "10.0", "1e300"]),
];

const ORBIT: Keys = &[
    (
        "start",
        &[
            "\"barycentric\"",
            "{ semi_major_axis_au = 1.0, eccentricity = 0.999999 }",
            "{ semi_major_axis_au = 1e-9, eccentricity = 1e-300 }",
            "{ semi_major_axis_au = 1e9, eccentricity = 0.5 }",
            "{ position_au = [1.0, 0.0, 0.0], velocity_au_per_day = [0.0, 5e-324, 0.0] }",
            "{ position_au = [1e-12, 0.0, 0.0], velocity_au_per_day = [0.0, 1e9, 0.0] }",
        ],
    ),
    (
        "bodies",
        &[
            "[{ gm_au3_per_day2 = 3e-4, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }, \
          { gm_au3_per_day2 = 5e-324, position_au = [1, 0, 0], velocity_au_per_day = [0, 0.017, 0] }]",
            "[{ gm_au3_per_day2 = 1e9, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }, \
          { gm_au3_per_day2 = 1e-21, position_au = [1e-3, 1e-9, 0], velocity_au_per_day = [1e-9, 5e-324, 0] }]",
        ],
    ),
    ("integrator", &["\"rk4\"", "\"dop853\"", "\"kepler\"", "\"explicit-euler\"", "\"yoshida4\""]),
    ("tolerance", &["1e-15", "1e-9", "0.01"]),
    ("time_step_days", &["1e-12", "1e-3", "1.0", "50.0", "1e300"]),
    ("summation", &["\"plain\"", "\"compensated\""]),
    ("duration_days", &["1e-300", "1e-3", "60.0", "1e9"]),
];

/// Processor time after which one of `LONG_RUN_IN` runs of the campaign is interrupted.
const LONGEST_LONG_RUN: Duration = Duration::from_secs(20);

/// Of so many runs of the campaign, one may take [`LONGEST_LONG_RUN`].
const LONG_RUN_IN: usize = 100;

/// A manifest in which a third of the keys has a value of its list, and the length of the run mostly a small one.
fn random_manifest(numbers: &mut Numbers) -> String {
    let (model, keys) = KEYS[numbers.below(KEYS.len())];
    let mut text = format!("seed = {}\n[model.{model}]\n", numbers.next() % 1000);
    for (key, values) in keys {
        if numbers.is_one_in(3) {
            text += &format!("{key} = {}\n", numbers.one_of(values));
        }
    }
    let frames = numbers.one_of(&["frames = 3", "frames = 1", "frames_per_decade = 3"]);
    text + "[record]\n" + frames + "\n"
}

/// How the runs of a campaign ended.
#[derive(Default)]
struct Outcomes {
    seen: BTreeMap<&'static str, usize>,
    longest_end: Duration,
    /// Runs that could take [`LONGEST_LONG_RUN`], and those of them that did and were interrupted.
    long: [usize; 2],
}

impl Outcomes {
    /// Runs a manifest; returns the bytes of its recording if it was not interrupted.
    fn run(
        &mut self,
        manifest: &str,
        longest: Duration,
        findings: &mut Findings,
    ) -> Option<Vec<u8>> {
        let experiment: Experiment = manifest.parse().ok()?;
        let mut ended = None;
        let run = execute_for(longest, |interrupt| {
            ended = Some(run_interruptibly(&experiment.runs[0], interrupt));
        });
        if longest > LONGEST_RUN {
            self.long[0] += 1;
            self.long[1] += usize::from(run.is_interrupted);
        }
        let mut find = |finding: &str| {
            findings.add("run", Path::new(""), &format!("{finding}\n{manifest}"));
        };
        if let Some(finding) = run.finding {
            find(&finding);
        }
        self.longest_end = self.longest_end.max(run.end_after_signal);
        let (outcome, recording) = match ended {
            _ if run.is_interrupted => ("interrupted", None),
            None => ("panic", None),
            Some(Ok(recording)) => match &recording.provenance().outcome {
                Some(Outcome::Complete) => ("complete", Some(recording)),
                Some(Outcome::Fault(why)) if !why.is_empty() => ("fault", Some(recording)),
                _ => {
                    find("the outcome has no name");
                    ("unnamed", None)
                }
            },
            Some(Err(RunError::Setup(why))) => {
                if why.to_string().is_empty() {
                    find("the error has no text");
                }
                ("error of the start", None)
            }
            Some(Err(other)) => {
                find(&other.to_string());
                ("error of the recording", None)
            }
        };
        *self.seen.entry(outcome).or_default() += 1;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        recording?.save(&path).unwrap();
        Some(fs::read(path).unwrap())
    }

    fn count(&self, outcome: &str) -> usize {
        self.seen.get(outcome).copied().unwrap_or(0)
    }
}

/// Runs, verifies and analyzes random manifests until `count` have an outcome; returns the findings and the outcomes. `after` receives both
/// after each batch.
fn run_random_manifests(
    count: usize,
    seed: u64,
    longest: impl Fn(&mut Numbers) -> Duration,
    kept: &Path,
    after: impl Fn(&[String], &Outcomes),
) -> (Vec<String>, Outcomes) {
    let mut findings = Findings::kept_in(kept);
    let mut outcomes = Outcomes::default();
    let mut numbers = Numbers(seed);
    while outcomes.seen.values().sum::<usize>() < count {
        let folder = tempfile::tempdir().unwrap();
        let mut files = Vec::new();
        while files.len() < BATCH && outcomes.seen.values().sum::<usize>() < count {
            let manifest = random_manifest(&mut numbers);
            let longest = longest(&mut numbers);
            let Some(bytes) = outcomes.run(&manifest, longest, &mut findings) else { continue };
            let path = folder.path().join(format!("random_{}.mcap", files.len()));
            fs::write(&path, bytes).unwrap();
            let mut verified = None;
            let run = execute(|interrupt| verified = Some(verify(&path, interrupt, &|_, _| {})));
            let finding = match verified {
                _ if run.is_interrupted => run.finding,
                None => run.finding,
                Some(Ok(verified)) => Some(format!("{:?}", verified.finding))
                    .filter(|finding| !finding.starts_with("SameBytes")),
                Some(Err(error)) => Some(error.to_string()),
            };
            if let Some(finding) = finding {
                findings.add("verify", &path, &format!("{finding}\n{manifest}"));
            }
            files.push(path);
        }
        findings.analyze(folder.path(), &files);
        after(&findings.found, &outcomes);
    }
    (findings.found, outcomes)
}

#[test]
fn random_manifests_end_with_a_named_outcome() {
    let kept = tempfile::tempdir().unwrap();
    let (findings, outcomes) = run_random_manifests(60, 3, |_| LONGEST_RUN, kept.path(), |_, _| {});
    assert_none(&findings);
    for outcome in ["complete", "fault", "error of the start"] {
        assert!(outcomes.count(outcome) > 0, "control: no {outcome} in {:?}", outcomes.seen);
    }
}

#[test]
#[ignore = "a campaign of minutes to hours: set MUTATIONS to the number of manifests, and SEED to others"]
#[allow(clippy::print_stderr, reason = "the figures of a campaign")]
fn full_harness_random_manifests() {
    let kept = Path::new("target/mutations");
    let seed = env::var("SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(2);
    let longest = |numbers: &mut Numbers| {
        if numbers.is_one_in(LONG_RUN_IN) { LONGEST_LONG_RUN } else { LONGEST_RUN }
    };
    let print = |findings: &[String], outcomes: &Outcomes| {
        let Outcomes { seen, longest_end, long: [long, interrupted] } = outcomes;
        eprintln!(
            "{seen:?}; of {long} long runs, {interrupted} interrupted; longest end after a signal: {longest_end:?}; {} findings",
            findings.len()
        );
    };
    let (findings, _) = run_random_manifests(mutations(500), seed, longest, kept, print);
    assert_none(&findings);
}

//! Promise: `start_from` begins with the last frame of a recording, bit for bit in all that is taken over.
//!
//! Where the state in a recording is all that a method knows (steps of one length in plain sums: five of the orbit's methods),
//! a run cut in two ends in the bits of the run in one piece. Where more than the state is known on the way (closed forms from
//! the start or from the last hit, compensated sums, own steps, places within cells, the order of DEM's discs), the two agree
//! to rounding: the bound is the number of roundings on the way times 2^-53 times the growth of a small error, or wider.
//!
//! Law: a bed at rest stays at rest when it is gone on with, and moves when its floor is shaken (the control). The measure is
//! its kinetic energy beside that of a fall by a diameter, m g d a disc.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod kinetoscope_program;

use kinetoscope_recording::reader::Recording;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

struct Bench(tempfile::TempDir);

impl Bench {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn experiment(&self, name: &str, text: &str, more: &[&str]) -> Output {
        let manifest = self.path(&format!("{name}.toml"));
        fs::write(&manifest, text).unwrap();
        program().arg(manifest).arg("--output").arg(self.0.path()).args(more).output().unwrap()
    }

    /// Runs an experiment of one run and returns its recording.
    fn run(&self, name: &str, text: &str) -> PathBuf {
        let output = self.experiment(name, text, &["--quiet"]);
        assert!(output.status.success(), "{}", words(&output));
        let recorded = recordings(&self.path(name));
        assert_eq!(recorded.len(), 1);
        recorded[0].clone()
    }

    /// Runs an experiment, calls its recording `FIRST.mcap`, and goes on from it.
    fn run_twice(&self, first: &str, second: &str) -> [PathBuf; 2] {
        let recording = self.run("first", first);
        fs::copy(&recording, self.path("FIRST.mcap")).unwrap();
        [recording, self.run("second", &second.replace("FROM", "start_from = \"FIRST.mcap\""))]
    }

    fn refusal(&self, text: &str) -> String {
        let output = self.experiment("refused", text, &[]);
        assert_eq!(output.status.code(), Some(2));
        words(&output)
    }
}

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_run-experiment"))
}

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn recordings(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut found: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|end| end == "mcap")).collect();
    found.sort();
    found
}

/// The named columns of all particles, of the first or the last frame.
fn state(recording: &Path, last: bool, columns: &[&str]) -> Vec<Vec<f64>> {
    let recording = Recording::open(recording).unwrap();
    let mut frames = recording.frames().unwrap().map(Result::unwrap);
    let frame = if last { frames.last() } else { frames.next() };
    let mut frame = frame.unwrap();
    let table = frame.take_state().unwrap();
    columns.iter().map(|column| table.column(column).unwrap().collect()).collect()
}

fn start(recording: &Path, columns: &[&str]) -> Vec<Vec<f64>> {
    state(recording, false, columns)
}

fn end(recording: &Path, columns: &[&str]) -> Vec<Vec<f64>> {
    state(recording, true, columns)
}

fn bits(columns: &[Vec<f64>]) -> Vec<u64> {
    columns.iter().flatten().map(|value| value.to_bits()).collect()
}

fn largest_difference(one: &[Vec<f64>], other: &[Vec<f64>]) -> f64 {
    let pairs = one.iter().flatten().zip(other.iter().flatten());
    let apart = pairs.map(|(one, other)| (one - other).abs());
    apart.fold(0.0, |most, next| if next > most { next } else { most })
}

const ORBIT: [&str; 6] = ["x", "y", "z", "vx", "vy", "vz"];
const MOTION: [&str; 4] = ["x", "y", "vx", "vy"];

#[test]
fn orbits_of_plain_fixed_steps_have_the_bits_of_the_undivided_run() {
    for integrator in
        ["explicit-euler", "semi-implicit-euler", "velocity-verlet", "rk4", "yoshida4"]
    {
        let bench = Bench::new();
        let orbit = |start: &str, days: f64| {
            format!(
                "[model.orbit]\n{start}\nintegrator = \"{integrator}\"\nduration_days = {days}\n[record]\nframes = 1\n"
            )
        };
        let [first, second] = bench.run_twice(&orbit("", 100.0), &orbit("FROM", 265.25));
        let whole = bench.run("whole", &orbit("", 365.25));
        assert_eq!(bits(&end(&first, &ORBIT)), bits(&start(&second, &ORBIT)), "{integrator}");
        assert_eq!(bits(&end(&second, &ORBIT)), bits(&end(&whole, &ORBIT)), "{integrator}");
        // Control: another day is another place.
        assert_ne!(bits(&end(&first, &ORBIT)), bits(&end(&whole, &ORBIT)));
    }
}

/// A thousand roundings of 1e-16 grow with the phase's error, by about three a revolution: below 1e-12.
#[test]
fn orbits_that_know_more_than_their_state_agree_to_rounding() {
    for keys in [
        "integrator = \"kepler\"",
        "integrator = \"rk4\"\nsummation = \"compensated\"",
        "integrator = \"dormand-prince8\"",
    ] {
        let bench = Bench::new();
        let orbit = |start: &str, days: f64| {
            format!(
                "[model.orbit]\n{start}\n{keys}\nduration_days = {days}\n[record]\nframes = 1\n"
            )
        };
        let [_, second] = bench.run_twice(&orbit("", 100.0), &orbit("FROM", 265.25));
        let whole = bench.run("whole", &orbit("", 365.25));
        let apart = largest_difference(&end(&second, &ORBIT), &end(&whole, &ORBIT));
        println!("{}: {apart:e}", keys.replace('\n', ", "));
        assert!(apart < 1e-12, "{keys}: {apart:e}");
    }
}

/// Some ten hits of the wall, and at grazing hits an error grows by some hundred: below 1e-11 of the radius.
#[test]
fn a_gas_agrees_to_rounding_and_can_be_heated() {
    let bench = Bench::new();
    let gas = |start: &str, duration: f64| {
        format!(
            "[model.gas]\nparticles = 50\n{start}\nduration_s = {duration}\n[record]\nframes = 1\n"
        )
    };
    let [first, second] = bench.run_twice(&gas("", 2e-3), &gas("FROM", 3e-3));
    let whole = bench.run("whole", &gas("", 5e-3));
    assert_eq!(bits(&end(&first, &MOTION)), bits(&start(&second, &MOTION)));
    let places = ["x", "y"];
    let apart = largest_difference(&end(&second, &places), &end(&whole, &places));
    let stepped = |text: String| {
        text.replace("[record]", "propagation = \"stepped\"\ntime_step_s = 1e-6\n[record]")
    };
    let in_steps = bench.run("in_steps", &stepped(gas("start_from = \"FIRST.mcap\"", 3e-3)));
    let whole_in_steps = bench.run("whole_in_steps", &stepped(gas("", 5e-3)));
    let apart_in_steps =
        largest_difference(&end(&in_steps, &places), &end(&whole_in_steps, &places));
    println!("gas: exact {apart:e} m of 1 m, stepped {apart_in_steps:e} m");
    assert!(apart < 1e-11 && apart_in_steps < 1e-11);

    // Four times the temperature is twice every speed: T by equation (13) of the gas document.
    let heated = gas("start_from = \"FIRST.mcap\"\ntemperature_k = 1200.0", 3e-3);
    let heated = start(&bench.run("heated", &heated), &["vx", "vy"]);
    let cold = end(&first, &["vx", "vy"]);
    let doubled: Vec<Vec<f64>> =
        cold.iter().map(|column| column.iter().map(|v| 2.0 * v).collect()).collect();
    assert!(largest_difference(&heated, &doubled) < 1e-9);
}

/// A collision or two a disc, each of which multiplies an error by about ten: from 1e-14 to well below 1e-9 of a
/// radius. Elastic discs keep their energy to rounding all the same.
#[test]
fn a_packing_goes_on_with_its_radii_and_its_energy() {
    let bench = Bench::new();
    let packing = |start: &str, duration: f64| {
        format!(
            "[model.packing]\ndiscs = 30\nradius = 1.0\npolydispersity = 0.2\nwall_noise_variance_rad2 = 0\n{start}\n\
             duration = {duration}\n[record]\nframes = 1\n"
        )
    };
    let [first, second] = bench.run_twice(&packing("", 20.0), &packing("FROM", 5.0));
    let whole = bench.run("whole", &packing("", 25.0));
    let all = ["x", "y", "vx", "vy", "radius"];
    assert_eq!(bits(&end(&first, &all[2..])), bits(&start(&second, &all[2..])));
    // A place is kept within its cell: written out anew it is rounded once more, to 2^-53 of half the box of 40.
    assert!(largest_difference(&end(&first, &all), &start(&second, &all)) < 1e-14);
    let apart = largest_difference(&end(&second, &all), &end(&whole, &all));
    println!("packing: {apart:e} of a radius of 1");
    assert!(apart < 1e-9, "{apart:e}");
    let energy = |state: Vec<Vec<f64>>| state.iter().flatten().map(|v| v * v).sum::<f64>();
    let (before, after) = (energy(end(&first, &["vx", "vy"])), energy(end(&second, &["vx", "vy"])));
    assert!((after / before - 1.0).abs() < 1e-12);
    let refusal = bench.refusal(&packing("start_from = \"FIRST.mcap\"", 5.0).replace("0.2", "0.1"));
    assert!(refusal.contains("polydispersity = "), "{refusal}");
}

/// A bed on a floor of its own, which may be shaken, with friction.
fn bed(friction: f64, start: &str, floor: &str, duration_s: f64) -> String {
    format!(
        "[model.dem]\ndiscs = 40\nradius_m = {{ min = 4e-4, max = 6e-4 }}\nwidth_m = 0.01\nheight_m = 0.02\nfriction = {friction}\n\
         walls = [{{ from_m = [0.0, 0.001], to_m = [0.01, 0.001]{floor} }}]\nregion_m = [[0.0, 0.001], [0.01, 0.02]]\n\
         {start}\nduration_s = {duration_s}\n[record]\nframes = 10\n"
    )
    .replace("region_m = [[0.0, 0.001], [0.01, 0.02]]\nstart_from", "start_from")
}

/// Kinetic energy of a disc of 1 g over its weight times its mean diameter, the mean over all.
fn liveliness(recording: &Path) -> f64 {
    let velocities = end(recording, &["vx", "vy"]);
    let squares: f64 = velocities.iter().flatten().map(|v| v * v).sum();
    0.5 * squares / velocities[0].len() as f64 / (9.81 * 1e-3)
}

#[test]
fn a_settled_bed_stays_at_rest_or_is_shaken() {
    // With friction its springs begin unstretched, and the bed yields until they bear: some hundredths of a radius.
    for (friction, longest_way) in [(0.0, 1e-7), (0.3, 5e-5)] {
        settled_then_shaken(friction, longest_way);
    }
}

fn settled_then_shaken(friction: f64, longest_way: f64) {
    let bench = Bench::new();
    let bed = |start: &str, floor: &str, duration_s: f64| bed(friction, start, floor, duration_s);
    let [first, second] = bench.run_twice(&bed("", "", 0.6), &bed("FROM", "", 0.1));
    let carried = ["x", "y", "vx_step", "vy_step", "radius"];
    assert_eq!(bits(&end(&first, &carried)), bits(&start(&second, &carried)));
    let shaken =
        bed("start_from = \"FIRST.mcap\"", ", amplitude_m = [0.0, 5e-4], frequency_hz = 50.0", 0.1);
    let shaken = bench.run("shaken", &shaken);
    assert_eq!(bits(&start(&second, &carried[..2])), bits(&start(&shaken, &carried[..2])));
    let (before, rest, lively) = (liveliness(&first), liveliness(&second), liveliness(&shaken));
    let moved = largest_difference(&end(&second, &["x", "y"]), &end(&first, &["x", "y"]));
    println!(
        "friction {friction}: kinetic over m g d: settled {before:e}, gone on with {rest:e}, shaken {lively:e}; moved {moved:e} m"
    );
    assert!(before < 1e-3 && rest < 1e-3 && lively > 1e-2);
    assert!(moved < longest_way, "{moved:e}");
}

/// One bed, a sweep over it: each run begins with the same state; the path is no part of the content key, the state is.
#[test]
fn a_sweep_reuses_a_bed_and_its_key_follows_the_state() {
    let bench = Bench::new();
    let recording = bench.run("first", &bed(0.3, "", "", 0.02));
    fs::copy(&recording, bench.path("bed.mcap")).unwrap();
    let sweep = bed(0.3, "start_from = \"bed.mcap\"", "", 0.01)
        + "[sweep]\n\"model.dem.restitution\" = [0.3, 0.5, 0.7]\n";
    assert!(bench.experiment("sweep", &sweep, &["--quiet"]).status.success());
    let before = recordings(&bench.path("sweep"));
    let starts = before.iter().map(|file| bits(&start(file, &["x", "y"])));
    assert!(
        before.len() == 3
            && starts
                .into_iter()
                .all(|bits_of_one| bits_of_one == bits(&end(&recording, &["x", "y"])))
    );

    fs::create_dir(bench.path("elsewhere")).unwrap();
    fs::rename(bench.path("bed.mcap"), bench.path("elsewhere/other.mcap")).unwrap();
    let moved = sweep.replace("bed.mcap", "elsewhere/other.mcap");
    let nothing = bench.experiment("sweep", &moved, &[]);
    assert!(words(&nothing).contains("Nothing to do"), "{}", words(&nothing));

    let other = bench.run("other", &("seed = 5\n".to_owned() + &bed(0.3, "", "", 0.02)));
    fs::copy(other, bench.path("elsewhere/other.mcap")).unwrap();
    let why = kinetoscope_program::kinetoscope()
        .arg("why")
        .arg(bench.path("sweep.toml"))
        .arg("--output")
        .arg(bench.path(""))
        .output()
        .unwrap();
    assert_eq!(words(&why).matches("model.dem.start_from: ").count(), 3, "{}", words(&why));

    // A task of a cluster has a copy of the manifest, and is told where the paths in it begin.
    let copy = bench.path("copy");
    fs::create_dir(&copy).unwrap();
    fs::write(copy.join("sweep.toml"), &sweep).unwrap();
    fs::copy(&recording, bench.path("bed.mcap")).unwrap();
    let key = Recording::open(&before[0]).unwrap().provenance().content_key.clone();
    let task = |more: &[&str]| {
        let mut command = program();
        command.arg(copy.join("sweep.toml")).arg("--output").arg(bench.path("again"));
        command.args(["--quiet", "--only-keys", &key]).args(more).output().unwrap().status.code()
    };
    assert_eq!(task(&["--start-from-dir", bench.path("").to_str().unwrap()]), Some(0));
    assert_eq!(task(&[]), Some(2));
    let again = recordings(&bench.path("again/sweep"));
    assert!(again.len() == 1 && fs::read(&again[0]).unwrap() == fs::read(&before[0]).unwrap());

    let verified =
        |file: &Path| kinetoscope_program::kinetoscope().arg("verify").arg(file).output().unwrap();
    let output = verified(&before[0]);
    assert!(words(&output).contains("equal in every byte"), "{}", words(&output));
    fs::remove_file(&recording).unwrap();
    let output = verified(&before[0]);
    assert_eq!(output.status.code(), Some(5));
    assert!(words(&output).contains("no recording with the content key"), "{}", words(&output));
}

#[test]
fn a_recording_that_no_run_can_start_from_is_refused_at_its_line() {
    let bench = Bench::new();
    let orbit = "[model.orbit]\nduration_days = 10\n[record]\nframes = 2\n";
    let recording = bench.run("orbit", orbit);
    let bytes = fs::read(&recording).unwrap();
    let refusal = |name: &str, contents: Option<&[u8]>, text: &str| {
        if let Some(contents) = contents {
            fs::write(bench.path(name), contents).unwrap();
        }
        let said = bench.refusal(text);
        assert!(said.contains("refused.toml:2:14"), "{said}");
        said
    };
    let from = |model: &str, name: &str| format!("[model.{model}]\nstart_from = \"{name}\"\n");
    assert!(refusal("", None, &from("orbit", "none.mcap")).contains("none.mcap"));
    let other = refusal("orbit.mcap", Some(&bytes), &from("gas", "orbit.mcap"));
    assert!(other.contains("a recording of model orbit, not gas"), "{other}");
    let torn = refusal("torn.mcap", Some(&bytes[..bytes.len() / 2]), &from("orbit", "torn.mcap"));
    assert!(torn.contains("is not finished") || torn.contains("torn"), "{torn}");
    let mut damaged = bytes.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    assert!(
        refusal("damaged.mcap", Some(&damaged), &from("orbit", "damaged.mcap")).contains("damaged")
    );
    assert!(
        refusal("text.mcap", Some(b"no recording"), &from("orbit", "text.mcap"))
            .contains("text.mcap")
    );
    let both = bench.refusal("[model.orbit]\nstart_from = \"orbit.mcap\"\nstart = \"document\"\n");
    assert!(both.contains("exclude each other"), "{both}");

    let gas =
        bench.run("gas", "[model.gas]\nparticles = 7\nduration_s = 1e-4\n[record]\nframes = 1\n");
    fs::copy(gas, bench.path("gas.mcap")).unwrap();
    let number = bench.refusal("[model.gas]\nparticles = 8\nstart_from = \"gas.mcap\"\n");
    assert!(number.contains("must be 7, or be left out"), "{number}");
    let smaller = bench.refusal("[model.gas]\nradius_m = 0.1\nstart_from = \"gas.mcap\"\n");
    assert!(smaller.contains("outside the wall"), "{smaller}");
}

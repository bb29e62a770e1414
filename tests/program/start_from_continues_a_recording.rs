//! Guarantee: `start_from` begins with the last frame of a recording; everything taken from it is bitwise identical.
//!
//! Setup: a run split in two is compared with the undivided run, for every model.
//! Tolerance: none if the recorded state is all that a method uses (fixed steps and plain sums: five integrators of the orbit model).
//! Rounding if a method uses more than the recorded state (closed forms from the start or from the last wall collision, compensated sums,
//! adaptive steps, positions within cells, the order of DEM's discs): number of roundings times 2^-53 times the growth of a small
//! error, or wider.
//!
//! Law: a bed at rest stays at rest when it is continued, measured by its kinetic energy relative to m g d per disc, the energy of a fall
//! by one diameter.
//! Control: the bed moves when its floor is shaken.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::kinetoscope_program;

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

    /// Executes an experiment of one run and returns its recording.
    fn run(&self, name: &str, text: &str) -> PathBuf {
        let output = self.experiment(name, text, &["--quiet"]);
        assert!(output.status.success(), "{}", messages(&output));
        let recorded = recordings(&self.path(name));
        assert_eq!(recorded.len(), 1);
        recorded[0].clone()
    }

    /// Executes an experiment, names its recording `FIRST.mcap`, and continues from it.
    fn run_twice(&self, first: &str, second: &str) -> [PathBuf; 2] {
        let recording = self.run("first", first);
        fs::copy(&recording, self.path("FIRST.mcap")).unwrap();
        [recording, self.run("second", &second.replace("FROM", "start_from = \"FIRST.mcap\""))]
    }

    fn rejection(&self, text: &str) -> String {
        let output = self.experiment("refused", text, &[]);
        assert_eq!(output.status.code(), Some(2));
        messages(&output)
    }
}

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_run-experiment"))
}

fn messages(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn recordings(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut found: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|end| end == "mcap")).collect();
    found.sort();
    found
}

/// The named columns of all particles in the first or the last frame.
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
    let difference = pairs.map(|(one, other)| (one - other).abs());
    difference.fold(0.0, |most, next| if next > most { next } else { most })
}

const ORBIT: [&str; 6] = ["x", "y", "z", "vx", "vy", "vz"];
const MOTION: [&str; 4] = ["x", "y", "vx", "vy"];

#[test]
fn split_orbit_with_fixed_steps_is_bitwise_identical() {
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
        // Control: the positions of another day differ.
        assert_ne!(bits(&end(&first, &ORBIT)), bits(&end(&whole, &ORBIT)));
    }
}

/// Tolerance: a thousand roundings of 1e-16 grow with the phase error, by about three per revolution: below 1e-12.
#[test]
fn split_orbit_with_internal_state_agrees_to_rounding() {
    for keys in [
        "integrator = \"kepler\"",
        "integrator = \"rk4\"\nsummation = \"compensated\"",
        "integrator = \"dop853\"",
    ] {
        let bench = Bench::new();
        let orbit = |start: &str, days: f64| {
            format!(
                "[model.orbit]\n{start}\n{keys}\nduration_days = {days}\n[record]\nframes = 1\n"
            )
        };
        let [_, second] = bench.run_twice(&orbit("", 100.0), &orbit("FROM", 265.25));
        let whole = bench.run("whole", &orbit("", 365.25));
        let difference = largest_difference(&end(&second, &ORBIT), &end(&whole, &ORBIT));
        println!("{}: {difference:e}", keys.replace('\n', ", "));
        assert!(difference < 1e-12, "{keys}: {difference:e}");
    }
}

/// Tolerance: about ten wall collisions, and a grazing one multiplies an error by about a hundred: below 1e-11 of the radius.
#[test]
fn split_gas_agrees_to_rounding_and_can_be_heated() {
    let bench = Bench::new();
    let gas = |start: &str, duration: f64| {
        format!(
            "[model.gas]\nparticles = 50\n{start}\nduration_s = {duration}\n[record]\nframes = 1\n"
        )
    };
    let [first, second] = bench.run_twice(&gas("", 2e-3), &gas("FROM", 3e-3));
    let whole = bench.run("whole", &gas("", 5e-3));
    assert_eq!(bits(&end(&first, &MOTION)), bits(&start(&second, &MOTION)));
    let positions = ["x", "y"];
    let difference = largest_difference(&end(&second, &positions), &end(&whole, &positions));
    let stepped = |text: String| {
        text.replace("[record]", "propagation = \"time-stepped\"\ntime_step_s = 1e-6\n[record]")
    };
    let in_steps = bench.run("in_steps", &stepped(gas("start_from = \"FIRST.mcap\"", 3e-3)));
    let whole_in_steps = bench.run("whole_in_steps", &stepped(gas("", 5e-3)));
    let stepped_difference =
        largest_difference(&end(&in_steps, &positions), &end(&whole_in_steps, &positions));
    println!("gas: exact {difference:e} m of 1 m, stepped {stepped_difference:e} m");
    assert!(difference < 1e-11 && stepped_difference < 1e-11);

    // Four times the temperature doubles every speed: T by equation (13) of the gas exercise.
    let heated = gas("start_from = \"FIRST.mcap\"\ntemperature_k = 1200.0", 3e-3);
    let heated = start(&bench.run("heated", &heated), &["vx", "vy"]);
    let cold = end(&first, &["vx", "vy"]);
    let doubled: Vec<Vec<f64>> =
        cold.iter().map(|column| column.iter().map(|v| 2.0 * v).collect()).collect();
    assert!(largest_difference(&heated, &doubled) < 1e-9);
}

/// Tolerance: one or two collisions per disc, each of which multiplies an error by about ten: from 1e-14 to well below 1e-9 of a
/// radius. Elastic discs conserve their energy to rounding.
#[test]
fn split_packing_keeps_its_radii_and_its_energy() {
    let bench = Bench::new();
    let packing = |start: &str, duration: f64| {
        format!(
            "[model.packing]\ndiscs = 30\nradius = 1.0\nradius_half_width = 0.2\nwall_noise_variance_rad2 = 0\n{start}\n\
             duration = {duration}\n[record]\nframes = 1\n"
        )
    };
    let [first, second] = bench.run_twice(&packing("", 20.0), &packing("FROM", 5.0));
    let whole = bench.run("whole", &packing("", 25.0));
    let all = ["x", "y", "vx", "vy", "radius"];
    assert_eq!(bits(&end(&first, &all[2..])), bits(&start(&second, &all[2..])));
    // A position is stored relative to its cell; each recording rounds it again, to 2^-53 of half the box of 40.
    assert!(largest_difference(&end(&first, &all), &start(&second, &all)) < 1e-14);
    let difference = largest_difference(&end(&second, &all), &end(&whole, &all));
    println!("packing: {difference:e} of a radius of 1");
    assert!(difference < 1e-9, "{difference:e}");
    let energy = |state: Vec<Vec<f64>>| state.iter().flatten().map(|v| v * v).sum::<f64>();
    let (before, after) = (energy(end(&first, &["vx", "vy"])), energy(end(&second, &["vx", "vy"])));
    assert!((after / before - 1.0).abs() < 1e-12);
    let rejection =
        bench.rejection(&packing("start_from = \"FIRST.mcap\"", 5.0).replace("0.2", "0.1"));
    assert!(rejection.contains("radius_half_width = "), "{rejection}");
}

/// A bed with friction on a separate floor, which may be shaken.
fn bed(friction: f64, start: &str, floor: &str, duration_s: f64) -> String {
    format!(
        "[model.dem]\ndiscs = 40\nradius_m = {{ min = 4e-4, max = 6e-4 }}\nwidth_m = 0.01\nheight_m = 0.02\nfriction = {friction}\n\
         integrator = \"semi-implicit-euler\"\n\
         walls = [{{ from_m = [0.0, 0.001], to_m = [0.01, 0.001]{floor} }}]\nplacement_region_m = [[0.0, 0.001], [0.01, 0.02]]\n\
         {start}\nduration_s = {duration_s}\n[record]\nframes = 10\n"
    )
    .replace("placement_region_m = [[0.0, 0.001], [0.01, 0.02]]\nstart_from", "start_from")
}

/// Kinetic energy over weight times mean diameter for discs of 1 g, averaged over all discs.
fn relative_kinetic_energy(recording: &Path) -> f64 {
    let velocities = end(recording, &["vx", "vy"]);
    let squares: f64 = velocities.iter().flatten().map(|v| v * v).sum();
    0.5 * squares / velocities[0].len() as f64 / (9.81 * 1e-3)
}

#[test]
fn settled_bed_stays_at_rest_unless_it_is_shaken() {
    // With friction, the springs start unstretched and the bed yields by a few hundredths of a radius until they carry it.
    for (friction, max_displacement) in [(0.0, 1e-7), (0.3, 5e-5)] {
        settled_then_shaken(friction, max_displacement);
    }
}

fn settled_then_shaken(friction: f64, max_displacement: f64) {
    let bench = Bench::new();
    let bed = |start: &str, floor: &str, duration_s: f64| bed(friction, start, floor, duration_s);
    let [first, second] = bench.run_twice(&bed("", "", 0.6), &bed("FROM", "", 0.1));
    let carried = ["x", "y", "vx_step", "vy_step", "radius"];
    assert_eq!(bits(&end(&first, &carried)), bits(&start(&second, &carried)));
    let shaken =
        bed("start_from = \"FIRST.mcap\"", ", amplitude_m = [0.0, 5e-4], frequency_hz = 50.0", 0.1);
    let shaken = bench.run("shaken", &shaken);
    assert_eq!(bits(&start(&second, &carried[..2])), bits(&start(&shaken, &carried[..2])));
    let (before, rest, shaken) = (
        relative_kinetic_energy(&first),
        relative_kinetic_energy(&second),
        relative_kinetic_energy(&shaken),
    );
    let moved = largest_difference(&end(&second, &["x", "y"]), &end(&first, &["x", "y"]));
    println!(
        "friction {friction}: kinetic energy over m g d: settled {before:e}, continued {rest:e}, shaken {shaken:e}; displacement {moved:e} m"
    );
    assert!(before < 1e-3 && rest < 1e-3 && shaken > 1e-2);
    assert!(moved < max_displacement, "{moved:e}");
}

/// Each run of a sweep starts from the same bed. The run key contains the state, not the path of the recording.
#[test]
fn run_key_contains_the_state_and_not_its_path() {
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
    assert!(messages(&nothing).contains("Nothing to do"), "{}", messages(&nothing));

    let other = bench.run("other", &("seed = 5\n".to_owned() + &bed(0.3, "", "", 0.02)));
    fs::copy(other, bench.path("elsewhere/other.mcap")).unwrap();
    let why = kinetoscope_program::kinetoscope()
        .arg("why")
        .arg(bench.path("sweep.toml"))
        .arg("--output")
        .arg(bench.path(""))
        .output()
        .unwrap();
    assert_eq!(messages(&why).matches("model.dem.start_from: ").count(), 3, "{}", messages(&why));

    // A task of a cluster has a copy of the manifest and receives the folder to which its paths are relative.
    let copy = bench.path("copy");
    fs::create_dir(&copy).unwrap();
    fs::write(copy.join("sweep.toml"), &sweep).unwrap();
    fs::copy(&recording, bench.path("bed.mcap")).unwrap();
    let key = Recording::open(&before[0]).unwrap().provenance().run_key.clone();
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
    assert!(messages(&output).contains("equal in every byte"), "{}", messages(&output));
    fs::remove_file(&recording).unwrap();
    let output = verified(&before[0]);
    assert_eq!(output.status.code(), Some(5));
    assert!(messages(&output).contains("no recording with the run key"), "{}", messages(&output));
}

#[test]
fn unsuitable_recordings_are_rejected_with_their_line() {
    let bench = Bench::new();
    let orbit = "[model.orbit]\nduration_days = 10\n[record]\nframes = 2\n";
    let recording = bench.run("orbit", orbit);
    let bytes = fs::read(&recording).unwrap();
    let rejection = |name: &str, contents: Option<&[u8]>, text: &str| {
        if let Some(contents) = contents {
            fs::write(bench.path(name), contents).unwrap();
        }
        let said = bench.rejection(text);
        assert!(said.contains("refused.toml:2:14"), "{said}");
        said
    };
    let from = |model: &str, name: &str| format!("[model.{model}]\nstart_from = \"{name}\"\n");
    assert!(rejection("", None, &from("orbit", "none.mcap")).contains("none.mcap"));
    let other = rejection("orbit.mcap", Some(&bytes), &from("gas", "orbit.mcap"));
    assert!(other.contains("a recording of model orbit, not gas"), "{other}");
    let torn = rejection("torn.mcap", Some(&bytes[..bytes.len() / 2]), &from("orbit", "torn.mcap"));
    assert!(torn.contains("is not finished") || torn.contains("torn"), "{torn}");
    let mut damaged = bytes.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    assert!(
        rejection("damaged.mcap", Some(&damaged), &from("orbit", "damaged.mcap"))
            .contains("damaged")
    );
    assert!(
        rejection("text.mcap", Some(b"no recording"), &from("orbit", "text.mcap"))
            .contains("text.mcap")
    );
    let both =
        bench.rejection("[model.orbit]\nstart_from = \"orbit.mcap\"\nstart = \"barycentric\"\n");
    assert!(both.contains("cannot be used together"), "{both}");

    let gas =
        bench.run("gas", "[model.gas]\nparticles = 7\nduration_s = 1e-4\n[record]\nframes = 1\n");
    fs::copy(gas, bench.path("gas.mcap")).unwrap();
    let number = bench.rejection("[model.gas]\nparticles = 8\nstart_from = \"gas.mcap\"\n");
    assert!(number.contains("must be 7, or be left out"), "{number}");
    let smaller = bench.rejection("[model.gas]\nradius_m = 0.1\nstart_from = \"gas.mcap\"\n");
    assert!(smaller.contains("outside the wall"), "{smaller}");
}

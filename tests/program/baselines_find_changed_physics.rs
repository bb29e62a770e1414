//! Guarantee: a comparison with a baseline of another seed finds changed physics, or states that nothing could be compared. It passes
//! for changes within the scatter of seeds only, and other seeds of the same physics do not fail.
//!
//! Setup: three scenes of each model with five changes each (`changed_physics.rs`), for single runs and for eight replicates. The keys
//! that change are allowed to differ, as if another version of the program computed something else for the same manifest.
//! Tolerance: of single runs, most of all of beds, few values have an error, so that 45 of 60 changes are found and the others have
//! exit code 3 and the advice to use replicates. Eight replicates find all but two (`WITHIN_SCATTER`).
//! At a level of 0.001, 1 of 960 comparisons of other seeds fails on average.
//! Control: the other seeds.

use crate::changed_physics::{Change, SCENES, SHORT_SCENES, Scene};
use crate::subcommand_bench::Bench;

/// What a comparison states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Finding {
    /// A difference, exit code 3.
    Different,
    /// That nothing could be compared, exit code 3.
    NotComparable,
    /// No difference, exit code 0.
    Equal,
}

/// A scene with its baseline of seed 1.
struct Baseline<'a> {
    bench: Bench,
    scene: &'a Scene,
    replicates: u32,
}

impl<'a> Baseline<'a> {
    fn new(scene: &'a Scene, replicates: u32) -> Self {
        let bench = Bench::new();
        bench.write("scene.toml", &scene.manifest());
        let baseline = Self { bench, scene, replicates };
        baseline.run("baseline", 1, None);
        let analyzed = baseline.bench.call(&["analyze", "--quiet", "--no-replay", "baseline"]);
        assert_eq!(analyzed.code, Some(0), "{}: {}", scene.name, analyzed.err);
        baseline
    }

    fn run(&self, folder: &str, seed: u32, change: Option<&Change>) {
        let mut set = vec![format!("seed={seed}"), format!("replicates={}", self.replicates)];
        set.extend(change.map(|change| format!("{}={}", change.key, change.value)));
        let mut arguments = vec!["run", "--quiet", "--output", folder];
        set.iter().for_each(|set| arguments.extend(["--set", set]));
        arguments.push("scene.toml");
        let ran = self.bench.call(&arguments);
        assert_eq!(ran.code, Some(0), "{}: {}", self.scene.name, ran.err);
    }

    /// Compares a seed, with or without a change, with the baseline; also returns the failures in words.
    fn compare(&self, seed: u32, change: Option<&Change>) -> (Finding, String) {
        self.run("other", seed, change);
        let metrics = format!("baseline/{}/metrics.json", self.scene.name);
        let mut arguments =
            vec!["analyze", "--quiet", "--no-replay", "--json", "--baseline", &metrics, "other"];
        if let Some(change) = change {
            arguments.extend(["--allow-changed", change.key]);
            // A thermal wall has a further key, with its default.
            if change.key.ends_with("wall_temperature_k") {
                arguments.extend(["--allow-changed", "accommodation_coefficient"]);
            }
        }
        let compared = self.bench.call(&arguments);
        std::fs::remove_dir_all(self.bench.path("other")).unwrap();
        let mut documents =
            serde_json::Deserializer::from_str(&compared.out).into_iter::<serde_json::Value>();
        let printed = documents.next().unwrap().unwrap();
        let comparison = &printed["experiments"][0]["baseline"];
        let texts = |list: &str, field: &str| -> Vec<String> {
            let rows = comparison[list].as_array().unwrap().iter();
            let failed = rows.filter(|row| row["passed"] == false || list == "failures");
            failed.map(|row| format!("{}: {}", row["subject"], row[field])).collect()
        };
        let (rows, failures) = (texts("rows", "reason"), texts("failures", "finding"));
        let nothing = failures.iter().any(|text| text.contains("nothing could be compared"));
        let (finding, code) = match (rows.is_empty() && failures.is_empty(), nothing) {
            (true, _) => (Finding::Equal, 0),
            (false, true) => (Finding::NotComparable, 3),
            (false, false) => (Finding::Different, 3),
        };
        assert_eq!(compared.code, Some(code), "{finding:?}: {}", compared.out);
        (finding, rows.into_iter().chain(failures).take(3).collect::<Vec<_>>().join("; "))
    }
}

/// A few cases of the table: errors, exact laws, values that the manifest sets, runs without random numbers, and nothing to compare.
#[test]
fn changed_physics_is_found_or_not_comparable() {
    use Finding::{Different, Equal, NotComparable};
    let few = [
        ("gas_falling", &[(0, Different), (1, Different), (2, Different)][..], Equal),
        ("packing_periodic", &[(1, Different), (3, Different)][..], Equal),
        ("dem_agitated", &[(0, Different), (3, Different), (4, NotComparable)][..], NotComparable),
        ("orbit_circle", &[(0, Different), (4, Different)][..], Equal),
    ];
    for (name, changes, of_seed) in few {
        let scene = SCENES.iter().find(|scene| scene.name == name).unwrap();
        let baseline = Baseline::new(scene, 1);
        for &(index, expected) in changes {
            let change = &scene.changes[index];
            let (finding, text) = baseline.compare(2, Some(change));
            assert_eq!(finding, expected, "{name}, {}: {text}", change.what);
        }
        let (finding, text) = baseline.compare(3, None);
        assert_eq!(finding, of_seed, "control, {name}: {text}");
    }
}

/// Whether a run is long enough for a standard error depends on its seed, and a value that scatters by an unknown amount may leave the
/// accuracy of its law. Control: changes of the same scenes.
#[test]
fn other_seeds_of_runs_too_short_for_errors_do_not_fail() {
    for scene in &SHORT_SCENES {
        let baseline = Baseline::new(scene, 1);
        for seed in (4..10).chain([28]) {
            let (finding, text) = baseline.compare(seed, None);
            assert_ne!(finding, Finding::Different, "{}, seed {seed}: {text}", scene.name);
        }
        let (finding, text) = baseline.compare(2, Some(&scene.changes[3]));
        assert_eq!(finding, Finding::Different, "{}: {text}", scene.name);
    }
}

/// All changes by what a comparison with the baseline states, in words.
#[derive(Default)]
struct Table {
    found: usize,
    not_comparable: Vec<String>,
    missed: Vec<String>,
}

fn table_of_changes(replicates: u32) -> Table {
    let mut table = Table::default();
    for scene in &SCENES {
        let baseline = Baseline::new(scene, replicates);
        for change in &scene.changes {
            let (finding, text) = baseline.compare(2, Some(change));
            let row =
                format!("{} x {replicates}, {}: {finding:?}: {text}", scene.name, change.what);
            println!("{row}");
            match finding {
                Finding::Different => table.found += 1,
                Finding::NotComparable => table.not_comparable.push(row),
                Finding::Equal => table.missed.push(row),
            }
        }
    }
    println!("{replicates} replicates: {} of 60 found", table.found);
    table
}

/// What eight replicates do not find: with twice the time step, the largest energy error of these discs is 4.8 and 3.4 times as large,
/// 2.6 and 3.4 σ of its scatter over seeds.
const WITHIN_SCATTER: [&str; 2] = ["dem_agitated x 8, time step x 2", "dem_gas x 8, time step x 2"];

#[test]
#[ignore = "records 650 runs in a minute"]
fn changed_physics_of_all_models_is_found() {
    let single = table_of_changes(1);
    let replicated = table_of_changes(8);
    assert!(single.missed.is_empty(), "{:#?}", single.missed);
    assert!(single.found >= 45, "{:#?}", single.not_comparable);
    let not_found = [replicated.missed, replicated.not_comparable].concat();
    let is_known = |row: &String| WITHIN_SCATTER.iter().any(|known| row.starts_with(known));
    let not_found: Vec<&String> = not_found.iter().filter(|row| !is_known(row)).collect();
    assert!(not_found.is_empty(), "{not_found:#?}");
}

/// The comparisons of 40 other seeds that fail, in words.
fn false_alarms(replicates: u32) -> Vec<String> {
    let mut alarms = Vec::new();
    for scene in &SCENES {
        let baseline = Baseline::new(scene, replicates);
        for seed in 3..43 {
            let (finding, text) = baseline.compare(seed, None);
            if finding == Finding::Different {
                alarms.push(format!("{} x {replicates}, seed {seed}: {text}", scene.name));
            }
        }
    }
    alarms
}

#[test]
#[ignore = "records 4500 runs in minutes"]
fn forty_other_seeds_of_all_models_do_not_fail() {
    let alarms = [false_alarms(1), false_alarms(8)].concat();
    println!("{} false alarms of 960: {alarms:#?}", alarms.len());
    assert!(alarms.len() <= 2, "{alarms:#?}");
}

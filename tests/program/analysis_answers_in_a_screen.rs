//! Guarantee: `analyze` prints the answer, what failed and the checked numbers in one screen; nothing is lost, `--all` prints the rest.

use crate::subcommand_bench::{Bench, call};
use std::fmt::Write as _;

/// Eighteen runs of a gas with checks.
const SWEEP: &str = "\
question = \"Is the pressure proportional to the temperature?\"
replicates = 6

[model.gas]
particles = 20
duration_s = 0.001

[record]
frames = 4

[sweep]
\"model.gas.temperature_k\" = [200, 300, 400]

[[checks]]
metric = \"energy.drift_relative\"
maximum = 1e-9
";

#[test]
fn sweep_is_answered_in_twenty_five_lines() {
    let bench = Bench::new();
    bench.write("gas.toml", SWEEP);
    assert_eq!(bench.call(&["gas.toml", "--quiet"]).code, Some(0));
    let brief = bench.call(&["analyze", "gas.toml"]);
    assert_eq!(brief.code, Some(0), "{}", brief.err);
    assert!(brief.out.lines().count() <= 25, "{}", brief.out);
    let lines: Vec<&str> = brief.out.lines().collect();
    assert_eq!(lines[1], "Is the pressure proportional to the temperature?");
    assert!(brief.out.contains("3 checks passed"), "{}", brief.out);
    assert!(brief.out.contains("recordings/gas/report.html"), "{}", brief.out);
    let all = bench.call(&["analyze", "--all", "gas.toml"]).out;
    let omitted = brief.out.lines().find(|line| line.starts_with("--all prints")).unwrap();
    let count: usize = omitted.split(' ').find_map(|word| word.parse().ok()).unwrap();
    // Rows of tables begin with a name that is indented by two; each of three points has the checked metric as well.
    let tables = all.split_once("\n\n").unwrap().1.split("\nchecks\n").next().unwrap();
    let names = tables.lines().filter(|line| {
        let name = line.strip_prefix("  ").filter(|name| !name.starts_with("metric"));
        name.is_some_and(|name| name.starts_with(|c: char| c.is_ascii_lowercase()))
    });
    let rows = names.filter(|line| !line.contains(": ")).count();
    assert_eq!(rows, count + 3, "{all}");
    for metric in ["pressure.measured", "energy.drift_relative"] {
        assert!(all.contains(metric), "{metric}");
    }
}

/// Control: what failed is not omitted.
#[test]
fn failures_are_all_printed() {
    let bench = Bench::new();
    let mut manifest = SWEEP.to_owned();
    for bound in 1..4 {
        let _ = write!(manifest, "\n[[checks]]\nmetric = \"mean_speed\"\nmaximum = {bound}\n");
    }
    bench.write("gas.toml", &manifest);
    assert_eq!(bench.call(&["gas.toml", "--quiet"]).code, Some(0));
    let brief = bench.call(&["analyze", "gas.toml"]);
    assert_eq!(brief.code, Some(3), "{}", brief.err);
    assert_eq!(brief.out.matches("  FAILED ").count(), 9, "{}", brief.out);
    assert!(brief.out.contains("9 of 12 checks failed, 3 of 12 checks passed"), "{}", brief.out);
}

#[test]
fn metrics_are_found_by_words() {
    let found = call(["analyze", "--list-metrics", "gas", "Pressure"]);
    assert_eq!(found.code, Some(0), "{}", found.err);
    assert!(found.out.contains("pressure.measured (gas, "), "{}", found.out);
    assert!(!found.out.contains("(dem") && !found.out.contains("do not edit"), "{}", found.out);
    let none = call(["analyze", "--list-metrics", "gas", "zzz"]);
    assert_eq!(none.code, Some(2));
    assert!(none.err.contains("\nhelp: "), "{}", none.err);
}

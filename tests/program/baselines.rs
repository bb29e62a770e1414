//! Guarantee: correct experiments with another seed agree with a baseline, changed experiments do not, and the same run is
//! equal to the last digit.
//!
//! Setup: the starter manifests of all models, as `kinetoscope new` prints them. Tolerance: at a level of 0.001 for all metrics
//! together, 0.04 of 40 seeds fail on average; more than two of 40 fail for one baseline in a hundred.

use crate::subcommand_bench::{Bench, Called, call};
use std::fs;

/// Models with keys of which a change by 1 % must be named.
const CHANGES: &[(&str, &[(&str, &str)])] = &[
    ("gas", &[("model.gas.temperature_k", "303.0"), ("model.gas.radius_m", "1.01")]),
    ("packing", &[("model.packing.restitution", "0.99"), ("model.packing.radius", "1.01")]),
    (
        "dem",
        &[
            ("model.dem.restitution", "0.505"),
            ("model.dem.radius_m", "0.000505"),
            ("model.dem.steps_per_wall_contact", "20.2"),
        ],
    ),
    ("orbit", &[("model.orbit.time_step_days", "1.01")]),
];

/// A starter with its baseline of seed 1.
struct Starter {
    bench: Bench,
    model: &'static str,
}

impl Starter {
    fn new(model: &'static str) -> Self {
        let bench = Bench::new();
        let starter = call(["new", model]);
        assert_eq!(starter.code, Some(0), "{}", starter.err);
        bench.write("starter.toml", &starter.out);
        let starter = Self { bench, model };
        starter.run("baseline", &["seed=1"]);
        let analyzed = starter.bench.call(&["analyze", "--quiet", "baseline"]);
        assert_eq!(analyzed.code, Some(0), "{model}: {}", analyzed.err);
        starter
    }

    /// Executes the starter with some keys changed.
    fn run(&self, folder: &str, set: &[&str]) {
        let mut arguments = vec!["run", "--quiet", "--output", folder];
        set.iter().for_each(|set| arguments.extend(["--set", set]));
        arguments.push("starter.toml");
        let ran = self.bench.call(&arguments);
        assert_eq!(ran.code, Some(0), "{}: {}", self.model, ran.err);
    }

    /// Compares a folder with the baseline.
    fn compare(&self, folder: &str) -> Called {
        self.bench.call(&["analyze", "--baseline", "baseline/starter/metrics.json", folder])
    }
}

/// Lines of the terminal that name failures.
fn failures(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let starts = lines.iter().enumerate().filter(|(_, line)| line.contains("FAILED"));
    starts.map(|(at, _)| lines[at..(at + 3).min(lines.len())].join(" ") + "\n").collect()
}

/// Guarantee: every metric of every starter has a value with an error, or a reason.
#[test]
fn every_metric_has_an_error_or_a_reason() {
    for (model, _) in CHANGES {
        let starter = Starter::new(model);
        let file = starter.bench.path("baseline/starter/metrics.json");
        let document: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
        let metrics = document["metrics"].as_array().unwrap();
        assert!(!metrics.is_empty());
        for metric in metrics {
            let has_error = metric["value"].is_f64() && metric["standard_error"].is_f64();
            assert!(has_error || metric["reason"].is_string(), "{model}: {metric}");
        }
    }
}

/// Guarantee: the first report of a new user asks a question, answers it with a number, and shows the requested plot, and next to it that of the answer if a number
/// is swept.
#[test]
fn first_report_of_every_starter_answers_its_question() {
    let swept = ["gas.temperature_k", "packing.discs", "dem.restitution", "orbit.time_step_days"];
    let values = ["[300.0, 400.0]", "[20, 40]", "[0.5, 0.8]", "[0.5, 1.0]"];
    for ((model, _), (key, values)) in CHANGES.iter().zip(swept.iter().zip(values)) {
        let starter = Starter::new(model);
        let sweep = format!("[sweep]\n\"model.{key}\" = {values}\n");
        let text = call(["new", model]).out + &sweep;
        starter.bench.write("swept.toml", &text);
        let ran = starter.bench.call(&["run", "--quiet", "--output", "baseline", "swept.toml"]);
        assert_eq!(ran.code, Some(0), "{model}: {}", ran.err);
        let analyzed = starter.bench.call(&["analyze", "--quiet", "baseline/swept"]);
        assert_eq!(analyzed.code, Some(0), "{model}: {}", analyzed.err);
        for name in ["starter", "swept"] {
            let folder = starter.bench.path("baseline").join(name);
            let metrics = fs::read_to_string(folder.join("metrics.json")).unwrap();
            let metrics: serde_json::Value = serde_json::from_str(&metrics).unwrap();
            assert!(metrics["question"].as_str().unwrap().ends_with('?'), "{model}: {name}");
            let answer = &metrics["answer"];
            assert!(answer["numbers"][0]["text"].is_string(), "{model}, {name}: {answer}");
            let text = answer["text"].as_str().unwrap();
            let is_begun = text.starts_with("The ") || text.starts_with("With ");
            assert!(is_begun && !text.contains('_'), "{model}, {name}: {text}");
            let page = fs::read_to_string(folder.join("report.html")).unwrap();
            let plots = page.split("class=\"adjacent\"").nth(1).unwrap();
            let mut plots = plots.split("</figure>");
            let mut is_over_key = || {
                let plot = plots.next().unwrap();
                plot.contains("_vs_") && !plot.contains("_vs_time\"")
            };
            // That of the answer, and behind it the plot that the starter requests, which has no title of its own.
            assert_eq!(name == "swept", is_over_key(), "{model}, {name}");
            assert!(!is_over_key(), "{model}, {name}");
        }
    }
}

#[test]
#[ignore = "records 160 runs"]
fn forty_seeds_of_every_starter_agree_with_one() {
    let mut report = String::new();
    let mut rejected = Vec::new();
    for (model, _) in CHANGES {
        let starter = Starter::new(model);
        let mut failed = 0;
        for seed in 2..=41 {
            starter.run("other", &[&format!("seed={seed}")]);
            let compared = starter.compare("other");
            assert!(matches!(compared.code, Some(0 | 3)), "{}", compared.err);
            // A bed has no error in a single run, and the pressure of few discs is hardly above that of points.
            let is_comparable = !compared.out.contains("nothing could be compared")
                && !compared.out.contains("this comparison is insensitive");
            assert!(
                is_comparable || ["dem", "packing"].contains(model),
                "{model}: {}",
                compared.out
            );
            if compared.code == Some(3) && is_comparable {
                failed += 1;
                report += &format!("{model}, seed {seed}:\n{}", failures(&compared.out));
            }
            fs::remove_dir_all(starter.bench.path("other")).unwrap();
        }
        report += &format!("{model}: {failed} of 40 seeds fail\n");
        if failed > 2 {
            rejected.push(*model);
        }
    }
    println!("{report}");
    assert!(rejected.is_empty(), "more than 2 of 40 seeds fail: {rejected:?}\n{report}");
}

#[test]
#[ignore = "records 13 runs"]
fn changed_keys_fail_and_are_named_and_the_same_run_is_equal() {
    for (model, changes) in CHANGES {
        let starter = Starter::new(model);
        starter.run("again", &["seed=1"]);
        let same = starter.compare("again");
        assert_eq!(same.code, Some(0), "{model}: {}", same.out);
        assert!(same.out.contains("equal to the last digit"), "{model}: {}", same.out);
        for (key, value) in *changes {
            starter.run("changed", &["seed=1", &format!("{key}={value}")]);
            let changed = starter.compare("changed");
            assert_eq!(changed.code, Some(3), "{key}: {}", changed.out);
            let words: Vec<&str> = changed.out.split_whitespace().collect();
            let text = words.join(" ");
            assert!(text.contains(&format!("FAILED keys of 1 run: {key}: ")), "{key}: {text}");
            assert!(text.contains(&format!(" → {value}")), "{key}: {text}");
            fs::remove_dir_all(starter.bench.path("changed")).unwrap();
        }
    }
}

/// Guarantee: a metric that some seeds do not have is no difference. Setup: a bed that settles, or has flying discs at its end, by chance.
#[test]
fn metrics_that_only_some_seeds_have_do_not_fail() {
    let bench = Bench::new();
    bench.write(
        "tilt.toml",
        "replicates = 8\n[model.dem]\ndiscs = 60\nwidth_m = 0.02\nheight_m = 0.03\nrestitution = 0.8\nfriction = 0.3\n\
         duration_s = 0.14\n[record]\nframes = 60\n",
    );
    let run = |seed: &str, output: &str| {
        let arguments = ["run", "--quiet", "tilt.toml", "--set", seed, "--output", output];
        assert_eq!(bench.call(&arguments).code, Some(0));
        let analyzed = bench.call(&["analyze", "--quiet", &format!("{output}/tilt")]);
        assert_eq!(analyzed.code, Some(0), "{}", analyzed.err);
    };
    run("seed=1000", "before");
    run("seed=1", "now");
    let arguments = ["analyze", "now/tilt", "--baseline", "before/tilt/metrics.json"];
    let compared = bench.call(&arguments);
    assert_eq!(compared.code, Some(0), "{}{}", compared.out, compared.err);
}

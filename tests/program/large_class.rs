//! Guarantee: a class of 1,000 hand-ins, right, wrong and hostile ones, is graded with one line each, and hostile ones are not run to their end.
//!
//! Setup: the solutions of the 36 exercises of the book with 1,000 seeds, and eleven changes. Seconds are printed and not asserted:
//! `cargo test --release -p kinetoscope-program --test program -- --ignored --nocapture full_harness_class`

use crate::subcommand_bench::Bench;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Instant;
use toml::{Table, Value};

const HAND_INS: u64 = 1000;

fn set(answer: &mut Table, table: &[&str], key: &str, value: impl Into<Value>) {
    let place = table.iter().fold(answer, |place, name| place[*name].as_table_mut().unwrap());
    place.insert(key.to_owned(), value.into());
}

/// The hand-in of this number, and what its line must contain; empty for any result.
fn hand_in(number: u64, solution: &str) -> (String, &'static str) {
    let mut answer: Table = solution.parse().unwrap();
    let model = answer["model"].as_table().unwrap().keys().next().unwrap().clone();
    let model = ["model", model.as_str()];
    let is_drawn = answer.contains_key("seed");
    if is_drawn {
        set(&mut answer, &[], "seed", 1000 + number as i64);
    }
    let value = answer["exercise"]["value"].as_float().unwrap();
    let expected = match number / 36 % 20 {
        0..8 => {
            if is_drawn {
                ""
            } else {
                "accepted"
            }
        }
        8 | 9 => {
            set(&mut answer, &["exercise"], "value", 1.37 * value);
            "value"
        }
        10 => {
            set(&mut answer, &["exercise"], "unit", "furlong");
            "`furlong` is not among the units"
        }
        11 => {
            set(&mut answer, &["exercise"], "standard_error", 10.0 * value.abs());
            "standard error"
        }
        12 => {
            set(&mut answer, &["record"], "frames", 1_000_000_000);
            "not graded"
        }
        13 => {
            set(&mut answer, &[], "replicates", 1_000_000);
            "not graded"
        }
        14 => {
            set(&mut answer, &[], "replicates", 16);
            set(&mut answer, &model, "particles", 20_000);
            ""
        }
        15 => {
            for key in ["duration_s", "duration_days", "events_per_disc"] {
                if answer["model"][model[1]].get(key).is_some() {
                    set(&mut answer, &model, key, 1e7);
                }
            }
            "not graded"
        }
        16 => {
            for (key, value) in [("temperature_k", 1e9), ("stiffness_n_per_m", 1e14)] {
                set(&mut answer, &model, key, value);
            }
            ""
        }
        17 => return (format!("a = {}1{}", "[".repeat(400), "]".repeat(400)), "not graded"),
        18 => return ("\u{0}\u{1b}[31m".repeat(50), "not graded"),
        _ => return (solution.chars().take(150).collect(), "not graded"),
    };
    (answer.to_string(), expected)
}

#[test]
#[ignore = "grades 1,000 hand-ins, for some minutes"]
fn full_harness_class_of_a_thousand_is_graded_with_one_line_each() {
    let bench = Bench::new();
    fs::create_dir(bench.path("class")).unwrap();
    let solutions = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book/solutions");
    let mut solved = Vec::new();
    for lesson in fs::read_dir(&solutions).unwrap() {
        for file in fs::read_dir(lesson.unwrap().path()).unwrap() {
            let file = file.unwrap().path();
            if !file.to_string_lossy().ends_with(".key.toml") {
                solved.push(file);
            }
        }
    }
    solved.sort();
    let mut expected = BTreeMap::new();
    for number in 0..HAND_INS {
        let solution = fs::read_to_string(&solved[number as usize % solved.len()]).unwrap();
        let (text, words) = hand_in(number, &solution);
        let name = format!("{number:04}.toml");
        bench.write(&format!("class/{name}"), &text);
        expected.insert(name, words);
    }
    let started = Instant::now();
    let graded =
        bench.call(&["grade", "--class", "class", "--solutions", &solutions.to_string_lossy()]);
    println!("{HAND_INS} hand-ins in {:.0} s", started.elapsed().as_secs_f64());
    println!("{}", graded.out.lines().last().unwrap());
    assert_eq!(graded.code, Some(4), "{}", graded.err);
    // A title, and a total.
    assert_eq!(graded.out.trim().lines().count() as u64, HAND_INS + 2);
    for line in graded.out.lines().skip(1).take(HAND_INS as usize) {
        let words = expected[&line[..9]];
        assert!(line.contains(words), "expected `{words}`: {line}");
    }
}

//! Guarantee: a hand-in of at most 1,024 bytes is graded by rerunning it. Damaged, edited and hostile ones are reported on one line each
//! and stop no other.

use crate::subcommand_bench::{Bench, Called};
use std::fs;
use std::path::Path;

/// A solved exercise with a short run.
const ANSWER: &str = "seed = 5
[model.gas]
particles = 100
speeds_m_per_s = [300.0, 900.0]
duration_s = 0.001
[record]
frames = 2
[exercise]
name = \"temperature_and_speed/two_speeds\"
value = 162.97
unit = \"K\"
standard_error = 0.0
";
const KEY: &str =
    "metric = \"temperature.mean_square\"\nrelative_tolerance = 0.002\n[units]\n\"K\" = 1\n";

/// A folder with the key of the exercise, and the hand-in of the answer in the folder `class`.
fn bench() -> Bench {
    let bench = Bench::new();
    let folder = bench.path("solutions/temperature_and_speed");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("two_speeds.key.toml"), KEY).unwrap();
    fs::write(folder.join("two_speeds.toml"), ANSWER).unwrap();
    fs::create_dir(bench.path("class")).unwrap();
    bench.write("answer.toml", ANSWER);
    let written = bench.call(&["grade", "answer.toml", "--hand-in", "class/a.toml"]);
    assert_eq!(written.code, Some(0), "{}", written.err);
    bench
}

fn class(bench: &Bench, more: &[&str]) -> Called {
    bench.call(&[&["grade", "--class", "class"], more].concat())
}

fn hand_in(bench: &Bench) -> String {
    fs::read_to_string(bench.path("class/a.toml")).unwrap()
}

#[test]
fn small_numbers_of_a_hand_in_have_an_exponent() {
    let bench = bench();
    bench.write("small.toml", &ANSWER.replace("162.97", "1.6297e-22"));
    let written = bench.call(&["grade", "small.toml", "--hand-in", "small_hand_in.toml"]);
    assert_eq!(written.code, Some(0), "{}", written.err);
    let text = fs::read_to_string(bench.path("small_hand_in.toml")).unwrap();
    assert!(text.contains("\nvalue = 1.6297e-22\n"), "{text}");
}

#[test]
fn hand_in_is_small_and_accepted() {
    let bench = bench();
    assert!(hand_in(&bench).len() <= 1024);
    let graded = class(&bench, &[]);
    assert_eq!(graded.code, Some(0), "{}", graded.err);
    assert!(graded.out.contains("1 of 1 hand-in accepted"), "{}", graded.out);
}

/// Each bad hand-in has its line, and the good one between them is accepted.
#[test]
fn bad_hand_ins_are_named_and_stop_no_other() {
    let bench = bench();
    let good = hand_in(&bench);
    let hash = good.split("hash = \"").nth(1).unwrap()[..32].to_owned();
    let changes: &[(&str, String, &str)] = &[
        ("copy", good.clone(), "identical to a.toml"),
        ("other_value", good.replace("162.97", "162.98"), "(same runs as a.toml)"),
        ("edited", good.replace("seed = 5", "seed = 6"), "the hash is not that of these runs"),
        ("hash", good.replace(&hash, &"0".repeat(32)), "the hash is not that of these runs"),
        ("empty", String::new(), "not graded"),
        ("words", "My answer is 163 K.".to_owned(), "not graded"),
        ("none", good.replace(&format!("hash = \"{hash}\""), ""), "accepted (no hash)"),
        ("long", format!("{good}# {}", "x".repeat(1024)), "larger than 1024 bytes"),
        (
            "path",
            good.replace("temperature_and_speed/two_speeds", "../../etc/passwd"),
            "must be a lesson and a name",
        ),
        ("html", good.replace("two_speeds", "<script>"), "must be a lesson and a name"),
        ("unit", good.replace("\"K\"", "\"<b>\""), "is not a unit"),
        ("other", good.replace("two_speeds", "three_speeds"), "the key of the exercise"),
        (
            "many",
            good.replace("particles = 100", "particles = 1000000000"),
            "at most 400 are graded",
        ),
        ("runs", good.replace("seed = 5", "seed = 5\nreplicates = 1000"), "at most 64 are graded"),
        ("frames", good.replace("frames = 2", "frames = 100000000"), "are graded"),
        ("binary", "\u{0}\u{1}\u{1b}[31m".to_owned(), "not graded"),
        (
            "start",
            good.replace("duration_s", "start_from = \"/etc/passwd\"\nduration_s"),
            "not graded",
        ),
    ];
    for (name, text, _) in changes {
        assert!(*name == "copy" || *text != good, "{name} changes nothing");
        bench.write(&format!("class/{name}.toml"), text);
    }
    bench.write("class/anna müller (2).toml", &good);
    bench.write("class/zoe.TOML", &good);
    bench.write("class/anna.toml.txt", &good);
    fs::create_dir(bench.path("class/folder.toml")).unwrap();
    let graded = class(&bench, &[]);
    assert_eq!(graded.code, Some(4), "{}", graded.err);
    let line = |name: &str| {
        let start = format!("{name}.toml ");
        graded
            .out
            .lines()
            .find(|line| line.starts_with(&start))
            .unwrap_or_else(|| panic!("{name}: {}", graded.out))
    };
    assert!(line("a").ends_with("accepted"), "{}", graded.out);
    for (name, _, expected) in changes {
        assert!(line(name).contains(expected), "{name}: {}", line(name));
    }
    assert!(line("folder").contains("not graded"), "{}", line("folder"));
    assert!(line("anna müller (2)").contains("accepted"), "{}", graded.out);
    assert!(
        graded.out.contains("zoe.TOML") && graded.out.contains("not graded: not a *.toml file")
    );
    assert!(!graded.out.contains('\u{1b}') && !graded.out.contains("<script>"), "{}", graded.out);
    // One line per hand-in, a title and a total.
    assert_eq!(graded.out.trim().lines().count(), changes.len() + 5 + 2, "{}", graded.out);
}

/// What the exercise does not ask for is not run to its end, and its keys are named.
#[test]
fn runs_beyond_those_of_the_exercise_are_rejected() {
    let bench = bench();
    let good = hand_in(&bench);
    let changes = [
        (
            "duration",
            good.replace("duration_s = 0.001", "duration_s = 0.005"),
            "more than 4 times the work of the exercise: check `model.gas.duration_s`",
        ),
        (
            "speeds",
            good.replace("[300.0, 900.0]", "[3e9, 9e9]\ndisc_radius_m = 0.01"),
            "the runs take more than 30 s: check `model.gas.",
        ),
    ];
    for (name, text, expected) in changes {
        assert_ne!(text, good, "{name} changes nothing");
        bench.write(&format!("class/{name}.toml"), &text);
        let graded = class(&bench, &[]);
        let line = graded.out.lines().find(|line| line.starts_with(&format!("{name}.toml ")));
        assert!(line.is_some_and(|line| line.contains(expected)), "{}", graded.out);
    }
}

#[test]
fn hand_in_of_another_lesson_is_named() {
    let bench = bench();
    let unknown = class(&bench, &["--lesson", "gas_pressure"]);
    assert_eq!(unknown.code, Some(2), "{}", unknown.out);
    assert!(unknown.err.contains("has no lesson gas_pressure"), "{}", unknown.err);
    fs::create_dir(bench.path("solutions/gas_pressure")).unwrap();
    let graded = class(&bench, &["--lesson", "gas_pressure"]);
    assert_eq!(graded.code, Some(0), "{}", graded.out);
    let skipped = "skipped: a hand-in of the lesson temperature_and_speed";
    assert!(graded.out.contains(skipped), "{}", graded.out);
}

#[test]
fn folders_without_hand_ins_are_bad_input() {
    let bench = bench();
    fs::create_dir(bench.path("none")).unwrap();
    for (folder, expected) in
        [("none", "has no hand-ins (*.toml)"), ("missing", "cannot read the folder missing")]
    {
        let graded = bench.call(&["grade", "--class", folder]);
        assert_eq!(graded.code, Some(2), "{}", graded.out);
        assert!(graded.err.contains(expected), "{}", graded.err);
    }
}

#[cfg(unix)]
#[test]
fn symbolic_links_are_not_graded() {
    let bench = bench();
    std::os::unix::fs::symlink(bench.path("class/a.toml"), bench.path("class/b.toml")).unwrap();
    let graded = class(&bench, &[]);
    assert_eq!(graded.code, Some(4), "{}", graded.err);
    assert!(graded.out.contains("not graded: a symbolic link"), "{}", graded.out);
}

#[test]
fn hand_in_replaces_only_a_hand_in_of_the_same_exercise() {
    let bench = bench();
    let refused = bench.call(&["grade", "answer.toml", "--hand-in", "answer.toml"]);
    assert_eq!(refused.code, Some(2), "{}", refused.out);
    assert!(refused.err.contains("name a new file"), "{}", refused.err);
    assert_eq!(fs::read_to_string(bench.path("answer.toml")).unwrap(), ANSWER);
    assert_eq!(bench.call(&["grade", "answer.toml", "--hand-in", "class/a.toml"]).code, Some(0));
}

/// A student's copy has no key: the answer cannot be graded, but it can be handed in.
#[test]
fn missing_key_is_named() {
    let bench = bench();
    fs::remove_dir_all(bench.path("solutions")).unwrap();
    let graded = bench.call(&["grade", "answer.toml"]);
    assert_eq!(graded.code, Some(2));
    assert!(
        graded.err.contains("the key of the exercise temperature_and_speed/two_speeds is missing"),
        "{}",
        graded.err
    );
    assert!(graded.err.contains("--hand-in"), "{}", graded.err);
    assert_eq!(bench.call(&["grade", "answer.toml", "--hand-in", "b.toml"]).code, Some(0));
    assert!(Path::new(&bench.path("b.toml")).is_file());
}

#[test]
fn answer_that_names_another_file_is_rejected() {
    let bench = bench();
    let start = "[model.packing]\nstart_from = \"/etc/passwd\"\nevents_per_disc = 1\n[record]\nframes = 1\n";
    let exercise = ANSWER.split_once("[exercise]").unwrap().1;
    bench.write("start.toml", &format!("{start}[exercise]{exercise}"));
    let graded = bench.call(&["grade", "start.toml"]);
    assert_eq!(graded.code, Some(2), "{}", graded.out);
    assert!(graded.err.contains("`start_from` names another file"), "{}", graded.err);
}

/// A manifest that is no answer, and wrong answers: the value of the solution is not printed, and accepted units only for another unit.
#[test]
fn wrong_answers_do_not_show_the_solution() {
    let bench = bench();
    bench.write("gas.toml", crate::subcommand_bench::GAS);
    let no_answer = bench.call(&["grade", "gas.toml"]);
    assert_eq!(no_answer.code, Some(2));
    assert!(no_answer.err.contains("has no table [exercise]"), "{}", no_answer.err);
    for (wrong, expected) in [
        ("value = 325.94", "a factor of 2"),
        ("value = -110.18", "kelvin and degrees Celsius"),
        ("value = 0.16297", "a power of ten"),
        ("value = 211.0", "not that of these runs"),
        ("value = 162.97\nstandard_error = 1.0", "larger than that of these runs"),
    ] {
        let stated = match wrong.contains("error") {
            true => ANSWER.replace("standard_error = 0.0\n", ""),
            false => ANSWER.to_owned(),
        };
        bench.write("answer.toml", &stated.replace("value = 162.97", wrong));
        let graded = bench.call(&["grade", "answer.toml"]);
        assert_eq!(graded.code, Some(4), "{}", graded.err);
        assert!(graded.out.contains(expected), "{}", graded.out);
        assert!(!graded.out.contains("162.9") && !graded.out.contains("`K`"), "{}", graded.out);
    }
    for (unit, expected) in [("K ", "accepted"), ("d", "`d` is not among the units")] {
        bench.write("answer.toml", &ANSWER.replace("\"K\"", &format!("\"{unit}\"")));
        let graded = bench.call(&["grade", "answer.toml"]);
        assert!(graded.out.contains(expected), "{}", graded.out);
        assert_eq!(graded.out.trim().lines().count(), if expected == "accepted" { 1 } else { 2 });
    }
}

/// Points of a sweep share random numbers: the error of an exponent may be that of the replicates' exponents, or that of independent points.
#[test]
fn errors_of_an_exponent_are_paired_or_not() {
    let solutions = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book/solutions");
    let solution = solutions.join("temperature_and_speed/power_of_temperature.toml");
    let solution = fs::read_to_string(solution).unwrap();
    let bench = Bench::new();
    for (error, code) in [("0.0", 0), ("0.0012", 0), ("0.004", 4)] {
        let stated = format!("standard_error = {error}");
        bench.write("a.toml", &solution.replace("standard_error = 0.0012", &stated));
        let solutions = solutions.to_string_lossy();
        let graded = bench.call(&["grade", "a.toml", "--solutions", &solutions]);
        assert_eq!(graded.code, Some(code), "{error}: {}{}", graded.out, graded.err);
    }
}

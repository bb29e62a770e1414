//! Guarantee: `check --locked` passes for the runs that `lock` saw, and names the frame of the first difference, with its particle and
//! field if the locked recording exists.
//!
//! A changed program is simulated by a changed manifest: its run key replaces that of the locked one in the lock file.

use crate::subcommand_bench::{Bench, Called, recordings};
use std::fs;

/// Discs without energy loss in the original; some lose energy when the restitution is changed.
const DISCS: &str = "name = \"discs\"\nseed = 4\n[model.packing]\ndiscs = 40\nradius = 0.5\nwidth = 12.0\nheight = 12.0\nrestitution = 1.0\nduration = 4.0\n[record]\nframes = 60\n";

/// A folder with a locked manifest.
fn locked() -> Bench {
    let bench = Bench::new();
    bench.write("discs.toml", DISCS);
    expect(&bench.call(&["lock", "discs.toml"]), 0);
    bench
}

fn expect(called: &Called, code: i32) {
    assert_eq!(called.code, Some(code), "{}{}", called.out, called.err);
}

/// The hash of the run keys that the manifest has now, in its line of a lock file.
fn keys(bench: &Bench) -> String {
    expect(&bench.call(&["lock", "--lock-file", "other.lock", "discs.toml"]), 0);
    let text = fs::read_to_string(bench.path("other.lock")).unwrap();
    fs::remove_file(bench.path("other.lock")).unwrap();
    line(&text, "keys = ")
}

/// The line of a text that starts with a word.
fn line(text: &str, start: &str) -> String {
    text.lines().find(|line| line.starts_with(start)).unwrap().to_owned()
}

fn edit(bench: &Bench, file: &str, edits: &[(&str, &str)]) {
    let mut text = fs::read_to_string(bench.path(file)).unwrap();
    for (old, new) in edits {
        assert!(text.contains(old), "{old} is not in {text}");
        text = text.replace(old, new);
    }
    bench.write(file, &text);
}

/// A folder in which the program seems to have changed: collisions lose energy.
fn changed() -> Bench {
    let bench = locked();
    let old = keys(&bench);
    edit(&bench, "discs.toml", &[("restitution = 1.0", "restitution = 0.9")]);
    let new = keys(&bench);
    edit(&bench, "kinetoscope.lock", &[(&old, &new)]);
    bench
}

#[test]
fn locked_runs_are_equal_and_the_file_is_reproducible() {
    let bench = locked();
    let first = fs::read(bench.path("kinetoscope.lock")).unwrap();
    expect(&bench.call(&["check", "--locked"]), 0);
    expect(&bench.call(&["check", "--locked", "--all", "discs.toml"]), 0);
    expect(&bench.call(&["lock", "discs.toml"]), 0);
    assert_eq!(fs::read(bench.path("kinetoscope.lock")).unwrap(), first);
    assert!(!bench.path("recordings").exists(), "a lock keeps no recording");
    let json = bench.call(&["check", "--locked", "--json"]).json();
    assert_eq!(json["experiments"][0]["equal"], true);
}

/// The frame of the first collision follows from the lock file alone.
/// Control: the check as it was, written in another way.
#[test]
fn weakened_and_removed_checks_and_edited_texts_are_reported() {
    let check =
        "[[checks]]\nmetric = \"energy.drift_relative\"\nexpected = 0.0\ntolerance = 1e-12\n";
    let bench = Bench::new();
    bench.write("discs.toml", &format!("{DISCS}{check}"));
    expect(&bench.call(&["lock", "discs.toml"]), 0);
    let found = |manifest: &str, words: &[&str], code: i32| {
        bench.write("discs.toml", manifest);
        let called = bench.call(&["check", "--locked"]);
        expect(&called, code);
        for word in words {
            assert!(called.out.contains(word), "{word}: {}", called.out);
        }
    };
    found(&format!("{DISCS}{}", check.replace("1e-12", "1.0e-12")), &[], 0);
    let other = "a check of the manifest was added, edited or removed";
    found(
        &format!("{DISCS}{}", check.replace("1e-12", "0.5")),
        &[other, "no checked metric moved"],
        4,
    );
    found(DISCS, &[other], 4);
    let manifest = format!("{DISCS}{check}");
    let file = fs::read_to_string(bench.path("kinetoscope.lock")).unwrap();
    let value = line(&file, "energy.drift_relative = ");
    for (text, edited) in [("seed = 4", "seed = 5"), (&value, "energy.drift_relative = 1.0")] {
        assert!(file.contains(text), "{file}");
        bench.write("kinetoscope.lock", &file.replace(text, edited));
        found(&manifest, &["this entry of the lock file was edited"], 4);
    }
}

#[test]
fn first_difference_is_named_without_a_recording() {
    let bench = changed();
    let called = bench.call(&["check", "--locked"]);
    expect(&called, 4);
    for part in [
        "first difference in frame ",
        " steps or events)",
        "copy a recording of the locked run to ",
        "`kinetoscope compare`",
        " → ",
    ] {
        assert!(called.out.contains(part), "{part}: {}", called.out);
    }
    // Reference: the recordings of both manifests, compared value by value.
    expect(&bench.call(&["run", "--quiet", "--output", "new", "discs.toml"]), 0);
    let set = ["run", "--quiet", "--output", "old", "--set", "model.packing.restitution=1.0"];
    expect(&bench.call(&[&set[..], &["discs.toml"]].concat()), 0);
    let [old, new] = ["old", "new"].map(|folder| recordings(&bench.path(folder).join("discs")));
    let compared = bench.call(&["compare", old[0].to_str().unwrap(), new[0].to_str().unwrap()]);
    expect(&compared, 4);
    let after = |text: &str, what: &str| {
        let rest = text.split(what).nth(1).unwrap_or_else(|| panic!("{what}: {text}")).to_owned();
        rest.split(|letter: char| !letter.is_ascii_digit()).next().unwrap().to_owned()
    };
    assert_eq!(after(&called.out, "in frame "), after(&compared.err, ", frame "));
}

/// With a recording that has the locked messages, both values are named.
#[test]
fn first_difference_has_values_if_the_locked_recording_exists() {
    let bench = changed();
    expect(&bench.call(&["run", "--quiet", "--output", "new", "discs.toml"]), 0);
    let set = ["run", "--quiet", "--output", "old", "--set", "model.packing.restitution=1.0"];
    expect(&bench.call(&[&set[..], &["discs.toml"]].concat()), 0);
    let [old, new] = ["old", "new"].map(|folder| recordings(&bench.path(folder).join("discs")));
    fs::create_dir_all(bench.path("recordings/discs")).unwrap();
    let name = bench.path("recordings/discs").join(new[0].file_name().unwrap());
    fs::copy(&old[0], &name).unwrap();
    let called = bench.call(&["check", "--locked"]);
    expect(&called, 4);
    for part in ["/state, frame ", "particle ", "in the locked recording", "in this run"] {
        assert!(called.out.contains(part), "{part}: {}", called.out);
    }
    // Control: another recording of that name is not taken for the locked one.
    fs::copy(&new[0], &name).unwrap();
    let called = bench.call(&["check", "--locked"]);
    assert!(!called.out.contains("in the locked recording"), "{}", called.out);
}

/// `--recorded` reads the recordings of the output folder, and runs what is missing.
#[test]
fn finished_recordings_are_compared_without_a_rerun() {
    let bench = locked();
    expect(&bench.call(&["check", "--locked", "--recorded", "--output", "done"]), 0);
    let recording = recordings(&bench.path("done/discs")).remove(0);
    let written = fs::metadata(&recording).unwrap().modified().unwrap();
    expect(&bench.call(&["check", "--locked", "--recorded", "--output", "done"]), 0);
    assert_eq!(fs::metadata(&recording).unwrap().modified().unwrap(), written);
    // Control: the recording that is compared is the one in the folder.
    let set = ["run", "--quiet", "--output", "other", "--set", "model.packing.restitution=0.9"];
    expect(&bench.call(&[&set[..], &["discs.toml"]].concat()), 0);
    fs::copy(&recordings(&bench.path("other/discs"))[0], &recording).unwrap();
    let called = bench.call(&["check", "--locked", "--recorded", "--output", "done"]);
    assert_ne!(called.code, Some(0), "{}{}", called.out, called.err);
    expect(&bench.call(&["check", "--locked"]), 0);
}

#[test]
fn runs_without_a_recorded_state_are_locked() {
    let bench = Bench::new();
    bench.write("discs.toml", &format!("{DISCS}channels = [\"temperature\"]\n"));
    expect(&bench.call(&["lock", "discs.toml"]), 0);
    expect(&bench.call(&["check", "--locked"]), 0);
    expect(&bench.call(&["lock", "discs.toml"]), 0);
}

#[test]
fn changed_manifests_and_other_versions_are_reported() {
    let bench = locked();
    edit(&bench, "discs.toml", &[("seed = 4", "seed = 5")]);
    let called = bench.call(&["check", "--locked"]);
    expect(&called, 4);
    assert!(called.out.contains("\n  the manifest was edited: seed: 4 → 5\n"), "{}", called.out);
    assert!(!called.out.contains("first difference"), "{}", called.out);
    bench.write("discs.toml", &DISCS.replace("seed = 4", "seed = 4\nreplicates = 2"));
    let called = bench.call(&["check", "--locked"]);
    for part in ["the manifest was edited: replicates: (none) → 2\n", "  2 runs, locked 1\n"] {
        assert!(called.out.contains(part), "{part}: {}", called.out);
    }
    // The same values in other words are the same runs.
    bench.write("discs.toml", &DISCS.replace("radius = 0.5", "radius = 0.50 # m"));
    expect(&bench.call(&["check", "--locked"]), 0);
    bench.write("discs.toml", DISCS);
    let whole = fs::read_to_string(bench.path("kinetoscope.lock")).unwrap();
    let keys = keys(&bench);
    // With the same run keys as well: the version is named, and not a place of other bits.
    for other_keys in [false, true] {
        bench.write("kinetoscope.lock", &whole);
        edit(&bench, "kinetoscope.lock", &[("physics = ", "physics = 9")]);
        if other_keys {
            edit(&bench, "kinetoscope.lock", &[(&keys, "keys = \"0123456789abcdef\"")]);
        }
        let called = bench.call(&["check", "--locked"]);
        expect(&called, 4);
        assert!(called.out.contains("the physics version of packing is"), "{}", called.out);
        assert!(!called.out.contains("first difference"), "{}", called.out);
    }
    bench.write("kinetoscope.lock", &whole);
    edit(&bench, "kinetoscope.lock", &[("model = \"packing\"", "model = \"gas\"")]);
    let called = bench.call(&["check", "--locked"]);
    expect(&called, 4);
    assert!(called.out.contains("the model is packing, locked gas"), "{}", called.out);
    edit(&bench, "kinetoscope.lock", &[("program_version = \"", "program_version = \"7.")]);
    let called = bench.call(&["check", "--locked"]);
    assert!(called.err.contains("which version 7."), "{}", called.err);
    edit(&bench, "kinetoscope.lock", &[("\nversion = 5", "\nversion = 3")]);
    for called in [bench.call(&["check", "--locked"]), bench.call(&["lock", "discs.toml"])] {
        expect(&called, 4);
        assert!(called.err.contains("version 3 of the layout; this program reads version 5"));
    }
}

/// Control: the entries are replaced if every manifest of the file is named.
#[test]
fn locks_of_another_schema_lose_no_entry_silently() {
    let bench = locked();
    bench.write("more.toml", &DISCS.replace("\"discs\"", "\"more\""));
    expect(&bench.call(&["lock", "more.toml"]), 0);
    edit(&bench, "kinetoscope.lock", &[("schema_version = ", "schema_version = 9")]);
    let called = bench.call(&["lock", "more.toml"]);
    expect(&called, 2);
    assert!(called.err.contains("the entry of discs.toml would be lost"), "{}", called.err);
    expect(&bench.call(&["lock", "more.toml", "discs.toml"]), 0);
    expect(&bench.call(&["check", "--locked"]), 0);
}

#[test]
fn damaged_and_missing_lock_files_are_reported() {
    let bench = locked();
    expect(&bench.call(&["check", "--locked", "other.toml"]), 2);
    let whole = fs::read_to_string(bench.path("kinetoscope.lock")).unwrap();
    for damaged in [
        whole.replace("keys = \"", "keys = \"x"),
        whole.replace("runs = 1", "runs = 2"),
        whole.replace("tags = \"", "tags = \"?"),
        whole
            .replace(" = 40\n", " = 40\nx = y\n")
            .replace("checked = \"\"\"", "checked = \"\"\"\nx"),
        whole.replace("model =", "modal ="),
        // The number of frames of a run that is equal.
        whole.replace("frames = 61", "frames = 62"),
        whole[..whole.len() / 2].to_owned(),
        "\u{0}".to_owned(),
        String::new(),
        whole[..whole.find("[[experiment]]").unwrap()].to_owned(),
        whole.clone() + &whole[whole.find("[[experiment]]").unwrap()..],
        whole.replace("manifest = \"", "manifest = \"/"),
    ] {
        bench.write("kinetoscope.lock", &damaged);
        let called = bench.call(&["check", "--locked"]);
        expect(&called, 5);
        assert!(called.err.contains("help: "), "{}", called.err);
    }
    fs::remove_file(bench.path("kinetoscope.lock")).unwrap();
    let called = bench.call(&["check", "--locked"]);
    expect(&called, 5);
    assert!(called.err.contains("kinetoscope lock"), "{}", called.err);
}

/// One digit of the hash: the tags, one of every frame, show that the run is equal. Controls: a run that differs, and one of two
/// frames, whose tags prove little.
#[test]
fn damaged_hash_is_told_from_changed_physics() {
    let damaged = |bench: &Bench| {
        let whole = fs::read_to_string(bench.path("kinetoscope.lock")).unwrap();
        let last = whole.find("messages = \"").unwrap() + "messages = \"".len() + 31;
        let digit = if &whole[last..=last] == "0" { "1" } else { "0" };
        whole[..last].to_owned() + digit + &whole[last + 1..]
    };
    let bench = locked();
    bench.write("kinetoscope.lock", &damaged(&bench));
    let called = bench.call(&["check", "--locked"]);
    expect(&called, 5);
    assert!(called.err.contains("the hash of discs is not that of its tags"), "{}", called.err);
    assert!(called.err.contains("\nhelp: restore the file"), "{}", called.err);
    let bench = changed();
    bench.write("kinetoscope.lock", &damaged(&bench));
    expect(&bench.call(&["check", "--locked"]), 4);
    let bench = Bench::new();
    bench.write("discs.toml", &DISCS.replace("frames = 60", "frames = 1"));
    expect(&bench.call(&["lock", "discs.toml"]), 0);
    bench.write("kinetoscope.lock", &damaged(&bench));
    expect(&bench.call(&["check", "--locked"]), 4);
}

/// Between two entries, a file is valid TOML; one whose last entry lost lines is as well.
#[test]
fn cut_lock_files_are_damaged() {
    let bench = locked();
    bench.write("more.toml", &DISCS.replace("\"discs\"", "\"more\""));
    expect(&bench.call(&["lock", "more.toml"]), 0);
    expect(&bench.call(&["check", "--locked"]), 0);
    let whole = fs::read_to_string(bench.path("kinetoscope.lock")).unwrap();
    let entries: Vec<usize> = whole.match_indices("[[experiment]]").map(|(at, _)| at).collect();
    let [first, second] = entries[..] else { panic!("{whole}") };
    let lines: Vec<usize> = whole.match_indices('\n').map(|(at, _)| at + 1).collect();
    let without = |from: usize, to: usize| whole[..from].to_owned() + &whole[to..];
    for cut in [
        whole[..second].to_owned(),
        whole[..whole.rfind("checked = ").unwrap()].to_owned(),
        without(first, second),
        without(second, lines[lines.len() - 2]),
    ] {
        bench.write("kinetoscope.lock", &cut);
        let called = bench.call(&["check", "--locked"]);
        expect(&called, 5);
        assert!(called.err.contains("its last line is not \"# End"), "{}", called.err);
        assert!(called.err.contains("\nhelp: "), "{}", called.err);
    }
}

/// A lock file that is not TOML, or has an unknown key, is shown with its line and a mark, as a manifest is.
#[test]
fn damaged_lock_files_are_shown_with_their_line() {
    let bench = locked();
    let whole = fs::read_to_string(bench.path("kinetoscope.lock")).unwrap();
    let damages = [("[[experiment]]", "[[experiment"), ("\nframes = ", "\nspeed = 1\nframes = ")];
    for (intact, damaged) in damages {
        let text = whole.replacen(intact, damaged, 1);
        assert_ne!(text, whole);
        let line = 1 + text[..text.find(damaged.trim_start()).unwrap()].matches('\n').count();
        bench.write("kinetoscope.lock", &text);
        let called = bench.call(&["check", "--locked"]);
        expect(&called, 5);
        let err = &called.err;
        assert!(err.contains(&format!("kinetoscope.lock:{line}:")), "{err}");
        assert!(err.contains(&format!("\n{line} | ")) && err.contains("^"), "{err}");
        assert!(!err.contains("; ") && err.contains("\nhelp: restore the file"), "{err}");
    }
}

/// A stranger's lock file reads no file elsewhere, whose lines an error would show; neither does one whose entry became a link.
#[test]
fn lock_file_names_only_manifests_of_its_folder() {
    let bench = locked();
    let whole = fs::read_to_string(bench.path("kinetoscope.lock")).unwrap();
    fs::create_dir(bench.path("sub")).unwrap();
    bench.write("secret.txt", "secret = password\n");
    let elsewhere = bench.path("secret.txt").to_str().unwrap().to_owned();
    for name in ["../secret.txt", "./../secret.txt", "a/../../secret.txt", &elsewhere, "..", ""] {
        let text = whole.replace("manifest = \"discs.toml\"", &format!("manifest = \"{name}\""));
        assert_ne!(text, whole);
        bench.write("sub/kinetoscope.lock", &text);
        let called = bench.call(&["check", "--locked", "--lock-file", "sub/kinetoscope.lock"]);
        expect(&called, 5);
        assert!(!called.err.contains("password"), "{name}: {}", called.err);
        assert!(called.err.contains("\nhelp: "), "{name}: {}", called.err);
    }
    let called = bench.call(&["lock", "--lock-file", "sub/other.lock", "discs.toml"]);
    expect(&called, 2);
    assert!(called.err.contains("discs.toml is not in the folder of sub/other.lock"));
    #[cfg(unix)]
    {
        bench.write("sub/kinetoscope.lock", &whole);
        std::os::unix::fs::symlink("../secret.txt", bench.path("sub/discs.toml")).unwrap();
        let called = bench.call(&["check", "--locked", "--lock-file", "sub/kinetoscope.lock"]);
        expect(&called, 5);
        assert!(called.err.contains("is a link out of the folder"), "{}", called.err);
        assert!(!called.err.contains("password"), "{}", called.err);
    }
}

/// No run is executed for a lock file that cannot be written.
#[test]
fn lock_file_that_cannot_be_written_is_rejected_before_the_first_run() {
    let bench = locked();
    fs::create_dir(bench.path("folder")).unwrap();
    for name in ["no/k.lock", "discs.toml/k.lock", "folder"] {
        let called = bench.call(&["lock", "--lock-file", name, "discs.toml"]);
        expect(&called, 2);
        assert!(called.err.contains(name) && called.err.contains("\nhelp: "), "{}", called.err);
        assert_eq!(called.out, "");
    }
    let missing = bench.call(&["check", "--locked", "missing.toml"]);
    expect(&missing, 2);
    assert!(missing.err.contains("cannot read the manifest missing.toml"), "{}", missing.err);
}

/// The hashes need no frames between the keyframes.
#[test]
fn runs_that_keep_only_keyframes_are_locked() {
    let bench = Bench::new();
    let keep = "keep = \"keyframes\"\nkeyframe_distance = 7\n";
    bench.write("discs.toml", &format!("{DISCS}{keep}"));
    expect(&bench.call(&["lock", "discs.toml"]), 0);
    expect(&bench.call(&["check", "--locked"]), 0);
    let old = keys(&bench);
    edit(&bench, "discs.toml", &[("restitution = 1.0", "restitution = 0.9")]);
    let new = keys(&bench);
    edit(&bench, "kinetoscope.lock", &[(&old, &new)]);
    expect(&bench.call(&["check", "--locked"]), 4);
}

/// Names of variants may contain what begins a line of the file or ends its text.
#[test]
fn names_of_variants_keep_the_lock_file_readable() {
    let bench = Bench::new();
    for name in [r"a\nb", r#"a\"\"\"\nseed = 5\n"#, "'''", "x = 1"] {
        let sweep =
            format!("[[sweep.variants]]\nname = \"{name}\"\n\"model.packing.discs\" = 30\n");
        let check = "[[checks]]\nmetric = \"energy.drift_relative\"\nmaximum = 1.0\n";
        bench.write("discs.toml", &format!("{DISCS}{sweep}{check}"));
        expect(&bench.call(&["lock", "discs.toml"]), 0);
        expect(&bench.call(&["check", "--locked"]), 0);
        let edited = fs::read_to_string(bench.path("discs.toml")).unwrap();
        bench.write("discs.toml", &edited.replace("seed = 4", "seed = 5"));
        let called = bench.call(&["check", "--locked"]);
        expect(&called, 4);
        assert_eq!(called.out.matches("was edited").count(), 1, "{}", called.out);
    }
}

/// A lock file may come from a stranger: its text begins no line, and its numbers end no command early.
#[test]
fn hostile_lock_files_are_reported() {
    let bench = locked();
    let whole = fs::read_to_string(bench.path("kinetoscope.lock")).unwrap();
    let hostile = r"a\n::error::b\u001b[31m.toml";
    let changed = whole.replace("manifest = \"discs.toml\"", &format!("manifest = \"{hostile}\""));
    assert_ne!(changed, whole);
    let old = whole.lines().find(|line| line.starts_with("model = ")).unwrap();
    let other_model = whole.replace(old, &format!("model = \"{hostile}\""));
    for (text, code) in [
        (&changed, 2),
        (&changed.replace("keys = \"", "keys = \"x"), 5),
        (&other_model.replace(&line(&whole, "keys = "), "keys = \"0123456789abcdef\""), 4),
    ] {
        bench.write("kinetoscope.lock", text);
        let called = bench.call(&["check", "--locked"]);
        expect(&called, code);
        for text in [&called.out, &called.err] {
            let is_hostile = |line: &str| {
                line.trim_start_matches(['\\', ' ']).starts_with("::") || line.contains('\u{1b}')
            };
            assert!(!text.lines().any(is_hostile), "{text}");
        }
    }
    // The run claims the last possible number of frames, and its messages are others.
    let hash = line(&whole, "messages = ");
    let text = whole.replace(&hash, &format!("messages = \"{}\"", "0".repeat(32)));
    let text = text.replace("frames = 61", &format!("frames = {}", i64::MAX));
    bench.write("kinetoscope.lock", &text);
    expect(&bench.call(&["check", "--locked"]), 5);
}

#[cfg(unix)]
#[test]
fn lock_file_behind_a_link_stays_there() {
    let bench = Bench::new();
    bench.write("discs.toml", DISCS);
    fs::create_dir(bench.path("elsewhere")).unwrap();
    std::os::unix::fs::symlink("elsewhere/k.lock", bench.path("kinetoscope.lock")).unwrap();
    for _ in 0..2 {
        expect(&bench.call(&["lock", "discs.toml"]), 0);
        assert!(bench.path("kinetoscope.lock").is_symlink());
        assert!(bench.path("elsewhere/k.lock").is_file());
    }
    expect(&bench.call(&["check", "--locked"]), 0);
    let pipe = std::process::Command::new("mkfifo").arg(bench.path("pipe")).status().unwrap();
    assert!(pipe.success());
    expect(&bench.call(&["lock", "--lock-file", "pipe", "discs.toml"]), 5);
    expect(&bench.call(&["check", "--locked", "--lock-file", "pipe"]), 5);
}

/// Each process reads the file before its runs and writes it after them; the first one is stopped in between.
#[cfg(target_os = "linux")]
#[test]
fn concurrent_locks_keep_the_entries_of_each_other() {
    let bench = Bench::new();
    bench.write("discs.toml", DISCS);
    bench.write("more.toml", &DISCS.replace("\"discs\"", "\"more\""));
    let temporary = bench.path("temporary");
    fs::create_dir(&temporary).unwrap();
    let mut first = crate::subcommand_bench::command()
        .args(["lock", "discs.toml"])
        .current_dir(bench.path("."))
        .env("TMPDIR", &temporary)
        .spawn()
        .unwrap();
    // The folder of its runs is created after the file was read.
    while fs::read_dir(&temporary).unwrap().count() == 0 && first.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let signal = |name: &str| {
        let process = first.id().to_string();
        std::process::Command::new("kill").args([name, &process]).status().unwrap()
    };
    signal("-STOP");
    let second = bench.call(&["lock", "more.toml"]);
    signal("-CONT");
    assert!(first.wait().unwrap().success());
    expect(&second, 0);
    let text = fs::read_to_string(bench.path("kinetoscope.lock")).unwrap();
    for manifest in ["discs.toml", "more.toml"] {
        assert!(text.contains(&format!("manifest = \"{manifest}\"")), "{manifest}: {text}");
    }
    expect(&bench.call(&["check", "--locked"]), 0);
    let names = fs::read_dir(bench.path(".")).unwrap().map(|entry| entry.unwrap().file_name());
    assert_eq!(names.count(), 4, "a lock leaves no other file");
}

/// The test stands for a process that writes a lock file in the same folder.
#[cfg(target_os = "linux")]
#[test]
fn lock_waits_for_a_process_that_writes_in_the_same_folder() {
    let bench = Bench::new();
    bench.write("discs.toml", DISCS);
    let folder = fs::File::open(bench.path(".")).unwrap();
    folder.try_lock().unwrap();
    let mut child = crate::subcommand_bench::command()
        .args(["lock", "discs.toml"])
        .current_dir(bench.path("."))
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // The line of a manifest is printed when its runs have ended.
    let mut line = String::new();
    let out = child.stdout.as_mut().unwrap();
    std::io::BufRead::read_line(&mut std::io::BufReader::new(out), &mut line).unwrap();
    assert!(line.starts_with("discs.toml: 1 run"), "{line}");
    assert!(!bench.path("kinetoscope.lock").exists());
    drop(folder);
    assert!(child.wait().unwrap().success());
    expect(&bench.call(&["check", "--locked"]), 0);
}

/// An error shows lines of the file, which may be as long as the file.
#[test]
fn error_of_a_lock_file_shows_the_start_of_a_long_line() {
    let bench = locked();
    bench.write("kinetoscope.lock", &format!("x = \"{}\"\n", "a".repeat(1_000_000)));
    let called = bench.call(&["check", "--locked"]);
    expect(&called, 5);
    assert!(called.err.contains("aaaa") && called.err.len() < 2000, "{}", called.err.len());
}

//! Guarantee: the scripts of `action/` run in a repository that has nothing but manifests and a lock file, need no token, and their summary
//! names what changed.
//!
//! A changed program is simulated by a changed manifest whose hash of run keys replaces that of the locked one in the lock file, and by a
//! recording of the locked run in the folder of another program.

use crate::subcommand_bench::{Bench, Called, recordings};
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

const DISCS: &str = "question = \"Do the discs lose energy?\"\nseed = 4\n[model.packing]\ndiscs = 40\nradius = 0.5\nwidth = 12.0\nheight = 12.0\nrestitution = 1.0\nduration = 4.0\n[record]\nframes = 60\n[[checks]]\nmetric = \"energy.drift_relative\"\nmaximum = 1.0\n";
const EQUAL: &str = "**1 experiment is equal to the lock file**, in every message.\n";

fn script(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../action")).join(name)
}

/// Calls `check.sh` in the folder of the bench, with the summary in `summary.md`.
fn check(bench: &Bench) -> Called {
    let _ = fs::remove_file(bench.path("summary.md"));
    Command::new(script("check.sh"))
        .arg("discs.toml")
        .current_dir(bench.path("."))
        .env("KINETOSCOPE", env!("CARGO_BIN_EXE_kinetoscope"))
        .env("SUMMARY", "summary.md")
        .env_remove("GITHUB_STEP_SUMMARY")
        .output()
        .unwrap()
        .into()
}

fn expect(called: &Called, code: i32) {
    assert_eq!(called.code, Some(code), "{}{}", called.out, called.err);
}

fn summary(bench: &Bench) -> String {
    fs::read_to_string(bench.path("summary.md")).unwrap()
}

fn locked() -> Bench {
    let bench = Bench::new();
    bench.write("discs.toml", DISCS);
    expect(&bench.call(&["lock", "discs.toml"]), 0);
    bench
}

/// The folder of this program's recordings.
fn results(bench: &Bench) -> PathBuf {
    let mut folders = fs::read_dir(bench.path(".kinetoscope")).unwrap();
    folders.next().unwrap().unwrap().path()
}

#[test]
fn unchanged_experiments_give_one_line_and_are_not_run_again() {
    let bench = locked();
    expect(&check(&bench), 0);
    assert_eq!(summary(&bench), EQUAL);
    let recording = recordings(&results(&bench).join("discs")).remove(0);
    let written = |path: &Path| fs::metadata(path).unwrap().modified().unwrap();
    let first = written(&recording);
    expect(&check(&bench), 0);
    assert_eq!((summary(&bench), written(&recording)), (EQUAL.to_owned(), first));
    assert!(bench.path("kinetoscope-reports/results.xml").exists());
    assert!(bench.path("kinetoscope-reports/discs/report.html").exists());
    // The cache keeps two programs, and folders that are not its own.
    let own = results(&bench);
    for folder in ["mine", "more", "0000000000000001", "0000000000000002"] {
        fs::create_dir(bench.path(".kinetoscope").join(folder)).unwrap();
    }
    expect(&check(&bench), 0);
    let kept = |name: &str| bench.path(".kinetoscope").join(name).exists();
    assert!(own.exists() && kept("mine") && kept("more"));
    assert_eq!(
        [kept("0000000000000001"), kept("0000000000000002")].iter().filter(|it| **it).count(),
        1
    );
    assert!(own.join("discs/report.html").exists());
}

/// Also without a lock file: the table of the checks.
#[test]
fn edited_manifest_is_named_with_its_key_and_the_metrics_that_moved() {
    let bench = locked();
    bench.write("discs.toml", &DISCS.replace("restitution = 1.0", "restitution = 0.9"));
    expect(&check(&bench), 4);
    let text = summary(&bench);
    for part in [
        "**1 of 1 experiment differs from the lock file.**",
        "- the manifest was edited: model.packing.restitution: 1.0 → 0.9\n",
        "| energy.drift\\_relative | ",
        " | passes |",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    fs::remove_file(bench.path("kinetoscope.lock")).unwrap();
    expect(&check(&bench), 0);
    assert!(
        summary(&bench).contains("| passed | energy.drift\\_relative | "),
        "{}",
        summary(&bench)
    );
}

#[test]
fn changed_program_is_explained_by_the_recording_of_the_earlier_one() {
    let bench = locked();
    let keys = |text: &str| text.lines().find(|line| line.starts_with("keys")).unwrap().to_owned();
    let whole = fs::read_to_string(bench.path("kinetoscope.lock")).unwrap();
    let run = |folder: &str| {
        expect(&bench.call(&["run", "--quiet", "--output", folder, "discs.toml"]), 0);
        recordings(&bench.path(folder).join("discs")).remove(0)
    };
    let old = run("old");
    bench.write("discs.toml", &DISCS.replace("restitution = 1.0", "restitution = 0.9"));
    let new = run("new");
    expect(&bench.call(&["lock", "--lock-file", "other.lock", "discs.toml"]), 0);
    let other = fs::read_to_string(bench.path("other.lock")).unwrap();
    bench.write("kinetoscope.lock", &whole.replace(&keys(&whole), &keys(&other)));
    let earlier = bench.path(".kinetoscope/0123456789abcdef/discs");
    fs::create_dir_all(&earlier).unwrap();
    fs::copy(&old, earlier.join(new.file_name().unwrap())).unwrap();
    expect(&check(&bench), 4);
    let text = summary(&bench);
    for part in ["/state, frame ", "particle ", "in the locked recording", "- cause: "] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // Control: without the earlier recording, only the frame is known.
    fs::remove_dir_all(bench.path(".kinetoscope/0123456789abcdef")).unwrap();
    expect(&check(&bench), 4);
    assert!(summary(&bench).contains("first difference in frame "), "{}", summary(&bench));
}

/// A failed check is named also if the runs are those of the lock file.
#[test]
fn failed_check_of_a_locked_run_is_in_the_summary() {
    let bench = Bench::new();
    bench.write("discs.toml", &DISCS.replace("maximum = 1.0", "maximum = -1.0"));
    expect(&bench.call(&["lock", "discs.toml"]), 0);
    let called = check(&bench);
    expect(&called, 3);
    assert!(called.out.contains("::error file=discs.toml,line="), "{}", called.out);
    let text = summary(&bench);
    assert!(text.starts_with(EQUAL) && text.contains("| **failed** | "), "{text}");
}

/// The summary counts metrics that are equal, and names what is not. Control: the same without a baseline.
#[test]
fn baselines_of_several_experiments_are_compared() {
    let bench = Bench::new();
    fs::create_dir(bench.path("manifests")).unwrap();
    for name in ["discs", "more"] {
        bench.write(&format!("manifests/{name}.toml"), &format!("name = \"{name}\"\n{DISCS}"));
    }
    let check = |baseline: &str| {
        let called = Command::new(script("check.sh"))
            .arg("manifests")
            .current_dir(bench.path("."))
            .env("KINETOSCOPE", env!("CARGO_BIN_EXE_kinetoscope"))
            .env("SUMMARY", "summary.md")
            .env("BASELINE", baseline)
            .env_remove("GITHUB_STEP_SUMMARY")
            .output();
        let text = summary(&bench);
        fs::remove_file(bench.path("summary.md")).unwrap();
        (Called::from(called.unwrap()), text)
    };
    let (called, without) = check("");
    expect(&called, 0);
    fs::create_dir(bench.path("baselines")).unwrap();
    for name in ["discs", "more"] {
        let metrics = bench.path(&format!("kinetoscope-reports/{name}/metrics.json"));
        fs::copy(metrics, bench.path(&format!("baselines/{name}.json"))).unwrap();
    }
    let counted = " compared metrics | equal to the baseline |";
    let (called, with) = check("baselines/*.json");
    expect(&called, 0);
    assert_eq!((with.matches(counted).count(), without.matches(counted).count()), (2, 0));
    assert_eq!(with.lines().count(), without.lines().count() + 2, "{with}");
    let edited =
        format!("name = \"more\"\n{}", DISCS.replace("= 1.0\nduration", "= 0.9\nduration"));
    bench.write("manifests/more.toml", &edited);
    let (called, text) = check("baselines/discs.json baselines/more.json");
    expect(&called, 3);
    let failed = "| **failed** | keys of 1 run | equal to the baseline | model.packing.restitution: 1.0 → 0.9";
    assert!(text.contains(failed) && text.matches(counted).count() == 1, "{text}");
    // A baseline that cannot be read, or whose manifest was deleted.
    fs::remove_file(bench.path("manifests/more.toml")).unwrap();
    for baseline in ["none.json", "baselines/*.json"] {
        let (called, text) = check(baseline);
        expect(&called, 2);
        assert!(text.contains("**Nothing was analyzed**"), "{text}");
    }
}

/// Nothing of the cache is taken for a result of manifests that are refused, and a locked manifest that was deleted is named.
#[test]
fn refused_and_deleted_manifests_are_not_equal() {
    let bench = locked();
    expect(&check(&bench), 0);
    bench.write("discs.toml", &DISCS.replace("discs = 40", "discs = -40"));
    expect(&check(&bench), 2);
    let text = summary(&bench);
    assert!(text.contains("were refused") && !text.contains("passed"), "{text}");
    let bench = Bench::new();
    fs::create_dir(bench.path("experiments")).unwrap();
    for name in ["discs", "more"] {
        let text = format!("name = \"{name}\"\n{DISCS}");
        bench.write(&format!("experiments/{name}.toml"), &text);
    }
    expect(&bench.call(&["lock", "experiments"]), 0);
    expect(&bench.call(&["check", "--locked", "experiments"]), 0);
    fs::remove_file(bench.path("experiments/more.toml")).unwrap();
    let called = bench.call(&["check", "--locked", "experiments"]);
    expect(&called, 4);
    let expected = "experiments/more.toml: differs\n  the manifest no longer exists";
    assert!(called.out.contains(expected), "{}", called.out);
    assert!(!called.out.contains("metric moved"), "{}", called.out);
    expect(&bench.call(&["lock", "experiments"]), 0);
    expect(&bench.call(&["check", "--locked", "experiments"]), 0);
}

/// A shell lists the manifests that are left, and a new manifest is in no lock file: neither hides what else differs.
#[test]
fn listed_manifests_name_deleted_new_and_edited_ones() {
    let bench = locked();
    bench.write("more.toml", &format!("name = \"more\"\n{DISCS}"));
    expect(&bench.call(&["lock", "discs.toml", "more.toml"]), 0);
    expect(&check(&bench), 0);
    fs::remove_file(bench.path("more.toml")).unwrap();
    expect(&check(&bench), 4);
    assert!(summary(&bench).contains("the manifest no longer exists"), "{}", summary(&bench));
    // Control: without a summary, as at a terminal, a named manifest stands for itself.
    expect(&bench.call(&["check", "--locked", "discs.toml"]), 0);
    bench.write("new.toml", &format!("name = \"new\"\n{DISCS}"));
    bench.write("discs.toml", &DISCS.replace("seed = 4", "seed = 5"));
    let both = ["check", "--locked", "--summary", "both.md", "new.toml", "discs.toml"];
    let called = bench.call(&both);
    expect(&called, 4);
    assert!(called.err.contains("no entry for new.toml"), "{}", called.err);
    let text = fs::read_to_string(bench.path("both.md")).unwrap();
    assert!(text.contains("1 experiment could not be compared"), "{text}");
    assert!(text.contains("seed: 4 → 5"), "{text}");
    bench.write("kinetoscope.lock", "version = 99\n");
    assert_ne!(check(&bench).code, Some(0));
    assert!(summary(&bench).contains("Nothing was compared"), "{}", summary(&bench));
}

/// A recording that is not readable, such as one of another version, in the folder of another program: only the frame is known.
#[test]
fn cached_recordings_of_another_version_are_no_results() {
    let bench = locked();
    let old = bench.path(".kinetoscope/0123456789abcdef/discs");
    fs::create_dir_all(&old).unwrap();
    expect(&bench.call(&["run", "--quiet", "--output", "new", "discs.toml"]), 0);
    let recording = recordings(&bench.path("new/discs")).remove(0);
    let mut bytes = fs::read(&recording).unwrap();
    let half = bytes.len() / 2;
    bytes.truncate(half);
    fs::write(old.join(recording.file_name().unwrap()), bytes).unwrap();
    expect(&check(&bench), 0);
    assert_eq!(summary(&bench), EQUAL);
}

/// Control: the same folder, not committed, in the other tests.
#[test]
fn committed_recordings_are_refused() {
    let bench = locked();
    let git = |arguments: &[&str]| -> Called {
        Command::new("git").args(arguments).current_dir(bench.path(".")).output().unwrap().into()
    };
    expect(&git(&["init", "--quiet"]), 0);
    expect(&check(&bench), 0);
    expect(&git(&["add", ".kinetoscope"]), 0);
    let called = check(&bench);
    expect(&called, 2);
    assert!(called.err.contains(".kinetoscope is committed"), "{}", called.err);
    // In a folder that git does not trust, it does not answer.
    fs::write(bench.path(".git/config"), "[core]\n\trepositoryformatversion = 99\n").unwrap();
    let called = check(&bench);
    expect(&called, 2);
    assert!(called.err.contains(".kinetoscope is committed"), "{}", called.err);
}

/// A manifest with 4,000 failed checks. Control: the summaries of the other tests have less than 900 kB, and are whole.
#[test]
fn summary_of_more_than_a_mebibyte_is_cut_and_linked() {
    let bench = Bench::new();
    let check_of = "[[checks]]\nmetric = \"energy.drift_relative\"\nmaximum = ";
    let checks: String = (0..9_000).map(|number| format!("{check_of}-1.{number:08}\n")).collect();
    bench.write("discs.toml", &format!("{DISCS}{checks}"));
    let called: Called = Command::new(script("check.sh"))
        .arg("discs.toml")
        .current_dir(bench.path("."))
        .env("KINETOSCOPE", env!("CARGO_BIN_EXE_kinetoscope"))
        .env("SUMMARY", "summary.md")
        .env("REPORTS_URL", "https://example.org/reports")
        .env_remove("GITHUB_RUN_ID")
        .output()
        .unwrap()
        .into();
    expect(&called, 3);
    let text = summary(&bench);
    assert!(text.len() > 890_000 && text.len() < 1_000_000, "{} bytes", text.len());
    let end = "\nThe rest would be too long for a summary; the reports have all.\n\n[Reports and test results](https://example.org/reports)\n";
    assert!(text.ends_with(end), "{}", &text[text.len() - 300..]);
}

/// A link in the artifact could name the environment of the job, which has the token.
#[test]
fn artifact_that_is_a_link_is_not_posted() {
    let bench = Bench::new();
    bench.write("secret", "token");
    std::os::unix::fs::symlink(bench.path("secret"), bench.path("summary.md")).unwrap();
    let called: Called = Command::new(script("comment.sh"))
        .arg("summary.md")
        .current_dir(bench.path("."))
        .env("GITHUB_REPOSITORY", "owner/name")
        .env("HEAD_SHA", "0123abcd")
        .output()
        .unwrap()
        .into();
    expect(&called, 2);
    assert!(called.err.contains("is not a file"), "{}", called.err);
}

/// `gh` is replaced by a script that keeps its arguments and the body of the comment.
#[test]
fn one_comment_is_written_and_then_replaced() {
    let bench = Bench::new();
    let gh = "#!/bin/sh\necho \"$@\" >> calls.txt\ncase \"$*\" in\n*/pulls*) echo 7 ;;\n*--paginate*) cat comment.txt 2>/dev/null ;;\n*--input*) cp \"$6\" body.json; echo 42 > comment.txt ;;\nesac\nexit 0\n";
    let path = bench.write("gh", gh);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    bench.write("summary.md", &format!("{}\n{}", "line\n".repeat(20_000), "last"));
    // No module of the working folder is executed.
    bench.write("json.py", "raise SystemExit(\"json.py was executed\")\n");
    let comment = |sha: &str| -> Called {
        let paths = format!("{}:{}", bench.path("").display(), std::env::var("PATH").unwrap());
        Command::new(script("comment.sh"))
            .arg("summary.md")
            .current_dir(bench.path("."))
            .env("PATH", paths)
            .env("GITHUB_REPOSITORY", "owner/name")
            .env("HEAD_SHA", sha)
            .env("RUN_URL", "https://example.org/run")
            .output()
            .unwrap()
            .into()
    };
    expect(&comment("0123abcd"), 0);
    expect(&comment("0123abcd"), 0);
    expect(&comment("main; rm -rf ."), 2);
    let calls = fs::read_to_string(bench.path("calls.txt")).unwrap();
    let written: Vec<&str> = calls.lines().filter(|call| call.contains("--method")).collect();
    assert!(
        written[0].starts_with("api --method POST repos/owner/name/issues/7/comments"),
        "{calls}"
    );
    assert!(
        written[1].starts_with("api --method PATCH repos/owner/name/issues/comments/42"),
        "{calls}"
    );
    assert_eq!(written.len(), 2);
    let body: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(bench.path("body.json")).unwrap()).unwrap();
    let body = body["body"].as_str().unwrap();
    assert!(body.starts_with("<!-- kinetoscope -->\nline\n") && body.len() < 65_536);
    assert!(
        body.contains("The rest is in the summary") && body.contains("](https://example.org/run)")
    );
}

/// Controls: other TOML files and deleted manifests are committed.
#[test]
fn hook_rejects_the_commit_of_a_manifest_that_differs() {
    let bench = locked();
    let git = |arguments: &[&str]| -> Called {
        let identity =
            ["-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "core.hooksPath=hooks"];
        Command::new("git")
            .args(identity)
            .args(arguments)
            .current_dir(bench.path("."))
            .env("KINETOSCOPE", env!("CARGO_BIN_EXE_kinetoscope"))
            .output()
            .unwrap()
            .into()
    };
    fs::create_dir(bench.path("hooks")).unwrap();
    fs::copy(script("pre-commit.sh"), bench.path("hooks/pre-commit")).unwrap();
    bench.write("Cargo.toml", "[package]\n");
    expect(&git(&["init", "--quiet"]), 0);
    expect(&git(&["add", "discs.toml", "Cargo.toml", "kinetoscope.lock"]), 0);
    expect(&git(&["commit", "--quiet", "-m", "equal"]), 0);
    bench.write("discs.toml", &DISCS.replace("seed = 4", "seed = 5"));
    expect(&git(&["add", "discs.toml"]), 0);
    let rejected = git(&["commit", "--quiet", "-m", "edited"]);
    assert_ne!(rejected.code, Some(0));
    assert!(rejected.err.contains("`kinetoscope lock` accepts the change"), "{}", rejected.err);
    // What is staged is committed, not what is in the work tree, and a name is no option.
    bench.write("discs.toml", DISCS);
    bench.write("-q.toml", "[package]\n");
    expect(&git(&["add", "--", "-q.toml"]), 0);
    assert_ne!(git(&["commit", "--quiet", "-m", "edited"]).code, Some(0));
    expect(&git(&["add", "discs.toml"]), 0);
    expect(&git(&["commit", "--quiet", "-m", "another file"]), 0);
    bench.write("discs.toml", &DISCS.replace("seed = 4", "seed = 5"));
    expect(&git(&["add", "discs.toml"]), 0);
    expect(&bench.call(&["lock", "discs.toml"]), 0);
    expect(&git(&["add", "kinetoscope.lock"]), 0);
    expect(&git(&["commit", "--quiet", "-m", "accepted"]), 0);
    expect(&git(&["rm", "--quiet", "discs.toml"]), 0);
    expect(&git(&["commit", "--quiet", "-m", "deleted"]), 0);
}

/// Control: the right hash is accepted up to the point where the file is no wheel.
#[test]
fn wheel_with_another_hash_is_not_installed() {
    let bench = Bench::new();
    bench.write("kinetoscope-0.1.0-py3-none-any.whl", "not a wheel");
    let install = |wheel: &str, hash: &str| -> Called {
        let mut command = Command::new(script("install.sh"));
        command.current_dir(bench.path(".")).env("WHEEL", wheel).env("SHA256", hash);
        command.output().unwrap().into()
    };
    let other = install("kinetoscope-0.1.0-py3-none-any.whl", &"0".repeat(64));
    expect(&other, 1);
    assert!(other.err.contains("does not have the SHA-256"), "{}", other.err);
    expect(&install("https://example.invalid/k.whl", ""), 2);
}

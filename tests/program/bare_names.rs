//! Guarantee: a recording or manifest has the same result under its bare name, with `./` before it, and under its absolute name.
//!
//! Setup: every command that reads a recording, in a folder with two runs that started from a third one; exit codes and output are
//! compared after the folder was removed from all paths. The second run is found by its run key, in an adjacent folder.
//! Control: without the recording from which they started, `compare --find-step` finds no step.

use crate::subcommand_bench::{Bench, Called, command, recordings};
use std::fs;
use std::path::Path;

/// Commands and their exit codes. `@` is where a name begins.
const COMMANDS: &[(&str, i32)] = &[
    ("info @b.mcap", 0),
    ("info --json @b.mcap", 0),
    ("verify --quiet @b.mcap", 0),
    ("verify --json @b.mcap", 0),
    ("compare @b.mcap @c.mcap", 4),
    ("compare --json @b.mcap @c.mcap", 4),
    ("compare --find-step @b.mcap @c.mcap", 4),
    ("compare --mcap @m.mcap @b.mcap @c.mcap", 4),
    ("compare --mcap @m.mcap @b.mcap @c.mcap", 2),
    ("fill --quiet @k.mcap", 0),
    ("fill --quiet --output @all.mcap @k.mcap", 0),
    ("fill @b.mcap", 2),
    ("zoom @b.mcap --from 1 --to 2 --every 0.1", 0),
    ("zoom --output @fine.mcap @b.mcap --from 1 --to 2 --every 0.1", 0),
    ("analyze --json @b.mcap", 0),
    ("export --format csv @b.mcap", 0),
    ("export --thumbnail @b.png @b.mcap", 0),
    ("plot @b.mcap --y /temperature.temperature --output @b.svg", 0),
    ("check @next.toml", 0),
    ("why @next.toml", 0),
    ("run --quiet --output next @next.toml", 0),
    ("lock --quiet --lock-file @k.lock @next.toml", 0),
    ("check --locked --quiet --lock-file @k.lock", 0),
    ("verify @missing.mcap", 5),
    ("check @missing.toml", 2),
];

fn discs(name: &str, start: &str, restitution: &str) -> String {
    format!(
        "name = \"{name}\"\nseed = 3\n[model.packing]\n{start}discs = 30\nradius = 1.0\nrestitution = {restitution}\nduration = 4.0\n\
         [record]\nframes = 8\n"
    )
}

fn expect(bench: &Bench, arguments: &[&str]) {
    let called = bench.call(arguments);
    assert_eq!(called.code, Some(0), "{arguments:?}: {}", called.err);
}

/// A folder `here` with two runs, and a folder next to it with the recording from which they started.
fn prepare() -> Bench {
    let bench = Bench::new();
    for folder in ["start", "here"] {
        fs::create_dir(bench.path(folder)).unwrap();
    }
    let start = "start_from = \"start/start.mcap\"\n";
    for (name, text, to) in [
        ("start", discs("start", "", "1.0"), "start/start.mcap"),
        ("b", discs("b", start, "1.0"), "here/b.mcap"),
        ("c", discs("c", start, "0.9"), "here/c.mcap"),
        ("k", discs("k", "", "1.0") + "keep = \"keyframes\"\n", "here/k.mcap"),
    ] {
        let manifest = format!("{name}.toml");
        bench.write(&manifest, &text);
        expect(&bench, &["run", "--quiet", &manifest]);
        let recording = recordings(&bench.path("recordings").join(name)).remove(0);
        fs::copy(&recording, bench.path(to)).unwrap();
        // A recording that is named by its run key is found by the end of its name.
        if name == "start" {
            let own = recording.file_name().unwrap();
            fs::copy(&recording, bench.path("start").join(own)).unwrap();
        }
    }
    fs::remove_dir_all(bench.path("recordings")).unwrap();
    let next = discs("next", "start_from = \"b.mcap\"\n", "1.0");
    bench.write("here/next.toml", &next);
    bench
}

/// Exit code, output and names of files after each command, without the folder in paths.
fn results(prefix: &str) -> Vec<(i32, String, Vec<String>)> {
    let bench = prepare();
    let here = bench.path("here");
    let absolute = format!("{}/", here.canonicalize().unwrap().display());
    let prefix = if prefix == "/" { &absolute } else { prefix };
    let call = |arguments: &str| {
        let words = arguments.split(' ').map(|word| word.replace('@', prefix));
        let called: Called = command().current_dir(&here).args(words).output().unwrap().into();
        let text = called.out + &called.err;
        // The folder itself is shown as well, such as that of an analysis.
        let text = text.replace(&absolute, "").replace(absolute.trim_end_matches('/'), ".");
        (called.code.unwrap(), text.replace("./", ""), names(&here))
    };
    COMMANDS.iter().map(|(arguments, _)| call(arguments)).collect()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string();
    let mut names: Vec<String> = entries.map(|entry| name(entry).unwrap()).collect();
    names.sort();
    names
}

#[test]
fn bare_names_give_the_same_results_as_others() {
    let [bare, dotted, absolute] = ["", "./", "/"].map(results);
    for (index, (arguments, code)) in COMMANDS.iter().enumerate() {
        assert_eq!(bare[index].0, *code, "{arguments}: {}", bare[index].1);
        assert_eq!(bare[index], dotted[index], "{arguments} with ./");
        assert_eq!(bare[index], absolute[index], "{arguments} with the absolute name");
    }
    let (_, found, _) = &bare[COMMANDS.iter().position(|(text, _)| text.contains("find")).unwrap()];
    assert!(found.contains(", at time "), "{found}");
    assert!(bare.last().unwrap().2.contains(&"m.layout.json".to_owned()), "{:?}", bare.last());
}

#[test]
fn control_step_is_not_found_without_the_start() {
    let bench = prepare();
    fs::remove_dir_all(bench.path("start")).unwrap();
    let here = bench.path("here");
    let arguments = ["compare", "--find-step", "b.mcap", "c.mcap"];
    let called: Called = command().current_dir(here).args(arguments).output().unwrap().into();
    assert!(called.out.contains("a run cannot be repeated by this program"), "{}", called.out);
}

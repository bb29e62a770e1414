//! Guarantee: a report of a sweep opens with the runs at its ends in parallel, with one clock and one color scale: whenever the first one shows a time, the
//! second one shows the same time, between its frames at positions on the way from one to the next.
//!
//! Setup: two runs of 60 and 40 frames, whose discs circle in opposite directions, in headless Chromium: steps, playback, and
//! another choice of the second run.
//! Control: the positions of the first run are not those that the second one shows, and a single run has no such choice.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]
#![allow(clippy::disallowed_methods, reason = "positions of a test need no fixed bits")]

use crate::browser::{element, examined};
use crate::synthetic::{Folder, Frames, analyze};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::DemTemperature;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;
use serde_json::Value;

const MANIFEST: &str = r#"
name = "two"
[model.dem]
discs = 30
width_m = 1.0
height_m = 1.0
radius_m = 1e-3
duration_s = 1.0
[record]
frames = 60
channels = ["state", "temperature"]
"#;
const SWEEP: &str = "[sweep]\n\"model.dem.restitution\" = [0.5, 0.8]\n";

/// Frames of each run in one second.
const FRAMES: [u32; 2] = [60, 40];

/// Position of a disc at a time; each run has its direction.
fn position(run: usize, disc: u32, time: f64) -> [f64; 2] {
    let phase = f64::from(disc) + if run == 0 { time } else { -time };
    let radius = 0.1 + 0.01 * f64::from(disc);
    [0.5 + radius * phase.cos(), 0.5 + radius * phase.sin()]
}

fn frames(manifest: &RunManifest) -> Frames {
    let run = usize::from(!manifest.canonical().contains("restitution = 0.5"));
    let frame = |index: u32| {
        let time = f64::from(index) / f64::from(FRAMES[run]);
        let mut frame = Frame::new();
        for disc in 0..30 {
            let [x, y] = position(run, disc, time);
            frame.push_state(&[x, y, 0.0, 0.0]);
        }
        frame.push(&DemTemperature::default());
        (Clock { count: u64::from(index), time }, frame)
    };
    (0..=FRAMES[run]).map(frame).collect()
}

/// Appended to the page: chooses two runs, moves the first one, and writes what the second one shows.
const PROBE: &str = r#"<script>
held((async () => {
  const found = [], note = (run) => found.push({
    run, time: replay.time, other: replay.second.time, positions: replay.second.positions(),
    widths: [...document.querySelectorAll("canvas")].map((canvas) => canvas.clientWidth),
  });
  try {
    await replay.ready;
    await replay.second.ready;
    note(1);
    for (const frame of [0, 7, 30, 59]) { replay.show(frame); note(1); }
    replay.show(50);
    document.querySelector(".speed").value = "10";
    document.querySelector(".play").click();
    while (replay.time < 1) await new Promise(requestAnimationFrame);
    note(1);
    replay.show(20);
    await replay.second.select(0);
    note(0);
  } catch (error) { console.error(String(error)); }
  const list = document.createElement("pre");
  list.id = "found";
  list.textContent = JSON.stringify(found);
  document.body.append(list);
})());
</script>"#;

/// Whether the drawn positions are those of a run at a time, within 1/500 of the view.
fn shows(positions: &Value, run: usize, time: f64) -> bool {
    let drawn = positions.as_array().unwrap();
    drawn.len() == 30
        && drawn.iter().all(|drawn| {
            let [x, y] = position(run, drawn[0].as_u64().unwrap() as u32, time);
            let distance = (x - drawn[1].as_f64().unwrap()).hypot(y - drawn[2].as_f64().unwrap());
            distance < 1.0 / 500.0
        })
}

#[test]
#[ignore = "needs chromium"]
fn second_run_follows_the_clock_of_the_first_one() {
    let folder = Folder::write(&format!("{MANIFEST}{SWEEP}"), frames);
    analyze(&[folder.name()]).exited_with(0);
    let (dom, console) = examined(&folder.path().join("report.html"), PROBE, false);
    assert!(console.is_empty(), "{console}");
    let found = dom.split("<pre id=\"found\">").nth(1).expect("the script must end");
    let found: Vec<Value> =
        serde_json::from_str(found.split("</pre>").next().unwrap()).expect("an array");
    assert_eq!(found.len(), 7);
    for shown in &found {
        let (run, time) =
            (shown["run"].as_u64().unwrap() as usize, shown["time"].as_f64().unwrap());
        let other = shown["other"].as_f64().unwrap();
        assert!((other - time).abs() < 1e-12, "{other} at {time}");
        assert!(shows(&shown["positions"], run, other), "{shown}");
        // Control.
        assert!(time == 0.0 || !shows(&shown["positions"], 1 - run, other), "{shown}");
        let widths: Vec<f64> = shown["widths"]
            .as_array()
            .unwrap()
            .iter()
            .map(|width| width.as_f64().unwrap())
            .collect();
        assert!(widths.iter().all(|width| *width > 300.0 && *width < 700.0), "{widths:?}");
    }
    assert!(found[5]["time"] == 1.0, "{}", found[5]["time"]);
}

/// Appended to the page: the last time that the clock reaches, and the notes below both players there, with each run in front.
const ENDS: &str = r#"<script>
held((async () => {
  const found = [];
  try {
    for (const run of [0, 1]) {
      await replay.select(run);
      await replay.second.select(1 - run);
      replay.show(1e9);
      found.push([replay.time, ...[...document.querySelectorAll(".player .note")].map((note) => note.textContent)]);
    }
    // With one player, the clock ends with its run.
    document.querySelector(".pair").click();
    replay.show(1e9);
    found.push([replay.time]);
  } catch (error) { console.error(String(error)); }
  document.title = JSON.stringify(found);
})());
</script>"#;

/// Guarantee: of two runs that are shown, one that ends before the other is marked, and the clock runs until both have ended. Control: runs of
/// equal length are not marked.
#[test]
#[ignore = "needs chromium"]
fn run_that_ends_early_is_marked_and_the_clock_goes_on() {
    let found = |last: usize| -> Value {
        let folder = Folder::write(&format!("{MANIFEST}{SWEEP}"), |manifest| {
            let mut all = frames(manifest);
            let is_first = manifest.canonical().contains("restitution = 0.5");
            all.truncate(if is_first { last } else { all.len() });
            all
        });
        assert!(analyze(&[folder.name()]).code != 2);
        let (dom, console) = examined(&folder.path().join("report.html"), ENDS, false);
        assert!(console.is_empty(), "{console}");
        serde_json::from_str(element(&dom, "title")).unwrap()
    };
    let mark = "This run ended at t = 0.5 s; another one that is shown lasts longer.";
    let is_marked = |note: &Value| note.as_str().unwrap().contains(mark);
    let short = found(31);
    let reaches_the_end = |shown: &Value| shown[0].as_f64() == Some(1.0);
    assert!(short.as_array().unwrap().iter().all(reaches_the_end), "{short}");
    assert!(is_marked(&short[0][1]) && !is_marked(&short[0][2]), "{short}");
    assert!(!is_marked(&short[1][1]) && is_marked(&short[1][2]), "{short}");
    // Control.
    let equal = found(61);
    assert!(!equal.to_string().contains("lasts longer"), "{equal}");
}

/// Guarantee: on request, all runs of a sweep play in parallel, up to six, each once and at the time of the first one. Control: without it, there are two.
#[test]
#[ignore = "needs chromium"]
fn further_runs_follow_the_clock_on_request() {
    let sweep = "[sweep]\n\"model.dem.restitution\" = [0.5, 0.6, 0.7, 0.8]\n";
    let folder = Folder::write(&format!("{MANIFEST}{sweep}"), frames);
    analyze(&[folder.name()]).exited_with(0);
    let script = "<script>held((async () => { await replay.ready; await replay.second.ready; const many = document.querySelector('.many'), found = []; \
        const note = async (count) => { await until(() => players().length === count); replay.show(30); await nextFrames(2); found.push(players().map(({ file, time, canvas }) => [file, time, canvas.clientWidth])); }; \
        await note(2); many.click(); await note(4); many.click(); await note(2); document.title = JSON.stringify(found); })());</script>";
    let (dom, console) = examined(&folder.path().join("report.html"), script, false);
    assert!(console.is_empty(), "{console}");
    let found: Vec<Vec<(String, f64, f64)>> = serde_json::from_str(element(&dom, "title")).unwrap();
    let counts: Vec<usize> = found.iter().map(Vec::len).collect();
    assert_eq!(counts, [2, 4, 2]);
    let files: std::collections::BTreeSet<&str> =
        found[1].iter().map(|(file, ..)| file.as_str()).collect();
    assert_eq!(files.len(), 4, "{files:?}");
    for (file, time, width) in &found[1] {
        assert!((time - 0.5).abs() < 1e-12 && *width > 100.0, "{file}: {time}, {width} px");
    }
}

/// Guarantee: menus name runs, metrics and swept keys in words with their units, not by the names of the manifest and of `metrics.json`. Control: the file
/// with the numbers has these names.
#[test]
fn menus_are_in_words_with_units() {
    let sweep = "[sweep]\n\"model.dem.height_m\" = [1.0, 2.5]\n";
    let manifest = format!("{}{sweep}", MANIFEST.replace("height_m = 1.0\n", ""));
    let folder = Folder::write(&manifest, frames);
    analyze(&[folder.name()]).exited_with(0);
    let page = folder.page();
    let options: Vec<&str> = page
        .split("<option")
        .skip(1)
        .map(|rest| rest.split("</option>").next().unwrap())
        .map(|option| option.split_once('>').unwrap().1)
        .collect();
    assert!(
        options.contains(&"height = 1 m") && options.contains(&"height = 2.5 m"),
        "{options:?}"
    );
    assert!(options.contains(&"height (m)"), "{options:?}");
    let is_name = |option: &&&str| {
        option.contains('_')
            || option
                .chars()
                .zip(option.chars().skip(1))
                .any(|(dot, next)| dot == '.' && next.is_alphabetic())
    };
    assert_eq!(options.iter().find(is_name), None);
    let numbers = std::fs::read_to_string(folder.path().join("metrics.csv")).unwrap();
    assert!(numbers.contains("height_m") && options.len() > 20, "control: {options:?}");
}

#[test]
fn one_run_has_no_second_one() {
    let folder = Folder::write(MANIFEST, frames);
    assert_eq!(analyze(&[folder.name()]).code, 0);
    let text = folder.page();
    assert_eq!(text.matches("<canvas").count(), 1);
    assert!(!text.contains("class=\"pair\""));
    // Control: two runs of the same model have one.
    let folder = Folder::write(&format!("{MANIFEST}{SWEEP}"), frames);
    assert_eq!(analyze(&[folder.name()]).code, 0);
    let text = folder.page();
    assert!(text.contains("class=\"pair\""));
    let selected = text.matches("<option selected>").count();
    assert_eq!(selected, 2, "the runs at both ends are shown");
    let second = text.split("Second run: ").nth(1).unwrap().split("</select>").next().unwrap();
    assert!(second.contains("<option selected>restitution = 0.8"), "{second}");
}

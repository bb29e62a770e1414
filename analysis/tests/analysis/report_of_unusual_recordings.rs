//! Guarantee: recordings with no frame, one frame, no finite number, very many particles or very many runs, torn ones, runs of another model,
//! and names that contain markup have a report without errors in the browser. What is left out is stated.
//!
//! Setup: recordings written by hand, in headless Chromium. Control: markup that is inserted into a page is found.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::browser::examined;
use crate::synthetic::{Folder, Frames, analyze, frames_of, two_frames};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::GasPressure;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;
use std::fmt::Write as _;
use std::fs;

const MANIFEST: &str = "name = \"gas\"\ndescription = \"<script>alert(1)</script>\"\n[model.gas]\nparticles = 1\nduration_s = 1.0\n[record]\nframes = 1\nchannels = [\"state\", \"pressure\"]\n";

/// Largest size of a page, bytes.
const MAX_PAGE_BYTES: usize = 10_000_000;

fn pressure(value: f64) -> GasPressure {
    GasPressure { measured_since_start_n_per_m: value, ..GasPressure::default() }
}

fn ordinary(_: &RunManifest) -> Frames {
    two_frames(&pressure(1.0))
}

/// Analyzes a folder, which must end with one of the exit codes; returns the page.
fn page(folder: &Folder, codes: &[i32]) -> String {
    let output = analyze(&[folder.name()]);
    assert!(codes.contains(&output.code), "{}: {}", output.code, output.text);
    assert!(!output.text.contains("internal error"), "{}", output.text);
    let page = fs::read_to_string(folder.path().join("report.html"));
    let page = page.unwrap_or_else(|error| panic!("{error}: {}", output.text));
    assert!(page.len() < MAX_PAGE_BYTES, "{} bytes", page.len());
    page
}

/// Waits until the page is drawn.
const DRAWN: &str =
    "<script>held((async () => { await window.replay?.ready; await nextFrames(10); })());</script>";

/// The console of the browser while it shows the report, and the document that its script makes.
fn shown(folder: &Folder) -> (String, String) {
    let (document, console) = examined(&folder.path().join("report.html"), DRAWN, false);
    (console, document)
}

fn console(folder: &Folder) -> String {
    shown(folder).0
}

/// As many particles as given, at two times.
fn crowd(particles: u32) -> Frames {
    frames_of(0..2, |index, frame| {
        for particle in 0..particles {
            let place = f64::from(particle % 1000) * 0.0018 - 0.9;
            frame.push_state(&[place, -place, 1.0, 0.0]);
        }
        frame.push(&pressure(1.0));
        f64::from(index)
    })
}

/// A pressure per frame, of a particle with this speed.
fn with_values(speed: f64, values: impl IntoIterator<Item = f64>) -> Frames {
    let frame = |(index, value): (u8, f64)| {
        let mut frame = Frame::new();
        frame.push_state(&[0.0, 0.0, speed, 0.0]);
        frame.push(&GasPressure { measured_n_per_m: value, ..pressure(value) });
        (Clock { count: u64::from(index), time: f64::from(index) }, frame)
    };
    (0..).zip(values).map(frame).collect()
}

/// A pressure that is not a number in the middle.
fn with_gaps() -> Frames {
    with_values(f64::NAN, [1.0, 2.0, f64::NAN, 3.0, f64::INFINITY, 4.0])
}

fn five_hundred_runs() -> Folder {
    let mut values = String::new();
    for run in 1..=500 {
        write!(values, "{run}.0, ").unwrap();
    }
    let sweep = format!("{MANIFEST}[sweep]\n\"model.gas.temperature_k\" = [{values}]\n");
    Folder::write(&sweep, ordinary)
}

/// A folder with a run of the gas and one of an orbit.
fn two_models() -> Folder {
    let mixed = Folder::write(MANIFEST, ordinary);
    let other = Folder::write(
        "name = \"other\"\n[model.orbit]\nduration_days = 10.0\n[record]\nframes = 1\nchannels = [\"state\"]\n",
        |_| {
            let mut frame = Frame::new();
            frame.push_state(&[1.0, 0.0, 0.0, 0.0, 0.017, 0.0]);
            vec![(Clock { count: 0, time: 0.0 }, frame)]
        },
    );
    fs::copy(other.file(0), mixed.path().join("other.mcap")).unwrap();
    fs::remove_file(mixed.path().join("experiment.toml")).unwrap();
    mixed
}

#[test]
fn runs_beyond_the_budget_are_listed_and_not_drawn() {
    let folder = five_hundred_runs();
    let page = page(&folder, &[0]);
    assert!(page.contains("more runs are not replayed"));
    let last = folder.files.last().unwrap();
    assert!(page.contains(last.as_str()), "{last} is not listed");
}

/// Setup: one run more than are replayed.
#[test]
fn a_single_run_is_in_the_singular() {
    let sweep = format!(
        "{MANIFEST}[sweep]\n\"model.gas.temperature_k\" = {{ from = 100.0, to = 800.0, count = 8 }}\n"
    );
    let folder = Folder::write(&sweep, |_| with_values(1.0, [1.0, 3.0, 4.0]));
    let page = page(&folder, &[0]);
    assert!(page.contains("<summary>1 more run is not replayed</summary>"));
}

#[test]
fn a_million_particles_are_thinned_and_the_page_states_it() {
    let folder = Folder::write(MANIFEST, |_| crowd(1_000_000));
    let page = page(&folder, &[0]);
    assert!(
        page.contains("Of up to 1000000 particles, every"),
        "the page does not state the thinning"
    );
}

#[test]
fn a_recording_without_frames_is_named_as_such() {
    let folder = Folder::write(MANIFEST, |_| Vec::new());
    let output = analyze(&[folder.name()]).exited_with(5);
    assert!(output.text.contains("holds no frame\nhelp: "), "{}", output.text);
}

#[test]
fn runs_of_two_models_are_counted_and_named_by_their_model() {
    let mixed = two_models();
    let text = page(&mixed, &[0, 3, 5]);
    assert!(text.contains("<dt>model</dt><dd>2 models: gas, 1 run; orbit, 1 run</dd>"));
    assert!(text.contains("model = gas: 2 frames") && text.contains("model = orbit: 1 frame "));
    // The keys of one model do not name the runs of the other.
    assert!(!text.contains("duration_<wbr>days = "));
    // Seconds and days have no common clock.
    assert!(text.matches("class=\"film\"").count() == 2 && !text.contains("class=\"pair\""));
}

#[test]
#[ignore = "needs chromium"]
fn unusual_recordings_have_pages_without_errors() {
    let no_number = Folder::write(MANIFEST, |_| two_frames(&pressure(f64::NAN)));
    let infinite = Folder::write(MANIFEST, |_| two_frames(&pressure(f64::INFINITY)));
    let one_frame = Folder::write(MANIFEST, |run| ordinary(run).into_iter().take(1).collect());
    for folder in [&no_number, &infinite, &one_frame] {
        let page = page(folder, &[0, 3, 5]);
        assert!(!page.contains("<script>alert"));
        assert_eq!(console(folder), "");
    }

    let gaps = Folder::write(MANIFEST, |_| with_gaps());
    page(&gaps, &[0]);
    assert_eq!(console(&gaps), "");

    let mixed = two_models();
    page(&mixed, &[0, 3, 5]);
    assert_eq!(console(&mixed), "");

    for folder in [five_hundred_runs(), Folder::write(MANIFEST, |_| crowd(1_000_000))] {
        page(&folder, &[0]);
        assert_eq!(console(&folder), "");
    }
}

/// Setup: more runs than rows that are open, each with a check; the last one or none fails.
#[test]
fn many_passed_checks_are_collapsed_and_failed_ones_are_not() {
    for (least, failed) in [(0.0, 0), (1.0, 1)] {
        let sweep =
            "[sweep]\n\"model.gas.temperature_k\" = { from = 100.0, to = 1600.0, count = 16 }\n";
        let check = format!("[[checks]]\nmetric = \"pressure.measured\"\nminimum = {least}\n");
        let folder = Folder::write(&format!("{MANIFEST}{sweep}{check}"), |run| {
            let is_low = run.canonical().contains("temperature_k = 1600");
            two_frames(&pressure(if is_low { 0.5 } else { 1.0 }))
        });
        let text = page(&folder, &[0, 3]);
        let (open, _) = text.split_once(" more passed checks").expect("all are open");
        let (_, open) = open.split_once("<h2>Checked numbers</h2>").unwrap();
        let rows = |word: &str| open.matches(&format!("<strong class=\"{word}\"")).count();
        assert_eq!((rows("bad"), rows("good")), (failed, 8));
        assert!(
            open.ends_with(&format!("<summary>{}", 8 - failed)),
            "{}",
            &open[open.len() - 20..]
        );
        // What fails is first.
        let (first, _) = open.split_once("</tr><tr>").unwrap();
        assert_eq!(first.matches("class=\"bad\"").count(), failed);
    }
}

/// Setup: the recording is spoiled after the first analysis, which passed. Control: no file is removed, be it the user's own.
#[test]
fn report_of_an_earlier_analysis_is_named_when_no_recording_can_be_read() {
    let folder = Folder::write(MANIFEST, ordinary);
    let name = folder.name();
    assert_eq!(analyze(&[name]).code, 0);
    let files = || {
        let mut names: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
        names.sort();
        names
    };
    let before = files();
    fs::write(folder.path().join(&folder.files[0]), "spoiled").unwrap();
    let output = analyze(&[name]).exited_with(5);
    assert!(output.text.contains("report.html is of an earlier analysis"), "{}", output.text);
    assert_eq!(files(), before);
}

/// Two runs, of which the second is spoiled: the page shows the first one and names the second.
#[test]
#[ignore = "needs chromium"]
fn a_spoiled_run_is_named_next_to_an_intact_one() {
    let two = format!("{MANIFEST}[sweep]\n\"model.gas.temperature_k\" = [200.0, 300.0]\n");
    let torn = Folder::write(&two, ordinary);
    let bytes = fs::read(torn.file(1)).unwrap();
    fs::write(torn.file(1), &bytes[..bytes.len() * 2 / 3]).unwrap();
    let empty = Folder::write(&two, |run| match run.canonical().contains("300") {
        true => Vec::new(),
        false => ordinary(run),
    });
    for (folder, fault) in [(&torn, "torn"), (&empty, "no frame")] {
        let page = page(folder, &[5]);
        let spoiled = folder.files[1].as_str();
        let (_, unreadable) = page.split_once("Unreadable").expect(fault);
        let (list, _) = unreadable.split_once("</section>").unwrap();
        assert!(list.contains(spoiled), "{fault}: {list}");
        assert!(page.contains("class=\"film\""), "{fault}: nothing is replayed");
        assert_eq!(console(folder), "");
    }
}

/// Setup: every name that a user chooses contains an element whose script would end the page's content.
#[test]
#[ignore = "needs chromium"]
fn markup_in_names_is_text() {
    const MARKUP: &str = "<img src=x onerror=document.title='run'> & '</script><b>";
    let manifest = format!(
        "# {MARKUP}?\n{}[[plots]]\ny = \"/pressure.measured_n_per_m\"\ntitle = \"{MARKUP}\"\n[[sweep.variants]]\nname = \"{MARKUP}\"\n\
         [[sweep.variants]]\nname = \"plain\"\n\"model.gas.temperature_k\" = 200.0\n",
        MANIFEST.replace("<script>alert(1)</script>", MARKUP)
    );
    let folder = Folder::write(&manifest, ordinary);
    let page = page(&folder, &[0]);
    let is_markup = |(console, document): (String, String)| {
        let document = document.split("<script").next().unwrap_or_default().to_owned();
        !console.is_empty() || document.contains("<img") || document.contains("<title>run<")
    };
    assert!(page.matches("&lt;img").count() > 3, "the names are not shown");
    assert!(!is_markup(shown(&folder)));
    // Control.
    let path = folder.path().join("report.html");
    fs::write(
        &path,
        page.replacen(
            "&lt;img src=x onerror=document.title='run'&gt;",
            "<img src=x onerror=document.title='run'>",
            5,
        ),
    )
    .unwrap();
    assert!(is_markup(shown(&folder)));
}

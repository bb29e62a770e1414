//! Guarantee: on the first screen of a report, the replay begins above 260 px and is complete on a screen of 1280 x 800, and it begins on the first screen of
//! a phone. Below it, only the checked numbers are open, so that a page is short.
//!
//! Setup: headless Chromium; the page is in a frame of the size of the screen. Control: a page with a tall element at its start is found.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::browser::{dumped, element, with_script};
use crate::synthetic::{Folder, Frames, analyze, frames_of};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::DemEnergy;
use std::fs;
use std::path::Path;

/// Largest distance of the replay from the top of the page, px.
const MAX_TOP: f64 = 260.0;
/// Largest heights of the pages of these recordings, px.
const MAX_HEIGHTS: [f64; 2] = [2600.0, 4000.0];

const PROBE: &str = r#"<script>
held((async () => {
  await window.replay?.ready;
  await window.replay?.second?.ready;
  await nextFrames(5);
  const boxes = [...document.querySelectorAll("canvas")].filter((canvas) => canvas.checkVisibility()).map((canvas) => canvas.getBoundingClientRect());
  parent.postMessage(JSON.stringify([Math.min(...boxes.map((box) => box.top)), Math.max(...boxes.map((box) => box.bottom)), document.documentElement.scrollHeight]), "*");
})());
</script>"#;

/// Top and bottom of the replay, and the height of the page, px.
fn measured(page: &Path, [width, height]: [u32; 2]) -> [f64; 3] {
    let (probed, host) = (page.with_file_name("screen.html"), page.with_file_name("host.html"));
    fs::write(&probed, with_script(&fs::read_to_string(page).unwrap(), PROBE)).unwrap();
    let text = format!(
        "<!doctype html><title></title><iframe src=\"screen.html\" style=\"border:0\" width=\"{width}\" height=\"{height}\"></iframe>\
         <script>addEventListener(\"message\", (message) => {{ document.title = message.data; }});</script>"
    );
    fs::write(&host, text).unwrap();
    let (document, console) = dumped(&host, width + 40, false);
    assert_eq!(console, "");
    for file in [probed, host] {
        fs::remove_file(file).unwrap();
    }
    serde_json::from_str(element(&document, "title")).unwrap()
}

/// What is wrong with a page on a screen and on a phone.
fn faults(page: &Path) -> Vec<String> {
    let ([top, bottom, height], phone) = (measured(page, [1280, 800]), measured(page, [390, 844]));
    let mut faults = Vec::new();
    if top >= MAX_TOP || bottom > 800.0 {
        faults.push(format!("the replay is from {top} to {bottom} px"));
    }
    if phone[0] >= 844.0 {
        faults.push(format!("the replay begins at {} px on a phone", phone[0]));
    }
    for (found, most) in [height, phone[2]].into_iter().zip(MAX_HEIGHTS) {
        if found > most {
            faults.push(format!("the page is {found} px high"));
        }
    }
    faults
}

const MANIFEST: &str = r#"# How do discs fall, and does the answer to a question of two lines still leave room for the replay on the first screen of a small laptop? Expected: yes.
name = "falling"
[model.dem]
discs = 3
duration_s = 1.0
[record]
frames = 20
channels = ["state", "energy"]
[sweep]
"model.dem.restitution" = [0.2, 0.5, 0.8]
[[checks]]
metric = "energy.kinetic"
maximum = 1e9
[[plots]]
y = "/energy.kinetic_j"
"#;

fn frames(_: &RunManifest) -> Frames {
    frames_of(0..=20, |index, frame| {
        let time = f64::from(index) / 20.0;
        for disc in 0..3 {
            frame.push_state(&[
                0.01 * f64::from(disc + 1),
                0.001 + 0.03 * (1.0 - time),
                0.0,
                -0.03,
            ]);
        }
        frame.push(&DemEnergy { kinetic_j: 1e-4 * time, ..DemEnergy::default() });
        time
    })
}

#[test]
#[ignore = "needs chromium"]
fn replay_is_on_the_first_screen_and_the_page_is_short() {
    let folder = Folder::write(MANIFEST, frames);
    analyze(&[folder.name()]).exited_with(0);
    let page = folder.path().join("report.html");
    assert_eq!(faults(&page), [""; 0]);

    // Control.
    let text = fs::read_to_string(&page).unwrap();
    let tall = folder.path().join("tall.html");
    fs::write(&tall, text.replace("<main>", "<main><div style=\"height: 900px\"></div>")).unwrap();
    let found = faults(&tall).join("; ");
    assert!(found.contains("the replay is from") && found.contains("on a phone"), "{found}");
}

#[test]
fn what_is_not_asked_is_folded_after_the_checked_numbers() {
    let folder = Folder::write(MANIFEST, frames);
    analyze(&[folder.name()]).exited_with(0);
    let text = folder.page();
    let (_, body) = text.split_once("<main>").unwrap();
    let order = [
        "class=\"question\"",
        "class=\"result\"",
        "class=\"deck\"",
        "id=\"plot-",
        "<h2>Checked numbers</h2>",
        "<h2>Expectation and setup</h2>",
        "<h2>More plots</h2>",
        "<h2>All numbers</h2>",
        "<h2>Definitions</h2>",
        "<h2>Manifest of the first run</h2>",
        "<h2>Files and keys</h2>",
    ];
    let places: Vec<usize> = order.iter().map(|part| body.find(part).expect(part)).collect();
    assert!(places.is_sorted(), "{places:?}");
    let folded = &body[places[5] - "<summary>".len()..];
    assert_eq!(folded.matches("<h2>").count(), folded.matches("<summary><h2>").count());
    assert!(!folded.contains("<details open"));
}

#[test]
#[ignore = "needs chromium; REPORTS contains the paths of report.html files, separated by colons"]
fn given_replays_are_on_the_first_screen() {
    let reports = std::env::var("REPORTS").expect("REPORTS must name the reports");
    for page in reports.split(':') {
        let text = fs::read_to_string(page).unwrap();
        assert!(
            !text.contains("class=\"deck\"") || faults(Path::new(page)).is_empty(),
            "{page}: {:?}",
            faults(Path::new(page))
        );
    }
}

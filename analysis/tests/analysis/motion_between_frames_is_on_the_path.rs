//! Guarantee: between two frames, the report draws a particle within 0.5 % of the picture's width of its true place, and a path only where it is
//! known so well: not where a frame spans more than a revolution.
//!
//! Setup: a circle of 1 AU with frames of 0.5 rad, and of 7 rad, with velocities; the truth is the circle at ten times as many instants. In
//! headless Chromium.
//! Control: the chord of 0.5 rad is farther from the circle.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]
#![allow(clippy::disallowed_methods, reason = "positions of a test need no fixed bits")]

use crate::browser::{element, examined};
use crate::synthetic::{Folder, analyze, frames_of};
use serde_json::Value;

/// Frames of each run.
const FRAMES: u32 = 12;
/// Instants between two frames.
const INSTANTS: u32 = 10;

/// Appended to the page: the places at ten times as many instants, the width of the view, and how many parts of the path are drawn.
const PROBE: &str = r#"<script>
held((async () => {
  await replay.ready;
  const places = [];
  for (let instant = 0; instant <= 10 * (replay.frames - 1); instant++) {
    replay.show(instant / 10);
    places.push([replay.time, ...replay.positions()[0].slice(1)]);
  }
  const [x0, , x1] = replay.view, parts = replay.film.paths[0].filter(Boolean).length;
  document.title = JSON.stringify({ places, width: x1 - x0, parts });
})());
</script>"#;

/// What the page draws of a circle with frames of this angle: the largest distance from the truth over the width of the view, and the number
/// of parts of the path.
fn drawn(angle: f64) -> (f64, u64) {
    let manifest = format!(
        "name = \"circle\"\n[model.orbit]\nduration_days = {}\n[record]\nframes = {FRAMES}\nchannels = [\"state\"]\n",
        f64::from(FRAMES) * angle
    );
    let folder = Folder::write(&manifest, |_| {
        frames_of(0..=FRAMES, |index, frame| {
            let phase = f64::from(index) * angle;
            frame.push_state(&[phase.cos(), phase.sin(), 0.0, -phase.sin(), phase.cos(), 0.0]);
            phase
        })
    });
    assert!(analyze(&[folder.name()]).code != 2);
    let (document, console) = examined(&folder.path().join("report.html"), PROBE, false);
    assert_eq!(console, "");
    let found: Value = serde_json::from_str(element(&document, "title")).unwrap();
    let places = found["places"].as_array().unwrap();
    assert_eq!(places.len() as u32, INSTANTS * FRAMES + 1);
    let distance = |place: &Value| {
        let [time, x, y] = [0, 1, 2].map(|index| place[index].as_f64().unwrap());
        (x - time.cos()).hypot(y - time.sin())
    };
    let farthest = places.iter().map(distance).fold(0.0, f64::max);
    (farthest / found["width"].as_f64().unwrap(), found["parts"].as_u64().unwrap())
}

#[test]
#[ignore = "needs chromium"]
fn particles_and_paths_are_where_they_were() {
    let (farthest, parts) = drawn(0.5);
    assert!(
        farthest < 0.005 && parts == u64::from(FRAMES),
        "{farthest} of the width, {parts} parts"
    );
    // Control: a chord. Its middle is 1 - cos(0.25) away, and the view is at least 2.3 AU wide, with its margins.
    assert!((1.0 - 0.25_f64.cos()) / 2.4 > 0.005);
    let (farthest, parts) = drawn(7.0);
    assert!(parts == 0 && farthest > 0.1, "{parts} parts of a path that is not known");
}

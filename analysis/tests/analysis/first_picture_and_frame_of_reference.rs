//! Guarantee: the first picture of a bed at rest shows the box of its discs, and the playback the region of all positions, on a canvas of the same size. In the
//! frame that rotates with the planet, the planet and what shares its angle stay where they are.
//!
//! Setup: headless Chromium. Discs that fall from a height onto a floor; a Sun, a planet and a particle 60 degrees ahead on a circle.
//! Control: discs that still move are not enlarged; in the fixed frame, the planet moves by the diameter of its orbit.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]
#![allow(clippy::disallowed_methods, reason = "positions of a test need no fixed bits")]

use crate::browser::{element, examined};
use crate::synthetic::{Folder, analyze, frames_of};
use serde_json::Value;

/// The JSON that a script writes to the title of the page.
fn found(folder: &Folder, script: &str) -> Value {
    assert!(analyze(&[folder.name()]).code != 2);
    let script =
        format!("<script>held((async () => {{ await replay.ready; {script} }})());</script>");
    let (document, console) = examined(&folder.path().join("report.html"), &script, false);
    assert_eq!(console, "");
    serde_json::from_str(element(&document, "title")).unwrap()
}

/// Height of the view in the first picture and during playback, m, and whether the canvas keeps its height.
fn heights(end_speed: f64) -> (f64, f64, bool) {
    let manifest = "name = \"bed\"\n[model.dem]\ndiscs = 60\nwidth_m = 0.1\nheight_m = 0.5\nradius_m = 5e-4\nduration_s = 1.0\n[record]\nframes = 10\nchannels = [\"state\"]\n";
    let folder = Folder::write(manifest, |_| {
        frames_of(0..=10, |index, frame| {
            let left = 1.0 - f64::from(index) / 10.0;
            for disc in 0..60 {
                let place = 0.001 + 0.001 * f64::from(disc);
                frame.push_state(&[place, 0.0005 + 0.4 * left, 0.0, -(left + end_speed)]);
            }
            f64::from(index) / 10.0
        })
    });
    let script = "const height = () => replay.view[3] - replay.view[1], first = [height(), replay.canvas.height]; \
        replay.show(3); document.title = JSON.stringify([first[0], height(), first[1] === replay.canvas.height]);";
    let found = found(&folder, script);
    (found[0].as_f64().unwrap(), found[1].as_f64().unwrap(), found[2].as_bool().unwrap())
}

#[test]
#[ignore = "needs chromium"]
fn first_picture_of_a_bed_at_rest_is_enlarged() {
    let (first, whole, is_same_canvas) = heights(0.0);
    assert!(whole > 0.4 && first < 0.02 && is_same_canvas, "{first} of {whole}");
    // Control.
    let (first, whole, _) = heights(0.5);
    assert!(first == whole, "{first} of {whole}");
}

/// The largest distance of the planet and of the particle from their first places, AU.
fn travel(view: &str) -> [f64; 2] {
    let body = |position: &str, velocity: &str| {
        format!(
            "{{ gm_au3_per_day2 = 1e-4, position_au = {position}, velocity_au_per_day = {velocity} }}"
        )
    };
    let bodies = [
        body("[0.0, 0.0, 0.0]", "[0.0, 0.0, 0.0]"),
        body("[1.0, 0.0, 0.0]", "[0.0, 0.01, 0.0]"),
        body("[0.5, 0.8, 0.0]", "[0.0, 0.01, 0.0]"),
    ];
    let manifest = format!(
        "name = \"turning\"\n[model.orbit]\nduration_days = 6.0\ntime_step_days = 0.1\nbodies = [{}]\n[record]\nframes = 12\nchannels = [\"state\"]\n{view}",
        bodies.join(", ")
    );
    let folder = Folder::write(&manifest, |_| {
        frames_of(0..=12, |index, frame| {
            let time = f64::from(index) / 2.0;
            frame.push_state(&[0.0; 6]);
            for angle in [time, time + std::f64::consts::FRAC_PI_3] {
                let (sin, cos) = angle.sin_cos();
                frame.push_state(&[cos, sin, 0.0, -sin, cos, 0.0]);
            }
            time
        })
    });
    let script = "const places = []; for (let instant = 0; instant <= 120; instant++) { replay.show(instant / 10); places.push(replay.positions()); } \
        document.title = JSON.stringify([1, 2].map((i) => Math.max(...places.map((all) => Math.hypot(all[i][1] - places[0][i][1], all[i][2] - places[0][i][2])))));";
    let found = found(&folder, script);
    [0, 1].map(|body| found[body].as_f64().unwrap())
}

/// The names in the replay of two bodies whose manifest has three bodies and these names.
fn names_of_two(names: &str) -> Value {
    let body = |place: u32| {
        format!(
            "{{ gm_au3_per_day2 = 1e-4, position_au = [{place}.0, 0.0, 0.0], velocity_au_per_day = [0.0, 0.0{place}, 0.0] }}"
        )
    };
    let [first, second, third] = [1, 2, 3].map(body);
    let manifest = format!(
        "name = \"names\"\n[model.orbit]\nduration_days = 1.0\ntime_step_days = 0.1\nbodies = [{first}, {second}, {third}]\n[record]\nframes = 1\nchannels = [\"state\"]\n[view]\nnames = {names}\n"
    );
    let folder = Folder::write(&manifest, |_| {
        frames_of(0..=1, |index, frame| {
            frame.push_state(&[0.0; 6]);
            frame.push_state(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
            f64::from(index)
        })
    });
    assert!(analyze(&[folder.name()]).code != 2);
    let page = folder.page();
    let film = page.split("data-film=\"").nth(1).unwrap().split('"').next().unwrap();
    let film: Value = serde_json::from_str(&film.replace("&quot;", "\"")).unwrap();
    film["names"].clone()
}

/// Guarantee: names are drawn only if the run has a body for each: of more names, it is open which body has which. Control: as many names as
/// bodies are drawn.
#[test]
fn names_without_a_body_are_not_drawn() {
    assert_eq!(names_of_two("[\"Sun\", \"Earth\", \"Moon\"]"), serde_json::json!([]));
    assert_eq!(names_of_two("[\"Sun\", \"Earth\"]"), serde_json::json!(["Sun", "Earth"]));
}

#[test]
#[ignore = "needs chromium"]
fn planet_rests_in_the_frame_that_rotates_with_it() {
    let rotating = travel("[view]\nframe = \"rotating\"\n");
    assert!(rotating.iter().all(|distance| *distance < 0.02), "{rotating:?}");
    // Control.
    let fixed = travel("");
    assert!(fixed.iter().all(|distance| *distance > 1.9), "{fixed:?}");
}

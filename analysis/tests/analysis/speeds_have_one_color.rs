//! Guarantee: a particle has the same color in the report and in the picture of the list of experiments, whatever the manifest requests of the first picture:
//! its frame, and what its color means. A speed has the same color in the recording's drawing, too, and the upper end of the color scale in the report is
//! that of the recorded color bar.
//!
//! Setup: three large discs with speeds of 0, 0.4 and 0.9 of the recorded top, which the last frame exchanges. The picture is decoded from the page of the
//! list. Control: the color of another speed is not in the picture, and another request changes the colors.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::browser::{element, examined};
use crate::synthetic::{Folder, analyze, frames_of};
use crate::thumbnail_shows_the_recording::pictures;
use base64::Engine as _;
use kinetoscope_recording::drawing::{Rgb, SPEED_COLORS, Shape, read_shapes};
use kinetoscope_recording::reader::Recording;
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

const SPEEDS: [f64; 3] = [0.0, 0.4, 0.9];
/// Horizontal positions, m: the middle one is not between two steps of the colors.
const PLACES: [f64; 3] = [0.2, 0.45, 0.8];
/// Heights, m, likewise.
const HEIGHTS: [f64; 3] = [0.48, 0.497, 0.52];
/// The ground of both pictures.
const GROUND: Rgb = [0x10, 0x14, 0x18];

/// In the last frame, the speeds are multiplied by this.
fn folder(view: &str, last: f64) -> Folder {
    let manifest = format!(
        "name = \"colors\"\n[model.dem]\ndiscs = 3\nwidth_m = 1.0\nheight_m = 1.0\nradius_m = 0.1\nduration_s = 1.0\n\
         [record]\nframes = 1\nchannels = [\"state\", \"discs\"]\n{view}"
    );
    Folder::write(&manifest, |_| {
        frames_of(0..2, |index, frame| {
            for (disc, speed) in SPEEDS.iter().enumerate() {
                let speed = if index == 0 { *speed } else { last * (0.3 - *speed / 3.0) };
                frame.push_state(&[PLACES[disc], HEIGHTS[disc], speed, 0.0]);
            }
            f64::from(index)
        })
    })
}

/// A folder of one experiment with the page of the list, and the pixels of its picture.
struct Listed {
    #[allow(dead_code, reason = "it is removed when it is dropped")]
    folder: TempDir,
    page: PathBuf,
    pixels: Vec<Rgb>,
}

fn listed(folder: &Folder) -> Listed {
    let all = TempDir::new().unwrap();
    let below = all.path().join("colors");
    fs::create_dir(&below).unwrap();
    for entry in fs::read_dir(folder.path()).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), below.join(entry.file_name())).unwrap();
    }
    assert_eq!(analyze(&[all.path().to_str().unwrap()]).code, 0);
    let list = fs::read_to_string(all.path().join("index.html")).unwrap();
    let encoded = list.split("data:image/png;base64,").nth(1).unwrap().split('"').next().unwrap();
    let png = base64::engine::general_purpose::STANDARD.decode(encoded).unwrap();
    let (mut shown, _) = pictures(&png);
    Listed { folder: all, page: below.join("report.html"), pixels: shown.remove(0) }
}

/// The shapes of a layer in the first frame that has it.
fn shapes(folder: &Folder, topic: &str) -> Vec<Shape> {
    let frames = Recording::open(&folder.file(0)).unwrap().frames().unwrap().map(Result::unwrap);
    let mut scenes = frames.filter_map(|frame| {
        let message = frame.messages().iter().find(|message| message.topic() == topic)?;
        read_shapes(message.payload())
    });
    scenes.next().unwrap()
}

#[test]
fn page_list_and_recording_agree() {
    let folder = folder("[view]\nposter = 0.0\n", 1.0);
    let listed = listed(&folder);
    let legend = shapes(&folder, "/legend");
    let text = legend.iter().rev().find_map(|shape| match shape {
        Shape::Text { text, .. } => Some(text.clone()),
        _ => None,
    });
    let page = fs::read_to_string(&listed.page).unwrap();
    let film = page.split("data-film=\"").nth(1).unwrap().split('"').next().unwrap();
    let film: serde_json::Value = serde_json::from_str(&film.replace("&quot;", "\"")).unwrap();
    assert_eq!(film["speedTopText"].as_str(), text.as_deref(), "the color bars differ");

    let pixels = |color: Rgb| listed.pixels.iter().filter(|pixel| **pixel == color).count();
    let recorded: Vec<Rgb> = shapes(&folder, "/discs")
        .iter()
        .filter_map(|shape| match shape {
            Shape::Disc { color, .. } => Some(*color),
            _ => None,
        })
        .collect();
    assert_eq!(recorded.len(), SPEEDS.len());
    for color in &recorded {
        assert!(pixels(*color) > 20, "{color:?} is not in the picture");
    }
    // Control: the color of the top speed, which no disc has.
    assert_eq!(pixels(SPEED_COLORS[SPEED_COLORS.len() - 1]), 0);
}

/// The colors of the middles of the discs in the first picture of the page, from the left, and in the picture of the list.
fn colors([view, last]: [&str; 2]) -> [Vec<Rgb>; 2] {
    let listed = listed(&folder(view, last.parse().unwrap()));
    let script = "<script>held((async () => { await replay.ready; const { canvas } = replay, { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height); \
        const at = ([, x, y]) => { const [across, down] = replay.pixel(x, y).map(Math.round), place = 4 * (down * canvas.width + across); return [...data.slice(place, place + 3)]; }; \
        document.title = JSON.stringify(replay.positions().map(at)); })());</script>";
    let (document, console) = examined(&listed.page, script, false);
    assert_eq!(console, "");
    let of_page: Vec<Rgb> = serde_json::from_str(element(&document, "title")).unwrap();
    // The row of the middles, in 16:9.
    let width = 384;
    let row = &listed.pixels[listed.pixels.len() / 2 / width * width..][..width];
    let mut of_list: Vec<Rgb> = Vec::new();
    for run in row.chunk_by(|one, other| one == other).filter(|run| run.len() > 8) {
        if run[0] != GROUND && !of_list.contains(&run[0]) {
            of_list.push(run[0]);
        }
    }
    [of_page, of_list]
}

#[test]
#[ignore = "needs chromium"]
fn page_and_list_begin_with_the_requested_frame_and_colors() {
    let requests = [
        ["", "1"],
        ["[view]\nposter = 0.0\n", "1"],
        ["[view]\ncolor = \"side\"\n", "1"],
        // At rest, the speeds have one color: without a request, colors are those of the heights at the start.
        ["", "1e-3"],
        ["[view]\ncolor = \"height\"\n", "1"],
    ];
    let found = requests.map(colors);
    for ([page, list], request) in found.iter().zip(requests) {
        assert_eq!(page, list, "{request:?}");
        assert_eq!(page.len(), 3, "{request:?}");
    }
    // Control.
    assert!(found[0] != found[1] && found[1] != found[2] && found[0] != found[2], "{found:?}");
    assert!(found[3] == found[4] && found[3] != found[0], "{found:?}");
    // A request for the speed is one, also at rest.
    let [page, _] = colors(["[view]\ncolor = \"speed\"\n", "1e-3"]);
    assert!(page.iter().all(|color| *color == page[0]), "{page:?}");
}

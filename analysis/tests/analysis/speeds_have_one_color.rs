//! Guarantee: a speed has the same color in the recording's drawing, in the report and in the picture of the list of experiments, and the upper end of
//! the color scale in the report is that of the recorded color bar.
//!
//! Setup: three large discs with speeds of 0, 0.4 and 0.9 of the recorded top. The picture is decoded from the page of the list.
//! Control: the color of another speed is not in the picture.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::synthetic::{Folder, analyze, frames_of};
use crate::thumbnail_shows_the_recording::pictures;
use base64::Engine as _;
use kinetoscope_recording::drawing::{Rgb, Shape, read_shapes};
use kinetoscope_recording::reader::Recording;
use std::fs;
use tempfile::TempDir;

const SPEEDS: [f64; 3] = [0.0, 0.4, 0.9];

fn folder() -> Folder {
    let manifest = "name = \"colors\"\n[model.dem]\ndiscs = 3\nwidth_m = 1.0\nheight_m = 1.0\nradius_m = 0.1\nduration_s = 1.0\n\
                    [record]\nframes = 1\nchannels = [\"state\", \"discs\"]\n";
    Folder::write(manifest, |_| {
        frames_of(0..2, |index, frame| {
            for (disc, speed) in SPEEDS.iter().enumerate() {
                frame.push_state(&[0.2 + 0.3 * disc as f64, 0.5, *speed, 0.0]);
            }
            f64::from(index)
        })
    })
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
    let folder = folder();
    let all = TempDir::new().unwrap();
    let below = all.path().join("colors");
    fs::create_dir(&below).unwrap();
    for entry in fs::read_dir(folder.path()).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), below.join(entry.file_name())).unwrap();
    }
    assert_eq!(analyze(&[all.path().to_str().unwrap()]).code, 0);

    let legend = shapes(&folder, "/legend");
    let text = legend.iter().rev().find_map(|shape| match shape {
        Shape::Text { text, .. } => Some(text.clone()),
        _ => None,
    });
    let page = fs::read_to_string(below.join("report.html")).unwrap();
    let film = page.split("data-film=\"").nth(1).unwrap().split('"').next().unwrap();
    let film: serde_json::Value = serde_json::from_str(&film.replace("&quot;", "\"")).unwrap();
    assert_eq!(film["speedTopText"].as_str(), text.as_deref(), "the color bars differ");

    let list = fs::read_to_string(all.path().join("index.html")).unwrap();
    let encoded = list.split("data:image/png;base64,").nth(1).unwrap().split('"').next().unwrap();
    let png = base64::engine::general_purpose::STANDARD.decode(encoded).unwrap();
    let (shown, _) = pictures(&png);
    let pixels = |color: Rgb| shown[0].iter().filter(|pixel| **pixel == color).count();
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
    assert_eq!(pixels([0xff, 0xe4, 0x30]), 0);
}

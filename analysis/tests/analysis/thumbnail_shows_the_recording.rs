//! Guarantee: a thumbnail shows each recorded disc at its position and in its color. An animation covers the recording from its first to its
//! last frame. The same recording gives the same bytes.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::synthetic::header;
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::recorder::{Clock, Header, Outcome, Recorder, Selection};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};
use std::fs::{self, File};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

type Rgb = [u8; 3];

/// The colors of speed zero and of the maximum speed: the ends of the color map.
const AT_REST: Rgb = [0x39, 0x6f, 0xc8];
const FASTEST: Rgb = [0xff, 0xe4, 0x30];
const WHITE: Rgb = [0xff; 3];
const FRAMES: u32 = 9;

const COLUMNS: &[StateColumn] = &[
    StateColumn { name: "x", unit: "m" },
    StateColumn { name: "y", unit: "m" },
    StateColumn { name: "vx", unit: "m/s" },
    StateColumn { name: "vy", unit: "m/s" },
];

/// Position of the fast disc in a frame, in a box from 0 to 4 m.
fn position_of_the_fast_disc(frame: u32) -> [f64; 2] {
    [0.5 + 0.25 * f64::from(frame), 1.0]
}

/// A recording of a disc that moves to the right and one at rest above it.
fn recording(folder: &Path, channels: &[&str]) -> PathBuf {
    let bare = header("dem");
    let header = Header {
        state_columns: COLUMNS,
        selection: Selection::Named(channels.iter().map(ToString::to_string).collect()),
        scenery: Scenery {
            walls: vec![Wall::Rectangle { min: [0.0, 0.0], max: [4.0, 4.0] }],
            view: [[0.0, 0.0], [4.0, 4.0]],
            drawn_radius: DrawnRadius::Fixed(0.25),
            speed_unit: "m/s",
            ..bare.scenery
        },
        frames_expected: Some(u64::from(FRAMES)),
        ..bare
    };
    let path = folder.join("discs.mcap");
    let mut recorder = Recorder::create(File::create(&path).unwrap(), &header).unwrap();
    for index in 0..FRAMES {
        let mut frame = Frame::new();
        let [x, y] = position_of_the_fast_disc(index);
        frame.push_state(&[x, y, 1.0, 0.0]);
        frame.push_state(&[2.0, 3.0, 0.0, 0.0]);
        let time = f64::from(index);
        recorder.write(Clock { count: u64::from(index), time }, &mut frame).unwrap();
    }
    recorder.finish(&Outcome::Complete).unwrap();
    path
}

fn export(recording: &Path, picture: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_kinetoscope"))
        .arg("export")
        .arg("--thumbnail")
        .arg(picture)
        .args(more)
        .arg(recording)
        .output()
        .unwrap()
}

/// The file of a thumbnail.
fn drawn(name: &str, more: &[&str]) -> Vec<u8> {
    let folder = TempDir::new().unwrap();
    let recording = recording(folder.path(), &["state", "discs"]);
    let picture = folder.path().join(name);
    let output = export(&recording, &picture, more);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read(picture).unwrap()
}

/// The pictures of a PNG file as a browser shows them, row by row, and their width.
pub(crate) fn pictures(file: &[u8]) -> (Vec<Vec<Rgb>>, usize) {
    let mut decoder = png::Decoder::new(Cursor::new(file));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().unwrap();
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let count = reader.info().animation_control.map_or(1, |control| control.num_frames);
    let mut canvas = vec![[0; 3]; width * height];
    let mut buffer = vec![0; reader.output_buffer_size().unwrap()];
    let mut shown = Vec::new();
    for _ in 0..count {
        let part = reader.next_frame(&mut buffer).unwrap();
        let control = reader.info().frame_control;
        let [left, top] = control.map_or([0, 0], |part| [part.x_offset, part.y_offset]);
        for (row, pixels) in buffer[..part.buffer_size()].chunks(part.line_size).enumerate() {
            let start = (top as usize + row) * width + left as usize;
            for (column, pixel) in pixels.chunks_exact(3).enumerate() {
                canvas[start + column] = [pixel[0], pixel[1], pixel[2]];
            }
        }
        shown.push(canvas.clone());
    }
    (shown, width)
}

/// The rows of a picture inside the box, without the color bar below it; the box is square.
fn inside(picture: &[Rgb], width: usize) -> &[Rgb] {
    &picture[..width * width]
}

/// The mean position of the pixels of a color in px, and their number.
fn place(picture: &[Rgb], width: usize, color: Rgb) -> ([f64; 2], usize) {
    let found = inside(picture, width).iter().enumerate().filter(|(_, pixel)| **pixel == color);
    let found: Vec<[f64; 2]> =
        found.map(|(index, _)| [(index % width) as f64, (index / width) as f64]).collect();
    assert!(!found.is_empty(), "no pixel has the color {color:?}");
    let mean = |axis: usize| found.iter().map(|at| at[axis]).sum::<f64>() / found.len() as f64;
    ([mean(0), mean(1)], found.len())
}

#[test]
fn each_disc_is_drawn_at_its_position_in_its_color() {
    let (shown, width) = pictures(&drawn("moving.png", &["--thumbnail-frames", "9"]));
    assert_eq!(shown.len(), FRAMES as usize);
    assert_eq!(shown[0][width + 1], WHITE, "the background");
    // The disc at rest is the reference point; the displacement of the fast disc by 2 m gives the scale.
    let (fixed, pixels) = place(&shown[0], width, AT_REST);
    let ends = [&shown[0], &shown[8]].map(|picture| place(picture, width, FASTEST).0[0]);
    let scale = (ends[1] - ends[0]) / 2.0;
    // The box of 4 m and a margin of 3 % on both sides fill the width, except for the labels of the color bar.
    assert!((scale * 4.0 * 1.06 / width as f64 - 1.0).abs() < 0.05, "{scale} px per meter");
    for (frame, picture) in shown.iter().enumerate() {
        let [x, y] = position_of_the_fast_disc(frame as u32);
        let (fast, _) = place(picture, width, FASTEST);
        // Positions are rounded to pixels: half of a pixel for each of the two discs.
        assert!((fast[0] - fixed[0] - scale * (x - 2.0)).abs() < 1.0, "frame {frame}: {fast:?}");
        assert!((fast[1] - fixed[1] + scale * (y - 3.0)).abs() < 1.0, "frame {frame}: {fast:?}");
    }
    // The fully colored pixels of a disc cover its area except for a rim of about half a pixel.
    let area = std::f64::consts::PI * (0.25 * scale) * (0.25 * scale);
    let rim = std::f64::consts::PI * 2.0 * 0.25 * scale;
    assert!((pixels as f64) < area && pixels as f64 > area - rim, "{pixels} px of {area}");
}

#[test]
fn still_picture_shows_the_last_frame_and_is_reproducible() {
    let still = drawn("still.png", &[]);
    let moving = drawn("moving.png", &["--thumbnail-frames", "5"]);
    let ((still_pictures, _), (moving_pictures, _)) = (pictures(&still), pictures(&moving));
    assert_eq!(moving_pictures.len(), 5);
    let last = &moving_pictures[4];
    // An animation has 256 colors for all frames, so a pixel on the rim of a disc may have the nearest color.
    let pairs = still_pictures[0].as_flattened().iter().zip(last.as_flattened());
    let farthest = pairs.map(|(still, last)| still.abs_diff(*last)).max().unwrap();
    assert!(farthest <= 16, "{farthest} of 255");
    assert!(moving_pictures[0] != *last);
    assert!(still == drawn("again.png", &[]));
    assert!(moving == drawn("again.png", &["--thumbnail-frames", "5"]));
}

#[test]
fn svg_contains_the_shapes_and_the_labels_of_the_color_bar() {
    let svg = String::from_utf8(drawn("still.svg", &["--thumbnail-width", "300"])).unwrap();
    assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"300\""), "{svg}");
    assert_eq!(svg.matches("<circle").count(), 2);
    assert_eq!(svg.matches("<path").count(), 1, "the box");
    assert!(svg.contains(">speed 0</text>") && svg.contains(">1 m/s</text>"), "{svg}");
}

#[test]
fn impossible_thumbnails_are_rejected() {
    let folder = TempDir::new().unwrap();
    let bare = recording(folder.path(), &["state"]);
    for (picture, more, code, word) in [
        ("picture.png", &[] as &[&str], 5, "\"discs\""),
        ("picture.jpg", &[], 2, ".png"),
        ("picture.svg", &["--thumbnail-frames", "3"], 2, "SVG"),
        ("picture.png", &["--thumbnail-frames", "0"], 2, "0"),
        ("picture.png", &["--thumbnail-width", "5"], 2, "64"),
    ] {
        let output = export(&bare, &folder.path().join(picture), more);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{message}");
        assert!(message.contains(word), "{message}");
        assert!(!folder.path().join(picture).exists());
    }
}

//! Guarantee: drawings show the state within their grid, and every drawn object is visible.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::sample::{header, read};
use foxglove::messages::{CubePrimitive, LinePrimitive, SceneEntity, SceneUpdate};
use kinetoscope_recording::frame::{ContactLine, Frame};
use kinetoscope_recording::reader::RecordedFrame;
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder};
use kinetoscope_recording::scenery::{DrawnRadius, GuideMeaning, Wall};
use prost::Message as _;
use std::f64::consts::TAU;
use std::num::NonZeroU32;

/// Records frames and reads them back.
fn recorded(header: &Header, frames: &[Frame]) -> Vec<RecordedFrame> {
    let mut recorder = Recorder::create(Vec::new(), header).unwrap();
    for (index, frame) in (0..).zip(frames) {
        recorder.write(Clock { count: index, time: index as f64 }, &mut frame.clone()).unwrap();
    }
    let bytes = recorder.finish(&Outcome::Complete).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (frames, error) = read(&bytes, &folder.path().join("drawing.mcap"));
    assert_eq!(error, None);
    frames
}

fn entity(frame: &RecordedFrame, topic: &str) -> SceneEntity {
    let message = frame.messages().iter().find(|message| message.topic() == topic).unwrap();
    let mut scene = SceneUpdate::decode(message.payload()).unwrap();
    assert_eq!(scene.entities.len(), 1, "{topic}");
    let entity = scene.entities.remove(0);
    assert_eq!(entity.id, topic[1..]);
    assert_eq!(entity.frame_id, "world");
    entity
}

fn frame_of(rows: &[[f64; 5]]) -> Frame {
    let mut frame = Frame::new();
    rows.iter().for_each(|row| frame.push_state(row));
    frame
}

#[test]
fn discs_are_drawn_at_their_positions() {
    // The container has a width of 2 and the grid a spacing of 2 / 4096, so the error is at most half of the spacing.
    let rows = [[0.123_456_789, -0.987_654_321, 1.5, 0.0, 0.02], [-1.0, 1.0, 0.0, 0.0, 0.5]];
    let frames = recorded(&header(Compression::Zstd), &[frame_of(&rows)]);
    let discs = entity(&frames[0], "/discs").cylinders;
    assert_eq!(discs.len(), 2);
    for (disc, row) in discs.iter().zip(&rows) {
        let place = disc.pose.unwrap().position.unwrap();
        assert!((place.x - row[0]).abs() <= 1.0 / 4096.0, "{}", place.x);
        assert!((place.y - row[1]).abs() <= 1.0 / 4096.0, "{}", place.y);
        assert_eq!((place.x * 2048.0).fract(), 0.0);
        let size = disc.size.unwrap();
        assert_eq!((size.x, size.y), (2.0 * row[4], 2.0 * row[4]));
        assert!(size.z > 0.0);
        assert_eq!((disc.bottom_scale, disc.top_scale), (1.0, 1.0));
        assert_eq!(disc.color.unwrap().a, 1.0);
    }
    // At rest: blue #396fc8.
    let blue = discs[1].color.unwrap();
    assert_eq!((blue.r, blue.g, blue.b), (57.0 / 255.0, 111.0 / 255.0, 200.0 / 255.0));
    assert_ne!(discs[0].color, discs[1].color);
}

#[test]
fn thinning_affects_drawings_and_not_the_state() {
    let rows: Vec<[f64; 5]> =
        (0..25_000).map(|index| [f64::from(index) / 25_000.0, 0.0, 0.1, 0.1, 0.001]).collect();
    let frames = recorded(&header(Compression::Zstd), &[frame_of(&rows)]);
    // Every third of 25,000.
    assert_eq!(entity(&frames[0], "/discs").cylinders.len(), 8_334);
    assert_eq!(entity(&frames[0], "/velocity").lines[0].points.len(), 2 * 8_334);
    assert_eq!(frames[0].state().unwrap().rows(), 25_000);
}

#[test]
fn manifest_limits_the_number_of_drawn_particles() {
    let mut header = header(Compression::Zstd);
    header.max_drawn_particles = NonZeroU32::new(10).unwrap();
    let rows: Vec<[f64; 5]> = (0..35).map(|index| [f64::from(index), 0.0, 0.1, 0.1, 0.1]).collect();
    let mut frame = frame_of(&rows);
    // The 30 strongest of 40 contacts are drawn: forces 10 to 39; those above 10 have the largest thickness.
    for force in (0..40).rev() {
        frame.push_contact(ContactLine {
            from: [0.0, 0.0],
            to: [0.5, 0.5],
            force: f64::from(force),
        });
    }
    let frames = recorded(&header, &[frame]);
    // Every fourth of 35.
    assert_eq!(entity(&frames[0], "/discs").cylinders.len(), 9);
    let lines = entity(&frames[0], "/force_chains").lines;
    assert_eq!(lines.iter().map(|line| line.points.len() / 2).sum::<usize>(), 30);
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert_eq!(frames[0].state().unwrap().rows(), 35);
}

/// Of a dense bed's 2000 contacts, the 500 strongest are drawn, in red, which no disc has.
#[test]
fn at_most_500_force_chains_are_drawn() {
    let mut frame = frame_of(&[[0.0; 5]]);
    for force in 0..2000 {
        let (from, to) = ([0.0, 0.0], [0.5, 0.5]);
        frame.push_contact(ContactLine { from, to, force: f64::from(force * 577 % 2000) / 100.0 });
    }
    let frames = recorded(&header(Compression::Zstd), &[frame]);
    let lines = entity(&frames[0], "/force_chains").lines;
    assert_eq!(lines.iter().map(|line| line.points.len() / 2).sum::<usize>(), 500);
    // The strongest force of the sample's scale is 10, so the drawn ones, above 15, have the largest thickness.
    assert_eq!(lines.len(), 1);
    let color = lines[0].color.unwrap();
    assert_eq!((color.r, color.g, color.b), (200.0 / 255.0, 20.0 / 255.0, 20.0 / 255.0));
}

/// In a view of width 2, the smallest drawn diameter is 0.6 %, or 0.012. Control: larger discs are drawn to scale, and a
/// recording without them states nothing.
#[test]
fn small_discs_are_enlarged_and_the_log_states_this() {
    let mut header = header(Compression::Zstd);
    let rows = [[0.0, 0.0, 0.0, 0.0, 0.001], [0.5, 0.0, 0.0, 0.0, 0.0061]];
    let states = |frames: &[RecordedFrame]| {
        frames[0]
            .log_lines()
            .iter()
            .any(|line| line.text.contains("at least 0.6 % of the view wide"))
    };
    assert!(!states(&recorded(&header, &[frame_of(&rows)])));
    header.scenery.drawn_radius = DrawnRadius::Column { min: 0.001 };
    let frames = recorded(&header, &[frame_of(&rows)]);
    let discs = entity(&frames[0], "/discs").cylinders;
    let widths: Vec<f64> = discs.iter().map(|disc| disc.size.unwrap().x).collect();
    assert_eq!(widths, [0.012, 0.0122]);
    assert!(states(&frames));
    assert_eq!(frames[0].state().unwrap().value(0, "radius"), Some(0.001));
}

#[test]
fn diverged_disc_is_recorded_and_not_drawn() {
    let rows = [[f64::NAN, 0.0, 0.0, 0.0, 0.1], [0.5, 0.0, f64::INFINITY, 0.0, 0.1], [0.0; 5]];
    let frames = recorded(&header(Compression::Zstd), &[frame_of(&rows)]);
    assert_eq!(entity(&frames[0], "/discs").cylinders.len(), 1);
    let state = frames[0].state().unwrap();
    assert_eq!(state.value(0, "x").unwrap().to_bits(), f64::NAN.to_bits());
    assert_eq!(state.value(1, "vx"), Some(f64::INFINITY));
}

#[test]
fn arrows_are_parallel_to_the_velocity() {
    // Maximum speed 2 in a container of width 2: an arrow of 0.06 x 2 for speed 2, so 0.06 for speed 1.
    let frames = recorded(&header(Compression::Zstd), &[frame_of(&[[0.0, 0.0, 0.0, -1.0, 0.1]])]);
    let lines = entity(&frames[0], "/velocity").lines;
    let [from, to] = lines[0].points[..] else { panic!("{lines:?}") };
    assert_eq!((from.x, from.y), (0.0, 0.0));
    assert_eq!(to.x, 0.0);
    assert!((to.y + 0.06).abs() <= 1.0 / 4096.0, "{}", to.y);
}

#[test]
fn strong_forces_are_thick_and_missing_contacts_give_an_empty_entity() {
    let contact = |force| ContactLine { from: [0.0, 0.0], to: [0.5, 0.5], force };
    let mut touching = Frame::new();
    for force in [0.1, 5.0, 9.9, 50.0] {
        touching.push_contact(contact(force));
    }
    let frames = recorded(&header(Compression::Zstd), &[touching, Frame::new()]);
    let lines = entity(&frames[0], "/force_chains").lines;
    let widths: Vec<(f64, usize)> =
        lines.iter().map(|line| (line.thickness, line.points.len() / 2)).collect();
    assert_eq!(widths, [(0.8, 1), (1.8, 1), (3.4, 2)]);
    assert_eq!(entity(&frames[1], "/force_chains").lines, []);
}

#[test]
fn container_and_color_bar_are_written_once() {
    let frame = frame_of(&[[0.0; 5]]);
    let frames = recorded(&header(Compression::Zstd), &[frame.clone(), frame]);
    let walls = entity(&frames[0], "/walls");
    assert_eq!((walls.lines.len(), walls.cylinders.len()), (2, 1));
    let legend = entity(&frames[0], "/legend");
    assert_eq!(legend.cubes.len(), 40);
    let texts: Vec<&str> = legend.texts.iter().map(|text| text.text.as_str()).collect();
    assert_eq!(texts, ["speed 0", "2 m/s"]);
    assert!(legend.texts.iter().all(|text| text.font_size == 16.0 && text.scale_invariant));
    for message in frames[1].messages() {
        assert!(!["/walls", "/legend"].contains(&message.topic()));
    }
}

#[test]
fn moving_walls_are_drawn_at_their_positions() {
    let mut moved = frame_of(&[[0.0; 5]]);
    let angles_rad = [0.1, TAU - 0.1];
    moved.push_wall(Wall::Arc { center: [0.25, 0.0], radius: 0.5, angles_rad });
    let frames = recorded(&header(Compression::Zstd), &[frame_of(&[[0.0; 5]]), moved]);
    assert_eq!(entity(&frames[0], "/walls").lines.len(), 2);
    let walls = entity(&frames[1], "/walls");
    assert_eq!((walls.lines.len(), walls.cylinders.len()), (1, 0));
    let corners = &walls.lines[0].points;
    let distance = |x: f64, y: f64| ((x - 0.25) * (x - 0.25) + y * y).sqrt();
    assert!(corners.iter().all(|corner| (distance(corner.x, corner.y) - 0.5).abs() < 1e-15));
    // The opening is centered on the x axis: from -0.1 to 0.1 rad.
    let (first, last) = (corners[0], corners[corners.len() - 1]);
    assert!((first.x - (0.25 + 0.5 * libm::cos(0.1))).abs() < 1e-15, "{}", first.x);
    assert!((first.y - 0.5 * libm::sin(0.1)).abs() < 1e-15, "{}", first.y);
    assert!((last.y + 0.5 * libm::sin(0.1)).abs() < 1e-15, "{}", last.y);
    assert!(corners.iter().all(|corner| libm::atan2(corner.y, corner.x - 0.25).abs() > 0.0999));
}

/// In a long box, the color bar has half of the length (not the height) of the box and is below it.
#[test]
fn color_bar_of_a_flat_box_is_legible() {
    let mut header = header(Compression::Zstd);
    header.scenery.view = [[0.0, 0.0], [20.0, 1.0]];
    let frames = recorded(&header, &[frame_of(&[[0.0; 5]])]);
    let legend = entity(&frames[0], "/legend");
    let place = |cube: &CubePrimitive| cube.pose.unwrap().position.unwrap();
    let (first, last) = (place(&legend.cubes[0]), place(&legend.cubes[39]));
    assert!((last.x - first.x - 10.0 * 39.0 / 40.0).abs() < 1e-12);
    assert!(first.y < 0.0);
}

/// Names are next to the particles, the central one is yellow, and lines for comparison are thin.
#[test]
fn names_the_central_body_and_lines_for_comparison_are_drawn() {
    let mut header = header(Compression::Zstd);
    header.scenery.names = vec![String::new(), "Earth".to_owned()];
    header.scenery.central_particle = Some(0);
    let axes = [[0.5, 0.0], [0.0, 0.25]];
    header.scenery.walls = vec![
        Wall::Guide { center: [0.25, 0.0], axes, meaning: GuideMeaning::ExactSolution },
        Wall::Label { center: [0.0, -0.5], text: "Sun" },
    ];
    let frames = recorded(&header, &[frame_of(&[[0.0; 5], [0.5, 0.0, 0.0, 0.0, 0.1]])]);
    let discs = entity(&frames[0], "/discs");
    let yellow = discs.cylinders[0].color.unwrap();
    assert_eq!((yellow.r, yellow.g, yellow.b), (240.0 / 255.0, 200.0 / 255.0, 60.0 / 255.0));
    assert_ne!(discs.cylinders[1].color, discs.cylinders[0].color);
    let [name] = &discs.texts[..] else { panic!("{:?}", discs.texts) };
    assert_eq!(name.text, "Earth");
    assert!((name.pose.unwrap().position.unwrap().x - 0.55).abs() < 1e-12);
    let walls = entity(&frames[0], "/walls");
    assert_eq!(walls.texts[0].text, "Sun");
    assert_eq!(walls.lines[0].thickness, 1.5);
    for corner in &walls.lines[0].points {
        let [x, y] = [(corner.x - 0.25) / 0.5, corner.y / 0.25];
        assert!((x * x + y * y - 1.0).abs() < 1e-14);
    }
}

#[test]
fn trail_ends_at_the_position_of_the_particle() {
    let at = |x: f64| frame_of(&[[x, 0.0, 0.0, 0.0, 0.1], [-x, 0.0, 0.0, 0.0, 0.1]]);
    let frames = recorded(&header(Compression::Zstd), &[at(0.0), at(0.25), at(0.5)]);
    let lines = entity(&frames[2], "/trail").lines;
    let path = |line: &LinePrimitive| line.points.iter().map(|point| point.x).collect::<Vec<f64>>();
    assert_eq!(path(&lines[0]), [0.0, 0.25, 0.5, 0.5]);
    assert_eq!(path(&lines[1]), [0.0, -0.25, -0.5, -0.5]);
}

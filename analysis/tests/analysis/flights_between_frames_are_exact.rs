//! Law: discs fly straight, in gravity on parabolas, between the collisions of `/events`, so that the data of the report's replay give the position of
//! each disc at any time between its frames.
//!
//! Source: free flight. The truth is the same run with 500 times as many frames, and without `/events`.
//! Setup: walls with noise, inelastic discs of several sizes in a periodic box, gravity, obstacles, and a gas in a circle; ten frames, and 1,000 random instants.
//! Tolerance: half a stored step per axis, and the way at the largest speed in the time between frames over 65,534, which times are rounded to. A run
//! that has more collisions than a small page has room for is exact up to the frame that the page states.
//! Control: without the corners, discs are elsewhere at most instants; without `/events`, the page has neither corners nor the script for them.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]
#![allow(clippy::disallowed_methods, reason = "a tolerance does not need the same bits everywhere")]

use crate::replay_shows_the_recording::{attribute, series, unescaped};
use crate::synthetic::analyze;
use kinetoscope_recording::reader::Recording;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

const FRAMES: u64 = 10;
const DENSE_FRAMES: u64 = 5000;
const INSTANTS: usize = 1000;
const PEGS: &str =
    "obstacles = { positions = [[-4.0, -3.0], [3.5, 0.0], [-1.0, 7.5]], radius = 1.5 }\n";
/// The largest stored time.
const LARGEST: f64 = 65_534.0;

/// Records a model with this number of frames.
fn record(folder: &Path, model: &str, frames: u64, channels: &str) -> PathBuf {
    let manifest = folder.join(format!("frames_{frames}.toml"));
    let text = format!(
        "name = \"flights_{frames}\"\nseed = 5\n[model.{model}\n[record]\nframes = {frames}\nchannels = [{channels}]\n"
    );
    std::fs::write(&manifest, text).unwrap();
    let arguments: [&std::ffi::OsStr; 4] =
        ["--quiet".as_ref(), "--output".as_ref(), folder.as_os_str(), manifest.as_os_str()];
    let ran = Command::new(env!("CARGO_BIN_EXE_run-experiment")).args(arguments).output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    folder.join(format!("flights_{frames}"))
}

/// A film with the corners between its frames, in the units of the state.
struct Film {
    note: String,
    times: Vec<f64>,
    numbers: Vec<u32>,
    particles: usize,
    step: f64,
    gravity: f64,
    /// Places per frame and particle.
    places: Vec<[f64; 2]>,
    /// For each interval and particle, the parts of the interval and the places.
    corners: Vec<Vec<(f64, [f64; 2])>>,
}

fn film(page: &str) -> Film {
    use base64::Engine as _;
    let element = page.split("<script type=\"text/plain\" class=\"film\"").nth(1).unwrap();
    let description = unescaped(attribute(element, "data-film").unwrap());
    let description: Value = serde_json::from_str(&description).unwrap();
    let text = element.split_once('>').unwrap().1.split('<').next().unwrap();
    let packed = base64::engine::general_purpose::STANDARD.decode(text).unwrap();
    let data = miniz_oxide::inflate::decompress_to_vec(&packed).unwrap();
    let number = |of: &Value| of.as_u64().unwrap() as usize;
    let [frames, particles] = ["frames", "particles"].map(|name| number(&description[name]));
    let times = data[..8 * frames].chunks_exact(8);
    let numbers = data[8 * frames..12 * frames].chunks_exact(4);
    let (step, order) =
        (description["step"].as_f64().unwrap(), |axis: usize| &description["orders"][axis]);
    let mut at = 12 * frames + 2 * particles;
    let stored = [0, 1]
        .map(|axis| series(&data, &mut at, [frames, particles], order(axis).as_u64().unwrap()));
    let place = |x: u16, y: u16| {
        let origin = [0, 1].map(|axis| description["origin"][axis].as_f64().unwrap());
        [origin[0] + f64::from(x) * step, origin[1] + f64::from(y) * step]
    };
    let [count, intervals] = [0, 1].map(|index| number(&description["flights"][index]));
    let mut at = data.len() - 2 * intervals * particles - 6 * count;
    let counts = series(&data, &mut at, [intervals, particles], 1);
    let [parts, xs, ys] = [(); 3].map(|()| series(&data, &mut at, [count, 1], 1));
    let mut all =
        (0..count).map(|index| (f64::from(parts[index]) / LARGEST, place(xs[index], ys[index])));
    let mut corners = vec![Vec::new(); intervals * particles];
    for particle in 0..particles {
        for index in (particle..counts.len()).step_by(particles) {
            corners[index] = all.by_ref().take(usize::from(counts[index])).collect();
        }
    }
    assert!(all.next().is_none() && at == data.len());
    Film {
        note: unescaped(attribute(element, "data-note").unwrap()),
        times: times.map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect(),
        numbers: numbers.map(|bytes| u32::from_le_bytes(bytes.try_into().unwrap())).collect(),
        particles,
        step,
        gravity: 2.0 * step * description["flights"][2].as_f64().unwrap(),
        places: stored[0].iter().zip(&stored[1]).map(|(x, y)| place(*x, *y)).collect(),
        corners,
    }
}

impl Film {
    fn intervals(&self) -> usize {
        self.corners.len() / self.particles
    }

    /// The place of a particle, as the script of the page has it; without corners, on the line between two frames.
    fn place(&self, particle: usize, time: f64, with_corners: bool) -> [f64; 2] {
        let interval =
            (self.times.partition_point(|start| *start <= time) - 1).min(self.intervals() - 1);
        let length = self.times[interval + 1] - self.times[interval];
        let (index, part) =
            (interval * self.particles + particle, (time - self.times[interval]) / length);
        let mut path = vec![(0.0, self.places[index])];
        path.extend(self.corners[index].iter().filter(|_| with_corners));
        path.push((1.0, self.places[index + self.particles]));
        let before =
            path.iter().rposition(|(start, _)| *start <= part).unwrap().min(path.len() - 2);
        let [(start, from), (end, to)] = [path[before], path[before + 1]];
        let share = if end > start { (part - start) / (end - start) } else { 1.0 };
        let rise = 0.5 * self.gravity * length * length * (part - start) * (end - part);
        let [x, y] = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        [x, y + rise]
    }
}

/// Numbers of random frames, by a linear congruential generator (Knuth, The Art of Computer Programming 2, section 3.3.4).
fn random_frames(last: u64) -> BTreeSet<u64> {
    let (mut state, mut frames) = (12_u64, BTreeSet::new());
    while frames.len() < INSTANTS {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        frames.insert((state >> 33) % last);
    }
    frames
}

/// Compares the replay with the denser run; `sides` of a periodic box, or of one so large that no disc is moved. Returns the film's note.
fn assert_exact(model: &str, sides: [f64; 2], budget: &str) -> String {
    let folder = TempDir::new().unwrap();
    let sparse = record(folder.path(), model, FRAMES, "\"state\", \"events\"");
    analyze(&["--replay-budget", budget, sparse.to_str().unwrap()]);
    let page = std::fs::read_to_string(sparse.join("report.html")).unwrap();
    let film = film(&page);
    let dense = record(folder.path(), model, DENSE_FRAMES, "\"state\"");
    let known = u64::from(film.numbers[film.intervals()]) * DENSE_FRAMES / FRAMES;
    let chosen = random_frames(known);
    let recording = std::fs::read_dir(&dense).unwrap().map(|entry| entry.unwrap().path());
    let recording =
        recording.into_iter().find(|path| path.extension().is_some_and(|it| it == "mcap")).unwrap();
    let frames = Recording::open(&recording).unwrap().frames().unwrap().map(Result::unwrap);
    let (mut instants, mut elsewhere) = (0, 0);
    for frame in frames.filter(|frame| chosen.contains(&frame.clock.frame)) {
        let (state, time) = (frame.state().unwrap(), frame.clock.time);
        let [x, y, vx, vy] = ["x", "y", "vx", "vy"].map(|name| state.index(name).unwrap());
        let speed = state.iter().map(|row| row[vx].hypot(row[vy])).fold(0.0, f64::max);
        let interval = film.times[1] - film.times[0];
        // Discs may be faster between frames than in any one.
        let tolerance = film.step / 2.0 * 2.0_f64.sqrt() + 2.0 * speed * interval / LARGEST;
        let missed = |with_corners: bool| -> f64 {
            let missed = state.iter().enumerate().map(|(particle, row)| {
                let found = film.place(particle, time, with_corners);
                let gaps = [found[0] - row[x], found[1] - row[y]];
                let gaps = [0, 1].map(|axis| {
                    gaps[axis] - sides[axis] * (gaps[axis] / sides[axis]).round_ties_even()
                });
                gaps[0].hypot(gaps[1])
            });
            // NaN is passed on.
            missed.fold(0.0, |most, next| if next <= most { most } else { next })
        };
        assert!(missed(true) <= tolerance, "{} of {tolerance} at {time}: {model}", missed(true));
        instants += 1;
        elsewhere += usize::from(missed(false) > 10.0 * tolerance);
    }
    assert!(instants == INSTANTS && elsewhere > INSTANTS * 9 / 10, "{instants}, {elsewhere}");
    // Control: the denser run has no `/events`.
    analyze(&["--replay-budget", budget, dense.to_str().unwrap()]);
    let without = std::fs::read_to_string(dense.join("report.html")).unwrap();
    for word in ["&quot;flights&quot;", "flightsOf", "discs fly as recorded"] {
        assert!(page.contains(word) && !without.contains(word), "{word}");
    }
    film.note
}

#[test]
fn corners_give_positions_at_any_time() {
    let fluid =
        "packing]\ndiscs = 60\nwidth = 16.0\nheight = 16.0\nradius = 0.6\nduration = 20.0\n";
    let (whole, walls) = (" Between frames, discs fly as recorded (channel \"events\").", [1e9; 2]);
    let mixture =
        format!("{fluid}radius_half_width = 0.2\nboundary = \"periodic\"\nrestitution = 0.95\n");
    let gravity = format!("{fluid}gravity = 0.2\nfloor_temperature = 1.0\n");
    let gas = "gas]\nparticles = 50\nradius_m = 1.0\ndisc_radius_m = 0.05\nduration_s = 0.02\n";
    for (model, sides) in [
        (format!("{fluid}wall_noise_variance_rad2 = 0.01\n"), walls),
        (mixture, [16.0; 2]),
        (gravity.clone(), walls),
        (format!("{gravity}{PEGS}"), walls),
        (format!("{fluid}boundary = \"periodic\"\n{PEGS}"), [16.0; 2]),
        (gas.to_owned(), walls),
        (format!("{gas}mass_kg = 1e-26\nadditional_masses_kg = [3e-26, 1e-27]\n"), walls),
    ] {
        assert!(assert_exact(&model, sides, "3").ends_with(whole));
    }
    // More collisions than a small page has room for, and a temperature that is set in the sixth interval.
    let scheduled = format!("{gas}temperature_schedule = [[0.011, 900.0]]\n");
    for (model, budget, [last, why]) in [
        (fluid, "0.02", ["up to frame ", "too many for a small page."]),
        (&scheduled, "3", ["up to frame 5:", "do not lead to the recorded positions."]),
    ] {
        let note = assert_exact(model, walls, budget);
        assert!(note.contains(&format!("(channel \"events\") {last}")), "{note}");
        assert!(note.ends_with(why), "{note}");
    }
}

//! Guarantee: the replay of `report.html` shows the recorded positions, within 1/500 of the view, at the start, in the middle and at
//! the end. Its size is within the budget, and it states what it leaves out. The same recordings give the same bytes.
//!
//! Setup: the film of the page is decoded as the page's script does it, and compared with the recorded `/state`. In headless
//! Chromium, the script itself draws and plays to the end from a page on disk, without network and without a message on the console.
//! Control: the positions of another frame are found, and a budget of 0 is rejected.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]
#![allow(clippy::disallowed_methods, reason = "positions of a test need no fixed bits")]

use crate::browser::{dumped, examined, with_script};
use crate::synthetic::{Folder, Frames, analyze};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::DemTemperature;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::Clock;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// A manifest of discs in a box of 1 m x 1 m.
fn manifest(discs: u32, frames: u32, rest: &str) -> String {
    format!(
        "name = \"moving\"\n[model.dem]\ndiscs = {discs}\nwidth_m = 1.0\nheight_m = 1.0\nradius_m = 1e-3\nduration_s = 1.0\n\
         [record]\nframes = {frames}\nchannels = [\"state\", \"temperature\"]\n{rest}"
    )
}

/// Position of a disc on its circle.
fn position(disc: u32, time: f64) -> [f64; 2] {
    let (phase, radius) =
        (f64::from(disc) * 2.399_963, 0.05 + 0.4 * (f64::from(disc) / 7.3).fract());
    [0.5 + radius * (phase + time).cos(), 0.5 + radius * (phase + time).sin()]
}

/// Frames of discs on circles, each with the speed of its own radius.
fn circling(discs: u32, frames: u32) -> impl Fn(&RunManifest) -> Frames {
    move |_| {
        let frame = |index: u32| {
            let time = f64::from(index) / f64::from(frames);
            let mut frame = Frame::new();
            for disc in 0..discs {
                let [x, y] = position(disc, time);
                frame.push_state(&[x, y, 0.5 - y, x - 0.5]);
            }
            frame.push(&DemTemperature::default());
            (Clock { count: u64::from(index), time }, frame)
        };
        (0..=frames).map(frame).collect()
    }
}

/// A decoded film: times, numbers of the frames, and the positions of each frame.
struct Film {
    description: Value,
    note: String,
    bytes: usize,
    times: Vec<f64>,
    numbers: Vec<u32>,
    positions: Vec<Vec<Option<[f64; 2]>>>,
    velocities: Vec<Vec<Option<[f64; 2]>>>,
}

/// A series of 16-bit values at `at`, decoded as the script does; moves `at` behind it.
pub(crate) fn series(data: &[u8], at: &mut usize, shape: [usize; 2], order: u64) -> Vec<u16> {
    let length = shape[0] * shape[1];
    let mut values: Vec<u16> = (0..length)
        .map(|index| {
            let zigzag = u16::from_le_bytes([data[*at + index], data[*at + length + index]]);
            (zigzag >> 1) ^ 0_u16.wrapping_sub(zigzag & 1)
        })
        .collect();
    for _ in 0..order {
        for index in shape[1]..length {
            values[index] = values[index].wrapping_add(values[index - shape[1]]);
        }
    }
    *at += 2 * length;
    values
}

pub(crate) fn attribute<'a>(element: &'a str, name: &str) -> Option<&'a str> {
    element.split(&format!(" {name}=\"")).nth(1)?.split('"').next()
}

pub(crate) fn unescaped(text: &str) -> String {
    text.replace("&quot;", "\"").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
}

/// The films of a page; one that cannot be drawn has no frames.
fn films(page: &str) -> Vec<Film> {
    page.split("<script type=\"text/plain\" class=\"film\"").skip(1).map(film).collect()
}

fn film(element: &str) -> Film {
    use base64::Engine as _;
    let note = unescaped(attribute(element, "data-note").unwrap());
    let (tag, rest) = element.split_once('>').unwrap();
    let text = rest.split("</script>").next().unwrap();
    let packed = base64::engine::general_purpose::STANDARD.decode(text).unwrap();
    let Some(description) = attribute(tag, "data-film") else {
        assert!(packed.is_empty());
        return Film {
            description: Value::Null,
            note,
            bytes: 0,
            times: vec![],
            numbers: vec![],
            positions: vec![],
            velocities: vec![],
        };
    };
    let description: Value = serde_json::from_str(&unescaped(description)).unwrap();
    let data = miniz_oxide::inflate::decompress_to_vec(&packed).unwrap();
    let size = |name: &str| description[name].as_u64().unwrap() as usize;
    let (frames, particles) = (size("frames"), size("particles"));
    let times: Vec<f64> = data[..8 * frames]
        .chunks_exact(8)
        .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap()))
        .collect();
    let numbers = data[8 * frames..12 * frames].chunks_exact(4);
    let numbers = numbers.map(|bytes| u32::from_le_bytes(bytes.try_into().unwrap())).collect();
    let growing = description["growing"].as_bool().unwrap();
    let mut at = 12 * frames + 2 * particles * if growing { frames } else { 1 };
    let number = |name: &str| description[name].as_f64().unwrap();
    let shape = [frames, particles];
    let coordinates = [0, 1].map(|axis| {
        let values = series(&data, &mut at, shape, description["orders"][axis].as_u64().unwrap());
        let (origin, step) = (description["origin"][axis].as_f64().unwrap(), number("step"));
        let coordinate = |value: u16| (value != u16::MAX).then(|| origin + f64::from(value) * step);
        values.into_iter().map(coordinate).collect::<Vec<_>>()
    });
    at += frames * particles;
    let wall_frames = if description["movingWalls"].as_bool().unwrap() { frames } else { 1 };
    at += 5 * wall_frames * size("wallPoints");
    let step = number("velocityStep");
    let parts = [0, 1].map(|_| {
        let values = if step > 0.0 { series(&data, &mut at, shape, 1) } else { Vec::new() };
        let part = |value: u16| {
            (value != u16::MAX).then(|| f64::from(value) * step - number("velocityTop"))
        };
        values.into_iter().map(part).collect::<Vec<_>>()
    });
    let has_spins = number("spinTop") > 0.0;
    assert_eq!(at + if has_spins { frames * particles } else { 0 }, data.len());
    let [vxs, vys] = parts;
    let pairs: Vec<_> = vxs.into_iter().zip(vys).map(|(x, y)| Some([x?, y?])).collect();
    let velocities = pairs.chunks(particles.max(1)).map(<[_]>::to_vec).collect();
    let [xs, ys] = coordinates;
    let points: Vec<Option<[f64; 2]>> =
        xs.into_iter().zip(ys).map(|(x, y)| Some([x?, y?])).collect();
    let positions = points.chunks(particles.max(1)).map(<[_]>::to_vec).collect();
    Film { description, note, bytes: text.len(), times, numbers, positions, velocities }
}

fn page(folder: &Folder, arguments: &[&str]) -> String {
    analyze(&[arguments, &[folder.name()]].concat()).exited_with(0);
    folder.page()
}

#[test]
fn film_contains_every_recorded_position() {
    let folder = Folder::write(&manifest(50, 40, ""), circling(50, 40));
    let text = page(&folder, &[]);
    let [film] = &films(&text)[..] else { panic!("one film") };
    assert_eq!(film.note, "All 41 frames are shown.");
    assert_eq!(film.numbers, (0..=40).collect::<Vec<u32>>());
    for (positions, time) in film.positions.iter().zip(&film.times) {
        for (disc, found) in (0..).zip(positions) {
            let ([x, y], [fx, fy]) = (position(disc, *time), found.unwrap());
            assert!((x - fx).hypot(y - fy) < 1e-4, "disc {disc} at {time}");
        }
    }
    let step = film.description["velocityStep"].as_f64().unwrap();
    assert!(step < 1e-4, "few points have fine velocities: {step}");
    for (velocities, time) in film.velocities.iter().zip(&film.times) {
        for (disc, found) in (0..).zip(velocities) {
            let ([x, y], [vx, vy]) = (position(disc, *time), found.unwrap());
            assert!((0.5 - y - vx).hypot(x - 0.5 - vy) < step, "disc {disc} at {time}");
        }
    }
    assert_eq!(film.description["lineStyles"], serde_json::json!([["#8c8c8c", 3.5]]));
    // The fastest discs are on the largest circle, at rad/s times m.
    let top = film.description["speedTop"].as_f64().unwrap();
    assert!((0.4..0.46).contains(&top), "{top}");
    // All positions with their radii, and 8 % of the longer side around them; not the box.
    let at = |time: &f64| (0..50).map(|disc| position(disc, *time)).collect::<Vec<_>>();
    let places = || film.times.iter().flat_map(at);
    let [low, high] = [f64::min, f64::max]
        .map(|of| [0, 1].map(|axis| places().map(|at| at[axis]).reduce(of).unwrap()));
    let margin = 0.08 * (high[0] - low[0]).max(high[1] - low[1]) + 1e-3;
    for (index, expected) in
        [low[0] - margin, low[1] - margin, high[0] + margin, high[1] + margin].iter().enumerate()
    {
        let found = film.description["view"][index].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-3, "{found}, not {expected}");
    }
    assert_eq!(film.description["poster"], 40);

    // The cached replay gives the same bytes, and so does a new analysis.
    assert_eq!(page(&folder, &[]), text);
    assert_eq!(page(&folder, &["--no-cache"]), text);
    // Without a replay, the page has neither data nor a section.
    let without = page(&folder, &["--no-replay"]);
    assert!(films(&without).is_empty() && !without.contains("class=\"deck\""));
    assert_eq!(page(&folder, &[]), text);
}

/// Setup: a circle of radius 1 m around (1e8, -1e8) m, within the 1e9 radii that a manifest may ask for; single precision rounds to 8 m there.
#[test]
fn film_of_a_container_far_from_the_origin_contains_the_positions() {
    let manifest = "name = \"far\"\n[model.gas]\nparticles = 2\nradius_m = 1.0\ncenter_m = [1e8, -1e8]\nduration_s = 1.0\n[record]\nframes = 1\nchannels = [\"state\"]\n";
    let places = [[1e8 + 0.5, -1e8 + 0.25], [1e8 - 0.75, -1e8]];
    let folder = Folder::write(manifest, |_| {
        let mut frame = Frame::new();
        places.iter().for_each(|[x, y]| frame.push_state(&[*x, *y, 1.0, 0.0]));
        vec![(Clock { count: 0, time: 0.0 }, frame)]
    });
    let film = &films(&page(&folder, &[]))[0];
    for (place, found) in places.iter().zip(&film.positions[0]) {
        let [fx, fy] = found.unwrap();
        assert!((place[0] - fx).hypot(place[1] - fy) < 1e-4, "{place:?}: {fx}, {fy}");
    }
}

#[test]
fn frames_are_thinned_to_the_budget_and_the_page_states_it() {
    let folder = Folder::write(&manifest(100, 400, ""), circling(100, 400));
    let whole = &films(&page(&folder, &[]))[0];
    assert!(whole.bytes > 22_000, "{}", whole.bytes);
    for (budget, bytes) in [("0.02", 20_000), ("0.015", 15_000)] {
        let thinned = &films(&page(&folder, &["--replay-budget", budget]))[0];
        assert!(thinned.bytes <= bytes && thinned.bytes > bytes / 4, "{}", thinned.bytes);
        let frames = thinned.numbers.len();
        let every = thinned.numbers[1] - thinned.numbers[0];
        assert!(
            thinned.note.starts_with(&format!("{frames} of 401 frames are shown (every {every}"))
        );
        assert_eq!((thinned.numbers[0], thinned.numbers.last()), (0, Some(&400)));
        assert_eq!(thinned.positions.len(), frames);
    }
    // Control: a budget that is no size.
    analyze(&["--replay-budget", "0", folder.name()]).exited_with(2);
}

#[test]
fn discs_are_thinned_before_frames_become_few() {
    let folder = Folder::write(&manifest(3000, 3, ""), circling(3000, 3));
    let film = &films(&page(&folder, &["--replay-budget", "0.01"]))[0];
    let every = film.description["every"].as_u64().unwrap();
    assert!(every > 1 && film.note.contains("Of up to 3000 particles, every"), "{}", film.note);
    for (index, found) in film.positions[0].iter().enumerate() {
        let [x, y] = position(u32::try_from(index as u64 * every).unwrap(), 0.0);
        let [fx, fy] = found.unwrap();
        assert!((x - fx).hypot(y - fy) < 1e-4, "disc {index}");
    }
}

#[test]
fn unusual_recordings_are_shown_as_far_as_possible() {
    // One frame.
    let one =
        Folder::write(&manifest(3, 1, ""), |run: &RunManifest| circling(3, 1)(run)[..1].to_vec());
    assert_eq!(films(&page(&one, &[]))[0].note, "The recording has one frame.");

    // Numbers that are not finite or far away.
    let bad = Folder::write(&manifest(3, 2, ""), |_: &RunManifest| {
        let states = [[0.5, 0.5], [f64::NAN, 0.5], [1e300, 0.5]];
        let mut frame = Frame::new();
        states.iter().for_each(|[x, y]| frame.push_state(&[*x, *y, f64::INFINITY, 0.0]));
        vec![(Clock { count: 0, time: 0.0 }, frame)]
    });
    let film = &films(&page(&bad, &[]))[0];
    let not_drawn = "One particle at no finite place is not drawn. One particle far outside of the view is not drawn.";
    assert!(film.note.ends_with(not_drawn), "{}", film.note);
    assert!(film.positions[0][0].is_some() && film.positions[0][1..] == [None, None]);

    // A torn file: its intact frames.
    let torn = Folder::write(&manifest(300, 60, ""), circling(300, 60));
    let file = torn.file(0);
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let output = analyze(&[torn.name()]);
    assert_ne!(output.code, 0);
    let text = fs::read_to_string(torn.path().join("report.html"));
    // The first chunk may be the torn one; then there is no frame and no page.
    if let Ok(text) = text {
        assert!(films(&text)[0].numbers.len() < 61);
    }

    // Without positions, the page gives the reason, and has no controls.
    let energies = manifest(3, 1, "").replace("\"state\", ", "");
    let blind = Folder::write(&energies, circling(3, 1));
    let text = page(&blind, &[]);
    let note = "<p class=\"facts\">No replay: positions were not recorded (channel `state`).</p>";
    assert!(text.contains(note), "no reason is given");
    assert!(!text.contains("class=\"controls\"") && films(&text).is_empty(), "nothing to play");
}

#[test]
fn runs_of_a_long_sweep_share_the_budget_and_the_others_are_listed() {
    let sweep = "[sweep]\n\"model.dem.restitution\" = { from = 0.1, to = 0.9, count = 20, spacing = \"linear\" }\n";
    let folder = Folder::write(&manifest(100, 100, sweep), circling(100, 100));
    let text = page(&folder, &["--replay-budget", "0.1"]);
    let films = films(&text);
    assert_eq!(films.len(), 7);
    let bytes: usize = films.iter().map(|film| film.bytes).sum();
    assert!(bytes <= 100_000, "{bytes}");
    assert!(text.contains("13 more runs are not replayed"));
    assert_eq!(page(&folder, &["--replay-budget", "0.1", "--no-cache"]), text);
}

/// Appended to the page: scrubs each of the first films to its start, middle and end, writes the drawn positions, and plays it to its end
/// in 0.2 s.
const PROBE: &str = r#"<script>
held((async () => {
  const found = [];
  try {
    await window.replay?.ready;
    document.querySelector(".rotating:checked")?.click(); // The recorded frame of reference.
    const count = document.querySelectorAll("script.film").length;
    for (let run = 0; run < Math.min(count, 3); run++) {
      await replay.select(run);
      // Without positions, the page states it and has nothing to play.
      if (document.querySelector(".stage").hidden && document.querySelector(".note").textContent) continue;
      const last = replay.frames - 1;
      for (const frame of [0, Math.floor(last / 2), last]) {
        replay.show(frame);
        const positions = replay.positions();
        const [x0, y0, x1, y1] = replay.view;
        const inside = positions.filter(([, x, y]) => x > x0 && x < x1 && y > y0 && y < y1);
        const canvas = document.querySelector("canvas"), copy = document.createElement("canvas");
        [copy.width, copy.height] = [canvas.width, canvas.height];
        const context = copy.getContext("2d", { willReadFrequently: true });
        context.drawImage(canvas, 0, 0);
        const isBlank = ([, x, y]) => {
          const [across, up] = replay.pixel(x, y);
          return context.getImageData(Math.floor(across), Math.floor(up), 1, 1).data.join() === "16,20,24,255";
        };
        const blank = inside.filter(isBlank).length;
        found.push({ run, number: replay.numbers[frame], view: replay.view, positions, blank });
      }
      const speed = document.querySelector(".speed"), { fps } = JSON.parse(document.querySelectorAll("script.film")[run].dataset.film);
      speed.options[0].value = last / fps / 0.2;
      speed.selectedIndex = 0;
      replay.show(0);
      if (last) document.querySelector(".play").click();
      for (let drawn = 0; Number(document.querySelector(".scrub").value) < last; drawn++) {
        if (drawn > 200) throw new Error(`run ${run} does not play to its end`);
        await new Promise(requestAnimationFrame);
      }
    }
  } catch (error) { console.error(String(error)); }
  const list = document.createElement("pre");
  list.id = "found";
  list.textContent = JSON.stringify(found);
  document.body.append(list);
})());
</script>"#;

/// Largest median size of the reports, the default of `--replay-budget`.
const MAX_MEDIAN_BYTES: u64 = 3_000_000;

/// The positions of all particles in a frame of a recording, by number.
fn recorded(path: &Path, number: u64) -> BTreeMap<u64, [f64; 2]> {
    let frames = Recording::open(path).unwrap().frames().unwrap().map(Result::unwrap);
    let frame = frames.into_iter().find(|frame| frame.clock.frame == number).unwrap();
    let state = frame.state().unwrap();
    let index = |name: &str| state.index(name);
    (0..state.rows())
        .map(|row| {
            let values = state.row(row);
            let number = index("id").map_or(row as u64, |id| values[id] as u64);
            (number, [values[index("x").unwrap()], values[index("y").unwrap()]])
        })
        .collect()
}

/// Compares the drawn positions of a report with its recordings, `shift` frames away; returns the number of frames compared.
fn compare(report: &Path, shift: u64) -> Result<usize, String> {
    let text = fs::read_to_string(report).unwrap();
    let (dom, console) = examined(report, PROBE, false);
    if !console.is_empty() {
        return Err(console);
    }
    let found = dom.split("<pre id=\"found\">").nth(1).ok_or("the script did not end")?;
    let found: Vec<Value> =
        serde_json::from_str(&unescaped(found.split("</pre>").next().unwrap())).unwrap();
    let films = text.split("class=\"film\"").skip(1);
    let files: Vec<&str> = films.map(|film| attribute(film, "data-file").unwrap()).collect();
    for frame in &found {
        let number = frame["number"].as_u64().unwrap();
        let file = files[frame["run"].as_u64().unwrap() as usize];
        let state = recorded(&report.with_file_name(file), number.saturating_sub(shift));
        let corner = |index: usize| frame["view"][index].as_f64().unwrap();
        let tolerance = (corner(2) - corner(0)).max(corner(3) - corner(1)) / 500.0;
        let positions = frame["positions"].as_array().unwrap();
        if positions.is_empty() || frame["blank"] != 0 {
            return Err(format!(
                "{file}, frame {number}: {} of {} discs are not painted",
                frame["blank"],
                positions.len()
            ));
        }
        for drawn in positions {
            let number_of_disc = drawn[0].as_u64().unwrap();
            let [x, y] = state.get(&number_of_disc).ok_or("a disc that was not recorded")?;
            let distance = (x - drawn[1].as_f64().unwrap()).hypot(y - drawn[2].as_f64().unwrap());
            if distance.is_nan() || distance > tolerance {
                return Err(format!(
                    "{file}, frame {number}, disc {number_of_disc}: {distance} away"
                ));
            }
        }
    }
    Ok(found.len())
}

#[test]
#[ignore = "needs chromium"]
fn browser_draws_the_recorded_positions() {
    let sweep = "[sweep]\n\"model.dem.restitution\" = [0.5, 0.8]\n";
    let folder = Folder::write(&manifest(80, 60, sweep), circling(80, 60));
    page(&folder, &[]);
    let report = folder.path().join("report.html");
    assert_eq!(compare(&report, 0), Ok(6));
    // Control: the positions of the frame before.
    assert!(compare(&report, 1).unwrap_err().contains("away"));
}

#[test]
#[ignore = "needs chromium"]
fn browser_draws_ten_thousand_discs() {
    let folder = Folder::write(&manifest(10_000, 30, ""), circling(10_000, 30));
    page(&folder, &[]);
    assert_eq!(compare(&folder.path().join("report.html"), 0), Ok(3));
}

/// Appended to a page in a frame: reports when the replay is decoded, and, once the frame is shown, how many particles are not painted.
const FRAMED: &str = r#"<script>
(async () => {
  const tell = (text) => parent.postMessage(text, "*");
  try {
    await replay.ready;
    replay.show(1);
    dispatchEvent(new Event("resize"));
    const canvas = document.querySelector("canvas");
    tell(`hidden ${canvas.clientWidth}`);
    while (!canvas.clientWidth) await new Promise((done) => setTimeout(done, 20));
    await nextFrames(5);
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height), isBlank = ([, x, y]) => {
      const [across, down] = replay.pixel(x, y).map(Math.floor), at = 4 * (down * canvas.width + across);
      return data.slice(at, at + 3).join() === "16,20,24";
    };
    tell(`shown ${replay.positions().length} ${replay.positions().filter(isBlank).length}`);
  } catch (error) { tell(`failed: ${error}`); }
})();
</script>"#;

/// Shows its frame when the replay in it is decoded; the messages of the frame are the title.
const HIDDEN_FRAME: &str = r#"<!doctype html><title></title><body><iframe hidden src="framed.html" width="600" height="700"></iframe></body>"#;
const SHOW_FRAME: &str = r#"<script>
held(new Promise((done) => addEventListener("message", ({ data }) => {
  document.title += `${data};`;
  document.querySelector("iframe").hidden = false;
  if (!data.startsWith("hidden")) done();
})));
</script>"#;

#[test]
#[ignore = "needs chromium"]
fn page_without_a_width_is_drawn_when_it_is_shown() {
    let folder = Folder::write(&manifest(2000, 3, ""), circling(2000, 3));
    let text = page(&folder, &[]);
    fs::write(folder.path().join("framed.html"), with_script(&text, FRAMED)).unwrap();
    let outer = folder.path().join("outer.html");
    fs::write(&outer, with_script(HIDDEN_FRAME, SHOW_FRAME)).unwrap();
    let (dom, console) = dumped(&outer, 1280, false);
    assert_eq!(console, "");
    assert!(dom.contains("<title>hidden 0;shown 2000 0;</title>"), "{dom}");
}

#[test]
#[ignore = "needs chromium; REPORTS contains the paths of report.html files, separated by colons"]
fn given_replays_show_the_recorded_positions() {
    let reports = std::env::var("REPORTS").expect("REPORTS must name the reports");
    let mut sizes = Vec::new();
    for page in reports.split(':') {
        let frames = compare(Path::new(page), 0).unwrap_or_else(|fault| panic!("{page}: {fault}"));
        let is_drawn = fs::read_to_string(page).unwrap().contains(" data-film=");
        assert_eq!(frames > 0, is_drawn, "{page}: {frames} frames were drawn");
        sizes.push(fs::metadata(page).unwrap().len());
        println!("{page}: {frames} frames, {} bytes", sizes.last().unwrap());
    }
    sizes.sort_unstable();
    let median = sizes[sizes.len() / 2];
    println!("{} reports, median {median} bytes", sizes.len());
    assert!(median <= MAX_MEDIAN_BYTES);
}

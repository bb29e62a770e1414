//! What recording costs a run: the program in turn with and without frames on the way, with all channels and with the state only,
//! with and without checkpoints, and with and without viewers.
//!
//! The bars: a run of 1e5 discs with `--threads 1` that records every 100th step takes at most 5 % longer than one that records
//! its start and end only, with `--threads 2` at most 15 %; a dense recording with all channels takes at most 1.15 times the time of
//! its state; checkpoints take at most 2 % of a run, also with 1e6 discs; 16 viewers that subscribe to all channels and do not read
//! take at most 2 % of a run that is served without viewers.
//!
//! Measured on two quiet cores of an AMD EPYC of the fourth generation (AVX-512), 7 pairs per series, median and range:
//!
//! | | one series before | now |
//! |---|---|---|
//! | every 100th step, `--threads 1` | 1.17 (1.13 to 1.24) | 1.19 (1.13 to 1.43), 1.14 (1.10 to 1.17), 1.13 (1.08 to 1.31) |
//! | the same, `--threads 2` | 1.65 (1.26 to 2.12) | 1.60 (1.23 to 1.79), 1.65 (1.60 to 1.65), 1.79 (1.57 to 1.89) |
//! | dense, all channels | 1.84 (1.74 to 2.43) | 1.65 (1.57 to 1.67), 1.66 (1.57 to 1.72), 1.63 (1.51 to 1.68), 1.61 (1.59 to 1.73) |
//!
//! Now, the model's thread draws the discs of frames that would have to wait. The series were not made in turn; only the dense recording
//! differs beyond noise. In turn, a dense recording of 801 frames takes 0.93 and 0.95 of the time before (medians of five runs each).
//!
//! Schema version 4 (chunks of their own for drawings, states and scalars, compressed on two threads), in turn with the program before it,
//! on two busy cores with AVX-512, three runs each, `-- dense`:
//!
//! | 10^4 particles | wall time | processor time, ms per frame | file, MB |
//! |---|---|---|---|
//! | dem, all channels / state / keyframes | 0.70 / 0.65 / 0.43 | 4.2 to 4.1 / 2.2 to 2.0 / 3.3 to 1.5 | 89.3 to 51.7 / 70.6 to 32.9 / 2.9 |
//! | gas | 0.81 / 1.07 / 0.84 | 5.5 to 5.8 / 3.2 to 3.3 / 4.4 to 2.7 | 122.7 to 82.6 / 67.8 to 50.1 / 6.4 |
//! | packing | 0.67 / 0.98 / 0.50 | 5.3 to 5.1 / 2.7 to 2.4 / 3.5 to 1.6 | 122.9 to 85.5 / 94.2 to 56.9 / 3.7 |
//!
//! The optimized program of version 4 before `draw_every`, 5 runs of each selection in turn, under a load of 25 to 45 on two cores with AVX-512.
//! Wall times are then those of the load; processor time in ms per frame, median and range, is not (`-- dense`, which prints all of it):
//!
//! | 10^4 particles | state only | all channels, every frame drawn | keyframes | all over state | file, MB |
//! |---|---|---|---|---|---|
//! | dem | 2.02 (1.85 to 2.09) | 3.49 (3.42 to 3.54) | 1.32 (1.27 to 1.35) | 1.72 | 32.9 / 51.7 / 2.9 |
//! | dem with friction | 5.08 (4.98 to 5.25) | 7.04 (6.81 to 7.18) | 2.33 (2.23 to 2.36) | 1.37 | 163.8 / 183.7 / 4.6 |
//! | gas | 1.66 (1.63 to 1.76) | 3.69 (3.52 to 3.69) | 1.03 (1.03 to 1.06) | 2.18 | 50.1 / 82.6 / 6.4 |
//! | packing | 2.09 (2.06 to 2.23) | 4.25 (4.19 to 4.62) | 1.26 (1.26 to 1.30) | 2.06 | 56.9 / 87.5 / 3.7 |
//!
//! Each of these runs draws more than 2,010,000 discs, so that by default one frame in two is drawn. Programs of the tests, otherwise as above,
//! every frame drawn and the default, processor time over state only and MB: dem 2.03 to 1.50, 51.7 to 42.4; with friction 1.33 to 1.17, 183.7
//! to 173.8; gas 1.69 to 1.36, 82.6 to 64.4; packing 2.08 to 1.55, 87.5 to 71.2. Peak memory of one run before version 4, with it, and with it and
//! compressed chunks of their own size, MB (runs of version 4 differ by up to 8): dem 38, 79, 75; gas 36, 70, 57; packing 36, 82, 63. With version
//! 5, and now that one frame in 10 is drawn, programs of the tests, two runs each: dem 70 and 62, 63 and 60; gas 73 and 71, 69 and 56; packing 73 and 74, 70 and 73.
//!
//! Schema version 5 (`/particles` has the constants, and a NaN is sought in many numbers at once), in turn with the program before it, programs of
//! the tests under a load of 20, processor time in ms per frame, medians of three, and MB of all channels: dem state only 2.17 to 2.02, all 3.10 to 3.04,
//! keyframes 1.60 to 1.46, 42.4 to 38.2 MB; with friction 7.36 to 6.00, 8.63 to 7.45, 4.36 to 4.32, 173.8 to 159.4 MB;
//! packing 2.51 to 2.40, 3.66 to 3.72 (3.57 to 3.98), 1.70 to 1.72, 71.2 to 69.8 MB. A gas has no constants.
//! The time saved is less than that of the compression alone (`chunk_compression`), since the rows are moved together and compared (5 % of a dem
//! run, `perf record`).
//!
//! Drawings within 15 % of a run's time (`RecordConfig::distance_of_drawings`): these runs draw one frame in 10 instead of 2. Programs of the tests
//! in turn with those before, `--threads 1`, a load of 13, processor time of all channels over the state only, medians of three with ranges:
//! dem 1.48 to 1.14 (1.09 to 1.15), with friction 1.20 to 1.08 (1.06 to 1.08), gas 1.37 to 1.10 (1.09 to 1.14), packing 1.52 to 1.13 (1.07 to 1.13);
//! every frame drawn 2.05, 1.44, 1.71 and 2.07. Files 38.2 to 30.8, 159.4 to 151.5, 64.4 to 53.1 and 69.8 to 58.4 MB.
//! zstd takes 36 % of a dem run with all channels, copies 7 and checksums 3; the search for NaNs took 7 before and takes 4 (`perf record`).
//!
//! The optimized program on the same machine when it was idle (28 Nov 2026, `-- dense`): all channels over the state only, wall and processor time, dem
//! 1.14 and 1.14, with friction 0.80 (0.78 to 1.02) and 0.93, gas 0.99 and 1.13, packing 1.05 and 1.11; ms per frame 1.06, 2.60, 1.05 and 1.22; files 30.8, 151.5, 53.1 and
//! 58.4 MB; keyframes over the state only 0.68, 0.37, 0.60 and 0.58. `-- overhead`: 1.13 (1.07 to 1.45) with one thread, 1.63 (1.54 to 1.69) with two.
//!
//! Measured and not built:
//! - Rows in the order of memory: they are as large as rows by id, and take as long to compress (`chunk_compression`). The model's thread
//!   would save less than the 2.5 ms per 10^5 discs below; each reader that follows a disc from frame to frame would sort instead.
//! - BLAKE3 for the hashes of unstored frames, 4.1 times as fast as SHA-256 with the instructions of the processor: 0.55 ms per 800 kB
//!   (1.5 GB/s; Python's `hashlib` takes as long). It would save some 0.4 of the 1.3 ms per frame of dense DEM keyframes. Run keys, lock files,
//!   `start_from` and S3 use SHA-256, which Python and browsers compute without another package, and one hash is enough for a project.
//!
//! The first two bars are not reached (the reasons are from before version 4):
//! - With `--threads 1`, a frame takes 4 to 5 ms of a run with 26 ms per frame. The rows, which are written in the order of the ids, take 2.5
//!   of them (`perf record`), and 2.2 in pages of 2 MB (`GLIBC_TUNABLES=glibc.malloc.hugetlb=1`): more than the 1.3 of the bar. If the
//!   recorder's thread writes them from copies of the columns, the run takes 0.98 (0.91 to 1.07) of the time, and 1.10 (1.08 to 1.16)
//!   with `--threads 2`: rejected.
//! - With `--threads 2`, 100 steps take 16 ms of wall time and 26 to 30 of processor time. If both cores were always busy, the bar
//!   would leave 7 to 11 ms of processor time per frame. Compressing its 8 MB takes 10.
//!
//! Two checkpoints of 1e6 discs in 51.4 s: 52.5 s, +2.1 % (one pair; a set takes twelve minutes).
//!
//! Earlier steps, on busy machines: rows in the order of the memory instead of a gather by id from each column 0.69 to 0.94 of the time of
//! a run with 21 frames; cylinders without a value per disc 0.56 to 0.88 of the time of a dense recording; discs encoded in place, and
//! rounded without a call, 0.90 of its processor time; rows requested before they are written 0.70 of their time.
//!
//! 16 silent viewers of 1e5 discs, a frame per 100 of 8000 steps: payloads are sent from the memory that all viewers share, without
//! a copy for each. Wall time 1.00 of that without viewers (21 pairs, 0.81 to 1.31); before, 1.10 (1.00 to 1.33). Processor time of the
//! program beyond that without viewers (5 s), 4 pairs on a busy machine: -0.4 to +0.1 s; before, 0.3 to 0.7 s. Memory: 121 MiB
//! instead of 250.
//!
//! Wall times are those of the runs' `.host.json`, so that the plan, which both have, does not count. Pairs are run in turn; what is
//! quoted is the median of the ratios. `cargo bench --bench recording_overhead -- overhead`, `-- dense`, `-- checkpoints` or
//! `-- viewers` runs one part. Each line ends with the range of the ratios; those of `-- dense` with the ratio of processor times.

#![allow(clippy::unwrap_used, reason = "a benchmark may end on an error")]

use serde_json::json;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::http::HeaderValue;
use tungstenite::{Message, WebSocket};

const PAIRS: usize = 7;
const DENSE_TRIALS: usize = 5;
/// Each run is short and the ratio close to one, so that seven pairs leave an uncertainty larger than the limit.
const VIEWER_PAIRS: usize = 21;

/// A dilute cloud that falls: some contacts, hardly any order, as in the middle of a settling run.
fn manifest(discs: u32, side_m: f64, steps: u32, every_steps: u32) -> String {
    // pi sqrt(m/k) / 20, the default step, of 1e-3 kg and 4e5 N/m.
    let duration_s = f64::from(steps) * 7.854e-6;
    format!(
        "seed = 5\n[model.dem]\ndiscs = {discs}\nwidth_m = {side_m}\nheight_m = {side_m}\nduration_s = {duration_s}\n\
         stiffness_n_per_m = 4e5\n[record]\nevery_steps = {every_steps}\n"
    )
}

/// Runs of 10^4 particles that record every step, or 300 times, with their numbers of frames: a falling cloud, a dense bed with friction and
/// random velocities, and both other models of many particles.
fn dense_manifests() -> [(&'static str, String, u32); 4] {
    let gas =
        "seed = 5\n[model.gas]\nparticles = 10000\nduration_s = 0.015\n[record]\nframes = 300\n";
    let packing = "seed = 5\n[model.packing]\ndiscs = 10000\nwidth = 280.0\nheight = 280.0\nevents_per_disc = 30\n\
                   [record]\nframes = 300\n";
    let bed = "seed = 5\n[model.dem]\ndiscs = 10000\nwidth_m = 0.101\nheight_m = 0.101\nplacement = \"lattice\"\nvelocity_std_m_per_s = 0.5\nfriction = 0.5\nduration_s = 0.0023562\n\
               stiffness_n_per_m = 4e5\n[record]\nevery_steps = 1\n";
    [
        ("dem", manifest(10_000, 0.15, 400, 1), 401),
        ("dem with friction", bed.to_owned(), 301),
        ("gas", gas.to_owned(), 301),
        ("packing", packing.to_owned(), 301),
    ]
}

/// Wall time of a run, s.
fn run(folder: &Path, name: &str, manifest: &str, arguments: &[&str]) -> f64 {
    let ended = command(folder, name, manifest, arguments).arg("--quiet").status().unwrap();
    assert!(ended.success());
    wall_time(&folder.join(name), name)
}

/// The program with a manifest, which it finds in the folder.
fn command(folder: &Path, name: &str, manifest: &str, arguments: &[&str]) -> Command {
    let path = folder.join(format!("{name}.toml"));
    fs::write(&path, manifest).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_run-experiment"));
    command.args(["--jobs", "1", "--output"]).arg(folder.join(name)).args(arguments).arg(path);
    command
}

/// Wall time of a run that is served to a number of viewers, s. The viewers subscribe to all channels and do not read.
fn run_with_viewers(folder: &Path, name: &str, manifest: &str, viewers: usize) -> f64 {
    let mut command = command(folder, name, manifest, &["--live=0"]);
    let mut program = command.stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(program.stdout.take().unwrap()).lines().map(Result::unwrap);
    let invitation = lines.find(|line| line.contains("ws://")).unwrap();
    let url = invitation.split_whitespace().find(|word| word.starts_with("ws://")).unwrap();
    let silent: Vec<_> = (0..viewers).map(|_| silent_viewer(url)).collect();
    lines.for_each(drop);
    assert!(program.wait().unwrap().success());
    drop(silent);
    wall_time(&folder.join(name), name)
}

fn silent_viewer(url: &str) -> WebSocket<TcpStream> {
    let mut request = url.into_client_request().unwrap();
    let protocol = HeaderValue::from_static("foxglove.sdk.v1");
    request.headers_mut().insert("sec-websocket-protocol", protocol);
    let stream = TcpStream::connect(url.trim_start_matches("ws://")).unwrap();
    let (mut socket, _) = tungstenite::client(request, stream).unwrap();
    // The ids of the first run's channels begin with 1; those without a channel are ignored.
    let wanted: Vec<_> = (1..=40).map(|id| json!({ "id": id, "channelId": id })).collect();
    let subscribe = json!({ "op": "subscribe", "subscriptions": wanted });
    socket.send(Message::text(subscribe.to_string())).unwrap();
    socket
}

/// The wall time that a run reports, s. Removes its output.
fn wall_time(output: &Path, name: &str) -> f64 {
    let host = fs::read_dir(output.join(name)).unwrap().map(|entry| entry.unwrap().path());
    let host =
        host.into_iter().find(|path| path.to_string_lossy().ends_with(".host.json")).unwrap();
    let host: serde_json::Value = serde_json::from_slice(&fs::read(host).unwrap()).unwrap();
    fs::remove_dir_all(output).unwrap();
    host["wall_time_s"].as_f64().unwrap()
}

/// What a run takes: wall and processor time, s, and the size of its recording, bytes.
fn cost_of(folder: &Path, name: &str, manifest: &str) -> [f64; 3] {
    let before = processor_time_of_children();
    let mut command = command(folder, name, manifest, &["--threads", "1", "--quiet"]);
    assert!(command.status().unwrap().success());
    let processor = processor_time_of_children() - before;
    let output = folder.join(name);
    let files = fs::read_dir(output.join(name)).unwrap().map(|entry| entry.unwrap());
    let bytes = files.map(|file| file.metadata().unwrap().len()).max().unwrap();
    [wall_time(&output, name), processor, bytes as f64]
}

/// Processor time of the programs that have ended, s, which Linux counts in hundredths. Other work on the machine changes it less than the
/// wall time.
fn processor_time_of_children() -> f64 {
    let text = fs::read_to_string("/proc/self/stat").unwrap();
    let (_, fields) = text.rsplit_once(')').unwrap();
    let ticks =
        fields.split_whitespace().skip(13).take(2).map(|field| field.parse::<f64>().unwrap());
    ticks.sum::<f64>() / 100.0
}

/// Runs a dense recording in turn with other selections; prints their costs, and the ratios of the processor times to that of the state only.
fn print_dense(folder: &Path, (model, text, frames): &(&str, String, u32)) {
    let selections = [
        ("state only", "channels = [\"state\"]\n"),
        ("all, every frame drawn", "draw_every = 1\n"),
        ("all", ""),
        ("keyframes", "keep = \"keyframes\"\n"),
    ];
    let cost = |more: &str| cost_of(folder, "dense", &(text.clone() + more));
    let trials: Vec<_> =
        (0..DENSE_TRIALS).map(|_| selections.map(|(_, more)| cost(more))).collect();
    for (index, (selection, _)) in selections.iter().enumerate() {
        let of = |value: usize, scale: f64| {
            let values: Vec<f64> = trials.iter().map(|trial| scale * trial[index][value]).collect();
            let (min, max) = range(&values);
            format!("{:.2} ({min:.2} to {max:.2})", median(values))
        };
        let per_frame = 1e3 / f64::from(*frames);
        let megabytes = trials[0][index][2] / 1e6;
        let (wall, processor) = (of(0, per_frame), of(1, per_frame));
        let ratios = trials.iter().map(|trial| trial[index][1] / trial[0][1]).collect();
        let what = format!("{model}: {selection}");
        println!("{what:<36}{wall:>22}{processor:>22}{megabytes:>10.1}{:>8.2}", median(ratios));
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Runs both in turn; prints medians, in s unless `what` states another unit, and the median of the ratios, with their range.
fn compare(what: &str, count: usize, with: &dyn Fn() -> f64, without: &dyn Fn() -> f64) {
    let pairs: Vec<[f64; 2]> = (0..count).map(|_| [with(), without()]).collect();
    let ratios: Vec<f64> = pairs.iter().map(|[with, without]| with / without).collect();
    let [with, without] = [0, 1].map(|side| median(pairs.iter().map(|pair| pair[side]).collect()));
    let (min, max) = range(&ratios);
    let ratio = median(ratios);
    println!("{what:<56}{with:>10.3} {without:>10.3} {ratio:>8.2} ({min:.2} to {max:.2})");
}

fn range(values: &[f64]) -> (f64, f64) {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    values.iter().fold(ends, |(min, max), &value| {
        (if value < min { value } else { min }, if value > max { value } else { max })
    })
}

fn main() {
    let wanted: Vec<String> =
        std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let wants = |half: &str| wanted.is_empty() || wanted.iter().any(|word| word == half);
    let folder = tempfile::tempdir().unwrap();
    println!("{:<56}{:>10} {:>10} {:>8}", "", "with", "without", "ratio");
    if wants("overhead") {
        for threads in ["1", "2"] {
            let time = |every| {
                run(
                    folder.path(),
                    "discs",
                    &manifest(100_000, 0.45, 4000, every),
                    &["--threads", threads],
                )
            };
            compare(
                &format!("every 100th step, 1e5 discs, --threads {threads}"),
                PAIRS,
                &|| time(100),
                &|| time(4000),
            );
        }
    }
    if wants("dense") {
        println!("{:<36}{:>22}{:>22}{:>10}", "ms per frame", "wall", "processor", "MB");
        dense_manifests().iter().for_each(|dense| print_dense(folder.path(), dense));
    }
    if wants("checkpoints") {
        // Long enough for two: the first one waits for 23 s, 50 times what its 93 MB are expected to cost.
        let time = |seconds| {
            let text = manifest(1_000_000, 1.5, 9000, 9000);
            run(folder.path(), "discs", &text, &["--checkpoint-every", seconds])
        };
        compare("checkpoints of 1e6 discs", PAIRS, &|| time("5"), &|| time("1000000"));
    }
    if wants("viewers") {
        let text = manifest(100_000, 0.45, 8000, 100);
        let time = |viewers| run_with_viewers(folder.path(), "discs", &text, viewers);
        compare("16 silent viewers, 1e5 discs", VIEWER_PAIRS, &|| time(16), &|| time(0));
    }
}

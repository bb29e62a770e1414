//! What whole runs cost beside their physics: tiny runs by the thousand, two jobs, memory with the recorder, and plans of large runs.
//!
//! `cargo bench --bench whole_runs -- tiny`, `-- jobs`, `-- memory` or `-- plan` runs one part.
//! - `tiny`: a thousand runs of each model with two jobs, from the start of the program to its end, and the ratio to a program that writes
//!   and syncs as many files of their mean size;
//! - `jobs`: all shipped experiments with one job over two, each time into an empty folder;
//! - `memory`: peak memory of a run of 10^6 particles with its recorder, over the number of particles; and that of a dense recording
//!   with all channels beyond the same run that records its start and end;
//! - `plan`: a plan of a run of 10^6 particles that is not executed.
//!
//! Ratios are the median of pairs in turn, with the smallest and the largest. Memory is the peak that the runs' `.host.json` report.
//! Two quiet cores of an AMD EPYC of the fourth generation (AVX-512), 5 pairs, medians: 1000 tiny runs of a gas 0.96 s, packing 0.63, DEM 0.94.
//! A gas with the 200 frames of the defaults takes 2.6 s, which exceeds the bar. Writing and syncing as many files takes 0.27 to 0.34 s;
//! while it took 0.5 s, the same runs took 1.36, 1.08, 1.38 and 2.6 s.
//! Three runs in turn with `/usr/bin/time run-experiment --jobs 2 --quiet`, medians before and after the following changes: gas with
//! 200 frames 3.7 and 2.8 s, packing 0.72 and 0.62, DEM 1.06 and 0.88.
//! - Small frames are handed to the recorder's thread together, and a run with few bytes has no such thread: 220 to 50 waits of threads
//!   per run of a gas with 200 frames.
//! - Host and processors are asked once, and small writes are joined (188 to 5 `write` calls per run).
//! - Runs are executed on the thread that takes them, their reports do not wake the thread that waits for them, and frames update no
//!   hidden progress bar (27 Nov 2026; `perf stat -e context-switches` of a gas with 20 frames, 3 pairs in turn on a busy machine: 10,200 to
//!   7,700 switches of threads for a thousand runs).
//! - While the file of a run waits for the disk, the next run is executed, and no thread is started for a recording of less than 10 ms.
//!   In turn with the program before, two cores of an Intel Xeon whose disk and processors other programs used (load 13), 3 pairs,
//!   medians: gas 5.3 and 1.23 s, with 200 frames 9.5 and 2.59, DEM 5.1 and 1.13. With one waiting file per job 1.7 (gas) and 4.7 s
//!   (200 frames), with two 1.4 and 4.2, with three 1.1 and 4.2, and without threads 2.6.
//!   The same machine when it was idle, before and after: gas 1.15 and 0.86 s, with 200 frames 3.26 and 2.15, packing 0.76 and 0.51, DEM 1.19
//!   and 0.83; `jobs`: 1.53 (1.49 to 1.55) and 1.59 (1.58 to 1.65).
//!
//! Then the heap was made to keep free memory at its end, the messages of a frame to share one piece of memory, and room to be reserved
//! where its size is known. The same manifests in turn before and after, 5 to 7 pairs: gas with 200 frames 0.65 (0.57 to 0.75), with
//! 20 frames 0.87 (0.69 to 0.91), packing 0.89 (0.81 to 0.95), DEM 0.96 (0.69 to 1.20).
//!
//! Where the processor time of a gas with 200 frames goes (`perf record`, optimized, a thousand runs): zstd 25 %, memory of many small messages 15, copies 6, the
//! Maxwell curve of `/speeds` 4, the rest spread over 40 functions with at most 3 each. 395 of the 755 kB of a run are `/speeds`.
//! Again by group, 300 runs in memory (`TMPDIR=/dev/shm`, `perf record`, two jobs, under load): zstd 27 %, recording 19, the kernel 14, allocations 12, physics with
//! the Maxwell curve 11, copies 8, checksums of chunks 0.5, SHA-256 below 0.1. All writes of files are 3 %; `strace -c -f` counts 7 writes, 2 `fsync`, 6 `openat` and
//! 12 waits of threads per run. A run takes 2.3 ms of processor time, so that two idle cores need 1.15 s for a thousand: no file, hash or summary that is left out
//! reaches the bar of 0.9, only smaller frames would.
//!
//! Rejected:
//! - One heap for each thread instead of one for all takes 0.8 of the time, but a DEM run of 10^6 discs then has a peak of 372 MB
//!   instead of 329, with friction 435 instead of 361. If only small runs have several heaps, the peaks are 352 and 403 MB, because of
//!   what the plan has allocated.
//! - zstd level 1 instead of 2 for chunks of at most 512 KiB: 0.99 of the processor time of a gas with 200 frames (7 pairs), files 0.2 % smaller.
//! - Memory of messages that is used again, a piece for each message: 1.0.
//! - Frames written on the thread of the model where all cores are busy: 0.9 to 1.1, within noise.
//!
//! New files take twice as long while others have been removed within the last minute (ext4). `tiny` therefore removes its files at
//! the end; `jobs`, whose sets have 1 GB each, after each set.
//!
//! `jobs`: 35.6 s and 23.2 s, 1.56 (1.39 to 1.57; 5 pairs). With one job, the recorder's threads already work beside the models: the set
//! takes 39 s of processor time with one job or two, so on two cores the ratio is at most 35.6/19.5 = 1.83. These are figures of manifests
//! that were executed one after the other, with an idle core at the end of each; now, their runs share the processors. On the Xeon, idle: 46.0 and
//! 28.6 s, 1.59, with 51.9 s of processor time. The bar of 1.75 would need 26.3 s, and two cores that never idle 26.0 (1.77): the threads of one job
//! already occupy 1.13 cores.
//!
//! Plans from samples instead of starts took the processor time of a plan from 0.8 to 0.1 s (DEM on a lattice), 3.1 to 0.16 (the same at
//! random), 1.8 to 0.09 (packing) and 0.6 to 0.03 (gas); 5 alternate plans on a busy machine, where the wall time is several times that.
//! Indices of two bytes and memory for forces per thread took the memory of the DEM run from 347 to 328 bytes per disc, and from 386 to 362
//! with friction; the last series was 332 and 360, gas 220, packing 202. With schema version 5, one DEM run of the programs of
//! the tests: 351. The largest parts at the peak: 80 of the rows of a frame, 69 of the discs, 62 of lists (an inner pair takes 20), 42 of the compressed chunk, 24 of velocities and spins at the positions' time, 16 of
//! the positions at which the lists were built. Now a large message is compressed into its own memory, of large `/particles` only the SHA-256 is
//! kept, and spins are evaluated only where there are some: the same run before and after, programs of the tests, one thread: 357 and 295
//! (`peak_memory_of_the_program_bytes` in its `.host.json`), of which the program itself takes 31. The peak is now where a frame is
//! filled: 80 of rows, 69 of the discs, 63 of lists, 16 of velocities, 16 of the positions at which the lists were built, 12 of the drawing
//! of 10^4 discs. 250 would need rows without the constants of particles (24) and velocities that are summed block by block (16).
//!
//! The bars: a thousand tiny runs in 1.0 s; 1.8; 250 bytes per particle, and 64 MB; 0.3 s.

#![allow(clippy::unwrap_used, reason = "a benchmark may end on an error")]

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

const PAIRS: usize = 5;
const TINY_RUNS: usize = 1000;

/// Runs that are over in a few steps.
const TINY: [(&str, &str); 4] = [
    ("gas", "[model.gas]\nparticles = 4\nduration_s = 0.01\n[record]\nframes = 20\n"),
    ("gas_200", "[model.gas]\nparticles = 4\nduration_s = 0.01\n"),
    ("packing", "[model.packing]\ndiscs = 4\nevents_per_disc = 3\n[record]\nframes = 2\n"),
    ("dem", "[model.dem]\ndiscs = 4\nduration_s = 0.001\n[record]\nframes = 20\n"),
];

/// Runs of 10^6 particles that record some frames.
const LARGE: [(&str, &str); 4] = [
    (
        "dem",
        "[model.dem]\ndiscs = 1000000\nwidth_m = 1.03\nheight_m = 1.03\nplacement = \"lattice\"\nvelocity_std_m_per_s = 0.3\n\
         stiffness_n_per_m = 4e5\nduration_s = 0.001\n[record]\nevery_steps = 70\n",
    ),
    (
        "dem_friction",
        "[model.dem]\ndiscs = 1000000\nwidth_m = 1.03\nheight_m = 1.03\nplacement = \"lattice\"\nvelocity_std_m_per_s = 0.3\n\
         stiffness_n_per_m = 4e5\nfriction = 0.5\nduration_s = 0.001\n[record]\nevery_steps = 70\n",
    ),
    ("gas", "[model.gas]\nparticles = 1000000\nduration_s = 0.1\n[record]\nframes = 3\n"),
    (
        "packing",
        "[model.packing]\ndiscs = 1000000\nwidth = 3240.0\nheight = 3240.0\nevents_per_disc = 1\n[record]\nframes = 3\n",
    ),
];

/// 10^4 discs for 400 steps, recorded after each of `steps`.
fn dense(steps: u32) -> String {
    format!(
        "[model.dem]\ndiscs = 10000\nwidth_m = 0.15\nheight_m = 0.15\nduration_s = 3.1416e-3\nstiffness_n_per_m = 4e5\n\
         [record]\nevery_steps = {steps}\n"
    )
}

/// Runs the program; returns its wall time, s.
fn run(output: &Path, arguments: &[&str], manifests: &[PathBuf]) -> f64 {
    let started = Instant::now();
    let mut command = Command::new(env!("CARGO_BIN_EXE_run-experiment"));
    command.args(arguments).args(["--quiet", "--output"]).arg(output).args(manifests);
    // A shipped experiment may end on a fault on purpose.
    command.status().unwrap();
    started.elapsed().as_secs_f64()
}

/// The files of an experiment whose names end so.
fn files(output: &Path, ending: &str) -> Vec<PathBuf> {
    let experiments = fs::read_dir(output).unwrap().map(|entry| entry.unwrap().path());
    let files = experiments.flat_map(|folder| fs::read_dir(folder).unwrap());
    files
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.to_string_lossy().ends_with(ending))
        .collect()
}

/// A manifest in the folder.
fn manifest(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(format!("{name}.toml"));
    fs::write(&path, text).unwrap();
    path
}

/// Time of a thousand runs of a model, and the mean size of their recordings.
fn run_tiny(folder: &Path, name: &str, model: &str) -> (f64, u64) {
    let text = format!("seed = 5\nreplicates = {TINY_RUNS}\n{model}");
    let (path, output) = (manifest(folder, name, &text), new_folder(folder));
    let took = run(&output, &["--jobs", "2"], &[path]);
    let recordings = files(&output, ".mcap");
    assert_eq!(recordings.len(), TINY_RUNS, "{name}");
    let bytes: u64 = recordings.iter().map(|path| path.metadata().unwrap().len()).sum();
    (took, bytes / TINY_RUNS as u64)
}

/// A folder for files that stay until the end: the system would need more time for new files after it has removed others.
fn new_folder(folder: &Path) -> PathBuf {
    tempfile::tempdir_in(folder).unwrap().keep()
}

/// Time of two threads that write and sync a thousand files of this size, rename each and sync the folder, s.
fn write_files(folder: &Path, bytes: u64) -> f64 {
    let output = new_folder(folder);
    let contents = vec![7; usize::try_from(bytes).unwrap()];
    let started = Instant::now();
    std::thread::scope(|scope| {
        for thread in 0..2 {
            let (output, contents) = (&output, &contents);
            scope.spawn(move || {
                for number in (thread..TINY_RUNS).step_by(2) {
                    let partial = output.join(format!("{number}.partial"));
                    let mut file = fs::File::create(&partial).unwrap();
                    file.write_all(contents).unwrap();
                    file.sync_all().unwrap();
                    fs::rename(&partial, output.join(number.to_string())).unwrap();
                    fs::File::open(output).unwrap().sync_all().unwrap();
                }
            });
        }
    });
    started.elapsed().as_secs_f64()
}

/// Peak memory of a run, bytes.
fn peak(folder: &Path, name: &str, text: &str) -> u64 {
    let output = folder.join("memory");
    run(&output, &["--jobs", "1", "--threads", "1"], &[manifest(folder, name, text)]);
    let host = files(&output, ".host.json").pop().unwrap();
    let host: serde_json::Value = serde_json::from_slice(&fs::read(host).unwrap()).unwrap();
    fs::remove_dir_all(output).unwrap();
    host["peak_memory_of_the_program_bytes"].as_u64().unwrap()
}

/// Time of all shipped experiments, s.
fn shipped(folder: &Path, jobs: &str) -> f64 {
    let experiments = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("experiments");
    let output = folder.join("shipped");
    let took = run(&output, &["--jobs", jobs], &[experiments]);
    fs::remove_dir_all(output).unwrap();
    took
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Runs both in turn; prints median times, and the median of the ratios with their range.
fn compare(what: &str, one: &dyn Fn() -> f64, other: &dyn Fn() -> f64) {
    let pairs: Vec<[f64; 2]> = (0..PAIRS).map(|_| [one(), other()]).collect();
    let ratios = sorted(pairs.iter().map(|pair| pair[0] / pair[1]));
    let median = |side: usize| sorted(pairs.iter().map(|pair| pair[side]))[PAIRS / 2];
    println!(
        "{what:<44}{:>8.3} s {:>8.3} s {:>8.2} ({:.2} to {:.2})",
        median(0),
        median(1),
        ratios[PAIRS / 2],
        ratios[0],
        ratios[PAIRS - 1]
    );
}

fn main() {
    let wanted: Vec<String> =
        std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let wants = |part: &str| wanted.is_empty() || wanted.iter().any(|word| word == part);
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    if wants("tiny") {
        for (name, model) in TINY {
            let (_, bytes) = run_tiny(folder, name, model);
            let what = format!("1000 tiny runs over their files, {name}");
            compare(&what, &|| run_tiny(folder, name, model).0, &|| write_files(folder, bytes));
        }
    }
    if wants("memory") {
        for (name, model) in LARGE {
            let bytes = peak(folder, name, model);
            println!("{name}, 10^6 particles: {} bytes per particle", bytes / 1_000_000);
        }
        let [all, ends] = [1, 400].map(|steps| peak(folder, "dense", &dense(steps)));
        let more = all.saturating_sub(ends) as f64 / 1e6;
        println!("dense recording: {more:.0} MB more than without frames");
    }
    if wants("plan") {
        for (name, model) in LARGE {
            let path = manifest(folder, name, model);
            let plan = || run(&folder.join("plan"), &["--dry-run"], std::slice::from_ref(&path));
            let times = sorted((0..PAIRS).map(|_| plan()));
            let (least, median, most) = (times[0], times[PAIRS / 2], times[PAIRS - 1]);
            println!("plan of {name}: {median:.2} s ({least:.2} to {most:.2})");
        }
    }
    if wants("jobs") {
        compare("shipped experiments, one job over two", &|| shipped(folder, "1"), &|| {
            shipped(folder, "2")
        });
    }
}

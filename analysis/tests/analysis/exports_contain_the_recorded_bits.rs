//! Guarantee: exports contain the recorded numbers, bitwise identical, in each format: CSV, the gnuplot format of the exercises, extended XYZ
//! and Parquet. Other programs read the last two.
#![allow(clippy::unwrap_used, missing_docs, reason = "a test's helper may panic")]

use crate::synthetic::{Folder, Frames, analyze};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::{PackingCollisions, PackingTemperature, PerCollision};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

const MANIFEST: &str = r#"
name = "discs"
[model.packing]
discs = 2
radius = 1.5
[record]
frames = 2
channels = ["state", "temperature", "collisions"]
"#;

/// Numbers that a decimal format may not preserve: a third, a tiny one, a large one.
fn state(frame: u64, disc: u64) -> [f64; 4] {
    let base = (frame + 1) as f64 / 3.0;
    [base + disc as f64, -base, 1e-300 * base, 1e15 * base + disc as f64]
}

fn frames(_: &RunManifest) -> Frames {
    (0..3)
        .map(|index| {
            let mut frame = Frame::new();
            (0..2).for_each(|disc| frame.push_state(&state(index, disc)));
            frame.push(&PackingTemperature { a2: 0.1, ..PackingTemperature::default() });
            frame.push(&PackingCollisions {
                pair_collisions: 7 * index,
                ..PackingCollisions::default()
            });
            (Clock { count: index, time: index as f64 / 7.0 }, frame)
        })
        .collect()
}

/// The folder with the exports of the recording.
fn exported(form: &str) -> (Folder, PathBuf) {
    let folder = Folder::write(MANIFEST, frames);
    analyze(&["--export", form, folder.name()]).exited_with(0);
    let stem = folder.files[0].trim_end_matches(".mcap");
    let path = folder.path().join("export").join(stem);
    (folder, path)
}

fn rows(text: &str, separator: char) -> Vec<Vec<f64>> {
    text.lines()
        .map(|line| line.split(separator).map(|word| word.parse().unwrap()).collect())
        .collect()
}

/// A table in a sweep has the coordinates as columns; identifiers and counts are integers; no column is there twice, although
/// the clock and the series of collisions have a time of their own.
#[test]
fn csv_has_coordinates_integer_identifiers_and_no_column_twice() {
    let sweep = MANIFEST.replace("\"collisions\"]", "\"collisions\", \"per_collision\"]")
        + "\n[sweep]\n\"model.packing.restitution\" = [0.25, 1]\n";
    let folder = Folder::write(&sweep, |run| {
        let mut all = frames(run);
        for (_, frame) in &mut all {
            frame.push(&PerCollision {
                event: vec![1, 2],
                time: vec![0.5, 1.5],
                mean_square_velocity: vec![1.0, 2.0],
                a2: vec![0.0, 0.0],
            });
        }
        all
    });
    assert_eq!(analyze(&["--export", "csv", folder.name()]).code, 0);
    for (file, restitution) in folder.files.iter().zip(["0.25", "1"]) {
        let path = folder.path().join("export").join(file.trim_end_matches(".mcap"));
        let read = |name: &str| fs::read_to_string(path.join(name)).unwrap();
        let (state, series) = (read("state.csv"), read("per_collision.csv"));
        assert!(state.starts_with("restitution,frame,time,particle,x,y,vx,vy\n"), "{state}");
        assert!(
            state.lines().nth(2).unwrap().starts_with(&format!("{restitution},0,0,1,")),
            "{state}"
        );
        let header = "restitution,frame,time,event,entry_time,mean_square_velocity,a2\n";
        assert!(series.starts_with(header), "{series}");
        assert_eq!(series.lines().nth(2).unwrap(), format!("{restitution},0,0,2,1.5,2,0"));
        let counts = read("collisions.csv");
        assert_eq!(
            counts.lines().nth(3).unwrap(),
            format!("{restitution},2,0.2857142857142857,14,0,0,0")
        );
        let clock = read("frame.csv");
        assert!(clock.starts_with("restitution,frame,time,step_or_event_count\n"), "{clock}");
    }
}

/// The columns of the state carry the units that the recording declares.
#[test]
fn csv_has_units_in_its_header() {
    let manifest = "name = \"orbit\"\n[model.orbit]\nduration_days = 1\n[record]\nframes = 1\nchannels = [\"state\"]\n";
    let folder = Folder::write(manifest, |_| {
        let frame = |index: u8| {
            let mut frame = Frame::new();
            frame.push_state(&[1.0, 0.0, 0.0, 0.0, 0.017, 0.0]);
            (Clock { count: u64::from(index), time: f64::from(index) }, frame)
        };
        vec![frame(0), frame(1)]
    });
    assert_eq!(analyze(&["--export", "csv", folder.name()]).code, 0);
    let stem = folder.files[0].trim_end_matches(".mcap");
    let text =
        fs::read_to_string(folder.path().join("export").join(stem).join("state.csv")).unwrap();
    let header =
        "frame,time_days,particle,x_au,y_au,z_au,vx_au_per_day,vy_au_per_day,vz_au_per_day\n";
    assert!(text.starts_with(header), "{text}");
}

#[test]
fn csv_contains_every_number_bitwise() {
    let (_folder, path) = exported("csv");
    let text = fs::read_to_string(path.join("state.csv")).unwrap();
    let (header, body) = text.split_once('\n').unwrap();
    assert_eq!(header, "frame,time,particle,x,y,vx,vy");
    let found = rows(body, ',');
    assert_eq!(found.len(), 6);
    for (row, values) in found.iter().enumerate() {
        let (frame, disc) = (row as u64 / 2, row as u64 % 2);
        assert_eq!(values[..3], [frame as f64, frame as f64 / 7.0, disc as f64]);
        assert_eq!(values[3..], state(frame, disc));
    }
    let text = fs::read_to_string(path.join("collisions.csv")).unwrap();
    let (header, body) = text.split_once('\n').unwrap();
    let pair = header.split(',').position(|name| name == "pair_collisions").unwrap();
    let pairs: Vec<f64> = rows(body, ',').iter().map(|row| row[pair]).collect();
    assert_eq!(pairs, [0.0, 7.0, 14.0]);
}

#[test]
#[cfg(not(feature = "parquet"))]
fn control_program_without_parquet_names_what_to_do() {
    let folder = Folder::write(MANIFEST, frames);
    for asked in [["--export", "csv,parquet"].as_slice(), &["--metrics-table"]] {
        let output = analyze(&[asked, &[folder.name()]].concat()).exited_with(2);
        for remedy in ["write CSV", "pip install kinetoscope", "--features parquet"] {
            assert!(output.text.contains(remedy), "{remedy}: {}", output.text);
        }
        assert!(!folder.path().join("export").exists());
    }
}

#[test]
fn gnuplot_files_have_one_disc_per_line_and_a_script_shows_all_frames() {
    let (_folder, path) = exported("gnuplot");
    for frame in 0..3 {
        let file = path.join(format!("gnuplot/frame_{frame:06}.txt"));
        let found = rows(&fs::read_to_string(file).unwrap(), ' ');
        let expected: Vec<Vec<f64>> = (0..2)
            .map(|disc| {
                let [x, y, vx, vy, ..] = state(frame, disc);
                vec![x, y, 1.5, vx, vy]
            })
            .collect();
        assert_eq!(found, expected);
    }
    let script = fs::read_to_string(path.join("gnuplot/play.gp")).unwrap();
    assert!(script.contains("do for [frame = 0:2]") && script.contains("with circles"), "{script}");
    assert!(script.contains("set xrange [-20:20]"), "{script}");
    assert!(script.contains("\"borders.txt\" with lines"), "{script}");
    assert!(!script.contains("mouse"), "{script}");
    let borders = fs::read_to_string(path.join("gnuplot/borders.txt")).unwrap();
    let corners: BTreeSet<&str> = borders.lines().filter(|line| !line.is_empty()).collect();
    assert_eq!(corners, BTreeSet::from(["-20.0 -20.0", "-20.0 20.0", "20.0 -20.0", "20.0 20.0"]));
    let script = fs::read_to_string(path.join("gnuplot/velocity.gp")).unwrap();
    assert!(script.contains("with vectors") && script.contains("set label"), "{script}");
}

#[test]
#[ignore = "needs gnuplot"]
fn gnuplot_plays_both_scripts_to_their_end() {
    let (_folder, path) = exported("gnuplot");
    for script in ["play.gp", "velocity.gp"] {
        let mut gnuplot = Command::new("gnuplot");
        gnuplot.args(["-e", "set terminal dumb", script]).current_dir(path.join("gnuplot"));
        let output = gnuplot.stdin(std::process::Stdio::null()).output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && !errors.contains("undefined"), "{errors}");
    }
}

/// Runs a Python program, which contains the assertions, on a file.
fn python(program: &str, file: PathBuf) {
    let output = Command::new("python3").args(["-c", program]).arg(&file).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
#[ignore = "needs python3 with ase"]
fn ase_reads_extended_xyz() {
    let (_folder, path) = exported("xyz");
    let program = "
import sys, numpy, ase.io
frames = ase.io.read(sys.argv[1], index=':')
assert len(frames) == 3
for index, atoms in enumerate(frames):
    base = (index + 1) / 3
    assert atoms.info['Time'] == index / 7, atoms.info
    assert atoms.info['Frame'] == index
    assert numpy.array_equal(atoms.positions, [[base, -base, 0], [base + 1, -base, 0]])
    velocities = [[1e-300 * base, 1e15 * base, 0], [1e-300 * base, 1e15 * base + 1, 0]]
    assert numpy.array_equal(atoms.arrays['velo'], velocities)
    assert numpy.array_equal(atoms.arrays['radius'], [1.5, 1.5])
    assert numpy.array_equal(atoms.cell.lengths()[:2], [40, 40])
";
    python(program, path.join("state.xyz"));
}

/// A sweep over two axes with two replicates, read with DuckDB and Polars by the commands of the README. The coordinates come
/// from the names of the folders, and a second analysis replaces every row of the first.
#[test]
#[cfg(feature = "parquet")]
#[ignore = "needs python3 with duckdb and polars"]
fn duckdb_and_polars_read_the_table_of_a_sweep() {
    let sweep = format!(
        "{MANIFEST}\n[sweep]\n\"model.packing.restitution\" = [0.25, 0.5]\n\
         \"model.packing.boundary\" = [\"walls\", \"periodic\"]\n"
    );
    let sweep = sweep.replace("name =", "replicates = 2\nname =");
    let folder = Folder::write(&sweep, frames);
    for _ in 0..2 {
        analyze(&["--metrics-table", folder.name()]).exited_with(0);
    }
    let part = "export/metrics/restitution=0.25/boundary=walls/metrics.parquet";
    assert!(folder.path().join(part).exists());
    let program = "
import sys, json, duckdb, polars
table = sys.argv[1] + '/export/metrics/**/*.parquet'
document = json.load(open(sys.argv[1] + '/metrics.json'))
runs = [entry for entry in document['metrics'] if 'run' in entry]
expected = sorted(
    (float(entry['run']['coordinates']['restitution']['value']), entry['run']['coordinates']['boundary']['value'],
     entry['run']['replicate'], entry['name'], entry['value'], entry['standard_error'], entry['run']['file'])
    for entry in runs)
assert len(expected) >= 8
columns = 'restitution::DOUBLE, boundary, replicate, metric, value, standard_error, file'
found = duckdb.sql(f\"select {columns} from read_parquet('{table}', hive_partitioning = true)\").fetchall()
assert sorted(found) == expected, (found, expected)
frame = polars.scan_parquet(table, hive_partitioning=True).collect()
names = ['restitution', 'boundary', 'replicate', 'metric', 'value', 'standard_error', 'file']
assert sorted(frame.select(names).rows()) == expected
mean = duckdb.sql(f\"select restitution, avg(value) from read_parquet('{table}', hive_partitioning = true) \"
                  f\"where metric = 'a2.final' group by all order by all\").fetchall()
assert len(mean) == 2, mean
";
    python(program, folder.path().to_path_buf());
}

#[test]
#[cfg(feature = "parquet")]
#[ignore = "needs python3 with pyarrow"]
fn pyarrow_reads_parquet() {
    let (_folder, path) = exported("parquet");
    let program = "
import sys, pyarrow.parquet
table = pyarrow.parquet.read_table(sys.argv[1]).to_pydict()
assert table['frame'] == [0, 0, 1, 1, 2, 2]
assert table['x'] == [frame / 3 + disc for frame in (1, 2, 3) for disc in (0, 1)]
assert table['vy'] == [1e15 * (frame / 3) + disc for frame in (1, 2, 3) for disc in (0, 1)]
assert table['time'] == [frame / 7 for frame in (0, 0, 1, 1, 2, 2)]
";
    python(program, path.join("state.parquet"));
}

#[test]
#[cfg(feature = "parquet")]
#[ignore = "needs python3 with pyarrow"]
fn pyarrow_reads_the_same_metrics_as_the_csv() {
    let (folder, _) = exported("parquet");
    let program = "
import csv, math, pathlib, sys, pyarrow.parquet
table = pyarrow.parquet.read_table(sys.argv[1]).to_pylist()
rows = list(csv.DictReader(pathlib.Path(sys.argv[1]).with_suffix('.csv').open()))
assert rows and len(rows) == len(table)
for row, metric in zip(rows, table):
    assert list(row) == list(metric)
    for name, text in row.items():
        value = metric[name]
        if value is None:
            assert text == ''
        elif isinstance(value, bool):
            assert text == str(value).lower()
        elif isinstance(value, str):
            assert text == value
        else:
            assert type(value)(text) == value
";
    python(program, folder.path().join("metrics.parquet"));
}

#[test]
fn help_names_every_format_and_no_identifier() {
    let help = analyze(&["--help"]).text;
    for form in ["csv:", "parquet:", "gnuplot:", "xyz:"] {
        assert!(help.contains(form), "{form}: {help}");
    }
    assert!(!help.contains("[`") && !help.contains("NEEDS_"), "{help}");
}

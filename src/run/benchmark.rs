//! Benchmark of an experiment: the time of each run, measured without recording, one run after the other. The table names the
//! machine.
//!
//! Runs that differ in a key with two values are executed alternately (A B A B …), so that other load on the machine affects
//! their ratio as little as possible.

use crate::interrupt::Interrupt;
use crate::run::adapted_budget;
use crate::run::published_times::published_s;
use crate::run::resources::memory;
use kinetoscope_console::Explained;
use kinetoscope_files::regular_file::{MAX_SIDE_FILE_BYTES, read_text};
use kinetoscope_manifest::{
    Coordinate, Experiment, Run, RunManifest, TimingComparison, TimingPoint, TimingRatio,
    TimingTable,
};
use kinetoscope_physics::model::{Progress, SetupError, SimulationFault};
use kinetoscope_physics::prepare_while;
use kinetoscope_physics::random::Seed;
use std::path::Path;
use std::time::Instant;
use thiserror::Error;

/// The reason why a run was not timed.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum TimingError {
    /// The run cannot start.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The simulation failed.
    #[error(transparent)]
    Fault(#[from] SimulationFault),
}

impl Explained for TimingError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Setup(error) => error.help(),
            Self::Fault(error) => error.help(),
        }
    }
}

/// The replicates of one point of the sweep, in order.
#[derive(Clone, Debug)]
struct Point {
    coordinates: Vec<Coordinate>,
    seconds: Vec<f64>,
    steps_or_events: u64,
    /// Published mean time of such runs, s.
    published_s: Option<f64>,
}

/// Measures every run of an experiment.
///
/// # Errors
/// The first run that cannot start or fails, or [`SetupError::stopped`] after an interrupt.
pub fn time_table(
    experiment: &Experiment,
    interrupt: &Interrupt,
) -> Result<TimingTable, TimingError> {
    let mut points: Vec<Point> = Vec::new();
    let mut runs: Vec<&Run> = experiment.runs.iter().collect();
    runs.sort_by_key(|run| run.replicate);
    let first_replicate = runs.first().map(|run| run.replicate);
    for run in runs {
        // The first run of a point is a warm-up and is repeated.
        if Some(run.replicate) == first_replicate {
            measure(&run.manifest, interrupt)?;
        }
        let (seconds, count) = measure(&run.manifest, interrupt)?;
        match points.iter_mut().find(|point| *point.coordinates == *run.coordinates) {
            Some(point) => {
                point.seconds.push(seconds);
                point.steps_or_events += count;
            }
            None => points.push(Point {
                coordinates: run.coordinates.to_vec(),
                seconds: vec![seconds],
                steps_or_events: count,
                published_s: published_s(&run.manifest.model),
            }),
        }
    }
    Ok(TimingTable {
        schema: TimingTable::SCHEMA,
        experiment: experiment.name.clone(),
        machine: machine(),
        comparison: comparison(&points),
        points: points.iter().map(Point::statistics).collect(),
    })
}

/// Time of a run, s, and number of its steps or events.
fn measure(manifest: &RunManifest, interrupt: &Interrupt) -> Result<(f64, u64), TimingError> {
    memory::check(manifest)?;
    let seed = Seed { seed: manifest.seed, replicate: manifest.replicate };
    let mut model = prepare_while(&manifest.model, seed, false, &|_| !interrupt.is_raised())?;
    let target = model.extent().end();
    let (started, mut budget) = (Instant::now(), 1);
    loop {
        let before = Instant::now();
        if model.advance(target, budget)? == Progress::Reached {
            return Ok((started.elapsed().as_secs_f64(), model.count()));
        }
        budget = adapted_budget(budget, before.elapsed());
        if interrupt.is_raised() {
            return Err(SetupError::stopped().into());
        }
    }
}

/// Description of the machine.
fn machine() -> String {
    let processor =
        read_text(Path::new("/proc/cpuinfo"), MAX_SIDE_FILE_BYTES).ok().and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            line.split_once(':').map(|(_, name)| name.trim().to_owned())
        });
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    format!(
        "on {} ({}, {}, {processors} processors), kinetoscope {}",
        processor.as_deref().unwrap_or("a processor without a name"),
        std::env::consts::OS,
        std::env::consts::ARCH,
        env!("CARGO_PKG_VERSION")
    )
}

impl Point {
    fn statistics(&self) -> TimingPoint {
        let (mean_s, standard_deviation_s) = mean_and_deviation(&self.seconds);
        TimingPoint {
            coordinates: self.coordinates.clone(),
            runs: self.seconds.len(),
            median_s: quantile(&self.seconds, 0.5),
            mean_s,
            standard_deviation_s,
            quartile_distance_s: quantile(&self.seconds, 0.75) - quantile(&self.seconds, 0.25),
            steps_or_events_per_s: self.steps_or_events as f64 / self.seconds.iter().sum::<f64>(),
            published_s: self.published_s,
        }
    }
}

/// The time ratios between the two values of the last key with two values, for equal other coordinates and replicates.
fn comparison(points: &[Point]) -> Option<TimingComparison> {
    let first = points.first()?;
    let (axis, [one, other]) = (0..first.coordinates.len()).rev().find_map(|axis| {
        let mut values: Vec<&str> = Vec::new();
        for point in points {
            let value = point.coordinates[axis].value.as_str();
            if !values.contains(&value) {
                values.push(value);
            }
        }
        <[&str; 2]>::try_from(values).ok().map(|values| (axis, values))
    })?;
    let (mut ratios, mut all) = (Vec::new(), Vec::new());
    for point in points.iter().filter(|point| point.coordinates[axis].value == one) {
        let mut wanted = point.coordinates.clone();
        wanted[axis].value = other.to_owned();
        let Some(partner) = points.iter().find(|point| point.coordinates == wanted) else {
            continue;
        };
        let of_runs: Vec<f64> =
            partner.seconds.iter().zip(&point.seconds).map(|(other, one)| other / one).collect();
        wanted.remove(axis);
        ratios.push(ratio(wanted, &of_runs));
        all.extend(of_runs);
    }
    let (of, over) = (other.to_owned(), one.to_owned());
    Some(TimingComparison { of, over, ratios, all: ratio(Vec::new(), &all) })
}

/// Median and geometric mean of the ratios. In a geometric mean, a delayed run has the same weight in numerator and denominator.
fn ratio(coordinates: Vec<Coordinate>, ratios: &[f64]) -> TimingRatio {
    let logarithms: Vec<f64> = ratios.iter().map(|&ratio| libm::log(ratio)).collect();
    let (mean, deviation) = mean_and_deviation(&logarithms);
    let mean = libm::exp(mean);
    let standard_error = mean * deviation / (ratios.len() as f64).sqrt();
    TimingRatio { coordinates, median: quantile(ratios, 0.5), mean, standard_error }
}

/// Formats the table for a terminal.
#[must_use]
pub fn text(table: &TimingTable) -> String {
    let runs = match table.points.first().map_or(0, |point| point.runs) {
        1 => "1 run".to_owned(),
        several => format!("{several} runs"),
    };
    let mut text = format!(
        "{}: time of the simulation without recording, one run at a time, {runs} per line after a warm-up run\n{}\n\n",
        table.experiment, table.machine
    );
    let names: Vec<String> = table.points.iter().map(|point| name(&point.coordinates)).collect();
    let width = names.iter().map(String::len).max().unwrap_or(0).max("run".len());
    text += &format!(
        "{:width$}  {:>11} {:>11} {:>11} {:>11}  {:>11}\n",
        "run", "median/s", "mean/s", "st.dev./s", "quartiles/s", "per second"
    );
    for (point, name) in table.points.iter().zip(names) {
        text += &format!(
            "{name:width$}  {:>11.3e} {:>11.3e} {:>11.3e} {:>11.3e}  {:>11.3e}\n",
            point.median_s,
            point.mean_s,
            point.standard_deviation_s,
            point.quartile_distance_s,
            point.steps_or_events_per_s
        );
    }
    text += &published_times(table, width);
    if let Some(comparison) = &table.comparison {
        text += &format!(
            "\nTime of {} over time of {}, run by run: median, geometric mean, standard error\n",
            comparison.of, comparison.over
        );
        for ratio in &comparison.ratios {
            text += &ratio_line(&name(&ratio.coordinates), ratio);
        }
        text += &ratio_line("all", &comparison.all);
    }
    text
}

/// The table of published times, empty if no point has one.
fn published_times(table: &TimingTable, width: usize) -> String {
    let mut text = String::new();
    for point in &table.points {
        let Some(published_s) = point.published_s else { continue };
        let (ours_s, ratio) = (point.mean_s, published_s / point.mean_s);
        let name = name(&point.coordinates);
        text += &format!("{name:width$}  {published_s:>11.4} {ours_s:>11.3e} {ratio:>11.0}\n");
    }
    if text.is_empty() {
        return text;
    }
    format!(
        "\nPublished times: {}\n{:width$}  {:>11} {:>11} {:>11}\n{text}",
        TimingPoint::PUBLISHED_BY,
        "run",
        "published/s",
        "mean/s",
        "ratio"
    )
}

fn ratio_line(name: &str, ratio: &TimingRatio) -> String {
    let TimingRatio { median, mean, standard_error, .. } = ratio;
    format!("{name}: {median:.4}, {mean:.4} +- {standard_error:.4}\n")
}

fn name(coordinates: &[Coordinate]) -> String {
    let parts: Vec<String> = coordinates
        .iter()
        .map(|Coordinate { key, value }| {
            let key = key.rsplit('.').next().unwrap_or(key);
            format!("{key} = {value}")
        })
        .collect();
    if parts.is_empty() { "the run".to_owned() } else { parts.join(", ") }
}

/// Mean and standard deviation of a sample; 0 where there is one value.
fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    (mean, if count > 1.0 { (squares / (count - 1.0)).sqrt() } else { 0.0 })
}

/// A quantile between the ordered values.
fn quantile(values: &[f64], fraction: f64) -> f64 {
    let mut ordered = values.to_vec();
    ordered.sort_by(f64::total_cmp);
    let position = fraction * (ordered.len() as f64 - 1.0);
    let below = position as usize;
    let (Some(&low), part) = (ordered.get(below), position - below as f64) else { return f64::NAN };
    let high = ordered.get(below + 1).copied().unwrap_or(low);
    low + part * (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(variant: &str, seconds: &[f64]) -> Point {
        let coordinate =
            |key: &str, value: &str| Coordinate { key: key.to_owned(), value: value.to_owned() };
        let coordinates = vec![coordinate("n", "5"), coordinate("variant", variant)];
        Point { coordinates, seconds: seconds.to_vec(), steps_or_events: 10, published_s: None }
    }

    /// Law: median, quartiles, mean and standard deviation of 1, 2, 3, 4, 10, by hand: 3, 2, 4, 4, sqrt(50/4).
    #[test]
    fn statistics_of_a_known_sample_are_exact() {
        let sample = [10.0, 1.0, 3.0, 2.0, 4.0];
        assert_eq!([0.25, 0.5, 0.75].map(|fraction| quantile(&sample, fraction)), [2.0, 3.0, 4.0]);
        assert_eq!(mean_and_deviation(&sample), (4.0, 12.5_f64.sqrt()));
    }

    /// The packing exercise's runs of 5 discs took 0.0048 s and 0.0046 s.
    #[test]
    fn published_times_are_shown_with_their_ratio() {
        let manifest = "name = \"timed\"\nseed = 1\n[model.packing]\ndiscs = 5\nevents_per_disc = 100\n\
                        initial_velocities = \"variance-1-over-n\"\n";
        let read = |text: &str| {
            let experiment = kinetoscope_manifest::parse(text, "timed.toml", &[]).unwrap();
            published_s(&experiment.runs[0].manifest.model)
        };
        assert_eq!(read(manifest), Some(0.0046));
        assert_eq!(read(&manifest.replace("variance-1-over-n", "unit-variance")), Some(0.0048));
        assert_eq!(read(&manifest.replace("= 100", "= 99")), None);
        let points = [Point { published_s: Some(0.0046), ..point("one", &[2e-5]) }];
        let table = TimingTable {
            schema: TimingTable::SCHEMA,
            experiment: "timed".to_owned(),
            machine: "on a machine".to_owned(),
            comparison: None,
            points: points.iter().map(Point::statistics).collect(),
        };
        let text = text(&table);
        let row = text.lines().last().unwrap();
        assert!(row.contains("0.0046") && row.ends_with(" 230"), "{text}");
    }

    /// Law: ratios are taken run by run, (2/1, 6/2): median 2.5, geometric mean sqrt 6, its error sqrt 6 ln(1.5) / 2.
    #[test]
    fn ratios_compare_runs_of_the_same_replicate() {
        let points = [point("one", &[1.0, 2.0]), point("other", &[2.0, 6.0])];
        let table = TimingTable {
            schema: TimingTable::SCHEMA,
            experiment: "timed".to_owned(),
            machine: "on a machine".to_owned(),
            comparison: comparison(&points),
            points: points.iter().map(Point::statistics).collect(),
        };
        let text = text(&table);
        assert!(text.contains("n = 5: 2.5000, 2.4495 +- 0.4966"), "{text}");
        assert!(text.contains("Time of other over time of one"), "{text}");
        assert!(!text.contains("Published"), "{text}");
        assert_eq!(TimingTable::from_json(&table.to_json().unwrap()).unwrap(), table);
    }
}

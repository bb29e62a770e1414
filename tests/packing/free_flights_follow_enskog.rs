//! Law: between two collisions with others, an elastic disc flies for 1/ν on average, and <|v|>/ν = 1/(2 sqrt(2) n d χ) far. The times of dilute discs
//! have the density <ν(v)^2 exp(-ν(v) t)>/ν with the collision rate ν(v) of a disc with the speed v; the lengths likewise.
//!
//! Source: Enskog's theory (Chapman and Cowling, The Mathematical Theory of Non-uniform Gases) with χ by Henderson, Mol. Phys. 30 (1975) 971, within 0.1 % up to
//! a packing fraction of 0.3; the distribution by Visco, van Wijland and Trizac, Phys. Rev. E 77 (2008) 041117, with ν(v) by quadrature in this file.
//! Setup: 1000 discs in a periodic box, 400,000 flights, found again from `/events` in this file; and 400 discs between walls.
//! Tolerance: three standard errors, which are at most 0.5 %, and 0.2 % for χ and 1/N; a chi-square of 1.5 per bin, in which 50 bins scatter by 0.2.
//! Control: χ = 1 is rejected; so are one rate for all speeds, and one flight per disc in place of flights in proportion to the rate.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use kinetoscope::{Experiment, run};
use kinetoscope_analysis::run::RunOptions;
use kinetoscope_analysis::{RunAnalysis, analyze, analyze_with, charts_of_run};
use kinetoscope_recording::channels::PackingEvents;
use kinetoscope_recording::reader::Recording;
use std::f64::consts::{PI, SQRT_2};

const METRICS: [&str; 2] = ["mean_free_time", "mean_free_path"];
/// Packing fraction of discs that are independent within the errors of 400,000 flights.
const DILUTE: f64 = 0.001;
const BIN: f64 = 0.1;
const BINS: usize = 50;

fn recorded(discs: u32, fraction: f64, keys: &str) -> Recording {
    let side = (f64::from(discs) * PI / fraction).sqrt();
    let manifest = format!(
        "seed = 12\n[model.packing]\ndiscs = {discs}\nradius = 1.0\nwidth = {side:?}\nheight = {side:?}\nremove_mean_velocity = true\n\
         events_per_disc = 205\n{keys}[record]\nframes = 205\nchannels = [\"state\", \"collisions\", \"temperature\", \"events\"]\n"
    );
    let experiment: Experiment = manifest.parse().unwrap();
    run(&experiment.runs[0]).unwrap()
}

const PERIODIC: &str = "boundary = \"periodic\"\n";

/// Times of the flights that end after the fifth frame, when the discs have collided ten times on average.
fn free_times(recording: &Recording) -> Vec<f64> {
    let (mut last, mut times) = (vec![f64::NAN; 1000], Vec::new());
    for (number, frame) in recording.frames().unwrap().enumerate() {
        let Some(events) = frame.unwrap().get::<PackingEvents>().unwrap() else { continue };
        for (event, time) in events.time.iter().enumerate() {
            for id in [events.first_id[event], events.second_id[event]] {
                let before = std::mem::replace(&mut last[id as usize], *time);
                times.extend((number > 5 && !before.is_nan()).then_some(time - before));
            }
        }
    }
    times
}

/// Mean time and path by theory, and both metrics with their conditional errors.
fn means(analysis: &RunAnalysis, fraction: f64, contact: f64) -> [[f64; 3]; 2] {
    let temperature = analysis.measurement("temperature.initial").unwrap().estimate.value;
    let crowding = fraction / PI * 2.0 * contact;
    let theory =
        [1.0 / (2.0 * PI.sqrt() * crowding * temperature.sqrt()), 1.0 / (2.0 * SQRT_2 * crowding)];
    [0, 1].map(|index| {
        let found = analysis.measurement(METRICS[index]).unwrap().estimate;
        let error = found.conditional_standard_error.or(found.standard_error).unwrap();
        [theory[index], found.value, error]
    })
}

/// Contact value of Henderson's equation of state.
fn henderson(fraction: f64) -> f64 {
    (1.0 - 7.0 * fraction / 16.0) / ((1.0 - fraction) * (1.0 - fraction))
}

/// Mean speed relative to discs with Maxwell's velocities and T = 1, over that of two such discs, sqrt(pi): ν(v)/ν.
fn rate_at(speed: f64) -> f64 {
    const STEPS: [usize; 2] = [200, 64];
    let mut sum = 0.0;
    for step in 0..STEPS[0] {
        let relative = (step as f64 + 0.5) * 14.0 / STEPS[0] as f64;
        for turn in 0..STEPS[1] {
            let cosine = ((turn as f64 + 0.5) * PI / STEPS[1] as f64).cos();
            let square = speed * speed + relative * relative - 2.0 * speed * relative * cosine;
            sum += relative * relative * (-square / 2.0).exp();
        }
    }
    sum * 14.0 / (STEPS[0] * STEPS[1]) as f64 / PI.sqrt()
}

/// Share of the flights that end in each bin, which the speeds have with these weights by the rate.
fn shares(weight: impl Fn(f64) -> f64) -> Vec<f64> {
    const STEP: f64 = 0.05;
    let speeds: Vec<[f64; 2]> = (0..140)
        .map(|step| {
            let speed = (f64::from(step) + 0.5) * STEP;
            let rate = rate_at(speed);
            [STEP * speed * (-speed * speed / 2.0).exp() * weight(rate), rate]
        })
        .collect();
    let longer =
        |time: f64| speeds.iter().map(|[share, rate]| share * (-rate * time).exp()).sum::<f64>();
    (0..BINS).map(|bin| longer(bin as f64 * BIN) - longer((bin + 1) as f64 * BIN)).collect()
}

/// Chi-square per bin of times in units of their mean.
fn chi_square(times: &[f64], shares: &[f64]) -> f64 {
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    let mut counts = vec![0.0; BINS];
    for time in times {
        if let Some(count) = counts.get_mut((time / mean / BIN) as usize) {
            *count += 1.0;
        }
    }
    let expected = shares.iter().map(|share| share * times.len() as f64);
    let terms =
        counts.iter().zip(expected).map(|(count, expected)| (count - expected).powi(2) / expected);
    terms.sum::<f64>() / BINS as f64
}

#[test]
fn means_follow_enskog_in_dilute_and_dense_discs() {
    for (fraction, contact) in [(0.01, henderson(0.01)), (0.3, henderson(0.3))] {
        let analysis = analyze(&recorded(1000, fraction, PERIODIC)).unwrap();
        for (index, [theory, value, error]) in
            means(&analysis, fraction, contact).into_iter().enumerate()
        {
            let found = analysis.measurement(METRICS[index]).unwrap().theory.unwrap();
            println!("{fraction}, {}: {value:.5} ± {error:.5}, theory {theory:.5}", METRICS[index]);
            let allowed = 3.0 * error + 0.002 * theory;
            assert!((value - theory).abs() < allowed && error < 0.005 * theory);
            assert!(found.in_range() && (found.value / theory - 1.0).abs() < 0.002, "{found:?}");
            // Control: without the contact value.
            assert!((value - theory * contact).abs() > allowed, "control, {fraction}");
        }
    }
}

/// Discs at a packing fraction of 0.1, of whose flights fewer are short, are the last control.
#[test]
fn times_follow_the_rates_of_the_speeds() {
    let by_rate = shares(|rate| rate);
    let one_rate: Vec<f64> = (0..BINS)
        .map(|bin| (-(bin as f64) * BIN).exp() - (-(bin as f64 + 1.0) * BIN).exp())
        .collect();
    let per_disc = shares(|_| 1.0);
    let times = free_times(&recorded(1000, DILUTE, PERIODIC));
    let found = [&by_rate, &one_rate, &per_disc].map(|shares| chi_square(&times, shares));
    println!("{} flights, chi-square per bin {found:.2?}", times.len());
    assert!(found[0] < 1.5 && found[1] > 5.0 && found[2] > 5.0, "{found:?}");
    let dense = chi_square(&free_times(&recorded(1000, 0.1, PERIODIC)), &by_rate);
    println!("packing fraction 0.1: {dense:.2}");
    assert!(dense > 2.0, "control: {dense}");
}

/// Both plots of dilute discs are within the errors of their theory, and not within those of one rate.
#[test]
fn plots_show_both_distributions() {
    let options = RunOptions { with_figures: true, ..RunOptions::default() };
    let analysis = analyze_with(&recorded(1000, DILUTE, PERIODIC), options).unwrap();
    let charts = charts_of_run(&analysis);
    for stem in ["free_times", "free_paths"] {
        let chart = charts.iter().find(|chart| chart[0] == stem).unwrap();
        let column = |curve: usize, key: &str| -> Vec<f64> {
            serde_json::from_value(chart[1]["curves"][curve][key].clone()).unwrap()
        };
        let (density, errors) = (column(0, "y"), column(0, "e"));
        let per_bin = |theory: Vec<f64>| {
            let terms = density.iter().zip(&errors).zip(theory);
            let terms = terms.filter(|((_, error), _)| **error > 0.0);
            let terms = terms.map(|((found, error), theory)| ((found - theory) / error).powi(2));
            terms.sum::<f64>() / density.len() as f64
        };
        let found = [per_bin(column(1, "y")), per_bin(column(2, "y"))];
        println!("{stem}: chi-square per bin {found:.2?}");
        assert!(found[0] < 1.6 && found[1] > 5.0, "{stem}: {found:?}");
    }
}

/// Collisions with walls end no flight; other discs have a reason in place of a value.
#[test]
fn walls_end_no_flight() {
    let analysis = analyze(&recorded(400, 0.1, "")).unwrap();
    for name in METRICS {
        let found = analysis.measurement(name).unwrap();
        let (value, theory) = (found.estimate, found.theory.unwrap());
        let error = value.conditional_standard_error.or(value.standard_error).unwrap();
        println!(
            "{name}: {} ± {error}, theory {} ± {}",
            value.value, theory.value, theory.accuracy
        );
        assert!(theory.in_range() && error < 0.01 * theory.value);
        assert!((value.value - theory.value).abs() < 3.0 * error + theory.accuracy);
    }
    for keys in ["restitution = 0.9\n", "radius_half_width = 0.2\n"] {
        let analysis = analyze(&recorded(100, 0.1, keys)).unwrap();
        let found = analysis.measurements.iter().find(|found| found.name() == METRICS[1]).unwrap();
        assert!(found.reason.as_ref().unwrap().contains("one size"), "{found:?}");
    }
}

/// Of a run in which few flights of a disc are complete, those that are not count as well. Control: the mean of the complete ones is
/// 10 % shorter, because long flights are rarely complete.
#[test]
fn flights_that_are_not_complete_count() {
    let mut ratios = Vec::new();
    for seed in 1..=10 {
        let manifest = format!(
            "seed = {seed}\n[model.packing]\ndiscs = 20\nradius = 0.01\nwidth = 10.0\nheight = 10.0\nevents_per_disc = 100\n\
             [record]\nframes = 100\nchannels = [\"state\", \"collisions\", \"temperature\", \"events\"]\n"
        );
        let experiment: Experiment = manifest.parse().unwrap();
        let analysis = analyze(&run(&experiment.runs[0]).unwrap()).unwrap();
        let [time, path] = METRICS.map(|name| analysis.measurement(name).unwrap());
        let speed = path.theory.unwrap().value / time.theory.unwrap().value;
        ratios.push(path.estimate.value / time.estimate.value / speed);
    }
    let mean = ratios.iter().sum::<f64>() / 10.0;
    println!("path over time, over the mean speed: {mean:.4}");
    assert!((mean - 1.0).abs() < 0.03, "{mean} {ratios:?}");
}

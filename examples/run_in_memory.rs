//! Executes every run of a manifest in memory and prints one metric, without writing a file.
//!
//!     cargo run --release --example run_in_memory -- experiments/orbit_exercise.toml energy.drift_relative

use kinetoscope::{Experiment, run};
use std::error::Error;
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [manifest, metric] = arguments.as_slice() else {
        return Err("usage: run_in_memory MANIFEST METRIC".into());
    };
    let experiment: Experiment = fs::read_to_string(manifest)?.parse()?;
    for planned in &experiment.runs {
        let analysis = kinetoscope_analysis::analyze(&run(planned)?)?;
        let Some(measured) = analysis.measurement(metric) else {
            return Err(format!("the run has no metric {metric}").into());
        };
        let (value, unit) = (measured.estimate.value, measured.definition.unit);
        println!("replicate {}: {metric} = {value} {unit}", planned.replicate);
    }
    Ok(())
}

//! Reads a recording frame by frame and prints the mean speed of the particles.
//!
//!     cargo run --release --example read_recording -- recordings/first_run/*.mcap

#![allow(clippy::disallowed_methods, reason = "what is printed is not recorded")]

use kinetoscope::Recording;
use std::env;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let Some(path) = env::args().nth(1) else {
        return Err("usage: read_recording RECORDING.mcap".into());
    };
    let recording = Recording::open(Path::new(&path))?;
    let written = recording.provenance();
    println!("model {}, run key {}, outcome {:?}", written.model, written.run_key, written.outcome);
    for frame in recording.frames()? {
        let frame = frame?;
        let Some(state) = frame.state() else { return Err("the recording has no /state".into()) };
        let speed = |row| Some(state.value(row, "vx")?.hypot(state.value(row, "vy")?));
        let speeds: Option<Vec<f64>> = (0..state.rows()).map(speed).collect();
        let speeds = speeds.ok_or("the state has no velocities vx and vy")?;
        let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
        println!("{} {}: mean speed {mean}", frame.clock.time, frame.clock.time_unit);
    }
    Ok(())
}

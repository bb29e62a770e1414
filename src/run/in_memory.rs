//! A run whose recording is kept in memory.

use super::frame_loop::{RunError, record_frames, record_start};
use super::prepared::Prepared;
use crate::interrupt::Interrupt;
use kinetoscope_manifest::{Run, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::Recorder;
use std::path::Path;

/// Executes a run and returns its recording, which is kept in memory. [`Recording::save`] writes the bytes that
/// `run-experiment` writes for the same manifest.
///
/// A physical failure of the simulation is not an error: it is the recording's outcome.
///
/// # Errors
/// A start that cannot be run, or a recording that cannot be written or read.
pub fn run(run: &Run) -> Result<Recording, RunError> {
    run_interruptibly(run, &Interrupt::default())
}

/// [`run`], which ends at an interrupt with the outcome that states it.
///
/// # Errors
/// Like those of [`run`], and `SetupError::stopped` at an interrupt before the start is complete.
pub fn run_interruptibly(run: &Run, interrupt: &Interrupt) -> Result<Recording, RunError> {
    let manifest = &run.manifest;
    let canonical = manifest.canonical();
    let key = run_key(&canonical, kind_of(&manifest.model).physics_version, SCHEMA_VERSION);
    let start = Prepared::new(manifest, &canonical, key.as_str(), interrupt)?;
    let recorder = Recorder::create(Vec::new(), &start.header)?;
    let mut state = record_start(start, recorder)?;
    let outcome = record_frames(&mut state, interrupt, &|_, _| {}, |_, _| Ok(()))?;
    let bytes = state.recorder.finish(&outcome)?;
    Ok(Recording::from_bytes(bytes, Path::new("the recording in memory"))?)
}

//! A run whose recording is kept in memory.

use super::frame_loop::{RunError, record_frames, record_start, record_start_on_this_thread};
use super::prepared::Prepared;
use crate::interrupt::Interrupt;
use kinetoscope_manifest::{Run, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use kinetoscope_recording::frame_hashes::HashingObserver;
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::{Compression, Recorder};
use std::path::Path;
use std::sync::{Arc, PoisonError};

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

/// Executes a run on this thread, and returns its recording, uncompressed and kept in memory, with the first half of the SHA-256 of all
/// messages, as a lock file contains it.
///
/// # Errors
/// Like those of [`run_interruptibly`].
pub fn run_with_hash(run: &Run, interrupt: &Interrupt) -> Result<(Recording, [u8; 16]), RunError> {
    let manifest = &run.manifest;
    let canonical = manifest.canonical();
    let key = run_key(&canonical, kind_of(&manifest.model).physics_version, SCHEMA_VERSION);
    let mut start = Prepared::new(manifest, &canonical, key.as_str(), interrupt)?;
    start.header.compression = Compression::None;
    let observer = HashingObserver::default();
    let hasher = Arc::clone(&observer.0);
    let mut recorder = Recorder::create(Vec::new(), &start.header)?;
    recorder.show_to(Box::new(observer))?;
    let mut state = record_start_on_this_thread(start, recorder)?;
    let outcome = record_frames(&mut state, interrupt, &|_, _| {}, |_, _| Ok(()))?;
    let bytes = state.recorder.finish(&outcome)?;
    let messages = hasher.lock().unwrap_or_else(PoisonError::into_inner).hashes().messages;
    Ok((Recording::from_bytes(bytes, Path::new(IN_MEMORY))?, messages))
}

/// The name of a recording in memory in errors.
const IN_MEMORY: &str = "the recording in memory";

/// [`run`], which ends at an interrupt with the outcome that states it.
///
/// # Errors
/// Like those of [`run`], and `SetupError::stopped` at an interrupt before the start is complete.
pub fn run_interruptibly(run: &Run, interrupt: &Interrupt) -> Result<Recording, RunError> {
    recorded(run, interrupt, None)
}

/// [`run_interruptibly`], with a recording that is not compressed.
///
/// # Errors
/// Like those of [`run_interruptibly`].
pub fn run_uncompressed(run: &Run, interrupt: &Interrupt) -> Result<Recording, RunError> {
    recorded(run, interrupt, Some(Compression::None))
}

fn recorded(
    run: &Run,
    interrupt: &Interrupt,
    compression: Option<Compression>,
) -> Result<Recording, RunError> {
    let manifest = &run.manifest;
    let canonical = manifest.canonical();
    let key = run_key(&canonical, kind_of(&manifest.model).physics_version, SCHEMA_VERSION);
    let mut start = Prepared::new(manifest, &canonical, key.as_str(), interrupt)?;
    start.header.compression = compression.unwrap_or(start.header.compression);
    let recorder = Recorder::create(Vec::new(), &start.header)?;
    let mut state = record_start(start, recorder)?;
    let outcome = record_frames(&mut state, interrupt, &|_, _| {}, |_, _| Ok(()))?;
    let bytes = state.recorder.finish(&outcome)?;
    Ok(Recording::from_bytes(bytes, Path::new(IN_MEMORY))?)
}

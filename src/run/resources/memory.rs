//! The memory that a run needs, from its number of particles, and the memory that this machine has for it.

use kinetoscope_files::regular_file::{MAX_SIDE_FILE_BYTES, read_text};
use kinetoscope_manifest::RunManifest;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_physics::model::SetupError;
use kinetoscope_physics::state_columns_of;
use std::path::Path;

/// Memory that any machine has. The available memory is not read for a run that needs less.
const ALWAYS_AVAILABLE_BYTES: u64 = 256 << 20;

/// Memory of a run without particles: the program, and the chunks of a block that its recorder fills and compresses.
pub(crate) const PROGRAM_BYTES: u64 = 80 << 20;
/// Memory of a model, its neighbors or events and its recorder's queue, as a number of recorded frames. The maximum measured
/// with 10^6 particles is 3.5, for a bed that starts from a recording; it is 3.3 with recorded contact forces.
const FRAMES_NEEDED: u64 = 4;
/// The same as an upper estimate.
const FRAMES_AT_MOST: u64 = 2 * FRAMES_NEEDED;
/// Size of the drawing of a disc, compressed.
const DRAWN_BYTES: u64 = 50;

/// The number of bytes that Linux reports in `file` as a line `LABEL: N kB`; `None` on other operating systems.
#[must_use]
pub fn memory_bytes(file: &str, label: &str) -> Option<u64> {
    let text = read_text(Path::new(file), MAX_SIDE_FILE_BYTES).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(label))?;
    let kibibytes: u64 =
        line.trim_start_matches(':').trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Memory of the program in a page: its module cannot have more (`src/browser`).
const BYTES_IN_A_PAGE: u64 = 512 << 20;

/// The available memory (`MemAvailable` of Linux); that of a page without an operating system; unlimited on other operating systems.
#[must_use]
pub fn available_bytes() -> u64 {
    if cfg!(target_os = "unknown") {
        return BYTES_IN_A_PAGE;
    }
    memory_bytes("/proc/meminfo", "MemAvailable").unwrap_or(u64::MAX)
}

/// Rejects a run that needs more memory than is available. No memory has been spent on its particles yet.
///
/// # Errors
/// A run that cannot be executed on this machine, with the remedy.
pub fn check(manifest: &RunManifest) -> Result<(), SetupError> {
    let needed = needed_memory_bytes(manifest);
    if needed <= ALWAYS_AVAILABLE_BYTES {
        return Ok(());
    }
    let available = available_bytes();
    if needed <= available {
        return Ok(());
    }
    let (needed, available) = (needed as f64 / 1e9, available as f64 / 1e9);
    let (place, more) = if cfg!(target_os = "unknown") {
        ("a page", "run the manifest with the program")
    } else {
        ("this machine", "end other programs, or use a machine with more memory")
    };
    Err(SetupError::new(
        format!(
            "the run needs {needed:.1} GB of memory for its {} particles, {place} has {available:.1} GB available",
            manifest.model.particles(),
        ),
        format!("reduce the number of particles, {more}"),
    ))
}

/// Memory that a run needs in any case, estimated without building its start.
#[must_use]
pub fn needed_memory_bytes(manifest: &RunManifest) -> u64 {
    let frame = bytes_of_particles(manifest.model.particles(), &manifest.model);
    let runs = if manifest.record.has_twin() { 2 } else { 1 };
    PROGRAM_BYTES.saturating_add(FRAMES_NEEDED.saturating_mul(frame).saturating_mul(runs))
}

/// Upper estimate of the memory of a run whose frames have this size.
pub(super) fn upper_memory_bytes(bytes_per_frame: u64) -> u64 {
    PROGRAM_BYTES.saturating_add(FRAMES_AT_MOST.saturating_mul(bytes_per_frame))
}

/// Size of the particles in a frame: the uncompressed state, and the drawing at its measured compressed size.
pub(super) fn bytes_of_particles(particles: u64, model: &ModelConfig) -> u64 {
    let state = (state_columns_of(model).len() * size_of::<f64>()) as u64;
    particles.saturating_mul(state + DRAWN_BYTES)
}

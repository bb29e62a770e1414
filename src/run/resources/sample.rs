//! A smaller run of the same physics, which stands in for a large one where building its start would take too long.

use kinetoscope_manifest::RunManifest;
use std::num::NonZeroU32;
use std::sync::Arc;

/// Particles of a sample: its start is built in some hundredths of a second.
const PARTICLES: NonZeroU32 = NonZeroU32::new(50_000).expect("not zero");
/// Particles from which a run is estimated by its sample.
const SAMPLED_FROM: u64 = 200_000;

/// The sample of a run; `None` for a small run, and for one whose start depends on more than the density.
#[must_use]
pub fn sample_of(manifest: &RunManifest) -> Option<RunManifest> {
    if manifest.model.particles() < SAMPLED_FROM {
        return None;
    }
    let model = manifest.model.with_particles(PARTICLES)?;
    Some(RunManifest { model: Arc::new(model), ..manifest.clone() })
}

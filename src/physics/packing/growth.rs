//! The growth of the discs during compression.

use serde::{Deserialize, Serialize};

/// Growth of all radii at the same relative rate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Growth {
    /// Radius over full radius at the origin of the engine's clock.
    pub(super) scale: f64,
    /// Growth of this ratio per unit of time.
    pub(super) rate: f64,
}

impl Growth {
    /// Radius over full radius at a local time.
    pub(super) fn scale_at(&self, time: f64) -> f64 {
        self.scale + self.rate * time
    }
}

//! Walls of a DEM run in addition to the box's own: straight segments and drums, at rest or moving.

use crate::inline::{inline_enum, inline_table};
use crate::keys::Reader;
use crate::quantity::{Finite, NonNegative, Positive};

inline_table! {
    /// One wall with its motion: the displacement at time t is u t + A sin(2 pi f t), where the clock t runs within
    /// `moves_s` only.
    #[derive(Copy)]
    pub struct DemWall = "a table { from_m, to_m } or { center_m, radius_m }" with DemWall::rules {
        /// Its shape at the start.
        shape: DemWallShape [flatten],
        /// Constant velocity u, m/s.
        velocity_m_per_s: [Finite; 2] [or [Finite::literal(0.0); 2]],
        /// Amplitude A of an oscillation, m.
        amplitude_m: [Finite; 2] [or [Finite::literal(0.0); 2]],
        /// Frequency f of the oscillation, Hz.
        frequency_hz: NonNegative [or NonNegative::literal(0.0)],
        /// RunStart and end of its motion, a drum's rotation included, s; `None` for all the time.
        moves_s: Option<[NonNegative; 2]> [optional],
    }
}

inline_enum! {
    /// The shape of a wall.
    pub enum DemWallShape = "a table { from_m, to_m } or { center_m, radius_m }" {
        /// A straight segment with two ends; discs may touch either side.
        Segment {
            /// One end, m.
            from_m: [Finite; 2] [required],
            /// The other end, m.
            to_m: [Finite; 2] [required],
        }
        /// A circle with the discs inside.
        Drum {
            /// Its center, m.
            center_m: [Finite; 2] [required],
            /// Its radius, m.
            radius_m: Positive [required],
            /// Its angular velocity, rad/s.
            spin_rad_per_s: Finite [or Finite::literal(0.0)],
        }
    }
}

impl DemWall {
    /// Whether no part of it moves.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        let is_zero = |pair: [Finite; 2]| pair.iter().all(|value| value.get() == 0.0);
        let turns = match self.shape {
            DemWallShape::Drum { spin_rad_per_s, .. } => spin_rad_per_s.get() != 0.0,
            DemWallShape::Segment { .. } => false,
        };
        let oscillates = !is_zero(self.amplitude_m) && self.frequency_hz.get() > 0.0;
        !turns && !oscillates && is_zero(self.velocity_m_per_s)
    }

    fn rules(&self, name: &str, reader: &mut Reader<'_>) {
        if let DemWallShape::Segment { from_m, to_m } = self.shape
            && from_m == to_m
        {
            let title = format!("`{name}` has a wall of zero length");
            reader.refuse(&["from_m", "to_m"], &title, "the two ends must differ");
        }
        if self.moves_s.is_some_and(|[begin, end]| begin >= end) {
            reader.refuse(&["moves_s"], "`moves_s` ends before it begins", "must be [begin, end]");
        }
    }
}

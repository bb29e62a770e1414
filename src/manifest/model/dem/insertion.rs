//! Discs that fall into a DEM run while it runs.

use crate::inline::inline_table;
use crate::keys::Reader;
use crate::quantity::{Finite, NonNegative, Positive};
use std::num::NonZeroU32;

inline_table! {
    /// Discs that enter one after the other, in the order of their ids, at random on a line where there is room.
    #[derive(Copy)]
    pub struct DemInsertion = "a table { discs, discs_per_s, from_m, to_m, velocity_m_per_s }" with DemInsertion::rules {
        /// Number of discs that enter, in addition to those of the start.
        discs: NonZeroU32 [required],
        /// Number of discs due per second; they enter later where there is no room.
        discs_per_s: Positive [required],
        /// One end of the line that their centers enter on, m.
        from_m: [Finite; 2] [required],
        /// The other end, m.
        to_m: [Finite; 2] [required],
        /// Their velocity, m/s; not zero.
        velocity_m_per_s: [Finite; 2] [required],
        /// Time at which the first disc is due, s.
        starts_s: NonNegative [or NonNegative::literal(0.0)],
    }
}

impl DemInsertion {
    fn rules(&self, _name: &str, reader: &mut Reader<'_>) {
        if self.velocity_m_per_s.iter().all(|component| component.get() == 0.0) {
            let title = "`velocity_m_per_s` is [0, 0]; discs cannot enter at rest";
            reader.refuse(&["velocity_m_per_s"], title, "must not be [0, 0]");
        }
    }
}

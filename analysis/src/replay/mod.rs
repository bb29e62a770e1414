//! The replay of a run in its report: positions and speeds of evenly spaced frames, small enough for a page.
//!
//! The collector takes frames in while the run is analyzed, in bounded memory. At the end, the frames become 16-bit numbers that the
//! script of the report draws. The replay is made from the recorded state and walls; a model only adds its `Extent`.

mod collector;
mod encoding;
mod film;
mod flights;
mod forces;
mod lines;
mod motion;
mod picture;
mod poster;
mod speeds;
mod still;
mod view;

pub(crate) use collector::{ReplayCollector, species};
pub(crate) use film::{Film, Replay};

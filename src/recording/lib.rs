//! One run, one MCAP file: what a recording holds, how it is written and how it is read.
//!
//! Nothing here knows physics beyond the columns and messages that a model declares.

pub mod channels;
pub mod frame;
pub mod scenery;

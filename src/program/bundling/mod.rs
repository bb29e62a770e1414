//! `bundle` and `reproduce`: an experiment with its results in one file, and the rerun of such a file by anyone.

pub(crate) mod archive;
pub(crate) mod bundle;
mod contents;
mod description;
mod program;
pub(crate) mod reproduce;
mod results;
mod seal;
mod starts;

//! The threads that all parts of a program share, and threads of their own.

use crate::message::Message;
use rayon::ThreadPoolBuilder;
use std::env;
use std::error::Error as _;
use std::num::NonZeroUsize;
use std::thread::{Builder, available_parallelism};

/// What to do if the system starts no further thread.
pub const ON_MISSING_THREAD: &str = "end other programs, or raise the limits of memory and processes (`ulimit -v`, `ulimit -u`); then \
     run the same command again";

/// The variables from which rayon takes the number of threads.
const VARIABLES: [&str; 2] = ["RAYON_NUM_THREADS", "RAYON_RS_NUM_CPUS"];

/// Starts the threads that all parts of a program share. Otherwise, they would be started by the first part that needs them, and
/// rayon panics if the system has no room for them. On `wasm32`, which has no threads, rayon replaces them by the caller's.
///
/// The number that the environment requests is limited to that of the processors: a huge one would use up the threads of the system.
///
/// # Errors
/// A system that starts no further thread.
pub fn start_threads() -> Result<(), Message> {
    if cfg!(target_family = "wasm") {
        return Ok(());
    }
    let requested = VARIABLES.iter().find_map(|name| env::var(name).ok()?.parse::<usize>().ok());
    let processors = available_parallelism().map_or(1, NonZeroUsize::get);
    // Zero is the number that the environment requests, by default that of the processors.
    let number = requested.filter(|requested| *requested > processors).map_or(0, |_| processors);
    let Err(error) = ThreadPoolBuilder::new().num_threads(number).build_global() else {
        return Ok(());
    };
    match error.source() {
        Some(cause) => {
            Err(Message::new(format!("a thread cannot be started: {cause}"), ON_MISSING_THREAD))
        }
        // They exist.
        None => Ok(()),
    }
}

/// Whether the system starts a further thread at present. Asked before a library starts one that the run can do without: the library
/// panics if it cannot.
#[must_use]
pub fn can_start_thread() -> bool {
    Builder::new().spawn(|| {}).is_ok_and(|thread| thread.join().is_ok())
}

//! The threads that all parts of a program share.

use rayon::ThreadPoolBuilder;
use std::env;
use std::num::NonZeroUsize;
use std::thread::available_parallelism;

/// The variables from which rayon takes the number of threads.
const VARIABLES: [&str; 2] = ["RAYON_NUM_THREADS", "RAYON_RS_NUM_CPUS"];

/// Limits the threads that the environment requests to the number of processors: a huge number would use up those of the system.
pub(crate) fn limit_threads() {
    let requested = VARIABLES.iter().find_map(|name| env::var(name).ok()?.parse::<usize>().ok());
    let processors = available_parallelism().map_or(1, NonZeroUsize::get);
    if requested.is_some_and(|requested| requested > processors) {
        // It fails if the threads exist, which then have the right number.
        let _ = ThreadPoolBuilder::new().num_threads(processors).build_global();
    }
}

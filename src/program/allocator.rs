//! The threads of the program, and how the system's allocator keeps the memory that they free.
//!
//! One thread allocates the memory of a run and another frees it, large blocks again and again. With the default of glibc (one
//! heap per thread, large blocks kept) a run of 10^6 discs held 440 MB, of which it used at most 340. With one heap and large
//! blocks returned it held 343, in the same time. (Peak reported by `/usr/bin/time -v run-experiment --threads 1` for
//! `discs = 1000000`, `width_m = height_m = 1.03`, `placement = "lattice"`, `velocity_std_m_per_s = 0.3`,
//! `stiffness_n_per_m = 4e5`, `duration_s = 0.001`, `every_steps = 70`.)
//!
//! Threads of several runs wait for one another at one heap. `run --jobs 2` of the same 1000 replicates of a gas took 7.1 s with one heap,
//! 7.0 with two, 5.6 with three and 5.2 with four, and 10 000 runs of 20 particles with `keep = "metrics"` 9.1, 6.5, 6.3 and 7.0 s: the
//! program of the dev profile on two cores, in a file system in memory. On a disk that took half of the time, there was little gain.
//! Therefore, a single run has one heap, and several runs at once have two each: for their thread and that of their recorder.
//!
//! By default, the heap shrinks and grows with every frame, which costs page faults. With some free memory kept at its end, the run
//! above holds as much as before. `/usr/bin/time -v run-experiment --jobs 2` for `replicates = 1000`, `particles = 10`, `duration_s = 10`
//! of a gas reports 4200 faults instead of 290 000, and 0.8 of the time.

use crate::messages::Failure;
use kinetoscope_console::{Exit, start_threads};

/// Makes heaps keep little free memory, and returns large freed blocks to the system. Called once, at the start of the program; does
/// nothing with another allocator.
pub(crate) fn keep_little() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        /// Smaller blocks are reused too often to be returned.
        const LARGE_BYTES: libc::c_int = 4 << 20;
        /// A heap shrinks if more than this is free at its end.
        const KEPT_BYTES: libc::c_int = 8 << 20;
        /// Added to what a heap grows by.
        const GROWTH_BYTES: libc::c_int = 1 << 20;
        set(libc::M_MMAP_THRESHOLD, LARGE_BYTES);
        set(libc::M_TRIM_THRESHOLD, KEPT_BYTES);
        set(libc::M_TOP_PAD, GROWTH_BYTES);
    }
}

/// Starts the threads that all parts of the program share, with heaps for so many runs at once. The allocator keeps the number of heaps
/// that the first thread finds.
///
/// # Errors
/// A system that starts no further thread.
pub(crate) fn start_threads_for(runs_at_once: usize) -> Result<(), Failure> {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        let heaps = if runs_at_once > 1 { runs_at_once.saturating_mul(2) } else { 1 };
        set(libc::M_ARENA_MAX, heaps.try_into().unwrap_or(libc::c_int::MAX));
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    let _ = runs_at_once;
    start_threads().map_err(|message| Failure::of(Exit::Retryable, message))
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn set(setting: libc::c_int, value: libc::c_int) {
    // SAFETY: `mallopt` takes two numbers and sets one of the allocator's own; it has no precondition but that no other code calls it at
    // the same time, and it is called before there are threads. A refused number leaves things as they were.
    #[allow(unsafe_code, reason = "the call into the C library; see the head of the file")]
    unsafe {
        libc::mallopt(setting, value);
    }
}

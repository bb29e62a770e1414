//! How the system's allocator keeps what the program has freed.
//!
//! A run's memory is made by one thread and freed by another, large pieces again and again. With glibc's own choice, a heap for
//! each thread and large pieces kept for later, a run of 10^6 discs held 440 MB of which it used at most 340; with one
//! heap and large pieces given back it held 343, in the same time. (The peak that `/usr/bin/time -v run-experiment --threads 1`
//! tells of `discs = 1000000`, `width_m = height_m = 1.03`, `placement = "lattice"`, `velocity_std_m_per_s = 0.3`,
//! `stiffness_n_per_m = 4e5`, `duration_s = 0.001`, `every_steps = 70`.)

/// Has all threads share one heap, and large pieces go back to the system once they are free. For the program's start;
/// where the allocator is another, nothing happens.
pub fn keep_little() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        /// Smaller pieces are used again too often to be given back.
        const LARGE_BYTES: libc::c_int = 4 << 20;
        // SAFETY: `mallopt` takes two numbers and sets two of the allocator's own; it has no precondition but that
        // nobody else calls it, and nobody does. A refused number leaves things as they were.
        #[allow(unsafe_code, reason = "the call into the C library; see the head of the file")]
        unsafe {
            libc::mallopt(libc::M_ARENA_MAX, 1);
            libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE_BYTES);
        }
    }
}

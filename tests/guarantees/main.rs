//! Guarantees that hold for every model: byte-identical recordings, resuming, observation, random streams, verification, memory,
//! and the layout of the repository.
//!
//! A test belongs here if it compares bytes or bits, not numbers within a tolerance. A guarantee of one model only is in the
//! folder of that model.

// Recordings rewritten with one change behind correct checksums.
#[path = "../shared/forged_recording.rs"]
mod forged_recording;
// A short experiment of each model and variant, and its trajectory as bits.
mod small_experiments;
// The distance of a sample from the uniform distribution.
mod uniformity;

// Signals, full disks and failing system calls lose no run.
mod faults_lose_no_run;
// A larger sweep keeps keys and bytes of the runs that exist.
mod growing_sweep_keeps_its_runs;
// Observation does not change the trajectory.
mod observation_is_passive;
// Jobs, threads, folder, user, time zone and build do not change a recording.
mod recording_is_byte_identical;
// A run that was killed and resumed gives the bytes of an undisturbed run.
mod resume_is_invisible;
// The work budget does not change the trajectory.
mod work_cut_is_invisible;

// A rerun of every model and variant verifies its recording.
mod verify_finds_every_model_equal;
// Verification names the first difference of a changed recording.
mod verify_names_the_first_difference;

// Random placement is uniform and free of overlaps.
mod random_placement_never_overlaps;
// Random streams keep their numbers across versions and agree with another program.
mod random_streams_are_pinned;

// The manifest accepts exactly the channels that each model records.
mod channels_can_be_named;
// Viewer layouts name only topics and fields that the recording contains.
mod layouts_name_what_is_recorded;

// A large recorded DEM bed stays within its bytes per disc.
mod dem_memory_a_disc;
// Paths named in documents exist; packages, unsafe code and imports stay where they belong.
mod layers;

mod tidy;

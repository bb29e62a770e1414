//! Guarantees that hold for every model: byte-identical recordings, resuming, observation, random streams, verification, memory,
//! and the layout of the repository.
//!
//! A test belongs here if it compares bytes or bits, not numbers within a tolerance. A guarantee of one model only is in the
//! folder of that model.

// Recordings rewritten with one change behind correct checksums.
#[path = "../shared/forged_recording.rs"]
mod forged_recording;
#[path = "../shared/kinetoscope_program.rs"]
mod kinetoscope_program;
// Recordings with changes of their structure behind correct checksums.
#[path = "../shared/mutated_recording.rs"]
mod mutated_recording;
// A short experiment of each model and variant, and its trajectory as bits.
mod small_experiments;
// The distance of a sample from the uniform distribution.
mod uniformity;

// Signals, full disks and failing system calls lose no run.
mod faults_lose_no_run;
// An interrupt stops a run also while its start is built.
mod interrupts_stop_a_start;
// A larger sweep keeps keys and bytes of the runs that exist.
mod extended_sweep_keeps_existing_runs;
// Observation does not change the trajectory.
mod observation_does_not_affect_the_trajectory;
// Jobs, threads, folder, user, time zone and build do not change a recording.
mod recording_is_byte_identical;
// The layout of the file does not affect the values in it.
mod recorded_values_are_pinned;
// A run that was killed and resumed gives the bytes of an undisturbed run.
mod resumed_run_is_byte_identical;
// A forged checkpoint with a correct checksum neither panics nor hangs the run.
mod forged_checkpoints_are_rejected;
// The work budget does not change the trajectory.
mod step_budget_does_not_affect_results;

// A rerun of every model and variant verifies its recording.
mod verification_confirms_every_model;
// Verification names the first difference of a changed recording.
mod verification_names_the_first_difference;

// Rounding errors are not taken for different physics, and different physics not for rounding errors.
mod causes_of_differences_are_told_apart;

// Mutated recordings cause no panic.
mod mutated_recordings_are_reported;
// Random manifests with extreme values end with a named outcome.
mod random_manifests_end;

// Random placement is uniform and free of overlaps.
mod random_placement_never_overlaps;
// Random streams keep their numbers across versions and agree with another program.
mod random_streams_are_pinned;

// The manifest accepts exactly the channels that each model records.
mod manifest_accepts_every_channel;
// Viewer layouts name only topics and fields that the recording contains.
mod layouts_name_only_recorded_topics;

// Checks of laws that hold up to the error of a method allow five times its scatter.
mod bounds_follow_from_scatter;
// Scenes whose seeds are compared with their standard errors.
mod scenes_of_seeds;
// Standard errors equal the scatter over seeds.
mod standard_errors_cover_other_seeds;
// Runs that state that they draw no random numbers are the same for every seed.
mod random_numbers_are_drawn_where_stated;

// A large recorded DEM bed stays within its bytes per disc.
mod dem_memory_per_disc_is_bounded;
// `check --locked` finds a flipped sign and names its place.
mod flipped_signs_are_found;
// A new model changes at most four existing files, a metric and an integrator those that ARCHITECTURE.md names.
mod extensions_change_few_files;
// Imports between folders follow the layers, without cycles; files stay below 500 lines.
mod layers;
// Paths named in documents exist; packages, unsafe code and imports stay where they belong.
mod repository_layout;
// Texts for users contain no replaced term and no British spelling.
mod vocabulary;

//! The program as its user sees it: command line, messages, exit codes, files next to a recording, and live viewers.
//!
//! A test belongs here if it starts the program on this machine, under any of its names, and checks what it prints, writes or sends.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

// Recordings rewritten with one change behind correct checksums.
#[path = "../shared/forged_recording.rs"]
mod forged_recording;
#[path = "../shared/kinetoscope_program.rs"]
mod kinetoscope_program;
// A viewer of a run in progress, and the run.
mod live_viewer;
// Clients of the live server that send and read what no viewer does.
mod hostile_client;
// A folder in which `kinetoscope` is called.
mod subcommand_bench;

// `--compare` lists differing keys, versions and the first differing message.
mod comparison_lists_differences;
// `verify` rejects manifests that no machine can execute, and recordings without frames.
mod forged_manifests_are_rejected;
// A live viewer receives the recorded messages and does not delay the run.
mod live_viewers_receive_recorded_messages;
// `run --gnuplot` writes the newest frame for gnuplot and changes no recording.
mod gnuplot_files_show_the_newest_frame;
// A panic or a failed allocation ends with an exit code of the help text.
mod exit_codes_are_documented;
// Columns and units of the state have the form of those of the models.
mod hostile_units_are_damage;
// Hostile clients of the live server neither change nor delay a run, and foreign web pages are rejected.
mod hostile_clients_change_no_run;
// All errors of a manifest are reported at once, each with its line.
mod manifest_errors_point_at_the_line;
// The plan reports runs, steps, memory and size before a run starts.
mod plan_reports_required_resources;
// `--prune` removes recordings that the manifest no longer requests, and nothing else.
mod pruning_removes_only_stale_recordings;
// `simulate` answers requests with recordings and metrics in memory.
mod simulations_in_memory;
// `keep = "metrics"` leaves a table with the bytes of an analysis, whose recordings can be restored.
mod metrics_are_kept_without_recordings;
// `start_from` continues from the last frame of a recording.
mod start_from_continues_a_recording;
// `--time` prints one line per sweep point and writes no recording.
mod timing_writes_no_recording;
// `--why` names the keys that changed since a recording.
mod why_names_the_changed_key;
// One program under three names.
mod names_decide_what_the_program_does;
// Messages name a next command that works.
mod messages_name_the_next_command;
// The program carries its examples, and runs a manifest that is its only argument.
mod examples_are_in_the_program;
// `analyze` prints the answer and the checks in one screen.
mod analysis_answers_in_a_screen;
// Help, misspelled names, closed pipes.
mod arguments;
// Names without a folder.
mod bare_names;
// Other seeds, changed keys and the same run against an earlier analysis.
mod baselines;
// Scenes of all models with changes of their physics.
mod changed_physics;
// The runs of several manifests share the processors.
#[cfg(unix)]
mod experiments_share_processors;
// The scripts of `action/` for CI systems.
#[cfg(unix)]
mod ci_scripts;
// Changed physics against an earlier analysis of another seed.
mod baselines_find_changed_physics;
mod baselines_of_few_particles;
mod baselines_state_their_power;
// `grade` on the solutions and planned errors of the book's exercises, and on hand-ins.
mod exercises_accept_their_solutions;
mod hand_ins;
mod large_class;
// Standard output and standard error on a full disk.
mod full_output;
// `info` on files that are not recordings.
mod hostile_files;
// Control characters in the names of folders.
mod hostile_paths;
// Control characters and commands of CI systems in text of manifests.
mod hostile_text;
// Recordings that keep only keyframes, `fill` and `zoom`.
mod keyframes;
// Keyframes and manifests that do not agree with the rerun.
mod changed_keyframes;
// Analysis, plots and exports of recordings that keep only keyframes.
mod analysis_of_keyframes;
// Experiments that travel in one file, and such files of authors who lie.
mod bundles;
mod hostile_bundles;
// Golden values of runs, and the place of the first difference.
mod lock;
// Several runs in one recording.
mod merged_recordings;
// Output for 60 columns, and inputs that are something else.
mod narrow_terminals;
// Sizes that files and manifests claim, pipes, devices and links, and concurrent starts.
mod oversized_files;
// Several manifests, folders, and manifests that start from manifests.
mod pipelines;
// Plots as SVG and PNG, and what cannot be plotted.
mod plots;
// Plots of the shipped experiments: what they check, and energies that fill their sum.
mod shipped_plots;
// The files of `fill` and `zoom`, and what replaces what.
mod restored_runs;
// Links, pipes, forged files and other processes in the folder of the recordings.
mod shared_folders;
// Large manifests and files next to recordings.
mod side_files;
// Signals while a start is built.
mod signals_end_a_start;
// Every subcommand on a recorded experiment.
mod subcommands;
// The server of recordings for Lichtblick, and who may read.
mod view;

//! The program as its user sees it: command line, messages, exit codes, files next to a recording, and live viewers.
//!
//! A test belongs here if it starts `run-experiment` on this machine and checks what it prints, writes or sends.

// Recordings rewritten with one change behind correct checksums.
#[path = "../shared/forged_recording.rs"]
mod forged_recording;
#[path = "../shared/kinetoscope_program.rs"]
mod kinetoscope_program;
// A viewer of a run in progress, and the run.
mod live_viewer;
// Clients of the live server that send and read what no viewer does.
mod hostile_client;

// An attestation is valid for the verified bytes only.
mod attestation_is_valid_for_one_file;
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
// `start_from` continues from the last frame of a recording.
mod start_from_continues_a_recording;
// `--time` prints one line per sweep point and writes no recording.
mod timing_writes_no_recording;
// `--why` names the keys that changed since a recording.
mod why_names_the_changed_key;
// Messages name a next command that works.
mod messages_name_the_next_command;

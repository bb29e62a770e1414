//! The program as its user sees it: command line, messages, exit codes, files next to a recording, and live viewers.
//!
//! A test belongs here if it starts `run-experiment` on this machine and checks what it prints, writes or sends.

// Recordings rewritten with one change behind correct checksums.
#[path = "../shared/forged_recording.rs"]
mod forged_recording;
// A viewer of a run in progress, and the run.
mod live_viewer;

// An attestation is valid for the verified bytes only.
mod attestation_holds_for_one_file;
// `--compare` lists differing keys, versions and the first differing message.
mod compare_lists_what_differs;
// A live viewer receives what is recorded and never delays the run.
mod live_viewers_see_what_is_recorded;
// All errors of a manifest are reported at once, each with its line.
mod manifest_errors_point_at_the_line;
// The plan reports runs, steps, memory and size before a run starts.
mod plan_says_what_it_takes;
// `--prune` removes recordings that the manifest no longer requests, and nothing else.
mod pruning_removes_only_what_is_stale;
// `start_from` continues from the last frame of a recording.
mod start_from_goes_on;
// `--time` prints one line per sweep point and writes no recording.
mod timing_records_nothing;
// `--why` names the keys that changed since a recording.
mod why_names_the_changed_key;
// Messages name a next command that works.
mod words_lead_on;

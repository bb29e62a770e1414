//! Runs that other machines execute: exported commands, Slurm, HyperQueue, analysis in tasks, and object storage.
//!
//! A test belongs here if it needs an executor other than the local pool, or a store other than a folder. Tests that need
//! daemons are ignored by default; they start and stop their own, on loopback.

// Names and bytes of the recordings in a folder.
mod recordings_in;
// An S3 server on loopback, behind a connection that can be cut or held.
#[cfg(feature = "object-storage")]
mod s3_server;
// A Slurm of one node on loopback.
#[cfg(target_os = "linux")]
mod slurm_cluster;

// Exported commands produce the recordings of the sweep.
mod exported_commands_reproduce_the_sweep;
// Killed tasks, workers and servers of HyperQueue lose no run.
mod hyperqueue_loses_no_run;
// Recordings on object storage equal those of a folder, whichever process is killed.
mod recordings_reach_object_storage;
// Killed, requeued and held tasks of Slurm lose no run.
mod slurm_loses_no_run;
// Tasks whose runs leave rows give the table of one machine.
#[cfg(target_os = "linux")]
mod tasks_of_rows_give_one_table;
// With `--analyze`, each task analyzes the recordings that it made.
mod tasks_analyze_their_recordings;

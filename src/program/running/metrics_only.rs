//! Runs of `keep = "metrics"`: each is executed and analyzed in memory, and what remains is its row in `runs.parquet`.
//!
//! Rows are appended to a journal while the sweep runs. A killed sweep loses the rows since the last sync, at most a second of them, and
//! executes these runs again. At the end, the rows of all runs become the table, in the order of the sweep: its bytes do not
//! depend on how often the sweep was killed or on the number of jobs.

use crate::executor::Executor;
use crate::messages::progress::ProgressDisplay;
use crate::messages::{Failure, bad, exit, plural};
use crate::planning::planner::parallel_runs;
use crate::planning::rows::{keeps_only_metrics, row_of};
use crate::running::experiment::{Executed, Execution};
use crate::running::journal::{BETWEEN_SYNCS, Journal};
use kinetoscope::executor::observer::ExecutionObserver as _;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::outputs::sidecars::write_experiment;
use kinetoscope_analysis::{RunRow, stored_rows, write_runs_table};
use kinetoscope_console::text::{one_line, shown_path};
use kinetoscope_console::{Exit, Message, complain};
use kinetoscope_manifest::{ExpectedOutcome, Experiment, Run, RunKey, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::{fs, thread};

/// Name of the journal in the folder of the experiment.
const JOURNAL: &str = ".runs.journal";
/// Rows that wait for the thread that writes them.
const MOST_WAITING: usize = 1024;
/// Maximum number of failures that are printed.
const MOST_REPORTED: usize = 10;

/// A run without a row, and why.
type Unexecuted = (usize, Message);

/// The run key of a run of the experiment.
fn key_of(run: &Run) -> String {
    let physics_version = kind_of(&run.manifest.model).physics_version;
    run_key(&run.manifest.canonical(), physics_version, SCHEMA_VERSION).as_str().to_owned()
}

impl Execution<'_> {
    /// Whether no recording of the runs is kept.
    pub(crate) fn keeps_only_metrics(&self) -> bool {
        keeps_only_metrics(&self.experiment)
    }

    /// Executes the runs that have no row yet, and writes the table when all have one.
    pub(crate) fn execute_for_metrics(&self) -> Result<Executed, Failure> {
        self.reject_other_places()?;
        let interrupt = self.listen()?;
        let folder = self.arguments.output.folder()?.join(&self.experiment.name);
        let failed = |error: io::Error| {
            let what = format!("{} cannot be written: {error}", shown_path(&folder));
            Failure::new(exit::of_output(&error), what)
                .help("end another program that executes this sweep, or make room; then run the same command again to resume")
        };
        fs::create_dir_all(&folder).map_err(failed)?;
        let keys: Vec<String> = self.experiment.runs.par_iter().map(key_of).collect();
        let (mut journal, found) = Journal::open(&folder.join(JOURNAL)).map_err(failed)?;
        let mut rows = HashMap::new();
        if !self.force {
            let stored = stored_rows(&folder).or_else(|error| {
                if !error.is_of_damage {
                    return Err(Failure::of(Exit::Unreadable, error.message));
                }
                let what = error.message.what;
                complain(&format!("note: {what}; the runs of its rows are executed again"), false);
                Ok(Vec::new())
            })?;
            rows.extend(stored.into_iter().chain(found).map(|row| (row.run_key.clone(), row)));
        }
        self.reject_other_rows(&keys, &rows, &folder)?;
        let to_do: Vec<usize> =
            (0..keys.len()).filter(|run| !rows.contains_key(&keys[*run])).collect();
        self.say(&format!(
            "{}: {}, {}, {} to do, of which the metrics are kept\n  to {}",
            self.experiment.name,
            self.experiment.model(),
            plural(keys.len() as u64, "run"),
            to_do.len(),
            shown_path(&folder)
        ));
        let unexecuted =
            self.execute_all(&to_do, &mut journal, &mut rows, interrupt).map_err(failed)?;
        journal.sync().map_err(failed)?;
        if let Some(code) = interrupt.exit_code() {
            return Ok(self.without_recordings(Exit::Signal(code)));
        }
        if let Some(exit) = self.report_unexecuted(&unexecuted) {
            return Ok(self.without_recordings(exit));
        }
        let rows = self.write_table(&folder, &keys, rows).map_err(failed)?;
        journal.remove().map_err(failed)?;
        let shown = shown_path(&folder);
        self.say(&format!(
            "Wrote {shown}/runs.parquet\nTables of it: kinetoscope table {shown}\nChecks, plots and report: kinetoscope analyze {shown}"
        ));
        Ok(self.without_recordings(self.report_faults(&rows)))
    }

    /// Rejects a folder with rows of runs that the manifest no longer describes, as with another seed: the new table would not have them.
    fn reject_other_rows(
        &self,
        keys: &[String],
        rows: &HashMap<String, RunRow>,
        folder: &Path,
    ) -> Result<(), Failure> {
        let own: HashSet<&String> = keys.iter().collect();
        let others = rows.keys().filter(|key| !own.contains(key)).count();
        if others == 0 || self.arguments.execution.prune {
            return Ok(());
        }
        let (folder, count) = (shown_path(folder), plural(others as u64, "run"));
        let what =
            format!("{folder} has the metrics of {count} that the manifest does not describe");
        Err(bad(what).help("name another folder with --output, or drop these rows with --prune"))
    }

    /// Rejects what needs recordings or other machines.
    fn reject_other_places(&self) -> Result<(), Failure> {
        let arguments = self.arguments;
        let options = [
            (arguments.output.is_remote(), "an address of object storage"),
            (arguments.executor.executor != Executor::Local, "--executor"),
            (arguments.executor.export_commands.is_some(), "--export-commands"),
            (arguments.executor.only_keys.is_some(), "--only-keys"),
            (arguments.executor.analyze, "--analyze"),
            (arguments.live.is_requested(), "a live view"),
        ];
        match options.iter().find(|(is_given, _)| *is_given) {
            Some((_, option)) => {
                let what = format!("{option} cannot be used with `keep = \"metrics\"`");
                Err(bad(what).help("execute the sweep on this machine, or keep its recordings"))
            }
            None => Ok(()),
        }
    }

    /// Executes runs in parallel and adds their rows to the journal; returns those that have none.
    fn execute_all(
        &self,
        to_do: &[usize],
        journal: &mut Journal,
        rows: &mut HashMap<String, RunRow>,
        interrupt: &Interrupt,
    ) -> io::Result<Vec<Unexecuted>> {
        let progress = ProgressDisplay::new(to_do.len(), self.arguments.verbosity());
        let next = AtomicUsize::new(0);
        let (mut unexecuted, mut done) = (Vec::new(), 0);
        let written = thread::scope(|scope| {
            let (sender, receiver) = sync_channel(MOST_WAITING);
            for _ in 0..parallel_runs(self.arguments.execution.jobs, to_do.len()) {
                let (sender, next, runs) = (sender.clone(), &next, &self.experiment.runs);
                let work = move || {
                    while let Some(run) = to_do.get(next.fetch_add(1, Ordering::Relaxed)) {
                        let row = row_of(&runs[*run], interrupt);
                        let Some(row) = row.transpose() else { break };
                        if sender.send((*run, row)).is_err() {
                            break;
                        }
                    }
                };
                // One thread per run: the results do not depend on it.
                scope.spawn(|| {
                    let pool = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
                    match pool {
                        Ok(pool) => pool.install(work),
                        Err(_) => work(),
                    }
                });
            }
            drop(sender);
            loop {
                let (run, row) = match receiver.recv_timeout(BETWEEN_SYNCS) {
                    Ok(received) => received,
                    Err(RecvTimeoutError::Timeout) => {
                        journal.sync()?;
                        continue;
                    }
                    Err(RecvTimeoutError::Disconnected) => return Ok(()),
                };
                match row {
                    Ok(row) => {
                        journal.append(&row)?;
                        rows.insert(row.run_key.clone(), row);
                    }
                    Err(why) => unexecuted.push((run, why)),
                }
                done += 1;
                progress.show_remote(done, "");
            }
        });
        progress.close();
        written.map(|()| unexecuted)
    }

    /// Writes the rows of all runs in the order of the sweep, and the experiment as executed; returns the rows.
    fn write_table(
        &self,
        folder: &Path,
        keys: &[String],
        mut rows: HashMap<String, RunRow>,
    ) -> io::Result<Vec<RunRow>> {
        let Experiment { runs, name, replicates, .. } = &*self.experiment;
        let (mut files, mut placed) = (Vec::new(), Vec::<RunRow>::new());
        for (run, key) in runs.iter().zip(keys) {
            // Variants of another name may be the same run.
            let copy = || placed.iter().find(|row| row.run_key == *key).cloned();
            let found = rows.remove(key).or_else(copy);
            let (Some(mut row), Some(key)) = (found, RunKey::from_hex(key)) else { continue };
            row.coordinates = run.coordinates.to_vec();
            (row.replicate, row.seed) = (run.replicate, run.manifest.seed);
            row.file = format!("{}.mcap", run.file_stem(name, &key, *replicates));
            files.push((row.file.clone(), key));
            placed.push(row);
        }
        let manifest = |row: usize| runs[row].manifest.canonical();
        write_runs_table(folder, name, &placed, &manifest)?;
        write_experiment(&self.experiment, folder, files)?;
        Ok(placed)
    }

    /// Prints why runs have no row; `None` if all have one.
    fn report_unexecuted(&self, unexecuted: &[Unexecuted]) -> Option<Exit> {
        let exit = Exit::RunFailed;
        for (run, why) in unexecuted.iter().take(MOST_REPORTED) {
            let message = why.clone().about(self.name_of(*run));
            Failure::of(exit, message).report();
        }
        (!unexecuted.is_empty()).then(|| {
            let failed = plural(unexecuted.len() as u64, "run");
            Failure::new(exit, format!("{failed} could not be executed, so there is no table"))
                .report()
        })
    }

    /// Prints which runs have ended otherwise than the manifest expects.
    fn report_faults(&self, rows: &[RunRow]) -> Exit {
        let expects_fault = self.experiment.expected_outcome == ExpectedOutcome::Fault;
        let is_other = |run: &usize| rows[*run].fault().is_some() != expects_fault;
        let others: Vec<usize> = (0..rows.len()).filter(is_other).collect();
        for run in others.iter().take(MOST_REPORTED) {
            let fault = rows[*run].fault();
            let what = fault.map_or(
                "the run is complete, but its manifest expects a fault".to_owned(),
                |fault| format!("failed: {}", one_line(fault)),
            );
            let help = "`kinetoscope restore` writes its recording";
            Failure::of(Exit::RunFailed, Message::new(what, help).about(self.name_of(*run)))
                .report();
        }
        if others.is_empty() {
            return Exit::Done;
        }
        let what = format!(
            "{} of {} ended otherwise than expected",
            others.len(),
            plural(rows.len() as u64, "run")
        );
        Failure::new(Exit::RunFailed, what).report()
    }

    fn name_of(&self, run: usize) -> String {
        let run = &self.experiment.runs[run];
        let place = run.coordinates.iter().map(|it| format!("{} = {}", it.key, it.value));
        let parts: Vec<String> = place.chain([format!("replicate {}", run.replicate)]).collect();
        one_line(&parts.join(", ")).into_owned()
    }

    fn without_recordings(&self, exit: Exit) -> Executed {
        Executed {
            exit,
            name: self.experiment.name.clone(),
            destination: None,
            is_remote: false,
            keyframes: Vec::new(),
            json: None,
        }
    }
}

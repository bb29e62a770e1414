//! Runs of `keep = "metrics"`: each is executed and analyzed in memory, and what remains is its row in `runs.parquet`.
//!
//! Rows are appended to a journal while the sweep runs. A killed sweep loses the rows since the last sync, at most a second of them, and
//! executes these runs again. At the end, the rows of all runs become the table, in the order of the sweep: its bytes do not
//! depend on how often the sweep was killed or on the number of jobs.

use crate::messages::progress::ProgressDisplay;
use crate::messages::{Failure, bad, exit, plural};
use crate::planning::planner::{Planner, parallel_runs};
use crate::planning::rows::{row_of, seconds_per_run};
use crate::running::experiment::{Executed, Execution};
use crate::running::journal::{BETWEEN_SYNCS, Journal};
use crate::running::shards::{JOURNAL, ReadShards, Shards, remove_shards, take_shards};
use crate::running::sweep_rows::Rows;
use kinetoscope::executor::cluster::queue::DEFAULT_TASKS;
use kinetoscope::executor::observer::ExecutionObserver as _;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::outputs::sidecars::{write_experiment, write_experiment_without_runs};
use kinetoscope_analysis::{each_stored_outcome, each_stored_row, write_runs_table};
use kinetoscope_console::text::{one_line, shown_path};
use kinetoscope_console::{Exit, Message, complain};
use kinetoscope_manifest::{ExpectedOutcome, Experiment, Run, RunKey};
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use serde_json::json;
use std::collections::{HashMap, HashSet};
use std::io;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::{fs, thread};

/// Rows that wait for the thread that writes them.
const MOST_WAITING: usize = 1024;
/// Maximum number of failures that are printed.
const MOST_REPORTED: usize = 10;

/// A run without a row, and why.
type Unexecuted = (usize, Message);

/// Time of a task of a cluster that keeps metrics, seconds: its start takes some seconds.
const TASK_S: f64 = 120.0;

/// Number of runs up to which `experiment.toml` lists them.
const MOST_LISTED: usize = 100_000;

/// What the table of an earlier execution contains.
#[derive(Default)]
struct EarlierTable {
    /// Whether its rows are those of the experiment, in its order.
    is_whole: bool,
    /// The keys of its rows of other runs.
    others: HashSet<String>,
    /// The failed runs, with the reason.
    faults: Vec<(usize, String)>,
}

impl Execution<'_> {
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
        let mut rows = Rows::of(&self.experiment.runs);
        let mut others = HashSet::new();
        let journal =
            Journal::open(&folder.join(JOURNAL), |row, place| match rows.find_text(&row.run_key) {
                _ if self.force => {}
                Some(run) => rows.places[run] = place,
                None => {
                    others.insert(row.run_key.clone());
                }
            });
        let of_journal =
            |error: io::Error| failed(io::Error::new(error.kind(), format!("{JOURNAL}: {error}")));
        let mut journal = journal.map_err(of_journal)?;
        let earlier =
            if self.force { EarlierTable::default() } else { self.earlier(&folder, &rows)? };
        others.extend(earlier.others);
        if self.force {
            remove_shards(&folder).map_err(failed)?;
        } else {
            let read = &mut ReadShards::new();
            take_shards(&folder, &mut rows, &mut journal, &mut others, read).map_err(failed)?;
        }
        self.reject_other_rows(others.len(), &folder)?;
        if earlier.is_whole {
            self.say_runs(0, &folder);
            self.write_record(&folder, &rows).map_err(failed)?;
            journal.remove().map_err(failed)?;
            remove_shards(&folder).map_err(failed)?;
            return Ok(self.with_table(&folder, &earlier.faults));
        }
        if !self.force {
            self.take_rows(&folder, &mut rows, &mut journal).map_err(failed)?;
        }
        if self.is_elsewhere() && !rows.to_do().is_empty() {
            let executed = self.execute_rows_elsewhere(&folder, &mut rows, &mut journal)?;
            if executed.exit != Exit::Done || !rows.to_do().is_empty() {
                return Ok(executed);
            }
        }
        let to_do = rows.to_do();
        self.say_runs(to_do.len(), &folder);
        let unexecuted =
            self.execute_all(&to_do, &mut journal, &mut rows, interrupt).map_err(failed)?;
        journal.sync().map_err(failed)?;
        if let Some(code) = interrupt.exit_code() {
            return Ok(self.without_recordings(Exit::Signal(code)));
        }
        if let Some(exit) = self.report_unexecuted(&unexecuted) {
            return Ok(self.without_recordings(exit));
        }
        let faults = self.write_table(&folder, &rows, &journal).map_err(failed)?;
        journal.remove().map_err(failed)?;
        remove_shards(&folder).map_err(failed)?;
        Ok(self.with_table(&folder, &faults))
    }

    /// Exports the runs without a row as commands, or executes them on a cluster.
    fn execute_rows_elsewhere(
        &self,
        folder: &Path,
        rows: &mut Rows,
        journal: &mut Journal,
    ) -> Result<Executed, Failure> {
        if self.force {
            return Err(bad(
                "--force is not supported on a cluster, whose tasks skip finished runs",
            )
            .help("remove the folder to execute all runs again"));
        }
        let interrupt = self.listen()?;
        let planner = Planner { is_outline: true, ..self.arguments.planner(interrupt) };
        let mut planned = planner.plan(&self.experiment)?;
        planned.reject_invalid_starts(&self.experiment)?;
        let to_do: HashSet<RunKey> = rows.to_do().into_iter().map(|run| rows.keys[run]).collect();
        planned.plan.runs.retain(|run| to_do.contains(&run.run_key));
        self.say_runs(to_do.len(), folder);
        let rows_per_task = Some(self.rows_per_task(to_do.len(), interrupt));
        if let Some(file) = &self.arguments.executor.export_commands {
            self.export(file, &planned.plan, rows_per_task)?;
            self.say("When these commands have been executed, on any machines, the same command without --export-commands writes the table");
            return Ok(self.without_recordings(Exit::Done));
        }
        let Some(engine) = self.arguments.executor.executor.engine() else {
            return Ok(self.without_recordings(Exit::Done));
        };
        let mut stored = Shards { folder, rows, journal, read: ReadShards::new() };
        self.execute_on_cluster(engine, &planned, &mut stored, rows_per_task)
    }

    /// Default number of runs per task: those of some minutes, or more if there would be more than the usual number of tasks.
    fn rows_per_task(&self, runs: usize, interrupt: &Interrupt) -> usize {
        let usual = runs.div_ceil(DEFAULT_TASKS);
        let is_needed = self.arguments.executor.runs_per_task.is_none();
        let seconds =
            is_needed.then(|| seconds_per_run(&self.experiment.runs, interrupt)).flatten();
        seconds.map_or(usual, |seconds| usual.max((TASK_S / seconds) as usize))
    }

    fn say_runs(&self, to_do: usize, folder: &Path) {
        self.say(&format!(
            "{}: {}, {}, {to_do} to do, of which the metrics are kept\n  to {}",
            self.experiment.name,
            self.experiment.model(),
            plural(self.experiment.runs.len() as u64, "run"),
            shown_path(folder)
        ));
    }

    /// States where the table is, and which runs ended otherwise than expected.
    fn with_table(&self, folder: &Path, faults: &[(usize, String)]) -> Executed {
        let shown = shown_path(folder);
        let next = match self.experiment.runs.len() <= MOST_LISTED {
            true => format!("\nChecks, plots and report: kinetoscope analyze {shown}"),
            false => String::new(),
        };
        self.say(&format!(
            "Wrote {shown}/runs.parquet\nTables of it: kinetoscope table {shown}{next}"
        ));
        let executed = self.without_recordings(self.report_faults(faults));
        let json = self.arguments.messages.json.then(|| {
            json!({
                "manifest": self.manifest,
                "experiment": self.experiment.name,
                "model": self.experiment.model(),
                "destination": folder,
                "exit_code": executed.exit.code(),
                "runs": [],
                "table": folder.join("runs.parquet"),
            })
        });
        Executed { json, ..executed }
    }

    /// The table that an earlier execution has written; a damaged one counts as none, with a note.
    fn earlier(&self, folder: &Path, rows: &Rows) -> Result<EarlierTable, Failure> {
        let Experiment { runs, name, replicates, .. } = &*self.experiment;
        let (mut found, mut next) = (EarlierTable { is_whole: true, ..EarlierTable::default() }, 0);
        let read = each_stored_outcome(folder, |row| {
            let is_next = runs.get(next).zip(rows.keys.get(next)).is_some_and(|(run, key)| {
                // A name without coordinates does not identify them.
                let stem = run.file_stem(name, key, *replicates);
                let is_complete = run.coordinates.is_empty() || !stem.ends_with(key.as_str());
                is_complete && key.as_str() == row.run_key && row.file == format!("{stem}.mcap")
            });
            found.is_whole &= is_next;
            found.faults.extend(row.fault.map(|fault| (next, fault)));
            next += 1;
            if rows.find_text(&row.run_key).is_none() {
                found.others.insert(row.run_key);
            }
        });
        found.is_whole &= next == runs.len();
        match read {
            Ok(()) => Ok(found),
            Err(error) if error.is_of_damage => {
                let what = error.message.what;
                complain(&format!("note: {what}; the runs of its rows are executed again"), false);
                Ok(EarlierTable::default())
            }
            Err(error) => Err(Failure::of(Exit::Unreadable, error.message)),
        }
    }

    /// Takes the rows of an earlier table that the runs need.
    fn take_rows(&self, folder: &Path, rows: &mut Rows, journal: &mut Journal) -> io::Result<()> {
        let mut written = Ok(());
        // A table that cannot be read was reported before.
        let _ = each_stored_row(folder, |row| {
            let run = rows.find_text(&row.run_key).filter(|run| rows.places[*run] == 0);
            if let (Some(run), Ok(())) = (run, &written) {
                written = journal.append(&row).map(|place| rows.places[run] = place);
            }
        });
        written
    }

    /// Rejects a folder with rows of runs that the manifest no longer describes, as with another seed: the new table would not have them.
    fn reject_other_rows(&self, others: usize, folder: &Path) -> Result<(), Failure> {
        if others == 0 || self.arguments.execution.prune {
            return Ok(());
        }
        let (folder, count) = (shown_path(folder), plural(others as u64, "run"));
        let what =
            format!("{folder} has the metrics of {count} that the manifest does not describe");
        Err(bad(what).help("name another folder with --output, or drop these rows with --prune"))
    }

    /// Rejects what needs recordings.
    fn reject_other_places(&self) -> Result<(), Failure> {
        let arguments = self.arguments;
        let options = [
            (arguments.output.is_remote(), "an address of object storage"),
            (arguments.executor.analyze, "--analyze"),
            (arguments.live.is_requested(), "a live view"),
        ];
        match options.iter().find(|(is_given, _)| *is_given) {
            Some((_, option)) => {
                let what = format!("{option} cannot be used with `keep = \"metrics\"`");
                Err(bad(what).help("leave it out, or keep the recordings"))
            }
            None => Ok(()),
        }
    }

    /// Executes runs in parallel and adds their rows to the journal; returns those that have none.
    pub(crate) fn execute_all(
        &self,
        to_do: &[usize],
        journal: &mut Journal,
        rows: &mut Rows,
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
                    Ok(row) => rows.places[run] = journal.append(&row)?,
                    Err(why) => unexecuted.push((run, why)),
                }
                done += 1;
                progress.show_remote(done, "");
            }
        });
        progress.close();
        written.map(|()| unexecuted)
    }

    /// Writes the rows of all runs in the order of the sweep, and the experiment as executed; returns the failed runs.
    fn write_table(
        &self,
        folder: &Path,
        rows: &Rows,
        journal: &Journal,
    ) -> io::Result<Vec<(usize, String)>> {
        let Experiment { runs, name, replicates, .. } = &*self.experiment;
        let (mut faults, mut seen) = (Vec::new(), 0);
        let mut read = |range: Range<usize>| {
            let mut found = journal.rows_at(range.clone().map(|run| rows.place(run)))?;
            range.clone().into_par_iter().zip(&mut found).for_each(|(run, row)| {
                let (planned, key) = (&runs[run], &rows.keys[run]);
                row.coordinates = planned.coordinates.to_vec();
                (row.replicate, row.seed) = (planned.replicate, planned.manifest.seed);
                row.file = format!("{}.mcap", planned.file_stem(name, key, *replicates));
            });
            for (run, row) in range.clone().zip(&found).filter(|(run, _)| *run >= seen) {
                faults.extend(row.fault().map(|fault| (run, fault.to_owned())));
            }
            seen = seen.max(range.end);
            Ok(found)
        };
        let manifest = |row: usize| runs[row].manifest.canonical();
        write_runs_table(folder, name, runs.len(), &mut read, &manifest)?;
        self.write_record(folder, rows)?;
        Ok(faults)
    }

    /// Writes the experiment as executed.
    fn write_record(&self, folder: &Path, rows: &Rows) -> io::Result<()> {
        let Experiment { runs, name, replicates, .. } = &*self.experiment;
        if runs.len() > MOST_LISTED {
            return write_experiment_without_runs(&self.experiment, folder);
        }
        let file =
            |(run, key): (&Run, &RunKey)| format!("{}.mcap", run.file_stem(name, key, *replicates));
        let files = runs.iter().zip(&rows.keys).map(|it| (file(it), *it.1));
        write_experiment(&self.experiment, folder, files)
    }

    /// Prints why runs have no row; `None` if all have one.
    pub(crate) fn report_unexecuted(&self, unexecuted: &[Unexecuted]) -> Option<Exit> {
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
    fn report_faults(&self, faults: &[(usize, String)]) -> Exit {
        let runs = self.experiment.runs.len();
        let is_expected = self.experiment.expected_outcome == ExpectedOutcome::Fault;
        let failed: HashMap<usize, &String> = faults.iter().map(|(run, why)| (*run, why)).collect();
        let is_other = |run: &usize| failed.contains_key(run) != is_expected;
        let others = (0..runs).filter(is_other).count();
        for run in (0..runs).filter(is_other).take(MOST_REPORTED) {
            let what = failed.get(&run).map_or(
                "the run is complete, but its manifest expects a fault".to_owned(),
                |fault| format!("failed: {}", one_line(fault)),
            );
            let help = "`kinetoscope restore` writes its recording";
            Failure::of(Exit::RunFailed, Message::new(what, help).about(self.name_of(run)))
                .report();
        }
        if others == 0 {
            return Exit::Done;
        }
        let runs = plural(runs as u64, "run");
        let what = format!("{others} of {runs} ended otherwise than expected");
        Failure::new(Exit::RunFailed, what).report()
    }

    fn name_of(&self, run: usize) -> String {
        let run = &self.experiment.runs[run];
        let place = run.coordinates.iter().map(|it| format!("{} = {}", it.key, it.value));
        let parts: Vec<String> = place.chain([format!("replicate {}", run.replicate)]).collect();
        one_line(&parts.join(", ")).into_owned()
    }

    /// The name of a run's files, without their ending.
    pub(crate) fn stem_of(&self, run: usize, rows: &Rows) -> String {
        let Experiment { runs, name, replicates, .. } = &*self.experiment;
        runs[run].file_stem(name, &rows.keys[run], *replicates)
    }

    pub(crate) fn without_recordings(&self, exit: Exit) -> Executed {
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

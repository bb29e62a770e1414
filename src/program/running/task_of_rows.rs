//! A task of a cluster whose runs leave rows.

use crate::messages::{Failure, complain, exit};
use crate::running::experiment::{Executed, Execution};
use crate::running::journal::Journal;
use crate::running::shards::{each_key_in, shard_of};
use crate::running::sweep_rows::Rows;
use kinetoscope::outputs::sidecars;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use std::{fs, io};

impl Execution<'_> {
    /// Executes the runs that the task names, as far as they have no row, and appends their rows to its shard.
    pub(crate) fn execute_task_of_rows(&self) -> Result<Executed, Failure> {
        let interrupt = self.listen()?;
        let folder = self.arguments.output.folder()?.join(&self.experiment.name);
        let failed = |error: io::Error| {
            let exit = match error.kind() {
                io::ErrorKind::WouldBlock => Exit::Retryable,
                _ => exit::of_output(&error),
            };
            let what = format!("{} cannot be written: {error}", shown_path(&folder));
            Failure::new(exit, what)
                .help("make room, or end another program that executes this task; then run the same command again")
        };
        let mut rows = Rows::of(&self.experiment.runs);
        let keys = self.arguments.executor.only_keys.as_deref().unwrap_or_default();
        let named = rows.named(keys)?;
        fs::create_dir_all(&folder).map_err(failed)?;
        each_key_in(&folder, |key| {
            if let Some(run) = rows.find_text(key) {
                rows.places[run] = 1;
            }
        });
        let to_do: Vec<usize> =
            rows.to_do().into_iter().filter(|run| named.contains(run)).collect();
        if to_do.is_empty() {
            return Ok(self.without_recordings(Exit::Done));
        }
        let mut shard = Journal::open(&shard_of(&folder, keys), |_, _| {}).map_err(failed)?;
        let unexecuted =
            self.execute_all(&to_do, &mut shard, &mut rows, interrupt).map_err(failed)?;
        shard.sync().map_err(failed)?;
        if let Some(code) = interrupt.exit_code() {
            return Ok(self.without_recordings(Exit::Signal(code)));
        }
        for (run, message) in &unexecuted {
            let stem = self.stem_of(*run, &rows);
            let failure = sidecars::Failure { is_retryable: false, message: message.clone() };
            if let Err(error) = sidecars::write_failure(&folder, &stem, &failure) {
                complain(&format!(
                    "warning: the failure of {stem} could not be written down: {error}"
                ));
            }
        }
        let exit = self.report_unexecuted(&unexecuted).unwrap_or(Exit::Done);
        Ok(self.without_recordings(exit))
    }
}

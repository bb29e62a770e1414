//! HyperQueue through its command `hq`: one job per submission, and one line of run keys per task.
//!
//! Its exit codes are ignored, because they are 0 for jobs that failed or do not exist. The state of a finished task is ignored,
//! because it may run again after a restart of the server. Waiting and running tasks are kept; for all others, the recordings
//! decide. `hq` finds the server by `HQ_SERVER_DIR`, or in the user's home folder.

use crate::executor::cluster::active_tasks::ActiveTasks;
use crate::executor::cluster::engine_command::output_of;
use crate::executor::cluster::submission::{self, JOB_NAME, Resources};
use crate::executor::cluster::task::{Task, TaskCommand};
use serde_json::Value;
use std::io;
use std::path::Path;
use std::process::Command;

/// HyperQueue has no limit; it lists this number of tasks within a second.
pub(super) const MOST_TASKS: usize = 10_000;

/// As [`super::scheduler::Engine::live`].
pub(super) fn live(folder: &Path) -> io::Result<ActiveTasks> {
    let mut live = ActiveTasks::default();
    for job in all(&ask(&["job", "list"])?) {
        let name = job["name"].as_str().and_then(|name| name.strip_prefix(JOB_NAME));
        let (Some(name), Some(id)) = (name, job["id"].as_u64()) else { continue };
        // Jobs of other folders have no file of keys in this folder.
        let lines = submission::key_lines(folder, name);
        if lines.is_empty() {
            continue;
        }
        let described = ask(&["job", "info", &id.to_string()])?;
        for task in all(&described).flat_map(|job| all(&job["tasks"])) {
            let index = task["id"].as_u64().and_then(|index| usize::try_from(index).ok());
            let keys = index.and_then(|index| lines.get(index));
            match (task["state"].as_str(), keys) {
                (Some("running"), Some(keys)) => live.add(keys, true),
                (Some("waiting"), Some(keys)) => live.add(keys, false),
                _ => {}
            }
        }
    }
    Ok(live)
}

/// As [`super::scheduler::Engine::submit`]. Memory is not requested, because not every worker offers it as a resource.
pub(super) fn submit(
    folder: &Path,
    tasks: &[Task<'_>],
    command: &TaskCommand,
    resources: Resources,
) -> io::Result<()> {
    let submission = submission::write(folder, tasks, command, "HQ_TASK_ID")?;
    let log = submission.own_folder.join("%{TASK_ID}.log");
    let mut hq = Command::new("hq");
    hq.args(["--output-mode", "json", "submit", "--crash-limit", "unlimited"])
        .arg(format!("--name={JOB_NAME}{}", submission.name))
        .arg(format!("--array=0-{}", tasks.len() - 1))
        .arg(format!("--cpus={}", resources.processors))
        .arg("--cwd")
        .arg(&submission.own_folder)
        .arg("--stdout")
        .arg(&log)
        .arg("--stderr")
        .arg(&log);
    if let Some(minutes) = resources.time_limit_min {
        hq.arg(format!("--time-limit={minutes}min"));
    }
    output_of(hq.args(["--", "sh"]).arg(&submission.script)).map(drop)
}

/// Runs `hq` and decodes its output. Its JSON is documented as unstable; therefore, unexpected values count as missing.
fn ask(arguments: &[&str]) -> io::Result<Value> {
    let text = output_of(Command::new("hq").args(["--output-mode", "json"]).args(arguments))?;
    serde_json::from_str(&text).map_err(|error| io::Error::other(format!("hq: {error}")))
}

/// The elements of a list; any other value counts as the only element.
fn all(value: &Value) -> impl Iterator<Item = &Value> {
    match value {
        Value::Array(elements) => elements.iter(),
        other => std::slice::from_ref(other).iter(),
    }
}

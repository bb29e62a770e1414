//! The output of `squeue`: tasks that run, tasks that wait, and tasks that Slurm does not start until a person acts.
//!
//! Slurm marks a held task by the priority 0 (`_job_runnable_test1` in its `job_scheduler.c`). Reasons are a hold by its user or
//! an operator, a failed prolog or launch, too many requeues, and a deleted reservation. Other tasks have a priority but never
//! start, because they request more than a single task may have. All other tasks start later: nodes are full or drained, or the
//! user's limit is reached.
//!
//! The program does not release held tasks: Slurm holds a task that failed on a broken node, so that it does not fail repeatedly.

use std::collections::BTreeSet;

/// The states of running and waiting tasks. `PENDING` does not include tasks that wait in a state of their own, such as
/// `REQUEUE_HOLD`.
pub(super) const STATES: &str = "PENDING,RUNNING,CONFIGURING,COMPLETING,SUSPENDED,REQUEUED,STOPPED,SIGNALING,\
    REQUEUE_HOLD,RESV_DEL_HOLD,SPECIAL_EXIT";
/// Name, index, state, priority, job and reason. The reason is the last field because it is free text.
pub(super) const FORMAT: &str = "%j|%K|%T|%Q|%F|%r";

/// States of a task that has not been started. A suspended task has the priority 0 as well.
const NOT_STARTED: [&str; 4] = ["PENDING", "REQUEUE_HOLD", "RESV_DEL_HOLD", "SPECIAL_EXIT"];
/// Reasons for which a task of any priority is never started, in addition to every limit "PerJob".
const NEVER: [&str; 7] = [
    "AccountNotAllowed",
    "DependencyNeverSatisfied",
    "InvalidAccount",
    "InvalidQOS",
    "PartitionConfig",
    "PartitionTimeLimit",
    "QOSNotAllowed",
];

/// A task in the queue.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct QueuedTask<'a> {
    /// The name of its job array.
    pub(super) name: &'a str,
    /// Its index there.
    pub(super) index: usize,
    /// The number of its job array.
    pub(super) job: &'a str,
    pub(super) state: TaskState<'a>,
}

/// State of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TaskState<'a> {
    Runs,
    Waits,
    /// Does not start until a person acts, for the reason reported by Slurm.
    Held(HoldReason, &'a str),
}

/// Why a task does not start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HoldReason {
    /// The task is held and can be released.
    Held,
    /// The task requests more than is allowed.
    Rejected,
}

/// Parses the output of `squeue` in [`FORMAT`]; lines of other jobs are skipped.
pub(super) fn tasks(queue: &str) -> impl Iterator<Item = QueuedTask<'_>> {
    queue.lines().filter_map(|line| {
        let mut parts = line.splitn(6, '|');
        let (name, index, state) = (parts.next()?, parts.next()?.parse().ok()?, parts.next()?);
        let (priority, job, reason) = (parts.next()?, parts.next()?, parts.next()?);
        Some(QueuedTask { name, index, job, state: task_state(state, priority, reason) })
    })
}

fn task_state<'a>(state: &str, priority: &str, reason: &'a str) -> TaskState<'a> {
    if state == "RUNNING" {
        TaskState::Runs
    } else if !NOT_STARTED.contains(&state) {
        TaskState::Waits
    } else if priority == "0" {
        TaskState::Held(HoldReason::Held, reason)
    } else if NEVER.contains(&reason) || reason.contains("PerJob") {
        TaskState::Held(HoldReason::Rejected, reason)
    } else {
        TaskState::Waits
    }
}

/// Formats the number of tasks that Slurm does not start, its reasons, and the remedy; empty if there are none.
pub(super) fn hold_reasons(tasks: &[QueuedTask<'_>]) -> String {
    let sentences = [HoldReason::Held, HoldReason::Rejected].map(|kind| kind.sentence(tasks));
    sentences.into_iter().flatten().collect::<Vec<_>>().join("\n")
}

impl HoldReason {
    fn sentence(self, tasks: &[QueuedTask<'_>]) -> Option<String> {
        let held = tasks.iter().filter_map(|task| match task.state {
            TaskState::Held(kind, reason) if kind == self => Some((reason, task.job)),
            _ => None,
        });
        let (reasons, jobs): (Vec<&str>, Vec<&str>) = held.unzip();
        let number = match reasons.len() {
            0 => return None,
            1 => "1 task".to_owned(),
            tasks => format!("{tasks} tasks"),
        };
        let (reasons, jobs) = (listed(reasons, ", "), listed(jobs, " "));
        Some(match self {
            Self::Held => format!(
                "Slurm holds back {number} ({reasons}). `scontrol release {jobs}` lets them start; where Slurm denies \
                 that, an operator has to"
            ),
            Self::Rejected => format!(
                "Slurm will not start {number} as submitted ({reasons}). Stop this command, type `scancel --state=PENDING {jobs}`, \
                 and start it again with a shorter --time-limit or another SBATCH_PARTITION, SBATCH_ACCOUNT or SBATCH_QOS"
            ),
        })
    }
}

/// The distinct words in alphabetical order.
fn listed(words: Vec<&str>, between: &str) -> String {
    BTreeSet::from_iter(words).into_iter().collect::<Vec<_>>().join(between)
}

#[cfg(test)]
mod tests {
    use super::{HoldReason, NOT_STARTED, QueuedTask, STATES, TaskState, hold_reasons, tasks};

    /// Lines as Slurm 22.05 prints them in `FORMAT`: a job array of which one task runs, one waits, one is suspended, one was held by root;
    /// a prolog that failed; `scontrol requeuehold`, with and without `State=SpecialExit`; `sbatch --hold`; a partition of ten
    /// minutes and `--time=20`; more processors than the node has; a dependency on a task that was canceled.
    const QUEUE: &str = "\
        kinetoscope-a|0|RUNNING|4294901759|1|None\n\
        kinetoscope-a|2|PENDING|4294901759|1|Resources\n\
        kinetoscope-a|5|SUSPENDED|0|1|None\n\
        kinetoscope-a|3|PENDING|0|1|JobHeldAdmin\n\
        kinetoscope-z|1|PENDING|0|15|launch failed requeued held\n\
        kinetoscope-a|4|PENDING|0|1|job requeued in held state\n\
        kinetoscope-a|1|SPECIAL_EXIT|0|1|job requeued in held state\n\
        kinetoscope-b|0|PENDING|0|6|JobHeldUser\n\
        kinetoscope-c|0|PENDING|4294901758|7|PartitionTimeLimit\n\
        kinetoscope-f|1|PENDING|4294901756|10|PartitionConfig\n\
        kinetoscope-g|0|PENDING|4294901755|11|DependencyNeverSatisfied\n";

    /// As above: reasons that pass by themselves. A drained and a down node say the same; `--begin`; a partition that is down.
    const LATER: &str = "\
        kinetoscope-z|0|PENDING|4294901744|15|Nodes required for job are DOWN, DRAINED or reserved for jobs in higher priority partitions\n\
        kinetoscope-g|0|PENDING|4294901755|11|Dependency\n\
        kinetoscope-h|0|PENDING|4294901754|12|BeginTime\n\
        kinetoscope-z|1|PENDING|4294901742|17|PartitionDown\n";

    #[test]
    fn tasks_that_slurm_will_not_start_are_told_from_those_that_wait() {
        let states: Vec<TaskState<'_>> = tasks(QUEUE).map(|task| task.state).collect();
        let held = |reason| TaskState::Held(HoldReason::Held, reason);
        let refused = |reason| TaskState::Held(HoldReason::Rejected, reason);
        assert_eq!(
            states,
            [
                TaskState::Runs,
                TaskState::Waits,
                TaskState::Waits,
                held("JobHeldAdmin"),
                held("launch failed requeued held"),
                held("job requeued in held state"),
                held("job requeued in held state"),
                held("JobHeldUser"),
                refused("PartitionTimeLimit"),
                refused("PartitionConfig"),
                refused("DependencyNeverSatisfied"),
            ]
        );
        assert_eq!(tasks(LATER).count(), 4);
        assert!(tasks(LATER).all(|task| task.state == TaskState::Waits));
        // Limits of accounting: `job_reason_string` in Slurm's slurm_protocol_defs.c. Of one task, and of a user's tasks in all.
        let limits = "n|0|PENDING|9|1|AssocMaxWallDurationPerJobLimit\nn|1|PENDING|9|1|QOSMaxCpuPerUserLimit";
        let states: Vec<TaskState<'_>> = tasks(limits).map(|task| task.state).collect();
        assert_eq!(states, [refused("AssocMaxWallDurationPerJobLimit"), TaskState::Waits]);
    }

    /// Else such a task would count as lost, and be submitted a second time.
    #[test]
    fn every_state_of_a_task_to_come_is_asked_for() {
        let asked: Vec<&str> = STATES.split(',').collect();
        assert!(NOT_STARTED.iter().all(|state| asked.contains(state)), "{asked:?}");
    }

    #[test]
    fn a_line_is_a_task_and_its_reason_may_hold_bars() {
        let task = tasks("kinetoscope-a|12|PENDING|0|7|held | by hand").next().unwrap();
        let state = TaskState::Held(HoldReason::Held, "held | by hand");
        assert_eq!(task, QueuedTask { name: "kinetoscope-a", index: 12, job: "7", state });
        // A job that is no array has no index, and a name may hold anything.
        assert_eq!(tasks("other|N/A|PENDING|9|7|None\na|b|c|0|PENDING|9|7|None\n\n").count(), 0);
    }

    #[test]
    fn what_is_said_names_numbers_reasons_and_commands() {
        let all: Vec<QueuedTask<'_>> = tasks(QUEUE).collect();
        assert_eq!(
            hold_reasons(&all),
            "Slurm holds back 5 tasks (JobHeldAdmin, JobHeldUser, job requeued in held state, launch failed requeued held). \
             `scontrol release 1 15 6` lets them start; where Slurm denies that, an operator has to\n\
             Slurm will not start 3 tasks as submitted (DependencyNeverSatisfied, PartitionConfig, PartitionTimeLimit). \
             Stop this command, type `scancel --state=PENDING 10 11 7`, and start it again with a shorter --time-limit or \
             another SBATCH_PARTITION, SBATCH_ACCOUNT or SBATCH_QOS"
        );
        let one: Vec<QueuedTask<'_>> = tasks(QUEUE).skip(3).take(1).collect();
        assert!(hold_reasons(&one).starts_with("Slurm holds back 1 task (JobHeldAdmin)."));
        let later: Vec<QueuedTask<'_>> = tasks(LATER).collect();
        assert_eq!(hold_reasons(&later), "");
    }
}

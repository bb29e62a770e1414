//! A Slurm cluster of one node on loopback, with munge, in a temporary folder; started and ended by process number.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A condition that has not come by then does not come: far above the time that a busy machine needs.
const HANG: Duration = Duration::from_secs(1800);

/// Number of checks of a task without processes after which it counts as lost: far above the time that its launch takes.
const LOOKS: u32 = 100;

pub(crate) struct Cluster {
    folder: tempfile::TempDir,
    /// The tasks that run according to the controller but have no process, with the number of looks.
    without_process: RefCell<BTreeMap<String, u32>>,
    munge: Child,
    controller: Child,
    node: Child,
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

fn daemon(program: &str, arguments: &[&str], folder: &Path) -> Child {
    let log = fs::File::create(folder.join(format!("{}.out", program.replace('/', "_")))).unwrap();
    Command::new(program)
        .args(arguments)
        .env("SLURM_CONF", folder.join("slurm.conf"))
        .stdin(Stdio::null())
        .stdout(log.try_clone().unwrap())
        .stderr(log)
        .spawn()
        .unwrap_or_else(|error| panic!("{program}: {error}; .ci/full installs it"))
}

impl Cluster {
    pub(crate) fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        // munge requires a folder that other users can traverse.
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
        let path = |name: &str| folder.path().join(name).display().to_string();
        fs::create_dir(path("state")).unwrap();
        fs::create_dir(path("spool")).unwrap();
        fs::write(path("munge.key"), [7; 1024]).unwrap();
        fs::set_permissions(path("munge.key"), fs::Permissions::from_mode(0o400)).unwrap();
        fs::write(path("slurm.conf"), configuration(folder.path())).unwrap();
        let option = |name: &str, file: &str| format!("--{name}={}", path(file));
        let munge = daemon(
            "munged",
            &[
                "--foreground",
                "--force",
                &option("socket", "munge.socket"),
                &option("key-file", "munge.key"),
                &option("log-file", "munge.log"),
                &option("pid-file", "munge.pid"),
                &option("seed-file", "munge.seed"),
            ],
            folder.path(),
        );
        let socket = PathBuf::from(path("munge.socket"));
        wait("munge", || socket.exists());
        let controller = daemon("slurmctld", &["-D"], folder.path());
        let node = daemon("slurmd", &["-D"], folder.path());
        let without_process = RefCell::default();
        let cluster = Self { folder, without_process, munge, controller, node };
        wait("an idle node", || {
            let nodes = cluster.command("sinfo").args(["--noheader", "--format=%T"]).output();
            nodes.is_ok_and(|nodes| String::from_utf8_lossy(&nodes.stdout).trim() == "idle")
        });
        cluster
    }

    /// A command whose environment names this cluster.
    pub(crate) fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.folder.path().join("slurm.conf"));
        command
    }

    /// Kills the controller without warning and starts it again.
    pub(crate) fn restart_controller(&mut self) {
        self.controller.kill().unwrap();
        self.controller.wait().unwrap();
        self.controller = daemon("slurmctld", &["-D"], self.folder.path());
    }

    /// Does the work of an operator: resumes a node that Slurm has drained because a requeued task had not left it yet, and
    /// releases tasks that Slurm holds.
    pub(crate) fn resume_node(&self) {
        self.set_node("RESUME");
        // Slurm holds a task that was requeued during its launch until it is released. Its priority is 0.
        let pending = self.command("squeue").args(["-h", "-t", "PD,RH", "-o", "%i|%Q"]).output();
        for job in words(&pending.unwrap()) {
            if let Some((job, "0")) = job.split_once('|') {
                let _ = self.command("scontrol").args(["release", job]).output();
            }
        }
        self.requeue_lost_tasks();
    }

    /// Requeues tasks that run according to the controller although no process of them is left: a controller that was killed
    /// may have missed their end. Slurm itself does so when the node registers again, after half an hour or more.
    fn requeue_lost_tasks(&self) {
        let active =
            self.command("squeue").args(["-h", "-r", "-t", "R,CG", "-o", "%A|%T"]).output();
        let mut lost: BTreeMap<String, u32> = BTreeMap::new();
        for line in words(&active.unwrap()) {
            let Some((job, state)) = line.split_once('|').filter(|(job, _)| !has_process(job))
            else {
                continue;
            };
            let looks = 1 + self.without_process.borrow().get(job).copied().unwrap_or_default();
            if looks < LOOKS {
                lost.insert(job.to_owned(), looks);
            } else if state == "RUNNING" {
                println!("the controller lost the end of job {job}: requeued");
                let _ = self.command("scontrol").args(["requeue", job]).output();
            } else {
                println!(
                    "the controller lost the end of job {job}, which is completing: node restarted"
                );
                self.set_node("DOWN");
                self.set_node("RESUME");
            }
        }
        *self.without_process.borrow_mut() = lost;
    }

    /// Drains or resumes the node.
    pub(crate) fn set_node(&self, state: &str) {
        let (node, state) = (format!("NodeName={}", host()), format!("State={state}"));
        // Slurm reports an error for a node that is in use, because it cannot be resumed.
        let _ = self.command("scontrol").args(["update", &node, &state, "Reason=test"]).output();
    }

    /// Numbers of the job arrays that have tasks in the queue.
    pub(crate) fn job_arrays(&self) -> BTreeSet<String> {
        let output = self.command("squeue").args(["--noheader", "--format=%F"]).output();
        words(&output.unwrap()).into_iter().collect()
    }

    /// The tasks in Slurm's queue, with the reasons why they are pending.
    pub(crate) fn queue(&self) -> String {
        let output = self.command("squeue").args(["--array", "--format=%i %T %Q %r"]).output();
        output.map_or_else(|error| error.to_string(), |output| output_text(&output))
    }

    /// Waits until a condition holds. If Slurm hangs, the test fails and prints Slurm's queue.
    pub(crate) fn wait(&self, condition: &str, mut holds: impl FnMut() -> bool) {
        let started = Instant::now();
        while !holds() {
            assert!(started.elapsed() < HANG, "no progress toward {condition}\n{}", self.queue());
            sleep(Duration::from_millis(100));
        }
    }

    /// Waits for a process to end and calls `tend` regularly.
    pub(crate) fn end_of(&self, mut process: Child, tend: impl Fn(&Self)) -> Output {
        self.wait("the end of the command", || {
            tend(self);
            process.try_wait().unwrap().is_some()
        });
        process.wait_with_output().unwrap()
    }

    /// Numbers of the running jobs.
    pub(crate) fn running(&self) -> Vec<String> {
        let mut squeue = self.command("squeue");
        let output =
            squeue.args(["--noheader", "--array", "--states=RUNNING", "--format=%i"]).output();
        words(&output.unwrap())
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        // The daemons end first, so that they do not restart tasks that have just been ended.
        for child in [&mut self.controller, &mut self.node, &mut self.munge] {
            let _ = child.kill();
            let _ = child.wait();
        }
        for process in processes_about(self.folder.path()) {
            kill(process);
        }
    }
}

pub(crate) fn kill(process: u32) {
    let _ = Command::new("kill").args(["-9", &process.to_string()]).output();
}

/// Whether a process of a job or the daemon that reports its end exists.
fn has_process(job: &str) -> bool {
    let of_step = format!("slurmstepd: [{job}.");
    let of_task = format!("\0SLURM_JOB_ID={job}\0");
    let Ok(entries) = fs::read_dir("/proc") else { return true };
    entries.filter_map(Result::ok).any(|entry| {
        let holds = |file: &str, text: &str| {
            fs::read(entry.path().join(file))
                .is_ok_and(|bytes| String::from_utf8_lossy(&bytes).contains(text))
        };
        holds("cmdline", &of_step) || holds("environ", &of_task)
    })
}

/// Processes whose command line or environment names the folder of this test.
pub(crate) fn processes_about(folder: &Path) -> Vec<u32> {
    let name = folder.display().to_string();
    let Ok(entries) = fs::read_dir("/proc") else { return Vec::new() };
    entries
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok())
        .filter(|process| *process != std::process::id())
        .filter(|process| {
            ["cmdline", "environ"].iter().any(|file| {
                fs::read(format!("/proc/{process}/{file}"))
                    .is_ok_and(|bytes| String::from_utf8_lossy(&bytes).contains(&name))
            })
        })
        .collect()
}

pub(crate) fn words(output: &Output) -> Vec<String> {
    String::from_utf8_lossy(&output.stdout).split_whitespace().map(str::to_owned).collect()
}

/// The complete output of a command.
pub(crate) fn output_text(output: &Output) -> String {
    let both = [output.stdout.as_slice(), output.stderr.as_slice()].concat();
    String::from_utf8_lossy(&both).into_owned()
}

fn wait(condition: &str, mut holds: impl FnMut() -> bool) {
    let started = Instant::now();
    while !holds() {
        assert!(started.elapsed() < HANG, "no progress toward {condition}");
        sleep(Duration::from_millis(100));
    }
}

/// Job arrays are limited to a small size, so that a sweep needs several. A requeued task waits for `cred_expire` seconds.
fn configuration(folder: &Path) -> String {
    let folder = folder.display();
    let host = host();
    let (controller, node) = (free_port(), free_port());
    format!(
        "ClusterName=t\n\
         SlurmctldHost={host}(127.0.0.1)\n\
         AuthType=auth/munge\n\
         AuthInfo=socket={folder}/munge.socket,cred_expire=5\n\
         CredType=cred/munge\n\
         SlurmUser=root\n\
         SlurmdUser=root\n\
         StateSaveLocation={folder}/state\n\
         SlurmdSpoolDir={folder}/spool\n\
         SlurmctldLogFile={folder}/slurmctld.log\n\
         SlurmdLogFile={folder}/slurmd.log\n\
         SlurmctldPidFile={folder}/slurmctld.pid\n\
         SlurmdPidFile={folder}/slurmd.pid\n\
         SlurmctldPort={controller}\n\
         SlurmdPort={node}\n\
         ProctrackType=proctrack/linuxproc\n\
         TaskPlugin=task/none\n\
         JobAcctGatherType=jobacct_gather/none\n\
         SelectType=select/cons_tres\n\
         SelectTypeParameters=CR_CPU\n\
         SchedulerType=sched/backfill\n\
         SchedulerParameters=sched_interval=2,bf_interval=2\n\
         MpiDefault=none\n\
         ReturnToService=2\n\
         MaxArraySize=9\n\
         NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=2000 State=UNKNOWN\n\
         PartitionName=p Nodes={host} Default=YES MaxTime=INFINITE State=UP\n"
    )
}

fn host() -> String {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").unwrap();
    name.trim().split('.').next().unwrap().to_owned()
}

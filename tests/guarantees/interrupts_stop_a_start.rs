//! Guarantee: an interrupt stops a run also while its start is built; nothing of it is recorded, and no error is reported. It stops discs
//! that cool between noisy walls at any time before they come to rest.
//!
//! Setup: discs that grow so slowly that the start is not complete within hours; the interrupt is raised from another thread. A call that does
//! not end within ten minutes counts as endless; it takes less than a second.
//! Tolerance: none.
//! Control: a compression at the rate of the starter manifest gives a plan that can be executed.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use kinetoscope::executor::local::{LocalPool, run_all};
use kinetoscope::executor::observer::{ExecutionObserver, RunObserver};
use kinetoscope::interrupt::Interrupt;
use kinetoscope::plan::Plan;
use kinetoscope::plan::preparation::Preparation;
use kinetoscope::run::in_memory::run_interruptibly;
use kinetoscope::run::resources::time::measured_seconds;
use kinetoscope::run::{RunContext, RunError, RunReport};
use kinetoscope_manifest::{Experiment, parse};
use kinetoscope_physics::model::SetupError;
use kinetoscope_recording::provenance::Outcome;
use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Mutex;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

/// More than a stop takes on any machine; only a call without an end takes longer.
const ENDLESS: Duration = Duration::from_secs(600);

/// The number of the signal of Ctrl-C (POSIX).
const SIGINT: usize = 2;

/// Ten discs, compressed at a rate.
fn experiment(compression_rate: f64) -> Experiment {
    let text = format!(
        "seed = 1\n[model.packing]\ndiscs = 10\nplacement = \"compressed\"\ncompression_rate = {compression_rate:e}\n"
    );
    parse(&text, "compressed.toml", &[]).unwrap()
}

/// A compression that takes 1e9 flights of a disc over its diameter.
fn slow() -> Experiment {
    experiment(1e-9)
}

/// The result of a call that is interrupted after a moment.
fn interrupted<T: Send + 'static>(call: impl FnOnce(&Interrupt) -> T + Send + 'static) -> T {
    let interrupt = Interrupt::default();
    let raised = interrupt.clone();
    let (sender, receiver) = channel();
    thread::spawn(move || sender.send(call(&interrupt)));
    let early = receiver.recv_timeout(Duration::from_millis(100));
    assert!(early.is_err(), "the start is complete before the interrupt");
    raised.raise(SIGINT);
    receiver.recv_timeout(ENDLESS).expect("the call does not end")
}

#[test]
fn interrupt_stops_an_estimate_whose_start_is_not_complete() {
    let measured = interrupted(|interrupt| {
        measured_seconds(&slow().runs[0].manifest, None, interrupt).is_some()
    });
    assert!(!measured);
    let control = &experiment(0.01).runs[0].manifest;
    assert!(measured_seconds(control, None, &Interrupt::default()).is_some());
}

/// Guarantee: a plan reports how much of its starts is complete: more and more, up to all of them.
/// Setup: two replicates of a compression of some 100,000 collisions per disc.
#[test]
fn plan_reports_the_complete_part_of_its_starts() {
    let folder = tempfile::tempdir().unwrap();
    let plan = |text: &str| {
        let interrupt = Interrupt::default();
        let seen = Mutex::new(Vec::new());
        let on_progress = |done, starts| seen.lock().unwrap().push((done, starts));
        let experiment = parse(text, "reported.toml", &[]).unwrap();
        let preparation = Preparation { interrupt: &interrupt, on_progress: &on_progress };
        let plan = Plan::new(&experiment, folder.path(), false, preparation);
        assert_eq!(plan.rejected().count(), 0);
        seen.into_inner().unwrap()
    };
    let compressed = "seed = 1\nreplicates = 2\n[model.packing]\ndiscs = 10\nplacement = \"compressed\"\ncompression_rate = 3e-6\n";
    let mut seen = plan(compressed);
    assert!(seen.iter().all(|(done, starts)| *starts == 2 && (0.0..=2.0).contains(done)));
    // The threads of two starts may report in either order.
    seen.sort_by(|one, other| one.0.total_cmp(&other.0));
    assert_eq!(seen.last(), Some(&(2.0, 2)));
    assert!(seen.windows(2).all(|pair| pair[0].0 < pair[1].0), "{seen:?}");
    let parts = seen.iter().filter(|(done, _)| done.fract() > 0.0).count();
    assert!(parts > 10, "{seen:?}");
    // Control: a start that is built at once is complete at once.
    assert_eq!(plan("seed = 1\n[model.packing]\ndiscs = 2\n").last(), Some(&(1.0, 1)));
}

struct Unobserved;

impl ExecutionObserver for Unobserved {
    fn start_run<'a>(&'a self, _: &str) -> Box<dyn RunObserver + 'a> {
        Box::new(Self)
    }

    fn show_remote(&self, _: usize, _: &str) {}

    fn remark(&self, _: &str) {}
}

impl RunObserver for Unobserved {
    fn frame(&self, _: u64, _: u64) {}

    fn finish(self: Box<Self>, _: &Result<RunReport, RunError>) {}
}

#[test]
fn interrupt_stops_a_plan_whose_start_is_not_complete() {
    let unused = Path::new("recordings");
    let rejected = interrupted(|interrupt| {
        let plan = Plan::new(&slow(), unused, false, interrupt);
        plan.rejected().map(|(_, error)| error.clone()).collect::<Vec<_>>()
    });
    assert_eq!(rejected, [SetupError::stopped()]);
    let control = Plan::new(&experiment(0.01), unused, false, &Interrupt::default());
    assert_eq!((control.to_do().len(), control.rejected().count()), (1, 0));
}

/// Setup: the plan has kept no start, so that the run builds it.
#[test]
fn interrupt_stops_a_run_whose_start_is_not_complete() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().to_owned();
    let reports = interrupted(move |interrupt| {
        let before = Interrupt::default();
        before.stop();
        let plan = Plan::new(&slow(), &output, false, &before);
        let runs: Vec<_> = plan.runs.iter().map(|run| (run, output.as_path())).collect();
        let pool_size = LocalPool { jobs: NonZeroUsize::MIN, threads: NonZeroUsize::MIN };
        let context = RunContext {
            interrupt,
            checkpoint_every: Duration::from_secs(5),
            on_frame: &|_, _| {},
            on_written: &|| {},
            live: None,
            gnuplot: None,
        };
        let mut reports = 0;
        run_all(&runs, pool_size, context, &Unobserved, &|_| {}, &mut |_, _| reports += 1);
        reports
    });
    assert_eq!(reports, 0);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is recorded");
}

/// Setup: the walls turn velocities that fall below the smallest normal number, unless the run ends before; signals after 0 to 95 ms, and
/// none. Previously, a wall drew directions without end, and no signal was read.
#[test]
fn discs_that_come_to_rest_end_with_the_fault_or_at_the_interrupt() {
    let text = "seed = 1\n[model.packing]\ndiscs = 20\nrestitution = 0.9\nwall_noise_variance_rad2 = 0.1\nevents_per_disc = 10000\n";
    let outcome = |signal_after: Option<Duration>| {
        let run = parse(text, "cooling.toml", &[]).unwrap().runs.remove(0);
        let interrupt = Interrupt::default();
        let raised = interrupt.clone();
        let (sender, receiver) = channel();
        thread::spawn(move || {
            let ended = run_interruptibly(&run, &interrupt);
            sender.send(ended.map(|recording| recording.provenance().outcome.clone()))
        });
        if let Some(after) = signal_after {
            thread::sleep(after);
            raised.raise(SIGINT);
        }
        receiver.recv_timeout(ENDLESS).expect("the call does not end")
    };
    let is_at_rest = |outcome: &Option<Outcome>| matches!(outcome, Some(Outcome::Fault(why)) if why.starts_with("the discs have come to rest"));
    assert!(is_at_rest(&outcome(None).unwrap()));
    for twentieth in 0..20 {
        match outcome(Some(Duration::from_millis(5 * twentieth))) {
            Ok(ended) => {
                assert!(ended == Some(Outcome::Interrupted) || is_at_rest(&ended), "{ended:?}")
            }
            // The signal came before the start was complete.
            Err(RunError::Setup(error)) => assert_eq!(error, SetupError::stopped()),
            Err(error) => panic!("{error}"),
        }
    }
}

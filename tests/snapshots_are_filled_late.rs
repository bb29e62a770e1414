//! Promise: a frame is the same whether it is filled at once or from a snapshot while the run has moved on, and whatever the
//! snapshot was used for before. The recorder's thread relies on it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod small_experiments;

use kinetoscope::model::{Model, Progress};
use kinetoscope::models::{ForModel, with_model};
use kinetoscope::random::Seed;
use kinetoscope::schedule::Schedule;
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::frame::{Frame, Snapshot};
use small_experiments::{MANIFESTS, run_of};

/// A run's frames, filled at once and one frame later, from two snapshots in turn.
struct BothWays<'a>(&'a RunManifest);

impl ForModel for BothWays<'_> {
    type Output = (Vec<Frame>, Vec<Frame>);

    fn call<M: Model>(self, config: &M::Config) -> Self::Output {
        let Self(manifest) = self;
        let seed = Seed { seed: manifest.seed, replicate: manifest.replicate };
        let mut model = M::prepare(config, seed, true).unwrap();
        let schedule = Schedule::new(manifest.record.interval, model.extent()).unwrap();
        let (mut at_once, mut late) = (Vec::new(), Vec::new());
        let (mut waiting, mut spare) = (M::Snapshot::default(), M::Snapshot::default());
        for index in 0..=schedule.frames() {
            if index > 0 {
                let target = schedule.target(index);
                while model.advance(target, u64::MAX).unwrap() == Progress::Working {}
                late.push(filled(&mut waiting));
            }
            at_once.push(Frame::new());
            model.observe(at_once.last_mut().unwrap());
            model.capture(&mut spare);
            std::mem::swap(&mut waiting, &mut spare);
        }
        late.push(filled(&mut waiting));
        (at_once, late)
    }
}

fn filled(snapshot: &mut impl Snapshot) -> Frame {
    let mut frame = Frame::new();
    snapshot.fill(&mut frame);
    frame
}

#[test]
fn a_frame_filled_late_is_the_frame_filled_at_once() {
    for (name, manifest) in MANIFESTS {
        let run = run_of(name, manifest);
        let (at_once, late) = with_model(&run.model, BothWays(&run));
        assert!(at_once.len() > 2 && at_once[0] != at_once[1], "{name}: nothing moves");
        for (index, (at_once, late)) in at_once.iter().zip(&late).enumerate() {
            assert!(at_once == late, "{name}: frame {index} differs");
        }
        assert_eq!(at_once.len(), late.len(), "{name}");
    }
}

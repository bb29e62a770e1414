//! The frames of an interval at a finer resolution: those of a run that is recorded at this resolution.

use crate::run::prepared::Prepared;
use crate::run::schedule::Schedule;
use crate::verify::error::VerifyError;
use crate::verify::source::Source;
use kinetoscope_console::Message;
use kinetoscope_manifest::RunManifest;
use kinetoscope_manifest::quantity::Positive;
use kinetoscope_manifest::record::RecordInterval;
use kinetoscope_physics::model::{Extent, Model, Target};
use std::num::NonZeroU64;
use std::sync::Arc;

/// What `--every` can be.
const AN_INTERVAL: &str = "write the time between two frames, such as 0.001";
/// Tolerance of the bounds, in frames.
const SAME_FRAME: f64 = 1e-9;

/// An interval of a run and the distance of its frames: in the model's unit of time, or in collisions if the length of the run is
/// a number of collisions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The start.
    pub from: f64,
    /// The end.
    pub to: f64,
    /// The distance.
    pub every: f64,
}

/// The frames of an interval.
pub(crate) struct FineFrames {
    interval: RecordInterval,
    schedule: Schedule,
    /// Index of the first frame, counted from the start of the run.
    pub(crate) first: u64,
    /// Index of the last frame.
    pub(crate) last: u64,
}

impl FineFrames {
    /// The multiples of `every` in the interval, and the end of the run if it is in the interval.
    pub(crate) fn new(start: &Prepared, interval: &Interval) -> Result<Self, VerifyError> {
        let &Interval { from, to, every } = interval;
        let refused =
            |what: String, help: &str| Err(VerifyError::Arguments(Message::new(what, help)));
        let extent = start.model.extent();
        let (end, unit) = match extent {
            Extent::Steps { total, step } => (total as f64 * step, start.header.time_unit),
            Extent::Time(duration) => (duration, start.header.time_unit),
            Extent::Events(total) => (total as f64, "collisions"),
        };
        let shown = |value: f64| {
            let number = if value < 1e-4 { format!("{value:e}") } else { value.to_string() };
            format!("{number} {unit}").trim_end().to_owned()
        };
        let length = format!("the run lasts from 0 to {}", shown(end));
        let slack = end * SAME_FRAME;
        // The duration of a manifest need not be a whole number of steps: the run ends less than a step before or after it.
        let rest = if let Extent::Steps { step, .. } = extent { step } else { 0.0 };
        if !(from >= 0.0 && from <= to && to <= end + rest + slack) {
            let what = format!("--from {from:?} --to {to:?} is not an interval of the run");
            return refused(what, &length);
        }
        if !(every > 0.0 && every.is_finite()) {
            return refused(format!("--every {every} must be above 0"), AN_INTERVAL);
        }
        match extent {
            Extent::Steps { step, .. } if every < step * (1.0 - SAME_FRAME) => {
                let what = format!("--every {every:?} is less than one time step");
                return refused(what, &format!("the step of {} is the limit", shown(step)));
            }
            Extent::Events(_) if every < 1.0 || every.fract() != 0.0 => {
                let what = format!("--every {every} is not a whole number of collisions");
                return refused(what, "write a whole number, such as 10");
            }
            _ => {}
        }
        let interval = match (extent, Positive::new(every), NonZeroU64::new(every as u64)) {
            (Extent::Events(_), _, Some(every)) => RecordInterval::EveryCollisions(every),
            // Rounding may make it less than the step.
            (Extent::Steps { step, .. }, Some(_), _) if every < step => {
                RecordInterval::EverySteps(NonZeroU64::MIN)
            }
            (_, Some(every), _) => RecordInterval::EveryTime(every),
            _ => return refused(format!("--every {every} must be above 0"), AN_INTERVAL),
        };
        let schedule = Schedule::new(interval, extent)?;
        if !start.header.can_be_played(schedule.frames()) {
            let frames = schedule.frames();
            let what = format!(
                "--every {every:?} divides the run into {frames} frames, more than a viewer can play"
            );
            return refused(what, "take a longer time");
        }
        // Relative to quotients below 1, so that a start above 0 is not the frame at 0.
        let frames_before = from / every;
        let tolerance = SAME_FRAME * if frames_before < 1.0 { frames_before } else { 1.0 };
        let first = (frames_before - tolerance).ceil() as u64;
        let reaches_end = to >= end - slack;
        let last = (to / every + SAME_FRAME).floor() as u64;
        let last = if reaches_end { schedule.frames() } else { last.min(schedule.frames()) };
        let first = if reaches_end { first.min(last) } else { first };
        if first > last {
            let what = format!("no multiple of {} is from {from} to {to}", shown(every));
            return refused(what, "change --every or the interval");
        }
        Ok(Self { interval, schedule, first, last })
    }

    /// The target of a frame.
    pub(crate) fn target(&self, frame: u64) -> Target {
        self.schedule.target_or_start(frame)
    }

    /// The manifest of a run with these frames.
    pub(crate) fn manifest(&self, source: &Source) -> RunManifest {
        let mut manifest = source.manifest.with_all_frames();
        Arc::make_mut(&mut manifest.record).interval = self.interval;
        manifest
    }

    /// A model with this schedule.
    pub(crate) fn prepared(
        &self,
        source: &Source,
        model: Box<dyn Model>,
    ) -> Result<Prepared, VerifyError> {
        let manifest = self.manifest(source);
        let (canonical, key) = source.identity(&manifest);
        Ok(Prepared::of(model, &manifest, &canonical, &key)?)
    }
}

//! The schedule of a run's frames: one target per frame, from the manifest's interval and the length of the run.

use kinetoscope_manifest::record::{Decades, FramesPerDecade, RecordConfig, RecordInterval};
use kinetoscope_physics::model::{Extent, SetupError, Target};
use std::num::NonZeroU64;

/// The targets of all frames after the start, in order. Invariant: the last one is the end of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    interval: RecordInterval,
    extent: Extent,
    frames: u64,
    /// The targets of a logarithmic interval.
    listed: Vec<Target>,
}

/// Distance from the end, in intervals, within which a time counts as the end.
const SAME_INSTANT: f64 = 1e-9;

impl Schedule {
    /// The schedule of a run of the given extent.
    ///
    /// # Errors
    /// An interval that does not fit the run, with the remedy.
    pub fn new(interval: RecordInterval, extent: Extent) -> Result<Self, SetupError> {
        use Extent::{Events, Steps, Time};
        let mut listed = Vec::new();
        let frames = match (interval, extent) {
            (RecordInterval::Frames(frames), Steps { total, .. } | Events(total))
                if frames.get() > total =>
            {
                return Err(too_many_frames(frames, extent, total));
            }
            (RecordInterval::Frames(frames), _) => frames.get(),
            (
                RecordInterval::EverySteps(every) | RecordInterval::EveryCollisions(every),
                Steps { total, .. } | Events(total),
            ) => total.div_ceil(every.get()),
            (RecordInterval::EveryTime(every), Steps { total, step }) => {
                frames_every_time(every.get(), step, total)?
            }
            (RecordInterval::EveryTime(every), Time(duration)) => {
                (duration / every.get() - SAME_INSTANT).ceil() as u64
            }
            (RecordInterval::Logarithmic(per_decade, decades), extent) => {
                listed = logarithmic(per_decade, decades, extent);
                listed.len() as u64
            }
            (RecordInterval::EveryTime(_), Events(_)) => {
                return Err(SetupError::new(
                    "[record] requests frames by time, but the run's length is in events",
                    "use frames or every_collisions, or give the model a duration",
                ));
            }
            (RecordInterval::EverySteps(_) | RecordInterval::EveryCollisions(_), Time(_)) => {
                return Err(SetupError::new(
                    "[record] requests frames by steps or collisions, but the run's length is a time",
                    "use frames, or an interval of time",
                ));
            }
        };
        Ok(Self { interval, extent, frames, listed })
    }

    /// Number of frames after the start.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// The target of frame `index`, from 0.
    pub(crate) fn target_or_start(&self, index: u64) -> Target {
        match (index, self.target(Ord::max(index, 1))) {
            (0, Target::Count(_)) => Target::Count(0),
            (0, Target::Time(_)) => Target::Time(0.0),
            (_, target) => target,
        }
    }

    /// The target of frame `index`, from 1 to [`Schedule::frames`].
    #[must_use]
    pub fn target(&self, index: u64) -> Target {
        match (self.interval, self.extent) {
            (RecordInterval::Frames(_), Extent::Steps { total, .. } | Extent::Events(total)) => {
                // The count round(index total / frames), halves up.
                let [index, total, frames] = [index, total, self.frames].map(u128::from);
                // The value is at most total; therefore, it fits.
                Target::Count(((2 * index * total + frames) / (2 * frames)) as u64)
            }
            (RecordInterval::Logarithmic(..), _) => {
                self.listed[Ord::min(index, self.frames).saturating_sub(1) as usize]
            }
            _ if index >= self.frames => self.extent.end(),
            (RecordInterval::Frames(_), Extent::Time(duration)) => {
                Target::Time(duration * (index as f64 / self.frames as f64))
            }
            (RecordInterval::EverySteps(every) | RecordInterval::EveryCollisions(every), _) => {
                Target::Count(index * every.get())
            }
            (RecordInterval::EveryTime(every), Extent::Steps { step, .. }) => {
                Target::Count(nearest_step(index as f64 * every.get(), step))
            }
            (RecordInterval::EveryTime(every), _) => Target::Time(index as f64 * every.get()),
        }
    }
}

/// Whether a target is not after another one of the same run.
pub(crate) fn is_at_or_before(one: Target, other: Target) -> bool {
    match (one, other) {
        (Target::Count(one), Target::Count(other)) => one <= other,
        (Target::Time(one), Target::Time(other)) => one <= other,
        _ => false,
    }
}

/// The step nearest to a time.
fn nearest_step(time: f64, step: f64) -> u64 {
    (time / step + 0.5).floor() as u64
}

fn frames_every_time(every: f64, step: f64, total: u64) -> Result<u64, SetupError> {
    if every < step {
        return Err(SetupError::new(
            format!(
                "[record] requests a frame every {every:e}, less than the time step of {step:e}"
            ),
            format!("set at least {step:e}"),
        ));
    }
    let frames = (total as f64 * step / every - SAME_INSTANT).ceil() as u64;
    let last_but_one = nearest_step(frames.saturating_sub(1) as f64 * every, step);
    // The last frame but one may round to the end, which is a frame of its own.
    Ok(if frames > 1 && last_but_one >= total { frames - 1 } else { frames })
}

/// The error of more frames than the run has steps or events: `frames` may be the default, which the manifest does not show.
fn too_many_frames(frames: NonZeroU64, extent: Extent, total: u64) -> SetupError {
    let what = match (extent, total) {
        (Extent::Steps { .. }, 1) => "step",
        (Extent::Steps { .. }, _) => "steps",
        (_, 1) => "event",
        _ => "events",
    };
    let is_default = RecordConfig::default().interval == RecordInterval::Frames(frames);
    // A manifest may also state the default.
    let default = if is_default { ", the default" } else { "" };
    SetupError::new(
        format!("[record] frames is {frames}{default}, but the run has only {total} {what}"),
        format!("set frames to at most {total} in [record], or make the run longer"),
    )
}

/// Frames at the fractions 10^(-j/p) of the run's length, p per decade; the last one is its end. Counts are rounded, and equal
/// counts are merged.
fn logarithmic(per_decade: FramesPerDecade, decades: Decades, extent: Extent) -> Vec<Target> {
    let frames = per_decade.get() * decades.get();
    let fractions = (0..=frames)
        .rev()
        .map(|before_end| libm::pow(10.0, -f64::from(before_end) / f64::from(per_decade.get())));
    match extent {
        Extent::Time(duration) => {
            fractions.map(|fraction| Target::Time(fraction * duration)).collect()
        }
        Extent::Steps { total, .. } | Extent::Events(total) => {
            let mut counts: Vec<u64> =
                fractions.map(|fraction| (fraction * total as f64 + 0.5).floor() as u64).collect();
            // A large total is not exact as a floating-point number.
            counts.pop();
            counts.push(total);
            counts.retain(|count| (1..=total).contains(count));
            counts.dedup();
            counts.into_iter().map(Target::Count).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinetoscope_manifest::quantity::Positive;

    fn targets(interval: RecordInterval, extent: Extent) -> Vec<Target> {
        let schedule = Schedule::new(interval, extent).unwrap();
        (1..=schedule.frames()).map(|index| schedule.target(index)).collect()
    }

    #[test]
    fn frames_are_even_in_steps_with_halves_rounded_up() {
        let interval = RecordInterval::Frames(NonZeroU64::new(4).unwrap());
        let extent = Extent::Steps { total: 10, step: 0.1 };
        let expected = [3, 5, 8, 10].map(Target::Count).to_vec();
        assert_eq!(targets(interval, extent), expected);
    }

    #[test]
    fn end_is_a_frame_for_every_interval() {
        let every = RecordInterval::EveryTime(Positive::literal(0.4));
        let steps = Extent::Steps { total: 10, step: 0.1 };
        assert_eq!(targets(every, steps), [4, 8, 10].map(Target::Count).to_vec());
        assert_eq!(targets(every, Extent::Time(1.0)), [0.4, 0.8, 1.0].map(Target::Time).to_vec());
        let collisions = RecordInterval::EveryCollisions(NonZeroU64::new(4).unwrap());
        assert_eq!(targets(collisions, Extent::Events(9)), [4, 8, 9].map(Target::Count).to_vec());
    }

    #[test]
    fn interval_that_divides_the_run_repeats_no_frame() {
        let every = RecordInterval::EveryTime(Positive::literal(0.1));
        assert_eq!(targets(every, Extent::Time(0.3)).len(), 3);
        let steps = Extent::Steps { total: 30, step: 0.01 };
        assert_eq!(targets(every, steps), [10, 20, 30].map(Target::Count).to_vec());
    }

    #[test]
    fn frame_that_rounds_to_the_end_is_taken_once() {
        let every = RecordInterval::EveryTime(Positive::literal(0.33));
        let steps = Extent::Steps { total: 10, step: 0.1 };
        assert_eq!(targets(every, steps), [3, 7, 10].map(Target::Count).to_vec());
    }

    /// Law: the targets are 10^(k/3) times the first: 1, 2.15, 4.64, 10 ... 1000, rounded; times are exact to a few rounding errors.
    #[test]
    fn logarithmic_frames_are_even_in_the_logarithm() {
        let three = RecordInterval::Logarithmic(3.try_into().unwrap(), 3.try_into().unwrap());
        let counts = [1, 2, 5, 10, 22, 46, 100, 215, 464, 1000].map(Target::Count).to_vec();
        assert_eq!(targets(three, Extent::Events(1000)), counts);
        assert_eq!(targets(three, Extent::Steps { total: 1000, step: 0.1 }), counts);
        // If there are fewer counts than frames, each is taken once.
        let few = [1, 2, 5, 10].map(Target::Count).to_vec();
        assert_eq!(targets(three, Extent::Events(10)), few);
        assert_eq!(targets(three, Extent::Events(1)), [Target::Count(1)]);
        let times = targets(three, Extent::Time(5.0));
        assert_eq!(times.len(), 10);
        assert_eq!(times[9], Target::Time(5.0));
        for (index, target) in times.iter().enumerate() {
            let Target::Time(time) = target else { panic!("{target:?}") };
            let whole = [5e-3, 5e-2, 5e-1, 5.0][index / 3];
            // 10^(1/3) and 10^(2/3).
            let part = [1.0, 2.154_434_690_031_884, 4.641_588_833_612_779][index % 3];
            let expected = whole * part;
            assert!((time / expected - 1.0).abs() < 1e-14, "{time} {expected}");
        }
        // The largest total is the end, and no frame is repeated or after it.
        let all = targets(three, Extent::Events(u64::MAX));
        assert_eq!(all.last(), Some(&Target::Count(u64::MAX)));
        assert!(
            all.windows(2)
                .all(|pair| matches!(pair, [Target::Count(a), Target::Count(b)] if a < b))
        );
    }

    #[test]
    fn more_frames_than_steps_are_rejected_with_the_maximum() {
        let interval = RecordInterval::Frames(NonZeroU64::new(11).unwrap());
        let error = Schedule::new(interval, Extent::Steps { total: 10, step: 0.1 }).unwrap_err();
        assert!(error.0.to_string().contains("frames to at most 10"), "{error}");
    }
}

//! The schedule of a run's frames: one target per frame, from the manifest's interval and the length of the run.

use kinetoscope_manifest::record::{Decades, FramesPerDecade, RecordInterval};
use kinetoscope_physics::model::{Extent, SetupError, Target};

/// The targets of all frames after the start, in order. Invariant: the last one is the end of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    interval: Interval,
    frames: u64,
}

#[derive(Clone, Debug, PartialEq)]
enum Interval {
    /// Frame k of n at count round(k total / n), halves up.
    EvenCounts { total: u64 },
    /// Frame k of n at time k duration / n.
    EvenTimes { duration: f64 },
    /// Frame k at count k every.
    EveryCount { every: u64, total: u64 },
    /// Frame k at the step nearest to time k every.
    EveryTimeInSteps { every: f64, step: f64, total: u64 },
    /// Frame k at time k every.
    EveryTime { every: f64, duration: f64 },
    /// Frame k at entry k - 1.
    Listed(Vec<Target>),
}

/// Distance from the end, in intervals, within which a time counts as the end.
const SAME_INSTANT: f64 = 1e-9;

impl Schedule {
    /// The schedule of a run of the given extent.
    ///
    /// # Errors
    /// An interval that does not fit the run, with the remedy.
    pub fn new(interval: RecordInterval, extent: Extent) -> Result<Self, SetupError> {
        match (interval, extent) {
            (RecordInterval::Frames(frames), Extent::Time(duration)) => {
                Ok(Self { interval: Interval::EvenTimes { duration }, frames: frames.get() })
            }
            (
                RecordInterval::Frames(frames),
                Extent::Steps { total, .. } | Extent::Events(total),
            ) => {
                if frames.get() > total {
                    return Err(SetupError(format!(
                        "[record] frames = {frames}, but the run has only {total} steps or events: \
                         ask for frames = {total} at most"
                    )));
                }
                Ok(Self { interval: Interval::EvenCounts { total }, frames: frames.get() })
            }
            (
                RecordInterval::EverySteps(every) | RecordInterval::EveryCollisions(every),
                Extent::Steps { total, .. } | Extent::Events(total),
            ) => Ok(Self {
                interval: Interval::EveryCount { every: every.get(), total },
                frames: total.div_ceil(every.get()),
            }),
            (RecordInterval::EveryTime(every), Extent::Steps { total, step }) => {
                every_time_in_steps(every.get(), step, total)
            }
            (RecordInterval::EveryTime(every), Extent::Time(duration)) => Ok(Self {
                frames: (duration / every.get() - SAME_INSTANT).ceil() as u64,
                interval: Interval::EveryTime { every: every.get(), duration },
            }),
            (RecordInterval::Logarithmic(per_decade, decades), extent) => {
                Ok(logarithmic(per_decade, decades, extent))
            }
            (RecordInterval::EveryTime(_), Extent::Events(_)) => Err(SetupError(
                "[record] asks for frames by time, but the run's length is in events: \
                 use frames or every_collisions, or give the model a duration"
                    .to_owned(),
            )),
            (
                RecordInterval::EverySteps(_) | RecordInterval::EveryCollisions(_),
                Extent::Time(_),
            ) => Err(SetupError(
                "[record] asks for frames by steps or collisions, but the run's length is a time: \
                 use frames, or an interval of time"
                    .to_owned(),
            )),
        }
    }

    /// Number of frames after the start.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// The target of frame `index`, from 1 to [`Schedule::frames`].
    #[must_use]
    pub fn target(&self, index: u64) -> Target {
        let is_last = index >= self.frames;
        match &self.interval {
            &Interval::EvenCounts { total } => {
                let (index, total, frames) =
                    (u128::from(index), u128::from(total), u128::from(self.frames));
                // The value is at most total; therefore, it fits.
                Target::Count(((2 * index * total + frames) / (2 * frames)) as u64)
            }
            &Interval::EveryCount { total, .. } | &Interval::EveryTimeInSteps { total, .. }
                if is_last =>
            {
                Target::Count(total)
            }
            &Interval::EvenTimes { duration } | &Interval::EveryTime { duration, .. }
                if is_last =>
            {
                Target::Time(duration)
            }
            Interval::EvenTimes { duration } => {
                Target::Time(duration * (index as f64 / self.frames as f64))
            }
            Interval::EveryCount { every, .. } => Target::Count(index * every),
            &Interval::EveryTimeInSteps { every, step, .. } => {
                Target::Count(step_next_to(index as f64 * every, step))
            }
            Interval::EveryTime { every, .. } => Target::Time(index as f64 * every),
            Interval::Listed(targets) => {
                let place = Ord::min(index, self.frames).saturating_sub(1);
                targets[place as usize]
            }
        }
    }
}

fn step_next_to(time: f64, step: f64) -> u64 {
    (time / step + 0.5).floor() as u64
}

fn every_time_in_steps(every: f64, step: f64, total: u64) -> Result<Schedule, SetupError> {
    if every < step {
        return Err(SetupError(format!(
            "[record] asks for a frame every {every:e}, less than the time step of {step:e}: \
             ask for {step:e} at least"
        )));
    }
    let frames = (total as f64 * step / every - SAME_INSTANT).ceil() as u64;
    let last_but_one = step_next_to(frames.saturating_sub(1) as f64 * every, step);
    // The last frame but one may round to the end, which is a frame of its own.
    let frames = if frames > 1 && last_but_one >= total { frames - 1 } else { frames };
    Ok(Schedule { interval: Interval::EveryTimeInSteps { every, step, total }, frames })
}

/// Frames at the fractions 10^(-j/p) of the run's length, p per decade; the last one is its end. Counts are rounded, and equal
/// counts are merged.
fn logarithmic(per_decade: FramesPerDecade, decades: Decades, extent: Extent) -> Schedule {
    let frames = per_decade.get() * decades.get();
    let shares = (0..=frames)
        .rev()
        .map(|before_end| libm::pow(10.0, -f64::from(before_end) / f64::from(per_decade.get())));
    let targets: Vec<Target> = match extent {
        Extent::Time(duration) => shares.map(|share| Target::Time(share * duration)).collect(),
        Extent::Steps { total, .. } | Extent::Events(total) => {
            let mut counts: Vec<u64> =
                shares.map(|share| (share * total as f64 + 0.5).floor() as u64).collect();
            // A large total is not exact as a floating-point number.
            counts.pop();
            counts.push(total);
            counts.retain(|count| (1..=total).contains(count));
            counts.dedup();
            counts.into_iter().map(Target::Count).collect()
        }
    };
    Schedule { frames: targets.len() as u64, interval: Interval::Listed(targets) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinetoscope_manifest::quantity::Positive;
    use std::num::NonZeroU64;

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
    fn the_end_is_a_frame_whatever_the_interval() {
        let every = RecordInterval::EveryTime(Positive::literal(0.4));
        let steps = Extent::Steps { total: 10, step: 0.1 };
        assert_eq!(targets(every, steps), [4, 8, 10].map(Target::Count).to_vec());
        assert_eq!(targets(every, Extent::Time(1.0)), [0.4, 0.8, 1.0].map(Target::Time).to_vec());
        let collisions = RecordInterval::EveryCollisions(NonZeroU64::new(4).unwrap());
        assert_eq!(targets(collisions, Extent::Events(9)), [4, 8, 9].map(Target::Count).to_vec());
    }

    #[test]
    fn an_interval_that_divides_the_run_gives_no_frame_twice() {
        let every = RecordInterval::EveryTime(Positive::literal(0.1));
        assert_eq!(targets(every, Extent::Time(0.3)).len(), 3);
        let steps = Extent::Steps { total: 30, step: 0.01 };
        assert_eq!(targets(every, steps), [10, 20, 30].map(Target::Count).to_vec());
    }

    #[test]
    fn a_frame_that_rounds_onto_the_end_is_taken_once() {
        let every = RecordInterval::EveryTime(Positive::literal(0.33));
        let steps = Extent::Steps { total: 10, step: 0.1 };
        assert_eq!(targets(every, steps), [3, 7, 10].map(Target::Count).to_vec());
    }

    /// Law: 10^(k/3) of the least; 1, 2.15, 4.64, 10 ... 1000 rounded, and in time to a few units in the last place.
    #[test]
    fn logarithmic_frames_are_even_in_the_logarithm() {
        let three = RecordInterval::Logarithmic(3.try_into().unwrap(), 3.try_into().unwrap());
        let counts = [1, 2, 5, 10, 22, 46, 100, 215, 464, 1000].map(Target::Count).to_vec();
        assert_eq!(targets(three, Extent::Events(1000)), counts);
        assert_eq!(targets(three, Extent::Steps { total: 1000, step: 0.1 }), counts);
        // Where counts are fewer than frames, each is taken once; of one step there is one.
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
        // The largest total is still the end, and no frame comes twice or after it.
        let all = targets(three, Extent::Events(u64::MAX));
        assert_eq!(all.last(), Some(&Target::Count(u64::MAX)));
        assert!(
            all.windows(2)
                .all(|pair| matches!(pair, [Target::Count(a), Target::Count(b)] if a < b))
        );
    }

    #[test]
    fn more_frames_than_steps_are_refused_with_the_most_there_can_be() {
        let interval = RecordInterval::Frames(NonZeroU64::new(11).unwrap());
        let error = Schedule::new(interval, Extent::Steps { total: 10, step: 0.1 }).unwrap_err();
        assert!(error.0.contains("frames = 10 at most"), "{error}");
    }
}

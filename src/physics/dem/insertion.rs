//! Insertion of discs during a run: one after the other, in the order of their ids, at random free positions on a line.

use super::discs::{Disc, Discs};
use super::motion;
use super::parameters::Parameters;
use super::start;
use super::walls::PlacedWall;
use crate::random::{Generator, Seed, Stream};
use kinetoscope_manifest::model::DemConfig;
use serde::{Deserialize, Serialize};

/// Positions that are tried for a disc at a time.
const TRIALS: u32 = 20;

/// The discs that are still to be inserted.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Insertion {
    /// The two ends of the line of entry, m.
    line: [[f64; 2]; 2],
    /// The integrator's velocity of a disc that enters, m/s.
    velocity: [f64; 2],
    /// Discs due per second.
    rate: f64,
    /// Time at which the first disc is due, s.
    starts: f64,
    /// Steps between two insertions: as many as a disc takes to clear the line.
    interval: u64,
    /// Discs to be inserted, the next one last.
    waiting: Vec<Disc>,
    /// Discs that have been inserted.
    pub(super) entered: u64,
    generator: Generator,
}

impl Insertion {
    /// The insertion of a manifest; `discs` have their ids, masses and materials.
    pub(super) fn new(
        config: &DemConfig,
        parameters: &Parameters,
        seed: Seed,
        mut discs: Vec<Disc>,
    ) -> Option<Self> {
        let insertion = config.insertion?;
        let [vx, vy] = insertion.velocity_m_per_s.map(|v| v.get());
        let clearing = 2.0 * parameters.radius_range.1 / (vx * vx + vy * vy).sqrt();
        let steps = (clearing / parameters.time_step).ceil() as u64;
        discs.reverse();
        Some(Self {
            line: [insertion.from_m, insertion.to_m].map(|end| end.map(|at| at.get())),
            velocity: parameters.integrator_velocity(config, [vx, vy]),
            rate: insertion.discs_per_s.get(),
            starts: insertion.starts_s.get(),
            interval: if steps > 0 { steps } else { 1 },
            waiting: discs,
            entered: 0,
            generator: seed.stream(Stream::Insertion),
        })
    }

    /// Whether numbers are finite and the waiting discs are the last of `total`.
    pub(super) fn is_valid(&self, total: u64) -> bool {
        let numbers = [self.velocity[0], self.velocity[1], self.rate, self.starts];
        let is_valid = |disc: &Disc| {
            u64::from(disc.id) < total
                && [disc.radius, disc.mass].iter().all(|size| size.is_finite() && *size > 0.0)
        };
        self.line.iter().flatten().chain(&numbers).all(|number| number.is_finite())
            && self.interval > 0
            && self.entered <= total
            && self.waiting.iter().all(is_valid)
    }

    /// Number of discs that are still to be inserted.
    pub(super) fn remaining(&self) -> u64 {
        self.waiting.len() as u64
    }

    /// Whether discs may be inserted after `count` steps.
    pub(super) fn is_open_at(&self, count: u64) -> bool {
        !self.waiting.is_empty() && count.is_multiple_of(self.interval)
    }

    /// The discs that are due and fit. The first one that does not fit is delayed, and so are all behind it.
    pub(super) fn due(
        &mut self,
        time: f64,
        discs: &Discs,
        walls: &[PlacedWall],
        parameters: &Parameters,
    ) -> Vec<Disc> {
        let due = if time < self.starts {
            0
        } else {
            // A rate without bound makes all discs due.
            (((time - self.starts) * self.rate).floor() as u64).saturating_add(1)
        };
        let mut entering: Vec<Disc> = Vec::new();
        if due <= self.entered {
            return entering;
        }
        let nearby = self.near_the_line(discs, parameters);
        while self.entered < due
            && let Some(next) = self.waiting.last()
        {
            let is_free = |center: [f64; 2]| {
                let others = nearby.iter().copied();
                let new = entering.iter().map(|disc| (disc.position, disc.radius));
                start::overlapped_wall(walls, center, next.radius).is_none()
                    && others.chain(new).all(|(at, radius)| {
                        let separation = parameters.separation(center, at);
                        let distance_squared = motion::distance_squared(separation);
                        !motion::is_closer(distance_squared, next.radius + radius)
                    })
            };
            let [from, to] = self.line;
            let position = (0..TRIALS).find_map(|_| {
                let fraction = self.generator.uniform();
                let along = |axis: usize| from[axis] + fraction * (to[axis] - from[axis]);
                let center = [along(0), along(1)];
                is_free(center).then_some(center)
            });
            let Some(position) = position else { break };
            entering.push(Disc { position, velocity: self.velocity, ..*next });
            self.waiting.pop();
            self.entered += 1;
        }
        entering
    }

    /// Centers and radii of the discs near the line.
    fn near_the_line(&self, discs: &Discs, parameters: &Parameters) -> Vec<([f64; 2], f64)> {
        let reach = 2.0 * parameters.radius_range.1;
        let [from, to] = self.line;
        let is_near = |at: [f64; 2]| {
            let near = |axis: usize| {
                let mut ends = [from[axis], to[axis]];
                ends.sort_by(f64::total_cmp);
                let [low, high] = [ends[0] - reach, ends[1] + reach];
                parameters.periodic[axis] || (at[axis] >= low && at[axis] <= high)
            };
            near(0) && near(1)
        };
        let all = (0..discs.len()).map(|disc| (discs.positions[disc], discs.radii[disc]));
        all.filter(|&(at, _)| is_near(at)).collect()
    }
}

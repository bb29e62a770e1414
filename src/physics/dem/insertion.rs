//! Discs that fall in while it runs: one after the other, in the order of their ids, at random on a line where there is room.

use crate::dem::discs::{Disc, Discs};
use crate::dem::parameters::Parameters;
use crate::dem::start;
use crate::dem::walls::PlacedWall;
use crate::random::{Generator, Seed, Stream};
use kinetoscope_manifest::model::{DemConfig, DemIntegrator};
use serde::{Deserialize, Serialize};

/// Places that are tried for a disc at one opening.
const TRIALS: u32 = 20;

/// The discs that are still to come.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Rain {
    /// The two ends of the line of entry, m.
    line: [[f64; 2]; 2],
    /// The integrator's velocity of a disc that enters, m/s.
    velocity: [f64; 2],
    /// Discs due in a second.
    rate: f64,
    /// When the first is due, s.
    starts: f64,
    /// Steps from one opening to the next: as many as a disc takes to clear the line.
    interval: u64,
    /// Discs to come, the next one last.
    waiting: Vec<Disc>,
    /// Discs that have come.
    pub(super) entered: u64,
    generator: Generator,
}

impl Rain {
    /// The rain of a manifest; `discs` come with their ids, masses and materials, in their order.
    pub(super) fn new(
        config: &DemConfig,
        parameters: &Parameters,
        seed: Seed,
        discs: impl DoubleEndedIterator<Item = Disc>,
    ) -> Option<Self> {
        let rain = config.rain?;
        let [vx, vy] = rain.velocity_m_per_s.map(|v| v.get());
        let clearing = 2.0 * parameters.radius_range.1 / (vx * vx + vy * vy).sqrt();
        let steps = (clearing / parameters.time_step).ceil() as u64;
        // Velocity Verlet's own velocities stand half a step behind, see `step`. Nothing overlaps, so a is gravity.
        let back = match config.integrator {
            DemIntegrator::VelocityVerlet => 0.5 * parameters.time_step,
            DemIntegrator::SemiImplicitEuler | DemIntegrator::ImplicitDashpot => 0.0,
        };
        Some(Self {
            line: [rain.from_m, rain.to_m].map(|end| end.map(|at| at.get())),
            velocity: [vx - parameters.gravity[0] * back, vy - parameters.gravity[1] * back],
            rate: rain.discs_per_s.get(),
            starts: rain.starts_s.get(),
            interval: if steps > 0 { steps } else { 1 },
            waiting: discs.rev().collect(),
            entered: 0,
            generator: seed.stream(Stream::Rain),
        })
    }

    /// Discs that are still to come.
    pub(super) fn to_come(&self) -> u64 {
        self.waiting.len() as u64
    }

    /// Whether discs may enter after so many steps.
    pub(super) fn opens_at(&self, count: u64) -> bool {
        !self.waiting.is_empty() && count.is_multiple_of(self.interval)
    }

    /// The discs that are due and find room. The first that finds none waits, and with it all behind it.
    pub(super) fn entering(
        &mut self,
        time: f64,
        discs: &Discs,
        walls: &[PlacedWall],
        parameters: &Parameters,
    ) -> Vec<Disc> {
        let due = if time < self.starts {
            0
        } else {
            ((time - self.starts) * self.rate).floor() as u64 + 1
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
                        let [x, y] = parameters.apart(center, at);
                        let reach = next.radius + radius;
                        x * x + y * y >= reach * reach
                    })
            };
            let [from, to] = self.line;
            let place = (0..TRIALS).find_map(|_| {
                let share = self.generator.uniform();
                let along = |axis: usize| from[axis] + share * (to[axis] - from[axis]);
                let center = [along(0), along(1)];
                is_free(center).then_some(center)
            });
            let Some(position) = place else { break };
            entering.push(Disc { position, velocity: self.velocity, ..*next });
            self.waiting.pop();
            self.entered += 1;
        }
        entering
    }

    /// Centers and radii of the discs that may stand in the way.
    fn near_the_line(&self, discs: &Discs, parameters: &Parameters) -> Vec<([f64; 2], f64)> {
        let reach = 2.0 * parameters.radius_range.1;
        let [from, to] = self.line;
        let is_near = |at: [f64; 2]| {
            let near = |axis: usize| {
                let (low, high) = if from[axis] < to[axis] {
                    (from[axis], to[axis])
                } else {
                    (to[axis], from[axis])
                };
                parameters.periodic[axis] || (at[axis] >= low - reach && at[axis] <= high + reach)
            };
            near(0) && near(1)
        };
        let all = (0..discs.len()).map(|disc| (discs.positions[disc], discs.radii[disc]));
        all.filter(|&(at, _)| is_near(at)).collect()
    }
}

//! A run with a twin: a second run of the same system, whose distance is reduced to its first value at fixed steps. The sum of the
//! logarithms of what it had grown by gives the largest Lyapunov exponent (Benettin, Galgani and Strelcyn, Phys. Rev. A 14 (1976) 2338).
//!
//! The run itself has the bits that it has without a twin, unless the twin fails: then the run ends with its fault.

use crate::model::{Extent, Model, ModelKind, Progress, SetupError, SimulationFault, Target};
use crate::random::Seed;
use kinetoscope_recording::channels::{ChannelDeclaration, Divergence};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::scenery::Scenery;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Differences or displacements of positions and of velocities, in the order of the particles' numbers.
pub(crate) type Offset = [Vec<f64>; 2];

/// A model whose particles can be displaced.
pub(crate) trait Displaceable:
    Model + Clone + Serialize + DeserializeOwned + 'static
{
    /// Positions and velocities relative to those of another state of the same particles. Through periodic sides, the shortest way counts.
    fn offset_from(&self, other: &Self) -> Offset;

    /// Displaces all particles.
    fn displace(&mut self, by: &Offset);

    /// The largest coordinate.
    fn size(&self) -> f64;
}

/// A model with its twin.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound = "M: Displaceable")]
pub(crate) struct Twins<M> {
    model: M,
    twin: M,
    /// Distance of the positions at the start, and after each reduction.
    distance: f64,
    /// Logarithm of the factor by which the distance was reduced since the start.
    logarithm: f64,
}

/// Steps between two reductions.
const STEPS: u64 = 64;
/// Displacement of a coordinate over the largest one: rounding errors are far smaller, and growth in [`STEPS`] steps is linear.
const DISPLACEMENT: f64 = 1e-9;

impl<M: Displaceable> Twins<M> {
    /// A model at its start, with a twin whose positions are displaced in all directions.
    pub(crate) fn of(model: M) -> Self {
        let mut twin = model.clone();
        let count = model.offset_from(&model)[0].len();
        let scale = DISPLACEMENT * model.size();
        let displaced = (0..count).map(|number| scale * libm::cos(2.4 * number as f64));
        twin.displace(&[displaced.collect(), vec![0.0; count]]);
        let distance = norm(&twin.offset_from(&model)[0]);
        Self { model, twin, distance, logarithm: 0.0 }
    }

    /// Restores a model with its twin from a checkpoint's bytes.
    pub(crate) fn restored(config: &M::Config, bytes: &[u8]) -> Option<Box<dyn Model>> {
        let twins = kinetoscope_recording::checkpoint::decode_content::<Self>(bytes)?;
        if twins.is_valid_for(config) { Some(Box::new(twins)) } else { None }
    }

    /// Logarithm of the growth since the start.
    fn growth(&self) -> f64 {
        self.logarithm + libm::log(norm(&self.twin.offset_from(&self.model)[0]) / self.distance)
    }

    /// Reduces the distance to its first value. The rest of the twin's state, such as tangential springs, becomes that of the run.
    fn reduce(&mut self) {
        let offset = self.twin.offset_from(&self.model);
        let grown = norm(&offset[0]) / self.distance;
        if grown > 0.0 && grown.is_finite() {
            self.logarithm += libm::log(grown);
            self.twin = self.model.clone();
            self.twin.displace(&offset.map(|of| of.iter().map(|part| part / grown).collect()));
        }
    }
}

impl<M: Displaceable> Model for Twins<M> {
    type Config = M::Config;

    fn kind() -> &'static ModelKind {
        M::kind()
    }

    fn prepare(config: &M::Config, seed: Seed, opt_in: bool) -> Result<Self, SetupError> {
        M::prepare(config, seed, opt_in).map(Self::of)
    }

    fn is_valid_for(&self, config: &M::Config) -> bool {
        let both = [&self.model, &self.twin];
        both.into_iter().all(|model| model.is_valid_for(config))
            && self.twin.count() == self.model.count()
            && self.twin.offset_from(&self.model)[0].len()
                == self.model.offset_from(&self.model)[0].len()
            && self.distance.is_normal()
            && self.logarithm.is_finite()
    }

    fn channels(&self) -> &'static [ChannelDeclaration] {
        self.model.channels()
    }

    fn extent(&self) -> Extent {
        self.model.extent()
    }

    /// The run proceeds as without a twin, and the twin follows. Reductions are at multiples of [`STEPS`], however the work is divided.
    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, SimulationFault> {
        let budget = at_most.max(1);
        let mut used = 0;
        loop {
            let before = self.model.count();
            let steps = (STEPS - before % STEPS).min(budget - used);
            let progress = self.model.advance(target, steps)?;
            let goal = self.model.count();
            while self.twin.advance(Target::Count(goal), steps)? == Progress::Working {}
            if goal > before && goal.is_multiple_of(STEPS) {
                self.reduce();
            }
            used += steps;
            if progress == Progress::Reached || used >= budget {
                return Ok(progress);
            }
        }
    }

    fn count(&self) -> u64 {
        self.model.count()
    }

    fn time(&self) -> f64 {
        self.model.time()
    }

    fn observe(&self, frame: &mut Frame) {
        self.model.observe(frame);
        frame.push(&Divergence { logarithm: self.growth() });
    }

    fn scenery(&self) -> Scenery {
        self.model.scenery()
    }
}

fn norm(parts: &[f64]) -> f64 {
    parts.iter().map(|part| part * part).sum::<f64>().sqrt()
}

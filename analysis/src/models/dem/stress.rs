//! Stress in a bed by height, derived from the contact forces.
//!
//! The stress of Love (1927) and Weber (1966), averaged over a layer with the area A, compression positive:
//!
//! sigma_ab = (1/A) [ sum over contacts f_a l_b + sum over discs m u_a u_b ],
//!
//! f is the force on a disc. l is the branch to its center from the center of the touched disc, or from the wall,
//! limited to the part within the layer. u is the velocity relative to the mean of the layer (Goldhirsch 2010). For
//! discs at rest between frictionless walls, the balance of forces at every height gives sigma_yy exactly: the weight
//! of the discs whose centers are above, over the width.

use super::disc::Disc;
use super::special_setups::has_floor;
use crate::statistics::{Blocking, Entries, Estimate, MissingError};
use kinetoscope_manifest::model::{DemConfig, DemWall, DemWallShape};
use kinetoscope_recording::channels::DemContactForces;
use std::f64::consts::TAU;

/// Maximum number of layers.
const MAX_LAYERS: f64 = 200.0;
/// Fraction of the run's duration after which frames are averaged.
const AVERAGED_FROM: f64 = 0.9;
/// Minimum number of averaged frames for an error: enough for the mean over frames to be that over time.
const MIN_FRAMES: u64 = 64;
/// Fraction of the averaged interval that counts as one of its ends.
const END_FRACTION: f64 = 0.2;

/// Stress in a layer of the bed, averaged over frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StressLayer {
    /// Height of the layer's middle above the floor, m.
    pub(crate) height_m: f64,
    /// sigma_yy, N/m.
    pub(crate) vertical: Estimate,
    /// sigma_xx, N/m.
    pub(crate) horizontal: f64,
    /// Weight of the discs above, divided by the width, N/m, averaged over the layer's heights.
    pub(crate) weight_above: f64,
}

/// Stress in layers one mean diameter thick, averaged over the last tenth of a run.
#[derive(Clone, Debug)]
pub(crate) struct StressProfile {
    width: f64,
    thickness: f64,
    /// Downward acceleration of gravity, m/s^2.
    gravity: f64,
    /// Begin and length of the averaged interval, s.
    since_s: f64,
    averaged_s: f64,
    layers: Vec<LayerMeans>,
    lateral_ratio: FrameMean,
    /// The same by blocks, for its error.
    lateral_blocks: Blocking,
}

#[derive(Clone, Debug, Default)]
struct LayerMeans {
    vertical: FrameMean,
    horizontal: FrameMean,
    weight: FrameMean,
    /// Squared vertical momentum of the discs above, in the first and in the last part of the averaged interval.
    squared_momentum: [FrameMean; 2],
}

/// Mean over frames.
#[derive(Clone, Copy, Debug, Default)]
struct FrameMean {
    frames: u64,
    sum: f64,
}

impl FrameMean {
    fn add(&mut self, value: f64) {
        self.frames += 1;
        self.sum += value;
    }

    fn mean(self) -> Option<f64> {
        (self.frames > 0).then(|| self.sum / self.frames as f64)
    }
}

/// Contribution of one frame to a layer: sums of f l in N m, kinetic sums, and weight.
#[derive(Clone, Copy, Debug, Default)]
struct LayerSums {
    branches: [f64; 2],
    mass: f64,
    momentum: [f64; 2],
    twice_kinetic: [f64; 2],
    /// Weight of the layer's discs, N, and the same weighted by the fraction of the layer below their centers.
    weight: f64,
    weight_over_layer: f64,
    /// The same of the vertical momentum, kg m/s.
    momentum_over_layer: f64,
}

impl StressProfile {
    /// Creates an empty profile; `None` if the box does not support the bed.
    pub(super) fn new(config: &DemConfig) -> Option<Self> {
        let gravity = -config.gravity_m_per_s2[1].get();
        floor_m(config, 0.0).filter(|_| has_floor(config) && gravity > 0.0)?;
        let height = config.height_m.get();
        let thickness = (2.0 * config.radius_m.mean()).max(height / MAX_LAYERS);
        let count = (height / thickness).ceil().max(1.0) as usize;
        Some(Self {
            width: config.width_m.get(),
            thickness,
            gravity,
            since_s: AVERAGED_FROM * config.duration_s.get(),
            averaged_s: (1.0 - AVERAGED_FROM) * config.duration_s.get(),
            layers: vec![LayerMeans::default(); count],
            lateral_ratio: FrameMean::default(),
            lateral_blocks: Blocking::of(Entries::AveragedFrames),
        })
    }

    /// Adds a frame; frames before the last tenth of the run are ignored.
    pub(super) fn add_frame(
        &mut self,
        time_s: f64,
        floor: f64,
        discs: impl Iterator<Item = Disc>,
        forces: &DemContactForces,
    ) {
        if time_s < self.since_s {
            return;
        }
        let mut sums = vec![LayerSums::default(); self.layers.len()];
        for disc in discs {
            self.add_disc(&mut sums, floor, &disc);
        }
        for contact in 0..forces.from_x_m.len() {
            self.add_contact(&mut sums, floor, forces, contact);
        }
        self.add_sums(time_s, &sums);
    }

    /// Index of the layer at a height above the floor, limited to the existing layers.
    fn layer_at(&self, height: f64) -> usize {
        ((height / self.thickness).max(0.0) as usize).min(self.layers.len() - 1)
    }

    fn add_disc(&self, sums: &mut [LayerSums], floor: f64, disc: &Disc) {
        let height = disc.position[1] - floor;
        let layer = self.layer_at(height);
        let sum = &mut sums[layer];
        let weight = disc.mass * self.gravity;
        sum.mass += disc.mass;
        sum.weight += weight;
        let share = height / self.thickness - layer as f64;
        sum.weight_over_layer += weight * share;
        sum.momentum_over_layer += disc.mass * disc.velocity[1] * share;
        for axis in [0, 1] {
            let momentum = disc.mass * disc.velocity[axis];
            sum.momentum[axis] += momentum;
            sum.twice_kinetic[axis] += momentum * disc.velocity[axis];
        }
    }

    fn add_contact(
        &self,
        sums: &mut [LayerSums],
        floor: f64,
        forces: &DemContactForces,
        contact: usize,
    ) {
        let [from, to] = [forces.from_y_m[contact] - floor, forces.to_y_m[contact] - floor];
        let across = forces.from_x_m[contact] - forces.to_x_m[contact];
        let products =
            [forces.force_x_n[contact] * across, forces.force_y_n[contact] * (from - to)];
        let (low, high) = if from < to { (from, to) } else { (to, from) };
        let [first, last] = [low, high].map(|height| self.layer_at(height));
        for (layer, sum) in sums.iter_mut().enumerate().take(last + 1).skip(first) {
            let bottom = layer as f64 * self.thickness;
            let within = high.min(bottom + self.thickness) - low.max(bottom);
            // A horizontal branch lies in one layer.
            let fraction = if first == last { 1.0 } else { within / (high - low) };
            sum.branches[0] += fraction * products[0];
            sum.branches[1] += fraction * products[1];
        }
    }

    fn add_sums(&mut self, time_s: f64, sums: &[LayerSums]) {
        let area = self.width * self.thickness;
        let share = (time_s - self.since_s) / self.averaged_s;
        let (mut above, mut momentum_above, mut whole) = (0.0, 0.0, [0.0; 2]);
        for (means, sum) in self.layers.iter_mut().zip(sums).rev() {
            let stress = [0, 1].map(|axis: usize| {
                let square = sum.momentum[axis] * sum.momentum[axis];
                let mean_flow = if sum.mass > 0.0 { square / sum.mass } else { 0.0 };
                (sum.branches[axis] + sum.twice_kinetic[axis] - mean_flow) / area
            });
            means.horizontal.add(stress[0]);
            means.vertical.add(stress[1]);
            means.weight.add((above + sum.weight_over_layer) / self.width);
            let momentum = momentum_above + sum.momentum_over_layer;
            for (end, squares) in means.squared_momentum.iter_mut().enumerate() {
                let apart = if end == 0 { share } else { 1.0 - share };
                if apart < END_FRACTION {
                    squares.add(momentum * momentum);
                }
            }
            above += sum.weight;
            momentum_above += sum.momentum[1];
            whole = [whole[0] + stress[0], whole[1] + stress[1]];
        }
        if whole[1] > 0.0 {
            self.lateral_ratio.add(whole[0] / whole[1]);
            self.lateral_blocks.add(whole[0] / whole[1]);
        }
    }

    /// The layers with discs, from the floor upwards; empty if no frame was averaged.
    pub(crate) fn layers(&self) -> Vec<StressLayer> {
        let layers = self.layers.iter().enumerate().map_while(|(layer, means)| {
            let weight_above = means.weight.mean()?;
            let stress = StressLayer {
                height_m: (layer as f64 + 0.5) * self.thickness,
                vertical: self.vertical(means)?,
                horizontal: means.horizontal.mean()?,
                weight_above,
            };
            (weight_above > 0.0).then_some(stress)
        });
        layers.collect()
    }

    /// Mean sigma_yy of a layer. Its time average differs from the weight above by the change of the momentum above over
    /// the averaged time. The momentum oscillates with a phase at random, so the conditional error results from its mean
    /// squares near the two ends. Other seeds give other beds, whose scatter is unknown.
    fn vertical(&self, means: &LayerMeans) -> Option<Estimate> {
        let value = Estimate::bare(means.vertical.mean()?);
        let has = means.vertical.frames;
        if has < MIN_FRAMES {
            let entries = Entries::AveragedFrames;
            let too_few = MissingError::TooFewEntries { entries, needs: MIN_FRAMES, has };
            return Some(value.without_error(too_few));
        }
        let [first, last] = means.squared_momentum.map(FrameMean::mean);
        let error = (first? + last?).sqrt() / (self.averaged_s * self.width);
        Some(Estimate::new(value.value, error).with_unknown_scatter_of_starts())
    }

    /// Ratio of sigma_xx to sigma_yy of the whole bed. Its error, by blocking, is that for a given start.
    pub(super) fn lateral_ratio(&self) -> Option<Estimate> {
        let ratio = self.lateral_ratio.mean()?;
        Some(Estimate::given_the_start(ratio, self.lateral_blocks.estimate()))
    }
}

/// Height of the floor, m: that of the box, or of the manifest's only wall if it is horizontal and as wide as the box.
/// `None` if other walls also support the discs.
pub(super) fn floor_m(config: &DemConfig, time_s: f64) -> Option<f64> {
    match config.walls.as_slice() {
        [] => Some(0.0),
        [wall] => {
            let [from, to] = segment_at(wall, time_s)?;
            let (left, right) = (from[0].min(to[0]), from[0].max(to[0]));
            let spans = left <= 0.0 && right >= config.width_m.get();
            (spans && from[1] == to[1]).then_some(from[1])
        }
        _ => None,
    }
}

/// Ends of a straight wall at a time, displaced by u t + A sin(2 pi f t), where t advances only while the wall moves; `None`
/// for a drum. The stress needs the floor also in recordings without scenes.
fn segment_at(wall: &DemWall, time_s: f64) -> Option<[[f64; 2]; 2]> {
    let DemWallShape::Segment { from_m, to_m } = wall.shape else { return None };
    let clock = match wall.moves_s {
        Some([begin, end]) => time_s.clamp(begin.get(), end.get()) - begin.get(),
        None => time_s,
    };
    let phase = libm::sin(TAU * wall.frequency_hz.get() * clock);
    Some([from_m, to_m].map(|end| {
        std::array::from_fn(|axis| {
            let velocity = wall.velocity_m_per_s[axis].get();
            end[axis].get() + velocity * clock + wall.amplitude_m[axis].get() * phase
        })
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinetoscope_manifest::quantity::{Finite, NonNegative};

    /// Setup: a wall with u = (1, 0) m/s that moves only between 0.1 s and 0.3 s.
    #[test]
    fn a_wall_moves_only_in_its_interval() {
        let [zero, one] = [0.0, 1.0].map(Finite::literal);
        let wall = DemWall {
            shape: DemWallShape::Segment { from_m: [zero; 2], to_m: [zero, one] },
            velocity_m_per_s: [one, zero],
            amplitude_m: [zero; 2],
            frequency_hz: NonNegative::literal(0.0),
            moves_s: Some([0.1, 0.3].map(NonNegative::literal)),
        };
        for (time, x) in [(0.0, 0.0), (0.1, 0.0), (0.2, 0.1), (0.3, 0.2), (5.0, 0.2)] {
            let [[from, _], _] = segment_at(&wall, time).unwrap();
            assert!((from - x).abs() < 1e-15, "{time}: {from}");
        }
    }
}

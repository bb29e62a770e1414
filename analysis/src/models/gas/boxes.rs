//! Change of the entropy by boxes, by free expansion of a gas behind a partition or by mixing.

use super::box_entropy::expected;
use super::laws::has_partition_through_center;
use super::metrics as metric;
use super::observe::GasRun;
use crate::metric::theory::ExpectedValue;
use crate::metric::{Measurements, Quantity};
use crate::statistics::Estimate;

/// Container crossings at the rms speed after which the gas has filled the container.
const CROSSINGS_TO_FILL: f64 = 50.0;

/// Container crossings up to which a particle is taken to be where it started.
const CROSSINGS_TO_MOVE: f64 = 5.0;

impl GasRun {
    /// Entropy per particle over k_B that is missing because particles are too slow to have moved: of a species of which a fraction f
    /// is still on its side of the center, the densities are 1 + f and 1 - f, and f^2/2 is missing. `None` without velocities.
    fn entropy_of_unmoved(&self, open_s: f64) -> Option<f64> {
        let state = self.snapshots.last()?;
        let slowest = CROSSINGS_TO_MOVE * 2.0 * self.config.radius_m.get() / open_s;
        let mut species = vec![[0.0; 2]; 1 + self.config.additional_masses_kg.len()];
        for (id, (vx, vy)) in state.column("vx")?.zip(state.column("vy")?).enumerate() {
            let [members, unmoved] = &mut species[self.config.species_of(id)];
            *members += 1.0;
            *unmoved += f64::from(u8::from(vx * vx + vy * vy < slowest * slowest));
        }
        let missing = |[members, unmoved]: &[f64; 2]| unmoved * unmoved / (2.0 * members);
        let present = species.iter().filter(|[members, _]| *members > 0.0);
        Some(present.map(missing).sum::<f64>() / state.rows() as f64)
    }

    /// Adds the entropy by boxes and the change of the temperature, which is zero if only specular reflections occur.
    pub(super) fn measure_boxes(&self, found: &mut Measurements) {
        let Some(partition) = self.config.partition else { return };
        if self.config.keeps_energy() && self.config.orifice_width_m.is_none() {
            found.compare(metric::TEMPERATURE_MAX_CHANGE, self.max_temperature_change, 0.0);
        } else {
            found.add(metric::TEMPERATURE_MAX_CHANGE, self.max_temperature_change);
        }
        let ends = (self.box_entropy.first(), self.box_entropy.last());
        let (Some(&(_, first)), Some(&(_, last))) = ends else { return };
        let Some([start, start_error, change, change_error]) = expected(&self.config) else {
            found.add(metric::BOX_ENTROPY_AT_START, first);
            found.add(metric::BOX_ENTROPY_CHANGE, last - first);
            return;
        };
        found.compare(metric::BOX_ENTROPY_AT_START, Estimate::new(first, Some(start_error)), start);
        let open_s = partition.opens_s.map_or(0.0, |opens| self.time_s - opens.get());
        let rms = self.mean_square().map_or(0.0, f64::sqrt);
        let crossings = rms * open_s / (2.0 * self.config.radius_m.get());
        let unmoved = self.entropy_of_unmoved(open_s);
        let missing = unmoved.map_or(f64::NAN, |missing| missing / change_error);
        let is_central = has_partition_through_center(&self.config);
        let violation = (Quantity::CrossingsSinceRemoval.at_least(crossings, CROSSINGS_TO_FILL))
            .or_else(|| Quantity::EntropyOfSlowParticles.at_most(missing, 0.5))
            .or_else(|| Quantity::CentralPartition.required(is_central));
        // A partition that stays changes nothing, up to the scatter of both entropies.
        let value = if partition.opens_s.is_some() { change } else { 0.0 };
        let violation = violation.filter(|_| partition.opens_s.is_some());
        let theory = ExpectedValue { value, accuracy: None, violation };
        let change = Estimate::new(last - first, Some(change_error));
        found.compare(metric::BOX_ENTROPY_CHANGE, change, theory);
    }
}

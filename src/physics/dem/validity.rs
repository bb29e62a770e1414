//! Whether a state that was restored from a checkpoint is possible, so that no later step panics.

use super::insertion::Insertion;
use super::parameters::Parameters;
use super::{Dem, Window};
use kinetoscope_manifest::model::DemConfig;

impl Dem {
    /// Whether the state can be one of a run with this configuration.
    pub(super) fn is_valid_state(&self, config: &DemConfig) -> bool {
        let records_forces = self.parameters.records_forces;
        let parameters = Parameters { records_forces, ..Parameters::new(config) };
        let inserted = config.insertion.map_or(0, |insertion| u64::from(insertion.discs.get()));
        let total = u64::from(config.discs.get()) + inserted;
        let walls = parameters.walls.len();
        let waiting = self.insertion.as_ref().map_or(0, Insertion::remaining);
        let present = self.discs.len() as u64;
        self.parameters == parameters
            && present.checked_add(waiting).and_then(|sum| sum.checked_add(self.removed))
                == Some(total)
            && (self.removed == 0 || parameters.outlet_below.is_some())
            && self.insertion.is_some() == config.insertion.is_some()
            && self.insertion.as_ref().is_none_or(|insertion| insertion.is_valid(total))
            && self.count <= parameters.total_steps
            && self.discs.is_valid(total, parameters.law.materials.of_discs())
            && self.neighbors.is_valid_for(&self.discs, &parameters)
            && self.balance.is_valid(walls)
            && self.window.is_valid(walls)
            && self.initial_top_speed.is_finite()
    }
}

impl Window {
    fn is_valid(&self, walls: usize) -> bool {
        self.max_overlap.is_finite()
            && [0, walls].contains(&self.wall_forces.len())
            && self.wall_forces.iter().flatten().all(|force| force.is_finite())
            && self.steps < u64::MAX / 2
    }
}

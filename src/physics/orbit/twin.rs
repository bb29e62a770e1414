//! Displaced bodies, for a twin of a run. A planet around the fixed Sun has none: its motion is regular.

use super::trajectory::Trajectory;
use super::{Orbit, System};
use crate::model::Model as _;
use crate::twins::{Displaceable, Offset};

impl Displaceable for Orbit {
    fn offset_from(&self, other: &Self) -> Offset {
        let [Some(one), Some(other)] = [self, other].map(Orbit::bodies_phase) else {
            return Offset::default();
        };
        let differences =
            |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a - b).collect();
        [differences(&one.position, &other.position), differences(&one.velocity, &other.velocity)]
    }

    fn displace(&mut self, [ways, changes]: &Offset) {
        let time = self.discretization.time_at(self.count());
        let System::Bodies(bodies) = &mut self.system else { return };
        let Trajectory { phase, .. } = &mut bodies.trajectory;
        for (column, by) in [(&mut phase.position, ways), (&mut phase.velocity, changes)] {
            column.iter_mut().zip(by).for_each(|(component, by)| *component += by);
        }
        bodies.trajectory.restart_at(time);
    }

    fn size(&self) -> f64 {
        let position = self.bodies_phase().map_or(&[] as &[f64], |phase| &phase.position);
        let larger = |most: f64, next: &f64| if next.abs() > most { next.abs() } else { most };
        position.iter().fold(0.0, larger)
    }
}

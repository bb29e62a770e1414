//! What a frame shows of the discs. Looking computes forces anew and changes nothing.

use super::Dem;
use super::contacts::Contact;
use super::energy::Energies;
use super::parameters::Parameters;
use super::step::Evaluation;
use kinetoscope_recording::channels::{DemContacts, DemEnergy, DemEnergyShare, DemTemperature};
use kinetoscope_recording::frame::{ContactLine, Frame, Level};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};

/// Discs up to which velocities are drawn as arrows.
const MOST_ARROWS: usize = 100;
/// Upper end of the colour bar over the speed of a fall through the whole box: few discs fall that deep.
const SPEED_RANGE: f64 = 0.75;

impl Dem {
    /// Forces at the present state, found without touching it.
    pub(super) fn evaluate(&self) -> Evaluation {
        let mut evaluation = Evaluation::default();
        evaluation.update(&self.discs, &self.parameters);
        evaluation
    }

    pub(super) fn fill(&self, frame: &mut Frame) {
        let evaluation = self.evaluate();
        let velocities = evaluation.velocities_at_positions(&self.discs, self.parameters.time_step);
        if self.count == 0 {
            for fact in &self.facts {
                frame.log(Level::Info, fact.as_str());
            }
            for warning in &self.warnings {
                frame.log(Level::Warning, warning.as_str());
            }
        }
        for (disc, &[vx, vy]) in velocities.iter().enumerate() {
            let [x, y] = self.discs.positions[disc];
            let [vx_step, vy_step] = self.discs.velocities[disc];
            frame.push_state(&[x, y, vx, vy, vx_step, vy_step, self.discs.radii[disc]]);
        }
        self.push_energy(frame, &evaluation, &velocities);
        self.push_contacts(frame, &evaluation);
        frame.push(&temperature(&velocities));
    }

    fn push_energy(&self, frame: &mut Frame, evaluation: &Evaluation, velocities: &[[f64; 2]]) {
        let energies = self.energies(evaluation, velocities);
        // The power of a step counts half before and half after the positions' time.
        let half_step = 0.5 * self.parameters.time_step;
        let dissipated =
            self.dissipated.value() + evaluation.dissipated_power(&self.parameters) * half_step;
        // The walls are at rest.
        let wall_work = 0.0;
        let total = energies.total();
        let residual = total + dissipated - wall_work - self.initial_energy;
        frame.push(&DemEnergy {
            kinetic_j: energies.kinetic,
            gravitational_j: energies.gravitational,
            elastic_j: energies.elastic,
            dissipated_j: dissipated,
            wall_work_j: wall_work,
            total_j: total,
            residual_j: residual,
        });
        let scale = self.initial_energy.abs();
        let share = |energy: f64| if scale > 0.0 { energy / scale } else { 0.0 };
        frame.push(&DemEnergyShare {
            kinetic_percent: 100.0 * share(energies.kinetic),
            gravitational_percent: 100.0 * share(energies.gravitational),
            elastic_percent: 100.0 * share(energies.elastic),
            dissipated_percent: 100.0 * share(dissipated),
            residual_ppm: 1e6 * share(residual),
        });
    }

    fn push_contacts(&self, frame: &mut Frame, evaluation: &Evaluation) {
        let (mut pairs, mut walls) = (0_u64, 0_u64);
        for contact in &evaluation.contacts {
            if contact.partner.is_some() {
                pairs += 1;
            } else {
                walls += 1;
            }
            frame.push_contact(self.line(contact));
        }
        let now = evaluation.largest_overlap();
        let before = self.window.largest_overlap;
        frame.push(&DemContacts {
            pair_contacts: pairs,
            wall_contacts: walls,
            coordination_number: (2 * pairs + walls) as f64 / self.discs.positions.len() as f64,
            largest_overlap_over_radius: if now > before { now } else { before },
        });
    }

    /// From the disc's centre to the partner's, or to the foot on the wall.
    fn line(&self, contact: &Contact) -> ContactLine {
        let disc = contact.disc as usize;
        let from = self.discs.positions[disc];
        let to = match contact.partner {
            Some(partner) => self.discs.positions[partner as usize],
            None => {
                let distance = self.discs.radii[disc] - contact.overlap;
                [from[0] - distance * contact.normal[0], from[1] - distance * contact.normal[1]]
            }
        };
        ContactLine { from, to, force: contact.force }
    }

    pub(super) fn energies(&self, evaluation: &Evaluation, velocities: &[[f64; 2]]) -> Energies {
        Energies::of(
            &self.discs,
            velocities,
            self.parameters.gravity,
            &evaluation.contacts,
            self.parameters.law.stiffness,
        )
    }

    pub(super) fn drawing(&self) -> Scenery {
        let parameters = &self.parameters;
        let sides = parameters.sides;
        let speed_squared =
            2.0 * parameters.deepest_fall() + self.initial_top_speed * self.initial_top_speed;
        let speed_range_top =
            if speed_squared > 0.0 { SPEED_RANGE * speed_squared.sqrt() } else { 1.0 };
        Scenery {
            walls: vec![Wall::Rectangle { min: [0.0, 0.0], max: sides }],
            view: [[0.0, 0.0], sides],
            drawn_radius: DrawnRadius::Column,
            speed_range_top,
            speed_unit: "m/s",
            arrows: self.discs.positions.len() <= MOST_ARROWS,
            force_range_top: Some(self.force_range_top(speed_range_top)),
            trail: false,
        }
    }

    /// The force of a hit, v sqrt(k m), and the weight of a column of discs lie far apart: their geometric mean shows the
    /// chains of a bed and does not drown in a hit. Without gravity, the hit alone.
    fn force_range_top(&self, speed: f64) -> f64 {
        let Parameters { gravity, mass, radius, sides, law, .. } = &self.parameters;
        let hit = speed * (law.stiffness * mass).sqrt();
        let layers = |side: f64| 1.0 + self.discs.radii.len() as f64 * 2.0 * radius / side;
        let weight =
            mass * (gravity[0].abs() * layers(sides[1]) + gravity[1].abs() * layers(sides[0]));
        if weight > 0.0 { (hit * weight).sqrt() } else { hit }
    }
}

/// Half of the mean square of v - <v>, and its root.
fn temperature(velocities: &[[f64; 2]]) -> DemTemperature {
    let count = velocities.len() as f64;
    let mean = velocities.iter().fold([0.0, 0.0], |sum, v| [sum[0] + v[0], sum[1] + v[1]]);
    let mean = [mean[0] / count, mean[1] / count];
    let squares = velocities.iter().fold(0.0, |sum, v| {
        let apart = [v[0] - mean[0], v[1] - mean[1]];
        sum + (apart[0] * apart[0] + apart[1] * apart[1])
    });
    let temperature = 0.5 * squares / count;
    DemTemperature {
        granular_temperature_m2_per_s2: temperature,
        thermal_speed_m_per_s: temperature.sqrt(),
    }
}

//! Frames: state, channels and drawing of the discs, with the forces of the next step.

use super::Dem;
use super::block::Partner;
use super::energy::{ClosedBalance, Energies};
use super::parameters::Parameters;
use super::step::{ContactStatistics, Evaluation};
use super::totals::Contact;
use super::walls::{PlacedWall, Shape};
use crate::model::Model as _;
use crate::simd::prefetch::prefetch_to_write;
use crate::simd::registers::Register as _;
use kinetoscope_recording::channels::{
    DemContactForces, DemContactStatistics, DemDiscForces, DemEnergy, DemEnergyPercent,
    DemTemperature, DemWalls,
};
use kinetoscope_recording::frame::{ContactLine, Frame, Level};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};

/// Number of discs up to which velocities are drawn as arrows.
const MAX_ARROWS: usize = 100;
/// Ends of the mark on a rotating drum over its radius.
const DRUM_MARK: [f64; 2] = [0.94, 1.06];
/// Discs after which a requested row is written.
const ROWS_AHEAD: usize = 16;
/// Upper end of the color bar over the speed of a fall through the whole box; few discs fall that far.
const SPEED_RANGE: f64 = 0.75;

impl Dem {
    /// Fills a frame.
    pub(super) fn fill(&self, frame: &mut Frame) {
        let records_forces = self.parameters.records_forces;
        let mut forces = DemContactForces::default();
        let evaluation = &self.evaluate_contacts(&mut |contact| {
            let line = self.line(contact);
            if records_forces {
                push_force(contact, &line, &mut forces);
                let [first, second] = self.ids_of(contact);
                forces.first_id.push(first);
                forces.second_id.push(second);
            }
            frame.push_contact(line);
        });
        if self.count == 0 {
            for fact in &self.facts {
                frame.log(Level::Info, fact.as_str());
            }
            for warning in &self.warnings {
                frame.log(Level::Warning, warning.as_str());
            }
        }
        if records_forces {
            frame.push(&forces);
            let component = |axis: usize| {
                self.discs.by_id().map(|disc| evaluation.forces[disc][axis]).collect()
            };
            frame.push(&DemDiscForces { force_x_n: component(0), force_y_n: component(1) });
        }
        // In a large bed, they take as much memory as the rows of the state, which follow.
        drop(forces);
        let rows = frame.resize_state(self.discs.len() * Self::kind().state_columns.len());
        let ((), (balance, temperature)) = rayon::join(
            || self.write_rows(rows, evaluation),
            || (self.balance_of(evaluation), temperature(&evaluation.velocities)),
        );
        if self.has_moving_walls() {
            self.drawn_walls(self.count).into_iter().for_each(|wall| frame.push_wall(wall));
        }
        self.push_energy(frame, balance);
        self.push_contacts(frame, evaluation);
        frame.push(&temperature);
    }

    /// Writes the rows in the order of the ids. The discs are read in the order of the memory: there is one scattered write per
    /// disc in place of a scattered read from each column.
    fn write_rows(&self, rows: &mut [f64], evaluation: &Evaluation) {
        let (rows, _) = rows.as_chunks_mut();
        let row_of = self.discs.rows_by_id();
        for (disc, &row) in row_of.iter().enumerate() {
            if let Some(&row) = row_of.get(disc + ROWS_AHEAD) {
                prefetch_to_write(rows, row as usize);
            }
            let [x, y] = self.within(self.discs.positions[disc]);
            let [vx, vy] = evaluation.velocities[disc];
            let [vx_step, vy_step] = self.discs.velocities[disc];
            let (radius, spin) = (self.discs.radii[disc], evaluation.spin(disc));
            let id = f64::from(self.discs.ids[disc]);
            let mass = self.discs.masses[disc];
            rows[row as usize] = [x, y, vx, vy, vx_step, vy_step, radius, spin, id, mass];
        }
    }

    /// A position inside the box: discs are wrapped around periodic sides only when the neighbor lists are built.
    fn within(&self, position: [f64; 2]) -> [f64; 2] {
        let Parameters { sides, periodic, .. } = &self.parameters;
        [0, 1].map(|axis: usize| {
            let is_inside = (0.0..sides[axis]).contains(&position[axis]);
            if !periodic[axis] || is_inside {
                return position[axis];
            }
            let turns = (position[axis] / sides[axis]).floor();
            if turns == 0.0 { position[axis] } else { position[axis] - turns * sides[axis] }
        })
    }

    fn push_energy(&self, frame: &mut Frame, (energies, balance): (Energies, ClosedBalance)) {
        let elastic = energies.elastic_normal + energies.elastic_tangential;
        frame.push(&DemEnergy {
            kinetic_j: energies.kinetic,
            gravitational_j: energies.gravitational,
            elastic_j: elastic,
            dissipated_j: balance.dissipated(),
            wall_work_j: balance.wall_work,
            total_j: energies.total(),
            residual_j: balance.residual,
            elastic_tangential_j: energies.elastic_tangential,
            friction_j: balance.friction,
            rolling_j: balance.rolling,
            removed_j: self.balance.removed.value(),
            entered_j: self.balance.entered.value(),
        });
        let scale = (self.balance.initial + self.balance.entered.value()).abs();
        let fraction = |energy: f64| if scale > 0.0 { energy / scale } else { 0.0 };
        frame.push(&DemEnergyPercent {
            kinetic_percent: 100.0 * fraction(energies.kinetic),
            gravitational_percent: 100.0 * fraction(energies.gravitational),
            elastic_percent: 100.0 * fraction(elastic),
            dissipated_percent: 100.0 * fraction(balance.dissipated()),
            residual_ppm: 1e6 * fraction(balance.residual),
            wall_work_percent: 100.0 * fraction(balance.wall_work),
            removed_percent: 100.0 * fraction(self.balance.removed.value()),
            reference_energy_uj: 1e6 * scale,
        });
        // Before the first step, there are no sums.
        let mean = |axis: usize, wall: usize| {
            let sums = self.window.wall_forces.get(wall);
            sums.map_or(f64::NAN, |sum| sum[axis] / self.window.steps as f64)
        };
        let walls = 0..self.parameters.walls.len();
        frame.push(&DemWalls {
            mean_force_x_n: walls.clone().map(|wall| mean(0, wall)).collect(),
            mean_force_y_n: walls.map(|wall| mean(1, wall)).collect(),
            work_j: balance.walls,
            discs_removed: self.removed,
            discs_entered: self.insertion.as_ref().map_or(0, |all| all.entered),
        });
    }

    fn push_contacts(&self, frame: &mut Frame, evaluation: &Evaluation) {
        let ContactStatistics { pairs, walls, max_overlap: now, .. } = evaluation.contacts;
        frame.push(&DemContactStatistics {
            pair_contacts: pairs,
            wall_contacts: walls,
            coordination_number: (2 * pairs + walls) as f64 / Ord::max(self.discs.len(), 1) as f64,
            max_overlap_over_radius: now.larger(self.window.max_overlap),
        });
    }

    /// The numbers of the touching discs; for a wall, twice that of the disc.
    fn ids_of(&self, contact: &Contact) -> [u64; 2] {
        let second = match contact.partner {
            Partner::Disc(other) => other,
            Partner::Wall(_) => contact.disc,
        };
        [contact.disc, second].map(|disc| self.discs.ids[disc as usize].into())
    }

    /// The line from the disc's center to the partner's (or its image beyond a periodic side), or to the wall.
    fn line(&self, contact: &Contact) -> ContactLine {
        let from = self.within(self.discs.positions[contact.disc as usize]);
        let [x, y] = contact.separation;
        ContactLine { from, to: [from[0] - x, from[1] - y], force: contact.normal_force }
    }

    /// The scenery of the whole run.
    pub(super) fn drawing(&self) -> Scenery {
        let parameters = &self.parameters;
        let sides = parameters.sides;
        let speed_squared =
            2.0 * parameters.max_fall() + self.initial_top_speed * self.initial_top_speed;
        let speed_range_top =
            if speed_squared > 0.0 { SPEED_RANGE * speed_squared.sqrt() } else { 1.0 };
        Scenery {
            walls: self.drawn_walls(0),
            view: [[0.0, 0.0], sides],
            drawn_radius: DrawnRadius::Column { min: parameters.radius_range.0 },
            speed_range_top,
            speed_unit: "m/s",
            arrows: self.initial_discs() <= MAX_ARROWS,
            force_range_top: Some(self.force_range_top(speed_range_top)),
            trail: false,
            unused_fields: self.unused_fields(),
            names: Vec::new(),
            central_particle: None,
        }
    }

    /// Number of discs at the start: the drawing of a resumed run must not depend on the number at present.
    fn initial_discs(&self) -> usize {
        let entered = self.insertion.as_ref().map_or(0, |all| all.entered);
        (self.discs.len() as u64).saturating_add(self.removed).saturating_sub(entered) as usize
    }

    /// The walls after `count` steps.
    fn drawn_walls(&self, count: u64) -> Vec<Wall> {
        let mut drawn = vec![Wall::Rectangle { min: [0.0, 0.0], max: self.parameters.sides }];
        drawn.extend(self.parameters.walls_at(count).iter().filter_map(|wall| match wall.shape {
            Shape::Plane { .. } => None,
            Shape::Segment { from, to } => Some(Wall::Segment { from, to }),
            Shape::Drum { center, radius } => Some(Wall::Circle { center, radius }),
        }));
        drawn.extend(self.drum_marks(count));
        drawn
    }

    fn has_moving_walls(&self) -> bool {
        self.parameters.walls.iter().any(|wall| wall.motion.is_moving())
    }

    /// A radial mark on each rotating drum, because the rotation of a circle cannot be seen.
    fn drum_marks(&self, count: u64) -> Vec<Wall> {
        let time = count as f64 * self.parameters.time_step;
        let placed = self.parameters.walls_at(count);
        let mark = |(wall, placed): (&super::walls::Wall, &PlacedWall)| {
            let Shape::Drum { center, radius } = placed.shape else { return None };
            let (sine, cosine) = libm::sincos(wall.motion.rotation(time));
            let at =
                |part: f64| [center[0] + part * radius * cosine, center[1] + part * radius * sine];
            let [from, to] = DRUM_MARK.map(at);
            (wall.motion.spin != 0.0).then_some(Wall::Segment { from, to })
        };
        self.parameters.walls.iter().zip(&placed).filter_map(mark).collect()
    }

    /// Fields that are zero throughout a run without an outlet, insertion or moving walls.
    fn unused_fields(&self) -> Vec<&'static str> {
        let mut unused = Vec::new();
        if self.parameters.outlet_below.is_none() {
            unused.extend(["/energy_percent.removed_percent", "/wall_forces.discs_removed"]);
        }
        if self.insertion.is_none() {
            unused.push("/wall_forces.discs_entered");
        }
        if !self.has_moving_walls() {
            unused.push("/energy_percent.wall_work_percent");
        }
        unused
    }

    /// The upper end of the color bar of forces, N: the geometric mean of the force of an impact, v sqrt(k m), and the weight of a
    /// column of discs, which differ by orders of magnitude. Without gravity, the force of an impact.
    fn force_range_top(&self, speed: f64) -> f64 {
        let Parameters { mass, ref law, .. } = self.parameters;
        let impact = law.normal.impact_force(speed, mass);
        let weight = self.parameters.column_weight(mass, self.initial_discs() as f64);
        if weight > 0.0 { (impact * weight).sqrt() } else { impact }
    }
}

/// Adds a contact to the channel of contact forces: its line, and its force in the next step, friction included.
fn push_force(contact: &Contact, line: &ContactLine, forces: &mut DemContactForces) {
    for (column, value) in [
        (&mut forces.from_x_m, line.from[0]),
        (&mut forces.from_y_m, line.from[1]),
        (&mut forces.to_x_m, line.to[0]),
        (&mut forces.to_y_m, line.to[1]),
        (&mut forces.force_x_n, contact.force[0]),
        (&mut forces.force_y_n, contact.force[1]),
    ] {
        column.push(value);
    }
}

/// Half the mean square of v - `<v>`, and its root.
fn temperature(velocities: &[[f64; 2]]) -> DemTemperature {
    let count = Ord::max(velocities.len(), 1) as f64;
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

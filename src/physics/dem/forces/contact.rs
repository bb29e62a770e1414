//! Who touches whom, one by one: for looking, for the implicit dashpot, and for the words of a fault.

use crate::dem::discs::Discs;
use crate::dem::forces::Scene;
use crate::dem::materials::{Dashpot, Materials};
use crate::dem::neighbors::{Block, Neighbors};
use crate::dem::{motion, restitution};
use crate::simd::dispatch::{self, Kernel, each};
use serde::{Deserialize, Serialize};

/// The force law of a contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(in crate::dem) struct ContactLaw {
    /// Stiffness k, N/m.
    pub(in crate::dem) stiffness: f64,
    /// Dashpots and friction by pairs of materials.
    pub(in crate::dem) materials: Materials,
    /// Whether the force is clamped at zero where it would pull.
    pub(in crate::dem) only_pushes: bool,
    /// Whether the dashpot takes the velocities at the step's end.
    pub(in crate::dem) is_implicit: bool,
    /// Stiffness k_t of the tangential and the rolling spring, N/m.
    pub(in crate::dem) tangential_stiffness: f64,
    /// eta_t over eta.
    pub(in crate::dem) tangential_damping_share: f64,
}

/// Two discs, or a disc and a wall, that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::dem) struct Contact {
    /// Where the disc that the normal points to stands in memory.
    pub(in crate::dem) disc: u32,
    /// The other.
    pub(in crate::dem) partner: Partner,
    /// Unit vector from the partner to the disc.
    pub(in crate::dem) normal: [f64; 2],
    /// Overlap delta, m.
    pub(in crate::dem) overlap: f64,
    /// Overlap over the smaller radius of the two.
    pub(in crate::dem) overlap_over_radius: f64,
    /// Speed v_n at which the two move apart, by the integrator's velocities, m/s.
    pub(in crate::dem) separating_speed: f64,
    /// Normal force f, positive where it pushes, N.
    pub(in crate::dem) force: f64,
    /// Stretch of the tangential spring, m; 0 without friction.
    pub(in crate::dem) stretch: f64,
}

/// What a disc touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::dem) enum Partner {
    /// A disc, by its place in memory.
    Disc(u32),
    /// A wall, by its number.
    Wall(u32),
}

impl ContactLaw {
    /// Damping eta of a pair of discs, N s/m.
    pub(in crate::dem) fn damping(&self, discs: &Discs, disc: usize, other: usize) -> f64 {
        let mass = motion::effective_mass(discs.masses[disc], discs.masses[other]);
        let pair = self.materials.between(discs.materials[disc], discs.materials[other]);
        pair.damping(self.stiffness, mass)
    }

    /// Damping eta of pairs of discs, N s/m, which are counted from given ones.
    pub(in crate::dem) fn dampings(
        &self,
        discs: &Discs,
        counted_from: [usize; 2],
        [first, second]: [&[u32]; 2],
        dampings: &mut [f64],
    ) {
        match self.materials.only().map(|pair| pair.dashpot) {
            Some(Dashpot::Damping(damping)) => dampings.fill(damping),
            Some(Dashpot::Ratio(ratio)) => {
                let masses = counted_from.map(|from| &discs.masses[from..]);
                let stiffness = self.stiffness;
                let ends = [first, second];
                dispatch::run(Dampings { masses, ends, ratio, stiffness, dampings });
            }
            None => {
                for (damping, (&one, &other)) in dampings.iter_mut().zip(first.iter().zip(second)) {
                    let [from, others_from] = counted_from;
                    *damping =
                        self.damping(discs, from + one as usize, others_from + other as usize);
                }
            }
        }
    }

    /// Damping eta of a disc with a wall, N s/m.
    pub(in crate::dem) fn wall_damping(&self, discs: &Discs, disc: usize) -> f64 {
        self.materials.with_walls(discs.materials[disc]).damping(self.stiffness, discs.masses[disc])
    }

    /// What the normal force does not fall below, N: zero where it only pushes.
    pub(in crate::dem) fn least_force(&self) -> f64 {
        if self.only_pushes { 0.0 } else { f64::NEG_INFINITY }
    }

    /// The force without its attractive tail, where it has none.
    pub(in crate::dem) fn clamped(&self, force: f64) -> f64 {
        let least = self.least_force();
        if force > least { force } else { least }
    }

    /// Whether contacts have tangential or rolling springs.
    pub(in crate::dem) fn has_friction(&self) -> bool {
        self.materials.have_friction()
    }

    /// Whether contacts have rolling springs.
    pub(in crate::dem) fn has_rolling_friction(&self) -> bool {
        self.materials.have_rolling_friction()
    }
}

/// Finds the dampings of pairs with one damping ratio.
struct Dampings<'a> {
    /// Masses of the discs that pairs name first, and of those that they name second, kg.
    masses: [&'a [f64]; 2],
    ends: [&'a [u32]; 2],
    ratio: f64,
    stiffness: f64,
    dampings: &'a mut [f64],
}

impl Kernel for Dampings<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { masses: [masses, other_masses], ends: [first, second], .. } = self;
        let damping = |mass: f64, other_mass: f64| {
            let effective_mass = motion::effective_mass(mass, other_mass);
            restitution::damping(self.ratio, self.stiffness, effective_mass)
        };
        let (fours, last) = self.dampings.as_chunks_mut::<4>();
        let (first, last_first) = first.as_chunks::<4>();
        let (second, last_second) = second.as_chunks::<4>();
        for ((dampings, first), second) in fours.iter_mut().zip(first).zip(second) {
            let masses = first.map(|disc| masses[disc as usize]);
            let other_masses = second.map(|disc| other_masses[disc as usize]);
            *dampings = each(|pair| damping(masses[pair], other_masses[pair]));
        }
        for ((value, &one), &other) in last.iter_mut().zip(last_first).zip(last_second) {
            *value = damping(masses[one as usize], other_masses[other as usize]);
        }
    }
}

impl Contact {
    fn stretched_as(self, stretch: Option<&f64>) -> Self {
        Self { stretch: stretch.copied().unwrap_or_default(), ..self }
    }
}

/// Finds all contacts with their explicit normal forces, block by block: pairs, edges, walls.
pub(in crate::dem) fn find(
    discs: &Discs,
    scene: &Scene<'_>,
    neighbors: &Neighbors,
    contacts: &mut Vec<Contact>,
) {
    contacts.clear();
    for block in &neighbors.blocks {
        contacts.extend(of_block(block, discs, scene));
    }
}

/// The contacts of one block with their explicit normal forces: pairs, edges, walls.
pub(in crate::dem) fn of_block(
    block: &Block,
    discs: &Discs,
    scene: &Scene<'_>,
) -> impl Iterator<Item = Contact> {
    let found = pair_contacts(block, discs, scene).chain(edge_contacts(block, discs, scene));
    found.chain(wall_contacts(block, discs, scene))
}

fn pair_contacts(block: &Block, discs: &Discs, scene: &Scene<'_>) -> impl Iterator<Item = Contact> {
    let law = scene.law;
    (0..block.inner.in_tiers(scene.scope.tiers)).filter_map(move |pair| {
        let first = block.start + block.inner.first[pair] as usize;
        let second = block.start + block.inner.second[pair] as usize;
        let contact =
            pair_contact(discs, law, [first, second], [0.0; 2], block.inner.damping[pair])?;
        Some(contact.stretched_as(block.inner.stretch.get(pair)))
    })
}

/// Edges are listed with both of their discs; here they count once.
fn edge_contacts(block: &Block, discs: &Discs, scene: &Scene<'_>) -> impl Iterator<Item = Contact> {
    let law = scene.law;
    (0..block.edges.in_tiers(scene.scope.tiers)).filter_map(move |edge| {
        let first = block.start + block.edges.first[edge] as usize;
        let second = block.edges.second[edge] as usize;
        if first > second {
            return None;
        }
        let contact = pair_contact(
            discs,
            law,
            [first, second],
            block.shifts[edge],
            block.edges.damping[edge],
        )?;
        Some(contact.stretched_as(block.edges.stretch.get(edge)))
    })
}

fn pair_contact(
    discs: &Discs,
    law: &ContactLaw,
    [disc, partner]: [usize; 2],
    shift: [f64; 2],
    damping: f64,
) -> Option<Contact> {
    let [[x, y], [other_x, other_y]] = [disc, partner].map(|disc| discs.positions[disc]);
    let [[vx, vy], [other_vx, other_vy]] = [disc, partner].map(|disc| discs.velocities[disc]);
    let apart = [x - (other_x + shift[0]), y - (other_y + shift[1])];
    let (radius, other_radius) = (discs.radii[disc], discs.radii[partner]);
    let reach = radius + other_radius;
    let distance_squared = apart[0] * apart[0] + apart[1] * apart[1];
    if distance_squared >= reach * reach {
        return None;
    }
    let distance = distance_squared.sqrt();
    // Centers on one point have no normal; any will do, for such an overlap ends the run.
    let normal =
        if distance > 0.0 { [apart[0] / distance, apart[1] / distance] } else { [0.0, 1.0] };
    let separating_speed = (vx - other_vx) * normal[0] + (vy - other_vy) * normal[1];
    let overlap = reach - distance;
    let force = motion::contact_force(law.stiffness, damping, overlap, separating_speed);
    Some(Contact {
        disc: disc as u32,
        partner: Partner::Disc(partner as u32),
        normal,
        overlap,
        overlap_over_radius: overlap / if radius < other_radius { radius } else { other_radius },
        separating_speed,
        force: law.clamped(force),
        stretch: 0.0,
    })
}

fn wall_contacts(block: &Block, discs: &Discs, scene: &Scene<'_>) -> impl Iterator<Item = Contact> {
    let (law, walls) = (scene.law, scene.walls);
    block.walls.iter().filter_map(move |pair| {
        let disc = block.start + pair.disc as usize;
        let wall = &walls[pair.wall as usize];
        let footing = wall.shape.footing(discs.positions[disc]);
        let (radius, normal) = (discs.radii[disc], footing.normal);
        if footing.distance >= radius {
            return None;
        }
        let [vx, vy] = discs.velocities[disc];
        let [wall_vx, wall_vy] = wall.surface_velocity(wall.step_velocity, normal);
        let separating_speed = (vx - wall_vx) * normal[0] + (vy - wall_vy) * normal[1];
        let overlap = radius - footing.distance;
        let force = motion::contact_force(law.stiffness, pair.damping, overlap, separating_speed);
        Some(Contact {
            disc: disc as u32,
            partner: Partner::Wall(pair.wall),
            normal,
            overlap,
            overlap_over_radius: overlap / radius,
            separating_speed,
            force: law.clamped(force),
            stretch: pair.stretch[0],
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dem::discs::Disc;
    use crate::dem::parameters::Parameters;
    use kinetoscope_manifest::model::{DemConfig, Dissipation};
    use kinetoscope_manifest::quantity::{NonNegative, Share};

    #[test]
    fn dampings_found_together_are_those_of_single_pairs() {
        let mut discs = Discs::default();
        for id in 0..40 {
            let mass = 0.5 + (f64::from(id) * std::f64::consts::SQRT_2).fract();
            let (position, velocity) = ([f64::from(id), 0.0], [0.0; 2]);
            discs.push(&Disc { id, position, velocity, radius: 0.5, mass, material: 0 });
        }
        let first: Vec<u32> = (0..19).collect();
        let second: Vec<u32> = (0..19).map(|number| number * number % 31).collect();
        for dissipation in [
            Dissipation::Restitution(Share::new(0.5).unwrap()),
            Dissipation::Damping(NonNegative::new(0.3).unwrap()),
        ] {
            let law = Parameters::new(&DemConfig { dissipation, ..DemConfig::default() }).law;
            let mut dampings = vec![0.0; 19];
            law.dampings(&discs, [5, 9], [&first, &second], &mut dampings);
            let pairs = first.iter().zip(&second);
            let wanted: Vec<f64> = pairs
                .map(|(&one, &other)| law.damping(&discs, 5 + one as usize, 9 + other as usize))
                .collect();
            assert_eq!(dampings, wanted);
        }
    }
}

//! The contact law's constants, by the materials of the two sides of a contact.
//!
//! Constants that the manifest gives for a pair take precedence. Others follow from the two materials:
//! - friction and rolling friction are the smaller of the two: the weaker surface yields first (the rule of Itasca's PFC
//!   and of YADE, Šmilauer et al., Yade Documentation);
//! - k = 2 k_i k_j/(k_i + k_j): two springs in series. For spheres, it is the rule 2/E* = 1/E*_i + 1/E*_j;
//! - e^2 = (e_i^2 k_j + e_j^2 k_i)/(k_i + k_j): the two springs store the energy in inverse proportion to their stiffness, and each
//!   material returns e^2 of its part (Coaplen, Stronge and Ravani, Int. J. Impact Eng. 30 (2004) 581);
//! - cohesion is the geometric mean of the two, as the work of adhesion is (Girifalco and Good, J. Phys. Chem. 61 (1957) 904).
//!
//! Elastic forces and energies of all laws are proportional to the stiffness. Therefore, a contact that is r times as stiff as that of the
//! manifest moves as one of 1/r of the mass and the load.

use crate::dem::block::Partner;
use crate::dem::discs::Discs;
use crate::dem::laws::{Impact, Law};
use crate::dem::{motion, restitution};
use crate::random::{Seed, Stream};
use crate::simd::registers::{each, vectorized};
use kinetoscope_manifest::model::{
    DISC, DemConfig, DemContactConstants, DemMaterial, Dissipation, WALL,
};
use kinetoscope_manifest::quantity::Positive;
use serde::{Deserialize, Serialize};

/// The rule for the damping of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Dashpot {
    /// From the damping ratio zeta, for each pair by its effective mass: one restitution for all.
    Ratio(f64),
    /// One damping eta for all, N s/m.
    Damping(f64),
}

/// Constants of the contacts between two materials.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ContactConstants {
    /// The dashpot.
    pub(super) dashpot: Dashpot,
    /// Coefficient of friction mu.
    pub(super) friction: f64,
    /// Coefficient of rolling friction mu_r.
    pub(super) rolling_friction: f64,
    /// Stiffness, or modulus, over that of the manifest.
    pub(super) stiffness_ratio: f64,
    /// Attraction F_c, N.
    pub(super) cohesion: f64,
}

/// The constants of all pairs of materials; the walls are the last material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Materials {
    /// Row by row, `count` squared.
    pairs: Vec<ContactConstants>,
    /// Materials, walls included.
    count: usize,
    /// Cumulative fraction of the discs, material by material.
    fractions: Vec<f64>,
    /// Areal density of each disc material over that of the manifest.
    density_ratios: Vec<f64>,
}

/// e, mu, mu_r, k over that of the manifest, and F_c of one material, before they are mixed.
#[derive(Clone, Copy)]
struct Surface {
    restitution: f64,
    friction: f64,
    rolling_friction: f64,
    stiffness_ratio: f64,
    cohesion: f64,
}

/// The force law of a contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ContactLaw {
    /// The normal force.
    pub(super) normal: Law,
    /// Dashpots and friction by pairs of materials.
    pub(super) materials: Materials,
    /// Whether the force is clamped at zero instead of attractive.
    pub(super) only_pushes: bool,
    /// Whether the dashpot acts at the velocities of the step's end.
    pub(super) is_implicit: bool,
    /// Stiffness k_t of the tangential and the rolling spring, N/m.
    pub(super) tangential_stiffness: f64,
    /// eta_t over eta.
    pub(super) tangential_to_normal_damping: f64,
}

impl ContactConstants {
    /// The constants that the loops over contacts read: mu, mu_r, the stiffness ratio and F_c.
    #[inline]
    pub(super) fn of_contact(&self) -> [f64; 4] {
        [self.friction, self.rolling_friction, self.stiffness_ratio, self.cohesion]
    }

    /// Damping eta of a pair, N s/m.
    pub(super) fn damping(&self, law: Law, effective_mass: f64) -> f64 {
        match self.dashpot {
            Dashpot::Ratio(ratio) => {
                let stiffness = self.stiffness_ratio * law.dashpot_stiffness();
                restitution::damping(ratio, stiffness, effective_mass)
            }
            Dashpot::Damping(damping) => damping,
        }
    }

    /// Damping ratio zeta = eta / (2 sqrt(k m_eff)) of a contact.
    pub(super) fn damping_ratio(&self, law: Law, effective_mass: f64) -> f64 {
        match self.dashpot {
            Dashpot::Ratio(ratio) => ratio,
            Dashpot::Damping(damping) => {
                let stiffness = self.stiffness_ratio * law.stiffness();
                damping / (2.0 * (stiffness * effective_mass).sqrt())
            }
        }
    }
}

impl Surface {
    fn of(own: &DemContactConstants, common: Self) -> Self {
        Self {
            restitution: own.restitution.map_or(common.restitution, |e| e.get()),
            friction: own.friction.map_or(common.friction, |mu| mu.get()),
            rolling_friction: own.rolling_friction.map_or(common.rolling_friction, |mu| mu.get()),
            stiffness_ratio: own.stiffness_ratio.map_or(common.stiffness_ratio, |k| k.get()),
            cohesion: own.cohesion_n.map_or(common.cohesion, |force| force.get()),
        }
    }

    /// The mixing rule.
    fn with(self, other: Self) -> Self {
        let smaller = |one: f64, other: f64| if one < other { one } else { other };
        // Without rounding if the two are equal.
        let unless_equal =
            |one: f64, other: f64, mixed: f64| if one == other { one } else { mixed };
        let (e, e_other) = (self.restitution, other.restitution);
        let (k, k_other) = (self.stiffness_ratio, other.stiffness_ratio);
        let squared = match k == k_other {
            true => 0.5 * (e * e + e_other * e_other),
            false => (e * e * k_other + e_other * e_other * k) / (k + k_other),
        };
        let (cohesion, other_cohesion) = (self.cohesion, other.cohesion);
        Self {
            restitution: unless_equal(e, e_other, squared.sqrt()),
            friction: smaller(self.friction, other.friction),
            rolling_friction: smaller(self.rolling_friction, other.rolling_friction),
            stiffness_ratio: unless_equal(k, k_other, 2.0 / (1.0 / k + 1.0 / k_other)),
            cohesion: unless_equal(
                cohesion,
                other_cohesion,
                cohesion.sqrt() * other_cohesion.sqrt(),
            ),
        }
    }
}

impl Materials {
    /// Number of materials that discs can have.
    pub(super) fn of_discs(&self) -> usize {
        self.density_ratios.len()
    }

    pub(super) fn new(config: &DemConfig) -> Self {
        let common = Surface {
            restitution: match config.dissipation {
                Dissipation::Restitution(wanted) => wanted.get(),
                Dissipation::Damping(_) => 1.0,
            },
            friction: config.friction.get(),
            rolling_friction: config.rolling_friction.get(),
            stiffness_ratio: 1.0,
            cohesion: config.cohesion_n.get(),
        };
        let single = [single_material()];
        let listed = if config.materials.is_empty() { &single[..] } else { &config.materials };
        let disc_materials =
            listed.iter().map(|one| (&*one.name, Surface::of(&one.constants, common)));
        let (names, surfaces): (Vec<&str>, Vec<Surface>) =
            disc_materials.chain([(WALL, common)]).unzip();
        let count = names.len();
        let constants = |place: usize| {
            let (one, other) = (place / count, place % count);
            let mixed = surfaces[one].with(surfaces[other]);
            let is_this = |between: &[String; 2]| {
                let [a, b] = [&*between[0], &*between[1]];
                [a, b] == [names[one], names[other]] || [b, a] == [names[one], names[other]]
            };
            let given = config.contact_pairs.iter().find(|pair| is_this(&pair.between));
            contact_constants(
                config,
                given.map_or(mixed, |pair| Surface::of(&pair.constants, mixed)),
            )
        };
        Self {
            pairs: (0..count * count).map(constants).collect(),
            count,
            fractions: cumulative_fractions(listed),
            density_ratios: listed.iter().map(|material| material.density_ratio.get()).collect(),
        }
    }

    /// The constants of contacts between two materials.
    #[inline]
    pub(super) fn between(&self, one: u8, other: u8) -> &ContactConstants {
        &self.pairs[usize::from(one) * self.count + usize::from(other)]
    }

    /// The constants of contacts with the walls.
    #[inline]
    pub(super) fn with_walls(&self, material: u8) -> &ContactConstants {
        &self.pairs[(usize::from(material) + 1) * self.count - 1]
    }

    /// Every pair's constants.
    pub(super) fn all(&self) -> &[ContactConstants] {
        &self.pairs
    }

    /// The constants of contacts between discs, if all discs are of one material with plain springs.
    pub(super) fn only(&self) -> Option<&ContactConstants> {
        let is_only = self.fractions.len() < 2 && self.have_plain_springs();
        self.pairs.first().filter(|_| is_only)
    }

    /// Whether all contacts between discs are as stiff as the manifest states, and no discs attract each other.
    pub(super) fn have_plain_springs(&self) -> bool {
        let discs = self.of_discs();
        let of_discs = self.pairs.chunks(self.count).take(discs).flat_map(|row| &row[..discs]);
        let mut pairs = of_discs.map(|pair| (pair.stiffness_ratio, pair.cohesion));
        pairs.all(|pair| pair == (1.0, 0.0))
    }

    /// The constants of all contacts.
    fn contacts(&self) -> &[ContactConstants] {
        // The last pair would be that of two walls.
        &self.pairs[..self.pairs.len() - 1]
    }

    /// Smallest and largest stiffness of a contact over that of the manifest.
    pub(super) fn stiffness_range(&self) -> (f64, f64) {
        range(self.contacts().iter().map(|pair| pair.stiffness_ratio))
    }

    /// The load, N, under which a contact of the manifest's stiffness overlaps as the softest one does under a weight, N, and as the most
    /// cohesive one for its stiffness does when it closes, which stretches it by twice its cohesion.
    pub(super) fn scaled_load(&self, weight: f64) -> f64 {
        let cohesions = self.contacts().iter().map(|pair| pair.cohesion / pair.stiffness_ratio);
        weight / self.stiffness_range().0 + 2.0 * range(cohesions).1
    }

    /// The constants with the strongest dashpot, which limits the time step.
    pub(super) fn strongest_dashpot(&self) -> &ContactConstants {
        let strength = |pair: &ContactConstants| match pair.dashpot {
            Dashpot::Ratio(ratio) => ratio * pair.stiffness_ratio.sqrt(),
            Dashpot::Damping(damping) => damping,
        };
        let mut strongest = &self.pairs[0];
        for pair in &self.pairs {
            strongest = if strength(pair) > strength(strongest) { pair } else { strongest };
        }
        strongest
    }

    /// Areal density of a material over the manifest's.
    pub(super) fn density_ratio(&self, material: u8) -> f64 {
        self.density_ratios[usize::from(material)]
    }

    /// Smallest and largest of the density ratios.
    pub(super) fn density_range(&self) -> (f64, f64) {
        range(self.density_ratios.iter().copied())
    }

    /// The material of each of `count` discs, drawn by the fractions.
    pub(super) fn drawn(&self, count: usize, seed: Seed) -> Vec<u8> {
        if self.fractions.len() < 2 {
            return vec![0; count];
        }
        let mut generator = seed.stream(Stream::Materials);
        let mut draw = || {
            let drawn = generator.uniform();
            // Up to the last but one: rounding cannot lead past the last.
            let is_below = |fraction: &&f64| drawn >= **fraction;
            self.fractions[..self.fractions.len() - 1].iter().take_while(is_below).count() as u8
        };
        (0..count).map(|_| draw()).collect()
    }
}

/// Smallest and largest of numbers, which are not negative.
fn range(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    numbers.fold((f64::INFINITY, 0.0), |(low, high), number| {
        (if number < low { number } else { low }, if number > high { number } else { high })
    })
}

fn contact_constants(config: &DemConfig, surface: Surface) -> ContactConstants {
    let dashpot = match config.dissipation {
        Dissipation::Restitution(_) => {
            Dashpot::Ratio(restitution::damping_ratio(surface.restitution, config.limit_damping))
        }
        Dissipation::Damping(damping) => Dashpot::Damping(damping.get()),
    };
    ContactConstants {
        dashpot,
        friction: surface.friction,
        rolling_friction: surface.rolling_friction,
        stiffness_ratio: surface.stiffness_ratio,
        cohesion: surface.cohesion,
    }
}

/// The material of all discs of a manifest that lists none.
fn single_material() -> DemMaterial {
    let (name, one) = (DISC.to_owned(), Positive::literal(1.0));
    DemMaterial { name, fraction: one, density_ratio: one, constants: Default::default() }
}

fn cumulative_fractions(materials: &[DemMaterial]) -> Vec<f64> {
    let fractions = || materials.iter().map(|material| material.fraction.get());
    let (total, mut sum): (f64, f64) = (fractions().sum(), 0.0);
    let add = |fraction: f64| {
        sum += fraction;
        sum / total
    };
    fractions().map(add).collect()
}

impl ContactLaw {
    /// The constants of a disc and its partner.
    fn constants(&self, discs: &Discs, disc: usize, partner: Partner) -> &ContactConstants {
        let material = discs.materials[disc];
        match partner {
            Partner::Disc(other) => {
                self.materials.between(material, discs.materials[other as usize])
            }
            Partner::Wall(_) => self.materials.with_walls(material),
        }
    }

    /// Damping eta of a disc and its partner, N s/m.
    pub(super) fn damping(&self, discs: &Discs, disc: usize, partner: Partner) -> f64 {
        let constants = self.constants(discs, disc, partner);
        constants.damping(self.normal, discs.effective_mass(disc, partner))
    }

    /// Elastic force f_e of a disc and its partner, N, and the potential energy U_e - F_c delta, J, by the overlap, m.
    pub(super) fn force_and_energy(
        &self,
        discs: &Discs,
        (disc, partner): (u32, Partner),
        overlap: f64,
    ) -> [f64; 2] {
        let constants = self.constants(discs, disc as usize, partner);
        let radius = discs.reduced_radius(disc as usize, partner);
        let [force, energy] = [
            self.normal.elastic_force(overlap, radius),
            self.normal.potential_energy(overlap, radius),
        ]
        .map(|of_manifest| constants.stiffness_ratio * of_manifest);
        [force, energy - constants.cohesion * overlap]
    }

    /// An effective mass over the largest stiffness ratio: with the manifest's stiffness, it moves as the mass in the stiffest contact.
    pub(super) fn mass_of_stiffest(&self, mass: f64) -> f64 {
        mass / self.materials.stiffness_range().1
    }

    /// The time pi sqrt(m/k), s, of the stiffest contact at an effective mass.
    pub(super) fn contact_time(&self, mass: f64) -> f64 {
        self.normal.contact_time(self.mass_of_stiffest(mass))
    }

    /// Largest overlap of an impact with the softest contact, and under a weight, N, and cohesion; in m.
    pub(super) fn expected_overlap(&self, impact: &Impact, weight: f64) -> f64 {
        let softest = self.materials.stiffness_range().0;
        let impact = Impact { mass: impact.mass / softest, ..*impact };
        self.normal.impact_overlap(&impact)
            + self.normal.overlap_under(self.materials.scaled_load(weight), impact.radius)
    }

    /// Damping eta of pairs of discs, N s/m, whose indices are counted from given discs.
    pub(super) fn dampings(
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
                let stiffness = self.normal.dashpot_stiffness();
                dampings_of_ratio(ratio, stiffness, masses, [first, second], dampings);
            }
            None => {
                let [from, others_from] = counted_from;
                for (damping, (&one, &other)) in dampings.iter_mut().zip(first.iter().zip(second)) {
                    let [one, other] = [from + one as usize, others_from + other as usize];
                    *damping = self.damping(discs, one, Partner::Disc(other as u32));
                }
            }
        }
    }

    /// The lower bound of the normal force, N: zero if it is clamped.
    pub(super) fn least_force(&self) -> f64 {
        if self.only_pushes { 0.0 } else { f64::NEG_INFINITY }
    }

    /// Whether contacts have tangential or rolling springs, or normal forces by material or with cohesion: only the loops with friction
    /// read constants by material.
    pub(super) fn has_friction(&self) -> bool {
        self.materials.pairs.iter().any(|pair| pair.friction > 0.0 || pair.rolling_friction > 0.0)
            || !self.materials.have_plain_springs()
    }

    /// Whether any surfaces attract each other.
    pub(super) fn is_cohesive(&self) -> bool {
        self.materials.contacts().iter().any(|pair| pair.cohesion > 0.0)
    }

    /// Whether contacts have rolling springs.
    pub(super) fn has_rolling_friction(&self) -> bool {
        self.materials.pairs.iter().any(|pair| pair.rolling_friction > 0.0)
    }
}

vectorized! {
    /// Finds the dampings of pairs with one damping ratio; `masses` are those of the first discs of pairs and of the second ones, kg.
    fn dampings_of_ratio(
        ratio: f64,
        stiffness: f64,
        masses: [&[f64]; 2],
        ends: [&[u32]; 2],
        dampings: &mut [f64],
    ) -> () {
        let ([masses, other_masses], [first, second]) = (masses, ends);
        let damping = |mass: f64, other_mass: f64| {
            restitution::damping(ratio, stiffness, motion::effective_mass(mass, other_mass))
        };
        let (fours, last) = dampings.as_chunks_mut::<4>();
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

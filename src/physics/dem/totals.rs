//! What contacts add up to: forces per disc, sums per block, and single contacts as they are reported.

use super::block::{BLOCK, Partner};
use super::parameters::StepContext;
use crate::simd::aligned_rows::AlignedRows;
use crate::simd::registers::{Register as _, vectorized};

/// Forces on the discs of a block, and sums over its contacts.
#[derive(Clone, Debug, Default)]
pub(super) struct BlockForces {
    /// Fx, Fy, Dx, Dy of each disc, N; zero between two steps. D is the dissipative part of F.
    pub(super) forces: AlignedRows,
    /// Torque on each disc and the part of it that dashpots take, N m; empty without friction, and zero between two steps.
    pub(super) torques: Vec<[f64; 2]>,
    pub(super) sums: ContactSums,
    /// Discs in contact.
    pub(super) mask: ContactMask,
}

/// Two discs, or a disc and a wall, that overlap, or whose cohesion ends in this step, the first one apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contact {
    /// Index of the disc that the normal points to.
    pub(super) disc: u32,
    pub(super) partner: Partner,
    /// Vector from the partner's center (of its image beyond a periodic side), or from the nearest point of the wall, to the
    /// disc's center, m.
    pub(super) separation: [f64; 2],
    /// Unit vector along the separation.
    pub(super) normal: [f64; 2],
    /// Overlap delta, m; negative in the first step apart.
    pub(super) overlap: f64,
    /// Overlap over the smaller radius of the two.
    pub(super) overlap_over_radius: f64,
    /// Normal force f, positive if it pushes, N.
    pub(super) normal_force: f64,
    /// Force on the disc, friction included, N.
    pub(super) force: [f64; 2],
}

impl Contact {
    /// A contact by the two ends and their radii, m, the separation and the normal, overlap and normal force, and Fx, Fy, Dx, Dy on the disc.
    pub(super) fn new(
        (disc, partner, radii): (usize, Partner, [f64; 2]),
        [separation, normal]: [[f64; 2]; 2],
        [overlap, normal_force]: [f64; 2],
        [fx, fy, ..]: [f64; 4],
    ) -> Self {
        let overlap_over_radius = overlap_over_radius(overlap, radii[0], radii[1]);
        Self {
            disc: disc as u32,
            partner,
            separation,
            normal,
            overlap,
            overlap_over_radius,
            normal_force,
            force: [fx, fy],
        }
    }
}

/// Where single contacts are recorded, if they are.
pub(super) type ContactRecorder<'a> = Option<&'a mut Vec<Contact>>;

/// Sums over the contacts of a block. An inter-block contact counts half in each of its two blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct ContactSums {
    /// Energy of the tangential and rolling springs, J.
    pub(super) elastic: f64,
    /// Energy dissipated by friction in the step before, J.
    pub(super) friction: f64,
    /// Energy dissipated by rolling friction in the step before, J.
    pub(super) rolling: f64,
    /// Power taken by the dashpots of moving walls beyond D . v of their discs, W.
    pub(super) wall_dissipation: f64,
    /// Force of each wall on the discs, N, and its power, W.
    pub(super) walls: Vec<[f64; 3]>,
    pub(super) max_overlap: MaxOverlap,
}

impl ContactSums {
    /// Resets all sums, for the block that begins with disc `start`.
    pub(super) fn clear(&mut self, step: &StepContext<'_>, start: usize) {
        let mut walls = std::mem::take(&mut self.walls);
        walls.clear();
        walls.resize(step.walls.len(), [0.0; 3]);
        *self = Self { walls, max_overlap: MaxOverlap::new(step, start), ..Self::default() };
    }

    /// Adds the sums of other contacts.
    pub(super) fn add(&mut self, other: &Self) {
        self.elastic += other.elastic;
        self.friction += other.friction;
        self.rolling += other.rolling;
        self.wall_dissipation += other.wall_dissipation;
        self.walls.resize(other.walls.len(), [0.0; 3]);
        for (sum, part) in self.walls.iter_mut().zip(&other.walls) {
            *sum = [sum[0] + part[0], sum[1] + part[1], sum[2] + part[2]];
        }
        self.max_overlap.merge(&other.max_overlap);
    }
}

/// The largest overlap so far. One comparison suffices for most contacts, which overlap less.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MaxOverlap {
    /// Overlap over the smaller radius.
    pub(super) over_radius: f64,
    /// Index of the disc, and its partner; `None` while no contact exceeds the value that was known before.
    pub(super) ends: Option<(u32, Partner)>,
    smallest_radius: f64,
    /// Index of the disc that pairs are counted from.
    start: usize,
}

impl MaxOverlap {
    /// The maximum with the known value of a step, for the block that begins with disc `start`.
    fn new(step: &StepContext<'_>, start: usize) -> Self {
        let smallest_radius = step.parameters.radius_range.0;
        Self { over_radius: step.known_overlap, ends: None, smallest_radius, start }
    }

    /// An overlap up to which no contact needs to be noted, m.
    #[inline]
    pub(super) fn bound(&self) -> f64 {
        self.over_radius * self.smallest_radius
    }

    /// Notes the overlap, m, of two discs of the block.
    #[inline]
    pub(super) fn note_pair(&mut self, overlap: f64, [a, b]: [usize; 2], radii: &[f64]) {
        let partner = Partner::Disc((self.start + b) as u32);
        self.note(overlap, a, radii[a], partner, radii[b]);
    }

    /// Notes the overlap, m, of a disc of the block with a partner, by their radii.
    #[inline]
    pub(super) fn note(
        &mut self,
        overlap: f64,
        disc: usize,
        radius: f64,
        partner: Partner,
        partner_radius: f64,
    ) {
        let ratio = overlap_over_radius(overlap, radius, partner_radius);
        self.note_ratio(ratio, ((self.start + disc) as u32, partner));
    }

    /// Notes the overlap over the smaller radius of a contact between a disc, by its index, and its partner.
    #[inline]
    pub(super) fn note_ratio(&mut self, over_radius: f64, ends: (u32, Partner)) {
        if over_radius > self.over_radius {
            (self.over_radius, self.ends) = (over_radius, Some(ends));
        }
    }

    /// Keeps the larger of two.
    fn merge(&mut self, other: &Self) {
        if other.over_radius > self.over_radius {
            *self = *other;
        }
    }
}

/// Overlap over the smaller of two radii.
#[inline]
pub(super) fn overlap_over_radius(overlap: f64, radius: f64, other: f64) -> f64 {
    overlap / if radius < other { radius } else { other }
}

const WORDS: usize = BLOCK.div_ceil(64);

/// The set of a block's discs that are in contact, one bit per disc.
#[derive(Clone, Debug)]
pub(super) struct ContactMask {
    bits: [u64; WORDS],
    /// Whether all discs with contacts inside the block are in the set.
    pub(super) is_complete: bool,
}

impl Default for ContactMask {
    fn default() -> Self {
        Self { bits: [0; WORDS], is_complete: false }
    }
}

impl ContactMask {
    /// Inserts a disc, counted from the block's first disc.
    #[inline]
    pub(super) fn insert(&mut self, disc: u32) {
        self.bits[disc as usize / 64] |= 1 << (disc % 64);
    }

    /// Whether the set is complete and holds less than a quarter of `discs` discs.
    pub(super) fn is_sparse(&self, discs: usize) -> bool {
        self.is_complete && 4 * number_of_bits(&self.bits) < discs
    }

    /// Visits the discs in ascending order.
    #[inline]
    pub(super) fn for_each(&self, mut visit: impl FnMut(usize)) {
        for (number, &word) in self.bits.iter().enumerate() {
            let mut left = word;
            while left != 0 {
                visit(number * 64 + left.trailing_zeros() as usize);
                left &= left - 1;
            }
        }
    }
}

vectorized! {
    /// Number of ones: every processor can count them, but few in one instruction.
    fn number_of_bits(words: &[u64]) -> usize {
        words.iter().map(|word| u64::from(word.count_ones())).sum::<u64>() as usize
    }
}

/// The sums over a step, or over the discs of one block in it.
#[derive(Clone, Debug, Default)]
pub(super) struct StepTotals {
    /// Power taken by the dashpots, W.
    pub(super) dashpot_power: f64,
    pub(super) contacts: ContactSums,
    /// Bound of the largest speed after the kick, squared, m^2/s^2.
    pub(super) fastest_squared: f64,
    /// Index of the first disc that left the box.
    pub(super) outside: Option<usize>,
}

/// The reason why a run cannot continue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BlowUp {
    /// A disc, by its index, and its partner overlap by more than the smaller radius; the ratio of the two.
    Overlap(u32, Partner, f64),
    /// The center of a disc, by its index, is outside the box or not a number.
    Outside(usize),
    /// The energy balance's residual exceeds this fraction of all energy.
    Residual(f64),
}

impl StepTotals {
    /// Bound of the displacement of any disc in the step, m.
    pub(super) fn max_displacement(&self, time_step: f64) -> f64 {
        self.fastest_squared.sqrt() * time_step
    }

    /// An overlap of more than the smaller radius, or a disc outside the box.
    pub(super) fn blow_up(&self) -> Option<BlowUp> {
        let MaxOverlap { over_radius, ends, .. } = self.contacts.max_overlap;
        let ends = ends.filter(|_| over_radius > 1.0);
        let overlap = ends.map(|(disc, partner)| BlowUp::Overlap(disc, partner, over_radius));
        overlap.or(self.outside.map(BlowUp::Outside))
    }

    /// The totals of several blocks, added in their order.
    pub(super) fn of_all(blocks: &[Self]) -> Self {
        let mut whole = Self::default();
        for block in blocks {
            whole.dashpot_power += block.dashpot_power;
            whole.fastest_squared = block.fastest_squared.larger(whole.fastest_squared);
            whole.outside = whole.outside.or(block.outside);
            whole.contacts.add(&block.contacts);
        }
        whole
    }
}

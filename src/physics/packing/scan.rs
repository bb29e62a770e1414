//! The search for the disc that another one touches next: where an engine of hard discs spends its time.

use super::disc::{DiscRecord, SENTINEL};
use super::events::NEVER;
use super::motion::{self, Vector};
#[cfg(target_arch = "x86_64")]
use super::scan_simd;
use crate::cell_grid::BlockOffsets;
use crate::cell_lists::{CellLists, NO_DISC};

/// Pairs that are looked at side by side.
pub(super) const LANES: usize = 8;

/// At most so many discs are collected before they are looked at: nine cells of four, up to a power of two.
const COLLECTED: usize = 64;

/// Room for them and what is written behind them.
const ROOM: usize = COLLECTED + 2 * LANES;

/// What all searches share.
#[derive(Clone, Copy)]
pub(super) struct ScanInput<'a> {
    /// All discs.
    pub(super) discs: &'a [DiscRecord],
    /// Where they are.
    pub(super) cells: &'a CellLists,
    /// The corners of the block of cells.
    pub(super) offsets: &'a BlockOffsets,
    /// How large discs are.
    pub(super) sizes: DiscSizes<'a>,
}

/// How large discs are.
#[derive(Clone, Copy)]
pub(super) enum DiscSizes<'a> {
    /// Any two touch at this distance of their centers.
    Equal(f64),
    /// Each has its own radius.
    Mixed(&'a [f64]),
    /// Each has its own radius, all of them now at this scale that grows at this rate.
    Growing {
        /// Radii at full scale.
        radii: &'a [f64],
        /// The scale now.
        scale: f64,
        /// Its growth in a unit of time.
        rate: f64,
    },
}

/// The contact that comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PredictedContact {
    /// Time until then, or [`NEVER`].
    pub(super) wait: f64,
    /// CollisionPartner whom; of several at the same time the one of the smallest number; the disc itself if there is none.
    pub(super) partner: u32,
}

/// Who searches: a disc, as it flies now.
#[derive(Clone, Copy)]
pub(super) struct MovingDisc {
    pub(super) id: u32,
    pub(super) cell: [u16; 2],
    /// From the corner of its cell.
    pub(super) position: Vector,
    pub(super) velocity: Vector,
    pub(super) now: f64,
}

/// The first contact of one of equal discs with any disc of the block around its cell. `HAS_AVX512` takes the instructions of
/// 512 bits, which the processor must have.
#[inline(always)]
pub(super) fn first_contact_of_equal_discs<const HAS_AVX512: bool>(
    discs: &[DiscRecord],
    cells: &CellLists,
    offsets: &BlockOffsets,
    moving: MovingDisc,
    contact_distance: f64,
) -> PredictedContact {
    #[cfg(target_arch = "x86_64")]
    if HAS_AVX512
        && !cells.has_overflow()
        && let Some(contact) =
            scan_simd::first_contact(discs, cells, offsets, moving, contact_distance)
    {
        return contact;
    }
    let field = ScanInput { discs, cells, offsets, sizes: DiscSizes::Equal(contact_distance) };
    if HAS_AVX512 { first_contact(field, moving) } else { search(field, moving) }
}

/// The first contact of a disc with any disc of the block around its cell.
#[inline(never)]
pub(super) fn first_contact(field: ScanInput<'_>, moving: MovingDisc) -> PredictedContact {
    search(field, moving)
}

#[inline(always)]
fn search(field: ScanInput<'_>, moving: MovingDisc) -> PredictedContact {
    let mut near = Candidates { discs: [NO_DISC; ROOM], places: [0; ROOM], count: 0 };
    collect(field.cells.block_slots(moving.cell), &mut near);
    let no_contact = PredictedContact { wait: NEVER, partner: moving.id };
    let mut first = of_lanes(field, &moving, &near, 0, no_contact);
    let mut begin = LANES;
    while begin < near.count {
        first = of_lanes(field, &moving, &near, begin, first);
        begin += LANES;
    }
    if field.cells.has_overflow() {
        first = crowds(field, &moving, first);
    }
    first
}

/// Collects the discs of nine cells. Behind them, up to a multiple of the lanes, stands nobody.
#[inline(always)]
fn collect(cells: [&[u32; 4]; 9], near: &mut Candidates) {
    for (place, slots) in cells.into_iter().enumerate() {
        let count = near.count % COLLECTED;
        near.discs[count..count + 4].copy_from_slice(slots);
        near.places[count..count + 4].fill(place as u32);
        near.count = count + slots.iter().filter(|&&slot| slot != NO_DISC).count();
    }
    let count = near.count % COLLECTED;
    near.discs[count..count + LANES].fill(NO_DISC);
    near.places[count..count + LANES].fill(0);
}

/// Discs that may be touched, and in which cell of the block each is.
pub(super) struct Candidates {
    pub(super) discs: [u32; ROOM],
    pub(super) places: [u32; ROOM],
    pub(super) count: usize,
}

/// Looks at discs that stand behind the last places of crowded cells.
#[inline(never)]
fn crowds(
    field: ScanInput<'_>,
    moving: &MovingDisc,
    mut first: PredictedContact,
) -> PredictedContact {
    let mut near = Candidates { discs: [NO_DISC; ROOM], places: [0; ROOM], count: 0 };
    for (place, slots) in field.cells.block_slots(moving.cell).into_iter().enumerate() {
        let mut disc = slots[3];
        while disc != NO_DISC {
            disc = field.cells.next_in_list(disc);
            near.discs[near.count] = disc;
            near.places[near.count] = place as u32;
            near.count += usize::from(disc != NO_DISC);
            if near.count == LANES {
                first = of_lanes(field, moving, &near, 0, first);
                near.count = 0;
            }
        }
    }
    near.discs[near.count..LANES].fill(NO_DISC);
    of_lanes(field, moving, &near, 0, first)
}

/// The earlier one of a contact and those with the discs that stand from `begin` on.
#[inline(always)]
fn of_lanes(
    field: ScanInput<'_>,
    moving: &MovingDisc,
    near: &Candidates,
    begin: usize,
    first: PredictedContact,
) -> PredictedContact {
    let mut partners = [0; LANES];
    partners.copy_from_slice(&near.discs[begin..begin + LANES]);
    let mut places = [0; LANES];
    places.copy_from_slice(&near.places[begin..begin + LANES]);
    let mut others = [&SENTINEL; LANES];
    for (other, partner) in others.iter_mut().zip(partners) {
        *other = field.discs.get(partner as usize).unwrap_or(&SENTINEL);
    }
    let gathered = gather(others, &places, field.offsets);
    let waits = match field.sizes {
        DiscSizes::Equal(contact_distance) => waits(moving, &gathered, &[contact_distance; LANES]),
        DiscSizes::Mixed(radii) => waits(moving, &gathered, &reaches(radii, moving, &partners)),
        DiscSizes::Growing { radii, scale, rate } => {
            let reaches = reaches(radii, moving, &partners);
            growing_waits(moving, &gathered, &reaches, [scale, rate], &partners)
        }
    };
    earliest(&waits, &partners, first)
}

/// At which distances of the centers a disc touches others, at full scale.
fn reaches(radii: &[f64], moving: &MovingDisc, partners: &[u32; LANES]) -> [f64; LANES] {
    let own = radii[moving.id as usize];
    partners.map(|partner| own + radii.get(partner as usize).copied().unwrap_or(0.0))
}

#[inline(always)]
fn waits(moving: &MovingDisc, others: &CandidateStates, reaches: &[f64; LANES]) -> [f64; LANES] {
    let mut waits = [NEVER; LANES];
    for (lane, wait) in waits.iter_mut().enumerate() {
        let (separation, relative) = others.seen_from(moving, lane);
        *wait = motion::time_to_contact(separation, relative, reaches[lane]);
    }
    waits
}

#[inline(never)]
fn growing_waits(
    moving: &MovingDisc,
    others: &CandidateStates,
    reaches: &[f64; LANES],
    [scale, rate]: [f64; 2],
    partners: &[u32; LANES],
) -> [f64; LANES] {
    let mut waits = [NEVER; LANES];
    for (lane, wait) in waits.iter_mut().enumerate() {
        // A growing disc is the only one that would touch itself.
        if partners[lane] != moving.id && partners[lane] != NO_DISC {
            let (separation, relative) = others.seen_from(moving, lane);
            let (distance, growth) = (scale * reaches[lane], rate * reaches[lane]);
            *wait = motion::time_to_growing_contact(separation, relative, distance, growth);
        }
    }
    waits
}

/// The earliest of the contacts and of another one; at the same time the one of the smallest number.
#[inline(always)]
fn earliest(
    waits: &[f64; LANES],
    partners: &[u32; LANES],
    first: PredictedContact,
) -> PredictedContact {
    // Halves against halves, so that the lanes work side by side.
    let mut halved = *waits;
    for half in [4, 2, 1] {
        for lane in 0..half {
            let (one, other) = (halved[lane], halved[lane + half]);
            halved[lane] = if one < other { one } else { other };
        }
    }
    let wait = halved[0];
    let lanes = lanes_with(waits, wait);
    if (lanes.count_ones() > 1) & (wait < NEVER) | (wait == first.wait) {
        return earliest_of_equals(waits, partners, wait, first);
    }
    let partner = partners[lanes.trailing_zeros() as usize % LANES];
    let is_earlier = wait < first.wait;
    PredictedContact {
        wait: if is_earlier { wait } else { first.wait },
        partner: if is_earlier { partner } else { first.partner },
    }
}

#[inline(always)]
fn lanes_with(numbers: &[f64; LANES], number: f64) -> u32 {
    let mut lanes = 0;
    for (lane, &other) in numbers.iter().enumerate() {
        lanes |= u32::from(other == number) << lane;
    }
    lanes
}

/// The same where several come at the same time, or none.
#[inline(never)]
fn earliest_of_equals(
    waits: &[f64; LANES],
    partners: &[u32; LANES],
    wait: f64,
    first: PredictedContact,
) -> PredictedContact {
    if wait == NEVER || first.wait < wait {
        return first;
    }
    let mut partner = if first.wait == wait { first.partner } else { NO_DISC };
    for (&other, &candidate) in waits.iter().zip(partners) {
        if other == wait && candidate < partner {
            partner = candidate;
        }
    }
    PredictedContact { wait, partner }
}

/// The numbers of the discs of all lanes side by side.
pub(super) struct CandidateStates {
    pub(super) position: [[f64; LANES]; 2],
    pub(super) velocity: [[f64; LANES]; 2],
    pub(super) time: [f64; LANES],
    /// From the moving's cell to theirs.
    pub(super) shift: [[f64; LANES]; 2],
}

impl CandidateStates {
    /// The separation now and the relative velocity of one of them.
    #[inline(always)]
    fn seen_from(&self, moving: &MovingDisc, lane: usize) -> (Vector, Vector) {
        let age = moving.now - self.time[lane];
        let along = |axis: usize| {
            let velocity = self.velocity[axis][lane];
            let place = self.position[axis][lane] + self.shift[axis][lane] + velocity * age;
            (place - moving.position[axis], velocity - moving.velocity[axis])
        };
        let (x, y) = (along(0), along(1));
        ([x.0, y.0], [x.1, y.1])
    }
}

#[inline(always)]
fn gather(
    others: [&DiscRecord; LANES],
    places: &[u32; LANES],
    offsets: &BlockOffsets,
) -> CandidateStates {
    let zero = [0.0; LANES];
    let mut gathered =
        CandidateStates { position: [zero; 2], velocity: [zero; 2], time: zero, shift: [zero; 2] };
    for (lane, other) in others.into_iter().enumerate() {
        gathered.time[lane] = other.time;
        for (axis, offsets) in offsets.iter().enumerate() {
            gathered.position[axis][lane] = other.position[axis];
            gathered.velocity[axis][lane] = other.velocity[axis];
            gathered.shift[axis][lane] = offsets[places[lane] as usize % 16];
        }
    }
    gathered
}

#[cfg(test)]
mod tests {
    use super::super::cells::cell_grid;
    use super::*;
    use crate::cell_grid::CellGrid;
    use crate::random::{Seed, Stream};
    use crate::simd::instruction_set::{InstructionSet, WideKernel};

    struct Search<'a> {
        discs: &'a [DiscRecord],
        cells: &'a CellLists,
        offsets: &'a BlockOffsets,
        moving: MovingDisc,
        contact_distance: f64,
    }

    impl WideKernel for Search<'_> {
        type Output = PredictedContact;

        #[inline(always)]
        fn run<const HAS_AVX512: bool>(self) -> PredictedContact {
            let Self { discs, cells, offsets, moving, contact_distance } = self;
            first_contact_of_equal_discs::<HAS_AVX512>(
                discs,
                cells,
                offsets,
                moving,
                contact_distance,
            )
        }
    }

    /// So many discs at random places, overlapping ones too, at most four a cell unless cells may be crowded.
    fn scattered(
        count: u32,
        grid: CellGrid,
        box_side: f64,
        may_crowd: bool,
    ) -> (Vec<DiscRecord>, CellLists) {
        let mut generator = Seed { seed: 5, replicate: 0 }.stream(Stream::Positions);
        let mut cells = CellLists::new(grid);
        let mut discs = Vec::new();
        while discs.len() < count as usize {
            let place =
                [0, 1].map(|_: usize| generator.uniform_in(-0.5 * box_side, 0.5 * box_side));
            let (cell, position) = grid.locate(place);
            let own_slots = cells.block_slots(cell)[4];
            if !may_crowd && own_slots[3] != NO_DISC {
                continue;
            }
            cells.insert(discs.len() as u32, cell, count as usize);
            let (velocity, time) = (generator.normal_pair(), -generator.uniform());
            discs.push(DiscRecord { position, velocity, time, cell, ..SENTINEL });
        }
        (discs, cells)
    }

    /// Promise: every width of lanes gives the same bits, whichever this processor has. Setup: 1500 discs, overlapping ones
    /// too, in the box's middle and at its edges: few in each block, so many that two rounds of lanes are needed, more than
    /// those, and crowded cells. Control: the widest lanes do take part where there are up to sixteen others.
    #[test]
    fn all_lanes_give_the_same_bits() {
        let radius = 1.0;
        for (box_side, may_crowd) in [(120.0, false), (75.0, false), (45.0, true)] {
            let grid = cell_grid([box_side; 2], 2.0 * radius, 1500, false);
            let count = if may_crowd { 1500 } else { 1300 };
            let (discs, cells) = scattered(count, grid, box_side, may_crowd);
            assert_eq!(cells.has_overflow(), may_crowd);
            let offsets = grid.block_offsets();
            let sizes = DiscSizes::Equal(2.0 * radius);
            let field = ScanInput { discs: &discs, cells: &cells, offsets: &offsets, sizes };
            let mut contacts = 0;
            for disc in 0..count {
                let record = &discs[disc as usize];
                let (cell, velocity) = (record.cell, record.velocity);
                let position = record.position_at(0.0);
                let moving = MovingDisc { id: disc, cell, position, velocity, now: 0.0 };
                let plain = first_contact(field, moving);
                contacts += u32::from(plain.wait < NEVER);
                for lanes in InstructionSet::available() {
                    let contact = lanes.run(Search {
                        discs: &discs,
                        cells: &cells,
                        offsets: &offsets,
                        moving,
                        contact_distance: 2.0 * radius,
                    });
                    assert_eq!(contact.wait.to_bits(), plain.wait.to_bits());
                    assert_eq!(contact.partner, plain.partner);
                }
            }
            assert!(contacts > 500, "{contacts}");
        }
    }
}

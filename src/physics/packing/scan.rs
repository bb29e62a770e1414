//! The contact scan: finds the disc that a disc touches first. The engine spends most of its time here.
//!
//! Candidates are the discs of the 3 x 3 block around the disc's cell. They are gathered into lanes and processed without
//! branches, so that the compiler vectorizes the loops. For equal discs, `scan_lanes` does the same in registers of AVX2 and SSE2.

use super::contact::{DiscSizes, MovingDisc, PredictedContact, ScanInput};
use super::disc::{DiscRecord, SENTINEL};
use super::events::NEVER;
use super::motion::{self, Vector};
#[cfg(target_arch = "x86_64")]
use super::scan_lanes;
use crate::cell_lists::NO_DISC;
#[cfg(target_arch = "x86_64")]
use crate::simd::{avx2::F64x4, sse2::F64x2};

/// Number of pairs that are processed in parallel.
const LANES: usize = 8;

/// Largest number of candidates that are collected before they are processed: nine cells of four discs, rounded up to a
/// power of two.
const MAX_CANDIDATES: usize = 64;

/// Room for the candidates and for the lanes that are written after them.
const ROOM: usize = MAX_CANDIDATES + 2 * LANES;

/// Finds the first contact of a disc with the discs of the block around its cell; all radii are equal. The
/// processor must have registers of `WIDTH` numbers, and the caller must be compiled for them.
#[inline(always)]
pub(super) fn first_contact_of_equal_discs<const WIDTH: usize, const FALLS: bool>(
    input: ScanInput<'_>,
    moving: MovingDisc,
) -> PredictedContact {
    #[cfg(target_arch = "x86_64")]
    if let (DiscSizes::Equal(distance), false) = (input.sizes, input.cells.has_overflow()) {
        let contact = if WIDTH >= 4 {
            scan_lanes::first_contact::<4, F64x4, FALLS>(input, moving, distance)
        } else {
            scan_lanes::first_contact::<2, F64x2, FALLS>(input, moving, distance)
        };
        if let Some(contact) = contact {
            return contact;
        }
    }
    first_contact::<FALLS>(input, moving)
}

/// Finds the first contact of a disc with the discs of the block around its cell.
#[inline(never)]
pub(super) fn first_contact<const FALLS: bool>(
    input: ScanInput<'_>,
    moving: MovingDisc,
) -> PredictedContact {
    scan::<FALLS>(input, moving)
}

#[inline(always)]
fn scan<const FALLS: bool>(input: ScanInput<'_>, moving: MovingDisc) -> PredictedContact {
    let mut candidates = Candidates::none();
    candidates.collect(input.cells.block_slots(moving.cell));
    let no_contact = PredictedContact { time_to_contact: NEVER, partner: moving.id };
    let mut first = scan_lanes::<FALLS>(input, &moving, &candidates, 0, no_contact);
    let mut begin = LANES;
    while begin < candidates.count {
        first = scan_lanes::<FALLS>(input, &moving, &candidates, begin, first);
        begin += LANES;
    }
    if input.cells.has_overflow() {
        first = scan_overflow::<FALLS>(input, &moving, first);
    }
    first
}

/// Discs that may be touched, and the cell of the block of each.
struct Candidates {
    ids: [u32; ROOM],
    block_cells: [u32; ROOM],
    count: usize,
}

impl Candidates {
    #[inline(always)]
    fn none() -> Self {
        Self { ids: [NO_DISC; ROOM], block_cells: [0; ROOM], count: 0 }
    }

    /// Collects the discs of nine cells. The lanes after them, up to a multiple of their number, are empty.
    #[inline(always)]
    fn collect(&mut self, cells: [&[u32; 4]; 9]) {
        for (cell, slots) in cells.into_iter().enumerate() {
            let count = self.count % MAX_CANDIDATES;
            self.ids[count..count + 4].copy_from_slice(slots);
            self.block_cells[count..count + 4].fill(cell as u32);
            self.count = count + slots.iter().filter(|&&slot| slot != NO_DISC).count();
        }
        let count = self.count % MAX_CANDIDATES;
        self.ids[count..count + LANES].fill(NO_DISC);
        self.block_cells[count..count + LANES].fill(0);
    }
}

/// Scans the discs that are in the linked lists of cells with more than four discs.
#[inline(never)]
fn scan_overflow<const FALLS: bool>(
    input: ScanInput<'_>,
    moving: &MovingDisc,
    mut first: PredictedContact,
) -> PredictedContact {
    let mut candidates = Candidates::none();
    for (cell, slots) in input.cells.block_slots(moving.cell).into_iter().enumerate() {
        let mut disc = slots[3];
        while disc != NO_DISC {
            disc = input.cells.next_in_list(disc);
            candidates.ids[candidates.count] = disc;
            candidates.block_cells[candidates.count] = cell as u32;
            candidates.count += usize::from(disc != NO_DISC);
            if candidates.count == LANES {
                first = scan_lanes::<FALLS>(input, moving, &candidates, 0, first);
                candidates.count = 0;
            }
        }
    }
    candidates.ids[candidates.count..LANES].fill(NO_DISC);
    scan_lanes::<FALLS>(input, moving, &candidates, 0, first)
}

/// The earliest of a contact and those with the candidates from `begin` on.
#[inline(always)]
fn scan_lanes<const FALLS: bool>(
    input: ScanInput<'_>,
    moving: &MovingDisc,
    candidates: &Candidates,
    begin: usize,
    first: PredictedContact,
) -> PredictedContact {
    let mut partners = [0; LANES];
    partners.copy_from_slice(&candidates.ids[begin..begin + LANES]);
    let mut block_cells = [0; LANES];
    block_cells.copy_from_slice(&candidates.block_cells[begin..begin + LANES]);
    let mut records = [&SENTINEL; LANES];
    for (record, partner) in records.iter_mut().zip(partners) {
        *record = input.discs.get(partner as usize).unwrap_or(&SENTINEL);
    }
    let states = CandidateStates::gather(records, &block_cells, input);
    let times = match input.sizes {
        DiscSizes::Equal(contact_distance) => {
            contact_times::<FALLS>(moving, &states, &[contact_distance; LANES])
        }
        DiscSizes::Mixed(radii) => {
            let distances = contact_distances(radii, moving, &partners);
            contact_times::<FALLS>(moving, &states, &distances)
        }
        DiscSizes::Growing { radii, scale, rate } => {
            let distances = contact_distances(radii, moving, &partners);
            growing_contact_times(moving, &states, &distances, [scale, rate], &partners)
        }
    };
    earliest(&times, &partners, first)
}

/// The distances of the centers at which a disc touches the candidates, at full radii.
fn contact_distances(radii: &[f64], moving: &MovingDisc, partners: &[u32; LANES]) -> [f64; LANES] {
    let own = radii[moving.id as usize];
    partners.map(|partner| own + radii.get(partner as usize).copied().unwrap_or(0.0))
}

#[inline(always)]
fn contact_times<const FALLS: bool>(
    moving: &MovingDisc,
    candidates: &CandidateStates,
    distances: &[f64; LANES],
) -> [f64; LANES] {
    let mut times = [NEVER; LANES];
    for (lane, time) in times.iter_mut().enumerate() {
        let (separation, relative) = candidates.relative_to::<FALLS>(moving, lane);
        *time = motion::time_to_contact(separation, relative, distances[lane]);
    }
    times
}

#[inline(never)]
fn growing_contact_times(
    moving: &MovingDisc,
    candidates: &CandidateStates,
    distances: &[f64; LANES],
    [scale, rate]: [f64; 2],
    partners: &[u32; LANES],
) -> [f64; LANES] {
    let mut times = [NEVER; LANES];
    for (lane, time) in times.iter_mut().enumerate() {
        // Only a growing disc would touch itself.
        if partners[lane] != moving.id && partners[lane] != NO_DISC {
            let (separation, relative) = candidates.relative_to::<false>(moving, lane);
            let (distance, growth_rate) = (scale * distances[lane], rate * distances[lane]);
            *time = motion::time_to_growing_contact(separation, relative, distance, growth_rate);
        }
    }
    times
}

/// The earliest of the contacts and of another one; of several at the same time, the one with the smallest id.
#[inline(always)]
fn earliest(
    times: &[f64; LANES],
    partners: &[u32; LANES],
    first: PredictedContact,
) -> PredictedContact {
    // The minimum by halves, so that the lanes are compared in parallel.
    let mut halved = *times;
    for half in [4, 2, 1] {
        for lane in 0..half {
            let (one, other) = (halved[lane], halved[lane + half]);
            halved[lane] = if one < other { one } else { other };
        }
    }
    let time = halved[0];
    let lanes = lanes_equal_to(times, time);
    if (lanes.count_ones() > 1) & (time < NEVER) | (time == first.time_to_contact) {
        return earliest_of_simultaneous(times, partners, time, first);
    }
    let partner = partners[lanes.trailing_zeros() as usize % LANES];
    let is_earlier = time < first.time_to_contact;
    PredictedContact {
        time_to_contact: if is_earlier { time } else { first.time_to_contact },
        partner: if is_earlier { partner } else { first.partner },
    }
}

/// The lanes that contain a number, as a bit mask.
#[inline(always)]
fn lanes_equal_to(numbers: &[f64; LANES], number: f64) -> u32 {
    let mut lanes = 0;
    for (lane, &other) in numbers.iter().enumerate() {
        lanes |= u32::from(other == number) << lane;
    }
    lanes
}

/// The earliest contact if several have the same time, or if there is none.
#[inline(never)]
fn earliest_of_simultaneous(
    times: &[f64; LANES],
    partners: &[u32; LANES],
    time: f64,
    first: PredictedContact,
) -> PredictedContact {
    if time == NEVER || first.time_to_contact < time {
        return first;
    }
    let mut partner = if first.time_to_contact == time { first.partner } else { NO_DISC };
    for (&other, &candidate) in times.iter().zip(partners) {
        if other == time && candidate < partner {
            partner = candidate;
        }
    }
    PredictedContact { time_to_contact: time, partner }
}

/// The states of the candidates of all lanes, by column.
struct CandidateStates {
    position: [[f64; LANES]; 2],
    velocity: [[f64; LANES]; 2],
    time: [f64; LANES],
    /// Offset from the cell of the moving disc to that of the candidate.
    offset: [[f64; LANES]; 2],
    gravity: f64,
}

impl CandidateStates {
    #[inline(always)]
    fn gather(
        records: [&DiscRecord; LANES],
        block_cells: &[u32; LANES],
        input: ScanInput<'_>,
    ) -> Self {
        let zero = [0.0; LANES];
        let mut states = Self {
            position: [zero; 2],
            velocity: [zero; 2],
            time: zero,
            offset: [zero; 2],
            gravity: input.gravity,
        };
        for (lane, record) in records.into_iter().enumerate() {
            states.time[lane] = record.time;
            for (axis, offsets) in input.offsets.columns.iter().enumerate() {
                states.position[axis][lane] = record.position[axis];
                states.velocity[axis][lane] = record.velocity[axis];
                states.offset[axis][lane] = offsets[block_cells[lane] as usize % 16];
            }
        }
        states
    }

    /// The present separation and relative velocity of a candidate.
    #[inline(always)]
    fn relative_to<const FALLS: bool>(&self, moving: &MovingDisc, lane: usize) -> (Vector, Vector) {
        let age = moving.now - self.time[lane];
        let fall = if FALLS { self.gravity * age } else { 0.0 };
        let along = |axis: usize| {
            let mut velocity = self.velocity[axis][lane];
            let mut position = self.position[axis][lane] + self.offset[axis][lane] + velocity * age;
            if FALLS && axis == 1 {
                position -= 0.5 * fall * age;
                velocity -= fall;
            }
            (position - moving.position[axis], velocity - moving.velocity[axis])
        };
        let (x, y) = (along(0), along(1));
        ([x.0, y.0], [x.1, y.1])
    }
}

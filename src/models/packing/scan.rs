//! The search for the disc that another one touches next: where an engine of hard discs spends its time.

use super::cells::{Cells, NOBODY, Shifts};
use super::disc::Disc;
use super::events::NEVER;
use super::motion::{self, Vector};
use super::processor::wide;

/// Pairs that are looked at side by side.
pub(super) const LANES: usize = 8;

/// At most so many discs are collected before they are looked at: nine cells of four, up to a power of two.
const COLLECTED: usize = 64;

/// Room for them and what is written behind them.
const ROOM: usize = COLLECTED + 2 * LANES;

/// What all searches share.
#[derive(Clone, Copy)]
pub(super) struct Field<'a> {
    /// All discs.
    pub(super) discs: &'a [Disc],
    /// Where they are.
    pub(super) cells: &'a Cells,
    /// The corners of the block of cells.
    pub(super) shifts: &'a Shifts,
    /// How large discs are.
    pub(super) sizes: Sizes<'a>,
}

/// How large discs are.
#[derive(Clone, Copy)]
pub(super) enum Sizes<'a> {
    /// Any two touch at this distance of their centres.
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
pub(super) struct Contact {
    /// Time until then, or [`NEVER`].
    pub(super) wait: f64,
    /// With whom; of several at the same time the one of the smallest number.
    pub(super) partner: u32,
}

/// The first contact of a disc that is now at `position` in its cell, with any disc of the block around that cell.
/// `WIDE` takes the instructions of 512 bits, which the processor must have.
#[inline(always)]
pub(super) fn first_contact<const WIDE: bool>(
    field: Field<'_>,
    disc: u32,
    position: Vector,
    now: f64,
) -> Contact {
    let own = &field.discs[disc as usize];
    let seeker = Seeker { disc, position, velocity: own.velocity, now };
    let mut first = Contact { wait: NEVER, partner: NOBODY };
    if WIDE
        && !field.cells.are_crowded()
        && let Some(rows) = field.cells.rows_around(own.cell)
        && let Some(Collected { discs, places, count }) = wide::collect(rows, disc)
    {
        let ([low, high], [low_places, high_places]) = (halves(discs), halves(places));
        first = of_lanes::<WIDE>(field, &seeker, low, low_places, first);
        if count > LANES {
            first = of_lanes::<WIDE>(field, &seeker, high, high_places, first);
        }
        return first;
    }
    let mut near = Near { discs: [disc; ROOM], places: [4; ROOM], count: 0 };
    for (place, slots) in field.cells.around(own.cell).enumerate() {
        let count = near.count;
        near.discs[count..count + 4].copy_from_slice(slots);
        near.places[count..count + 4].fill(place as u32);
        let taken = slots.iter().filter(|&&slot| slot != NOBODY).count();
        near.count = (count + taken) % COLLECTED;
        if field.cells.are_crowded() && slots[3] != NOBODY {
            first = crowd::<WIDE>(field, &seeker, slots[3], place as u32, &mut near, first);
        }
    }
    of_near::<WIDE>(field, &seeker, &mut near, first)
}

/// Who searches.
struct Seeker {
    disc: u32,
    position: Vector,
    velocity: Vector,
    now: f64,
}

/// Discs that may be touched, and in which cell of the block each is.
struct Near {
    discs: [u32; ROOM],
    places: [u32; ROOM],
    count: usize,
}

/// The same for two rounds of lanes.
pub(super) struct Collected {
    pub(super) discs: [u32; 2 * LANES],
    pub(super) places: [u32; 2 * LANES],
    pub(super) count: usize,
}

#[inline(always)]
fn halves(both: [u32; 2 * LANES]) -> [[u32; LANES]; 2] {
    let [mut low, mut high] = [[0; LANES]; 2];
    low.copy_from_slice(&both[..LANES]);
    high.copy_from_slice(&both[LANES..]);
    [low, high]
}

/// Looks at discs that stand behind the last place of a crowded cell.
#[inline(never)]
fn crowd<const WIDE: bool>(
    field: Field<'_>,
    seeker: &Seeker,
    last: u32,
    place: u32,
    near: &mut Near,
    mut first: Contact,
) -> Contact {
    let mut disc = field.cells.behind(last);
    while disc != NOBODY {
        if near.count >= LANES {
            first = of_near::<WIDE>(field, seeker, near, first);
            near.count = 0;
        }
        near.discs[near.count] = disc;
        near.places[near.count] = place;
        near.count += 1;
        disc = field.cells.behind(disc);
    }
    if near.count >= LANES {
        first = of_near::<WIDE>(field, seeker, near, first);
        near.count = 0;
    }
    first
}

#[inline(always)]
fn of_near<const WIDE: bool>(
    field: Field<'_>,
    seeker: &Seeker,
    near: &mut Near,
    mut first: Contact,
) -> Contact {
    // The lanes that are left over look at the disc itself, which it never touches.
    near.discs[near.count..near.count + LANES].fill(seeker.disc);
    near.places[near.count..near.count + LANES].fill(4);
    let mut begin = 0;
    while begin < near.count {
        let mut partners = [0; LANES];
        partners.copy_from_slice(&near.discs[begin..begin + LANES]);
        let mut places = [0; LANES];
        places.copy_from_slice(&near.places[begin..begin + LANES]);
        first = of_lanes::<WIDE>(field, seeker, partners, places, first);
        begin += LANES;
    }
    first
}

#[inline(always)]
fn of_lanes<const WIDE: bool>(
    field: Field<'_>,
    seeker: &Seeker,
    partners: [u32; LANES],
    places: [u32; LANES],
    first: Contact,
) -> Contact {
    let mut others = [&field.discs[seeker.disc as usize]; LANES];
    for (other, partner) in others.iter_mut().zip(partners) {
        *other = &field.discs[partner as usize];
    }
    let Gathered { position, velocity, time, shift } = if WIDE {
        wide::gather(others, &places, field.shifts)
    } else {
        gather(others, &places, field.shifts)
    };
    let mut reach = [0.0; LANES];
    match field.sizes {
        Sizes::Equal(contact_distance) => reach = [contact_distance; LANES],
        Sizes::Mixed(radii) | Sizes::Growing { radii, .. } => {
            for (reach, partner) in reach.iter_mut().zip(partners) {
                *reach = radii[seeker.disc as usize] + radii[partner as usize];
            }
        }
    }
    let mut waits = [NEVER; LANES];
    for lane in 0..LANES {
        let age = seeker.now - time[lane];
        let separation = [
            position[0][lane] + shift[0][lane] + velocity[0][lane] * age - seeker.position[0],
            position[1][lane] + shift[1][lane] + velocity[1][lane] * age - seeker.position[1],
        ];
        let relative =
            [velocity[0][lane] - seeker.velocity[0], velocity[1][lane] - seeker.velocity[1]];
        if let Sizes::Growing { scale, rate, .. } = field.sizes {
            let (distance, growth) = (scale * reach[lane], rate * reach[lane]);
            let wait = motion::time_to_growing_contact(separation, relative, distance, growth);
            // A growing disc is the only one that would touch itself.
            waits[lane] = if partners[lane] == seeker.disc { NEVER } else { wait };
        } else {
            waits[lane] = motion::time_to_contact(separation, relative, reach[lane]);
        }
    }
    earliest(waits, partners, first)
}

/// The earliest of the contacts and of another one; at the same time the one of the smallest number.
#[inline(always)]
fn earliest(waits: [f64; LANES], partners: [u32; LANES], first: Contact) -> Contact {
    // Halves against halves, so that the lanes work side by side.
    let mut halved = waits;
    for half in [4, 2, 1] {
        for lane in 0..half {
            let (one, other) = (halved[lane], halved[lane + half]);
            halved[lane] = if one < other { one } else { other };
        }
    }
    if first.wait < halved[0] || halved[0] == NEVER {
        return first;
    }
    let mut named = [first.partner; LANES];
    if halved[0] < first.wait {
        named = [NOBODY; LANES];
    }
    for lane in 0..LANES {
        let candidate = if waits[lane] == halved[0] { partners[lane] } else { NOBODY };
        named[lane] = if candidate < named[lane] { candidate } else { named[lane] };
    }
    let partner =
        named.into_iter().fold(NOBODY, |least, next| if next < least { next } else { least });
    Contact { wait: halved[0], partner }
}

/// The numbers of the discs of all lanes side by side.
pub(super) struct Gathered {
    pub(super) position: [[f64; LANES]; 2],
    pub(super) velocity: [[f64; LANES]; 2],
    pub(super) time: [f64; LANES],
    /// From the seeker's cell to theirs.
    pub(super) shift: [[f64; LANES]; 2],
}

#[inline(always)]
fn gather(others: [&Disc; LANES], places: &[u32; LANES], shifts: &Shifts) -> Gathered {
    let zero = [0.0; LANES];
    let mut gathered =
        Gathered { position: [zero; 2], velocity: [zero; 2], time: zero, shift: [zero; 2] };
    for (lane, other) in others.into_iter().enumerate() {
        gathered.time[lane] = other.time;
        for (axis, shifts) in shifts.iter().enumerate() {
            gathered.position[axis][lane] = other.position[axis];
            gathered.velocity[axis][lane] = other.velocity[axis];
            gathered.shift[axis][lane] = shifts[places[lane] as usize % 16];
        }
    }
    gathered
}

#[cfg(test)]
mod tests {
    use super::super::cells::Grid;
    use super::super::events::EventCode;
    use super::super::processor::Lanes;
    use super::*;
    use crate::random::{Seed, Stream};

    /// Promise: every width of lanes gives the same bits, whichever this processor has. Setup: 4000 discs at random places,
    /// overlapping ones too, in cells of four and in crowded ones, equal and mixed radii.
    #[test]
    fn all_lanes_give_the_same_bits() {
        for (box_side, radius) in [(100.0, 1.0), (60.0, 0.4)] {
            let mut generator = Seed { seed: 5, replicate: 0 }.stream(Stream::Positions);
            let grid = Grid::new([box_side; 2], 2.0 * radius, 1500, true);
            let mut cells = Cells::new(grid);
            let mut discs = Vec::new();
            for disc in 0..1500 {
                let place = [0, 1].map(|_: usize| {
                    generator.uniform_in(radius - 0.5 * box_side, 0.5 * box_side - radius)
                });
                let (cell, position) = grid.locate(place);
                let velocity = generator.normal_pair();
                let time = -generator.uniform();
                let event = EventCode::NOTHING;
                let (partner_collisions, collisions) = (0, 0);
                cells.insert(disc, cell, 1500);
                discs.push(Disc {
                    position,
                    velocity,
                    time,
                    event_time: NEVER,
                    event,
                    partner_collisions,
                    collisions,
                    cell,
                });
            }
            let radii: Vec<f64> = (0..1500).map(|_| generator.uniform_in(0.1, radius)).collect();
            let shifts = grid.shifts();
            let mut contacts = 0;
            for sizes in [Sizes::Equal(2.0 * radius), Sizes::Mixed(&radii)] {
                let field = Field { discs: &discs, cells: &cells, shifts: &shifts, sizes };
                for disc in 0..1500 {
                    let position = discs[disc as usize].position_at(0.0);
                    let plain = first_contact::<false>(field, disc, position, 0.0);
                    contacts += u32::from(plain.wait < NEVER);
                    for lanes in Lanes::available() {
                        let wide = lanes.first_contact(field, disc, position, 0.0);
                        assert_eq!(wide.wait.to_bits(), plain.wait.to_bits());
                        assert_eq!(wide.partner, plain.partner);
                    }
                }
            }
            assert!(contacts > 500, "{contacts}");
        }
    }
}

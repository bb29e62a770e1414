//! The paths of hard discs between frames, by the collisions of `/events`: a disc flies straight, in gravity on a parabola, from one corner of its path
//! to the next. At a periodic side, two corners at one time lead to the opposite side.

use super::encoding::{ABSENT, LARGEST, append_series, quantized};
use super::still::{Columns, Still};
use super::view::Range;
use crate::models::contract::{Extent, Flight};
use kinetoscope_recording::channels::{GasEvents, PackingEvents};
use kinetoscope_recording::reader::RecordedFrame;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Largest distance of a recorded position from the end of its path, in longer sides of the container: flights lead to it within some roundings.
const MOST_MISSED: f64 = 1e-9;
/// Bytes of the page per corner that is kept at most: corners of 6 bytes take at most half of the replay, in base64.
const BYTES_PER_CORNER: usize = 16;

/// A disc after its last corner.
#[derive(Clone, Copy, Debug)]
struct Disc {
    place: [f64; 2],
    velocity: [f64; 2],
    time: f64,
}

/// A place where the path of a disc has a corner, before or at the frame of this number.
#[derive(Clone, Copy, Debug)]
struct Corner {
    disc: usize,
    frame: u64,
    time: f64,
    place: [f64; 2],
}

/// The paths from the first frame up to one, as far as the collisions lead from each frame to the next.
#[derive(Debug)]
pub(super) struct Flights {
    law: Option<Flight>,
    bounds: [[f64; 2]; 2],
    is_periodic: bool,
    most_corners: usize,
    discs: Vec<Disc>,
    corners: Vec<Corner>,
    /// The last frame that the paths lead to.
    until: u64,
    has_ended: bool,
    /// Whether they ended because the corners were too many.
    has_no_room: bool,
    /// Whether the recording has collisions.
    is_recorded: bool,
}

/// What the script needs to draw paths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct DrawnFlights {
    pub(super) corners: usize,
    /// Number of intervals between frames, from the first one, whose motion is known.
    pub(super) intervals: usize,
    /// Half of the acceleration downward, in stored steps.
    pub(super) fall: f64,
}

impl Flights {
    /// For a replay of at most `max_bytes` in the page.
    pub(super) fn new(extent: &Extent, max_bytes: usize) -> Self {
        Self {
            law: extent.flight.clone(),
            bounds: extent.bounds.unwrap_or_default(),
            is_periodic: extent.is_periodic,
            most_corners: max_bytes / BYTES_PER_CORNER,
            discs: Vec::new(),
            corners: Vec::new(),
            until: 0,
            has_ended: false,
            has_no_room: false,
            is_recorded: false,
        }
    }

    /// Takes in a frame with the collisions since the one before, for every k-th disc. The paths end if the collisions do not lead to the frame, or
    /// are too many.
    pub(super) fn observe(
        &mut self,
        number: u64,
        frame: &RecordedFrame,
        columns: &Columns,
        every: u64,
    ) {
        if self.has_ended {
            return;
        }
        let known = self.corners.len();
        let followed =
            self.law.clone().and_then(|law| self.follow(&law, number, frame, columns, every));
        match followed {
            Some(()) => self.until = number,
            None => {
                self.has_ended = true;
                self.has_no_room = self.corners.len() > self.most_corners;
                self.corners.truncate(known);
            }
        }
    }

    fn follow(
        &mut self,
        law: &Flight,
        number: u64,
        frame: &RecordedFrame,
        columns: &Columns,
        every: u64,
    ) -> Option<()> {
        let (events, end) = (events(frame)?, frame.clock.time);
        self.is_recorded = true;
        for (event, time) in events.time.iter().enumerate() {
            let [first, second] = [events.first_id[event], events.second_id[event]];
            let impulse = [events.impulse_x[event], events.impulse_y[event]];
            let turns = [(first, 1.0), (second, -1.0)];
            for (id, sign) in turns.into_iter().take(1 + usize::from(first != second)) {
                let id = usize::try_from(id).ok()?;
                let is_drawn = (id as u64).is_multiple_of(every);
                self.fly(law, id, number, *time, is_drawn)?;
                let disc = &mut self.discs[id];
                for (part, change) in disc.velocity.iter_mut().zip(impulse) {
                    *part += sign * change / law.masses[id % law.masses.len()];
                }
                let place = disc.place;
                self.push(Corner { disc: id, frame: number, time: *time, place }, is_drawn)?;
            }
        }
        let Some(state) = frame.state() else { return Some(()) };
        if number == 0 {
            let at_rest = Disc { place: [0.0; 2], velocity: [0.0; 2], time: end };
            self.discs = vec![at_rest; state.rows()];
        }
        for row in 0..state.rows() {
            let values = state.row(row);
            let id = usize::try_from(columns.number(row, values)).ok()?;
            let [place, velocity] = columns.motion(values)?;
            if number > 0 {
                let is_drawn = (id as u64).is_multiple_of(every);
                self.fly(law, id, number, end, is_drawn)?;
                let found = self.discs[id].place;
                // A disc on a periodic side may be recorded at the opposite one.
                if self.is_elsewhere(found, place)? {
                    self.push(
                        Corner { disc: id, frame: number, time: end, place: found },
                        is_drawn,
                    )?;
                }
            }
            *self.discs.get_mut(id)? = Disc { place, velocity, time: end };
        }
        Some(())
    }

    /// Whether two places are the same one at opposite sides; `None` for different places.
    fn is_elsewhere(&self, found: [f64; 2], recorded: [f64; 2]) -> Option<bool> {
        let sides = [0, 1].map(|axis| self.bounds[1][axis] - self.bounds[0][axis]);
        let mut is_elsewhere = false;
        for axis in 0..2 {
            let gap = found[axis] - recorded[axis];
            let turns = if self.is_periodic { libm::round(gap / sides[axis]) } else { 0.0 };
            is_elsewhere |= turns != 0.0;
            let missed = (gap - turns * sides[axis]).abs();
            (missed <= MOST_MISSED * sides[0].max(sides[1])).then_some(())?;
        }
        Some(is_elsewhere)
    }

    fn push(&mut self, corner: Corner, is_drawn: bool) -> Option<()> {
        if is_drawn {
            self.corners.push(corner);
        }
        (self.corners.len() <= self.most_corners).then_some(())
    }

    /// Moves a disc to a time without a collision. Only a disc that is drawn is moved from a periodic side to the opposite one.
    fn fly(&mut self, law: &Flight, id: usize, frame: u64, to: f64, is_drawn: bool) -> Option<()> {
        while is_drawn && self.is_periodic {
            let disc = *self.discs.get(id)?;
            let hit = |axis: usize| {
                let side = usize::from(disc.velocity[axis] > 0.0);
                let way = self.bounds[side][axis] - disc.place[axis];
                let after = if disc.velocity[axis] == 0.0 {
                    f64::INFINITY
                } else {
                    way / disc.velocity[axis]
                };
                (after.max(0.0), axis, side)
            };
            let [across, up] = [hit(0), hit(1)];
            let (after, axis, side) = if across.0 < up.0 { across } else { up };
            if disc.time + after > to {
                break;
            }
            let disc = self.discs.get_mut(id)?;
            disc.fly(after, 0.0);
            for side in [side, 1 - side] {
                let disc = &mut self.discs[id];
                disc.place[axis] = self.bounds[side][axis];
                let Disc { place, time, .. } = *disc;
                self.push(Corner { disc: id, frame, time, place }, true)?;
            }
        }
        let disc = self.discs.get_mut(id)?;
        (to >= disc.time).then_some(())?;
        disc.fly(to - disc.time, law.gravity);
        disc.time = to;
        Some(())
    }

    /// Appends, for each interval between frames whose motion is known, the number of corners of each particle; then time, x and y of all corners, particle
    /// after particle. `None` without paths.
    pub(super) fn append(
        &self,
        data: &mut Vec<u8>,
        stills: &[&Still],
        range: &Range,
        [particles, every]: [usize; 2],
    ) -> Option<DrawnFlights> {
        let law = self.law.as_ref()?;
        let intervals = self.drawable_intervals(stills)?;
        let last = stills.get(intervals).filter(|_| intervals > 0)?.number;
        let is_drawn = |corner: &&Corner| corner.frame <= last && corner.disc.is_multiple_of(every);
        let mut corners: Vec<&Corner> = self.corners.iter().filter(is_drawn).collect();
        corners.sort_by_key(|corner| corner.disc);
        let mut counts = vec![0_u16; intervals * particles];
        let mut columns = [Vec::new(), Vec::new(), Vec::new()];
        for Corner { disc, frame, time, place } in &corners {
            let interval = stills.partition_point(|still| still.number < *frame).checked_sub(1)?;
            let count = counts.get_mut(interval * particles + disc / every)?;
            *count = count.checked_add(1)?;
            let [start, end] = [stills[interval].time, stills[interval + 1].time];
            let part = if end > start { (time - start) / (end - start) } else { 0.0 };
            let [x, y] = range.stored(*place);
            (x != ABSENT).then_some(())?;
            let part = quantized(part.clamp(0.0, 1.0), 1.0 / f64::from(LARGEST));
            for (column, value) in columns.iter_mut().zip([part, x, y]) {
                column.push(value);
            }
        }
        append_series(data, &counts, particles, 1);
        for column in columns {
            append_series(data, &column, 1, 1);
        }
        Some(DrawnFlights {
            corners: corners.len(),
            intervals,
            fall: law.gravity / 2.0 / range.step,
        })
    }

    /// Number of intervals between these frames in which the paths are known, and no disc has more corners than can be counted.
    fn drawable_intervals(&self, stills: &[&Still]) -> Option<usize> {
        let known = stills.partition_point(|still| still.number <= self.until).checked_sub(1)?;
        let interval_of = |corner: &Corner| {
            stills.partition_point(|still| still.number < corner.frame).saturating_sub(1)
        };
        let mut counts = BTreeMap::new();
        for corner in &self.corners {
            *counts.entry((interval_of(corner), corner.disc)).or_insert(0) += 1;
        }
        let is_full = |(place, count): (&(usize, usize), &u32)| {
            (*count > u32::from(u16::MAX)).then_some(place.0)
        };
        Some(counts.iter().find_map(is_full).map_or(known, |full| known.min(full)))
    }

    /// The places of all corners, with this radius.
    pub(super) fn places(&self, radius: f64) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.corners.iter().map(move |corner| [corner.place[0], corner.place[1], radius])
    }

    /// Up to where the motion between frames is known.
    pub(super) fn note(&self, stills: &[&Still], drawn: Option<DrawnFlights>) -> String {
        let intervals = drawn.map_or(0, |drawn| drawn.intervals);
        if !self.is_recorded || stills.len() < 2 {
            return String::new();
        }
        let known = " Between frames, discs fly as recorded (channel \"events\")";
        if intervals + 1 == stills.len() {
            return format!("{known}.");
        }
        let is_known = stills[intervals + 1].number <= self.until;
        let why = match self.has_no_room || is_known {
            true => "collisions are too many for a small page",
            false => "collisions do not lead to the recorded positions",
        };
        if intervals == 0 {
            return format!(" The flights between frames are not shown: the {why}.");
        }
        format!("{known} up to frame {}: later {why}.", stills[intervals].number)
    }
}

impl Disc {
    fn fly(&mut self, after: f64, gravity: f64) {
        self.place[0] += self.velocity[0] * after;
        self.place[1] += (self.velocity[1] - 0.5 * gravity * after) * after;
        self.velocity[1] -= gravity * after;
        self.time += after;
    }
}

/// The collisions since the frame before.
fn events(frame: &RecordedFrame) -> Option<PackingEvents> {
    if let Ok(Some(events)) = frame.get() {
        return Some(events);
    }
    let GasEvents {
        event,
        time_s,
        first_id,
        second_id,
        impulse_x_n_s,
        impulse_y_n_s,
        normal_x,
        normal_y,
    } = frame.get().ok()??;
    let [time, impulse_x, impulse_y] = [time_s, impulse_x_n_s, impulse_y_n_s];
    Some(PackingEvents {
        event,
        time,
        first_id,
        second_id,
        impulse_x,
        impulse_y,
        normal_x,
        normal_y,
    })
}

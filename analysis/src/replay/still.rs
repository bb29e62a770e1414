//! A frame as a replay shows it, and the columns of the state behind it.

use super::forces::ForceLine;
use super::lines::Lines;
use kinetoscope_recording::reader::StateTable;
use std::sync::Arc;

/// A particle of a frame. A position keeps its digits: a container may be far from the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) speed: f32,
    pub(super) velocity: [f32; 2],
    pub(super) radius: f32,
    /// Angular velocity, counterclockwise; NaN if it is not recorded.
    pub(super) spin: f32,
}

impl Point {
    /// A particle that the frame does not have; the radius of others is a number.
    pub(super) const ABSENT: Self = Self {
        x: f64::NAN,
        y: f64::NAN,
        speed: f32::NAN,
        velocity: [f32::NAN; 2],
        radius: f32::NAN,
        spin: f32::NAN,
    };

    pub(super) fn disc(&self) -> [f64; 3] {
        [self.x, self.y, f64::from(self.radius)]
    }
}

/// A frame as a replay shows it.
#[derive(Clone, Debug)]
pub(super) struct Still {
    pub(super) number: u64,
    pub(super) time: f64,
    pub(super) points: Vec<Point>,
    pub(super) lines: Arc<Lines>,
    /// The contact forces; empty unless they are requested.
    pub(super) forces: Vec<ForceLine>,
}

/// The columns of the state that a replay shows.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    position: [usize; 2],
    velocity: Vec<usize>,
    /// vx and vy.
    in_plane: Option<[usize; 2]>,
    radius: Option<usize>,
    spin: Option<usize>,
    id: Option<usize>,
}

impl Columns {
    pub(super) fn of(state: &StateTable) -> Option<Self> {
        let index = |name: &str| state.index(name);
        Some(Self {
            position: [index("x")?, index("y")?],
            velocity: ["vx", "vy", "vz"].into_iter().filter_map(index).collect(),
            in_plane: index("vx").zip(index("vy")).map(|(x, y)| [x, y]),
            radius: index("radius"),
            spin: index("spin"),
            id: index("id"),
        })
    }

    /// The particle's number: its id, or else its row.
    pub(super) fn number(&self, row: usize, values: &[f64]) -> u64 {
        let id = self.id.map(|column| values[column]);
        let is_number = |id: &f64| *id >= 0.0 && *id < f64::from(u32::MAX) && id.fract() == 0.0;
        id.filter(is_number).map_or(row as u64, |id| id as u64)
    }

    /// Position and velocity with all digits; `None` without velocities.
    pub(super) fn motion(&self, values: &[f64]) -> Option<[[f64; 2]; 2]> {
        Some([self.position, self.in_plane?].map(|columns| columns.map(|column| values[column])))
    }

    pub(super) fn point(&self, values: &[f64], radius: f64) -> Point {
        let [x, y] = self.position.map(|column| values[column]);
        let squares = self.velocity.iter().map(|column| values[*column] * values[*column]);
        let speed = if self.velocity.is_empty() { f64::NAN } else { squares.sum::<f64>().sqrt() };
        let velocity = self
            .in_plane
            .map_or([f32::NAN; 2], |columns| columns.map(|column| narrowed(values[column])));
        let radius = self.radius.map_or(radius, |column| values[column]) as f32;
        let radius = if radius >= 0.0 { radius } else { 0.0 };
        let spin = self.spin.map_or(f32::NAN, |column| narrowed(values[column]));
        Point { x, y, speed: narrowed(speed), velocity, radius, spin }
    }
}

/// A finite number stays finite; another one becomes NaN.
fn narrowed(value: f64) -> f32 {
    let largest = f64::from(f32::MAX);
    if value.is_finite() { value.clamp(-largest, largest) as f32 } else { f32::NAN }
}

/// Every k-th frame, and the last.
pub(super) fn thinned(stills: &[Still], every: usize) -> Vec<&Still> {
    let mut kept: Vec<&Still> = stills.iter().step_by(every).collect();
    if let Some(last) = stills.last()
        && !(stills.len() - 1).is_multiple_of(every)
    {
        kept.push(last);
    }
    kept
}

/// Removes every second particle.
pub(super) fn halve(points: &mut Vec<Point>) {
    *points = points.iter().copied().step_by(2).collect();
}

/// The points of a frame, followed by absent ones up to this number.
pub(super) fn padded(points: &[Point], number: usize) -> impl Iterator<Item = Point> + Clone + '_ {
    points.iter().copied().chain(std::iter::repeat(Point::ABSENT)).take(number)
}

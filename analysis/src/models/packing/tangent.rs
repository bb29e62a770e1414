//! The largest Lyapunov exponent of hard discs, by the exact motion of an infinitesimal difference.
//!
//! The difference of two neighboring states flies and collides with the discs (Dellago, Posch and Hoover, Phys. Rev. E 53 (1996) 1485). With
//! the discs at contact at time t, their difference of positions δq and of velocities δv, the normal n and the approach g·n < 0, the
//! neighboring state collides δt = -(δq·n)/(g·n) later. Between collisions, δq grows by δv per unit of time. All of it follows
//! from the collisions of `/events` and from the velocities of one frame.

use crate::models::lyapunov::Growth;
use kinetoscope_recording::channels::PackingEvents;
use kinetoscope_recording::reader::StateTable;

type Vector = [f64; 2];

/// A disc, and the difference to its neighbor at the time of its last collision.
#[derive(Clone, Copy, Debug, Default)]
struct Disc {
    velocity: Vector,
    radius: f64,
    /// δq
    shift: Vector,
    /// δv
    change: Vector,
    time: f64,
    /// Length of the longest chain of collisions that ends here.
    chain: u64,
}

/// The difference of two neighboring runs.
#[derive(Clone, Debug, Default)]
pub(super) struct Tangent {
    discs: Vec<Disc>,
    /// Radius of obstacles, if there are any.
    obstacle: Option<f64>,
    has_walls: bool,
    time: f64,
    pub(super) growth: Growth,
    /// The same over the collisions per disc in place of the time.
    pub(super) growth_by_collisions: Growth,
    /// Logarithm of the factor by which the difference was reduced since the last frame.
    reduced: f64,
    events: usize,
    /// Collisions with other discs and with obstacles, of all discs since the last frame.
    collisions: u64,
    /// Time and length of the longest chain when the growth began to count.
    settled: Option<(f64, u64)>,
}

impl Tangent {
    /// Without frames, for discs among obstacles of this radius, and between walls.
    pub(super) fn new(obstacle: Option<f64>, has_walls: bool) -> Self {
        Self { obstacle, has_walls, ..Self::default() }
    }

    /// Adds a frame with the collisions since the one before; `is_settled` if growth counts from here.
    pub(super) fn add_frame(
        &mut self,
        time: f64,
        state: Option<&StateTable>,
        events: &PackingEvents,
        is_settled: bool,
    ) {
        for event in 0..events.event.len() {
            self.collide(event, events);
        }
        self.discs.iter_mut().for_each(|disc| disc.fly_to(time));
        self.reduce();
        if self.settled.is_some() {
            self.growth.add(self.reduced, time - self.time);
            let collisions = self.collisions as f64 / self.discs.len() as f64;
            self.growth_by_collisions.add(self.reduced, collisions);
        } else if is_settled {
            self.settled = Some((time, self.longest_chain()));
        }
        (self.time, self.reduced, self.events, self.collisions) = (time, 0.0, 0, 0);
        if let Some(state) = state {
            self.take_velocities(time, state);
        }
    }

    fn longest_chain(&self) -> u64 {
        self.discs.iter().map(|disc| disc.chain).max().unwrap_or(0)
    }

    /// Takes the velocities of a state. At the start, the velocities differ by unit vectors of all directions.
    fn take_velocities(&mut self, time: f64, state: &StateTable) {
        let places = ["vx", "vy", "radius"].map(|name| state.index(name));
        let [Some(vx), Some(vy), Some(radius)] = places else { return };
        if self.discs.is_empty() {
            let change = |disc: usize| [libm::cos(2.4 * disc as f64), libm::sin(2.4 * disc as f64)];
            let disc = |disc| Disc { change: change(disc), time, ..Disc::default() };
            self.discs = (0..state.rows()).map(disc).collect();
        }
        for (disc, row) in self.discs.iter_mut().zip(state.iter()) {
            (disc.velocity, disc.radius) = ([row[vx], row[vy]], row[radius]);
        }
    }

    fn collide(&mut self, event: usize, events: &PackingEvents) {
        let ids = [&events.first_id, &events.second_id].map(|ids| ids[event] as usize);
        let impulse = [events.impulse_x[event], events.impulse_y[event]];
        let normal = [events.normal_x[event], events.normal_y[event]];
        if ids[0] == ids[1] {
            let Some(disc) = self.discs.get_mut(ids[0]) else { return };
            disc.fly_to(events.time[event]);
            // The normal of a wall is along an axis, that of an obstacle only by a choice of the start.
            let is_wall = self.has_walls && (normal[0] == 0.0 || normal[1] == 0.0);
            match self.obstacle.filter(|_| !is_wall) {
                Some(radius) => {
                    let mut obstacle = Disc { radius, ..Disc::default() };
                    Disc::collide(disc, &mut obstacle, impulse, normal);
                    self.collisions += 1;
                }
                None => disc.reflect(impulse, normal),
            }
        } else if let Ok([first, second]) = self.discs.get_disjoint_mut(ids) {
            first.fly_to(events.time[event]);
            second.fly_to(events.time[event]);
            Disc::collide(first, second, impulse, normal);
            self.collisions += 2;
        }
        // The difference may grow by several orders of magnitude per collision.
        self.events += 1;
        if self.events.is_multiple_of(self.discs.len().max(1)) {
            self.reduce();
        }
    }

    /// Divides the difference by its norm.
    fn reduce(&mut self) {
        let square = |disc: &Disc| dot(disc.shift, disc.shift) + dot(disc.change, disc.change);
        let norm = self.discs.iter().map(square).sum::<f64>().sqrt();
        for disc in self.discs.iter_mut().filter(|_| norm > 0.0) {
            disc.shift = disc.shift.map(|component| component / norm);
            disc.change = disc.change.map(|component| component / norm);
        }
        self.reduced += if norm > 0.0 { libm::log(norm) } else { 0.0 };
    }

    /// Whether collisions and the velocities of a frame were recorded.
    pub(super) fn is_recorded(&self) -> bool {
        !self.discs.is_empty()
    }

    /// Relative speed of two elastic discs of equal mass, or of one and an obstacle, which is constant; `None` for another number of discs.
    pub(super) fn relative_speed(&self) -> Option<f64> {
        let relative = match self.discs.as_slice() {
            [one] => one.velocity,
            [first, second] => sum(second.velocity, first.velocity, -1.0),
            _ => return None,
        };
        Some(dot(relative, relative).sqrt())
    }

    /// Collisions of the longest chain per unit of time.
    pub(super) fn chain_rate(&self) -> Option<f64> {
        let (since, before) = self.settled.filter(|(since, _)| self.time > *since)?;
        Some((self.longest_chain() - before) as f64 / (self.time - since))
    }
}

impl Disc {
    fn fly_to(&mut self, time: f64) {
        self.shift = sum(self.shift, self.change, time - self.time);
        self.time = time;
    }

    /// A collision of two discs: velocities change by κ (g·n) n, with κ = (1 + e)/2.
    fn collide(first: &mut Self, second: &mut Self, impulse: Vector, normal: Vector) {
        let contact = first.radius + second.radius;
        let relative = sum(second.velocity, first.velocity, -1.0);
        let approach = dot(relative, normal);
        let factor = dot(impulse, normal) / approach;
        let (shift, change) =
            (sum(second.shift, first.shift, -1.0), sum(second.change, first.change, -1.0));
        let along = dot(shift, normal);
        let turn = sum(shift, relative, -along / approach).map(|component| component / contact);
        let kick = dot(change, normal) + dot(relative, turn);
        for (disc, sign) in [(&mut *first, 1.0), (&mut *second, -1.0)] {
            let signed = sign * factor;
            disc.shift = sum(disc.shift, normal, signed * along);
            disc.change = sum(sum(disc.change, normal, signed * kick), turn, signed * approach);
            disc.velocity = sum(disc.velocity, impulse, sign);
        }
        let chain = 1 + first.chain.max(second.chain);
        (first.chain, second.chain) = (chain, chain);
    }

    /// A collision with a wall: a reflection, and a rotation by wall noise.
    fn reflect(&mut self, impulse: Vector, normal: Vector) {
        let before = self.velocity;
        let reflected = |vector: Vector| sum(vector, normal, -2.0 * dot(vector, normal));
        self.velocity = sum(before, impulse, 1.0);
        let mirrored = reflected(before);
        let square = dot(before, before);
        let cosine = dot(mirrored, self.velocity) / square;
        let sine = (mirrored[0] * self.velocity[1] - mirrored[1] * self.velocity[0]) / square;
        let delay = -dot(self.shift, normal) / dot(before, normal);
        self.shift = sum(self.shift, impulse, -delay);
        let [x, y] = reflected(self.change);
        self.change = [cosine * x - sine * y, sine * x + cosine * y];
    }
}

/// a + factor b
fn sum(a: Vector, b: Vector, factor: f64) -> Vector {
    [a[0] + factor * b[0], a[1] + factor * b[1]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

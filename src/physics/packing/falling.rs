//! What changes between the collisions of discs in gravity: the moments of their velocities; and where their energy goes.

use super::collision::{Collision, CollisionPartner};
use super::domain::Domain;
use super::motion::Vector;
use super::velocity_moments::VelocityMoments;
use crate::sum::CompensatedSum;
use kinetoscope_recording::channels::PackingEnergy;
use serde::{Deserialize, Serialize};

/// Discs in gravity after their last collision.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Falling {
    gravity: f64,
    /// Half of the box's height.
    half_height: f64,
    sums: VerticalSums,
    energy_at_start: f64,
    /// Energy gained from the floor since the start.
    floor: CompensatedSum,
    /// Energy lost in collisions since the start.
    dissipated: CompensatedSum,
}

/// Sums over all discs of v_y, of v_y², and of v² v_y: with those of v² and v⁴, they give the moments at any later time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct VerticalSums {
    first: f64,
    second: f64,
    mixed: f64,
}

impl VerticalSums {
    fn of(velocities: impl Iterator<Item = Vector>) -> Self {
        velocities.fold(Self::default(), |sums, velocity| sums.plus(velocity, 1.0))
    }

    fn plus(self, [vx, vy]: Vector, sign: f64) -> Self {
        Self {
            first: self.first + sign * vy,
            second: self.second + sign * (vy * vy),
            mixed: self.mixed + sign * ((vx * vx + vy * vy) * vy),
        }
    }
}

impl Falling {
    /// Discs at the start.
    pub(super) fn new(
        gravity: f64,
        height: f64,
        discs: impl Iterator<Item = [Vector; 2]> + Clone,
    ) -> Self {
        let sums = VerticalSums::of(discs.clone().map(|[_, velocity]| velocity));
        let mut falling = Self {
            gravity,
            half_height: 0.5 * height,
            sums,
            energy_at_start: 0.0,
            floor: CompensatedSum::default(),
            dissipated: CompensatedSum::default(),
        };
        let [kinetic, potential] = falling.energies(discs);
        falling.energy_at_start = kinetic + potential;
        falling
    }

    /// Kinetic and potential energy at the start.
    pub(super) fn energy_at_start(&self) -> f64 {
        self.energy_at_start
    }

    /// Whether the constants are those of a box, and all sums are numbers.
    pub(super) fn is_valid_for(&self, domain: &Domain) -> bool {
        let VerticalSums { first, second, mixed } = self.sums;
        self.gravity == domain.gravity
            && self.half_height == 0.5 * domain.sides[1]
            && [first, second, mixed, self.energy_at_start].iter().all(|sum| sum.is_finite())
            && self.floor.is_finite()
            && self.dissipated.is_finite()
    }

    /// The moments after discs with these moments have fallen for a time.
    pub(super) fn moments_after(&self, moments: &VelocityMoments, time: f64) -> VelocityMoments {
        let VerticalSums { first, second, mixed } = self.sums;
        let fall = self.gravity * time;
        let (square, n) = (fall * fall, moments.count);
        VelocityMoments {
            second: moments.second - 2.0 * fall * first + n * square,
            fourth: moments.fourth - 4.0 * fall * mixed
                + square * (2.0 * moments.second + 4.0 * second)
                - square * fall * (4.0 * first - n * fall),
            count: n,
        }
    }

    /// Time integrals of the kinetic energy, which is exact, and of a2, by Simpson's rule.
    pub(super) fn integrals(&self, moments: &VelocityMoments, time: f64) -> [f64; 2] {
        let fall = self.gravity * time;
        let mean = moments.second - fall * self.sums.first + moments.count * fall * fall / 3.0;
        let [middle, end] = [0.5 * time, time].map(|time| self.moments_after(moments, time));
        [0.5 * mean * time, (moments.a2() + 4.0 * middle.a2() + end.a2()) * time / 6.0]
    }

    /// Replaces the sums by recalculated ones.
    pub(super) fn set_velocities(&mut self, velocities: impl Iterator<Item = Vector>) {
        self.sums = VerticalSums::of(velocities);
    }

    /// Adds a collision after a time without any; `moments` are those before this time.
    pub(super) fn add(&mut self, moments: &VelocityMoments, collision: &Collision) {
        let fall = self.gravity * collision.time_since_previous;
        let (VerticalSums { first, second, mixed }, n) = (self.sums, moments.count);
        self.sums = VerticalSums {
            first: first - n * fall,
            second: second - 2.0 * fall * first + n * fall * fall,
            mixed: mixed - fall * (moments.second + 2.0 * second)
                + fall * fall * (3.0 * first - n * fall),
        };
        for [before, after] in collision.velocity_changes {
            self.sums = self.sums.plus(after, 1.0).plus(before, -1.0);
        }
        match collision.partner {
            CollisionPartner::Disc { .. } | CollisionPartner::Obstacle => {
                self.dissipated.add(-collision.energy_gain)
            }
            CollisionPartner::Wall => self.floor.add(collision.energy_gain),
        }
    }

    /// Kinetic energy, and energy in gravity above the bottom of the box.
    fn energies(&self, discs: impl Iterator<Item = [Vector; 2]>) -> [f64; 2] {
        let (mut kinetic, mut height) = (CompensatedSum::default(), CompensatedSum::default());
        for [[_, y], [vx, vy]] in discs {
            kinetic.add(0.5 * (vx * vx + vy * vy));
            height.add(y + self.half_height);
        }
        [kinetic.value(), self.gravity * height.value()]
    }

    /// The message of `/energy`.
    pub(super) fn message(&self, discs: impl Iterator<Item = [Vector; 2]>) -> PackingEnergy {
        let [kinetic, potential] = self.energies(discs);
        let (floor, dissipated) = (self.floor.value(), self.dissipated.value());
        let mut residual = CompensatedSum::default();
        for term in [kinetic, potential, dissipated, -floor, -self.energy_at_start] {
            residual.add(term);
        }
        PackingEnergy {
            kinetic,
            potential,
            total: kinetic + potential,
            from_floor: floor,
            dissipated,
            residual: residual.value(),
        }
    }
}

//! Close encounters of several bodies: the closest approach of a run, tracked at every step.
//!
//! A pair that approached in one step and recedes in the next had its least separation in one of the two. The force has computed the
//! separations anyway, so two comparisons per pair and step find it; its place within the step is found by shorter steps of the same
//! method. Nothing here changes the trajectory.

use super::motion::{MutualGravity, Phase, State, add_scaled, attracting_pairs, dot, length};
use super::path::{PathTracker, StepPath};
use kinetoscope_recording::channels::OrbitClosestApproach;
use serde::{Deserialize, Serialize};

/// The closest approach of two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Approach {
    /// Numbers of the bodies, the lower one first.
    pub(super) pair: [usize; 2],
    /// Days.
    pub(super) time: f64,
    /// AU.
    pub(super) separation: f64,
    /// Relative speed, AU/day.
    pub(super) speed: f64,
    /// Separation over the mutual Hill radius; `None` without a central body, or for a pair with it.
    pub(super) over_hill_radius: Option<f64>,
}

/// The closest approaches since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Closest {
    /// By separation.
    pub(super) separation: Option<Approach>,
    /// By separation over the mutual Hill radius.
    pub(super) over_hill_radius: Option<Approach>,
}

impl Closest {
    fn add(&mut self, approach: Approach) {
        if self.separation.is_none_or(|least| approach.separation < least.separation) {
            self.separation = Some(approach);
        }
        let ratio = |of: Approach| of.over_hill_radius.unwrap_or(f64::INFINITY);
        if ratio(approach) < self.over_hill_radius.map_or(f64::INFINITY, ratio) {
            self.over_hill_radius = Some(approach);
        }
    }
}

/// Closest approaches, and the separations by which the next one is recognized.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct EncounterRecord {
    closest: Closest,
    /// Separations of the attracting pairs one and two steps ago, AU.
    separations: [Vec<f64>; 2],
    /// Length of the step between them, days; 0 at the start.
    last_length: f64,
}

impl EncounterRecord {
    /// Bodies at their start, which counts as an approach if they recede from there.
    pub(super) fn at_start(gravitational_parameters: &[f64], phase: &Phase<Vec<f64>>) -> Self {
        let pairs = attracting_pairs(gravitational_parameters);
        let now: Vec<f64> = pairs.map(|pair| length(relative(phase, pair).position)).collect();
        let before = vec![f64::INFINITY; now.len()];
        Self { closest: Closest::default(), separations: [now, before], last_length: 0.0 }
    }
}

/// Two bodies that attract.
#[derive(Clone, Copy)]
struct Pair {
    /// Numbers of the bodies, the lower one first.
    bodies: [usize; 2],
    /// Mutual Hill radius over the mean distance from the central body; `None` without a central body, or for a pair with it.
    hill_factor: Option<f64>,
    /// Whether its approaches are recorded.
    counts: bool,
}

/// Finds the encounters of bodies.
pub(super) struct Encounters {
    pairs: Vec<Pair>,
    /// The body with more than half of the mass.
    pub(super) central: Option<usize>,
    /// Sum of G m, AU^3/day^2.
    total: f64,
}

impl Encounters {
    pub(super) fn of(force: &MutualGravity) -> Self {
        let bodies = &force.gravitational_parameters;
        let total: f64 = bodies.iter().sum();
        let central = bodies.iter().position(|body| *body > 0.5 * total);
        let attracts = |(body, parameter): (usize, &f64)| Some(body) != central && *parameter > 0.0;
        // Where only the central body attracts, the others meet nothing else.
        let counts_central = bodies.len() == 2 || !bodies.iter().enumerate().any(attracts);
        let pairs = attracting_pairs(bodies).map(|pair| {
            let other_than = |central: &usize| !pair.contains(central);
            // (m_1 + m_2)/(3 M), to the power of 1/3 (Chambers, Mon. Not. R. Astron. Soc. 304 (1999) 793).
            let factor = |central: usize| {
                let [first, second] = pair.map(|body| bodies[body]);
                libm::cbrt((first + second) / (3.0 * bodies[central]))
            };
            Pair {
                bodies: pair,
                hill_factor: central.filter(other_than).map(factor),
                counts: counts_central || central.as_ref().is_none_or(other_than),
            }
        });
        Self { pairs: pairs.collect(), central, total }
    }

    /// The closest approaches since the start, including the present separations.
    pub(super) fn closest(
        &self,
        record: &EncounterRecord,
        phase: &Phase<Vec<f64>>,
        time: f64,
    ) -> Closest {
        let mut closest = record.closest;
        for pair in self.pairs.iter().filter(|pair| pair.counts) {
            closest.add(self.approach(pair, phase, time));
        }
        closest
    }

    /// The first pair at one position.
    pub(super) fn coinciding(&self, phase: &Phase<Vec<f64>>) -> Option<[usize; 2]> {
        let mut pairs = self.pairs.iter().map(|pair| pair.bodies);
        pairs.find(|pair| length(relative(phase, *pair).position) == 0.0)
    }

    fn approach(&self, pair: &Pair, phase: &Phase<Vec<f64>>, time: f64) -> Approach {
        let State { position, velocity } = relative(phase, pair.bodies);
        let separation = length(position);
        Approach {
            pair: pair.bodies,
            time,
            separation,
            speed: length(velocity),
            over_hill_radius: self.hill_radius(pair, phase).map(|radius| separation / radius),
        }
    }

    /// Mutual Hill radius, with the distances from the central body in place of the semi-major axes: (r_1 + r_2)/2
    /// ((m_1 + m_2)/(3 M))^(1/3).
    fn hill_radius(&self, pair: &Pair, phase: &Phase<Vec<f64>>) -> Option<f64> {
        let (factor, central) = pair.hill_factor.zip(self.central)?;
        let [one, other] =
            pair.bodies.map(|body| length(relative(phase, [central, body]).position));
        Some(0.5 * (one + other) * factor)
    }

    /// Whether the least separation of a pair near the start of a step can be less than those found: the straight line through the
    /// start passes at `distance`, and the path leaves it by less than half of the change of the velocity times the length.
    fn may_be_closest(
        &self,
        step: &StepPath<'_, Vec<f64>>,
        pair: &Pair,
        last_length: f64,
        closest: &Closest,
    ) -> bool {
        let [from, to] = [step.from, step.to].map(|phase| relative(phase, pair.bodies));
        let along = dot(from.position, from.velocity);
        let square =
            dot(from.position, from.position) - along * along / dot(from.velocity, from.velocity);
        let distance = if square > 0.0 { square.sqrt() } else { 0.0 };
        let change = length(add_scaled(to.velocity, from.velocity, -1.0));
        let span = if step.length > last_length { step.length } else { last_length };
        // Not a number, where the relative velocity is zero, counts as small.
        let bound = distance - 0.5 * change * span;
        let is_far = closest.separation.is_some_and(|least| bound >= least.separation);
        let is_out = match (self.hill_radius(pair, step.from), closest.over_hill_radius) {
            (Some(radius), Some(least)) => {
                least.over_hill_radius.is_some_and(|ratio| bound >= ratio * radius)
            }
            (radius, _) => radius.is_none(),
        };
        !(is_far && is_out)
    }

    /// The least separation of a pair that approached before the step and recedes at its end, in this step or the one before.
    fn within(&self, step: &StepPath<'_, Vec<f64>>, pair: &Pair, last_length: f64) -> Approach {
        let radial = |phase: &Phase<Vec<f64>>| {
            let State { position, velocity } = relative(phase, pair.bodies);
            dot(position, velocity)
        };
        let at = |step: &StepPath<'_, Vec<f64>>| {
            let part = step.zero_of(radial);
            self.approach(pair, &(step.part)(part), step.start + part)
        };
        let (from, to) = (radial(step.from), radial(step.to));
        if from < 0.0 && to >= 0.0 {
            return at(step);
        }
        let start = self.approach(pair, step.from, step.start);
        if from >= 0.0 && last_length > 0.0 {
            let before = (step.part)(-last_length);
            if radial(&before) < 0.0 {
                let back = StepPath { to: &before, length: -last_length, ..*step };
                let found = at(&back);
                return if found.separation < start.separation { found } else { start };
            }
        }
        start
    }
}

impl PathTracker<MutualGravity> for Encounters {
    type Record = EncounterRecord;
    type Signs = ();

    fn signs(&self, _: &Phase<Vec<f64>>) {}

    /// Bounds: while no separation D falls below D/2, no body is accelerated by more than a = 4 G M/D^2 of the nearest two, where M is the
    /// sum of all masses, so that the separation of two bodies of relative speed v changes by at most v t + 2 a t^2.
    fn quiet_time(&self, phase: &Phase<Vec<f64>>, record: &EncounterRecord) -> f64 {
        let EncounterRecord { closest, separations: [separations, _], .. } = record;
        let Some(least) = closest.separation else { return 0.0 };
        let least_ratio = closest.over_hill_radius.and_then(|least| least.over_hill_radius);
        let nearest = separations.iter().copied().fold(f64::INFINITY, smaller);
        let acceleration = 4.0 * self.total / (nearest * nearest);
        let mut time = f64::INFINITY;
        for (pair, separation) in self.pairs.iter().zip(separations) {
            let mut change = 0.5 * separation;
            if pair.counts {
                change = smaller(change, separation - least.separation);
            }
            if let Some((radius, factor)) = self.hill_radius(pair, phase).zip(pair.hill_factor) {
                let Some(ratio) = least_ratio else { return 0.0 };
                // The distances from the central body change as well.
                change = smaller(change, (separation - ratio * radius) / (1.0 + ratio * factor));
            }
            if change <= 0.0 {
                return 0.0;
            }
            let change = (1.0 - BOUND_ROUNDING) * change;
            let speed = length(relative(phase, pair.bodies).velocity);
            let root = (speed * speed + 8.0 * acceleration * change).sqrt();
            time = smaller(time, 2.0 * change / (speed + root));
        }
        time
    }

    #[inline]
    fn has_event(
        &self,
        _: &Phase<Vec<f64>>,
        separations: &Vec<f64>,
        (): &mut (),
        record: &EncounterRecord,
    ) -> bool {
        let [one_ago, two_ago] = &record.separations;
        let steps = separations.iter().zip(one_ago).zip(two_ago);
        // No early return, so that several pairs are compared at once.
        steps.fold(false, |found, ((now, one), two)| found | ((now >= one) & (one < two)))
    }

    #[cold]
    fn add_step(&self, step: &StepPath<'_, Vec<f64>>, record: &mut EncounterRecord) {
        let [one_ago, two_ago] = &record.separations;
        let pairs = self.pairs.iter().zip(one_ago).zip(two_ago);
        let turns = pairs.filter(|((pair, one), two)| {
            one < two && length(relative(step.to, pair.bodies).position) >= **one && pair.counts
        });
        let mut closest = record.closest;
        for ((pair, _), _) in turns {
            if self.may_be_closest(step, pair, record.last_length, &closest) {
                closest.add(self.within(step, pair, record.last_length));
            }
        }
        record.closest = closest;
    }

    #[inline]
    fn complete_step(&self, now: &mut Vec<f64>, h: f64, record: &mut EncounterRecord) {
        let [one_ago, two_ago] = &mut record.separations;
        std::mem::swap(one_ago, two_ago);
        std::mem::swap(one_ago, now);
        record.last_length = h;
    }
}

/// Position and velocity of the second body of a pair relative to the first.
#[inline]
fn relative(phase: &Phase<Vec<f64>>, [one, other]: [usize; 2]) -> State {
    let difference = |numbers: &[f64]| {
        let (vectors, _) = numbers.as_chunks::<3>();
        add_scaled(vectors[other], vectors[one], -1.0)
    };
    State { position: difference(&phase.position), velocity: difference(&phase.velocity) }
}

impl Closest {
    /// The message of the channel; `None` without a pair.
    pub(super) fn message(&self) -> Option<OrbitClosestApproach> {
        let Approach { pair: [first, second], time, separation, speed, over_hill_radius } =
            self.separation?;
        let least = self.over_hill_radius.and_then(|approach| approach.over_hill_radius);
        Some(OrbitClosestApproach {
            first_body: first as u64,
            second_body: second as u64,
            time_d: time,
            separation_au: separation,
            relative_speed_au_per_day: speed,
            separation_over_hill_radius: over_hill_radius.unwrap_or(f64::NAN),
            min_separation_over_hill_radius: least.unwrap_or(f64::NAN),
        })
    }

    /// Warnings of encounters that change the orbits, or that steps of the given length do not follow.
    pub(super) fn warnings(&self, step: Option<f64>) -> Vec<String> {
        let mut warnings = Vec::new();
        let text = |approach: Approach| {
            let Approach { pair: [first, second], time, separation, .. } = approach;
            format!("bodies {first} and {second} approached to {separation:.4e} AU at {time:.6} d")
        };
        if let Some(approach) = self.over_hill_radius
            && let Some(ratio) = approach.over_hill_radius
            && ratio < 1.0
        {
            warnings.push(format!(
                "close encounter: {}, {ratio:.3} of their mutual Hill radius, which changes their orbits",
                text(approach)
            ));
        }
        let steps = |approach: &Approach, step: f64| approach.separation / (approach.speed * step);
        if let Some((step, approach)) = step.zip(self.separation)
            && steps(&approach, step) < MIN_STEPS
        {
            warnings.push(format!(
                "the time step of {step} d is too long for an encounter: {}, a distance that they move in {:.2} steps (10 or more follow \
                 it); reduce time_step_days to {:.1e}, or set integrator = \"dop853\", which adapts its steps",
                text(approach),
                steps(&approach, step),
                step * steps(&approach, step) / MIN_STEPS
            ));
        }
        warnings
    }
}

/// Steps per passage, separation over relative speed, below which a method of fixed steps does not follow an encounter.
const MIN_STEPS: f64 = 10.0;

/// The smaller of two numbers.
fn smaller(one: f64, other: f64) -> f64 {
    if other < one { other } else { one }
}

/// Part of a bound that rounding may exceed.
const BOUND_ROUNDING: f64 = 1e-6;

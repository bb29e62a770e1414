//! Close encounters of several bodies: the least separation of a pair over the frames and between them.

use super::laws::{difference, dot, norm};

/// Positions and velocities of all bodies at one time.
#[derive(Clone, Debug, Default)]
pub(super) struct Instant {
    pub(super) time_days: f64,
    /// AU.
    pub(super) positions: Vec<[f64; 3]>,
    /// AU/day.
    pub(super) velocities: Vec<[f64; 3]>,
}

/// The closest approach of two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Approach {
    /// Numbers of the bodies, the lower one first.
    pub(super) pair: [usize; 2],
    pub(super) time_days: f64,
    /// AU.
    pub(super) separation: f64,
    /// Relative speed, AU/day.
    pub(super) speed: f64,
    /// Mutual Hill radius at this time, AU; `None` without a central body, or for a pair with it.
    pub(super) hill_radius: Option<f64>,
}

/// Largest change of the relative velocity between two frames over the mean of its sizes there, up to which a cubic
/// follows the motion: on a circle, its error is this number to the fourth power over 384, below 0.1 % of the radius.
const MAX_TURN: f64 = 0.7;

/// Finds the closest approach of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Encounters {
    gravitational_parameters: Vec<f64>,
    central: Option<usize>,
    pairs: Vec<[usize; 2]>,
    previous: Option<Instant>,
    closest: Option<Approach>,
}

/// The body with more than half of the mass.
pub(super) fn central_body(gravitational_parameters: &[f64]) -> Option<usize> {
    let total: f64 = gravitational_parameters.iter().sum();
    gravitational_parameters.iter().position(|body| *body > 0.5 * total)
}

impl Encounters {
    pub(super) fn new(gravitational_parameters: &[f64]) -> Self {
        let central = central_body(gravitational_parameters);
        let count = gravitational_parameters.len();
        let all = (0..count).flat_map(|one| (one + 1..count).map(move |other| [one, other]));
        let attracting: Vec<[usize; 2]> =
            all.filter(|pair| pair.iter().any(|b| gravitational_parameters[*b] > 0.0)).collect();
        let orbits = |pair: &[usize; 2]| central.is_some_and(|central| pair.contains(&central));
        let others: Vec<[usize; 2]> =
            attracting.iter().copied().filter(|pair| !orbits(pair)).collect();
        // Test particles around one mass meet nothing else.
        let pairs = if others.is_empty() { attracting } else { others };
        let gravitational_parameters = gravitational_parameters.to_vec();
        Self { gravitational_parameters, central, pairs, previous: None, closest: None }
    }

    /// The closest approach so far.
    pub(super) fn closest(&self) -> Option<Approach> {
        self.closest
    }

    /// Takes in the next frame.
    pub(super) fn add(&mut self, now: Instant) {
        for pair in &self.pairs {
            let found = self.at(&now, *pair);
            let between =
                self.previous.as_ref().and_then(|before| self.between(before, &now, *pair));
            for approach in between.into_iter().chain([found]) {
                if self.closest.is_none_or(|closest| approach.separation < closest.separation) {
                    self.closest = Some(approach);
                }
            }
        }
        self.previous = Some(now);
    }

    /// The pair at a frame.
    fn at(&self, instant: &Instant, pair: [usize; 2]) -> Approach {
        let [position, velocity] = relative(instant, pair);
        Approach {
            pair,
            time_days: instant.time_days,
            separation: norm(position),
            speed: norm(velocity),
            hill_radius: self.hill_radius(instant, pair),
        }
    }

    /// Mutual Hill radius, with the distances from the central body in place of the semi-major axes: (r_1 + r_2)/2
    /// ((m_1 + m_2)/(3 M))^(1/3) (Chambers, Mon. Not. R. Astron. Soc. 304 (1999) 793).
    fn hill_radius(&self, instant: &Instant, pair: [usize; 2]) -> Option<f64> {
        let central = self.central.filter(|central| !pair.contains(central))?;
        let distance =
            |body: usize| norm(difference(instant.positions[body], instant.positions[central]));
        let masses = pair.map(|body| self.gravitational_parameters[body]);
        let ratio = (masses[0] + masses[1]) / (3.0 * self.gravitational_parameters[central]);
        Some(0.5 * (distance(pair[0]) + distance(pair[1])) * libm::cbrt(ratio))
    }

    /// The minimum between two frames, by the cubic through the relative positions and velocities at both; `None` if the bodies
    /// do not first approach and then recede, or if the cubic does not follow their motion.
    fn between(&self, before: &Instant, now: &Instant, pair: [usize; 2]) -> Option<Approach> {
        let ([start, first], [end, last]) = (relative(before, pair), relative(now, pair));
        let interval = now.time_days - before.time_days;
        let turn = norm(difference(last, first)) / (0.5 * (norm(first) + norm(last)));
        if !(dot(start, first) < 0.0 && dot(end, last) > 0.0 && turn <= MAX_TURN) {
            return None;
        }
        let cubic = |part: f64| -> [[f64; 3]; 2] {
            let rest = 1.0 - part;
            let position = |axis: usize| {
                rest * rest * ((1.0 + 2.0 * part) * start[axis] + part * interval * first[axis])
                    + part * part * ((3.0 - 2.0 * part) * end[axis] - rest * interval * last[axis])
            };
            let velocity = |axis: usize| {
                6.0 * part * rest * (end[axis] - start[axis]) / interval
                    + rest * (1.0 - 3.0 * part) * first[axis]
                    - part * (2.0 - 3.0 * part) * last[axis]
            };
            [std::array::from_fn(position), std::array::from_fn(velocity)]
        };
        let (mut low, mut high) = (0.0, 1.0);
        // Bisection to the last bit of a double.
        for _ in 0..53 {
            let middle = 0.5 * (low + high);
            let [position, velocity] = cubic(middle);
            if dot(position, velocity) < 0.0 { low = middle } else { high = middle }
        }
        let [position, velocity] = cubic(low);
        let nearer = if low < 0.5 { before } else { now };
        Some(Approach {
            time_days: before.time_days + low * interval,
            separation: norm(position),
            speed: norm(velocity),
            ..self.at(nearer, pair)
        })
    }
}

/// Position and velocity of the second body of a pair relative to the first.
fn relative(instant: &Instant, [one, other]: [usize; 2]) -> [[f64; 3]; 2] {
    [
        difference(instant.positions[other], instant.positions[one]),
        difference(instant.velocities[other], instant.velocities[one]),
    ]
}

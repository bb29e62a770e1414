//! Self-diffusion coefficient: Green–Kubo integral of the velocity autocorrelation, and growth of the mean square displacement.
//!
//! The run is divided into windows of ten mean free times, each with an origin of its own. Only the current origin is in memory, so
//! memory does not grow with the number of frames, and the values of different windows enter the blocking analysis one by one.

use super::displacement::{Displacement, MAX_PARTICLES};
use super::laws as law;
use super::metrics as metric;
use super::observe::PackingRun;
use crate::metric::Measurements;
use crate::metric::theory::ExpectedValue;
use crate::models::hard_discs::contact_value;
use crate::statistics::{Blocking, Entries, Estimate, MissingError};
use kinetoscope_recording::reader::StateTable;

/// Length of a window in mean free times. After it, exp(-t/t_0) is 5e-5. In two dimensions, the velocity autocorrelation has a tail
/// proportional to 1/t, whose integral has no limit (Alder and Wainwright 1970), so the length is part of the definition of D.
pub(super) const WINDOW_MEAN_FREE_TIMES: f64 = 10.0;

/// Maximum interval between frames in mean free times: the trapezoidal rule then overestimates the integral of exp(-t/t_0) by 0.5 %.
const MAX_INTERVAL_MEAN_FREE_TIMES: f64 = 0.25;

/// Deviation of an interval between frames from the first one that rounding explains.
const ROUNDING: f64 = 1e-6;

/// Windows of one run.
#[derive(Clone, Debug, Default)]
pub(crate) struct SelfDiffusion {
    /// Length of a window; zero if the run has no theory for it.
    window: f64,
    origin: Option<Origin>,
    is_coarse: bool,
    by_velocities: Blocking,
    by_displacements: Blocking,
}

/// Start of the current window, and the integral since then.
#[derive(Clone, Debug)]
struct Origin {
    start: f64,
    velocities: Vec<[f64; 2]>,
    displacements: Vec<[f64; 2]>,
    /// Last time and mean v(start) . v.
    last: (f64, f64),
    integral: f64,
    /// Time since the start and mean square displacement, in the middle of the window.
    middle: Option<(f64, f64)>,
}

impl SelfDiffusion {
    /// Creates an empty record for discs that collide once per mean free time.
    pub(super) fn new(mean_free_time: Option<f64>) -> Self {
        Self {
            window: mean_free_time.map_or(0.0, |time| WINDOW_MEAN_FREE_TIMES * time),
            by_velocities: Blocking::of(Entries::Intervals),
            by_displacements: Blocking::of(Entries::Intervals),
            ..Self::default()
        }
    }

    /// Adds a frame, after its displacements were added.
    pub(super) fn add_frame(&mut self, time: f64, moved: &Displacement, velocities: &[[f64; 2]]) {
        if self.window <= 0.0 || self.is_coarse {
            return;
        }
        let Some(displacements) = moved.unwrapped() else {
            self.is_coarse = true;
            return;
        };
        if let Some(origin) = &mut self.origin {
            let longest = MAX_INTERVAL_MEAN_FREE_TIMES / WINDOW_MEAN_FREE_TIMES * self.window;
            if time - origin.last.0 > longest * (1.0 + ROUNDING) {
                self.is_coarse = true;
                return;
            }
            origin.add(time, velocities);
            let elapsed = time - origin.start;
            if origin.middle.is_none() && elapsed >= 0.5 * self.window {
                origin.middle = Some((elapsed, origin.mean_square_displacement(displacements)));
            }
            if elapsed < self.window * (1.0 - ROUNDING) {
                return;
            }
            // D = 1/2 integral of <v(0) . v(t)>, and d<|r|^2>/dt = 4 D.
            self.by_velocities.add(0.5 * origin.integral);
            if let Some((middle, square)) = origin.middle {
                let grown = origin.mean_square_displacement(displacements) - square;
                self.by_displacements.add(grown / (4.0 * (elapsed - middle)));
            }
        }
        self.origin = Some(Origin::new(time, velocities, displacements));
    }

    /// D by velocities and by displacements, or why there is none.
    pub(super) fn estimates(&self) -> Result<[Estimate; 2], &'static str> {
        if self.is_coarse {
            return Err(COARSE);
        }
        let found = self.by_velocities.estimate().zip(self.by_displacements.estimate());
        found.map(|(velocities, displacements)| [velocities, displacements]).ok_or(SHORT)
    }
}

/// Why frames far apart give no value.
const COARSE: &str = "frames are more than a quarter of a mean free time apart, or a disc may have traveled a quarter of a side between two";
/// Why a short run gives no value.
const SHORT: &str = "the run is shorter than ten mean free times";

impl Origin {
    fn new(time: f64, velocities: &[[f64; 2]], displacements: &[[f64; 2]]) -> Self {
        let (velocities, displacements) = (velocities.to_vec(), displacements.to_vec());
        let first = mean_product(&velocities, &velocities);
        Self {
            start: time,
            velocities,
            displacements,
            last: (time, first),
            integral: 0.0,
            middle: None,
        }
    }

    /// Adds an interval by the trapezoidal rule.
    fn add(&mut self, time: f64, velocities: &[[f64; 2]]) {
        let product = mean_product(&self.velocities, velocities);
        let (before, earlier) = std::mem::replace(&mut self.last, (time, product));
        self.integral += 0.5 * (time - before) * (earlier + product);
    }

    fn mean_square_displacement(&self, displacements: &[[f64; 2]]) -> f64 {
        let pairs = self.displacements.iter().zip(displacements);
        let squares = pairs.map(|(from, to)| {
            let [x, y] = [to[0] - from[0], to[1] - from[1]];
            x * x + y * y
        });
        squares.sum::<f64>() / displacements.len() as f64
    }
}

fn mean_product(first: &[[f64; 2]], second: &[[f64; 2]]) -> f64 {
    let products = first.iter().zip(second).map(|(a, b)| a[0] * b[0] + a[1] * b[1]);
    products.sum::<f64>() / first.len() as f64
}

/// Packing fraction up to which Enskog's D is compared, and the accuracy of the comparison.
const MAX_FRACTION: f64 = 0.25;
const ACCURACY: f64 = 0.05;
/// Number of discs from which the correction for fixed momentum is small.
const MIN_DISCS: f64 = 200.0;

impl PackingRun {
    /// Adds a frame to the windows. Their length follows from the collision rate by theory at the temperature of the first frame.
    pub(super) fn add_to_self_diffusion(&mut self, time: f64, state: &StateTable) {
        let places = ["vx", "vy"].map(|name| state.index(name));
        let ([Some(vx), Some(vy)], true) = (places, self.diffuses()) else { return };
        let rows = (0..state.rows().min(MAX_PARTICLES)).map(|disc| state.row(disc));
        let velocities: Vec<[f64; 2]> = rows.map(|row| [row[vx], row[vy]]).collect();
        if self.self_diffusion.is_none() {
            let free_time = self.theory_rate().map(|rate| 1.0 / rate);
            self.self_diffusion = Some(SelfDiffusion::new(free_time));
        }
        if let Some(windows) = &mut self.self_diffusion {
            windows.add_frame(time, &self.displacement, &velocities);
        }
    }

    /// Whether D is defined: nothing bounds the displacements, and no common drift adds to them.
    fn diffuses(&self) -> bool {
        !self.has_walls() && !self.has_drift() && self.equal_radius().is_some()
    }

    /// Pair collisions per disc and unit of time by theory, at the temperature of the first frame.
    fn theory_rate(&self) -> Option<f64> {
        let temperature = self.frames.first()?.temperature;
        let rate = self.equilibrium()?.pair_rate * temperature.sqrt();
        (rate > 0.0).then_some(rate)
    }

    pub(super) fn measure_self_diffusion(&self, found: &mut Measurements) {
        let definitions = [metric::DIFFUSION_GREEN_KUBO, metric::DIFFUSION_EINSTEIN];
        if !self.diffuses() {
            return definitions.iter().for_each(|definition| found.explain(definition, BOUNDED));
        }
        let Some(windows) = &self.self_diffusion else { return };
        match windows.estimates() {
            Ok(estimates) => {
                let values = estimates.into_iter().zip(moments_of_window());
                for (definition, (estimate, moments)) in definitions.into_iter().zip(values) {
                    let theory = self.expected_diffusion(moments);
                    found.compare(definition, self.with_drifting(estimate), theory);
                }
            }
            Err(reason) => {
                definitions.iter().for_each(|definition| found.explain(definition, reason));
            }
        }
    }

    /// Cooling discs diffuse ever more slowly, so their D has neither a theory nor an error.
    fn with_drifting(&self, estimate: Estimate) -> Estimate {
        if self.is_elastic() { estimate } else { estimate.without_error(MissingError::Drifting) }
    }

    /// Theory after a time in mean free times, with the mean of ln(t / onset of the tail).
    fn expected_diffusion(&self, [time, logarithm]: [f64; 2]) -> Option<ExpectedValue> {
        let temperature = self.frames.first().filter(|_| self.is_elastic())?.temperature;
        let (packing_fraction, radius) = (self.packing_fraction()?, self.equal_radius()?);
        let discs = law::DiffusingDiscs {
            discs: self.discs(),
            packing_fraction,
            diameter: 2.0 * radius,
            contact_value: contact_value(packing_fraction),
            temperature,
            pair_rate: self.theory_rate()?,
        };
        let value = discs.self_diffusion(time, logarithm);
        let in_range = self.discs() >= MIN_DISCS && packing_fraction <= MAX_FRACTION;
        Some(ExpectedValue { value, accuracy: Some(ACCURACY * value), in_range })
    }
}

/// Time and mean of ln(t / onset): at the end of a window, and averaged over its second half, in which the mean square displacement
/// grows. The mean of ln t from w/2 to w is ln w - 1 + ln 2.
fn moments_of_window() -> [[f64; 2]; 2] {
    let end = WINDOW_MEAN_FREE_TIMES;
    let logarithm = libm::log(end / law::TAIL_ONSET_MEAN_FREE_TIMES);
    [[end, logarithm], [0.75 * end, logarithm - 1.0 + std::f64::consts::LN_2]]
}

/// Why D is not defined.
const BOUNDED: &str = "needs discs of one size in a periodic box, with a total momentum of zero (remove_mean_velocity)";

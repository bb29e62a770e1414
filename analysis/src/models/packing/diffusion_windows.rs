//! Windows of a run in which its self-diffusion coefficient is measured: Green–Kubo integral of the velocity autocorrelation, and growth of the mean square displacement.
//!
//! The run is divided into windows of ten mean free times, each with an origin of its own. Only the current origin is in memory, so
//! memory does not grow with the number of frames, and the values of different windows enter the blocking analysis separately.

use super::displacement::Displacement;
use crate::statistics::{Blocking, Entries, Estimate, FRAMES_FAR_APART, SHORTER_THAN_WINDOW};

/// Length of a window in mean free times. After it, exp(-t/t_0) is 5e-5. In two dimensions, the velocity autocorrelation has a tail
/// proportional to 1/t, whose integral has no limit (Alder and Wainwright 1970), so the length is part of the definition of D.
pub(super) const WINDOW_MEAN_FREE_TIMES: f64 = 10.0;

/// Maximum interval between frames in mean free times: the trapezoidal rule then overestimates the integral of exp(-t/t_0) by 0.5 %.
const MAX_INTERVAL_MEAN_FREE_TIMES: f64 = 0.25;

/// Deviation of an interval between frames from the first one that rounding explains.
const ROUNDING: f64 = 1e-6;

/// The windows of one run.
#[derive(Clone, Debug, Default)]
pub(crate) struct DiffusionWindows {
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

impl DiffusionWindows {
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
            return Err(FRAMES_FAR_APART);
        }
        let found = self.by_velocities.estimate().zip(self.by_displacements.estimate());
        found
            .map(|(velocities, displacements)| [velocities, displacements])
            .ok_or(SHORTER_THAN_WINDOW)
    }
}

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

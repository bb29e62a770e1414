//! Effect of collisions and time on a gas: relaxation to Maxwell's distribution, collision rates, stationarity.

use super::kinetics_laws as law;
use super::laws as ideal;
use super::metrics as metric;
use crate::metric::Measurement;
use crate::models::series::Series;
use crate::statistics::{Estimate, mean};
use kinetoscope_manifest::model::GasConfig;
use kinetoscope_recording::reader::StateTable;

/// Collisions per disc after which the initial speeds are forgotten. The deviation of the fourth moment from Maxwell's
/// falls by a factor of about exp(-0.35) per collision, so 1e-6 of it remains.
const COLLISIONS_TO_FORGET: f64 = 40.0;

/// Container crossings after which the initial positions are forgotten.
const CROSSINGS_TO_FORGET: f64 = 20.0;

/// Quantities collected from frames.
#[derive(Clone, Debug, Default)]
pub struct Kinetics {
    /// Time, s, then the pair collisions and their virial, J s, since the start.
    pub(crate) pairs: Series<(f64, f64, f64)>,
    /// Time, s, and H above its minimum.
    pub(crate) relative_entropy: Series<(f64, f64)>,
    /// Number of bins of the histogram that H is derived from.
    pub(crate) bins: usize,
    pub(crate) energy_j: Option<f64>,
    pub(crate) inside_half_at_start: Option<f64>,
}

/// Quantities of the run that the metrics need in addition.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    pub(crate) config: &'a GasConfig,
    pub(crate) time_s: f64,
    /// The state of the last frame.
    pub(crate) state: Option<&'a StateTable>,
    /// `<v^2>` of the last frame, m^2/s^2; `None` for several masses.
    pub(crate) mean_square: Option<f64>,
    /// Time, s, and mean pressure since the start, N/m.
    pub(crate) pressures: &'a Series<(f64, f64)>,
    /// Whether no particle leaves or changes its speed.
    pub(crate) keeps_particles: bool,
}

impl Kinetics {
    /// The metrics of the run.
    #[must_use]
    pub fn measurements(&self, inputs: &Inputs<'_>) -> Vec<Measurement> {
        let mut found = Vec::new();
        self.maxwell(inputs, &mut found);
        self.least_h(inputs, &mut found);
        self.rates(inputs, &mut found);
        self.places(inputs, &mut found);
        found.extend(pressure_drift(inputs));
        found
    }

    /// Whether the discs have collided often enough to forget their initial speeds.
    fn has_forgotten(&self, inputs: &Inputs<'_>) -> bool {
        let particles = f64::from(inputs.config.particles.get());
        let pairs = self.pairs.last().map_or(0.0, |(_, pairs, _)| *pairs);
        inputs.config.keeps_energy() && 2.0 * pairs / particles >= COLLISIONS_TO_FORGET
    }

    fn maxwell(&self, inputs: &Inputs<'_>, found: &mut Vec<Measurement>) {
        let Some(squares) = inputs.state.and_then(squares_of) else { return };
        if inputs.config.orifice_width_m.is_some() || ideal::has_several_masses(inputs.config) {
            return;
        }
        let speeds: Vec<f64> = squares.iter().map(|square| square.sqrt()).collect();
        let fourths: Vec<f64> = squares.iter().map(|square| square * square).collect();
        let (Some(speed), Some(square), Some(fourth)) =
            (mean(&speeds), mean(&squares), mean(&fourths))
        else {
            return;
        };
        if square == 0.0 {
            return;
        }
        let particles = squares.len() as f64;
        // Energies follow an exponential distribution at a fixed total: the variances of x^2 and sqrt(x), reduced by
        // their covariance with x.
        let mean_error = (1.0 - 5.0 * std::f64::consts::PI / 16.0).sqrt() / particles.sqrt();
        let relaxed = self.has_forgotten(inputs);
        let against = |definition, value, error: f64, theory: f64| {
            let estimate = Estimate { value, standard_error: relaxed.then_some(error) };
            Measurement::new(definition, estimate).against(relaxed.then_some(theory))
        };
        found.extend([
            against(
                metric::MEAN_OVER_RMS,
                speed / square.sqrt(),
                mean_error,
                std::f64::consts::PI.sqrt() / 2.0,
            ),
            against(
                metric::A2,
                fourth / (2.0 * square * square) - 1.0,
                1.0 / particles.sqrt(),
                -1.0 / (particles + 1.0),
            ),
        ]);
    }

    fn least_h(&self, inputs: &Inputs<'_>, found: &mut Vec<Measurement>) {
        let (Some((_, first)), Some((_, last))) =
            (self.relative_entropy.first(), self.relative_entropy.last())
        else {
            return;
        };
        let particles = f64::from(inputs.config.particles.get());
        let freedom = self.bins.saturating_sub(2) as f64;
        let relaxed = self.has_forgotten(inputs);
        let scatter = relaxed.then(|| (2.0 * freedom).sqrt() / (2.0 * particles));
        let theory = relaxed.then(|| freedom / (2.0 * particles));
        let of = |value: f64| Estimate { value, standard_error: scatter };
        found.push(Measurement::new(metric::RELATIVE_ENTROPY, of(*last)).against(theory));
        found.push(Measurement::new(metric::RELATIVE_ENTROPY_AT_START, *first));
        if let Some(square) = inputs.mean_square.filter(|square| *square > 0.0) {
            let least = law::least_h(square);
            let theory = theory.map(|excess| least + excess);
            found.push(Measurement::new(metric::H_FUNCTION, of(least + last)).against(theory));
        }
    }

    /// Collision rate and compressibility factor, for discs only.
    fn rates(&self, inputs: &Inputs<'_>, found: &mut Vec<Measurement>) {
        let (Some(_), Some((time, pairs, virial))) =
            (inputs.config.disc_radius_m, self.pairs.last())
        else {
            return;
        };
        let particles = f64::from(inputs.config.particles.get());
        let square = inputs.mean_square.filter(|_| inputs.config.keeps_energy());
        let theory = square.and_then(|square| law::collisions(inputs.config, square));
        let half = self.pairs.iter().find(|(at, ..)| 2.0 * at >= *time);
        if let Some((from, before, _)) = half.filter(|(from, ..)| from < time) {
            let count = pairs - before;
            let a_disc = 2.0 / (particles * (time - from));
            let estimate =
                Estimate { value: count * a_disc, standard_error: Some(count.sqrt() * a_disc) };
            let relaxed = theory.filter(|_| self.has_forgotten(inputs));
            found.push(
                Measurement::new(metric::PAIR_RATE, estimate)
                    .against(relaxed.map(|theory| theory.rate_per_s)),
            );
        }
        if let Some(energy) = self
            .energy_j
            .filter(|energy| *energy > 0.0 && *time > 0.0 && inputs.config.keeps_energy())
        {
            let excess = virial / (2.0 * energy * time);
            // Approach speeds at collisions follow x exp(-x^2/2): <x^2>/<x>^2 = 4/pi.
            let error = excess * (4.0 / (std::f64::consts::PI * pairs)).sqrt();
            let estimate = Estimate { value: 1.0 + excess, standard_error: Some(error) };
            found.push(
                Measurement::new(metric::COMPRESSIBILITY, estimate)
                    .against(theory.map(|theory| theory.compressibility_factor)),
            );
        }
    }

    /// Fraction of particles within half the radius. The theory is that of points, because discs exclude each other.
    fn places(&self, inputs: &Inputs<'_>, found: &mut Vec<Measurement>) {
        let places = inputs.config.position_distribution;
        let points = inputs.config.disc_radius_m.is_none() && inputs.keeps_particles;
        let crossings = inputs.mean_square.map_or(0.0, f64::sqrt) * inputs.time_s
            / (2.0 * inputs.config.radius_m.get());
        let start = law::share_inside_at_start(places);
        let later = law::share_inside_later(places);
        let later = (start == later || crossings > CROSSINGS_TO_FORGET).then_some(later);
        let last = inputs.state.and_then(|state| share_inside_half(state, inputs.config));
        for (definition, share, theory) in [
            (metric::INSIDE_HALF, last, later),
            (metric::INSIDE_HALF_AT_START, self.inside_half_at_start, Some(start)),
        ] {
            let Some(value) = share else { continue };
            let theory = theory.filter(|_| points);
            let particles = f64::from(inputs.config.particles.get());
            let error = theory.map(|share| (share * (1.0 - share) / particles).sqrt());
            let estimate = Estimate { value, standard_error: error };
            found.push(Measurement::new(definition, estimate).against(theory));
        }
    }
}

/// Pressure of the second half of the run over that of the first. The momentum in transit at midtime counts negatively
/// in one half and positively in the other: three times the variance of a single half.
fn pressure_drift(inputs: &Inputs<'_>) -> Option<Measurement> {
    let (time, since_start) = *inputs.pressures.last()?;
    let (middle, first) =
        *inputs.pressures.iter().find(|(at, _)| 2.0 * at >= time).filter(|(at, _)| *at < time)?;
    if first == 0.0 {
        return None;
    }
    let second = (since_start * time - first * middle) / (time - middle);
    let square = inputs.mean_square.filter(|square| inputs.keeps_particles && *square > 0.0);
    let is_stationary = law::share_inside_later(inputs.config.position_distribution)
        == law::share_inside_at_start(inputs.config.position_distribution);
    let error = square.map(|square| {
        3.0_f64.sqrt() * ideal::pressure_error_relative(inputs.config, square.sqrt(), time / 2.0)
    });
    let estimate = Estimate { value: second / first, standard_error: error };
    let theory = (is_stationary && error.is_some()).then_some(1.0);
    Some(Measurement::new(metric::PRESSURE_DRIFT, estimate).against(theory))
}

/// Squared speed of each particle; `None` without velocities.
fn squares_of(state: &StateTable) -> Option<Vec<f64>> {
    Some(state.column("vx")?.zip(state.column("vy")?).map(|(x, y)| x * x + y * y).collect())
}

/// Fraction of the particles within half the radius; `None` without positions, or if the container changes its size or
/// loses particles.
pub(crate) fn share_inside_half(state: &StateTable, config: &GasConfig) -> Option<f64> {
    if config.wall_speed_m_per_s.get() != 0.0 || config.orifice_width_m.is_some() {
        return None;
    }
    let [cx, cy] = config.center_m.map(|component| component.get());
    let half = config.radius_m.get() / 2.0;
    let inside = state
        .column("x")?
        .zip(state.column("y")?)
        .filter(|(x, y)| (x - cx) * (x - cx) + (y - cy) * (y - cy) < half * half)
        .count();
    Some(inside as f64 / state.rows() as f64)
}

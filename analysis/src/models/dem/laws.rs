//! Laws of spring–dashpot contacts, beds and granular gases.

use super::contact_constants;
use super::elasticity::Elastic;
use crate::metric::law::laws;
use crate::metric::theory::ExpectedValue;
use crate::metric::{Quantity, Violation};
use crate::models::hard_discs;
use kinetoscope_manifest::model::{
    DISC, DemConfig, DemDashpot, DiscRadius, Dissipation, Placement, WALL,
};
use kinetoscope_manifest::quantity::{Finite, NonNegative};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

laws! {
    ENERGY_BALANCE: "kinetic + gravitational + elastic + dissipated - wall work is constant", "conservation of energy; what is left is the integrator's", conserves "sum of all energies", integrator true;
    KINETIC_ENERGY: "0: both are the energies of translation and rotation of the same discs", "definition of the kinetic energy", identity true;
    RESTITUTION: "the specified e of the disc's material and the wall, if there is one; for a damping, e = exp(-pi ζ / sqrt(1 - ζ^2)) without limit_damping", "Schwager and Poeschel 2007", range "a time step of a tenth of a contact or less and η_n Δt/m below 1; accuracy e (2 ζ - ζ^2/2 d ln e/dζ) ω Δt + (ω Δt)^2/2 + 0.001, with ζ in place of 2 ζ with limit_damping, for a twentieth of a contact or less, explicit dashpots and η_n Δt/m below 0.15, else 5 %, or 1.2 η_n Δt/m if larger";
    CONTACT_DURATION: "pi / ω, ω^2 = k_n/m_eff - (η_n/(2 m_eff))^2; with limit_damping to the end of the force, and then η_n/k_n until the surfaces part", "damped harmonic oscillator; Schwager and Poeschel 2007", range "a time step of a tenth of a contact or less and η_n Δt/m below 1; accuracy 5 %, or 1.2 η_n Δt/m if larger";
    HERTZ_DURATION: "2.9433 δ_max/v, δ_max = (5 m v^2/(4 κ))^(2/5)", "Hertz 1882; Landau and Lifshitz, Theory of Elasticity, section 9", range "elastic spheres; accuracy: two time steps, and 0.375 g δ_max/v^2 of it by the weight", named "Hertz's law";
    WEIGHT: "sum of the discs' weights, for discs at rest", "equilibrium of forces without friction at the side walls", range "kinetic energy below 0.001 of the elastic energy", accuracy 0.01;
    WEIGHT_PER_WIDTH: "sum of the discs' weights over the box's width, for discs at rest", "equilibrium of forces without friction at the side walls", range "kinetic energy below 0.001 of the elastic energy", accuracy 0.01;
    WEIGHT_ABOVE: "weight over the box's width, of the discs whose centers are above, mean over the layer's heights", "equilibrium of forces at every height, of discs at rest between walls without friction; in the continuum the mean density times gravity and depth", range "kinetic energy below 0.001 of the elastic energy", accuracy 0.01;
    DRAWN_TEMPERATURE: "velocity_std_m_per_s^2 (N - 1)/N: half the mean square of N normal velocities, of which the mean is subtracted", "chi-square distribution with 2 (N - 1) degrees of freedom", manifest true;
    HAFF: "1/τ = (1 - e^2) ν/4 of T = T_0/(1 + t/τ)^2, ν = 2 sqrt(pi) n d χ sqrt(T_0), χ = (Z - 1)/(2φ)", "Haff 1983; Enskog's collision rate in two dimensions, Kolafa and Rottner 2006", range "φ up to 0.69, 128 discs or more without flow or clusters: energy of the mean velocities and variance of the numbers of cells of 8 discs or more as for independent discs", accuracy 0.03, named "Haff's law";
    ROW_OF_DISCS: "((1 + e)/2)^(N - 1) of discs of one material if each gap is longer than the distance traveled in a contact, v pi/ω", "conservation of momentum, collision by collision; Herrmann and Seitz 1982", range "gaps longer than the distance traveled in a contact", accuracy 0.01, named "momentum and restitution";
    BEVERLOO: "3/2 of the opening less 1.4 diameters, in two dimensions", "Beverloo, Leniger and van de Velde 1961; limited range of widths: Mankoc et al. 2007", range "openings of 5 diameters or more", accuracy 0.1, named "Beverloo's law";
    RUNOUT: "between 2/3 and 1 of the aspect ratio: linear below about 3, about 2/3 above; columns on both sides of it do not distinguish them", "Staron and Hinch 2005; Lube et al. 2005";
    JANSSEN: "F = F_s (1 - exp(-F_g/F_s)): the walls carry the rest of the weight", "Janssen 1895", range "fully mobilized friction at the walls", accuracy 0.1, named "Janssen's law";
}

/// Reduction of the effective orifice width, in mean diameters.
pub(crate) const EMPTY_ANNULUS: f64 = 1.4;

/// Whether all walls are frictionless.
pub(crate) fn are_walls_frictionless(config: &DemConfig) -> bool {
    let smooth = |name: &str, own: Option<NonNegative>| {
        let pair = contact_constants::given_pair(config, [name, WALL]);
        let mixed = own.map_or(config.friction.get(), |own| own.get().min(config.friction.get()));
        pair.friction.map_or(mixed, NonNegative::get) == 0.0
    };
    if config.materials.is_empty() {
        return smooth(DISC, None);
    }
    let mut materials = config.materials.iter();
    materials.all(|material| smooth(&material.name, material.constants.friction))
}

/// Expected granular temperature at the start, m^2/s^2, and its standard deviation over seeds: σ^2 χ^2/(2N) of velocity components with
/// the standard deviation σ, where χ^2 has 2 (N - 1) degrees of freedom. `None` if no velocities are drawn, or if discs are inserted.
pub(crate) fn drawn_temperature(config: &DemConfig) -> Option<[f64; 2]> {
    let std = config.velocity_std_m_per_s?.get();
    let discs = f64::from(config.discs.get());
    let expected = std * std * (discs - 1.0) / discs;
    (discs > 1.0 && config.insertion.is_none()).then(|| [expected, expected / (discs - 1.0).sqrt()])
}

/// Haff's 1/tau, 1/s, of equal frictionless discs at a granular temperature T0 = `<v^2>`/2.
pub(crate) fn cooling_rate_per_s(config: &DemConfig, temperature: f64) -> Option<ExpectedValue> {
    let DiscRadius::Equal(radius) = config.radius_m else { return None };
    let e = contact_constants::of_discs(config, |pair| pair.restitution)?;
    let area = config.width_m.get() * config.height_m.get();
    let density = f64::from(config.discs.get()) / area;
    let radius = radius.get();
    let fraction = density * PI * radius * radius;
    let contact = hard_discs::contact_value(fraction);
    let collisions = 2.0 * PI.sqrt() * density * 2.0 * radius * contact * temperature.sqrt();
    let pair = contact_constants::given_pair(config, [DISC, DISC]);
    let friction = pair.friction.unwrap_or(config.friction);
    let plain = friction.get() == 0.0 && config.materials.is_empty();
    plain.then(|| ExpectedValue {
        value: (1.0 - e * e) * collisions / 4.0,
        accuracy: None,
        violation: Quantity::PackingFraction
            .at_most(fraction, hard_discs::MAX_PACKING_FRACTION)
            .or_else(|| cohesion(config)),
    })
}

/// The violation of laws of contacts that attract each other.
fn cohesion(config: &DemConfig) -> Option<Violation> {
    Quantity::Cohesion.required(!contact_constants::is_cohesive(config))
}

/// Velocity of a row's last disc, divided by that of its first disc, if every gap is longer than v pi/w. `None` if restitution,
/// stiffness or mass differ from disc to disc.
pub(crate) fn velocity_transmission(config: &DemConfig) -> Option<ExpectedValue> {
    let Placement::Given(state) = &config.placement else { return None };
    let DiscRadius::Equal(radius) = config.radius_m else { return None };
    let e = contact_constants::of_discs(config, |pair| pair.restitution)?;
    let zeta = damping_ratio(e, config.limit_damping);
    let mass = contact_constants::disc_mass_kg(config)?;
    let ratio = contact_constants::of_discs(config, |pair| Some(pair.stiffness))?;
    let stiffness = Elastic::of(config, ratio).spring_n_per_m()?;
    let frequency = (2.0 * stiffness / mass).sqrt();
    let way =
        state.velocities_m_per_s.first()?[0].get() * PI / (frequency * (1.0 - zeta * zeta).sqrt());
    let gap = |pair: &[[Finite; 2]]| pair[1][0].get() - pair[0][0].get() - 2.0 * radius.get();
    let is_apart = state.positions_m.windows(2).all(|pair| gap(pair) >= way);
    let collisions = state.positions_m.len() as i32 - 1;
    is_apart.then(|| ExpectedValue {
        value: ((1.0 + e) / 2.0).powi(collisions),
        accuracy: None,
        violation: cohesion(config),
    })
}

/// Damping ratio eta / (2 sqrt(k m_eff)) of a restitution, in [0, 1]; found by bisection, because the restitution
/// decreases with the damping ratio.
fn damping_ratio(wanted: f64, tail: bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let middle = (low + high) / 2.0;
        if restitution(middle, tail) > wanted { low = middle } else { high = middle }
    }
    (low + high) / 2.0
}

/// A contact of a disc with a wall, as a damped oscillator.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallContact {
    /// sqrt(k/m), rad/s; `None` with Hertz's law, for which it depends on the speed.
    frequency: Option<f64>,
    /// eta / (2 sqrt(k m)).
    damping_ratio: f64,
    /// The specified restitution, or that of the damping.
    restitution: f64,
    /// Whether the force is clamped at zero.
    limit_damping: bool,
    /// Whether the dashpot uses the velocity before the step.
    is_explicit: bool,
    /// Time step, s; `None` for the automatic one.
    time_step_s: Option<f64>,
    /// Cohesion, for which the laws do not hold.
    cohesion: Option<Violation>,
}

/// eta dt/m below which the leading errors of the restitution are all that matter.
const MAX_DAMPING_STEP_OF_LEADING_ERRORS: f64 = 0.15;

/// Change of the restitution by gravity during the contact, for rebounds high enough to be used.
const CHANGE_BY_GRAVITY: f64 = 1e-3;

/// Accuracy of the laws of a contact over eta dt/m, measured with time steps of a twentieth to a tenth of a contact and e between
/// 0.1 and 0.9: errors of e are up to 1.1 of it, with either dashpot.
const ACCURACY_PER_DAMPING_STEP: f64 = 1.2;

/// Accuracy of the laws of a contact for a weak dashpot.
const CONTACT_ACCURACY: f64 = 0.05;

impl WallContact {
    /// The wall contact of a manifest's discs; `None` if restitution or mass differ from disc to disc.
    pub(crate) fn of(config: &DemConfig) -> Option<Self> {
        let mass = contact_constants::disc_mass_kg(config)?;
        let stiffness = Elastic::of_walls(config)?.spring_n_per_m();
        let limit_damping = config.limit_damping;
        let (damping_ratio, restitution) = match config.dissipation {
            Dissipation::Restitution(_) => {
                let wanted = contact_constants::with_walls(config, |pair| pair.restitution)?;
                (damping_ratio(wanted, limit_damping), wanted)
            }
            Dissipation::Damping(damping) => {
                let ratio = damping.get() / (2.0 * (stiffness? * mass).sqrt());
                (ratio, restitution(ratio, limit_damping))
            }
        };
        let time_step_s = contact_constants::time_step_s(config);
        let frequency = stiffness.map(|stiffness| (stiffness / mass).sqrt());
        let is_explicit = config.dashpot == DemDashpot::Explicit;
        Some(Self {
            frequency,
            damping_ratio,
            restitution,
            limit_damping,
            is_explicit,
            time_step_s,
            cohesion: cohesion(config),
        })
    }

    /// Coefficient of restitution.
    pub(crate) fn restitution(&self) -> ExpectedValue {
        let expected = self.at_time_step(self.restitution);
        let accuracy = self.restitution_bound().or(expected.accuracy);
        ExpectedValue { accuracy, ..expected }
    }

    /// Bound of the leading errors, of first and second order in h = w dt, and of gravity. Velocities lag half a step behind the
    /// positions, and the dashpot of a contact that begins within a step acts from the middle of that step; with the attractive tail,
    /// it ends so as well. The sum is e (2 zeta + |d ln e/dzeta| zeta^2/2) h, with zeta in place of 2 zeta for the clamped force. Terms
    /// of second order are at most h^2/2. `tests/dem/restitution_is_correct_for_random_parameters.rs` derives and tests both.
    fn restitution_bound(&self) -> Option<f64> {
        let h = self.frequency? * self.time_step_s?;
        let zeta = self.damping_ratio;
        let is_leading = self.is_explicit
            && zeta < 0.99
            && 2.0 * zeta * h < MAX_DAMPING_STEP_OF_LEADING_ERRORS
            && h <= PI / 20.0 * (1.0 + 1e-9);
        let ends = if self.limit_damping { zeta } else { 2.0 * zeta };
        let first = self.restitution * (ends + self.logarithmic_slope() * zeta * zeta / 2.0);
        is_leading.then_some(first * h + h * h / 2.0 + CHANGE_BY_GRAVITY)
    }

    /// |d ln e/dzeta| below critical damping, by a central difference.
    fn logarithmic_slope(&self) -> f64 {
        const STEP: f64 = 1e-5;
        let logarithm = |zeta: f64| libm::log(restitution(zeta, self.limit_damping));
        let low = (self.damping_ratio - STEP).max(0.0);
        let high = self.damping_ratio + STEP;
        ((logarithm(high) - logarithm(low)) / (high - low)).abs()
    }

    /// Duration without gravity, s; `None` near and above critical damping.
    pub(crate) fn duration_s(&self) -> Option<ExpectedValue> {
        self.duration().map(|duration| self.at_time_step(duration))
    }

    fn duration(&self) -> Option<f64> {
        let zeta = self.damping_ratio;
        if zeta.is_nan() || zeta >= 0.99 {
            return None;
        }
        let frequency = self.frequency?;
        let w = frequency * (1.0 - zeta * zeta).sqrt();
        Some(match self.limit_damping {
            false => PI / w,
            // The force ends when k delta = eta v; the surfaces separate delta / v = eta / k later.
            true => clamped_phase(zeta) / w + 2.0 * zeta / frequency,
        })
    }

    /// A value with its accuracy at the time step. A contact near or above critical damping counts as long as one without damping.
    fn at_time_step(&self, value: f64) -> ExpectedValue {
        let Some(frequency) = self.frequency else {
            return ExpectedValue {
                value,
                accuracy: Some(CONTACT_ACCURACY * value),
                violation: self.cohesion,
            };
        };
        let step = self.time_step_s.unwrap_or(0.0);
        let duration = self.duration().unwrap_or(PI / frequency);
        let damping_step = 2.0 * self.damping_ratio * frequency * step;
        let accuracy = (ACCURACY_PER_DAMPING_STEP * damping_step).max(CONTACT_ACCURACY);
        // Ten steps per contact are in range, also after rounding.
        let violation = (Quantity::StepOverContact)
            .at_most(step / duration / (1.0 + 1e-9), 0.1)
            .or_else(|| Quantity::DampingStep.below(damping_step, 1.0))
            .or(self.cohesion);
        ExpectedValue { value, accuracy: Some(accuracy * value), violation }
    }
}

/// 2 times the integral of 1/sqrt(1 - x^(5/2)) from 0 to 1: 4 sqrt(pi)/5 gamma(2/5)/gamma(9/10).
const HERTZ_FACTOR: f64 = 2.943_275_182_605_99;

/// Duration of the contact of an elastic sphere with a wall at an impact velocity, m/s, by Hertz's law; `None` for another contact.
pub(crate) fn hertz_duration_s(
    config: &DemConfig,
    velocity: f64,
    [gravity, time_step_s]: [f64; 2],
) -> Option<ExpectedValue> {
    let mass = contact_constants::disc_mass_kg(config)?;
    let elastic = Elastic::of_walls(config)?;
    let is_elastic = contact_constants::with_walls(config, |pair| pair.restitution) == Some(1.0);
    if elastic.spring_n_per_m().is_some() || !is_elastic {
        return None;
    }
    let factor = elastic.factor() * config.radius_m.mean().sqrt();
    let overlap = libm::pow(1.25 * mass * velocity * velocity / factor, 0.4);
    let value = HERTZ_FACTOR * overlap / velocity;
    let by_weight = 0.375 * gravity * overlap / (velocity * velocity) * value;
    let accuracy = Some(by_weight + 2.0 * time_step_s);
    Some(ExpectedValue { value, accuracy, violation: cohesion(config) })
}

/// w times the time until a clamped force ends, below critical damping (Schwager and Pöschel 2007, equations 17 to 19).
fn clamped_phase(zeta: f64) -> f64 {
    let root = (1.0 - zeta * zeta).sqrt();
    let angle = libm::atan(2.0 * zeta * root / (1.0 - 2.0 * zeta * zeta));
    if zeta < FRAC_1_SQRT_2 { PI - angle } else { -angle }
}

/// Coefficient of restitution of a linear spring and dashpot as a function of the damping ratio (Schwager and Pöschel
/// 2007, equations 17 to 21 for the clamped force).
pub(crate) fn restitution(damping_ratio: f64, tail: bool) -> f64 {
    let zeta = damping_ratio;
    let root = (1.0 - zeta * zeta).abs().sqrt();
    match tail {
        false if zeta < 1.0 => libm::exp(-PI * zeta / root),
        false => 0.0,
        true if zeta < 1.0 => libm::exp(-zeta / root * clamped_phase(zeta)),
        true if zeta == 1.0 => libm::exp(-2.0),
        true => {
            let ratio = (zeta + root) / (zeta - root);
            libm::exp(-zeta / root * libm::log(ratio))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Uniform;
    use kinetoscope_manifest::model::{DemContactConstants, DemContactPair};
    use kinetoscope_manifest::quantity::Positive;

    /// Law: mean and standard deviation of the granular temperature of 10 discs with drawn velocities. Setup: 20,000 samples of
    /// σ = 0.5 m/s. Tolerance: four standard errors, 1.0 % and 2.5 % (the excess kurtosis is 12/18). Control: a tenth of a mean
    /// square that is not subtracted, and 1/sqrt(N) for the scatter, deviate by more.
    #[test]
    fn temperature_of_drawn_velocities_has_the_moments_of_chi_square() {
        let config = DemConfig {
            discs: 10.try_into().unwrap(),
            velocity_std_m_per_s: Positive::new(0.5),
            ..DemConfig::default()
        };
        let [expected, scatter] = drawn_temperature(&config).unwrap();
        let mut uniform = Uniform(60);
        let samples: Vec<f64> = (0..20_000)
            .map(|_| {
                let axis = |uniform: &mut Uniform| {
                    let drawn: Vec<f64> = (0..10).map(|_| 0.5 * uniform.normal()).collect();
                    let mean = drawn.iter().sum::<f64>() / 10.0;
                    drawn.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / 20.0
                };
                axis(&mut uniform) + axis(&mut uniform)
            })
            .collect();
        let mean = crate::statistics::mean(&samples).unwrap();
        let std = crate::statistics::standard_deviation(&samples).unwrap();
        assert!((mean / expected - 1.0).abs() < 0.01, "{mean} {expected}");
        assert!((std / scatter - 1.0).abs() < 0.025, "{std} {scatter}");
        assert!((mean / 0.25 - 1.0).abs() > 0.05, "control: {mean}");
        assert!((std / (expected / 10.0_f64.sqrt()) - 1.0).abs() > 0.025, "control: {std}");
    }

    /// Guarantee: laws of impacts are not compared with those of surfaces that attract each other, and refer to the stiffness of the pair.
    /// Control: without cohesion they are in range, and four times the stiffness halves the duration.
    #[test]
    fn laws_of_impacts_exclude_cohesion() {
        let config = |cohesion: f64, ratio: f64| {
            let constants = DemContactConstants {
                stiffness_ratio: Positive::new(ratio),
                ..DemContactConstants::default()
            };
            let between = [DISC, WALL].map(str::to_owned);
            DemConfig {
                cohesion_n: NonNegative::new(cohesion).unwrap(),
                contact_pairs: vec![DemContactPair { between, constants }],
                ..DemConfig::default()
            }
        };
        let duration = |config: &DemConfig| WallContact::of(config).unwrap().duration_s().unwrap();
        let restitution = |config: &DemConfig| WallContact::of(config).unwrap().restitution();
        let sticky = config(1e-3, 1.0);
        for law in [duration(&sticky), restitution(&sticky)] {
            assert!(law.violation.unwrap().to_string().contains("cohesion_n"));
        }
        let plain = config(0.0, 1.0);
        assert_eq!([duration(&plain), restitution(&plain)].map(|law| law.violation), [None; 2]);
        let ratio = duration(&plain).value / duration(&config(0.0, 4.0)).value;
        assert!((ratio - 2.0).abs() < 1e-12, "{ratio}");
    }

    /// Source: table of the DEM exercise, damping ratios for e = 0.9, 0.8, 0.5, 0.2 in both conventions.
    #[test]
    fn restitution_follows_from_the_damping_ratio() {
        let table = [
            (0.9, 0.033_518_45, 0.034_265_20),
            (0.8, 0.070_850_30, 0.074_355_10),
            (0.5, 0.215_453_76, 0.255_275_64),
            (0.2, 0.455_949_81, 0.731_246_93),
        ];
        for (wanted, attractive, clamped) in table {
            assert!((restitution(attractive, false) - wanted).abs() < 1e-7);
            assert!((restitution(clamped, true) - wanted).abs() < 1e-7);
        }
        // Far above critical damping, the clamped restitution approaches 1 / (4 zeta^2).
        assert!((restitution(1e3, true) * 4e6 - 1.0).abs() < 1e-4);
        let critical = libm::exp(-2.0);
        for zeta in [1.0 - 1e-6, 1.0, 1.0 + 1e-6] {
            assert!((restitution(zeta, true) - critical).abs() < 1e-5);
        }
    }

    /// Source: the closed form of the attractive tail, |d ln e/dζ| = pi/(1 - ζ^2)^(3/2), at e = 0.2, ζ = 0.455950, with 100 steps per
    /// contact: h = pi/100, A = 0.2 (0.911900 + 4.4566 * 0.207890/2) = 0.275022. Control: five percent, which no correct program exceeds.
    #[test]
    fn restitution_is_bounded_by_its_leading_errors() {
        let contact = |restitution: f64, steps: f64| {
            let step = PI * (1e-3_f64 / 5e4).sqrt() / steps;
            WallContact {
                frequency: Some((5e4_f64 / 1e-3).sqrt()),
                damping_ratio: damping_ratio(restitution, false),
                restitution,
                limit_damping: false,
                is_explicit: true,
                time_step_s: Some(step),
                cohesion: None,
            }
            .restitution()
        };
        let h = PI / 100.0;
        let expected = 0.275_022 * h + h * h / 2.0 + 1e-3;
        let bound = contact(0.2, 100.0).accuracy.unwrap();
        assert!((bound / expected - 1.0).abs() < 1e-3, "{bound} {expected}");
        // Steps that are not small have the measured accuracy.
        assert!((contact(0.2, 12.0).accuracy.unwrap() / 0.2 - 1.2 * 0.2388).abs() < 1e-3);
        assert!(contact(0.9, 100.0).accuracy.unwrap() < 0.05 * 0.9, "control");
    }
}

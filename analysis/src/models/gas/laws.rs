//! Laws of an ideal gas in a circle.

use crate::metric::law::laws;
use kinetoscope_manifest::model::{
    BoltzmannConstant, GasConfig, GasPlacement, PositionDistribution, SpeedDistribution,
    SpeedScale, TemperatureDefinition,
};
use std::f64::consts::{FRAC_PI_4, PI};

laws! {
    KINETIC_PRESSURE: "P = N m <v^2> / (2A)", "kinetic theory in two dimensions, exact in a circle", named "kinetic theory";
    SPEED_LAW: "<v>^2 / <v^2> = 3/4 for uniform speeds, pi/4 for Maxwell's, 1 for equal ones; for a given temperature with the terms of a finite N, which are exact for N = 1", "moments of the speeds' law", manifest true;
    GIVEN_TEMPERATURE: "the temperature of the manifest, to which the drawn speeds are scaled; m <v^2>/(2 k_B) of the distribution if a maximum speed is given", "definition of the temperature, moments of the speeds' law", manifest true;
    BAROMETRIC_TEMPERATURE: "T is that of the start at all times and heights", "Maxwell-Boltzmann distribution in gravity", range "points that start in barometric equilibrium", manifest true;
    WALL_COLLISION_RATE: "2 N <v> / (pi R)", "mean chord pi R / 2 of a uniform isotropic state", range "points, placed uniformly over the area";
    INVARIANTS: "speed and angular momentum of each particle are constant", "specular reflection in a circle", conserves "motion of each particle";
    EFFUSION: "N (1 - exp(-t/tau)) / t with 1/tau = <v> w / (pi A)", "flux n <v> / pi on a wall in two dimensions (Knudsen), of a gas that empties and stays well mixed", range "accuracy: half of the fraction that has left, because fast particles leave first and points mix slowly", named "kinetic theory";
    ADIABATIC: "T A = constant for a slow wall", "adiabatic exponent 2 in two dimensions", range "wall slower than a tenth of v_rms", accuracy 0.02, named "the adiabatic law";
    ENERGY_BALANCE: "energy = energy at the start + work + heat + rescaling - escaped", "first law of thermodynamics", conserves "sum of all energies";
    THERMALIZATION: "T tends to the wall's temperature", "equilibrium with a thermal wall (Maxwell 1879)", range "after 20 crossings of the container";
    HISTOGRAM: "(bins - constraints)/bins: the number of particles is given, and <v> or <v^2> if a temperature is", "Pearson's chi-square";
    BAROMETRIC_CHI: "(layers - 1)/layers for a density proportional to exp(-m g y/(k_B T))", "barometric law, integrated over the layers of the circle; Pearson's chi-square", range "points that start in barometric equilibrium";
    BAROMETRIC_HEIGHT: "<y> of a density proportional to exp(-m g y/(k_B T))", "barometric law, integrated over the circle", range "points that start in barometric equilibrium", manifest true, named "the barometric law";
    BAROMETRIC_CHI_OF_WALL: "(layers - 1)/layers for a density proportional to exp(-m g y/(k_B T)) at the temperature of the wall", "barometric law, integrated over the layers of the circle; Pearson's chi-square", range "after 20 crossings of the container";
    BAROMETRIC_HEIGHT_OF_WALL: "<y> of a density proportional to exp(-m g y/(k_B T)) at the temperature of the wall", "barometric law, integrated over the circle", range "after 20 crossings of the container", manifest true, named "the barometric law";
    TEMPERATURE_CONSTANT: "T is constant: no work is done", "free expansion (Joule 1845)", conserves "temperature";
    BOX_ENTROPY_START: "sum over the species of x_s ln(A_s/A) - (B - 1)/(2N)", "uniform start on one side; Wilks 1938";
    BOX_ENTROPY_CHANGE: "sum over the species of x_s ln(A/A_s) - B/(2N); 0 if the partition stays", "ideal gas: free expansion and mixing; Wilks 1938", range "a partition through the center, at least 50 crossings at the rms speed after it is removed, and particles with fewer than 5 crossings lack less than half of the error", named "an ideal gas";
    PRESSURE_SLOPE: "slope N k_B / A of P over T, times <v^2> over its value by the definition", "ideal gas law";
    PRESSURE_RADIUS_EXPONENT: "P is proportional to R^-2 at fixed T", "ideal gas law, A = pi R^2";
    SPEED_EXPONENT: "<v> is proportional to T^(1/2)", "definition of temperature";
}

/// Boltzmann's constant in use, J/K (CODATA 1986, or exact in the SI since 2019).
pub(crate) fn boltzmann_j_per_k(config: &GasConfig) -> f64 {
    match config.boltzmann_constant {
        BoltzmannConstant::Codata1986 => 1.380_658e-23,
        BoltzmannConstant::Si2019 => 1.380_649e-23,
    }
}

/// Area of the container, m^2.
pub(crate) fn area_m2(config: &GasConfig) -> f64 {
    PI * config.radius_m.get() * config.radius_m.get()
}

/// Temperature of the manifest, K; `None` if speeds are given otherwise or change during the run.
pub(crate) fn temperature_k(config: &GasConfig) -> Option<f64> {
    match config.speed_scale {
        _ if !config.keeps_speeds() => None,
        SpeedScale::Temperature(temperature) => Some(temperature.get()),
        SpeedScale::MaxSpeed(_) | SpeedScale::Given => None,
    }
}

/// `<v>^2` / `<v^2>` of the initial speed distribution, or of the list of speeds.
pub(crate) fn mean_squared_over_mean_square(config: &GasConfig) -> f64 {
    if !config.speeds_m_per_s.is_empty() {
        let (mean, mean_square) = moments_of_list(config);
        return mean * mean / mean_square;
    }
    match config.speed_distribution {
        SpeedDistribution::Uniform => 0.75,
        SpeedDistribution::Maxwell => FRAC_PI_4,
        SpeedDistribution::Equal => 1.0,
    }
}

/// `<v>` and `<v^2>` of the list of speeds, which is assigned cyclically, m/s and m^2/s^2.
fn moments_of_list(config: &GasConfig) -> (f64, f64) {
    let count = config.particles.get() as usize;
    let given = || config.speeds_m_per_s.iter().map(|speed| speed.get()).cycle().take(count);
    let mean = |sum: f64| sum / count as f64;
    (mean(given().sum()), mean(given().map(|speed| speed * speed).sum()))
}

/// Whether the partition passes through the center. Behind any other, the distribution of the angular momenta, which are conserved after
/// the expansion, is not that of a uniform gas.
pub(crate) fn has_partition_through_center(config: &GasConfig) -> bool {
    let center = config.center_m[0].get();
    config.partition.is_some_and(|partition| {
        (partition.x_m.get() - center).abs() <= 1e-9 * config.radius_m.get()
    })
}

/// Whether particles differ in mass. Means of the speed then do not determine the energy.
pub(crate) fn has_several_masses(config: &GasConfig) -> bool {
    !config.additional_masses_kg.is_empty()
}

/// Number of particles that leave through an opening of width w within a time, N (1 - exp(-t/tau)) with 1/tau = `<v>` w / (pi A): a flux
/// n `<v>` / pi per meter of wall, of a density that falls and stays uniform; `None` where it is not uniform.
pub(crate) fn escaped(config: &GasConfig, mean_speed_m_per_s: f64, time_s: f64) -> Option<f64> {
    let width = config.orifice_width_m.filter(|_| !config.has_gravity_or_partition())?.get();
    let rate_per_s = mean_speed_m_per_s * width / (PI * area_m2(config));
    Some(-f64::from(config.particles.get()) * libm::expm1(-rate_per_s * time_s))
}

/// Mean over drawn speeds of `<v>` at a fixed `<v^2>`, and of `<v^2>` at a fixed `<v>`, over their values for many particles. They are
/// expansions in 1/N whose first terms follow from the moments and whose last ones make them exact for N = 1, where `<v>^2` is
/// `<v^2>`; between, they agree with random samples within 0.7 % and 2 %.
fn finite_number_factors(config: &GasConfig) -> [f64; 2] {
    let inverse = 1.0 / f64::from(config.particles.get());
    let ratio = mean_squared_over_mean_square(config);
    let [of_mean, of_mean_square] = match config.speed_distribution {
        _ if !config.speeds_m_per_s.is_empty() => return [1.0; 2],
        SpeedDistribution::Equal => return [1.0; 2],
        SpeedDistribution::Uniform => [0.05, 0.0],
        SpeedDistribution::Maxwell => [0.125, 12.0 / PI - 4.0],
    };
    let factor =
        |first: f64, of_one: f64| 1.0 + inverse * (first + inverse * (of_one - 1.0 - first));
    [factor(of_mean, 1.0 / ratio.sqrt()), factor(of_mean_square, ratio)]
}

/// `<v^2>` = 2 k_B T/m of the first mass in a gas that starts in equilibrium with gravity and keeps it, m^2/s^2; `None` for another
/// start, and next to a thermal wall or an opening.
pub(crate) fn barometric_mean_square_m2_per_s2(config: &GasConfig) -> Option<f64> {
    let SpeedScale::Temperature(temperature) = config.speed_scale else { return None };
    let is_barometric = config.position_distribution == PositionDistribution::Barometric
        && config.thermal_wall.is_none()
        && config.orifice_width_m.is_none();
    let square = 2.0 * boltzmann_j_per_k(config) * temperature.get() / config.mass_kg.get();
    is_barometric.then_some(square)
}

/// Whether points of one mass start in equilibrium with gravity in a container that stays as it is.
pub(crate) fn is_in_barometric_equilibrium(config: &GasConfig) -> bool {
    barometric_mean_square_m2_per_s2(config).is_some()
        && !has_several_masses(config)
        && config.partition.is_none()
        && config.wall_speed_m_per_s.get() == 0.0
}

/// Fraction of Maxwell's speeds in a bin from 0: the integral of 2 v/`<v^2>` exp(-v^2/`<v^2>`).
pub(crate) fn maxwell_fraction(bin: usize, width: f64, mean_square: f64) -> f64 {
    let below = |edge: usize| {
        let speed = edge as f64 * width;
        -libm::expm1(-speed * speed / mean_square)
    };
    below(bin + 1) - below(bin)
}

/// Moments of the initial speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpeedMoments {
    /// `<v>`, m/s.
    pub(crate) mean_m_per_s: f64,
    /// `<v^2>`, m^2/s^2.
    pub(crate) mean_square_m2_per_s2: f64,
}

/// Expected moments of the initial speeds for many particles; `None` for given velocities, for several masses, or if
/// particles leave or change their speeds.
pub(crate) fn speed_moments(config: &GasConfig) -> Option<SpeedMoments> {
    let is_drawn = config.placement == GasPlacement::Random;
    let is_one_gas = !has_several_masses(config) && config.orifice_width_m.is_none();
    if !(is_drawn && is_one_gas && config.keeps_speeds()) {
        return None;
    }
    let ratio = mean_squared_over_mean_square(config);
    let of_mean_square = |square: f64| SpeedMoments {
        mean_m_per_s: (ratio * square).sqrt(),
        mean_square_m2_per_s2: square,
    };
    match config.speed_scale {
        SpeedScale::Temperature(temperature) => {
            let square = 2.0 * boltzmann_j_per_k(config) * temperature.get() / config.mass_kg.get();
            let [of_mean, of_square] = finite_number_factors(config);
            Some(match config.temperature_definition {
                TemperatureDefinition::MeanSquare => SpeedMoments {
                    mean_m_per_s: (ratio * square).sqrt() * of_mean,
                    mean_square_m2_per_s2: square,
                },
                TemperatureDefinition::MeanSpeed => SpeedMoments {
                    mean_m_per_s: square.sqrt(),
                    mean_square_m2_per_s2: square / ratio * of_square,
                },
            })
        }
        SpeedScale::MaxSpeed(_) => mean_square_of_max_speed_m2_per_s2(config).map(of_mean_square),
        SpeedScale::Given if !config.speeds_m_per_s.is_empty() => {
            let (mean_m_per_s, mean_square_m2_per_s2) = moments_of_list(config);
            Some(SpeedMoments { mean_m_per_s, mean_square_m2_per_s2 })
        }
        SpeedScale::Given => None,
    }
}

/// Expected `<v^2>` of drawn speeds below a given maximum, m^2/s^2; `None` for another scale, and for Maxwell's speeds, which have no maximum.
pub(crate) fn mean_square_of_max_speed_m2_per_s2(config: &GasConfig) -> Option<f64> {
    let SpeedScale::MaxSpeed(speed) = config.speed_scale else { return None };
    let square = speed.get() * speed.get();
    match config.speed_distribution {
        SpeedDistribution::Uniform => Some(square / 3.0),
        SpeedDistribution::Equal => Some(square),
        SpeedDistribution::Maxwell => None,
    }
}

/// N k_B T / A of the manifest's temperature, N/m.
pub(crate) fn ideal_gas_pressure_n_per_m(config: &GasConfig) -> Option<f64> {
    let energy = f64::from(config.particles.get()) * boltzmann_j_per_k(config);
    Some(energy * temperature_k(config)? / area_m2(config))
}

/// N m `<v^2>` / (2A), N/m. With `<v>^2` instead of `<v^2>`, it is formula (12) of the gas exercise.
pub(crate) fn pressure_n_per_m(config: &GasConfig, mean_square_m2_per_s2: f64) -> f64 {
    f64::from(config.particles.get()) * config.mass_kg.get() * mean_square_m2_per_s2
        / (2.0 * area_m2(config))
}

/// m `<v^2>` / (2 k_B), K. With `<v>^2` instead of `<v^2>`, it is equation (13) of the gas exercise.
pub(crate) fn temperature_of_k(config: &GasConfig, mean_square_m2_per_s2: f64) -> f64 {
    config.mass_kg.get() * mean_square_m2_per_s2 / (2.0 * boltzmann_j_per_k(config))
}

/// Wall collisions per second of all particles, 2 N `<v>` / (pi R).
pub(crate) fn wall_collision_rate_per_s(config: &GasConfig, mean_speed_m_per_s: f64) -> f64 {
    2.0 * f64::from(config.particles.get()) * mean_speed_m_per_s / (PI * config.radius_m.get())
}

/// Relative standard error of the wall pressure over a time, R / (v_rms t sqrt(2N)): the transferred momentum of a
/// particle is uncertain by one wall collision at each end.
pub(crate) fn pressure_error_relative(
    config: &GasConfig,
    rms_speed_m_per_s: f64,
    time_s: f64,
) -> f64 {
    config.radius_m.get()
        / (rms_speed_m_per_s * time_s * (2.0 * f64::from(config.particles.get())).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinetoscope_manifest::model::GasConfig;

    fn close(value: f64, reference: f64) {
        assert!((value / reference - 1.0).abs() < 1e-12, "{value} is not {reference}");
    }

    /// Source: 50-digit arithmetic. Setup: T = 300 K, m = 1e-26 kg, N = 1000, r = 1 m, CODATA 1986; for uniform speeds,
    /// `<v>` is sqrt(3)/2 of v_rms, apart from the terms of a finite N.
    #[test]
    fn moments_and_pressure_at_300_k() {
        let mut config = GasConfig {
            speed_distribution: SpeedDistribution::Uniform,
            temperature_definition: TemperatureDefinition::MeanSquare,
            boltzmann_constant: BoltzmannConstant::Codata1986,
            ..GasConfig::default()
        };
        let uniform = speed_moments(&config).unwrap();
        close(uniform.mean_square_m2_per_s2.sqrt(), 910.161_963_608_676);
        let of_mean = |config: &GasConfig| finite_number_factors(config)[0];
        close(uniform.mean_m_per_s / of_mean(&config), 788.223_382_043_440_9);
        close(pressure_n_per_m(&config, uniform.mean_square_m2_per_s2), 1.318_431_272_516_22e-18);
        config.speed_distribution = SpeedDistribution::Maxwell;
        close(speed_moments(&config).unwrap().mean_m_per_s / of_mean(&config), 806.610_038_672_962);
        // With the mean-speed definition, the true temperature is 4/3 of the given one.
        config.speed_distribution = SpeedDistribution::Uniform;
        config.temperature_definition = TemperatureDefinition::MeanSpeed;
        let moments = speed_moments(&config).unwrap();
        let of_mean_square = finite_number_factors(&config)[1];
        close(temperature_of_k(&config, moments.mean_square_m2_per_s2) / of_mean_square, 400.0);
    }

    /// Source: 1e5 to 4e5 random samples of the speeds of N particles; exact for N = 1, and for two uniform speeds the integral
    /// (ln(1 + sqrt 2) + sqrt 2)/sqrt 2 - 1/sqrt 2 = 0.91612 of v_rms.
    /// Control: the values of many particles deviate by more.
    #[test]
    fn means_of_few_speeds_agree_with_random_samples() {
        use SpeedDistribution::{Maxwell, Uniform};
        for (particles, distribution, mean, mean_square) in [
            (1_u32, Uniform, 1.154_70, 0.75),
            (1, Maxwell, std::f64::consts::FRAC_2_SQRT_PI, FRAC_PI_4),
            (2, Uniform, 1.057_84, 0.920_3),
            (2, Maxwell, 1.063_6, 0.897_2),
            (3, Uniform, 1.031_2, 0.967_9),
            (3, Maxwell, 1.042_5, 0.933_3),
            (10, Uniform, 1.005_9, 0.998_4),
            (10, Maxwell, 1.012_8, 0.980_9),
        ] {
            let config = GasConfig {
                particles: particles.try_into().unwrap(),
                speed_distribution: distribution,
                ..GasConfig::default()
            };
            let [of_mean, of_mean_square] = finite_number_factors(&config);
            assert!((of_mean / mean - 1.0).abs() < 0.007, "{particles}: {of_mean} {mean}");
            let error = (of_mean_square / mean_square - 1.0).abs();
            assert!(error < 0.02, "{particles}: {of_mean_square} {mean_square}");
            assert!(particles > 3 || (1.0 / mean - 1.0).abs() > 0.02, "control");
        }
    }
}

//! Laws of hard discs.

use crate::metric::law::laws;
use kinetoscope_manifest::model::PackingConfig;
use std::f64::consts::PI;

laws! {
    COOLING: "T = T_0 exp(-(1 - e^2) C / N) after C pair collisions; constant for e = 1", "Haff 1983";
    A2_FIXED_ENERGY: "mean a2 = -1/(N + 1) at fixed energy", "uniform law on the energy sphere";
    A2_FIXED_MOMENTUM: "mean a2 = -1/N at fixed energy and momentum", "uniform law on the energy sphere of relative velocities";
    A2_COOLING: "a2 = 16 (1 - e)(1 - 2 e^2) / (57 - 25 e + 30 e^2 (1 - e))", "van Noije and Ernst 1998, homogeneous cooling state";
    COLLISION_RATE: "Enskog: ν = 2 sqrt(pi) n d χ sqrt(T), corrected for walls and fixed N and energy", "Chapman and Enskog; Henderson 1975; walls by Helfand, Frisch and Lebowitz 1961";
    WALL_COLLISION_RATE: "force on the walls / (m T) times sqrt(T / (2 pi))", "contact theorem; Henderson 1975; walls by Helfand, Frisch and Lebowitz 1961";
    COMPRESSIBILITY: "Z = (1 + φ^2/8) / (1 - φ)^2, corrected for walls and fixed N; Z - 1 times (1 + e)/2", "Henderson 1975; walls by Helfand, Frisch and Lebowitz 1961";
    COMPRESSIBILITY_OF_SIZES: "Z = (1 - q)/(1 - φ) + q (1 + φ^2/8)/(1 - φ)^2, corrected for walls and fixed N; Z - 1 times (1 + e)/2", "Santos, Yuste and Lopez de Haro 1999; Henderson 1975; walls by Helfand, Frisch and Lebowitz 1961";
    COLLISION_RATE_OF_SIZES: "Enskog: ν = 2 sqrt(pi) n <d_ij χ_ij> sqrt(T), χ_ij = 1/(1 - φ) + (9/16) φ/(1 - φ)^2 (d_i d_j/d_ij) <d>/<d^2>, corrected for walls and fixed N and energy", "Santos, Yuste and Lopez de Haro 1999; Henderson 1975; walls by Helfand, Frisch and Lebowitz 1961";
    CONTACT_VALUE: "<d_ij χ_ij>/<d> = 1/(1 - φ) + (9/16) q φ/(1 - φ)^2, for one size (1 - 7φ/16)/(1 - φ)^2; corrected for fixed N", "Santos, Yuste and Lopez de Haro 1999; Henderson 1975";
    VIRIAL_IDENTITY: "Z - 1 = (1 + e)/2 (sqrt(pi)/4) d ν/sqrt(T), for several sizes with <d_ij^2 χ_ij>/<d_ij χ_ij> in place of d", "virial theorem with Maxwell's velocities, corrected for fixed energy; Henderson 1975";
    ELASTIC_ENERGY: "constant for e = 1", "conservation of energy; walls keep the speed";
}

/// Henderson's compressibility factor (1 + f^2/8) / (1 - f)^2 of discs at packing fraction f.
pub(crate) fn henderson(packing_fraction: f64) -> f64 {
    let free = 1.0 - packing_fraction;
    (1.0 + packing_fraction * packing_fraction / 8.0) / (free * free)
}

/// a2 at fixed energy, -1 / (n + 1).
pub(crate) fn a2_at_fixed_energy(discs: u32) -> f64 {
    -1.0 / (f64::from(discs) + 1.0)
}

/// a2 of the homogeneous cooling state.
pub(crate) fn a2_cooling(restitution: f64) -> f64 {
    let a = restitution;
    16.0 * (1.0 - a) * (1.0 - 2.0 * a * a) / (57.0 - 25.0 * a + 30.0 * a * a * (1.0 - a))
}

/// Temperature over its initial value after this number of pair collisions.
pub(crate) fn cooling(restitution: f64, pair_collisions: f64, discs: u32) -> f64 {
    (-(1.0 - restitution * restitution) * pair_collisions / f64::from(discs)).exp()
}

/// Equilibrium of hard discs in a rectangle. Lengths are in the model's unit, rates for kT/m = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Equilibrium {
    /// P A / (N kT) from the virial of the pair collisions in the whole box.
    pub(crate) compressibility_factor: f64,
    /// Pair collisions per disc and unit of time, over sqrt(kT/m).
    pub(crate) pair_rate: f64,
    /// Wall collisions per disc and unit of time, over sqrt(kT/m).
    pub(crate) wall_collision_rate_per_disc: f64,
    /// Ratio of the mean approach speed of a pair to Maxwell's at the same mean square speed; rates are larger by this
    /// ratio.
    pub(crate) approach: f64,
}

/// Size distribution of discs of equal mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DiscSizes {
    /// Packing fraction f.
    pub(crate) packing_fraction: f64,
    /// Mean radius `<r>`.
    pub(crate) mean_radius: f64,
    /// x = `<r>^2/<r^2>`; 1 for equal discs.
    pub(crate) squared_mean_over_mean_square: f64,
}

impl DiscSizes {
    /// Equal discs with the manifest's radius.
    pub(crate) fn equal(config: &PackingConfig) -> Self {
        Self {
            packing_fraction: packing_fraction(config),
            mean_radius: config.radius.get(),
            squared_mean_over_mean_square: 1.0,
        }
    }

    /// Mean distance of centers in a collision, `<s_ij^2 g_ij>/<s_ij g_ij>` with s_ij = (s_i + s_j)/2 and the contact
    /// values g_ij = 1/(1 - f) + (9/16) f/(1 - f)^2 (s_i s_j/s_ij) `<s>/<s^2>` of diameters s (Santos, Yuste and López de
    /// Haro 1999 with Henderson's value for equal discs).
    pub(crate) fn collision_diameter(&self) -> f64 {
        let x = self.squared_mean_over_mean_square;
        let crowding = 9.0 / 16.0 * self.packing_fraction / (1.0 - self.packing_fraction);
        2.0 * self.mean_radius * ((1.0 + 1.0 / x) / 2.0 + crowding) / (1.0 + crowding * x)
    }

    /// Mean radius of the discs at a wall. Large discs collide with it more often, with g = 1/(1 - f) + (9/8) f/(1 -
    /// f)^2 s `<s>/<s^2>`, the contact value with an infinitely large disc.
    fn radius_at_walls(&self) -> f64 {
        let x = self.squared_mean_over_mean_square;
        let crowding = 9.0 / 8.0 * self.packing_fraction / (1.0 - self.packing_fraction);
        self.mean_radius * (1.0 + crowding) / (1.0 + crowding * x)
    }

    /// The same size distribution at another packing fraction.
    fn at(&self, packing_fraction: f64) -> Self {
        Self { packing_fraction, ..*self }
    }

    /// Z = (1 - x)/(1 - f) + x (1 + f^2/8)/(1 - f)^2, which follows from the contact values.
    fn bulk_compressibility(&self) -> f64 {
        let (f, x) = (self.packing_fraction, self.squared_mean_over_mean_square);
        x * henderson(f) + (1.0 - x) / (1.0 - f)
    }
}

/// Maximum packing fraction of the fluid, up to which Henderson's law holds (Bernard and Krauth 2011: 0.700).
pub(crate) const DENSEST_FLUID: f64 = 0.69;

/// Equilibrium of discs in a periodic box. There is no correction for walls. The number n is fixed as in
/// [`equilibrium`], and the momentum is fixed at zero, so relative velocities are those of n - 1 discs and their mean
/// square is larger by n/(n - 1). `None` for one disc and above the fluid's maximum packing fraction.
pub(crate) fn periodic_equilibrium(
    config: &PackingConfig,
    sizes: DiscSizes,
) -> Option<Equilibrium> {
    let fraction = sizes.packing_fraction;
    let discs = f64::from(config.discs.get());
    if discs < 2.0 || fraction > DENSEST_FLUID {
        return None;
    }
    let bulk = sizes.bulk_compressibility() - 1.0;
    let curve = PressureCurve::at(sizes);
    let value = fraction * bulk;
    let fixed_number = 1.0 - fraction * fraction * curve.bend / (2.0 * value * curve.slope * discs);
    let others = discs - 1.0;
    let excess = bulk * fixed_number * discs / others;
    let approach = fixed_energy_speed(others) * (others / discs).sqrt();
    Some(Equilibrium {
        compressibility_factor: 1.0 + (1.0 + config.restitution.get()) / 2.0 * excess,
        pair_rate: excess * 4.0 / (PI.sqrt() * sizes.collision_diameter()) * approach,
        wall_collision_rate_per_disc: 0.0,
        approach,
    })
}

/// Packing fraction of the manifest's discs.
pub(crate) fn packing_fraction(config: &PackingConfig) -> f64 {
    let radius = config.radius.get();
    f64::from(config.discs.get()) * PI * radius * radius
        / (config.width.get() * config.height.get())
}

/// Equilibrium of discs between walls.
///
/// The pressure is that of Henderson and of Santos, Yuste and López de Haro, with three corrections for a small box:
/// - Walls exclude the centers within one radius, so the bulk is denser than n/A. The line tension at a wall is
///   kT rho `<r>` [1/(1 - f) + (1 - 8/(3 pi)) f]: scaled-particle theory, made exact to second order in the density for equal
///   discs. It determines the number of discs missing per unit length of wall, and the force on a wall of length l,
///   P l - 2 tension.
/// - The number n is fixed: a function y of the density is lower by y'' rho S/(2A) than for fluctuating n,
///   S = kT d(rho)/dP.
/// - The energy is fixed: mean speeds are higher than Maxwell's by the factor sqrt(n) Gamma(n)/Gamma(n + 1/2).
///
/// The pair virial then follows from the virial theorem for the box. Compared with event-driven runs of 5 to 150 equal
/// discs with f up to 0.3, Z - 1 is accurate to 0.5 %, and to 2 % at n = 5.
pub(crate) fn equilibrium(config: &PackingConfig, sizes: DiscSizes) -> Equilibrium {
    const SECOND_ORDER: f64 = 1.0 - 8.0 / (3.0 * PI);
    let (radius, discs) = (sizes.mean_radius, f64::from(config.discs.get()));
    let (width, height) = (config.width.get(), config.height.get());
    let (area, disc_area) =
        (width * height, PI * radius * radius / sizes.squared_mean_over_mean_square);
    let mut density = discs / area;
    // In boxes wider than a few discs, each iteration reduces the error by a factor of at least four.
    for _ in 0..60 {
        let fraction = (density * disc_area).min(0.9);
        let tension_slope =
            1.0 / ((1.0 - fraction) * (1.0 - fraction)) + 2.0 * SECOND_ORDER * fraction;
        let short = radius * tension_slope / PressureCurve::at(sizes.at(fraction)).slope;
        density = discs / ((width - 2.0 * short) * (height - 2.0 * short));
    }
    let bulk = sizes.at(density * disc_area);
    let fraction = bulk.packing_fraction;
    let curve = PressureCurve::at(bulk);
    let tension = density * radius * (1.0 / (1.0 - fraction) + SECOND_ORDER * fraction);
    let force = |length: f64| density * bulk.bulk_compressibility() * length - 2.0 * tension;
    let kept_off = 2.0 * bulk.radius_at_walls();
    let virial = force(height) * (width - kept_off) + force(width) * (height - kept_off);
    let fixed_number =
        |value: f64| 1.0 - fraction * fraction * curve.bend / (2.0 * value * curve.slope * discs);
    let excess = (virial / (2.0 * discs) - 1.0)
        * fixed_number(fraction * (bulk.bulk_compressibility() - 1.0));
    let speed = fixed_energy_speed(discs);
    let wall_speed = speed * fixed_number(fraction * bulk.bulk_compressibility());
    Equilibrium {
        compressibility_factor: 1.0 + (1.0 + config.restitution.get()) / 2.0 * excess,
        pair_rate: excess * 4.0 / (PI.sqrt() * bulk.collision_diameter()) * speed,
        approach: speed,
        wall_collision_rate_per_disc: 2.0 * (force(width) + force(height))
            / ((2.0 * PI).sqrt() * discs)
            * wall_speed,
    }
}

/// First and second derivative of f Z(f), the pressure in units of kT over a disc's mean area, for given sizes.
struct PressureCurve {
    slope: f64,
    bend: f64,
}

impl PressureCurve {
    fn at(sizes: DiscSizes) -> Self {
        let (f, x) = (sizes.packing_fraction, sizes.squared_mean_over_mean_square);
        let free = 1.0 - f;
        let numerator = 1.0 + f * f / 8.0;
        let slope_of_z = x * (f / 4.0 / (free * free) + 2.0 * numerator / (free * free * free))
            + (1.0 - x) / (free * free);
        let bend_of_z = x
            * (0.25 / (free * free)
                + f / (free * free * free)
                + 6.0 * numerator / (free * free * free * free))
            + (1.0 - x) * 2.0 / (free * free * free);
        Self {
            slope: sizes.bulk_compressibility() + f * slope_of_z,
            bend: 2.0 * slope_of_z + f * bend_of_z,
        }
    }
}

/// Ratio of the mean speed at fixed energy to Maxwell's, sqrt(n) Gamma(n) / Gamma(n + 1/2), by its series in 1/n (error
/// 2e-4 at n = 1).
pub(crate) fn fixed_energy_speed(discs: f64) -> f64 {
    let inverse = 1.0 / discs;
    1.0 + inverse * (1.0 / 8.0 + inverse * (1.0 / 128.0 - inverse * 5.0 / 1024.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinetoscope_manifest::quantity::{BoxSide, Positive};

    /// Source: independent event-driven programs, N = 1e4: Z at packing fractions from 0.1 to 0.5. Tolerance:
    /// Henderson's law is within 0.6 % there.
    #[test]
    fn henderson_is_close_to_simulated_pressures() {
        for (fraction, simulated) in
            [(0.1, 1.23615), (0.2, 1.5702), (0.3, 2.0633), (0.4, 2.8288), (0.5, 4.106)]
        {
            assert!((henderson(fraction) / simulated - 1.0).abs() < 0.006, "{fraction}");
        }
    }

    /// Source: event-driven runs, 4 replicates of 2000 n events in a box of 40 x 40, r = 1: Z and its standard error.
    #[test]
    fn small_boxes_agree_with_simulation() {
        for (discs, simulated, error) in
            [(20, 1.08239, 23e-5), (50, 1.23369, 33e-5), (150, 2.0613, 1.2e-3)]
        {
            let config =
                PackingConfig { discs: discs.try_into().unwrap(), ..PackingConfig::default() };
            let z = equilibrium(&config, DiscSizes::equal(&config)).compressibility_factor;
            let allowed = 3.0 * error + 0.003 * (z - 1.0);
            assert!((z - simulated).abs() < allowed, "n = {discs}: {z} against {simulated}");
        }
    }

    /// Source: event-driven runs of 4000 n events in a periodic box at f = 0.3: Z, pair rate over sqrt(kT/m), and their
    /// standard errors. Tolerance: Henderson's law is within 0.1 % of Z - 1 there. A mixture of radii uniform in [0.7,
    /// 1.3] is tested as well: x = 1/1.03, within 0.5 %.
    #[test]
    fn periodic_boxes_agree_with_simulation() {
        let side = |side: f64| BoxSide::new(side).unwrap();
        let of = |discs: u32, length: f64| PackingConfig {
            discs: discs.try_into().unwrap(),
            width: side(length),
            height: side(length),
            ..PackingConfig::default()
        };
        for (config, [z, z_error, rate, rate_error]) in [
            (of(100, 32.36), [2.06461, 1.7e-3, 1.19700, 1.7e-3]),
            (of(12, 11.21), [2.08719, 4.3e-3, 1.18750, 3.7e-3]),
        ] {
            let theory = periodic_equilibrium(&config, DiscSizes::equal(&config)).unwrap();
            let allowed = 3.0 * z_error + 1e-3 * (z - 1.0);
            assert!((theory.compressibility_factor - z).abs() < allowed, "{theory:?} {z}");
            let allowed = 3.0 * rate_error + 1e-3 * rate;
            assert!((theory.pair_rate - rate).abs() < allowed, "{theory:?} {rate}");
        }
        let mixed = DiscSizes {
            packing_fraction: 0.309_160,
            mean_radius: 1.0,
            squared_mean_over_mean_square: 1.0 / 1.03,
        };
        let z = periodic_equilibrium(&of(100, 32.36), mixed).unwrap().compressibility_factor;
        assert!((z - 2.10804).abs() < 3.0 * 2.0e-3 + 0.005 * 1.108, "{z}");
    }

    /// Source: event-driven runs of 3000 n events in a box of 40 x 40, radii uniform in [0.4, 1.6]: f, `<r>` and x of the
    /// drawn radii, then Z and the pair and wall collision rates over sqrt(kT/m), each with its standard error.
    /// Tolerance: in addition 0.5 % of Z - 1 and of the rates. Control: equal discs with the same packing fraction.
    #[test]
    fn mixtures_between_walls_agree_with_simulation() {
        type Simulated = [(f64, f64); 3];
        let runs: [(u32, [f64; 3], Simulated); 3] = [
            (
                20,
                [0.053_410_45, 1.126_786_65, 0.933_505_81],
                [(1.111_97, 6.4e-4), (0.108_435, 6.0e-4), (0.047_234, 1.2e-4)],
            ),
            (
                50,
                [0.129_831_98, 1.102_035_52, 0.918_352_49],
                [(1.315_09, 1.1e-3), (0.308_884, 9.6e-4), (0.055_754, 1.2e-4)],
            ),
            (
                150,
                [0.340_925_29, 1.014_832_73, 0.889_714_89],
                [(2.283_82, 2.6e-3), (1.328_562, 2.2e-3), (0.096_398, 2.5e-4)],
            ),
        ];
        for (discs, [packing_fraction, mean_radius, squared_mean_over_mean_square], simulated) in
            runs
        {
            let config =
                PackingConfig { discs: discs.try_into().unwrap(), ..PackingConfig::default() };
            let mixed = DiscSizes { packing_fraction, mean_radius, squared_mean_over_mean_square };
            let agrees = |sizes: DiscSizes| {
                let theory = equilibrium(&config, sizes);
                let given = [
                    theory.compressibility_factor - 1.0,
                    theory.pair_rate,
                    theory.wall_collision_rate_per_disc,
                ];
                given
                    .iter()
                    .zip(simulated)
                    .enumerate()
                    .map(|(index, (&theory, (value, error)))| {
                        let value = if index == 0 { value - 1.0 } else { value };
                        (theory - value).abs() < 3.0 * error + 0.005 * value
                    })
                    .collect::<Vec<bool>>()
            };
            assert_eq!(agrees(mixed), [true; 3], "n = {discs}: {:?}", equilibrium(&config, mixed));
            let one_size = DiscSizes {
                mean_radius: mean_radius / squared_mean_over_mean_square.sqrt(),
                squared_mean_over_mean_square: 1.0,
                ..mixed
            };
            assert!(!agrees(one_size)[0], "control, n = {discs}");
        }
    }

    /// In a box much larger than its discs, walls have no effect: Enskog's rate with g = (1 - 7f/16)/(1 - f)^2.
    #[test]
    fn without_walls_the_rate_is_enskogs() {
        let config = PackingConfig {
            discs: 300_000.try_into().unwrap(),
            width: BoxSide::new(100_000.0).unwrap(),
            height: BoxSide::new(100_000.0).unwrap(),
            radius: Positive::new(46.0).unwrap(),
            ..PackingConfig::default()
        };
        let fraction = packing_fraction(&config);
        let contact_value = (1.0 - 7.0 * fraction / 16.0) / ((1.0 - fraction) * (1.0 - fraction));
        let density = 300_000.0 / 1e10;
        let enskog = 2.0 * PI.sqrt() * density * 92.0 * contact_value;
        let theory = equilibrium(&config, DiscSizes::equal(&config));
        assert!((theory.pair_rate / enskog - 1.0).abs() < 2e-3, "{theory:?} {enskog}");
        assert!((theory.compressibility_factor / henderson(fraction) - 1.0).abs() < 2e-3);
    }

    /// A single disc has no pair collisions and one speed v. It crosses a square of side a at the rate 4 <|v_x|>/(2a),
    /// with <|v_x|> = 2 v/pi and kT/m = v^2/2.
    #[test]
    fn a_single_disc_meets_walls_alone() {
        let config = PackingConfig {
            discs: 1.try_into().unwrap(),
            radius: Positive::new(0.5).unwrap(),
            ..PackingConfig::default()
        };
        let theory = equilibrium(&config, DiscSizes::equal(&config));
        let exact = 4.0 / (2.0 * 39.0) * 2.0 / PI * 2.0_f64.sqrt();
        assert!(
            (theory.wall_collision_rate_per_disc / exact - 1.0).abs() < 2e-3,
            "{theory:?} {exact}"
        );
        assert!(theory.pair_rate.abs() < 1e-4, "{theory:?}");
    }
}

//! Laws of hard discs.

use crate::metric::law::laws;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, LN_2, PI};

laws! {
    COOLING: "T = T_0 exp(-(1 - e^2) C / N) after C pair collisions; constant for e = 1", "Haff 1983; velocities by Maxwell's law", range "128 discs or more without flow or clusters: energy of the mean velocities and variance of the numbers of cells of 8 discs or more as for independent discs; accuracy of the exponent 2 % and 1/sqrt(C)", named "Haff's law";
    A2_FIXED_ENERGY: "mean a2 = -1/(N + 1) at fixed energy", "uniform law on the energy sphere";
    A2_FIXED_MOMENTUM: "mean a2 = -1/N at fixed energy and momentum", "uniform law on the energy sphere of relative velocities";
    A2_COOLING: "a2 = 16 (1 - e)(1 - 2 e^2) / (57 - 25 e + 30 e^2 (1 - e))", "van Noije and Ernst 1998, homogeneous cooling state to first order in a2", range "no flow or clusters, as for the temperature; accuracy 0.003, 0.1 a2 and 1/N, as against direct simulation Monte Carlo";
    COLLISION_RATE: "Enskog: ν = 2 sqrt(pi) n d χ sqrt(T), corrected for walls and fixed N and energy", "Chapman and Enskog; Kolafa and Rottner 2006, at freezing Li et al. 2022; walls by Helfand, Frisch and Lebowitz 1961", range "no flow or clusters of cooling discs, as for their temperature; φ up to 0.69 in a periodic box, accuracy 1e-4 up to 0.68 with 870 discs or more, 1.7e-3 at 0.69, and for n discs, at most 870, 0.8 exp(9.5 sqrt(n) (φ - 0.712)) of Z; with walls up to 0.6 far from them and wall noise up to 0.004 rad^2, accuracy (0.3 + (10 + 6000 φ^6)/N) % of Z - 1; as many discs as in the simulations at freezing as for compressibility_factor", named "Enskog's theory";
    FREE_PATH: "Enskog: <|v|>/ν = 1/(2 sqrt(2) n d χ), corrected for walls and fixed N and energy", "Chapman and Enskog; Kolafa and Rottner 2006, at freezing Li et al. 2022; walls by Helfand, Frisch and Lebowitz 1961", range "elastic discs of one size; φ up to 0.69 in a periodic box, accuracy 1e-4 up to 0.68 with 870 discs or more, 1.7e-3 at 0.69, and for n discs, at most 870, 0.8 exp(9.5 sqrt(n) (φ - 0.712)) of Z; with walls up to 0.6 far from them and wall noise up to 0.004 rad^2, accuracy (0.3 + (10 + 6000 φ^6)/N) % of Z - 1; as many discs as in the simulations at freezing as for compressibility_factor", named "Enskog's theory";
    WALL_COLLISION_RATE: "force on the walls / (m T) times sqrt(T / (2 pi))", "contact theorem; Kolafa and Rottner 2006; walls by Helfand, Frisch and Lebowitz 1961", range "no flow or clusters of cooling discs, as for their temperature; φ up to 0.6 far from the walls and wall noise up to 0.004 rad^2; accuracy (0.3 + (10 + 6000 φ^6)/N) %";
    COMPRESSIBILITY: "Z by Kolafa and Rottner, with the line tension of scaled-particle theory at walls, corrected for fixed N; Z - 1 times (1 + e)/2", "Kolafa and Rottner 2006; walls by Helfand, Frisch and Lebowitz 1961", range "no flow or clusters of cooling discs, as for their temperature; φ up to 0.69 in a periodic box, accuracy 1e-4 up to 0.68 with 870 discs or more, 1.7e-3 at 0.69, and for n discs, at most 870, 0.8 exp(9.5 sqrt(n) (φ - 0.712)) of Z; with walls up to 0.6 far from them and wall noise up to 0.004 rad^2, accuracy (0.3 + (10 + 6000 φ^6)/N) % of Z - 1", named "Kolafa and Rottner's equation of state";
    COMPRESSIBILITY_AT_FREEZING: "Z of event-chain simulations of as many discs, interpolated between packing fractions; Z - 1 times N/(N - 1)", "Li et al., J. Chem. Phys. 157 (2022) 234111", range "elastic discs of one size in a periodic square: 224 discs at φ of 0.67 to 0.722, 870 at 0.67 to 0.718, 16384 at 0.698 to 0.716; accuracy that of the simulations, 3e-6 to 1e-3, and 0.1 of the difference from linear interpolation", named "the simulations of Li et al.";
    PRESSURE_AT_FREEZING: "P d^2/(m T) of event-chain simulations of as many discs, interpolated between packing fractions", "Li et al., J. Chem. Phys. 157 (2022) 234111", range "elastic discs of one size in a periodic square: 224 discs at φ of 0.67 to 0.722, 870 at 0.67 to 0.718, 16384 at 0.698 to 0.716; accuracy that of the simulations, 3e-6 to 1e-3, and 0.1 of the difference from linear interpolation", named "the simulations of Li et al.";
    PRESSURE_OF_FLUID: "P d^2/(m T) = (4 φ/pi) Z, corrected for fixed N", "Kolafa and Rottner 2006", range "no flow or clusters of cooling discs, as for their temperature; φ up to 0.69, accuracy as of Z", named "Kolafa and Rottner's equation of state";
    COMPRESSIBILITY_OF_WAVES: "S(Q) = S (1 + (1 - S)(Q d)^2/16) with S = 1/(Z + φ times the slope of Z over φ)", "compressibility equation of Ornstein and Zernike; Kolafa and Rottner 2006", range "elastic discs in a periodic box, φ up to 0.68, Q d up to 0.5; accuracy (1 - S)(Q d)^2/16 and 3/N";
    COMPRESSIBILITY_OF_SIZES: "Z = (1 - q)/(1 - φ) + q Z of one size, corrected for walls and fixed N; Z - 1 times (1 + e)/2", "Santos, Yuste and Lopez de Haro 1999; Kolafa and Rottner 2006; walls by Helfand, Frisch and Lebowitz 1961", range "no flow or clusters of cooling discs, as for their temperature; φ up to 0.69 in a periodic box, up to 0.6 far from walls with noise up to 0.004 rad^2; accuracy 0.5 % of Z - 1 more than for one size";
    COLLISION_RATE_OF_SIZES: "Enskog: ν = 2 sqrt(pi) n <d_ij χ_ij> sqrt(T), (1 - φ) χ_ij = 1 + ((1 - φ) χ - 1) (d_i d_j/d_ij) <d>/<d^2> with χ of one size, corrected for walls and fixed N and energy", "Santos, Yuste and Lopez de Haro 1999; Kolafa and Rottner 2006; walls by Helfand, Frisch and Lebowitz 1961", range "no flow or clusters of cooling discs, as for their temperature; φ up to 0.69 in a periodic box, up to 0.6 far from walls with noise up to 0.004 rad^2; accuracy 0.5 % of Z - 1 more than for one size", named "Enskog's theory";
    CONTACT_VALUE: "<d_ij χ_ij>/<d> = 1/(1 - φ) + q (χ - 1/(1 - φ)), for one size χ = (Z - 1)/(2φ); corrected for fixed N", "Santos, Yuste and Lopez de Haro 1999; Kolafa and Rottner 2006, at freezing Li et al. 2022", range "no flow or clusters of cooling discs, as for their temperature; φ up to 0.69; accuracy 1e-4 of Z up to 0.68 with 870 discs or more, 1.7e-3 at 0.69, and for n discs, at most 870, 0.8 exp(9.5 sqrt(n) (φ - 0.712)) of Z; 0.5 % more for several sizes; as many discs as in the simulations at freezing as for compressibility_factor";
    VIRIAL_IDENTITY: "Z - 1 = (1 + e)/2 (sqrt(pi)/4) d ν/sqrt(T), for several sizes with <d_ij^2 χ_ij>/<d_ij χ_ij> in place of d", "virial theorem with Maxwell's velocities, corrected for fixed energy; Kolafa and Rottner 2006, at freezing Li et al. 2022", range "no flow or clusters of cooling discs, as for their temperature; φ up to 0.69 in a periodic box, accuracy 1e-4 up to 0.68 with 870 discs or more, 1.7e-3 at 0.69, and for n discs, at most 870, 0.8 exp(9.5 sqrt(n) (φ - 0.712)) of Z; with walls up to 0.6 far from them and wall noise up to 0.004 rad^2, accuracy (0.3 + (10 + 6000 φ^6)/N) % of Z - 1; as many discs as in the simulations at freezing as for compressibility_factor";
    SELF_DIFFUSION: "Enskog: D = 1.027 sqrt(T/pi) / (2 n d χ), plus the tail of the velocity autocorrelation from 2.5 mean free times (fitted) to the end of the window, minus that of fixed momentum", "Chapman and Enskog, four Sonine polynomials; tail by Ernst, Hauge and van Leeuwen 1970; viscosity by Gass 1971; Kolafa and Rottner 2006", range "φ up to 0.25, 200 discs or more; accuracy 5 %", named "Enskog's theory";
    SINAI: "collision rate of Sinai's billiard, times the mean logarithm of the factor by which a difference grows in a collision", "Chernov 1997; mean logarithm of the free path by Boca and Zaharescu, Communications in Mathematical Physics 269 (2007) 425", range "two discs of one size, or one disc and one obstacle with the distance d at contact, in a periodic square of the side L without drift, d/L up to 0.1; accuracy 1.5 d/L of the growth per collision", named "the theory of Sinai's billiard";
    CHAINS: "collisions of the longest chain per unit of time, times the logarithm of the mean free path over the diameter; Krylov's estimate takes the collisions of one disc", "Krylov 1979; van Zon, van Beijeren and Dellago, Phys. Rev. Lett. 80 (1998) 2035", range "three discs or more of one size in a periodic box without drift, φ up to 0.002; accuracy 1.5 over ln(l/d), the next term", named "the kinetic theory of van Zon et al.";
    ENERGY_BALANCE: "kinetic + potential + dissipated - from the floor is constant", "conservation of energy; the floor's work is its impulse times its velocity", conserves "energy";
    BALANCE_OF_WEIGHT: "<y> of a density n with dp/dy = -n m g and p = n m T Z where obstacles leave room for centers, barometric for points", "hydrostatic balance; Kolafa and Rottner 2006", range "elastic discs of one size above a floor that is not shaken, a fluid at all heights, at the temperature of the floor or else of the states; a width of 10 diameters and 20 crossings of the column or more, and 20 discs without a temperature of the floor; accuracy 1e-4, 1/N without a temperature of the floor, and the diameter times φ at the floor for the layers that order there, and φ at the floor times the share of the area within a diameter of obstacles; discs reach all of the area that obstacles leave", named "the balance of weight and pressure";
    ELASTIC_ENERGY: "constant for e = 1", "conservation of energy; walls keep the speed", conserves "kinetic energy";
}

/// Ratio of Enskog's D to that of the first Sonine polynomial: 1.0239, 1.0266 and 1.0271 with two, three and four polynomials.
const SONINE_CORRECTION: f64 = 1.027;

/// Time in mean free times from which the tail is added: fitted to runs at packing fractions of 0.05 to 0.2, where it adds as much as
/// the tail of mode coupling from there to the end of a window.
pub(crate) const TAIL_ONSET_MEAN_FREE_TIMES: f64 = 2.5;

/// Elastic discs of one size whose diffusion is expected.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DiffusingDiscs {
    pub(crate) discs: f64,
    pub(crate) packing_fraction: f64,
    pub(crate) diameter: f64,
    /// χ
    pub(crate) contact_value: f64,
    pub(crate) temperature: f64,
    /// Pair collisions per disc and unit of time.
    pub(crate) pair_rate: f64,
}

impl DiffusingDiscs {
    /// Self-diffusion coefficient after a time t, in mean free times t_0 = 1/(2 sqrt(pi) n d χ sqrt(T)); `logarithm` is the mean of
    /// ln(t / onset of the tail).
    ///
    /// In Enskog's first approximation, the velocity autocorrelation is exp(-t/t_0), so D = T t_0. The tail is
    /// T / (8 pi n (D + viscosity) t) of D per unit of time (mode coupling). A fixed momentum takes T/N off the autocorrelation.
    pub(crate) fn self_diffusion(&self, time: f64, logarithm: f64) -> f64 {
        let free_time = 1.0 / self.pair_rate;
        let enskog = SONINE_CORRECTION * self.temperature * free_time;
        let density = 4.0 * self.packing_fraction / (PI * self.diameter * self.diameter);
        let spread = 8.0 * PI * density * (enskog + self.kinematic_viscosity(density));
        enskog + self.temperature / spread * logarithm
            - self.temperature * free_time * time / self.discs
    }

    /// Wavelength beyond which shear waves of cooling discs grow relative to the thermal speed: viscosity k^2 = ζ/2 with the cooling
    /// rate ζ = (1 - e^2) ν/2 (McNamara, Phys. Fluids A 5 (1993) 3056; van Noije and Ernst, Phys. Rev. E 61 (2000) 1765).
    pub(crate) fn critical_wavelength(&self, restitution: f64) -> f64 {
        let density = 4.0 * self.packing_fraction / (PI * self.diameter * self.diameter);
        let cooling = (1.0 - restitution * restitution) * self.pair_rate / 2.0;
        2.0 * PI * (2.0 * self.kinematic_viscosity(density) / cooling).sqrt()
    }

    /// Enskog's kinematic viscosity of discs (Gass, J. Chem. Phys. 54 (1971) 1898): 1.022 sqrt(T/pi) / (2 d n) times
    /// (1 + x + 0.8729 x^2) / χ with x = 2 φ χ.
    fn kinematic_viscosity(&self, density: f64) -> f64 {
        let dilute = 1.022 * (self.temperature / PI).sqrt() / (2.0 * self.diameter * density);
        let x = 2.0 * self.packing_fraction * self.contact_value;
        dilute * (1.0 + x + 0.8729 * x * x) / self.contact_value
    }
}

/// Mean logarithm of the factor by which a difference grows per collision of two discs of the diameter d in a periodic square of the side L,
/// `ratio` = d/L: the mean of ln(2 τ/(d cos φ)), with the free path τ of the relative motion and the angle φ to the normal. The mean of
/// ln τ is that of the logarithm of the mean, ln(L^2/(2 d)), minus 3 ln 2 - 9 ζ(3)/(4 ζ(2)); the mean of ln cos φ is ln 2 - 1.
pub(crate) fn sinai_growth_per_collision(ratio: f64) -> f64 {
    const ZETA_3: f64 = 1.202_056_903_159_594_3;
    let of_free_paths = 3.0 * LN_2 - 27.0 * ZETA_3 / (2.0 * PI * PI);
    1.0 - LN_2 - of_free_paths - 2.0 * libm::log(ratio)
}

/// Ratio of the collision rate of a disc with this speed, in sqrt(T), to ν: the mean relative speed is sqrt(pi/2) exp(-x) times the sum over k of
/// (3/2)_k x^k/(k!)^2 with x = v^2/2, Kummer's function M(-1/2, 1, -x), and its mean over all speeds is sqrt(pi).
fn collision_rate_at_speed(speed: f64) -> f64 {
    let x = speed * speed / 2.0;
    let (mut term, mut sum, mut order) = (1.0, 1.0, 0.0);
    while term > f64::EPSILON * sum {
        term *= (1.5 + order) * x / ((1.0 + order) * (1.0 + order));
        sum += term;
        order += 1.0;
    }
    FRAC_1_SQRT_2 * libm::exp(-x) * sum
}

/// Fraction of the flights between two collisions that take longer than this time, or lead farther than this path, in mean free times or mean free
/// paths, of independent discs with Maxwell's speeds. A disc with the speed v collides after a time with the density ν(v) exp(-ν(v) t), and its flights
/// are ν(v)/ν times as many as its share of the discs (Visco, van Wijland and Trizac, Phys. Rev. E 77 (2008) 041117).
pub(crate) fn longer_flights(than: f64, is_path: bool) -> f64 {
    const STEP: f64 = 0.02;
    let at = |step: u32| {
        let speed = (f64::from(step) + 0.5) * STEP;
        let rate = collision_rate_at_speed(speed);
        // A mean free path at the speed v takes <v>/v mean free times.
        let slowness = if is_path { FRAC_PI_2.sqrt() / speed } else { 1.0 };
        STEP * speed * rate * libm::exp(-speed * speed / 2.0 - rate * slowness * than)
    };
    (0..400).map(at).sum()
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

/// Temperature over its initial value after this number of pair collisions; [`cooling_accuracy`] is its relative accuracy.
pub(crate) fn cooling(restitution: f64, pair_collisions: f64, discs: u32) -> f64 {
    libm::exp(-(1.0 - restitution * restitution) * pair_collisions / f64::from(discs))
}

/// Relative accuracy of [`cooling`]: that of the mean energy loss per collision, 2 % for a2 up to 0.07, and the scatter of the
/// losses.
pub(crate) fn cooling_accuracy(restitution: f64, pair_collisions: f64, discs: u32) -> f64 {
    let exponent = -libm::log(cooling(restitution, pair_collisions, discs));
    exponent * (0.02 + 1.0 / pair_collisions.max(1.0).sqrt())
}

/// Time average of a speed between two values if its inverse grows linearly, as in Haff's law.
pub(crate) fn mean_while_cooling(before: f64, after: f64) -> f64 {
    if (before - after).abs() <= 1e-6 * before {
        return (before + after) / 2.0;
    }
    before * after * libm::log(before / after) / (before - after)
}

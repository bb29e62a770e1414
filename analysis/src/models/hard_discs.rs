//! Hard discs in equilibrium: equation of state, contact values, and the excess at the walls of a container.
//!
//! Pressures and line tensions are over kT. They are exact laws of statistical mechanics applied to two approximations: the
//! equation of state of Kolafa and Rottner, Mol. Phys. 104 (2006) 3435, and a line tension at hard walls by scaled-particle
//! theory (Helfand, Frisch and Lebowitz, J. Chem. Phys. 34 (1961) 1037), which is made exact to second order in the density.

use std::f64::consts::{FRAC_2_PI, PI};

/// Maximum packing fraction of the fluid: the equation of state is fitted up to 0.6912, and the hexatic phase begins at
/// 0.700 (Bernard and Krauth 2011).
pub(crate) const MAX_PACKING_FRACTION: f64 = 0.6912;
/// Relative accuracy of the equation of state. Its fit deviates from the simulations of its source by up to 5e-6, and independent
/// programs agree to 1e-4.
pub(crate) const STATE_EQUATION_ACCURACY: f64 = 1e-4;

/// Largest number of discs with which the deviations near freezing were measured. Larger boxes deviate less, by an unknown amount.
const MOST_MEASURED_DISCS: f64 = 870.0;

/// Relative accuracy of Z of a fixed number of discs in a periodic box, with the leading correction for that number.
///
/// Where the second derivative of the pressure is large, the next terms of that correction are missing, and the sides of the box order
/// the discs. Z exceeds the simulations of Li et al., J. Chem. Phys. 157 (2022) 234111, by 8e-5 at a packing fraction of 0.68 and 1.5e-3
/// at 0.69 with 870 discs, by 4e-3 and 2.4 % with 224, and by up to 5 % and 12 % with 72. The bound 0.8 exp(-9.5 sqrt(n) (0.712 - f))
/// contains all their deviations from 0.65 to 0.69 in boxes of five shapes.
pub(crate) fn periodic_accuracy(packing_fraction: f64, discs: f64) -> f64 {
    let side = discs.min(MOST_MEASURED_DISCS).sqrt();
    let of_finite_box = 0.8 * libm::exp(-9.5 * side * (0.712 - packing_fraction));
    if of_finite_box > STATE_EQUATION_ACCURACY { of_finite_box } else { STATE_EQUATION_ACCURACY }
}

/// Maximum packing fraction far from the walls of a container up to which the line tension has been compared with runs.
pub(crate) const MAX_BULK_FRACTION: f64 = 0.6;

/// Accuracy of Z - 1 in a container, as a fraction of it: 0.3 %, and for few discs (0.1 + 60 f^6)/n in addition, with the packing
/// fraction f far from the walls. It was measured with event-driven runs of 5 to 400 discs in rectangles at packing fractions
/// from 0.05 to 0.5.
pub(crate) fn confined_accuracy(bulk_fraction: f64, discs: f64) -> f64 {
    0.003 + (0.1 + 60.0 * bulk_fraction.powi(6)) / discs
}

/// Powers and coefficients of x = f/(1 - f) in Z (Kolafa and Rottner 2006, section 3.2, fit up to a number density of 0.88).
const COEFFICIENTS: [(i32, f64); 14] = [
    (0, 1.0),
    (1, 2.0),
    (2, 1.128_017_75),
    (3, 0.001_818_952_91),
    (4, -0.052_613_473_7),
    (5, 0.050_495_166_8),
    (6, -0.032_543_384_6),
    (7, 0.013_394_653_1),
    (8, 0.001_742_656_04),
    (9, -0.009_446_322_02),
    (10, 0.008_511_117_68),
    (11, -0.003_596_352_5),
    (12, 0.000_577_345_106),
    (19, -1.063_991_27e-7),
];
/// Packing fraction up to which the fit is extrapolated beyond its maximum. Near 0.70, where the fluid ends, the pressure of the fit
/// falls with the density, so at higher fractions there are no theoretical values.
pub(crate) const EXTRAPOLATION_LIMIT: f64 = 0.695;

/// Z with its first two derivatives over the packing fraction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StateEquation {
    pub(crate) compressibility: f64,
    pub(crate) slope: f64,
    pub(crate) bend: f64,
}

impl StateEquation {
    /// Equal discs at a packing fraction.
    pub(crate) fn at(packing_fraction: f64) -> Self {
        let free = 1.0 - packing_fraction.min(EXTRAPOLATION_LIMIT);
        let x = (1.0 - free) / free;
        let (x_slope, x_bend) = (1.0 / (free * free), 2.0 / (free * free * free));
        let [mut value, mut first, mut second] = [0.0; 3];
        for (power, coefficient) in COEFFICIENTS {
            let n = f64::from(power);
            value += coefficient * x.powi(power);
            first += coefficient * n * x.powi(power - 1);
            if power > 1 {
                second += coefficient * n * (n - 1.0) * x.powi(power - 2);
            }
        }
        // The zeroth power has no slope, also at x = 0.
        let first = if x == 0.0 { COEFFICIENTS[1].1 } else { first };
        Self {
            compressibility: value,
            slope: first * x_slope,
            bend: second * x_slope * x_slope + first * x_bend,
        }
    }
}

/// Pair correlation function of equal discs at contact, (Z - 1)/(2 f).
pub(crate) fn contact_value(packing_fraction: f64) -> f64 {
    let fraction = packing_fraction.max(1e-12);
    (StateEquation::at(fraction).compressibility - 1.0) / (2.0 * fraction.min(EXTRAPOLATION_LIMIT))
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
    /// Discs of one radius.
    pub(crate) fn equal(packing_fraction: f64, radius: f64) -> Self {
        Self { packing_fraction, mean_radius: radius, squared_mean_over_mean_square: 1.0 }
    }

    /// Mean area of a disc.
    pub(crate) fn disc_area(&self) -> f64 {
        PI * self.mean_radius * self.mean_radius / self.squared_mean_over_mean_square
    }

    /// The same size distribution at another packing fraction.
    pub(crate) fn at(&self, packing_fraction: f64) -> Self {
        Self { packing_fraction, ..*self }
    }

    /// g (1 - f) - 1 of equal discs at contact: what crowding adds to the contact value of a mixture of points and discs.
    fn crowding(&self) -> f64 {
        contact_value(self.packing_fraction) * (1.0 - self.packing_fraction) - 1.0
    }

    /// Mean distance of centers in a collision, `<s_ij^2 g_ij>/<s_ij g_ij>` with s_ij = (s_i + s_j)/2 and the contact
    /// values (1 - f) g_ij = 1 + c (s_i s_j/s_ij) `<s>/<s^2>` of diameters s, where c is [`Self::crowding`] (Santos, Yuste and
    /// López de Haro, Mol. Phys. 96 (1999) 1).
    pub(crate) fn collision_diameter(&self) -> f64 {
        let x = self.squared_mean_over_mean_square;
        let crowding = self.crowding();
        2.0 * self.mean_radius * ((1.0 + 1.0 / x) / 2.0 + crowding) / (1.0 + crowding * x)
    }

    /// Mean radius of the discs at a wall. Large discs collide with it more often: (1 - f) g = 1 + 2 c s `<s>/<s^2>`, the
    /// contact value with an infinitely large disc.
    pub(crate) fn radius_at_walls(&self) -> f64 {
        let x = self.squared_mean_over_mean_square;
        let crowding = 2.0 * self.crowding();
        self.mean_radius * (1.0 + crowding) / (1.0 + crowding * x)
    }

    /// Z = (1 - x)/(1 - f) + x Z of equal discs, which follows from the contact values.
    pub(crate) fn compressibility(&self) -> f64 {
        let (f, x) = (self.packing_fraction, self.squared_mean_over_mean_square);
        x * StateEquation::at(f).compressibility + (1.0 - x) / (1.0 - f)
    }

    /// First and second derivative of f Z(f), the pressure in units of kT over a disc's mean area.
    pub(crate) fn pressure_curve(&self) -> PressureCurve {
        let (f, x) = (self.packing_fraction, self.squared_mean_over_mean_square);
        let (free, one_size) = (1.0 - f, StateEquation::at(f));
        let slope = x * one_size.slope + (1.0 - x) / (free * free);
        let bend = x * one_size.bend + (1.0 - x) * 2.0 / (free * free * free);
        PressureCurve { slope: self.compressibility() + f * slope, bend: 2.0 * slope + f * bend }
    }

    /// Line tension at a wall over `<r>` times the density, 1/(1 - f) + (1 - 8/(3 pi)) f, and its slope over the density
    /// over `<r>`.
    fn tension(&self) -> (f64, f64) {
        const SECOND_ORDER: f64 = 1.0 - 8.0 / (3.0 * PI);
        let (f, free) = (self.packing_fraction, 1.0 - self.packing_fraction);
        (1.0 / free + SECOND_ORDER * f, 1.0 / (free * free) + 2.0 * SECOND_ORDER * f)
    }
}

/// Derivatives of f Z(f).
pub(crate) struct PressureCurve {
    pub(crate) slope: f64,
    pub(crate) bend: f64,
}

impl PressureCurve {
    /// Factor of a function y = f Y(f) of the density for a fixed number of discs. It is lower by y'' rho S/(2A) than for a
    /// fluctuating number, S = kT d(rho)/dP (Lebowitz, Percus and Verlet, Phys. Rev. 153 (1967) 250).
    pub(crate) fn fixed_number(&self, packing_fraction: f64, value: f64, discs: f64) -> f64 {
        let square = packing_fraction * packing_fraction;
        1.0 - square * self.bend / (2.0 * value * self.slope * discs)
    }
}

/// A container with hard walls; lengths are those of the walls, not of the centers' room.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Container {
    Rectangle { width: f64, height: f64 },
    Circle { radius: f64 },
}

/// A fluid in a container: its state far from the walls, and the line tension there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConfinedFluid {
    container: Container,
    pub(crate) bulk: DiscSizes,
    /// Discs per area far from the walls.
    density: f64,
    /// Line tension over kT.
    tension: f64,
}

impl Container {
    fn area(self) -> f64 {
        match self {
            Self::Rectangle { width, height } => width * height,
            Self::Circle { radius } => PI * radius * radius,
        }
    }

    fn perimeter(self) -> f64 {
        match self {
            Self::Rectangle { width, height } => 2.0 * (width + height),
            Self::Circle { radius } => 2.0 * PI * radius,
        }
    }

    /// The fluid of this many discs. The grand potential is -P A + tension L + c, where c is the constant of the corners or of
    /// the curvature, and the number of discs is its slope over the chemical potential. `None` if no fluid up to
    /// [`EXTRAPOLATION_LIMIT`] has this many discs.
    pub(crate) fn filled(self, discs: f64, sizes: DiscSizes) -> Option<ConfinedFluid> {
        let (mut low, mut high) = (0.0, EXTRAPOLATION_LIMIT);
        // Each halving doubles the accuracy.
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            if self.number(sizes.at(middle)) < discs {
                low = middle;
            } else {
                high = middle;
            }
        }
        if high == EXTRAPOLATION_LIMIT {
            return None;
        }
        let bulk = sizes.at(high);
        let density = bulk.packing_fraction / bulk.disc_area();
        let tension = density * bulk.mean_radius * bulk.tension().0;
        Some(ConfinedFluid { container: self, bulk, density, tension })
    }

    fn number(self, bulk: DiscSizes) -> f64 {
        let density = bulk.packing_fraction / bulk.disc_area();
        let slope = bulk.pressure_curve().slope;
        let adsorbed = bulk.mean_radius * bulk.tension().1 / slope * self.perimeter();
        density * (self.area() - adsorbed - bulk.disc_area() * self.constant_slope(bulk) / slope)
    }

    /// Slope over f of the constant c, which is exact to second order in the density: f Z - 2 f t for a circle with the
    /// tension t over `<r>` times the density, and 4/pi of it plus 4 f^2/pi^2 for four corners.
    fn constant_slope(self, bulk: DiscSizes) -> f64 {
        let circle = bulk.pressure_curve().slope - 2.0 * bulk.tension().1;
        match self {
            Self::Rectangle { .. } => {
                2.0 * FRAC_2_PI * circle + 2.0 * FRAC_2_PI * FRAC_2_PI * bulk.packing_fraction
            }
            Self::Circle { .. } => circle,
        }
    }
}

impl ConfinedFluid {
    /// Force on all walls over kT: the pressure on their length, less that of the line tension.
    pub(crate) fn force(&self) -> f64 {
        let pressure = self.density * self.bulk.compressibility();
        let ends = match self.container {
            Container::Rectangle { .. } => 4.0,
            Container::Circle { .. } => PI,
        };
        pressure * self.container.perimeter() - 2.0 * ends * self.tension
    }

    /// Virial of the walls over kT: the forces on them times the distances of the discs that touch them from the middle.
    pub(crate) fn virial(&self) -> f64 {
        let kept_off = 2.0 * self.bulk.radius_at_walls();
        match self.container {
            Container::Rectangle { width, height } => {
                let pressure = self.density * self.bulk.compressibility();
                let force = |length: f64| pressure * length - 2.0 * self.tension;
                force(height) * (width - kept_off) + force(width) * (height - kept_off)
            }
            Container::Circle { radius } => self.force() * (radius - kept_off / 2.0),
        }
    }

    /// Z - 1 of the pair virial by the virial theorem, for a fixed number of discs.
    pub(crate) fn excess(&self, discs: f64) -> f64 {
        let fraction = self.bulk.packing_fraction;
        let value = fraction * (self.bulk.compressibility() - 1.0);
        let fixed = self.bulk.pressure_curve().fixed_number(fraction, value, discs);
        (self.virial() / (2.0 * discs) - 1.0) * fixed
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

    /// Compares Z at each packing fraction with a simulated value and its standard error; `allowed` is computed from Z and the error.
    fn assert_compressibilities(rows: &[(f64, f64, f64)], allowed: impl Fn(f64, f64) -> f64) {
        for &(fraction, simulated, error) in rows {
            let z = StateEquation::at(fraction).compressibility;
            assert!(
                (z - simulated).abs() < allowed(z, error),
                "{fraction}: {z} against {simulated}"
            );
        }
    }

    /// Source: Kolafa and Rottner 2006, table 1: number density, Z and its standard error, extrapolated to infinite size.
    /// Control: Henderson's equation, which deviates by up to 0.6 %.
    #[test]
    fn equation_of_state_agrees_with_its_source() {
        let rows = [
            (0.40, 2.151_439_3, 5.2e-6),
            (0.50, 2.760_123_5, 7.9e-6),
            (0.60, 3.663_691, 1.2e-5),
            (0.70, 5.082_362, 1.9e-5),
            (0.80, 7.476_491, 3.6e-5),
            (0.84, 8.866_011, 5.9e-5),
            (0.88, 10.230_9, 3e-4),
        ]
        .map(|(density, simulated, error)| (PI / 4.0 * density, simulated, error));
        assert_compressibilities(&rows, |_, error| 1.5 * error);
        for (fraction, simulated, _) in rows {
            let free = 1.0 - fraction;
            let henderson = (1.0 + fraction * fraction / 8.0) / (free * free);
            assert!((henderson / simulated - 1.0).abs() > STATE_EQUATION_ACCURACY, "{fraction}");
        }
    }

    /// Source: independent event-driven programs, N = 1e4: Z and its standard error.
    #[test]
    fn equation_of_state_agrees_with_independent_programs() {
        let rows = [
            (0.1, 1.236_15, 9e-5),
            (0.2, 1.570_2, 2e-4),
            (0.3, 2.063_3, 2e-4),
            (0.4, 2.828_8, 4e-4),
            (0.5, 4.106, 1e-3),
            (0.6, 6.454, 2e-3),
            (0.65, 8.406, 2e-3),
        ];
        assert_compressibilities(&rows, |z, error| {
            3.0 * libm::hypot(error, STATE_EQUATION_ACCURACY * z)
        });
    }

    #[test]
    fn derivatives_are_those_of_the_curve() {
        for fraction in [0.05, 0.3, 0.6, 0.68] {
            let [below, here, above] =
                [-1e-4, 0.0, 1e-4].map(|shift| StateEquation::at(fraction + shift));
            let slope = (above.compressibility - below.compressibility) / 2e-4;
            assert!((here.slope / slope - 1.0).abs() < 1e-4, "{fraction}");
            assert!((here.bend / ((above.slope - below.slope) / 2e-4) - 1.0).abs() < 1e-4);
        }
    }

    /// Two discs are exact: W = L d(ln Q)/dL / 2 with the probability of an overlap in a square of side l for the centers,
    /// pi x^2 - 8 x^3/3 + x^4/2, x = d/l. To second order in the density, so with n(n - 1)/2 pairs.
    /// Tolerance: the terms of third order, a fraction 2 f of Z - 1, and those of order 1/n.
    #[test]
    fn excess_is_exact_to_second_order() {
        let (discs, side) = (400.0, 400.0);
        let sizes = DiscSizes::equal(discs * PI / (side * side), 1.0);
        let fluid =
            Container::Rectangle { width: side, height: side }.filled(discs, sizes).unwrap();
        let x = 2.0 / (side - 2.0);
        let exact = (discs - 1.0) / 2.0 * (PI * x * x - 4.0 * x * x * x + x * x * x * x);
        let found = fluid.excess(discs);
        assert!((found / exact - 1.0).abs() < 2.5 * sizes.packing_fraction, "{found} {exact}");
    }
}

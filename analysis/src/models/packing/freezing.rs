//! Pressure of discs at freezing, from simulations of the same number of discs in a periodic square.
//!
//! Near freezing, no equation of state holds for a finite box: the pressure falls where liquid and hexatic coexist, because their border costs
//! free energy, and by how much depends on the number of discs.
//!
//! Source: Li, Nishikawa, Höllmer, Carillo, Maggs and Krauth, J. Chem. Phys. 157 (2022) 234111, event-chain Monte Carlo; the values are those of the
//! file `DigitizedData/ThisWork.csv` of the repository jellyfysh/HistoricDisks (commit 3afcb07), blocks of the aspect ratio 1 : 1.

use std::f64::consts::PI;

/// Numbers of discs with simulated values, and their rows: packing fraction, P d^2/kT and its standard error.
const TABLES: [(u32, &[[f64; 3]]); 3] = [(224, OF_224), (870, OF_870), (16_384, OF_16384)];

/// Rows that a value between two of them is interpolated from.
const NODES: usize = 4;

/// Share of the difference of the cubic and the linear interpolation that is the accuracy of the cubic one. Values left out of the
/// tables deviate by less from the interpolation of their neighbors, twice as far away.
const INTERPOLATION_SHARE: f64 = 0.1;

/// Rounding of a packing fraction that the sides of a box or the radius result in.
const ROUNDING: f64 = 1e-9;

/// A simulated pressure P d^2/kT with its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FreezingPressure {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

impl FreezingPressure {
    /// The pressure of this many discs; `None` without simulations of them at this packing fraction.
    pub(crate) fn of(discs: u32, packing_fraction: f64) -> Option<Self> {
        let (_, rows) = TABLES.iter().find(|(number, _)| *number == discs)?;
        Self::interpolated(rows, packing_fraction)
    }

    /// The compressibility factor Z = pi/(4 f) P d^2/kT, and its error.
    pub(crate) fn compressibility(self, packing_fraction: f64) -> [f64; 2] {
        [self.value, self.error].map(|pressure| PI / (4.0 * packing_fraction) * pressure)
    }

    /// The polynomial of third degree through the nearest rows.
    fn interpolated(rows: &[[f64; 3]], at: f64) -> Option<Self> {
        let is_inside = rows.first()?[0] - ROUNDING <= at && at <= rows.last()?[0] + ROUNDING;
        let above = rows.partition_point(|row| row[0] < at).clamp(1, rows.len() - 1);
        let start = above.saturating_sub(NODES / 2).min(rows.len().checked_sub(NODES)?);
        let (cubic, linear) = (&rows[start..start + NODES], &rows[above - 1..=above]);
        let (value, straight) = (polynomial(cubic, at), polynomial(linear, at));
        let of_rows = linear.iter().fold(0.0_f64, |error, row| error.max(row[2]));
        let error = of_rows + INTERPOLATION_SHARE * (value - straight).abs();
        is_inside.then_some(Self { value, error })
    }
}

/// Lagrange's polynomial through the first two numbers of rows.
fn polynomial(rows: &[[f64; 3]], at: f64) -> f64 {
    let weight = |own: usize| {
        let others = rows.iter().enumerate().filter(|(other, _)| *other != own);
        others.map(|(_, row)| (at - row[0]) / (rows[own][0] - row[0])).product::<f64>()
    };
    rows.iter().enumerate().map(|(own, row)| weight(own) * row[1]).sum()
}

/// 224 discs.
const OF_224: &[[f64; 3]] = &[
    [0.670, 7.979_479, 5.8e-5],
    [0.672, 8.085_31, 1.1e-4],
    [0.674, 8.189_99, 1.3e-4],
    [0.676, 8.293_15, 1.6e-4],
    [0.678, 8.393_90, 2.1e-4],
    [0.680, 8.491_05, 1.9e-4],
    [0.682, 8.582_44, 1.5e-4],
    [0.684, 8.665_82, 2.4e-4],
    [0.686, 8.738_03, 4.4e-4],
    [0.688, 8.795_79, 2.6e-4],
    [0.690, 8.833_48, 4.6e-4],
    [0.692, 8.846_51, 5.5e-4],
    [0.694, 8.833_44, 7.9e-4],
    [0.696, 8.796_6, 1.1e-3],
    [0.698, 8.745_04, 9.7e-4],
    [0.700, 8.687_6, 1.2e-3],
    [0.702, 8.643_6, 2e-3],
    [0.704, 8.626_2, 2.1e-3],
    [0.706, 8.617_5, 2.9e-3],
    [0.708, 8.630_5, 4.4e-3],
    [0.710, 8.672_1, 4.3e-3],
    [0.712, 8.737_8, 5.3e-3],
    [0.714, 8.798_4, 4.5e-3],
    [0.716, 8.886_9, 7.3e-3],
    [0.718, 8.957_0, 4.6e-3],
    [0.720, 9.084_4, 9.9e-3],
    [0.722, 9.179_8, 6.5e-3],
];

/// 870 discs.
const OF_870: &[[f64; 3]] = &[
    [0.670, 7.986_779, 2.5e-5],
    [0.672, 8.093_305, 3.5e-5],
    [0.674, 8.199_729, 2.5e-5],
    [0.676, 8.305_464, 4.6e-5],
    [0.678, 8.410_215, 2.7e-5],
    [0.680, 8.513_249, 3.7e-5],
    [0.682, 8.613_949, 6.8e-5],
    [0.684, 8.711_343, 6.8e-5],
    [0.686, 8.804_458, 5.2e-5],
    [0.688, 8.891_164, 3.4e-5],
    [0.690, 8.969_898, 7.5e-5],
    [0.692, 9.036_66, 1.1e-4],
    [0.694, 9.089_054, 8.3e-5],
    [0.696, 9.122_12, 1.6e-4],
    [0.698, 9.134_14, 2.2e-4],
    [0.700, 9.129_66, 1.5e-4],
    [0.702, 9.114_72, 1.6e-4],
    [0.704, 9.096_81, 3.5e-4],
    [0.706, 9.081_75, 3.1e-4],
    [0.708, 9.071_74, 3.6e-4],
    [0.710, 9.064_69, 4.3e-4],
    [0.712, 9.054_1, 1.3e-3],
    [0.714, 9.031_0, 3.2e-3],
    [0.716, 9.027_2, 4.9e-3],
    [0.718, 9.050_7, 4e-3],
];

/// 128 x 128 discs.
const OF_16384: &[[f64; 3]] = &[
    [0.698, 9.174_05, 4.9e-4],
    [0.704, 9.185_58, 8e-4],
    [0.708, 9.176_30, 7.4e-4],
    [0.712, 9.165_54, 9e-4],
    [0.716, 9.158_7, 1e-3],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Law: the stated error contains the error of interpolation.
    /// Setup: every second row is left out, so that rows are twice as far apart as in use, and the error of a polynomial of third degree is
    /// larger by a factor of up to 16.
    /// Tolerance: 3 combined errors.
    /// Control: linear interpolation.
    #[test]
    fn values_left_out_are_within_the_error_of_interpolation() {
        let mut linear_is_rejected = 0;
        for rows in [OF_224, OF_870] {
            let kept: Vec<[f64; 3]> = rows.iter().step_by(2).copied().collect();
            for (index, [fraction, simulated, error]) in rows.iter().enumerate() {
                let found = FreezingPressure::interpolated(&kept, *fraction);
                let Some(found) = found.filter(|_| index % 2 == 1) else { continue };
                let allowed = 3.0 * libm::hypot(found.error, *error);
                let deviation = (found.value - simulated).abs();
                println!("{fraction}: {deviation:.1e} of {allowed:.1e}");
                assert!(deviation < allowed, "{fraction}: {deviation} {allowed}");
                let linear = (rows[index - 1][1] + rows.get(index + 1).unwrap()[1]) / 2.0;
                linear_is_rejected += u32::from((linear - simulated).abs() > allowed);
            }
        }
        assert!(linear_is_rejected > 8, "control: {linear_is_rejected}");
    }

    /// Law: at a packing fraction of 0.67, liquids of 224 and 870 discs have the pressure of the equation of state with its correction for a fixed
    /// number; 870 discs in the rectangle 29 : 30 sqrt(3)/2 have that of the square up to 0.70.
    /// Source: Li et al. 2022, as the table.
    /// Tolerance: stated at each line.
    #[test]
    fn tables_agree_with_their_neighbors() {
        for (fraction, rectangle) in [(0.680, 8.513_233), (0.690, 8.969_476), (0.700, 9.129_56)] {
            let square = FreezingPressure::of(870, fraction).unwrap();
            assert!((square.value - rectangle).abs() < 5e-4, "{fraction}: {square:?}");
        }
        let many = FreezingPressure::of(870, 0.67).unwrap().compressibility(0.67)[0];
        let few = FreezingPressure::of(224, 0.67).unwrap().compressibility(0.67)[0];
        let fluid = crate::models::hard_discs::StateEquation::at(0.67).compressibility;
        assert!(
            (many / fluid - 1.0).abs() < 1e-3 && (few / many - 1.0).abs() < 1e-3,
            "{few} {many} {fluid}"
        );
    }

    #[test]
    fn other_numbers_of_discs_and_packing_fractions_have_no_value() {
        for (discs, fraction) in [(869, 0.69), (870, 0.66), (870, 0.72), (16_384, 0.69)] {
            assert_eq!(FreezingPressure::of(discs, fraction), None, "{discs} {fraction}");
        }
        assert!(FreezingPressure::of(16_384, 0.708 - 1e-12).is_some());
    }
}

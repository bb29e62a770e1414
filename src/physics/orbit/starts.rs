//! Starts that the manifest can name.

use super::motion::State;

/// Start as printed in the orbit exercise, which states "from the center of the Sun". The numbers are the position of the Earth relative to
/// the barycenter of the solar system (2013-01-01 0h, ecliptic of J2000), so the period of the orbit is 362.073 days.
pub const BARYCENTRIC_START: State = State {
    position: [-1.813_068_419_866_209e-1, 9.642_197_733_507_97e-1, -6.850_809_238_551_276e-5],
    velocity: [-1.718_334_419_397_708e-2, -3.209_800_047_122_614e-3, 6.736_104_268_755_766e-9],
};

/// The Earth at the same time relative to the Sun (ecliptic of J2000, from an ephemeris): period 364.898 days.
pub const HELIOCENTRIC_START: State = State {
    position: [-0.180_022_557_728, 0.966_674_933_247, -2.644_611e-5],
    velocity: [-0.017_189_490_082_1, -0.003_208_481_984_12, 1.372_135e-7],
};

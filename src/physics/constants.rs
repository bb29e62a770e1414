//! Physical constants with unit and source. Constants of only one model are in the folder of that model.

/// Boltzmann constant of the gas exercise, J/K (CODATA 1986).
pub const BOLTZMANN_CODATA_1986_J_PER_K: f64 = 1.380_658e-23;

/// Boltzmann constant, J/K (exact in the SI since 2019).
pub const BOLTZMANN_SI_2019_J_PER_K: f64 = 1.380_649e-23;

/// Gravitational constant times the mass of the Sun, AU^3/day^2 (orbit exercise 14to4).
pub const GM_SUN_AU3_PER_DAY2: f64 = 2.959_122_082_322_128e-4;

//! Constants of nature, each with unit and source. Constants of one model stand in that model.

/// Boltzmann's constant of the gas document, J/K (CODATA 1986).
pub const BOLTZMANN_CODATA_1986_J_PER_K: f64 = 1.380_658e-23;

/// Boltzmann's constant, J/K, exact in the SI since 2019.
pub const BOLTZMANN_SI_2019_J_PER_K: f64 = 1.380_649e-23;

/// Gravitational constant times the Sun's mass, AU^3/day^2 (orbit document, exercise 14to4).
pub const GM_SUN_AU3_PER_DAY2: f64 = 2.959_122_082_322_128e-4;

//! Laws of hard discs.

use crate::metric::law::laws;

laws! {
    COOLING: "T = T_0 exp(-(1 - e^2) C / N) after C pair collisions; constant for e = 1", "Haff 1983; velocities by Maxwell's law", range "128 discs or more without flow or clusters: energy of the mean velocities and variance of the numbers of cells of 8 discs or more as for independent discs; accuracy of the exponent 2 % and 1/sqrt(C)";
    A2_FIXED_ENERGY: "mean a2 = -1/(N + 1) at fixed energy", "uniform law on the energy sphere";
    A2_FIXED_MOMENTUM: "mean a2 = -1/N at fixed energy and momentum", "uniform law on the energy sphere of relative velocities";
    A2_COOLING: "a2 = 16 (1 - e)(1 - 2 e^2) / (57 - 25 e + 30 e^2 (1 - e))", "van Noije and Ernst 1998, homogeneous cooling state to first order in a2", range "no flow or clusters, as for the temperature; accuracy 0.003, 0.1 a2 and 1/N, as against direct simulation Monte Carlo";
    COLLISION_RATE: "Enskog: ν = 2 sqrt(pi) n d χ sqrt(T), corrected for walls and fixed N and energy", "Chapman and Enskog; Kolafa and Rottner 2006; walls by Helfand, Frisch and Lebowitz 1961", range "φ up to 0.69 in a periodic box, accuracy 1e-4; with walls up to 0.6 far from them and wall noise up to 0.004 rad^2, accuracy (0.3 + (10 + 6000 φ^6)/N) % of Z - 1";
    WALL_COLLISION_RATE: "force on the walls / (m T) times sqrt(T / (2 pi))", "contact theorem; Kolafa and Rottner 2006; walls by Helfand, Frisch and Lebowitz 1961", range "φ up to 0.6 far from the walls and wall noise up to 0.004 rad^2; accuracy (0.3 + (10 + 6000 φ^6)/N) %";
    COMPRESSIBILITY: "Z by Kolafa and Rottner, with the line tension of scaled-particle theory at walls, corrected for fixed N; Z - 1 times (1 + e)/2", "Kolafa and Rottner 2006; walls by Helfand, Frisch and Lebowitz 1961", range "φ up to 0.69 in a periodic box, accuracy 1e-4; with walls up to 0.6 far from them and wall noise up to 0.004 rad^2, accuracy (0.3 + (10 + 6000 φ^6)/N) % of Z - 1";
    COMPRESSIBILITY_OF_SIZES: "Z = (1 - q)/(1 - φ) + q Z of one size, corrected for walls and fixed N; Z - 1 times (1 + e)/2", "Santos, Yuste and Lopez de Haro 1999; Kolafa and Rottner 2006; walls by Helfand, Frisch and Lebowitz 1961", range "φ up to 0.69 in a periodic box, up to 0.6 far from walls with noise up to 0.004 rad^2; accuracy 0.5 % of Z - 1 more than for one size";
    COLLISION_RATE_OF_SIZES: "Enskog: ν = 2 sqrt(pi) n <d_ij χ_ij> sqrt(T), (1 - φ) χ_ij = 1 + ((1 - φ) χ - 1) (d_i d_j/d_ij) <d>/<d^2> with χ of one size, corrected for walls and fixed N and energy", "Santos, Yuste and Lopez de Haro 1999; Kolafa and Rottner 2006; walls by Helfand, Frisch and Lebowitz 1961", range "φ up to 0.69 in a periodic box, up to 0.6 far from walls with noise up to 0.004 rad^2; accuracy 0.5 % of Z - 1 more than for one size";
    CONTACT_VALUE: "<d_ij χ_ij>/<d> = 1/(1 - φ) + q (χ - 1/(1 - φ)), for one size χ = (Z - 1)/(2φ); corrected for fixed N", "Santos, Yuste and Lopez de Haro 1999; Kolafa and Rottner 2006", range "φ up to 0.69; accuracy 1e-4 of Z, and 0.5 % for several sizes";
    VIRIAL_IDENTITY: "Z - 1 = (1 + e)/2 (sqrt(pi)/4) d ν/sqrt(T), for several sizes with <d_ij^2 χ_ij>/<d_ij χ_ij> in place of d", "virial theorem with Maxwell's velocities, corrected for fixed energy; Kolafa and Rottner 2006", range "φ up to 0.69 in a periodic box, accuracy 1e-4; with walls up to 0.6 far from them and wall noise up to 0.004 rad^2, accuracy (0.3 + (10 + 6000 φ^6)/N) % of Z - 1";
    ELASTIC_ENERGY: "constant for e = 1", "conservation of energy; walls keep the speed";
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

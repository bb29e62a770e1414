//! The equation of motion of discs with spring–dashpot contacts, and nothing else.
//!
//! Cundall and Strack, Géotechnique 29 (1979) 47; the source document's equation (1).

/// The equation of motion, m a = m g + sum of f_c, solved for a in m/s^2.
///
/// `gravity` is g in m/s^2, `contact_force` the sum of the contact forces f_c on the disc in N, `mass` is m in kg.
#[must_use]
pub fn acceleration(gravity: [f64; 2], contact_force: [f64; 2], mass: f64) -> [f64; 2] {
    [gravity[0] + contact_force[0] / mass, gravity[1] + contact_force[1] / mass]
}

/// Equation (1) along the normal: f = k delta - eta v_n, in N, positive where it pushes.
///
/// `stiffness` is k in N/m, `damping` eta in N s/m, `overlap` delta in m, `separating_speed` v_n in m/s: the relative
/// velocity along the normal, positive where the two move apart.
#[must_use]
pub fn contact_force(stiffness: f64, damping: f64, overlap: f64, separating_speed: f64) -> f64 {
    stiffness * overlap - damping * separating_speed
}

/// Effective mass of a pair, m_eff = m_i m_j / (m_i + m_j), in kg. Against a wall it is the disc's own mass.
#[must_use]
pub fn effective_mass(first: f64, second: f64) -> f64 {
    first * second / (first + second)
}

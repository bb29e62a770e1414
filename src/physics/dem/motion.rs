//! The equations of motion of discs with spring–dashpot contacts, and nothing else.
//!
//! Cundall and Strack, Géotechnique 29 (1979) 47; the dem exercise's equation (1). Friction and rolling: Luding,
//! Granular Matter 10 (2008) 235, sections 3.2 and 3.3.

/// The equation of motion, m a = m g + sum of f_c, solved for a in m/s^2.
///
/// `gravity` is g in m/s^2, `contact_force` the sum of the contact forces f_c on the disc in N, `inverse_mass` is 1/m in 1/kg.
#[must_use]
#[inline(always)]
pub fn acceleration(gravity: [f64; 2], contact_force: [f64; 2], inverse_mass: f64) -> [f64; 2] {
    [gravity[0] + contact_force[0] * inverse_mass, gravity[1] + contact_force[1] * inverse_mass]
}

/// The equation of motion of the spin, I alpha = sum of torques, for a disc: I = m r^2/2. In rad/s^2.
#[must_use]
#[inline(always)]
pub fn angular_acceleration(torque: f64, mass: f64, radius: f64) -> f64 {
    torque / moment_of_inertia(mass, radius)
}

/// Moment of inertia of a disc about its center, I = m r^2/2, in kg m^2.
#[must_use]
#[inline(always)]
pub fn moment_of_inertia(mass: f64, radius: f64) -> f64 {
    0.5 * mass * radius * radius
}

/// Equation (1) along the normal: f = k delta - eta v_n, in N, positive where it pushes.
///
/// `stiffness` is k in N/m, `damping` eta in N s/m, `overlap` delta in m, `separating_speed` v_n in m/s: the relative
/// velocity along the normal, positive where the two move apart.
#[must_use]
#[inline]
pub fn contact_force(stiffness: f64, damping: f64, overlap: f64, separating_speed: f64) -> f64 {
    stiffness * overlap - damping * separating_speed
}

/// What a spring with a slider does in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringSlider {
    /// Force on the disc along the tangent, N.
    pub force: f64,
    /// Fraction of the force that is the dashpot's, N; 0 while it slides.
    pub dashpot_force: f64,
    /// Stretch of the spring afterward, m.
    pub stretch: f64,
    /// How far the slider moved, m.
    pub slip: f64,
}

/// A spring in series with a slider that gives way at |f| = `limit`, a dashpot beside the spring while the slider holds:
///
/// xi' = xi + v_t dt; f = -k_t xi' - eta_t v_t while |f| <= mu f_n; else |f| = mu f_n and xi = -f/k_t.
///
/// `stretch` is xi in m from the step before, `travel` is v_t dt in m, `speed` v_t in m/s, `limit` mu f_n >= 0 in N.
#[must_use]
#[inline]
pub fn spring_slider(
    stiffness: f64,
    damping: f64,
    stretch: f64,
    travel: f64,
    speed: f64,
    limit: f64,
) -> SpringSlider {
    let stretched = stretch + travel;
    let dashpot_force = -damping * speed;
    let trial = dashpot_force - stiffness * stretched;
    if trial.abs() <= limit {
        return SpringSlider { force: trial, dashpot_force, stretch: stretched, slip: 0.0 };
    }
    let force = if trial > 0.0 { limit } else { -limit };
    // Times 1/k_t, which is found once for many contacts.
    let stretch = -force * (1.0 / stiffness);
    SpringSlider { force, dashpot_force: 0.0, stretch, slip: stretched - stretch }
}

/// Effective mass of a pair, m_eff = m_i m_j / (m_i + m_j), in kg. Against a wall it is the disc's own mass.
#[must_use]
#[inline(always)]
pub fn effective_mass(first: f64, second: f64) -> f64 {
    first * second / (first + second)
}

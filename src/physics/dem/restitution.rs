//! One collision in closed form: restitution, duration and maximal overlap by the damping ratio.
//!
//! A contact is a damped oscillator of the overlap, with w0 = sqrt(k/m_eff), b = eta/(2 m_eff), zeta = b/w0 and
//! w = sqrt(w0^2 - b^2). Schwager and Pöschel, Granular Matter 9 (2007) 465; Schäfer, Dippel and Wolf,
//! J. Phys. I France 6 (1996) 5.

use std::f64::consts::PI;

/// Coefficient of restitution e of a collision with damping ratio zeta >= 0.
///
/// - Attractive tail: e = exp(-pi b/w), the discs part after half a period; 0 from zeta = 1 on, because they never part.
/// - Clamped: the contact ends where the force would turn attractive, e = exp(-2 (b/w) acos(zeta)). This is the source's
///   exp{-(b/w) [pi - atan(2 b w / (w^2 - b^2))]} below zeta = 1/sqrt 2 and exp{-(b/w) atan(2 b w / (b^2 - w^2))} above,
///   for (b + i w)^2 = b^2 - w^2 + 2 i b w has the angle 2 acos(zeta); e^-2 at zeta = 1, 1/(4 zeta^2) far above.
#[must_use]
pub fn restitution(damping_ratio: f64, tail: bool) -> f64 {
    match tail {
        false if damping_ratio >= 1.0 => 0.0,
        false => libm::exp(-PI * damping_ratio / damped_frequency_ratio(damping_ratio)),
        true => libm::exp(-2.0 * damping_ratio * phase_at_turn(damping_ratio)),
    }
}

/// The damping ratio zeta that gives the restitution e in (0, 1]: the inverse of [`restitution`].
///
/// With the attractive tail zeta = -ln e / sqrt(pi^2 + ln^2 e); clamped by bisection, to the last bit.
#[must_use]
pub fn damping_ratio(wanted: f64, tail: bool) -> f64 {
    match tail {
        false => {
            let logarithm = libm::log(wanted);
            (0.0 - logarithm) / (PI * PI + logarithm * logarithm).sqrt()
        }
        true => bisect_clamped(wanted),
    }
}

/// Zeta with the clamped tail; the restitution decreases monotonically with it.
fn bisect_clamped(wanted: f64) -> f64 {
    if wanted >= 1.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while restitution(high, true) > wanted {
        (low, high) = (high, 2.0 * high);
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if restitution(middle, true) > wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// Damping eta = 2 zeta sqrt(k m_eff), in N s/m.
#[must_use]
#[inline(always)]
pub fn damping(damping_ratio: f64, stiffness: f64, effective_mass: f64) -> f64 {
    2.0 * damping_ratio * (stiffness * effective_mass).sqrt()
}

/// Duration of a collision, in s: pi/w with the attractive tail (`None` from zeta = 1 on, because it never ends),
/// 2 acos(zeta)/w until a clamped force ends. `natural_frequency` is w0 in rad/s.
#[must_use]
pub fn contact_duration(damping_ratio: f64, natural_frequency: f64, tail: bool) -> Option<f64> {
    match tail {
        false if damping_ratio >= 1.0 => None,
        false => Some(PI / (natural_frequency * damped_frequency_ratio(damping_ratio))),
        true => Some(2.0 * phase_at_turn(damping_ratio) / natural_frequency),
    }
}

/// Maximal overlap of a collision at `speed`, in m: (v/w0) exp[-(b/w) acos(zeta)], without gravity, for either tail.
#[must_use]
pub fn max_overlap(speed: f64, damping_ratio: f64, natural_frequency: f64) -> f64 {
    speed / natural_frequency * libm::exp(-damping_ratio * phase_at_turn(damping_ratio))
}

/// w/w0 = sqrt(1 - zeta^2), for zeta <= 1.
fn damped_frequency_ratio(damping_ratio: f64) -> f64 {
    ((1.0 - damping_ratio) * (1.0 + damping_ratio)).sqrt()
}

/// w0 times the time from the first contact to the maximal overlap: acos(zeta) / sqrt(1 - zeta^2) below critical damping, 1 at
/// it, acosh(zeta) / sqrt(zeta^2 - 1) above.
fn phase_at_turn(damping_ratio: f64) -> f64 {
    if damping_ratio < 1.0 {
        let root = damped_frequency_ratio(damping_ratio);
        libm::atan2(root, damping_ratio) / root
    } else if damping_ratio > 1.0 {
        // Factor by factor: the square of a huge ratio would overflow.
        let root = (damping_ratio - 1.0).sqrt() * (damping_ratio + 1.0).sqrt();
        libm::log1p(damping_ratio - 1.0 + root) / root
    } else {
        1.0
    }
}

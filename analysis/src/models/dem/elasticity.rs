//! The elastic force of a disc's contact with a wall, by the law of the manifest.

use super::contact_constants;
use kinetoscope_manifest::model::{DemConfig, Elasticity};

/// k of f = k delta, N/m, or 4/3 E* of Hertz's law, Pa: f = 4/3 E* sqrt(r delta) delta (Landau and Lifshitz, Theory of Elasticity,
/// section 9).
#[derive(Clone, Copy, Debug)]
pub(super) enum Elastic {
    Spring(f64),
    Hertz(f64),
}

impl Elastic {
    /// The force of contacts with a stiffness over that of the manifest.
    pub(super) fn of(config: &DemConfig, stiffness_ratio: f64) -> Self {
        match config.elasticity {
            Elasticity::Spring(stiffness) => Self::Spring(stiffness_ratio * stiffness.get()),
            Elasticity::Hertz(modulus) => {
                let modulus = config.effective_modulus_pa(modulus);
                Self::Hertz(stiffness_ratio * (4.0 / 3.0 * modulus))
            }
        }
    }

    /// The force of contacts with the walls; `None` if it depends on the material.
    pub(super) fn of_walls(config: &DemConfig) -> Option<Self> {
        Some(Self::of(config, contact_constants::with_walls(config, |pair| Some(pair.stiffness))?))
    }

    /// Stiffness of a linear spring, N/m.
    pub(super) fn spring_n_per_m(self) -> Option<f64> {
        match self {
            Self::Spring(stiffness) => Some(stiffness),
            Self::Hertz(_) => None,
        }
    }

    /// The constant of the law.
    pub(super) fn factor(self) -> f64 {
        let (Self::Spring(factor) | Self::Hertz(factor)) = self;
        factor
    }

    /// The force of an overlap, m, of a disc with a radius, m, over the factor.
    pub(super) fn force_over_factor(self, overlap: f64, radius: f64) -> f64 {
        match self {
            Self::Spring(_) => overlap,
            Self::Hertz(_) => (radius * overlap).sqrt() * overlap,
        }
    }

    /// Overlap, m, at which a disc's force is the given one, N.
    pub(super) fn overlap_m(self, force: f64, radius: f64) -> f64 {
        match self {
            Self::Spring(stiffness) => force / stiffness,
            Self::Hertz(modulus) => {
                let root = libm::cbrt(force / (modulus * radius.sqrt()));
                root * root
            }
        }
    }

    /// Elastic energy, J, at which a disc's force is the given one, N: f delta/2, or 2/5 f delta.
    pub(super) fn energy_j(self, force: f64, radius: f64) -> f64 {
        let fraction = if let Self::Spring(_) = self { 0.5 } else { 0.4 };
        fraction * force * self.overlap_m(force, radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Source: f = 4/3 E* sqrt(r) delta^(3/2) and 8/15 E* sqrt(r) delta^(5/2) for E* = 3/4 Pa, r = 4 m, delta = 0.25 m: 0.25 N and 0.025 J.
    /// Control: a linear spring with the same force has other energy.
    #[test]
    fn overlap_and_energy_follow_from_the_force() {
        let hertz = Elastic::Hertz(1.0);
        let force = hertz.factor() * hertz.force_over_factor(0.25, 4.0);
        assert!((force - 0.25).abs() < 1e-15, "{force}");
        assert!((hertz.overlap_m(force, 4.0) - 0.25).abs() < 1e-15);
        assert!((hertz.energy_j(force, 4.0) - 0.025).abs() < 1e-16);
        assert!((Elastic::Spring(1.0).energy_j(force, 4.0) - 0.025).abs() > 1e-3, "control");
    }
}

//! A further contact law of discs: a cone in a plane (Sneddon, Int. J. Engng Sci. 3 (1965) 47), run by the one kernel.

use super::Edit;

pub(super) const EDITS: &[Edit] = &[
    (
        "src/manifest/model/dem/mod.rs",
        "\n        elasticity: Elasticity [group] = Elasticity::Spring(Positive::literal(5e4)),",
        "\n        /// Modulus kappa of a cone's contact, whose largest stiffness is then `stiffness_n_per_m`.\
         \n        cone_modulus_pa: Option<Positive> [\"Pa\", optional],",
    ),
    ("src/physics/dem/laws/mod.rs", "\nmod linear_spring;", "\nmod cone;"),
    (
        "src/physics/dem/laws/mod.rs",
        "\nuse kinetoscope_manifest::model::{DemConfig, Elasticity};",
        "\nuse cone::Cone;",
    ),
    ("src/physics/dem/laws/mod.rs", "\n    LinearSpring,", "\n    Cone,"),
    (
        "src/physics/dem/laws/mod.rs",
        "\n    pub(super) fn of(config: &DemConfig, softest: f64) -> Self {",
        "\n        if let (Some(modulus), Elasticity::Spring(k)) = (config.cone_modulus_pa, config.elasticity) {\
         \n            return Self::Cone(Cone::new(modulus.get(), k.get()));\
         \n        }",
    ),
];

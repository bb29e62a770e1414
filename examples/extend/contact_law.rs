//! A further contact law of discs: elastic spheres (Landau and Lifshitz, Theory of Elasticity, section 9), run by the one kernel.

use super::Edit;

pub(super) const EDITS: &[Edit] = &[
    (
        "src/manifest/model/dem/mod.rs",
        "\n        stiffness_n_per_m: Positive [\"N/m\"] = Positive::literal(5e4),",
        "\n        /// Modulus kappa of Hertz's contact, whose largest stiffness is then `stiffness_n_per_m`.\
         \n        hertz_modulus: Option<Positive> [\"N/m^(3/2)\", optional],",
    ),
    ("src/physics/dem/laws/mod.rs", "\nmod linear_spring;", "\nmod hertz_contact;"),
    (
        "src/physics/dem/laws/mod.rs",
        "\nuse kinetoscope_manifest::model::DemConfig;",
        "\nuse hertz_contact::HertzContact;",
    ),
    ("src/physics/dem/laws/mod.rs", "\n    LinearSpring,", "\n    HertzContact,"),
    (
        "src/physics/dem/laws/mod.rs",
        "\n    pub(super) fn of(config: &DemConfig) -> Self {",
        "\n        if let Some(modulus) = config.hertz_modulus {\
         \n            let stiffness = config.stiffness_n_per_m.get();\
         \n            return Self::HertzContact(HertzContact::new(modulus.get(), stiffness));\
         \n        }",
    ),
];

//! A fifth model, a body on a spring: a folder each in physics, in the analysis and in the manifest (its table and its starter), and
//! an experiment.

use super::Edit;

pub(super) const EDITS: &[Edit] = &[
    ("src/manifest/model/mod.rs", "\nmod orbit;", "\nmod oscillator;"),
    ("src/manifest/model/mod.rs", "\npub use orbit::*;", "\npub use oscillator::*;"),
    (
        "src/manifest/model/mod.rs",
        "\n        state discs walls legend velocity trail energy orbit conserved closest_approach log\n    ],",
        "\n    /// A body on a spring.\n    oscillator: Oscillator(OscillatorConfig) every every_s [\
         \n        state discs walls legend velocity trail energy log\n    ],",
    ),
    ("src/physics/lib.rs", "\npub mod orbit;", "\npub mod oscillator;"),
    (
        "src/physics/lib.rs",
        "\n    Orbit => orbit::Orbit,",
        "\n    Oscillator => oscillator::Oscillator,",
    ),
    (
        "src/recording/channels.rs",
        "\nchannels! {",
        "\n    /// Oscillator: energy per unit mass.\n    OscillatorEnergy on \"/energy\" {\
         \n        /// v^2/2 + omega^2 x^2/2, J/kg.\n        specific_energy_j_per_kg: f64 [double] = \"1\",\n    }\n",
    ),
    ("analysis/src/models/mod.rs", "\nmod orbit;", "\nmod oscillator;"),
    ("analysis/src/models/mod.rs", "\n    Orbit => orbit,", "\n    Oscillator => oscillator,"),
];

//! A further metric of orbits: the largest speed, with its law.

use super::Edit;

pub(super) const EDITS: &[Edit] = &[
    (
        "analysis/src/models/orbit/laws.rs",
        "\nlaws! {",
        "\n    MAX_SPEED: \"sqrt(GM/a (1 + ε)/(1 - ε)), at the perihelion\", \"conservation of energy\";",
    ),
    (
        "analysis/src/models/orbit/metrics.rs",
        "\ndefinitions! {",
        "\n    MAX_SPEED: \"speed.max\", \"AU/d\", \"largest speed\", \"/state: largest |v| of the frames\", [law::MAX_SPEED], 0.0;",
    ),
    ("analysis/src/models/orbit/observe.rs", "\n    frames: u64,", "\n    max_speed: f64,"),
    (
        "analysis/src/models/orbit/observe.rs",
        "\n        self.points.add(point);",
        "\n        self.max_speed = max_or_nan(self.max_speed, norm(velocity));",
    ),
    (
        "analysis/src/models/orbit/observe.rs",
        "\n        self.measure_path(last, found);",
        "\n        let theory = self.exact.map(|orbit| {\
         \n            let circular = orbit.mean_motion_rad_per_day * orbit.semi_major_axis_au;\
         \n            circular * ((1.0 + orbit.eccentricity()) / (1.0 - orbit.eccentricity())).sqrt()\
         \n        });\
         \n        found.compare(metric::MAX_SPEED, self.max_speed, theory);",
    ),
];

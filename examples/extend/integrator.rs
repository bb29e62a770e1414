//! A further integrator of orbits: Ruth's symplectic method of order 3 (Ruth, IEEE Trans. Nucl. Sci. 30 (1983) 2669).

use super::Edit;

pub(super) const EDITS: &[Edit] = &[
    (
        "src/manifest/model/orbit/integrator.rs",
        "\n        Yoshida4 = \"yoshida4\",",
        "\n        /// Ruth's third-order symplectic composition.\n        Ruth3 = \"ruth3\",",
    ),
    (
        "src/manifest/model/orbit/integrator.rs",
        "\n            Self::Yoshida4 => of_order(4.0, true),",
        "\n            Self::Ruth3 => of_order(3.0, true),",
    ),
    ("src/physics/orbit/integrators.rs", "\n    Yoshida4: YOSHIDA_4,", "\n    Ruth3: RUTH_3,"),
    (
        "src/physics/orbit/integrators.rs",
        "\nconst CUBE_ROOT_OF_2: f64 = 1.259_921_049_894_873_2;\n",
        "\n/// Ruth's symplectic method, order 3 (Ruth, IEEE Trans. Nucl. Sci. 30 (1983) 2669).\
         \npub const RUTH_3: Splitting<6> = Splitting([\
         \n    Kick(7.0 / 24.0),\
         \n    Drift(2.0 / 3.0),\
         \n    Kick(3.0 / 4.0),\
         \n    Drift(-2.0 / 3.0),\
         \n    Kick(-1.0 / 24.0),\
         \n    Drift(1.0),\
         \n]);\n",
    ),
];

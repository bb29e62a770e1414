//! Materials of DEM's discs, and the constants of pairs of them.

use crate::inline::inline_table;
use crate::keys::Reader;
use crate::quantity::{Fraction, NonNegative, Positive};

inline_table! {
    /// What some of the discs are made of. Constants that are left out are those of `[model.dem]`.
    pub struct DemMaterial = "a table { name, fraction, density_ratio, restitution, … }" with DemMaterial::rules {
        /// Its name, for `contact_pairs`; neither `wall` nor empty.
        name: String [required],
        /// Its fraction of the discs, relative to the sum of all fractions: each disc's material is drawn.
        fraction: Positive [or Positive::literal(1.0)],
        /// Its areal density over that of a disc of the mean radius with the manifest's mass.
        density_ratio: Positive [or Positive::literal(1.0)],
        /// Constants of contacts between two discs of it.
        constants: DemContactConstants [flatten],
    }
}

inline_table! {
    /// Constants of the contacts between two materials, or of one with the walls.
    pub struct DemContactPair = "a table { between = [\"…\", \"…\"], restitution, … }" {
        /// Names of the two: of materials, or `wall`.
        between: [String; 2] [required],
        /// The constants.
        constants: DemContactConstants [flatten],
    }
}

inline_table! {
    /// Constants of a contact, as far as they are given.
    #[derive(Copy, Default)]
    pub struct DemContactConstants = "a table { restitution, friction, rolling_friction, stiffness_ratio, cohesion_n }" {
        /// Coefficient of restitution e.
        restitution: Option<Fraction> [optional],
        /// Coefficient of friction mu.
        friction: Option<NonNegative> [optional],
        /// Coefficient of rolling friction mu_r.
        rolling_friction: Option<NonNegative> [optional],
        /// Stiffness of the contact, or Young's modulus, over that of the manifest.
        stiffness_ratio: Option<Positive> [optional],
        /// Attraction F_c during the contact, N.
        cohesion_n: Option<NonNegative> [optional],
    }
}

/// What `between` calls the walls.
pub const WALL: &str = "wall";
/// What `between` calls the discs where no materials are named.
pub const DISC: &str = "disc";
/// Maximum number of materials in a run.
pub(super) const MOST_MATERIALS: usize = 8;

impl DemMaterial {
    fn rules(&self, _name: &str, reader: &mut Reader<'_>) {
        if self.name.is_empty() || self.name == WALL {
            reader.refuse(
                &["name"],
                "a material cannot have this name",
                "must not be empty or \"wall\"",
            );
        }
    }
}

//! The rules between the keys of a DEM scene: sizes, walls, regions, materials, insertion.

use super::materials::{DISC, DemContactConstants, MOST_MATERIALS, WALL};
use super::radius::MOST_RADIUS_RATIO;
use super::walls::{DemWall, DemWallShape};
use super::{DemConfig, DemDashpot, Dissipation, Elasticity};
use crate::keys::{Reader, rules};
use crate::model::start::Placement;
use crate::quantity::Finite;

impl DemConfig {
    /// Reports discs that do not fit into the box, and radii that differ too much.
    pub(super) fn check_sizes(&self, table: &mut Reader<'_>) {
        let (smallest, radius) = self.radius_m.range();
        let ([width, height], ratio) = (self.sides(), radius / smallest);
        rules! { table;
            2.0 * radius >= width || 2.0 * radius >= height => ["radius_m", "width_m", "height_m"]
                "a disc of radius {radius:?} m does not fit into a box of {width:?} m x {height:?} m",
                "the radius must be below half of the shorter side";
            smallest * MOST_RADIUS_RATIO < radius * (1.0 - 1e-12) => ["radius_m"]
                "the largest radius is {ratio:.1} times the smallest", "must be at most 10 times";
        }
    }

    /// Reports a scene that cannot be set up.
    pub(super) fn check_scene(&self, table: &mut Reader<'_>) {
        self.check_integrator(table);
        self.check_elasticity(table);
        self.check_box(table);
        for wall in &self.walls {
            rules! { table;
                !self.contains(wall) => ["walls", "width_m", "height_m"]
                    "a wall reaches outside the box",
                    "walls must begin within the box: an outlet cannot be wider than its hopper";
            }
        }
        self.check_materials(table);
        self.check_insertion(table);
        let is_drawn = matches!(self.placement, Placement::Random | Placement::Lattice);
        rules! { table;
            !is_drawn && self.velocity_std_m_per_s.is_some() => ["velocity_std_m_per_s", "placement"]
                "`velocity_std_m_per_s` cannot be used with a given or recorded start", "remove one of them";
        }
    }

    fn sides(&self) -> [f64; 2] {
        [self.width_m.get(), self.height_m.get()]
    }

    fn check_integrator(&self, table: &mut Reader<'_>) {
        rules! { table;
            self.dashpot == DemDashpot::Implicit && !self.may_be_implicit() =>
                ["dashpot", "friction", "rolling_friction", "cohesion_n", "materials", "contact_pairs", "walls"]
                "the implicit dashpot supports neither friction nor moving walls nor cohesion",
                "set dashpot to \"explicit\"";
        }
    }

    fn check_elasticity(&self, table: &mut Reader<'_>) {
        let is_hertz = matches!(self.elasticity, Elasticity::Hertz(_));
        rules! { table;
            !is_hertz && self.poisson_ratio.is_some() => ["poisson_ratio", "stiffness_n_per_m"]
                "`poisson_ratio` needs `youngs_modulus_pa`", "give `youngs_modulus_pa` in place of `stiffness_n_per_m`";
            !is_hertz && self.has_mindlin_springs() => ["tangential_law", "stiffness_n_per_m"]
                "`tangential_law` needs `youngs_modulus_pa`", "give `youngs_modulus_pa` in place of `stiffness_n_per_m`";
            is_hertz && matches!(self.dissipation, Dissipation::Damping(_)) => ["damping_n_s_per_m", "youngs_modulus_pa"]
                "`damping_n_s_per_m` cannot be used with `youngs_modulus_pa`",
                "replace `damping_n_s_per_m` with `restitution`, from which the dashpots of Hertz's law follow";
        }
    }

    fn check_box(&self, table: &mut Reader<'_>) {
        // Neighbors across a periodic side must not be neighbors within the box as well.
        let least = 12.0 * self.radius_m.range().1;
        let is_short = |axis: usize| self.periodic.axes()[axis] && self.sides()[axis] < least;
        let is_outside = |[low, high]: [[Finite; 2]; 2]| {
            let is_inside = |at: [Finite; 2]| self.is_inside(at.map(Finite::get));
            !is_inside(low) || !is_inside(high) || low[0] >= high[0] || low[1] >= high[1]
        };
        rules! { table;
            is_short(0) || is_short(1) => ["periodic", "width_m", "height_m", "radius_m"]
                "the periodic box is too small for its discs",
                "a periodic side must be at least 12 of the largest radii long";
            self.placement_region_m.is_some_and(is_outside) => ["placement_region_m", "width_m", "height_m"]
                "`placement_region_m` is not a rectangle within the box",
                "its corners, lower left first, must lie within the box";
        }
    }

    fn is_inside(&self, [x, y]: [f64; 2]) -> bool {
        let [width, height] = self.sides();
        (0.0..=width).contains(&x) && (0.0..=height).contains(&y)
    }

    /// Whether any contact has friction or rolling friction.
    #[must_use]
    pub fn has_friction(&self) -> bool {
        let given = self.given_constants().flat_map(|own| [own.friction, own.rolling_friction]);
        let common = [self.friction, self.rolling_friction];
        given.flatten().chain(common).any(|coefficient| coefficient.get() > 0.0)
    }

    /// Whether the dashpot may be implicit.
    #[must_use]
    pub fn may_be_implicit(&self) -> bool {
        let moves = self.walls.iter().any(|wall| !wall.is_at_rest());
        !(moves || self.has_friction() || self.has_cohesion())
    }

    /// Whether a material or a pair of materials has its own restitution.
    #[must_use]
    pub fn has_own_restitution(&self) -> bool {
        self.given_constants().any(|own| own.restitution.is_some())
    }

    /// Whether any cohesion is given.
    #[must_use]
    pub fn has_cohesion(&self) -> bool {
        let given = self.given_constants().filter_map(|own| own.cohesion_n);
        given.chain([self.cohesion_n]).any(|force| force.get() > 0.0)
    }

    /// The constants that the materials and the pairs of materials give.
    fn given_constants(&self) -> impl Iterator<Item = DemContactConstants> {
        let materials = self.materials.iter().map(|material| material.constants);
        materials.chain(self.contact_pairs.iter().map(|pair| pair.constants))
    }

    fn check_materials(&self, table: &mut Reader<'_>) {
        let names: Vec<&str> = self.materials.iter().map(|material| &*material.name).collect();
        let count = names.len();
        rules! { table;
            count > MOST_MATERIALS => ["materials"] "there are {count} materials", "must be at most {MOST_MATERIALS}";
        }
        let is_repeated = |(index, name): &(usize, &&str)| names[..*index].contains(name);
        if let Some((_, name)) = names.iter().enumerate().find(is_repeated) {
            let title = format!("material {name:?} is listed twice");
            table.refuse(&["materials"], title, "each material needs a name of its own");
        }
        let known = if names.is_empty() { vec![DISC] } else { names };
        let mut seen: Vec<[&str; 2]> = Vec::new();
        for pair in &self.contact_pairs {
            let [one, other] = [&*pair.between[0], &*pair.between[1]];
            let unknown =
                [one, other].into_iter().find(|name| *name != WALL && !known.contains(name));
            if let Some(name) = unknown {
                let label = format!("known: {}, {WALL}", known.join(", "));
                table.refuse(&["contact_pairs"], format!("unknown material {name:?}"), label);
            } else if one == WALL && other == WALL {
                let title = "walls do not touch each other";
                table.refuse(&["contact_pairs"], title, "one of the two must be a material");
            } else if seen.contains(&[one, other]) || seen.contains(&[other, one]) {
                let title = format!("the pair of {one:?} and {other:?} is listed twice");
                table.refuse(&["contact_pairs"], title, "keep one of them");
            }
            seen.push([one, other]);
        }
        rules! { table;
            self.has_own_restitution() && matches!(self.dissipation, Dissipation::Damping(_)) =>
                ["damping_n_s_per_m", "materials", "contact_pairs"]
                "`damping_n_s_per_m` cannot be used together with a restitution per material",
                "replace damping_n_s_per_m with restitution";
        }
    }

    fn check_insertion(&self, table: &mut Reader<'_>) {
        let Some(insertion) = &self.insertion else { return };
        let largest_radius = self.radius_m.range().1;
        let has_room = |end: [Finite; 2]| {
            let room = self.sides().map(|side| largest_radius..=side - largest_radius);
            room.iter().zip(end).all(|(room, at)| room.contains(&at.get()))
        };
        rules! { table;
            !has_room(insertion.from_m) || !has_room(insertion.to_m) => ["insertion", "width_m", "height_m", "radius_m"]
                "discs would enter outside the box",
                "the line from from_m to to_m must keep the largest radius off the box's sides";
            self.discs.checked_add(insertion.discs.get()).is_none() => ["insertion", "discs"]
                "there are too many discs", "must be at most 2^32 - 1 in total";
        }
    }

    /// Whether a wall is within the box at the start.
    fn contains(&self, wall: &DemWall) -> bool {
        match wall.shape {
            DemWallShape::Segment { from_m, to_m } => {
                [from_m, to_m].iter().all(|end| self.is_inside(end.map(Finite::get)))
            }
            DemWallShape::Drum { center_m, radius_m, .. } => {
                let (center, radius) = (center_m.map(Finite::get), radius_m.get());
                let slack = 1e-9 * radius;
                self.is_inside(center.map(|x| x - radius + slack))
                    && self.is_inside(center.map(|x| x + radius - slack))
            }
        }
    }
}

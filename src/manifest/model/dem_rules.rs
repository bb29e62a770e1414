//! The rules between the keys of a DEM scene: sizes, walls, regions, materials, insertion.

use super::dem::{DemConfig, DemDashpot, Dissipation, PeriodicSides};
use super::dem_materials::{DISC, MOST_MATERIALS, WALL};
use super::dem_radius::MOST_RADIUS_RATIO;
use super::dem_walls::{DemWall, DemWallShape};
use super::placement::Placement;
use crate::keys::Reader;
use crate::quantity::Finite;

impl DemConfig {
    /// Reports discs that do not fit into the box, or radii that differ too much.
    pub(super) fn check_sizes(&self, table: &mut Reader<'_>) {
        let (smallest, radius) = self.radius_m.range();
        let (width, height) = (self.width_m.get(), self.height_m.get());
        if 2.0 * radius >= width || 2.0 * radius >= height {
            let title = format!(
                "a disc of radius {radius:?} m does not fit into a box of {width:?} m x {height:?} m"
            );
            table.refuse(
                &["radius_m", "width_m", "height_m"],
                &title,
                "the radius must be below half of the shorter side",
            );
        }
        if smallest * MOST_RADIUS_RATIO < radius * (1.0 - 1e-12) {
            table.refuse(
                &["radius_m"],
                &format!("the largest radius is {:.1} times the smallest", radius / smallest),
                "must be at most 10 times",
            );
        }
    }

    /// Reports a scene that cannot be set up.
    pub(super) fn check_scene(&self, table: &mut Reader<'_>) {
        self.check_integrator(table);
        self.check_periodic_sides(table);
        self.check_region(table);
        for wall in &self.walls {
            self.check_wall(wall, table);
        }
        self.check_materials(table);
        self.check_insertion(table);
        let is_drawn = matches!(self.placement, Placement::Random | Placement::Lattice);
        if !is_drawn && self.velocity_std_m_per_s.is_some() {
            table.refuse(
                &["velocity_std_m_per_s", "placement"],
                "`velocity_std_m_per_s` cannot be used with a given or recorded start",
                "remove one of them",
            );
        }
    }

    fn check_integrator(&self, table: &mut Reader<'_>) {
        if self.dashpot == DemDashpot::Explicit {
            return;
        }
        let moves = self.walls.iter().any(|wall| !wall.is_at_rest());
        if moves || self.rubs() {
            table.refuse(
                &["dashpot", "friction", "rolling_friction", "materials", "contact_pairs", "walls"],
                "the implicit dashpot supports neither friction nor moving walls",
                "set dashpot to \"explicit\"",
            );
        }
    }

    fn check_periodic_sides(&self, table: &mut Reader<'_>) {
        // Neighbors across a periodic side must not be neighbors within the box as well.
        let least = 12.0 * self.radius_m.range().1;
        let (width, height) = (self.width_m.get(), self.height_m.get());
        let (x, y) = match self.periodic {
            PeriodicSides::None => (false, false),
            PeriodicSides::X => (true, false),
            PeriodicSides::Y => (false, true),
            PeriodicSides::Both => (true, true),
        };
        if (x && width < least) || (y && height < least) {
            table.refuse(
                &["periodic", "width_m", "height_m", "radius_m"],
                "the periodic box is too small for its discs",
                "a periodic side must be at least 12 of the largest radii long",
            );
        }
    }

    fn check_region(&self, table: &mut Reader<'_>) {
        let (width, height) = (self.width_m.get(), self.height_m.get());
        if let Some([low, high]) = self.placement_region_m {
            let is_inside = |at: [Finite; 2]| {
                (0.0..=width).contains(&at[0].get()) && (0.0..=height).contains(&at[1].get())
            };
            if !is_inside(low) || !is_inside(high) || low[0] >= high[0] || low[1] >= high[1] {
                table.refuse(
                    &["placement_region_m", "width_m", "height_m"],
                    "`placement_region_m` is not a rectangle within the box",
                    "its corners, lower left first, must lie within the box",
                );
            }
        }
    }

    /// Whether any contact has friction or rolling friction.
    fn rubs(&self) -> bool {
        let materials = self.materials.iter().map(|material| material.constants);
        let pairs = self.contact_pairs.iter().map(|pair| pair.constants);
        let given = materials.chain(pairs).flat_map(|own| [own.friction, own.rolling_friction]);
        let common = [self.friction, self.rolling_friction];
        given.flatten().chain(common).any(|coefficient| coefficient.get() > 0.0)
    }

    fn check_materials(&self, table: &mut Reader<'_>) {
        let names: Vec<&str> = self.materials.iter().map(|material| &*material.name).collect();
        if names.len() > MOST_MATERIALS {
            let title = format!("there are {} materials", names.len());
            table.refuse(&["materials"], &title, &format!("must be at most {MOST_MATERIALS}"));
        }
        let is_repeated = |(index, name): &(usize, &&str)| names[..*index].contains(name);
        if let Some((_, name)) = names.iter().enumerate().find(is_repeated) {
            let title = format!("material {name:?} is listed twice");
            table.refuse(&["materials"], &title, "each material needs a name of its own");
        }
        let known = if names.is_empty() { vec![DISC] } else { names };
        let mut seen: Vec<[&str; 2]> = Vec::new();
        for pair in &self.contact_pairs {
            let [one, other] = [&*pair.between[0], &*pair.between[1]];
            let unknown =
                [one, other].into_iter().find(|name| *name != WALL && !known.contains(name));
            if let Some(name) = unknown {
                let label = format!("known: {}, {WALL}", known.join(", "));
                let title = format!("unknown material {name:?}");
                table.refuse(&["contact_pairs"], &title, &label);
            } else if one == WALL && other == WALL {
                let title = "walls do not touch each other";
                table.refuse(&["contact_pairs"], title, "one of the two must be a material");
            } else if seen.contains(&[one, other]) || seen.contains(&[other, one]) {
                let title = format!("the pair of {one:?} and {other:?} is listed twice");
                table.refuse(&["contact_pairs"], &title, "keep one of them");
            }
            seen.push([one, other]);
        }
        let materials = self.materials.iter().map(|material| material.constants);
        let pairs = self.contact_pairs.iter().map(|pair| pair.constants);
        let wants_restitution = materials.chain(pairs).any(|own| own.restitution.is_some());
        if wants_restitution && matches!(self.dissipation, Dissipation::Damping(_)) {
            table.refuse(
                &["damping_n_s_per_m", "materials", "contact_pairs"],
                "`damping_n_s_per_m` cannot be used together with a restitution per material",
                "replace damping_n_s_per_m with restitution",
            );
        }
    }

    fn check_insertion(&self, table: &mut Reader<'_>) {
        let Some(insertion) = &self.insertion else { return };
        let largest_radius = self.radius_m.range().1;
        let sides = [self.width_m.get(), self.height_m.get()];
        let has_room = |end: [Finite; 2]| {
            let fits = |axis: usize| {
                let at = end[axis].get();
                at >= largest_radius && at <= sides[axis] - largest_radius
            };
            fits(0) && fits(1)
        };
        if !has_room(insertion.from_m) || !has_room(insertion.to_m) {
            table.refuse(
                &["insertion", "width_m", "height_m", "radius_m"],
                "discs would enter outside the box",
                "the line from from_m to to_m must keep the largest radius off the box's sides",
            );
        }
        if self.discs.checked_add(insertion.discs.get()).is_none() {
            table.refuse(
                &["insertion", "discs"],
                "there are too many discs",
                "must be at most 2^32 - 1 in total",
            );
        }
    }

    fn check_wall(&self, wall: &DemWall, table: &mut Reader<'_>) {
        let (width, height) = (self.width_m.get(), self.height_m.get());
        let is_inside = |x: f64, y: f64| (0.0..=width).contains(&x) && (0.0..=height).contains(&y);
        let fits = match wall.shape {
            DemWallShape::Segment { from_m, to_m } => {
                [from_m, to_m].iter().all(|end| is_inside(end[0].get(), end[1].get()))
            }
            DemWallShape::Drum { center_m, radius_m, .. } => {
                let ([x, y], r) = (center_m.map(Finite::get), radius_m.get());
                let slack = 1e-9 * r;
                is_inside(x - r + slack, y - r + slack) && is_inside(x + r - slack, y + r - slack)
            }
        };
        if !fits {
            table.refuse(
                &["walls", "width_m", "height_m"],
                "a wall reaches outside the box",
                "walls must begin within the box: an outlet cannot be wider than its hopper",
            );
        }
    }
}

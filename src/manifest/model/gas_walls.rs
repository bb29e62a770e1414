//! `[model.gas]`: keys of a wall that does more than mirror, and of particles that meet one another.

use super::gas::{GasConfig, PlaceDistribution, Propagation};
use crate::keys::{Keys, Reader};
use crate::quantity::{Finite, Positive, Share};

/// A wall with a temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThermalWall {
    /// Temperature of the wall, K, by the mean square.
    pub temperature_k: Positive,
    /// Share of the hits after which a particle leaves with the wall's temperature; the others are mirrored.
    pub accommodation: Share,
}

impl GasConfig {
    pub(super) fn wall_keys(&mut self, keys: &mut impl Keys) {
        let moving = (self.wall_speed_m_per_s.get() != 0.0).then_some(self.wall_speed_m_per_s);
        self.wall_speed_m_per_s = keys
            .optional(
                "wall_speed_m_per_s",
                "m/s",
                "Speed at which the radius grows (above 0) or shrinks (below): a piston. Needs exact propagation.",
                moving,
            )
            .unwrap_or(const { Finite::literal(0.0) });
        let temperature = keys.optional(
            "wall_temperature_k",
            "K",
            "Temperature of a wall that gives particles back with Maxwell's velocities. Needs exact propagation.",
            self.thermal_wall.map(|wall| wall.temperature_k),
        );
        let accommodation = keys.optional(
            "wall_accommodation",
            "1",
            "Share of the hits after which a particle leaves with the wall's temperature, the others being \
            mirrored; 1 where it is left out. Needs `wall_temperature_k`.",
            self.thermal_wall.map(|wall| wall.accommodation),
        );
        self.thermal_wall = temperature.map(|temperature_k| ThermalWall {
            temperature_k,
            accommodation: accommodation.unwrap_or(const { Share::literal(1.0) }),
        });
        self.opening_width_m = keys.optional(
            "opening_width_m",
            "m",
            "Arc of an opening in the wall about the direction of x, at the start. Needs exact propagation.",
            self.opening_width_m,
        );
    }

    pub(super) fn check_wall(&self, table: &mut Reader<'_>) {
        let exact = self.propagation == Propagation::Exact;
        for key in ["wall_speed_m_per_s", "wall_temperature_k", "opening_width_m"] {
            if table.has(key) && !exact {
                let title = format!("`{key}` needs exact propagation");
                table.refuse(&["propagation", key], &title, "set propagation to \"exact\"");
            }
        }
        if table.has("temperature_schedule")
            && matches!(self.propagation, Propagation::Literal { .. })
        {
            let title = "the scheme as printed has no temperature schedule";
            table.refuse(
                &["propagation", "temperature_schedule"],
                title,
                "set propagation to \"exact\" or \"stepped\"",
            );
        }
        if table.has("wall_accommodation") && !table.has("wall_temperature_k") {
            table.refuse(
                &["wall_accommodation"],
                "a wall without temperature accommodates nothing",
                "add `wall_temperature_k`",
            );
        }
        let rising = self.temperature_schedule.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        if !rising {
            table.refuse(
                &["temperature_schedule"],
                "the times of the schedule do not rise",
                "order the pairs [time, temperature] by time",
            );
        }
        let radius_at_end =
            self.radius_m.get() + self.wall_speed_m_per_s.get() * self.duration_s.get();
        if radius_at_end <= 0.0 {
            table.refuse(
                &["wall_speed_m_per_s", "duration_s"],
                "the wall reaches the center before the run ends",
                "shorten the duration or slow the wall",
            );
        }
        let perimeter = std::f64::consts::TAU * self.radius_m.get();
        if self.opening_width_m.is_some_and(|width| width.get() > perimeter) {
            table.refuse(
                &["opening_width_m", "radius_m"],
                "the opening is wider than the wall is long",
                "must be at most 2 pi radius_m",
            );
        }
    }

    /// The key of particles that meet one another.
    pub(super) fn collision_keys(&mut self, keys: &mut impl Keys) {
        self.disc_radius_m = keys.optional(
            "disc_radius_m",
            "m",
            "Radius of particles that are discs and collide elastically with one another; points, which do not, where it is \
            left out. Needs exact propagation and a plain wall.",
            self.disc_radius_m,
        );
    }

    pub(super) fn check_collisions(&self, table: &mut Reader<'_>) {
        let Some(disc_radius) = self.disc_radius_m.map(|radius| radius.get()) else { return };
        let beside = [
            ("propagation", self.propagation == Propagation::Exact, "set propagation to \"exact\""),
            ("wall_speed_m_per_s", self.wall_speed_m_per_s.get() == 0.0, "remove the wall's speed"),
            ("wall_temperature_k", self.thermal_wall.is_none(), "remove the wall's temperature"),
            ("opening_width_m", self.opening_width_m.is_none(), "remove the opening"),
            (
                "place_distribution",
                self.place_distribution == PlaceDistribution::Area,
                "set place_distribution to \"area\"",
            ),
        ];
        for (key, is_plain, label) in beside {
            if !is_plain {
                let title = format!("discs that collide do not go with this `{key}`");
                table.refuse(&["disc_radius_m", key], &title, label);
            }
        }
        let radius = self.radius_m.get();
        let share = f64::from(self.particles.get()) * disc_radius * disc_radius / (radius * radius);
        if disc_radius >= radius || share > MOST_COVERED {
            let title = format!("the discs would cover {share:.3} of the container");
            let label = format!(
                "must be at most {MOST_COVERED}: fewer or smaller discs, or a larger container"
            );
            table.refuse(&["disc_radius_m", "particles", "radius_m"], &title, &label);
        }
    }
}

/// Share of the container that discs placed at random can cover: random sequential addition jams at 0.547 (Feder, J. Theor. Biol.
/// 87, 237 (1980)), and comes near it ever more slowly.
const MOST_COVERED: f64 = 0.5;

//! `[model.packing]`: rules for gravity, and for a floor that gives the discs energy.

use super::{Boundary, PackingConfig};
use crate::keys::{Reader, rules};
use crate::quantity::Positive;

/// Maximum of gravity times the height of the box, in squares of the thermal speed 1 of random velocities.
const MAX_FALL: f64 = 1e12;

/// Maximum speed of a shaken floor over that of a disc: above, no disc would leave it at once.
const MAX_FLOOR_SPEED: f64 = 1e3;

/// Minimum stroke of a shaken floor over the mean radius.
const MIN_STROKE: f64 = 1e-6;

/// Minimum period of a shaken floor, and gravity above it, so that the periods until a disc falls back can be counted.
const MIN_PERIOD: f64 = 1e-3;
const MIN_GRAVITY: f64 = 1e-6;

/// Range of the temperature of the floor, in those of discs with the thermal speed 1.
const MIN_TEMPERATURE: f64 = 1e-6;
const MAX_TEMPERATURE: f64 = 1e12;

impl PackingConfig {
    /// Rejects gravity without walls, and floors that cannot be used.
    pub(super) fn check_gravity(&self, table: &mut Reader<'_>) {
        let (gravity, height) = (self.gravity.get(), self.height.get());
        let highest = MAX_FALL / height;
        rules! { table;
            gravity > 0.0 && self.boundary == Boundary::Periodic => ["gravity", "boundary"]
                "discs would fall through a periodic box forever", "remove `gravity`, or set boundary to \"walls\"";
            gravity > highest => ["gravity"]
                "`gravity` is {gravity:?}, so that discs fall through the box a million times as fast as they start",
                "must be at most {highest:?}";
        }
        let own = ["floor_temperature", "floor_stroke", "floor_period"];
        for key in own {
            let is_given = table.has(key);
            rules! { table;
                is_given && gravity == 0.0 => [key] "`{key}` needs `gravity`", "add `gravity`, such as 0.1";
                is_given && self.wall_noise_variance_rad2.get() > 0.0 => [key, "wall_noise_variance_rad2"]
                    "`{key}` cannot be used with wall noise", "remove one of them";
            }
        }
        let temperature = self.floor_temperature.map_or(1.0, Positive::get);
        rules! { table;
            !(MIN_TEMPERATURE..=MAX_TEMPERATURE).contains(&temperature) => ["floor_temperature"]
                "`floor_temperature` is {temperature:e}, so that discs are a million times as fast, or a thousandth, as they start",
                "must be in [{MIN_TEMPERATURE:e}, {MAX_TEMPERATURE:e}]";
            table.has("floor_temperature") && self.shaking.is_some() => ["floor_temperature", "floor_stroke"]
                "a shaken floor has no temperature", "remove one of them";
            table.has("floor_stroke") != table.has("floor_period") => ["floor_stroke", "floor_period"]
                "a shaken floor needs `floor_stroke` and `floor_period`", "add the other one";
        }
        let Some(floor) = self.shaking else { return };
        let (stroke, period) = (floor.stroke.get(), floor.period.get());
        let room = height - 2.0 * self.largest_radius();
        let (least, most) = (MIN_STROKE * self.radius.get(), 0.5 * room);
        // Discs have the speed 1 at the start, or fall from the top.
        let speed = 4.0 * stroke / period;
        let fastest = MAX_FLOOR_SPEED * (2.0 + 2.0 * gravity * height).sqrt();
        let shortest = 4.0 * stroke / fastest;
        rules! { table;
            !(least..=most).contains(&stroke) => ["floor_stroke"]
                "`floor_stroke` is {stroke:?}, too small or too large", "must be in [{least:?}, {most:?}], at most half of the height above a disc";
            gravity > 0.0 && gravity < MIN_GRAVITY => ["gravity", "floor_stroke"]
                "`gravity` is {gravity:e}, too weak for a shaken floor", "must be at least {MIN_GRAVITY:e}";
            period < MIN_PERIOD => ["floor_period"]
                "`floor_period` is {period:e}, too short", "must be at least {MIN_PERIOD:e}";
            period >= MIN_PERIOD && speed > fastest => ["floor_period", "floor_stroke"]
                "the floor reaches a speed of {speed:e}, a thousand times that of any disc",
                "the nearest period that works is {shortest:e}";
        }
    }
}

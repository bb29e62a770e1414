//! The motion of a shaken floor on parabolas, for which every contact of a falling disc is the root of a quadratic equation.
//!
//! h(t) = b τ²/2 with τ = t − k P, and between these arcs h(t) = S − b τ²/2 with τ = t − (k + 1/2) P, each for |τ| <= P/4: height and
//! velocity are continuous, and the acceleration is b = 16 S/P² up and down in turn. The floor starts at rest at the bottom of the
//! box. A sine with the same stroke S and period P would have 1.23 times this acceleration at its ends, and no closed form of the
//! contacts.

use super::motion;
use kinetoscope_manifest::model::Shaking as Keys;
use serde::{Deserialize, Serialize};

/// A floor that moves up and down.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Shaking {
    /// Distance between its lowest and its highest position.
    stroke: f64,
    period: f64,
}

/// A parabola of the motion.
struct Arc {
    /// Number of half periods from the start to its middle.
    number: f64,
    middle: f64,
    /// Height of the middle, and the acceleration.
    height: f64,
    acceleration: f64,
}

impl Shaking {
    /// The motion of a manifest.
    pub(super) fn new(keys: Keys) -> Self {
        Self { stroke: keys.stroke.get(), period: keys.period.get() }
    }

    /// Its speed where two arcs meet.
    pub(super) fn greatest_speed(&self) -> f64 {
        4.0 * self.stroke / self.period
    }

    fn arc(&self, number: f64) -> Arc {
        let acceleration = 16.0 * self.stroke / (self.period * self.period);
        let is_lower = number * 0.5 == (number * 0.5).floor();
        Arc {
            number,
            middle: 0.5 * number * self.period,
            height: if is_lower { 0.0 } else { self.stroke },
            acceleration: if is_lower { acceleration } else { -acceleration },
        }
    }

    /// Number of the arc at a time.
    fn number_at(&self, time: f64) -> f64 {
        (2.0 * time / self.period + 0.5).floor()
    }

    /// Height above the bottom of the box and velocity at a time since the start.
    pub(super) fn motion_at(&self, time: f64) -> [f64; 2] {
        self.arc(self.number_at(time)).motion_at(time)
    }

    /// Time from `now` until a disc touches the floor; `None` if it does not before `until`. The flight is the height of its lowest
    /// point above the bottom of the box, its velocity, and gravity.
    pub(super) fn time_to_contact(
        &self,
        now: f64,
        [height, speed, gravity]: [f64; 3],
        until: f64,
    ) -> Option<f64> {
        let mut arc = self.arc(self.number_at(now));
        loop {
            let quarter = 0.25 * self.period;
            let (start, end) = (arc.middle - quarter - now, arc.middle + quarter - now);
            let start = if start > 0.0 { start } else { 0.0 };
            if start > until {
                return None;
            }
            let ([_, y], [_, vy]) = motion::free_fall([0.0, height], [0.0, speed], gravity, start);
            let [floor, floor_speed] = arc.motion_at(now + start);
            let relative = [y - floor, vy - floor_speed, gravity + arc.acceleration];
            let time = start + time_to_approach(relative);
            // Of more periods than can be counted, none follows.
            if time <= end || arc.number + 1.0 == arc.number {
                return Some(time);
            }
            // Above the highest position there is no contact until the disc falls back to it.
            let above = y - self.stroke;
            let back = if above > 0.0 { motion::time_to_fall(above, vy, gravity) } else { 0.0 };
            let (next, at_zone) = (arc.number + 1.0, self.number_at(now + start + back));
            arc = self.arc(if next > at_zone { next } else { at_zone });
        }
    }
}

impl Arc {
    fn motion_at(&self, time: f64) -> [f64; 2] {
        let from_middle = time - self.middle;
        let speed = self.acceleration * from_middle;
        [self.height + 0.5 * speed * from_middle, speed]
    }
}

/// Time until a height h above the floor becomes zero, h + w t − c t²/2 = 0 with the relative velocity w and acceleration −c.
fn time_to_approach([height, speed, acceleration]: [f64; 3]) -> f64 {
    if acceleration > 0.0 {
        motion::time_to_fall(height, speed, acceleration)
    } else {
        motion::time_to_rise(height, -speed, -acceleration)
    }
}

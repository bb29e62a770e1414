//! `[model.packing]`: rules for obstacles.

use super::{MAX_OBSTACLES, PackingConfig, PackingPlacement};
use crate::keys::{Reader, rules};
use std::f64::consts::PI;

impl PackingConfig {
    /// Centers and radius of the obstacles; none with the radius 0.
    #[must_use]
    pub fn obstacles(&self) -> (Vec<[f64; 2]>, f64) {
        let Some(obstacles) = &self.obstacles else { return (Vec::new(), 0.0) };
        let centers = obstacles.positions.iter().map(|center| center.map(|part| part.get()));
        (centers.collect(), obstacles.radius.get())
    }

    /// Rejects obstacles that are too many, too large or outside of the box, and starts that do not avoid them.
    pub(super) fn check_obstacles(&self, table: &mut Reader<'_>) {
        let (centers, radius) = self.obstacles();
        let (count, [x, y]) = (centers.len(), [0.5 * self.width.get(), 0.5 * self.height.get()]);
        let is_outside = |center: &&[f64; 2]| center[0].abs() > x || center[1].abs() > y;
        let outside = centers.iter().find(is_outside).copied().unwrap_or_default();
        let share = count as f64 * PI * radius * radius / (4.0 * x * y);
        let room = 2.0 * self.largest_radius();
        let floor = self.shaking.map_or(-y, |floor| floor.stroke.get() - y);
        let is_low = self.shaking.is_some()
            && centers.iter().any(|center| center[1] - radius < floor + room);
        let avoids =
            !matches!(self.placement, PackingPlacement::Lattice | PackingPlacement::Compressed);
        rules! { table;
            self.obstacles.is_some() && count == 0 => ["obstacles"]
                "`obstacles` has no positions", "add one, or remove `obstacles`";
            count > MAX_OBSTACLES => ["obstacles"]
                "there are {count} obstacles", "must be at most {MAX_OBSTACLES}";
            is_outside(&&outside) => ["obstacles", "width", "height"]
                "the obstacle at {outside:?} is outside of the box", "must have |x| <= {x:?} and |y| <= {y:?}";
            share > 1.0 => ["obstacles", "width", "height"]
                "the area of all obstacles is {share:.3} times that of the box", "must be at most 1: use fewer or smaller obstacles";
            is_low => ["obstacles", "floor_stroke"]
                "the shaken floor would press discs against an obstacle: it rises to y = {floor:?}, and the largest disc needs {room:?} above it",
                "raise the obstacles, or use a smaller `floor_stroke`";
            count > 0 && !avoids => ["obstacles", "placement"]
                "discs on a lattice and compressed discs do not avoid obstacles", "set placement to \"random\" or to positions and velocities";
        }
    }
}

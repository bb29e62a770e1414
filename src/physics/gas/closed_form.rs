//! Exact propagation: every frame is computed from where the paths began in closed form, whatever frames came before.

use super::closed_form_simd::Paths;
use super::motion::Circle;
use super::particle_groups::Particles;
use super::wall_tally::{WallLedger, WallTally};
use serde::{Deserialize, Serialize};

/// Where the closed form stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ExactClock {
    pub(super) duration_s: f64,
    pub(super) time_s: f64,
    /// When the present paths began, s.
    pub(super) began_s: f64,
    paths: Paths,
    /// What the wall felt before they began.
    before: WallTally,
}

impl ExactClock {
    pub(super) fn new(
        duration_s: f64,
        particles: &Particles,
        mass_ratios: &[f64],
        circle: Circle,
    ) -> Self {
        let paths = Paths::begin(particles, mass_ratios, circle);
        Self { duration_s, time_s: 0.0, began_s: 0.0, paths, before: WallTally::default() }
    }

    /// Moves the particles to a time and books their hits: those since the paths began by the closed form, those since the last
    /// jump by its difference.
    pub(super) fn jump_to(
        &mut self,
        time_s: f64,
        particles: &mut Particles,
        wall: &mut WallLedger,
    ) {
        let sums = self.paths.jump_to(time_s - self.began_s, particles);
        wall.total = self.before;
        wall.total.add(sums.hits, sums.impulse.value());
        wall.window.add(sums.fresh_hits, sums.fresh_impulse.value());
        self.time_s = time_s;
    }

    /// Begins new paths with the particles as they are, in a circle that is the wall now.
    pub(super) fn rebegin(
        &mut self,
        particles: &Particles,
        mass_ratios: &[f64],
        circle: Circle,
        wall: &WallLedger,
    ) {
        self.paths = Paths::begin(particles, mass_ratios, circle);
        self.began_s = self.time_s;
        self.before = wall.total;
    }
}

//! The trajectories of the first particles, with a bounded number of points.

use serde::{Deserialize, Serialize};

/// Maximum number of particles with a stored trajectory.
pub(crate) const PATHS: usize = 8;
/// Maximum number of points per trajectory.
const POINTS: usize = 512;

/// Every k-th position since the start. When the list is full, every other position is removed and k is doubled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Trails {
    every: u64,
    // One entry per stored frame: the positions of the particles.
    kept: Vec<Vec<[f64; 2]>>,
    last: Vec<[f64; 2]>,
}

impl Trails {
    pub(crate) fn new() -> Self {
        Self { every: 1, kept: Vec::new(), last: Vec::new() }
    }

    /// Adds the positions at a frame, always of the same particles; frames come in order, from 0.
    pub(crate) fn push(&mut self, frame: u64, positions: Vec<[f64; 2]>) {
        self.last.clone_from(&positions);
        if !frame.is_multiple_of(self.every) {
            return;
        }
        if self.kept.len() == POINTS {
            let mut even = [true, false].into_iter().cycle();
            self.kept.retain(|_| even.next().unwrap_or(true));
            self.every *= 2;
        }
        if frame.is_multiple_of(self.every) {
            self.kept.push(positions);
        }
    }

    /// For each particle, the stored positions in order, then the current one.
    pub(crate) fn paths(&self) -> impl Iterator<Item = impl Iterator<Item = [f64; 2]>> {
        (0..self.last.len()).map(|particle| {
            let at = move |positions: &Vec<[f64; 2]>| positions.get(particle).copied();
            self.kept.iter().chain([&self.last]).filter_map(at)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paths_are_evenly_thinned_and_end_where_the_particles_are() {
        let mut trails = Trails::new();
        for frame in 0..5000_u64 {
            trails.push(frame, vec![[frame as f64, 0.0], [-(frame as f64), 1.0]]);
            let paths: Vec<Vec<[f64; 2]>> = trails.paths().map(Iterator::collect).collect();
            assert_eq!(paths.len(), 2);
            assert!(paths[0].len() <= POINTS + 1);
            assert_eq!(paths[0][0], [0.0, 0.0]);
            assert_eq!(paths[0].last(), Some(&[frame as f64, 0.0]));
            assert_eq!(paths[1].last(), Some(&[-(frame as f64), 1.0]));
        }
        assert_eq!(trails.every, 16);
        assert!(trails.kept.windows(2).all(|pair| pair[1][0][0] - pair[0][0][0] == 16.0));
    }
}

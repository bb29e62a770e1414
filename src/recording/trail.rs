//! The path of the first particle so far, in a bounded number of points.

use serde::{Deserialize, Serialize};

/// Points kept at most.
const POINTS: usize = 512;

/// Every k-th position since the start; when full, every other one goes and k doubles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Trail {
    every: u64,
    kept: Vec<[f64; 2]>,
    last: Option<[f64; 2]>,
}

impl Trail {
    pub(crate) fn new() -> Self {
        Self { every: 1, kept: Vec::new(), last: None }
    }

    /// Adds the position at a frame; frames come in order, from 0.
    pub(crate) fn push(&mut self, frame: u64, position: [f64; 2]) {
        self.last = Some(position);
        if !frame.is_multiple_of(self.every) {
            return;
        }
        if self.kept.len() == POINTS {
            let mut even = [true, false].into_iter().cycle();
            self.kept.retain(|_| even.next().unwrap_or(true));
            self.every *= 2;
        }
        if frame.is_multiple_of(self.every) {
            self.kept.push(position);
        }
    }

    /// The kept positions in order, then where the particle is now.
    pub(crate) fn path(&self) -> impl Iterator<Item = [f64; 2]> {
        self.kept.iter().copied().chain(self.last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_is_evenly_thinned_and_ends_where_the_particle_is() {
        let mut trail = Trail::new();
        for frame in 0..5000_u64 {
            trail.push(frame, [frame as f64, 0.0]);
            let path: Vec<f64> = trail.path().map(|point| point[0]).collect();
            assert!(path.len() <= POINTS + 1);
            assert_eq!(path[0], 0.0);
            assert_eq!(path[path.len() - 1], frame as f64);
        }
        assert_eq!(trail.every, 16);
        assert!(trail.kept.windows(2).all(|pair| pair[1][0] - pair[0][0] == 16.0));
    }
}

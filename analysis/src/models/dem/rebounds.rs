//! The coefficient of restitution of one disc that falls on the floor.

use crate::statistics::mean;

/// Follows a falling disc from frame to frame and gathers e = sqrt(E after / E before) of its rebounds, E the energy above
/// first touch.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rebounds {
    gravity: f64,
    least_energy: f64,
    /// Time, energy and velocity when it was last seen to fall.
    falling: Option<(f64, f64, f64)>,
    restitutions: Vec<f64>,
    contact_durations_s: Vec<f64>,
}

/// A rebound counts while its drop height is this many times the static sag m g / k: gravity during the contact then
/// changes e by less than a thousandth.
const LEAST_HEIGHT_OVER_SAG: f64 = 1e4;

impl Rebounds {
    /// A disc under a gravity (m/s^2, downwards) on a floor where it sinks in by `sag` (m) when at rest.
    #[must_use]
    pub(super) fn new(gravity: f64, sag: f64) -> Self {
        Self {
            gravity,
            least_energy: LEAST_HEIGHT_OVER_SAG * gravity * sag,
            falling: None,
            restitutions: Vec::new(),
            contact_durations_s: Vec::new(),
        }
    }

    /// The next frame: time (s), height of the lowest point over the floor (m), vertical velocity (m/s).
    pub(super) fn add_frame(&mut self, time: f64, gap: f64, velocity: f64) {
        if gap < 0.0 {
            return;
        }
        let energy = velocity * velocity / 2.0 + self.gravity * gap;
        if velocity <= 0.0 {
            self.falling = Some((time, energy, velocity));
        } else if let Some((fell, before, fell_at)) = self.falling.take() {
            // A whole flight between these two frames would have lasted longer than the one that begins now.
            let flight = 2.0 * (2.0 * energy).sqrt() / self.gravity;
            if time - fell < flight && before > self.least_energy {
                self.restitutions.push((energy / before).sqrt());
                // The parabolas before and after meet the floor with sqrt(2 E): when, from a velocity on them.
                let touch = fell + ((2.0 * before).sqrt() + fell_at) / self.gravity;
                let parting = time - ((2.0 * energy).sqrt() - velocity) / self.gravity;
                self.contact_durations_s.push(parting - touch);
            }
        }
    }

    /// Mean over the rebounds seen. It has no standard error: the integrator's error is the same for each, and no chance.
    #[must_use]
    pub(super) fn restitution(&self) -> Option<f64> {
        mean(&self.restitutions)
    }

    /// Mean time from touch to parting, s.
    #[must_use]
    pub(super) fn contact_duration_s(&self) -> Option<f64> {
        mean(&self.contact_durations_s)
    }

    /// Rebounds seen.
    #[must_use]
    pub(super) fn count(&self) -> usize {
        self.restitutions.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point that rebounds with e = 0.5 from a drop of 0.1 m: closed-form parabolas, seen every 2 ms.
    #[test]
    fn restitution_of_a_drop_is_found_from_its_flights() {
        let gravity = 9.81;
        let mut rebounds = Rebounds::new(gravity, 1e-8);
        let (mut start, mut speed, mut flight) = (0.0_f64, 0.0_f64, (0.2 / gravity).sqrt());
        let mut height = 0.1;
        for frame in 0..400 {
            let time = f64::from(frame) * 2e-3;
            while time > start + flight && speed < 1e3 {
                speed = 0.5 * (2.0 * gravity * height_of(speed, height, gravity)).sqrt();
                start += flight;
                flight = 2.0 * speed / gravity;
                height = 0.0;
                if flight < 1e-4 {
                    speed = 1e9;
                }
            }
            let since = time - start;
            let gap = height + speed * since - gravity * since * since / 2.0;
            if speed < 1e3 {
                rebounds.add_frame(time, gap, speed - gravity * since);
            }
        }
        let restitution = rebounds.restitution().unwrap();
        assert!((restitution - 0.5).abs() < 1e-9, "{restitution:?}");
        assert!(rebounds.restitutions.len() >= 4);
    }

    fn height_of(speed: f64, height: f64, gravity: f64) -> f64 {
        height + speed * speed / (2.0 * gravity)
    }

    /// Frames ten flights apart can't tell one rebound from many: nothing is claimed.
    #[test]
    fn rebounds_between_frames_are_not_guessed() {
        let mut rebounds = Rebounds::new(10.0, 1e-9);
        rebounds.add_frame(0.0, 0.1, 0.0);
        rebounds.add_frame(10.0, 0.001, 0.1);
        assert!(rebounds.restitution().is_none());
    }
}

//! Coefficient of restitution of one disc that falls on the floor.

use crate::statistics::mean;

/// Follows a falling disc from frame to frame and collects e = sqrt(E after / E before) of its rebounds, where E is the
/// energy relative to first contact.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rebounds {
    gravity: f64,
    least_energy: f64,
    /// Time, energy and velocity of the last frame in which the disc fell.
    falling: Option<(f64, f64, f64)>,
    restitutions: Vec<f64>,
    contact_durations_s: Vec<f64>,
    impact_velocities: Vec<f64>,
}

/// A rebound is used if its drop height is at least this multiple of the static sag m g / k: gravity during the contact
/// then changes e by less than 0.001.
const MIN_HEIGHT_OVER_SAG: f64 = 1e4;

impl Rebounds {
    /// Creates a tracker for gravity (m/s^2, downward) and the static sag (m) of the disc on the floor.
    pub(super) fn new(gravity: f64, sag: f64) -> Self {
        Self {
            gravity,
            least_energy: MIN_HEIGHT_OVER_SAG * gravity * sag,
            falling: None,
            restitutions: Vec::new(),
            contact_durations_s: Vec::new(),
            impact_velocities: Vec::new(),
        }
    }

    /// Adds a frame: time (s), height of the lowest point above the floor (m), vertical velocity (m/s).
    pub(super) fn add_frame(&mut self, time: f64, gap: f64, velocity: f64) {
        if gap < 0.0 {
            return;
        }
        let energy = velocity * velocity / 2.0 + self.gravity * gap;
        if velocity <= 0.0 {
            self.falling = Some((time, energy, velocity));
        } else if let Some((fell, before, fell_at)) = self.falling.take() {
            // A complete flight between these two frames would have lasted longer than the flight that begins now.
            let flight = 2.0 * (2.0 * energy).sqrt() / self.gravity;
            if time - fell < flight && before > self.least_energy {
                self.restitutions.push((energy / before).sqrt());
                // The parabolas before and after meet the floor at the speed sqrt(2 E), which gives the two times of
                // contact.
                let touch = fell + ((2.0 * before).sqrt() + fell_at) / self.gravity;
                let parting = time - ((2.0 * energy).sqrt() - velocity) / self.gravity;
                self.contact_durations_s.push(parting - touch);
                self.impact_velocities.push((2.0 * before).sqrt());
            }
        }
    }

    /// Mean over the observed rebounds. There is no standard error, because the integrator's error is the same for each
    /// rebound.
    pub(super) fn restitution(&self) -> Option<f64> {
        mean(&self.restitutions)
    }

    /// The restitution of each observed rebound, in order.
    pub(super) fn restitutions(&self) -> &[f64] {
        &self.restitutions
    }

    /// Mean contact duration, s.
    pub(super) fn contact_duration_s(&self) -> Option<f64> {
        mean(&self.contact_durations_s)
    }

    /// Downward gravity, m/s^2.
    pub(super) const fn gravity(&self) -> f64 {
        self.gravity
    }

    /// Mean velocity of the impacts, m/s.
    pub(super) fn impact_velocity(&self) -> Option<f64> {
        mean(&self.impact_velocities)
    }

    /// Number of observed rebounds.
    pub(super) fn count(&self) -> usize {
        self.restitutions.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Setup: a point that rebounds with e = 0.5 from a height of 0.1 m, closed-form parabolas, one frame every 2 ms.
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

    /// Frames ten flights apart cannot distinguish one rebound from several.
    #[test]
    fn rebounds_between_frames_are_not_guessed() {
        let mut rebounds = Rebounds::new(10.0, 1e-9);
        rebounds.add_frame(0.0, 0.1, 0.0);
        rebounds.add_frame(10.0, 0.001, 0.1);
        assert!(rebounds.restitution().is_none());
    }
}

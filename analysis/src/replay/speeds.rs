//! Speeds and velocities as small numbers.

use super::encoding::{ABSENT, ABSENT_SPEED, LARGEST, LARGEST_SPEED, append_speeds, quantized};
use super::lines::texts;
use super::still::{Still, padded};
use kinetoscope_recording::drawing::Shape;

/// Fraction of the particles of a frame that are not faster than its typical top speed.
const TOP_FRACTION: f64 = 0.99;
/// Number of points up to which velocities have 16 bits; those of more points have 8, so that the page stays small.
const MAX_FINE_POINTS: usize = 20_000;
/// Number of points up to which spins are stored: those of more would take the place of frames.
const MAX_SPINS: usize = 200_000;
/// The largest stored value of a coarse velocity, which is even so that zero is a stored value.
const LARGEST_COARSE: u16 = 254;

/// The stored speeds: the square of the stored number is proportional to the speed, so that low speeds differ as well.
pub(super) struct Speeds {
    pub(super) max: f64,
    pub(super) top: f64,
}

impl Speeds {
    /// The top of the color scale is that of the recorded color bar, else the largest typical top speed of a frame: a few fast particles do not darken
    /// the others.
    pub(super) fn of(frames: impl Iterator<Item = Vec<f64>>, legend_top: Option<f64>) -> Self {
        let (mut max, mut top) = (0.0_f64, 0.0_f64);
        for mut speeds in frames {
            speeds.retain(|speed| speed.is_finite());
            let rank = (TOP_FRACTION * speeds.len() as f64).ceil() as usize;
            if let Some(index) = rank.checked_sub(1) {
                top = top.max(*speeds.select_nth_unstable_by(index, f64::total_cmp).1);
                max = speeds.into_iter().fold(max, f64::max);
            }
        }
        Self { max, top: legend_top.unwrap_or(top) }
    }

    pub(super) fn stored(&self, speed: f32) -> u8 {
        let speed = f64::from(speed);
        if !speed.is_finite() {
            return ABSENT_SPEED;
        }
        let fraction = if self.max > 0.0 { (speed / self.max).sqrt() } else { 0.0 };
        libm::round(fraction * f64::from(LARGEST_SPEED)) as u8
    }
}

/// Appends the spins if discs spin and have few enough points; the spin of the largest stored value, or 0.
pub(super) fn append_spins(data: &mut Vec<u8>, stills: &[&Still], particles: usize) -> f64 {
    let sizes = |still: &&Still| {
        still.points.iter().map(|point| f64::from(point.spin.abs())).collect::<Vec<f64>>()
    };
    let spins = Spins::of(stills.iter().map(sizes));
    if !(spins.top > 0.0 && particles * stills.len() <= MAX_SPINS) {
        return 0.0;
    }
    let points = stills.iter().flat_map(|still| padded(&still.points, particles));
    append_speeds(
        data,
        &points.map(|point| spins.stored(point.spin)).collect::<Vec<_>>(),
        particles,
    );
    spins.top
}

/// The stored spins: equal steps between the largest clockwise and counterclockwise spins, of which a few fast ones do not darken the others.
pub(super) struct Spins {
    /// The spin of the largest stored value; 0 if nothing spins.
    pub(super) top: f64,
}

impl Spins {
    pub(super) fn of(frames: impl Iterator<Item = Vec<f64>>) -> Self {
        Self { top: Speeds::of(frames, None).top }
    }

    pub(super) fn stored(&self, spin: f32) -> u8 {
        let (fraction, middle) = (f64::from(spin) / self.top, f64::from(LARGEST_SPEED / 2));
        if fraction.is_finite() {
            libm::round(middle * (1.0 + fraction.clamp(-1.0, 1.0))) as u8
        } else {
            ABSENT_SPEED
        }
    }
}

/// The speed at the upper end of a recorded color bar, by its last text, such as "0.848 m/s"; `None` without a positive number.
pub(super) fn legend_top(legend: &[Shape]) -> Option<f64> {
    let text = texts(legend).pop()?;
    let number = text.split(' ').next()?;
    let top: f64 = number.parse().ok()?;
    (top > 0.0 && top.is_finite()).then_some(top)
}

/// The stored components of velocities: equal steps from `-top` to `top`.
pub(super) struct Velocities {
    pub(super) top: f64,
    /// The length of a step; 0 if no velocity is recorded.
    pub(super) step: f64,
}

impl Velocities {
    pub(super) fn of(components: impl Iterator<Item = f32>, points: usize) -> Self {
        let sizes = components.filter(|part| part.is_finite()).map(|part| f64::from(part.abs()));
        let Some(top) = sizes.reduce(f64::max) else { return Self { top: 0.0, step: 0.0 } };
        let largest = if points > MAX_FINE_POINTS { LARGEST_COARSE } else { LARGEST };
        let step = if top > 0.0 { 2.0 * top / f64::from(largest) } else { 1.0 };
        Self { top, step }
    }

    pub(super) fn stored(&self, component: f32) -> u16 {
        if self.step > 0.0 { quantized(f64::from(component) + self.top, self.step) } else { ABSENT }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn top_of_the_color_scale_is_that_of_the_recorded_bar() {
        let legend = |texts: &[&str]| -> Vec<Shape> {
            let text = |text: &&str| Shape::Text { center: [0.0; 2], text: (*text).to_owned() };
            texts.iter().map(text).collect()
        };
        assert_eq!(legend_top(&legend(&["speed 0", "0.848 m/s"])), Some(0.848));
        assert_eq!(legend_top(&legend(&["speed 0", "1.2e-8"])), Some(1.2e-8));
        for damaged in ["", "fast", "-1 m/s", "inf", "0 m/s"] {
            assert_eq!(legend_top(&legend(&["speed 0", damaged])), None, "{damaged}");
        }
        let speeds = || [vec![0.1, 0.2, 5.0]].into_iter();
        assert_eq!(Speeds::of(speeds(), Some(0.848)).top, 0.848);
        assert_eq!(Speeds::of(speeds(), None).top, 5.0);
    }

    /// Control: without a spin, none is stored.
    #[test]
    fn spins_are_stored_with_their_sign() {
        let spins = Spins::of([vec![2.0, 1.0, 0.0]].into_iter());
        assert_eq!(spins.top, 2.0);
        let stored = [-9.0, -2.0, -1.0, 0.0, 1.0, 2.0].map(|spin| spins.stored(spin));
        assert_eq!(stored, [0, 0, 64, 127, 191, 254]);
        assert_eq!(spins.stored(f32::NAN), ABSENT_SPEED);
        assert_eq!(Spins::of([vec![0.0]].into_iter()).stored(0.0), ABSENT_SPEED);
    }

    #[test]
    fn velocities_are_stored_within_half_a_step() {
        let parts = [-3.0_f32, -0.7, 0.0, 1e-3, 2.9];
        for points in [5, MAX_FINE_POINTS + 1] {
            let velocities = Velocities::of(parts.into_iter().chain([f32::NAN]), points);
            assert_eq!(velocities.top, 3.0);
            for part in parts {
                let found = f64::from(velocities.stored(part)) * velocities.step - velocities.top;
                assert!((found - f64::from(part)).abs() <= 0.501 * velocities.step, "{part}");
            }
            assert_eq!(velocities.stored(f32::NAN), ABSENT);
        }
        assert_eq!(Velocities::of([f32::NAN].into_iter(), 1).step, 0.0);
    }
}

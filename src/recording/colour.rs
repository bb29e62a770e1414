//! Speeds to colours: blue, sky, yellow, vermillion in 64 steps. All are legible on light and on dark grounds.

use foxglove::messages::Color;

/// Number of colours.
pub(crate) const STEPS: usize = 64;

/// Blue, sky blue, yellow and vermillion, evenly spaced from rest to the top speed.
const STOPS: [[u8; 3]; 4] =
    [[0x00, 0x72, 0xb2], [0x56, 0xb4, 0xe9], [0xf0, 0xc8, 0x3c], [0xd5, 0x5e, 0x00]];

/// Walls.
pub(crate) const GREY: Color = opaque([0x8c, 0x8c, 0x8c]);
/// Contact forces, legible on all four colours of the discs.
pub(crate) const NEARLY_BLACK: Color = opaque([0x14, 0x14, 0x14]);
/// Velocities.
pub(crate) const DARK_GREY: Color = opaque([0x6e, 0x6e, 0x6e]);
/// The path so far.
pub(crate) const SKY: Color = opaque(STOPS[1]);
/// Bodies at rest.
pub(crate) const YELLOW: Color = opaque(STOPS[2]);
/// Text, which the viewers put on a black box.
pub(crate) const WHITE: Color = opaque([0xff, 0xff, 0xff]);

const fn opaque(rgb: [u8; 3]) -> Color {
    Color {
        r: rgb[0] as f64 / 255.0,
        g: rgb[1] as f64 / 255.0,
        b: rgb[2] as f64 / 255.0,
        // Protobuf's unset 0 would leave an outline only.
        a: 1.0,
    }
}

/// The colours of the speeds, from rest to the top.
#[derive(Clone, Debug)]
pub(crate) struct ColourMap {
    colours: [Color; STEPS],
}

impl ColourMap {
    pub(crate) fn new() -> Self {
        Self { colours: std::array::from_fn(|step| interpolated(step as f64 / (STEPS - 1) as f64)) }
    }

    /// The colour at a share of the top speed; beyond the ends the end's colour.
    pub(crate) fn at(&self, share: f64) -> Color {
        // A cast from float saturates: negative shares and NaN give step 0.
        let step = (share * STEPS as f64) as usize;
        self.colours[step.min(STEPS - 1)]
    }
}

/// The colour between the stops at a share in [0, 1], in steps of 1/255.
fn interpolated(share: f64) -> Color {
    let position = share * (STOPS.len() - 1) as f64;
    let segment = (position as usize).min(STOPS.len() - 2);
    let part = position - segment as f64;
    let [low, high] = [STOPS[segment], STOPS[segment + 1]];
    opaque(std::array::from_fn(|channel| {
        let (low, high) = (f64::from(low[channel]), f64::from(high[channel]));
        (low + part * (high - low)).round() as u8
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_and_what_is_beyond_have_the_stops_colours() {
        let map = ColourMap::new();
        assert_eq!(map.at(0.0), opaque(STOPS[0]));
        assert_eq!(map.at(-1.0), opaque(STOPS[0]));
        assert_eq!(map.at(1.0), opaque(STOPS[3]));
        assert_eq!(map.at(7.0), opaque(STOPS[3]));
        assert_eq!(map.at(f64::INFINITY), opaque(STOPS[3]));
    }
}

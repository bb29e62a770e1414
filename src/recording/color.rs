//! Speeds to colors: from blue at rest over green to yellow at the top speed, in 64 steps.
//!
//! The scale is perceptually uniform, and lightness increases monotonically, so that the order is visible with any color vision
//! and on a gray print. Red, the hue of the force chains, is no speed's; it is distinct from every disc and from light and dark
//! backgrounds.

use foxglove::messages::Color;

/// Number of colors.
pub(crate) const STEPS: usize = 64;

/// Colors from rest to the top speed, equally far apart in Oklab (B. Ottosson, A perceptual color space for image
/// processing, 2020): its lightness goes from 0.55 to 0.91, its hue from 260 to 100 degrees.
pub(crate) const STOPS: [[u8; 3]; 9] = [
    [0x39, 0x6f, 0xc8],
    [0x23, 0x87, 0xc7],
    [0x1b, 0x9d, 0xc1],
    [0x1c, 0xb2, 0xb6],
    [0x43, 0xc3, 0xa4],
    [0x6f, 0xd1, 0x8c],
    [0x9e, 0xda, 0x6b],
    [0xd0, 0xe0, 0x4b],
    [0xff, 0xe4, 0x30],
];

/// Contact forces, in a hue that no speed has.
const FORCE_CHAIN: [u8; 3] = [0xc8, 0x14, 0x14];
/// Walls.
pub(crate) const GRAY: Color = opaque([0x8c, 0x8c, 0x8c]);
/// Contact forces.
pub(crate) const RED: Color = opaque(FORCE_CHAIN);
/// Velocities.
pub(crate) const DARK_GRAY: Color = opaque([0x6e, 0x6e, 0x6e]);
/// The path so far.
pub(crate) const SKY: Color = opaque([0x56, 0xb4, 0xe9]);
/// Exact solutions.
pub(crate) const GREEN: Color = opaque([0x2e, 0x9e, 0x5b]);
/// Bodies at rest.
pub(crate) const YELLOW: Color = opaque([0xf0, 0xc8, 0x3c]);
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

/// The colors of the speeds, from rest to the top.
#[derive(Clone, Debug)]
pub(crate) struct ColorMap {
    colors: [Color; STEPS],
}

impl ColorMap {
    pub(crate) fn new() -> Self {
        Self { colors: std::array::from_fn(|step| interpolated(step as f64 / (STEPS - 1) as f64)) }
    }

    /// The color at a share of the top speed; beyond the ends the end's color.
    pub(crate) fn at(&self, share: f64) -> Color {
        self.colors[Self::step(share)]
    }

    /// The index of the color at a share of the top speed.
    pub(crate) fn step(share: f64) -> usize {
        // A cast from float saturates: negative shares and NaN give step 0.
        ((share * STEPS as f64) as usize).min(STEPS - 1)
    }

    /// All colors, from rest to the top speed.
    pub(crate) fn all(&self) -> [Color; STEPS] {
        self.colors
    }
}

/// The color between the stops at a share in [0, 1], in steps of 1/255.
fn interpolated(share: f64) -> Color {
    let position = share * (STOPS.len() - 1) as f64;
    let segment = (position as usize).min(STOPS.len() - 2);
    let part = position - segment as f64;
    let [low, high] = [STOPS[segment], STOPS[segment + 1]];
    opaque(std::array::from_fn(|channel| {
        let (low, high) = (f64::from(low[channel]), f64::from(high[channel]));
        libm::round(low + part * (high - low)) as u8
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Color blindness as matrices on linear sRGB: G. M. Machado, M. M. Oliveira, L. A. F. Fernandes, A physiologically-based
    /// model for simulation of color vision deficiency, IEEE TVCG 15 (2009) 1291, severity 1.
    const PROTANOPIA: [[f64; 3]; 3] = [
        [0.152_286, 1.052_583, -0.204_868],
        [0.114_503, 0.786_281, 0.099_216],
        [-0.003_882, -0.048_116, 1.051_998],
    ];
    const DEUTERANOPIA: [[f64; 3]; 3] = [
        [0.367_322, 0.860_646, -0.227_968],
        [0.280_085, 0.672_501, 0.047_413],
        [-0.011_820, 0.042_940, 0.968_881],
    ];
    const TRITANOPIA: [[f64; 3]; 3] = [
        [1.255_528, -0.076_749, -0.178_779],
        [-0.078_411, 0.930_809, 0.147_602],
        [0.004_733, 0.691_367, 0.303_900],
    ];
    const FULL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    fn product(matrix: [[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
    }

    /// The transfer function of IEC 61966-2-1.
    fn linear(value: f64) -> f64 {
        if value <= 0.040_45 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
    }

    /// Oklab of a color as eyes with this vision see it; matrices as Ottosson gives them for linear sRGB.
    fn seen(vision: [[f64; 3]; 3], [r, g, b]: [u8; 3]) -> [f64; 3] {
        let linear = [r, g, b].map(|channel| linear(f64::from(channel) / 255.0));
        let light = product(vision, linear).map(|x| if x > 0.0 { x } else { 0.0 });
        let cones = product(
            [
                [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
                [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
                [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
            ],
            light,
        );
        product(
            [
                [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
                [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
                [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
            ],
            cones.map(libm::cbrt),
        )
    }

    fn distance(one: [f64; 3], other: [f64; 3]) -> f64 {
        one.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    }

    /// Smallest and largest distance of neighboring stops, and whether lightness rises at each.
    fn steps(vision: [[f64; 3]; 3], stops: &[[u8; 3]]) -> (f64, f64, bool) {
        let seen: Vec<[f64; 3]> = stops.iter().map(|&stop| seen(vision, stop)).collect();
        let steps = seen.windows(2).map(|pair| distance(pair[0], pair[1]));
        let (least, most) = steps.fold((f64::INFINITY, 0.0_f64), |(least, most), step| {
            (if step < least { step } else { least }, if step > most { step } else { most })
        });
        (least, most, seen.windows(2).all(|pair| pair[1][0] > pair[0][0]))
    }

    /// White is (1, 0, 0) in Oklab by its definition; red's values are from Ottosson's page.
    #[test]
    fn the_judge_knows_white_and_red() {
        assert!(distance(seen(FULL, [255; 3]), [1.0, 0.0, 0.0]) < 1e-4);
        assert!(distance(seen(FULL, [255, 0, 0]), [0.628, 0.225, 0.126]) < 1e-3);
    }

    /// Stops are rounded to 1/255, which is 0.004 in Oklab against steps of 0.07: 10 % is what even steps can show.
    #[test]
    fn equal_steps_of_speed_look_equally_far_apart() {
        let (least, most, lighter) = steps(FULL, &STOPS);
        println!("steps from {least:.4} to {most:.4} in Oklab, ratio {:.3}", most / least);
        assert!(most / least < 1.1, "{least} to {most}");
        assert!(lighter);
    }

    /// 0.02 in Oklab is what one notices: eight steps stay well apart for all, and their order is that of lightness.
    #[test]
    fn the_order_of_speeds_is_seen_with_any_color_vision() {
        for (name, vision) in
            [("protanopia", PROTANOPIA), ("deuteranopia", DEUTERANOPIA), ("tritanopia", TRITANOPIA)]
        {
            let (least, most, lighter) = steps(vision, &STOPS);
            println!("{name}: steps from {least:.4} to {most:.4} in Oklab");
            assert!(least > 0.03, "{name}: {least}");
            assert!(lighter, "{name}");
        }
    }

    /// Smallest Oklab distance of a color from the discs, the walls and the viewers' light and dark backgrounds.
    fn contrast(vision: [[f64; 3]; 3], color: [u8; 3]) -> f64 {
        let around = STOPS.into_iter().chain([[0x8c; 3], [0xff; 3], [0x15, 0x15, 0x1a]]);
        let distances = around.map(|other| distance(seen(vision, color), seen(vision, other)));
        distances.fold(f64::INFINITY, |least, next| if next < least { next } else { least })
    }

    /// 0.14 in Oklab is twice the distance of two stops of the speeds. Control: black disappears on a dark background.
    #[test]
    fn force_chains_are_visible_on_discs_and_backgrounds_with_any_color_vision() {
        for (name, vision) in [
            ("full", FULL),
            ("protanopia", PROTANOPIA),
            ("deuteranopia", DEUTERANOPIA),
            ("tritanopia", TRITANOPIA),
        ] {
            println!("{name}: {:.3}", contrast(vision, FORCE_CHAIN));
            assert!(contrast(vision, FORCE_CHAIN) > 0.14, "{name}");
        }
        assert!(contrast(FULL, [0x14; 3]) < 0.02);
    }

    /// Control: a rainbow's steps are uneven, and its lightness goes up and down.
    #[test]
    fn a_rainbow_is_rejected() {
        let rainbow = [[0, 0, 255], [0, 255, 255], [0, 255, 0], [255, 255, 0], [255, 0, 0]];
        let (least, most, lighter) = steps(FULL, &rainbow);
        assert!(most / least > 1.5 && !lighter, "{least} to {most}");
    }

    #[test]
    fn the_ends_and_what_is_beyond_have_the_stops_colors() {
        let (map, last) = (ColorMap::new(), STOPS[STOPS.len() - 1]);
        assert_eq!(map.at(0.0), opaque(STOPS[0]));
        assert_eq!(map.at(-1.0), opaque(STOPS[0]));
        assert_eq!(map.at(1.0), opaque(last));
        assert_eq!(map.at(7.0), opaque(last));
        assert_eq!(map.at(f64::INFINITY), opaque(last));
    }
}

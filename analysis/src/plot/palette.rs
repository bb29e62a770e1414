//! The palette of curves: seven colors on white and the same seven on the dark page. All pairs are distinct with any type of color
//! vision, which a test verifies.

use std::fmt::Write;

/// A color as red, green and blue.
type Color = [u8; 3];

/// The colors on white, each with a contrast of 3:1 to it; the last one is for references.
pub(super) const ON_WHITE: [Color; 7] = [
    [0x6c, 0x1d, 0xc1],
    [0xb2, 0x4b, 0x08],
    [0x00, 0x72, 0x73],
    [0xc0, 0x7b, 0xb0],
    [0x28, 0x8f, 0xff],
    [0xf9, 0x66, 0x02],
    [0x3f, 0x32, 0x36],
];

/// The colors on the dark page, in the same order.
const ON_DARK: [Color; 7] = [
    [0x92, 0x55, 0xd7],
    [0xf2, 0x6d, 0x1c],
    [0x2a, 0x9f, 0x87],
    [0xdd, 0x71, 0xff],
    [0xc0, 0xf8, 0xff],
    [0xf2, 0xdc, 0x64],
    [0xb9, 0xb9, 0xb9],
];

/// Rules for a page: the variables `--c0` to `--c6` in both themes, and the colors of plots that were drawn for white paper.
pub(crate) fn style_sheet() -> String {
    let variables = |colors: &[Color; 7]| {
        let all = colors.iter().enumerate();
        all.map(|(index, color)| format!("--c{index}:{};", hexadecimal(*color))).collect::<String>()
    };
    let (light, dark) = (variables(&ON_WHITE), variables(&ON_DARK));
    let mut rules = format!(
        "\n:root{{{light}}}\n@media (prefers-color-scheme:dark){{:root{{{dark}}}}}\n@media print{{:root{{{light}}}}}\n"
    );
    for (index, color) in ON_WHITE.iter().enumerate() {
        let color = hexadecimal(*color);
        for property in ["stroke", "fill"] {
            // Writing to a String cannot fail.
            let _ = writeln!(rules, "svg [{property}=\"{color}\"]{{{property}:var(--c{index})}}");
        }
    }
    rules
}

/// A color as the drawing library writes it.
fn hexadecimal([red, green, blue]: Color) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}

#[cfg(test)]
mod tests {
    use super::*;

    type Matrix = [[f64; 3]; 3];

    /// Björn Ottosson: A perceptual color space for image processing (2020), from linear sRGB.
    const TO_CONES: Matrix = [
        [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
        [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
        [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
    ];
    const TO_OKLAB: Matrix = [
        [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
        [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
        [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
    ];
    /// Machado, Oliveira, Fernandes: IEEE Trans. Vis. Comput. Graph. 15, 1291 (2009), table of severity 1.
    const DEUTERANOPIA: Matrix = [
        [0.367_322, 0.860_646, -0.227_968],
        [0.280_085, 0.672_501, 0.047_413],
        [-0.011_820, 0.042_940, 0.968_881],
    ];
    const PROTANOPIA: Matrix = [
        [0.152_286, 1.052_583, -0.204_868],
        [0.114_503, 0.786_281, 0.099_216],
        [-0.003_882, -0.048_116, 1.051_998],
    ];
    const TRITANOPIA: Matrix = [
        [1.255_528, -0.076_749, -0.178_779],
        [-0.078_411, 0.930_809, 0.147_602],
        [0.004_733, 0.691_367, 0.303_900],
    ];
    const NORMAL: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    fn times(matrix: &Matrix, vector: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
    }

    /// Linear intensities of sRGB (IEC 61966-2-1).
    fn linear(color: Color) -> [f64; 3] {
        color.map(|part| match f64::from(part) / 255.0 {
            dark if dark <= 0.040_45 => dark / 12.92,
            bright => libm::pow((bright + 0.055) / 1.055, 2.4),
        })
    }

    /// The least distance of two colors in Oklab, times 100, as seen with this type of color vision.
    fn least_distance(colors: &[Color], vision: &Matrix) -> f64 {
        let oklab = |color: &Color| {
            let seen = times(vision, linear(*color)).map(|part| part.clamp(0.0, 1.0));
            times(&TO_OKLAB, times(&TO_CONES, seen).map(libm::cbrt))
        };
        let places: Vec<[f64; 3]> = colors.iter().map(oklab).collect();
        let mut least = f64::INFINITY;
        for (index, one) in places.iter().enumerate() {
            for other in &places[index + 1..] {
                let squares = one.iter().zip(other).map(|(a, b)| (a - b) * (a - b));
                least = least.min(100.0 * squares.sum::<f64>().sqrt());
            }
        }
        least
    }

    /// Contrast by WCAG 2.2.
    fn contrast(one: Color, other: Color) -> f64 {
        let luminance = |color: Color| {
            let [red, green, blue] = linear(color);
            0.2126 * red + 0.7152 * green + 0.0722 * blue + 0.05
        };
        let (a, b) = (luminance(one), luminance(other));
        (a / b).max(b / a)
    }

    const WHITE: Color = [0xff; 3];

    /// The colors of a theme's text in the style sheet, and its paper.
    fn variables(theme: &str) -> (Vec<(String, Color)>, Color) {
        let parsed = |text: &str| {
            let text = text.trim().trim_start_matches('#');
            [0, 2, 4].map(|at| u8::from_str_radix(&text[at..at + 2], 16).unwrap())
        };
        let lines = theme.lines().map(str::trim).take_while(|line| *line != "}");
        let all = lines.filter_map(|line| line.strip_prefix("--")?.split_once(": #"));
        let all: Vec<(String, Color)> = all
            .map(|(name, value)| (name.to_owned(), parsed(value.trim_end_matches(';'))))
            .collect();
        let paper = all.iter().find(|(name, _)| name == "paper").unwrap().1;
        (all, paper)
    }

    const SHEET: &str = include_str!("../report/report.css");

    fn themes() -> [(Vec<(String, Color)>, Color); 2] {
        let dark = SHEET.split("prefers-color-scheme: dark").nth(1).unwrap();
        [
            variables(SHEET.split(":root {").nth(1).unwrap()),
            variables(dark.split(":root {").nth(1).unwrap()),
        ]
    }

    /// Guarantee: any two curves differ by 15 in Oklab (100 times ΔE), also with deuteranopia, and by 11 with the other types of color
    /// vision, in both themes. Control: Okabe and Ito's colors with a lighter blue, which an earlier version used, do not.
    #[test]
    fn curves_are_distinct_in_both_themes_with_any_color_vision() {
        for (theme, colors) in [("white", ON_WHITE), ("dark", ON_DARK)] {
            for (vision, matrix, least) in [
                ("normal", NORMAL, 15.0),
                ("deuteranopia", DEUTERANOPIA, 15.0),
                ("protanopia", PROTANOPIA, 11.0),
                ("tritanopia", TRITANOPIA, 11.0),
            ] {
                let found = least_distance(&colors, &matrix);
                assert!(found >= least, "{theme}, {vision}: {found:.2}");
            }
        }
        let earlier = [[0x4a, 0xa8, 0xe0], [0x56, 0xb4, 0xe9]];
        assert!(least_distance(&earlier, &NORMAL) < 15.0);
    }

    #[test]
    fn curves_and_text_stand_out_from_the_page() {
        let [(light, paper), (dark, night)] = themes();
        assert_eq!(paper, WHITE);
        for (colors, page) in [(ON_WHITE, paper), (ON_DARK, night)] {
            for color in colors {
                let found = contrast(color, page);
                assert!(found >= 3.0, "{}: {found:.2}", hexadecimal(color));
            }
        }
        for (theme, page) in [(light, paper), (dark, night)] {
            for (name, color) in theme
                .iter()
                .filter(|(name, _)| !["paper", "line", "panel"].contains(&name.as_str()))
            {
                let found = contrast(*color, page);
                assert!(found >= 4.5, "--{name}: {found:.2}");
            }
        }
        assert!(contrast([0x99; 3], WHITE) < 4.5, "control");
    }

    #[test]
    fn style_sheet_names_every_color_of_a_plot() {
        let rules = style_sheet();
        for (index, color) in ON_WHITE.iter().enumerate() {
            let rule =
                format!("svg [stroke=\"{}\"]{{stroke:var(--c{index})}}", hexadecimal(*color));
            assert!(rules.contains(&rule), "{rules}");
        }
    }
}

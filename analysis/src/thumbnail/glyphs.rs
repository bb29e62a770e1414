//! Letters as strokes, for the labels of a color bar: numbers and units of speed.

/// Height of the grid.
const GRID_HEIGHT: f64 = 6.0;

/// Letters with their widths and strokes. A stroke is a list of points, each the column and the row in a grid that is 6 high,
/// from the upper left corner.
const GLYPHS: &[(char, f64, &str)] = &[
    ('0', 4.0, "10-30-41-45-36-16-05-01-10"),
    ('1', 3.0, "01-20-26"),
    ('2', 4.0, "01-10-30-41-42-06-46"),
    ('3', 4.0, "00-40-22-32-43-45-36-16-05"),
    ('4', 4.0, "36-30-04-44"),
    ('5', 4.0, "40-00-02-32-43-45-36-16-05"),
    ('6', 4.0, "41-30-10-01-05-16-36-45-44-33-03"),
    ('7', 4.0, "00-40-16"),
    ('8', 4.0, "10-30-41-42-33-13-02-01-10 13-04-05-16-36-45-44-33"),
    ('9', 4.0, "43-13-02-01-10-30-41-45-36-16-05"),
    ('.', 0.5, "06-06"),
    ('-', 3.0, "03-33"),
    ('/', 3.0, "06-30"),
    (' ', 2.0, ""),
    ('e', 4.0, "04-44-43-32-12-03-05-16-46"),
    ('m', 6.0, "06-02-22-33-36 33-42-52-63-66"),
    ('s', 3.0, "32-12-03-14-24-35-26-06"),
    ('d', 4.0, "40-46-16-05-03-12-42"),
    ('p', 4.0, "02-08 02-32-43-45-36-06"),
    ('A', 4.0, "06-20-46 14-34"),
    ('U', 4.0, "00-05-16-36-45-40"),
];

/// Width of an unknown letter, which leaves a gap.
const UNKNOWN_WIDTH: f64 = 4.0;
/// Space between two letters.
const GAP: f64 = 1.7;

/// The segments of a text around its middle, px.
pub(super) fn strokes(text: &str, middle: [f64; 2], height: f64) -> Vec<[[f64; 2]; 2]> {
    let unit = height / GRID_HEIGHT;
    let glyph = |letter: char| {
        let known = GLYPHS.iter().find(|(known, ..)| *known == letter);
        known.map_or((UNKNOWN_WIDTH, ""), |(_, width, strokes)| (*width, *strokes))
    };
    let letters: Vec<(f64, &str)> = text.chars().map(glyph).collect();
    let width = letters.iter().map(|(width, _)| width + GAP).sum::<f64>() - GAP;
    let mut left = middle[0] - unit * width / 2.0;
    let top = middle[1] - height / 2.0;
    let mut segments = Vec::new();
    for (width, strokes) in letters {
        for stroke in strokes.split_whitespace() {
            let points = stroke.split('-').map(|point| {
                let [x, y] = [0, 1].map(|axis| f64::from(point.as_bytes()[axis] - b'0'));
                [left + unit * x, top + unit * y]
            });
            let points: Vec<[f64; 2]> = points.collect();
            segments.extend(points.windows(2).map(|ends| [ends[0], ends[1]]));
        }
        left += unit * (width + GAP);
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_of_a_color_bar_has_strokes() {
        for letter in "0123456789.-e m/sAU/d".chars() {
            assert!(GLYPHS.iter().any(|(known, ..)| *known == letter), "{letter}");
        }
    }
}

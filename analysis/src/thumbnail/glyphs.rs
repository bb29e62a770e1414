//! Letters as strokes, for the labels of a color bar: numbers and units of speed.

/// Points of a stroke in grid units: 4 wide and 6 high, from the upper left corner.
type Stroke = &'static [[u8; 2]];

/// Height of the grid.
const GRID_HEIGHT: f64 = 6.0;

/// The strokes of a letter and its width; `None` for an unknown letter.
fn glyph(letter: char) -> Option<(&'static [Stroke], f64)> {
    let (strokes, width): (&'static [Stroke], f64) = match letter {
        '0' => (&[&[[1, 0], [3, 0], [4, 1], [4, 5], [3, 6], [1, 6], [0, 5], [0, 1], [1, 0]]], 4.0),
        '1' => (&[&[[0, 1], [2, 0], [2, 6]]], 3.0),
        '2' => (&[&[[0, 1], [1, 0], [3, 0], [4, 1], [4, 2], [0, 6], [4, 6]]], 4.0),
        '3' => (&[&[[0, 0], [4, 0], [2, 2], [3, 2], [4, 3], [4, 5], [3, 6], [1, 6], [0, 5]]], 4.0),
        '4' => (&[&[[3, 6], [3, 0], [0, 4], [4, 4]]], 4.0),
        '5' => (&[&[[4, 0], [0, 0], [0, 2], [3, 2], [4, 3], [4, 5], [3, 6], [1, 6], [0, 5]]], 4.0),
        '6' => (
            &[&[
                [4, 1],
                [3, 0],
                [1, 0],
                [0, 1],
                [0, 5],
                [1, 6],
                [3, 6],
                [4, 5],
                [4, 4],
                [3, 3],
                [0, 3],
            ]],
            4.0,
        ),
        '7' => (&[&[[0, 0], [4, 0], [1, 6]]], 4.0),
        '8' => (
            &[
                &[[1, 0], [3, 0], [4, 1], [4, 2], [3, 3], [1, 3], [0, 2], [0, 1], [1, 0]],
                &[[1, 3], [0, 4], [0, 5], [1, 6], [3, 6], [4, 5], [4, 4], [3, 3]],
            ],
            4.0,
        ),
        '9' => (
            &[&[
                [4, 3],
                [1, 3],
                [0, 2],
                [0, 1],
                [1, 0],
                [3, 0],
                [4, 1],
                [4, 5],
                [3, 6],
                [1, 6],
                [0, 5],
            ]],
            4.0,
        ),
        '.' => (&[&[[0, 6], [0, 6]]], 0.5),
        '-' => (&[&[[0, 3], [3, 3]]], 3.0),
        '/' => (&[&[[0, 6], [3, 0]]], 3.0),
        ' ' => (&[], 2.0),
        'e' => (&[&[[0, 4], [4, 4], [4, 3], [3, 2], [1, 2], [0, 3], [0, 5], [1, 6], [4, 6]]], 4.0),
        'm' => (
            &[&[[0, 6], [0, 2], [2, 2], [3, 3], [3, 6]], &[[3, 3], [4, 2], [5, 2], [6, 3], [6, 6]]],
            6.0,
        ),
        's' => (&[&[[3, 2], [1, 2], [0, 3], [1, 4], [2, 4], [3, 5], [2, 6], [0, 6]]], 3.0),
        'd' => (&[&[[4, 0], [4, 6], [1, 6], [0, 5], [0, 3], [1, 2], [4, 2]]], 4.0),
        'A' => (&[&[[0, 6], [2, 0], [4, 6]], &[[1, 4], [3, 4]]], 4.0),
        'U' => (&[&[[0, 0], [0, 5], [1, 6], [3, 6], [4, 5], [4, 0]]], 4.0),
        _ => return None,
    };
    Some((strokes, width))
}

/// Space between two letters.
const GAP: f64 = 1.7;

/// The segments of a text around its middle, px. An unknown letter leaves a gap.
pub(super) fn strokes(text: &str, middle: [f64; 2], height: f64) -> Vec<[[f64; 2]; 2]> {
    let unit = height / GRID_HEIGHT;
    let letters: Vec<(&[Stroke], f64)> =
        text.chars().map(|letter| glyph(letter).unwrap_or((&[], 4.0))).collect();
    let width = letters.iter().map(|(_, width)| width + GAP).sum::<f64>() - GAP;
    let mut left = middle[0] - unit * width / 2.0;
    let top = middle[1] - height / 2.0;
    let mut segments = Vec::new();
    for (strokes, width) in letters {
        let place = |[x, y]: [u8; 2]| [left + unit * f64::from(x), top + unit * f64::from(y)];
        for stroke in strokes {
            segments.extend(stroke.windows(2).map(|ends| [place(ends[0]), place(ends[1])]));
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
            assert!(glyph(letter).is_some(), "{letter}");
        }
    }
}

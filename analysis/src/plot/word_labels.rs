//! The words below an axis that has words in place of numbers: in letters that fit, and in two lines where one is too long.

use super::axis::Layout;
use super::canvas::{Canvas, DrawingError, failure, fine, text_style, text_width};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Sizes of the letters, the preferred one first.
const SIZES: std::ops::RangeInclusive<i32> = 9..=15;
/// Size up to which two lines fit between the axis and its caption.
const SIZE_OF_TWO_LINES: i32 = 12;
/// Space between the axis and the first line.
const ABOVE: i32 = 9;
/// Space between two words.
const BETWEEN: i32 = 6;

/// Draws the words below an axis from `left` to `right` at the height `axis`.
pub(super) fn draw_words(
    sheet: &Canvas<'_>,
    x: &Layout,
    [left, right]: [i32; 2],
    axis: i32,
) -> Result<(), DrawingError> {
    let room = (right - left) / x.ticks.len().max(1) as i32 - BETWEEN;
    let words: Vec<String> = x.ticks.iter().map(|tick| x.tick_text(*tick)).collect();
    let fits = |size: &i32| {
        let mut lines = words.iter().flat_map(|word| lines(word, *size, room));
        lines.all(|line| text_width(line, *size) <= room)
    };
    let size = SIZES.rev().find(fits).unwrap_or(*SIZES.start());
    for (tick, word) in x.ticks.iter().zip(&words) {
        let share = (tick - x.low) / (x.high - x.low);
        let center = left + libm::round(share * f64::from(right - left)) as i32;
        for (row, line) in lines(word, size, room).into_iter().enumerate() {
            let middle = axis + ABOVE + size / 2 + row as i32 * size;
            let style = text_style(size, HPos::Center, VPos::Center);
            let text = Text::new(line.to_owned(), (fine(center), fine(middle)), style);
            sheet.draw(&text).map_err(failure)?;
        }
    }
    Ok(())
}

/// A word in one line, or in the two shortest ones if that is too long.
fn lines(word: &str, size: i32, room: i32) -> Vec<&str> {
    if text_width(word, size) <= room || size > SIZE_OF_TWO_LINES {
        return vec![word];
    }
    let ends = word.match_indices([' ', '_', '-']).map(|(at, mark)| at + mark.len());
    let longest = |end: &usize| word[..*end].trim_end().len().max(word.len() - end);
    match ends.filter(|end| *end < word.len()).min_by_key(longest) {
        Some(end) => vec![word[..end].trim_end(), &word[end..]],
        None => vec![word],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_words_are_split_at_the_middle_mark() {
        assert_eq!(lines("semi-implicit Euler", 12, 80), ["semi-implicit", "Euler"]);
        assert_eq!(lines("velocity_verlet", 10, 50), ["velocity_", "verlet"]);
        assert_eq!(lines("RK4", 12, 80), ["RK4"]);
        assert_eq!(lines("semi-implicit Euler", 12, 400), ["semi-implicit Euler"], "control");
        assert_eq!(lines("indivisible", 12, 10), ["indivisible"]);
        assert_eq!(lines("ends-", 12, 10), ["ends-"]);
    }
}

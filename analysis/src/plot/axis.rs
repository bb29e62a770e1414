//! Axes: range, readable ticks, and a caption with the unit.

use crate::number_text::{power_text, short_number};
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Scale {
    /// Linear.
    Linear,
    /// Logarithmic; values that are not positive are not drawn.
    Logarithmic,
}

/// The quantity on an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Axis {
    /// The name of the quantity.
    pub(crate) label: String,
    /// The unit; empty for a dimensionless quantity.
    pub(crate) unit: String,
    /// The scale.
    pub(crate) scale: Scale,
    /// The words at 0, 1, 2, and so on, in place of numbers; empty for an axis of numbers.
    pub(crate) words: Vec<String>,
}

impl Axis {
    /// A linear axis.
    pub(crate) fn linear(label: &str, unit: &str) -> Self {
        let unit = if unit == "1" { "" } else { unit };
        Self { label: label.into(), unit: unit.into(), scale: Scale::Linear, words: Vec::new() }
    }

    /// A logarithmic axis.
    pub(crate) fn logarithmic(label: &str, unit: &str) -> Self {
        Self { scale: Scale::Logarithmic, ..Self::linear(label, unit) }
    }

    /// Whether the axis can show a value.
    pub(crate) fn can_show(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == Scale::Linear || value > 0.0)
    }
}

/// Layout of an axis for its data. Drawn coordinates are values over a power of ten, or decimal logarithms.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    scale: Scale,
    exponent: i32,
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) ticks: Vec<f64>,
    decimals: usize,
    words: Vec<String>,
    pub(super) caption: String,
}

/// Relative range below which a curve is flat within rounding.
pub(super) const FLAT_RELATIVE: f64 = 1e-9;
/// Relative range of the axis of a flat curve.
const FLAT_RANGE_RELATIVE: f64 = 0.02;
/// Maximum number of words below an axis.
const MOST_WORDS: usize = 20;
/// Margin between data and frame, as a fraction of the range.
const MARGIN: f64 = 0.05;

impl Layout {
    /// Lays out an axis for values between two extremes, in the axis' unit.
    pub(super) fn new(axis: &Axis, least: f64, greatest: f64) -> Self {
        let mut layout = Self {
            scale: axis.scale,
            exponent: 0,
            low: least,
            high: greatest,
            ticks: Vec::new(),
            decimals: 0,
            words: axis.words.clone(),
            caption: String::new(),
        };
        match axis.scale {
            _ if !axis.words.is_empty() => {
                layout.low = -0.5;
                layout.high = axis.words.len() as f64 - 0.5;
            }
            Scale::Linear => {
                layout.exponent = common_exponent(least.abs().max(greatest.abs()));
                let unit = power_of_ten(layout.exponent);
                layout.widen(least / unit, greatest / unit);
            }
            Scale::Logarithmic => layout.widen(libm::log10(least), libm::log10(greatest)),
        }
        layout.set_ticks();
        layout.caption = caption(axis, layout.exponent);
        layout
    }

    fn widen(&mut self, low: f64, high: f64) {
        let size = low.abs().max(high.abs());
        let flat = high - low <= size * FLAT_RELATIVE;
        let range = if size > 0.0 { size * FLAT_RANGE_RELATIVE } else { 1.0 };
        let missing = if flat { range / 2.0 } else { 0.0 };
        let margin = MARGIN * (high - low + 2.0 * missing);
        self.low = low - missing - margin;
        self.high = high + missing + margin;
    }

    /// Replaces the drawn range, for equal scales along both axes.
    pub(super) fn set_range(&mut self, low: f64, high: f64) {
        self.low = low;
        self.high = high;
        self.set_ticks();
    }

    /// Uses the power of ten of another axis, for equal scales along both axes.
    pub(super) fn adopt_exponent(&mut self, axis: &Axis, exponent: i32) {
        let factor = power_of_ten(self.exponent) / power_of_ten(exponent);
        self.exponent = exponent;
        self.caption = caption(axis, exponent);
        self.set_range(self.low * factor, self.high * factor);
    }

    /// Whether the axis has words in place of numbers.
    pub(super) const fn has_words(&self) -> bool {
        !self.words.is_empty()
    }

    pub(super) const fn exponent(&self) -> i32 {
        self.exponent
    }

    fn set_ticks(&mut self) {
        if !self.words.is_empty() {
            let places = (0..self.words.len()).step_by(self.words.len().div_ceil(MOST_WORDS));
            let places = places.map(|word| word as f64);
            self.ticks = places.filter(|tick| (self.low..self.high).contains(tick)).collect();
            return;
        }
        if self.scale == Scale::Logarithmic
            && let Some(ticks) = decade_ticks(self.low, self.high)
        {
            self.ticks = ticks;
            return;
        }
        if self.scale == Scale::Logarithmic {
            let (low, high) = (libm::pow(10.0, self.low), libm::pow(10.0, self.high));
            let coarse = even_ticks(low, high, 6.0).0;
            let ticks = if coarse.len() >= 3 { coarse } else { even_ticks(low, high, 12.0).0 };
            self.ticks = ticks.into_iter().filter(|tick| *tick > 0.0).map(libm::log10).collect();
            return;
        }
        (self.ticks, self.decimals) = even_ticks(self.low, self.high, 6.0);
    }

    /// Number of characters of the longest tick label.
    pub(super) fn longest_text(&self) -> usize {
        let lengths = self.ticks.iter().map(|tick| self.tick_text(*tick).chars().count());
        lengths.max().unwrap_or(0)
    }

    /// The drawn coordinate of a value.
    pub(super) fn position(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value / power_of_ten(self.exponent),
            Scale::Logarithmic => libm::log10(value),
        }
    }

    /// The label of a tick.
    pub(super) fn tick_text(&self, tick: f64) -> String {
        match self.scale {
            _ if !self.words.is_empty() => {
                self.words.get(tick as usize).cloned().unwrap_or_default()
            }
            Scale::Linear => {
                let text = format!("{tick:.*}", self.decimals).replace('-', "−");
                if text.chars().any(|digit| ('1'..='9').contains(&digit)) {
                    text
                } else {
                    text.replace('−', "")
                }
            }
            Scale::Logarithmic => short_number(libm::pow(10.0, tick)),
        }
    }
}

impl Ranged for Layout {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let fraction = (value - self.low) / (self.high - self.low);
        limit.0 + libm::round(fraction * f64::from(limit.1 - limit.0)) as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

fn caption(axis: &Axis, exponent: i32) -> String {
    let power = if exponent == 0 { String::new() } else { power_text(exponent) };
    match (power.is_empty(), axis.unit.is_empty()) {
        (true, true) => axis.label.clone(),
        (true, false) => format!("{} ({})", axis.label, axis.unit),
        (false, true) => format!("{} ({power})", axis.label),
        (false, false) => format!("{} ({power} {})", axis.label, axis.unit),
    }
}

/// The power of ten in the caption; zero if plain numbers are readable.
fn common_exponent(size: f64) -> i32 {
    if size == 0.0 || (1e-2..1e5).contains(&size) { 0 } else { libm::log10(size).floor() as i32 }
}

/// A power of ten, exact for decimal literals, so that a division by 10^e rounds only once.
fn power_of_ten(exponent: i32) -> f64 {
    10.0_f64.powi(exponent)
}

/// Ticks at multiples of 1, 2 or 5 times a power of ten, at most about this many, and the number of decimals that distinguishes them.
fn even_ticks(low: f64, high: f64, most: f64) -> (Vec<f64>, usize) {
    let rough = (high - low) / most;
    let power = libm::log10(rough).floor();
    let unit = libm::pow(10.0, power);
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * unit)
        .find(|step| *step >= rough)
        .unwrap_or(unit);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    let decimals = (-libm::log10(step).floor()).max(0.0) as usize;
    ((first..=last).map(|index| index as f64 * step).collect(), decimals)
}

/// Logarithmic ticks (as decimal logarithms): powers of ten, with 2 and 5 in between if there is space; `None` for a
/// range that cannot hold three of them.
fn decade_ticks(low: f64, high: f64) -> Option<Vec<f64>> {
    let decades = high - low;
    let stride = ((decades / 8.0).ceil() as i64).max(1);
    let mantissas: &[f64] = if decades < 3.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let first = low.floor() as i64;
    let first = first - first.rem_euclid(stride);
    let mut ticks = Vec::new();
    for decade in (first..=high.ceil() as i64).step_by(stride as usize) {
        for mantissa in mantissas {
            let tick = decade as f64 + libm::log10(*mantissa);
            if (low..=high).contains(&tick) {
                ticks.push(tick);
            }
        }
    }
    (ticks.len() >= 3).then_some(ticks)
}

/// The least and the greatest of the values; `None` for no values.
pub(crate) fn extremes(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, value| match range {
        None => Some((value, value)),
        Some((least, greatest)) => Some((value.min(least), value.max(greatest))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_are_written_in_a_power_of_ten_of_the_caption() {
        let layout = Layout::new(&Axis::linear("pressure", "N/m"), 0.9e-18, 1.7e-18);
        assert_eq!(layout.caption, "pressure (10⁻¹⁸ N/m)");
        let texts: Vec<String> = layout.ticks.iter().map(|tick| layout.tick_text(*tick)).collect();
        assert_eq!(texts, ["1.0", "1.2", "1.4", "1.6"]);
    }

    #[test]
    fn a_constant_has_an_axis_with_different_ticks() {
        for constant in [0.0, 2.0, -3e-20] {
            let layout = Layout::new(&Axis::linear("y", ""), constant, constant);
            let mut texts: Vec<String> =
                layout.ticks.iter().map(|tick| layout.tick_text(*tick)).collect();
            assert!(texts.len() >= 3, "{constant}: {texts:?}");
            texts.dedup();
            assert_eq!(texts.len(), layout.ticks.len(), "{constant}: {texts:?}");
        }
    }

    /// Guarantee: a logarithmic axis of any range has at least three different labels.
    #[test]
    fn logarithmic_axes_have_three_labels() {
        for start in 0..40 {
            for width in 1..60 {
                let least = libm::pow(10.0, f64::from(start) / 40.0 - 3.0);
                let greatest = least * libm::pow(10.0, f64::from(width) / 10.0);
                let layout = Layout::new(&Axis::logarithmic("y", ""), least, greatest);
                let mut texts: Vec<String> =
                    layout.ticks.iter().map(|tick| layout.tick_text(*tick)).collect();
                texts.dedup();
                assert!(texts.len() >= 3, "{least} to {greatest}: {texts:?}");
            }
        }
    }

    #[test]
    fn logarithmic_ticks_suit_narrow_and_wide_ranges() {
        let texts = |least: f64, greatest: f64| -> Vec<String> {
            let layout = Layout::new(&Axis::logarithmic("r", "m"), least, greatest);
            layout.ticks.iter().map(|tick| layout.tick_text(*tick)).collect()
        };
        assert_eq!(texts(0.5, 2.0), ["0.5", "1", "2"]);
        assert_eq!(texts(1e-18, 3e-18), ["10⁻¹⁸", "1.5·10⁻¹⁸", "2·10⁻¹⁸", "2.5·10⁻¹⁸", "3·10⁻¹⁸"]);
        let wide = texts(1e-12, 1e4);
        assert!((4..=9).contains(&wide.len()), "{wide:?}");
    }
}

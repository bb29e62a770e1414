//! Tables and numbers for the terminal.

use crate::metric::{Deviation, Metric};
use crate::plot::{short_number, three_digits};

/// Width and color support of the terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Terminal {
    /// Characters per line.
    pub(crate) width: usize,
    /// Whether colors may be used.
    pub(crate) colors: bool,
}

/// Style of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Style {
    /// A heading.
    Heading,
    /// A success.
    Good,
    /// A failure.
    Bad,
    /// Less important.
    Faint,
}

impl Terminal {
    /// The text in its style, if colors may be used.
    pub(crate) fn paint(&self, style: Style, text: &str) -> String {
        if !self.colors {
            return text.to_owned();
        }
        let code = match style {
            Style::Heading => "1",
            Style::Good => "32",
            Style::Bad => "1;31",
            Style::Faint => "2",
        };
        format!("\x1b[{code}m{text}\x1b[0m")
    }

    /// Wraps text at the terminal's width with indented continuation lines; long words are not split.
    pub(crate) fn wrapped(&self, text: &str, indent: usize) -> String {
        let mut lines: Vec<String> = Vec::new();
        for paragraph in text.lines() {
            let mut line = String::new();
            // Lines of an underlined manifest are not wrapped.
            if paragraph.starts_with(' ') || paragraph.contains('|') {
                lines.push(paragraph.to_owned());
                continue;
            }
            for word in paragraph.split_whitespace() {
                let length = line.chars().count() + 1 + word.chars().count();
                if length > self.width && !line.trim().is_empty() {
                    lines.push(std::mem::replace(&mut line, " ".repeat(indent)));
                } else if !line.trim().is_empty() {
                    line.push(' ');
                }
                line.push_str(word);
            }
            lines.push(line);
        }
        lines.join("\n")
    }
}

/// Relative differences below this are rounding errors.
const ROUNDING: f64 = 1e-9;

/// Formats a number with its standard error in the last digits, such as 1.3182(13)·10⁻¹⁸; with six digits if the error
/// is unknown.
pub(crate) fn with_error(value: f64, standard_error: Option<f64>) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    let error = standard_error.filter(|error| {
        error.is_finite() && *error > ROUNDING * value.abs() && *error > f64::MIN_POSITIVE
    });
    let Some(error) = error else { return six_digits(value) };
    let size = value.abs().max(error);
    let exponent = decimal_exponent(size);
    let plain = (-2..=4).contains(&exponent);
    let unit = if plain { 1.0 } else { 10.0_f64.powi(exponent) };
    let (value, error) = (value / unit, error / unit);
    // Two digits of the error, except if it exceeds the digits before the decimal point.
    let decimals = (1 - decimal_exponent(error)).max(0);
    let shift = 10.0_f64.powi(decimals);
    let digits = (error * shift).round();
    let digits = if decimals == 0 { error.round() } else { digits };
    let text = format!("{value:.*}({digits})", decimals as usize).replace('-', "−");
    if plain { text } else { format!("{text}·{}", short_number(unit)) }
}

fn decimal_exponent(value: f64) -> i32 {
    value.log10().floor() as i32
}

/// Formats a number with six digits.
pub(crate) fn six_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = decimal_exponent(value.abs());
    if (-3..=5).contains(&exponent) {
        let text = format!("{value:.*}", usize::try_from(5 - exponent).unwrap_or(0));
        let text = if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        };
        text.replace('-', "−")
    } else {
        let unit = 10.0_f64.powi(exponent);
        let text = format!("{:.5}", value / unit);
        let mantissa = text.trim_end_matches('0').trim_end_matches('.').replace('-', "−");
        format!("{mantissa}·{}", short_number(unit))
    }
}

/// Formats one line per metric: name, value with error, unit, theoretical value and deviation. On a narrow terminal the
/// numbers are below the name.
pub(crate) fn table(metrics: &[&Metric], terminal: Terminal) -> String {
    let rows: Vec<[String; 4]> = metrics.iter().map(|metric| row(metric)).collect();
    let header = ["metric", "value", "theory", "deviation"].map(str::to_owned);
    let mut widths = header.each_ref().map(|text| text.chars().count());
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let pad = |text: &str, width: usize| {
        let missing = width.saturating_sub(text.chars().count());
        format!("{text}{}", " ".repeat(missing))
    };
    let wide = 2 + widths.iter().sum::<usize>() + 6 <= terminal.width;
    let mut lines = Vec::new();
    let mut add = |cells: &[String; 4], style: Option<Style>| {
        let paint = |text: String| style.map_or(text.clone(), |style| terminal.paint(style, &text));
        let numbers = |first: usize| {
            let cells = (first..4).map(|index| pad(&cells[index], widths[index]));
            cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
        };
        if wide {
            lines.push(format!("  {}", paint(numbers(0))));
        } else {
            lines.push(format!("  {}", paint(cells[0].clone())));
            lines.push(format!("      {}", paint(numbers(1))));
        }
    };
    add(&header, Some(Style::Faint));
    rows.iter().for_each(|row| add(row, None));
    lines.join("\n")
}

fn row(metric: &Metric) -> [String; 4] {
    let unit = match metric.unit() {
        "" | "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let value = format!("{}{unit}", with_error(metric.value, metric.standard_error));
    let theory = metric.theory.map_or_else(String::new, six_digits);
    [metric.name().to_owned(), value, theory, deviation_text(metric)]
}

/// Formats the deviation from theory: in standard errors if these are known and meaningful, else in percent or as a
/// factor; "rounding" within rounding errors.
pub(crate) fn deviation_text(metric: &Metric) -> String {
    let theory = metric.theory.unwrap_or(0.0);
    let deviation = metric.value - theory;
    match metric.deviation() {
        None => String::new(),
        Some(Deviation::Rounding) => "rounding".to_owned(),
        Some(Deviation::StandardErrors(deviation)) if deviation.abs() < 1000.0 => {
            format!("{deviation:+.1} σ").replace('-', "−")
        }
        Some(_) if theory != 0.0 => {
            let percent = 100.0 * deviation / theory.abs();
            if percent.abs() < 1000.0 {
                format!("{percent:+.2} %").replace('-', "−")
            } else {
                format!("× {}", three_digits(metric.value / theory))
            }
        }
        Some(_) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::definition::Definition;
    use crate::metric::{MetricScope, SweepScope};

    #[test]
    fn numbers_carry_their_error_in_the_last_digits() {
        assert_eq!(with_error(1.318_24e-18, Some(1.3e-21)), "1.3182(13)·10⁻¹⁸");
        assert_eq!(with_error(-0.019_61, Some(0.000_73)), "−0.01961(73)");
        assert_eq!(with_error(912.3456, Some(0.123)), "912.35(12)");
        assert_eq!(with_error(12_345.0, Some(250.0)), "12345(250)");
        assert_eq!(with_error(0.000_4, Some(0.02)), "0.000(20)");
        assert_eq!(with_error(0.000_1, None), "10⁻⁴".replace("10⁻⁴", "1·10⁻⁴"));
        assert_eq!(with_error(0.5, None), "0.5");
        assert_eq!(with_error(f64::NAN, None), "NaN");
    }

    #[test]
    fn sixty_columns_are_enough() {
        let scope =
            MetricScope::Sweep(SweepScope { along: None, coordinates: Vec::new(), replicates: 2 });
        let metric = Metric {
            definition: &Definition {
                name: "pressure_vs_temperature.mean_speed_formula.intercept",
                unit: "N/(m K)",
                how: "",
                laws: &[],
                rounding: 0.0,
            },
            value: -1.234_567e-23,
            rounding: 0.0,
            standard_error: Some(2.3e-24),
            theory: Some(0.0),
            source: String::new(),
            scope,
        };
        let text = table(&[&metric], Terminal { width: 60, colors: false });
        for line in text.lines() {
            assert!(line.chars().count() <= 60, "{line}");
        }
        assert!(text.contains("−1.23(23)·10⁻²³ N/(m K)") && text.contains("−5.4 σ"), "{text}");
        let wide = table(&[&metric], Terminal { width: 120, colors: false });
        assert_eq!(wide.lines().count(), 2);
    }
}

//! Tables and numbers for the terminal.

use crate::checks::{CheckResult, one_line};
use crate::metric::{Deviation, Metric};
use crate::number_text::{six_digits, three_digits, two_digits, with_error};
use crate::sweep::samples::typographic_unit;
use kinetoscope_console::text::visible;
use kinetoscope_console::wrapped_line;

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
    /// The text in its style, if colors may be used, without control characters.
    pub(crate) fn paint(&self, style: Style, text: &str) -> String {
        let text = visible(text);
        if !self.colors {
            return text.into_owned();
        }
        let code = match style {
            Style::Heading => "1",
            Style::Good => "32",
            Style::Bad => "1;31",
            Style::Faint => "2",
        };
        format!("\x1b[{code}m{text}\x1b[0m")
    }

    /// Wraps text at the terminal's width with indented continuation lines; long words are not split, and control characters
    /// are escaped.
    pub(crate) fn wrapped(&self, text: &str, indent: usize) -> String {
        let mut lines: Vec<String> = Vec::new();
        for paragraph in visible(text).lines() {
            // Lines of an underlined manifest are not wrapped.
            if paragraph.starts_with(' ') || paragraph.contains('|') {
                lines.push(paragraph.to_owned());
                continue;
            }
            lines.push(wrapped_line(paragraph, self.width, indent));
        }
        lines.join("\n")
    }
}

/// Formats one line per metric: name, value with error, unit, theoretical value and deviation. On a narrow terminal the
/// numbers are below the name, and the deviation below the numbers if it has no room next to them.
pub(crate) fn table(metrics: &[&Metric], terminal: Terminal) -> String {
    let rows: Vec<[String; 4]> = metrics.iter().map(|metric| row(metric)).collect();
    rows_of_four(["metric", "value", "theory", "deviation"], &rows, terminal)
}

/// Formats one line per metric of a check that passes: name and place, value, theoretical value, and what is required.
pub(crate) fn table_of_passed(
    checked: &[(&CheckResult, Option<&Metric>)],
    terminal: Terminal,
) -> String {
    let rows: Vec<[String; 4]> = checked
        .iter()
        .map(|(result, metric)| {
            let [_, value, theory, _] = metric.map(row).unwrap_or_default();
            [&result.subject, &value, &theory, &result.requirement].map(|cell| one_line(cell))
        })
        .collect();
    rows_of_four(["passed", "value", "theory", "required"], &rows, terminal)
}

fn rows_of_four(header: [&str; 4], rows: &[[String; 4]], terminal: Terminal) -> String {
    let header = header.map(str::to_owned);
    let mut widths = header.each_ref().map(|text| text.chars().count());
    for row in rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let pad = |text: &str, width: usize| {
        let missing = width.saturating_sub(text.chars().count());
        format!("{text}{}", " ".repeat(missing))
    };
    let wide = 2 + widths.iter().sum::<usize>() + 6 <= terminal.width;
    let numbers_fit = 6 + widths[1..].iter().sum::<usize>() + 4 <= terminal.width;
    let mut lines = Vec::new();
    let mut add = |cells: &[String; 4], style: Option<Style>| {
        let paint = |text: String| style.map_or(text.clone(), |style| terminal.paint(style, &text));
        let joined = |[first, end]: [usize; 2]| {
            let cells = (first..end).map(|index| pad(&cells[index], widths[index]));
            cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
        };
        let parts: &[[usize; 2]] = match (wide, numbers_fit) {
            (true, _) => &[[0, 4]],
            (false, true) => &[[0, 1], [1, 4]],
            (false, false) => &[[0, 1], [1, 3], [3, 4]],
        };
        for &part in parts {
            let (indent, text) = (if part[0] == 0 { 2 } else { 6 }, joined(part));
            if !text.is_empty() {
                lines.push(format!("{}{}", " ".repeat(indent), paint(text)));
            }
        }
    };
    add(&header, Some(Style::Faint));
    rows.iter().for_each(|row| add(row, None));
    lines.join("\n")
}

fn row(metric: &Metric) -> [String; 4] {
    let unit = match typographic_unit(metric.unit()) {
        none if none.is_empty() => none,
        unit => format!(" {unit}"),
    };
    let value = match value_text(metric) {
        missing if !metric.value().is_finite() => missing,
        value => format!("{value}{unit}"),
    };
    [metric.name().to_owned(), value, theory_text(metric), deviation_text(metric)]
}

/// Formats the value with its standard error; "none" if there is no value, for which [`reasons`] gives the reason.
pub(crate) fn value_text(metric: &Metric) -> String {
    if !metric.value().is_finite() {
        return "none".to_owned();
    }
    with_error(metric.value(), metric.standard_error())
}

/// Formats the theoretical value with the accuracy of its law, if that is not exact.
pub(crate) fn theory_text(metric: &Metric) -> String {
    let Some(theory) = metric.theory else { return String::new() };
    let value = six_digits(theory.value);
    if theory.accuracy > 0.0 {
        return format!("{value} ± {}", two_digits(theory.accuracy));
    }
    value
}

/// Degrees of freedom above which Student's t is close to the normal distribution, so that they are not shown.
const MANY_DEGREES_OF_FREEDOM: f64 = 30.0;

/// In place of a deviation from a theoretical value that does not apply.
const OUT_OF_RANGE: &str = "out of range";

/// Formats the deviation from theory: in standard errors if these are known and meaningful, as inside or outside the accuracy of the
/// law if that is larger, else in percent, or as a factor; empty
/// for a deviation from 0, which is the value itself. It is "0" for a number that equals theory, or "within round-off".
pub(crate) fn deviation_text(metric: &Metric) -> String {
    let theory = metric.theory_value().unwrap_or(0.0);
    let difference = metric.value() - theory;
    let Some(deviation) = metric.deviation() else {
        let is_outside = metric.theory.is_some_and(|theory| !theory.in_range());
        return if is_outside { OUT_OF_RANGE.to_owned() } else { String::new() };
    };
    let few = |freedom: &f64| *freedom < MANY_DEGREES_OF_FREEDOM;
    match deviation {
        _ if difference == 0.0 => "0".to_owned(),
        Deviation::Rounding => "within round-off".to_owned(),
        Deviation::Bound { is_inside } => {
            let place = if is_inside { "inside" } else { "outside" };
            let percent = 100.0 * difference / theory.abs();
            match percent.is_finite() && percent.abs() < 1000.0 {
                true => format!("{place} the bound ({})", percent_text(percent)),
                false => format!("{place} the bound"),
            }
        }
        Deviation::StandardErrors(sigma) if sigma.abs() < 1000.0 => {
            let freedom = metric.estimate.degrees_of_freedom.filter(few);
            let freedom = freedom.map(|freedom| format!(" (ν = {})", two_digits(freedom)));
            format!("{sigma:+.1} σ{}", freedom.unwrap_or_default())
        }
        Deviation::StandardErrors(_) if theory == 0.0 => "over 1000 σ".to_owned(),
        _ if theory == 0.0 => String::new(),
        _ => match 100.0 * difference / theory.abs() {
            percent if percent.abs() < 1000.0 => percent_text(percent),
            _ => format!("× {}", three_digits(metric.value() / theory)),
        },
    }
}

/// Formats a difference in percent with its sign.
fn percent_text(percent: f64) -> String {
    if percent.abs() < 0.1 { format!("{} %", signed(percent)) } else { format!("{percent:+.2} %") }
}

/// Formats a difference with its sign and two digits.
fn signed(difference: f64) -> String {
    let sign = if difference < 0.0 { "" } else { "+" };
    format!("{sign}{}", two_digits(difference))
}

/// The reasons why values, errors or deviations are missing, each once with the metrics that it concerns.
pub(crate) fn reasons(metrics: &[&Metric]) -> Vec<String> {
    let mut reasons: Vec<(String, Vec<&str>)> = Vec::new();
    for metric in metrics {
        let Some(reason) = metric.reason() else { continue };
        match reasons.iter_mut().find(|(other, _)| *other == reason) {
            Some((_, names)) => names.push(metric.name()),
            None => reasons.push((reason, vec![metric.name()])),
        }
    }
    let lines =
        reasons.into_iter().map(|(reason, names)| format!("{}: {reason}", names.join(", ")));
    lines.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::definition::Definition;
    use crate::metric::theory::{Expected, ExpectedValue};
    use crate::metric::{MetricScope, Quantity, SweepScope};
    use crate::statistics::Estimate;

    const LENGTH: &Definition = &Definition {
        name: "length",
        unit: "m",
        label: "quantity",
        how: "",
        laws: &[],
        rounding: 1e-12,
    };

    fn compared(estimate: Estimate, theory: impl Expected) -> Metric {
        let scope =
            MetricScope::Sweep(SweepScope { along: None, coordinates: Vec::new(), replicates: 2 });
        let theory = theory.expected().map(|expected| expected.by(None));
        Metric::new(LENGTH, estimate, theory, scope)
    }

    /// A tiny deviation is not "+0.00 %", only a rounding error is called one, and a deviation from 0 does not repeat the value.
    #[test]
    fn deviations_add_to_the_value_and_rounding_is_named_only_where_it_is() {
        let text =
            |value: f64, theory: f64| deviation_text(&compared(Estimate::bare(value), theory));
        assert_eq!(text(3.0, 3.0), "0");
        assert_eq!(text(3.0 + 1e-10, 3.0), "within round-off");
        assert_eq!(text(3.0 + 3e-8, 3.0), "+1·10⁻⁶ %");
        assert_eq!(text(2.7, 3.0), "-10.00 %");
        assert_eq!(text(3e20, 3.0), "× 10²⁰");
        for repeated in [-3e20, 4e-9, 474.0, 1.96617] {
            assert_eq!(text(repeated, 0.0), "");
        }
        let with_error = |sigma: f64| deviation_text(&compared(Estimate::new(sigma, 1.0), 0.0));
        assert_eq!(with_error(-5.13), "-5.1 σ");
        assert_eq!(with_error(5e15), "over 1000 σ");
    }

    #[test]
    fn accuracy_range_and_reasons_are_shown() {
        let violation = Quantity::StepAngle.at_most(0.05, 0.02);
        let expected = ExpectedValue { value: 3.0, accuracy: Some(0.012), violation };
        let outside = compared(Estimate::new(4.0, 0.1), expected);
        assert_eq!(theory_text(&outside), "3 ± 0.012");
        assert_eq!(deviation_text(&outside), "out of range");
        let mut missing = compared(Estimate::bare(f64::NAN), 3.0);
        missing.reason = Some("the radii differ".into());
        assert_eq!(value_text(&missing), "none");
        let lines = reasons(&[&missing, &outside, &missing]);
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[0], "length, length: the radii differ");
        let stated = "length: the run is outside the range of its law: ω Δt is 0.05, above 0.02";
        assert!(lines[1].starts_with(stated), "{lines:?}");
    }

    #[test]
    fn sixty_columns_are_enough() {
        let scope =
            MetricScope::Sweep(SweepScope { along: None, coordinates: Vec::new(), replicates: 2 });
        const INTERCEPT: &Definition = &Definition {
            name: "pressure_vs_temperature.mean_speed_formula.intercept",
            unit: "N/(m K)",
            label: "quantity",
            how: "",
            laws: &[],
            rounding: 0.0,
        };
        let estimate = Estimate::new(-1.234_567e-23, 2.3e-24);
        let theory = 0.0.expected().map(|expected| expected.by(None));
        let metric = Metric::new(INTERCEPT, estimate, theory, scope);
        let text = table(&[&metric], Terminal { width: 60, colors: false });
        for line in text.lines() {
            assert!(line.chars().count() <= 60, "{line}");
        }
        assert!(text.contains("-1.23(23)·10⁻²³ N/(m K)") && text.contains("-5.4 σ"), "{text}");
        let violation = Quantity::StepAngle.at_most(0.01, 0.02);
        let bounded = ExpectedValue { value: 4.454_08e-4, accuracy: Some(2.2e-5), violation };
        let bounded = compared(Estimate::bare(4.452_09e-4), bounded);
        let text = table(&[&metric, &bounded], Terminal { width: 60, colors: false });
        for line in text.lines() {
            assert!(line.chars().count() <= 60, "{line}");
        }
        assert!(text.contains("± 2.2·10⁻⁵\n      inside the bound (-0.045 %)"), "{text}");
        let wide = table(&[&metric], Terminal { width: 120, colors: false });
        assert_eq!(wide.lines().count(), 2);
    }
}

//! The section of `report.html` with all numbers in one table: value with error, theory, deviation and check of a metric in one row; and
//! the definitions behind them.

use super::AnalysisReport;
use super::markup::{breakable, law_text, typographic};
use super::table::{deviation_text, reasons, theory_text, value_text};
use crate::checks::{CheckKind, CheckResult, subject};
use crate::input::coordinates::label;
use crate::metric::{Definition, Metric, MetricScope, symbols};
use kinetoscope_console::text::plural;
use kinetoscope_manifest::ViewRequest;
use maud::{Markup, html};
use std::collections::{BTreeMap, BTreeSet};

/// The checks of each metric, by the metric and its scope.
type Checks<'a> = BTreeMap<&'a str, Vec<&'a CheckResult>>;

/// Number of passed checks that are shown openly.
const PASSED_SHOWN: usize = 8;

/// The table of the checked numbers in the order of the checks, first those that fail; many that pass are collapsed. A check of a metric that no run
/// has is a row with its finding.
pub(super) fn checked(report: &AnalysisReport) -> Markup {
    let mut checks: Vec<(&str, Vec<&CheckResult>)> = Vec::new();
    for result in report.check_results.iter().filter(|result| result.kind == CheckKind::Check) {
        match checks.iter_mut().find(|(subject, _)| *subject == result.subject) {
            Some((_, results)) => results.push(result),
            None => checks.push((&result.subject, vec![result])),
        }
    }
    let (passed, mut shown): (Vec<_>, Vec<_>) =
        checks.into_iter().partition(|(_, results)| results.iter().all(|result| result.passed));
    let mut passed = passed.into_iter();
    shown.extend(passed.by_ref().take(PASSED_SHOWN));
    let folded: Vec<_> = passed.collect();
    // Means over replicates precede the runs that they are of.
    let mut metrics: BTreeMap<String, &Metric> = BTreeMap::new();
    for metric in &report.metrics {
        metrics.entry(subject(metric)).or_insert(metric);
    }
    let rows = |checks: &[(&str, Vec<&CheckResult>)]| {
        html! {
            @for (subject, results) in checks {
                @match metrics.get(*subject) {
                    Some(metric) => (row(metric, results, Some(&report.view))),
                    None => tr {
                        td { (breakable(subject)) }
                        td colspan="4" { (typographic(&results[0].finding)) }
                        td data-label="" { (check_results(results)) }
                    },
                }
            }
        }
    };
    html! {
        @if !shown.is_empty() {
            section {
                h2 { "Checked numbers" }
                table class="numbers" { (head(true)) tbody { (rows(&shown)) } }
                @if !folded.is_empty() {
                    details class="printed" {
                        summary { (folded.len()) " more passed checks" }
                        table class="numbers" { (head(true)) tbody { (rows(&folded)) } }
                    }
                }
            }
        }
    }
}

fn head(has_checks: bool) -> Markup {
    html! {
        thead {
            tr {
                th { "quantity" } th { "value" } th { "unit" } th { "theory" }
                th { "deviation" } @if has_checks { th { "check" } } @else { td {} }
            }
        }
    }
}

/// The table of all numbers, collapsed.
pub(super) fn section(report: &AnalysisReport) -> Markup {
    let mut checks = Checks::new();
    for result in report.check_results.iter().filter(|result| result.kind == CheckKind::Check) {
        checks.entry(&result.subject).or_default().push(result);
    }
    let sections = report.sections();
    let shown = || sections.iter().flat_map(|(_, metrics)| metrics);
    let has_checks = shown().any(|metric| checks.contains_key(subject(metric).as_str()));
    let widths = [value_text, theory_text].map(|text| {
        let texts = shown().map(|metric| whole_part(&text(metric)).chars().count());
        texts.max().unwrap_or(0)
    });
    html! {
        details class="printed" {
            summary { h2 { "All numbers" } " " span class="facts" { (shown().count()) } }
            p class="facts" {
                "Digits in brackets are one standard error, in units of the last digits. "
                "σ is the deviation from theory in standard errors; with few degrees of freedom ν it is the equally probable one of a normal distribution, by Student's t. "
                "A theoretical value is followed by the accuracy of its law, if that is not exact. "
                "Each name leads to its definition."
            }
            table class="numbers" style=(format!("--value:{}ch;--theory:{}ch", widths[0], widths[1])) {
                (head(has_checks))
                @for (title, metrics) in &sections { (group(title, metrics, &checks)) }
            }
        }
    }
}

/// The rows of one run, of one point or of the sweep. Metrics that are zero by construction are collapsed.
fn group(title: &str, metrics: &[&Metric], checks: &Checks<'_>) -> Markup {
    let of_metric = |metric: &Metric| checks.get(subject(metric).as_str()).map(Vec::as_slice);
    let (zeros, rows): (Vec<&Metric>, Vec<&Metric>) = metrics
        .iter()
        .partition(|metric| is_zero_by_construction(metric) && of_metric(metric).is_none());
    let reasons = reasons(metrics);
    html! {
        tbody {
            tr class="group" { th colspan="6" scope="rowgroup" { (breakable(title)) } }
            @for metric in rows { (row(metric, of_metric(metric).unwrap_or_default(), None)) }
            @if !zeros.is_empty() {
                tr class="group" {
                    td colspan="6" {
                        details {
                            @let count = plural(zeros.len() as u64, "metric");
                            summary { "0 in this run: " (count) " without a theoretical value" }
                            @for (index, metric) in zeros.iter().enumerate() {
                                @if index > 0 { ", " }
                                (name(metric))
                            }
                        }
                    }
                }
            }
            @if !reasons.is_empty() {
                tr class="group" {
                    td colspan="6" { ul { @for line in &reasons { li { (breakable(line)) } } } }
                }
            }
        }
    }
}

/// Whether a value is exactly zero, without an error and without a theoretical value: nothing of its kind occurs in the run.
fn is_zero_by_construction(metric: &Metric) -> bool {
    metric.value() == 0.0 && metric.standard_error().is_none() && metric.theory.is_none()
}

/// A metric with its checks; with its place in the sweep as a view names it, unless its group names that.
fn row(metric: &Metric, checks: &[&CheckResult], place_in: Option<&ViewRequest>) -> Markup {
    let is_bare = metric.unit() == "1" || !metric.value().is_finite();
    let unit = if is_bare { "" } else { metric.unit() };
    let deviation = typographic(&deviation_text(metric));
    let theory = theory_text(metric);
    let label = |label: &'static str, text: &str| if text.is_empty() { "" } else { label };
    html! {
        tr {
            td {
                @if let Some(view) = place_in { (quantity(metric)) span class="facts" { (place(metric, view)) } }
                @else { (name(metric)) }
            }
            td class="value" data-label="" { (aligned(&value_text(metric))) }
            td class="unit" data-label="" { (unit) }
            td class="theory" data-label=(label("theory", &theory)) { (aligned(&theory)) }
            td class="deviation" data-label=(label("deviation", &deviation)) { (deviation) }
            td data-label="" { (check_results(checks)) }
        }
    }
}

/// The place of a metric in the sweep, in words after a comma; empty for a single run.
fn place(metric: &Metric, view: &ViewRequest) -> String {
    let replicate = match &metric.scope {
        MetricScope::Run(run) if run.replicate > 0 => format!("replicate {}", run.replicate),
        _ => String::new(),
    };
    let parts = [label(&view.named(metric.coordinates())), replicate];
    parts.into_iter().filter(|part| !part.is_empty()).map(|part| format!(", {part}")).collect()
}

fn check_results(checks: &[&CheckResult]) -> Markup {
    html! {
        @for (index, check) in checks.iter().enumerate() {
            @if index > 0 { br; }
            @let (class, word) = if check.passed { ("good", "ok") } else { ("bad", "failed") };
            strong class=(class) { (word) } ": "
            span title=(check.finding) { (typographic(&check.requirement)) }
        }
    }
}

/// A metric in words, which lead to its definition and show its name under the pointer.
fn quantity(metric: &Metric) -> Markup {
    html! {
        a href=(format!("#{}", anchor(metric.definition))) title=(metric.name()) {
            (metric.definition.label)
        }
    }
}

/// A metric's name, which leads to its definition and shows it under the pointer.
fn name(metric: &Metric) -> Markup {
    html! {
        a href=(format!("#{}", anchor(metric.definition))) title=(metric.definition.how) {
            (breakable(metric.name()))
        }
    }
}

/// A number in two parts that meet at the decimal point, so that a column aligns there.
fn aligned(number: &str) -> Markup {
    let whole = whole_part(number);
    let rest = &number[whole.len()..];
    html! {
        @if whole.is_empty() { (number) }
        @else { span class="whole" { (typographic(whole)) } (typographic(rest)) }
    }
}

/// The sign and the digits before the decimal point.
fn whole_part(number: &str) -> &str {
    let unsigned = number.trim_start_matches('-');
    let rest = unsigned.trim_start_matches(|digit: char| digit.is_ascii_digit());
    &number[..number.len() - rest.len()]
}

/// The name of a definition's place in the page.
fn anchor(definition: &Definition) -> String {
    format!("metric-{}", definition.name)
}

/// How each metric of this report is derived, and the laws behind its theoretical value.
pub(super) fn definitions(report: &AnalysisReport) -> Markup {
    let mut listed = BTreeSet::new();
    let all = report.metrics.iter().map(|metric| metric.definition);
    let definitions = all.filter(|definition| listed.insert((definition.name, definition.how)));
    let definitions: Vec<&Definition> = definitions.collect();
    let formulas = definitions.iter().flat_map(|definition| {
        definition.laws.iter().map(|law| law.statement).chain([definition.how])
    });
    let symbols: Vec<String> =
        symbols::used(formulas).map(|(symbol, meaning)| format!("{symbol}: {meaning}")).collect();
    html! {
        details class="definitions" {
            summary { h2 { "Definitions" } " " span class="facts" { (definitions.len()) } }
            @if !symbols.is_empty() { p { (symbols.join(" · ")) } }
            dl {
                @for definition in definitions {
                    @let laws: Vec<String> = definition.laws.iter().map(law_text).collect();
                    dt id=(anchor(definition)) { (breakable(definition.name)) }
                    dd {
                        (definition.how)
                        @if !laws.is_empty() { br; "Theory: " (laws.join("; or ")) }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::SweepScope;
    use crate::metric::theory::Expected as _;
    use crate::statistics::Estimate;

    const FORCE: &Definition = &Definition {
        name: "force.mean",
        unit: "N",
        label: "quantity",
        how: "<F> & \"more\"",
        laws: &[],
        rounding: 0.0,
    };

    fn metric(value: f64, theory: Option<f64>) -> Metric {
        let scope =
            MetricScope::Sweep(SweepScope { along: None, coordinates: Vec::new(), replicates: 1 });
        let theory = theory.expected().map(|expected| expected.by(None));
        Metric::new(FORCE, Estimate::bare(value), theory, scope)
    }

    fn check(passed: bool) -> CheckResult {
        CheckResult {
            passed,
            kind: CheckKind::Check,
            subject: "force.mean".to_owned(),
            run: None,
            requirement: "at most <2>".to_owned(),
            finding: "measured \"3\"".to_owned(),
            file: None,
            line: 1,
            seconds: 0.0,
        }
    }

    #[test]
    fn numbers_are_split_at_the_decimal_point() {
        for (number, whole) in
            [("-0.01961(73)", "-0"), ("12345(25)", "12345"), ("1.3·10⁻¹⁸", "1"), ("none", "")]
        {
            assert_eq!(whole_part(number), whole);
        }
        let cell = aligned("-12.5(3)").into_string();
        assert_eq!(cell, "<span class=\"whole\">−12</span>.5(3)");
    }

    #[test]
    fn row_holds_the_check_and_definitions_are_escaped() {
        let (passed, failed) = (check(true), check(false));
        let row = row(&metric(3.0, Some(2.0)), &[&passed, &failed], None).into_string();
        assert!(row.contains("<strong class=\"good\">ok</strong>"), "{row}");
        assert!(row.contains("<strong class=\"bad\">failed</strong>"), "{row}");
        assert!(
            row.contains("at most &lt;2&gt;") && row.contains("measured &quot;3&quot;"),
            "{row}"
        );
        assert!(row.contains("title=\"&lt;F&gt; &amp; &quot;more&quot;\""), "{row}");
        assert!(row.contains("href=\"#metric-force.mean\""), "{row}");
        assert!(row.contains("<td class=\"unit\" data-label=\"\">N</td>"), "{row}");
        let missing = super::row(&metric(f64::NAN, None), &[], None).into_string();
        assert!(
            missing.contains(">none</td><td class=\"unit\" data-label=\"\"></td>"),
            "{missing}"
        );
    }

    /// Guarantee: zeros are collapsed only where they say nothing. Control: a zero that theory predicts, or that is checked, has a row.
    #[test]
    fn zeros_by_construction_are_collapsed() {
        let (zero, predicted, positive) =
            (metric(0.0, None), metric(0.0, Some(0.0)), metric(1.0, None));
        let result = check(true);
        let none = Checks::new();
        let checked = Checks::from([("force.mean", vec![&result])]);
        let collapsed = |metric: &Metric, checks: &Checks<'_>| {
            group("run", &[metric], checks).into_string().contains("<details>")
        };
        assert!(collapsed(&zero, &none));
        assert!(!collapsed(&predicted, &none) && !collapsed(&positive, &none));
        assert!(!collapsed(&zero, &checked));
    }
}

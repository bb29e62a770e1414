//! Plots as SVG: charts with axes, and pictures of a state to scale.

mod axis;
mod canvas;
mod chart;
mod chart_size;
mod curve;
pub(crate) mod drawing;
mod legend;
pub(crate) mod page;
pub(crate) mod palette;
mod picture;
#[cfg(feature = "png")]
pub(crate) mod png;
#[cfg(not(feature = "png"))]
#[path = "no_png.rs"]
pub(crate) mod png;
pub(crate) mod shapes_svg;
pub(crate) mod velocity_field;
mod word_labels;

pub(crate) use axis::{Axis, Scale, extremes};
use canvas::DrawingError;
pub(crate) use chart::Chart;
pub(crate) use chart_size::ChartSize;
pub(crate) use curve::{Curve, CurveStyle, Point, stacked, thinned};
pub(crate) use legend::SLOPE;
pub(crate) use picture::Picture;

use kinetoscope_console::text::visible;
use serde::{Deserialize, Serialize};

/// The engine of a page has the curves of charts only: it contains no code of pictures and replays.
pub(crate) const DRAWS: bool = !cfg!(all(target_family = "wasm", target_os = "unknown"));

/// Boltzmann's constant with its subscript, as the unit of an axis.
const BOLTZMANN_CONSTANT: &str =
    "(k<tspan dy=\"0.25em\" font-size=\"75%\">B</tspan><tspan dy=\"-0.19em\">)</tspan>";

/// A plot with its title and its file name without the extension.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Plot {
    pub(crate) stem: String,
    pub(crate) title: String,
    pub(crate) content: PlotContent,
}

/// What a plot shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum PlotContent {
    /// Curves and points over two axes.
    Chart(Chart),
    /// A picture of particles in their container, to scale.
    Picture(Picture),
}

impl Plot {
    /// A chart with unequal axes.
    pub(crate) fn chart(
        stem: impl Into<String>,
        title: impl Into<String>,
        [x, y]: [Axis; 2],
        curves: Vec<Curve>,
    ) -> Self {
        let remark = String::new();
        let content = PlotContent::Chart(Chart { x, y, equal_aspect: false, curves, remark });
        Self { stem: stem.into(), title: title.into(), content }
    }

    /// The points of the data that logarithmic axes cannot show, in words; `None` if there are none.
    pub(crate) fn hidden_data(&self) -> Option<String> {
        match &self.content {
            PlotContent::Chart(chart) => chart.hidden_data(),
            PlotContent::Picture(_) => None,
        }
    }

    /// The same plot with a remark below, if it is a chart.
    pub(crate) fn with_remark(mut self, remark: &str) -> Self {
        if let PlotContent::Chart(chart) = &mut self.content {
            chart.remark = remark.to_owned();
        }
        self
    }

    /// Whether two plots have the same curves, or are the same picture. Titles and remarks may differ.
    pub(crate) fn shows_the_same_as(&self, other: &Self) -> bool {
        match (&self.content, &other.content) {
            (PlotContent::Chart(one), PlotContent::Chart(other)) => one.curves == other.curves,
            (one, other) => one == other,
        }
    }

    /// Whether the first curve of two charts has the same points over the same axes.
    pub(crate) fn draws_the_points_of(&self, other: &Self) -> bool {
        let (PlotContent::Chart(one), PlotContent::Chart(other)) = (&self.content, &other.content)
        else {
            return false;
        };
        let [points, others] =
            [one, other].map(|chart| chart.curves.first().map(|curve| &curve.points));
        one.x.label == other.x.label && one.y.label == other.y.label && points == others
    }

    /// Whether the plot shows more than one number: not one dot, and not a flat line.
    pub(crate) fn is_informative(&self) -> bool {
        match &self.content {
            PlotContent::Chart(chart) => chart.is_informative(),
            PlotContent::Picture(_) => true,
        }
    }

    /// The plot as an SVG document; `None` if it is empty. Characters that XML does not allow are escaped.
    pub(crate) fn svg(&self) -> Result<Option<String>, DrawingError> {
        self.svg_of(None)
    }

    /// The plot as [`Self::svg`], with a chart of this size.
    pub(crate) fn svg_of(&self, size: Option<ChartSize>) -> Result<Option<String>, DrawingError> {
        let svg = match &self.content {
            // The drawing library escapes markup, but not these characters.
            PlotContent::Chart(chart) => chart.svg(&self.title, size)?,
            PlotContent::Picture(picture) => picture.svg(&self.title),
        };
        let svg = svg.map(|svg| svg.replace("(k_B)", BOLTZMANN_CONSTANT));
        // TeamCity and Azure find commands such as `##vso[…]` anywhere in a line.
        Ok(svg.map(|svg| visible(&in_lines_of_elements(&svg)).replace("##", "#&#35;")))
    }
}

/// The SVG with each text in the line of its element: a line that begins with a name from a manifest could be a command of a CI system
/// that reads the output.
fn in_lines_of_elements(svg: &str) -> String {
    let mut joined = String::with_capacity(svg.len());
    let mut is_in_text = false;
    for line in svg.lines() {
        joined.push_str(line);
        is_in_text = (is_in_text || line.starts_with("<text")) && !line.contains("</text>");
        if !is_in_text {
            joined.push('\n');
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guarantee: no line of an SVG is a command of a CI system.
    #[test]
    fn texts_are_in_the_lines_of_their_elements() {
        let points = [(0.0, 1.0), (1.0, 2.0)];
        let words = ["::a::b", "##vso[c]d"].map(str::to_owned).to_vec();
        let x = Axis { words, ..Axis::linear("::x::", "") };
        let curve = Curve::new("::error::c", CurveStyle::Data, 0, points);
        let plot =
            Plot::chart("s", "::error::t\n::error::u", [x, Axis::linear("y", "")], vec![curve]);
        let svg = plot.with_remark("::warning::r").svg().unwrap().unwrap();
        assert!(svg.contains("::error::c</text>") && svg.contains("#&#35;vso[c]d</text>"), "{svg}");
        assert!(svg.lines().all(|line| line.starts_with('<')), "{svg}");
    }

    fn svg_of(axes: [Axis; 2], curves: Vec<Curve>) -> String {
        Plot::chart("a", "a", axes, curves).svg().unwrap().unwrap()
    }

    /// Guarantee: values and theory of one method are one entry of the legend. Control: theory of another name has its own.
    #[test]
    fn theory_named_after_its_curve_shares_its_entry() {
        let curve =
            |name: &str, style, color| Curve::new(name, style, color, [(1.0, 2.0), (2.0, 4.0)]);
        let texts = |theory: &str| {
            let curves =
                vec![curve("RK4", CurveStyle::Data, 0), curve(theory, CurveStyle::Theory, 0)];
            svg_of([Axis::linear("x", ""), Axis::linear("y", "")], curves)
        };
        let shared = texts("RK4: order 4");
        assert!(shared.contains("RK4</text>") && !shared.contains("order 4"), "{shared}");
        assert!(texts("theory").contains("theory</text>"), "control");
        assert!(texts("RK4: slope 4").contains("RK4, slope 4</text>"), "a slope is stated");
    }

    /// Guarantee: a fit and theory of one color differ in their lines and have entries of their own, so that print and color vision do not matter; so do
    /// theories of both rounds of colors. Control: theories of one round have the same dashes.
    #[test]
    fn fits_and_theory_differ_without_colors() {
        let drawn = |curves: &[(&str, CurveStyle, usize)]| {
            let all = [("RK4", CurveStyle::Data, 0)].into_iter().chain(curves.iter().copied());
            let curve =
                |(name, style, color)| Curve::new(name, style, color, [(1.0, 2.0), (2.0, 4.0)]);
            svg_of([Axis::linear("x", ""), Axis::linear("y", "")], all.map(curve).collect())
        };
        let lines = |style, color| drawn(&[("line", style, color)]).matches("<polyline").count();
        let [theory, fit, dotted] =
            [(CurveStyle::Theory, 0), (CurveStyle::Fit, 0), (CurveStyle::Theory, 7)]
                .map(|(style, color)| lines(style, color));
        assert!(fit + 20 < theory && theory + 20 < dotted, "{fit} {theory} {dotted}");
        assert_eq!(theory, lines(CurveStyle::Theory, 6), "control");
        let both = drawn(&[
            ("RK4: theory", CurveStyle::Theory, 0),
            ("RK4: fit, slope 2", CurveStyle::Fit, 0),
        ]);
        assert!(
            both.contains("RK4: fit, slope 2</text>") && !both.contains("RK4: theory"),
            "{both}"
        );
    }

    /// Guarantee: a logarithmic axis of an error that grows begins at its first value; rounding below it does not stretch the axis.
    /// Control: an axis of a quantity that falls shows all of it.
    #[test]
    fn rounding_does_not_stretch_a_logarithmic_axis() {
        let floor = |values: &[f64]| {
            let points = values.iter().enumerate().map(|(index, value)| (index as f64, *value));
            let axes = [Axis::linear("t", ""), Axis::logarithmic("error", "")];
            let plot = Plot::chart("a", "a", axes, vec![Curve::line("", 0, points)]);
            let PlotContent::Chart(chart) = plot.content else { panic!("no chart") };
            chart.floor(&chart.curves)
        };
        assert_eq!(floor(&[0.0, 1e-6, 1e-3, 1e-16, 1e-2]), Some(1e-6));
        assert_eq!(floor(&[1.0, 1e-3, 1e-6]), Some(1e-6), "control");
    }

    /// Guarantee: areas stack to the sum of their amounts, none is negative, and the shifts are known.
    #[test]
    fn areas_stack_to_the_sum_of_their_amounts() {
        let times: Vec<f64> = (0..2000).map(f64::from).collect();
        let falling: Vec<f64> = times.iter().map(|time| 5.0 - 0.01 * time).collect();
        let columns = [("a", 0, vec![2.0; 2000]), ("b", 1, falling)];
        let (areas, shifts) = stacked(&times, &columns);
        assert!((shifts - 14.99).abs() < 1e-12, "{shifts}");
        let tops = &areas[1].points;
        assert!(tops.len() < 1500 && tops.last().unwrap().x == 1999.0);
        for (lower, upper) in areas[0].points.iter().zip(tops) {
            let sum = 2.0 + 5.0 - 0.01 * upper.x + shifts;
            assert!((upper.y - sum).abs() < 1e-9 && upper.y >= lower.y, "{upper:?}");
        }
    }

    /// Guarantee: one dot and a flat line are no plots. Control: two dots, and a flat line away from theory, are.
    #[test]
    fn plots_without_information_are_recognized() {
        let is_informative = |curves: Vec<Curve>| {
            let axes = [Axis::linear("x", ""), Axis::linear("y", "")];
            Plot::chart("a", "a", axes, curves).is_informative()
        };
        let data =
            |points: &[(f64, f64)]| Curve::new("", CurveStyle::Data, 0, points.iter().copied());
        let level = |y: f64| Curve::theory("", 1, [(0.0, y), (1.0, y)]);
        assert!(!is_informative(vec![data(&[(0.5, 2.0)])]));
        assert!(!is_informative(vec![data(&[(0.5, 2.0)]), level(3.0)]), "one dot below theory");
        assert!(!is_informative(vec![data(&[(0.0, 2.0), (1.0, 2.0 + 1e-12)])]), "flat");
        assert!(!is_informative(vec![data(&[(0.0, 0.0), (1.0, 0.0)]), level(0.0)]), "zero");
        assert!(!is_informative(Vec::new()));
        assert!(is_informative(vec![data(&[(0.0, 2.0), (1.0, 2.1)])]));
        assert!(is_informative(vec![data(&[(0.0, 2.0), (1.0, 2.0)]), level(3.0)]));
    }
}

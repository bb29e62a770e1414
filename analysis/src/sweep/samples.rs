//! The points of a plot of a metric: its values over a swept key or over another metric.

use super::swept_key::{position, swept_key, words};
use crate::input::coordinates::{self, CoordinateValue, grouped, last_part, value_of};
use crate::input::key_words::words_and_unit;
use crate::metric::{Definition, Theory};
use crate::models::{MODELS, label_of};
use crate::number_text::{six_digits, with_error};
use crate::plot::{Curve, CurveStyle, Point};
use crate::run::RunAnalysis;
use crate::statistics::Estimate;
use crate::sweep::SweepPoint;
use crate::sweep::figures::{MAX_CURVES, MEASURED};
use kinetoscope_console::Message;
use kinetoscope_manifest::{Axis as SweptAxis, Coordinate, RunManifest, manifest_values};

/// What the horizontal axis of a plot of metrics shows.
pub(crate) enum Abscissa {
    /// A swept key, with its words in the order of the sweep if its values are not numbers.
    Key {
        /// The full name.
        key: String,
        /// The words; empty for numbers.
        words: Vec<String>,
    },
    /// Another metric.
    Metric(&'static Definition),
    /// The full name of a key to which the variants of a sweep give different numbers.
    Set(String),
}

impl Abscissa {
    /// The requested swept key, metric or key of the variants, or the only numeric key, or the only key.
    ///
    /// # Errors
    /// A name that is none of them, or a choice among several keys, with the keys.
    pub(crate) fn find<'a>(
        requested: Option<&str>,
        places: &[Vec<Coordinate>],
        axes: &[SweptAxis],
        manifests: impl Iterator<Item = &'a RunManifest>,
    ) -> Result<Self, Message> {
        let manifests: Vec<&RunManifest> = manifests.collect();
        let found = swept_key(requested, places, axes);
        let other = requested.filter(|_| found.is_err());
        let model = manifests.first().map_or("", |manifest| manifest.model.name());
        if let Some(metric) = other.and_then(|name| definition(model, name)) {
            return Ok(Self::Metric(metric));
        }
        if let Some(key) = other.and_then(|name| set_key(name, &manifests)) {
            return Ok(Self::Set(key));
        }
        found.map(|key| Self::Key { words: words(&key, places), key })
    }

    /// The place of a point of the sweep.
    fn of_point(&self, point: &SweepPoint<'_>) -> Option<f64> {
        match self {
            Self::Key { .. } => self.of_place(&point.coordinates),
            Self::Metric(metric) => point.mean_of(metric.name).map(|(mean, ..)| mean.value),
            Self::Set(key) => point.runs.first().and_then(|run| number_set(&run.manifest, key)),
        }
        .filter(|place| place.is_finite())
    }

    /// The place of a run.
    pub(super) fn of_run(&self, run: &RunAnalysis) -> Option<f64> {
        match self {
            Self::Key { .. } => self.of_place(&run.coordinates),
            Self::Metric(metric) => run.measurement(metric.name).map(|found| found.estimate.value),
            Self::Set(key) => number_set(&run.manifest, key),
        }
        .filter(|place| place.is_finite())
    }

    /// The place of a fit, which has coordinates only.
    pub(super) fn of_place(&self, place: &[Coordinate]) -> Option<f64> {
        match self {
            Self::Key { key, words } => position(place, key, words),
            Self::Metric(_) | Self::Set(_) => None,
        }
    }

    /// The name of the quantity, and its unit.
    pub(super) fn label(&self) -> (String, String) {
        match self {
            Self::Key { key, .. } | Self::Set(key) => {
                let (words, unit) = words_and_unit(last_part(key));
                (words, unit.to_owned())
            }
            Self::Metric(metric) => (label(metric.name).0, typographic_unit(metric.unit)),
        }
    }

    /// The words in place of numbers; empty for numbers.
    pub(super) fn words(&self) -> &[String] {
        match self {
            Self::Key { words, .. } => words,
            Self::Metric(_) | Self::Set(_) => &[],
        }
    }

    /// The name of the key or metric, as the manifest writes it.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Key { key, .. } | Self::Set(key) => last_part(key),
            Self::Metric(metric) => metric.name,
        }
    }

    /// The coordinates that distinguish the curves. Points that differ in the key of the axis share a curve; over a metric, points
    /// that differ in numbers only, or all points of a sweep without numbers.
    fn distinguishing(&self, place: &[Coordinate], axes: &[SweptAxis]) -> Vec<Coordinate> {
        let is_number = |it: &Coordinate| !matches!(value_of(it), CoordinateValue::Text(_));
        let has_numbers = place.iter().any(is_number);
        let is_along = |coordinate: &&Coordinate| match self {
            Self::Key { key, .. } => {
                let is = |key: &String| *key == coordinate.key;
                // Keys that advance together with the key are not coordinates of a curve.
                is(key)
                    || axes.iter().any(|axis| axis.keys.contains(key) && axis.keys.iter().any(is))
            }
            Self::Metric(_) => !has_numbers || is_number(coordinate),
            Self::Set(_) => coordinate.key == "variant",
        };
        place.iter().filter(|coordinate| !is_along(coordinate)).cloned().collect()
    }
}

/// The key with this full name or last part to which the runs' manifests give different numbers.
fn set_key(name: &str, all: &[&RunManifest]) -> Option<String> {
    let values = manifest_values(&all.first()?.canonical());
    let mut keys = values.into_iter().map(|(key, _)| key);
    let key = keys.find(|key| key == name || last_part(key) == name)?;
    let numbers: Option<Vec<f64>> = all.iter().map(|it| number_set(it, &key)).collect();
    numbers.is_some_and(|numbers| numbers.iter().any(|it| *it != numbers[0])).then_some(key)
}

/// The number that a manifest gives to a key.
fn number_set(manifest: &RunManifest, key: &str) -> Option<f64> {
    let mut values = manifest_values(&manifest.canonical()).into_iter();
    values.find(|(other, _)| other == key)?.1.parse().ok()
}

/// A value at a point of the sweep.
pub(super) struct Sample {
    pub(super) coordinates: Vec<Coordinate>,
    /// Place on the horizontal axis.
    pub(super) x: Option<f64>,
    pub(super) estimate: Option<Estimate>,
    pub(super) theory: Option<f64>,
    /// What the theory is called.
    pub(super) law: &'static str,
}

impl Sample {
    /// The mean of a metric at a point of the sweep.
    pub(super) fn of_point(point: &SweepPoint<'_>, metric: &str, abscissa: &Abscissa) -> Self {
        let found = point.mean_of(metric);
        Self {
            coordinates: point.coordinates.clone(),
            x: abscissa.of_point(point),
            estimate: found.map(|(estimate, ..)| estimate),
            theory: found.and_then(|(_, theory, _)| theory?.applicable()),
            law: title_of(found.and_then(|(_, theory, _)| theory)),
        }
    }

    /// Whether the metric has a value there.
    pub(super) fn has_value(&self) -> bool {
        self.estimate.is_some_and(|estimate| estimate.value.is_finite())
    }

    /// Its place with its numbers: theory is a line only between several points.
    pub(super) fn described(&self, unit: &str) -> String {
        let with_unit = |number: String| format!("{number} {unit}").trim_end().to_owned();
        let measured = self.estimate.map_or_else(String::new, |estimate| {
            with_unit(with_error(estimate.value, estimate.standard_error))
        });
        let theory =
            self.theory.map(|theory| format!(", theory {}", with_unit(six_digits(theory))));
        let place = coordinates::label(&self.coordinates);
        format!("{place}: measured {measured}{}", theory.unwrap_or_default())
    }
}

/// What a legend calls a theoretical value.
pub(super) fn title_of(theory: Option<Theory>) -> &'static str {
    theory.and_then(|theory| theory.law).map_or("theory", |law| law.title())
}

/// The curves of points that differ along the horizontal axis only.
pub(super) struct Group {
    /// The coordinates that distinguish it from the others.
    pub(super) coordinates: Vec<Coordinate>,
    /// Its data, and its theory if there is one.
    pub(super) curves: Vec<Curve>,
}

/// One curve of data and one of theory for each group of points that differ along the horizontal axis only, in colors from the first.
/// `name` is that of the metric if the plot has several, or else empty.
pub(super) fn groups(
    samples: &[Sample],
    abscissa: &Abscissa,
    axes: &[SweptAxis],
    (name, first_color): (&str, usize),
    remarks: &mut Vec<String>,
) -> Vec<Group> {
    let distinguishing = |sample: &Sample| abscissa.distinguishing(&sample.coordinates, axes);
    let mut groups = grouped(samples.iter().map(|sample| (distinguishing(sample), sample)));
    groups.retain(|(_, group)| group.iter().any(|sample| sample.has_value()));
    let most = MAX_CURVES - first_color.min(MAX_CURVES);
    if groups.len() > most {
        remarks.push(format!("the first {most} of {} curves", groups.len()));
    }
    let groups = groups.into_iter().take(most).enumerate();
    groups
        .map(|(index, (coordinates, samples))| {
            let place = coordinates::label(&coordinates);
            let parts = [name, place.as_str()].into_iter().filter(|part| !part.is_empty());
            let name = parts.collect::<Vec<_>>().join(", ");
            let curves = curves_of(&samples, &name, first_color + index, abscissa);
            Group { coordinates, curves }
        })
        .collect()
}

/// The data and the theory of one group.
fn curves_of(samples: &[&Sample], name: &str, color: usize, abscissa: &Abscissa) -> Vec<Curve> {
    let (mut data, mut theory) = (Vec::new(), Vec::new());
    for sample in samples {
        let Some(x) = sample.x else { continue };
        if let Some(estimate) = sample.estimate.filter(|_| sample.has_value()) {
            data.push(Point { x, y: estimate.value, error: estimate.standard_error });
        }
        theory.extend(sample.theory.map(|y| Point::bare(x, y)));
    }
    let law = samples.iter().find(|sample| sample.theory.is_some()).map_or("", |it| it.law);
    let of_theory = if name.is_empty() { law.to_owned() } else { format!("{name}: {law}") };
    let measured = if name.is_empty() { MEASURED } else { name };
    let mut curves = Vec::new();
    for (name, style, mut points) in
        [(measured.to_owned(), CurveStyle::Data, data), (of_theory, CurveStyle::Theory, theory)]
    {
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        // A line needs two points, except over words.
        let least = usize::from(style == CurveStyle::Theory && abscissa.words().is_empty());
        if points.len() > least {
            curves.push(Curve { name, style, color, points });
        }
    }
    curves
}

/// The definition of a metric of a model's runs or of sweeps over them.
pub(super) fn definition(model: &str, name: &str) -> Option<&'static Definition> {
    let models = MODELS.iter().filter(|known| known.name == model);
    let mut all = models.flat_map(|model| model.metrics.iter().chain(model.sweep_metrics));
    all.find(|definition| definition.name == name).copied()
}

/// The name of a metric in words, and whether it follows a power law.
pub(super) fn label(metric: &str) -> (String, bool) {
    let mut ordinates = MODELS.iter().flat_map(|model| model.ordinates);
    match ordinates.find(|ordinate| ordinate.metric == metric) {
        Some(ordinate) => (ordinate.title.to_owned(), ordinate.is_power_law),
        None => {
            let words = || metric.replace(['.', '_'], " ");
            (label_of(metric).map_or_else(words, str::to_owned), false)
        }
    }
}

/// A unit of a metric with raised exponents, such as m²/s²; empty for a pure number.
pub(crate) fn typographic_unit(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        "d" => "days".to_owned(),
        unit => unit.replace("^2", "²").replace("^3", "³"),
    }
}

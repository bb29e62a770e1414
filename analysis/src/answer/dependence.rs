//! How listed values depend on the swept key, in words that follow from these values alone.

use crate::input::coordinates::VARIANT;
use crate::metric::Metric;
use crate::number_text::significant;
use kinetoscope_manifest::Coordinate;

/// The powers that are named, the simplest first.
const POWERS: [(f64, &str); 6] = [
    (1.0, "is proportional to the"),
    (-1.0, "is inversely proportional to the"),
    (2.0, "is proportional to the square of the"),
    (0.5, "is proportional to the square root of the"),
    (-2.0, "is inversely proportional to the square of the"),
    (-0.5, "is inversely proportional to the square root of the"),
];

/// Largest relative difference of the values over the power that is named as one.
const LARGEST_SPREAD: f64 = 0.05;
/// Least number of points that show a dependence. Two have an exponent, too.
const LEAST_POINTS: usize = 3;
/// Largest difference of the exponents between neighboring points that are stated.
const LARGEST_RANGE: f64 = 0.5;
/// Largest standard error of an exponent that is stated with one decimal.
const LARGEST_ERROR: f64 = 0.05;

/// Largest relative difference between values that are said to change little.
const LARGEST_CHANGE: f64 = 0.02;

/// How values depend on a swept key. Indices are those of the metrics.
#[derive(Debug, PartialEq)]
pub(super) enum Dependence {
    /// Nothing simple to say.
    None,
    /// A verb that needs only two of the values, such as "is proportional to the temperature within 0.2 %".
    OfEnds {
        /// The verb with its object.
        verb: String,
        /// The value to state first.
        first: usize,
        /// The value to state last.
        last: usize,
    },
    /// Words after all values.
    Remark(String),
    /// The greatest value is neither the first nor the last.
    GreatestAt(usize),
    /// The least value is neither the first nor the last.
    LeastAt(usize),
}

/// The dependence of values with this sign on the only number that is swept. `name` gives the words for a key.
pub(super) fn dependence(
    metrics: &[&Metric],
    sign: f64,
    name: impl Fn(&Coordinate) -> String,
) -> Dependence {
    let point = |(index, metric): (usize, &&Metric)| match metric.coordinates() {
        [only] if only.key != VARIANT => {
            let error = metric.standard_error().unwrap_or(0.0);
            Some((index, [only.value.parse::<f64>().ok()?, sign * metric.value(), error]))
        }
        _ => None,
    };
    let points: Option<Vec<(usize, [f64; 3])>> = metrics.iter().enumerate().map(point).collect();
    let Some(mut points) = points.filter(|points| points.len() >= 2) else {
        return Dependence::None;
    };
    points.sort_by(|(_, one), (_, other)| one[0].total_cmp(&other[0]));
    let key = name(&metrics[0].coordinates()[0]);
    let (indices, points): (Vec<usize>, Vec<[f64; 3]>) = points.into_iter().unzip();
    let exponents = exponents(&points);
    if points.len() < LEAST_POINTS {
        let between = |range| format!(", an exponent of {range} in the {key}");
        return exponents.map(between).map_or(Dependence::None, Dependence::Remark);
    }
    let values: Vec<(f64, f64)> = points.iter().map(|[x, y, _]| (*x, *y)).collect();
    let (first, last) = (indices[0], indices[indices.len() - 1]);
    let has_risen = rises_beyond_errors(&points);
    match verb(&values, &key, exponents, has_risen) {
        Some(verb) => Dependence::OfEnds { verb, first, last },
        None => extremum(&points, &indices),
    }
}

/// Whether each value is above the one before it by more than the scatter of both, which is known.
fn rises_beyond_errors(points: &[[f64; 3]]) -> bool {
    points.windows(2).all(|pair| {
        let scatter = LEAST_DIFFERENCE * libm::hypot(pair[0][2], pair[1][2]);
        scatter > 0.0 && pair[1][1] - pair[0][1] > scatter
    })
}

/// The verb of values that follow a power, rise, fall or change little; `has_risen` if they rise by more than their scatter.
fn verb(
    points: &[(f64, f64)],
    key: &str,
    exponents: Option<String>,
    has_risen: bool,
) -> Option<String> {
    let exponents = exponents.map(|range| format!(" (exponent {range})")).unwrap_or_default();
    let falling: Vec<(f64, f64)> = points.iter().map(|(x, y)| (*x, -y)).collect();
    match (named_power(points), change(points)) {
        (Some((words, spread)), _) if spread < 1e-9 => Some(format!("{words} {key}")),
        (Some((words, spread)), _) => {
            Some(format!("{words} {key} within {} %", significant(100.0 * spread, 2)))
        }
        (None, change) if change <= LARGEST_CHANGE && has_risen => {
            Some(format!("rises with the {key} by only {} %", significant(100.0 * change, 2)))
        }
        (None, change) if change <= LARGEST_CHANGE => Some(format!("hardly depends on the {key}")),
        _ if rises(points) => Some(format!("rises with the {key}{exponents}")),
        _ if rises(&falling) => Some(format!("falls with the {key}{exponents}")),
        _ => None,
    }
}

/// The difference of the extremes over the larger size.
fn change(points: &[(f64, f64)]) -> f64 {
    let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
    for (_, y) in points {
        least = if *y < least { *y } else { least };
        greatest = if *y > greatest { *y } else { greatest };
    }
    let larger = if greatest.abs() > least.abs() { greatest.abs() } else { least.abs() };
    (greatest - least) / larger
}

/// Standard errors of a difference above which an extremum is not due to scatter.
const LEAST_DIFFERENCE: f64 = 3.0;

/// A value in the middle that is beyond both ends by more than their scatter.
fn extremum(points: &[[f64; 3]], indices: &[usize]) -> Dependence {
    let [start, .., end] = points else { return Dependence::None };
    let inner = points.iter().zip(indices).take(points.len() - 1).skip(1);
    let by_value =
        |one: &(&[f64; 3], &usize), other: &(&[f64; 3], &usize)| one.0[1].total_cmp(&other.0[1]);
    let is_beyond = |value: &[f64; 3], sign: f64| {
        [start, end].into_iter().all(|other| {
            let scatter = LEAST_DIFFERENCE * libm::hypot(value[2], other[2]);
            sign * (value[1] - other[1]) > scatter
        })
    };
    if let Some((_, index)) = inner.clone().max_by(by_value).filter(|it| is_beyond(it.0, 1.0)) {
        return Dependence::GreatestAt(*index);
    }
    let least = inner.min_by(by_value).filter(|it| is_beyond(it.0, -1.0));
    least.map_or(Dependence::None, |(_, index)| Dependence::LeastAt(*index))
}

/// The exponents between neighboring points, such as "2.0" or "4.1 to 4.2"; `None` if their errors or differences are large.
fn exponents(points: &[[f64; 3]]) -> Option<String> {
    let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
    for pair in points.windows(2) {
        let [x, y] = [0, 1].map(|column| pair[1][column] / pair[0][column]);
        if !(x > 1.0 && y > 0.0 && pair[0][0] > 0.0) {
            return None;
        }
        let exponent = libm::log(y) / libm::log(x);
        let [one, other] = [0, 1].map(|point| pair[point][2] / pair[point][1]);
        let error = libm::sqrt(one * one + other * other) / libm::log(x);
        if !exponent.is_finite() || error > LARGEST_ERROR {
            return None;
        }
        least = if exponent < least { exponent } else { least };
        greatest = if exponent > greatest { exponent } else { greatest };
    }
    let text = |exponent: f64| format!("{exponent:.1}").replace('-', "−");
    let [one, other] = [least, greatest].map(text);
    // Values that hardly change show no exponent.
    let changes = least > LARGEST_RANGE || greatest < -LARGEST_RANGE;
    let range = if one == other { one } else { format!("{one} to {other}") };
    (changes && greatest - least <= LARGEST_RANGE).then_some(range)
}

/// The order of a method: the whole number to which the exponents of its errors over the time step are close; `None` if there is none, or if
/// the steps are not swept alone.
pub(super) fn order(metrics: &[&Metric]) -> Option<i64> {
    let point = |metric: &&Metric| match metric.coordinates() {
        [only] if only.key.contains(".time_step") => {
            Some((only.value.parse::<f64>().ok()?, metric.value()))
        }
        _ => None,
    };
    let mut points = metrics.iter().map(point).collect::<Option<Vec<(f64, f64)>>>()?;
    points.sort_by(|(one, _), (other, _)| one.total_cmp(other));
    order_of(&points)
}

/// The order of the method of errors over rising time steps.
fn order_of(points: &[(f64, f64)]) -> Option<i64> {
    let exponent =
        |pair: &[(f64, f64)]| libm::log(pair[1].1 / pair[0].1) / libm::log(pair[1].0 / pair[0].0);
    let exponents: Vec<f64> = points.windows(2).map(exponent).collect();
    let order = libm::round(*exponents.first()?);
    let is_close = exponents.iter().all(|exponent| (exponent - order).abs() <= FROM_ORDER);
    (is_close && order >= 1.0).then_some(order as i64)
}

/// Largest difference of an exponent from the order of a method.
const FROM_ORDER: f64 = 0.25;

/// The power of the key over which the values are the same, with their largest relative difference.
fn named_power(points: &[(f64, f64)]) -> Option<(&'static str, f64)> {
    let spread = |power: f64| {
        let ratios = points.iter().map(|(x, y)| y / libm::pow(*x, power));
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for ratio in ratios {
            least = if ratio < least { ratio } else { least };
            greatest = if ratio > greatest { ratio } else { greatest };
        }
        let has_one_sign = least > 0.0 || greatest < 0.0;
        let larger = if greatest > -least { greatest } else { -least };
        has_one_sign.then(|| (greatest - least) / larger)
    };
    let is_positive = points.iter().all(|(x, y)| *x > 0.0 && y.is_finite());
    // Values that hardly change show no power.
    if !is_positive || spread(0.0).is_some_and(|spread| spread <= 2.0 * LARGEST_SPREAD) {
        return None;
    }
    let found = POWERS.iter().filter_map(|(power, words)| Some((*words, spread(*power)?)));
    let found = found.filter(|(_, spread)| *spread <= LARGEST_SPREAD);
    found.min_by(|one, other| one.1.total_cmp(&other.1))
}

/// Whether each value is above the one before it by more than the differences that are not named.
fn rises(points: &[(f64, f64)]) -> bool {
    let size = |(one, other): (f64, f64)| {
        let [one, other] = [one.abs(), other.abs()];
        if one > other { one } else { other }
    };
    let mut pairs = points.iter().zip(&points[1..]);
    pairs.all(|((_, one), (_, next))| next - one > LARGEST_SPREAD * size((*one, *next)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::{
        Dependence, POWERS, exponents, extremum, named_power, order_of, rises, rises_beyond_errors,
        verb,
    };

    /// Values of exact powers; controls: other powers, values that do not change, and a change of sign.
    #[test]
    fn powers_of_the_swept_key_are_named() {
        let of = |power: f64| [1.0, 2.0, 4.0].map(|x: f64| (x, 3.0 * libm::pow(x, power)));
        for (power, words) in POWERS {
            let (found, spread) = named_power(&of(power)).unwrap();
            assert_eq!(found, words);
            assert!(spread < 1e-12);
        }
        for power in [0.0, 0.01, 0.7, 1.5, 3.0] {
            assert!(named_power(&of(power)).is_none(), "{power}");
        }
        assert!(named_power(&[(1.0, -1.0), (2.0, 1.0), (3.0, 2.0)]).is_none());
        let negative = of(1.0).map(|(x, y)| (x, -y));
        assert_eq!(named_power(&negative).unwrap().0, "is proportional to the");
    }

    /// Values of two powers; controls: large errors, different powers, values that hardly change, a start at zero, and a change of sign.
    #[test]
    fn exponents_between_points_are_stated_where_they_agree() {
        let of = |power: f64, error: f64| {
            [1.0, 2.0, 4.0].map(|x: f64| {
                let y = 3.0 * libm::pow(x, power);
                [x, y, error * y]
            })
        };
        assert_eq!(exponents(&of(5.0, 0.0)).unwrap(), "5.0");
        assert_eq!(exponents(&of(-3.0, 0.01)).unwrap(), "−3.0");
        assert_eq!(exponents(&of(4.0, 0.0)[..2]).unwrap(), "4.0");
        assert_eq!(
            exponents(&[[1.0, 1.0, 0.0], [2.0, 4.0, 0.0], [4.0, 19.0, 0.0]]).unwrap(),
            "2.0 to 2.2"
        );
        assert_eq!(exponents(&of(5.0, 0.1)), None);
        assert_eq!(exponents(&[[1.0, 1.0, 0.0], [2.0, 4.0, 0.0], [4.0, 64.0, 0.0]]), None);
        assert_eq!(exponents(&of(0.01, 0.0)), None);
        assert_eq!(exponents(&[[0.0, 1.0, 0.0], [2.0, 4.0, 0.0]]), None);
        assert_eq!(exponents(&[[1.0, -1.0, 0.0], [2.0, 4.0, 0.0]]), None);
    }

    /// Controls: exponents between two orders, errors that do not grow, a single step, and an error of 0.
    #[test]
    fn order_of_a_method_is_the_whole_number_of_its_exponents() {
        let of = |power: f64| [1.0, 2.0, 4.0].map(|step: f64| (step, libm::pow(step, power)));
        assert_eq!(order_of(&of(2.0)), Some(2));
        assert_eq!(order_of(&of(4.2)), Some(4));
        for points in [&of(1.5)[..], &of(0.0), &of(-1.0), &of(2.0)[..1], &[(1.0, 0.0), (2.0, 1.0)]]
        {
            assert_eq!(order_of(points), None, "{points:?}");
        }
    }

    #[test]
    fn values_that_hardly_change_do_not_rise() {
        assert!(rises(&[(1.0, 1.0), (2.0, 1.2), (3.0, 1.5)]));
        assert!(!rises(&[(1.0, 1.0), (2.0, 1.01), (3.0, 1.02)]));
        assert!(!rises(&[(1.0, 1.0), (2.0, 2.0), (3.0, 1.5)]));
    }

    /// Controls: a difference within the scatter, and values without a known one.
    #[test]
    fn small_rise_is_named_where_it_is_beyond_the_scatter() {
        let of = |error: f64| [1.0, 2.0, 3.0].map(|x| [x, 1.0 + 1e-3 * x, error]);
        assert!(rises_beyond_errors(&of(1e-4)));
        assert!(!rises_beyond_errors(&of(1e-3)) && !rises_beyond_errors(&of(0.0)));
    }

    /// Control: a difference within the scatter is no extremum.
    #[test]
    fn value_in_the_middle_is_named_where_it_is_beyond_the_ends() {
        let of = |y: f64, error: f64| [[1.0, 1.0, error], [2.0, y, error], [3.0, 1.5, error]];
        assert_eq!(extremum(&of(2.0, 0.0), &[4, 5, 6]), Dependence::GreatestAt(5));
        assert_eq!(extremum(&of(0.2, 0.0), &[4, 5, 6]), Dependence::LeastAt(5));
        assert_eq!(extremum(&of(2.0, 0.2), &[4, 5, 6]), Dependence::None);
        assert_eq!(extremum(&of(1.2, 0.0), &[4, 5, 6]), Dependence::None);
    }

    #[test]
    fn values_that_hardly_change_hardly_depend_on_the_key() {
        let points = [(1.0, -0.97), (2.0, -0.97), (3.0, -0.968)];
        let of = |has_risen| verb(&points, "friction", None, has_risen).unwrap();
        assert_eq!(of(false), "hardly depends on the friction");
        assert_eq!(of(true), "rises with the friction by only 0.21 %");
    }
}

//! Least-squares fits of straight lines, power laws and saturating exponentials.

use super::sums::Sum;

/// A straight line y = slope x + intercept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    /// The slope.
    pub(crate) slope: f64,
    /// The value y at x = 0.
    pub(crate) intercept: f64,
}

/// The least-squares line through points of equal weight; `None` for fewer than two different x, or for a number that
/// is not finite.
pub(crate) fn least_squares_line(points: &[(f64, f64)]) -> Option<Line> {
    let count = points.len() as f64;
    let x_mean = points.iter().map(|point| point.0).collect::<Sum>().value() / count;
    let y_mean = points.iter().map(|point| point.1).collect::<Sum>().value() / count;
    let xx: Sum = points.iter().map(|(x, _)| (x - x_mean) * (x - x_mean)).collect();
    let xy: Sum = points.iter().map(|(x, y)| (x - x_mean) * (y - y_mean)).collect();
    let slope = xy.value() / xx.value();
    let line = Line { slope, intercept: y_mean - slope * x_mean };
    (xx.value() > 0.0 && line.slope.is_finite() && line.intercept.is_finite()).then_some(line)
}

/// The exponent p of y = c x^p from a least-squares line through the logarithms; `None` for fewer than two different x,
/// or for a value that is not positive.
pub(crate) fn power_law_exponent(points: &[(f64, f64)]) -> Option<f64> {
    if points.iter().any(|&(x, y)| !(x > 0.0 && y > 0.0)) {
        return None;
    }
    let logarithms: Vec<(f64, f64)> =
        points.iter().map(|(x, y)| (libm::log(*x), libm::log(*y))).collect();
    least_squares_line(&logarithms).map(|line| line.slope)
}

/// The scale s of y = s (1 - exp(-x/s)) through points with x > 0, by least squares of the relative deviations, and
/// their root mean square. `None` if the points are on or above y = x: the scale would exceed ten times the largest x.
pub(crate) fn saturation(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let largest = points.iter().map(|point| point.0).fold(0.0, f64::max);
    if points.len() < 2 || points.iter().any(|&(x, y)| x <= 0.0 || y <= 0.0) {
        return None;
    }
    let misfit = |scale: f64| {
        let squares = points.iter().map(|&(x, y)| {
            let distance = y / (-scale * libm::expm1(-x / scale)) - 1.0;
            distance * distance
        });
        (squares.sum::<f64>() / points.len() as f64).sqrt()
    };
    // Golden-section search in the logarithm of the scale: the misfit has one minimum.
    let (mut low, mut high) = (libm::log(1e-3 * largest), libm::log(1e2 * largest));
    let section = (5.0_f64.sqrt() - 1.0) / 2.0;
    for _ in 0..100 {
        let (left, right) = (high - section * (high - low), low + section * (high - low));
        if misfit(libm::exp(left)) < misfit(libm::exp(right)) { high = right } else { low = left }
    }
    let scale = libm::exp((low + high) / 2.0);
    (scale < 10.0 * largest).then(|| (scale, misfit(scale)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_and_power_law_through_exact_points() {
        let line = least_squares_line(&[(1.0, 5.0), (2.0, 8.0), (4.0, 14.0)]).unwrap();
        assert!((line.slope - 3.0).abs() < 1e-14 && (line.intercept - 2.0).abs() < 1e-14);
        // Source: closed form with a residual: (0,0), (1,0), (2,3) has slope 3/2 and intercept -1/2.
        let line = least_squares_line(&[(0.0, 0.0), (1.0, 0.0), (2.0, 3.0)]).unwrap();
        assert!((line.slope - 1.5).abs() < 1e-14 && (line.intercept + 0.5).abs() < 1e-14);
        let exponent =
            power_law_exponent(&[(0.5, 28.0), (1.0, 7.0), (2.0, 1.75), (4.0, 0.4375)]).unwrap();
        assert!((exponent + 2.0).abs() < 1e-14);
        assert!(least_squares_line(&[(1.0, 1.0), (1.0, 2.0)]).is_none());
        assert!(power_law_exponent(&[(1.0, 1.0), (2.0, 0.0)]).is_none());
    }

    /// Law: points on the curve determine its scale; points on y = x have none.
    #[test]
    fn a_saturating_curve_is_found() {
        let curve = |x: f64| (x, 3.0 * (1.0 - libm::exp(-x / 3.0)));
        let points: Vec<(f64, f64)> = [0.5, 1.0, 4.0, 12.0].map(curve).to_vec();
        let (scale, misfit) = saturation(&points).unwrap();
        assert!((scale - 3.0).abs() < 1e-7 && misfit < 1e-8, "{scale} {misfit}");
        assert!(saturation(&[(1.0, 1.0), (2.0, 2.0), (4.0, 4.0)]).is_none());
    }
}

//! Log times of frames: frame index over playback rate, and the simulated time per second of playback.

use foxglove::messages::Timestamp;

/// Maximum frames per second that viewers play without a warning.
pub(crate) const LARGEST_RATE: f64 = 50.0;
/// Maximum duration of a playback, s: 93 days. Viewers reject a range of 93.8 days, and beyond 2^53 ns, or 104 days, their
/// numbers no longer resolve a nanosecond.
const LONGEST_PLAYBACK_S: u64 = 93 * 86_400;

/// Log time of a frame, ns: `frame / rate`, exactly rounded to the nearest, halves up.
///
/// `rate` counts as an exact binary number. `None` if it is outside (0, 50], or if the playback would exceed 93 days.
pub(crate) fn log_time_ns(frame: u64, rate: f64) -> Option<u64> {
    if !(rate > 0.0 && rate <= LARGEST_RATE) {
        return None;
    }
    let (mantissa, exponent) = binary_parts(rate);
    let nanoseconds = u128::from(frame) * 1_000_000_000;
    let latest = u128::from(LONGEST_PLAYBACK_S) * 1_000_000_000;
    // An integral rate has a mantissa of at most 50; any other a negative exponent: long division, bit by bit.
    let divisor = u128::from(mantissa) << exponent.max(0);
    let mut quotient = nanoseconds / divisor;
    let mut remainder = nanoseconds % divisor;
    for _ in exponent..0 {
        let digit = u128::from(2 * remainder >= divisor);
        quotient = 2 * quotient + digit;
        remainder = 2 * remainder - digit * divisor;
        if quotient > latest {
            return None;
        }
    }
    let rounded = quotient + u128::from(2 * remainder >= divisor);
    if rounded > latest { None } else { u64::try_from(rounded).ok() }
}

/// Log time of a frame at a playback rate, ns and as a timestamp.
pub(crate) fn log_times(frame: u64, rate: f64) -> Option<(u64, Timestamp)> {
    let ns = log_time_ns(frame, rate)?;
    Some((ns, Timestamp::new((ns / 1_000_000_000) as u32, (ns % 1_000_000_000) as u32)))
}

/// Odd mantissa and exponent of a positive finite number: `value = mantissa * 2^exponent`.
fn binary_parts(value: f64) -> (u64, i32) {
    let bits = value.to_bits();
    let fraction = bits & ((1 << 52) - 1);
    let biased = (bits >> 52) as i32;
    let (mantissa, exponent) =
        if biased == 0 { (fraction, -1074) } else { (fraction | (1 << 52), biased - 1075) };
    let zeros = mantissa.trailing_zeros();
    (mantissa >> zeros, exponent + zeros as i32)
}

/// Simulated time per second of playback, such as "75 ms"; `None` if it is not known in advance.
pub(crate) fn simulated_per_second(
    model_time: Option<f64>,
    time_unit: &str,
    frames: Option<u64>,
    rate: f64,
) -> Option<String> {
    let intervals = frames?.checked_sub(1).filter(|&intervals| intervals > 0)?;
    let time = model_time? / intervals as f64 * rate;
    if !(time.is_finite() && time > 0.0) {
        return None;
    }
    let units: &[(f64, &str)] = match time_unit {
        "s" => &[(1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"), (1e-12, "ps")],
        "d" => &[(365.25, "yr"), (1.0, "d")],
        _ => &[(1.0, "time units")],
    };
    let last = units.last()?;
    let (size, name) = units.iter().find(|(size, _)| time >= *size).unwrap_or(last);
    Some(format!("{} {name}", three_digits(time / size)))
}

/// A number with three significant digits, such as "0.075" or "1820".
pub(crate) fn three_digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_times_are_exactly_rounded() {
        assert_eq!(log_time_ns(0, 25.0), Some(0));
        assert_eq!(log_time_ns(1, 25.0), Some(40_000_000));
        assert_eq!(log_time_ns(1, 30.0), Some(33_333_333));
        assert_eq!(log_time_ns(2, 30.0), Some(66_666_667));
        assert_eq!(log_time_ns(3, 0.5), Some(6_000_000_000));
        // Python's Fraction, round half up: floor(n * 10**9 / Fraction(rate) + 1/2).
        assert_eq!(log_time_ns(1, 0.1), Some(10_000_000_000));
        assert_eq!(log_time_ns(400_000, 0.1), Some(4_000_000_000_000_000));
        assert_eq!(log_time_ns(123_456_789, 29.97), Some(4_119_345_645_645_646));
    }

    #[test]
    fn rates_and_spans_beyond_the_viewers_are_refused() {
        assert_eq!(log_time_ns(1, 0.0), None);
        assert_eq!(log_time_ns(1, f64::NAN), None);
        assert_eq!(log_time_ns(1, 50.5), None);
        assert_eq!(log_time_ns(0, f64::MIN_POSITIVE / 2.0), Some(0));
        assert_eq!(log_time_ns(1, f64::MIN_POSITIVE / 2.0), None);
        assert_eq!(log_time_ns(u64::MAX, 50.0), None);
        assert_eq!(log_time_ns(8_035_200, 1.0), Some(8_035_200_000_000_000));
        assert_eq!(log_time_ns(8_035_201, 1.0), None);
        assert_eq!(log_time_ns(401_760_000, 50.0), Some(8_035_200_000_000_000));
        assert_eq!(log_time_ns(401_760_001, 50.0), None);
    }

    #[test]
    fn the_scale_is_in_words() {
        let scale = |time, unit, frames| simulated_per_second(Some(time), unit, Some(frames), 25.0);
        assert_eq!(scale(1.0, "s", 101).as_deref(), Some("250 ms"));
        assert_eq!(scale(365.25, "d", 101).as_deref(), Some("91.3 d"));
        assert_eq!(scale(36525.0, "d", 101).as_deref(), Some("25 yr"));
        assert_eq!(scale(8.0, "", 201).as_deref(), Some("1 time units"));
        assert_eq!(scale(1.0, "s", 1), None);
    }
}

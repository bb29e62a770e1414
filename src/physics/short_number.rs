//! Short decimal text of a number in log lines and faults.

/// Formats a number with six digits, with an exponent if the plain number would be long.
pub(crate) fn short(value: f64) -> String {
    let rounded = format!("{value:.5e}");
    match rounded.parse::<f64>() {
        Ok(number) if number == 0.0 || (1e-3..1e7).contains(&number.abs()) => number.to_string(),
        Ok(number) => format!("{number:e}"),
        Err(_) => rounded,
    }
}

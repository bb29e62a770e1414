//! Dates of the Gregorian calendar.

/// A time in seconds since 1970 in ISO 8601, in UTC, such as "2026-11-27T14:56:18+00:00". Days are counted from March 1 of the year 0,
/// so that a leap day ends a year (Hinnant: chrono-compatible low-level date algorithms).
#[must_use]
pub fn iso_time(unix_time_s: u64) -> String {
    let (days, second) = (unix_time_s / 86_400, unix_time_s % 86_400);
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let date = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = era * 400 + year + u64::from(month <= 2);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{date:02}T{hour:02}:{minute:02}:{second:02}+00:00")
}

#[cfg(test)]
mod tests {
    use super::iso_time;

    /// Source: `date --utc --iso-8601=seconds --date @N`.
    #[test]
    fn seconds_are_dates_of_the_gregorian_calendar() {
        let cases = [
            (0, "1970-01-01T00:00:00+00:00"),
            (951_782_400, "2000-02-29T00:00:00+00:00"),
            (951_868_799, "2000-02-29T23:59:59+00:00"),
            (1_735_689_599, "2024-12-31T23:59:59+00:00"),
            (1_795_791_378, "2026-11-27T14:56:18+00:00"),
            (4_107_542_400, "2100-03-01T00:00:00+00:00"),
        ];
        for (unix_time_s, expected) in cases {
            assert_eq!(iso_time(unix_time_s), expected);
        }
    }
}

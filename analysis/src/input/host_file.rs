//! `STEM.host.json` next to a recording: machine, date and wall time of its run. No metric reads it.

use super::RecordingFolder;
use serde::Deserialize;
use std::path::Path;

/// The facts of one run's host file that a report shows.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(crate) struct HostFile {
    /// The host's name.
    pub(crate) host: Option<String>,
    pub(crate) operating_system: String,
    pub(crate) architecture: String,
    /// End of the run, seconds since 1970 UTC.
    pub(crate) finished_unix_time_s: Option<u64>,
    /// Wall time of the run, s.
    pub(crate) wall_time_s: Option<f64>,
}

impl RecordingFolder {
    /// The host file of a recording; `None` if there is none that can be read, which loses no result.
    pub(crate) fn host_file(&self, recording: &str) -> Option<HostFile> {
        let stem = Path::new(recording).file_stem()?.to_str()?;
        let text = self.text(&self.folder.join(format!("{stem}.host.json"))).ok()?;
        serde_json::from_str(&text).ok()
    }
}

/// A time in seconds since 1970 as a date of the Gregorian calendar, such as "2026-11-23 02:34 UTC".
pub(crate) fn utc(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    // Days are counted from March 1 of the year 0, so that a leap day ends a year (Hinnant: chrono-compatible low-level date algorithms).
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let date = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = era * 400 + year + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{date:02} {:02}:{:02} UTC", second / 3600, second / 60 % 60)
}

#[cfg(test)]
mod tests {
    use super::utc;

    #[test]
    fn seconds_are_dates_of_the_gregorian_calendar() {
        // POSIX time of the dates by `date -u -d @SECONDS`.
        assert_eq!(utc(0), "1970-01-01 00:00 UTC");
        assert_eq!(utc(951_782_400), "2000-02-29 00:00 UTC");
        assert_eq!(utc(951_868_799), "2000-02-29 23:59 UTC");
        assert_eq!(utc(1_735_689_599), "2024-12-31 23:59 UTC");
        assert_eq!(utc(4_107_542_400), "2100-03-01 00:00 UTC");
    }
}

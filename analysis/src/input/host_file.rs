//! `STEM.host.json` next to a recording: machine, date and wall time of its run. No metric reads it.

use super::RecordingFolder;
use kinetoscope_console::calendar::iso_time;
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

/// A time in seconds since 1970 to the minute, such as "2026-11-23 02:34 UTC".
pub(crate) fn utc(seconds: u64) -> String {
    let time = iso_time(seconds);
    let (date, time) = time.split_once('T').unwrap_or((&time, ""));
    format!("{date} {} UTC", time.get(..5).unwrap_or(time))
}

#[cfg(test)]
mod tests {
    use super::utc;

    #[test]
    fn times_are_shown_to_the_minute() {
        assert_eq!(utc(951_868_799), "2000-02-29 23:59 UTC");
    }
}

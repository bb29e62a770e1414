//! The log lines of the start as one message. After a seek, a viewer shows only the last message before the playhead, so single
//! lines would be lost.

use crate::frame::{Level, LogLine};
use crate::limits::MAX_LOG_LINES;

/// Prefixes of the lines that are more than a fact.
const PREFIXES: [(&str, Level); 2] = [("warning: ", Level::Warning), ("error: ", Level::Error)];

/// Joins lines into one, with the highest of their levels; `None` without lines. A line that is more than a fact begins
/// with its level. A single line stays as it is.
pub(crate) fn joined(lines: &[LogLine]) -> Option<LogLine> {
    if let [line] = lines {
        return Some(line.clone());
    }
    let level = lines.iter().map(|line| line.level).max()?;
    let prefixed = |line: &LogLine| {
        let prefix = PREFIXES.into_iter().find(|(_, level)| *level == line.level);
        format!("{}{}", prefix.map_or("", |(prefix, _)| prefix), line.text.replace('\n', " "))
    };
    let text: Vec<String> = lines.iter().map(prefixed).collect();
    Some(LogLine { level, text: text.join("\n") })
}

/// The lines of a message that [`joined`] returned, up to as many as a frame can have.
pub(crate) fn split(message: LogLine) -> Vec<LogLine> {
    if !message.text.contains('\n') {
        return vec![message];
    }
    let line = |text: &str| {
        let found = PREFIXES
            .into_iter()
            .find_map(|(prefix, level)| text.strip_prefix(prefix).map(|text| (text, level)));
        let (text, level) = found.unwrap_or((text, Level::Info));
        LogLine { level, text: text.to_owned() }
    };
    message.text.splitn(MAX_LOG_LINES, '\n').map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(level: Level, text: &str) -> LogLine {
        LogLine { level, text: text.to_owned() }
    }

    #[test]
    fn split_lines_are_those_that_were_joined() {
        let lines = [
            line(Level::Info, "1 s of playback = 75 ms simulated"),
            line(Level::Warning, "the time step is large"),
            line(Level::Info, "400 discs"),
        ];
        assert_eq!(joined(&[]), None);
        for count in 1..=3 {
            assert_eq!(split(joined(&lines[..count]).unwrap()), lines[..count]);
        }
        assert_eq!(joined(&lines).unwrap().level, Level::Warning);
        assert_eq!(joined(&lines[1..2]).unwrap().text, "the time step is large");
    }

    #[test]
    fn message_of_many_lines_is_split_into_a_limited_number() {
        let message = line(Level::Info, &"\n".repeat(100_000));
        assert_eq!(split(message).len(), MAX_LOG_LINES);
    }
}

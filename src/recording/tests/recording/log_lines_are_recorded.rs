//! Guarantee: all lines of the start are one message, so that a viewer shows them after a seek as well; later lines are messages of
//! their own. The reader returns every line with its level.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::sample::{header, read};
use kinetoscope_recording::frame::{Frame, Level, LogLine};
use kinetoscope_recording::recorder::{Clock, Compression, Outcome, Recorder};

#[test]
fn lines_of_the_start_are_one_message() {
    let mut recorder = Recorder::create(Vec::new(), &header(Compression::Zstd)).unwrap();
    for count in 0..2 {
        let mut frame = Frame::new();
        frame.log(Level::Info, format!("fact {count}"));
        frame.log(Level::Warning, format!("warning {count}"));
        recorder.write(Clock { count, time: count as f64 }, &mut frame).unwrap();
        let text = format!("remark {count}");
        recorder.remark(LogLine { level: Level::Error, text }).unwrap();
    }
    let bytes = recorder.finish(&Outcome::Complete).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (frames, error) = read(&bytes, &folder.path().join("log.mcap"));
    assert_eq!(error, None);
    let messages = |frame: usize| {
        frames[frame].messages().iter().filter(|message| message.topic() == "/log").count()
    };
    assert_eq!((messages(0), messages(1)), (2, 3));
    let lines = |frame: usize| {
        let lines = frames[frame].log_lines().iter();
        lines.map(|line| (line.level, line.text.as_str())).collect::<Vec<_>>()
    };
    assert_eq!(
        lines(0),
        [
            (Level::Info, "1 s of playback = 75 ms simulated"),
            (Level::Info, "fact 0"),
            (Level::Warning, "warning 0"),
            (Level::Error, "remark 0"),
        ]
    );
    assert_eq!(
        lines(1),
        [(Level::Info, "fact 1"), (Level::Warning, "warning 1"), (Level::Error, "remark 1")]
    );
}

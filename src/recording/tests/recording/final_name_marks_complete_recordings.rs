//! Guarantee: a recording gets its final name only when it is complete, and it never replaces another one. After any failure of the disk,
//! the file contains the start of the recording.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::sample::{fill, header, read_file, record};
use kinetoscope_console::Explained as _;
use kinetoscope_recording::checkpoint;
use kinetoscope_recording::error::RecordError;
use kinetoscope_recording::file::{Committed, RecordingFile, is_being_written};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::{Clock, Compression, Outcome, Recorder};
use kinetoscope_recording::removal::{Removal, remove_leftovers, remove_recording};
use std::io::{self, Write};
use std::path::Path;

fn write_run(
    file: RecordingFile,
    frames: u64,
    outcome: &Outcome,
) -> Result<RecordingFile, RecordError> {
    let mut recorder = Recorder::create(file, &header(Compression::Zstd))?;
    let mut frame = Frame::new();
    for index in 0..frames {
        fill(&mut frame, index, 5);
        recorder.write(Clock { count: index, time: 0.0 }, &mut frame)?;
    }
    recorder.finish(outcome)
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn finished_run_gets_its_final_name() {
    let folder = tempfile::tempdir().unwrap();
    let file = RecordingFile::create(folder.path(), "run").unwrap();
    assert_eq!(names(folder.path()), ["run.partial.mcap"]);
    let file = write_run(file, 3, &Outcome::Complete).unwrap();
    assert_eq!(file.commit().unwrap(), Committed::New);
    assert_eq!(names(folder.path()), ["run.mcap"]);
    let (frames, error) = read_file(&folder.path().join("run.mcap"));
    assert_eq!((frames.len(), error), (3, None));
}

/// A kill between the two steps of the rename leaves the partial name as a second name of the finished recording. The next run
/// with this name must not truncate it.
#[cfg(unix)]
#[test]
fn new_partial_file_never_truncates_a_finished_recording() {
    let folder = tempfile::tempdir().unwrap();
    let file = RecordingFile::create(folder.path(), "run").unwrap();
    write_run(file, 3, &Outcome::Complete).unwrap().commit().unwrap();
    let finished = folder.path().join("run.mcap");
    let bytes = std::fs::read(&finished).unwrap();
    std::fs::hard_link(&finished, folder.path().join("run.partial.mcap")).unwrap();
    let file = RecordingFile::create(folder.path(), "run").unwrap();
    assert_eq!(std::fs::read(&finished).unwrap(), bytes);
    assert_eq!(
        write_run(file, 3, &Outcome::Complete).unwrap().commit().unwrap(),
        Committed::AlreadyThere
    );
}

#[test]
fn equal_bytes_are_accepted_and_other_bytes_are_an_error_that_keeps_both_files() {
    let folder = tempfile::tempdir().unwrap();
    let run = |frames| {
        let file = RecordingFile::create(folder.path(), "run").unwrap();
        write_run(file, frames, &Outcome::Complete).unwrap().commit()
    };
    assert_eq!(run(3).unwrap(), Committed::New);
    let first = std::fs::read(folder.path().join("run.mcap")).unwrap();
    assert_eq!(run(3).unwrap(), Committed::AlreadyThere);
    assert_eq!(names(folder.path()), ["run.mcap"]);
    let error = run(4).unwrap_err();
    assert!(matches!(error, RecordError::Differs { .. }) && !error.is_retryable(), "{error}");
    assert_eq!(names(folder.path()), ["run.mcap", "run.partial.mcap"]);
    assert_eq!(std::fs::read(folder.path().join("run.mcap")).unwrap(), first);
}

/// A damaged recording is no result of another run: its run can be recorded again, and the damaged bytes are kept. Control: the test
/// above, in which both are intact.
#[test]
fn recording_takes_the_place_of_a_damaged_one() {
    let folder = tempfile::tempdir().unwrap();
    let run = || {
        let file = RecordingFile::create(folder.path(), "run").unwrap();
        write_run(file, 3, &Outcome::Complete).unwrap().commit()
    };
    assert_eq!(run().unwrap(), Committed::New);
    let finished = folder.path().join("run.mcap");
    let intact = std::fs::read(&finished).unwrap();
    let mut flipped = intact.clone();
    flipped[intact.len() / 2] ^= 1;
    for damaged in [&flipped[..], &intact[..intact.len() / 2]] {
        std::fs::write(&finished, damaged).unwrap();
        assert_eq!(run().unwrap(), Committed::Replaced);
        assert_eq!(std::fs::read(&finished).unwrap(), intact);
        let kept = folder.path().join("run.mcap.damaged");
        assert_eq!(std::fs::read(&kept).unwrap(), damaged);
    }
}

#[test]
fn second_writer_of_a_recording_is_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let first = RecordingFile::create(folder.path(), "run").unwrap();
    let error = RecordingFile::create(folder.path(), "run").err().unwrap();
    assert!(matches!(error, RecordError::Locked { .. }) && error.is_retryable(), "{error}");
    drop(first);
    assert!(RecordingFile::create(folder.path(), "run").is_ok());
}

/// A reader asks whether a recording is being written; a run that starts at this instant waits for it. Control: a lock that stays is
/// found by the reader and rejects the run.
#[test]
fn lock_of_an_instant_rejects_no_run() {
    let folder = tempfile::tempdir().unwrap();
    let partial = folder.path().join("run.partial.mcap");
    assert!(!is_being_written(&partial));
    let first = RecordingFile::create(folder.path(), "run").unwrap();
    assert!(is_being_written(&partial));
    drop(first);
    assert!(!is_being_written(&partial));
    let reader = std::fs::File::open(&partial).unwrap();
    reader.try_lock_shared().unwrap();
    let writer = std::thread::spawn(move || RecordingFile::create(folder.path(), "run").is_ok());
    std::thread::sleep(std::time::Duration::from_millis(2));
    drop(reader);
    assert!(writer.join().unwrap());
}

/// Control: without a writer, the same file is cut off.
#[test]
fn file_that_is_being_written_is_not_called_cut_off() {
    let folder = tempfile::tempdir().unwrap();
    let partial = folder.path().join("run.partial.mcap");
    let writer = RecordingFile::create(folder.path(), "run").unwrap();
    let whole = record(&header(Compression::Zstd), 30, 3000);
    std::fs::write(&partial, &whole[..whole.len() / 2]).unwrap();
    let last_error = || {
        let frames = Recording::open(&partial).unwrap().frames().unwrap();
        frames.last().unwrap().unwrap_err().to_string()
    };
    let during = last_error();
    assert!(during.contains("is being written by another process"), "{during}");
    assert!(!during.contains("cut off"), "{during}");
    drop(writer);
    assert!(last_error().contains("is cut off"));
}

/// A verification reads a recording several times, and another process may write it meanwhile. Control: opened again, it has all
/// frames.
#[test]
fn frames_are_those_of_the_file_when_it_was_opened() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("growing.mcap");
    let whole = record(&header(Compression::Zstd), 30, 3000);
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let recording = Recording::open(&path).unwrap();
    let frames = || {
        let read: Vec<_> = recording.frames().unwrap().collect();
        (read.len(), read.last().unwrap().as_ref().unwrap_err().to_string())
    };
    let before = frames();
    std::fs::write(&path, &whole).unwrap();
    assert_eq!(frames(), before);
    assert_eq!(Recording::open(&path).unwrap().frames().unwrap().flatten().count(), 30);
}

/// Another process may prune the folder at any time.
#[test]
fn leftovers_of_a_run_that_is_being_written_stay() {
    let folder = tempfile::tempdir().unwrap();
    let file = RecordingFile::create(folder.path(), "run").unwrap();
    checkpoint::write(folder.path(), "run", "identity", &[&1_u8]).unwrap();
    for name in ["run.mcap", "run.host.json"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    let before = names(folder.path());
    assert_eq!(remove_leftovers(folder.path(), "run").unwrap(), Removal::InUse);
    assert_eq!(remove_recording(folder.path(), "run", &["host.json"]).unwrap(), Removal::InUse);
    assert_eq!((names(folder.path()), before.len()), (before, 4));
    drop(file);
    assert_eq!(remove_leftovers(folder.path(), "run").unwrap(), Removal::Removed);
    assert_eq!(names(folder.path()), ["run.host.json", "run.mcap"]);
    checkpoint::write(folder.path(), "run", "identity", &[&1_u8]).unwrap();
    assert_eq!(remove_recording(folder.path(), "run", &["host.json"]).unwrap(), Removal::Removed);
    assert!(names(folder.path()).is_empty());
    checkpoint::write(folder.path(), "run", "identity", &[&1_u8]).unwrap();
    assert_eq!(remove_leftovers(folder.path(), "run").unwrap(), Removal::Removed);
    assert!(names(folder.path()).is_empty());
}

#[test]
fn interrupted_run_leaves_a_readable_partial_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = RecordingFile::create(folder.path(), "run").unwrap();
    let path = write_run(file, 3, &Outcome::Interrupted).unwrap().keep_partial().unwrap();
    assert_eq!(names(folder.path()), ["run.partial.mcap"]);
    let (frames, error) = read_file(&path);
    assert_eq!((frames.len(), error), (3, None));
    assert_eq!(Recording::open(&path).unwrap().provenance().outcome, Some(Outcome::Interrupted));
}

#[test]
fn missing_folder_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let error = RecordingFile::create(&folder.path().join("nowhere"), "run").err().unwrap();
    assert!(error.to_string().contains("nowhere"), "{error}");
}

/// A disk that is full after a given number of bytes.
struct FullDisk<'a> {
    bytes: &'a mut Vec<u8>,
    room: usize,
}

impl Write for FullDisk<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let left = self.room - self.bytes.len();
        if left == 0 {
            return Err(io::Error::new(io::ErrorKind::StorageFull, "run.partial.mcap: disk full"));
        }
        let written = &bytes[..bytes.len().min(left)];
        self.bytes.extend_from_slice(written);
        Ok(written.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn full_disk_is_retryable_and_leaves_the_start_of_the_recording() {
    let header = header(Compression::Zstd);
    // The run has several chunks, so that the disk becomes full in the middle of the run as well.
    let (frames, particles) = (30, 500);
    let whole = record(&header, frames, particles);
    for part in 0..40 {
        let room = whole.len() * part / 40 + part;
        let mut bytes = Vec::new();
        let disk = FullDisk { bytes: &mut bytes, room };
        let result = Recorder::create(disk, &header).and_then(|mut recorder| {
            let mut frame = Frame::new();
            for index in 0..frames {
                fill(&mut frame, index, particles);
                recorder.write(
                    Clock { count: 10 * index, time: crate::sample::time_of(index) },
                    &mut frame,
                )?;
            }
            recorder.finish(&Outcome::Complete).map(|_| ())
        });
        let error = result.unwrap_err();
        assert!(error.is_retryable(), "{room} bytes: {error}");
        assert!(error.help().unwrap().contains("free space"), "{room} bytes: {error}");
        assert!(whole.starts_with(&bytes), "{room} bytes");
    }
}

/// A state that cannot be decoded behind a correct checksum is of another version, or damaged: the message says both.
#[test]
fn checkpoint_with_another_layout_is_not_only_called_damaged() {
    let folder = tempfile::tempdir().unwrap();
    checkpoint::write(folder.path(), "run", "identity", &[&1_u8]).unwrap();
    let read = |identity: &str| {
        let read = checkpoint::read(folder.path(), "run", identity, 1 << 20, |_| None::<u8>);
        read.unwrap_err().to_string()
    };
    assert!(read("identity").contains("of another version of the program"), "{}", read("identity"));
    assert!(read("identity").ends_with("or damaged"), "{}", read("identity"));
    assert!(read("other").contains("another run or another version"), "{}", read("other"));
}

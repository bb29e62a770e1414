//! `fill` and `zoom`: frames that a recording does not hold, recomputed from its keyframes.

use crate::comparison::rerun::{listen, with_progress};
use crate::messages::exit::unread_recording;
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, plural};
use clap::Args;
use kinetoscope::verify::fill::fill;
use kinetoscope::verify::fine_frames::Interval;
use kinetoscope::verify::restored_file::Restored;
use kinetoscope::verify::zoom::zoom;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use serde_json::json;
use std::path::PathBuf;

/// Restore all frames of a recording that keeps only keyframes, and check that they are those of the run.
#[derive(Debug, Args)]
pub(crate) struct FillArguments {
    /// Recording (*.mcap) of a run with `keep = "keyframes"`
    #[arg(value_name = "RECORDING")]
    path: PathBuf,
    /// The new recording; by default a file next to the other one
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: ResultArguments,
}

/// Recompute an interval of a recorded run with more frames, from the nearest keyframe before it.
#[derive(Debug, Args)]
pub(crate) struct ZoomArguments {
    /// Recording (*.mcap)
    #[arg(value_name = "RECORDING")]
    path: PathBuf,
    /// Start of the interval, in the unit of the model's time (in collisions if the run's length is a number of collisions)
    #[arg(long, value_name = "TIME", allow_negative_numbers = true)]
    from: f64,
    /// End of the interval
    #[arg(long, value_name = "TIME", allow_negative_numbers = true)]
    to: f64,
    /// Time between two frames, at least one time step; frames are at its multiples
    #[arg(long, value_name = "TIME", allow_negative_numbers = true)]
    every: f64,
    /// The new recording; by default a file next to the other one
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: ResultArguments,
}

impl FillArguments {
    /// Restores the frames and prints the result.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        let restored = with_progress(&self.path, &self.result, |interrupt, on_frame| {
            fill(&self.path, self.output.as_deref(), interrupt, on_frame)
        });
        concluded(restored.and_then(|restored| Ok(restored?)), &self.result)
    }
}

impl ZoomArguments {
    /// Recomputes the interval and prints the result.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        let interval = Interval { from: self.from, to: self.to, every: self.every };
        let restored = listen().and_then(|interrupt| {
            Ok(zoom(&self.path, interval, self.output.as_deref(), &interrupt)?)
        });
        concluded(restored, &self.result)
    }
}

fn concluded(restored: Result<Restored, Failure>, result: &ResultArguments) -> Exit {
    let restored = match restored {
        Ok(restored) => restored,
        Err(failure) => return result.concluded(result.failed(&failure)),
    };
    let Restored { path, frames, equal_frames, notes, damage } = &restored;
    let damage = damage.as_ref().map(unread_recording);
    let exit = damage.as_ref().map_or(Exit::Done, Failure::report);
    let mut lines = vec![format!("{}: {}", shown_path(path), plural(*frames, "frame"))];
    lines.push(format!(
        "{} of the recording recomputed: equal in every message",
        plural(*equal_frames, "frame")
    ));
    lines.extend(notes.iter().map(|note| format!("note: {note}")));
    result.print(&lines.join("\n"), || {
        json!({
            "exit_code": exit.code(), "file": path, "frames": frames, "equal_frames": equal_frames, "notes": notes,
            "errors": damage.iter().map(Failure::plain_text).collect::<Vec<_>>(),
        })
    });
    result.concluded(exit)
}

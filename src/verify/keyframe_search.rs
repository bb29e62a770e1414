//! The keyframe from which a run continues.

use crate::interrupt::Interrupt;
use crate::run::prepared::{self, Prepared};
use crate::run::schedule::is_at_or_before;
use crate::verify::error::VerifyError;
use crate::verify::rerun_check::keyframe_of;
use crate::verify::source::Source;
use kinetoscope_physics::model::Target;

/// Where a rerun begins.
pub(crate) struct Base {
    /// The model at the start or at a keyframe.
    pub(crate) prepared: Prepared,
    /// The first frame of the rerun: 0, or the one after the keyframe.
    pub(crate) first: u64,
    /// What is damaged.
    pub(crate) notes: Vec<String>,
}

/// The nearest keyframe at or before a target that can be restored; the start of the run if there is none. The state in the first frame is
/// not used: the rerun begins before it, so that it is compared.
///
/// # Errors
/// A recording that cannot be opened, a run that does not start, or an interruption.
pub(crate) fn nearest(
    source: &Source,
    start: &Prepared,
    before: Target,
    interrupt: &Interrupt,
) -> Result<Base, VerifyError> {
    let mut notes = Vec::new();
    let mut found: Vec<(u64, Vec<u8>)> = Vec::new();
    for frame in source.recording.frames()? {
        let frame = match frame {
            Ok(frame) => frame,
            // The caller reports the error.
            Err(_) => {
                let used = found.last().map_or(0, |(frame, _)| *frame);
                notes
                    .push(format!("the nearest keyframe is damaged, that of frame {used} is used"));
                break;
            }
        };
        let index = frame.clock.frame;
        if index > start.schedule.frames()
            || !is_at_or_before(start.schedule.target_or_start(index), before)
        {
            break;
        }
        if let Some(keyframe) = keyframe_of(&frame) {
            // Two suffice: the nearest one, and one if that is damaged.
            if found.len() == 2 {
                found.remove(0);
            }
            found.push((index, keyframe.model));
        }
    }
    let (canonical, key) = (&start.header.manifest, &start.header.run_key);
    for (frame, model) in found.iter().rev().filter(|(frame, _)| *frame > 0) {
        if let Some(model) = prepared::restored(&source.manifest, model)
            && let Ok(prepared) =
                Prepared::of(model, &source.manifest.with_all_frames(), canonical, key)
            && prepared.is_before_frame(frame + 1)
        {
            return Ok(Base { prepared, first: frame + 1, notes });
        }
        notes.push(format!("the keyframe of frame {frame} is damaged: an earlier one is used"));
    }
    Ok(Base { prepared: source.prepared_with_all_frames(interrupt)?, first: 0, notes })
}

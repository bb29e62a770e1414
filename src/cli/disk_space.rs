//! Whether the recordings of a plan fit the disk that they go to.

use crate::executor::progress::size;
use crate::plan::Plan;
use std::path::Path;

/// Says so where the disk has less room than the bytes that the plan wants at a time. `option` names its folder on the
/// command line.
#[must_use]
pub fn shortage(plan: &Plan, wanted: u64, option: &str) -> Option<String> {
    let existing = plan.folder.ancestors().find(|folder| folder.is_dir())?;
    let existing = if existing.as_os_str().is_empty() { Path::new(".") } else { existing };
    let free = fs4::available_space(existing).ok()?;
    (wanted > free).then(|| {
        format!(
            "The recordings may take {}, but {} has only {} free.\n\
             Free some, choose another folder with {option} DIR, or record less ([record] frames, channels).",
            size(wanted),
            existing.display(),
            size(free)
        )
    })
}

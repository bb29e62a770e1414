//! Names of what an analysis writes: its cache, its plots, and the file that lists them next to the plots with the recordings that
//! they show, so that plots of recordings that are removed can be removed.

use kinetoscope_files::regular_file::read_text;
use std::path::Path;

/// Folder of the cached analyses next to the results. It can be deleted at any time.
pub const CACHE_FOLDER: &str = ".analysis-cache";
/// Name of the list.
pub const PLOT_LIST: &str = ".analysis-plots";
/// Maximum size of a list that is read.
const MAX_BYTES: u64 = 1 << 20;

/// The plots in a folder by its list, if there is one. Names that lead out of the folder are left out: any user of a shared folder
/// can write the list.
#[must_use]
pub fn listed_plots(folder: &Path) -> Vec<String> {
    listed(folder, ".svg")
}

/// The recordings in a folder that its plots show, by the list.
#[must_use]
pub fn listed_recordings(folder: &Path) -> Vec<String> {
    listed(folder, ".mcap")
}

fn listed(folder: &Path, ending: &str) -> Vec<String> {
    let Ok(list) = read_text(&folder.join(PLOT_LIST), MAX_BYTES) else { return Vec::new() };
    let is_listed = |name: &&str| name.ends_with(ending) && is_plain_name(name);
    list.lines().filter(is_listed).map(str::to_owned).collect()
}

/// Whether a text can be the name of a plot: a file of its folder on every system, which is not hidden.
#[must_use]
pub fn is_plot_name(name: &str) -> bool {
    name.ends_with(".svg") && is_plain_name(name)
}

fn is_plain_name(name: &str) -> bool {
    let is_plain = |c: char| c.is_alphanumeric() || "._=,+-".contains(c);
    !name.starts_with('.') && name.chars().all(is_plain)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::{PLOT_LIST, listed_plots, listed_recordings};

    #[test]
    fn list_names_only_plots_of_its_folder() {
        let folder = std::env::temp_dir().join(format!("plot-list-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let list = "a_r=2,5.svg\n../b.svg\n/c.svg\nd\\e.svg\nf.mcap\n.svg.txt\n.g.svg\nC:h.svg\n";
        std::fs::write(folder.join(PLOT_LIST), list).unwrap();
        assert_eq!(listed_plots(&folder), ["a_r=2,5.svg"]);
        assert_eq!(listed_recordings(&folder), ["f.mcap"]);
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(listed_plots(&folder).is_empty());
    }
}

//! The newest frame of each run as text files for gnuplot, replaced in place, with a script that shows it in a loop.
//!
//! For each run: `STEM.txt` with `x y r` per line, `STEM.borders.txt` with one wall per block, `STEM.time.gp`, and the script `STEM.gp`.
//! Invariant: gnuplot reads whole files only, and a file that cannot be written changes neither the run nor its recording.

use kinetoscope_files::atomic_file::replace_unsynced;
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// Corners of a whole circle.
const CIRCLE_CORNERS: u32 = 128;

/// The folder of the files.
pub struct GnuplotLoop {
    folder: PathBuf,
}

impl GnuplotLoop {
    /// Creates the folder.
    ///
    /// # Errors
    /// A folder that cannot be created.
    pub fn create(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        Ok(Self { folder: folder.to_owned() })
    }

    /// Begins the files of a run.
    pub(crate) fn begin(
        &self,
        stem: &str,
        columns: &[StateColumn],
        scenery: &Scenery,
    ) -> GnuplotFiles {
        let index = |name: &str| columns.iter().position(|column| column.name == name);
        let files = GnuplotFiles {
            stem: self.folder.join(stem),
            row: columns.len(),
            columns: [index("x"), index("y"), index("radius")],
            radius: match scenery.drawn_radius {
                DrawnRadius::Column { min } => min,
                DrawnRadius::Fixed(radius) => radius,
            },
            last_time: 0.0,
        };
        files.write(".borders.txt", &borders(&scenery.walls));
        files.write(".gp", &script(stem, scenery));
        files
    }
}

/// The files of a run. Dropping them ends the loop of the script.
pub(crate) struct GnuplotFiles {
    /// The path without its ending.
    stem: PathBuf,
    /// Number of columns of the state.
    row: usize,
    /// The columns x, y and radius.
    columns: [Option<usize>; 3],
    /// Radius of particles without a column.
    radius: f64,
    last_time: f64,
}

impl GnuplotFiles {
    /// Replaces the files by the state at a time.
    pub(crate) fn update(&mut self, frame: &Frame, time: f64) {
        self.last_time = time;
        let [Some(x), Some(y), radius] = self.columns else { return };
        let mut text = String::new();
        for row in frame.state().chunks_exact(self.row) {
            let radius = radius.map_or(self.radius, |column| row[column]);
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{:?} {:?} {radius:?}", row[x], row[y]);
        }
        if !frame.walls().is_empty() {
            self.write(".borders.txt", &borders(frame.walls()));
        }
        self.write(".txt", &text);
        self.set_running(true);
    }

    fn set_running(&self, is_running: bool) {
        let running = u8::from(is_running);
        self.write(
            ".time.gp",
            &format!("set title \"t = {:.6}\"\nrunning = {running}\n", self.last_time),
        );
    }

    fn write(&self, ending: &str, text: &str) {
        let mut path = self.stem.clone().into_os_string();
        path.push(ending);
        // A viewer's file that cannot be written is no reason to stop a run.
        let _ = replace_unsynced(Path::new(&path), text.as_bytes());
    }
}

impl Drop for GnuplotFiles {
    fn drop(&mut self) {
        self.set_running(false);
    }
}

/// The ends of each wall's segments, block by block.
fn borders(walls: &[Wall]) -> String {
    let arc = |[x, y]: [f64; 2], radius: f64, [begin, end]: [f64; 2]| -> Vec<[f64; 2]> {
        let angle =
            |corner: u32| begin + (end - begin) * f64::from(corner) / f64::from(CIRCLE_CORNERS);
        let corners = (0..=CIRCLE_CORNERS).map(|corner| libm::sincos(angle(corner)));
        corners.map(|(sine, cosine)| [x + radius * cosine, y + radius * sine]).collect()
    };
    let mut text = String::new();
    for wall in walls {
        let corners = match *wall {
            Wall::Rectangle { min, max } => {
                vec![min, [max[0], min[1]], max, [min[0], max[1]], min]
            }
            Wall::Circle { center, radius } => arc(center, radius, [0.0, TAU]),
            Wall::Arc { center, radius, angles_rad: [begin, end] } => {
                let end = if end < begin { end + TAU } else { end };
                arc(center, radius, [begin, end])
            }
            Wall::Segment { from, to } => vec![from, to],
            Wall::Guide { .. } | Wall::Label { .. } | Wall::Body { .. } => continue,
        };
        for [x, y] in corners {
            let _ = writeln!(text, "{x:?} {y:?}");
        }
        text.push_str("\n\n");
    }
    text
}

/// The script that shows the newest frame twice per second until the run ends.
fn script(stem: &str, scenery: &Scenery) -> String {
    let [low, high] = scenery.view;
    let borders = if borders(&scenery.walls).is_empty() {
        String::new()
    } else {
        format!("\"{stem}.borders.txt\" with lines linewidth 2 linecolor \"gray50\" notitle, ")
    };
    format!(
        "# Shows the newest frame until the run ends: gnuplot {stem}.gp\n\
         set size ratio -1\n\
         set xrange [{}:{}]\nset yrange [{}:{}]\n\
         running = 1\n\
         while (running) {{\n\
         \x20   load \"{stem}.time.gp\"\n\
         \x20   plot {borders}\"{stem}.txt\" using 1:2:3 with circles notitle\n\
         \x20   pause 0.5\n\
         }}\n\
         pause -1 \"The run has ended; press Enter\"\n",
        low[0], high[0], low[1], high[1]
    )
}

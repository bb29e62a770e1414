//! Text files for gnuplot, as in the exercises: `x y r` per line, one file per frame, and a script that plays them.

use super::exporter::{ExportedRun, Exporter, WrittenFile};
use crate::write_file::{WriteError, replace_unsynced};
use kinetoscope_recording::reader::RecordedFrame;
use std::fmt::Write as _;
use std::path::PathBuf;

pub(super) struct Gnuplot {
    run: ExportedRun,
    folder: PathBuf,
    written: Vec<WrittenFile>,
    frames: u64,
    /// Lower left and upper right corner of the positions, for models without walls.
    seen: [[f64; 2]; 2],
}

impl Gnuplot {
    pub(super) fn new(run: ExportedRun, folder: PathBuf) -> Self {
        let seen = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        Self { run, folder, written: Vec::new(), frames: 0, seen }
    }

    fn write(&mut self, name: &str, text: &str, rows: usize) -> Result<(), WriteError> {
        let path = self.folder.join(name);
        replace_unsynced(&path, text)?;
        self.written.push(WrittenFile { path, rows: rows as u64 });
        Ok(())
    }

    fn script(&self) -> String {
        let [low, high] = self.run.extent.bounds.unwrap_or(self.seen);
        let points = self.run.extent.radius == 0.0 && self.run.index("radius").is_none();
        let style =
            if points { "using 1:2 with points pointtype 7" } else { "using 1:2:3 with circles" };
        let last = self.frames.saturating_sub(1);
        format!(
            "# Plays the frames: gnuplot play.gp\n\
             set size ratio -1\n\
             set xrange [{}:{}]\nset yrange [{}:{}]\n\
             do for [frame = 0:{last}] {{\n\
             \x20   set title sprintf(\"frame %d\", frame)\n\
             \x20   plot sprintf(\"frame_%06d.txt\", frame) {style} notitle\n\
             \x20   pause 0.04\n\
             }}\n\
             pause mouse close\n",
            low[0], high[0], low[1], high[1]
        )
    }
}

impl Exporter for Gnuplot {
    fn write_frame(&mut self, frame: &RecordedFrame) -> Result<(), WriteError> {
        let Some(state) = frame.state() else { return Ok(()) };
        let (Some(x), Some(y)) = (self.run.index("x"), self.run.index("y")) else {
            return Ok(());
        };
        let radius = self.run.index("radius");
        let mut text = String::new();
        for particle in 0..state.rows() {
            let row = state.row(particle);
            let radius = radius.map_or(self.run.extent.radius, |column| row[column]);
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{:?} {:?} {radius:?}", row[x], row[y]);
            for (axis, place) in [row[x], row[y]].into_iter().enumerate() {
                self.seen[0][axis] = self.seen[0][axis].min(place);
                self.seen[1][axis] = self.seen[1][axis].max(place);
            }
        }
        self.frames = frame.clock.frame + 1;
        self.write(&format!("frame_{:06}.txt", frame.clock.frame), &text, state.rows())
    }

    fn finish(&mut self) -> Result<Vec<WrittenFile>, WriteError> {
        self.write("play.gp", &self.script(), 0)?;
        Ok(std::mem::take(&mut self.written))
    }
}

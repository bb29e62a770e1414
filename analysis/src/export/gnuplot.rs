//! Text files for gnuplot, as in the exercises: `x y r` per line, and `vx vy` if recorded, one file per frame, the borders, and
//! scripts that play the particles and their velocities.

use super::exporter::{ExportedRun, Exporter, WrittenFile};
use crate::number_text::short_number;
use crate::plot::drawing::segments_of;
use crate::plot::velocity_field::ArrowScale;
use crate::write_file::{WriteError, replace_unsynced};
use kinetoscope_recording::reader::RecordedFrame;
use std::fmt::Write as _;
use std::path::PathBuf;

/// The container and the walls at rest: the ends of one segment per block.
const BORDERS: &str = "borders.txt";

pub(super) struct Gnuplot {
    run: ExportedRun,
    folder: PathBuf,
    written: Vec<WrittenFile>,
    /// Indices of the frames: keyframes and parts of a run have not all of them.
    frames: Vec<u64>,
    /// Lower left and upper right corner of the positions, for models without walls.
    seen: [[f64; 2]; 2],
    max_speed: f64,
}

impl Gnuplot {
    pub(super) fn new(run: ExportedRun, folder: PathBuf) -> Self {
        let seen = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        Self { run, folder, written: Vec::new(), frames: Vec::new(), seen, max_speed: 0.0 }
    }

    fn write(&mut self, name: &str, text: &str, rows: usize) -> Result<(), WriteError> {
        let path = self.folder.join(name);
        replace_unsynced(&path, text)?;
        self.written.push(WrittenFile { path, rows: rows as u64 });
        Ok(())
    }

    fn bounds(&self) -> [[f64; 2]; 2] {
        self.run.extent.bounds.unwrap_or(self.seen)
    }

    /// A script that plays the frames; `settings` and `style` draw the particles of one.
    fn script(&self, name: &str, settings: &str, style: &str) -> String {
        let [low, high] = self.bounds();
        let borders = if self.run.extent.walls.is_empty() {
            String::new()
        } else {
            format!("\"{BORDERS}\" with lines linewidth 2 linecolor \"gray50\" notitle, ")
        };
        format!(
            "# Plays the frames: gnuplot {name}\n\
             set size ratio -1\n\
             set xrange [{}:{}]\nset yrange [{}:{}]\n\
             {settings}do for [frame {}] {{\n\
             \x20   set title sprintf(\"frame %d\", int(frame))\n\
             \x20   plot {borders}sprintf(\"frame_%06d.txt\", int(frame)) {style} notitle\n\
             \x20   pause 0.04\n\
             }}\n\
             pause -1 \"Press Enter to end\"\n",
            low[0],
            high[0],
            low[1],
            high[1],
            self.range()
        )
    }

    /// The frames as gnuplot iterates over them.
    fn range(&self) -> String {
        let [first, last] =
            [self.frames.first(), self.frames.last()].map(|frame| frame.copied().unwrap_or(0));
        if self.frames.windows(2).all(|pair| pair[1] == pair[0] + 1) {
            return format!("= {first}:{last}");
        }
        let words: Vec<String> = self.frames.iter().map(u64::to_string).collect();
        format!("in \"{}\"", words.join(" "))
    }

    /// The script that plays the velocities as arrows to scale, with a key; `None` for particles at rest or without velocities.
    fn velocity_script(&self) -> Option<String> {
        let (vx, [low, high]) = (self.run.index("vx")?, self.bounds());
        let side = (high[0] - low[0]).max(high[1] - low[1]);
        let ArrowScale { length_over_speed, key_speed } = ArrowScale::new(self.max_speed, side)?;
        let unit = self.run.units.get(vx).map_or("", |unit| plain(unit));
        let length = key_speed * length_over_speed;
        let [x, y, top] = [low[0] + 0.02 * side, high[1] + 0.05 * side, high[1] + 0.1 * side];
        let settings = format!(
            "set yrange [{}:{top}]\n\
             set arrow from {x},{y} rto {length},0\n\
             set label \"{} {unit}\" at {},{y}\n",
            low[1],
            short_number(key_speed),
            x + length + 0.02 * side
        );
        let style =
            format!("using 1:2:($4*{length_over_speed}):($5*{length_over_speed}) with vectors");
        Some(self.script("velocity.gp", &settings, &style))
    }
}

/// A unit that may be part of a script, or nothing: gnuplot executes commands within other text, and a recording may be a stranger's.
fn plain(unit: &str) -> &str {
    let is_plain = |part: char| part.is_ascii_alphanumeric() || "/^*.- ".contains(part);
    if unit.chars().all(is_plain) { unit } else { "" }
}

impl Exporter for Gnuplot {
    fn write_frame(&mut self, frame: &RecordedFrame) -> Result<(), WriteError> {
        let Some(state) = frame.state() else { return Ok(()) };
        let (Some(x), Some(y)) = (self.run.index("x"), self.run.index("y")) else {
            return Ok(());
        };
        let radius = self.run.index("radius");
        let velocity = self.run.index("vx").zip(self.run.index("vy"));
        let mut text = String::new();
        for particle in 0..state.rows() {
            let row = state.row(particle);
            let radius = radius.map_or(self.run.extent.radius, |column| row[column]);
            // Writing to a String cannot fail.
            let _ = write!(text, "{:?} {:?} {radius:?}", row[x], row[y]);
            if let Some((vx, vy)) = velocity {
                let _ = write!(text, " {:?} {:?}", row[vx], row[vy]);
                self.max_speed = self.max_speed.max(libm::hypot(row[vx], row[vy]));
            }
            text.push('\n');
            for (axis, place) in [row[x], row[y]].into_iter().enumerate() {
                self.seen[0][axis] = self.seen[0][axis].min(place);
                self.seen[1][axis] = self.seen[1][axis].max(place);
            }
        }
        self.frames.push(frame.clock.frame);
        self.write(&format!("frame_{:06}.txt", frame.clock.frame), &text, state.rows())
    }

    fn finish(&mut self) -> Result<Vec<WrittenFile>, WriteError> {
        let segments: Vec<_> = segments_of(&self.run.extent.walls).collect();
        if !segments.is_empty() {
            let block = |[[x, y], [to_x, to_y]]: &[[f64; 2]; 2]| {
                format!("{x:?} {y:?}\n{to_x:?} {to_y:?}\n\n")
            };
            let text: String = segments.iter().map(block).collect();
            self.write(BORDERS, &text, segments.len())?;
        }
        let points = self.run.extent.radius == 0.0 && self.run.index("radius").is_none();
        let style =
            if points { "using 1:2 with points pointtype 7" } else { "using 1:2:3 with circles" };
        self.write("play.gp", &self.script("play.gp", "", style), 0)?;
        if let Some(script) = self.velocity_script() {
            self.write("velocity.gp", &script, 0)?;
        }
        Ok(std::mem::take(&mut self.written))
    }
}

#[cfg(test)]
mod tests {
    use super::plain;

    /// Control: the units of the models are kept.
    #[test]
    fn units_that_gnuplot_could_execute_are_omitted() {
        for hostile in ["\"\n!touch x\n#", "`id`", "@x", "m\\", "$(id)"] {
            assert_eq!(plain(hostile), "", "{hostile}");
        }
        for unit in ["m/s", "au/d", "m/s^2", "1", ""] {
            assert_eq!(plain(unit), unit);
        }
    }
}

//! Extended XYZ for OVITO and ASE: every column of the state, the box, and the time.

use super::exporter::{ExportedRun, Exporter, WrittenFile};
use crate::write_file::{WriteError, begin};
use kinetoscope_recording::atomic_file::NewFile;
use kinetoscope_recording::reader::RecordedFrame;
use std::io::Write;
use std::path::PathBuf;

pub(super) struct Xyz {
    run: ExportedRun,
    path: PathBuf,
    file: Option<NewFile>,
    rows: u64,
}

impl Xyz {
    pub(super) fn new(run: ExportedRun, folder: PathBuf) -> Self {
        Self { run, path: folder.join("state.xyz"), file: None, rows: 0 }
    }

    /// The second line of a frame: box, columns, time.
    fn comment(&self, frame: u64, time: f64) -> String {
        let lattice = self.run.extent.bounds.map_or_else(String::new, |[low, high]| {
            // The box has a thickness, because readers reject a box without a volume.
            let [width, height] = [0, 1].map(|axis| high[axis] - low[axis]);
            let depth = width.min(height);
            format!(
                "Lattice=\"{width} 0 0 0 {height} 0 0 0 {depth}\" Origin=\"{} {} {}\" pbc=\"F F F\" ",
                low[0],
                low[1],
                -depth / 2.0
            )
        });
        let others: String = self.others().map(|(_, name)| format!(":{name}:R:1")).collect();
        format!(
            "{lattice}Properties=species:S:1:pos:R:3:velo:R:3:radius:R:1{others} Time={time:?} Frame={frame}"
        )
    }

    /// The columns without a standard XYZ property.
    fn others(&self) -> impl Iterator<Item = (usize, &String)> {
        let known = ["x", "y", "z", "vx", "vy", "vz", "radius"];
        let columns = self.run.columns.iter().enumerate();
        columns.filter(move |(_, name)| !known.contains(&name.as_str()))
    }

    fn frame(&self, file: &mut impl Write, frame: &RecordedFrame) -> std::io::Result<()> {
        let Some(state) = frame.state() else { return Ok(()) };
        writeln!(file, "{}", state.rows())?;
        writeln!(file, "{}", self.comment(frame.clock.frame, frame.clock.time))?;
        let places = ["x", "y", "z", "vx", "vy", "vz"].map(|name| self.run.index(name));
        let radius = self.run.index("radius");
        for particle in 0..state.rows() {
            let row = state.row(particle);
            // The type is not an element; OVITO accepts any name.
            write!(file, "X")?;
            for place in places {
                write!(file, " {:?}", place.map_or(0.0, |column| row[column]))?;
            }
            write!(file, " {:?}", radius.map_or(self.run.extent.radius, |column| row[column]))?;
            for (column, _) in self.others() {
                write!(file, " {:?}", row[column])?;
            }
            writeln!(file)?;
        }
        Ok(())
    }
}

impl Exporter for Xyz {
    fn write_frame(&mut self, frame: &RecordedFrame) -> Result<(), WriteError> {
        let failed = |error| WriteError::new(&self.path, error);
        let mut file = match self.file.take() {
            Some(file) => file,
            None => begin(&self.path)?,
        };
        self.frame(&mut file, frame).map_err(failed)?;
        self.file = Some(file);
        self.rows += frame.state().map_or(0, |state| state.rows() as u64);
        Ok(())
    }

    fn finish(&mut self) -> Result<Vec<WrittenFile>, WriteError> {
        let Some(file) = self.file.take() else { return Ok(Vec::new()) };
        file.finish().map_err(|error| WriteError::new(&self.path, error))?;
        Ok(vec![WrittenFile { path: self.path.clone(), rows: self.rows }])
    }
}

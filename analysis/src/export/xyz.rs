//! Extended XYZ for OVITO and ASE: every column of the state, the box, and the time.

use super::exporter::{ExportedRun, Exporter, WrittenFile};
use crate::write_file::{WriteError, begin};
use kinetoscope_files::atomic_file::NewFile;
use kinetoscope_recording::reader::RecordedFrame;
use std::io::Write;
use std::path::PathBuf;

/// The properties of every particle, and the names that readers give to the species.
const STANDARD: [&str; 6] = ["species", "numbers", "Z", "pos", "velo", "radius"];

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
        let others = self.others().map(|(_, name)| format!(":{}:R:1", self.property(name)));
        let others: String = others.collect();
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

    /// The property of a column: its name, with underscores where a standard property or another column has it.
    fn property(&self, column: &str) -> String {
        let mut name = column.to_owned();
        while STANDARD.contains(&name.as_str())
            || (name != column && self.run.columns.contains(&name))
        {
            name.push('_');
        }
        name
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::contract::Extent;

    /// Guarantee: every property has a name of its own. Control: other names stay as they are.
    #[test]
    fn columns_named_as_standard_properties_are_told_apart() {
        let columns = ["x", "velo", "velo_", "spin"].map(str::to_owned).to_vec();
        let run = ExportedRun {
            extent: Extent::default(),
            units: vec![String::new(); columns.len()],
            columns,
            time_unit: "s".to_owned(),
            coordinates: Vec::new(),
            replicate: None,
        };
        let xyz = Xyz::new(run, PathBuf::new());
        let comment = xyz.comment(0, 0.0);
        assert!(
            comment.contains(":velo:R:3:radius:R:1:velo__:R:1:velo_:R:1:spin:R:1 "),
            "{comment}"
        );
    }
}

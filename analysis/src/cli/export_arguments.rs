//! The command `kinetoscope export`: recordings in the formats of other programs, or as a small picture.

use super::exit::CommandError;
use super::meant_paths::meant_paths;
use super::messages::{complain_unreadable, concluded, terminal};
use crate::export::{self, Export, ExportFormat};
use crate::input::recording::with_frame_limit;
use crate::input::{self, RecordingFolder, UnreadableRecording};
use crate::thumbnail::{ThumbnailFormat, ThumbnailOptions, thumbnail};
use crate::write_file;
use clap::ValueEnum as _;
use kinetoscope_console::text::{plural, shown_path};
use kinetoscope_console::{Exit, Message, StandardOutput};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

/// Write recordings in the formats of other programs, or draw one as a small picture.
#[derive(Debug, clap::Args)]
pub struct ExportArguments {
    /// Recordings, and folders of recordings
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Formats
    #[arg(
        long,
        value_name = "FORMAT,…",
        value_delimiter = ',',
        required_unless_present = "thumbnail"
    )]
    format: Vec<ExportFormat>,
    /// Folder for the exported files [default: `export` in the folder of the recordings]
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Draw one recording as a small picture, a .png or .svg
    #[arg(long, value_name = "FILE", conflicts_with_all = ["format", "output"], help_heading = "Thumbnail")]
    thumbnail: Option<PathBuf>,
    /// Number of pictures of an animated thumbnail (.png as APNG), evenly spaced; 1 is the last frame
    #[arg(
        long,
        value_name = "N",
        default_value = "1",
        requires = "thumbnail",
        help_heading = "Thumbnail"
    )]
    thumbnail_frames: NonZeroU32,
    /// Width of a thumbnail in pixels, from 64 to 4096
    #[arg(long, value_name = "PIXELS", default_value = "480", requires = "thumbnail", value_parser = width,
          help_heading = "Thumbnail")]
    thumbnail_width: NonZeroU32,
    /// Print errors only
    #[arg(long, short, help_heading = "Messages")]
    quiet: bool,
    /// Print the written files with their rows and bytes as JSON
    #[arg(long, help_heading = "Messages")]
    json: bool,
    #[arg(skip)]
    standard_output: StandardOutput,
}

impl ExportArguments {
    /// Writes the files.
    #[must_use]
    pub fn execute(&self) -> Exit {
        let result = match &self.thumbnail {
            Some(file) => self.draw(file),
            None => self.export(),
        };
        concluded(result, &self.standard_output, self.json)
    }

    fn say(&self, text: &str) {
        if !self.quiet && !self.json {
            self.standard_output.print_styled(text);
        }
    }

    fn print_json(&self, exit: Exit, exports: impl IntoIterator<Item = Value>) {
        if self.json {
            let exports: Vec<Value> = exports.into_iter().collect();
            let document = json!({ "exit_code": exit.code(), "exports": exports });
            self.standard_output.print_json(&format!("{document:#}\n"));
        }
    }

    fn export(&self) -> Result<Exit, CommandError> {
        if self.format.contains(&ExportFormat::Parquet) && cfg!(not(feature = "parquet")) {
            return Err(CommandError::usage(export::needs_parquet()));
        }
        let sources = input::sources(&meant_paths(&self.paths)?)?;
        let several = input::are_several(&sources);
        let (mut exports, mut unreadable) = (Vec::new(), BTreeSet::new());
        for source in &sources {
            unreadable.extend(source.unreadable.iter().cloned());
        }
        for source in sources.iter().filter(|source| !source.files.is_empty()) {
            let folder = match &self.output {
                Some(output) if several => output.join(&source.name),
                Some(output) => output.clone(),
                None if source.is_remote() => {
                    let folder = shown_path(&source.folder);
                    return Err(CommandError::usage(Message::new(
                        format!("{folder} is not on this machine"),
                        "name a folder with --output DIR",
                    )));
                }
                None => source.folder.join("export"),
            };
            let say = |line: &str| self.say(line);
            exports.extend(export_all(source, &self.format, &folder, say, &mut unreadable)?);
        }
        unreadable.iter().for_each(complain_unreadable);
        let exit = UnreadableRecording::exit(&unreadable).unwrap_or(Exit::Done);
        self.print_json(
            exit,
            exports.iter().map(|export| {
                let format = export.format.to_possible_value();
                let files = export.files.iter().map(|file| written(&file.path, Some(file.rows)));
                json!({
                    "recording": export.recording,
                    "format": format.map(|format| format.get_name().to_owned()),
                    "files": files.collect::<Vec<_>>(),
                })
            }),
        );
        Ok(exit)
    }

    /// Draws the one recording among the paths.
    fn draw(&self, file: &Path) -> Result<Exit, CommandError> {
        let format =
            ThumbnailFormat::of(file, self.thumbnail_frames).map_err(CommandError::usage)?;
        write_file::check(file)?;
        let sources = input::sources(&meant_paths(&self.paths)?)?;
        let recordings: Vec<(&RecordingFolder, &PathBuf)> = sources
            .iter()
            .flat_map(|source| source.files.iter().map(move |path| (source, path)))
            .collect();
        let [(source, path)] = recordings.as_slice() else {
            return Err(CommandError::usage(Message::new(
                "a thumbnail shows one recording",
                "name its file",
            )));
        };
        let recording = source.recording(path)?;
        let recording = with_frame_limit(recording);
        let options = ThumbnailOptions { format, width: self.thumbnail_width };
        let drawn = thumbnail(&recording, options)?;
        let size = drawn.len().div_ceil(1000);
        write_file::write(file, drawn)?;
        self.say(&format!("written: {} ({size} kB)\n", shown_path(file)));
        let files = [written(file, None)];
        self.print_json(
            Exit::Done,
            [json!({ "recording": path, "format": "thumbnail", "files": files })],
        );
        Ok(Exit::Done)
    }
}

/// A written file, with its number of rows if it is a table.
fn written(path: &Path, rows: Option<u64>) -> Value {
    let bytes = std::fs::metadata(path).map(|file| file.len()).ok();
    json!({ "path": path, "rows": rows, "bytes": bytes })
}

/// Parses the width of a picture.
fn width(text: &str) -> Result<NonZeroU32, String> {
    let width = text.parse().ok().filter(|width: &NonZeroU32| (64..=4096).contains(&width.get()));
    width.ok_or_else(|| "must be a number from 64 to 4096".to_owned())
}

/// Exports the recordings in all requested formats to a folder, and passes one line per format to `say`. `unreadable` receives
/// what cannot be read.
pub(super) fn export_all(
    source: &RecordingFolder,
    formats: &[ExportFormat],
    folder: &Path,
    say: impl Fn(&str),
    unreadable: &mut BTreeSet<UnreadableRecording>,
) -> Result<Vec<Export>, CommandError> {
    let mut all = Vec::new();
    for format in formats {
        let mut exports = export::export(source, *format, folder, unreadable)?;
        let count = exports.iter().filter(|export| !export.files.is_empty()).count();
        let recordings = plural(count as u64, "recording");
        let line = format!("exported: {recordings} to {}", shown_path(folder));
        say(&format!("{}\n", terminal().wrapped(&line, 2)));
        all.append(&mut exports);
    }
    Ok(all)
}

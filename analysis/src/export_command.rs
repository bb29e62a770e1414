//! The command line of `kinetoscope export`: recordings in the formats of other programs, or as a small picture.

use crate::command::{Exit, concluded, export_all, print, sources, terminal};
use crate::export::{self, Form};
use crate::files;
use crate::input::Source;
use crate::thumbnail::{PictureForm, ThumbnailError, Wish, thumbnail};
use kinetoscope_recording::error::ReadError;
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
    format: Vec<Form>,
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
}

impl ExportArguments {
    /// Writes the files.
    #[must_use]
    pub fn execute(&self) -> Exit {
        concluded(match &self.thumbnail {
            Some(file) => self.draw(file),
            None => self.export(),
        })
    }

    fn say(&self, text: &str) {
        if !self.quiet {
            print(text);
        }
    }

    fn export(&self) -> Result<Exit, (Exit, String)> {
        if self.format.contains(&Form::Parquet) && cfg!(not(feature = "parquet")) {
            return Err((Exit::Usage, export::NEEDS_PARQUET.to_owned()));
        }
        let sources = sources(&self.paths)?;
        let several = sources.len() > 1;
        for source in &sources {
            let folder = match &self.output {
                Some(output) if several => output.join(&source.name),
                Some(output) => output.clone(),
                None if source.is_remote() => {
                    let folder = source.folder.display();
                    return Err((
                        Exit::Usage,
                        format!("{folder} is not on this machine: name a folder with --output DIR"),
                    ));
                }
                None => source.folder.join("export"),
            };
            for line in export_all(source, &self.format, &folder, terminal())? {
                self.say(&line);
            }
        }
        Ok(Exit::Done)
    }

    /// Draws the one recording among the paths.
    fn draw(&self, file: &Path) -> Result<Exit, (Exit, String)> {
        let usage = |message: &str| (Exit::Usage, message.to_owned());
        let form = PictureForm::of(file, self.thumbnail_frames).map_err(usage)?;
        let sources = sources(&self.paths)?;
        let recordings: Vec<(&Source, &PathBuf)> = sources
            .iter()
            .flat_map(|source| source.files.iter().map(move |path| (source, path)))
            .collect();
        let [(source, path)] = recordings.as_slice() else {
            return Err(usage("a thumbnail shows one recording: name its file"));
        };
        let unread = |error: ReadError| (Exit::Unreadable, error.to_string());
        let recording = source.recording(path).map_err(unread)?;
        let wish = Wish { form, width: self.thumbnail_width };
        let unreadable = |error: ThumbnailError| (Exit::Unreadable, error.to_string());
        let drawn = thumbnail(&recording, wish).map_err(unreadable)?;
        let size = drawn.len().div_ceil(1000);
        files::replace(file, drawn).map_err(|error| (Exit::Retry, error.to_string()))?;
        self.say(&format!("written: {} ({size} kB)\n", file.display()));
        Ok(Exit::Done)
    }
}

/// Parses the width of a picture.
fn width(text: &str) -> Result<NonZeroU32, String> {
    let width = text.parse().ok().filter(|width: &NonZeroU32| (64..=4096).contains(&width.get()));
    width.ok_or_else(|| "must be a number from 64 to 4096".to_owned())
}

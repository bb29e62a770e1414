//! A small picture of a recording, still or moving, for a page or a slide: drawn from the recording's own scenes, with their
//! colours, without a viewer.

mod glyphs;
mod png_file;
mod raster;
mod sheet;
mod svg;

use kinetoscope_recording::drawing::{Shape, read_shapes};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, Recording};
use raster::Raster;
use sheet::Sheet;
use std::num::NonZeroU32;
use std::path::Path;

/// Topics in the order in which they are drawn, the lowest first. Arrows and force chains would hide a small picture.
const LAYERS: [&str; 4] = ["/trail", "/walls", "/discs", "/legend"];

/// The shapes of a frame, layer by layer.
type Drawing = [Vec<Shape>; LAYERS.len()];

/// The form of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureForm {
    /// Lines and discs, to any scale.
    Svg,
    /// Pixels; with several frames an APNG, which browsers play.
    Png,
}

impl PictureForm {
    /// By the end of a file's name.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        match ending.as_str() {
            "svg" => Some(Self::Svg),
            "png" | "apng" => Some(Self::Png),
            _ => None,
        }
    }
}

/// What a picture shall be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wish {
    /// Its form.
    pub form: PictureForm,
    /// How many frames, evenly spread over the recording and played as fast as it; 1 is the last frame.
    pub frames: NonZeroU32,
    /// Width, px.
    pub width: NonZeroU32,
}

/// Why there is no picture.
#[derive(Debug)]
pub enum ThumbnailError {
    /// The recording can't be read.
    Read(ReadError),
    /// It can't be drawn, in words.
    Undrawn(String),
}

impl From<ReadError> for ThumbnailError {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}

impl std::fmt::Display for ThumbnailError {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Read(error) => error.fmt(formatter),
            Self::Undrawn(why) => formatter.write_str(why),
        }
    }
}

impl std::error::Error for ThumbnailError {}

/// Draws a recording and returns the file's bytes, the same for the same recording and wish.
///
/// # Errors
/// A recording that is not whole, or that has no drawing.
pub fn thumbnail(recording: &Path, wish: Wish) -> Result<Vec<u8>, ThumbnailError> {
    let recording = Recording::open(recording)?;
    let playback_rate = recording.provenance().playback_rate;
    let mut frames = 0;
    for frame in recording.frames()? {
        frame?;
        frames += 1;
    }
    let chosen = chosen(frames, u64::from(wish.frames.get()));
    let drawings = drawings(&recording, &chosen)?;
    let undrawn = |why: &str| ThumbnailError::Undrawn(why.to_owned());
    let sheet = Sheet::new(&drawings, wish.width.get());
    let sheet = sheet.ok_or_else(|| {
        undrawn("the recording has no drawing: record the channel \"discs\" as well")
    })?;
    match wish.form {
        PictureForm::Svg => match drawings.as_slice() {
            [drawing] => Ok(svg::document(&sheet, drawing).into_bytes()),
            _ => Err(undrawn("an SVG does not move: write a .png, or ask for one frame")),
        },
        PictureForm::Png => {
            let rasters: Vec<Raster> =
                drawings.iter().map(|drawing| Raster::of(&sheet, drawing)).collect();
            let seconds = frames as f64 / playback_rate / rasters.len() as f64;
            png_file::file(&rasters, seconds).map_err(ThumbnailError::Undrawn)
        }
    }
}

/// Which of so many frames are drawn: evenly spread from the first to the last, or the last alone.
fn chosen(frames: u64, wanted: u64) -> Vec<u64> {
    let Some(last) = frames.checked_sub(1) else { return Vec::new() };
    let wanted = wanted.min(frames);
    if wanted == 1 {
        return vec![last];
    }
    (0..wanted).map(|picture| picture * last / (wanted - 1)).collect()
}

/// What is drawn in each chosen frame. What is drawn once belongs to all that follow.
fn drawings(recording: &Recording, chosen: &[u64]) -> Result<Vec<Drawing>, ThumbnailError> {
    let mut layers = Drawing::default();
    let mut drawings = Vec::with_capacity(chosen.len());
    for frame in recording.frames()? {
        let frame = frame?;
        let wanted = chosen.contains(&frame.clock.frame);
        if wanted || frame.clock.frame == 0 {
            draw(&frame, &mut layers)?;
        }
        if wanted {
            drawings.push(layers.clone());
        }
    }
    Ok(drawings)
}

fn draw(frame: &RecordedFrame, layers: &mut Drawing) -> Result<(), ThumbnailError> {
    for (topic, layer) in LAYERS.iter().zip(layers) {
        let message = frame.messages().iter().find(|message| message.topic() == *topic);
        if let Some(message) = message {
            *layer = read_shapes(message.payload()).ok_or_else(|| {
                let frame = frame.clock.frame;
                ThumbnailError::Undrawn(format!("{topic} of frame {frame} is no drawing"))
            })?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_evenly_spread_from_the_first_to_the_last() {
        assert_eq!(chosen(301, 1), [300]);
        assert_eq!(chosen(301, 4), [0, 100, 200, 300]);
        assert_eq!(chosen(3, 60), [0, 1, 2]);
        assert!(chosen(0, 5).is_empty());
    }
}

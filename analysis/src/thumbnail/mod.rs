//! Thumbnails of a recording, static or animated, drawn from the recorded scenes with their colors.

mod png_file;

use crate::plot::drawing::{Drawing, InvalidScene};
use crate::plot::page::PageLayout;
use crate::plot::png::SvgRenderer;
use crate::plot::shapes_svg;
use kinetoscope_console::{Explained, Message};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::Recording;
use std::num::NonZeroU32;
use std::path::Path;

/// The format of a thumbnail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ThumbnailFormat {
    /// The last frame as vector graphics.
    Svg,
    /// Pixels, as PNG or APNG.
    Png {
        /// Number of frames, evenly spread over the recording and played at its speed as an APNG; 1 is the last frame.
        frames: NonZeroU32,
    },
}

impl ThumbnailFormat {
    /// Selects the format by the extension of a file name and the number of frames.
    ///
    /// # Errors
    /// An unsupported combination, with the reason.
    pub(crate) fn of(path: &Path, frames: NonZeroU32) -> Result<Self, Message> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        match ending.to_ascii_lowercase().as_str() {
            "svg" if frames == NonZeroU32::MIN => Ok(Self::Svg),
            "svg" => {
                Err(Message::new("an SVG does not move", "write a .png, or ask for one frame"))
            }
            "png" | "apng" => Ok(Self::Png { frames }),
            _ => Err(Message::new(
                "the name of a thumbnail ends in neither .png nor .svg",
                "write `--thumbnail NAME.png`",
            )),
        }
    }
}

/// Options of a thumbnail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ThumbnailOptions {
    /// The format.
    pub(crate) format: ThumbnailFormat,
    /// The width, px.
    pub(crate) width: NonZeroU32,
}

/// Why a recording has no thumbnail.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ThumbnailError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A recorded scene cannot be decoded.
    #[error(transparent)]
    Scene(#[from] InvalidScene),
    /// It cannot be drawn, with the reason.
    #[error("{}", .0.what)]
    NotDrawn(Message),
}

impl Explained for ThumbnailError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Read(error) => error.help(),
            Self::Scene(_) => None,
            Self::NotDrawn(message) => message.help.clone(),
        }
    }
}

/// Draws a recording and returns the bytes of the file; equal recordings and options give equal bytes.
///
/// # Errors
/// A damaged recording, or one without drawings.
pub(crate) fn thumbnail(
    recording: &Recording,
    options: ThumbnailOptions,
) -> Result<Vec<u8>, ThumbnailError> {
    let playback_fps = recording.provenance().playback_fps;
    let mut frames = 0;
    let mut indices: Option<[u64; 2]> = None;
    for frame in recording.frames()? {
        let index = frame?.clock.frame;
        indices = Some(indices.map_or([index; 2], |[first, _]| [first, index]));
        frames += 1;
    }
    let wanted = match options.format {
        ThumbnailFormat::Svg => NonZeroU32::MIN,
        ThumbnailFormat::Png { frames } => frames,
    };
    let drawings = drawings(recording, &chosen(frames, u64::from(wanted.get())))?;
    let undrawn = || {
        ThumbnailError::NotDrawn(Message::new(
            "the recording has no drawing",
            "record \"discs\" too",
        ))
    };
    let page = PageLayout::new(&drawings, options.width).ok_or_else(undrawn)?;
    match options.format {
        ThumbnailFormat::Svg => {
            let last = drawings.last().ok_or_else(undrawn)?;
            Ok(shapes_svg::document(&page, last).into_bytes())
        }
        ThumbnailFormat::Png { .. } => {
            let renderer = SvgRenderer::new();
            let draw = |drawing| renderer.raster(&shapes_svg::document(&page, drawing), 1.0);
            let rasters = drawings.iter().map(draw).collect::<Result<Vec<_>, _>>();
            let rasters = rasters.map_err(|error| ThumbnailError::NotDrawn(error.0))?;
            // Keyframes are played as fast as the run that they are of.
            let played = indices.map_or(0, |[first, last]| last.saturating_sub(first)) as f64 + 1.0;
            let seconds = played / playback_fps / rasters.len() as f64;
            png_file::file(&rasters, seconds).map_err(|why| ThumbnailError::NotDrawn(why.into()))
        }
    }
}

/// An SVG document as the pixels of a PNG file.
///
/// # Errors
/// The message of the drawing library.
pub(crate) fn still_png(svg: &str) -> Result<Vec<u8>, ThumbnailError> {
    let raster = SvgRenderer::new().raster(svg, 1.0);
    let raster = raster.map_err(|error| ThumbnailError::NotDrawn(error.0))?;
    png_file::file(&[raster], 0.0).map_err(|why| ThumbnailError::NotDrawn(why.into()))
}

/// Which frames of the file are drawn: evenly spread from the first to the last, or only the last.
fn chosen(frames: u64, wanted: u64) -> Vec<u64> {
    let Some(last) = frames.checked_sub(1) else { return Vec::new() };
    let wanted = wanted.min(frames);
    if wanted == 1 {
        return vec![last];
    }
    (0..wanted).map(|picture| picture * last / (wanted - 1)).collect()
}

/// The drawings of the chosen frames of the file, which may be keyframes or a part of a run. A layer that is recorded once, with the
/// first one, applies to all following frames.
fn drawings(recording: &Recording, chosen: &[u64]) -> Result<Vec<Drawing>, ThumbnailError> {
    let mut layers = Drawing::default();
    let mut drawings = Vec::with_capacity(chosen.len());
    for (place, frame) in (0..).zip(recording.frames()?) {
        let frame = frame?;
        let wanted = chosen.contains(&place);
        if wanted || place == 0 {
            layers.update(&frame)?;
        }
        if wanted {
            drawings.push(layers.clone());
        }
    }
    Ok(drawings)
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

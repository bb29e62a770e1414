//! Rasters as a PNG file, or several as an APNG, with at most 256 colors, which makes files five times smaller.

use crate::plot::png::Raster;
use kinetoscope_recording::drawing::Rgb;
use std::collections::HashMap;

/// Duration of the last picture before an animation restarts, s.
const REST: f64 = 2.0;

/// Encodes a file. Each picture of an animation except the last is shown for `seconds`.
///
/// # Errors
/// The message of the encoder.
pub(super) fn file(rasters: &[Raster], seconds: f64) -> Result<Vec<u8>, String> {
    let Some(first) = rasters.first() else { return Err("there is no frame".to_owned()) };
    let mut palette = Palette::of(rasters);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, first.width, first.height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette.colors.concat());
    encoder.set_compression(png::Compression::High);
    // Differences of indices of a palette are no smaller than the indices.
    encoder.set_filter(png::Filter::NoFilter);
    let words = |error: png::EncodingError| error.to_string();
    if rasters.len() > 1 {
        encoder.set_animated(rasters.len() as u32, 0).map_err(words)?;
    }
    let mut writer = encoder.write_header().map_err(words)?;
    let mut before: Option<&Raster> = None;
    for (index, raster) in rasters.iter().enumerate() {
        let part = before.map_or(Part::whole(raster), |before| Part::changed(before, raster));
        if rasters.len() > 1 {
            let is_last = index + 1 == rasters.len();
            let stays = if is_last { seconds + REST } else { seconds };
            let milliseconds = libm::round(stays * 1000.0).clamp(1.0, f64::from(u16::MAX)) as u16;
            writer.set_frame_delay(milliseconds, 1000).map_err(words)?;
            // The origin is reset first, because dimension and position are validated together.
            writer.reset_frame_position().map_err(words)?;
            writer.set_frame_dimension(part.width, part.height).map_err(words)?;
            writer.set_frame_position(part.left, part.top).map_err(words)?;
        }
        writer.write_image_data(&part.indices(raster, &mut palette)).map_err(words)?;
        before = Some(raster);
    }
    writer.finish().map_err(words)?;
    Ok(bytes)
}

/// A rectangle of a picture, px.
struct Part {
    left: u32,
    top: u32,
    width: u32,
    height: u32,
}

impl Part {
    fn whole(raster: &Raster) -> Self {
        Self { left: 0, top: 0, width: raster.width, height: raster.height }
    }

    /// The smallest rectangle with all different pixels; one pixel if none differs.
    fn changed(before: &Raster, after: &Raster) -> Self {
        let width = after.width as usize;
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        let pairs = before.pixels.iter().zip(&after.pixels).enumerate();
        for (index, _) in pairs.filter(|(_, (before, after))| before != after) {
            let pixel = [index % width, index / width];
            for axis in 0..2 {
                low[axis] = low[axis].min(pixel[axis]);
                high[axis] = high[axis].max(pixel[axis] + 1);
            }
        }
        if low[0] == usize::MAX {
            return Self { left: 0, top: 0, width: 1, height: 1 };
        }
        let [left, top, right, bottom] = [low[0], low[1], high[0], high[1]].map(|at| at as u32);
        Self { left, top, width: right - left, height: bottom - top }
    }

    /// The palette indices of its pixels, row by row.
    fn indices(&self, raster: &Raster, palette: &mut Palette) -> Vec<u8> {
        let rows = self.top..self.top + self.height;
        rows.flat_map(|row| {
            let start = (row * raster.width + self.left) as usize;
            raster.pixels[start..start + self.width as usize].iter()
        })
        .map(|pixel| palette.index(*pixel))
        .collect()
    }
}

/// The most frequent colors; other colors are replaced by the nearest of them.
struct Palette {
    colors: Vec<Rgb>,
    nearest: HashMap<Rgb, u8>,
}

impl Palette {
    const SIZE: usize = 256;

    fn of(rasters: &[Raster]) -> Self {
        let mut counts: HashMap<Rgb, u64> = HashMap::new();
        for raster in rasters {
            for run in raster.pixels.chunk_by(|one, next| one == next) {
                *counts.entry(run[0]).or_default() += run.len() as u64;
            }
        }
        let mut counted: Vec<(u64, Rgb)> =
            counts.into_iter().map(|(color, count)| (count, color)).collect();
        // Equal counts are ordered by color, so the file does not depend on the order of the map.
        counted.sort_unstable_by(|one, other| other.cmp(one));
        let colors: Vec<Rgb> =
            counted.into_iter().take(Self::SIZE).map(|(_, color)| color).collect();
        let nearest = (0..=u8::MAX).zip(&colors).map(|(index, color)| (*color, index)).collect();
        Self { colors, nearest }
    }

    fn index(&mut self, color: Rgb) -> u8 {
        let Self { colors, nearest } = self;
        *nearest.entry(color).or_insert_with(|| {
            let distance = |other: &Rgb| -> i32 {
                let parts = color.iter().zip(other);
                parts.map(|(one, other)| (i32::from(*one) - i32::from(*other)).pow(2)).sum()
            };
            let indexed = (0..=u8::MAX).zip(colors.iter());
            indexed.min_by_key(|(_, other)| distance(other)).map_or(0, |(index, _)| index)
        })
    }
}

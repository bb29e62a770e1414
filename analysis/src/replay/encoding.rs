//! Numbers of a replay as bytes: 16-bit values, differences in time, byte planes, raw DEFLATE, base64.
//!
//! Layout, little-endian: the times (f64) and the numbers (u32) of the frames; the radii; x; y; the speeds; x and y of the ends of
//! the segments of lines, and the style of each segment; vx and vy, if they are recorded; the spins, if discs spin; x and y of both ends of the contact forces, and their sizes, if they are requested;
//! the numbers of corners between frames, and the times and places of all corners (`flights`), if collisions are recorded. A series of 16-bit values is frame after frame; its differences in time are stored as a plane of low bytes and
//! then a plane of high bytes. Differences of frame 0 are those from zero. DEFLATE stores the planes of particles at rest, or in
//! uniform motion, in almost no space.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use miniz_oxide::deflate::core::{
    CompressorOxide, TDEFLFlush, compress_to_output, create_comp_flags_from_zip_params,
};
use rayon::prelude::*;

/// The value of a coordinate, or of a speed, that is absent.
pub(super) const ABSENT: u16 = u16::MAX;
pub(super) const ABSENT_SPEED: u8 = u8::MAX;
/// The largest stored value.
pub(super) const LARGEST: u16 = ABSENT - 1;
pub(super) const LARGEST_SPEED: u8 = ABSENT_SPEED - 1;
/// Level of the compression: 7 takes twice as long for less than one percent.
const LEVEL: i32 = 4;
/// Bytes that are compressed together. Blocks are compressed in parallel; their bounds depend on the data only.
const BLOCK_BYTES: usize = 1 << 20;

/// Rounds a number to a multiple of `step`; absent if it is not finite or out of range.
pub(super) fn quantized(value: f64, step: f64) -> u16 {
    let steps = libm::round(value / step);
    if steps >= 0.0 && steps <= f64::from(LARGEST) { steps as u16 } else { ABSENT }
}

/// Appends a series of frames of `width` values each, as differences of this order in time.
pub(super) fn append_series(bytes: &mut Vec<u8>, values: &[u16], width: usize, order: u8) {
    let mut differences = values.to_vec();
    for _ in 0..order {
        difference(&mut differences, width);
    }
    let zigzag = |difference: &u16| {
        let signed = difference.cast_signed();
        ((signed << 1) ^ (signed >> 15)).cast_unsigned().to_le_bytes()
    };
    bytes.extend(differences.iter().map(|difference| zigzag(difference)[0]));
    bytes.extend(differences.iter().map(|difference| zigzag(difference)[1]));
}

/// Replaces each frame by its difference from the frame before.
fn difference(values: &mut [u16], width: usize) {
    for index in (width..values.len()).rev() {
        values[index] = values[index].wrapping_sub(values[index - width]);
    }
}

/// The order of differences, 1 or 2, that needs fewer bits: the second order for smooth motion, the first for motion that is
/// coarse in time.
pub(super) fn best_order(values: &[u16], width: usize) -> u8 {
    let bits = |values: &[u16]| -> u64 {
        let size = |value: &u16| u64::from(16 - value.cast_signed().unsigned_abs().leading_zeros());
        values.iter().map(size).sum()
    };
    let mut differences = values.to_vec();
    difference(&mut differences, width);
    let first = bits(&differences);
    difference(&mut differences, width);
    if bits(&differences) < first { 2 } else { 1 }
}

/// Appends 8-bit values as first differences in time.
pub(super) fn append_speeds(bytes: &mut Vec<u8>, values: &[u8], width: usize) {
    bytes.extend((0..values.len()).map(|index| {
        let before = index.checked_sub(width).map_or(0, |before| values[before]);
        values[index].wrapping_sub(before)
    }));
}

/// Compresses as raw DEFLATE; equal bytes give equal bytes, with any number of threads.
pub(super) fn deflated(bytes: &[u8]) -> Vec<u8> {
    let whole = bytes.len() / BLOCK_BYTES * BLOCK_BYTES;
    let (blocks, last) = bytes.split_at(whole);
    let mut packed: Vec<Vec<u8>> = blocks
        .par_chunks(BLOCK_BYTES)
        .map(|block| deflated_block(block, TDEFLFlush::Sync))
        .collect();
    packed.push(deflated_block(last, TDEFLFlush::Finish));
    packed.concat()
}

/// One block of a raw DEFLATE stream, which refers to no other block. `Sync` ends it at a whole byte, `Finish` ends the stream.
fn deflated_block(block: &[u8], end: TDEFLFlush) -> Vec<u8> {
    let (raw, default_strategy) = (0, 0);
    let flags = create_comp_flags_from_zip_params(LEVEL, raw, default_strategy);
    let mut packed = Vec::new();
    compress_to_output(&mut CompressorOxide::new(flags), block, end, |bytes| {
        packed.extend_from_slice(bytes);
        true
    });
    packed
}

/// Bytes as text.
pub(super) fn base64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// Bytes that base64 makes of so many.
pub(super) const fn base64_bytes(bytes: usize) -> usize {
    bytes.div_ceil(3) * 4
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decodes a series as the script of the report does.
    fn series(bytes: &[u8], width: usize, order: u8) -> Vec<u16> {
        let (low, high) = bytes.split_at(bytes.len() / 2);
        let mut values: Vec<u16> = low
            .iter()
            .zip(high)
            .map(|(low, high)| {
                let zigzag = u16::from_le_bytes([*low, *high]);
                (zigzag >> 1) ^ 0_u16.wrapping_sub(zigzag & 1)
            })
            .collect();
        for _ in 0..order {
            for index in width..values.len() {
                values[index] = values[index].wrapping_add(values[index - width]);
            }
        }
        values
    }

    #[test]
    fn series_round_trip_whatever_their_values() {
        let width = 7;
        let values: Vec<u16> = (0..70_u32)
            .map(|index| (index.wrapping_mul(2_654_435_761) >> 16) as u16)
            .chain([ABSENT, 0, ABSENT, LARGEST, 1, 0, 3])
            .collect();
        for order in 0..=2 {
            let mut bytes = Vec::new();
            append_series(&mut bytes, &values, width, order);
            assert_eq!(bytes.len(), 2 * values.len());
            assert_eq!(series(&bytes, width, order), values);
        }
        let mut bytes = Vec::new();
        append_speeds(&mut bytes, &[3, 200, 5, 100], 2);
        assert_eq!(bytes, [3, 200, 2, 156]);
    }

    #[test]
    fn uniform_motion_takes_almost_no_space() {
        let width = 100;
        let values: Vec<u16> = (0..200_u16)
            .flat_map(|frame| (0..100_u16).map(move |row| row * 97 + frame * (row + 1)))
            .collect();
        assert_eq!(best_order(&values, width), 2);
        let mut bytes = Vec::new();
        append_series(&mut bytes, &values, width, 2);
        let packed = deflated(&bytes);
        assert!(packed.len() < bytes.len() / 50, "{} of {}", packed.len(), bytes.len());
        assert_eq!(miniz_oxide::inflate::decompress_to_vec(&packed).unwrap(), bytes);
        assert_eq!(base64(&packed).len(), base64_bytes(packed.len()));
    }

    #[test]
    fn blocks_of_any_number_are_one_stream() {
        let byte = |index: usize| (index.wrapping_mul(2_654_435_761) >> 28) as u8;
        for length in [0, 1, BLOCK_BYTES - 1, BLOCK_BYTES, BLOCK_BYTES + 1, 3 * BLOCK_BYTES] {
            let bytes: Vec<u8> = (0..length).map(byte).collect();
            let packed = deflated(&bytes);
            assert_eq!(
                miniz_oxide::inflate::decompress_to_vec(&packed).unwrap(),
                bytes,
                "{length}"
            );
        }
    }

    #[test]
    fn numbers_out_of_range_are_absent() {
        assert_eq!(quantized(1.0, 0.1), 10);
        assert_eq!(quantized(f64::from(LARGEST), 1.0), LARGEST);
        for absent in [-1.0, 65_535.0, 1e300, f64::NAN, f64::NEG_INFINITY] {
            assert_eq!(quantized(absent, 1.0), ABSENT, "{absent}");
        }
    }
}

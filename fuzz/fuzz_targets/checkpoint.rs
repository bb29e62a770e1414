//! Guarantee: any bytes as a checkpoint, or as the content of a checkpoint with a correct checksum, give a state or an error. A state that
//! is saved and read again gives the same bytes.

#![no_main]

use kinetoscope_physics::{dem::Dem, gas::Gas, orbit::Orbit, packing::Packing};
use kinetoscope_fuzz::{IDENTITY, checkpoint_of};
use kinetoscope_recording::checkpoint::{content, decode_content, encode};
use kinetoscope_recording::recorder::RecorderState;
use libfuzzer_sys::fuzz_target;
use serde::Serialize;
use serde::de::DeserializeOwned;

// The model, then the content.
fuzz_target!(|input: &[u8]| {
    let Some((which, content)) = input.split_first() else { return };
    match which % 4 {
        0 => check::<Dem>(content),
        1 => check::<Gas>(content),
        2 => check::<Packing>(content),
        _ => check::<Orbit>(content),
    }
});

fn check<M: Serialize + DeserializeOwned>(input: &[u8]) {
    let sealed = checkpoint_of(input);
    let decode = |bytes: &[u8]| decode_content::<(u64, RecorderState, M)>(content(bytes, IDENTITY).ok()?);
    for bytes in [input, &sealed] {
        let Some(state) = decode(bytes) else { continue };
        let once = encode(IDENTITY, &[&state]).unwrap();
        let again = decode(&once).unwrap();
        assert!(encode(IDENTITY, &[&again]).unwrap() == once, "saving changes the state");
    }
}

//! Guarantee: topics, schemas, field names, types and tags do not change. Recordings outlive programs: a channel may get a new field with
//! a new tag at its end, and a channel may be added; any other change requires a new `SCHEMA_VERSION`.

use kinetoscope_recording::channels::{self, ALL, SCHEMA_VERSION};
use std::fmt::Write as _;

#[test]
fn channels_are_frozen() {
    let mut text = format!("schema version {SCHEMA_VERSION}\n");
    for topic in [channels::PARTICLES, channels::STATE] {
        writeln!(text, "{topic} foxglove.PointCloud").unwrap();
    }
    for topic in [
        channels::DISCS,
        channels::VELOCITY,
        channels::FORCE_CHAINS,
        channels::TRAIL,
        channels::WALLS,
        channels::LEGEND,
    ] {
        writeln!(text, "{topic} foxglove.SceneUpdate").unwrap();
    }
    writeln!(text, "{} foxglove.Log", channels::LOG).unwrap();
    for channel in ALL {
        writeln!(text, "{} {}", channel.topic, channel.schema).unwrap();
        for field in channel.fields {
            writeln!(text, "  {} {}: {}", field.tag, field.name, field.kind).unwrap();
        }
    }
    let golden = include_str!("golden/channels.txt");
    assert_eq!(text, golden, "\n--- found:\n{text}");
}

/// The descriptor and the encoding use the same table: a message with all fields set decodes by tag.
#[test]
fn encoded_tags_and_types_match_the_descriptor() {
    use kinetoscope_recording::channels::FrameClock;
    use prost::Message as _;
    let clock =
        FrameClock { frame: 1, step_or_event_count: 2, time: 0.5, time_unit: "s".to_owned() };
    // Protobuf's wire format, written by hand: key = tag << 3 | wire type (0 varint, 1 64-bit, 2 bytes).
    let expected =
        [&[0x08, 1, 0x10, 2, 0x19][..], &0.5_f64.to_le_bytes(), &[0x22, 1, b's']].concat();
    assert_eq!(clock.encode_to_vec(), expected);
}

//! Guarantee: reading the fields of a message by name, without its Rust type, gives the same values as its own decoder, for single values,
//! series and defaults.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use kinetoscope_recording::channels::{
    ALL, Channel, ChannelDeclaration, FrameClock, GasSpeeds, PerCollision,
};
use kinetoscope_recording::fields::{FieldValue, read_fields};
use prost::Message as _;

fn values<C: Channel>(message: &C, name: &str) -> Vec<FieldValue> {
    let fields = read_fields(&ChannelDeclaration::of::<C>(), &message.encode_to_vec()).unwrap();
    assert_eq!(fields.len(), C::FIELDS.len());
    fields.into_iter().find(|field| field.name == name).unwrap().values
}

#[test]
fn single_values_of_each_type_are_read() {
    let clock = FrameClock {
        frame: 300,
        step_or_event_count: u64::MAX,
        time: -0.1,
        time_unit: "d".to_owned(),
    };
    assert_eq!(values(&clock, "frame"), [FieldValue::Count(300)]);
    assert_eq!(values(&clock, "step_or_event_count"), [FieldValue::Count(u64::MAX)]);
    assert_eq!(values(&clock, "time"), [FieldValue::Number(-0.1)]);
    assert_eq!(values(&clock, "time_unit"), [FieldValue::Text("d".to_owned())]);
}

#[test]
fn series_of_each_type_are_read() {
    let series =
        PerCollision { event: vec![0, 1, 300], time: vec![0.5, 1.5], ..PerCollision::default() };
    let counts = [FieldValue::Count(0), FieldValue::Count(1), FieldValue::Count(300)];
    assert_eq!(values(&series, "event"), counts);
    assert_eq!(values(&series, "time"), [FieldValue::Number(0.5), FieldValue::Number(1.5)]);
    assert_eq!(values(&series, "a2"), []);
}

#[test]
fn omitted_fields_have_their_defaults() {
    for channel in ALL {
        let fields = read_fields(channel, &[]).unwrap();
        for (field, declared) in fields.iter().zip(channel.fields) {
            assert_eq!(field.series, declared.kind.contains("repeated"), "{}", channel.schema);
            assert_eq!(field.values.is_empty(), field.series, "{}: {}", channel.schema, field.name);
        }
    }
}

#[test]
fn unknown_tags_are_skipped_and_invalid_data_is_rejected() {
    let clock = ChannelDeclaration::of::<FrameClock>();
    // Tag 15, varint 1: a field of a later version.
    assert_eq!(read_fields(&clock, &[15 << 3, 1]), read_fields(&clock, &[]));
    // A length without its data; the end of a group; half a double.
    for nonsense in [&[0x22, 9, b'd'][..], &[0x0c], &[0x19, 0, 0, 0]] {
        assert_eq!(read_fields(&clock, nonsense), None, "{nonsense:?}");
    }
    let speeds = GasSpeeds { density: vec![1.0; 3], ..GasSpeeds::default() }.encode_to_vec();
    let channel = ChannelDeclaration::of::<GasSpeeds>();
    assert_eq!(read_fields(&channel, &speeds[..speeds.len() - 1]), None);
}

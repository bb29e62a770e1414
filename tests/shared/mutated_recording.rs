//! Structure-aware mutations of recordings: the records are decoded, one to three are changed, and all are encoded again by the
//! container's own library, with correct lengths and checksums. Raw damage is found by checksums; these changes are not.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use mcap::records::Metadata;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::Arc;

/// Reproducible numbers from SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number below a positive limit.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }

    pub(crate) fn one_of<'a, T: ?Sized>(&mut self, choices: &[&'a T]) -> &'a T {
        choices[self.below(choices.len())]
    }

    pub(crate) fn is_one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }
}

/// Numbers at which conversions, allocations and loops fail.
const SPECIALS: [f64; 12] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    0.0,
    -1.0,
    1e300,
    -1e300,
    1e-300,
    5e-324,
    4_294_967_296.0,
    1e18,
    0.5,
];
/// The same as text of a manifest.
const SPECIAL_WORDS: [&str; 14] = [
    "nan",
    "inf",
    "0",
    "0.0",
    "-1",
    "1e300",
    "1e-300",
    "4294967295",
    "9223372036854775807",
    "1e9",
    "1",
    "\"\"",
    "[]",
    "true",
];

/// The manifest of a recording.
#[derive(Clone)]
struct Attachment {
    name: String,
    media_type: String,
    text: String,
}

/// The records of a recording.
#[derive(Clone)]
pub(crate) struct Records<'a> {
    attachments: Vec<Attachment>,
    metadata: Vec<Metadata>,
    messages: Vec<mcap::Message<'a>>,
}

impl<'a> Records<'a> {
    /// Decodes a valid recording.
    pub(crate) fn of(bytes: &'a [u8]) -> Self {
        let summary = mcap::Summary::read(bytes).unwrap().unwrap();
        let attachments = summary.attachment_indexes.iter().map(|index| {
            let mcap::Attachment { name, media_type, data, .. } =
                mcap::read::attachment(bytes, index).unwrap();
            Attachment { name, media_type, text: String::from_utf8(data.into_owned()).unwrap() }
        });
        let metadata = summary.metadata_indexes.iter();
        let messages = mcap::MessageStream::new(bytes).unwrap().map(Result::unwrap);
        let mut messages: Vec<mcap::Message<'a>> = messages.collect();
        // In the file, groups of channels have chunks of their own.
        messages.sort_by_key(|message| (message.log_time, message.channel.id));
        Self {
            attachments: attachments.collect(),
            metadata: metadata.map(|index| mcap::read::metadata(bytes, index).unwrap()).collect(),
            messages,
        }
    }

    /// Encodes the records. Each frame has a chunk of its own, except for some mutations; in every other file, states and drawings are in
    /// chunks of their own before the one with the other messages, as in a recording of the program.
    fn encode(&self, numbers: &mut Numbers) -> Vec<u8> {
        let compression = match numbers.below(4) {
            0 => Some(mcap::Compression::Zstd),
            1 => Some(mcap::Compression::Lz4),
            _ => None,
        };
        let mut writer = mcap::WriteOptions::new()
            .library("kinetoscope")
            .compression(compression)
            .chunk_size(None)
            .disable_seeking(true)
            .create(Cursor::new(Vec::new()))
            .unwrap();
        for Attachment { name, media_type, text } in &self.attachments {
            let (name, media_type) = (name.clone(), media_type.clone());
            let data = Cow::Borrowed(text.as_bytes());
            let attachment =
                mcap::Attachment { log_time: 0, create_time: 0, name, media_type, data };
            writer.attach(&attachment).unwrap();
        }
        let (end, start): (Vec<_>, Vec<_>) =
            self.metadata.iter().partition(|record| record.name == "kinetoscope.outcome");
        start.iter().for_each(|record| writer.write_metadata(record).unwrap());
        let (has_one_chunk, has_groups) = (numbers.is_one_in(8), numbers.is_one_in(2));
        let is_first_group = |message: &mcap::Message<'_>| {
            ["/particles", "/state", "/walls", "/discs", "/keyframe"]
                .contains(&message.channel.topic.as_str())
        };
        for frame in self.messages.chunk_by(|_, next| next.channel.topic != "/frame") {
            let (first, rest): (Vec<_>, Vec<_>) =
                frame.iter().partition(|message| has_groups && is_first_group(message));
            for group in [first, rest] {
                // Two channels with one id that differ are the writer's own error.
                group.iter().for_each(|message| drop(writer.write(message)));
                if !has_one_chunk {
                    writer.flush().unwrap();
                }
            }
        }
        end.iter().for_each(|record| writer.write_metadata(record).unwrap());
        writer.finish().unwrap();
        writer.into_inner().into_inner()
    }

    /// The bytes of a recording with one to three changes.
    pub(crate) fn mutated(&self, numbers: &mut Numbers) -> Vec<u8> {
        let mut records = self.clone();
        for _ in 0..1 + numbers.below(3) {
            match numbers.below(12) {
                0 | 1 => records.change_manifest(numbers),
                2 => records.change_metadata(numbers),
                3 => records.change_channel(numbers),
                4 => records.change_order(numbers),
                _ => records.change_payload(numbers),
            }
        }
        records.encode(numbers)
    }

    fn change_manifest(&mut self, numbers: &mut Numbers) {
        let Some(attachment) = self.attachments.first_mut() else { return };
        match numbers.below(12) {
            0 => attachment.name = "other.toml".to_owned(),
            1 => attachment.media_type = String::new(),
            _ => attachment.text = changed_manifest(&attachment.text, numbers),
        }
    }

    fn change_metadata(&mut self, numbers: &mut Numbers) {
        if self.metadata.is_empty() {
            return;
        }
        let index = numbers.below(self.metadata.len());
        if numbers.is_one_in(10) {
            self.metadata.remove(index);
            return;
        }
        let record = &mut self.metadata[index];
        let keys: Vec<String> = record.metadata.keys().cloned().collect();
        if keys.is_empty() {
            return;
        }
        let key = keys[numbers.below(keys.len())].clone();
        let texts = [
            "",
            "-1",
            "99999999999999999999",
            "nan",
            "complete",
            "fault: \u{1b}[2J\n::error::x",
            "dem",
            "gas",
        ];
        match numbers.below(6) {
            0 => drop(record.metadata.remove(&key)),
            1 => record.name = "other".to_owned(),
            2 => drop(record.metadata.insert(key, "x".repeat(100_000))),
            _ => drop(record.metadata.insert(key, numbers.one_of(&texts).to_owned())),
        }
    }

    fn change_channel(&mut self, numbers: &mut Numbers) {
        if self.messages.is_empty() {
            return;
        }
        let index = numbers.below(self.messages.len());
        let old = Arc::clone(&self.messages[index].channel);
        let other = Arc::clone(&self.messages[numbers.below(self.messages.len())].channel);
        let mut channel = (*old).clone();
        match numbers.below(6) {
            0 => channel.topic = "/other".to_owned(),
            1 => channel.topic.clone_from(&other.topic),
            2 => channel.schema.clone_from(&other.schema),
            3 => channel.schema = None,
            4 => channel.message_encoding = "json".to_owned(),
            _ => {
                channel.metadata = BTreeMap::from([("a".to_owned(), "\u{202e}".to_owned())]);
                if let Some(schema) = &channel.schema {
                    let mut schema = (**schema).clone();
                    // The writer accepts no two schemas of one id.
                    schema.id = 1000 + numbers.below(60_000) as u16;
                    let mut data = schema.data.into_owned();
                    change_bytes(&mut data, numbers);
                    schema.data = Cow::Owned(data);
                    channel.schema = Some(Arc::new(schema));
                }
            }
        }
        // Nor two channels.
        channel.id = 1000 + numbers.below(60_000) as u16;
        let channel = Arc::new(channel);
        for message in self.messages.iter_mut().filter(|message| message.channel.id == old.id) {
            message.channel = Arc::clone(&channel);
        }
    }

    fn change_order(&mut self, numbers: &mut Numbers) {
        if self.messages.len() < 2 {
            return;
        }
        let [one, other] = [0; 2].map(|_| numbers.below(self.messages.len()));
        match numbers.below(6) {
            0 => drop(self.messages.remove(one)),
            1 => self.messages.insert(one, self.messages[other].clone()),
            2 => self.messages.swap(one, other),
            3 => self.messages[one].log_time = numbers.next() >> numbers.below(64),
            4 => self.messages[one].sequence = numbers.next() as u32,
            _ => self.messages.truncate(one),
        }
    }

    fn change_payload(&mut self, numbers: &mut Numbers) {
        if self.messages.is_empty() {
            return;
        }
        // One message, or the same change in all messages of its topic.
        let index = numbers.below(self.messages.len());
        let id = self.messages[index].channel.id;
        let (all, seed) = (numbers.is_one_in(3), numbers.next());
        for (place, message) in self.messages.iter_mut().enumerate() {
            if place == index || all && message.channel.id == id {
                let mut payload = message.data.to_vec();
                let fields = Fields::of(&payload);
                let mut numbers = Numbers(seed);
                payload = fields.map_or_else(|| payload, |fields| fields.changed(&mut numbers, 0));
                message.data = Cow::Owned(payload);
            }
        }
    }
}

/// Replaces, removes or repeats a value or a line of a manifest.
pub(crate) fn changed_manifest(text: &str, numbers: &mut Numbers) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    if lines.is_empty() {
        return String::new();
    }
    let index = numbers.below(lines.len());
    match numbers.below(8) {
        0 => drop(lines.remove(index)),
        1 => lines.insert(index, lines[numbers.below(text.lines().count())].clone()),
        2 => lines.truncate(index),
        _ => {
            if let Some((key, _)) = lines[index].split_once(" = ") {
                lines[index] = format!("{key} = {}", numbers.one_of(&SPECIAL_WORDS));
            }
        }
    }
    lines.join("\n") + "\n"
}

fn change_bytes(bytes: &mut Vec<u8>, numbers: &mut Numbers) {
    if bytes.is_empty() {
        return;
    }
    let place = numbers.below(bytes.len());
    match numbers.below(4) {
        0 => bytes[place] ^= 1 << numbers.below(8),
        1 => bytes.truncate(place),
        2 => bytes.insert(place, numbers.next() as u8),
        _ => {
            let number = SPECIALS[numbers.below(SPECIALS.len())].to_le_bytes();
            let length = number.len().min(bytes.len() - place);
            bytes[place..place + length].copy_from_slice(&number[..length]);
        }
    }
}

/// A field of a protobuf message: its tag and its value.
#[derive(Clone)]
struct Field {
    number: u64,
    value: Value,
}

#[derive(Clone)]
enum Value {
    Varint(u64),
    Eight([u8; 8]),
    Four([u8; 4]),
    Bytes(Vec<u8>),
}

/// The fields of a protobuf message, in order.
#[derive(Clone)]
struct Fields(Vec<Field>);

impl Fields {
    /// `None` if the bytes are no message.
    fn of(mut bytes: &[u8]) -> Option<Self> {
        let mut fields = Vec::new();
        while !bytes.is_empty() {
            let tag = varint(&mut bytes)?;
            let value = match tag & 7 {
                0 => Value::Varint(varint(&mut bytes)?),
                1 => Value::Eight(take(&mut bytes, 8)?.try_into().ok()?),
                2 => {
                    let length = usize::try_from(varint(&mut bytes)?).ok()?;
                    Value::Bytes(take(&mut bytes, length)?.to_vec())
                }
                5 => Value::Four(take(&mut bytes, 4)?.try_into().ok()?),
                _ => return None,
            };
            fields.push(Field { number: tag >> 3, value });
        }
        Some(Self(fields))
    }

    fn encoded(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for Field { number, value } in &self.0 {
            let kind = match value {
                Value::Varint(_) => 0,
                Value::Eight(_) => 1,
                Value::Bytes(_) => 2,
                Value::Four(_) => 5,
            };
            put_varint(&mut bytes, number << 3 | kind);
            match value {
                Value::Varint(number) => put_varint(&mut bytes, *number),
                Value::Eight(content) => bytes.extend(content),
                Value::Four(content) => bytes.extend(content),
                Value::Bytes(content) => {
                    put_varint(&mut bytes, content.len() as u64);
                    bytes.extend(content);
                }
            }
        }
        bytes
    }

    /// The message with one change, in this message or in one that it contains.
    fn changed(mut self, numbers: &mut Numbers, depth: u32) -> Vec<u8> {
        if self.0.is_empty() {
            return Vec::new();
        }
        let index = numbers.below(self.0.len());
        match numbers.below(8) {
            0 => drop(self.0.remove(index)),
            1 => self.0.push(self.0[index].clone()),
            2 => self.0[index].number = 1 + numbers.next() % 20,
            _ => self.0[index].value = changed_value(&self.0[index].value, numbers, depth),
        }
        self.encoded()
    }
}

fn changed_value(value: &Value, numbers: &mut Numbers, depth: u32) -> Value {
    let special = SPECIALS[numbers.below(SPECIALS.len())];
    match value {
        Value::Varint(_) => Value::Varint(numbers.next() >> numbers.below(64)),
        Value::Eight(_) => Value::Eight(special.to_le_bytes()),
        Value::Four(_) => Value::Four((special as f32).to_le_bytes()),
        Value::Bytes(content) => {
            let mut content = content.clone();
            let inner = Fields::of(&content).filter(|_| depth < 4 && !numbers.is_one_in(3));
            if let Some(inner) = inner.filter(|inner| !inner.0.is_empty()) {
                return Value::Bytes(inner.changed(numbers, depth + 1));
            }
            // A column of numbers: one more, one less, none, or a special one.
            match numbers.below(5) {
                0 => content.extend(special.to_le_bytes()),
                1 => content.truncate(content.len().saturating_sub(8)),
                2 => content.clear(),
                3 if content.len() >= 8 => {
                    let place = 8 * numbers.below(content.len() / 8);
                    content[place..place + 8].copy_from_slice(&special.to_le_bytes());
                }
                _ => change_bytes(&mut content, numbers),
            }
            Value::Bytes(content)
        }
    }
}

fn varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0_u64;
    for place in 0..10 {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        value |= u64::from(byte & 0x7f).checked_shl(7 * place)?;
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

fn put_varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

fn take<'a>(bytes: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, rest) = bytes.split_at_checked(count)?;
    *bytes = rest;
    Some(taken)
}

//! What a lock file keeps of a recording: the hash of all messages, and a trace from which the place of a difference follows.
//!
//! The hash covers topic, log time and payload of each message, not the compression of the file. Therefore, it is the same on
//! every architecture.

use crate::verify::syndromes::Syndromes;
use data_encoding::BASE64_NOPAD;
use kinetoscope_recording::channels::STATE;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, Recording};
use sha2::{Digest, Sha256};

/// Number of frames from the start that each have a row in the trace; the others are spaced by a ratio.
const DENSE_FRAMES: u64 = 16;
/// Frames with a tag of their own. Later differences are located between two rows.
const TAGGED_FRAMES: u64 = 4096;

/// Hash and trace of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fingerprint {
    /// The first half of the SHA-256 of all messages, 32 hexadecimal digits.
    pub messages: String,
    /// Number of frames.
    pub frames: u64,
    /// One byte per frame: the state of the hash after the frame.
    pub tags: Vec<u8>,
    /// Details of a few frames.
    pub rows: Vec<Row>,
    /// The topics, in the order of their tags.
    pub topics: Vec<String>,
    /// The columns of the state, in the order of their tags.
    pub columns: Vec<String>,
}

/// Details of one frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// Index of the frame.
    pub frame: u64,
    /// One byte per topic.
    pub topics: Vec<u8>,
    /// One byte per column of the state; zeros if the state is not recorded.
    pub columns: Vec<u8>,
    /// From which up to two differing particles follow.
    pub particles: Syndromes,
}

/// Reads a recording and derives its fingerprint.
///
/// # Errors
/// A recording that is not complete and intact.
pub fn fingerprint(recording: &Recording) -> Result<Fingerprint, ReadError> {
    let mut all = Sha256::new();
    let mut found = Fingerprint {
        messages: String::new(),
        frames: 0,
        tags: Vec::new(),
        rows: Vec::new(),
        topics: Vec::new(),
        columns: recording.state_columns().to_vec(),
    };
    let mut next_row = 0;
    for frame in recording.frames()? {
        let frame = frame?;
        add_messages(&mut all, &frame);
        if found.frames < TAGGED_FRAMES {
            found.tags.push(all.clone().finalize()[0]);
        }
        if found.frames == next_row {
            let row = found.row(&frame);
            found.rows.push(row);
            next_row = following_row(next_row);
        }
        found.frames += 1;
    }
    found.messages = hexadecimal(&all.finalize()[..16]);
    Ok(found)
}

/// The frame of the row after that of `frame`.
const fn following_row(frame: u64) -> u64 {
    if frame < DENSE_FRAMES { frame + 1 } else { frame + frame / 6 }
}

fn add_messages(hash: &mut Sha256, frame: &RecordedFrame) {
    for message in frame.messages() {
        hash.update((message.topic().len() as u64).to_le_bytes());
        hash.update(message.topic());
        hash.update(message.log_time_ns().to_le_bytes());
        hash.update((message.payload().len() as u64).to_le_bytes());
        hash.update(message.payload());
    }
}

impl Fingerprint {
    /// Details of a frame. A topic that occurs for the first time is added to the list.
    fn row(&mut self, frame: &RecordedFrame) -> Row {
        let mut hashes: Vec<Sha256> = self.topics.iter().map(|_| Sha256::new()).collect();
        for message in frame.messages() {
            let known = self.topics.iter().position(|topic| topic == message.topic());
            let index = known.unwrap_or_else(|| {
                self.topics.push(message.topic().to_owned());
                hashes.push(Sha256::new());
                hashes.len() - 1
            });
            hashes[index].update(message.payload());
        }
        let topics = hashes.into_iter().map(|hash| hash.finalize()[0]).collect();
        let (mut columns, mut particles) = (vec![0; self.columns.len()], Syndromes::default());
        if let Some(state) = frame.state() {
            let mut of_columns = vec![0_u64; state.columns().len()];
            for row in 0..state.rows() {
                let mut of_row = 0;
                for (sum, value) in of_columns.iter_mut().zip(state.row(row)) {
                    *sum = mixed(*sum ^ value.to_bits());
                    of_row = mixed(of_row ^ value.to_bits());
                }
                particles.add(row as u64, of_row);
            }
            columns = of_columns.into_iter().map(|sum| (sum >> 56) as u8).collect();
        }
        Row { frame: frame.clock.frame, topics, columns, particles }
    }
}

/// A bijection that spreads every bit over the whole word (the finalizer of SplitMix64).
const fn mixed(word: u64) -> u64 {
    let word = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
}

fn hexadecimal(bytes: &[u8]) -> String {
    data_encoding::HEXLOWER.encode(bytes)
}

impl Row {
    /// The row as text: the frame, then base64.
    #[must_use]
    pub fn text(&self) -> String {
        let mut bytes = self.topics.clone();
        bytes.extend(&self.columns);
        bytes.extend(self.particles.bytes());
        format!("{} {}", self.frame, BASE64_NOPAD.encode(&bytes))
    }

    /// Reads the row of a trace with so many topics and columns. Later rows may have more topics than earlier ones.
    #[must_use]
    pub fn parse(text: &str, columns: usize) -> Option<Self> {
        let (frame, encoded) = text.split_once(' ')?;
        let bytes = BASE64_NOPAD.decode(encoded.as_bytes()).ok()?;
        let (rest, particles) = bytes.split_last_chunk()?;
        let (topics, columns) = rest.split_at_checked(rest.len().checked_sub(columns)?)?;
        Some(Self {
            frame: frame.parse().ok()?,
            topics: topics.to_vec(),
            columns: columns.to_vec(),
            particles: Syndromes::from_bytes(*particles),
        })
    }
}

/// Where two traces differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The first differing frame, or the last frame known to be equal and the first one known to differ.
    pub frames: (Option<u64>, u64),
    /// Where to look for details: the first frame with a row that differs.
    pub row: Option<RowPlace>,
}

/// What differs in one frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowPlace {
    /// Index of the frame.
    pub frame: u64,
    /// The topics.
    pub topics: Vec<String>,
    /// The columns of the state.
    pub columns: Vec<String>,
    /// The particles, if they are at most two.
    pub particles: Option<Vec<u64>>,
}

impl Fingerprint {
    /// Whether the traces show that two runs have the same messages: every frame has a tag, and all are equal. A change k frames
    /// before the end has equal tags with a probability of 256^-(k + 1); runs of fewer than three frames are not decided.
    #[must_use]
    pub fn has_equal_trace(&self, other: &Self) -> bool {
        let covers_run = self.frames == self.tags.len() as u64 && self.frames >= 3;
        let Self { messages: _, frames, tags, rows, topics, columns } = self;
        covers_run
            && (frames, tags, rows) == (&other.frames, &other.tags, &other.rows)
            && (topics, columns) == (&other.topics, &other.columns)
    }

    /// The place of the first difference to the trace of another recording of the same run.
    #[must_use]
    pub fn first_difference(&self, other: &Self, particles: u64) -> Option<Place> {
        let tagged = self.tags.iter().zip(&other.tags).position(|(one, other)| one != other);
        let rows = self.rows.iter().zip(&other.rows).position(|(one, other)| one != other);
        let row = rows.map(|index| self.row_difference(index, other, particles));
        let exact = tagged.map(|frame| frame as u64);
        let differs = match (exact, &row) {
            (Some(tagged), Some(row)) => tagged.min(row.frame),
            (Some(tagged), None) => tagged,
            (None, Some(row)) => row.frame,
            (None, None) if self.frames != other.frames => self.frames.min(other.frames),
            (None, None) => return None,
        };
        let equal = match exact {
            Some(_) => differs.checked_sub(1),
            None => rows.and_then(|row| row.checked_sub(1)).map(|row| self.rows[row].frame),
        };
        Some(Place { frames: (equal, differs), row })
    }

    fn row_difference(&self, index: usize, other: &Self, particles: u64) -> RowPlace {
        let (one, two) = (&self.rows[index], &other.rows[index]);
        let named = |names: &[String], one: &[u8], two: &[u8]| {
            let differs = |index: &usize| one.get(*index) != two.get(*index);
            (0..names.len()).filter(differs).map(|index| names[index].clone()).collect()
        };
        // The tag of a topic is the same for other values one time in 256; the columns and particles are further tags of the state.
        let has_other_state = (&one.columns, one.particles) != (&two.columns, two.particles);
        let topics = (0..self.topics.len()).filter(|&topic| {
            one.topics.get(topic) != two.topics.get(topic)
                || (has_other_state && self.topics[topic] == STATE)
        });
        RowPlace {
            frame: one.frame,
            topics: topics.map(|topic| self.topics[topic].clone()).collect(),
            columns: named(&self.columns, &one.columns, &two.columns),
            particles: one.particles.differing(&two.particles, particles),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fingerprint(frame_tag: u8, columns: [u8; 2]) -> Fingerprint {
        let topics = vec![7; 2];
        let particles = Syndromes::default();
        Fingerprint {
            messages: String::new(),
            frames: 1,
            tags: vec![frame_tag],
            rows: vec![Row { frame: 0, topics, columns: columns.to_vec(), particles }],
            topics: ["/frame", STATE].map(str::to_owned).to_vec(),
            columns: ["x", "y"].map(str::to_owned).to_vec(),
        }
    }

    /// Control: equal columns are no difference of the state.
    #[test]
    fn state_is_named_for_its_columns_if_its_tag_is_the_same() {
        let locked = fingerprint(1, [3, 4]);
        let row = locked.first_difference(&fingerprint(2, [3, 5]), 10).unwrap().row.unwrap();
        assert_eq!((row.topics, row.columns), (vec![STATE.to_owned()], vec!["y".to_owned()]));
        assert_eq!(locked.first_difference(&fingerprint(2, [3, 4]), 10).unwrap().row, None);
    }
}

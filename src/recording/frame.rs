//! The messages of one instant in memory: the interface between physics and recording.

pub use crate::column::StateColumn;
pub use crate::encoded_messages::EncodedMessage;
pub use crate::force_lines::ContactLine;

use crate::channels::Channel;
use crate::encoded_messages::EncodedMessages;
use crate::force_lines::ForceLines;
use crate::scene::EncodedDiscs;
use crate::scenery::Wall;
use crate::table::Rows;

/// Severity of a log line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// A fact.
    Info,
    /// Something that the user should check.
    Warning,
    /// The run is wrong or cannot continue.
    Error,
}

/// A line of the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// Its severity.
    pub level: Level,
    /// One line, facts with units.
    pub text: String,
}

/// The messages of one instant. A model fills it, the recorder writes it; it is reused from frame to frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    state: Rows,
    messages: EncodedMessages,
    contacts: ForceLines,
    walls: Vec<Wall>,
    log: Vec<LogLine>,
    model: Vec<u8>,
    discs: EncodedDiscs,
}

impl Frame {
    /// An empty frame.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// An empty frame that stores only the `at_most` strongest contact forces.
    pub(crate) fn drawing_contacts(at_most: usize) -> Self {
        Self { contacts: ForceLines::drawing(at_most), ..Self::default() }
    }

    /// Empties the frame; its memory is kept.
    pub fn clear(&mut self) {
        self.state.clear();
        self.messages.clear();
        self.contacts.clear();
        self.walls.clear();
        self.log.clear();
        self.model.clear();
        self.discs.clear();
    }

    /// Size of the state and the messages in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.state()) + self.messages.bytes() + self.model.len()
    }

    /// The values of the state, row by row in the order of the particles' ids, for a model that does not write its rows in this
    /// order. All of them must be written: until then, they are zeros or those of an earlier frame.
    pub fn resize_state(&mut self, values: usize) -> &mut [f64] {
        self.state.resize(values)
    }

    /// Gives every NaN of the state the bits of `f64::NAN`, before anything is drawn or encoded; messages have them already.
    pub(crate) fn make_nan_canonical(&mut self) {
        self.state.make_nan_canonical();
    }

    /// The rows of the state, before which the recorder writes the header of the message.
    pub(crate) fn rows_mut(&mut self) -> &mut Rows {
        &mut self.state
    }

    /// Adds one particle's row, one value for each declared column; rows come in the order of the particles' ids.
    pub fn push_state(&mut self, row: &[f64]) {
        self.state.push(row);
    }

    /// Adds a message; at most one per topic and frame.
    pub fn push<C: Channel>(&mut self, message: &C) {
        self.messages.push(message);
    }

    /// Adds a contact force to the drawing.
    pub fn push_contact(&mut self, contact: ContactLine) {
        self.contacts.push(contact);
    }

    /// Adds a wall to the drawing. A model whose walls move adds all of them to every frame.
    pub fn push_wall(&mut self, wall: Wall) {
        self.walls.push(wall);
    }

    /// Adds a line to the log.
    pub fn log(&mut self, level: Level, text: impl Into<String>) {
        self.log.push(LogLine { level, text: text.into() });
    }

    /// The state of the model, in the encoding of checkpoints: of a keyframe only.
    pub fn model_mut(&mut self) -> &mut Vec<u8> {
        &mut self.model
    }

    /// The state and the drawing of its discs, which is empty until it is encoded.
    pub(crate) fn state_and_discs(&mut self) -> (&[f64], &mut EncodedDiscs) {
        (self.state.values(), &mut self.discs)
    }

    /// Exchanges the memory of the drawing of the discs.
    pub(crate) fn swap_discs(&mut self, discs: &mut EncodedDiscs) {
        std::mem::swap(&mut self.discs, discs);
    }

    /// The encoded drawing of the discs; empty until it is encoded.
    pub(crate) fn discs(&self) -> &[u8] {
        self.discs.bytes()
    }

    /// The state, row by row.
    #[must_use]
    pub fn state(&self) -> &[f64] {
        self.state.values()
    }

    /// The messages, in the order in which they were added.
    pub fn messages(&self) -> impl Iterator<Item = EncodedMessage<'_>> {
        self.messages.iter()
    }

    /// The message with a topic.
    pub(crate) fn message(&self, topic: &str) -> Option<EncodedMessage<'_>> {
        self.messages().find(|message| message.topic == topic)
    }

    /// The message of one channel, decoded; `None` if it was not added.
    #[must_use]
    pub fn get<C: Channel>(&self) -> Option<C> {
        C::decode(self.message(C::TOPIC)?.payload).ok()
    }

    /// The contact forces to draw; a recorder's frame may leave out those that are too weak to be drawn.
    #[must_use]
    pub fn contacts(&self) -> &[ContactLine] {
        self.contacts.lines()
    }

    /// The walls to draw; none if they have not moved since the start.
    #[must_use]
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// The lines of the log.
    #[must_use]
    pub fn log_lines(&self) -> &[LogLine] {
        &self.log
    }
}

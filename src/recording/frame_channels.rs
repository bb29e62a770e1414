//! Which channels a frame has messages of, and how many messages a file has.

use crate::block_writer::Group;
use crate::channels;
use crate::container::Broken;
use crate::keyframe::KEYFRAME;
use crate::recorded_frame::{RecordedMessage, Topic};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The channels that have a message in all frames or in none, and the messages so far.
#[derive(Default)]
pub(crate) struct FrameChannels {
    /// Each with whether the first frame has a message. Frames between keyframes have only those that are declared with the clock.
    of_each_frame: Vec<(Arc<Topic>, Option<bool>)>,
    /// Messages so far, by channel.
    counts: BTreeMap<u16, u64>,
}

impl FrameChannels {
    /// Adds a channel. Drawings and what changes rarely may be absent from any frame.
    pub(crate) fn declare(&mut self, topic: &Arc<Topic>) {
        self.of_each_frame.retain(|(earlier, _)| earlier.id != topic.id);
        let is_of_changes = [channels::PARTICLES, channels::WALLS, channels::LOG, KEYFRAME];
        if !is_drawing(topic) && !is_of_changes.contains(&topic.name.as_str()) {
            self.of_each_frame.push((Arc::clone(topic), None));
        }
    }

    /// Counts a message.
    pub(crate) fn count(&mut self, channel: u16) {
        *self.counts.entry(channel).or_default() += 1;
    }

    /// Checks that a frame has messages of the channels of the first one.
    pub(crate) fn check(
        &mut self,
        messages: &[RecordedMessage],
        is_complete: bool,
    ) -> Result<(), Broken> {
        let clocks = messages.first().map(RecordedMessage::group);
        for (topic, is_in_first) in &mut self.of_each_frame {
            let is_scalar =
                Some(topic.declared_in) == clocks && Group::of(&topic.name, &[]) == Group::Scalars;
            if !is_complete && !is_scalar {
                continue;
            }
            let is_here = messages.iter().any(|message| message.topic.id == topic.id);
            if is_in_first.replace(is_here).is_some_and(|first| first != is_here) {
                let what = format!("a frame has no message of {}, but another one has", topic.name);
                return Err(Broken::Damaged(what));
            }
        }
        Ok(())
    }

    /// Whether the channels that are read have these numbers of messages.
    pub(crate) fn have_counts(
        &self,
        stated: &BTreeMap<u16, u64>,
        is_read: impl Fn(u16) -> bool,
    ) -> bool {
        let mut channels = stated.keys().chain(self.counts.keys()).filter(|id| is_read(**id));
        let of = |counts: &BTreeMap<u16, u64>, id| counts.get(id).copied().unwrap_or_default();
        channels.all(|id| of(stated, id) == of(&self.counts, id))
    }
}

/// Whether two channels may be in one chunk.
pub(crate) fn is_one_group(one: &Topic, other: &Topic) -> bool {
    one.declared_in == other.declared_in
}

/// Whether a channel is one of the drawings.
pub(crate) fn is_drawing(topic: &Topic) -> bool {
    Group::of(&topic.name, &[]) == Group::Drawings
}

//! Guarantee: the manifest accepts exactly the channels that a model can record.
//!
//! Setup: the channel names of the manifest's package and of the models' package, which do not depend on each other, are compared
//! for every model with its default values.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::record::CHANNELS;
use kinetoscope_physics::random::Seed;
use kinetoscope_physics::{kind_of, prepare};
use kinetoscope_recording::channels;
use std::collections::BTreeSet;

/// The topics that a recording of a model can contain, without their slashes; `/frame` is in every recording.
fn recordable_topics(config: &ModelConfig) -> BTreeSet<&'static str> {
    let model = prepare(config, Seed { seed: 0, replicate: 0 }, false).unwrap();
    let scenery = model.scenery();
    let mut topics: BTreeSet<&str> =
        [channels::STATE, channels::DISCS, channels::WALLS, channels::LEGEND, channels::LOG].into();
    topics.extend(kind_of(config).channels.iter().map(|channel| channel.topic));
    topics.insert(channels::VELOCITY);
    topics.extend(scenery.force_range_top.map(|_| channels::CONTACTS));
    topics.extend(scenery.trail.then_some(channels::TRAIL));
    topics.into_iter().map(|topic| topic.trim_start_matches('/')).collect()
}

#[test]
fn manifest_accepts_exactly_the_channels_of_its_model() {
    for (name, named) in CHANNELS {
        let config = ModelConfig::with_defaults(name).unwrap();
        assert_eq!(recordable_topics(&config), named.iter().copied().collect(), "{name}");
    }
}

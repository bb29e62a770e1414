//! Plots in a manifest of fields that no recording will have: the manifest's package knows the channels, and the models their fields.

use crate::messages::Failure;
use kinetoscope_console::Exit;
use kinetoscope_manifest::{Experiment, channel_field, nearest};
use kinetoscope_physics::kind_of;
use kinetoscope_recording::channels::{ChannelDeclaration, FrameClock};

/// Rejects a plot of a field that is not one number per frame of the experiment's model.
///
/// # Errors
/// The first such plot, with its line.
pub(crate) fn reject_unknown(experiment: &Experiment) -> Result<(), Failure> {
    let Some(run) = experiment.runs.first() else { return Ok(()) };
    let clock = ChannelDeclaration::of::<FrameClock>();
    let channels: Vec<&ChannelDeclaration> =
        kind_of(&run.manifest.model).channels.iter().chain([&clock]).collect();
    let mut of_channels = experiment.plots.iter().filter(|plot| plot.is_of_channel());
    of_channels.try_for_each(|plot| {
        let place = format!("{}:{}", experiment.manifest, plot.line);
        plot.ordinates().try_for_each(|name| check(name, &channels, &place))
    })
}

fn check(name: &str, channels: &[&ChannelDeclaration], place: &str) -> Result<(), Failure> {
    let (topic, field) = channel_field(name).unwrap_or((name, ""));
    let declared = channels.iter().find(|channel| channel.topic == topic);
    let fields = declared.map_or(&[][..], |channel| channel.fields);
    let is_number = |kind: &str| matches!(kind, "double" | "uint64");
    let of_kind = |is_wanted: bool| -> Vec<&str> {
        let fields = fields.iter().filter(|field| is_number(field.kind) == is_wanted);
        fields.map(|field| field.name).collect()
    };
    let numbers = of_kind(true);
    if numbers.contains(&field) {
        return Ok(());
    }
    let what = if of_kind(false).contains(&field) {
        format!("`{name}` is not one number per frame")
    } else {
        format!("`{topic}` has no field `{field}`")
    };
    let help = match nearest(field, numbers.iter().copied()) {
        Some(meant) => format!("did you mean `{topic}.{meant}`?"),
        None if numbers.is_empty() => {
            let topics = channels.iter().map(|channel| channel.topic).collect::<Vec<_>>();
            format!("plot a field of one of: {}", topics.join(", "))
        }
        None => format!("fields: {}", numbers.join(", ")),
    };
    Err(Failure::new(Exit::BadInput, format!("{place}: {what}")).help(help))
}

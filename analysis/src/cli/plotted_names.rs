//! The names on the command line of a plot: metrics, fields, charts, and places in the sweep, compared with the recordings.

use crate::input::coordinates::{keys_of, last_part};
use crate::models::{MODELS, figure_names, metrics_of};
use kinetoscope_console::Message;
use kinetoscope_manifest::{Coordinate, PlotRequest, nearest};

/// Rejects a name that is neither a metric of the model nor one of the fields of its recordings, and an unknown chart.
pub(super) fn check_names(
    request: &PlotRequest,
    model: &str,
    fields: &[String],
) -> Result<(), Message> {
    if let Some(figure) = &request.figure {
        let known = figure_names(model);
        let help = match nearest(figure, known.iter().copied()) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => format!("charts: {}", known.join(", ")),
        };
        let what = format!("`{figure}` is not a chart of the model {model}");
        return if known.contains(&figure.as_str()) {
            Ok(())
        } else {
            Err(Message::new(what, help))
        };
    }
    let is_of_channel = request.is_of_channel();
    if let Some(other) = request.ordinates().find(|name| name.starts_with('/') != is_of_channel) {
        return Err(Message::new(
            format!("`{}` and `{other}` have no common horizontal axis", request.y),
            "name metrics only, or fields of channels only",
        ));
    }
    request.ordinates().try_for_each(|name| check_name(name, model, fields))
}

fn check_name(y: &str, model: &str, fields: &[String]) -> Result<(), Message> {
    let is_of_channel = y.starts_with('/');
    let of_sweeps = MODELS.iter().filter(|it| it.name == model).flat_map(|it| it.sweep_metrics);
    let metrics: Vec<&str> =
        metrics_of(model).iter().chain(of_sweeps).map(|metric| metric.name).collect();
    let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
    if metrics.contains(&y) || fields.contains(&y) || (fields.is_empty() && is_of_channel) {
        return Ok(());
    }
    let with_slash = format!("/{y}");
    let help = match nearest(y, metrics.iter().chain(&fields).copied()) {
        _ if fields.contains(&with_slash.as_str()) => {
            format!("a field of a channel is written `{with_slash}`")
        }
        Some(meant) => format!("did you mean `{meant}`?"),
        None if is_of_channel => {
            let topic = y.split('.').next().unwrap_or_default();
            let of_topic: Vec<&str> = fields
                .iter()
                .copied()
                .filter(|field| field.split('.').next() == Some(topic))
                .collect();
            let listed = if of_topic.is_empty() { &fields } else { &of_topic };
            format!("fields: {}", listed.join(", "))
        }
        None => "`kinetoscope analyze --list-metrics` lists all metrics".to_owned(),
    };
    let kind = if is_of_channel { "recorded field" } else { "metric of these recordings" };
    Err(Message::new(format!("`{y}` is not a {kind}"), help))
}

/// Rejects a place that no recording has.
pub(super) fn check_places(request: &PlotRequest, runs: &[Vec<Coordinate>]) -> Result<(), Message> {
    let keys = keys_of(runs.iter().map(Vec::as_slice));
    for (key, value) in &request.at {
        let is_named = |other: &&String| *other == key || last_part(other) == key;
        let Some(full) = keys.iter().find(is_named) else {
            let help = match nearest(last_part(key), keys.iter().map(|key| last_part(key))) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => "name a key in which the recordings differ".to_owned(),
            };
            return Err(Message::new(format!("`{key}` is not swept"), help));
        };
        let mut values: Vec<&str> = Vec::new();
        for place in runs.iter().flatten().filter(|place| place.key == *full) {
            if !values.contains(&place.value.as_str()) {
                values.push(&place.value);
            }
        }
        if !values.contains(&value.as_str()) {
            let what = format!("the sweep has no point `{key}` = {value}");
            // Numbers that look alike may be far apart.
            let is_number = value.parse::<f64>().is_ok();
            let meant = nearest(value, values.iter().copied()).filter(|_| !is_number);
            values.truncate(20);
            let help = meant.map_or_else(
                || format!("values: {}", values.join(", ")),
                |meant| format!("did you mean `{meant}`?"),
            );
            return Err(Message::new(what, help));
        }
    }
    if runs.iter().any(|run| request.selects(run)) {
        return Ok(());
    }
    Err(Message::new("no recording is at all these points", "leave out one of them"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Setup: three variants at two temperatures, so that each value occurs again after others.
    #[test]
    fn unknown_value_of_a_key_names_the_nearest_or_each_value_once() {
        let place =
            |key: &str, value: &str| Coordinate { key: key.to_owned(), value: value.to_owned() };
        let variants = |kelvin: &str| {
            let run = |name: &str| vec![place("temperature_k", kelvin), place("variant", name)];
            ["smooth", "rough", "steep"].map(run)
        };
        let runs = [variants("200"), variants("300")].concat();
        let help = |key: &str, value: &str| {
            let at = vec![(key.to_owned(), value.to_owned())];
            let request = PlotRequest { at, ..PlotRequest::default() };
            check_places(&request, &runs).unwrap_err().help
        };
        assert_eq!(help("variant", "rogh").as_deref(), Some("did you mean `rough`?"));
        assert_eq!(help("variant", "unknown").as_deref(), Some("values: smooth, rough, steep"));
        // A near number is not a misspelled one.
        assert_eq!(help("temperature_k", "201").as_deref(), Some("values: 200, 300"));
    }
}

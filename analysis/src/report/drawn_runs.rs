//! The runs that have plots and a replay.

use crate::number_text::six_digits;
use crate::run::RunAnalysis;
use crate::sweep::figures::MAX_CURVES;
use kinetoscope_manifest::{Coordinate, ExperimentRecord, ViewRequest};

/// The recordings that an analysis draws if all runs are complete.
pub(super) fn drawn_files(record: &ExperimentRecord) -> Vec<String> {
    let places = record.runs.iter().map(|run| run.coordinates.as_slice());
    let view = record.view.clone().unwrap_or_default();
    let drawn = drawn_runs(places, &view);
    drawn.into_iter().map(|index| record.runs[index].file.clone()).collect()
}

/// Which runs are drawn: the first one of each point, because plots take most of the memory; of more points than curves in a chart, that many from the
/// first to the last, with those that the manifest compares.
pub(super) fn drawn_runs<'a>(
    places: impl Iterator<Item = &'a [Coordinate]>,
    view: &ViewRequest,
) -> Vec<usize> {
    let mut points: Vec<(&[Coordinate], usize)> = Vec::new();
    for (index, place) in places.enumerate() {
        if !points.iter().any(|(other, _)| *other == place) {
            points.push((place, index));
        }
    }
    let (last, most) = (points.len().saturating_sub(1), MAX_CURVES);
    if points.len() <= most {
        return points.into_iter().map(|(_, run)| run).collect();
    }
    let mut chosen: Vec<usize> = (0..most).map(|curve| curve * last / (most - 1)).collect();
    for place in 0..view.compare.len() {
        let is_compared =
            |(coordinates, _): &(&[Coordinate], usize)| view.compared(coordinates) == Some(place);
        if let Some(point) = points.iter().position(is_compared)
            && !chosen.contains(&point)
        {
            // In place of one within the sweep.
            chosen[1 + place] = point;
        }
    }
    chosen.sort_unstable();
    chosen.into_iter().map(|point| points[point].1).collect()
}

/// Notes about requested snapshots that no run reaches.
pub(crate) fn snapshots_outside(runs: &[RunAnalysis], requested: &[f64]) -> Vec<String> {
    let Some(end) = runs.iter().map(|run| run.end_time).reduce(f64::max) else { return Vec::new() };
    let unit = runs.first().map_or("", |run| run.time_unit.as_str());
    let outside = requested.iter().filter(|time| **time > end || **time < 0.0);
    let note = |time: &f64| {
        let (time, end) = (six_digits(*time), six_digits(end));
        format!("no snapshot at t = {time} {unit}: the recordings are from 0 to {end} {unit}")
    };
    outside.map(note).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guarantee: the ends of a sweep are drawn, whatever its length, and each point once.
    #[test]
    fn ends_of_a_sweep_are_drawn() {
        for points in [1_usize, 2, 7, 8, 50, 1000] {
            let places: Vec<Vec<Coordinate>> = (0..2 * points)
                .map(|run| vec![Coordinate { key: "x".into(), value: (run / 2).to_string() }])
                .collect();
            let drawn = drawn_runs(places.iter().map(Vec::as_slice), &ViewRequest::default());
            assert_eq!(drawn.len(), points.min(MAX_CURVES));
            assert_eq!((drawn[0], drawn[drawn.len() - 1]), (0, 2 * (points - 1)));
            assert!(drawn.windows(2).all(|pair| pair[0] < pair[1]), "{drawn:?}");
        }
        assert!(drawn_runs(std::iter::empty(), &ViewRequest::default()).is_empty());
    }

    #[test]
    fn compared_points_are_drawn() {
        let places: Vec<Vec<Coordinate>> = (0..50)
            .map(|run| vec![Coordinate { key: "x".into(), value: run.to_string() }])
            .collect();
        let at = |value: &str| vec![("x".to_owned(), value.to_owned())];
        let view = ViewRequest { compare: vec![at("3"), at("4")], ..ViewRequest::default() };
        let drawn = drawn_runs(places.iter().map(Vec::as_slice), &view);
        assert!(drawn.contains(&3) && drawn.contains(&4), "{drawn:?}");
        assert!(drawn.len() == MAX_CURVES && drawn[0] == 0 && drawn[MAX_CURVES - 1] == 49);
    }
}

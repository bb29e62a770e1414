//! Plots of several bodies: their paths, and their energy over time.

use super::bodies::BodiesRun;
use crate::models::contract::PlottedObserver;
use crate::models::figures::{Figures, chart, curve};
use crate::models::relative_change;
use crate::plot::{Axis, Chart, Curve, CurveStyle, Plot, Point};

impl PlottedObserver for BodiesRun {
    fn figures(&self) -> Figures {
        let Some(first) = self.instants.first() else { return Figures::default() };
        // A closed path is thinned evenly, because its extremes are not those of its neighbors.
        let stride = self.instants.len().div_ceil(2000).max(1);
        let paths = (0..first.positions.len()).map(|body| {
            let instants = self.instants.iter().step_by(stride);
            let positions = instants.map(|instant| instant.positions[body]);
            let points = positions.map(|position| Point::bare(position[0], position[1]));
            let name = format!("body {body}");
            Curve { name, style: CurveStyle::Line, color: body, points: points.collect() }
        });
        let path = Plot::Chart(Chart {
            stem: "path".to_owned(),
            title: "Paths about the center of mass".to_owned(),
            x: Axis::linear("x", "AU"),
            y: Axis::linear("y", "AU"),
            equal_aspect: true,
            curves: paths.collect(),
        });
        let drifts = self
            .instants
            .iter()
            .map(|instant| (instant.time_days, relative_change(instant.energy, first.energy)));
        let curves = vec![curve("measured", CurveStyle::Line, 0, drifts)];
        let (x, y) = (Axis::linear("time", "days"), Axis::linear("(E − E₀) / |E₀|", ""));
        let energy = chart("energy_drift", "Energy of all bodies", x, y, curves);
        Figures { plots: vec![path, energy], comparisons: Vec::new() }
    }
}

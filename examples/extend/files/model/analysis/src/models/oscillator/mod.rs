//! Analysis of oscillator runs.

use crate::metric::Measurements;
use crate::metric::definition::definitions;
use crate::models::contract::{Extent, MainResults, ModelAnalysis, Observer, PlottedObserver};
use crate::models::figures::Figures;
use crate::models::snapshots::Snapshots;
use kinetoscope_manifest::model::OscillatorConfig;
use kinetoscope_recording::channels::OscillatorEnergy;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::RecordedFrame;

definitions! {
    MAX_ENERGY_ERROR: "energy.max_error_relative", "1", "largest error of the energy", "/energy: max |E - E_0|/E_0 over the frames", [], 0.0;
}

/// The analysis of oscillator runs.
pub(super) const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "oscillator",
    title: "Oscillator",
    metrics: ALL,
    never: &[],
    needs_replicates: &[],
    needs_all_states: &[],
    sweep_metrics: &[],
    fits: &[],
    ordinates: &[],
    trade_offs: &[],
    figures: &[],
};

/// The observer of a run.
pub(super) fn observer(_: OscillatorConfig, _: Snapshots) -> Box<dyn PlottedObserver> {
    Box::new(OscillatorRun::default())
}

/// The error of the energy, without a chart.
pub(super) fn main_results(_: &OscillatorConfig) -> MainResults {
    MainResults::new(&["energy.max_error_relative"], &[])
}

/// A point without walls.
pub(super) fn extent(_: &OscillatorConfig) -> Extent {
    Extent::default()
}

#[derive(Default)]
struct OscillatorRun {
    start_energy: Option<f64>,
    max_error: f64,
}

impl Observer for OscillatorRun {
    fn observe(&mut self, frame: RecordedFrame) -> Result<(), ReadError> {
        if let Some(energy) = frame.get::<OscillatorEnergy>()? {
            let energy = energy.specific_energy_j_per_kg;
            let start = *self.start_energy.get_or_insert(energy);
            self.max_error = self.max_error.max((energy / start - 1.0).abs());
        }
        Ok(())
    }

    fn measure(&self, found: &mut Measurements) {
        found.add(MAX_ENERGY_ERROR, self.start_energy.map(|_| self.max_error));
    }
}

impl PlottedObserver for OscillatorRun {
    fn figures(&self) -> Figures {
        Figures::default()
    }
}

//! Discs in gravity against the balance of weight and pressure, and their energy balance.

use super::in_gravity::{InGravity, LAYERS, room};
use super::laws as law;
use super::metrics as metric;
use super::observe::PackingRun;
use crate::metric::Measurements;
use crate::metric::theory::ExpectedValue;
use crate::models::hard_discs::{EXTRAPOLATION_LIMIT, STATE_EQUATION_ACCURACY, StateEquation};
use crate::plot::{Axis, Curve, CurveStyle, Plot};
use kinetoscope_manifest::model::PackingConfig;
use std::f64::consts::PI;

/// Steps of the integration over the height, per layer.
const STEPS: usize = 100;

/// Equilibrium of discs of one size in gravity.
struct Column {
    /// Discs per layer.
    layers: [f64; LAYERS],
    mean_height: f64,
    /// Packing fraction at the floor.
    at_floor: f64,
}

impl Column {
    /// The discs of a manifest at a temperature; `None` if they are denser than a fluid at the floor.
    fn of(config: &PackingConfig, temperature: f64) -> Option<Self> {
        let discs = f64::from(config.discs.get());
        let (mut low, mut high) = (0.0, EXTRAPOLATION_LIMIT);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            let fewer = Self::above(config, temperature, middle).layers.iter().sum::<f64>() < discs;
            if fewer { low = middle } else { high = middle }
        }
        let is_fluid = temperature > 0.0 && high < EXTRAPOLATION_LIMIT;
        is_fluid.then(|| Self::above(config, temperature, low))
    }

    /// The column above a packing fraction f at the floor: d(f Z)/dy = -f g/T, by the midpoint rule.
    fn above(config: &PackingConfig, temperature: f64, at_floor: f64) -> Self {
        let room = room(config);
        let radius = config.radius.get();
        let step = room / (LAYERS * STEPS) as f64;
        let per_fraction = (config.width.get() - 2.0 * radius) * step / (PI * radius * radius);
        let slope = |fraction: f64| {
            let state = StateEquation::at(fraction);
            let rise = state.compressibility + fraction * state.slope;
            -fraction * config.gravity.get() / temperature / rise
        };
        let (mut fraction, mut layers, mut moment) = (at_floor, [0.0; LAYERS], 0.0);
        for index in 0..LAYERS * STEPS {
            let middle = fraction + 0.5 * step * slope(fraction);
            fraction = (fraction + step * slope(middle)).max(0.0);
            layers[index / STEPS] += middle * per_fraction;
            moment += middle * per_fraction * step * (index as f64 + 0.5);
        }
        let mean_height = moment / layers.iter().sum::<f64>();
        Self { layers, mean_height, at_floor }
    }
}

impl PackingRun {
    /// Whether there is gravity.
    pub(super) fn falls(&self) -> bool {
        self.config.gravity.get() > 0.0
    }

    /// The equilibrium at the temperature of the floor, or else of the settled states; `None` for discs that have none.
    fn column(&self) -> Option<Column> {
        let config = &self.config;
        let has_equilibrium =
            self.is_elastic() && self.equal_radius().is_some() && config.shaking.is_none();
        let measured = self.gravity.temperatures.value() / self.gravity.states;
        let temperature = config.floor_temperature.map_or(measured, |floor| floor.get());
        if has_equilibrium { Column::of(config, temperature) } else { None }
    }

    /// Adds the metrics of discs in gravity.
    pub(super) fn measure_gravity(&self, found: &mut Measurements) {
        if let Some((first, last)) = &self.gravity.energy {
            let exchanged = first.total.abs() + last.from_floor.abs() + last.dissipated;
            let residual = if exchanged > 0.0 { last.residual / exchanged } else { 0.0 };
            found.compare(metric::ENERGY_RESIDUAL, residual, Some(0.0));
            found.add(metric::ENERGY_FROM_FLOOR, last.from_floor);
            found.add(metric::ENERGY_DISSIPATED, last.dissipated);
        }
        let Some(height) = self.gravity.heights.estimate() else { return };
        let theory = self.column().map(|column| {
            let of_floor = column.at_floor * 2.0 * self.config.radius.get();
            // At a fixed energy, the temperature of few discs scatters.
            let of_energy = if self.config.floor_temperature.is_some() { 0.0 } else { 1.0 };
            let relative = STATE_EQUATION_ACCURACY + of_energy / self.discs();
            let accuracy = Some(of_floor + relative * column.mean_height);
            ExpectedValue { value: column.mean_height, accuracy, violation: None }
        });
        found.compare_with(metric::MEAN_HEIGHT, height, law::BALANCE_OF_WEIGHT, theory);
    }
}

/// Density over height in the settled states; `None` without gravity.
pub(super) fn density_by_height(run: &PackingRun) -> Option<Plot> {
    let InGravity { layers, states, .. } = &run.gravity;
    if *states == 0.0 {
        return None;
    }
    let thickness = room(&run.config) / LAYERS as f64;
    let over_height = |counts: &[f64; LAYERS], states: f64| -> Vec<(f64, f64)> {
        let density = |count: f64| count / states * LAYERS as f64 / run.discs();
        let height = |layer: usize| thickness * (layer as f64 + 0.5);
        (0..LAYERS).map(|layer| (height(layer), density(counts[layer]))).collect()
    };
    let mut curves =
        vec![Curve::new("measured", CurveStyle::Data, 0, over_height(layers, *states))];
    if let Some(column) = run.column() {
        let theory = over_height(&column.layers, 1.0);
        curves.push(Curve::theory("balance of weight and pressure", 1, theory));
    }
    let axes = [
        Axis::linear("height above the lowest center", ""),
        Axis::linear("density over the mean", "1"),
    ];
    Some(Plot::chart("density_by_height", "Density by height", axes, curves))
}

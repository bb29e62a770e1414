//! Discs in gravity: their density by height against the balance of weight and pressure, and their energy balance.

use super::laws as law;
use super::metrics as metric;
use super::observe::PackingRun;
use crate::metric::Measurements;
use crate::metric::theory::ExpectedValue;
use crate::models::hard_discs::{EXTRAPOLATION_LIMIT, STATE_EQUATION_ACCURACY, StateEquation};
use crate::plot::{Axis, Curve, CurveStyle, Plot};
use crate::statistics::{Blocking, Sum};
use kinetoscope_manifest::model::{PackingConfig, RunLength};
use kinetoscope_recording::channels::PackingEnergy;
use kinetoscope_recording::reader::StateTable;
use std::f64::consts::PI;

/// Number of layers of equal height.
const LAYERS: usize = 20;

/// Steps of the integration over the height, per layer.
const STEPS: usize = 100;

/// Fraction of the run after which means begin: the heights settle by sound and heat, which take longer than the velocities.
const SETTLED_FROM: f64 = 0.5;

/// What the states and the energies of discs in gravity give.
#[derive(Clone, Debug, Default)]
pub(super) struct InGravity {
    /// Of the first frame and of the last one.
    energy: Option<(PackingEnergy, PackingEnergy)>,
    /// Discs per layer, in all settled states.
    layers: [f64; LAYERS],
    /// Number of settled states, and the sum of their temperatures.
    states: f64,
    temperatures: Sum,
    /// Mean height of the centers above their lowest position, per settled state.
    heights: Blocking,
}

impl InGravity {
    /// Adds the energy of a frame, if it has one.
    pub(super) fn add_energy(&mut self, energy: Option<PackingEnergy>) {
        let Some(energy) = energy else { return };
        let first = self.energy.take().map_or_else(|| energy.clone(), |(first, _)| first);
        self.energy = Some((first, energy));
    }

    /// Adds a state, if it is settled.
    pub(super) fn add_state(
        &mut self,
        config: &PackingConfig,
        [time, events]: [f64; 2],
        state: &StateTable,
    ) {
        let progress = match config.length {
            RunLength::Duration(duration) => time / duration.get(),
            RunLength::EventsPerDisc(per_disc) => {
                events / (f64::from(per_disc.get()) * f64::from(config.discs.get()))
            }
        };
        let columns = ["y", "vx", "vy"].map(|name| state.index(name));
        let [Some(y), Some(vx), Some(vy)] = columns else { return };
        if config.gravity.get() == 0.0 || progress < SETTLED_FROM {
            return;
        }
        let room = room(config);
        let (mut heights, mut squares, mut count) = (0.0, 0.0, 0.0);
        for row in state.iter() {
            let height = row[y] + 0.5 * room;
            let layer = (height / room * LAYERS as f64).clamp(0.0, LAYERS as f64 - 1.0);
            self.layers[layer as usize] += 1.0;
            heights += height;
            squares += row[vx] * row[vx] + row[vy] * row[vy];
            count += 1.0;
        }
        self.states += 1.0;
        self.heights.add(heights / count);
        self.temperatures.add(0.5 * squares / count);
    }
}

/// Distance between the lowest and the highest position of a center.
fn room(config: &PackingConfig) -> f64 {
    config.height.get() - 2.0 * config.radius.get()
}

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
            let of_floor = column.at_floor * self.config.radius.get();
            let relative = STATE_EQUATION_ACCURACY + 1.0 / self.discs();
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

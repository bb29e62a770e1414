//! Discs in gravity against the balance of weight and pressure, and their energy balance.

use super::in_gravity::{InGravity, LAYERS, room};
use super::laws as law;
use super::metrics as metric;
use super::observe::PackingRun;
use crate::metric::theory::ExpectedValue;
use crate::metric::{Measurements, Quantity, Violation};
use crate::models::hard_discs::{EXTRAPOLATION_LIMIT, STATE_EQUATION_ACCURACY, StateEquation};
use crate::plot::{Axis, Curve, CurveStyle, Plot};
use kinetoscope_manifest::model::{PackingConfig, RunLength};
use std::f64::consts::PI;

/// Least number of steps of the integration per layer, the largest one of the logarithm of the packing fraction, and the fraction of that at the
/// floor at which the column ends.
const STEPS: usize = 200;
const LARGEST_STEP: f64 = 0.01;
const SPARSEST: f64 = 1e-14;

/// Largest diameter over the width of the box for which the walls do not matter.
const MAX_DIAMETER_OVER_WIDTH: f64 = 0.1;
/// Number of discs from which on a fixed energy gives a temperature.
const LEAST_DISCS_AT_FIXED_ENERGY: f64 = 20.0;
/// Least time over that in which a disc crosses the column.
const LEAST_CROSSINGS: f64 = 20.0;
/// Why heights are not measured in a run whose length is a number of collisions.
const AT_COLLISIONS: &str =
    "the frames are at collisions, which do not sample the time: set `duration`";

/// Equilibrium of discs of one size in gravity.
struct Column {
    /// Discs per layer.
    layers: [f64; LAYERS],
    mean_height: f64,
    /// Packing fraction at the floor.
    at_floor: f64,
    /// Share of the area that is within a diameter of obstacles, at most.
    near_obstacles: f64,
    /// Whether obstacles leave no way at some height.
    is_blocked: bool,
}

/// The room that obstacles leave for centers.
struct Obstacles {
    /// Free part of the width at the heights of [`STEPS`] per layer, from the lowest center up; empty without obstacles.
    free: Vec<f64>,
    near: f64,
}

impl Obstacles {
    fn new(config: &PackingConfig) -> Self {
        let (centers, of_obstacle) = config.obstacles();
        let radius = config.radius.get();
        let (contact, room) = (of_obstacle + radius, room(config));
        let half = 0.5 * config.width.get() - radius;
        let free = |step: usize| {
            let y = ((step as f64 + 0.5) / (LAYERS * STEPS) as f64 - 0.5) * room;
            let cut = |[x, at]: &[f64; 2]| {
                let square = contact * contact - (y - at) * (y - at);
                (square > 0.0).then(|| [x - square.sqrt(), x + square.sqrt()])
            };
            let mut cuts: Vec<[f64; 2]> = centers.iter().filter_map(cut).collect();
            cuts.sort_by(|one, other| one[0].total_cmp(&other[0]));
            let (mut free, mut from) = (0.0, -half);
            for [left, right] in cuts.into_iter().chain([[half, half]]) {
                free += (left.min(half) - from).max(0.0);
                from = from.max(right);
            }
            free / (2.0 * half)
        };
        let area = config.width.get() * config.height.get();
        let near = centers.len() as f64 * 2.0 * PI * contact * 2.0 * radius / area;
        let steps = if centers.is_empty() { 0 } else { LAYERS * STEPS };
        Self { free: (0..steps).map(free).collect(), near }
    }

    /// Free part of the width at a part of the room.
    fn free_part(&self, height: f64) -> f64 {
        let step = (height * (LAYERS * STEPS) as f64) as usize;
        self.free.get(step).copied().unwrap_or(1.0)
    }
}

impl Column {
    /// The discs of a manifest at a temperature; `None` if they are denser than a fluid at the floor.
    fn of(config: &PackingConfig, temperature: f64) -> Option<Self> {
        let discs = f64::from(config.discs.get());
        let obstacles = Obstacles::new(config);
        let above = |at_floor| Self::above(config, temperature, at_floor, &obstacles);
        let (mut low, mut high) = (0.0, EXTRAPOLATION_LIMIT);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            let fewer = above(middle).layers.iter().sum::<f64>() < discs;
            if fewer { low = middle } else { high = middle }
        }
        let is_fluid = temperature > 0.0 && high < EXTRAPOLATION_LIMIT;
        let (near_obstacles, is_blocked) = (obstacles.near, obstacles.free.contains(&0.0));
        is_fluid.then(|| Self { near_obstacles, is_blocked, ..above(low) })
    }

    /// The column above a packing fraction f at the floor: with s = ln f, dy = -(T/g) d(f Z)/df ds, by the midpoint rule. Steps are at most
    /// a part of a layer high, and a part of a scale height, so that both thin and high columns are followed.
    fn above(
        config: &PackingConfig,
        temperature: f64,
        at_floor: f64,
        obstacles: &Obstacles,
    ) -> Self {
        let (room, radius) = (room(config), config.radius.get());
        let scale_height = temperature / config.gravity.get();
        let highest = room / (LAYERS * STEPS) as f64;
        let per_area = (config.width.get() - 2.0 * radius) / (PI * radius * radius);
        let rise = |fraction: f64| {
            let state = StateEquation::at(fraction);
            scale_height * (state.compressibility + fraction * state.slope)
        };
        let (mut fraction, mut bottom) = (at_floor, 0.0);
        let (mut layers, mut moment) = ([0.0; LAYERS], 0.0);
        while bottom < room && fraction > SPARSEST * at_floor {
            let wanted = highest / rise(fraction);
            let step = if wanted < LARGEST_STEP { wanted } else { LARGEST_STEP };
            let middle = fraction * libm::exp(-0.5 * step);
            let (whole, left) = (rise(middle) * step, room - bottom);
            let thickness = if whole < left { whole } else { left };
            let height = bottom + 0.5 * thickness;
            let discs = middle * thickness * (per_area * obstacles.free_part(height / room));
            layers[((height / room * LAYERS as f64) as usize).min(LAYERS - 1)] += discs;
            moment += discs * height;
            fraction *= libm::exp(-step);
            bottom += thickness;
        }
        let mean_height = moment / layers.iter().sum::<f64>();
        Self { layers, mean_height, at_floor, near_obstacles: 0.0, is_blocked: false }
    }
}

impl PackingRun {
    /// Whether there is gravity.
    pub(super) fn falls(&self) -> bool {
        self.config.gravity.get() > 0.0
    }

    /// The duration that the manifest gives.
    fn duration(&self) -> Option<f64> {
        match self.config.length {
            RunLength::Duration(duration) => Some(duration.get()),
            RunLength::EventsPerDisc(_) => None,
        }
    }

    /// The temperature of the floor, or else of the settled states.
    fn column_temperature(&self) -> f64 {
        let measured = self.gravity.temperatures.value() / self.gravity.states;
        self.config.floor_temperature.map_or(measured, |floor| floor.get())
    }

    /// The condition of the balance of weight and pressure that the run does not meet.
    fn outside_balance(&self) -> Option<Violation> {
        let config = &self.config;
        let (temperature, room) = (self.column_temperature(), room(config));
        let scale_height = temperature / config.gravity.get();
        let height = if scale_height < room { scale_height } else { room };
        let crossings = self.duration()? * temperature.sqrt() / height;
        let ratio = 2.0 * config.radius.get() / config.width.get();
        let at_fixed_energy = config.floor_temperature.is_none();
        (Quantity::DiameterOverSide.at_most(ratio, MAX_DIAMETER_OVER_WIDTH))
            .or_else(|| Quantity::Crossings.at_least(crossings, LEAST_CROSSINGS))
            .or_else(|| {
                let violation = Quantity::Discs.at_least(self.discs(), LEAST_DISCS_AT_FIXED_ENERGY);
                violation.filter(|_| at_fixed_energy)
            })
    }

    /// The equilibrium at the temperature of the floor, or else of the settled states; `None` for discs that have none.
    fn column(&self) -> Option<Column> {
        let config = &self.config;
        let has_equilibrium =
            self.is_elastic() && self.equal_radius().is_some() && config.shaking.is_none();
        if has_equilibrium { Column::of(config, self.column_temperature()) } else { None }
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
        if self.falls() && self.duration().is_none() {
            return found.explain(metric::MEAN_HEIGHT, AT_COLLISIONS);
        }
        let Some(height) = self.gravity.heights.estimate() else { return };
        let theory = self.column().map(|column| {
            let of_floor = column.at_floor * 2.0 * self.config.radius.get();
            // At a fixed energy, the temperature of few discs scatters.
            let of_energy = if self.config.floor_temperature.is_some() { 0.0 } else { 1.0 };
            let relative = STATE_EQUATION_ACCURACY
                + of_energy / self.discs()
                + column.at_floor * column.near_obstacles;
            let accuracy = Some(of_floor + relative * column.mean_height);
            let is_untouched = self.config.floor_temperature.is_some()
                && self.gravity.energy.as_ref().is_some_and(|(_, last)| last.from_floor == 0.0);
            let violation = self
                .outside_balance()
                .or_else(|| Quantity::Barrier.required(!column.is_blocked && !is_untouched));
            ExpectedValue { value: column.mean_height, accuracy, violation }
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

//! One type a model: all its physics and its duration, every value in range.

mod dem;
mod dem_materials;
mod dem_radius;
mod dem_rain;
mod dem_scene;
mod dem_walls;
mod gas;
mod gas_walls;
mod orbit;
mod packing;
mod start_from;

pub use dem::{
    DemConfig, DemIntegrator, Dissipation, ForceTail, PeriodicSides, Stability, TimeStep,
};
pub use dem_materials::{DISC, DemContactConstants, DemContactPair, DemMaterial, WALL};
pub use dem_radius::DiscRadius;
pub use dem_rain::DemRain;
pub use dem_walls::{DemWall, DemWallShape};
pub use gas::{
    BoltzmannConstant, GasConfig, PlaceDistribution, Propagation, SpeedDistribution, SpeedScale,
    TemperatureDefinition,
};
pub use gas_walls::ThermalWall;
pub use orbit::{OrbitBody, OrbitConfig, OrbitIntegrator, OrbitStart, OrbitSummation};
pub use packing::{
    Boundary, CollapseGuard, InitialVelocities, PERIODIC_DIAMETERS, PackingConfig,
    PackingPlacement, RunLength,
};
pub use start_from::{RecordedState, Recordings, StartFrom};

use crate::diagnostics::{Diagnostic, nearest};
use crate::keys::{Keys, Reader};
use crate::quantity::Finite;
use crate::tree::{Entry, Node, Table, Value};
use crate::value::{TomlValue, refuse, table_schema, word};
use serde_json::{Value as Json, json};
use start_from::{MayBeRecorded as _, start_keys};
use std::num::NonZeroU32;

/// The table `[model.<NAME>]`: which model, and its values.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelConfig {
    /// Spring–dashpot discs in a box.
    Dem(DemConfig),
    /// Point particles in a circular container.
    Gas(GasConfig),
    /// Event-driven hard discs.
    Packing(PackingConfig),
    /// The Earth around the Sun.
    Orbit(OrbitConfig),
}

/// Positions and velocities written out in a manifest, one pair a particle, in SI units or the model's own.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenState {
    /// Centers, `[x, y]` each.
    pub positions: Vec<[Finite; 2]>,
    /// Velocities, `[vx, vy]` each; as many as positions.
    pub velocities: Vec<[Finite; 2]>,
}

/// How particles are placed at the start.
#[derive(Clone, Debug, PartialEq)]
pub enum Placement {
    /// Uniformly at random, without overlap where particles have a size.
    Random,
    /// On a regular lattice (DEM only).
    Lattice,
    /// Written out.
    Given(GivenState),
    /// As the run of a recording ended.
    Recorded(StartFrom),
}

impl ModelConfig {
    /// The names of all models.
    pub const NAMES: [&'static str; 4] = ["dem", "gas", "packing", "orbit"];

    /// The model of a name with all its defaults.
    #[must_use]
    pub fn with_defaults(name: &str) -> Option<Self> {
        match name {
            "dem" => Some(Self::Dem(DemConfig::default())),
            "gas" => Some(Self::Gas(GasConfig::default())),
            "packing" => Some(Self::Packing(PackingConfig::default())),
            "orbit" => Some(Self::Orbit(OrbitConfig::default())),
            _ => None,
        }
    }

    /// The name of the model, as in `[model.<NAME>]`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Dem(_) => "dem",
            Self::Gas(_) => "gas",
            Self::Packing(_) => "packing",
            Self::Orbit(_) => "orbit",
        }
    }

    /// The keys of the model's table.
    pub(crate) fn keys(&mut self, keys: &mut impl Keys) {
        match self {
            Self::Dem(config) => config.keys(keys),
            Self::Gas(config) => config.keys(keys),
            Self::Packing(config) => config.keys(keys),
            Self::Orbit(config) => config.keys(keys),
        }
    }

    /// The recording that the run begins with, if it does.
    #[must_use]
    pub fn start_from(&self) -> Option<&StartFrom> {
        match self {
            Self::Dem(config) => config.placement.recorded(),
            Self::Gas(config) => config.placement.recorded(),
            Self::Packing(config) => config.placement.recorded(),
            Self::Orbit(config) => config.start.recorded(),
        }
    }

    /// Looks for the recording that the run begins with, if it does.
    ///
    /// # Errors
    /// Why there is none, or none that this model can begin with.
    pub fn read_start(&mut self, recordings: Recordings<'_>) -> Result<(), String> {
        let name = self.name();
        let start = match self {
            Self::Dem(config) => config.placement.recorded_mut(),
            Self::Gas(config) => config.placement.recorded_mut(),
            Self::Packing(config) => config.placement.recorded_mut(),
            Self::Orbit(config) => config.start.recorded_mut(),
        };
        start.map_or(Ok(()), |start| start.read_by(recordings, name))
    }

    fn check(&mut self, table: &mut Reader<'_>) {
        match self {
            Self::Dem(config) => config.check(table),
            Self::Gas(config) => config.check(table),
            Self::Packing(config) => config.check(table),
            Self::Orbit(config) => config.check(table),
        }
    }

    /// Reads the table `[model]`, which holds exactly one model. `None` if there is no telling which. Without `recordings` a
    /// start from one is left a name.
    pub(crate) fn read(
        models: &Table,
        recordings: Option<Recordings<'_>>,
        errors: &mut Vec<Diagnostic>,
    ) -> Option<Self> {
        let mut known: Vec<&Entry> = Vec::new();
        for entry in &models.entries {
            if Self::NAMES.contains(&&*entry.key) {
                known.push(entry);
                continue;
            }
            let label = match nearest(&entry.key, Self::NAMES) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => format!("models: {}", Self::NAMES.join(", ")),
            };
            let title = format!("unknown model `{}`", entry.key);
            errors.push(Diagnostic::new(title).at(entry.key_span, label));
        }
        if known.len() > 1 {
            let names: Vec<String> =
                known.iter().map(|entry| format!("[model.{}]", entry.key)).collect();
            let title = format!("{} exclude each other", names.join(" and "));
            let places = known.iter().map(|entry| entry.key_span).collect();
            errors.push(Diagnostic::between(title, places, "keep one model"));
        }
        if models.entries.is_empty() {
            errors.push(no_model());
        }
        let entry = known.first()?;
        let mut model = Self::with_defaults(&entry.key)?;
        let path = format!("model.{}", entry.key);
        let Some(table) = entry.node.table() else {
            refuse(&entry.node, &path, "a table", errors);
            return Some(model);
        };
        let mut reader = Reader::new(&path, table, errors);
        model.keys(&mut reader);
        if let Some(Err(why)) = recordings.map(|recordings| model.read_start(recordings)) {
            let title = format!("the run cannot start from `{path}.start_from`");
            reader.refuse(&["start_from"], &title, &why);
        }
        model.check(&mut reader);
        reader.finish();
        Some(model)
    }
}

/// The error of a manifest without a model.
pub(crate) fn no_model() -> Diagnostic {
    Diagnostic::new("no model: add one of [model.dem], [model.gas], [model.packing], [model.orbit]")
}

/// Refuses a run that ends before its first step.
fn at_least_one_step(steps: f64, table: &mut Reader<'_>, keys: &[&str]) {
    // The rule for the number of steps is floor(duration / step + 1e-9).
    if steps + 1e-9 < 1.0 {
        table.refuse(
            keys,
            "the run is shorter than one time step",
            "the time step must be <= the duration",
        );
    }
}

/// What a model calls the two lists of a given state.
#[derive(Clone, Copy)]
struct GivenNames {
    positions: &'static str,
    velocities: &'static str,
}

const GIVEN_SI: GivenNames =
    GivenNames { positions: "positions_m", velocities: "velocities_m_per_s" };

impl GivenState {
    fn read(
        node: &Node,
        table: &Table,
        name: &str,
        names: GivenNames,
        errors: &mut Vec<Diagnostic>,
    ) -> Option<Self> {
        let mut reader = Reader::new(name, table, errors);
        let positions: Option<Vec<[Finite; 2]>> = reader.required(names.positions, node.span);
        let velocities: Option<Vec<[Finite; 2]>> = reader.required(names.velocities, node.span);
        let state =
            positions.zip(velocities).map(|(positions, velocities)| Self { positions, velocities });
        let mut sound = true;
        if let Some(Self { positions, velocities }) = &state {
            let keys = [names.positions, names.velocities];
            sound = !positions.is_empty() && positions.len() == velocities.len();
            if positions.len() != velocities.len() {
                let title = format!(
                    "`{name}` has {} positions but {} velocities",
                    positions.len(),
                    velocities.len()
                );
                reader.refuse(&keys, &title, "one velocity for each position");
            } else if positions.is_empty() {
                reader.refuse(&keys, &format!("`{name}` is empty"), "needs at least one particle");
            }
        }
        reader.finish();
        state.filter(|_| sound)
    }

    fn write(&self, names: GivenNames) -> String {
        format!(
            "{{ {} = {}, {} = {} }}",
            names.positions,
            self.positions.write(),
            names.velocities,
            self.velocities.write()
        )
    }

    /// The number of particles, which the key `counter` may repeat but not contradict.
    fn count(&self, table: &mut Reader<'_>, counter: &str, stated: NonZeroU32) -> NonZeroU32 {
        let given = u32::try_from(self.positions.len()).ok().and_then(NonZeroU32::new);
        if table.has(counter) && given != Some(stated) {
            let title = format!("`{counter}` is {stated}, but {} are placed", self.positions.len());
            let label = format!("must be {}, or be left out", self.positions.len());
            table.refuse(&["placement", counter], &title, &label);
        }
        given.unwrap_or(stated)
    }
}

fn read_placement<T: Clone>(
    node: &Node,
    name: &str,
    words: &[(&str, T)],
    given: impl FnOnce(GivenState) -> T,
    names: GivenNames,
    errors: &mut Vec<Diagnostic>,
) -> Option<T> {
    match &node.value {
        Value::Table(table) => GivenState::read(node, table, name, names, errors).map(given),
        _ => {
            let besides =
                format!(" or {{ {} = ..., {} = ... }}", names.positions, names.velocities);
            word(node, name, words, &besides, errors)
        }
    }
}

fn placement_schema(words: &[&str], names: GivenNames) -> Json {
    let mut vectors = Vec::<[Finite; 2]>::schema();
    vectors["minItems"] = json!(1);
    let properties = json!({ names.positions: vectors, names.velocities: vectors });
    let given = table_schema(&properties, &[names.positions, names.velocities]);
    json!({ "anyOf": [{ "enum": words }, given] })
}

impl TomlValue for Placement {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let words = [("random", Self::Random), ("lattice", Self::Lattice)];
        read_placement(node, name, &words, Self::Given, GIVEN_SI, errors)
    }

    fn write(&self) -> String {
        match self {
            Self::Random => "\"random\"".to_owned(),
            Self::Lattice => "\"lattice\"".to_owned(),
            Self::Given(state) => state.write(GIVEN_SI),
            Self::Recorded(start) => start.write(),
        }
    }

    fn schema() -> Json {
        placement_schema(&["random", "lattice"], GIVEN_SI)
    }
}

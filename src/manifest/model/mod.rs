//! The models: one type per model with all its physics and its duration, every value in range.
//!
//! A new model needs a folder here, with a type that implements `contract::Model` and a starter manifest, its `mod` and `use` lines,
//! and one line in `models!`.

mod contract;
mod dem;
mod gas;
mod orbit;
mod packing;
mod sizes;
mod start;
mod start_from;

pub use contract::MAX_STEPS;
pub use dem::*;
pub use gas::*;
pub use orbit::*;
pub use packing::*;
pub use start::{GivenState, Placement};
pub use start_from::{RecordedState, Recordings, StartFrom};

use crate::diagnostics::{Diagnostic, Errors, nearest};
use crate::keys::{HasKeys, Keys, Names, Reader};
use crate::tree::{Entry, Node, Table, Value};
use crate::value::refuse_type;
use contract::Model;
use start_from::MayBeRecorded as _;
use std::num::NonZeroU32;

/// Defines [`ModelConfig`] and [`CHANNELS`] from the list of models: each with its name, its variant, its type, the key of
/// `[record]` for an interval of simulated time, its channels and, if a run can start from a recording, the field of its
/// start.
macro_rules! models {
    ($(
        $(#[$meta:meta])*
        $name:ident: $variant:ident($config:ty) $(from $start:ident)? every $time_key:ident [$($channel:ident)+],
    )+) => {
        /// The table `[model.<NAME>]`: which model, and its values.
        #[derive(Clone, Debug, PartialEq)]
        pub enum ModelConfig {
            $($(#[$meta])* $variant($config),)+
        }

        /// The channels that each model can record, without the leading slash; `/frame` is always recorded.
        pub const CHANNELS: [(&str, &[&str]); ModelConfig::NAMES.len()] =
            [$((stringify!($name), &[$(stringify!($channel)),+])),+];

        impl ModelConfig {
            /// The names of all models.
            pub const NAMES: [&'static str; [$(stringify!($name)),+].len()] =
                [$(stringify!($name)),+];

            /// The model of a name with all its defaults.
            #[must_use]
            pub fn with_defaults(name: &str) -> Option<Self> {
                match name {
                    $(stringify!($name) => Some(Self::$variant(<$config>::default())),)+
                    _ => None,
                }
            }

            /// The name of the model, as in `[model.<NAME>]`.
            #[must_use]
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => stringify!($name),)+
                }
            }

            /// The recording that the run begins with, if it begins with one.
            #[must_use]
            pub fn start_from(&self) -> Option<&StartFrom> {
                match self {
                    $(Self::$variant(_model) => None$(.or(_model.$start.recorded()))?,)+
                }
            }

            /// The same physics with so many particles at the same density; `None` if the start depends on more than the density.
            #[must_use]
            pub fn with_particles(&self, particles: NonZeroU32) -> Option<Self> {
                match self {
                    $(Self::$variant(model) => model.with_particles(particles).map(Self::$variant),)+
                }
            }

            fn start_from_mut(&mut self) -> Option<&mut StartFrom> {
                match self {
                    $(Self::$variant(_model) => None$(.or(_model.$start.recorded_mut()))?,)+
                }
            }

            /// The key of `[record]` for an interval of simulated time.
            pub(crate) fn time_key(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => stringify!($time_key),)+
                }
            }
        }

        /// Returns a commented manifest of a model to begin from: all its keys, at their defaults.
        #[must_use]
        pub fn starter(model: &str) -> Option<&'static str> {
            match model {
                $(stringify!($name) => {
                    Some(concat!(
                        include_str!(concat!(stringify!($name), "/starter.toml")),
                        include_str!("starter_tables.toml")
                    ))
                })+
                _ => None,
            }
        }

        /// Evaluates an expression for the model's own type.
        macro_rules! each {
            ($model:expr, $own:ident => $result:expr) => {
                match $model {
                    $(ModelConfig::$variant($own) => $result,)+
                }
            };
        }
    };
}

models! {
    /// Spring–dashpot discs in a box.
    dem: Dem(DemConfig) from placement every every_s [
        state discs walls legend velocity force_chains energy energy_percent contact_statistics wall_forces temperature
        contact_forces disc_forces divergence log
    ],
    /// Point particles in a circular container.
    gas: Gas(GasConfig) from placement every every_s [
        state discs walls legend velocity pressure temperature energy energy_balance collisions speeds events log
    ],
    /// Event-driven hard discs.
    packing: Packing(PackingConfig) from placement every every_time [
        state discs walls legend velocity temperature collisions pressure per_collision events energy log
    ],
    /// The Earth around the Sun.
    orbit: Orbit(OrbitConfig) from start every every_days [
        state discs walls legend velocity trail energy orbit conserved closest_approach divergence log
    ],
}

impl HasKeys for ModelConfig {
    fn keys(&mut self, keys: &mut impl Keys) {
        each!(self, model => model.keys(keys));
    }
}

impl ModelConfig {
    /// Reads the recording that the run begins with, if it begins with one.
    ///
    /// # Errors
    /// Why there is none, or none that this model can begin with.
    pub fn read_start(&mut self, recordings: Recordings<'_>) -> Result<(), String> {
        let name = self.name();
        self.start_from_mut().map_or(Ok(()), |start| start.read_by(recordings, name))
    }

    /// Maximum number of particles in a frame, those included that enter during the run.
    #[must_use]
    pub fn particles(&self) -> u64 {
        each!(self, model => model.particles())
    }

    /// Whether all particles are there from the start to the end, and may begin elsewhere.
    pub(crate) fn keeps_its_particles(&self) -> bool {
        match self {
            Self::Dem(dem) => dem.insertion.is_none() && dem.remove_below_m.is_none(),
            Self::Orbit(orbit) => orbit.bodies.is_some(),
            _ => false,
        }
    }

    /// Whether a run draws random numbers: at its start, at a wall or for discs that enter. Runs that draw none are the same for every
    /// seed.
    #[must_use]
    pub fn draws_random_numbers(&self) -> bool {
        each!(self, model => model.draws_random_numbers())
    }

    /// Simulated time at the end, in the model's unit; `None` if the run ends after a number of events.
    #[must_use]
    pub fn duration(&self) -> Option<f64> {
        each!(self, model => model.duration())
    }

    /// Number of species, which the particles have in turn.
    #[must_use]
    pub fn species(&self) -> usize {
        each!(self, model => model.species())
    }

    /// The keys of `[record]` that give an interval between frames of this model.
    pub(crate) fn intervals(&self, sound: bool) -> Vec<&'static str> {
        let own = each!(self, model => model.intervals(sound));
        [&["frames"], own, &["frames_per_decade"]].concat()
    }

    /// The channels that the model can record.
    pub(crate) fn channels(&self) -> &'static [&'static str] {
        CHANNELS.iter().find(|(name, _)| *name == self.name()).map_or(&[], |(_, own)| own)
    }

    /// Reads the table `[model]`, which holds exactly one model. `None` if no model can be identified. Without
    /// `recordings`, a start from a recording remains a name. A key of `[record]` in the model's table is named as such.
    pub(crate) fn read(
        models: &Table,
        recordings: Option<Recordings<'_>>,
        keys_of_record: Names,
        errors: &mut Errors,
    ) -> Option<Self> {
        let entry = one_model(models, errors)?;
        let mut model = Self::with_defaults(&entry.key)?;
        let path = format!("model.{}", entry.key);
        let Some(table) = entry.node.table() else {
            return refuse_type(&entry.node, &path, "a table", errors).or(Some(model));
        };
        let mut reader = Reader::new(&path, table, errors);
        reader.names_elsewhere("record", keys_of_record);
        model.keys(&mut reader);
        if let Some(Err(why)) = recordings.map(|recordings| model.read_start(recordings)) {
            let title = format!("the run cannot start from `{path}.start_from`");
            reader.refuse(&["start_from"], &title, &why);
        }
        each!(&mut model, model => model.check(&mut reader));
        reader.finish();
        Some(model)
    }
}

/// Reads a table `[gas]` as `[model.gas]`, and reports it.
pub(crate) fn accept_misplaced(root: &mut Table, errors: &mut Errors) {
    if root.get("model").is_some() {
        return;
    }
    let Some(entry) = ModelConfig::NAMES.iter().find_map(|name| root.take(name)) else { return };
    let title = format!("the table of the model is `model.{}`", entry.key);
    let label = format!("write [model.{}]", entry.key);
    errors.push(Diagnostic::new(title).at(entry.key_span, label));
    let (key_span, span) = (entry.key_span, entry.node.span);
    let node = Node { span, value: Value::Table(Table { entries: vec![entry] }) };
    root.entries.push(Entry { key: "model".to_owned(), key_span, node });
}

/// The entry of the model in `[model]`; unknown and further models are errors.
fn one_model<'a>(models: &'a Table, errors: &mut Errors) -> Option<&'a Entry> {
    let mut known: Vec<&Entry> = Vec::new();
    let is_name = |entry: &&Entry| matches!(&entry.node.value, Value::Text(name) if ModelConfig::NAMES.contains(&&**name));
    if let Some(entry) = models.entries.iter().find(is_name) {
        let title = format!("`model.{}` is not how a model is named", entry.key);
        let label = "write the model into the table's name, such as [model.gas]";
        errors.push(Diagnostic::new(title).at(entry.key_span, label));
        return None;
    }
    for entry in &models.entries {
        if ModelConfig::NAMES.contains(&&*entry.key) {
            known.push(entry);
            continue;
        }
        let label = match nearest(&entry.key, ModelConfig::NAMES) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => format!("models: {}", ModelConfig::NAMES.join(", ")),
        };
        let title = format!("unknown model `{}`", entry.key);
        errors.push(Diagnostic::new(title).at(entry.key_span, label));
    }
    if known.len() > 1 {
        let names: Vec<String> =
            known.iter().map(|entry| format!("[model.{}]", entry.key)).collect();
        let title = format!("{} cannot be used together", names.join(" and "));
        let places = known.iter().map(|entry| entry.key_span).collect();
        errors.push(Diagnostic::between(title, places, "keep one model"));
    }
    if models.entries.is_empty() {
        errors.push(no_model());
    }
    known.first().copied()
}

/// The error of a manifest without a model.
pub(crate) fn no_model() -> Diagnostic {
    let tables = ModelConfig::NAMES.map(|name| format!("[model.{name}]"));
    Diagnostic::new(format!("no model: add one of {}", tables.join(", ")))
}

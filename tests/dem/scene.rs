//! Builders of DEM configurations, and functions that run a model and read its frames.

use kinetoscope_manifest::model::{
    DemConfig, DemContactConstants, DemContactPair, DemInsertion, DemMaterial, DemWall,
    DemWallShape, DiscRadius, Dissipation, Elasticity, GivenState, ModelConfig, PeriodicSides,
    Placement, TangentialLaw, TangentialStiffness, TimeStep, UnstableTimeStep,
};
use kinetoscope_manifest::quantity::{Finite, Fraction, NonNegative, Positive};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::DemEnergy;
use kinetoscope_recording::frame::Frame;
use std::num::NonZeroU32;

pub(crate) const SEED: Seed = Seed { seed: 14, replicate: 0 };

/// One row of the recorded state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disc {
    pub(crate) position: [f64; 2],
    /// Velocity at the time of the positions.
    pub(crate) velocity: [f64; 2],
    /// Velocity that the integrator stores.
    pub(crate) step_velocity: [f64; 2],
    pub(crate) radius: f64,
    /// Angular velocity at the time of the positions, rad/s.
    pub(crate) spin: f64,
    pub(crate) id: u32,
    pub(crate) mass: f64,
}

pub(crate) fn positive(value: f64) -> Positive {
    Positive::new(value).expect("positive")
}

pub(crate) fn per_contact(steps: f64) -> TimeStep {
    TimeStep::PerContact(positive(steps))
}

pub(crate) fn spring(stiffness: f64) -> Elasticity {
    Elasticity::Spring(positive(stiffness))
}

pub(crate) fn restitution(value: f64) -> Dissipation {
    Dissipation::Restitution(Fraction::new(value).expect("in (0, 1]"))
}

pub(crate) fn damping(value: f64) -> Dissipation {
    Dissipation::Damping(NonNegative::new(value).expect("non-negative"))
}

pub(crate) fn gravity(gx: f64, gy: f64) -> [Finite; 2] {
    finite([gx, gy])
}

pub(crate) fn equal(radius: f64) -> DiscRadius {
    DiscRadius::Equal(positive(radius))
}

pub(crate) fn finite(pair: [f64; 2]) -> [Finite; 2] {
    pair.map(|value| Finite::new(value).expect("finite"))
}

/// Sets the number, positions and velocities of the discs.
pub(crate) fn given(config: DemConfig, discs: &[([f64; 2], [f64; 2])]) -> DemConfig {
    DemConfig {
        discs: NonZeroU32::new(discs.len() as u32).expect("not empty"),
        placement: Placement::Given(GivenState {
            positions_m: discs.iter().map(|disc| finite(disc.0)).collect(),
            velocities_m_per_s: discs.iter().map(|disc| finite(disc.1)).collect(),
        }),
        ..config
    }
}

/// Returns the model in its initial state.
pub(crate) fn prepared(config: &DemConfig) -> Dem {
    Dem::prepare(config, SEED, false).unwrap_or_else(|error| panic!("{error}"))
}

/// Advances the model to a step.
pub(crate) fn run_to(model: &mut Dem, step: u64) {
    if let Err(fault) = model.advance(Target::Count(step), u64::MAX) {
        panic!("{fault}");
    }
}

pub(crate) fn frame(model: &Dem) -> Frame {
    let mut frame = Frame::new();
    model.observe(&mut frame);
    frame
}

pub(crate) fn discs(model: &Dem) -> Vec<Disc> {
    frame(model)
        .state()
        .chunks_exact(10)
        .map(|row| Disc {
            position: [row[0], row[1]],
            velocity: [row[2], row[3]],
            step_velocity: [row[4], row[5]],
            radius: row[6],
            spin: row[7],
            id: row[8] as u32,
            mass: row[9],
        })
        .collect()
}

pub(crate) fn energy(model: &Dem) -> DemEnergy {
    frame(model).get().expect("every frame contains the energy")
}

/// Returns the time step, s.
pub(crate) fn time_step(model: &Dem) -> f64 {
    match model.extent() {
        kinetoscope_physics::model::Extent::Steps { step, .. } => step,
        other => panic!("{other:?}"),
    }
}

pub(crate) fn non_negative(value: f64) -> NonNegative {
    NonNegative::new(value).expect("non-negative")
}

/// Returns a straight wall at rest.
pub(crate) fn segment(from: [f64; 2], to: [f64; 2]) -> DemWall {
    DemWall {
        shape: DemWallShape::Segment { from_m: finite(from), to_m: finite(to) },
        velocity_m_per_s: finite([0.0; 2]),
        amplitude_m: finite([0.0; 2]),
        frequency_hz: non_negative(0.0),
        moves_s: None,
    }
}

/// Returns a rotating circular wall that encloses the discs.
pub(crate) fn drum(center: [f64; 2], radius: f64, spin: f64) -> DemWall {
    let spin_rad_per_s = Finite::new(spin).expect("finite");
    let shape =
        DemWallShape::Drum { center_m: finite(center), radius_m: positive(radius), spin_rad_per_s };
    DemWall { shape, ..segment([0.0; 2], [1.0; 2]) }
}

/// Returns the runs of a shipped experiment, each with its coordinates as text.
pub(crate) fn shipped(name: &str) -> Vec<(String, DemConfig, Seed)> {
    let path = format!("{}/experiments/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let experiment = kinetoscope_manifest::parse(&text, &path, &[])
        .unwrap_or_else(|diagnostics| panic!("{diagnostics}"));
    let as_text = |coordinate: &kinetoscope_manifest::Coordinate| {
        format!("{}={} ", coordinate.key, coordinate.value)
    };
    experiment
        .runs
        .iter()
        .map(|run| {
            let ModelConfig::Dem(config) = &*run.manifest.model else {
                panic!("{name} is not DEM")
            };
            let seed = Seed { seed: run.manifest.seed, replicate: run.manifest.replicate };
            (run.coordinates.iter().map(as_text).collect(), config.clone(), seed)
        })
        .collect()
}

/// Returns the first run of a shipped experiment whose coordinates contain a text.
pub(crate) fn shipped_run(name: &str, coordinates: &str) -> (DemConfig, Seed) {
    let mut runs = shipped(name).into_iter().filter(|run| run.0.contains(coordinates));
    let Some((_, config, seed)) = runs.next() else {
        panic!("{name} has no run with {coordinates}")
    };
    (config, seed)
}

/// Advances the model to a time, s.
pub(crate) fn run_to_time(model: &mut Dem, time: f64) {
    if let Err(fault) = model.advance(Target::Time(time), u64::MAX) {
        panic!("{fault}");
    }
}

pub(crate) fn material(name: &str, restitution: f64, friction: f64) -> DemMaterial {
    DemMaterial {
        name: name.to_owned(),
        fraction: positive(1.0),
        density_ratio: positive(1.0),
        constants: DemContactConstants {
            restitution: Fraction::new(restitution),
            friction: NonNegative::new(friction),
            ..DemContactConstants::default()
        },
    }
}

/// Returns named scenes that cover every feature and are in full motion within a few hundred steps.
pub(crate) fn scenes() -> Vec<(&'static str, DemConfig)> {
    let count = |discs: u32| NonZeroU32::new(discs).expect("not zero");
    // With 100 times the gravity of the Earth, a bed forms in a few hundred steps.
    let bed = DemConfig {
        discs: count(6000),
        radius_m: DiscRadius::Uniform { min: positive(4.5e-4), max: positive(5.5e-4) },
        width_m: positive(0.3),
        height_m: positive(0.036),
        gravity_m_per_s2: gravity(50.0, -981.0),
        elasticity: spring(5e6),
        time_step: per_contact(20.0),
        ..DemConfig::default()
    };
    let frictional = DemConfig {
        friction: non_negative(0.5),
        rolling_friction: non_negative(0.1),
        ..bed.clone()
    };
    let small = DemConfig { discs: count(300), width_m: positive(0.04), ..frictional.clone() };
    let mut scenes = scenes_of_materials(&bed, &small);
    scenes.extend([
        ("bed", bed.clone()),
        ("frictional bed", frictional.clone()),
        ("bed of spheres", of_spheres(bed.clone())),
        ("frictional spheres", of_spheres(small.clone())),
        ("spheres with Mindlin's springs", with_mindlin_springs(of_spheres(small.clone()))),
        (
            "periodic",
            DemConfig {
                periodic: PeriodicSides::X,
                on_unstable_time_step: UnstableTimeStep::Warn,
                ..frictional.clone()
            },
        ),
        (
            "drum",
            DemConfig {
                height_m: positive(0.04),
                walls: vec![drum([0.02, 0.02], 0.02, 100.0)],
                ..small.clone()
            },
        ),
        (
            "shaken box",
            DemConfig {
                walls: vec![DemWall {
                    amplitude_m: finite([0.0, 1e-3]),
                    frequency_hz: non_negative(500.0),
                    ..segment([0.0, 0.002], [0.04, 0.002])
                }],
                ..small.clone()
            },
        ),
        (
            "hopper",
            DemConfig {
                walls: vec![
                    segment([0.0, 0.012], [0.015, 0.006]),
                    segment([0.04, 0.012], [0.025, 0.006]),
                ],
                remove_below_m: Finite::new(0.004),
                placement_region_m: Some([finite([0.0, 0.005]), finite([0.04, 0.036])]),
                ..small.clone()
            },
        ),
    ]);
    scenes
}

/// Scenes of several materials, and of cohesion.
fn scenes_of_materials(bed: &DemConfig, small: &DemConfig) -> Vec<(&'static str, DemConfig)> {
    vec![
        ("insertion onto two materials behind a gate", insertion_scene(small.clone())),
        ("cohesive bed", DemConfig { cohesion_n: non_negative(5.0), ..bed.clone() }),
        ("cohesive materials of unequal stiffness", of_two_stiffnesses(small.clone())),
        (
            "spheres of unequal stiffness with Mindlin's springs",
            with_mindlin_springs(of_spheres(of_two_stiffnesses(small.clone()))),
        ),
        ("frictionless spheres of unequal stiffness", without_friction(of_spheres(small.clone()))),
    ]
}

/// Discs of two materials, of which one is stiffer than the walls, and the other softer and more cohesive.
fn of_two_stiffnesses(config: DemConfig) -> DemConfig {
    let mut soft = material("soft", 0.5, 0.6);
    soft.constants.stiffness_ratio = Positive::new(0.6);
    soft.constants.cohesion_n = NonNegative::new(4.0);
    let mut hard = DemMaterial { density_ratio: positive(2.0), ..material("hard", 0.9, 0.3) };
    hard.constants.stiffness_ratio = Positive::new(2.0);
    DemConfig { materials: vec![hard, soft], cohesion_n: non_negative(1.0), ..config }
}

/// The same without friction.
fn without_friction(config: DemConfig) -> DemConfig {
    let mut config = of_two_stiffnesses(config);
    config.materials.iter_mut().for_each(|one| one.constants.friction = None);
    DemConfig { friction: non_negative(0.0), rolling_friction: non_negative(0.0), ..config }
}

/// Spheres about as stiff as the discs.
fn of_spheres(config: DemConfig) -> DemConfig {
    DemConfig { elasticity: Elasticity::Hertz(positive(4e10)), ..config }
}

/// In a box that is periodic in x, with a shaken wall.
fn with_mindlin_springs(config: DemConfig) -> DemConfig {
    DemConfig {
        tangential_stiffness: TangentialStiffness::Law(TangentialLaw::Mindlin),
        periodic: PeriodicSides::X,
        walls: vec![shaken_wall()],
        ..config
    }
}

/// A short wall above the floor that is shaken.
fn shaken_wall() -> DemWall {
    DemWall {
        amplitude_m: finite([0.0, 1e-3]),
        frequency_hz: non_negative(500.0),
        ..segment([0.01, 0.002], [0.03, 0.002])
    }
}

/// Discs of two materials behind a gate that opens, with insertion from above.
fn insertion_scene(small: DemConfig) -> DemConfig {
    DemConfig {
        materials: vec![
            DemMaterial { density_ratio: positive(2.0), ..material("heavy", 0.9, 0.2) },
            material("light", 0.4, 0.6),
        ],
        contact_pairs: vec![DemContactPair {
            between: ["light".to_owned(), "wall".to_owned()],
            constants: DemContactConstants {
                friction: Some(non_negative(0.0)),
                ..DemContactConstants::default()
            },
        }],
        walls: vec![DemWall {
            velocity_m_per_s: finite([20.0, 0.0]),
            moves_s: Some([non_negative(2e-4), non_negative(1e-3)]),
            ..segment([0.02, 0.0], [0.02, 0.03])
        }],
        placement_region_m: Some([finite([0.0, 0.0]), finite([0.02, 0.03])]),
        discs: NonZeroU32::new(200).expect("not zero"),
        insertion: Some(DemInsertion {
            discs: NonZeroU32::new(100).expect("not zero"),
            discs_per_s: positive(5e4),
            from_m: finite([0.002, 0.035]),
            to_m: finite([0.038, 0.035]),
            velocity_m_per_s: finite([0.0, -5.0]),
            starts_s: non_negative(1e-4),
        }),
        ..small
    }
}

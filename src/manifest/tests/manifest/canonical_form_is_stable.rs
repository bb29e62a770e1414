//! Guarantee: the canonical manifest, from which the run key is computed, is stable.
//!
//! Setup: equal runs have equal texts; the text parses to the same run and is itself a manifest; its form is pinned.

// A test may panic.
#![allow(clippy::unwrap_used)]

use kinetoscope_manifest::model::*;
use kinetoscope_manifest::quantity::{
    BoxSide, Finite, Fraction, NonNegative, PlaybackRate, Positive, StepTolerance,
};
use kinetoscope_manifest::record::{Compression, Keep, RecordConfig, RecordInterval};
use kinetoscope_manifest::{RunManifest, parse, parse_run, run_key};
use std::num::{NonZeroU32, NonZeroU64};
use std::sync::Arc;

/// A change of this text changes every run key, so all recordings would be rerun.
const GOLDEN_DEM: &str = r#"seed = 14
replicate = 2

[model.dem]
discs = 1
mass_kg = 1e-7
radius_m = { min = 0.0004, max = 0.0006 }
width_m = 0.04
height_m = 0.05
gravity_m_per_s2 = [0.0, -9.81]
stiffness_n_per_m = 1e16
damping_n_s_per_m = 0.47402245
limit_damping = true
friction = 0.0
rolling_friction = 0.0
tangential_to_normal_stiffness = 0.2857142857142857
tangential_to_normal_damping = 0.5
periodic = "none"
walls = []
integrator = "semi-implicit-euler"
dashpot = "implicit"
time_step_s = 1e-6
on_unstable_time_step = "warn"
placement = { positions_m = [[0.01, 0.02]], velocities_m_per_s = [[0.0, -1.5]] }
duration_s = 0.30000000000000004

[record]
every_steps = 100
channels = ["state", "energy"]
playback_fps = 12.5
max_drawn_particles = 500
draw_every = 3
compression = "none"
"#;

const GOLDEN_GAS: &str = r#"seed = 18446744073709551615
replicate = 0

[model.gas]
particles = 1000
mass_kg = 1e-26
radius_m = 1.0
center_m = [0.0, 0.0]
speed_distribution = "maxwell"
temperature_k = 300.0
temperature_definition = "mean-square"
boltzmann_constant = "si-2019"
propagation = "exact"
placement = "random"
duration_s = 0.1

[record]
frames = 200
playback_fps = 25.0
max_drawn_particles = 10000
compression = "zstd"
"#;

#[test]
fn canonical_form_is_pinned() {
    let dem = RunManifest {
        seed: 14,
        replicate: 2,
        model: Arc::new(ModelConfig::Dem(DemConfig {
            discs: NonZeroU32::new(1).unwrap(),
            mass_kg: Positive::literal(1e-7),
            radius_m: DiscRadius::Uniform {
                min: Positive::literal(4e-4),
                max: Positive::literal(6e-4),
            },
            height_m: Positive::literal(0.05),
            elasticity: Elasticity::Spring(Positive::literal(1e16)),
            dissipation: Dissipation::Damping(NonNegative::literal(0.474_022_45)),
            limit_damping: true,
            integrator: DemIntegrator::SemiImplicitEuler,
            dashpot: DemDashpot::Implicit,
            time_step: TimeStep::Length(StepLength::Fixed(Positive::literal(1e-6))),
            on_unstable_time_step: UnstableTimeStep::Warn,
            placement: Placement::Given(given(1, |_| [[0.01, 0.02], [-0.0, -1.5]])),
            duration_s: Positive::literal(0.1 + 0.2),
            ..DemConfig::default()
        })),
        record: Arc::new(RecordConfig {
            interval: RecordInterval::EverySteps(NonZeroU64::new(100).unwrap()),
            channels: Some(vec!["state".to_owned(), "energy".to_owned()]),
            playback_fps: PlaybackRate::literal(12.5),
            max_drawn_particles: NonZeroU32::new(500).unwrap(),
            compression: Compression::None,
            keep: Keep::All,
            keyframe_distance: None,
            draw_every: NonZeroU64::new(3),
        }),
    };
    assert_eq!(dem.canonical(), GOLDEN_DEM);
    assert_eq!(parse_run(GOLDEN_DEM).unwrap(), dem);
    let gas = run(ModelConfig::Gas(GasConfig::default()));
    assert_eq!(RunManifest { seed: u64::MAX, ..gas }.canonical(), GOLDEN_GAS);
}

#[test]
fn canonical_text_parses_to_the_same_run() {
    let mut numbers = Numbers(7);
    for _ in 0..2000 {
        let manifest = numbers.run();
        let text = manifest.canonical();
        assert_eq!(parse_run(&text).unwrap_or_else(|errors| panic!("{errors}\n{text}")), manifest);
        let experiment = parse(&text, "embedded.toml", &[]).unwrap();
        assert_eq!(experiment.runs.len(), 1);
        assert_eq!(experiment.runs[0].manifest.canonical(), text);
    }
}

/// Keys with table values are read back as written, and omitted keys stay omitted.
#[test]
fn dem_scene_is_read_back() {
    let scene = "[model.dem]\nmaterials = [{ name = \"a \\\"b\\\"\", fraction = 2, friction = 0.5 }, { name = \"c\", density_ratio = 3, stiffness_ratio = 0.2 }]\n\
        contact_pairs = [{ between = [\"c\", \"wall\"], restitution = 0.9, rolling_friction = 0.1, cohesion_n = 0 }]\n\
        cohesion_n = 0.01\n\
        walls = [{ from_m = [0, 0.01], to_m = [0.01, 0.01], velocity_m_per_s = [1, 0], moves_s = [0.1, 0.2] }]\n\
        velocity_std_m_per_s = 0.5\ninsertion = { discs = 7, discs_per_s = 10, from_m = [0.01, 0.01], to_m = [0.02, 0.01], \
        velocity_m_per_s = [0, -1] }\n";
    let manifest = parse_run(scene).unwrap();
    let text = manifest.canonical();
    assert_eq!(parse_run(&text).unwrap(), manifest, "{text}");
    for line in [
        r#"materials = [{ name = "a \"b\"", fraction = 2.0, density_ratio = 1.0, friction = 0.5 }, { name = "c", fraction = 1.0, density_ratio = 3.0, stiffness_ratio = 0.2 }]"#,
        r#"contact_pairs = [{ between = ["c", "wall"], restitution = 0.9, rolling_friction = 0.1, cohesion_n = 0.0 }]"#,
        "cohesion_n = 0.01",
        "velocity_std_m_per_s = 0.5",
    ] {
        assert!(text.contains(line), "{text}");
    }
    assert!(
        text.contains("moves_s = [0.1, 0.2] }]") && text.contains("starts_s = 0.0 }"),
        "{text}"
    );
}

#[test]
fn notation_does_not_affect_the_canonical_form() {
    let written = "seed = 0x10\nname = \"a\"\ndescription = \"b\"\n[record]\nchannels = [\"pressure\", \"state\"]\n\
        [model]\ngas.particles = 1e3\ngas.mass_kg = 0.01e-24\ngas.center_m = [-0.0, 0]\n\
        [[checks]]\nmetric = \"pressure.measured\"\nstandard_errors = 3\n";
    let other =
        "seed = 16\n[model.gas]\n[record]\ncompression = 'zstd'\nchannels = ['state', 'pressure']";
    assert_eq!(parse_run(written).unwrap().canonical(), parse_run(other).unwrap().canonical());
}

#[test]
fn run_key_depends_only_on_content_and_versions() {
    let text = GOLDEN_GAS;
    let key = run_key(text, 1, 1);
    // Computed with Python's hashlib: sha256 of the two versions (four bytes each, little-endian) and of the text.
    assert_eq!(key.to_string(), "6c90e8bdd6fdf5a8da4ab0de71fa4aa4568a3439fba22eb057fa0c042f572df2");
    assert_eq!(key.short(), &key.to_string()[..8]);
    assert_eq!(key, run_key(text, 1, 1));
    assert_ne!(key, run_key(text, 2, 1));
    assert_ne!(key, run_key(text, 1, 2));
    assert_ne!(key, run_key(&text.replace("300.0", "300.00000000000006"), 1, 1));
    assert_ne!(key, run_key(&text.replace("replicate = 0", "replicate = 1"), 1, 1));
    assert_ne!(key, run_key(&text.replace("seed = 1", "seed = 2"), 1, 1));
}

fn run(model: ModelConfig) -> RunManifest {
    RunManifest { seed: 0, replicate: 0, model: Arc::new(model), record: Arc::default() }
}

fn given(count: usize, mut state: impl FnMut(usize) -> [[f64; 2]; 2]) -> GivenState {
    let states: Vec<[[Finite; 2]; 2]> = (0..count)
        .map(|index| state(index).map(|vector| vector.map(|x| Finite::new(x).unwrap())))
        .collect();
    GivenState {
        positions_m: states.iter().map(|[position, _]| *position).collect(),
        velocities_m_per_s: states.iter().map(|[_, velocity]| *velocity).collect(),
    }
}

/// Reproducible runs with values from their whole ranges, from a linear congruential generator (Knuth's MMIX).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 11
    }

    fn below(&mut self, bound: u64) -> u64 {
        (self.next() >> 8) % bound
    }

    /// Any finite number, including subnormal ones.
    fn finite(&mut self) -> Finite {
        loop {
            if let Some(finite) = Finite::new(f64::from_bits(self.next() << 11 ^ self.next())) {
                return finite;
            }
        }
    }

    /// A component of a vector whose length may not exceed 1e50.
    fn component(&mut self) -> Finite {
        loop {
            let finite = self.finite();
            if finite.get().abs() <= 1e49 {
                return finite;
            }
        }
    }

    fn positive(&mut self) -> Positive {
        loop {
            if let Some(positive) = Positive::new(self.finite().get().abs()) {
                return positive;
            }
        }
    }

    /// A number whose products do not overflow.
    fn size(&mut self) -> Positive {
        loop {
            let size = self.positive();
            if (1e-48..=1e48).contains(&size.get()) {
                return size;
            }
        }
    }

    fn share(&mut self) -> Fraction {
        Fraction::new((1 + self.next()) as f64 / (1_u64 << 53) as f64).unwrap()
    }

    fn count(&mut self) -> NonZeroU32 {
        NonZeroU32::new(1 + self.below(u64::from(u32::MAX)) as u32).unwrap()
    }

    fn state(&mut self) -> GivenState {
        let count = 1 + self.below(3) as usize;
        given(count, |_| {
            [[self.finite().get(), self.finite().get()], [self.finite().get(), self.finite().get()]]
        })
    }

    fn run(&mut self) -> RunManifest {
        let (model, time_key) = match self.below(4) {
            0 => (ModelConfig::Dem(self.dem()), true),
            1 => (ModelConfig::Gas(self.gas()), true),
            2 => {
                let packing = self.packing();
                let timed = matches!(packing.length, RunLength::Duration(_));
                (ModelConfig::Packing(packing), timed)
            }
            _ => (ModelConfig::Orbit(self.orbit()), true),
        };
        let interval = if time_key && self.below(2) == 0 {
            RecordInterval::EveryTime(self.positive())
        } else if self.below(4) == 0 {
            RecordInterval::Logarithmic(
                (1 + self.below(1000) as u32).try_into().unwrap(),
                (1 + self.below(15) as u32).try_into().unwrap(),
            )
        } else {
            RecordInterval::Frames(NonZeroU64::new(1 + self.next()).unwrap())
        };
        let distance = NonZeroU64::new(self.below(3) * 7);
        RunManifest {
            seed: self.next() << 11 ^ self.next(),
            replicate: self.next() as u32,
            model: Arc::new(model),
            record: Arc::new(RecordConfig {
                keep: if distance.is_some() { Keep::Keyframes } else { Keep::All },
                keyframe_distance: distance,
                draw_every: distance,
                interval,
                channels: [None, Some(vec![]), Some(vec!["state".to_owned(), "log".to_owned()])]
                    [self.below(3) as usize]
                    .clone(),
                playback_fps: PlaybackRate::new(50.0 * self.share().get()).unwrap(),
                max_drawn_particles: NonZeroU32::new(1 + self.below(20_000) as u32).unwrap(),
                compression: [
                    Compression::Zstd,
                    Compression::Zstd3,
                    Compression::Lz4,
                    Compression::None,
                ][self.below(4) as usize],
            }),
        }
    }

    fn dem(&mut self) -> DemConfig {
        let placement = match self.below(3) {
            0 => Placement::Random,
            1 => Placement::Lattice,
            _ => Placement::Given(self.state()),
        };
        let discs = match &placement {
            Placement::Given(state) => NonZeroU32::new(state.positions_m.len() as u32).unwrap(),
            _ => self.count(),
        };
        let (elasticity, dissipation) = match self.below(3) {
            0 => (
                Elasticity::Spring(self.positive()),
                Dissipation::Damping(NonNegative::literal(self.positive().get())),
            ),
            1 => (Elasticity::Spring(self.positive()), Dissipation::Restitution(self.share())),
            _ => (Elasticity::Hertz(self.positive()), Dissipation::Restitution(self.share())),
        };
        DemConfig {
            discs,
            mass_kg: self.positive(),
            gravity_m_per_s2: [self.finite(), self.finite()],
            elasticity,
            dissipation,
            integrator: [DemIntegrator::SemiImplicitEuler, DemIntegrator::VelocityVerlet]
                [self.below(2) as usize],
            time_step: TimeStep::PerContact(self.positive()),
            placement,
            duration_s: self.positive(),
            ..DemConfig::default()
        }
    }

    fn gas(&mut self) -> GasConfig {
        let placement = if self.below(2) == 0 {
            GasPlacement::Random
        } else {
            GasPlacement::Given(self.state())
        };
        let temperature = SpeedScale::Temperature(NonNegative::literal(self.size().get()));
        let radius_m = self.size();
        let (particles, speed_scale) = match (&placement, self.below(2)) {
            (GasPlacement::Given(state), other) => (
                NonZeroU32::new(state.positions_m.len() as u32).unwrap(),
                if other == 0 { SpeedScale::Given } else { temperature },
            ),
            (_, 0) => (self.count(), temperature),
            _ => (self.count(), SpeedScale::MaxSpeed(NonNegative::literal(0.0))),
        };
        let time_step_s = Positive::literal(1e-3);
        let drawn = placement == GasPlacement::Random && self.below(2) == 0;
        let listed = drawn && !matches!(speed_scale, SpeedScale::MaxSpeed(_));
        let speeds_m_per_s = if listed { vec![NonNegative::literal(0.5); 3] } else { Vec::new() };
        GasConfig {
            particles,
            speeds_m_per_s,
            // The speeds of Maxwell's distribution have no maximum.
            speed_distribution: SpeedDistribution::Uniform,
            radius_m,
            // Up to 1e9 radii from the origin.
            center_m: [-1e8, 1e8]
                .map(|most| Finite::new(most * self.share().get() * radius_m.get()).unwrap()),
            speed_scale,
            propagation: [
                Propagation::Exact,
                Propagation::TimeStepped { time_step_s },
                Propagation::AsPrinted { time_step_s },
            ][self.below(3) as usize],
            boltzmann_constant: BoltzmannConstant::Si2019,
            temperature_definition: TemperatureDefinition::MeanSquare,
            placement,
            ..GasConfig::default()
        }
    }

    fn packing(&mut self) -> PackingConfig {
        let placement = match self.below(2) {
            0 => PackingPlacement::Lattice,
            _ => {
                let GivenState { positions_m: positions, velocities_m_per_s: velocities } =
                    self.state();
                PackingPlacement::Given(PackingState { positions, velocities })
            }
        };
        PackingConfig {
            discs: match &placement {
                PackingPlacement::Given(state) => {
                    NonZeroU32::new(state.positions.len() as u32).unwrap()
                }
                _ => self.count(),
            },
            width: BoxSide::new(10.0 + 1e4 * self.share().get()).unwrap(),
            restitution: self.share(),
            initial_velocities: InitialVelocities::VarianceOneOverN,
            length: if self.below(2) == 0 {
                RunLength::EventsPerDisc(self.count())
            } else {
                RunLength::Duration(self.positive())
            },
            placement,
            ..PackingConfig::default()
        }
    }

    fn orbit_body(&mut self) -> OrbitBody {
        OrbitBody {
            gm_au3_per_day2: NonNegative::new(self.share().get()).unwrap(),
            state: self.orbit_state(),
        }
    }

    /// Elements are relative to the first body, which has none.
    fn central_body(&mut self) -> OrbitBody {
        OrbitBody {
            gm_au3_per_day2: NonNegative::new(self.share().get()).unwrap(),
            state: OrbitState::Vectors {
                position_au: [self.component(), self.component(), self.component()],
                velocity_au_per_day: [self.component(), self.component(), self.component()],
            },
        }
    }

    fn orbit_state(&mut self) -> OrbitState {
        if self.below(2) == 0 {
            return OrbitState::Vectors {
                // At right angles: a straight line through the Sun is rejected.
                position_au: [
                    Finite::literal(0.0),
                    Finite::new(self.share().get()).unwrap(),
                    Finite::literal(0.0),
                ],
                velocity_au_per_day: [self.component(), Finite::literal(0.0), self.component()],
            };
        }
        OrbitState::Elements {
            semi_major_axis_au: Finite::new(1e3 * self.share().get()).unwrap(),
            eccentricity: Finite::new(0.5 * self.share().get()).unwrap(),
            inclination_rad: Finite::new(self.share().get()).unwrap(),
            longitude_of_ascending_node_rad: self.finite(),
            argument_of_perihelion_rad: self.finite(),
            true_anomaly_rad: None,
            mean_anomaly_rad: (self.below(2) == 0)
                .then(|| Finite::new(100.0 * self.share().get()).unwrap()),
        }
    }

    fn orbit(&mut self) -> OrbitConfig {
        if self.below(3) == 0 {
            return OrbitConfig {
                bodies: Some(vec![self.central_body(), self.orbit_body(), self.orbit_body()]),
                ..OrbitConfig::default()
            };
        }
        OrbitConfig {
            start: match self.below(3) {
                0 => OrbitStart::Barycentric,
                1 => OrbitStart::Heliocentric,
                _ => OrbitStart::Given(self.orbit_state()),
            },
            integrator: [
                OrbitIntegrator::Rk4,
                OrbitIntegrator::Yoshida4,
                OrbitIntegrator::Kepler,
                OrbitIntegrator::VelocityVerlet,
                OrbitIntegrator::Dop853,
            ][self.below(5) as usize],
            summation: [OrbitSummation::Plain, OrbitSummation::Compensated][self.below(2) as usize],
            tolerance: StepTolerance::new(1e-3 * self.share().get() + 1e-15).unwrap(),
            time_step_days: Positive::new(365.0 * self.share().get()).unwrap(),
            ..OrbitConfig::default()
        }
    }
}

//! Event-driven hard discs.
//!
//! Equal discs of mass 1 fly freely in a box until two of them touch or one touches a wall. In reading order: the laws of
//! flight and collision (`motion`), the start (`start`, `lattice`, `compression`), what can happen (`events`), what comes next
//! (`engine` with its `collisions`, `prediction` and `prefetch`, `scan`, `cells`, `event_queue`, `clock`), and what is measured (`observables`).
//!
//! The mean velocity of a random start is removed (but for a single disc), so that T at the start is 2 (1 - 1/n) times the
//! variance of a component. Walls do not keep the momentum: it fluctuates about zero later on.

mod cells;
mod clock;
mod compression;
mod disc;
mod domain;
mod engine;
mod event_queue;
mod events;
mod inelastic_collapse;
mod lattice;
mod motion;
mod observables;
mod scan;
#[cfg(target_arch = "x86_64")]
mod scan_simd;
mod start;

use self::domain::{Domain, ElasticThreshold};
use self::engine::{Collision, Engine, StepOutcome};
use self::observables::{CollisionSeries, CollisionStatistics, VelocityMoments};

use crate::model::{Extent, Fault, Model, Progress, Refusal, Target};
use crate::random::{Seed, Stream};
use crate::simd::instruction_set::{self, WideKernel};
use kinetoscope_manifest::model::{
    Boundary, CollapseGuard, PackingConfig, PackingPlacement, RunLength,
};
use kinetoscope_recording::channels::{
    ChannelDeclaration, PackingCollisions, PackingPressure, PackingTemperature, PerCollision,
};
use kinetoscope_recording::frame::{Frame, Level, StateColumn};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};
use serde::{Deserialize, Serialize};

/// More arrows than this hide the discs.
const MOST_ARROWS: usize = 200;

/// The color bar ends at this multiple of the root mean square speed of the start.
const SPEED_RANGE: f64 = 2.5;

/// Event-driven hard discs in a box: see [`PackingConfig`] for the physics that can be chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Packing {
    engine: Engine,
    statistics: CollisionStatistics,
    series: Option<CollisionSeries>,
    extent: RunExtent,
    /// Time of the target that was reached last, or of the last collision since.
    time: f64,
    /// Whether the next call of `advance` opens a new window: as at the start, whose frame is taken first.
    at_target: bool,
    /// How the start came about: logged in the frame of the start, then dropped.
    start_description: Option<String>,
    speed_range_top: f64,
}

/// The run's length as it is stored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum RunExtent {
    Events(u64),
    Time(f64),
}

impl Model for Packing {
    type Config = PackingConfig;
    const NAME: &'static str = "packing";
    const PHYSICS_VERSION: u32 = 2;
    const TIME_UNIT: &'static str = "";
    const STATE_COLUMNS: &'static [StateColumn] = &[
        StateColumn { name: "x", unit: "" },
        StateColumn { name: "y", unit: "" },
        StateColumn { name: "vx", unit: "" },
        StateColumn { name: "vy", unit: "" },
        StateColumn { name: "radius", unit: "" },
    ];
    const CHANNELS: &'static [ChannelDeclaration] = &[
        ChannelDeclaration::of::<PackingTemperature>(),
        ChannelDeclaration::of::<PackingCollisions>(),
        ChannelDeclaration::of::<PackingPressure>(),
        ChannelDeclaration::opt_in::<PerCollision>(),
    ];

    fn prepare(config: &PackingConfig, seed: Seed, per_collision: bool) -> Result<Self, Refusal> {
        let start = start::start(config, seed)?;
        let moments = VelocityMoments::of(start.velocities.iter().copied());
        let domain = Domain {
            sides: [config.width.get(), config.height.get()],
            has_walls: config.boundary == Boundary::Walls,
            max_radius: start.max_radius,
            restitution: config.restitution.get(),
            elastic_threshold: match config.collapse_guard {
                CollapseGuard::Off => ElasticThreshold::Off,
                CollapseGuard::ContactTime(time) => ElasticThreshold::ContactTime(time.get()),
                CollapseGuard::CutoffVelocity(velocity) => {
                    ElasticThreshold::CutoffVelocity(velocity.get())
                }
            },
            wall_noise_rad: config.wall_noise_variance_rad2.get().sqrt(),
        };
        let rms_speed = match &config.placement {
            PackingPlacement::Given(_) | PackingPlacement::Recorded(_) => {
                moments.temperature().sqrt()
            }
            PackingPlacement::Random | PackingPlacement::Lattice | PackingPlacement::Compressed => {
                2.0_f64.sqrt() * start::velocity_std(config)
            }
        };
        let mut series = per_collision.then(CollisionSeries::default);
        if let Some(series) = &mut series {
            series.push(0, 0.0, &moments);
        }
        Ok(Self {
            engine: Engine::new(
                domain,
                start.positions,
                start.velocities,
                start.radii,
                moments.temperature(),
                seed.stream(Stream::WallNoise),
            ),
            statistics: CollisionStatistics::new(moments),
            series,
            extent: match config.length {
                RunLength::EventsPerDisc(events) => {
                    RunExtent::Events(u64::from(events.get()) * u64::from(config.discs.get()))
                }
                RunLength::Duration(duration) => RunExtent::Time(duration.get()),
            },
            time: 0.0,
            at_target: true,
            start_description: Some(start.description),
            speed_range_top: if rms_speed > 0.0 { SPEED_RANGE * rms_speed } else { 1.0 },
        })
    }

    fn extent(&self) -> Extent {
        match self.extent {
            RunExtent::Events(events) => Extent::Events(events),
            RunExtent::Time(duration) => Extent::Time(duration),
        }
    }

    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, Fault> {
        instruction_set::run(Advance { packing: self, target, at_most })
    }

    fn count(&self) -> u64 {
        self.statistics.events()
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn observe(&self, frame: &mut Frame) {
        let domain = self.engine.domain();
        for (disc, (position, velocity)) in self.engine.positions_and_velocities().enumerate() {
            let radius = self.engine.radius(disc);
            frame.push_state(&[position[0], position[1], velocity[0], velocity[1], radius]);
        }
        let moments = VelocityMoments::of(self.engine.velocities());
        let wait = self.engine.time_since_last_collision();
        frame.push(&self.statistics.temperature(&moments));
        frame.push(&self.statistics.collisions(self.time));
        frame.push(&self.statistics.pressure(domain, self.time, wait));
        if let Some(series) = &self.series {
            frame.push(&series.message());
        }
        if let Some(description) = &self.start_description {
            frame.log(Level::Info, description.as_str());
        }
    }

    fn scenery(&self) -> Scenery {
        let half = self.engine.domain().sides.map(|side| 0.5 * side);
        let (min, max) = (half.map(|half| -half), half);
        Scenery {
            walls: vec![Wall::Rectangle { min, max }],
            view: [min, max],
            drawn_radius: DrawnRadius::Column,
            speed_range_top: self.speed_range_top,
            speed_unit: "",
            arrows: self.engine.count() <= MOST_ARROWS,
            force_range_top: None,
            trail: false,
        }
    }
}

impl Packing {
    fn open_window(&mut self) {
        if self.at_target
            && let Some(series) = &mut self.series
        {
            series.clear();
        }
        self.at_target = false;
        self.start_description = None;
    }

    /// One event toward the target; returns whether it was reached before.
    #[inline(always)]
    fn step<const HAS_AVX512: bool>(&mut self, target: Target) -> Result<bool, Fault> {
        let until = match target {
            Target::Count(events) if self.statistics.events() >= events => {
                self.at_target = true;
                return Ok(true);
            }
            Target::Count(_) => f64::INFINITY,
            Target::Time(time) => time,
        };
        match self.engine.step::<HAS_AVX512>(until)? {
            StepOutcome::Collision(collision) => self.note(&collision),
            StepOutcome::Bookkeeping => {}
            StepOutcome::NoEvent => return self.arrive(target).map(|()| true),
        }
        Ok(false)
    }

    /// Nothing happens any more up to the target: time goes on to it.
    #[inline(never)]
    fn arrive(&mut self, target: Target) -> Result<(), Fault> {
        match target {
            Target::Count(events) => {
                return Err(Fault(format!(
                    "event {events} never comes: after {} events at time {} nothing moves toward anything; \
                     give the discs velocities, or set a duration",
                    self.statistics.events(),
                    self.time
                )));
            }
            Target::Time(time) => {
                self.engine.advance_clock_to(time);
                self.time = time;
            }
        }
        self.at_target = true;
        Ok(())
    }

    /// Takes note of a collision.
    #[inline(always)]
    fn note(&mut self, collision: &Collision) {
        self.time = self.engine.time();
        self.statistics.count(collision);
        // Summing anew costs n: every n collisions it costs nothing that grows.
        if self.statistics.events().is_multiple_of(self.engine.count() as u64) {
            self.renew_moments();
        }
        if let Some(series) = &mut self.series {
            series.push(self.statistics.events(), self.time, self.statistics.moments());
        }
    }

    #[inline(never)]
    fn renew_moments(&mut self) {
        self.statistics.renew_moments(VelocityMoments::of(self.engine.velocities()));
        self.engine.set_mean_square_speed(self.statistics.moments().temperature());
    }
}

/// The work of [`Packing::advance`].
struct Advance<'a> {
    packing: &'a mut Packing,
    target: Target,
    at_most: u64,
}

impl WideKernel for Advance<'_> {
    type Output = Result<Progress, Fault>;

    #[inline(always)]
    fn run<const HAS_AVX512: bool>(self) -> Self::Output {
        let Self { packing, target, at_most } = self;
        packing.open_window();
        for _ in 0..at_most.max(1) {
            if packing.step::<HAS_AVX512>(target)? {
                return Ok(Progress::Reached);
            }
        }
        Ok(Progress::Working)
    }
}

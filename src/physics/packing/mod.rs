//! Event-driven hard discs.
//!
//! Equal discs of mass 1 fly freely in a box until two of them touch or one touches a wall. In reading order: the laws of
//! flight and collision (`motion`), the start (`start`, `lattice`, `compression`), what can happen (`events`), what comes next
//! (`engine` with its `collisions`, `prediction` and `foresight`, `scan`, `cells`, `calendar`, `clock`), and what is measured (`observables`).
//!
//! The mean velocity of a random start is removed (but for a single disc), so that T at the start is 2 (1 - 1/n) times the
//! variance of a component. Walls do not keep the momentum: it fluctuates about zero later on.

mod arena;
mod calendar;
mod cells;
mod clock;
mod compression;
mod disc;
mod engine;
mod events;
mod lattice;
mod motion;
mod observables;
mod processor;
mod rapid;
mod scan;
mod start;

use self::arena::{Arena, Guard};
use self::engine::{Collision, Engine, Step};
use self::observables::{Moments, Series, Tallies};
use self::processor::Kernel;
use crate::model::{Extent, Model, ModelKind, Progress, SetupError, SimulationFault, Target};
use crate::random::{Seed, Stream};
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
    tallies: Tallies,
    series: Option<Series>,
    extent: RunExtent,
    /// Time of the target that was reached last, or of the last collision since.
    time: f64,
    /// Whether the next call of `advance` opens a new window: as at the start, whose frame is taken first.
    at_target: bool,
    /// How the start came about: logged in the frame of the start, then dropped.
    account_of_start: Option<String>,
    speed_range_top: f64,
}

/// The run's length as it is stored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum RunExtent {
    Events(u64),
    Time(f64),
}

const KIND: ModelKind = ModelKind {
    name: "packing",
    physics_version: 2,
    time_unit: "",
    state_columns: &[
        StateColumn { name: "x", unit: "" },
        StateColumn { name: "y", unit: "" },
        StateColumn { name: "vx", unit: "" },
        StateColumn { name: "vy", unit: "" },
        StateColumn { name: "radius", unit: "" },
    ],
    channels: &[
        ChannelDeclaration::of::<PackingTemperature>(),
        ChannelDeclaration::of::<PackingCollisions>(),
        ChannelDeclaration::of::<PackingPressure>(),
        ChannelDeclaration::opt_in::<PerCollision>(),
    ],
};

impl Model for Packing {
    type Config = PackingConfig;

    fn kind() -> &'static ModelKind {
        &KIND
    }

    fn prepare(
        config: &PackingConfig,
        seed: Seed,
        per_collision: bool,
    ) -> Result<Self, SetupError> {
        let start = start::start(config, seed)?;
        let moments = Moments::of(start.velocities.iter().copied());
        let arena = Arena {
            sides: [config.width.get(), config.height.get()],
            has_walls: config.boundary == Boundary::Walls,
            largest_radius: start.largest_radius,
            restitution: config.restitution.get(),
            guard: match config.collapse_guard {
                CollapseGuard::Off => Guard::Off,
                CollapseGuard::ContactTime(time) => Guard::ContactTime(time.get()),
                CollapseGuard::CutoffVelocity(velocity) => Guard::CutoffVelocity(velocity.get()),
            },
            wall_noise_rad: config.wall_noise_variance_rad2.get().sqrt(),
        };
        let rms_speed = match &config.placement {
            PackingPlacement::Given(_) | PackingPlacement::Recorded(_) => {
                moments.temperature().sqrt()
            }
            PackingPlacement::Random | PackingPlacement::Lattice | PackingPlacement::Compressed => {
                2.0_f64.sqrt() * start::velocity_deviation(config)
            }
        };
        let mut series = per_collision.then(Series::default);
        if let Some(series) = &mut series {
            series.push(0, 0.0, &moments);
        }
        Ok(Self {
            engine: Engine::new(
                arena,
                start.positions,
                start.velocities,
                start.radii,
                moments.temperature(),
                seed.stream(Stream::WallNoise),
            ),
            tallies: Tallies::new(moments),
            series,
            extent: match config.length {
                RunLength::EventsPerDisc(events) => {
                    RunExtent::Events(u64::from(events.get()) * u64::from(config.discs.get()))
                }
                RunLength::Duration(duration) => RunExtent::Time(duration.get()),
            },
            time: 0.0,
            at_target: true,
            account_of_start: Some(start.account),
            speed_range_top: if rms_speed > 0.0 { SPEED_RANGE * rms_speed } else { 1.0 },
        })
    }

    fn channels(&self) -> &'static [ChannelDeclaration] {
        KIND.channels
    }

    fn extent(&self) -> Extent {
        match self.extent {
            RunExtent::Events(events) => Extent::Events(events),
            RunExtent::Time(duration) => Extent::Time(duration),
        }
    }

    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, SimulationFault> {
        processor::run(Advance { packing: self, target, at_most })
    }

    fn count(&self) -> u64 {
        self.tallies.events()
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn observe(&self, frame: &mut Frame) {
        let arena = self.engine.arena();
        for (disc, (position, velocity)) in self.engine.look().enumerate() {
            let radius = self.engine.radius(disc);
            frame.push_state(&[position[0], position[1], velocity[0], velocity[1], radius]);
        }
        let moments = Moments::of(self.engine.velocities());
        let wait = self.engine.time_since_collision();
        frame.push(&self.tallies.temperature(&moments));
        frame.push(&self.tallies.collisions(self.time));
        frame.push(&self.tallies.pressure(arena, self.time, wait));
        if let Some(series) = &self.series {
            frame.push(&series.message());
        }
        if let Some(account) = &self.account_of_start {
            frame.log(Level::Info, account.as_str());
        }
    }

    fn scenery(&self) -> Scenery {
        let half = self.engine.arena().sides.map(|side| 0.5 * side);
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
        self.account_of_start = None;
    }

    /// One event toward the target; returns whether it was reached before.
    #[inline(always)]
    fn step<const WIDE: bool>(&mut self, target: Target) -> Result<bool, SimulationFault> {
        let until = match target {
            Target::Count(events) if self.tallies.events() >= events => {
                self.at_target = true;
                return Ok(true);
            }
            Target::Count(_) => f64::INFINITY,
            Target::Time(time) => time,
        };
        match self.engine.step::<WIDE>(until)? {
            Step::Collision(collision) => self.note(&collision),
            Step::Other => {}
            Step::Quiet => return self.arrive(target).map(|()| true),
        }
        Ok(false)
    }

    /// Nothing happens any more up to the target: time goes on to it.
    #[inline(never)]
    fn arrive(&mut self, target: Target) -> Result<(), SimulationFault> {
        match target {
            Target::Count(events) => {
                return Err(SimulationFault(format!(
                    "event {events} never comes: after {} events at time {} nothing moves toward anything; \
                     give the discs velocities, or set a duration",
                    self.tallies.events(),
                    self.time
                )));
            }
            Target::Time(time) => {
                self.engine.wait_until(time);
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
        self.tallies.count(collision);
        // Summing anew costs n: every n collisions it costs nothing that grows.
        if self.tallies.events().is_multiple_of(self.engine.count() as u64) {
            self.renew_moments();
        }
        if let Some(series) = &mut self.series {
            series.push(self.tallies.events(), self.time, self.tallies.moments());
        }
    }

    #[inline(never)]
    fn renew_moments(&mut self) {
        self.tallies.renew_moments(Moments::of(self.engine.velocities()));
        self.engine.set_mean_square_speed(self.tallies.moments().temperature());
    }
}

/// The work of [`Packing::advance`].
struct Advance<'a> {
    packing: &'a mut Packing,
    target: Target,
    at_most: u64,
}

impl Kernel for Advance<'_> {
    type Output = Result<Progress, SimulationFault>;

    #[inline(always)]
    fn run<const WIDE: bool>(self) -> Self::Output {
        let Self { packing, target, at_most } = self;
        packing.open_window();
        for _ in 0..at_most.max(1) {
            if packing.step::<WIDE>(target)? {
                return Ok(Progress::Reached);
            }
        }
        Ok(Progress::Working)
    }
}

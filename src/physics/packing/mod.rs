//! Event-driven hard discs: discs of mass 1 fly freely or fall in a box and collide with each other and with the walls.
//!
//! Start reading here: `motion` has the rules of motion, and `Engine::step` executes one event. The
//! other files, in reading order:
//!
//! - data: `domain` (box and collision parameters), `shaking`, `obstacles`, `disc`, `events`, `collision`, `contact`, `growth`, `clock`;
//! - start: `start`, `random_start`, `lattice`, `compression`;
//! - end: `rest`;
//! - algorithms: `engine` with `prediction`, `collisions`, `obstacles`, `crossings`, `growth` and `prefetch`; the contact scan `scan` and
//!   `scan_lanes`, and `falling_contact`; `cells`, `near_obstacles`; `event_queue`; `inelastic_collapse`;
//! - measurement: `observables`, `velocity_moments`, and in gravity `falling`.
//!
//! Invariant: the trajectory depends on the manifest and the seed only, not on observation, checkpoints, the step budget or
//! the instruction set.
//!
//! The velocities of a random start follow their distribution: the expectation of the initial `<v²>` is twice the variance of a
//! component. With `remove_mean_velocity`, it is 2 (1 − 1/n) times the variance. Walls do not conserve momentum.

mod cells;
mod clock;
mod collision;
mod compression;
mod contact;
mod disc;
mod domain;
mod engine;
mod event_queue;
mod events;
mod falling;
mod falling_contact;
mod growth;
mod inelastic_collapse;
mod lattice;
mod motion;
mod near_obstacles;
mod observables;
mod obstacles;
mod random_start;
mod rest;
mod scan;
#[cfg(target_arch = "x86_64")]
mod scan_lanes;
mod shaking;
mod start;
mod velocity_moments;

use self::collision::{Collision, CollisionPartner};
use self::domain::{Domain, Floor};
use self::engine::{Engine, StepOutcome};
use self::falling::Falling;
use self::observables::{CollisionSeries, CollisionStatistics};
use self::velocity_moments::VelocityMoments;
use crate::event_record::EventRecord;
use crate::model::{
    Extent, Model, ModelKind, Proceed, Progress, SetupError, SimulationFault, Target,
};
use crate::random::{Seed, Stream};
use crate::simd::registers::{self, InstructionSet, Kernel};
use kinetoscope_manifest::model::{PackingConfig, PackingPlacement, RunLength, drawn_obstacles};
use kinetoscope_recording::channels::{
    ChannelDeclaration, PackingCollisions, PackingEnergy, PackingEvents, PackingPressure,
    PackingTemperature, PerCollision,
};
use kinetoscope_recording::frame::{Frame, Level, StateColumn};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};
use serde::{Deserialize, Serialize};

/// Numbers in the widest registers of the engine: wider ones are not faster (`benches/packing_speed.rs`).
const WIDEST: usize = 4;

/// Largest number of discs that are drawn with velocity arrows; more arrows would hide the discs.
const MAX_ARROWS: usize = 200;

/// Upper end of the color bar, in multiples of the initial root mean square speed.
const SPEED_RANGE: f64 = 2.5;

/// Event-driven hard discs in a box; [`PackingConfig`] lists the physics that can be chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Packing {
    engine: Engine,
    statistics: CollisionStatistics,
    /// What is recorded of single collisions, if it is.
    series: Option<(CollisionSeries, EventRecord)>,
    length: Extent,
    /// Time of the last target, or of the last collision after it.
    time: f64,
    /// Whether the next call of `advance` opens a new window. It does so at first, because the start has a frame.
    is_at_target: bool,
    /// How the discs were placed: logged in the first frame, then dropped.
    start_description: Option<String>,
    speed_range_top: f64,
}

const KIND: ModelKind = ModelKind {
    name: "packing",
    physics_version: 3,
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
        ChannelDeclaration::opt_in::<PackingEvents>(),
        ChannelDeclaration::of::<PackingEnergy>(),
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
        Self::prepare_while(config, seed, per_collision, &|_| true)
    }

    fn prepare_while(
        config: &PackingConfig,
        seed: Seed,
        per_collision: bool,
        proceed: Proceed<'_>,
    ) -> Result<Self, SetupError> {
        let start = start::start(config, seed, proceed)?;
        let moments = VelocityMoments::of(start.velocities.iter().copied());
        let mut series = per_collision.then(<(CollisionSeries, EventRecord)>::default);
        if let Some((series, _)) = &mut series {
            series.push(0, 0.0, &moments);
        }
        let gravity = config.gravity.get();
        let discs = start.positions.iter().zip(&start.velocities);
        let falling = (gravity > 0.0).then(|| {
            let discs = discs.map(|(position, velocity)| [*position, *velocity]);
            Falling::new(gravity, config.height.get(), discs)
        });
        let rms_speed = initial_rms_speed(config, &moments, falling.as_ref());
        Ok(Self {
            engine: Engine::new(
                Domain::new(config, start.max_radius),
                start.positions,
                start.velocities,
                start.radii,
                moments.mean_square_speed(),
                seed.stream(match config.floor_temperature {
                    Some(_) => Stream::ThermalWall,
                    None => Stream::WallNoise,
                }),
            ),
            statistics: CollisionStatistics::new(moments, falling),
            series,
            length: run_length(config),
            time: 0.0,
            is_at_target: true,
            start_description: Some(start.description),
            speed_range_top: if rms_speed > 0.0 { SPEED_RANGE * rms_speed } else { 1.0 },
        })
    }

    fn is_valid_for(&self, config: &PackingConfig) -> bool {
        let max_radius = self.engine.domain().max_radius;
        let moments = VelocityMoments::of(self.engine.velocities());
        self.engine.count() == config.discs.get() as usize
            && *self.engine.domain() == Domain::new(config, max_radius)
            && self.length == run_length(config)
            && self.time.is_finite()
            && self.time >= 0.0
            && self.speed_range_top.is_finite()
            && self.statistics.falling().is_some() == (config.gravity.get() > 0.0)
            && self.statistics.is_valid_for(
                &moments,
                self.engine.time_since_last_collision(),
                self.speed_range_top,
                self.engine.domain(),
            )
            && self.series.as_ref().is_none_or(|(series, events)| {
                series.is_valid() && events.is_valid(self.engine.count())
            })
    }

    fn channels(&self) -> &'static [ChannelDeclaration] {
        // The last one is the energy in gravity.
        let without_gravity = KIND.channels.len() - 1;
        if self.statistics.falling().is_some() {
            KIND.channels
        } else {
            &KIND.channels[..without_gravity]
        }
    }

    fn extent(&self) -> Extent {
        self.length
    }

    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, SimulationFault> {
        self.advance_at_width(target, at_most, WIDEST)
    }

    fn count(&self) -> u64 {
        self.statistics.collision_count()
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn observe(&self, frame: &mut Frame) {
        let domain = self.engine.domain();
        let discs = self.engine.positions_and_velocities();
        for (disc, (position, velocity)) in discs.enumerate() {
            let radius = self.engine.radius(disc);
            frame.push_state(&[position[0], position[1], velocity[0], velocity[1], radius]);
        }
        let moments = VelocityMoments::of(self.engine.velocities());
        let time_since_last = self.engine.time_since_last_collision();
        frame.push(&self.statistics.temperature(&moments, time_since_last));
        frame.push(&self.statistics.collisions(self.time));
        frame.push(&self.statistics.pressure(domain, self.time, time_since_last));
        if let Some((series, events)) = &self.series {
            frame.push(&series.message());
            frame.push(&events_message(events));
        }
        if let Some(falling) = self.statistics.falling() {
            let discs = self.engine.positions_and_velocities();
            frame.push(&falling.message(discs.map(|(position, velocity)| [position, velocity])));
        }
        if let Some(description) = &self.start_description {
            frame.log(Level::Info, description.as_str());
        }
    }

    fn scenery(&self) -> Scenery {
        let domain = self.engine.domain();
        let half = domain.sides.map(|side| 0.5 * side);
        let (min, max) = (half.map(|half| -half), half);
        let radius = domain.obstacles.radius;
        let centers = &domain.obstacles.centers;
        let drawn = drawn_obstacles(centers, radius, domain.sides, !domain.has_walls);
        let circles = drawn.into_iter().map(|center| Wall::Circle { center, radius });
        Scenery {
            walls: [Wall::Rectangle { min, max }].into_iter().chain(circles).collect(),
            view: [min, max],
            drawn_radius: DrawnRadius::Column { min: self.min_radius() },
            speed_range_top: self.speed_range_top,
            speed_unit: "",
            arrows: self.engine.count() <= MAX_ARROWS,
            force_range_top: None,
            trail: false,
            unused_fields: Vec::new(),
            names: Vec::new(),
            central_particle: None,
        }
    }
}

fn run_length(config: &PackingConfig) -> Extent {
    match config.length {
        RunLength::EventsPerDisc(events) => {
            Extent::Events(u64::from(events.get()) * u64::from(config.discs.get()))
        }
        RunLength::Duration(duration) => Extent::Time(duration.get()),
    }
}

/// The initial root mean square speed; for random velocities, that of their distribution. Discs that fall, or a floor, may be faster.
fn initial_rms_speed(
    config: &PackingConfig,
    moments: &VelocityMoments,
    falling: Option<&Falling>,
) -> f64 {
    let at_start = match &config.placement {
        PackingPlacement::Given(_) | PackingPlacement::Recorded(_) => {
            moments.mean_square_speed().sqrt()
        }
        PackingPlacement::Random | PackingPlacement::Lattice | PackingPlacement::Compressed => {
            2.0_f64.sqrt() * random_start::velocity_std(config)
        }
    };
    // In gravity, discs that fill the lower part of the box have as much potential as kinetic energy.
    let of_energy = falling.map_or(0.0, |falling| falling.energy_at_start() / moments.count);
    let of_floor = match Floor::of(config) {
        Floor::AtRest => 0.0,
        Floor::Thermal { speed } => 2.0_f64.sqrt() * speed,
        Floor::Shaken(shaking) => shaking.greatest_speed(),
    };
    [of_energy.sqrt(), of_floor]
        .into_iter()
        .fold(at_start, |most, next| if next > most { next } else { most })
}

impl Packing {
    /// Advances as [`Model::advance`] does, in registers of at most `width` numbers: 4 is AVX2, 1 plain x86-64. Every width gives
    /// the same bits; benchmarks and tests compare them.
    ///
    /// # Errors
    /// Those of [`Model::advance`].
    pub fn advance_at_width(
        &mut self,
        target: Target,
        at_most: u64,
        width: usize,
    ) -> Result<Progress, SimulationFault> {
        registers::run(AdvanceKernel { packing: self, target, at_most }, Ord::min(width, WIDEST))
    }

    fn min_radius(&self) -> f64 {
        let radii = (0..self.engine.count()).map(|disc| self.engine.radius(disc));
        radii.fold(f64::INFINITY, |least, next| if next < least { next } else { least })
    }

    fn open_window(&mut self) {
        if self.is_at_target
            && let Some((series, events)) = &mut self.series
        {
            series.clear();
            events.clear();
        }
        self.is_at_target = false;
        self.start_description = None;
    }

    /// Executes as many events toward the target as allowed, at least one.
    #[inline(always)]
    fn steps<const WIDTH: usize, const FALLS: bool>(
        &mut self,
        target: Target,
        at_most: u64,
    ) -> Result<Progress, SimulationFault> {
        for _ in 0..at_most.max(1) {
            if self.step::<WIDTH, FALLS>(target)? {
                return Ok(Progress::Reached);
            }
        }
        Ok(Progress::Working)
    }

    /// Executes one event toward the target; returns whether the target was reached before it.
    #[inline(always)]
    fn step<const WIDTH: usize, const FALLS: bool>(
        &mut self,
        target: Target,
    ) -> Result<bool, SimulationFault> {
        let until = match target {
            Target::Count(events) if self.statistics.collision_count() >= events => {
                self.is_at_target = true;
                return Ok(true);
            }
            Target::Count(_) => f64::INFINITY,
            Target::Time(time) => time,
        };
        match self.engine.step::<WIDTH, FALLS>(until)? {
            StepOutcome::Collision(collision) => self.record(&collision)?,
            StepOutcome::Bookkeeping if self.engine.is_clock_shifted() => self.check_approach()?,
            StepOutcome::Bookkeeping => {}
            StepOutcome::NoEvent => return self.reach(target).map(|()| true),
        }
        Ok(false)
    }

    /// Rejects discs that no longer approach each other, if the run counts collisions.
    #[inline(never)]
    fn check_approach(&self) -> Result<(), SimulationFault> {
        let Extent::Events(total) = self.length else { return Ok(()) };
        match self.engine.excessive_crossings() {
            None => Ok(()),
            Some(crossings) => Err(SimulationFault::new(
                format!(
                    "event {total} cannot be reached: after {} events, the discs crossed {crossings:.2e} cells without a collision, \
                     because all move in parallel",
                    self.statistics.collision_count()
                ),
                "set a duration, fewer events_per_disc, or a restitution closer to 1; if the manifest has remove_mean_velocity = false, omit it",
            )),
        }
    }

    /// Advances the time to a target before which there is no event.
    #[inline(never)]
    fn reach(&mut self, target: Target) -> Result<(), SimulationFault> {
        match target {
            Target::Count(events) => {
                return Err(SimulationFault::new(
                    format!(
                        "event {events} cannot be reached: after {} events at time {} no disc approaches a disc or a wall",
                        self.statistics.collision_count(),
                        self.time
                    ),
                    "give the discs velocities, or set a duration",
                ));
            }
            Target::Time(time) => {
                self.engine.advance_clock_to(time);
                self.time = time;
            }
        }
        self.is_at_target = true;
        Ok(())
    }

    /// Updates time, statistics and series after a collision.
    ///
    /// # Errors
    /// Discs that have come to rest.
    #[inline(always)]
    fn record(&mut self, collision: &Collision) -> Result<(), SimulationFault> {
        self.time = self.engine.time();
        self.statistics.add(collision);
        // The recalculation costs n operations: every n collisions, this is a constant cost per collision.
        if self.statistics.collision_count().is_multiple_of(self.engine.count() as u64) {
            self.recalculate_moments();
        }
        if let Some((series, events)) = &mut self.series {
            let event = self.statistics.collision_count();
            series.push(event, self.time, self.statistics.moments());
            push_event(events, event, self.time, collision);
        }
        self.check_motion()
    }

    /// Rejects discs that have come to rest.
    #[inline(always)]
    fn check_motion(&self) -> Result<(), SimulationFault> {
        if self.statistics.may_be_at_rest() { self.check_velocities() } else { Ok(()) }
    }

    #[inline(never)]
    fn check_velocities(&self) -> Result<(), SimulationFault> {
        let initial = self.statistics.initial_mean_square_speed();
        let now = VelocityMoments::of(self.engine.velocities()).mean_square_speed();
        if now < rest::limit(initial) {
            return Err(rest::fault(self.statistics.collision_count(), now, initial));
        }
        Ok(())
    }

    #[inline(never)]
    fn recalculate_moments(&mut self) {
        self.statistics.set_velocities(self.engine.velocities());
        self.engine.set_mean_square_speed(self.statistics.moments().mean_square_speed());
    }
}

/// Appends a collision to those since the last frame. The mass of a disc is 1.
fn push_event(events: &mut EventRecord, event: u64, time: f64, collision: &Collision) {
    let second = match collision.partner {
        CollisionPartner::Disc { id, .. } => id,
        CollisionPartner::Wall | CollisionPartner::Obstacle => collision.disc,
    };
    let [before, after] = collision.velocity_changes[0];
    let impulse = motion::difference(before, after);
    events.push((event, time), [collision.disc, second], impulse, collision.separation);
}

/// The message of `/events`.
fn events_message(events: &EventRecord) -> PackingEvents {
    let EventRecord { event, time, discs, impulse, normal } = events.clone();
    let ([first_id, second_id], [impulse_x, impulse_y]) = (discs, impulse);
    let [normal_x, normal_y] = normal;
    PackingEvents { event, time, first_id, second_id, impulse_x, impulse_y, normal_x, normal_y }
}

/// The work of [`Packing::advance`].
struct AdvanceKernel<'a> {
    packing: &'a mut Packing,
    target: Target,
    at_most: u64,
}

impl Kernel for AdvanceKernel<'_> {
    type Output = Result<Progress, SimulationFault>;

    #[inline(always)]
    fn run<const N: usize, I: InstructionSet<N>>(self, _: I) -> Self::Output {
        let Self { packing, target, at_most } = self;
        packing.open_window();
        packing.check_motion()?;
        if packing.statistics.falling().is_some() {
            packing.steps::<N, true>(target, at_most)
        } else {
            packing.steps::<N, false>(target, at_most)
        }
    }
}

//! The event-driven engine: it advances from event to event, at a cost per event that does not depend on the number of discs.
//!
//! Each disc has its own clock: its record holds the state after its last collision, and its present position is
//! extrapolated. Each disc has one event in the queue, its next one. If the partner of a predicted collision has collided in
//! the meantime, the event is invalid, which is detected when it is due (Lubachevsky, J. Comput. Phys. 94 (1991) 255; Paul,
//! J. Comput. Phys. 221 (2007) 615).
//!
//! Start reading here: [`Engine::step`] executes one event with the rules of `motion`.

mod collisions;
mod crossings;
mod growth;
mod obstacles;
mod prediction;
mod prefetch;
mod state;

pub(super) use self::state::Engine;
use self::state::State;
use super::clock::Clock;
use super::collision::Collision;
use super::disc::DiscRecord;
use super::domain::Domain;
use super::events::{EventKind, NEVER};
use super::inelastic_collapse::CollapseDetector;
use super::motion::Vector;
use crate::memory::with_large_pages;
use crate::model::SimulationFault;
use crate::random::Generator;

/// The outcome of one step of the engine.
pub(super) enum StepOutcome {
    /// A collision was executed.
    Collision(Collision),
    /// A cell crossing was executed, or an invalid event was replaced.
    Bookkeeping,
    /// There is no event up to the given time.
    NoEvent,
}

impl Engine {
    /// An engine at time 0. There are as many velocities as positions, at least one; the discs are inside of the box and do
    /// not overlap. `radii` has the radius of each disc, or is empty if all are equal.
    pub(super) fn new(
        domain: Domain,
        positions: Vec<Vector>,
        velocities: Vec<Vector>,
        radii: Vec<f64>,
        mean_square_speed: f64,
        wall_noise: Generator,
    ) -> Self {
        let grid = domain.cell_grid(positions.len());
        let mut discs = with_large_pages(positions.len());
        discs.extend(positions.into_iter().zip(velocities).map(|(position, velocity)| {
            let (cell, relative) = grid.locate(position);
            DiscRecord::new(cell, relative, velocity)
        }));
        let (diameter, gravity) = (2.0 * domain.max_radius, domain.gravity);
        // A disc that falls by its diameter reaches this square of its speed, and twice this at its end.
        let mean_square_speed = mean_square_speed + gravity * diameter;
        let mut engine = Self::from_state(State {
            domain,
            discs,
            radii,
            growth: None,
            clock: Clock::new(diameter, mean_square_speed),
            last_collision: 0.0,
            events_since_shift: 0,
            wall_noise,
            collapse_detector: CollapseDetector::new(diameter, mean_square_speed),
        });
        for disc in 0..engine.state.discs.len() as u32 {
            if gravity > 0.0 {
                engine.predict::<1, true>(disc);
            } else {
                engine.predict::<1, false>(disc);
            }
        }
        engine.rebuild_event_queue();
        engine
    }

    /// Executes the next event, unless it is later than a time since the start. `WIDTH` is that of the registers of `simd::registers`
    /// that are used; `FALLS` says whether there is gravity.
    ///
    /// # Errors
    /// Inelastic collapse (McNamara and Young, Phys. Fluids A 4 (1992) 496), a jam, or a disc too slow to leave a wall.
    #[inline(always)]
    pub(super) fn step<const WIDTH: usize, const FALLS: bool>(
        &mut self,
        until: f64,
    ) -> Result<StepOutcome, SimulationFault> {
        let Some(disc) = self.first_scheduled() else { return Ok(StepOutcome::NoEvent) };
        let record = &self.state.discs[disc as usize];
        if record.event_time > self.state.clock.to_local(until) {
            return Ok(StepOutcome::NoEvent);
        }
        self.state.clock.advance_to(record.event_time);
        let outcome = match record.event.kind() {
            EventKind::Pair(partner)
                if self.state.discs[partner as usize].collisions == record.partner_collisions =>
            {
                StepOutcome::Collision(self.collide_pair::<WIDTH, FALLS>(disc, partner)?)
            }
            EventKind::Obstacle => {
                let number = record.partner_collisions;
                StepOutcome::Collision(self.collide_obstacle::<WIDTH, FALLS>(disc, number)?)
            }
            EventKind::Wall(side) => {
                StepOutcome::Collision(self.collide_wall::<WIDTH, FALLS>(disc, side)?)
            }
            EventKind::CellCrossing(side) => {
                self.cross_cell::<WIDTH, FALLS>(disc, side);
                StepOutcome::Bookkeeping
            }
            EventKind::Pair(_) | EventKind::None => {
                self.predict::<WIDTH, FALLS>(disc);
                self.schedule(disc);
                StepOutcome::Bookkeeping
            }
        };
        self.state.events_since_shift += 1;
        if self.state.events_since_shift >= self.events_between_shifts {
            self.shift_clock_origin();
        }
        Ok(outcome)
    }

    /// Shifts the clock's origin close to the present. This depends on the number of events only, never on observation.
    #[inline(never)]
    pub(super) fn shift_clock_origin(&mut self) {
        self.state.events_since_shift = 0;
        let shift = self.state.clock.shift_origin();
        self.state.last_collision -= shift;
        for disc in &mut self.state.discs {
            disc.time -= shift;
            if disc.event_time < NEVER {
                disc.event_time -= shift;
            }
        }
        if let Some(growth) = &mut self.state.growth {
            growth.scale += growth.rate * shift;
        }
        self.rebuild_event_queue();
    }

    /// Schedules all events again, in buckets that suit the present mean time.
    fn rebuild_event_queue(&mut self) {
        self.event_queue.rebuild(&self.state.discs, self.state.mean_time_to_event());
    }
}

//! Law: discs fly straight between their collisions, so that a frame and the collisions after it, as `/events` records them, give the
//! position and the velocity of each disc at any time until the next frame.
//!
//! Source: free flight; the momentum of two discs is conserved in a collision.
//! Setup: walls with noise, inelastic discs, several sizes, obstacles and a periodic box; ten frames, and 1000 random times at which another run
//! is observed.
//! Tolerance: 1e-12 of the longer side, some 40 roundings of a coordinate; centers at contact and directions likewise.
//! Control: without the event before a random time, one disc is elsewhere.

use crate::runs::{
    DiscState, advance_to_time, at_fraction, disc_states, message, prepare, prepare_with_series,
    squared_speed, with_obstacles, with_restitution, without_noise,
};
use kinetoscope_manifest::model::{Boundary, PackingConfig};
use kinetoscope_manifest::quantity::NonNegative;
use kinetoscope_recording::channels::PackingEvents;

const SEED: u64 = 12;
const FRAMES: usize = 10;
const TIMES: usize = 1000;
const DURATION: f64 = 20.0;
const TOLERANCE: f64 = 1e-12;

/// The discs of a frame, each at the time of its last collision.
struct Flights<'a> {
    discs: Vec<(DiscState, f64)>,
    sides: [f64; 2],
    is_periodic: bool,
    events: &'a PackingEvents,
    executed: usize,
}

impl Flights<'_> {
    fn position(&self, disc: usize, time: f64) -> [f64; 2] {
        let (state, since) = self.discs[disc];
        [0, 1].map(|axis| state.position[axis] + state.velocity[axis] * (time - since))
    }

    /// The shortest difference of two points.
    fn difference(&self, one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            let difference = one[axis] - other[axis];
            let side = self.sides[axis];
            difference - if self.is_periodic { side * libm::round(difference / side) } else { 0.0 }
        })
    }

    fn execute(&mut self) {
        let (event, events) = (self.executed, self.events);
        let time = events.time[event];
        let [first, second] =
            [events.first_id[event], events.second_id[event]].map(|id| id as usize);
        let impulse = [events.impulse_x[event], events.impulse_y[event]];
        let normal = [events.normal_x[event], events.normal_y[event]];
        let [one, other] = [first, second].map(|disc| self.position(disc, time));
        if first != second {
            let between = self.difference(other, one);
            let contact = self.discs[first].0.radius + self.discs[second].0.radius;
            for axis in 0..2 {
                assert!((between[axis] - contact * normal[axis]).abs() < self.tolerance());
            }
            let cross = impulse[0] * normal[1] - impulse[1] * normal[0];
            assert!(
                cross.abs() < TOLERANCE && impulse[0] * normal[0] + impulse[1] * normal[1] < 0.0
            );
        }
        let turns = [(first, one, 1.0), (second, other, -1.0)];
        for (disc, position, sign) in turns.into_iter().take(1 + usize::from(first != second)) {
            let state = &mut self.discs[disc];
            state.0.position = position;
            for (component, change) in state.0.velocity.iter_mut().zip(impulse) {
                *component += sign * change;
            }
            state.1 = time;
        }
        self.executed += 1;
    }

    fn tolerance(&self) -> f64 {
        TOLERANCE * if self.sides[0] > self.sides[1] { self.sides[0] } else { self.sides[1] }
    }

    /// Number of discs whose position or velocity at a time is not that of another run.
    fn different(&self, discs: &[DiscState], time: f64) -> usize {
        let is_off = |vector: [f64; 2], tolerance: f64| squared_speed(vector).sqrt() > tolerance;
        let is_different = |(disc, state): &(usize, &DiscState)| {
            let velocity = self.discs[*disc].0.velocity;
            let change = [velocity[0] - state.velocity[0], velocity[1] - state.velocity[1]];
            let offset = self.difference(self.position(*disc, time), state.position);
            is_off(offset, self.tolerance()) || is_off(change, TOLERANCE)
        };
        discs.iter().enumerate().filter(is_different).count()
    }
}

/// Random times in ascending order, by a linear congruential generator (Knuth, The Art of Computer Programming 2, section 3.3.4).
fn random_times() -> Vec<f64> {
    let mut state = SEED;
    let mut times: Vec<f64> = (0..TIMES)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 * DURATION
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times
}

fn assert_rebuilt(config: &PackingConfig) {
    let mut recorded = prepare_with_series(config, SEED);
    let mut observed = prepare(config, SEED, 0);
    let mut times = random_times().into_iter().peekable();
    assert_eq!(message::<PackingEvents>(&recorded).event, [0_u64; 0]);
    let (mut last_event, mut controls) = (0, 0);
    for frame in 1..=FRAMES {
        let start = (frame - 1) as f64 * DURATION / FRAMES as f64;
        let end = frame as f64 * DURATION / FRAMES as f64;
        let discs = disc_states(&recorded).into_iter().map(|disc| (disc, start)).collect();
        advance_to_time(&mut recorded, end);
        let events = message::<PackingEvents>(&recorded);
        assert!(events.event.iter().copied().eq((last_event + 1..).take(events.event.len())));
        last_event += events.event.len() as u64;
        let sides = [config.width.get(), config.height.get()];
        let mut flights = Flights {
            discs,
            sides,
            is_periodic: config.boundary == Boundary::Periodic,
            events: &events,
            executed: 0,
        };
        while let Some(time) = times.next_if(|time| *time <= end) {
            advance_to_time(&mut observed, time);
            let there = disc_states(&observed);
            while events.time.get(flights.executed).is_some_and(|event| *event <= time) {
                if events.time.get(flights.executed + 1).is_none_or(|next| *next > time) {
                    controls += usize::from(flights.different(&there, time) > 0);
                }
                flights.execute();
            }
            assert_eq!(flights.different(&there, time), 0, "at {time}");
        }
    }
    assert!(last_event > 1000 && controls > TIMES / 4, "{last_event} events, {controls} controls");
}

#[test]
fn frame_and_events_give_positions_at_any_time() {
    let fluid = at_fraction(80, 0.4);
    assert_rebuilt(&fluid);
    assert_rebuilt(&with_restitution(without_noise(fluid.clone()), 0.95));
    let pegs = [[-5.0, -6.0], [4.0, 3.0], [-3.0, 6.0]];
    let among_pegs = with_obstacles(without_noise(at_fraction(80, 0.3)), &pegs, 1.5);
    assert_rebuilt(&with_restitution(among_pegs.clone(), 0.95));
    assert_rebuilt(&PackingConfig { boundary: Boundary::Periodic, ..among_pegs });
    let mixture = PackingConfig { radius_half_width: NonNegative::literal(0.2), ..fluid };
    assert_rebuilt(&PackingConfig { boundary: Boundary::Periodic, ..without_noise(mixture) });
}

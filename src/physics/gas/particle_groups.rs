//! Particles in groups of eight with one array per component, which the compiler turns into vector instructions.

use super::motion::Particle;
use serde::{Deserialize, Serialize};

/// Number of particles per group: a whole number of vector registers on every machine.
pub(super) const LANES: usize = 8;

/// Number of groups per block. A block is the unit of work of a thread and of a sum. Its size is fixed, so results do not depend on the
/// number of threads.
pub(super) const BLOCK: usize = 128;

/// One number per particle of a group.
pub(super) type Lanes = [f64; LANES];

/// Eight particles. No column crosses a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(align(64))]
pub(super) struct Group {
    pub(super) x: Lanes,
    pub(super) y: Lanes,
    pub(super) vx: Lanes,
    pub(super) vy: Lanes,
}

impl Group {
    #[inline(always)]
    pub(super) fn particle(&self, lane: usize) -> Particle {
        Particle {
            position: [self.x[lane], self.y[lane]],
            velocity: [self.vx[lane], self.vy[lane]],
        }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, particle: Particle) {
        [self.x[lane], self.y[lane]] = particle.position;
        [self.vx[lane], self.vy[lane]] = particle.velocity;
    }
}

/// All particles in the order of their ids. Lanes after the last particle are at rest at the center and are not counted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Particles {
    count: usize,
    pub(super) groups: Vec<Group>,
}

impl Particles {
    /// Whether these are `count` particles at finite positions, none of which is faster than `max_speed`, m/s.
    pub(super) fn is_valid(&self, count: usize, max_speed: f64) -> bool {
        let is_valid = |particle: Particle| {
            let [position, speed] =
                [particle.position, particle.velocity].map(|v| v[0].abs() + v[1].abs());
            // Comparisons with numbers that are not finite are false.
            position < f64::INFINITY && speed <= 2.0 * max_speed
        };
        self.count == count
            && self.groups.len() == count.div_ceil(LANES)
            && self.lanes().all(is_valid)
    }

    pub(super) fn of(list: &[Particle]) -> Self {
        let mut groups = vec![Group::default(); list.len().div_ceil(LANES)];
        for (group, members) in groups.iter_mut().zip(list.chunks(LANES)) {
            for (lane, &particle) in members.iter().enumerate() {
                group.set(lane, particle);
            }
        }
        Self { count: list.len(), groups }
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    pub(super) fn get(&self, id: usize) -> Particle {
        self.groups[id / LANES].particle(id % LANES)
    }

    pub(super) fn set(&mut self, id: usize, particle: Particle) {
        self.groups[id / LANES].set(id % LANES, particle);
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Particle> + '_ {
        self.lanes().take(self.count)
    }

    /// All particles and empty lanes.
    pub(super) fn lanes(&self) -> impl Iterator<Item = Particle> + '_ {
        self.groups.iter().flat_map(|group| (0..LANES).map(|lane| group.particle(lane)))
    }
}

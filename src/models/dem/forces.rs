//! The forces on the discs of a block, pair by pair in the order of its lists.
//!
//! Beside each disc's force F stands its dissipative part D, the sum of (k delta - f) n. The power that dashpots take is
//! then the sum of D . v over discs, and no contact has to be looked at a second time once accelerations are known.

use super::contacts::ContactLaw;
use super::discs::Discs;
use super::lanes;
use super::materials::ContactConstants;
use super::motion::{self, SpringSlider};
use super::neighbours::{Block, Pairs, Stretch};
use super::walls::PlacedWall;

/// Forces on the discs of a block, and what its contacts did.
#[derive(Clone, Debug, Default)]
pub(super) struct Forces {
    /// Fx, Fy, Dx, Dy of each disc, N.
    pub(super) forces: Vec<[f64; 4]>,
    /// Torque and its dissipative part, N m; empty without friction.
    pub(super) torques: Vec<[f64; 2]>,
    pub(super) sums: ContactSums,
}

/// Sums over the contacts of a block. An edge, which two blocks see, counts half in each.
#[derive(Clone, Debug, Default)]
pub(super) struct ContactSums {
    /// Energy of the tangential and rolling springs, J.
    pub(super) elastic: f64,
    /// Energy that friction took in the step before, J.
    pub(super) friction: f64,
    /// Energy that rolling friction took in the step before, J.
    pub(super) rolling: f64,
    /// Power taken by the dashpots of moving walls beyond D . v of their discs, W.
    pub(super) wall_dissipation: f64,
    /// Force of each wall on the discs, N, and its power, W.
    pub(super) walls: Vec<[f64; 3]>,
    /// Largest overlap over the smaller radius.
    pub(super) largest_overlap: f64,
}

/// The deepest contact so far. Most contacts are less deep and are told by one comparison.
#[derive(Clone, Copy, Debug)]
pub(super) struct Deepest {
    over_radius: f64,
    smallest_radius: f64,
}

impl Deepest {
    /// `over_radius` is the largest overlap over the smaller radius so far.
    pub(super) fn new(over_radius: f64, smallest_radius: f64) -> Self {
        Self { over_radius, smallest_radius }
    }

    /// Overlaps up to this, m, need not be noted.
    #[inline]
    pub(super) fn bound(&self) -> f64 {
        self.over_radius * self.smallest_radius
    }

    #[inline]
    pub(super) fn note(&mut self, overlap: f64, radius: f64, other_radius: f64) {
        let ratio = overlap / if radius < other_radius { radius } else { other_radius };
        if ratio > self.over_radius {
            self.over_radius = ratio;
        }
    }
}

/// What a block's forces follow from, besides its own lists.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub(super) discs: &'a Discs,
    pub(super) law: &'a ContactLaw,
    pub(super) walls: &'a [PlacedWall],
    pub(super) time_step: f64,
    pub(super) smallest_radius: f64,
    /// Largest overlap over radius that is known already.
    pub(super) known_overlap: f64,
    /// Whether four pairs may be taken at a time.
    pub(super) use_lanes: bool,
}

impl Scene<'_> {
    /// Constants of the contact of two discs.
    #[inline]
    fn constants(&self, [a, b]: [usize; 2]) -> &ContactConstants {
        self.law.materials.between(self.discs.materials[a], self.discs.materials[b])
    }
}

impl Forces {
    /// Finds all forces on the discs of a block; the springs of its contacts move on by a step.
    pub(super) fn find(&mut self, block: &mut Block, scene: &Scene<'_>) {
        let count = block.len(scene.discs);
        self.forces.clear();
        self.forces.resize(count, [0.0; 4]);
        self.torques.clear();
        let walls = std::mem::take(&mut self.sums.walls);
        self.sums = ContactSums { walls, ..ContactSums::default() };
        self.sums.walls.clear();
        self.sums.walls.resize(scene.walls.len(), [0.0; 3]);
        let mut deepest = Deepest::new(scene.known_overlap, scene.smallest_radius);
        if scene.law.has_friction() {
            self.torques.resize(count, [0.0; 2]);
            self.rubbing_pairs(block, scene, &mut deepest);
        } else {
            let own = block.start..block.start + count;
            let (states, radii) = (&scene.discs.states[own.clone()], &scene.discs.radii[own]);
            let (forces, law) = (&mut self.forces, scene.law);
            let done = if scene.use_lanes {
                lanes::inner_pairs(&block.inner, states, radii, law, forces, &mut deepest)
            } else {
                0
            };
            inner_pairs(&block.inner, done, states, radii, law, forces, &mut deepest);
        }
        self.edges(block, scene, &mut deepest);
        self.walls(block, scene, &mut deepest);
        self.sums.largest_overlap = deepest.over_radius;
    }

    fn rubbing_pairs(&mut self, block: &mut Block, scene: &Scene<'_>, deepest: &mut Deepest) {
        let Pairs { first, second, reach, damping, stretch } = &mut block.inner;
        for pair in 0..first.len() {
            let (a, b) = (first[pair] as usize, second[pair] as usize);
            let ends = [block.start + a, block.start + b];
            let Some(touch) = touch(scene.discs, ends, [0.0; 2], reach[pair]) else {
                self.sums.let_go(&mut stretch[pair], scene.law, 1.0);
                continue;
            };
            let radii = ends.map(|end| scene.discs.radii[end]);
            deepest.note(touch.overlap, radii[0], radii[1]);
            let push = touch.push(scene.law, damping[pair]);
            let own = scene.constants(ends);
            let rub = touch.rub(scene, own, radii, &push, damping[pair], &mut stretch[pair]);
            self.sums.take(&rub, 1.0);
            let on_first = push.and(&rub, touch.normal);
            add(&mut self.forces[a], on_first);
            add(&mut self.forces[b], on_first.map(|part| -part));
            add_torque(&mut self.torques[a], rub.torques(radii[0], 1.0));
            add_torque(&mut self.torques[b], rub.torques(radii[1], -1.0));
        }
    }

    fn edges(&mut self, block: &mut Block, scene: &Scene<'_>, deepest: &mut Deepest) {
        for edge in 0..block.edges.len() {
            let own = block.edges.first[edge] as usize;
            let ends = [block.start + own, block.edges.second[edge] as usize];
            let damping = block.edges.damping[edge];
            let touch = touch(scene.discs, ends, block.shifts[edge], block.edges.reach[edge]);
            let Some(touch) = touch else {
                if let Some(stretch) = block.edges.stretch.get_mut(edge) {
                    self.sums.let_go(stretch, scene.law, 0.5);
                }
                continue;
            };
            let radii = ends.map(|end| scene.discs.radii[end]);
            deepest.note(touch.overlap, radii[0], radii[1]);
            let push = touch.push(scene.law, damping);
            let Some(stretch) = block.edges.stretch.get_mut(edge) else {
                add(&mut self.forces[own], push.along(touch.normal));
                continue;
            };
            let rub = touch.rub(scene, scene.constants(ends), radii, &push, damping, stretch);
            self.sums.take(&rub, 0.5);
            add(&mut self.forces[own], push.and(&rub, touch.normal));
            add_torque(&mut self.torques[own], rub.torques(radii[0], 1.0));
        }
    }

    fn walls(&mut self, block: &mut Block, scene: &Scene<'_>, deepest: &mut Deepest) {
        for pair in &mut block.walls {
            let own = pair.disc as usize;
            let disc = block.start + own;
            let wall = &scene.walls[pair.wall as usize];
            let radius = scene.discs.radii[disc];
            let [x, y, vx, vy] = scene.discs.states[disc];
            let footing = wall.shape.footing([x, y]);
            if footing.distance >= radius {
                self.sums.let_go(&mut pair.stretch, scene.law, 1.0);
                continue;
            }
            let normal = footing.normal;
            let [wall_vx, wall_vy] = wall.surface_velocity(wall.step_velocity, normal);
            let touch = Touch {
                normal,
                overlap: radius - footing.distance,
                velocity: [vx - wall_vx, vy - wall_vy],
                rolling_rate: scene.discs.spins[disc] - wall.spin,
                surface_speed: radius * scene.discs.spins[disc],
            };
            deepest.note(touch.overlap, radius, radius);
            let push = touch.push(scene.law, pair.damping);
            let mut on_disc = push.along(normal);
            if scene.law.has_friction() {
                // Against a wall the reduced radius is the disc's own.
                let rub = touch.rub(
                    scene,
                    scene.law.materials.with_walls(scene.discs.materials[disc]),
                    [radius, f64::INFINITY],
                    &push,
                    pair.damping,
                    &mut pair.stretch,
                );
                self.sums.take(&rub, 1.0);
                on_disc = push.and(&rub, normal);
                add_torque(&mut self.torques[own], rub.torques(radius, 1.0));
            }
            add(&mut self.forces[own], on_disc);
            let [u, v] = wall.surface_velocity(wall.mid_velocity, normal);
            self.sums.wall_dissipation -= on_disc[2] * u + on_disc[3] * v;
            let by_wall = &mut self.sums.walls[pair.wall as usize];
            let [fx, fy, ..] = on_disc;
            *by_wall = [by_wall[0] + fx, by_wall[1] + fy, by_wall[2] + (fx * u + fy * v)];
        }
    }
}

/// Pairs without friction from number `from` on. `lanes` does the same for four pairs at a time.
fn inner_pairs(
    pairs: &Pairs,
    from: usize,
    own: &[[f64; 4]],
    radii: &[f64],
    law: &ContactLaw,
    forces: &mut [[f64; 4]],
    deepest: &mut Deepest,
) {
    let ends = pairs.first.iter().zip(&pairs.second);
    let constants = pairs.reach.iter().zip(&pairs.damping);
    for ((&first, &second), (&reach, &damping)) in ends.zip(constants).skip(from) {
        let (a, b) = (first as usize, second as usize);
        let (state, other) = (own[a], own[b]);
        let apart = [state[0] - other[0], state[1] - other[1]];
        let squared = apart[0] * apart[0] + apart[1] * apart[1];
        if squared < reach * reach {
            let velocity = [state[2] - other[2], state[3] - other[3]];
            let touch = Touch::of(apart, squared, reach, velocity);
            if touch.overlap > deepest.bound() {
                deepest.note(touch.overlap, radii[a], radii[b]);
            }
            let push = touch.push(law, damping).along(touch.normal);
            add(&mut forces[a], push);
            add(&mut forces[b], push.map(|part| -part));
        }
    }
}

/// Two that overlap.
struct Touch {
    /// Unit vector from the other to the disc.
    normal: [f64; 2],
    /// delta, m.
    overlap: f64,
    /// Velocity of the disc against the other, spins left out, m/s.
    velocity: [f64; 2],
    /// w_i - w_j, rad/s.
    rolling_rate: f64,
    /// r_i w_i + r_j w_j, m/s.
    surface_speed: f64,
}

/// Normal force f and its dissipative part k delta - f, N.
struct Push {
    force: f64,
    loss: f64,
}

/// What friction does in a step.
struct Rub {
    /// Tangential force and the dashpot's share of it, N.
    force: f64,
    dashpot: f64,
    /// Torque of the rolling spring over the reduced radius, N; and that radius, m.
    rolling_force: f64,
    reduced_radius: f64,
    /// Energy of both springs, J.
    elastic: f64,
    /// Energy taken by either slider, J.
    friction_loss: f64,
    rolling_loss: f64,
}

/// The contact of two discs, the second shifted; `None` where they are apart.
#[inline]
fn touch(discs: &Discs, [a, b]: [usize; 2], shift: [f64; 2], reach: f64) -> Option<Touch> {
    let (state, other) = (discs.states[a], discs.states[b]);
    let apart = [state[0] - (other[0] + shift[0]), state[1] - (other[1] + shift[1])];
    let squared = apart[0] * apart[0] + apart[1] * apart[1];
    if squared < reach * reach {
        let velocity = [state[2] - other[2], state[3] - other[3]];
        let (spin, other_spin) = (discs.spins[a], discs.spins[b]);
        return Some(Touch {
            rolling_rate: spin - other_spin,
            surface_speed: discs.radii[a] * spin + discs.radii[b] * other_spin,
            ..Touch::of(apart, squared, reach, velocity)
        });
    }
    None
}

impl Touch {
    #[inline]
    fn of(apart: [f64; 2], squared: f64, reach: f64, velocity: [f64; 2]) -> Self {
        let distance = squared.sqrt();
        // Centres on one point have no normal, and such an overlap ends the run: no force will do.
        let inverse = 1.0 / if distance > f64::MIN_POSITIVE { distance } else { f64::MIN_POSITIVE };
        Self {
            normal: [apart[0] * inverse, apart[1] * inverse],
            overlap: reach - distance,
            velocity,
            rolling_rate: 0.0,
            surface_speed: 0.0,
        }
    }

    #[inline]
    fn push(&self, law: &ContactLaw, damping: f64) -> Push {
        let speed = self.velocity[0] * self.normal[0] + self.velocity[1] * self.normal[1];
        let force = motion::contact_force(law.stiffness, damping, self.overlap, speed);
        let force = law.clamped(force);
        Push { force, loss: law.stiffness * self.overlap - force }
    }

    /// Moves the springs of the contact on. Slippage counts with the mean of the spring's force before and after it: with
    /// the velocities half a step behind the positions that makes work and energy of the springs agree exactly.
    #[inline]
    fn rub(
        &self,
        scene: &Scene<'_>,
        constants: &ContactConstants,
        radii: [f64; 2],
        push: &Push,
        damping: f64,
        stretch: &mut Stretch,
    ) -> Rub {
        let law = scene.law;
        let pressing = if push.force > 0.0 { push.force } else { 0.0 };
        let damping = law.tangential_damping_share * damping;
        let stiffness = law.tangential_stiffness;
        let slide = |before: f64, speed: f64, limit: f64| {
            let travel = speed * scene.time_step;
            let moved: SpringSlider =
                motion::spring_slider(stiffness, damping, before, travel, speed, limit);
            let loss = 0.5 * stiffness * (before + moved.stretch) * moved.slip;
            (moved, loss)
        };
        let [nx, ny] = self.normal;
        let speed = self.velocity[1] * nx - self.velocity[0] * ny - self.surface_speed;
        let (tangential, friction_loss) = slide(stretch[0], speed, constants.friction * pressing);
        let mut rub = Rub {
            force: tangential.force,
            dashpot: tangential.dashpot_force,
            rolling_force: 0.0,
            reduced_radius: 0.0,
            elastic: 0.5 * stiffness * tangential.stretch * tangential.stretch,
            friction_loss,
            rolling_loss: 0.0,
        };
        stretch[0] = tangential.stretch;
        if constants.rolling_friction > 0.0 {
            let reduced = 1.0 / (1.0 / radii[0] + 1.0 / radii[1]);
            let travel = reduced * self.rolling_rate * scene.time_step;
            let limit = constants.rolling_friction * pressing;
            // Without a dashpot: rolling friction alone takes the energy.
            let rolling = motion::spring_slider(stiffness, 0.0, stretch[1], travel, 0.0, limit);
            rub.rolling_loss = 0.5 * stiffness * (stretch[1] + rolling.stretch) * rolling.slip;
            rub.elastic += 0.5 * stiffness * rolling.stretch * rolling.stretch;
            rub.rolling_force = rolling.force;
            rub.reduced_radius = reduced;
            stretch[1] = rolling.stretch;
        }
        rub
    }
}

impl Push {
    /// F and D along a normal.
    #[inline]
    fn along(&self, [nx, ny]: [f64; 2]) -> [f64; 4] {
        [self.force * nx, self.force * ny, self.loss * nx, self.loss * ny]
    }

    /// F and D with those of the tangent (-ny, nx).
    #[inline]
    fn and(&self, rub: &Rub, [nx, ny]: [f64; 2]) -> [f64; 4] {
        let [fx, fy, dx, dy] = self.along([nx, ny]);
        let (force, loss) = (rub.force, -rub.dashpot);
        [fx - force * ny, fy + force * nx, dx - loss * ny, dy + loss * nx]
    }
}

impl Rub {
    /// Torque on a disc of a radius, and its dissipative part. `side` is 1 for the disc that the normal points to, else -1.
    #[inline]
    fn torques(&self, radius: f64, side: f64) -> [f64; 2] {
        let rolling = side * self.reduced_radius * self.rolling_force;
        [rolling - radius * self.force, radius * self.dashpot]
    }
}

impl ContactSums {
    #[inline]
    fn take(&mut self, rub: &Rub, share: f64) {
        self.elastic += share * rub.elastic;
        self.friction += share * rub.friction_loss;
        self.rolling += share * rub.rolling_loss;
    }

    /// The contact has ended: what its springs still held is lost to friction.
    #[inline]
    fn let_go(&mut self, stretch: &mut Stretch, law: &ContactLaw, share: f64) {
        if *stretch != [0.0; 2] {
            let half = 0.5 * law.tangential_stiffness * share;
            self.friction += half * stretch[0] * stretch[0];
            self.rolling += half * stretch[1] * stretch[1];
            *stretch = [0.0; 2];
        }
    }
}

#[inline]
fn add(sum: &mut [f64; 4], part: [f64; 4]) {
    *sum = [sum[0] + part[0], sum[1] + part[1], sum[2] + part[2], sum[3] + part[3]];
}

#[inline]
fn add_torque(sum: &mut [f64; 2], part: [f64; 2]) {
    *sum = [sum[0] + part[0], sum[1] + part[1]];
}

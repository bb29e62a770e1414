//! The forces on the discs of a block, pair by pair in the order of its lists.
//!
//! Beside each disc's force F stands its dissipative part D, the sum of (k delta - f) n. The power that dashpots take is
//! then the sum of D . v over discs, and no contact has to be looked at a second time once accelerations are known.
//!
//! Edges see discs of other blocks, so all of them come first, while no disc has moved. What is left of a block follows
//! from its own discs alone, and they can move on at once.

pub(super) mod contact;
pub(super) mod fours;
pub(super) mod implicit;
pub(super) mod lanes;
#[cfg(test)]
mod register_width_does_not_affect_forces;
pub(super) mod rows;
pub(super) mod rubbing;
pub(super) mod rubbing_lanes;
pub(super) mod touch;
pub(super) mod touched;

use crate::dem::discs::Discs;
use crate::dem::forces::contact::{ContactLaw, Partner};
use crate::dem::forces::lanes::{Lanes, Memory};
use crate::dem::forces::rows::Rows;
use crate::dem::forces::touch::{Rub, Touch};
use crate::dem::forces::touched::Touched;
use crate::dem::neighbors::near_pairs::{self, Good, Near, Touching};
use crate::dem::neighbors::springs::Stretch;
use crate::dem::neighbors::{Block, Pairs, Scope};
use crate::dem::walls::PlacedWall;

/// Forces on the discs of a block, and what its contacts did.
#[derive(Clone, Debug, Default)]
pub(super) struct Forces {
    /// Fx, Fy, Dx, Dy of each disc, N; zero between two steps.
    pub(super) forces: Rows,
    /// Tangential force on the rim of each disc and the dashpots' share of it, N; empty without friction.
    pub(super) tangential: Vec<[f64; 2]>,
    /// Torque of the rolling springs on each disc, N m; empty without friction.
    pub(super) rolling: Vec<f64>,
    pub(super) sums: ContactSums,
    /// Memory for the speeds r w of the discs' rims, m/s.
    pub(super) rim_speeds: Vec<f64>,
    /// Discs on which something acts.
    pub(super) touched: Touched,
    /// Memory of the lanes.
    touching: Touching,
}

/// Forces of a block's edges on its own discs.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgeForces {
    /// The disc, counted from the block's first, with Fx, Fy, Dx, Dy, N.
    forces: Vec<(u32, [f64; 4])>,
    /// What friction does to each; empty without friction.
    rubs: Vec<RimForce>,
    sums: ContactSums,
    /// Numbers of the near edges; see `near`.
    near: Vec<u32>,
    /// What these are good for.
    good: Good,
}

/// Tangential force on a rim and the dashpot's share of it, N, and the torque of a rolling spring, N m.
type RimForce = ([f64; 2], f64);

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
    pub(super) deepest: Deepest,
}

/// The deepest contact so far. Most contacts are less deep and are told by one comparison.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Deepest {
    /// Overlap over the smaller radius.
    pub(super) over_radius: f64,
    /// Where the disc stands in memory, and its partner; `None` while no contact is deeper than was known before.
    pub(super) ends: Option<(u32, Partner)>,
    smallest_radius: f64,
    /// Where the discs begin that pairs are counted from.
    start: usize,
}

impl Deepest {
    /// Overlaps up to this, m, need not be noted.
    #[inline]
    pub(super) fn bound(&self) -> f64 {
        self.over_radius * self.smallest_radius
    }

    /// Notes the overlap, m, of two discs of the block.
    #[inline]
    pub(super) fn note_pair(&mut self, overlap: f64, [a, b]: [usize; 2], radii: &[f64]) {
        let partner = Partner::Disc((self.start + b) as u32);
        self.note(overlap, a, radii[a], partner, radii[b]);
    }

    #[inline]
    fn note(&mut self, overlap: f64, disc: usize, radius: f64, partner: Partner, other: f64) {
        let ratio = overlap / if radius < other { radius } else { other };
        if ratio > self.over_radius {
            self.over_radius = ratio;
            self.ends = Some(((self.start + disc) as u32, partner));
        }
    }

    /// Takes the deeper of two.
    pub(super) fn take(&mut self, other: &Self) {
        if other.over_radius > self.over_radius {
            *self = *other;
        }
    }
}

/// What forces follow from, besides discs and lists.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub(super) law: &'a ContactLaw,
    pub(super) walls: &'a [PlacedWall],
    pub(super) time_step: f64,
    pub(super) smallest_radius: f64,
    /// Largest overlap over radius that is known already.
    pub(super) known_overlap: f64,
    /// How much of the lists is looked at.
    pub(super) scope: Scope,
    /// Whether four pairs may be taken at a time.
    pub(super) use_lanes: bool,
}

/// The discs of a block, column by column.
pub(super) struct Own<'a> {
    /// Centers, m.
    pub(super) positions: &'a mut [[f64; 2]],
    /// The integrator's velocities, m/s.
    pub(super) velocities: &'a mut [[f64; 2]],
    /// Angular velocities, rad/s.
    pub(super) spins: &'a mut [f64],
    /// Radii, m.
    pub(super) radii: &'a [f64],
    /// Masses, kg, and one over them, 1/kg.
    pub(super) masses: &'a [f64],
    pub(super) inverse_masses: &'a [f64],
    /// Materials, by their number.
    pub(super) materials: &'a [u8],
}

impl EdgeForces {
    /// Finds the forces of a block's edges; the springs of its contacts move on by a step.
    pub(super) fn find(&mut self, block: &mut Block, discs: &Discs, scene: &Scene<'_>) {
        self.forces.clear();
        self.rubs.clear();
        self.sums.clear(scene, block.start);
        if !scene.law.has_friction() {
            self.find_without_friction(block, discs, scene);
            return;
        }
        let rolls = scene.law.has_rolling_friction();
        for edge in 0..block.edges.in_tiers(scene.scope.tiers) {
            let own = block.edges.first[edge];
            let ends = [block.start + own as usize, block.edges.second[edge] as usize];
            let damping = block.edges.damping[edge];
            let touch = Touch::between(discs, ends, block.shifts[edge], block.edges.reach[edge]);
            let Some(touch) = touch else {
                let mut stretch = block.edges.stretch_of(edge);
                self.sums.let_go(&mut stretch, scene.law, 0.5);
                block.edges.set_stretch(edge, stretch);
                continue;
            };
            let radii = ends.map(|disc| discs.radii[disc]);
            let touch = touch.turning(ends.map(|disc| discs.spins[disc]), radii);
            let partner = Partner::Disc(ends[1] as u32);
            self.sums.deepest.note(touch.overlap, own as usize, radii[0], partner, radii[1]);
            let push = touch.push(scene.law, damping);
            let [first, second] = ends.map(|disc| discs.materials[disc]);
            let pair = scene.law.materials.between(first, second);
            let reduced_radius = rolls.then(|| radii[0] * radii[1] / block.edges.reach[edge]);
            let mut stretch = block.edges.stretch_of(edge);
            let (law, time_step) = (scene.law, scene.time_step);
            let rub = touch.rub(law, pair, time_step, reduced_radius, &push, &mut stretch);
            block.edges.set_stretch(edge, stretch);
            self.sums.take(&rub, 0.5);
            self.forces.push((own, push.and(&rub, touch.normal)));
            self.rubs.push(([rub.force, rub.dashpot], rub.rolling_torque));
        }
    }

    /// Looks at the near edges alone; at all in reach where pairs are taken one by one, so that the bits of both can be compared.
    fn find_without_friction(&mut self, block: &Block, discs: &Discs, scene: &Scene<'_>) {
        if !scene.use_lanes {
            let all = 0..block.edges.in_tiers(scene.scope.tiers);
            all.for_each(|edge| self.push(edge, block, discs, scene));
            return;
        }
        if !self.good.is_for(&scene.scope) {
            self.good = Good::until_the_horizon(&scene.scope);
            self.list_near(block, discs, &scene.scope);
        }
        let near = std::mem::take(&mut self.near);
        near.iter().for_each(|&edge| self.push(edge as usize, block, discs, scene));
        self.near = near;
    }

    /// Lists the edges that may touch before the horizon.
    fn list_near(&mut self, block: &Block, discs: &Discs, scope: &Scope) {
        let (horizon, margin) = near_pairs::horizon(scope);
        let looked_at = 0..block.edges.in_tiers(scope.tiers_within(horizon));
        let is_near = |&edge: &usize| {
            let reach = block.edges.reach[edge] + margin;
            Touch::between(discs, block.edge(edge), block.shifts[edge], reach).is_some()
        };
        self.near.clear();
        self.near.extend(looked_at.filter(is_near).map(|edge| edge as u32));
    }

    /// Adds the force of an edge that touches, without friction.
    #[inline]
    fn push(&mut self, edge: usize, block: &Block, discs: &Discs, scene: &Scene<'_>) {
        let (edges, ends) = (&block.edges, block.edge(edge));
        let touch = Touch::between(discs, ends, block.shifts[edge], edges.reach[edge]);
        let Some(touch) = touch else { return };
        let own = edges.first[edge];
        let radii = ends.map(|disc| discs.radii[disc]);
        let partner = Partner::Disc(ends[1] as u32);
        self.sums.deepest.note(touch.overlap, own as usize, radii[0], partner, radii[1]);
        let push = touch.push(scene.law, edges.damping[edge]);
        self.forces.push((own, push.along(touch.normal)));
    }
}

impl Forces {
    /// Finds all forces on the discs of a block; the springs of its contacts move on by a step.
    pub(super) fn find(
        &mut self,
        block: &mut Block,
        own: &Own<'_>,
        edges: &EdgeForces,
        near: &mut Near,
        scene: &Scene<'_>,
    ) {
        let count = own.positions.len();
        // The drift has left them at zero.
        if self.forces.len() != count {
            self.forces.clear_to(count);
        }
        self.sums.clear(scene, block.start);
        self.touched.clear();
        if scene.law.has_friction() {
            self.tangential.resize(count, [0.0; 2]);
            self.tangential.as_flattened_mut().fill(0.0);
            self.rolling.resize(count, 0.0);
            self.rolling.fill(0.0);
            rubbing::inner_pairs(&mut block.inner, own, scene, self);
        } else {
            self.tangential.clear();
            self.rolling.clear();
            let (pairs, law) = (&block.inner, scene.law);
            let (forces, deepest) = (&mut self.forces, &mut self.sums.deepest);
            let lanes = Lanes { pairs, scope: &scene.scope, own, law };
            let memory = Memory { near, touching: &mut self.touching, touched: &mut self.touched };
            if !scene.use_lanes || !lanes::inner_pairs(&lanes, memory, forces, deepest) {
                let end = pairs.in_tiers(scene.scope.tiers);
                inner_pairs(pairs, end, own, law, forces, deepest);
            }
        }
        for &(disc, force) in &edges.forces {
            add(&mut self.forces[disc as usize], force);
            self.touched.note(disc);
        }
        for (&(disc, _), &rub) in edges.forces.iter().zip(&edges.rubs) {
            self.add_rub(disc as usize, rub);
        }
        self.walls(block, own, scene);
        self.sums.add(&edges.sums);
    }

    /// Adds what friction does to a disc.
    #[inline]
    fn add_rub(&mut self, disc: usize, ([force, dashpot], rolling_torque): RimForce) {
        let sum = self.tangential[disc];
        self.tangential[disc] = [sum[0] + force, sum[1] + dashpot];
        self.rolling[disc] += rolling_torque;
    }

    fn walls(&mut self, block: &mut Block, own: &Own<'_>, scene: &Scene<'_>) {
        for pair in &mut block.walls {
            let disc = pair.disc as usize;
            let wall = &scene.walls[pair.wall as usize];
            let radius = own.radii[disc];
            let [vx, vy] = own.velocities[disc];
            let footing = wall.shape.footing(own.positions[disc]);
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
                rolling_rate: own.spins[disc] - wall.spin,
                surface_speed: radius * own.spins[disc],
            };
            let partner = Partner::Wall(pair.wall);
            self.sums.deepest.note(touch.overlap, disc, radius, partner, radius);
            let push = touch.push(scene.law, pair.damping);
            let mut on_disc = push.along(normal);
            if scene.law.has_friction() {
                let (law, stretch) = (scene.law, &mut pair.stretch);
                let constants = law.materials.with_walls(own.materials[disc]);
                let reduced_radius = law.has_rolling_friction().then_some(radius);
                let rub =
                    touch.rub(law, constants, scene.time_step, reduced_radius, &push, stretch);
                self.sums.take(&rub, 1.0);
                on_disc = push.and(&rub, normal);
                self.add_rub(disc, ([rub.force, rub.dashpot], rub.rolling_torque));
            }
            add(&mut self.forces[disc], on_disc);
            self.touched.note(pair.disc);
            let [u, v] = wall.surface_velocity(wall.mid_velocity, normal);
            self.sums.wall_dissipation -= on_disc[2] * u + on_disc[3] * v;
            let by_wall = &mut self.sums.walls[pair.wall as usize];
            let [fx, fy, ..] = on_disc;
            *by_wall = [by_wall[0] + fx, by_wall[1] + fy, by_wall[2] + (fx * u + fy * v)];
        }
    }
}

/// Pairs without friction, those before an end. `lanes` does the same for four pairs at a time.
fn inner_pairs(
    pairs: &Pairs,
    end: usize,
    own: &Own<'_>,
    law: &ContactLaw,
    forces: &mut [[f64; 4]],
    deepest: &mut Deepest,
) {
    let ends = pairs.first[..end].iter().zip(&pairs.second[..end]);
    let constants = pairs.reach[..end].iter().zip(&pairs.damping[..end]);
    for ((&first, &second), (&reach, &damping)) in ends.zip(constants) {
        let (a, b) = (first as usize, second as usize);
        let ([x, y], [other_x, other_y]) = (own.positions[a], own.positions[b]);
        let apart = [x - other_x, y - other_y];
        let squared = apart[0] * apart[0] + apart[1] * apart[1];
        if squared < reach * reach {
            let ([vx, vy], [other_vx, other_vy]) = (own.velocities[a], own.velocities[b]);
            let touch = Touch::of(apart, squared, reach, [vx - other_vx, vy - other_vy]);
            if touch.overlap > deepest.bound() {
                deepest.note_pair(touch.overlap, [a, b], own.radii);
            }
            let push = touch.push(law, damping).along(touch.normal);
            add(&mut forces[a], push);
            add(&mut forces[b], push.map(|part| -part));
        }
    }
}

impl ContactSums {
    /// Nothing yet, in a scene, for the block of the discs from `start` on.
    pub(super) fn clear(&mut self, scene: &Scene<'_>, start: usize) {
        let mut walls = std::mem::take(&mut self.walls);
        walls.clear();
        walls.resize(scene.walls.len(), [0.0; 3]);
        let (over_radius, smallest_radius) = (scene.known_overlap, scene.smallest_radius);
        let deepest = Deepest { over_radius, ends: None, smallest_radius, start };
        *self = Self { walls, deepest, ..Self::default() };
    }

    /// Adds those of other contacts.
    pub(super) fn add(&mut self, other: &Self) {
        self.elastic += other.elastic;
        self.friction += other.friction;
        self.rolling += other.rolling;
        self.wall_dissipation += other.wall_dissipation;
        self.walls.resize(other.walls.len(), [0.0; 3]);
        for (sum, part) in self.walls.iter_mut().zip(&other.walls) {
            *sum = [sum[0] + part[0], sum[1] + part[1], sum[2] + part[2]];
        }
        self.deepest.take(&other.deepest);
    }

    #[inline]
    fn take(&mut self, rub: &Rub, share: f64) {
        self.elastic += share * rub.elastic;
        self.friction += share * rub.friction_loss;
        self.rolling += share * rub.rolling_loss;
    }

    /// The contact has ended: what its springs still held is lost to friction.
    #[inline]
    fn let_go(&mut self, stretch: &mut Stretch, law: &ContactLaw, share: f64) {
        let half = 0.5 * law.tangential_stiffness * share;
        self.friction += half * stretch[0] * stretch[0];
        self.rolling += half * stretch[1] * stretch[1];
        *stretch = [0.0; 2];
    }
}

#[inline]
fn add(sum: &mut [f64; 4], part: [f64; 4]) {
    *sum = [sum[0] + part[0], sum[1] + part[1], sum[2] + part[2], sum[3] + part[3]];
}

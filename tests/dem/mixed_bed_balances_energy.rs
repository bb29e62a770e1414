//! Law: in a bed of two materials of unequal stiffness, restitution and cohesion, with friction and rolling friction, the kinetic energy changes
//! by the work of all forces and torques, and the energies of springs and cohesion, dashpots, friction and rolling friction are those of the
//! energy balance.
//!
//! Source: m (v' - v) . (v' + v)/2 = m (v'^2 - v^2)/2, an identity, and the same of the spins. Forces, springs and spins are computed here
//! independently, over all pairs, from the recorded positions and the integrator's velocities: springs in series, Coaplen, Stronge and Ravani,
//! Int. J. Impact Eng. 30 (2004) 581, and the potential energy k delta^2/2 - F_c delta.
//! Setup: 60 discs of mixed radii that collapse in a narrow box, 3000 steps, 12,000 of spheres: both tails, linear springs with all kinds of friction; spheres of two
//! moduli and discs of one material with cohesion, without friction.
//! Tolerance: 1e-11 of the sum of |work| and of the energies, for the rounding of the sums; 1e-9 of the largest spin.
//! Control: the arithmetic mean of stiffnesses, 1 + 1e-6 of the cohesion, and a potential energy without cohesion are rejected.

use crate::scene::{
    Disc, discs, energy, material, non_negative, per_contact, positive, prepared, restitution,
    run_to, spring, time_step,
};
use kinetoscope_manifest::model::{DemConfig, DemMaterial, DiscRadius, Elasticity};
use kinetoscope_manifest::quantity::{NonNegative, Positive};
use kinetoscope_physics::dem::restitution::damping_ratio;
use std::collections::BTreeMap;
use std::num::NonZeroU32;

const STIFFNESS: f64 = 5e4;
/// Young's modulus, Pa; Poisson's ratio is 0.3.
const MODULUS: f64 = 3e8;
const SIDE: f64 = 0.012;
/// Steps with linear springs, and with Hertz's law, whose time steps are shorter.
const STEPS: [u64; 2] = [3000, 12_000];
/// Of the walls.
const WALL: Material =
    Material { restitution: 0.7, friction: 0.3, rolling: 0.05, stiffness: 1.0, cohesion: 0.02 };
const LIGHT: Material =
    Material { restitution: 0.9, friction: 0.5, rolling: 0.1, stiffness: 3.0, cohesion: 0.04 };
const HEAVY: Material =
    Material { restitution: 0.5, friction: 0.2, rolling: 0.02, stiffness: 0.25, cohesion: 0.01 };

#[derive(Clone, Copy)]
struct Material {
    restitution: f64,
    friction: f64,
    rolling: f64,
    stiffness: f64,
    cohesion: f64,
}

/// A kind of bed.
#[derive(Clone, Copy)]
struct Case {
    tail: bool,
    hertz: bool,
    /// Whether discs are of two materials; else all are as the walls.
    is_mixed: bool,
    has_friction: bool,
}

/// What the reference changes, for the controls.
#[derive(Clone, Copy)]
struct Changed {
    arithmetic_mean: bool,
    cohesion_factor: f64,
    /// Factor of the potential energy of cohesion.
    potential_factor: f64,
}

const UNCHANGED: Changed =
    Changed { arithmetic_mean: false, cohesion_factor: 1.0, potential_factor: 1.0 };

/// The mixing rules.
fn mixed(one: Material, other: Material, changed: Changed) -> Material {
    let (k, l) = (one.stiffness, other.stiffness);
    let squared = |of: Material| of.restitution * of.restitution;
    let smaller = |a: f64, b: f64| if a < b { a } else { b };
    Material {
        restitution: libm::sqrt((squared(one) * l + squared(other) * k) / (k + l)),
        friction: smaller(one.friction, other.friction),
        rolling: smaller(one.rolling, other.rolling),
        stiffness: if changed.arithmetic_mean { 0.5 * (k + l) } else { 2.0 / (1.0 / k + 1.0 / l) },
        cohesion: changed.cohesion_factor * libm::sqrt(one.cohesion * other.cohesion),
    }
}

fn listed(name: &str, density: f64, of: Material, has_friction: bool) -> DemMaterial {
    let factor = if has_friction { 1.0 } else { 0.0 };
    let mut listed = material(name, of.restitution, factor * of.friction);
    listed.density_ratio = positive(density);
    listed.constants.rolling_friction = NonNegative::new(factor * of.rolling);
    listed.constants.stiffness_ratio = Positive::new(of.stiffness);
    listed.constants.cohesion_n = NonNegative::new(of.cohesion);
    listed
}

fn bed(case: Case) -> DemConfig {
    let factor = if case.has_friction { 1.0 } else { 0.0 };
    let materials = vec![
        listed("light", 1.0, LIGHT, case.has_friction),
        listed("heavy", 2.0, HEAVY, case.has_friction),
    ];
    DemConfig {
        discs: NonZeroU32::new(60).expect("not zero"),
        radius_m: DiscRadius::Uniform { min: positive(3e-4), max: positive(7e-4) },
        width_m: positive(SIDE),
        height_m: positive(SIDE),
        dissipation: restitution(WALL.restitution),
        limit_damping: case.tail,
        elasticity: match case.hertz {
            true => Elasticity::Hertz(positive(MODULUS)),
            false => spring(STIFFNESS),
        },
        friction: non_negative(factor * WALL.friction),
        rolling_friction: non_negative(factor * WALL.rolling),
        cohesion_n: non_negative(WALL.cohesion),
        materials: if case.is_mixed { materials } else { Vec::new() },
        time_step: per_contact(20.0),
        ..DemConfig::default()
    }
}

/// The geometry of a contact, with the velocities of a disc relative to its partner.
struct Geometry {
    /// From the partner to the disc.
    normal: [f64; 2],
    overlap: f64,
    /// The overlap at the step before.
    before: f64,
    mass: f64,
    reduced_radius: f64,
    /// Distances from both centers to the contact point; the second is 0 of a wall.
    arms: [f64; 2],
    /// At the step before and in the middle of the step, m/s.
    velocities: [[f64; 2]; 2],
}

/// Sums over the contacts of a step.
#[derive(Default)]
struct Step {
    /// Force, N, and torque, N m, on each disc.
    forces: Vec<[f64; 3]>,
    dashpot_j: f64,
    friction_j: f64,
    rolling_j: f64,
    normal_j: f64,
    tangential_j: f64,
    contacts: u64,
}

impl Step {
    /// Adds a force on a disc and its partner, and the torques on both.
    fn apply(&mut self, ends: [usize; 2], force: [f64; 2], torques: [f64; 2]) {
        for (end, sign) in [(0, 1.0), (1, -1.0)] {
            if let Some(on_disc) = self.forces.get_mut(ends[end]) {
                on_disc[0] += sign * force[0];
                on_disc[1] += sign * force[1];
                on_disc[2] += torques[end];
            }
        }
    }
}

/// The independent calculation: springs by the two discs, or a disc and a wall, and the spins half a step behind.
struct Reference {
    case: Case,
    changed: Changed,
    time_step: f64,
    springs: BTreeMap<[usize; 2], [f64; 2]>,
    spins: Vec<f64>,
}

impl Reference {
    fn material(&self, disc: &Disc) -> Material {
        let equal = 1e-3 * disc.radius * disc.radius / (5e-4 * 5e-4);
        match (self.case.is_mixed, disc.mass > 1.5 * equal) {
            (false, _) => WALL,
            (true, true) => HEAVY,
            (true, false) => LIGHT,
        }
    }

    /// Elastic force, damping and potential energy without cohesion.
    fn normal(&self, pair: Material, contact: &Geometry) -> [f64; 3] {
        let Geometry { overlap, mass, reduced_radius, .. } = *contact;
        let zeta = damping_ratio(pair.restitution, self.case.tail);
        if !self.case.hertz {
            let k = pair.stiffness * STIFFNESS;
            return [k * overlap, 2.0 * zeta * libm::sqrt(k * mass), 0.5 * k * overlap * overlap];
        }
        let modulus = pair.stiffness * MODULUS / (2.0 * (1.0 - 0.09));
        let kappa = 4.0 / 3.0 * modulus * libm::sqrt(reduced_radius);
        let damping = zeta * libm::sqrt(5.0 * mass * kappa) * libm::pow(overlap, 0.25);
        [kappa * libm::pow(overlap, 1.5), damping, 0.4 * kappa * libm::pow(overlap, 2.5)]
    }

    /// Force of a spring with a slider, its stretch and the loss.
    fn slide(k: f64, before: f64, travel: f64, dashpot: f64, limit: f64) -> [f64; 4] {
        let stretched = before + travel;
        let trial = dashpot - k * stretched;
        if trial.abs() <= limit {
            return [trial, stretched, 0.0, dashpot];
        }
        let force = if trial > 0.0 { limit } else { -limit };
        let stretch = -force / k;
        [force, stretch, 0.5 * k * (before + stretch) * (stretched - stretch), 0.0]
    }

    /// Adds a contact of a disc and its partner, whose number is beyond the discs for a wall.
    fn add(&mut self, sum: &mut Step, ends: [usize; 2], pair: Material, contact: &Geometry) {
        let springs = self.springs.remove(&ends).unwrap_or([0.0; 2]);
        let tangential = 2.0 / 7.0 * pair.stiffness * STIFFNESS;
        let stored = |stretch: f64| 0.5 * tangential * stretch * stretch;
        let [nx, ny] = contact.normal;
        if contact.overlap <= 0.0 {
            sum.friction_j += stored(springs[0]);
            sum.rolling_j += stored(springs[1]);
            if contact.before > 0.0 {
                let part = contact.before / (contact.before - contact.overlap) - 0.5;
                let attraction = pair.cohesion * part;
                sum.apply(ends, [-attraction * nx, -attraction * ny], [0.0; 2]);
            }
            return;
        }
        let along = |[x, y]: [f64; 2]| [x * nx + y * ny, y * nx - x * ny];
        let [[speed, slip], [mid_speed, mid_slip]] = contact.velocities.map(along);
        let [elastic, damping, potential] = self.normal(pair, contact);
        let mut pressing = elastic - damping * speed;
        if self.case.tail && pressing < 0.0 {
            pressing = 0.0;
        }
        sum.contacts += 1;
        sum.dashpot_j += (elastic - pressing) * mid_speed * self.time_step;
        sum.normal_j += potential - self.changed.potential_factor * pair.cohesion * contact.overlap;
        let (mut tangent, mut torques) = (0.0, [0.0; 2]);
        if self.case.has_friction {
            let limit = if pressing > 0.0 { pressing } else { 0.0 };
            let spin = |end: usize| self.spins.get(ends[end]).copied().unwrap_or(0.0);
            let [arm, other_arm] = contact.arms;
            let surface = slip - (arm * spin(0) + other_arm * spin(1));
            let step = self.time_step;
            let dashpot = -0.5 * damping * surface;
            let [force, stretch, loss, held] =
                Self::slide(tangential, springs[0], surface * step, dashpot, pair.friction * limit);
            let travel = contact.reduced_radius * (spin(0) - spin(1)) * step;
            let [roll, rolled, rolling_loss, _] =
                Self::slide(tangential, springs[1], travel, 0.0, pair.rolling * limit);
            sum.friction_j += loss;
            sum.rolling_j += rolling_loss;
            sum.tangential_j += stored(stretch) + stored(rolled);
            // The dashpot's work needs the spins in the middle of the step; it is completed in `dashpot_of_spins`.
            sum.dashpot_j -= held * mid_slip * step;
            tangent = force;
            let lever = contact.reduced_radius * roll;
            torques = [-arm * force + lever, -other_arm * force - lever];
            self.springs.insert(ends, [stretch, rolled]);
            self.add_held(sum, ends, [arm * held, other_arm * held]);
        }
        // In the first step of a contact, for the part of the way with an overlap, and half of the next one.
        let entered = 0.5 + contact.overlap / (contact.overlap - contact.before);
        let normal = pressing - pair.cohesion * if contact.before > 0.0 { 1.0 } else { entered };
        let force = [normal * nx - tangent * ny, normal * ny + tangent * nx];
        sum.apply(ends, force, torques);
    }

    /// Notes the torques of dashpots on both ends.
    fn add_held(&self, sum: &mut Step, ends: [usize; 2], torques: [f64; 2]) {
        let discs = self.spins.len();
        for (end, torque) in ends.into_iter().zip(torques).filter(|(end, _)| *end < discs) {
            sum.forces[discs + end][2] += torque;
        }
    }

    /// All contacts of a state. Springs advance by a step.
    fn step(&mut self, state: &[Disc]) -> Step {
        let count = state.len();
        // Behind the discs, the torques of dashpots.
        let mut sum = Step { forces: vec![[0.0; 3]; 2 * count], ..Step::default() };
        for (index, disc) in state.iter().enumerate() {
            for (number, other) in state.iter().enumerate().skip(index + 1) {
                let branch = [0, 1].map(|axis: usize| disc.position[axis] - other.position[axis]);
                let distance = libm::sqrt(branch[0] * branch[0] + branch[1] * branch[1]);
                let overlap = disc.radius + other.radius - distance;
                let apart = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
                let contact = Geometry {
                    normal: branch.map(|part| part / distance),
                    overlap,
                    before: {
                        let way = apart(disc.step_velocity, other.step_velocity);
                        let then =
                            [0, 1].map(|axis: usize| branch[axis] - way[axis] * self.time_step);
                        disc.radius + other.radius
                            - libm::sqrt(then[0] * then[0] + then[1] * then[1])
                    },
                    mass: 1.0 / (1.0 / disc.mass + 1.0 / other.mass),
                    reduced_radius: 1.0 / (1.0 / disc.radius + 1.0 / other.radius),
                    arms: [disc.radius, other.radius].map(|radius| radius - 0.5 * overlap),
                    velocities: [
                        apart(disc.step_velocity, other.step_velocity),
                        apart(disc.velocity, other.velocity),
                    ],
                };
                let pair = mixed(self.material(disc), self.material(other), self.changed);
                self.add(&mut sum, [index, number], pair, &contact);
            }
            for wall in 0..4 {
                let (axis, sign) = (wall / 2, [1.0, -1.0][wall % 2]);
                let mut normal = [0.0; 2];
                normal[axis] = sign;
                let position = disc.position[axis];
                let distance = if sign > 0.0 { position } else { SIDE - position };
                let contact = Geometry {
                    normal,
                    overlap: disc.radius - distance,
                    before: disc.radius - distance
                        + sign * disc.step_velocity[axis] * self.time_step,
                    mass: disc.mass,
                    reduced_radius: disc.radius,
                    arms: [distance, 0.0],
                    velocities: [disc.step_velocity, disc.velocity],
                };
                let pair = mixed(self.material(disc), WALL, self.changed);
                self.add(&mut sum, [index, 2 * count + wall], pair, &contact);
            }
        }
        self.dashpot_of_spins(state, &mut sum);
        sum
    }

    /// Completes the work of the tangential dashpots by that on the spins in the middle of the step.
    fn dashpot_of_spins(&self, state: &[Disc], sum: &mut Step) {
        for (index, disc) in state.iter().enumerate() {
            let alpha = sum.forces[index][2] / (0.5 * disc.mass * disc.radius * disc.radius);
            let mid = self.spins[index] + 0.5 * alpha * self.time_step;
            sum.dashpot_j += sum.forces[state.len() + index][2] * mid * self.time_step;
        }
    }
}

/// Deviations of a run from the reference.
#[derive(Debug)]
struct Outcome {
    /// |dKE - work| over the sum of |work|.
    imbalance: f64,
    /// Largest relative difference of the recorded energies: dashpots, friction, rolling, normal forces, tangential springs.
    energy_error: f64,
    /// Largest difference of a spin over the largest spin.
    spin_error: f64,
    contact_steps: u64,
}

/// Kinetic energy of velocities and spins half a step behind, J.
fn kinetic(state: &[Disc], spins: &[f64]) -> f64 {
    let of_disc = |(disc, spin): (&Disc, &f64)| {
        let [vx, vy] = disc.step_velocity;
        0.5 * disc.mass * (vx * vx + vy * vy + 0.5 * disc.radius * disc.radius * spin * spin)
    };
    state.iter().zip(spins).map(of_disc).sum()
}

fn outcome(case: Case, changed: Changed) -> Outcome {
    let mut model = prepared(&bed(case));
    let time_step = time_step(&model);
    let mut state = discs(&model);
    let (springs, spins) = (BTreeMap::new(), vec![0.0; state.len()]);
    let mut reference = Reference { case, changed, time_step, springs, spins };
    let start = kinetic(&state, &reference.spins);
    let (mut work, mut throughput) = (0.0, 0.0);
    let mut sums = Step::default();
    let (mut spin_error, mut largest_spin) = (0.0_f64, 0.0_f64);
    let steps = STEPS[usize::from(case.hertz)];
    for count in 1..=steps + 1 {
        let found = reference.step(&state);
        let is_last = count > steps;
        // At the time of a frame, the recorded energy includes half a step of the current power.
        sums.dashpot_j += if is_last { 0.5 } else { 1.0 } * found.dashpot_j;
        sums.friction_j += found.friction_j;
        sums.rolling_j += found.rolling_j;
        (sums.normal_j, sums.tangential_j) = (found.normal_j, found.tangential_j);
        sums.contacts += found.contacts;
        let mut done = 0.0;
        for (index, disc) in state.iter().enumerate() {
            let [fx, fy, torque] = found.forces[index];
            let alpha = torque / (0.5 * disc.mass * disc.radius * disc.radius);
            let spin = reference.spins[index];
            let mid = spin + 0.5 * alpha * time_step;
            let difference = (disc.spin - mid).abs();
            spin_error = if difference > spin_error { difference } else { spin_error };
            largest_spin = if mid.abs() > largest_spin { mid.abs() } else { largest_spin };
            let [vx, vy] = disc.velocity;
            done += (fx * vx + (fy - 9.81 * disc.mass) * vy + torque * mid) * time_step;
            if !is_last {
                reference.spins[index] = spin + alpha * time_step;
            }
        }
        if !is_last {
            work += done;
            throughput += done.abs();
            run_to(&mut model, count);
            state = discs(&model);
        }
    }
    let recorded = energy(&model);
    let dashpot = recorded.dissipated_j - recorded.friction_j - recorded.rolling_j;
    let pairs = [
        (dashpot, sums.dashpot_j),
        (recorded.friction_j, sums.friction_j),
        (recorded.rolling_j, sums.rolling_j),
        (recorded.elastic_j - recorded.elastic_tangential_j, sums.normal_j),
        (recorded.elastic_tangential_j, sums.tangential_j),
    ];
    let error = |(found, expected): (f64, f64)| {
        if expected == 0.0 { found.abs() } else { (found / expected - 1.0).abs() }
    };
    Outcome {
        imbalance: (kinetic(&state, &reference.spins) - start - work).abs() / throughput,
        energy_error: pairs.into_iter().map(error).fold(0.0, |a, b| if b > a { b } else { a }),
        spin_error: if largest_spin > 0.0 { spin_error / largest_spin } else { spin_error },
        contact_steps: sums.contacts,
    }
}

fn cases() -> Vec<(&'static str, Case)> {
    let case = |tail, hertz, is_mixed, has_friction| Case { tail, hertz, is_mixed, has_friction };
    vec![
        ("two materials with friction", case(false, false, true, true)),
        ("two materials with friction, clamped", case(true, false, true, true)),
        ("spheres of two moduli", case(true, true, true, false)),
        ("one cohesive material", case(false, false, false, false)),
        ("one cohesive material with friction", case(true, false, false, true)),
    ]
}

#[test]
fn work_and_energies_agree_with_the_reference() {
    for (name, case) in cases() {
        let found = outcome(case, UNCHANGED);
        println!("{name}: {found:?}");
        assert!(found.contact_steps > 10_000, "{name}");
        assert!(found.imbalance < 1e-11, "{name}: {:e}", found.imbalance);
        assert!(found.energy_error < 1e-11, "{name}: {:e}", found.energy_error);
        assert!(found.spin_error < 1e-9, "{name}: {:e}", found.spin_error);
    }
}

#[test]
fn control_other_laws_are_rejected() {
    let (_, case) = cases()[0];
    for changed in [
        Changed { arithmetic_mean: true, ..UNCHANGED },
        Changed { cohesion_factor: 1.0 + 1e-6, ..UNCHANGED },
    ] {
        let found = outcome(case, changed);
        println!("{found:?}");
        assert!(found.imbalance > 1e-10, "{:e}", found.imbalance);
    }
    let found = outcome(case, Changed { potential_factor: 0.0, ..UNCHANGED });
    println!("without the energy of cohesion: {found:?}");
    assert!(found.energy_error > 1e-3, "{:e}", found.energy_error);
}

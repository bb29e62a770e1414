//! Forces of the pairs of a block that rub against each other, in the order of its list.
//!
//! A pair's tangential force f acts on both rims: the torque on either disc is -r f, whichever of the two is the first. So
//! f is summed disc by disc, and multiplied by the radius once.

use crate::dem::forces::contact::ContactLaw;
use crate::dem::forces::rubbing_lanes;
use crate::dem::forces::touch::{Rub, Touch};
use crate::dem::forces::{Deepest, Forces, Own, Scene};
use crate::dem::neighbors::Pairs;
use crate::dem::turn;

/// Energies are summed in so many lanes; as many pairs at most are taken at a time.
pub(in crate::dem) const SUM_LANES: usize = 8;

/// Discs of a block, as their pairs see them.
pub(in crate::dem) struct Sight<'a> {
    /// Centers, m.
    pub(in crate::dem) positions: &'a [[f64; 2]],
    /// Velocities, m/s.
    pub(in crate::dem) velocities: &'a [[f64; 2]],
    /// Speeds r w of the rims, m/s.
    pub(in crate::dem) rim_speeds: &'a [f64],
    /// Angular velocities, rad/s.
    pub(in crate::dem) spins: &'a [f64],
    /// Radii, m.
    pub(in crate::dem) radii: &'a [f64],
    /// Materials, by their number.
    pub(in crate::dem) materials: &'a [u8],
    pub(in crate::dem) law: &'a ContactLaw,
    pub(in crate::dem) time_step: f64,
    /// Pairs up to here are looked at.
    pub(in crate::dem) end: usize,
}

/// What pairs add to.
pub(in crate::dem) struct Totals<'a> {
    /// Fx, Fy, Dx, Dy of each disc, N.
    pub(in crate::dem) forces: &'a mut [[f64; 4]],
    /// Tangential force on the rim of each disc and the dashpots' share of it, N.
    pub(in crate::dem) tangential: &'a mut [[f64; 2]],
    /// Torque of the rolling springs on each disc, N m.
    pub(in crate::dem) rolling: &'a mut [f64],
    pub(in crate::dem) energies: LaneSums,
    pub(in crate::dem) deepest: &'a mut Deepest,
}

/// Energies, J, of the pairs whose numbers leave the same remainder when divided by eight. How many pairs are taken at a
/// time changes no bit of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::dem) struct LaneSums {
    /// Held by the tangential and rolling springs.
    pub(in crate::dem) elastic: [f64; SUM_LANES],
    /// Taken by friction.
    pub(in crate::dem) friction: [f64; SUM_LANES],
    /// Taken by rolling friction.
    pub(in crate::dem) rolling: [f64; SUM_LANES],
}

/// Adds the forces of a block's inner pairs; the springs of its contacts move on by a step.
pub(in crate::dem) fn inner_pairs(
    pairs: &mut Pairs,
    own: &Own<'_>,
    scene: &Scene<'_>,
    forces: &mut Forces,
) {
    turn::find_rim_speeds(&mut forces.rim_speeds, own.radii, own.spins);
    let sight = Sight {
        positions: own.positions,
        velocities: own.velocities,
        rim_speeds: &forces.rim_speeds,
        spins: own.spins,
        radii: own.radii,
        materials: own.materials,
        law: scene.law,
        time_step: scene.time_step,
        end: pairs.in_tiers(scene.scope.tiers),
    };
    let mut totals = Totals {
        forces: &mut forces.forces,
        tangential: &mut forces.tangential,
        rolling: &mut forces.rolling,
        energies: LaneSums::default(),
        deepest: &mut forces.sums.deepest,
    };
    let most = if scene.use_lanes { SUM_LANES } else { 1 };
    in_lanes(pairs, &sight, &mut totals, most);
    let LaneSums { elastic, friction, rolling } = totals.energies;
    let sum =
        |[a, b, c, d, e, f, g, h]: [f64; SUM_LANES]| ((a + e) + (c + g)) + ((b + f) + (d + h));
    forces.sums.elastic += sum(elastic);
    forces.sums.friction += sum(friction);
    forces.sums.rolling += sum(rolling);
}

/// At most `most` pairs at a time, where the machine can; then the few that are left, or all, one by one.
pub(in crate::dem) fn in_lanes(
    pairs: &mut Pairs,
    sight: &Sight<'_>,
    totals: &mut Totals<'_>,
    most: usize,
) {
    let done = rubbing_lanes::inner_pairs(pairs, sight, totals, most);
    pair_by_pair(pairs, done, sight, totals);
}

/// Pairs from number `from` on. `rubbing_lanes` does the same for four pairs at a time.
fn pair_by_pair(pairs: &mut Pairs, from: usize, sight: &Sight<'_>, totals: &mut Totals<'_>) {
    let Pairs { first, second, reach, damping, stretch, rolling_stretch, .. } = pairs;
    let (law, rolls) = (sight.law, sight.law.has_rolling_friction());
    let ends = first.iter().zip(&*second);
    let constants = reach.iter().zip(&*damping).zip(stretch).enumerate();
    for ((&a, &b), (number, ((&reach, &damping), sliding))) in
        ends.zip(constants).take(sight.end).skip(from)
    {
        let (ends, lane) = ([a as usize, b as usize], number % SUM_LANES);
        let [[x, y], [other_x, other_y]] = ends.map(|disc| sight.positions[disc]);
        let mut stretch = [*sliding, if rolls { rolling_stretch[number] } else { 0.0 }];
        let apart = [x - other_x, y - other_y];
        let squared = apart[0] * apart[0] + apart[1] * apart[1];
        if squared < reach * reach {
            let [[vx, vy], [other_vx, other_vy]] = ends.map(|disc| sight.velocities[disc]);
            let velocity = [vx - other_vx, vy - other_vy];
            let spins = ends.map(|disc| sight.spins[disc]);
            let radii = ends.map(|disc| sight.radii[disc]);
            let touch = Touch::of(apart, squared, reach, velocity).turning(spins, radii);
            if touch.overlap > totals.deepest.bound() {
                totals.deepest.note_pair(touch.overlap, ends, sight.radii);
            }
            let push = touch.push(law, damping);
            let [first, second] = ends.map(|disc| sight.materials[disc]);
            let pair = law.materials.between(first, second);
            let reduced_radius = rolls.then(|| radii[0] * radii[1] / reach);
            let rub = touch.rub(law, pair, sight.time_step, reduced_radius, &push, &mut stretch);
            totals.energies.take(&rub, lane);
            totals.add(ends, push.and(&rub, touch.normal), &rub);
        } else {
            totals.energies.let_go(&mut stretch, law, lane);
        }
        *sliding = stretch[0];
        if rolls {
            rolling_stretch[number] = stretch[1];
        }
    }
}

impl LaneSums {
    #[inline]
    fn take(&mut self, rub: &Rub, lane: usize) {
        self.elastic[lane] += rub.elastic;
        self.friction[lane] += rub.friction_loss;
        self.rolling[lane] += rub.rolling_loss;
    }

    /// A pair is apart: what its springs still held is lost to friction.
    #[inline]
    fn let_go(&mut self, stretch: &mut [f64; 2], law: &ContactLaw, lane: usize) {
        let half = 0.5 * law.tangential_stiffness;
        self.friction[lane] += half * stretch[0] * stretch[0];
        self.rolling[lane] += half * stretch[1] * stretch[1];
        *stretch = [0.0; 2];
    }
}

impl Totals<'_> {
    #[inline]
    fn add(&mut self, [a, b]: [usize; 2], on_first: [f64; 4], rub: &Rub) {
        let sum = self.forces[a];
        self.forces[a] = [0, 1, 2, 3].map(|part: usize| sum[part] + on_first[part]);
        let sum = self.forces[b];
        self.forces[b] = [0, 1, 2, 3].map(|part: usize| sum[part] - on_first[part]);
        for disc in [a, b] {
            let [force, dashpot] = self.tangential[disc];
            self.tangential[disc] = [force + rub.force, dashpot + rub.dashpot];
        }
        self.rolling[a] += rub.rolling_torque;
        self.rolling[b] -= rub.rolling_torque;
    }
}

//! Forces of pairs that rub, several at a time: the same operations in the same order as `rubbing::pair_by_pair`, with
//! choices by masks instead of branches, so the same bits (a test compares them).

use crate::dem::forces::Deepest;
use crate::dem::forces::rubbing::{LaneSums, SUM_LANES, Sight, Totals};
use crate::dem::neighbors::Pairs;
use crate::simd::registers::{self, Kernel, Lanes, Machine, Mask};

/// Adds the forces of as many pairs as fill whole registers of at most `most` numbers, and returns how many that were: 0
/// where the machine has none.
pub(in crate::dem) fn inner_pairs(
    pairs: &mut Pairs,
    sight: &Sight<'_>,
    totals: &mut Totals<'_>,
    most: usize,
) -> usize {
    let done = match (sight.law.has_rolling_friction(), sight.law.materials.only().is_none()) {
        (false, false) => registers::run(Rubbing::<false, false> { pairs, sight, totals }, most),
        (false, true) => registers::run(Rubbing::<false, true> { pairs, sight, totals }, most),
        (true, false) => registers::run(Rubbing::<true, false> { pairs, sight, totals }, most),
        (true, true) => registers::run(Rubbing::<true, true> { pairs, sight, totals }, most),
    };
    done.unwrap_or(0)
}

/// The loop; with rolling springs or without, for discs of one material or of several.
struct Rubbing<'a, 'b, const ROLLS: bool, const DIFFER: bool> {
    pairs: &'a mut Pairs,
    sight: &'a Sight<'a>,
    totals: &'a mut Totals<'b>,
}

/// Constants of the contact law, in all lanes.
#[derive(Clone, Copy)]
struct Constants<L> {
    zero: L,
    one: L,
    least_distance: L,
    stiffness: L,
    least_force: L,
    tangential_stiffness: L,
    half_tangential_stiffness: L,
    tangential_compliance: L,
    tangential_damping_share: L,
    time_step: L,
    /// Friction and rolling friction, where all discs are of one material.
    friction: [L; 2],
}

/// Pairs side by side: unit normals from the second discs to the first, overlaps, and velocities against the second.
#[derive(Clone, Copy)]
struct Approach<L> {
    normal: [L; 2],
    overlap: L,
    velocity: [L; 2],
}

/// Normal forces, and their dissipative parts.
struct Push<L> {
    force: L,
    loss: L,
}

/// What springs with sliders do in a step; `loss` is the energy that slipping takes.
struct Moved<L> {
    force: L,
    dashpot: L,
    stretch: L,
    loss: L,
}

impl<L> Constants<L> {
    #[inline(always)]
    fn new<const N: usize>(machine: impl Machine<N, Lanes = L>, sight: &Sight<'_>) -> Self {
        let law = sight.law;
        let friction =
            law.materials.only().map_or([0.0; 2], |one| [one.friction, one.rolling_friction]);
        Self {
            zero: machine.all(0.0),
            one: machine.all(1.0),
            least_distance: machine.all(f64::MIN_POSITIVE),
            stiffness: machine.all(law.stiffness),
            least_force: machine.all(law.least_force()),
            tangential_stiffness: machine.all(law.tangential_stiffness),
            half_tangential_stiffness: machine.all(0.5 * law.tangential_stiffness),
            tangential_compliance: machine.all(1.0 / law.tangential_stiffness),
            tangential_damping_share: machine.all(law.tangential_damping_share),
            time_step: machine.all(sight.time_step),
            friction: [machine.all(friction[0]), machine.all(friction[1])],
        }
    }

    /// `Touch::of`.
    #[inline(always)]
    fn approach<const N: usize>(
        &self,
        [x, y]: [L; 2],
        velocity: [L; 2],
        squared: L,
        reach: L,
    ) -> Approach<L>
    where
        L: Lanes<N>,
    {
        let distance = squared.sqrt();
        let inverse = self.one / distance.larger(self.least_distance);
        Approach { normal: [x * inverse, y * inverse], overlap: reach - distance, velocity }
    }

    /// `Touch::push`.
    #[inline(always)]
    fn push<const N: usize>(&self, pair: &Approach<L>, damping: L) -> Push<L>
    where
        L: Lanes<N>,
    {
        let [nx, ny] = pair.normal;
        let speed = pair.velocity[0] * nx + pair.velocity[1] * ny;
        let spring = self.stiffness * pair.overlap;
        let force = (spring - damping * speed).larger(self.least_force);
        Push { force, loss: spring - force }
    }

    /// `motion::spring_slider`, and the energy that its slip takes.
    #[inline(always)]
    fn slide<const N: usize>(&self, before: L, travel: L, dashpot: L, limit: L) -> Moved<L>
    where
        L: Lanes<N>,
    {
        let stretched = before + travel;
        let trial = dashpot - self.tangential_stiffness * stretched;
        let holds = trial.abs().is_at_most(limit);
        let sliding = limit.or_else(self.zero.is_less(trial), -limit);
        let given = -sliding * self.tangential_compliance;
        let stretch = stretched.or_else(holds, given);
        let slip = self.zero.or_else(holds, stretched - given);
        Moved {
            force: trial.or_else(holds, sliding),
            dashpot: dashpot.only(holds),
            stretch,
            loss: self.half_tangential_stiffness * (before + stretch) * slip,
        }
    }

    /// Energy of stretched springs.
    #[inline(always)]
    fn energy<const N: usize>(&self, stretch: L) -> L
    where
        L: Lanes<N>,
    {
        self.half_tangential_stiffness * stretch * stretch
    }
}

/// A block's list, in groups of as many pairs as a register has lanes.
struct Groups<'a, const N: usize> {
    first: &'a [[u32; N]],
    second: &'a [[u32; N]],
    reach: &'a [[f64; N]],
    damping: &'a [[f64; N]],
    stretch: &'a mut [[f64; N]],
    rolling_stretch: &'a mut [[f64; N]],
}

/// `LaneSums` in registers: one of eight lanes, or two of four.
struct Energies<L> {
    elastic: [L; 2],
    friction: [L; 2],
    rolling: [L; 2],
}

impl<L> Energies<L> {
    #[inline(always)]
    fn put_into<const N: usize>(&self, sums: &mut LaneSums)
    where
        L: Lanes<N>,
    {
        let columns = [&mut sums.elastic, &mut sums.friction, &mut sums.rolling];
        for (column, energies) in
            columns.into_iter().zip([self.elastic, self.friction, self.rolling])
        {
            for (lanes, energy) in column.as_chunks_mut::<N>().0.iter_mut().zip(energies) {
                energy.store(lanes);
            }
        }
    }
}

/// Roots and quotients take long, and forces wait for them: so many groups first meet, and rub afterward.
const BATCH: usize = 16;

/// A group of pairs of which some touch, or touched until now.
#[derive(Clone, Copy)]
struct Meeting<L, T> {
    group: usize,
    touch: T,
    pair: Approach<L>,
}

impl<const ROLLS: bool, const DIFFER: bool> Kernel for Rubbing<'_, '_, ROLLS, DIFFER> {
    type Output = usize;

    #[inline(always)]
    fn run<const N: usize, M: Machine<N>>(self, machine: M) -> usize {
        let Self { pairs, sight, totals } = self;
        let law = Constants::new(machine, sight);
        let mut groups = Groups {
            first: pairs.first.as_chunks().0,
            second: pairs.second.as_chunks().0,
            reach: pairs.reach.as_chunks().0,
            damping: pairs.damping.as_chunks().0,
            stretch: pairs.stretch.as_chunks_mut().0,
            rolling_stretch: pairs.rolling_stretch.as_chunks_mut().0,
        };
        let count = sight.end / N;
        let pair = Approach { normal: [law.zero; 2], overlap: law.zero, velocity: [law.zero; 2] };
        let nobody = Meeting { group: 0, touch: law.zero.is_less(law.zero), pair };
        let mut meetings = [nobody; BATCH];
        let none = [law.zero; 2];
        let mut energies = Energies { elastic: none, friction: none, rolling: none };
        for start in (0..count).step_by(BATCH) {
            let mut met = 0;
            for group in start..Ord::min(start + BATCH, count) {
                if let Some(meeting) = meet::<ROLLS, N, M>(machine, &law, &groups, group, sight) {
                    meetings[met] = meeting;
                    met += 1;
                }
            }
            for meeting in &meetings[..met] {
                let energies = &mut energies;
                rub::<ROLLS, DIFFER, N, M>(
                    machine,
                    &law,
                    &mut groups,
                    meeting,
                    sight,
                    totals,
                    energies,
                );
            }
        }
        energies.put_into(&mut totals.energies);
        count * N
    }
}

/// Who touches of a group, and how; `None` where all are apart and no spring is stretched.
#[inline(always)]
fn meet<const ROLLS: bool, const N: usize, M: Machine<N>>(
    machine: M,
    law: &Constants<M::Lanes>,
    groups: &Groups<'_, N>,
    group: usize,
    sight: &Sight<'_>,
) -> Option<Meeting<M::Lanes, <M::Lanes as Lanes<N>>::Mask>> {
    let mut held = machine.load(&groups.stretch[group]).abs();
    if ROLLS {
        held = held + machine.load(&groups.rolling_stretch[group]).abs();
    }
    let reach = machine.load(&groups.reach[group]);
    let ends = [&groups.first[group], &groups.second[group]];
    let [x, y] = machine.differences(sight.positions, ends);
    let squared = x * x + y * y;
    let touch = squared.is_less(reach * reach);
    if touch.bits() | law.zero.is_less(held).bits() == 0 {
        return None;
    }
    // One length, so that an index is checked once.
    let velocities = &sight.velocities[..sight.positions.len()];
    let velocity = machine.differences(velocities, ends);
    Some(Meeting { group, touch, pair: law.approach([x, y], velocity, squared, reach) })
}

/// Forces of a group's pairs; their springs move on by a step.
#[inline(always)]
fn rub<const ROLLS: bool, const DIFFER: bool, const N: usize, M: Machine<N>>(
    machine: M,
    law: &Constants<M::Lanes>,
    groups: &mut Groups<'_, N>,
    meeting: &Meeting<M::Lanes, <M::Lanes as Lanes<N>>::Mask>,
    sight: &Sight<'_>,
    totals: &mut Totals<'_>,
    energies: &mut Energies<M::Lanes>,
) {
    let &Meeting { group, touch, ref pair } = meeting;
    let ends = [&groups.first[group], &groups.second[group]];
    note_deepest(machine, pair.overlap, touch, ends, sight.radii, totals.deepest);
    let damping = machine.load(&groups.damping[group]);
    let Push { force, loss } = law.push(pair, damping);
    let pressing = force.larger(law.zero);
    let [friction, rolling_friction] =
        if DIFFER { coefficients(machine, ends, sight) } else { law.friction };
    // One length, so that an index is checked once.
    let rim_speeds = &sight.rim_speeds[..totals.forces.len()];
    let tangential = &mut totals.tangential[..totals.forces.len()];
    let rims = gathered(machine, rim_speeds, ends[0]) + gathered(machine, rim_speeds, ends[1]);
    let ([nx, ny], [vx, vy]) = (pair.normal, pair.velocity);
    let speed = vy * nx - vx * ny - rims;
    let before = machine.load(&groups.stretch[group]);
    let dashpot = -(law.tangential_damping_share * damping) * speed;
    let slid = law.slide(before, speed * law.time_step, dashpot, friction * pressing);
    slid.stretch.only(touch).store(&mut groups.stretch[group]);
    let part = group % (SUM_LANES / N);
    let lost = slid.loss.or_else(touch, law.energy(before));
    energies.friction[part] = energies.friction[part] + lost;
    let mut elastic = law.energy(slid.stretch);
    if ROLLS {
        let before = machine.load(&groups.rolling_stretch[group]);
        let reach = machine.load(&groups.reach[group]);
        let limit = rolling_friction * pressing;
        let (turned, torque) = roll(machine, law, ends, reach, before, limit, sight);
        turned.stretch.only(touch).store(&mut groups.rolling_stretch[group]);
        let lost = turned.loss.or_else(touch, law.energy(before));
        energies.rolling[part] = energies.rolling[part] + lost;
        elastic = elastic + law.energy(turned.stretch);
        add_torques(torque.only(touch), totals.rolling, ends);
    }
    energies.elastic[part] = energies.elastic[part] + elastic.only(touch);
    let on_first = [
        (force * nx - slid.force * ny).only(touch),
        (force * ny + slid.force * nx).only(touch),
        (loss * nx + slid.dashpot * ny).only(touch),
        (loss * ny - slid.dashpot * nx).only(touch),
    ];
    // A pair apart adds +0, which changes no bit: a sum that began with +0 is never -0.
    Lanes::add_opposite(on_first, totals.forces, ends);
    let on_rims = [slid.force.only(touch), slid.dashpot.only(touch)];
    Lanes::add_to_both(on_rims, tangential, ends);
}

/// What rolling springs do, and their torques on the first discs, N m.
#[inline(always)]
fn roll<const N: usize, M: Machine<N>>(
    machine: M,
    law: &Constants<M::Lanes>,
    [first, second]: [&[u32; N]; 2],
    reach: M::Lanes,
    before: M::Lanes,
    limit: M::Lanes,
    sight: &Sight<'_>,
) -> (Moved<M::Lanes>, M::Lanes) {
    let radii = gathered(machine, sight.radii, first) * gathered(machine, sight.radii, second);
    let rate = gathered(machine, sight.spins, first) - gathered(machine, sight.spins, second);
    let reduced_radius = radii / reach;
    // Without a dashpot.
    let moved = law.slide(before, reduced_radius * rate * law.time_step, -law.zero, limit);
    let torque = reduced_radius * moved.force;
    (moved, torque)
}

/// A number of each of some discs.
#[inline(always)]
fn gathered<const N: usize, M: Machine<N>>(
    machine: M,
    column: &[f64],
    discs: &[u32; N],
) -> M::Lanes {
    let mut values = [0.0; N];
    for (value, disc) in values.iter_mut().zip(discs) {
        *value = column[*disc as usize];
    }
    machine.of(values)
}

/// Friction and rolling friction where materials differ.
#[inline(always)]
fn coefficients<const N: usize, M: Machine<N>>(
    machine: M,
    [first, second]: [&[u32; N]; 2],
    sight: &Sight<'_>,
) -> [M::Lanes; 2] {
    let (mut friction, mut rolling_friction) = ([0.0; N], [0.0; N]);
    for lane in 0..N {
        let [one, other] = [first[lane], second[lane]].map(|disc| sight.materials[disc as usize]);
        let pair = sight.law.materials.between(one, other);
        (friction[lane], rolling_friction[lane]) = (pair.friction, pair.rolling_friction);
    }
    [machine.of(friction), machine.of(rolling_friction)]
}

/// Adds torques to those on the first discs, and takes them off those on the second.
#[inline(always)]
fn add_torques<const N: usize>(
    torques: impl Lanes<N>,
    sums: &mut [f64],
    [first, second]: [&[u32; N]; 2],
) {
    let mut on_first = [0.0; N];
    torques.store(&mut on_first);
    for (lane, torque) in on_first.into_iter().enumerate() {
        sums[first[lane] as usize] += torque;
        sums[second[lane] as usize] -= torque;
    }
}

#[inline(always)]
fn note_deepest<const N: usize, M: Machine<N>>(
    machine: M,
    overlap: M::Lanes,
    touch: <M::Lanes as Lanes<N>>::Mask,
    ends: [&[u32; N]; 2],
    radii: &[f64],
    deepest: &mut Deepest,
) {
    let is_deeper = machine.all(deepest.bound()).is_less(overlap);
    let deeper = is_deeper.bits() & touch.bits();
    if deeper != 0 {
        let mut overlaps = [0.0; N];
        overlap.store(&mut overlaps);
        for lane in (0..N).filter(|lane| deeper >> lane & 1 == 1) {
            let ends = ends.map(|end| end[lane] as usize);
            deepest.note_pair(overlaps[lane], ends, radii);
        }
    }
}

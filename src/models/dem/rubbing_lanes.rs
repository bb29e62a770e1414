//! Forces of four pairs that rub at a time with AVX2, where the machine has it: the same operations in the same order as
//! `rubbing::pair_by_pair`, with choices by masks instead of branches, so the same bits (a test compares them). No fused
//! multiply-add.
//!
//! What the unsafe code keeps to:
//! - Loads and stores of whole `[f64; 4]` and `[f64; 2]` through their own references: in bounds, and unaligned by instruction.
//! - Columns of discs by a pair's indices, unchecked pair by pair: all indices are checked before the loop.
//! - The call of a function compiled for AVX2, made only where `is_x86_feature_detected!` has found it.

#![allow(unsafe_code)]

use super::neighbours::Pairs;
use super::rubbing::{Sight, Totals};

/// Adds the forces of as many pairs as fill whole lanes, and returns their number: 0 where the machine has no AVX2.
pub(super) fn inner_pairs(pairs: &mut Pairs, sight: &Sight<'_>, totals: &mut Totals<'_>) -> usize {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        let rolls = sight.law.has_rolling_friction();
        let differ = sight.law.materials.only().is_none();
        // SAFETY: the machine has AVX2.
        return unsafe {
            match (rolls, differ) {
                (false, false) => avx2::inner_pairs::<false, false>(pairs, sight, totals),
                (false, true) => avx2::inner_pairs::<false, true>(pairs, sight, totals),
                (true, false) => avx2::inner_pairs::<true, false>(pairs, sight, totals),
                (true, true) => avx2::inner_pairs::<true, true>(pairs, sight, totals),
            }
        };
    }
    0
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::super::rubbing::{LANES, LaneSums};
    use super::{Pairs, Sight, Totals};
    use std::arch::x86_64::{
        __m256d, _CMP_GT_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _CMP_NEQ_UQ, _mm_add_pd, _mm_loadu_pd,
        _mm_storeu_pd, _mm256_add_pd as add, _mm256_and_pd as and, _mm256_andnot_pd as and_not,
        _mm256_blendv_pd as blend, _mm256_castpd256_pd128, _mm256_cmp_pd as compare,
        _mm256_div_pd as div, _mm256_extractf128_pd, _mm256_loadu_pd, _mm256_max_pd as max,
        _mm256_movemask_pd as lanes_of, _mm256_mul_pd as mul, _mm256_or_pd as or,
        _mm256_permute2f128_pd, _mm256_set_pd, _mm256_set1_pd as all, _mm256_sqrt_pd as sqrt,
        _mm256_storeu_pd, _mm256_sub_pd as sub, _mm256_unpackhi_pd, _mm256_unpacklo_pd,
        _mm256_xor_pd as xor,
    };

    #[inline]
    #[target_feature(enable = "avx2")]
    fn load(values: &[f64; 4]) -> __m256d {
        // SAFETY: four f64 lie behind the reference.
        unsafe { _mm256_loadu_pd(values.as_ptr()) }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn store(into: &mut [f64; 4], values: __m256d) {
        // SAFETY: four f64 lie behind the reference.
        unsafe { _mm256_storeu_pd(into.as_mut_ptr(), values) }
    }

    /// Rows to columns, and back.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn transposed(rows: [__m256d; 4]) -> [__m256d; 4] {
        let low = [_mm256_unpacklo_pd(rows[0], rows[1]), _mm256_unpacklo_pd(rows[2], rows[3])];
        let high = [_mm256_unpackhi_pd(rows[0], rows[1]), _mm256_unpackhi_pd(rows[2], rows[3])];
        [
            _mm256_permute2f128_pd::<0x20>(low[0], low[1]),
            _mm256_permute2f128_pd::<0x20>(high[0], high[1]),
            _mm256_permute2f128_pd::<0x31>(low[0], low[1]),
            _mm256_permute2f128_pd::<0x31>(high[0], high[1]),
        ]
    }

    /// With the other sign.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn opposite(values: __m256d) -> __m256d {
        xor(values, all(-0.0))
    }

    /// A row by an index that is known to be in bounds.
    ///
    /// # Safety
    /// `column` is longer than `index`.
    #[inline]
    unsafe fn row<T: Copy>(column: &[T], index: u32) -> T {
        // SAFETY: the caller knows it.
        unsafe { *column.get_unchecked(index as usize) }
    }

    /// Values of four discs.
    ///
    /// # Safety
    /// `column` is longer than every index.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn gathered(column: &[f64], [a, b, c, d]: [u32; 4]) -> __m256d {
        // SAFETY: the caller knows it.
        unsafe { _mm256_set_pd(row(column, d), row(column, c), row(column, b), row(column, a)) }
    }

    /// Adds to the tangential forces on a disc.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn add_to(sum: &mut [f64; 2], part: std::arch::x86_64::__m128d) {
        // SAFETY: two f64 lie behind the reference.
        unsafe { _mm_storeu_pd(sum.as_mut_ptr(), _mm_add_pd(_mm_loadu_pd(sum.as_ptr()), part)) }
    }

    /// Constants of a spring with a slider, each in all lanes.
    #[derive(Clone, Copy)]
    struct Springs {
        stiffness: __m256d,
        half_stiffness: __m256d,
    }

    /// What springs with sliders do in a step; `loss` is the energy that slipping takes.
    struct Moved {
        force: __m256d,
        dashpot: __m256d,
        stretch: __m256d,
        loss: __m256d,
    }

    impl Springs {
        /// `motion::spring_slider`, and the energy that its slip takes.
        #[inline]
        #[target_feature(enable = "avx2")]
        fn slide(
            self,
            before: __m256d,
            travel: __m256d,
            dashpot: __m256d,
            limit: __m256d,
        ) -> Moved {
            let stretched = add(before, travel);
            let trial = sub(dashpot, mul(self.stiffness, stretched));
            let holds = compare::<_CMP_LE_OQ>(and_not(all(-0.0), trial), limit);
            let is_positive = compare::<_CMP_GT_OQ>(trial, all(0.0));
            let sliding = xor(limit, and_not(is_positive, all(-0.0)));
            let given = div(opposite(sliding), self.stiffness);
            let stretch = blend(given, stretched, holds);
            let slip = and_not(holds, sub(stretched, given));
            Moved {
                force: blend(sliding, trial, holds),
                dashpot: and(dashpot, holds),
                stretch,
                loss: mul(mul(self.half_stiffness, add(before, stretch)), slip),
            }
        }

        /// Energy of stretched springs.
        #[inline]
        #[target_feature(enable = "avx2")]
        fn energy(self, stretch: __m256d) -> __m256d {
            mul(mul(self.half_stiffness, stretch), stretch)
        }
    }

    /// Energies by lanes.
    struct Energies {
        elastic: __m256d,
        friction: __m256d,
        rolling: __m256d,
    }

    impl Energies {
        #[inline]
        #[target_feature(enable = "avx2")]
        fn of(sums: &LaneSums) -> Self {
            let LaneSums { elastic, friction, rolling } = sums;
            Self { elastic: load(elastic), friction: load(friction), rolling: load(rolling) }
        }

        #[inline]
        #[target_feature(enable = "avx2")]
        fn put_into(&self, sums: &mut LaneSums) {
            store(&mut sums.elastic, self.elastic);
            store(&mut sums.friction, self.friction);
            store(&mut sums.rolling, self.rolling);
        }
    }

    #[target_feature(enable = "avx2")]
    pub(super) fn inner_pairs<const ROLLS: bool, const DIFFER: bool>(
        pairs: &mut Pairs,
        sight: &Sight<'_>,
        totals: &mut Totals<'_>,
    ) -> usize {
        check_indices(pairs, sight, totals);
        let (firsts, _) = pairs.first.as_chunks::<LANES>();
        let (seconds, _) = pairs.second.as_chunks::<LANES>();
        let (reaches, _) = pairs.reach.as_chunks::<LANES>();
        let (dampings, _) = pairs.damping.as_chunks::<LANES>();
        let (stretches, _) = pairs.stretch.as_chunks_mut::<LANES>();
        let (rolling_stretches, _) = pairs.rolling_stretch.as_chunks_mut::<LANES>();
        let law = sight.law;
        let springs = Springs {
            stiffness: all(law.tangential_stiffness),
            half_stiffness: all(0.5 * law.tangential_stiffness),
        };
        let one_for_all =
            law.materials.only().map_or([0.0; 2], |pair| [pair.friction, pair.rolling_friction]);
        let mut energies = Energies::of(&totals.energies);
        let constants = reaches.iter().zip(dampings).zip(stretches);
        for (number, ((first, second), ((reach, damping), stretch))) in
            firsts.iter().zip(seconds).zip(constants).enumerate()
        {
            let before = load(stretch);
            let rolled = if ROLLS { load(&rolling_stretches[number]) } else { all(0.0) };
            let reach = load(reach);
            let [x, y, vx, vy] = apart(sight, *first, *second);
            let squared = add(mul(x, x), mul(y, y));
            let touch = compare::<_CMP_LT_OQ>(squared, mul(reach, reach));
            let touching = lanes_of(touch);
            let held = compare::<_CMP_NEQ_UQ>(or(before, rolled), all(0.0));
            if touching | lanes_of(held) == 0 {
                continue;
            }
            let distance = sqrt(squared);
            let inverse = div(all(1.0), max(distance, all(f64::MIN_POSITIVE)));
            let (nx, ny) = (mul(x, inverse), mul(y, inverse));
            let overlap = sub(reach, distance);
            note_deepest(overlap, touch, [*first, *second], sight, totals);
            let separating = add(mul(vx, nx), mul(vy, ny));
            let damping = load(damping);
            let spring = mul(all(law.stiffness), overlap);
            let force = max(sub(spring, mul(damping, separating)), all(law.least_force()));
            let loss = sub(spring, force);
            let pressing = max(force, all(0.0));
            let [friction, rolling_friction] = if DIFFER {
                coefficients(sight, first, second)
            } else {
                one_for_all.map(|mu| all(mu))
            };
            // SAFETY: no index reaches beyond.
            let rims = unsafe {
                add(gathered(sight.rim_speeds, *first), gathered(sight.rim_speeds, *second))
            };
            let speed = sub(sub(mul(vy, nx), mul(vx, ny)), rims);
            let dashpot = mul(opposite(mul(all(law.tangential_damping_share), damping)), speed);
            let slid = springs.slide(
                before,
                mul(speed, all(sight.time_step)),
                dashpot,
                mul(friction, pressing),
            );
            let mut elastic = springs.energy(slid.stretch);
            energies.friction =
                add(energies.friction, blend(springs.energy(before), slid.loss, touch));
            store(stretch, and(slid.stretch, touch));
            if ROLLS {
                // SAFETY: no index reaches beyond.
                let [spins, radii] = unsafe {
                    [
                        sub(gathered(sight.spins, *first), gathered(sight.spins, *second)),
                        mul(gathered(sight.radii, *first), gathered(sight.radii, *second)),
                    ]
                };
                let reduced = div(radii, reach);
                let travel = mul(mul(reduced, spins), all(sight.time_step));
                let turned =
                    springs.slide(rolled, travel, all(-0.0), mul(rolling_friction, pressing));
                elastic = add(elastic, springs.energy(turned.stretch));
                energies.rolling =
                    add(energies.rolling, blend(springs.energy(rolled), turned.loss, touch));
                store(&mut rolling_stretches[number], and(turned.stretch, touch));
                let mut torques = [0.0; 4];
                store(&mut torques, and(mul(reduced, turned.force), touch));
                for lane in 0..LANES {
                    totals.rolling[first[lane] as usize] += torques[lane];
                    totals.rolling[second[lane] as usize] -= torques[lane];
                }
            }
            energies.elastic = add(energies.elastic, and(elastic, touch));
            let rows = transposed([
                and(touch, sub(mul(force, nx), mul(slid.force, ny))),
                and(touch, add(mul(force, ny), mul(slid.force, nx))),
                and(touch, add(mul(loss, nx), mul(slid.dashpot, ny))),
                and(touch, sub(mul(loss, ny), mul(slid.dashpot, nx))),
            ]);
            let (tangential, dashpot) = (and(touch, slid.force), and(touch, slid.dashpot));
            let even = _mm256_unpacklo_pd(tangential, dashpot);
            let odd = _mm256_unpackhi_pd(tangential, dashpot);
            let rims = [
                _mm256_castpd256_pd128(even),
                _mm256_castpd256_pd128(odd),
                _mm256_extractf128_pd::<1>(even),
                _mm256_extractf128_pd::<1>(odd),
            ];
            for lane in 0..LANES {
                let (a, b) = (first[lane] as usize, second[lane] as usize);
                // SAFETY: no index reaches beyond.
                unsafe {
                    let on_first = totals.forces.get_unchecked_mut(a);
                    store(on_first, add(load(on_first), rows[lane]));
                    let on_second = totals.forces.get_unchecked_mut(b);
                    store(on_second, sub(load(on_second), rows[lane]));
                    add_to(totals.tangential.get_unchecked_mut(a), rims[lane]);
                    add_to(totals.tangential.get_unchecked_mut(b), rims[lane]);
                }
            }
        }
        energies.put_into(&mut totals.energies);
        firsts.len() * LANES
    }

    /// Also a list out of a damaged checkpoint must not reach beyond.
    fn check_indices(pairs: &Pairs, sight: &Sight<'_>, totals: &Totals<'_>) {
        let largest = |of: &[u32]| of.iter().fold(0, |most, &index| Ord::max(most, index)) as usize;
        let beyond = Ord::max(largest(&pairs.first), largest(&pairs.second));
        let columns = [
            sight.states.len(),
            sight.rim_speeds.len(),
            sight.spins.len(),
            sight.radii.len(),
            totals.forces.len(),
            totals.tangential.len(),
        ];
        assert!(columns.into_iter().all(|length| beyond < length), "a pair of no disc");
    }

    /// Places and velocities of the first discs against the second: x, y, vx, vy.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn apart(sight: &Sight<'_>, first: [u32; 4], second: [u32; 4]) -> [__m256d; 4] {
        let apart = |lane: usize| {
            let (a, b) = (first[lane] as usize, second[lane] as usize);
            // SAFETY: no index reaches beyond.
            let (a, b) = unsafe { (sight.states.get_unchecked(a), sight.states.get_unchecked(b)) };
            sub(load(a), load(b))
        };
        transposed([apart(0), apart(1), apart(2), apart(3)])
    }

    /// Friction and rolling friction where materials differ.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn coefficients(sight: &Sight<'_>, first: &[u32; 4], second: &[u32; 4]) -> [__m256d; 2] {
        let materials = |lane: usize| {
            let [a, b] = [first[lane], second[lane]].map(|disc| sight.materials[disc as usize]);
            sight.law.materials.between(a, b)
        };
        let pairs = [materials(0), materials(1), materials(2), materials(3)];
        [load(&pairs.map(|pair| pair.friction)), load(&pairs.map(|pair| pair.rolling_friction))]
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn note_deepest(
        overlap: __m256d,
        touch: __m256d,
        [first, second]: [[u32; 4]; 2],
        sight: &Sight<'_>,
        totals: &mut Totals<'_>,
    ) {
        let deep = compare::<_CMP_GT_OQ>(overlap, all(totals.deepest.bound()));
        let deep = lanes_of(and(deep, touch));
        if deep != 0 {
            let mut overlaps = [0.0; 4];
            store(&mut overlaps, overlap);
            for lane in (0..LANES).filter(|lane| deep >> lane & 1 == 1) {
                let ends = [first[lane] as usize, second[lane] as usize];
                totals.deepest.note_pair(overlaps[lane], ends, sight.radii);
            }
        }
    }
}

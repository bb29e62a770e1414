//! Speed of settled beds over that of a tight loop which does the same work on the same discs, in turn, on one thread.
//!
//! `cargo bench --bench dem_tight_loop`; settled beds without friction of 10^4 and 10^5 discs. The loop has one array of positions and
//! velocities, sorted as the engine sorts its discs, a half list of pairs with their constants, and no more: no energies, no check of
//! the largest overlap, no neighbor search (a bed at rest needs none; the loop asserts it). With AVX2 it computes four pairs at a
//! time. After some steps, its kinetic energy must be that of the engine.
//!
//! Figures are million particle-steps per second and the ratio engine / loop: the median of pairs, with the smallest and the largest.
//! Aim: 0.9 at 10^5. Not reached: two quiet cores of an AMD EPYC of the fourth generation (AVX-512), two series: 0.82 (0.82 to 0.83)
//! and 0.83 (0.81 to 0.84) at 10^4, 0.73 (0.66 to 1.03) and 0.71 (0.60 to 0.79) at 10^5; a third one, 0.84 (0.69 to 0.85) and 0.73 (0.58
//! to 0.76). The engine takes 1.2 times the time of the loop at 10^4 and 1.4 times at 10^5. It also sums energies, checks overlaps and
//! keeps its lists valid. Of the time of `dem_peer settled 100000` (`perf record`), 68 % are pairs within blocks, 14 % kick and drift, 5 %
//! walls, 5 % pairs of two blocks, and most of the rest lists: without walls and pairs of two blocks, the ratio would be 0.81. Rows of
//! position and velocity, as in the loop, make beds faster by a factor of 1.05 and a gas slower by 1.07 (`dem_speed`).

#![allow(unsafe_code, reason = "the loop uses AVX2, which is checked before its call")]
#![allow(clippy::disallowed_methods, reason = "no recorded number depends on this loop")]

mod dem_beds;

use dem_beds::{Scene, print_header, print_row};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::{Extent, Model, Target};
use kinetoscope_recording::frame::Frame;
use rayon::ThreadPoolBuilder;
use std::time::Instant;

const PAIRS: usize = 7;
/// Particle-steps per measurement.
const WORK: usize = 10_000_000;
/// Steps between two checks whether a bed is at rest, and the maximum number of checks.
const SETTLING_STEPS: usize = 20_000;
const MAX_SETTLING: usize = 25;
/// The constants of the scene.
const STIFFNESS: f64 = 5e4;
const RESTITUTION: f64 = 0.5;
const GRAVITY: f64 = -9.81;
const RADIUS: f64 = 5e-4;
/// Distance beyond contact up to which pairs are listed, m.
const SKIN: f64 = 0.1 * RADIUS;
/// Discs per side of a patch that is adjacent in memory.
const PATCH: f64 = 50.0;

/// Position and velocity of a disc.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Row([f64; 4]);

/// Two discs, r_i + r_j and eta.
#[derive(Clone, Copy)]
struct Pair {
    ends: [u32; 2],
    reach: f64,
    damping: f64,
}

struct Bed {
    rows: Vec<Row>,
    start: Vec<Row>,
    radii: Vec<f64>,
    inverse_masses: Vec<f64>,
    forces: Vec<[f64; 2]>,
    pairs: Vec<Pair>,
    /// Discs near walls with eta.
    near_walls: Vec<(u32, f64)>,
    sides: [f64; 2],
    time_step: f64,
}

fn damping(effective_mass: f64) -> f64 {
    let log = -RESTITUTION.ln();
    2.0 * log / std::f64::consts::PI.hypot(log) * (STIFFNESS * effective_mass).sqrt()
}

impl Bed {
    fn of(model: &Dem, sides: [f64; 2], time_step: f64) -> Self {
        let mut frame = Frame::new();
        model.observe(&mut frame);
        let mut discs: Vec<&[f64]> =
            frame.state().chunks_exact(Dem::kind().state_columns.len()).collect();
        let cell = 2.0 * RADIUS;
        let place = |disc: &&[f64]| {
            let [x, y] = [disc[0], disc[1]].map(|part| (part / cell) as u32);
            (y / PATCH as u32, x / PATCH as u32, x, y)
        };
        discs.sort_by_key(place);
        let rows: Vec<Row> = discs.iter().map(|d| Row([d[0], d[1], d[4], d[5]])).collect();
        let radii: Vec<f64> = discs.iter().map(|disc| disc[6]).collect();
        let masses: Vec<f64> = discs.iter().map(|disc| disc[9]).collect();
        let mut bed = Self {
            start: rows.clone(),
            forces: vec![[0.0; 2]; rows.len()],
            inverse_masses: masses.iter().map(|mass| 1.0 / mass).collect(),
            pairs: Vec::new(),
            near_walls: Vec::new(),
            rows,
            radii,
            sides,
            time_step,
        };
        bed.list(&masses);
        bed
    }

    fn list(&mut self, masses: &[f64]) {
        let reach = 2.2 * RADIUS + SKIN;
        let columns = (self.sides[0] / reach) as usize + 2;
        let cell = |row: &Row| [row.0[0], row.0[1]].map(|part| (part / reach) as usize + 1);
        let mut cells = vec![Vec::new(); columns * ((self.sides[1] / reach) as usize + 3)];
        for (disc, row) in self.rows.iter().enumerate() {
            let [x, y] = cell(row);
            cells[y * columns + x].push(disc);
        }
        for (i, row) in self.rows.iter().enumerate() {
            let [x, y] = cell(row);
            let around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y)));
            let others = around.filter_map(|(x, y)| cells.get(y * columns + x)).flatten();
            let mut near: Vec<usize> = others.copied().filter(|&j| j > i).collect();
            near.sort_unstable();
            for j in near {
                let [dx, dy] = [0, 1].map(|axis: usize| row.0[axis] - self.rows[j].0[axis]);
                let sum = self.radii[i] + self.radii[j];
                if dx.hypot(dy) < sum + SKIN {
                    let effective = masses[i] * masses[j] / (masses[i] + masses[j]);
                    let ends = [i as u32, j as u32];
                    self.pairs.push(Pair { ends, reach: sum, damping: damping(effective) });
                }
            }
            let to_wall = |axis: usize| row.0[axis].min(self.sides[axis] - row.0[axis]);
            if to_wall(0).min(to_wall(1)) < self.radii[i] + SKIN {
                self.near_walls.push((i as u32, damping(masses[i])));
            }
        }
        // Whole groups: a disc and itself are not in contact.
        let filler = Pair { ends: [0; 2], reach: 0.0, damping: 0.0 };
        self.pairs.resize(self.pairs.len().next_multiple_of(4), filler);
    }

    fn step(&mut self) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2, and pairs name existing discs.
            unsafe { add_pairs_wide(&self.pairs, &self.rows, &mut self.forces) };
        } else {
            self.add_pairs();
        }
        #[cfg(not(target_arch = "x86_64"))]
        self.add_pairs();
        for &(disc, damping) in &self.near_walls {
            let disc = disc as usize;
            let Row(row) = self.rows[disc];
            for axis in 0..2 {
                let (radius, v) = (self.radii[disc], row[2 + axis]);
                let (low, high) = (radius - row[axis], row[axis] + radius - self.sides[axis]);
                let force = &mut self.forces[disc][axis];
                *force += if low > 0.0 { STIFFNESS * low - damping * v } else { 0.0 };
                *force -= if high > 0.0 { STIFFNESS * high + damping * v } else { 0.0 };
            }
        }
        let dt = self.time_step;
        let discs = self.rows.iter_mut().zip(&mut self.forces).zip(&self.inverse_masses);
        for ((Row([x, y, vx, vy]), force), inverse) in discs {
            let [fx, fy] = std::mem::take(force);
            *vx += fx * inverse * dt;
            *vy += (fy * inverse + GRAVITY) * dt;
            *x += *vx * dt;
            *y += *vy * dt;
        }
    }

    fn add_pairs(&mut self) {
        for &Pair { ends, reach, damping } in &self.pairs {
            let [i, j] = ends.map(|disc| disc as usize);
            let (Row(one), Row(other)) = (self.rows[i], self.rows[j]);
            let [dx, dy, dvx, dvy] = [0, 1, 2, 3].map(|part: usize| one[part] - other[part]);
            let squared = dx * dx + dy * dy;
            if squared < reach * reach {
                let distance = squared.sqrt();
                let [nx, ny] = [dx / distance, dy / distance];
                let force = STIFFNESS * (reach - distance) - damping * (dvx * nx + dvy * ny);
                for (part, n) in [nx, ny].into_iter().enumerate() {
                    self.forces[i][part] += force * n;
                    self.forces[j][part] -= force * n;
                }
            }
        }
    }

    /// Kinetic energy, J.
    fn kinetic(&self) -> f64 {
        let discs = self.rows.iter().zip(&self.inverse_masses);
        discs.map(|(Row([.., vx, vy]), inverse)| 0.5 * (vx * vx + vy * vy) / inverse).sum()
    }

    /// Million particle-steps per second.
    fn speed(&mut self) -> f64 {
        let steps = WORK / self.rows.len();
        let started = Instant::now();
        (0..steps).for_each(|_| self.step());
        let seconds = started.elapsed().as_secs_f64();
        let moved =
            |(Row(now), Row(then)): (&Row, &Row)| (now[0] - then[0]).hypot(now[1] - then[1]);
        let furthest = self.rows.iter().zip(&self.start).map(moved).fold(0.0, f64::max);
        assert!(furthest < 0.5 * SKIN, "the bed is not at rest");
        (steps * self.rows.len()) as f64 / seconds / 1e6
    }
}

/// Adds the forces of groups of four pairs.
///
/// # Safety
/// - The processor has AVX2, and every index is less than the number of rows and of forces.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn add_pairs_wide(pairs: &[Pair], rows: &[Row], forces: &mut [[f64; 2]]) {
    use std::arch::x86_64::*;
    let stiffness = _mm256_set1_pd(STIFFNESS);
    for four in pairs.as_chunks::<4>().0 {
        let [a, b, c, d] = four;
        // SAFETY: the caller checked the indices.
        let apart = |pair: &Pair| unsafe {
            let [i, j] = pair.ends.map(|disc| rows.get_unchecked(disc as usize).0.as_ptr());
            _mm256_sub_pd(_mm256_load_pd(i), _mm256_load_pd(j))
        };
        let (ra, rb, rc, rd) = (apart(a), apart(b), apart(c), apart(d));
        let (low_ab, high_ab) = (_mm256_unpacklo_pd(ra, rb), _mm256_unpackhi_pd(ra, rb));
        let (low_cd, high_cd) = (_mm256_unpacklo_pd(rc, rd), _mm256_unpackhi_pd(rc, rd));
        let dx = _mm256_permute2f128_pd::<0x20>(low_ab, low_cd);
        let dy = _mm256_permute2f128_pd::<0x20>(high_ab, high_cd);
        let dvx = _mm256_permute2f128_pd::<0x31>(low_ab, low_cd);
        let dvy = _mm256_permute2f128_pd::<0x31>(high_ab, high_cd);
        let reach = _mm256_setr_pd(a.reach, b.reach, c.reach, d.reach);
        let damping = _mm256_setr_pd(a.damping, b.damping, c.damping, d.damping);
        let squared = _mm256_add_pd(_mm256_mul_pd(dx, dx), _mm256_mul_pd(dy, dy));
        let touch = _mm256_cmp_pd::<_CMP_LT_OQ>(squared, _mm256_mul_pd(reach, reach));
        if _mm256_movemask_pd(touch) == 0 {
            continue;
        }
        let distance = _mm256_sqrt_pd(squared);
        let inverse = _mm256_div_pd(_mm256_set1_pd(1.0), distance);
        let (nx, ny) = (_mm256_mul_pd(dx, inverse), _mm256_mul_pd(dy, inverse));
        let speed = _mm256_add_pd(_mm256_mul_pd(dvx, nx), _mm256_mul_pd(dvy, ny));
        let spring = _mm256_mul_pd(stiffness, _mm256_sub_pd(reach, distance));
        let force = _mm256_sub_pd(spring, _mm256_mul_pd(damping, speed));
        let fx = _mm256_and_pd(touch, _mm256_mul_pd(force, nx));
        let fy = _mm256_and_pd(touch, _mm256_mul_pd(force, ny));
        let (even, odd) = (_mm256_unpacklo_pd(fx, fy), _mm256_unpackhi_pd(fx, fy));
        let on = [
            _mm256_castpd256_pd128(even),
            _mm256_castpd256_pd128(odd),
            _mm256_extractf128_pd::<1>(even),
            _mm256_extractf128_pd::<1>(odd),
        ];
        for (pair, force) in four.iter().zip(on) {
            // SAFETY: the caller checked the indices.
            unsafe {
                let [i, j] = pair.ends.map(|disc| disc as usize);
                let sum = forces.get_unchecked_mut(i).as_mut_ptr();
                _mm_storeu_pd(sum, _mm_add_pd(_mm_loadu_pd(sum), force));
                let sum = forces.get_unchecked_mut(j).as_mut_ptr();
                _mm_storeu_pd(sum, _mm_sub_pd(_mm_loadu_pd(sum), force));
            }
        }
    }
}

/// Kinetic energy at the integrator's velocities, J.
fn kinetic(model: &Dem) -> f64 {
    let mut frame = Frame::new();
    model.observe(&mut frame);
    let discs = frame.state().chunks_exact(Dem::kind().state_columns.len());
    discs.map(|disc| 0.5 * disc[9] * (disc[4] * disc[4] + disc[5] * disc[5])).sum()
}

fn advance(model: &mut Dem, steps: usize) {
    let goal = Target::Count(model.count() + steps as u64);
    model.advance(goal, u64::MAX).expect("no blow-up");
}

/// Lets the bed come to rest: no disc moves by a quarter of the skin in `steps` steps.
fn settle(model: &mut Dem, steps: usize, time_step: f64) {
    for _ in 0..MAX_SETTLING {
        let mut frame = Frame::new();
        model.observe(&mut frame);
        let discs = frame.state().chunks_exact(Dem::kind().state_columns.len());
        let fastest = discs.map(|disc| disc[4].hypot(disc[5])).fold(0.0, f64::max);
        if fastest * time_step * (steps as f64) < 0.25 * SKIN {
            return;
        }
        advance(model, SETTLING_STEPS);
    }
}

fn main() {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    print_header(["engine", "loop"]);
    for discs in [10_000, 100_000] {
        let mut model = pool.install(|| Scene::Settled.model(discs));
        let config = Scene::Settled.config(discs);
        let Extent::Steps { step: time_step, .. } = model.extent() else { unreachable!("steps") };
        let sides = [config.width_m.get(), config.height_m.get()];
        pool.install(|| settle(&mut model, WORK / discs as usize, time_step));
        let mut bed = Bed::of(&model, sides, time_step);
        pool.install(|| advance(&mut model, 20));
        (0..20).for_each(|_| bed.step());
        let (ours, of_loop) = (kinetic(&model), bed.kinetic());
        assert!((ours / of_loop - 1.0).abs() < 1e-6, "{ours} J and {of_loop} J");
        let pairs: Vec<[f64; 2]> = (0..PAIRS)
            .map(|_| {
                // From the engine's state, because some discs still move, and the loop's list stays as it is.
                let mut bed = Bed::of(&model, sides, time_step);
                let steps = WORK / discs as usize;
                let started = Instant::now();
                pool.install(|| advance(&mut model, steps));
                let seconds = started.elapsed().as_secs_f64();
                [(steps * discs as usize) as f64 / seconds / 1e6, bed.speed()]
            })
            .collect();
        print_row(discs, &pairs, |[engine, tight]| engine / tight);
    }
}

//! Kinetoscope's side of a comparison with another program: writes the initial state, advances it, and prints the speed in
//! particle-steps per second and the kinetic energy. `benches/peers/dem_lammps.py` runs it in turn with its peer.
//!
//! dem_peer SCENE DISCS STEPS THREADS STATE_FILE; SCENE is settled, frictional, spheres, frictional_spheres, gas, collapse or equal.
//! STATE_FILE receives one line `x y vx vy vx_step vy_step radius mass` per disc.

mod dem_beds;

use dem_beds::Scene;
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::{Extent, Model, Target};
use kinetoscope_recording::channels::DemEnergy;
use kinetoscope_recording::frame::Frame;
use std::fmt::Write as _;
use std::time::Instant;

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let [scene, discs, steps, threads, file] = arguments.as_slice() else {
        println!("dem_peer SCENE DISCS STEPS THREADS STATE_FILE");
        return;
    };
    let number = |text: &String| text.parse::<u64>().expect("a number");
    let scene = Scene::named(scene).expect("a scene");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(number(threads) as usize).build();
    pool.expect("threads").install(|| {
        let mut model = scene.model(number(discs) as u32);
        std::fs::write(file, text_of(&model, scene, number(discs) as u32)).expect("a state file");
        let begin = model.count();
        let clock = Instant::now();
        model.advance(Target::Count(begin + number(steps)), u64::MAX).expect("no blow-up");
        let seconds = clock.elapsed().as_secs_f64();
        let speed = (number(discs) * number(steps)) as f64 / seconds;
        println!("{:.4e} {:.12e}", speed, kinetic_of_steps(&model));
    });
}

fn observed(model: &Dem) -> Frame {
    let mut frame = Frame::new();
    model.observe(&mut frame);
    frame
}

/// Width and height of the box and the time step, then one line per disc.
fn text_of(model: &Dem, scene: Scene, discs: u32) -> String {
    let config = scene.config(discs);
    let Extent::Steps { step, .. } = model.extent() else { unreachable!("steps") };
    let mut text = format!("{} {} {:e}\n", config.width_m.get(), config.height_m.get(), step);
    for row in observed(model).state().chunks_exact(Dem::kind().state_columns.len()) {
        let mass = 1e-3 * row[6] * row[6] / (5e-4 * 5e-4);
        for value in &row[..7] {
            write!(text, "{value:e} ").expect("text");
        }
        writeln!(text, "{mass:e}").expect("text");
    }
    text
}

/// Kinetic energy at the positions' time, J.
fn kinetic_of_steps(model: &Dem) -> f64 {
    observed(model).get::<DemEnergy>().expect("energy").kinetic_j
}

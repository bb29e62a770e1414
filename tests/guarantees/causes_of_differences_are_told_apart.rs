//! Guarantee: of 200 changes of a coefficient by one unit in the last place, none is taken for different physics; of 200 changes
//! by 1 %, all are.
//!
//! Setup: small runs of all models, with coefficients that are drawn; each is compared with its original, whose frames are
//! far apart.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use kinetoscope::verify::divergence::{Cause, Divergence, find_step, in_frames};
use kinetoscope::{Experiment, Recording, interrupt::Interrupt, run};
use std::collections::BTreeMap;

/// Name and range of a coefficient.
type Coefficient = (&'static str, f64, f64);

/// A model, its manifest with coefficients in braces, and their ranges.
const SCENES: &[(&str, &str, &[Coefficient])] = &[
    (
        "dem",
        "seed = {seed}\n[model.dem]\ndiscs = 25\nwidth_m = 0.012\nheight_m = 0.012\nfriction = {friction}\nrestitution = {restitution}\nstiffness_n_per_m = {stiffness}\nmass_kg = {mass}\nvelocity_std_m_per_s = 0.3\nduration_s = 0.03\n[record]\nframes = 6\n",
        &[
            ("friction", 0.1, 0.9),
            ("restitution", 0.3, 0.9),
            ("stiffness", 1e5, 3e5),
            ("mass", 5e-4, 2e-3),
        ],
    ),
    (
        "gas",
        "seed = {seed}\n[model.gas]\nparticles = 30\nradius_m = {radius}\ntemperature_k = {temperature}\nmass_kg = {mass}\nduration_s = 0.01\n[record]\nframes = 4\n",
        &[("radius", 0.5, 2.0), ("temperature", 100.0, 400.0), ("mass", 1e-26, 4e-26)],
    ),
    (
        "packing",
        "seed = {seed}\n[model.packing]\ndiscs = 30\nradius = {radius}\nwidth = 12.0\nheight = {height}\nrestitution = {restitution}\nduration = 12.0\n[record]\nframes = 4\n",
        &[("radius", 0.4, 0.6), ("height", 11.0, 13.0), ("restitution", 0.8, 0.99)],
    ),
    (
        "orbit",
        "[model.orbit]\nstart = { position_au = [{x}, 0.0, 0.0], velocity_au_per_day = [0.0, {velocity}, 0.0] }\ntime_step_days = {step}\nduration_days = 120.0\n[record]\nframes = 4\n",
        &[("x", 0.8, 1.2), ("velocity", 0.012, 0.018), ("step", 0.2, 0.4)],
    ),
];
const PER_SCENE: u64 = 50;

fn recorded(template: &str, seed: u64, values: &BTreeMap<&str, f64>) -> Recording {
    let mut text = template.replace("{seed}", &seed.to_string());
    for (name, value) in values {
        text = text.replace(&format!("{{{name}}}"), &format!("{value:?}"));
    }
    let experiment: Experiment = text.parse().unwrap_or_else(|error| panic!("{text}: {error}"));
    run(&experiment.runs[0]).unwrap()
}

fn compared(one: &Recording, other: &Recording) -> Option<Divergence> {
    let found = in_frames(one, other).unwrap()?;
    Some(find_step([one, other], &found, &Interrupt::default()).unwrap_or(found))
}

/// Uniform numbers from a counter (the finalizer of SplitMix64).
fn uniform(index: u64) -> f64 {
    let mut word = index.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((word ^ (word >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

#[test]
fn rounding_and_physics_are_told_apart() {
    let mut table = BTreeMap::<(&str, &str), usize>::new();
    let mut wrong = Vec::new();
    for (model, template, coefficients) in SCENES {
        for seed in 0..PER_SCENE {
            let draw = |(index, (name, low, high)): (usize, &Coefficient)| {
                let share = uniform(100 * seed + index as u64 + 1);
                (*name, low + share * (high - low))
            };
            let values: BTreeMap<&str, f64> = coefficients.iter().enumerate().map(draw).collect();
            let original = recorded(template, seed, &values);
            let name = coefficients[seed as usize % coefficients.len()].0;
            for (change, value) in
                [("one ulp", values[name].next_up()), ("1 %", 1.01 * values[name])]
            {
                let mut changed = values.clone();
                changed.insert(name, value);
                let found = compared(&original, &recorded(template, seed, &changed));
                let cause = match found.as_ref().map(Divergence::cause) {
                    None => "equal",
                    Some(Cause::Rounding) => "rounding",
                    Some(Cause::Physics) => "physics",
                    Some(Cause::Undecided) => "undecided",
                };
                *table.entry((change, cause)).or_default() += 1;
                let is_wrong = match change {
                    "one ulp" => cause == "physics" || cause == "undecided",
                    _ => cause != "physics",
                };
                if is_wrong {
                    wrong.push(format!("{model} {seed}, {name} by {change}: {cause} {found:?}"));
                }
            }
        }
    }
    println!("{table:?}");
    assert!(wrong.is_empty(), "{table:?}\n{}", wrong.join("\n"));
}

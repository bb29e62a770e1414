//! The hardest contact of a disc that a manifest lets expect: a fall onto a wall, and the weight of a column of discs.

use crate::restart_state;
use crate::simd::registers::Register as _;
use kinetoscope_manifest::model::{DemConfig, Placement, StartFrom};

/// Standard deviations of drawn velocities that are taken into account.
const DRAWN_DEVIATIONS: f64 = 4.0;

/// The load on the contact of a disc with a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ExpectedLoad {
    /// Mass of a disc of the mean radius and the densest material, kg.
    pub(super) mass: f64,
    /// Its speed at the wall, m/s.
    pub(super) speed: f64,
    /// Weight of a column of discs, with all discs in even layers, N.
    pub(super) weight: f64,
}

impl ExpectedLoad {
    pub(super) fn of(config: &DemConfig) -> Self {
        let densities = config.materials.iter().map(|material| material.density_ratio.get());
        let densest = densities.reduce(|most, ratio| ratio.larger(most)).unwrap_or(1.0);
        let mass = config.mass_kg.get() * densest;
        let insertion = config.insertion.map_or(0, |insertion| insertion.discs.get());
        let discs = f64::from(config.discs.get()) + f64::from(insertion);
        let weight = column_weight(
            mass,
            discs - 1.0,
            config.radius_m.mean(),
            [config.width_m.get(), config.height_m.get()],
            config.gravity_m_per_s2.map(|component| component.get()),
        );
        Self { mass, speed: impact_speed(config), weight }
    }
}

/// Weight of a column of discs as high as the box, and of a row as wide, in N: a disc of `mass` and `others` in even layers.
pub(super) fn column_weight(
    mass: f64,
    others: f64,
    radius: f64,
    sides: [f64; 2],
    gravity: [f64; 2],
) -> f64 {
    let layers = |side: f64| 1.0 + others * 2.0 * radius / side;
    mass * (gravity[0].abs() * layers(sides[1]) + gravity[1].abs() * layers(sides[0]))
}

/// Speed of the fastest disc at the wall onto which it falls, m/s: from the given start, else through the whole box.
fn impact_speed(config: &DemConfig) -> f64 {
    let (_, radius) = config.radius_m.range();
    let sides = [config.width_m.get(), config.height_m.get()];
    let fall = |axis: usize, start: Option<f64>| {
        let gravity = config.gravity_m_per_s2[axis].get();
        let height = match start {
            Some(at) if gravity < 0.0 => at - radius,
            Some(at) => sides[axis] - radius - at,
            None => sides[axis] - 2.0 * radius,
        };
        if height > 0.0 { 2.0 * gravity.abs() * height } else { 0.0 }
    };
    let whole_fall = fall(0, None) + fall(1, None);
    let mut fastest = config.insertion.map_or(0.0, |insertion| {
        let [vx, vy] = insertion.velocity_m_per_s.map(|v| v.get());
        vx * vx + vy * vy + whole_fall
    });
    let motions: Vec<[f64; 4]> = match &config.placement {
        Placement::Random | Placement::Lattice => {
            let deviation = config.velocity_std_m_per_s.map_or(0.0, |v| v.get());
            let squared =
                DRAWN_DEVIATIONS * deviation * (DRAWN_DEVIATIONS * deviation) + whole_fall;
            return squared.larger(fastest).sqrt();
        }
        Placement::Given(given) => {
            let moving = given.positions_m.iter().zip(&given.velocities_m_per_s);
            moving.map(|([x, y], [vx, vy])| [x, y, vx, vy].map(|value| value.get())).collect()
        }
        Placement::Recorded(recording) => recorded_motions(recording),
    };
    for [x, y, vx, vy] in motions {
        let squared = vx * vx + vy * vy + fall(0, Some(x)) + fall(1, Some(y));
        fastest = squared.larger(fastest);
    }
    fastest.sqrt()
}

/// Centers and velocities of a recorded start; empty if it was not read.
fn recorded_motions(start: &StartFrom) -> Vec<[f64; 4]> {
    restart_state::rows(start, ["x", "y", "vx", "vy"]).unwrap_or_default()
}

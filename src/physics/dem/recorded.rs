//! Discs that go on from where the run of a recording ended.
//!
//! Positions, radii, spins and the integrator's velocities are taken over bit for bit. Tangential and rolling springs are
//! not in a recording and begin unstretched; discs are numbered anew, from 0 in their order.

use crate::dem::discs::{Disc, Discs};
use crate::dem::parameters::{Parameters, mass_of};
use crate::dem::start::{Kinds, TOUCHING};
use crate::model::Refusal;
use crate::restart_state;
use kinetoscope_manifest::model::{DemConfig, StartFrom};

/// Share of its radius by which a disc may stand in a wall at the start. A resting bed stands in its floor by far less; a
/// wall of the new run must not cut through discs.
const DEEPEST_IN_WALL: f64 = 0.5;

/// The discs of a recording's last frame.
///
/// # Errors
/// Several materials, which a recording does not tell apart, radii that `radius_m` does not know, or discs outside of the box or within a wall.
pub(super) fn discs(
    start: &StartFrom,
    config: &DemConfig,
    parameters: &Parameters,
    kinds: &Kinds,
) -> Result<Discs, Refusal> {
    if config.materials.len() > 1 {
        return Err(Refusal(
            "A recording does not say which disc is of which material: with start_from, give one material at most."
                .to_owned(),
        ));
    }
    let rows = restart_state::rows(start, ["x", "y", "vx_step", "vy_step", "radius", "spin"])?;
    check(&rows, config, parameters)?;
    let mut discs = Discs::default();
    for (number, &[x, y, vx, vy, radius, spin]) in rows.iter().enumerate() {
        let kind = kinds.disc(number, parameters);
        let density_ratio = parameters.law.materials.density_ratio(kind.material);
        let mass = density_ratio * mass_of(radius, parameters.radius, parameters.mass);
        discs.push(&Disc { position: [x, y], velocity: [vx, vy], radius, mass, ..kind });
        discs.spins[number] = spin;
    }
    Ok(discs)
}

/// Centers and velocities of a recorded start; none where it was not read.
pub(super) fn motions(start: &StartFrom) -> Vec<[f64; 4]> {
    restart_state::rows(start, ["x", "y", "vx", "vy"]).unwrap_or_default()
}

fn check(rows: &[[f64; 6]], config: &DemConfig, parameters: &Parameters) -> Result<(), Refusal> {
    let (smallest, largest) = config.radius_m.range();
    let walls = parameters.walls_at(0);
    for (disc, &[x, y, _, _, radius, _]) in rows.iter().enumerate() {
        if radius < smallest * (1.0 - TOUCHING) || radius > largest * (1.0 + TOUCHING) {
            return Err(Refusal(format!(
                "Disc {disc} (counted from 0) of the recording in start_from has the radius {radius:e} m, which radius_m \
                 does not allow: write the radius_m of the recording's manifest."
            )));
        }
        let is_inside =
            (0.0..=parameters.sides[0]).contains(&x) && (0.0..=parameters.sides[1]).contains(&y);
        let is_free = walls
            .iter()
            .all(|wall| wall.shape.footing([x, y]).distance >= radius * (1.0 - DEEPEST_IN_WALL));
        if !is_inside || !is_free {
            return Err(Refusal(format!(
                "Disc {disc} (counted from 0) of the recording in start_from stands at [{x:e}, {y:e}] m, outside of this \
                 run's box or within one of its walls: keep width_m, height_m and walls as they were, or move the walls \
                 to where no disc stands."
            )));
        }
    }
    Ok(())
}

//! The discs of a recorded state.

use kinetoscope_manifest::model::{DemConfig, DiscRadius};
use kinetoscope_recording::reader::StateTable;

/// State of one disc, SI units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    pub(super) position: [f64; 2],
    pub(super) velocity: [f64; 2],
    pub(super) radius: f64,
    pub(super) mass: f64,
    /// Angular velocity, rad/s.
    pub(super) spin: f64,
}

/// The discs of a state. Radii and masses that were not recorded are those of the manifest: the areal density is that of
/// a disc with the mean radius and the manifest's mass. `None` if the state has no positions, velocities or radii.
pub(super) fn discs<'a>(
    config: &'a DemConfig,
    state: &'a StateTable,
) -> Option<impl Iterator<Item = Disc> + 'a> {
    let index = |name: &str| state.index(name);
    let (x, y, vx, vy) = (index("x")?, index("y")?, index("vx")?, index("vy")?);
    let (radius, mass, spin) = (index("radius"), index("mass"), index("spin"));
    let equal = match config.radius_m {
        DiscRadius::Equal(radius) => radius.get(),
        _ => radius.map(|_| 0.0)?,
    };
    let (mean_radius, mean_mass) = (config.radius_m.mean(), config.mass_kg.get());
    Some((0..state.rows()).map(move |disc| {
        let row = state.row(disc);
        let radius = radius.map_or(equal, |column| row[column]);
        let ratio = radius / mean_radius;
        Disc {
            position: [row[x], row[y]],
            velocity: [row[vx], row[vy]],
            radius,
            mass: mass.map_or_else(|| mean_mass * ratio * ratio, |column| row[column]),
            spin: spin.map_or(0.0, |column| row[column]),
        }
    }))
}

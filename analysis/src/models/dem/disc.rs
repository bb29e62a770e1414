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

/// Indices of a state's columns, and the values of discs whose column was not recorded.
struct Columns {
    position: [usize; 2],
    velocity: [usize; 2],
    radius: Option<usize>,
    mass: Option<usize>,
    spin: Option<usize>,
    /// Radius without a column of radii, m.
    equal_radius: f64,
    /// Mean radius, m, and the mass, kg, of a disc with it.
    mean_radius: f64,
    mean_mass: f64,
}

impl Columns {
    /// Called once per disc and frame: a call that returns the disc in memory would take twice as long.
    #[inline(always)]
    fn disc(&self, row: &[f64]) -> Disc {
        let radius = self.radius.map_or(self.equal_radius, |column| row[column]);
        let mass = self.mass.map_or_else(
            || {
                let ratio = radius / self.mean_radius;
                self.mean_mass * ratio * ratio
            },
            |column| row[column],
        );
        Disc {
            position: self.position.map(|column| row[column]),
            velocity: self.velocity.map(|column| row[column]),
            radius,
            mass,
            spin: self.spin.map_or(0.0, |column| row[column]),
        }
    }
}

/// The discs of a state. Radii and masses that were not recorded are those of the manifest: the areal density is that of
/// a disc with the mean radius and the manifest's mass. `None` if the state has no positions, velocities or radii.
pub(super) fn discs(config: &DemConfig, state: &StateTable) -> Option<impl Iterator<Item = Disc>> {
    let index = |name: &str| state.index(name);
    let radius = index("radius");
    let columns = Columns {
        position: [index("x")?, index("y")?],
        velocity: [index("vx")?, index("vy")?],
        radius,
        mass: index("mass"),
        spin: index("spin"),
        equal_radius: match config.radius_m {
            DiscRadius::Equal(radius) => radius.get(),
            _ => radius.map(|_| 0.0)?,
        },
        mean_radius: config.radius_m.mean(),
        mean_mass: config.mass_kg.get(),
    };
    Some(state.iter().map(move |row| columns.disc(row)))
}

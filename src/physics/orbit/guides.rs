//! Lines for comparison in the drawing of one body around the Sun: the exact orbit, the start, and a distance of 1 AU.

use super::elements::Elements;
use super::motion::{State, add_scaled, angular_momentum, cross, length, scaled};
use crate::constants::GM_SUN_AU3_PER_DAY2;
use kinetoscope_recording::scenery::{GuideMeaning, Wall};

/// Radius of the mark at the start over half the width of the view.
const MARK_RADIUS: f64 = 0.03;
/// Distance of a text from what it names over half the width of the view.
const TEXT_DISTANCE: f64 = 0.07;

/// The lines and texts of a view with this half width, AU.
pub(super) fn around_the_sun(start: State, view_half_width: f64) -> Vec<Wall> {
    let [x, y, _] = start.position;
    let text_distance = TEXT_DISTANCE * view_half_width;
    let below = |[x, y]: [f64; 2]| [x, y - text_distance];
    let mut drawn = vec![
        Wall::Label { center: below([0.0, 0.0]), text: "Sun" },
        ring([x, y], MARK_RADIUS * view_half_width),
        Wall::Label { center: below([x, y]), text: "start" },
    ];
    if view_half_width > 1.0 {
        drawn.push(ring([0.0, 0.0], 1.0));
        // Inside the ring, to the upper left.
        let diagonal = (1.0 - 1.5 * text_distance) * 0.5_f64.sqrt();
        drawn.push(Wall::Label { center: [-diagonal, diagonal], text: "1 AU" });
    }
    drawn.extend(exact_orbit(start));
    drawn
}

fn ring(center: [f64; 2], radius: f64) -> Wall {
    Wall::Guide { center, axes: [[radius, 0.0], [0.0, radius]], meaning: GuideMeaning::Mark }
}

/// The ellipse through a state, projected onto the plane z = 0; `None` for an open path.
///
/// With P toward the perihelion, Q ahead of it in the orbital plane, and b = a sqrt(1 - e^2), the ellipse is
/// r = -a e P + a P cos E + b Q sin E. P is the direction of v x L / GM - r / |r|, whose length is e.
fn exact_orbit(start: State) -> Option<Wall> {
    let elements = Elements::of(start);
    elements.bound?;
    let momentum = angular_momentum(start);
    let to_body = scaled(start.position, 1.0 / length(start.position));
    let along = scaled(cross(start.velocity, momentum), 1.0 / GM_SUN_AU3_PER_DAY2);
    let apsidal = add_scaled(along, to_body, -1.0);
    // A circle has no perihelion, and any direction serves.
    let apsidal = if length(apsidal) > 1e-12 { apsidal } else { to_body };
    let perihelion = scaled(apsidal, 1.0 / length(apsidal));
    let ahead = cross(scaled(momentum, 1.0 / length(momentum)), perihelion);
    let (a, e) = (elements.semi_major_axis, elements.eccentricity);
    let projected = |vector: [f64; 3], factor: f64| [factor * vector[0], factor * vector[1]];
    Some(Wall::Guide {
        center: projected(perihelion, -a * e),
        axes: [projected(perihelion, a), projected(ahead, a * (1.0 - e * e).sqrt())],
        meaning: GuideMeaning::ExactSolution,
    })
}

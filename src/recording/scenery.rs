//! The constant part of a drawing: the container, the view and the color range.

/// A wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wall {
    /// An axis-parallel rectangle.
    Rectangle {
        /// Lower left corner.
        min: [f64; 2],
        /// Upper right corner.
        max: [f64; 2],
    },
    /// A circle.
    Circle {
        /// Its center.
        center: [f64; 2],
        /// Its radius.
        radius: f64,
    },
    /// A part of a circle.
    Arc {
        /// The circle's center.
        center: [f64; 2],
        /// The circle's radius.
        radius: f64,
        /// Where it begins and ends, counter-clockwise from the direction of x, rad.
        angles_rad: [f64; 2],
    },
    /// A straight line.
    Segment {
        /// One end.
        from: [f64; 2],
        /// The other.
        to: [f64; 2],
    },
    /// A body at rest, drawn as a filled disc (the Sun).
    Body {
        /// Its center.
        center: [f64; 2],
        /// Its drawn radius.
        radius: f64,
    },
}

/// Drawn radius of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DrawnRadius {
    /// From the `radius` column of the state.
    Column,
    /// Equal for all, in the state's length unit (point particles).
    Fixed(f64),
}

/// The fixed part of the drawing, in the state's length unit. Moving walls are drawn again with each frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenery {
    /// The container.
    pub walls: Vec<Wall>,
    /// Lower left and upper right corner of what the camera must show.
    pub view: [[f64; 2]; 2],
    /// Drawn radius of a particle.
    pub drawn_radius: DrawnRadius,
    /// Speed at the upper end of the color bar; fixed for the run, above zero.
    pub speed_range_top: f64,
    /// Unit of the speeds next to the color bar, such as "m/s".
    pub speed_unit: &'static str,
    /// Whether velocities are drawn as arrows.
    pub arrows: bool,
    /// Force of the thickest line; `None` if contact forces are not drawn.
    pub force_range_top: Option<f64>,
    /// Whether the paths so far are drawn.
    pub trail: bool,
}

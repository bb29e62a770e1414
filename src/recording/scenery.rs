//! The constant part of a drawing: the container, the view and the color range.

use crate::playback::three_digits;

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
    /// A thin line for comparison, not a wall: the ellipse `center + axes[0] cos t + axes[1] sin t`.
    Guide {
        /// Its center.
        center: [f64; 2],
        /// Two conjugate half diameters.
        axes: [[f64; 2]; 2],
        /// What it shows.
        meaning: GuideMeaning,
    },
    /// A text.
    Label {
        /// The middle of the text.
        center: [f64; 2],
        /// One line.
        text: &'static str,
    },
    /// A body at rest, drawn as a filled disc (the Sun).
    Body {
        /// Its center.
        center: [f64; 2],
        /// Its drawn radius.
        radius: f64,
    },
}

/// What a line for comparison shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuideMeaning {
    /// The exact solution.
    ExactSolution,
    /// A length or a position.
    Mark,
}

/// Drawn radius of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DrawnRadius {
    /// From the `radius` column of the state.
    Column {
        /// Radius of the smallest particle, in the state's length unit.
        min: f64,
    },
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
    /// Paths of fields without information in this run, such as "/energy_percent.removed_percent"; the layout has no curves of them.
    pub unused_fields: Vec<&'static str>,
    /// Names of the first particles, drawn next to them.
    pub names: Vec<String>,
    /// Row of the particle that is drawn as the Sun.
    pub central_particle: Option<usize>,
}

/// Smallest drawn diameter over the longer side of the view. At this size, a disc has about 4 px in a viewer's panel.
pub(crate) const MIN_DIAMETER_OVER_EXTENT: f64 = 0.006;

impl Scenery {
    /// The longer side of the view.
    pub(crate) fn extent(&self) -> f64 {
        let [low, high] = self.view;
        let (width, height) = (high[0] - low[0], high[1] - low[1]);
        if width > height { width } else { height }
    }

    /// The radius below which particles are drawn enlarged.
    pub(crate) fn min_drawn_radius(&self) -> f64 {
        0.5 * MIN_DIAMETER_OVER_EXTENT * self.extent()
    }

    /// States that discs are drawn enlarged; `None` if all are drawn to scale.
    pub(crate) fn enlargement(&self) -> Option<String> {
        let percent = 100.0 * MIN_DIAMETER_OVER_EXTENT;
        (self.min_radius() < self.min_drawn_radius()).then(|| {
            format!(
                "discs are drawn at least {percent} % of the view wide: those with a radius below {} are enlarged",
                three_digits(self.min_drawn_radius())
            )
        })
    }

    /// Radius of the smallest particle.
    pub(crate) fn min_radius(&self) -> f64 {
        match self.drawn_radius {
            DrawnRadius::Column { min } => min,
            DrawnRadius::Fixed(radius) => radius,
        }
    }
}

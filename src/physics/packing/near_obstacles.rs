//! The obstacles that a disc can touch before it leaves its cell.

use super::domain::Domain;
use super::motion::{self, Vector};
use crate::cell_grid::{Cell, CellGrid};
use kinetoscope_manifest::model::PackingConfig;
use std::ops::Range;

/// Distance beyond contact, in sides of a cell, within which an obstacle is near a cell: far more than rounding.
const MARGIN: f64 = 1e-6;

/// The obstacles near each cell; in a periodic box, all of their images.
#[derive(Clone, Debug)]
pub(super) struct NearObstacles {
    grid: CellGrid,
    /// Index of a cell, and a center relative to its corner, cell after cell.
    centers: Vec<(usize, Vector)>,
}

impl NearObstacles {
    /// The obstacles of a manifest, for discs of any of its radii.
    pub(super) fn of(config: &PackingConfig) -> Self {
        let domain = Domain::new(config, config.largest_radius());
        Self::new(&domain, domain.cell_grid(config.discs.get() as usize))
    }

    /// The obstacles of a box that a disc with its center in a cell of the grid may touch.
    pub(super) fn new(domain: &Domain, grid: CellGrid) -> Self {
        let reach = domain.obstacles.radius + domain.max_radius;
        let mut centers = Vec::new();
        for &center in &domain.obstacles.centers {
            let (own, relative) = grid.locate(center);
            let [columns, rows] = [0, 1].map(|axis: usize| {
                let [at, reach] = [relative[axis], reach].map(|of| of / grid.cell_sides[axis]);
                (at - reach - MARGIN).floor() as i32..=(at + reach + MARGIN).floor() as i32
            });
            for [column, row] in rows.flat_map(|row| columns.clone().map(move |at| [at, row])) {
                let Some(cell) = grid.shifted(own, [column, row]) else { continue };
                let [width, height] = grid.cell_sides;
                let corner = [f64::from(column) * width, f64::from(row) * height];
                centers.push((grid.index(cell), motion::difference(corner, relative)));
            }
        }
        centers.sort_by_key(|(cell, _)| *cell);
        Self { grid, centers }
    }

    /// Whether there is none.
    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.centers.is_empty()
    }

    /// The numbers of those near a cell.
    pub(super) fn near(&self, cell: Cell) -> Range<u32> {
        let index = self.grid.index(cell);
        let begin = |index| self.centers.partition_point(|(cell, _)| *cell < index) as u32;
        begin(index)..begin(index + 1)
    }

    /// The vector from a position relative to the corner of its cell to the center of an obstacle near that cell.
    pub(super) fn separation(&self, from: Vector, number: u32) -> Vector {
        motion::difference(from, self.centers[number as usize].1)
    }

    /// The centers and the distances of the obstacles that are closer to a point of the box than a distance.
    pub(super) fn closer_than(
        &self,
        distance: f64,
        point: Vector,
    ) -> impl Iterator<Item = (Vector, f64)> {
        let (cell, relative) = self.grid.locate(point);
        self.near(cell).filter_map(move |number| {
            let apart = motion::speed(self.separation(relative, number));
            let center = self.grid.point(cell, self.centers[number as usize].1);
            (apart < distance).then_some((center, apart))
        })
    }
}

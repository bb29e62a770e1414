//! Shape of a bed: its surface, its length on the floor, and the angle of a heap's flanks.

use crate::statistics::least_squares_line;
use std::collections::BTreeMap;

/// Upper surface of discs (x, y, radius, mass): the highest point above each column of two mean diameters, counted from the left
/// wall. Empty columns are left out, so that memory depends on the number of discs and not on the box.
fn surface(discs: &[[f64; 4]], width: f64) -> (f64, BTreeMap<u64, f64>) {
    let mean = discs.iter().map(|disc| disc[2]).sum::<f64>() / discs.len() as f64;
    let columns = (width / (4.0 * mean)).floor().max(1.0);
    let pitch = width / columns;
    let last = columns as u64 - 1;
    let mut tops = BTreeMap::new();
    for &[x, y, radius, _] in discs {
        let column = ((x / pitch).max(0.0) as u64).min(last);
        let top: &mut f64 = tops.entry(column).or_insert(0.0);
        *top = top.max(y + radius);
    }
    (pitch, tops)
}

/// Length of the deposit from the left wall to the first gap as wide as a column, m.
pub(super) fn deposit_length_m(discs: &[[f64; 4]], width: f64) -> Option<f64> {
    let (pitch, tops) = surface(discs, width);
    let columns = (0_u64..).zip(tops.keys()).take_while(|(column, found)| column == *found).count();
    let edge = columns as f64 * pitch;
    let ends = discs.iter().filter(|disc| disc[0] < edge).map(|disc| disc[0] + disc[2]);
    (columns > 0).then(|| ends.fold(0.0, f64::max))
}

/// Fractions of a heap's height between which its surface angle is measured: its foot and its tip are round.
const FLANK: [f64; 2] = [0.15, 0.85];

/// The surface of discs: the middle of each column and its highest point, m.
pub(super) fn surface_points(discs: &[[f64; 4]], width: f64) -> Vec<(f64, f64)> {
    let (pitch, tops) = surface(discs, width);
    tops.iter().map(|(&column, &top)| ((column as f64 + 0.5) * pitch, top)).collect()
}

/// The ends of the lines through a heap's two flanks, m.
pub(super) fn flank_lines(discs: &[[f64; 4]], width: f64) -> Option<[[(f64, f64); 2]; 2]> {
    let (middle, flanks) = flanks(discs, width);
    let line = least_squares_line(&flanks).filter(|_| flanks.len() >= FEWEST_COLUMNS)?;
    let distances = || flanks.iter().map(|(distance, _)| *distance);
    let ends = [distances().fold(f64::MAX, f64::min), distances().fold(0.0, f64::max)];
    let height = |distance: f64| line.intercept + line.slope * distance;
    Some([-1.0, 1.0].map(|side| ends.map(|end| (middle + side * end, height(end)))))
}

/// Mean angle of a heap's two flanks, degrees: least squares of the surface height over the distance from the center of
/// area of the discs.
pub(super) fn surface_angle_deg(discs: &[[f64; 4]], width: f64) -> Option<f64> {
    let (_, flanks) = flanks(discs, width);
    let line = least_squares_line(&flanks).filter(|_| flanks.len() >= FEWEST_COLUMNS);
    line.map(|line| libm::atan(-line.slope).to_degrees())
}

/// Number of columns from which flanks have an angle.
const FEWEST_COLUMNS: usize = 4;

/// The center of area of the discs, and of the columns of both flanks the distance from it and the surface height, m.
fn flanks(discs: &[[f64; 4]], width: f64) -> (f64, Vec<(f64, f64)>) {
    let (pitch, tops) = surface(discs, width);
    let areas = discs.iter().map(|disc| disc[2] * disc[2]).sum::<f64>();
    let middle = discs.iter().map(|disc| disc[0] * disc[2] * disc[2]).sum::<f64>() / areas;
    let floor = discs.iter().map(|disc| disc[1] - disc[2]).fold(f64::INFINITY, f64::min);
    let height = tops.values().fold(0.0_f64, |top, &at| top.max(at)) - floor;
    let [low, high] = FLANK.map(|share| floor + share * height);
    let flanks: Vec<(f64, f64)> = tops
        .iter()
        .map(|(&column, &top)| (((column as f64 + 0.5) * pitch - middle).abs(), top))
        .filter(|(_, top)| (low..=high).contains(top))
        .collect();
    (middle, flanks)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Setup: a triangle of discs with a slope of 1 : 2 on a lattice of 1 mm; its angle is 26.57 degrees.
    #[test]
    fn the_slope_of_a_triangle_is_its_own() {
        let mut discs = Vec::new();
        for row in 0..30 {
            let half = 2 * (30 - row);
            for column in -half..=half {
                let x = 0.1 + 1e-3 * f64::from(column);
                discs.push([x, 1e-3 * (f64::from(row) + 0.5), 5e-4, 1.0]);
            }
        }
        let slope = surface_angle_deg(&discs, 0.2).unwrap();
        assert!((slope - 26.57).abs() < 1.5, "{slope}");
        // A distant disc is not part of the bed.
        let level: Vec<[f64; 4]> =
            (0..20).map(|column| [1e-3 * (f64::from(column) + 0.5), 5e-4, 5e-4, 1.0]).collect();
        let stray = [0.15, 5e-4, 5e-4, 1.0];
        let reach = deposit_length_m(&[&level[..], &[stray]].concat(), 0.2).unwrap();
        assert!((reach - 0.02).abs() < 1e-12, "{reach}");
    }
}

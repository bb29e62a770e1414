//! The contact forces of a frame: lines whose width is the normal force, only if the manifest requests them.

use super::encoding::{ABSENT, append_series, quantized};
use super::view::Range;
use kinetoscope_recording::channels::DemContactForces;
use kinetoscope_recording::reader::RecordedFrame;

/// Maximum number of lines per frame, those of the largest forces.
const MOST_LINES: usize = 300;

/// A contact with a force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ForceLine {
    /// Center of a disc, and that of the touching disc or the nearest point of a wall.
    pub(super) ends: [[f64; 2]; 2],
    /// Normal force, N.
    pub(super) force: f64,
}

/// The drawn forces of a frame, those of `/contact_forces`, and the number of all.
pub(super) fn forces(frame: &RecordedFrame) -> (Vec<ForceLine>, usize) {
    let columns = frame.get::<DemContactForces>().ok().flatten();
    columns.map_or_else(Default::default, |columns| strongest(of_columns(&columns)))
}

/// The component of each force along its branch; a pull is as wide as a push.
fn of_columns(columns: &DemContactForces) -> Vec<ForceLine> {
    let vectors = |x: &[f64], y: &[f64]| -> Vec<[f64; 2]> {
        x.iter().zip(y).map(|(&x, &y)| [x, y]).collect()
    };
    let from = vectors(&columns.from_x_m, &columns.from_y_m);
    let to = vectors(&columns.to_x_m, &columns.to_y_m);
    let forces = vectors(&columns.force_x_n, &columns.force_y_n);
    let lines = from.iter().zip(&to).zip(&forces).map(|((from, to), force)| {
        let [x, y] = [from[0] - to[0], from[1] - to[1]];
        let force = (force[0] * x + force[1] * y).abs() / libm::hypot(x, y);
        ForceLine { ends: [*from, *to], force }
    });
    lines.collect()
}

/// The lines of the largest forces, in the order of the recording, and the number of all; none of a contact without a force.
fn strongest(mut lines: Vec<ForceLine>) -> (Vec<ForceLine>, usize) {
    lines.retain(|line| line.force > 0.0 && line.force.is_finite());
    let all = lines.len();
    if let Some(left_out) = all.checked_sub(MOST_LINES) {
        let mut sizes: Vec<f64> = lines.iter().map(|line| line.force).collect();
        let weakest = *sizes.select_nth_unstable_by(left_out, f64::total_cmp).1;
        lines.retain(|line| line.force >= weakest);
        lines.truncate(MOST_LINES);
    }
    (lines, all)
}

/// States that the lines of a frame are not all of its forces.
pub(super) fn note(all: usize) -> String {
    match all > MOST_LINES {
        true => format!(" The {MOST_LINES} largest of up to {all} contact forces are drawn."),
        false => String::new(),
    }
}

/// Appends the lines, five series: x and y of both ends, and the force over the typical largest one. Returns how many lines each frame has room for, and that force.
pub(super) fn append_forces(
    data: &mut Vec<u8>,
    frames: &[&[ForceLine]],
    range: &Range,
) -> (usize, f64) {
    let most = frames.iter().map(|lines| lines.len()).max().unwrap_or(0);
    let top = typical_largest(frames.iter().copied());
    let series = |value: &dyn Fn(&ForceLine) -> u16| -> Vec<u16> {
        let of_frame = |lines: &&[ForceLine]| {
            let values: Vec<u16> = lines.iter().map(value).collect();
            values.into_iter().chain(std::iter::repeat(ABSENT)).take(most)
        };
        frames.iter().flat_map(of_frame).collect()
    };
    for end in 0..if most > 0 { 2 } else { 0 } {
        for axis in 0..2 {
            append_series(data, &series(&|line| range.stored(line.ends[end])[axis]), most, 1);
        }
    }
    if most > 0 {
        append_series(data, &series(&|line| quantized(line.force / top, STEP)), most, 1);
    }
    (most, top)
}

/// The median of the largest forces of the frames with a contact: a single impact does not make all other lines thin. 0 without forces.
fn typical_largest<'a>(frames: impl Iterator<Item = &'a [ForceLine]>) -> f64 {
    let largest = |lines: &[ForceLine]| lines.iter().map(|it| it.force).max_by(f64::total_cmp);
    let mut all: Vec<f64> = frames.filter_map(largest).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0)
}

/// Step of a stored force, over the typical largest one.
const STEP: f64 = 1.0 / 255.0;

#[cfg(test)]
mod tests {
    use super::{MOST_LINES, note, of_columns, strongest, typical_largest};
    use kinetoscope_recording::channels::DemContactForces;

    /// Contacts along x at these heights, with these forces on the first disc along x, and friction along y.
    fn columns(forces: &[f64]) -> DemContactForces {
        let of = |value: f64| vec![value; forces.len()];
        DemContactForces {
            from_x_m: of(0.0),
            from_y_m: (0..forces.len()).map(|height| height as f64).collect(),
            to_x_m: of(-2.0),
            to_y_m: (0..forces.len()).map(|height| height as f64).collect(),
            force_x_n: forces.to_vec(),
            force_y_n: of(7.0),
            ..DemContactForces::default()
        }
    }

    /// Guarantee: the line of the largest normal force is the widest. Control: discs that do not press on each other have no line, whatever their friction.
    #[test]
    fn width_is_the_normal_force() {
        let (lines, all) = strongest(of_columns(&columns(&[1.0, 0.0, 4.0, 2.0])));
        assert_eq!(note(all), "");
        let widths: Vec<f64> = lines.iter().map(|line| line.force).collect();
        assert_eq!(widths, [1.0, 4.0, 2.0]);
        assert_eq!(lines[1].ends, [[0.0, 2.0], [-2.0, 2.0]]);
    }

    /// Guarantee: frames without a contact and a single impact do not change the scale of the widths.
    #[test]
    fn scale_of_the_widths_is_that_of_a_typical_frame() {
        let frame = |force: f64| strongest(of_columns(&columns(&[force, force / 2.0]))).0;
        let frames = [0.0, 3.0, 3.0, 900.0].map(frame);
        assert_eq!(typical_largest(frames.iter().map(|lines| &**lines)), 3.0);
        assert_eq!(typical_largest(frames[..1].iter().map(|lines| &**lines)), 0.0);
    }

    /// Guarantee: the weakest of very many forces are left out, which the replay states.
    #[test]
    fn left_out_forces_are_the_weakest_and_counted() {
        let all: Vec<f64> = (1..=1000).map(f64::from).collect();
        let (lines, all) = strongest(of_columns(&columns(&all)));
        assert_eq!(lines.len(), MOST_LINES);
        assert_eq!(lines[0].force, 701.0);
        assert_eq!(note(all), " The 300 largest of up to 1000 contact forces are drawn.");
        let (equal, _) = strongest(of_columns(&columns(&[3.0; 1000])));
        assert_eq!(equal.len(), MOST_LINES);
    }
}

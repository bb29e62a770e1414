//! The contact forces that a drawing shows: only the strongest, because a bed of a million discs has millions.

/// A contact force, drawn as a line between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLine {
    /// One end, in the state's length unit.
    pub from: [f64; 2],
    /// The other end.
    pub to: [f64; 2],
    /// Normal force, in the unit of `Scenery::force_range_top`.
    pub force: f64,
}

/// Contact forces in the order of addition, without some that are too weak to be drawn.
#[derive(Clone, Debug)]
pub(crate) struct ForceLines {
    lines: Vec<ContactLine>,
    /// Number of forces drawn; more only if forces are equal.
    drawn_at_most: usize,
    /// Length at which the weak forces are removed.
    full_at: usize,
}

/// Keeps every contact, for a frame that is not recorded.
impl Default for ForceLines {
    fn default() -> Self {
        Self::drawing(usize::MAX)
    }
}

impl PartialEq for ForceLines {
    fn eq(&self, other: &Self) -> bool {
        self.lines == other.lines
    }
}

impl ForceLines {
    /// A list of forces of which at most `at_most` are drawn.
    pub(crate) fn drawing(at_most: usize) -> Self {
        Self { lines: Vec::new(), drawn_at_most: at_most, full_at: at_most.saturating_mul(2) }
    }

    pub(crate) fn clear(&mut self) {
        *self =
            Self { lines: std::mem::take(&mut self.lines), ..Self::drawing(self.drawn_at_most) };
        self.lines.clear();
    }

    pub(crate) fn push(&mut self, line: ContactLine) {
        if self.drawn_at_most == 0 {
            return;
        }
        self.lines.push(line);
        if self.lines.len() >= self.full_at {
            let weakest = weakest_drawn(&self.lines, self.drawn_at_most);
            self.lines.retain(|line| line.force.abs() >= weakest);
            // If all forces are equal, none was removed, and the next removal must not follow at once.
            self.full_at = 2 * Ord::max(self.lines.len(), self.drawn_at_most);
        }
    }

    pub(crate) fn lines(&self) -> &[ContactLine] {
        &self.lines
    }
}

/// The force below which contacts are left out, so that `at_most` are drawn, and more only where forces are equal; 0 draws
/// all. It does not change when weaker ones are left out before.
pub(crate) fn weakest_drawn(lines: &[ContactLine], at_most: usize) -> f64 {
    let Some(left_out) = lines.len().checked_sub(at_most).filter(|&left_out| left_out > 0) else {
        return 0.0;
    };
    let mut forces: Vec<f64> = lines.iter().map(|line| line.force.abs()).collect();
    *forces.select_nth_unstable_by(left_out, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(force: f64) -> ContactLine {
        ContactLine { from: [0.0, 0.0], to: [1.0, 0.0], force }
    }

    fn drawn(lines: &[ContactLine], at_most: usize) -> Vec<f64> {
        let weakest = weakest_drawn(lines, at_most);
        let forces = lines.iter().map(|line| line.force);
        forces.filter(|force| force.abs() >= weakest).collect()
    }

    /// Forces in no order, with many that are equal, and pulls among them.
    #[test]
    fn forces_left_out_early_would_not_have_been_drawn() {
        for kinds in [3, 17, 1000] {
            let all: Vec<_> = (0..997_i32).map(|i| line(f64::from(i * 577 % kinds - 5))).collect();
            let mut kept = ForceLines::drawing(40);
            all.iter().for_each(|&line| kept.push(line));
            assert_eq!(drawn(kept.lines(), 40), drawn(&all, 40));
            if kinds == 1000 {
                assert!(kept.lines().len() < 80, "{}", kept.lines().len());
            }
        }
    }
}

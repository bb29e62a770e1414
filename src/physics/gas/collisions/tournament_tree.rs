//! Tournament tree that finds the earliest event. Its result depends only on the times and numbers of the discs.

/// Binary tree of comparisons between discs: the earlier event wins; among equal times, the lower number wins.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TournamentTree {
    /// Event times of the discs.
    times: Vec<f64>,
    /// Winner of each comparison, the root first; the children of node k are 2 k + 1 and 2 k + 2.
    winners: Vec<u32>,
}

impl TournamentTree {
    /// Builds the tree for the times of at least one disc.
    pub(super) fn new(times: Vec<f64>) -> Self {
        let mut tree = Self { winners: vec![0; times.len() - 1], times };
        for at in (0..tree.winners.len()).rev() {
            tree.compare(at);
        }
        tree
    }

    /// Disc with the earliest event, and the time of that event.
    pub(super) fn earliest(&self) -> (u32, f64) {
        let first = self.winners.first().copied().unwrap_or(0);
        (first, self.times[first as usize])
    }

    /// Changes the time of a disc.
    pub(super) fn set(&mut self, disc: u32, time: f64) {
        self.times[disc as usize] = time;
        let mut at = self.winners.len() + disc as usize;
        while at > 0 {
            at = (at - 1) / 2;
            self.compare(at);
        }
    }

    fn compare(&mut self, at: usize) {
        let [one, other] = [self.disc_at(2 * at + 1), self.disc_at(2 * at + 2)];
        let times = [self.times[one as usize], self.times[other as usize]];
        let first_wins = times[0] < times[1] || (times[0] == times[1] && one < other);
        self.winners[at] = if first_wins { one } else { other };
    }

    /// Disc at a node: a leaf, or the winner of a comparison.
    fn disc_at(&self, node: usize) -> u32 {
        match node.checked_sub(self.winners.len()) {
            Some(disc) => disc as u32,
            None => self.winners[node],
        }
    }
}

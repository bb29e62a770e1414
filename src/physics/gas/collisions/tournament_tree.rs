//! Whose event is the soonest: a knockout tournament. Its answer follows from the times and numbers of the discs alone.

/// A tree of matches over the discs; the sooner event wins, of equal ones that of the lower number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Soonest {
    /// Times of the discs' events.
    times: Vec<f64>,
    /// The winner of each match, the final first; the children of match k are 2 k + 1 and 2 k + 2.
    winners: Vec<u32>,
}

impl Soonest {
    /// The tournament of these times, of one disc at least.
    pub(super) fn of(times: Vec<f64>) -> Self {
        let mut tree = Self { winners: vec![0; times.len() - 1], times };
        for at in (0..tree.winners.len()).rev() {
            tree.play(at);
        }
        tree
    }

    /// The disc whose event is the soonest, and when that is.
    pub(super) fn first(&self) -> (u32, f64) {
        let first = self.winners.first().copied().unwrap_or(0);
        (first, self.times[first as usize])
    }

    /// Gives a disc another time.
    pub(super) fn set(&mut self, disc: u32, time: f64) {
        self.times[disc as usize] = time;
        let mut at = self.winners.len() + disc as usize;
        while at > 0 {
            at = (at - 1) / 2;
            self.play(at);
        }
    }

    fn play(&mut self, at: usize) {
        let [one, other] = [self.entrant(2 * at + 1), self.entrant(2 * at + 2)];
        let times = [self.times[one as usize], self.times[other as usize]];
        let first_wins = times[0] < times[1] || (times[0] == times[1] && one < other);
        self.winners[at] = if first_wins { one } else { other };
    }

    /// Who comes to a match from below: a disc, or the winner of another match.
    fn entrant(&self, node: usize) -> u32 {
        match node.checked_sub(self.winners.len()) {
            Some(disc) => disc as u32,
            None => self.winners[node],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Law: the winner is the least of all (time, number), after any changes, for any number of discs.
    #[test]
    fn the_first_is_the_least() {
        for count in 1..40_u32 {
            let time = |k: u32| f64::from(k * 7 % 11);
            let mut times: Vec<f64> = (0..count).map(time).collect();
            let mut tree = Soonest::of(times.clone());
            for change in 0..200 {
                let least = (0..count).fold(0, |best, disc| {
                    if times[disc as usize] < times[best as usize] { disc } else { best }
                });
                assert_eq!(tree.first(), (least, times[least as usize]), "{count} discs");
                times[least as usize] += time(change) / 4.0;
                tree.set(least, times[least as usize]);
            }
        }
    }
}

//! A copy of a run at one instant, from which another thread fills a frame while the run moves on.
//!
//! To fill a frame takes as long as several steps: forces, ledger, contacts, rows by id. To copy takes as long as one: what
//! is large is copied as it lies in memory, into memory that is kept from frame to frame.

use super::Dem;
use super::discs::Discs;
use super::neighbours::{Block, Neighbours, Pairs};
use super::rain::Rain;
use super::step::Workspace;
use kinetoscope_recording::frame::{Frame, Snapshot};

/// All of a run that is looked at. Empty until one is taken.
#[derive(Debug, Default)]
pub struct DemSnapshot {
    /// The run without its lists.
    run: Option<Dem>,
    neighbours: Neighbours,
}

impl DemSnapshot {
    /// Takes a run as it is now.
    pub(super) fn take(&mut self, run: &Dem) {
        let mut discs = self.run.take().map_or_else(Discs::default, |earlier| earlier.discs);
        copy_discs(&mut discs, &run.discs);
        copy_lists(&mut self.neighbours, &run.neighbours);
        self.run = Some(Dem {
            discs,
            neighbours: Neighbours::default(),
            workspace: Workspace::default(),
            parameters: run.parameters.clone(),
            count: run.count,
            ledger: run.ledger.clone(),
            removed: run.removed,
            rain: run.rain.as_ref().map(Rain::without_those_to_come),
            initial_top_speed: run.initial_top_speed,
            damping_step: run.damping_step,
            window: run.window.clone(),
            facts: run.facts.clone(),
            warnings: run.warnings.clone(),
            use_lanes: run.use_lanes,
        });
    }
}

impl Snapshot for DemSnapshot {
    fn fill(&mut self, frame: &mut Frame) {
        if let Some(run) = &self.run {
            run.fill(&self.neighbours, frame);
        }
    }
}

fn copy_discs(copy: &mut Discs, discs: &Discs) {
    let Discs { ids, states, spins, radii, masses, inverse_masses, materials } = discs;
    copy.ids.clone_from(ids);
    copy.states.copy_from(states);
    copy.spins.clone_from(spins);
    copy.radii.clone_from(radii);
    copy.masses.clone_from(masses);
    copy.inverse_masses.clone_from(inverse_masses);
    copy.materials.clone_from(materials);
}

/// Who touches whom, without what tells when lists are too old.
fn copy_lists(copy: &mut Neighbours, neighbours: &Neighbours) {
    copy.blocks.resize_with(neighbours.blocks.len(), Block::default);
    for (copy, block) in copy.blocks.iter_mut().zip(&neighbours.blocks) {
        let Block { start, inner, edges, shifts, walls } = block;
        copy.start = *start;
        copy_pairs(&mut copy.inner, inner);
        copy_pairs(&mut copy.edges, edges);
        copy.shifts.clone_from(shifts);
        copy.walls.clone_from(walls);
    }
}

fn copy_pairs(copy: &mut Pairs, pairs: &Pairs) {
    let Pairs { first, second, reach, damping, stretch, rolling_stretch, ends } = pairs;
    copy.ends = *ends;
    copy.first.clone_from(first);
    copy.second.clone_from(second);
    copy.reach.clone_from(reach);
    copy.damping.clone_from(damping);
    copy.stretch.clone_from(stretch);
    copy.rolling_stretch.clone_from(rolling_stretch);
}

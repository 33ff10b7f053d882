//! From a plan, its targets and what is resident to a schedule.

use std::{collections::HashSet, ops::RangeBounds, sync::Arc};

use crate::{
    Decision, History, LeafIndex, MissingLeaf, Output, PassIndex, Plan, PlanError, Reason, Schedule, Stamp, Step,
    plan::{Cull, PassNode, Source},
};

/// What may be skipped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Skipping {
    /// Whatever is resident is reused.
    #[default]
    On,
    /// Every pass on a path to a target runs. Leaves are data, not work: they are materialised only where missing.
    Off,
    /// Whatever is resident is executed again and compared. A pass that such an execution reads from and that is not
    /// resident runs, since there is nothing to compare it with.
    Verify,
}

const NOT_NEEDED: &str = "nothing shown needs it";

/// What the targets ask of every pass and leaf.
struct Demand {
    /// A path of inputs leads from a target to the pass.
    reached: Vec<bool>,
    /// The pass has to run because an output that is read is not resident, skipping being on.
    missing: Vec<bool>,
    /// The pass is executed under the skipping asked for.
    executed: Vec<bool>,
    /// The leaf is read by an executed pass, or is itself a target.
    leaves: Vec<bool>,
}

/// How strongly an output slot is asked for.
#[derive(Clone, Copy, Default)]
struct SlotDemand {
    /// By a path to a target.
    reached: bool,
    /// By a target or a pass that runs with skipping on.
    needed: bool,
}

impl<W> Plan<W> {
    /// Decides what becomes of every pass when `targets` are wanted and `resident` tells which stamps are in memory.
    ///
    /// `resident` must not change its answers during the call, and what it affirmed has to stay in memory until the
    /// schedule is executed. `history` is brought up to date.
    ///
    /// # Errors
    /// [`PlanError::ForeignTarget`] if a target was not made by this plan.
    pub fn resolve(
        &self,
        targets: &[Output],
        resident: impl Fn(Stamp) -> bool,
        history: &mut History,
        skipping: Skipping,
    ) -> Result<Schedule, PlanError> {
        self.resolve_rounds(targets, ..=self.round, resident, history, skipping)
    }

    /// As [`Plan::resolve`] for one round after the other: the schedule is about `round` and needs none behind it. What the rounds
    /// before have computed is taken as it is, whatever is skipped, and runs again only where it is no longer resident.
    ///
    /// # Errors
    /// As [`Plan::resolve`].
    pub fn resolve_round(
        &self,
        targets: &[Output],
        round: u32,
        resident: impl Fn(Stamp) -> bool,
        history: &mut History,
        skipping: Skipping,
    ) -> Result<Schedule, PlanError> {
        self.resolve_rounds(targets, round..=round, resident, history, skipping)
    }

    fn resolve_rounds(
        &self,
        targets: &[Output],
        rounds: impl RangeBounds<u32>,
        resident: impl Fn(Stamp) -> bool,
        history: &mut History,
        skipping: Skipping,
    ) -> Result<Schedule, PlanError> {
        if let Some(position) = targets.iter().position(|target| !self.owns(*target)) {
            return Err(PlanError::ForeignTarget { position });
        }
        let demand = self.demand(targets, &rounds, &resident, skipping);
        let steps = self.steps(&demand, &rounds, history, skipping);
        Ok(Schedule { leaves: self.missing_leaves(&demand, &resident), steps })
    }

    /// Walks from the targets to the leaves, against the order of declaration: all readers of a pass come before it.
    fn demand(
        &self,
        targets: &[Output],
        rounds: &impl RangeBounds<u32>,
        resident: &impl Fn(Stamp) -> bool,
        skipping: Skipping,
    ) -> Demand {
        let mut slots: Vec<Vec<SlotDemand>> =
            self.passes.iter().map(|node| vec![SlotDemand::default(); node.stamps.len()]).collect();
        let mut demand = Demand {
            reached: vec![false; self.passes.len()],
            missing: vec![false; self.passes.len()],
            executed: vec![false; self.passes.len()],
            leaves: vec![false; self.leaves.len()],
        };
        for target in targets {
            match target.source {
                Source::Leaf(leaf) => demand.leaves[leaf.0] = true,
                Source::Slot(pass, slot) => slots[pass.0][slot] = SlotDemand { reached: true, needed: true },
            }
        }
        for (index, node) in self.passes.iter().enumerate().rev() {
            let absent = |wanted: fn(&SlotDemand) -> bool| {
                slots[index].iter().zip(&*node.stamps).any(|(slot, stamp)| wanted(slot) && !resident(*stamp))
            };
            let reached = slots[index].iter().any(|slot| slot.reached);
            let missing = absent(|slot| slot.needed);
            demand.reached[index] = reached;
            let forced = reached && skipping != Skipping::On && rounds.contains(&node.round);
            demand.executed[index] = missing || forced;
            demand.missing[index] = missing || (forced && skipping == Skipping::Verify && absent(|slot| slot.reached));
            for (_, input) in &node.pass.inputs {
                match input.source {
                    Source::Leaf(leaf) => demand.leaves[leaf.0] |= demand.executed[index],
                    Source::Slot(pass, slot) => {
                        let slot = &mut slots[pass.0][slot];
                        slot.reached |= reached;
                        slot.needed |= missing;
                    }
                }
            }
        }
        demand
    }

    fn missing_leaves(&self, demand: &Demand, resident: &impl Fn(Stamp) -> bool) -> Vec<MissingLeaf> {
        let mut listed = HashSet::new();
        self.leaves
            .iter()
            .zip(&self.leaf_stamps)
            .enumerate()
            .filter(|(index, (_, stamp))| demand.leaves[*index] && !resident(**stamp) && listed.insert(**stamp))
            .map(|(index, (leaf, stamp))| MissingLeaf { leaf: LeafIndex(index), name: leaf.name, stamp: *stamp })
            .collect()
    }

    /// All passes in order of declaration, those the caller culled at their place among them.
    fn steps(
        &self,
        demand: &Demand,
        rounds: &impl RangeBounds<u32>,
        history: &mut History,
        skipping: Skipping,
    ) -> Vec<Step> {
        let mut steps = Vec::new();
        let mut culls = self.culls.iter().filter(|cull| rounds.contains(&cull.round)).peekable();
        // Of other rounds, only what has to run again.
        let passes = self.passes.iter().enumerate();
        for (index, node) in passes.filter(|(index, node)| rounds.contains(&node.round) || demand.missing[*index]) {
            while let Some(cull) = culls.next_if(|cull| cull.position <= index) {
                steps.push(culled(cull));
            }
            let decision = decide(node, demand, index, history, skipping);
            steps.push(Step {
                name: node.pass.name,
                round: node.round,
                instance: node.pass.instance,
                pass: Some(PassIndex(index)),
                decision,
                verify: decision == Decision::Reused && demand.executed[index],
                outputs: Arc::clone(&node.stamps),
            });
        }
        steps.extend(culls.map(culled));
        steps
    }
}

fn decide<W>(node: &PassNode<W>, demand: &Demand, index: usize, history: &mut History, skipping: Skipping) -> Decision {
    if !demand.reached[index] {
        return Decision::Culled(NOT_NEEDED);
    }
    let reason = history.record((node.pass.name, node.round, node.pass.instance), &node.fields);
    if demand.missing[index] {
        Decision::Ran(reason)
    } else if skipping == Skipping::Off && demand.executed[index] {
        Decision::Ran(Reason::Forced)
    } else {
        Decision::Reused
    }
}

fn culled(cull: &Cull) -> Step {
    Step {
        name: cull.name,
        round: cull.round,
        instance: cull.instance,
        pass: None,
        decision: Decision::Culled(cull.reason),
        verify: false,
        outputs: Arc::default(),
    }
}

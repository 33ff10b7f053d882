//! A toy frame and its interpreter: passes hash numbers. The values are computed without any stamp, so that they can
//! tell whether stamps are right.

use std::{
    collections::{HashMap, HashSet},
    hash::{DefaultHasher, Hash, Hasher},
};

use murano_scheduler::{History, Output, Pass, Plan, Schedule, Skipping, Stamp, StampBuilder};

/// Names of inputs, by position.
pub const INPUT_NAMES: [&str; 4] = ["body", "light", "floor", "sky"];

/// A pass that hashes what it reads.
#[derive(Clone, Debug, Hash)]
pub struct ToyPass {
    pub code: u8,
    pub gain: u8,
    /// One byte a slot.
    pub extents: Vec<u8>,
    /// Indices of sources; see [`Toy::sources_before`].
    pub inputs: Vec<usize>,
}

/// A frame. Sources are numbered: first the leaves, then the slots of all passes in order.
#[derive(Clone, Debug)]
pub struct Toy {
    pub leaves: Vec<u8>,
    pub passes: Vec<ToyPass>,
    pub targets: Vec<usize>,
}

/// What the interpreter needs to know of a node.
pub enum Work {
    Leaf(u8),
    Pass(usize),
}

/// The executor's memory: contents by stamp.
#[derive(Default)]
pub struct Store {
    pub contents: HashMap<Stamp, u64>,
    pub history: History,
}

impl Toy {
    /// Number of sources declared before a pass, all of which it may read.
    pub fn sources_before(&self, pass: usize) -> usize {
        self.leaves.len() + self.passes[..pass].iter().map(|pass| pass.extents.len()).sum::<usize>()
    }

    /// The pass that a source is a slot of; `None` for a leaf.
    pub fn producer(&self, source: usize) -> Option<usize> {
        (0..self.passes.len())
            .rev()
            .find(|&pass| source >= self.sources_before(pass))
            .filter(|_| source >= self.leaves.len())
    }

    /// Passes on a path to a target.
    pub fn reached(&self) -> HashSet<usize> {
        let mut open: Vec<usize> = self.targets.iter().filter_map(|&target| self.producer(target)).collect();
        let mut reached = HashSet::new();
        while let Some(pass) = open.pop() {
            if reached.insert(pass) {
                open.extend(self.passes[pass].inputs.iter().filter_map(|&input| self.producer(input)));
            }
        }
        reached
    }

    /// Sources that a leaf or pass can influence: `changed` is a leaf's source number, or any slot of the pass.
    pub fn downstream(&self, changed: impl Fn(usize) -> bool) -> HashSet<usize> {
        let mut sources: HashSet<usize> = (0..self.sources_before(self.passes.len())).filter(|&s| changed(s)).collect();
        for (index, pass) in self.passes.iter().enumerate() {
            if pass.inputs.iter().any(|input| sources.contains(input)) {
                let first = self.sources_before(index);
                sources.extend(first..first + pass.extents.len());
            }
        }
        sources
    }

    /// Declares everything; returns the outputs by source number.
    pub fn plan(&self) -> (Plan<Work>, Vec<Output>) {
        let mut plan = Plan::new();
        let mut outputs: Vec<Output> =
            self.leaves.iter().map(|&value| plan.leaf("leaf", Stamp::of(&[value]), Work::Leaf(value))).collect();
        for (index, pass) in self.passes.iter().enumerate() {
            let declared = plan.add(Pass {
                name: "pass",
                instance: index as u32,
                subject: index as u32,
                code: StampBuilder::new("code").number(pass.code.into()).finish(),
                params: vec![("gain", vec![pass.gain])],
                inputs: pass.inputs.iter().zip(INPUT_NAMES).map(|(&input, name)| (name, outputs[input])).collect(),
                outputs: pass.extents.iter().map(|&extent| ("slot", vec![extent])).collect(),
                work: Work::Pass(index),
            });
            outputs.extend(declared.expect("every declaration is legal"));
        }
        (plan, outputs)
    }

    /// Values of the targets, computed directly.
    pub fn truth(&self) -> Vec<u64> {
        let mut values: Vec<u64> = self.leaves.iter().map(|&value| leaf_value(value)).collect();
        for index in 0..self.passes.len() {
            let inputs: Vec<u64> = self.passes[index].inputs.iter().map(|&input| values[input]).collect();
            values.extend((0..self.passes[index].extents.len()).map(|slot| self.slot_value(index, slot, &inputs)));
        }
        self.targets.iter().map(|&target| values[target]).collect()
    }

    /// Plans and executes with what the store holds; returns the schedule and the values of the targets.
    pub fn run(&self, store: &mut Store, skipping: Skipping) -> (Schedule, Vec<u64>) {
        let (plan, outputs) = self.plan();
        let targets: Vec<Output> = self.targets.iter().map(|&target| outputs[target]).collect();
        let contents = &mut store.contents;
        let schedule = plan
            .resolve(&targets, |stamp| contents.contains_key(&stamp), &mut store.history, skipping)
            .expect("the targets are the plan's");
        for missing in &schedule.leaves {
            let Work::Leaf(value) = plan.leaf_at(missing.leaf).work else { panic!("not a leaf") };
            assert!(contents.insert(missing.stamp, leaf_value(value)).is_none(), "a resident leaf was materialised");
        }
        for (index, step) in schedule.executed() {
            let pass = plan.pass(index);
            let inputs: Vec<u64> = pass.inputs.iter().map(|(_, input)| contents[&input.stamp()]).collect();
            let Work::Pass(toy) = pass.work else { panic!("not a pass") };
            for (slot, &stamp) in step.outputs.iter().enumerate() {
                let value = self.slot_value(toy, slot, &inputs);
                let old = if step.verify { contents.get(&stamp).copied() } else { contents.insert(stamp, value) };
                assert!(old.is_none_or(|old| old == value), "one stamp, two contents");
            }
        }
        let values = targets.iter().map(|target| contents[&target.stamp()]).collect();
        (schedule, values)
    }

    fn slot_value(&self, pass: usize, slot: usize, inputs: &[u64]) -> u64 {
        let ToyPass { code, gain, extents, .. } = &self.passes[pass];
        hash(&(pass, code, gain, extents, inputs, slot))
    }
}

/// Numbers of the passes that a schedule executes, be it to use or to compare.
pub fn executed(schedule: &Schedule) -> HashSet<usize> {
    schedule.executed().map(|(_, step)| step.instance as usize).collect()
}

fn leaf_value(value: u8) -> u64 {
    hash(&("leaf", value))
}

fn hash(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

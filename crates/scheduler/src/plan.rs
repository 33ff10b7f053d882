//! Declaring a frame.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use crate::{Stamp, StampBuilder, history::Field};

/// Index of a pass within its [`Plan`], in order of declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PassIndex(pub(crate) usize);

/// Index of a leaf within its [`Plan`], in order of declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LeafIndex(pub(crate) usize);

/// A pure function of the frame: what it is called, everything that its outputs depend on, and the work itself.
///
/// `work` is not part of the pass's identity: two declarations that differ only in `work` are the same computation.
pub struct Pass<W> {
    /// What it does, the same in every frame.
    pub name: &'static str,
    /// Tells passes of one name apart: the caster's number, the light's number.
    pub instance: u32,
    /// What it is about: part of its key, as the name is. The instance, but for a pass that does at another moment what another
    /// does now, and so finds what that has left.
    pub subject: u32,
    /// Identity of the code: shader source and pipeline state.
    pub code: Stamp,
    /// Named parameters as bytes, by value.
    pub params: Vec<(&'static str, Vec<u8>)>,
    /// Named outputs of other passes, or leaves, that it reads.
    pub inputs: Vec<(&'static str, Output)>,
    /// Slots it writes: a name, and bytes that describe extent and format.
    pub outputs: Vec<(&'static str, Vec<u8>)>,
    /// Whatever the executor needs to run it.
    pub work: W,
}

/// Data given by value.
pub struct Leaf<W> {
    /// What it is.
    pub name: &'static str,
    /// Identity of its bytes.
    pub content: Stamp,
    /// Whatever the executor needs to materialise it.
    pub work: W,
}

/// Where an [`Output`] comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Source {
    Leaf(LeafIndex),
    Slot(PassIndex, usize),
}

/// A leaf, or one output slot of one pass: what other passes name as their input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Output {
    pub(crate) source: Source,
    stamp: Stamp,
}

impl Output {
    /// Identity of its content.
    pub fn stamp(self) -> Stamp {
        self.stamp
    }
}

/// A frame that cannot be planned.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// Two passes of a round share name and instance.
    #[error("pass `{name}:{instance}` is declared twice in one plan; give each declaration its own instance number")]
    Duplicate {
        /// Name of the pass.
        name: &'static str,
        /// Instance of the pass.
        instance: u32,
    },
    /// An input was made by another plan.
    #[error(
        "input `{input}` of pass `{name}:{instance}` belongs to another plan; declare what makes it in this plan first"
    )]
    ForeignInput {
        /// Name of the pass that reads it.
        name: &'static str,
        /// Instance of the pass that reads it.
        instance: u32,
        /// Name of the input.
        input: &'static str,
    },
    /// A target was made by another plan.
    #[error("target number {position} belongs to another plan; resolve targets with the plan that declared them")]
    ForeignTarget {
        /// Position among the targets, from 0.
        position: usize,
    },
}

/// A declared pass with what follows from its declaration.
pub(crate) struct PassNode<W> {
    pub(crate) pass: Pass<W>,
    pub(crate) round: u32,
    /// Everything the key is made of, for telling what changed.
    pub(crate) fields: Arc<[Field]>,
    /// Stamps of the output slots.
    pub(crate) stamps: Arc<[Stamp]>,
}

/// A pass that the caller left out knowingly.
pub(crate) struct Cull {
    pub(crate) name: &'static str,
    pub(crate) round: u32,
    pub(crate) instance: u32,
    pub(crate) reason: &'static str,
    /// Number of passes declared before it.
    pub(crate) position: usize,
}

/// One frame as a value: leaves, passes, and passes left out.
///
/// A pass can only read what was declared before it, so the order of declaration is an order of execution and a plan
/// can have no cycle.
pub struct Plan<W> {
    pub(crate) leaves: Vec<Leaf<W>>,
    pub(crate) leaf_stamps: Vec<Stamp>,
    pub(crate) passes: Vec<PassNode<W>>,
    pub(crate) culls: Vec<Cull>,
    /// Names, rounds and instances.
    declared: HashSet<(&'static str, u32, u32)>,
    pub(crate) round: u32,
    /// The pass of each key.
    keys: HashMap<Stamp, PassIndex>,
}

impl<W> Default for Plan<W> {
    fn default() -> Self {
        Self::new()
    }
}

impl<W> Plan<W> {
    /// An empty plan.
    pub fn new() -> Self {
        Self {
            leaves: Vec::new(),
            leaf_stamps: Vec::new(),
            passes: Vec::new(),
            culls: Vec::new(),
            declared: HashSet::new(),
            round: 0,
            keys: HashMap::new(),
        }
    }

    /// From here on the same passes may be declared over again, such as for another sample of each pixel: what is the same as in a
    /// round before is that pass, and the others are told apart by their round.
    pub fn next_round(&mut self) {
        self.round += 1;
    }

    /// Declares data by value. Leaves of equal name and content are one thing to the executor.
    pub fn leaf(&mut self, name: &'static str, content: Stamp, work: W) -> Output {
        let stamp = StampBuilder::new("leaf").text(name).stamp(content).finish();
        let index = LeafIndex(self.leaves.len());
        self.leaves.push(Leaf { name, content, work });
        self.leaf_stamps.push(stamp);
        Output { source: Source::Leaf(index), stamp }
    }

    /// Declares a pass and returns its outputs in the order of its slots. One with the key of another instance is that pass.
    ///
    /// # Errors
    /// [`PlanError::Duplicate`] if name and instance are taken, [`PlanError::ForeignInput`] if an input was not made by
    /// this plan. The plan is then unchanged.
    pub fn add(&mut self, pass: Pass<W>) -> Result<Vec<Output>, PlanError> {
        let foreign = pass.inputs.iter().find(|(_, output)| !self.owns(*output));
        if let Some(&(input, _)) = foreign {
            return Err(PlanError::ForeignInput { name: pass.name, instance: pass.instance, input });
        }
        let fields = Field::all_of(&pass);
        let key = Field::key(pass.name, pass.subject, &fields);
        let declared = self.keys.get(&key).copied();
        let is_another = |same: &PassIndex| {
            let node = &self.passes[same.0];
            (node.round, node.pass.instance) != (self.round, pass.instance)
        };
        if let Some(same) = declared.filter(is_another) {
            return Ok(self.outputs_of(same));
        }
        self.declare(pass.name, pass.instance)?;

        let index = PassIndex(self.passes.len());
        let stamps: Arc<[Stamp]> = (0..pass.outputs.len())
            .map(|slot| StampBuilder::new("slot").stamp(key).number(slot as u64).finish())
            .collect();
        self.passes.push(PassNode { pass, round: self.round, fields, stamps });
        self.keys.insert(key, index);
        Ok(self.outputs_of(index))
    }

    fn outputs_of(&self, index: PassIndex) -> Vec<Output> {
        let stamps = self.passes[index.0].stamps.iter().enumerate();
        stamps.map(|(slot, &stamp)| Output { source: Source::Slot(index, slot), stamp }).collect()
    }

    /// Declares that a pass is left out because it cannot matter, so that the schedule can say so.
    ///
    /// # Errors
    /// [`PlanError::Duplicate`] if name and instance are taken.
    pub fn cull(&mut self, name: &'static str, instance: u32, reason: &'static str) -> Result<(), PlanError> {
        self.declare(name, instance)?;
        self.culls.push(Cull { name, round: self.round, instance, reason, position: self.passes.len() });
        Ok(())
    }

    /// The pass at an index of this plan.
    ///
    /// # Panics
    /// If the index is another, larger plan's.
    pub fn pass(&self, index: PassIndex) -> &Pass<W> {
        &self.passes[index.0].pass
    }

    /// Stamps of the output slots of a pass, in the order of its slots.
    ///
    /// # Panics
    /// If the index is another, larger plan's.
    pub fn stamps(&self, index: PassIndex) -> &[Stamp] {
        &self.passes[index.0].stamps
    }

    /// The leaf at an index of this plan.
    ///
    /// # Panics
    /// If the index is another, larger plan's.
    pub fn leaf_at(&self, index: LeafIndex) -> &Leaf<W> {
        &self.leaves[index.0]
    }

    /// Whether this plan made an output.
    pub(crate) fn owns(&self, output: Output) -> bool {
        let own = match output.source {
            Source::Leaf(leaf) => self.leaf_stamps.get(leaf.0),
            Source::Slot(pass, slot) => self.passes.get(pass.0).and_then(|node| node.stamps.get(slot)),
        };
        own == Some(&output.stamp)
    }

    fn declare(&mut self, name: &'static str, instance: u32) -> Result<(), PlanError> {
        let new = self.declared.insert((name, self.round, instance));
        if new { Ok(()) } else { Err(PlanError::Duplicate { name, instance }) }
    }
}

//! What is to be done, and why.

use std::{fmt, sync::Arc};

use crate::{LeafIndex, PassIndex, Stamp};

/// Why a pass has to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reason {
    /// It was on no path to a target before.
    FirstRun,
    /// The first parameter or input, by its name, that differs from the last frame in which the pass mattered;
    /// `"shader"` for its code, `"extent"` for the description of an output.
    Changed(&'static str),
    /// Nothing differs, but an output that is read is no longer resident.
    Evicted,
    /// Nothing requires it; skipping is off.
    Forced,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FirstRun => f.write_str("first run"),
            Self::Changed(name) => write!(f, "{name} changed"),
            Self::Evicted => f.write_str("evicted"),
            Self::Forced => f.write_str("skipping is off"),
        }
    }
}

/// What becomes of one pass in one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Decision {
    /// It is executed.
    Ran(Reason),
    /// Its outputs are there already, or nobody who is executed reads them.
    Reused,
    /// It cannot influence any target.
    Culled(&'static str),
}

impl Decision {
    /// "ran", "reused" or "culled".
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ran(_) => "ran",
            Self::Reused => "reused",
            Self::Culled(_) => "culled",
        }
    }

    /// Why, in a few words.
    pub fn reason(&self) -> String {
        match self {
            Self::Ran(reason) => reason.to_string(),
            Self::Reused => "nothing that runs needs it anew".into(),
            Self::Culled(reason) => (*reason).to_owned(),
        }
    }
}

impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reused => f.write_str(self.name()),
            Self::Ran(_) | Self::Culled(_) => write!(f, "{}: {}", self.name(), self.reason()),
        }
    }
}

/// One pass of the plan with its decision.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// Name of the pass.
    pub name: &'static str,
    /// Round in which it was declared, from 0 ([`Plan::next_round`](crate::Plan::next_round)).
    pub round: u32,
    /// Instance of the pass.
    pub instance: u32,
    /// The pass in its plan; `None` where the caller declared it culled and there is no work.
    pub pass: Option<PassIndex>,
    /// What becomes of it.
    pub decision: Decision,
    /// Whether it is reused, but to be executed again beside the resident outputs and compared with them.
    pub verify: bool,
    /// Stamps of its output slots.
    pub outputs: Arc<[Stamp]>,
}

impl Step {
    /// Name and instance, and behind a dot the round, but for the first.
    fn label(&self) -> String {
        let round = if self.round == 0 { String::new() } else { format!(".{}", self.round) };
        format!("{}:{}{round}", self.name, self.instance)
    }

    /// Whether its work is executed, be it to be used or to be compared.
    pub fn executes(&self) -> bool {
        self.verify || matches!(self.decision, Decision::Ran(_))
    }
}

/// A leaf that an executed pass or a target reads and that is not resident.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissingLeaf {
    /// The leaf in its plan.
    pub leaf: LeafIndex,
    /// Its name.
    pub name: &'static str,
    /// What its resource is to be known by.
    pub stamp: Stamp,
}

/// The decisions of one frame: materialise the leaves, then execute the steps in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// Leaves to materialise first, each stamp once.
    pub leaves: Vec<MissingLeaf>,
    /// Every pass of the plan, executed or not, in order of declaration, which is an order of execution.
    pub steps: Vec<Step>,
}

impl Schedule {
    /// The steps with work to execute, in order.
    pub fn executed(&self) -> impl Iterator<Item = (PassIndex, &Step)> {
        self.steps.iter().filter(|step| step.executes()).filter_map(|step| step.pass.map(|pass| (pass, step)))
    }

    /// What became of a pass of the first round; `None` if the plan does not name it.
    pub fn decision(&self, name: &str, instance: u32) -> Option<Decision> {
        self.steps
            .iter()
            .find(|step| (step.name, step.round, step.instance) == (name, 0, instance))
            .map(|step| step.decision)
    }
}

impl fmt::Display for Schedule {
    /// A table with a row a pass: name and instance, decision, reason.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let labels: Vec<String> = self.steps.iter().map(Step::label).collect();
        let width = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0);
        for (step, label) in self.steps.iter().zip(&labels) {
            let why = if step.verify { "executed again to compare".to_owned() } else { step.decision.reason() };
            let row = format!("{label:width$}  {:6}  {why}", step.decision.name());
            writeln!(f, "{}", row.trim_end())?;
        }
        for leaf in &self.leaves {
            writeln!(f, "{:width$}  leaf", leaf.name)?;
        }
        Ok(())
    }
}

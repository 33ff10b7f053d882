//! What passes looked like when they last mattered: the source of reasons.

use std::{collections::HashMap, sync::Arc};

use crate::{Pass, Reason, Stamp, StampBuilder};

/// Which part of a pass's identity a field is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Part {
    Code,
    Param,
    Extent,
    Input,
}

/// One named contribution to a pass's key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Field {
    part: Part,
    name: &'static str,
    stamp: Stamp,
}

impl Field {
    /// Everything the outputs of a pass depend on: code, parameters, extents, inputs, in this order.
    pub(crate) fn all_of<W>(pass: &Pass<W>) -> Arc<[Self]> {
        let code = Self { part: Part::Code, name: "shader", stamp: pass.code };
        let param = |(name, bytes): &(&'static str, Vec<u8>)| Self { part: Part::Param, name, stamp: Stamp::of(bytes) };
        let extent =
            |(name, bytes): &(&'static str, Vec<u8>)| Self { part: Part::Extent, name, stamp: Stamp::of(bytes) };
        let input =
            |(name, output): &(&'static str, crate::Output)| Self { part: Part::Input, name, stamp: output.stamp() };
        std::iter::once(code)
            .chain(pass.params.iter().map(param))
            .chain(pass.outputs.iter().map(extent))
            .chain(pass.inputs.iter().map(input))
            .collect()
    }

    /// The key of a pass with these fields.
    pub(crate) fn key(name: &str, subject: u32, fields: &[Self]) -> Stamp {
        let mut key = StampBuilder::new("pass");
        key.text(name).number(subject.into());
        for field in fields {
            key.number(field.part as u64).text(field.name).stamp(field.stamp);
        }
        key.finish()
    }

    fn names_the_same_as(self, other: Self) -> bool {
        (self.part, self.name) == (other.part, other.name)
    }

    /// What to call it in a reason: extents are one thing to people, whatever slots they belong to.
    fn label(self) -> &'static str {
        if self.part == Part::Extent { "extent" } else { self.name }
    }
}

/// Remembers the identity of every pass when it was last on a path to a target, so that the next frame can say what
/// differs. Kept by the caller from frame to frame; grows with the number of different passes only.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// By name, round and instance.
    records: HashMap<(&'static str, u32, u32), Arc<[Field]>>,
}

impl History {
    /// A history without any frame.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes note of a pass and tells why it would have to run if it does.
    pub(crate) fn record(&mut self, pass: (&'static str, u32, u32), fields: &Arc<[Field]>) -> Reason {
        match self.records.insert(pass, Arc::clone(fields)) {
            None => Reason::FirstRun,
            Some(last) => first_difference(&last, fields).map_or(Reason::Evicted, Reason::Changed),
        }
    }
}

/// Label of the first field that is new, gone or different.
fn first_difference(last: &[Field], now: &[Field]) -> Option<&'static str> {
    let position = last.iter().zip(now).position(|(a, b)| a != b).unwrap_or(last.len().min(now.len()));
    match (last.get(position), now.get(position)) {
        (Some(gone), Some(new)) if !gone.names_the_same_as(*new) => {
            let is_gone = !now.iter().any(|field| field.names_the_same_as(*gone));
            Some(if is_gone { gone.label() } else { new.label() })
        }
        (_, Some(field)) | (Some(field), None) => Some(field.label()),
        (None, None) => None,
    }
}

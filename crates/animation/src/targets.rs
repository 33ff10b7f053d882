//! Morph targets packed so that a target of weight 0 costs nothing, nor a vertex that a target does not move.
//!
//! Every target of an instance has a row of words, one for 32 of its vertices: which of them it moves, and where the first of
//! these stands in the list of displacements.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use murano_scene::Primitive;

use crate::geometry::{Geometry, Instance};
use crate::pose::Pose;

/// Vertices of a [`MorphWord`].
pub(crate) const WORD: usize = 32;

/// What a target does to 32 vertices.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MorphWord {
    /// Bit `k`: it moves the `k`-th of them.
    pub moved: u32,
    /// Index of the first displacement.
    pub first: u32,
}

/// A target that is not at weight 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ActiveTarget {
    /// Index of its first word.
    pub word: u32,
    /// Its weight.
    pub weight: f32,
}

/// The targets of an instance that are not at weight 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ActiveRange {
    /// First vertex of the instance.
    pub vertex: u32,
    /// First of its [`ActiveTarget`]s.
    pub start: u32,
    /// Behind the last.
    pub end: u32,
    /// Fills the record to 16 bytes; zero.
    pub padding: u32,
}

/// What a target does to a vertex of a primitive at weight 1: displacement of the position, metres, and of the normal.
pub(crate) fn displacement(primitive: &Primitive, target: usize, vertex: usize) -> Option<[Vec3; 2]> {
    let target = &primitive.targets[target];
    let at = |list: &Option<Vec<Vec3>>| list.as_ref().and_then(|list| list.get(vertex)).copied().unwrap_or_default();
    let normals = if primitive.normals.is_some() { at(&target.normals) } else { Vec3::ZERO };
    let both = [at(&target.positions), normals];
    (both != [Vec3::ZERO; 2]).then_some(both)
}

/// Words of a row.
pub(crate) fn words(vertices: usize) -> usize {
    vertices.div_ceil(WORD)
}

impl Geometry {
    /// Appends the rows of a primitive's targets; `sources` are its vertices as the instance has them.
    pub(crate) fn push_targets(&mut self, primitive: &Primitive, sources: &[usize]) {
        for target in 0..primitive.targets.len() {
            for sources in sources.chunks(WORD) {
                let mut word = MorphWord { moved: 0, first: self.displacements.len() as u32 };
                for (bit, &source) in sources.iter().enumerate() {
                    let Some([position, normal]) = displacement(primitive, target, source) else { continue };
                    word.moved |= 1 << bit;
                    self.displacements.push([position.x, position.y, position.z, normal.x, normal.y, normal.z]);
                }
                self.morph_words.push(word);
            }
        }
    }

    /// Appends the targets of a pose that are not at weight 0, and their range for every instance in order.
    pub fn push_active_targets(&self, pose: &Pose, targets: &mut Vec<ActiveTarget>, ranges: &mut Vec<ActiveRange>) {
        for instance in &self.instances {
            let start = targets.len() as u32;
            let weights = &pose.weights[instance.node];
            let row = words(instance.vertices.len()) as u32;
            for target in 0..instance.targets {
                let weight = weights.get(target as usize).map_or(0.0, |&weight| weight as f32);
                if weight != 0.0 {
                    targets.push(ActiveTarget { word: instance.morph_words + target * row, weight });
                }
            }
            let Instance { vertices, .. } = instance;
            ranges.push(ActiveRange { vertex: vertices.start, start, end: targets.len() as u32, padding: 0 });
        }
    }
}

//! Morph targets packed so that a target of weight 0 costs nothing, nor a vertex that a target does not move.
//!
//! Every 8 vertices of an instance have a row of words, one for each of its targets: which of the vertices it moves, and where
//! the first of these stands in the list of displacements. What neighbouring threads read one after the other so lies side by side.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use murano_scene::Primitive;

use crate::geometry::Geometry;
use crate::pose::Pose;

/// Vertices of a [`MorphWord`].
pub(crate) const WORD: usize = 8;

/// What a target does to 8 vertices.
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
    /// Index of its word in the first row.
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
    /// Words in a row: all targets of the instance.
    pub row: u32,
}

/// What a target does to a vertex of a primitive at weight 1: displacement of the position, metres, of the normal and the tangent.
pub(crate) fn displacement(primitive: &Primitive, target: usize, vertex: usize) -> Option<[Vec3; 3]> {
    let target = &primitive.targets[target];
    let at = |list: &Option<Vec<Vec3>>| list.as_ref().and_then(|list| list.get(vertex)).copied().unwrap_or_default();
    let normals = if primitive.normals.is_some() { at(&target.normals) } else { Vec3::ZERO };
    let all = [at(&target.positions), normals, at(&target.tangents)];
    (all != [Vec3::ZERO; 3]).then_some(all)
}

impl Geometry {
    /// Appends the rows of a primitive's targets; `sources` are its vertices as the instance has them, `framed` says whether tangents
    /// matter.
    pub(crate) fn push_targets(&mut self, primitive: &Primitive, sources: &[usize], framed: bool) {
        for sources in sources.chunks(WORD) {
            for target in 0..primitive.targets.len() {
                let mut word = MorphWord { moved: 0, first: self.displacements.len() as u32 };
                for (bit, &source) in sources.iter().enumerate() {
                    let Some([position, normal, tangent]) = displacement(primitive, target, source) else { continue };
                    word.moved |= 1 << bit;
                    if framed {
                        self.tangent_displacements.push(tangent.to_array());
                    }
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
            for target in 0..instance.targets {
                let weight = weights.get(target as usize).map_or(0.0, |&weight| weight as f32);
                if weight != 0.0 {
                    targets.push(ActiveTarget { word: instance.morph_words + target, weight });
                }
            }
            let end = targets.len() as u32;
            ranges.push(ActiveRange { vertex: instance.vertices.start, start, end, row: instance.targets });
        }
    }
}

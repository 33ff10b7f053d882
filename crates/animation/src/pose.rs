//! A scene at a moment: local transforms, morph weights, world matrices.

use glam::{DMat4, DQuat, DVec3, DVec4};
use murano_scene::{Channel, Clip, Local, NodeIndex, Path, Property, PropertyChannel, Scene, Transform};

use crate::layer::{Blend, Layer};
use crate::sample::{sample_rotation, sample_vector, sample_weights};

/// Transforms and weights of every node of a scene, all in f64. Lists have one entry per node.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Own transform, `parent_from_local`.
    pub locals: Vec<Local>,
    /// Morph weights, one per target of the node's mesh.
    pub weights: Vec<Vec<f64>>,
    /// World matrix: also of nodes that the default scene does not show, for they may be joints.
    pub world_from_node: Vec<DMat4>,
}

impl Pose {
    /// The pose as stored, no clip applied.
    pub fn rest(scene: &Scene) -> Self {
        Self::from_locals(
            scene,
            scene.nodes.iter().map(|node| node.local).collect(),
            scene.nodes.iter().map(|node| node.weights.clone()).collect(),
        )
    }

    /// What layers make of the rest pose, in order, in f64 from the scene's own curves: the truth that [`crate::Rig`] is held to.
    /// Times outside a curve's keys hold its first or last key; see [`crate::clip_time`] for loops. Layers of clips that do not
    /// exist have no effect.
    ///
    /// Channels that drive a node given as a matrix have no effect (glTF 2.0, 3.6.1.2).
    pub fn sample(scene: &Scene, playing: &[Layer]) -> Self {
        let rest = Moving::rest(scene);
        let mut below = rest.clone();
        let mut blended = false;
        for layer in playing {
            let Some(clip) = scene.clips.get(layer.clip) else { continue };
            let at = |time: f64| {
                let mut moving = rest.clone();
                moving.apply(clip, time);
                moving
            };
            if layer.hides_all() {
                below = at(layer.time);
                blended = false;
                continue;
            }
            match layer.blend {
                Blend::Over => below.lay_over(layer, &at(layer.time)),
                Blend::Add => {
                    below.normalise();
                    below.add(layer, &at(layer.time), &at(0.0));
                }
            }
            blended = true;
        }
        if blended {
            below.normalise();
        }
        Self::from_locals(scene, below.locals, below.weights)
    }

    /// World matrices from local transforms.
    fn from_locals(scene: &Scene, locals: Vec<Local>, weights: Vec<Vec<f64>>) -> Self {
        let parents: Vec<Option<NodeIndex>> = scene.nodes.iter().map(|node| node.parent).collect();
        let mut world_from_node = vec![DMat4::IDENTITY; locals.len()];
        for (node, parent) in parents_first(&parents) {
            let local = locals[node].matrix();
            world_from_node[node] = parent.map_or(local, |parent| world_from_node[parent] * local);
        }
        Self { locals, weights, world_from_node }
    }
}

/// Every node with its parent, parents before children. A parent that does not exist, and one that would close a loop (which the
/// import refuses), counts as none.
pub(crate) fn parents_first(parents: &[Option<NodeIndex>]) -> Vec<(NodeIndex, Option<NodeIndex>)> {
    let mut order = Vec::with_capacity(parents.len());
    let mut placed = vec![false; parents.len()];
    let mut chain: Vec<NodeIndex> = Vec::new();
    for node in 0..parents.len() {
        let mut next = Some(node);
        while let Some(current) = next.filter(|&current| current < parents.len() && !placed[current]) {
            placed[current] = true;
            chain.push(current);
            next = parents[current];
        }
        // The first of the chain hangs on what was placed before, unless that stands in this very chain.
        let mut parent = next.filter(|&parent| parent < parents.len() && !chain.contains(&parent));
        while let Some(current) = chain.pop() {
            order.push((current, parent));
            parent = Some(current);
        }
    }
    order
}

/// Local transforms and morph weights while layers are laid.
#[derive(Clone)]
struct Moving {
    locals: Vec<Local>,
    weights: Vec<Vec<f64>>,
}

impl Moving {
    fn rest(scene: &Scene) -> Self {
        Self {
            locals: scene.nodes.iter().map(|node| node.local).collect(),
            weights: scene.nodes.iter().map(|node| node.weights.clone()).collect(),
        }
    }

    fn apply(&mut self, clip: &Clip, time: f64) {
        for Channel { node, path, sampler } in &clip.channels {
            let (Some(local), Some(weights)) = (self.locals.get_mut(*node), self.weights.get_mut(*node)) else {
                continue;
            };
            match (path, local) {
                (Path::Weights, _) => {
                    let sampled = sample_weights(sampler, time).unwrap_or_default();
                    weights.iter_mut().zip(sampled).for_each(|(weight, value)| *weight = value);
                }
                (Path::Translation, Local::Trs(own)) => {
                    own.translation = sample_vector(sampler, time).unwrap_or(own.translation);
                }
                (Path::Rotation, Local::Trs(own)) => {
                    own.rotation = sample_rotation(sampler, time).unwrap_or(own.rotation);
                }
                (Path::Scale, Local::Trs(own)) => own.scale = sample_vector(sampler, time).unwrap_or(own.scale),
                (_, Local::Matrix(_)) => {}
            }
        }
        for PropertyChannel { property, sampler } in &clip.properties {
            let Property::Weight(node, target) = *property else { continue };
            let weight = self.weights.get_mut(node).and_then(|weights| weights.get_mut(target));
            if let (Some(weight), Some(&[value])) = (weight, sample_weights(sampler, time).as_deref()) {
                *weight = value;
            }
        }
    }

    fn lay_over(&mut self, layer: &Layer, other: &Self) {
        for (node, (below, above)) in self.locals.iter_mut().zip(&other.locals).enumerate() {
            let weight = layer.weight_of(node);
            if let (Local::Trs(below), Local::Trs(above)) = (below, above) {
                let aligned = if below.rotation.dot(above.rotation) < 0.0 { -above.rotation } else { above.rotation };
                *below = Transform {
                    translation: below.translation * (1.0 - weight) + above.translation * weight,
                    rotation: below.rotation * (1.0 - weight) + aligned * weight,
                    scale: below.scale * (1.0 - weight) + above.scale * weight,
                };
            }
            for (below, above) in self.weights[node].iter_mut().zip(&other.weights[node]) {
                *below = *below * (1.0 - weight) + above * weight;
            }
        }
    }

    fn add(&mut self, layer: &Layer, other: &Self, reference: &Self) {
        for (node, below) in self.locals.iter_mut().enumerate() {
            let weight = layer.weight_of(node);
            if let (Local::Trs(below), Local::Trs(above), Local::Trs(start)) =
                (below, &other.locals[node], &reference.locals[node])
            {
                let change = start.rotation.conjugate() * above.rotation;
                let change = if change.w < 0.0 { -change } else { change };
                let quotient = DVec3::select(start.scale.cmpeq(DVec3::ZERO), DVec3::ONE, above.scale / start.scale);
                *below = Transform {
                    translation: below.translation + (above.translation - start.translation) * weight,
                    rotation: below.rotation * unit_or_identity(DQuat::IDENTITY * (1.0 - weight) + change * weight),
                    scale: below.scale * (DVec3::ONE + (quotient - DVec3::ONE) * weight),
                };
            }
            let values = other.weights[node].iter().zip(&reference.weights[node]);
            for (below, (above, start)) in self.weights[node].iter_mut().zip(values) {
                *below += (above - start) * weight;
            }
        }
    }

    fn normalise(&mut self) {
        for local in &mut self.locals {
            if let Local::Trs(own) = local {
                own.rotation = unit_or_identity(own.rotation);
            }
        }
    }
}

fn unit_or_identity(rotation: DQuat) -> DQuat {
    DQuat::from_vec4(DVec4::from(rotation).normalize_or(DVec4::W))
}

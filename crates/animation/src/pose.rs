//! A scene at a moment: local transforms, morph weights, world matrices.

use glam::DMat4;
use murano_scene::{Channel, Clip, Local, NodeIndex, Path, Scene};

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

    /// A clip (index into `Scene::clips`) laid over the rest pose at a time in seconds. Times outside a curve's keys hold
    /// its first or last key; see [`crate::clip_time`] for loops. `None` or an index that does not exist is the rest pose.
    ///
    /// Channels that drive a node given as a matrix have no effect (glTF 2.0, 3.6.1.2).
    pub fn sample(scene: &Scene, clip: Option<usize>, time: f64) -> Self {
        let Some(clip) = clip.and_then(|clip| scene.clips.get(clip)) else { return Self::rest(scene) };
        let mut locals: Vec<Local> = scene.nodes.iter().map(|node| node.local).collect();
        let mut weights: Vec<Vec<f64>> = scene.nodes.iter().map(|node| node.weights.clone()).collect();
        apply_clip(clip, time, &mut locals, &mut weights);
        Self::from_locals(scene, locals, weights)
    }

    /// World matrices from local transforms.
    fn from_locals(scene: &Scene, locals: Vec<Local>, weights: Vec<Vec<f64>>) -> Self {
        let parents: Vec<Option<NodeIndex>> = scene.nodes.iter().map(|node| node.parent).collect();
        let world_from_node = world_matrices(&parents, &locals);
        Self { locals, weights, world_from_node }
    }
}

fn apply_clip(clip: &Clip, time: f64, locals: &mut [Local], weights: &mut [Vec<f64>]) {
    for Channel { node, path, sampler } in &clip.channels {
        let (Some(local), Some(weights)) = (locals.get_mut(*node), weights.get_mut(*node)) else { continue };
        match (path, local) {
            (Path::Weights, _) => {
                let sampled = sample_weights(sampler, time).unwrap_or_default();
                weights.iter_mut().zip(sampled).for_each(|(weight, value)| *weight = value);
            }
            (Path::Translation, Local::Trs(own)) => {
                own.translation = sample_vector(sampler, time).unwrap_or(own.translation);
            }
            (Path::Rotation, Local::Trs(own)) => own.rotation = sample_rotation(sampler, time).unwrap_or(own.rotation),
            (Path::Scale, Local::Trs(own)) => own.scale = sample_vector(sampler, time).unwrap_or(own.scale),
            (_, Local::Matrix(_)) => {}
        }
    }
}

/// `world_from_node` of every node. Each is found by climbing to the nearest ancestor already known; a climb longer than
/// there are nodes (a loop of parents, which the import refuses) is cut.
fn world_matrices(parents: &[Option<NodeIndex>], locals: &[Local]) -> Vec<DMat4> {
    let mut known: Vec<Option<DMat4>> = vec![None; locals.len()];
    let mut chain = Vec::new();
    for node in 0..locals.len() {
        let mut next = Some(node);
        let mut world = DMat4::IDENTITY;
        while let Some(current) = next.filter(|&current| current < locals.len() && chain.len() < locals.len()) {
            if let Some(matrix) = known[current] {
                world = matrix;
                break;
            }
            chain.push(current);
            next = parents[current];
        }
        while let Some(current) = chain.pop() {
            world *= locals[current].matrix();
            known[current] = Some(world);
        }
    }
    known.into_iter().map(Option::unwrap_or_default).collect()
}

//! A scene's hierarchy and clips made ready to be posed fast, any number of times, by any number of threads.

use glam::{DMat4, DQuat, DVec3, Quat, Vec3A, Vec4};
use murano_scene::{Local, NodeIndex, Scene, Transform};

use crate::layer::{Blend, Layer};
use crate::pose::{Pose, parents_first};
use crate::tracks::{Locals, Tracks};

/// What is constant about posing a scene. Curves are evaluated in f32, but for translations; these and world matrices are
/// in f64. [`Pose::sample`] is the same in f64 throughout.
#[derive(Clone, Debug)]
pub struct Rig {
    rest: Pose,
    rest_locals: Locals,
    /// Where each node's morph weights begin, and the end of the last.
    weight_starts: Vec<u32>,
    /// Nodes whose parent comes before them, with that parent.
    order: Vec<(NodeIndex, Option<NodeIndex>)>,
    clips: Vec<Tracks>,
}

/// Memory that posing needs; kept by the caller, so that a pose allocates nothing after the first.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    below: Locals,
    layer: Locals,
    reference: Locals,
}

impl Rig {
    /// Sorts a scene's nodes and curves.
    pub fn new(scene: &Scene) -> Self {
        let mut weight_starts = vec![0];
        let mut rest_locals = Locals::default();
        for node in &scene.nodes {
            let local = match node.local {
                Local::Trs(own) => own,
                Local::Matrix(_) => Transform::IDENTITY,
            };
            rest_locals.translations.push(local.translation);
            rest_locals.rotations.push(local.rotation.as_quat());
            rest_locals.scales.push(local.scale.as_vec3a());
            rest_locals.weights.extend(node.weights.iter().map(|&weight| weight as f32));
            weight_starts.push(rest_locals.weights.len() as u32);
        }
        let parents: Vec<Option<NodeIndex>> = scene.nodes.iter().map(|node| node.parent).collect();
        let clips = scene.clips.iter().map(|clip| Tracks::new(scene, clip, &weight_starts)).collect();
        Self { rest: Pose::rest(scene), rest_locals, weight_starts, order: parents_first(&parents), clips }
    }

    /// The rest pose.
    pub fn rest(&self) -> &Pose {
        &self.rest
    }

    /// What layers make of the rest pose, in order.
    pub fn pose(&self, playing: &[Layer]) -> Pose {
        let mut pose = self.rest.clone();
        self.pose_into(playing, &mut Workspace::default(), &mut pose);
        pose
    }

    /// As [`Rig::pose`], into a pose of this rig.
    pub fn pose_into(&self, playing: &[Layer], workspace: &mut Workspace, pose: &mut Pose) {
        self.pose_at(playing, &DMat4::IDENTITY, workspace, pose);
    }

    /// As [`Rig::pose_into`], with every root hung on `world_from_root`.
    pub fn pose_at(&self, playing: &[Layer], world_from_root: &DMat4, workspace: &mut Workspace, pose: &mut Pose) {
        self.sample(playing, workspace);
        let below = &workspace.below;
        for (node, local) in pose.locals.iter_mut().enumerate() {
            // What no curve has touched stays as precise as it was.
            let Local::Trs(rest) = self.rest.locals[node] else { continue };
            let same = |now: Vec3A, then: Vec3A, rest: DVec3| if now == then { rest } else { now.as_dvec3() };
            let rotation = below.rotations[node];
            let unmoved = rotation == self.rest_locals.rotations[node];
            *local = Local::Trs(Transform {
                translation: below.translations[node],
                rotation: if unmoved { rest.rotation } else { unit(rotation) },
                scale: same(below.scales[node], self.rest_locals.scales[node], rest.scale),
            });
        }
        for (node, weights) in pose.weights.iter_mut().enumerate() {
            let start = self.weight_starts[node] as usize;
            let pairs = below.weights[start..].iter().zip(&self.rest_locals.weights[start..]);
            for ((weight, (&now, &then)), &rest) in weights.iter_mut().zip(pairs).zip(&self.rest.weights[node]) {
                *weight = if now == then { rest } else { now.into() };
            }
        }
        for &(node, parent) in &self.order {
            let local = pose.locals[node].matrix();
            let world_from_parent = parent.map_or(world_from_root, |parent| &pose.world_from_node[parent]);
            pose.world_from_node[node] = *world_from_parent * local;
        }
    }

    /// Evaluates curves and blends layers, without matrices: what [`Rig::pose_into`] begins with.
    pub fn sample(&self, playing: &[Layer], workspace: &mut Workspace) {
        let Workspace { below, layer, reference } = workspace;
        // Nothing shows from under the last layer that hides all.
        let hidden = playing.iter().rposition(|layer| layer.hides_all() && layer.clip < self.clips.len());
        below.copy_from(&self.rest_locals);
        if let Some(base) = hidden {
            self.clips[playing[base].clip].write(playing[base].time, below);
        }
        let mut blended = false;
        for playing in &playing[hidden.map_or(0, |base| base + 1)..] {
            let Some(tracks) = self.clips.get(playing.clip) else { continue };
            layer.copy_from(&self.rest_locals);
            tracks.write(playing.time, layer);
            match playing.blend {
                Blend::Over => self.lay_over(playing, layer, below),
                Blend::Add => {
                    reference.copy_from(&self.rest_locals);
                    tracks.write(0.0, reference);
                    normalise(below, blended);
                    self.add(playing, layer, reference, below);
                }
            }
            blended = true;
        }
        normalise(below, blended);
    }

    fn lay_over(&self, playing: &Layer, layer: &Locals, below: &mut Locals) {
        if playing.mask.is_none() {
            let (weight, rest) = (playing.weight_of(0) as f32, 1.0 - playing.weight_of(0) as f32);
            let [near, far] = [1.0 - playing.weight_of(0), playing.weight_of(0)];
            let places = below.translations.iter_mut().zip(&layer.translations);
            places.for_each(|(below, &layer)| *below = *below * near + layer * far);
            let scales = below.scales.iter_mut().zip(&layer.scales);
            scales.for_each(|(below, &layer)| *below = *below * rest + layer * weight);
            below.rotations.iter_mut().zip(&layer.rotations).for_each(|(below, &layer)| {
                *below = toward(*below, layer, rest, weight);
            });
            below
                .weights
                .iter_mut()
                .zip(&layer.weights)
                .for_each(|(below, &layer)| *below = *below * rest + layer * weight);
            return;
        }
        for node in 0..below.rotations.len() {
            let share = playing.weight_of(node);
            if share == 0.0 {
                continue;
            }
            let (weight, rest) = (share as f32, (1.0 - share) as f32);
            below.translations[node] = below.translations[node] * (1.0 - share) + layer.translations[node] * share;
            below.scales[node] = below.scales[node] * rest + layer.scales[node] * weight;
            below.rotations[node] = toward(below.rotations[node], layer.rotations[node], rest, weight);
            for index in self.weights_of(node) {
                below.weights[index] = below.weights[index] * rest + layer.weights[index] * weight;
            }
        }
    }

    fn add(&self, playing: &Layer, layer: &Locals, reference: &Locals, below: &mut Locals) {
        for node in 0..below.rotations.len() {
            let share = playing.weight_of(node);
            if share == 0.0 {
                continue;
            }
            let weight = share as f32;
            below.translations[node] += (layer.translations[node] - reference.translations[node]) * share;
            let scale = reference.scales[node];
            let quotient = Vec3A::select(scale.cmpeq(Vec3A::ZERO), Vec3A::ONE, layer.scales[node] / scale);
            below.scales[node] *= Vec3A::ONE + (quotient - Vec3A::ONE) * weight;
            let change = reference.rotations[node].conjugate() * layer.rotations[node];
            let change = if change.w < 0.0 { -change } else { change };
            let part = Quat::IDENTITY * (1.0 - weight) + change * weight;
            below.rotations[node] = (below.rotations[node] * unit(part).as_quat()).normalize();
            for index in self.weights_of(node) {
                below.weights[index] += (layer.weights[index] - reference.weights[index]) * weight;
            }
        }
    }

    fn weights_of(&self, node: usize) -> std::ops::Range<usize> {
        self.weight_starts[node] as usize..self.weight_starts[node + 1] as usize
    }
}

/// A sum of two rotations on the hemisphere of the first; not unit.
fn toward(from: Quat, to: Quat, rest: f32, weight: f32) -> Quat {
    let aligned = if from.dot(to) < 0.0 { -weight } else { weight };
    from * rest + to * aligned
}

fn normalise(locals: &mut Locals, blended: bool) {
    if blended {
        let unit = |rotation: Quat| Quat::from_vec4(Vec4::from(rotation).normalize_or(Vec4::W));
        locals.rotations.iter_mut().for_each(|rotation| *rotation = unit(*rotation));
    }
}

fn unit(rotation: Quat) -> DQuat {
    DQuat::from_vec4(glam::DVec4::from(rotation.as_dquat()).normalize_or(glam::DVec4::W))
}

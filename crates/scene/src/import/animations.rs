//! Clips: channels of node properties, by node or by KHR_animation_pointer.

use std::collections::HashSet;

use serde::Deserialize;

use super::accessors::{Accessors, Integers};
use super::document::{self, Document, extension, get, label};
use super::error::ImportProblem;
use super::pointers::{self, Target, node_path};
use crate::{
    Channel, Clip, Interpolation, Local, Node, NodeIndex, Path, Property, PropertyChannel, Sampler, Transform,
};

/// How far a matrix may be from its translation, rotation and scale, relative to its largest element.
const DECOMPOSITION_TOLERANCE: f64 = 1e-5;

/// KHR_animation_pointer on a channel's target.
#[derive(Deserialize)]
struct Pointer {
    pointer: String,
}

/// Imports every animation. Channels that drive nothing that can be shown are dropped with a warning. A node whose
/// rest transform is a matrix gets its decomposition where it is animated.
pub(super) fn import(
    document: &Document,
    accessors: &Accessors,
    nodes: &mut [Node],
    warnings: &mut Vec<String>,
) -> Result<Vec<Clip>, ImportProblem> {
    let mut by_mesh = vec![Vec::new(); document.meshes.len()];
    for (node, source) in document.nodes.iter().enumerate() {
        if let (Some(mesh), None) = (source.mesh, &source.weights) {
            by_mesh[mesh].push(node);
        }
    }
    let mut clips = Vec::with_capacity(document.animations.len());
    for (index, animation) in document.animations.iter().enumerate() {
        let at = label("animations", index, animation.name.as_deref());
        clips.push(import_clip(document, accessors, animation, &at, (nodes, &by_mesh), warnings)?);
    }
    Ok(clips)
}

fn import_clip(
    document: &Document,
    accessors: &Accessors,
    animation: &document::Animation,
    clip_label: &str,
    (nodes, by_mesh): (&mut [Node], &[Vec<NodeIndex>]),
    warnings: &mut Vec<String>,
) -> Result<Clip, ImportProblem> {
    let mut clip = Clip { name: animation.name.clone().unwrap_or_default(), ..Clip::default() };
    let mut driven = HashSet::new();
    for (index, channel) in animation.channels.iter().enumerate() {
        let at = format!("{clip_label}.channels[{index}]");
        let sampler = get(&animation.samplers, channel.sampler, "samplers", &at)?;
        let driven = &mut driven;
        // By pointer, integers are what they say; by path, they are fractions in any case.
        let by_pointer = channel.target.extensions.contains_key("KHR_animation_pointer");
        let integers = if by_pointer { Integers::AsFlagged } else { Integers::Fractions };
        let mut reader =
            ChannelReader { document, accessors, nodes, warnings, source: sampler, at: &at, driven, integers, by_mesh };
        let imported = match target(document, &channel.target, &at)? {
            Ok(target) => reader.read(target, &mut clip)?,
            Err(reason) => Err(reason),
        };
        if let Err(reason) = imported {
            warnings.push(format!("{at} dropped: {reason}"));
        }
    }
    let samplers = clip.channels.iter().map(|channel| &channel.sampler);
    let samplers = samplers.chain(clip.properties.iter().map(|channel| &channel.sampler));
    let last_keys = samplers.filter_map(|sampler| sampler.times.last());
    clip.duration = last_keys.fold(0.0, |duration: f64, &time| duration.max(f64::from(time)));
    Ok(clip)
}

/// What a channel drives, or why it drives nothing.
fn target(
    document: &Document,
    target: &document::ChannelTarget,
    at: &str,
) -> Result<Result<Target, String>, ImportProblem> {
    if let Some(Pointer { pointer }) = extension(&target.extensions, "KHR_animation_pointer", at)? {
        return pointers::target(document, &pointer, at);
    }
    let Some(node) = target.node else { return Ok(Err("it has no target node".to_owned())) };
    get(&document.nodes, node, "nodes", at)?;
    Ok(match node_path(&target.path) {
        Some(path) => Ok(Target::Node(node, path)),
        None => Err(format!("unknown target path \"{}\"", target.path)),
    })
}

struct ChannelReader<'a, 'd> {
    document: &'d Document,
    accessors: &'a Accessors<'d>,
    nodes: &'a mut [Node],
    warnings: &'a mut Vec<String>,
    source: &'a document::AnimationSampler,
    at: &'a str,
    /// What channels of the clip drive already.
    driven: &'a mut HashSet<Target>,
    integers: Integers,
    /// Nodes that show each mesh with the mesh's own morph weights.
    by_mesh: &'a [Vec<NodeIndex>],
}

/// Why a channel of what is driven already has no effect.
const DRIVEN: &str = "an earlier channel drives the same property";

impl ChannelReader<'_, '_> {
    /// Adds the channels of a target to a clip, or says why there are none.
    fn read(&mut self, target: Target, clip: &mut Clip) -> Result<Result<(), String>, ImportProblem> {
        let (of_mesh, known) = match target {
            Target::MeshWeights(mesh) | Target::MeshWeight(mesh, _) => {
                let first = self.by_mesh[mesh].first();
                (true, first.map_or(0, |&node| self.nodes[node].weights.len()))
            }
            _ => (false, 0),
        };
        // Before every node is asked.
        if of_mesh && !self.driven.insert(target) {
            return Ok(Err(DRIVEN.to_owned()));
        }
        match target {
            Target::MeshWeight(mesh, target) if target >= known => {
                Ok(Err(format!("no node shows morph target {target} of meshes[{mesh}] with the mesh's own weights")))
            }
            Target::Node(node, path) => self.node(node, path, clip),
            Target::Property(property) => self.property(property, clip),
            Target::MeshWeights(mesh) => self.each_node_of(mesh, |reader, node| reader.node(node, Path::Weights, clip)),
            Target::MeshWeight(mesh, target) => {
                self.each_node_of(mesh, |reader, node| reader.property(Property::Weight(node, target), clip))
            }
        }
    }

    /// Every node that shows a mesh with the mesh's own morph weights.
    fn each_node_of(
        &mut self,
        mesh: usize,
        mut read: impl FnMut(&mut Self, NodeIndex) -> Result<Result<(), String>, ImportProblem>,
    ) -> Result<Result<(), String>, ImportProblem> {
        let mut drives = Err(format!("no node shows meshes[{mesh}] with the mesh's own weights"));
        for &node in &self.by_mesh[mesh] {
            let own = read(self, node)?;
            drives = if drives.is_ok() { drives } else { own };
        }
        Ok(drives)
    }

    fn node(&mut self, node: NodeIndex, path: Path, clip: &mut Clip) -> Result<Result<(), String>, ImportProblem> {
        let width = match path {
            Path::Translation | Path::Scale => 3,
            Path::Rotation => 4,
            Path::Weights if self.nodes[node].weights.is_empty() => return self.weights_of_instances(node, clip),
            Path::Weights => self.nodes[node].weights.len(),
        };
        if self.driven.contains(&Target::Node(node, path)) {
            return Ok(Err(DRIVEN.to_owned()));
        }
        if path != Path::Weights
            && let Err(reason) = decompose(&mut self.nodes[node])
        {
            return Ok(Err(reason.to_owned()));
        }
        let element = if path == Path::Weights { 1 } else { width };
        let sampler = self.sampler(width, element)?;
        Ok(sampler.map(|sampler| {
            self.driven.insert(Target::Node(node, path));
            clip.channels.push(Channel { node, path, sampler });
        }))
    }

    /// Morph weights of a node whose mesh is instanced: of every instance.
    fn weights_of_instances(&mut self, node: NodeIndex, clip: &mut Clip) -> Result<Result<(), String>, ImportProblem> {
        let mut drives = Err(format!("nodes[{node}] has no morph targets"));
        let own = self.document.nodes.len();
        let morphed = |&child: &NodeIndex| child >= own && !self.nodes[child].weights.is_empty();
        let instances: Vec<NodeIndex> = self.nodes[node].children.iter().copied().filter(morphed).collect();
        for instance in instances {
            drives = self.node(instance, Path::Weights, clip)?;
        }
        Ok(drives)
    }

    fn property(&mut self, property: Property, clip: &mut Clip) -> Result<Result<(), String>, ImportProblem> {
        if let Property::Weight(node, target) = property
            && target >= self.nodes[node].weights.len()
        {
            return Ok(Err(format!("nodes[{node}] has no morph target {target}")));
        }
        if self.driven.contains(&Target::Property(property)) {
            return Ok(Err(DRIVEN.to_owned()));
        }
        let width = property.width();
        let sampler = self.sampler(width, width)?;
        Ok(sampler.map(|sampler| {
            self.driven.insert(Target::Property(property));
            clip.properties.push(PropertyChannel { property, sampler });
        }))
    }

    /// The curve: `width` numbers a value, `element` of them an element of the accessor.
    fn sampler(&mut self, width: usize, element: usize) -> Result<Result<Sampler, String>, ImportProblem> {
        let (accessors, at) = (self.accessors, self.at);
        let (input, output) = (format!("{at} input"), format!("{at} output"));
        if accessors.count(self.source.input, &input)? == 0 {
            return Ok(Err("it has no keys".to_owned()));
        }
        let times: Vec<f32> =
            accessors.floats::<1>(self.source.input, Integers::AsFlagged, &input)?.into_iter().flatten().collect();
        let values = values(accessors, self.source.output, element, self.integers, &output)?;
        let interpolation = interpolation(self.source, at)?;
        let per_key = if interpolation == Interpolation::CubicSpline { 3 * width } else { width };
        if values.len() != times.len() * per_key {
            return Err(ImportProblem::Accessor {
                at: format!("accessors[{}] ({output})", self.source.output),
                problem: format!("it has {} numbers where {} keys need {per_key} each", values.len(), times.len()),
            });
        }
        let mut sampler = Sampler { interpolation, times, width, values };
        let dropped = drop_unordered_keys(&mut sampler, per_key);
        if dropped > 0 {
            self.warnings.push(format!("{at}: {dropped} keys not later than the one before them dropped"));
        }
        Ok(Ok(sampler))
    }
}

fn interpolation(source: &document::AnimationSampler, at: &str) -> Result<Interpolation, ImportProblem> {
    match source.interpolation.as_deref() {
        None | Some("LINEAR") => Ok(Interpolation::Linear),
        Some("STEP") => Ok(Interpolation::Step),
        Some("CUBICSPLINE") => Ok(Interpolation::CubicSpline),
        Some(name) => {
            Err(ImportProblem::Schema { at: at.to_owned(), problem: format!("unknown interpolation \"{name}\"") })
        }
    }
}

fn values(
    accessors: &Accessors,
    accessor: usize,
    element: usize,
    kind: Integers,
    user: &str,
) -> Result<Vec<f32>, ImportProblem> {
    Ok(match element {
        4 => flat(accessors.floats::<4>(accessor, kind, user)?),
        3 => flat(accessors.floats::<3>(accessor, kind, user)?),
        2 => flat(accessors.floats::<2>(accessor, kind, user)?),
        _ => flat(accessors.floats::<1>(accessor, kind, user)?),
    })
}

fn flat<const N: usize>(values: Vec<[f32; N]>) -> Vec<f32> {
    values.into_iter().flatten().collect()
}

/// Keeps the keys that are later than all before them; returns how many were not.
fn drop_unordered_keys(sampler: &mut Sampler, per_key: usize) -> usize {
    let mut latest = f32::NEG_INFINITY;
    let keep: Vec<bool> = sampler
        .times
        .iter()
        .map(|&time| {
            let later = time > latest;
            latest = latest.max(time);
            later
        })
        .collect();
    let dropped = keep.iter().filter(|keep| !**keep).count();
    if dropped > 0 {
        sampler.values = sampler
            .values
            .chunks(per_key)
            .zip(&keep)
            .filter(|(_, keep)| **keep)
            .flat_map(|(key, _)| key)
            .copied()
            .collect();
        let mut keep = keep.iter();
        sampler.times.retain(|_| keep.next().copied().unwrap_or(false));
    }
    dropped
}

/// Turns a node's matrix into translation, rotation and scale, which the channels replace one by one.
fn decompose(node: &mut Node) -> Result<(), &'static str> {
    let Local::Matrix(matrix) = node.local else { return Ok(()) };
    let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
    let transform = Transform { translation, rotation, scale };
    let largest = matrix.to_cols_array().into_iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    if !transform.matrix().abs_diff_eq(matrix, DECOMPOSITION_TOLERANCE * largest) {
        return Err("its node has a matrix that is no translation, rotation and scale");
    }
    node.local = Local::Trs(transform);
    Ok(())
}

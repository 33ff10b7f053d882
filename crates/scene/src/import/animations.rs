//! Clips: channels of node properties, by node or by KHR_animation_pointer.

use std::collections::HashSet;

use serde::Deserialize;

use super::accessors::{Accessors, Integers};
use super::document::{self, Document, extension, get, label};
use super::error::ImportProblem;
use crate::{Channel, Clip, Interpolation, Local, Node, NodeIndex, Path, Sampler, Transform};

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
    let mut clips = Vec::with_capacity(document.animations.len());
    for (index, animation) in document.animations.iter().enumerate() {
        let at = label("animations", index, animation.name.as_deref());
        clips.push(import_clip(document, accessors, animation, &at, nodes, warnings)?);
    }
    Ok(clips)
}

fn import_clip(
    document: &Document,
    accessors: &Accessors,
    animation: &document::Animation,
    clip_label: &str,
    nodes: &mut [Node],
    warnings: &mut Vec<String>,
) -> Result<Clip, ImportProblem> {
    let mut channels: Vec<Channel> = Vec::with_capacity(animation.channels.len());
    let mut driven = HashSet::new();
    for (index, channel) in animation.channels.iter().enumerate() {
        let at = format!("{clip_label}.channels[{index}]");
        let sampler = get(&animation.samplers, channel.sampler, "samplers", &at)?;
        let imported = match target(document, &channel.target, &at)? {
            Ok((node, path)) if driven.contains(&(node, path)) => {
                Err(format!("an earlier channel drives the same property of {}", document.node_label(node)))
            }
            Ok((node, path)) => import_channel(accessors, sampler, node, path, nodes, &at, warnings)?,
            Err(reason) => Err(reason),
        };
        match imported {
            Ok(channel) => {
                driven.insert((channel.node, channel.path));
                channels.push(channel);
            }
            Err(reason) => warnings.push(format!("{at} dropped: {reason}")),
        }
    }
    let last_keys = channels.iter().filter_map(|channel| channel.sampler.times.last());
    let duration = last_keys.fold(0.0, |duration: f64, &time| duration.max(f64::from(time)));
    Ok(Clip { name: animation.name.clone().unwrap_or_default(), channels, duration })
}

/// The node and property a channel drives, or why it drives none.
fn target(
    document: &Document,
    target: &document::ChannelTarget,
    at: &str,
) -> Result<Result<(NodeIndex, Path), String>, ImportProblem> {
    if let Some(Pointer { pointer }) = extension(&target.extensions, "KHR_animation_pointer", at)? {
        let Some((node, property)) = node_pointer(&pointer) else {
            return Ok(Err(format!("the pointer {pointer} is not to a node's transform or weights")));
        };
        get(&document.nodes, node, "nodes", &format!("{at} pointer"))?;
        return Ok(Ok((node, property)));
    }
    let Some(node) = target.node else { return Ok(Err("it has no target node".to_owned())) };
    get(&document.nodes, node, "nodes", at)?;
    Ok(match property(&target.path) {
        Some(path) => Ok((node, path)),
        None => Err(format!("unknown target path \"{}\"", target.path)),
    })
}

/// `/nodes/3/rotation`.
fn node_pointer(pointer: &str) -> Option<(NodeIndex, Path)> {
    let (node, name) = pointer.strip_prefix("/nodes/")?.split_once('/')?;
    Some((node.parse().ok()?, property(name)?))
}

fn property(name: &str) -> Option<Path> {
    match name {
        "translation" => Some(Path::Translation),
        "rotation" => Some(Path::Rotation),
        "scale" => Some(Path::Scale),
        "weights" => Some(Path::Weights),
        _ => None,
    }
}

fn import_channel(
    accessors: &Accessors,
    source: &document::AnimationSampler,
    node: NodeIndex,
    path: Path,
    nodes: &mut [Node],
    at: &str,
    warnings: &mut Vec<String>,
) -> Result<Result<Channel, String>, ImportProblem> {
    let width = match path {
        Path::Translation | Path::Scale => 3,
        Path::Rotation => 4,
        Path::Weights if nodes[node].weights.is_empty() => {
            return Ok(Err(format!("nodes[{node}] has no morph targets")));
        }
        Path::Weights => nodes[node].weights.len(),
    };
    let (input, output) = (format!("{at} input"), format!("{at} output"));
    if accessors.count(source.input, &input)? == 0 {
        return Ok(Err("it has no keys".to_owned()));
    }
    if path != Path::Weights
        && let Err(reason) = decompose(&mut nodes[node])
    {
        return Ok(Err(reason.to_owned()));
    }
    let times: Vec<f32> =
        accessors.floats::<1>(source.input, Integers::AsFlagged, &input)?.into_iter().flatten().collect();
    let values = values(accessors, source.output, path, &output)?;
    let interpolation = interpolation(source, at)?;
    let per_key = if interpolation == Interpolation::CubicSpline { 3 * width } else { width };
    if values.len() != times.len() * per_key {
        return Err(ImportProblem::Accessor {
            at: format!("accessors[{}] ({output})", source.output),
            problem: format!("it has {} numbers where {} keys need {per_key} each", values.len(), times.len()),
        });
    }
    let mut sampler = Sampler { interpolation, times, width, values };
    let dropped = drop_unordered_keys(&mut sampler, per_key);
    if dropped > 0 {
        warnings.push(format!("{at}: {dropped} keys not later than the one before them dropped"));
    }
    Ok(Ok(Channel { node, path, sampler }))
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

fn values(accessors: &Accessors, accessor: usize, path: Path, user: &str) -> Result<Vec<f32>, ImportProblem> {
    Ok(match path {
        Path::Translation | Path::Scale => flat(accessors.floats::<3>(accessor, Integers::Fractions, user)?),
        Path::Rotation => flat(accessors.floats::<4>(accessor, Integers::Fractions, user)?),
        Path::Weights => flat(accessors.floats::<1>(accessor, Integers::Fractions, user)?),
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

//! The hierarchy, its roots and its skins.

use glam::{DMat4, DQuat, DVec3, DVec4};

use super::accessors::{Accessors, Integers};
use super::document::{self, Document, NodeLight, extension, get, label};
use super::error::ImportProblem;
use crate::{Local, Mesh, Node, NodeIndex, Skin, Transform};

/// How far a matrix's last row may be from 0 0 0 1, for exporters that write rounded numbers.
const AFFINE_TOLERANCE: f64 = 1e-4;

/// Imports every node and checks that they form a forest.
pub(super) fn import(
    document: &Document,
    accessors: &Accessors,
    meshes: &[Mesh],
    skins: &[Skin],
    warnings: &mut Vec<String>,
) -> Result<Vec<Node>, ImportProblem> {
    let parents = parents(document)?;
    let joints_used: Vec<Option<u16>> = meshes.iter().map(highest_joint).collect();
    let mut nodes = Vec::with_capacity(document.nodes.len());
    for (index, (source, parent)) in document.nodes.iter().zip(parents).enumerate() {
        let at = document.node_label(index);
        check_references(document, source, &at)?;
        check_joints(source, &joints_used, skins, &at)?;
        nodes.push(Node {
            name: source.name.clone().unwrap_or_default(),
            parent,
            children: source.children.clone(),
            local: local(source, &at, warnings)?,
            mesh: source.mesh,
            skin: source.skin,
            camera: source.camera,
            light: light(document, source, &at)?,
            weights: weights(document, accessors, source, meshes, &at, warnings)?,
        });
    }
    Ok(nodes)
}

/// Each node's parent. A node with two parents and a cycle are errors, found without recursion.
fn parents(document: &Document) -> Result<Vec<Option<NodeIndex>>, ImportProblem> {
    let mut parents: Vec<Option<NodeIndex>> = vec![None; document.nodes.len()];
    for (index, node) in document.nodes.iter().enumerate() {
        for &child in &node.children {
            get(&document.nodes, child, "nodes", &format!("{}.children", document.node_label(index)))?;
            if let Some(first) = parents[child].replace(index) {
                return Err(ImportProblem::SharedParent {
                    at: document.node_label(child),
                    first: document.node_label(first),
                    second: document.node_label(index),
                });
            }
        }
    }
    refuse_cycles(document, &parents)?;
    Ok(parents)
}

/// With one parent each, a node that cannot be reached from a parentless one is on a cycle or below one.
fn refuse_cycles(document: &Document, parents: &[Option<NodeIndex>]) -> Result<(), ImportProblem> {
    let mut reached = vec![false; parents.len()];
    let mut stack: Vec<NodeIndex> = (0..parents.len()).filter(|&node| parents[node].is_none()).collect();
    while let Some(node) = stack.pop() {
        reached[node] = true;
        stack.extend(&document.nodes[node].children);
    }
    let Some(mut node) = reached.iter().position(|reached| !reached) else { return Ok(()) };
    // Climbing as often as there are nodes ends on the cycle itself.
    for _ in parents {
        node = parents[node].unwrap_or(node);
    }
    Err(ImportProblem::Cycle { at: document.node_label(node) })
}

fn check_references(document: &Document, node: &document::Node, at: &str) -> Result<(), ImportProblem> {
    if let Some(mesh) = node.mesh {
        get(&document.meshes, mesh, "meshes", at)?;
    }
    if let Some(skin) = node.skin {
        get(&document.skins, skin, "skins", at)?;
    }
    if let Some(camera) = node.camera {
        get(&document.cameras, camera, "cameras", at)?;
    }
    Ok(())
}

fn highest_joint(mesh: &Mesh) -> Option<u16> {
    mesh.primitives.iter().flat_map(|primitive| &primitive.joints).flatten().flatten().copied().max()
}

fn check_joints(
    node: &document::Node,
    joints_used: &[Option<u16>],
    skins: &[Skin],
    at: &str,
) -> Result<(), ImportProblem> {
    let (Some(mesh), Some(skin)) = (node.mesh, node.skin) else { return Ok(()) };
    match joints_used[mesh] {
        Some(joint) if usize::from(joint) >= skins[skin].joints.len() => Err(ImportProblem::BadIndex {
            at: format!("{at}: JOINTS_n of meshes[{mesh}]"),
            list: format!("skins[{skin}].joints"),
            index: u64::from(joint),
            count: skins[skin].joints.len(),
        }),
        _ => Ok(()),
    }
}

fn local(node: &document::Node, at: &str, warnings: &mut Vec<String>) -> Result<Local, ImportProblem> {
    let Some(columns) = node.matrix else { return transform(node, at).map(Local::Trs) };
    if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() {
        warnings.push(format!("{at} has both a matrix and translation, rotation or scale; the matrix counts"));
    }
    Ok(Local::Matrix(affine(columns, &format!("the matrix of {at}"), warnings)))
}

/// The matrix with its last row exactly 0 0 0 1, and a warning where it was not even nearly that.
fn affine(columns: [f64; 16], what: &str, warnings: &mut Vec<String>) -> DMat4 {
    let mut matrix = DMat4::from_cols_array(&columns);
    if !(matrix.row(3) - DVec4::W).abs().cmple(DVec4::splat(AFFINE_TOLERANCE)).all() {
        warnings.push(format!("the last row of {what} is not 0 0 0 1; taken as such"));
    }
    for axis in [&mut matrix.x_axis, &mut matrix.y_axis, &mut matrix.z_axis] {
        axis.w = 0.0;
    }
    matrix.w_axis.w = 1.0;
    matrix
}

fn transform(node: &document::Node, at: &str) -> Result<Transform, ImportProblem> {
    Ok(Transform {
        translation: node.translation.map_or(DVec3::ZERO, DVec3::from_array),
        rotation: unit_rotation(node.rotation.map_or(DQuat::IDENTITY, DQuat::from_array), at)?,
        scale: node.scale.map_or(DVec3::ONE, DVec3::from_array),
    })
}

/// The rotation that a quaternion of nearly any length stands for.
pub(super) fn unit_rotation(rotation: DQuat, at: &str) -> Result<DQuat, ImportProblem> {
    let length = rotation.length();
    if length > 1e-6 && length.is_finite() {
        return Ok(rotation / length);
    }
    let problem = format!("its rotation is a quaternion of length {length}, not 1");
    Err(ImportProblem::Value { at: at.to_owned(), problem })
}

fn light(document: &Document, node: &document::Node, at: &str) -> Result<Option<usize>, ImportProblem> {
    let Some(NodeLight { light }) = extension(&node.extensions, "KHR_lights_punctual", at)? else { return Ok(None) };
    get(&document.lights, light, "extensions.KHR_lights_punctual.lights", at)?;
    Ok(Some(light))
}

/// Weights at rest, one per morph target.
fn weights(
    document: &Document,
    accessors: &Accessors,
    node: &document::Node,
    meshes: &[Mesh],
    at: &str,
    warnings: &mut Vec<String>,
) -> Result<Vec<f64>, ImportProblem> {
    let Some(mesh) = node.mesh else { return Ok(Vec::new()) };
    let targets = target_count(&meshes[mesh]);
    let stored = node.weights.as_ref().or(document.meshes[mesh].weights.as_ref());
    let length = stored.map_or(0, Vec::len).max(targets);
    accessors.reserve((length * size_of::<f64>()) as u64, || at.to_owned())?;
    let mut weights = stored.cloned().unwrap_or_default();
    if stored.is_some() && weights.len() != targets {
        warnings.push(format!("{at}: {} morph weights for {targets} targets", weights.len()));
    }
    weights.resize(targets, 0.0);
    Ok(weights)
}

/// Morph targets of a mesh; its primitives have equally many.
pub(super) fn target_count(mesh: &Mesh) -> usize {
    mesh.primitives.first().map_or(0, |primitive| primitive.targets.len())
}

/// Roots of the default scene; without scenes, every node without a parent.
pub(super) fn roots(
    document: &Document,
    nodes: &[Node],
    warnings: &mut Vec<String>,
) -> Result<Vec<NodeIndex>, ImportProblem> {
    if document.scenes.is_empty() && document.scene.is_none() {
        return Ok((0..nodes.len()).filter(|&node| nodes[node].parent.is_none()).collect());
    }
    let index = document.scene.unwrap_or(0);
    let scene = get(&document.scenes, index, "scenes", "scene")?;
    let at = format!("scenes[{index}].nodes");
    let mut listed = vec![false; nodes.len()];
    let mut roots = Vec::with_capacity(scene.nodes.len());
    for &root in &scene.nodes {
        if let Some(parent) = get(nodes, root, "nodes", &at)?.parent {
            return Err(ImportProblem::SharedParent {
                at: document.node_label(root),
                first: document.node_label(parent),
                second: at,
            });
        }
        if listed[root] {
            warnings.push(format!("{at} lists {} twice", document.node_label(root)));
            continue;
        }
        listed[root] = true;
        roots.push(root);
    }
    Ok(roots)
}

/// Imports every skin.
pub(super) fn import_skins(
    document: &Document,
    accessors: &Accessors,
    warnings: &mut Vec<String>,
) -> Result<Vec<Skin>, ImportProblem> {
    let mut skins = Vec::with_capacity(document.skins.len());
    for (index, skin) in document.skins.iter().enumerate() {
        let at = label("skins", index, skin.name.as_deref());
        for &joint in &skin.joints {
            get(&document.nodes, joint, "nodes", &format!("{at}.joints"))?;
        }
        skins.push(Skin {
            name: skin.name.clone().unwrap_or_default(),
            joints: skin.joints.clone(),
            inverse_bind: inverse_bind(skin, accessors, &at, warnings)?,
        });
    }
    Ok(skins)
}

fn inverse_bind(
    skin: &document::Skin,
    accessors: &Accessors,
    at: &str,
    warnings: &mut Vec<String>,
) -> Result<Vec<DMat4>, ImportProblem> {
    let joints = skin.joints.len();
    let Some(accessor) = skin.inverse_bind_matrices else { return Ok(vec![DMat4::IDENTITY; joints]) };
    let user = format!("{at}.inverseBindMatrices");
    let matrices = accessors.floats::<16>(accessor, Integers::AsFlagged, &user)?;
    if matrices.len() < joints {
        return Err(ImportProblem::Accessor {
            at: format!("accessors[{accessor}] ({user})"),
            problem: format!("it has {} matrices for {joints} joints", matrices.len()),
        });
    }
    let named = matrices.iter().take(joints).enumerate();
    Ok(named.map(|(joint, columns)| affine(columns.map(f64::from), &format!("{user}[{joint}]"), warnings)).collect())
}

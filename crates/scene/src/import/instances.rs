//! EXT_mesh_gpu_instancing: each copy of a node's mesh becomes a node of its own.

use glam::{DQuat, DVec3};
use serde::Deserialize;

use super::accessors::{Accessors, Integers};
use super::document::{Attributes, Document, extension};
use super::error::ImportProblem;
use super::nodes::unit_rotation;
use crate::{Local, Node, NodeIndex, Transform};

#[derive(Deserialize)]
struct Instancing {
    #[serde(default)]
    attributes: Attributes,
}

/// Gives every instance of a node's mesh a child node `NAME[i]`, after all other nodes, and takes the mesh from the
/// node itself, which keeps its place. Morph weights of instances stay at rest. Where instancing means nothing it is
/// ignored with a warning.
pub(super) fn expand(
    document: &Document,
    accessors: &Accessors,
    nodes: &mut Vec<Node>,
    warnings: &mut Vec<String>,
) -> Result<(), ImportProblem> {
    for (index, source) in document.nodes.iter().enumerate() {
        let at = document.node_label(index);
        let instancing = extension(&source.extensions, "EXT_mesh_gpu_instancing", &at)?;
        let Some(Instancing { attributes }) = instancing else { continue };
        let reason = match (source.mesh, source.skin) {
            (None, _) => "it has no mesh",
            // A skin places its mesh by the joints alone (glTF 2.0, section 3.7.3.3), so all copies would coincide.
            (_, Some(_)) => "its mesh is skinned",
            _ if attributes.is_empty() => "it has no instance attributes",
            _ => {
                expand_node(nodes, index, &Instances::read(accessors, &attributes, &at, warnings)?, accessors, &at)?;
                continue;
            }
        };
        warnings.push(format!("{at}: EXT_mesh_gpu_instancing ignored: {reason}"));
    }
    Ok(())
}

/// Where a node's instances are, in its space; each list present has one entry an instance.
struct Instances {
    count: u64,
    translations: Option<Vec<[f32; 3]>>,
    rotations: Option<Vec<[f32; 4]>>,
    scales: Option<Vec<[f32; 3]>>,
}

impl Instances {
    /// Reads the attributes, which all have one count. Those of an application (`_ID`) mean nothing here.
    fn read(
        accessors: &Accessors,
        attributes: &Attributes,
        at: &str,
        warnings: &mut Vec<String>,
    ) -> Result<Self, ImportProblem> {
        let user = |name: &str| format!("{at} {name}");
        let mut counts = Vec::with_capacity(attributes.len());
        for (name, &accessor) in attributes {
            counts.push((accessors.count(accessor, &user(name))?, name));
            if !name.starts_with('_') && !["TRANSLATION", "ROTATION", "SCALE"].contains(&name.as_str()) {
                warnings.push(format!("{at}: unknown instance attribute {name} ignored"));
            }
        }
        let (count, first) = counts[0];
        if let Some((other, name)) = counts.iter().find(|(other, _)| *other != count) {
            return Err(ImportProblem::Accessor {
                at: format!("accessors[{}] ({})", attributes[*name], user(name)),
                problem: format!("it has {other} elements, {first} has {count}"),
            });
        }
        let vectors = |name: &str| {
            let accessor = attributes.get(name);
            accessor.map(|&accessor| accessors.floats(accessor, Integers::AsFlagged, &user(name))).transpose()
        };
        let rotations = attributes
            .get("ROTATION")
            .map(|&accessor| accessors.floats(accessor, Integers::Fractions, &user("ROTATION")));
        Ok(Self {
            count,
            translations: vectors("TRANSLATION")?,
            rotations: rotations.transpose()?,
            scales: vectors("SCALE")?,
        })
    }

    fn transform(&self, instance: usize, at: &str) -> Result<Transform, ImportProblem> {
        let vector = |list: &Option<Vec<[f32; 3]>>, otherwise| {
            list.as_ref().map_or(otherwise, |list| DVec3::from_array(list[instance].map(f64::from)))
        };
        let rotation = self
            .rotations
            .as_ref()
            .map_or(DQuat::IDENTITY, |rotations| DQuat::from_array(rotations[instance].map(f64::from)));
        Ok(Transform {
            translation: vector(&self.translations, DVec3::ZERO),
            rotation: unit_rotation(rotation, at)?,
            scale: vector(&self.scales, DVec3::ONE),
        })
    }
}

fn expand_node(
    nodes: &mut Vec<Node>,
    parent: NodeIndex,
    instances: &Instances,
    accessors: &Accessors,
    at: &str,
) -> Result<(), ImportProblem> {
    let Node { name, mesh, weights, .. } = &mut nodes[parent];
    let (name, mesh, weights) = (name.clone(), mesh.take(), std::mem::take(weights));
    let size = size_of::<Node>() + size_of::<NodeIndex>() + name.len() + 24 + size_of_val(weights.as_slice());
    accessors.reserve(instances.count.saturating_mul(size as u64), || at.to_owned())?;
    nodes.reserve(instances.count as usize);
    for instance in 0..instances.count as usize {
        let at = format!("{at} instance {instance}");
        let child = nodes.len();
        nodes[parent].children.push(child);
        nodes.push(Node {
            name: format!("{name}[{instance}]"),
            parent: Some(parent),
            local: Local::Trs(instances.transform(instance, &at)?),
            mesh,
            weights: weights.clone(),
            ..Node::default()
        });
    }
    Ok(())
}

//! KHR_animation_pointer: JSON pointers to what a channel drives.

use super::document::{Document, get};
use super::error::ImportProblem;
use crate::{CameraProperty, LightProperty, MaterialProperty, NodeIndex, Path, Property, TextureSlot};

/// What a channel drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Target {
    /// A node's transform or all of its morph weights.
    Node(NodeIndex, Path),
    /// The morph weights of a mesh, for every node that has none of its own.
    MeshWeights(usize),
    /// One morph weight of a mesh, likewise.
    MeshWeight(usize, usize),
    /// Anything else.
    Property(Property),
}

/// What a pointer means, or why it drives nothing. An index that does not exist is an error.
pub(super) fn target(document: &Document, pointer: &str, at: &str) -> Result<Result<Target, String>, ImportProblem> {
    let at = format!("{at} pointer {pointer}");
    let nothing = || Ok(Err(format!("the pointer {pointer} is to nothing that can be driven here")));
    let Some(path) = pointer.strip_prefix('/') else { return nothing() };
    let parts: Vec<&str> = path.split('/').collect();
    let index = |text: &str| text.parse::<usize>().ok();
    let found = match parts.as_slice() {
        ["nodes", node, rest @ ..] => {
            let Some(node) = index(node) else { return nothing() };
            get(&document.nodes, node, "nodes", &at)?;
            node_target(node, rest)
        }
        ["meshes", mesh, "weights", rest @ ..] => {
            let Some(mesh) = index(mesh) else { return nothing() };
            get(&document.meshes, mesh, "meshes", &at)?;
            match rest {
                [] => Some(Target::MeshWeights(mesh)),
                [target] => index(target).map(|target| Target::MeshWeight(mesh, target)),
                _ => None,
            }
        }
        ["materials", material, rest @ ..] => {
            let Some(material) = index(material) else { return nothing() };
            get(&document.materials, material, "materials", &at)?;
            material_property(rest).map(|property| Target::Property(Property::Material(material, property)))
        }
        ["extensions", "KHR_lights_punctual", "lights", light, rest @ ..] => {
            let Some(light) = index(light) else { return nothing() };
            get(&document.lights, light, "extensions.KHR_lights_punctual.lights", &at)?;
            light_property(rest).map(|property| Target::Property(Property::Light(light, property)))
        }
        ["cameras", camera, rest @ ..] => {
            let Some(camera) = index(camera) else { return nothing() };
            get(&document.cameras, camera, "cameras", &at)?;
            camera_property(rest).map(|property| Target::Property(Property::Camera(camera, property)))
        }
        _ => None,
    };
    found.map_or_else(nothing, |target| Ok(Ok(target)))
}

/// The node property of that name.
pub(super) fn node_path(name: &str) -> Option<Path> {
    match name {
        "translation" => Some(Path::Translation),
        "rotation" => Some(Path::Rotation),
        "scale" => Some(Path::Scale),
        "weights" => Some(Path::Weights),
        _ => None,
    }
}

fn node_target(node: NodeIndex, rest: &[&str]) -> Option<Target> {
    match rest {
        [name] => node_path(name).map(|path| Target::Node(node, path)),
        ["weights", target] => Some(Target::Property(Property::Weight(node, target.parse().ok()?))),
        _ => None,
    }
}

fn material_property(rest: &[&str]) -> Option<MaterialProperty> {
    use MaterialProperty as M;
    Some(match rest {
        ["alphaCutoff"] => M::AlphaCutoff,
        ["emissiveFactor"] => M::Emissive,
        ["normalTexture", "scale"] => M::NormalScale,
        ["pbrMetallicRoughness", "baseColorFactor"] => M::BaseColor,
        ["pbrMetallicRoughness", "metallicFactor"] => M::Metallic,
        ["pbrMetallicRoughness", "roughnessFactor"] => M::Roughness,
        ["extensions", "KHR_materials_emissive_strength", "emissiveStrength"] => M::EmissiveStrength,
        ["extensions", "KHR_materials_transmission", "transmissionFactor"] => M::Transmission,
        ["extensions", "KHR_materials_ior", "ior"] => M::Ior,
        ["extensions", "KHR_materials_dispersion", "dispersion"] => M::Dispersion,
        ["extensions", "KHR_materials_volume", name] => match *name {
            "thicknessFactor" => M::Thickness,
            "attenuationDistance" => M::AttenuationDistance,
            "attenuationColor" => M::AttenuationColor,
            _ => return None,
        },
        [slot @ .., "extensions", "KHR_texture_transform", name] => {
            let slot = match slot {
                ["normalTexture"] => TextureSlot::Normal,
                ["emissiveTexture"] => TextureSlot::Emissive,
                ["pbrMetallicRoughness", "baseColorTexture"] => TextureSlot::BaseColor,
                ["pbrMetallicRoughness", "metallicRoughnessTexture"] => TextureSlot::MetallicRoughness,
                ["extensions", "KHR_materials_transmission", "transmissionTexture"] => TextureSlot::Transmission,
                _ => return None,
            };
            match *name {
                "offset" => M::TextureOffset(slot),
                "rotation" => M::TextureRotation(slot),
                "scale" => M::TextureScale(slot),
                _ => return None,
            }
        }
        _ => return None,
    })
}

fn light_property(rest: &[&str]) -> Option<LightProperty> {
    Some(match rest {
        ["color"] => LightProperty::Color,
        ["intensity"] => LightProperty::Intensity,
        ["range"] => LightProperty::Range,
        ["spot", "innerConeAngle"] => LightProperty::InnerCone,
        ["spot", "outerConeAngle"] => LightProperty::OuterCone,
        _ => return None,
    })
}

fn camera_property(rest: &[&str]) -> Option<CameraProperty> {
    Some(match rest {
        ["perspective", "yfov"] => CameraProperty::FieldOfView,
        ["orthographic", "ymag"] => CameraProperty::HalfHeight,
        ["perspective" | "orthographic", "znear"] => CameraProperty::Near,
        _ => return None,
    })
}

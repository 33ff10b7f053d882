//! What the targets have in common.

use std::collections::HashSet;

use murano_scene::{Interpolation, Path, Primitive, Property, Sampler, Scene, import_bytes};

/// The scene that bytes hold, its indices and lengths checked; `None` where they hold none.
///
/// Bytes that are no GLB are taken as JSON, a NUL, and the binary chunk as well, so that changes of either need not
/// agree with a container's lengths.
pub fn imported(bytes: &[u8]) -> Option<Scene> {
    let packed = match bytes.iter().position(|&byte| byte == 0) {
        Some(end) if !bytes.starts_with(b"glTF") => &glb(&bytes[..end], &bytes[end + 1..]),
        _ => bytes,
    };
    match import_bytes(packed, "fuzz.glb") {
        Ok(scene) => {
            check(&scene);
            Some(scene)
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            None
        }
    }
}

/// A container of a JSON and a binary chunk.
fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let chunks = [(0x4E4F_534A_u32, json, b' '), (0x004E_4942, binary, 0)];
    let length: usize = chunks.iter().map(|(_, content, _)| 8 + content.len().next_multiple_of(4)).sum();
    let mut glb = b"glTF".to_vec();
    glb.extend(2_u32.to_le_bytes());
    glb.extend((12 + length as u32).to_le_bytes());
    for (kind, content, padding) in chunks {
        let padded = content.len().next_multiple_of(4);
        glb.extend((padded as u32).to_le_bytes());
        glb.extend(kind.to_le_bytes());
        glb.extend(content);
        glb.extend(std::iter::repeat_n(padding, padded - content.len()));
    }
    glb
}

/// Follows every index of a scene.
fn check(scene: &Scene) {
    let shown = scene.traversal();
    assert!(shown.len() <= scene.nodes.len());
    for node in &scene.nodes {
        assert!(node.local.matrix().is_finite());
        if let Some(mesh) = node.mesh {
            for primitive in &scene.meshes[mesh].primitives {
                assert_eq!(primitive.targets.len(), node.weights.len());
                if let Some(skin) = node.skin {
                    let joints = &scene.skins[skin].joints;
                    assert!(
                        primitive.joints.iter().flatten().flatten().all(|&joint| usize::from(joint) < joints.len())
                    );
                }
            }
        }
        let _ = (node.light.map(|light| &scene.lights[light]), node.camera.map(|camera| &scene.cameras[camera]));
    }
    for primitive in scene.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        check_primitive(scene, primitive);
    }
    for skin in &scene.skins {
        assert_eq!(skin.joints.len(), skin.inverse_bind.len());
        assert!(skin.joints.iter().all(|&joint| joint < scene.nodes.len()));
    }
    for clip in &scene.clips {
        let mut driven = HashSet::new();
        assert!(clip.channels.iter().all(|channel| driven.insert((channel.node, channel.path))));
        let mut driven = HashSet::new();
        assert!(clip.properties.iter().all(|channel| driven.insert(channel.property)));
        for channel in &clip.channels {
            check_sampler(&channel.sampler);
            let weights = &scene.nodes[channel.node].weights;
            assert!(channel.path != Path::Weights || channel.sampler.width == weights.len());
        }
        for channel in &clip.properties {
            check_sampler(&channel.sampler);
            assert_eq!(channel.sampler.width, channel.property.width());
            assert!(match channel.property {
                Property::Material(material, _) => material < scene.materials.len(),
                Property::Light(light, _) => light < scene.lights.len(),
                Property::Camera(camera, _) => camera < scene.cameras.len(),
                Property::Weight(node, target) => target < scene.nodes[node].weights.len(),
            });
        }
    }
}

fn check_sampler(sampler: &Sampler) {
    let per_key = if sampler.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    assert!(!sampler.times.is_empty() && sampler.times.is_sorted_by(|a, b| a < b));
    assert_eq!(sampler.values.len(), sampler.times.len() * sampler.width * per_key);
}

fn check_primitive(scene: &Scene, primitive: &Primitive) {
    let vertices = primitive.positions.len();
    assert!(primitive.triangles.iter().flatten().all(|&vertex| (vertex as usize) < vertices));
    assert!(primitive.positions.iter().all(|position| position.is_finite()));
    assert!(primitive.normals.iter().all(|normals| normals.len() == vertices));
    assert!(primitive.tangents.iter().all(|tangents| tangents.len() == vertices));
    assert!(primitive.texcoords.iter().all(|set| set.len() == vertices));
    assert!(primitive.joints.iter().all(|set| set.len() == vertices));
    assert!(primitive.weights.iter().all(|set| set.len() == vertices));
    let materials = &primitive.variant_materials;
    assert!(materials.is_empty() || materials.len() == scene.variants.len());
    let materials = materials.iter().chain([&primitive.material]).flatten();
    assert!(materials.copied().all(|material| material < scene.materials.len()));
    for target in &primitive.targets {
        for list in [&target.positions, &target.normals, &target.tangents].into_iter().flatten() {
            assert_eq!(list.len(), vertices);
        }
    }
}

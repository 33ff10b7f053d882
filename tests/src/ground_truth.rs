//! The data of an independent ray tracer, where they lie beside the project.

use std::path::Path;

use glam::DVec3;
use murano_animation::Pose;
use murano_reference::World;
use murano_scene::Material;
use serde_json::Value;

use crate::bench::shared;

/// `index.json`: cameras, lights, planes and figures; `None`, said on stderr, where there is none.
///
/// # Panics
/// If it is no JSON.
pub fn index() -> Option<Value> {
    let path = shared("reference/index.json")?;
    let text = std::fs::read(path).expect("index.json is readable");
    Some(serde_json::from_slice(&text).expect("index.json is JSON"))
}

/// A number of the index.
///
/// # Panics
/// If it is none.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Three numbers of the index.
///
/// # Panics
/// If they are not.
pub fn vector(value: &Value) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|axis| number(&value[axis])))
}

/// A text of the index.
///
/// # Panics
/// If it is none.
pub fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("{value} is no text"))
}

/// A body of the independent tracer's, in rest pose, as one clear glass; `None`, said on stderr, where it is not.
///
/// # Panics
/// If it cannot be loaded.
pub fn body(mesh: &str, ior: f64) -> Option<World> {
    let folder = if mesh.contains("20k") { "reference/meshes" } else { "data/paper" };
    Some(clear_glass(&shared(&format!("{folder}/{mesh}"))?, ior))
}

/// All that a model file shows in rest pose, as one clear glass.
///
/// # Panics
/// If it cannot be loaded.
pub fn clear_glass(model: &Path, ior: f64) -> World {
    let mut scene = murano_scene::import(model).unwrap_or_else(|error| panic!("{error}"));
    scene.materials.push(Material::glass(ior));
    let glass = scene.materials.len() - 1;
    for primitive in scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        primitive.material = Some(glass);
    }
    World::of_scene(&scene, &Pose::rest(&scene)).unwrap_or_else(|error| panic!("{error}"))
}

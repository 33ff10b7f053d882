//! Writes the models that fuzzing begins with into a folder, or without one into those of both targets: the smaller of
//! `assets/`, those that the import's tests begin with, and one that moves in every way; also with only a NUL between
//! their JSON and their binary chunk, and that behind bytes that choose layers.

use std::path::Path;
use std::{env, fs, io};

use common::Model;
use serde_json::json;

#[path = "../../crates/scene/tests/common/mod.rs"]
mod common;

/// Longest seed, bytes; larger ones would be cut.
const MAX_LENGTH: u64 = 65536;

fn main() -> io::Result<()> {
    match env::args().nth(1) {
        Some(folder) => write_seeds(Path::new(&folder)),
        None => ["fuzz/corpus/import", "fuzz/corpus/sample"].into_iter().map(Path::new).try_for_each(write_seeds),
    }
}

fn write_seeds(folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    for (name, model) in [("triangle", Model::triangle()), ("rich", Model::rich()), ("moving", moving())] {
        fs::write(folder.join(format!("{name}.gltf")), model.gltf())?;
        fs::write(folder.join(format!("{name}.glb")), model.glb())?;
        let mut json = model.json;
        json["buffers"] = json!([{ "byteLength": model.bytes.len() }]);
        let split = [json.to_string().as_bytes(), &[0], &model.bytes].concat();
        let choices: Vec<u8> = (0x80..0x90).collect();
        fs::write(folder.join(format!("chosen-{name}")), [&choices[..], &split[..]].concat())?;
        fs::write(folder.join(name), split)?;
    }
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets"))? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "glb") && path.metadata()?.len() <= MAX_LENGTH {
            fs::copy(&path, folder.join(path.file_name().unwrap_or_default()))?;
        }
    }
    Ok(())
}

/// A triangle on two joints with a morph target, a light and a camera; its first clip drives nodes by every path and
/// interpolation, its second what pointers reach.
fn moving() -> Model {
    let mut model = Model::triangle();
    let joints = model.accessor(5121, "VEC4", 3, &[0, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0]);
    let weights = model.floats("VEC4", &[0.5, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.25, 0.5, 0.25, 0.0]);
    let target = model.floats("VEC3", &[0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.25, 0.0, -0.5]);
    let times = [model.floats("SCALAR", &[0.0, 1.0]), model.floats("SCALAR", &[0.25, 0.5, 2.0])];
    let vectors = [2, 9].map(|rows| model.floats("VEC3", &wave(3 * rows)));
    let rotations = [2, 3, 9].map(|rows| model.floats("VEC4", &wave(4 * rows)));
    let numbers = [2, 3, 9].map(|rows| model.floats("SCALAR", &wave(rows)));
    let primitive = &mut model.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["JOINTS_0"] = json!(joints);
    primitive["attributes"]["WEIGHTS_0"] = json!(weights);
    primitive["targets"] = json!([{ "POSITION": target }]);
    primitive["material"] = json!(0);
    model.json["materials"] = json!([{ "extensions": { "KHR_materials_volume": { "thicknessFactor": 0.5 } } }]);
    model.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]);
    model.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": {} }] } });
    model.json["skins"] = json!([{ "joints": [1, 2] }]);
    model.json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "weights": [0.5] },
        { "children": [2], "rotation": [0.0, 0.6, 0.0, 0.8] },
        { "translation": [0.0, 0.5, 0.0], "scale": [1.0, 2.0, 0.5] },
        { "mesh": 0, "matrix": [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, -1, 0, 3, 0, 0, 1] },
        { "camera": 0, "extensions": { "KHR_lights_punctual": { "light": 0 } } },
    ]);
    let sampler =
        |kind: &str, times: usize, values: usize| json!({ "input": times, "output": values, "interpolation": kind });
    let samplers = json!([
        sampler("LINEAR", times[0], vectors[0]),
        sampler("CUBICSPLINE", times[1], vectors[1]),
        sampler("LINEAR", times[0], rotations[0]),
        sampler("STEP", times[1], rotations[1]),
        sampler("CUBICSPLINE", times[1], rotations[2]),
        sampler("LINEAR", times[0], numbers[0]),
        sampler("STEP", times[1], numbers[1]),
        sampler("CUBICSPLINE", times[1], numbers[2]),
    ]);
    let driven = [
        (1, "translation", 0),
        (1, "rotation", 2),
        (1, "scale", 1),
        (2, "translation", 1),
        (2, "rotation", 4),
        (4, "rotation", 3),
        (0, "weights", 7),
    ];
    let nodes =
        driven.map(|(node, path, sampler)| json!({ "sampler": sampler, "target": { "node": node, "path": path } }));
    let reached = [
        ("/materials/0/extensions/KHR_materials_volume/attenuationDistance", 7),
        ("/materials/0/extensions/KHR_materials_volume/attenuationColor", 0),
        ("/materials/0/pbrMetallicRoughness/baseColorFactor", 2),
        ("/extensions/KHR_lights_punctual/lights/0/spot/innerConeAngle", 5),
        ("/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle", 7),
        ("/extensions/KHR_lights_punctual/lights/0/range", 6),
        ("/cameras/0/perspective/yfov", 5),
        ("/nodes/3/weights/0", 6),
        ("/nodes/1/rotation", 2),
    ];
    let pointers = reached.map(|(pointer, sampler)| {
        let extensions = json!({ "KHR_animation_pointer": { "pointer": pointer } });
        json!({ "sampler": sampler, "target": { "path": "pointer", "extensions": extensions } })
    });
    model.json["animations"] =
        json!([{ "channels": nodes, "samplers": samplers }, { "channels": pointers, "samplers": samplers }]);
    model
}

/// Numbers of about 1 that differ.
fn wave(count: usize) -> Vec<f32> {
    (0..count).map(|index| (1.7 * index as f32).sin() + 0.1).collect()
}

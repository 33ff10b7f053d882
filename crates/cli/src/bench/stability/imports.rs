//! Files with numbers that are none: they must be refused, by name and element.

use std::{env, fs, process};

use anyhow::{Context, Result};
use murano_scene::{ImportProblem, import};
use serde_json::{Value, json};

use super::table::Row;

/// Vertices of the model.
const VERTICES: usize = 3;

/// An accessor of the model, by its use.
struct Accessor {
    user: &'static str,
    kind: &'static str,
    width: usize,
    count: usize,
}

const fn accessor(user: &'static str, kind: &'static str, width: usize, count: usize) -> Accessor {
    Accessor { user, kind, width, count }
}

/// Every accessor of floats that a model can have.
const ACCESSORS: [Accessor; 13] = [
    accessor("POSITION", "VEC3", 3, VERTICES),
    accessor("NORMAL", "VEC3", 3, VERTICES),
    accessor("TANGENT", "VEC4", 4, VERTICES),
    accessor("TEXCOORD_0", "VEC2", 2, VERTICES),
    accessor("COLOR_0", "VEC4", 4, VERTICES),
    accessor("WEIGHTS_0", "VEC4", 4, VERTICES),
    accessor("target POSITION", "VEC3", 3, VERTICES),
    accessor("target NORMAL", "VEC3", 3, VERTICES),
    accessor("inverseBindMatrices", "MAT4", 16, 1),
    accessor("input", "SCALAR", 1, 2),
    accessor("output translation", "VEC3", 3, 2),
    accessor("output rotation", "VEC4", 4, 2),
    accessor("output weights", "SCALAR", 1, 2),
];

/// Plants NaN and both infinities in every accessor in turn.
pub fn refusals() -> Result<Row> {
    let path = env::temp_dir().join(format!("murano-stability-{}.glb", process::id()));
    let mut problems = Vec::new();
    let mut files = 0;
    let mut try_file = |planted: Option<(usize, f32)>| -> Result<()> {
        fs::write(&path, glb(planted)).with_context(|| format!("{} cannot be written", path.display()))?;
        files += 1;
        let refused = import(&path).map_err(|error| error.problem);
        match (planted, refused) {
            (None, Ok(_)) => {}
            (None, Err(problem)) => problems.push(format!("the sound file is refused: {problem}")),
            (Some((index, value)), Ok(_)) => problems.push(format!("{value} in {} is let in", ACCESSORS[index].user)),
            (Some((index, _)), Err(ImportProblem::NonFinite { at, element })) => {
                let last = ACCESSORS[index].count - 1;
                if element != last || !at.starts_with(&format!("accessors[{index}] ")) {
                    problems.push(format!("{}: {at}, element {element} is blamed", ACCESSORS[index].user));
                }
            }
            (Some((index, _)), Err(problem)) => problems.push(format!("{}: {problem}", ACCESSORS[index].user)),
        }
        Ok(())
    };
    try_file(None)?;
    for index in 0..ACCESSORS.len() {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            try_file(Some((index, value)))?;
        }
    }
    fs::remove_file(&path).with_context(|| format!("{} cannot be removed", path.display()))?;
    Ok(Row::of_checks("files with NaN or infinity are refused", files, problems))
}

/// A skinned, morphed and animated triangle as GLB, with a number planted in the last component of an accessor.
fn glb(planted: Option<(usize, f32)>) -> Vec<u8> {
    let mut binary: Vec<u8> = Vec::new();
    let (mut views, mut accessors): (Vec<Value>, Vec<Value>) = (Vec::new(), Vec::new());
    for (index, accessor) in ACCESSORS.iter().enumerate() {
        // Times increase; everything else may be anything that is a direction, a colour and a weight too.
        let mut values: Vec<f32> = (0..accessor.count * accessor.width).map(|k| 0.25 + 0.1 * k as f32).collect();
        if let (Some(last), Some((_, value))) = (values.last_mut(), planted.filter(|(at, _)| *at == index)) {
            *last = value;
        }
        views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": 4 * values.len() }));
        binary.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        accessors.push(json!({
            "bufferView": index, "componentType": 5126, "type": accessor.kind, "count": accessor.count,
        }));
    }
    let joints = views.len();
    views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": 4 * VERTICES }));
    binary.extend([0_u8; 4 * VERTICES]);
    accessors.push(json!({ "bufferView": joints, "componentType": 5121, "type": "VEC4", "count": VERTICES }));

    let place = |user: &str| ACCESSORS.iter().position(|accessor| accessor.user == user);
    let of_vertices = ACCESSORS.iter().take(6).map(|accessor| (accessor.user.to_owned(), json!(place(accessor.user))));
    let mut attributes: serde_json::Map<String, Value> = of_vertices.collect();
    attributes.insert("JOINTS_0".into(), json!(joints));
    let animated = ["translation", "rotation", "weights"];
    let samplers = animated.map(|path| json!({ "input": place("input"), "output": place(&format!("output {path}")) }));
    let channels = [0, 1, 2].map(|sampler| {
        json!({ "sampler": sampler, "target": { "node": u32::from(sampler < 2), "path": animated[sampler] } })
    });
    let json = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": binary.len() }],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{ "primitives": [{
            "attributes": attributes,
            "targets": [{ "POSITION": place("target POSITION"), "NORMAL": place("target NORMAL") }],
        }] }],
        "nodes": [{ "mesh": 0, "skin": 0 }, {}],
        "skins": [{ "joints": [1], "inverseBindMatrices": place("inverseBindMatrices") }],
        "animations": [{ "samplers": samplers, "channels": channels }],
    });
    container(json.to_string().into_bytes(), binary)
}

/// The two chunks of a GLB file.
fn container(mut text: Vec<u8>, mut binary: Vec<u8>) -> Vec<u8> {
    text.resize(text.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let length = 12 + 8 + text.len() + 8 + binary.len();
    let mut file = b"glTF".to_vec();
    file.extend(2_u32.to_le_bytes());
    file.extend((length as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

//! Where the test data lies, and models made in a test.

// Every test file compiles its own copy of this module and uses part of it.
#![allow(dead_code)]

use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use murano_scene::{ImportError, ImportProblem, Scene, import};
use serde_json::{Value, json};

/// The shared data folder, or `None` with a note on stderr where it is absent.
pub fn data(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(folder);
    if !path.exists() {
        eprintln!("skipped: {} is absent", path.display());
        return None;
    }
    Some(path)
}

/// Every `.glb` and `.gltf` below a folder, sorted.
pub fn models(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("data folder is readable") {
            let path = entry.expect("data folder is readable").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// A model under construction: JSON and one buffer.
pub struct Model {
    pub json: Value,
    pub bytes: Vec<u8>,
}

impl Model {
    /// An empty model.
    pub fn new() -> Self {
        Self { json: json!({ "asset": { "version": "2.0" }, "bufferViews": [], "accessors": [] }), bytes: Vec::new() }
    }

    /// One triangle in the plane z = 0, counter-clockwise from +Z, on one node.
    pub fn triangle() -> Self {
        let mut model = Self::new();
        let positions = model.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        model.json["meshes"] = json!([{ "primitives": [{ "attributes": { "POSITION": positions } }] }]);
        model.json["nodes"] = json!([{ "name": "body", "mesh": 0 }]);
        model
    }

    /// A triangle with everything that has a count: indices, sparse values, a skin, a morph target, a clip, instances,
    /// variants and compressed positions.
    pub fn rich() -> Self {
        let mut model = Self::triangle();
        let indices = model.accessor(5121, "SCALAR", 3, &[0, 1, 2]);
        let joints = model.accessor(5121, "VEC4", 3, &[0; 12]);
        let weights = model.floats("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(3));
        let matrices = model.floats("MAT4", &glam::Mat4::IDENTITY.to_cols_array());
        let [times, places] = [model.floats("SCALAR", &[0.0, 1.0]), model.floats("VEC3", &[0.0; 6])];
        let encoded = meshopt::encode_vertex_buffer(&[[0.0_f32; 3]; 3]).expect("encoded");
        let view = model.view(&encoded);
        let mut compression = model.json["bufferViews"][view].take();
        compression["count"] = json!(3);
        compression["byteStride"] = json!(12);
        compression["mode"] = json!("ATTRIBUTES");
        let compressed = json!({ "EXT_meshopt_compression": compression });
        model.json["bufferViews"][view] = json!({ "buffer": 0, "byteLength": 36, "extensions": compressed });
        let [place, value] = [model.view(&[1]), model.view(&[0; 12])];
        let accessors = model.json["accessors"].as_array_mut().expect("a list");
        accessors.push(json!({ "bufferView": view, "componentType": 5126, "type": "VEC3", "count": 3, "sparse": {
            "count": 1,
            "indices": { "bufferView": place, "componentType": 5121 },
            "values": { "bufferView": value },
        }}));
        let target = accessors.len() - 1;
        let primitive = &mut model.json["meshes"][0]["primitives"][0];
        primitive["indices"] = json!(indices);
        primitive["material"] = json!(0);
        primitive["attributes"]["JOINTS_0"] = json!(joints);
        primitive["attributes"]["WEIGHTS_0"] = json!(weights);
        primitive["targets"] = json!([{ "POSITION": target }]);
        primitive["extensions"] =
            json!({ "KHR_materials_variants": { "mappings": [{ "material": 0, "variants": [0] }] } });
        model.json["materials"] = json!([{}]);
        model.json["extensions"] = json!({ "KHR_materials_variants": { "variants": [{ "name": "only" }] } });
        model.json["skins"] = json!([{ "joints": [1], "inverseBindMatrices": matrices }]);
        let instances = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
        model.json["nodes"] = json!([{ "mesh": 0, "skin": 0 }, {}, { "mesh": 0, "extensions": instances }]);
        model.json["animations"] = json!([{
            "channels": [{ "sampler": 0, "target": { "node": 1, "path": "translation" } }],
            "samplers": [{ "input": times, "output": places }],
        }]);
        model
    }

    /// Appends a buffer view; returns its index.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        self.bytes.extend_from_slice(bytes);
        push(&mut self.json["bufferViews"], view)
    }

    /// Appends an accessor over a view of its own; returns its index.
    pub fn accessor(&mut self, component_type: u32, element_type: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({ "bufferView": view, "componentType": component_type, "type": element_type, "count": count });
        push(&mut self.json["accessors"], accessor)
    }

    /// Appends an accessor of floats; returns its index.
    pub fn floats(&mut self, element_type: &str, values: &[f32]) -> usize {
        let width = match element_type {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(5126, element_type, values.len() / width, &bytes)
    }

    /// The JSON with its buffer as a data URI.
    pub fn gltf(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bytes));
        json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        serde_json::to_vec(&json).expect("a JSON value is written")
    }

    /// A GLB container.
    pub fn glb(&self) -> Vec<u8> {
        self.glb_with_buffers(&[])
    }

    /// A GLB container whose JSON lists further buffers after its own.
    pub fn glb_with_buffers(&self, others: &[Value]) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        for buffer in others {
            push(&mut json["buffers"], buffer.clone());
        }
        let mut text = serde_json::to_vec(&json).expect("a JSON value is written");
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.bytes.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let length = 12 + 8 + text.len() + 8 + binary.len();
        let mut glb = b"glTF".to_vec();
        glb.extend_from_slice(&2u32.to_le_bytes());
        glb.extend_from_slice(&(length as u32).to_le_bytes());
        for (kind, chunk) in [(0x4E4F_534A_u32, text), (0x004E_4942, binary)] {
            glb.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
            glb.extend_from_slice(&kind.to_le_bytes());
            glb.extend_from_slice(&chunk);
        }
        glb
    }

    /// Imports the model as `.gltf`.
    pub fn import(&self) -> Result<Scene, ImportError> {
        import_bytes(&self.gltf())
    }

    /// What the import finds wrong.
    pub fn problem(&self) -> ImportProblem {
        self.import().expect_err("the model is malformed").problem
    }
}

fn push(list: &mut Value, item: Value) -> usize {
    let list = list.as_array_mut().expect("a list");
    list.push(item);
    list.len() - 1
}

/// Imports bytes through a file.
pub fn import_bytes(bytes: &[u8]) -> Result<Scene, ImportError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("model.gltf");
    fs::write(&path, bytes).expect("a temporary file");
    import(&path)
}

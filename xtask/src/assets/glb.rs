//! A writer for binary glTF 2.0: one JSON chunk, one binary chunk.

use serde_json::{Map, Value, json};

/// What a buffer view is bound as, by its WebGL constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Vertex attributes.
    Vertices = 34962,
    /// Triangle indices.
    Indices = 34963,
}

/// Element type of an accessor of floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One float.
    Scalar,
    /// Three floats.
    Vec3,
    /// Four floats.
    Vec4,
    /// Sixteen floats, column-major.
    Mat4,
}

impl Shape {
    fn name(self) -> &'static str {
        match self {
            Self::Scalar => "SCALAR",
            Self::Vec3 => "VEC3",
            Self::Vec4 => "VEC4",
            Self::Mat4 => "MAT4",
        }
    }

    fn components(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vec3 => 3,
            Self::Vec4 => 4,
            Self::Mat4 => 16,
        }
    }
}

const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const FLOAT: u32 = 5126;

/// A glTF document under construction. Top-level arrays are filled by [`push`](Self::push), geometry and animation
/// data by the accessor methods.
#[derive(Debug, Default)]
pub struct Document {
    root: Map<String, Value>,
    binary: Vec<u8>,
    extensions: Vec<&'static str>,
}

impl Document {
    /// Appends `item` to the top-level array `array` (`"nodes"`, `"meshes"`, ...) and returns its index.
    pub fn push(&mut self, array: &str, item: Value) -> usize {
        let items = self.root.entry(array).or_insert_with(|| json!([]));
        let items = items.as_array_mut().expect("top-level entries are arrays until the document is finished");
        items.push(item);
        items.len() - 1
    }

    /// Names an extension that the document uses.
    pub fn use_extension(&mut self, name: &'static str) {
        if !self.extensions.contains(&name) {
            self.extensions.push(name);
        }
    }

    /// Accessor over floats; with its bounds where the specification asks for them (positions, animation input).
    pub fn floats(&mut self, values: &[f32], shape: Shape, target: Option<Target>, bounded: bool) -> usize {
        let view = self.view(values.iter().flat_map(|v| v.to_le_bytes()), target);
        let mut accessor = json!({
            "bufferView": view,
            "componentType": FLOAT,
            "count": values.len() / shape.components(),
            "type": shape.name(),
        });
        if bounded {
            set_bounds(&mut accessor, values, shape.components());
        }
        self.push("accessors", accessor)
    }

    /// Accessor of three floats a vertex that stores only the vertices whose value is not zero.
    pub fn sparse_vec3(&mut self, values: &[[f32; 3]]) -> usize {
        let flat: Vec<f32> = values.iter().flatten().copied().collect();
        let touched: Vec<u16> = (0..values.len()).filter(|&i| values[i] != [0.0; 3]).map(|i| i as u16).collect();
        let mut accessor = json!({ "componentType": FLOAT, "count": values.len(), "type": "VEC3" });
        set_bounds(&mut accessor, &flat, 3);
        if !touched.is_empty() {
            let indices = self.view(touched.iter().flat_map(|i| i.to_le_bytes()), None);
            let data = self.view(touched.iter().flat_map(|&i| values[i as usize]).flat_map(f32::to_le_bytes), None);
            accessor["sparse"] = json!({
                "count": touched.len(),
                "indices": { "bufferView": indices, "componentType": UNSIGNED_SHORT },
                "values": { "bufferView": data },
            });
        }
        self.push("accessors", accessor)
    }

    /// Accessor over triangle indices (fewer than 65 535 vertices).
    pub fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let bytes = triangles.iter().flatten().flat_map(|&i| (i as u16).to_le_bytes());
        let view = self.view(bytes, Some(Target::Indices));
        self.push(
            "accessors",
            json!({
                "bufferView": view,
                "componentType": UNSIGNED_SHORT,
                "count": triangles.len() * 3,
                "type": "SCALAR",
            }),
        )
    }

    /// Accessor over four joint indices a vertex (`JOINTS_0`).
    pub fn joints(&mut self, joints: &[[u8; 4]]) -> usize {
        let view = self.view(joints.iter().flatten().copied(), Some(Target::Vertices));
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": UNSIGNED_BYTE, "count": joints.len(), "type": "VEC4" }),
        )
    }

    /// Accessor over four joint weights a vertex (`WEIGHTS_0`), in 65 535ths.
    pub fn weights(&mut self, weights: &[[u16; 4]]) -> usize {
        let bytes = weights.iter().flatten().flat_map(|w| w.to_le_bytes());
        let view = self.view(bytes, Some(Target::Vertices));
        self.push(
            "accessors",
            json!({
                "bufferView": view,
                "componentType": UNSIGNED_SHORT,
                "normalized": true,
                "count": weights.len(),
                "type": "VEC4",
            }),
        )
    }

    /// The finished file, showing `nodes` in its only scene.
    pub fn finish(mut self, nodes: &[usize]) -> Vec<u8> {
        pad(&mut self.binary, 0);
        self.push("buffers", json!({ "byteLength": self.binary.len() }));
        self.push("scenes", json!({ "nodes": nodes }));
        self.root.insert("scene".into(), json!(0));
        self.root.insert(
            "asset".into(),
            json!({ "version": "2.0", "generator": "cargo xtask assets", "copyright": "Murano, MIT OR Apache-2.0" }),
        );
        if !self.extensions.is_empty() {
            self.extensions.sort_unstable();
            self.root.insert("extensionsUsed".into(), json!(self.extensions));
        }
        let mut text = sorted(Value::Object(self.root)).to_string().into_bytes();
        pad(&mut text, b' ');
        let total = 12 + 8 + text.len() + 8 + self.binary.len();
        let mut file = Vec::with_capacity(total);
        file.extend(b"glTF");
        file.extend(2_u32.to_le_bytes());
        file.extend((total as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &self.binary)] {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
        file
    }

    fn view(&mut self, bytes: impl Iterator<Item = u8>, target: Option<Target>) -> usize {
        pad(&mut self.binary, 0);
        let offset = self.binary.len();
        self.binary.extend(bytes);
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": self.binary.len() - offset });
        if let Some(target) = target {
            view["target"] = json!(target as u32);
        }
        self.push("bufferViews", view)
    }
}

/// glTF chunks and our buffer views start at multiples of four bytes.
fn pad(bytes: &mut Vec<u8>, filler: u8) {
    bytes.resize(bytes.len().next_multiple_of(4), filler);
}

fn set_bounds(accessor: &mut Value, values: &[f32], components: usize) {
    let fold = |start: f32, pick: fn(f32, f32) -> f32| {
        let mut bound = vec![start; components];
        for (i, &value) in values.iter().enumerate() {
            bound[i % components] = pick(bound[i % components], value);
        }
        json!(bound)
    };
    accessor["min"] = fold(f32::INFINITY, f32::min);
    accessor["max"] = fold(f32::NEG_INFINITY, f32::max);
}

/// Rebuilds every object with its keys in order: `serde_json` keeps insertion order or not depending on what other
/// crates of the build ask of it, and the file's bytes must not.
fn sorted(value: Value) -> Value {
    match value {
        Value::Object(map) => {
            let mut entries: Vec<_> = map.into_iter().collect();
            entries.sort_by(|a, b| a.0.cmp(&b.0));
            Value::Object(entries.into_iter().map(|(key, value)| (key, sorted(value))).collect())
        }
        Value::Array(items) => Value::Array(items.into_iter().map(sorted).collect()),
        other => other,
    }
}

//! The glTF 2.0 JSON as far as it is used, every element parsed by itself so that an error names it.
//!
//! Numbers are f64 as written: a node 10^6 m from the origin keeps its millimetres.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{DeserializeOwned, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer as _};
use serde_json::value::RawValue;
use serde_json::{Map, Value};

use super::error::ImportProblem;

/// Members of a JSON object as text, parsed where they are used: a tree of values would take ten times the file.
type Object<'a> = BTreeMap<String, &'a RawValue>;

/// Extension objects by name.
pub(super) type Extensions = Map<String, Value>;

#[derive(Debug)]
pub(super) struct Document {
    pub asset: Asset,
    pub extensions_used: Vec<String>,
    pub extensions_required: Vec<String>,
    pub buffers: Vec<Buffer>,
    pub buffer_views: Vec<BufferView>,
    pub accessors: Vec<Accessor>,
    pub meshes: Vec<Mesh>,
    pub nodes: Vec<Node>,
    pub scenes: Vec<Scene>,
    pub scene: Option<usize>,
    pub skins: Vec<Skin>,
    pub animations: Vec<Animation>,
    pub cameras: Vec<Camera>,
    pub lights: Vec<Light>,
    pub variants: Vec<Variant>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub samplers: Vec<TextureSampler>,
    pub images: Vec<Image>,
}

impl Document {
    /// Parses the JSON chunk.
    pub(super) fn parse(json: &[u8]) -> Result<Self, ImportProblem> {
        let root: Object = serde_json::from_slice(json).map_err(|source| ImportProblem::Json { source })?;
        let asset = root
            .get("asset")
            .ok_or_else(|| ImportProblem::Schema { at: "asset".to_owned(), problem: "missing".to_owned() })?;
        let extensions = object(&root, "extensions")?;
        Ok(Self {
            asset: parse(asset, "asset")?,
            extensions_used: list(&root, "extensionsUsed")?,
            extensions_required: list(&root, "extensionsRequired")?,
            buffers: list(&root, "buffers")?,
            buffer_views: list(&root, "bufferViews")?,
            accessors: list(&root, "accessors")?,
            meshes: list(&root, "meshes")?,
            nodes: list(&root, "nodes")?,
            scenes: list(&root, "scenes")?,
            scene: root.get("scene").map_or(Ok(None), |scene| parse(scene, "scene"))?,
            skins: list(&root, "skins")?,
            animations: list(&root, "animations")?,
            cameras: list(&root, "cameras")?,
            lights: extension_list(&extensions, "KHR_lights_punctual", "lights")?,
            variants: extension_list(&extensions, "KHR_materials_variants", "variants")?,
            materials: list(&root, "materials")?,
            textures: list(&root, "textures")?,
            samplers: list(&root, "samplers")?,
            images: list(&root, "images")?,
        })
    }

    /// A node for messages: its place and its name.
    pub(super) fn node_label(&self, index: usize) -> String {
        label("nodes", index, self.nodes.get(index).and_then(|node| node.name.as_deref()))
    }
}

/// Most characters of a name in a message; a file may have a message for each of its elements.
const LABEL_LENGTH: usize = 64;

/// An element for messages: its place in the JSON and, if it has one, its name or how that begins.
pub(super) fn label(list: &str, index: usize, name: Option<&str>) -> String {
    let name = name.unwrap_or_default();
    match name.char_indices().nth(LABEL_LENGTH) {
        _ if name.is_empty() => format!("{list}[{index}]"),
        None => format!("{list}[{index}] \"{name}\""),
        Some((end, _)) => format!("{list}[{index}] \"{}...\"", &name[..end]),
    }
}

/// The element that an index means, or an error that names the holder of the index.
pub(super) fn get<'a, T>(items: &'a [T], index: usize, list: &str, at: &str) -> Result<&'a T, ImportProblem> {
    items.get(index).ok_or_else(|| ImportProblem::BadIndex {
        at: at.to_owned(),
        list: list.to_owned(),
        index: index as u64,
        count: items.len(),
    })
}

/// One extension object of an element, parsed.
pub(super) fn extension<T: DeserializeOwned>(
    extensions: &Extensions,
    name: &str,
    at: &str,
) -> Result<Option<T>, ImportProblem> {
    extensions.get(name).map(|object| value(object.clone(), &format!("{at}.extensions.{name}"))).transpose()
}

fn value<T: DeserializeOwned>(value: Value, at: &str) -> Result<T, ImportProblem> {
    serde_json::from_value(value).map_err(|error| schema(at, &error))
}

fn parse<'a, T: Deserialize<'a>>(text: &'a RawValue, at: &str) -> Result<T, ImportProblem> {
    serde_json::from_str(text.get()).map_err(|error| schema(at, &error))
}

/// Lines and columns would count from the element's beginning, so they are left out.
fn schema(at: &str, error: &serde_json::Error) -> ImportProblem {
    let problem = error.to_string();
    let problem = problem.split(" at line ").next().unwrap_or_default().to_owned();
    ImportProblem::Schema { at: at.to_owned(), problem }
}

/// An object within another, empty if there is none.
fn object<'a>(parent: &Object<'a>, name: &str) -> Result<Object<'a>, ImportProblem> {
    match parent.get(name) {
        Some(text) if text.get() != "null" => parse(text, name),
        _ => Ok(Object::new()),
    }
}

/// A list that an extension adds to the document.
fn extension_list<T: DeserializeOwned>(
    extensions: &Object,
    extension: &str,
    name: &str,
) -> Result<Vec<T>, ImportProblem> {
    list(&object(extensions, extension)?, name)
}

/// A list of the document, each element parsed as it comes.
fn list<T: DeserializeOwned>(parent: &Object, name: &str) -> Result<Vec<T>, ImportProblem> {
    let Some(text) = parent.get(name) else { return Ok(Vec::new()) };
    if !text.get().starts_with('[') {
        return Err(ImportProblem::Schema { at: name.to_owned(), problem: "not an array".to_owned() });
    }
    let mut elements = Vec::new();
    match serde_json::Deserializer::from_str(text.get()).deserialize_seq(Elements(&mut elements)) {
        Ok(()) => Ok(elements),
        Err(error) => Err(schema(&format!("{name}[{}]", elements.len()), &error)),
    }
}

/// Appends elements to a list that is still there after an error, to tell which of them it was.
struct Elements<'a, T>(&'a mut Vec<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Elements<'_, T> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("an array")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<(), A::Error> {
        while let Some(element) = sequence.next_element()? {
            self.0.push(element);
        }
        Ok(())
    }
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Asset {
    pub version: String,
    pub min_version: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub uri: Option<String>,
    pub byte_length: u64,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
    #[serde(default)]
    pub extensions: Extensions,
}

/// `componentType`, by its OpenGL constant.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "u32")]
pub(super) enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl TryFrom<u32> for ComponentType {
    type Error = String;

    fn try_from(constant: u32) -> Result<Self, String> {
        Ok(match constant {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(format!("unknown component type {constant}")),
        })
    }
}

impl ComponentType {
    /// Bytes of one component.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// Accessor `type`.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum ElementType {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
}

impl ElementType {
    /// Components of one element.
    pub(super) fn width(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vec2 => 2,
            Self::Vec3 => 3,
            Self::Vec4 | Self::Mat2 => 4,
            Self::Mat3 => 9,
            Self::Mat4 => 16,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: ComponentType,
    #[serde(default)]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub element_type: ElementType,
    pub sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Sparse {
    pub count: u64,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: ComponentType,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: u64,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
    pub weights: Option<Vec<f64>>,
}

/// Attribute semantics to accessors.
pub(super) type Attributes = BTreeMap<String, usize>;

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    #[serde(default = "triangles")]
    pub mode: u32,
    #[serde(default)]
    pub targets: Vec<Attributes>,
    #[serde(default)]
    pub extensions: Extensions,
}

fn triangles() -> u32 {
    4
}

#[derive(Debug, Deserialize)]
pub(super) struct Node {
    pub name: Option<String>,
    #[serde(default)]
    pub children: Vec<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    pub camera: Option<usize>,
    pub weights: Option<Vec<f64>>,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub nodes: Vec<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    pub name: Option<String>,
    pub inverse_bind_matrices: Option<usize>,
    pub joints: Vec<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Animation {
    pub name: Option<String>,
    pub channels: Vec<Channel>,
    pub samplers: Vec<AnimationSampler>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Channel {
    pub sampler: usize,
    pub target: ChannelTarget,
}

#[derive(Debug, Deserialize)]
pub(super) struct ChannelTarget {
    pub node: Option<usize>,
    pub path: String,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Debug, Deserialize)]
pub(super) struct AnimationSampler {
    pub input: usize,
    pub output: usize,
    pub interpolation: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub(super) enum Camera {
    Perspective { name: Option<String>, perspective: Perspective },
    Orthographic { name: Option<String>, orthographic: Orthographic },
}

#[derive(Debug, Deserialize)]
pub(super) struct Perspective {
    pub yfov: f64,
    pub znear: f64,
}

#[derive(Debug, Deserialize)]
pub(super) struct Orthographic {
    pub ymag: f64,
    pub znear: f64,
}

/// KHR_lights_punctual.
#[derive(Debug, Deserialize)]
pub(super) struct Light {
    pub name: Option<String>,
    #[serde(rename = "type")]
    pub kind: String,
    pub color: Option<[f32; 3]>,
    pub intensity: Option<f32>,
    pub range: Option<f32>,
    pub spot: Option<Spot>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Spot {
    pub inner_cone_angle: Option<f32>,
    pub outer_cone_angle: Option<f32>,
}

/// KHR_lights_punctual on a node.
#[derive(Debug, Deserialize)]
pub(super) struct NodeLight {
    pub light: usize,
}

/// KHR_materials_variants.
#[derive(Debug, Deserialize)]
pub(super) struct Variant {
    pub name: String,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Material {
    pub name: Option<String>,
    #[serde(default)]
    pub pbr_metallic_roughness: MetallicRoughness,
    pub normal_texture: Option<TextureInfo>,
    pub emissive_factor: Option<[f32; 3]>,
    pub emissive_texture: Option<TextureInfo>,
    pub alpha_mode: Option<String>,
    pub alpha_cutoff: Option<f32>,
    #[serde(default)]
    pub double_sided: bool,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MetallicRoughness {
    pub base_color_factor: Option<[f32; 4]>,
    pub base_color_texture: Option<TextureInfo>,
    pub metallic_factor: Option<f32>,
    pub roughness_factor: Option<f32>,
    #[serde(rename = "metallicRoughnessTexture")]
    pub texture: Option<TextureInfo>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    pub index: usize,
    #[serde(default)]
    pub tex_coord: usize,
    /// Of a normal texture.
    pub scale: Option<f32>,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Debug, Deserialize)]
pub(super) struct Texture {
    pub sampler: Option<usize>,
    pub source: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureSampler {
    pub wrap_s: Option<u32>,
    pub wrap_t: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image {
    pub name: Option<String>,
    pub uri: Option<String>,
    pub buffer_view: Option<usize>,
}

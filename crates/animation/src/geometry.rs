//! Mesh instances concatenated into flat arrays: one deformation dispatch and one draw for all of them.
//!
//! The arrays of [`Geometry`] are laid out as WGSL storage buffers read them (`repr(C)`, every record a multiple of its
//! alignment), so that they upload as they are:
//!
//! | array | WGSL element |
//! |---|---|
//! | `vertices` | `struct { position: vec3f, instance: u32, normal: vec3f, corner: u32 }` |
//! | `texcoords`, `colors` | `vec4f` |
//! | `influence_offsets` | `u32`, one more than there are vertices |
//! | `influences` | `struct { entry: u32, weight: f32 }` |
//! | `morph_words` | `struct { moved: u32, first: u32 }` |
//! | `displacements` | six `f32`: position, normal |
//! | `tangents` | `vec4f` |
//! | `tangent_displacements` | three `f32` |
//! | `triangles` | three `u32` (no `vec3u`: its stride would be 16) |
//! | `triangle_instances` | `u32` |
//!
//! The deformation of vertex `v` (glTF 2.0, 3.7.2 and 3.7.3) is then `p = position + sum(weight * displacement)` over the
//! targets of [`Geometry::push_active_targets`] whose word has the bit of `v`, likewise for the normal, and
//! `sum(i.weight * palette[i.entry]) * (p, 1)` over `influences[influence_offsets[v]..influence_offsets[v + 1]]`, with
//! [`Geometry::palette`] of the pose.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, Vec2, Vec4};
use murano_scene::{NodeIndex, Primitive, Scene, Skinning};

use crate::bounds::Bounds;
use crate::companies::{Company, companies};
use crate::influences::Binding;
use crate::targets::MorphWord;

/// A vertex in the rest pose.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct RestVertex {
    /// Mesh space, relative to [`Instance::pivot`], metres.
    pub position: [f32; 3],
    /// Index into [`Geometry::instances`].
    pub instance: u32,
    /// Mesh space; zero where the shading is flat.
    pub normal: [f32; 3],
    /// In the lowest two bits 0: smooth, `normal` deforms with the vertex. 1, 2, 3: flat, the vertex is the first, second, third of its
    /// triangle, whose vertices are the three from `index + 1 - corner` on; its normal is that of the deformed triangle. Above
    /// them [`Instance::shell`].
    pub corner: u32,
}

/// The share of one palette matrix in a vertex.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Influence {
    /// Index into the palette.
    pub entry: u32,
    /// Greater than zero; the weights of a vertex sum to 1.
    pub weight: f32,
}

/// One primitive of one node, and where its parts lie in the arrays of [`Geometry`].
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// The node's name, else its mesh's, for messages.
    pub name: String,
    /// The node.
    pub node: NodeIndex,
    /// Of several surfaces that have nothing to do with each other, which one it is a part of.
    pub shell: u32,
    /// Index into `Scene::meshes`.
    pub mesh: usize,
    /// Index into `Mesh::primitives`.
    pub primitive: usize,
    /// Index into `Scene::materials`; `None` for the default material.
    pub material: Option<usize>,
    /// Centre of the rest positions in mesh space, metres. Rest positions are stored relative to it and the palette adds
    /// it back in f64: a mesh modelled far from its origin keeps its precision.
    pub pivot: DVec3,
    /// Whether its normals are those of the deformed triangles.
    pub flat_normals: bool,
    /// Vertices.
    pub vertices: Range<u32>,
    /// Triangles.
    pub triangles: Range<u32>,
    /// Palette entries.
    pub palette: Range<u32>,
    pub(crate) companies: Range<u32>,
    /// Morph targets.
    pub targets: u32,
    /// First of its words in [`Geometry::morph_words`]: a row of one word a target for every 8 vertices.
    pub morph_words: u32,
}

/// A matrix of the palette: its node, and what is constant about it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PaletteEntry {
    /// The joint, or the mesh's own node.
    pub node: NodeIndex,
    /// Inverse bind matrix times the translation to the pivot.
    pub node_from_vertex: DMat4,
    /// Bounds of the rest positions that it influences, relative to the pivot.
    pub rest: Bounds,
    /// Bounds of those vertices' displacements and zero, per morph target of the instance.
    pub displacements: Vec<Bounds>,
}

/// Mesh instances as flat arrays; constant over a clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// How skins are blended.
    pub skinning: Skinning,
    /// What was concatenated, in order.
    pub instances: Vec<Instance>,
    /// Vertices in the rest pose.
    pub vertices: Vec<RestVertex>,
    /// TEXCOORD_0 in xy and TEXCOORD_1 in zw; zero where there is none.
    pub texcoords: Vec<[f32; 4]>,
    /// COLOR_0, linear RGBA; white where there is none.
    pub colors: Vec<[f32; 4]>,
    /// Tangents of the rest pose for maps of normals, w the sign of the bitangent; zero where the file has none. Empty if no
    /// primitive has both tangents and a map.
    pub tangents: Vec<[f32; 4]>,
    /// Where a vertex's influences begin; one more at the end.
    pub influence_offsets: Vec<u32>,
    /// Influences, at least one per vertex.
    pub influences: Vec<Influence>,
    /// Which vertices the morph targets move.
    pub morph_words: Vec<MorphWord>,
    /// By how much at weight 1: position, metres, and normal. Only where either is not zero.
    pub displacements: Vec<[f32; 6]>,
    /// And of the tangent; empty where `tangents` is.
    pub tangent_displacements: Vec<[f32; 3]>,
    /// Counter-clockwise seen from outside in the rest pose (see [`Geometry::mirrored`]).
    pub triangles: Vec<[u32; 3]>,
    /// Instance of each triangle.
    pub triangle_instances: Vec<u32>,
    pub(crate) palette_entries: Vec<PaletteEntry>,
    /// Which entries move vertices together, for the bounds of dual quaternions; none for linear blending.
    pub(crate) companies: Vec<Company>,
}

/// Why a geometry could not be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GeometryError {
    /// The pair of indices names nothing.
    #[error(
        "node {node} has no primitive {primitive}: the scene has {nodes} nodes; list what it has with `shown_primitives`"
    )]
    NoSuchPrimitive {
        /// Node asked for.
        node: NodeIndex,
        /// Primitive asked for.
        primitive: usize,
        /// Nodes there are.
        nodes: usize,
    },
    /// The arrays are indexed by u32.
    #[error("node {node} brings the geometry over 2^32 {what}: split it into several geometries")]
    TooLarge {
        /// Node at which the limit was passed.
        node: NodeIndex,
        /// What there are too many of.
        what: &'static str,
    },
}

/// Every primitive that the default scene shows: (node, index of the primitive in the node's mesh), in traversal order.
pub fn shown_primitives(scene: &Scene) -> Vec<(NodeIndex, usize)> {
    let primitives_of = |node: NodeIndex| {
        let count = scene.nodes[node].mesh.map_or(0, |mesh| scene.meshes[mesh].primitives.len());
        (0..count).map(move |primitive| (node, primitive))
    };
    scene.traversal().into_iter().flat_map(primitives_of).collect()
}

/// Whether a primitive has tangents, and a map of normals that needs them.
fn is_framed(scene: &Scene, node: NodeIndex, primitive: usize) -> bool {
    let mesh = scene.nodes.get(node).and_then(|node| scene.meshes.get(node.mesh?));
    let Some(primitive) = mesh.and_then(|mesh| mesh.primitives.get(primitive)) else { return false };
    let material = primitive.material.and_then(|index| scene.materials.get(index));
    primitive.tangents.is_some() && material.is_some_and(|material| material.normal_texture.is_some())
}

/// Triangles of a primitive whose indices all exist.
pub(crate) fn valid_triangles(primitive: &Primitive) -> impl Iterator<Item = [u32; 3]> {
    let count = primitive.positions.len();
    primitive.triangles.iter().copied().filter(move |triangle| triangle.iter().all(|&index| (index as usize) < count))
}

/// For each vertex of an instance, the vertex of the primitive that it copies. With flat shading every triangle gets
/// vertices of its own, whether or not the primitive came that way.
pub(crate) fn source_vertices(primitive: &Primitive) -> Vec<usize> {
    if primitive.normals.is_some() {
        (0..primitive.positions.len()).collect()
    } else {
        valid_triangles(primitive).flatten().map(|index| index as usize).collect()
    }
}

impl Geometry {
    /// Concatenates primitives, each given as a node and the index of a primitive in that node's mesh.
    ///
    /// Skin weights that are zero, negative or not finite are dropped, as are those of joints that the skin does not
    /// have, and the rest is scaled to sum to 1. A vertex left without any follows the first joint of its JOINTS_0, and
    /// without a skin its node.
    ///
    /// # Errors
    /// [`GeometryError`] when a pair names nothing or the arrays outgrow 32-bit indices.
    pub fn build(scene: &Scene, instances: &[(NodeIndex, usize)]) -> Result<Self, GeometryError> {
        Self::of_shells(scene, &[instances])
    }

    /// Gathers several surfaces into one geometry, one after the other: they may touch, but what lies across an edge is of the same one.
    ///
    /// # Errors
    /// As [`Geometry::build`].
    pub fn of_shells(scene: &Scene, shells: &[&[(NodeIndex, usize)]]) -> Result<Self, GeometryError> {
        let mut geometry = Self { skinning: scene.skinning, influence_offsets: vec![0], ..Self::default() };
        let framed = |&(node, primitive): &(NodeIndex, usize)| is_framed(scene, node, primitive);
        let framed = shells.iter().copied().flatten().any(framed);
        for (shell, instances) in (0..).zip(shells) {
            for &(node, primitive) in *instances {
                geometry.append(scene, node, primitive, shell, framed).ok_or(GeometryError::NoSuchPrimitive {
                    node,
                    primitive,
                    nodes: scene.nodes.len(),
                })?;
                geometry.check_size(node)?;
            }
        }
        Ok(geometry)
    }

    fn check_size(&self, node: NodeIndex) -> Result<(), GeometryError> {
        let sizes = [
            (self.vertices.len(), "vertices"),
            (self.triangles.len(), "triangles"),
            (self.influences.len(), "influences"),
            (self.displacements.len(), "morph displacements"),
            (self.morph_words.len(), "words of morph targets"),
        ];
        match sizes.into_iter().find(|&(size, _)| size > u32::MAX as usize) {
            Some((_, what)) => Err(GeometryError::TooLarge { node, what }),
            None => Ok(()),
        }
    }

    /// Appends one instance; `None` if there is no such primitive.
    fn append(
        &mut self,
        scene: &Scene,
        node: NodeIndex,
        primitive_index: usize,
        shell: u32,
        framed: bool,
    ) -> Option<()> {
        let owner = scene.nodes.get(node)?;
        let mesh_index = owner.mesh?;
        let mesh = scene.meshes.get(mesh_index)?;
        let primitive = mesh.primitives.get(primitive_index)?;

        let pivot = Bounds::of(primitive.positions.iter().map(|position| position.as_dvec3())).center();
        let vertex_start = self.vertices.len() as u32;
        let triangle_start = self.triangles.len() as u32;
        let palette_start = self.palette_entries.len() as u32;
        let morph_words = self.morph_words.len() as u32;
        let instance = self.instances.len() as u32;
        let flat_normals = primitive.normals.is_none();

        let sources = source_vertices(primitive);
        let mut binding = Binding::new(scene, node, primitive, pivot);
        for (ordinal, &source) in sources.iter().enumerate() {
            let corner = if flat_normals { ordinal as u32 % 3 + 1 } else { 0 } | shell << 2;
            let rest = primitive.positions[source].as_dvec3() - pivot;
            self.vertices.push(RestVertex {
                position: rest.as_vec3().to_array(),
                instance,
                normal: at(primitive.normals.as_deref(), source).to_array(),
                corner,
            });
            self.push_appearance(primitive, source);
            if framed {
                self.tangents.push(at::<Vec4>(primitive.tangents.as_deref(), source).to_array());
            }
            binding.push(source, rest, &mut self.palette_entries, &mut self.influences);
            self.influence_offsets.push(self.influences.len() as u32);
        }
        let companies_start = self.companies.len() as u32;
        if self.skinning == Skinning::DualQuaternion {
            self.companies.extend(companies(primitive, &sources, &self.influences_since(vertex_start), pivot));
        }
        self.push_targets(primitive, &sources, framed);
        self.push_triangles(primitive, vertex_start, instance);

        self.instances.push(Instance {
            name: if owner.name.is_empty() { mesh.name.clone() } else { owner.name.clone() },
            node,
            shell,
            mesh: mesh_index,
            primitive: primitive_index,
            material: primitive.material,
            pivot,
            flat_normals,
            vertices: vertex_start..self.vertices.len() as u32,
            triangles: triangle_start..self.triangles.len() as u32,
            palette: palette_start..self.palette_entries.len() as u32,
            companies: companies_start..self.companies.len() as u32,
            targets: primitive.targets.len() as u32,
            morph_words,
        });
        Some(())
    }

    /// Palette entries of every vertex from one on.
    fn influences_since(&self, vertex: u32) -> Vec<Vec<u32>> {
        let spans = self.influence_offsets[vertex as usize..].windows(2);
        let entries = |span: &[u32]| {
            self.influences[span[0] as usize..span[1] as usize].iter().map(|influence| influence.entry).collect()
        };
        spans.map(entries).collect()
    }

    fn push_appearance(&mut self, primitive: &Primitive, source: usize) {
        let texcoord = |set: usize| at::<Vec2>(primitive.texcoords.get(set).map(Vec::as_slice), source);
        let (first, second) = (texcoord(0), texcoord(1));
        self.texcoords.push([first.x, first.y, second.x, second.y]);
        let color = primitive.colors.as_ref().and_then(|colors| colors.get(source)).copied();
        self.colors.push(color.unwrap_or(Vec4::ONE).to_array());
    }

    fn push_triangles(&mut self, primitive: &Primitive, vertex_start: u32, instance: u32) {
        for (triangle, ordinal) in valid_triangles(primitive).zip(0u32..) {
            let local =
                if primitive.normals.is_some() { triangle } else { [0, 1, 2].map(|corner| 3 * ordinal + corner) };
            self.triangles.push(local.map(|index| index + vertex_start));
            self.triangle_instances.push(instance);
        }
    }
}

/// The entry of a per-vertex list, zero where the list or the entry is missing.
fn at<T: Copy + Default>(list: Option<&[T]>, index: usize) -> T {
    list.and_then(|list| list.get(index)).copied().unwrap_or_default()
}

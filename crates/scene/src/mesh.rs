//! Triangle meshes with skinning influences and morph targets.

use glam::{Vec2, Vec3, Vec4};

/// A mesh: primitives that share a node.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name in the file, or empty.
    pub name: String,
    /// Triangle primitives; points and lines are dropped at import with a warning.
    pub primitives: Vec<Primitive>,
}

/// Indexed triangles of one material. Every per-vertex list present has the length of `positions`.
#[derive(Clone, Debug, Default)]
pub struct Primitive {
    /// Mesh space, metres.
    pub positions: Vec<Vec3>,
    /// Unit normals. `None`: flat shading, and the vertices of each triangle are its own: `triangles[i]` is
    /// `[3i, 3i+1, 3i+2]` (glTF 2.0, 3.7.2.1).
    pub normals: Option<Vec<Vec3>>,
    /// Unit tangents, w = handedness.
    pub tangents: Option<Vec<Vec4>>,
    /// TEXCOORD_n sets in order.
    pub texcoords: Vec<Vec<Vec2>>,
    /// COLOR_0, linear RGBA.
    pub colors: Option<Vec<Vec4>>,
    /// JOINTS_n sets in order, indices into the skin's joints.
    pub joints: Vec<Vec<[u16; 4]>>,
    /// WEIGHTS_n sets in order, as stored (not renormalised).
    pub weights: Vec<Vec<[f32; 4]>>,
    /// Counter-clockwise seen from outside. Strips and fans are expanded.
    pub triangles: Vec<[u32; 3]>,
    /// Morph targets; every primitive of a mesh has the same number.
    pub targets: Vec<MorphTarget>,
    /// Index into `Scene::materials`.
    pub material: Option<usize>,
    /// Material in each of `Scene::variants`; empty where it is `material` in all of them.
    pub variant_materials: Vec<Option<usize>>,
}

/// Displacements of one morph target; each list present has one entry per vertex.
#[derive(Clone, Debug, Default)]
pub struct MorphTarget {
    /// Added to positions, metres.
    pub positions: Option<Vec<Vec3>>,
    /// Added to normals.
    pub normals: Option<Vec<Vec3>>,
    /// Added to tangents' xyz.
    pub tangents: Option<Vec<Vec3>>,
}

//! The node hierarchy and what hangs on it.

use glam::{DMat4, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Camera, Clip, Image, ImportReport, Light, Material, Mesh};

/// Index of a node in [`Scene::nodes`].
pub type NodeIndex = usize;

/// Translation, rotation and scale of a node relative to its parent, applied as T * R * S.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Metres.
    pub translation: DVec3,
    /// Unit quaternion.
    pub rotation: DQuat,
    /// Factor per axis; may be zero or negative.
    pub scale: DVec3,
}

impl Transform {
    /// The transform that changes nothing.
    pub const IDENTITY: Self = Self { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE };

    /// `parent_from_local` as a matrix.
    pub fn matrix(&self) -> DMat4 {
        DMat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// A node's own transform. A matrix may shear and is never animated (glTF 2.0, 3.6.1.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Local {
    /// Translation, rotation, scale.
    Trs(Transform),
    /// Any affine matrix, `parent_from_local`.
    Matrix(DMat4),
}

impl Default for Local {
    fn default() -> Self {
        Self::Trs(Transform::IDENTITY)
    }
}

impl Local {
    /// `parent_from_local` as a matrix.
    pub fn matrix(&self) -> DMat4 {
        match self {
            Self::Trs(transform) => transform.matrix(),
            Self::Matrix(matrix) => *matrix,
        }
    }
}

/// One node of the hierarchy.
#[derive(Clone, Debug, Default)]
pub struct Node {
    /// Name in the file, or empty; of an instance the name of its parent and its number, `tree[3]`.
    pub name: String,
    /// Parent, or `None` for a root.
    pub parent: Option<NodeIndex>,
    /// Children, each with this node as `parent`.
    pub children: Vec<NodeIndex>,
    /// Own transform in the rest pose.
    pub local: Local,
    /// Index into [`Scene::meshes`].
    pub mesh: Option<usize>,
    /// Index into [`Scene::skins`].
    pub skin: Option<usize>,
    /// Index into [`Scene::cameras`].
    pub camera: Option<usize>,
    /// Index into [`Scene::lights`].
    pub light: Option<usize>,
    /// Morph weights at rest: the node's own, else its mesh's, else zeros; one per morph target of the mesh.
    pub weights: Vec<f64>,
}

/// Joints and their inverse bind matrices.
#[derive(Clone, Debug)]
pub struct Skin {
    /// Name in the file, or empty.
    pub name: String,
    /// Joint nodes; the vertex attribute `JOINTS_n` indexes this list.
    pub joints: Vec<NodeIndex>,
    /// `joint_from_mesh` at bind time, one per joint (identity where the file gives none).
    pub inverse_bind: Vec<DMat4>,
}

/// How the joints that move a vertex are blended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Skinning {
    /// The mean of their matrices (glTF 2.0, 3.7.3): loses volume where they turn far against one another.
    #[default]
    Linear,
    /// The mean of their dual quaternions: keeps it.
    DualQuaternion,
}

/// A whole scene: what one model file holds, of its default scene.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Every node of the file, then one for each instance of a mesh (EXT_mesh_gpu_instancing); only those reachable from
    /// `roots` are shown.
    pub nodes: Vec<Node>,
    /// Roots of the default scene (the first scene if none is marked; all parentless nodes if there is no scene).
    pub roots: Vec<NodeIndex>,
    /// Meshes, shared by nodes.
    pub meshes: Vec<Mesh>,
    /// Skins, shared by nodes.
    pub skins: Vec<Skin>,
    /// Materials; a primitive without one uses [`Material::default`].
    pub materials: Vec<Material>,
    /// Decoded images.
    pub images: Vec<Image>,
    /// Animation clips.
    pub clips: Vec<Clip>,
    /// How skins are blended; a file does not say.
    pub skinning: Skinning,
    /// Cameras, placed by nodes.
    pub cameras: Vec<Camera>,
    /// Lights, placed by nodes.
    pub lights: Vec<Light>,
    /// Names of the material variants; see [`Scene::select_variant`]. As imported, none is selected.
    pub variants: Vec<String>,
    /// What the import had to say.
    pub report: ImportReport,
}

impl Scene {
    /// Nodes reachable from the roots, every parent before its children.
    pub fn traversal(&self) -> Vec<NodeIndex> {
        let mut order = Vec::with_capacity(self.nodes.len());
        let mut stack: Vec<NodeIndex> = self.roots.iter().rev().copied().collect();
        while let Some(node) = stack.pop() {
            order.push(node);
            stack.extend(self.nodes[node].children.iter().rev());
        }
        order
    }
}

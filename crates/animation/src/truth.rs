//! The deformation of glTF 2.0 in f64 from the scene's own data: the truth that the GPU pass is held to.
//!
//! Nothing here reads the packed arrays of [`Geometry`]; only which vertices there are, and in which order, comes from it.

use glam::{DMat3, DMat4, DVec3, DVec4, Vec3};
use murano_scene::{Primitive, Scene, Skinning};
use rayon::prelude::*;

use crate::bounds::Bounds;
use crate::geometry::{Geometry, Instance, source_vertices};
use crate::motion::Motion;
use crate::pose::Pose;

/// A deformed body in world space, vertex by vertex as in [`Geometry::vertices`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deformed {
    /// World, metres.
    pub positions: Vec<DVec3>,
    /// World, unit, outward; zero where the body has collapsed so far that there is none.
    pub normals: Vec<DVec3>,
    /// World, unit (zero where there is none), with the sign of the bitangent; empty where [`Geometry::tangents`] is.
    pub tangents: Vec<DVec4>,
}

impl Deformed {
    /// The box around the deformed positions.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.positions.iter().copied())
    }
}

/// Deforms every vertex: morph, then skin (or the node's matrix), then normals by the inverse transpose of the blended
/// matrix, or from the deformed triangle where the primitive has none (glTF 2.0, 3.7.2, 3.7.3).
///
/// `geometry` must have been built from `scene` and `pose` sampled of it.
pub fn deform_f64(geometry: &Geometry, scene: &Scene, pose: &Pose) -> Deformed {
    let mut deformed = Deformed::default();
    for instance in &geometry.instances {
        let body = Body::new(scene, pose, instance);
        let vertices: Vec<Vertex> = source_vertices(body.primitive).into_par_iter().map(|v| body.deform(v)).collect();
        deformed.positions.extend(vertices.iter().map(|vertex| vertex.position));
        if !geometry.tangents.is_empty() {
            deformed.tangents.extend(vertices.iter().map(|vertex| vertex.tangent));
        }
        if instance.flat_normals {
            deformed.normals.extend(vertices.chunks_exact(3).flat_map(flat_normals));
        } else {
            deformed.normals.extend(vertices.iter().map(|vertex| vertex.normal));
        }
    }
    deformed
}

/// One deformed vertex, and whether the matrix that moved it mirrors.
struct Vertex {
    position: DVec3,
    normal: DVec3,
    tangent: DVec4,
    mirrored: bool,
}

/// One instance with everything its vertices share.
struct Body<'a> {
    primitive: &'a Primitive,
    weights: &'a [f64],
    world_from_mesh: DMat4,
    /// World matrix times inverse bind matrix of each joint; empty for a rigid body.
    joints: Vec<DMat4>,
    /// The same about the pivot as motions, where dual quaternions blend them.
    motions: Option<Vec<Motion>>,
    pivot: DVec3,
}

impl<'a> Body<'a> {
    fn new(scene: &'a Scene, pose: &'a Pose, instance: &Instance) -> Self {
        let primitive = &scene.meshes[instance.mesh].primitives[instance.primitive];
        let skin = scene.nodes[instance.node].skin.and_then(|skin| scene.skins.get(skin));
        let joints = skin.map_or_else(Vec::new, |skin| {
            let inverse_bind = skin.inverse_bind.iter().copied().chain(std::iter::repeat(DMat4::IDENTITY));
            skin.joints
                .iter()
                .zip(inverse_bind)
                .map(|(&joint, inverse)| pose.world_from_node[joint] * inverse)
                .collect()
        });
        let about_pivot = |joint: &DMat4| Motion::of(&(*joint * DMat4::from_translation(instance.pivot)));
        let dual = scene.skinning == Skinning::DualQuaternion;
        Self {
            motions: dual.then(|| joints.iter().map(about_pivot).collect()),
            pivot: instance.pivot,
            primitive,
            weights: &pose.weights[instance.node],
            world_from_mesh: pose.world_from_node[instance.node],
            joints,
        }
    }

    fn deform(&self, vertex: usize) -> Vertex {
        let mut position = self.primitive.positions[vertex].as_dvec3();
        let mut normal = entry(self.primitive.normals.as_ref(), vertex);
        let stored =
            self.primitive.tangents.as_ref().and_then(|tangents| tangents.get(vertex)).copied().unwrap_or_default();
        let mut tangent = stored.truncate().as_dvec3();
        for (target, &weight) in self.primitive.targets.iter().zip(self.weights) {
            tangent += weight * entry(target.tangents.as_ref(), vertex);
            position += weight * entry(target.positions.as_ref(), vertex);
            normal += weight * entry(target.normals.as_ref(), vertex);
        }
        if let Some(motion) = self.mean_motion(vertex) {
            let mirrored = motion.stretch.determinant() < 0.0;
            return Vertex {
                position: motion.apply(position - self.pivot),
                normal: motion.real * outward(&motion.stretch, normal),
                tangent: framed(motion.real * (motion.stretch * tangent), stored.w, mirrored),
                mirrored,
            };
        }
        let matrix = self.blended_matrix(vertex);
        let linear = DMat3::from_mat4(matrix);
        let mirrored = linear.determinant() < 0.0;
        Vertex {
            position: matrix.transform_point3(position),
            normal: outward(&linear, normal),
            tangent: framed(linear * tangent, stored.w, mirrored),
            mirrored,
        }
    }

    /// Joints that move a vertex, and their weights as stored.
    fn influences(&self, vertex: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let sets = self.primitive.joints.iter().zip(&self.primitive.weights);
        sets.filter_map(move |(joints, weights)| Some(joints.get(vertex)?.iter().zip(weights.get(vertex)?)))
            .flatten()
            .map(|(&joint, &weight)| (usize::from(joint), f64::from(weight)))
            .filter(|&(joint, weight)| joint < self.joints.len() && weight > 0.0 && weight.is_finite())
    }

    /// The mean of the joints' motions; `None` where matrices are blended, or no joint moves the vertex.
    fn mean_motion(&self, vertex: usize) -> Option<Motion> {
        let motions = self.motions.as_ref()?;
        let total: f64 = self.influences(vertex).map(|(_, weight)| weight).sum();
        Motion::mean(self.influences(vertex).map(|(joint, weight)| (weight / total, motions[joint])))
    }

    /// The weighted mean of the joints' matrices, or the node's matrix for a rigid body.
    fn blended_matrix(&self, vertex: usize) -> DMat4 {
        let (sum, total) = self.influences(vertex).fold((DMat4::ZERO, 0.0), |(sum, total), (joint, weight)| {
            (sum + self.joints[joint] * weight, total + weight)
        });
        if total > 0.0 {
            return sum * total.recip();
        }
        let first = self.primitive.joints.first().and_then(|joints| joints.get(vertex));
        let joint = first.and_then(|joints| self.joints.get(usize::from(joints[0])));
        joint.copied().unwrap_or(self.world_from_mesh)
    }
}

/// A deformed tangent, unit, with the sign of its bitangent, which turns where the map mirrors.
fn framed(tangent: DVec3, sign: f32, mirrored: bool) -> DVec4 {
    tangent.normalize_or_zero().extend(if mirrored { -f64::from(sign) } else { sign.into() })
}

fn entry(list: Option<&Vec<Vec3>>, vertex: usize) -> DVec3 {
    list.and_then(|list| list.get(vertex)).map_or(DVec3::ZERO, |value| value.as_dvec3())
}

/// A normal under a linear map: by its inverse transpose, taken from the cofactor matrix (which exists for singular maps
/// too) with the sign of the determinant, so that it points outward when the map mirrors.
fn outward(linear: &DMat3, normal: DVec3) -> DVec3 {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *linear;
    let cofactor = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    (cofactor * normal * sign).normalize_or_zero()
}

/// The normals of the three corners of a deformed triangle.
fn flat_normals(corners: &[Vertex]) -> [DVec3; 3] {
    let edge = |corner: usize| corners[corner].position - corners[0].position;
    let normal = edge(1).cross(edge(2)).normalize_or_zero();
    [0, 1, 2].map(|corner| if corners[corner].mirrored { -normal } else { normal })
}

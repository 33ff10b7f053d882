//! From parts, skeleton and choreography to an animated .glb.

use glam::{DQuat, DVec3};
use serde_json::json;

use super::contour;
use super::flatten;
use super::glb::{Document, Shape, Target};
use super::implicit::{Loft, ellipsoid, gradient, smooth_union};
use super::material::Glass;
use super::remesh::{Resolution, remesh};
use super::rig::{Chain, Influences, Pose, Skeleton, pack};
use super::surface::Surface;

/// A part of a body: a field that is blended into the parts before it, and the joints that move it.
pub struct Part {
    /// Box that holds the part, metres; away from it the field is not asked.
    pub bounds: [DVec3; 2],
    /// Signed field, negative inside.
    pub field: Box<dyn Fn(DVec3) -> f64>,
    /// Radius of the blend with the parts before it, metres.
    pub blend: f64,
    /// Joints at a point of the part; weights sum to 1.
    pub influences: Box<dyn Fn(DVec3) -> Influences>,
}

/// Away from its box by this much a part neither blends nor moves anything, metres.
const MARGIN: f64 = 0.1;

impl Part {
    /// A limb that a chain of joints moves.
    pub fn limb(loft: Loft, blend: f64, chain: Chain) -> Self {
        let axis = loft.clone();
        Self {
            bounds: loft.bounds(),
            field: Box::new(move |p| loft.field(p)),
            blend,
            influences: Box::new(move |p| chain.at(axis.station(p))),
        }
    }

    /// An ellipsoid that follows one joint.
    pub fn blob(center: DVec3, radii: DVec3, blend: f64, joint: usize) -> Self {
        Self {
            bounds: [center - radii, center + radii],
            field: Box::new(move |p| ellipsoid(p - center, radii)),
            blend,
            influences: Box::new(move |_| vec![(joint, 1.0)]),
        }
    }

    /// Its field, or infinity far from it.
    fn distance(&self, p: DVec3) -> f64 {
        let [low, high] = self.bounds;
        if (p - p.clamp(low, high)).length_squared() > MARGIN * MARGIN { f64::INFINITY } else { (self.field)(p) }
    }
}

/// A morph target: a displacement of the rest pose, metres.
pub struct Morph {
    /// Target name.
    pub name: &'static str,
    /// Displacement of a point.
    pub displace: Box<dyn Fn(DVec3) -> DVec3>,
}

/// A key of the weights clip.
#[derive(Clone, Debug)]
pub struct WeightKey {
    /// Seconds.
    pub time: f64,
    /// A weight a target.
    pub weights: Vec<f64>,
    /// A slope a target, per second, on both sides of the key.
    pub slopes: Vec<f64>,
}

/// A looping clip: the last key repeats the first.
pub struct Clip {
    /// Clip name.
    pub name: &'static str,
    /// Seconds.
    pub duration: f64,
    /// Evenly spaced poses from 0 to `duration`.
    pub poses: Vec<Pose>,
    /// Keys of the morph weights; empty without targets.
    pub weights: Vec<WeightKey>,
}

/// Everything a character is made of.
pub struct Character {
    /// Node and mesh name.
    pub name: &'static str,
    /// Joints.
    pub skeleton: Skeleton,
    /// Body parts in order of blending.
    pub parts: Vec<Part>,
    /// Morph targets.
    pub morphs: Vec<Morph>,
    /// Its clip.
    pub clip: Clip,
    /// Its glass.
    pub glass: Glass,
    /// Box that holds the rest pose, metres.
    pub bounds: [DVec3; 2],
    /// How much farther than the nearest part another part may be and still move a vertex, metres.
    pub sharing: f64,
    /// How fine its mesh is.
    pub resolution: Resolution,
}

impl Character {
    /// Meshes the body, binds it and writes it out.
    pub fn to_glb(&self) -> Vec<u8> {
        let body = |p: DVec3| self.field(p);
        let cell = self.resolution.finest * 1.4;
        let contour = contour::extract(&body, self.bounds[0], self.bounds[1], cell);
        let surface = remesh(&body, contour, self.resolution);
        let mut document = Document::default();
        let primitive = self.primitive(&mut document, &surface);
        let mut mesh = json!({ "name": self.name, "primitives": [primitive] });
        if !self.morphs.is_empty() {
            let names: Vec<_> = self.morphs.iter().map(|m| m.name).collect();
            mesh["weights"] = json!(vec![0.0; names.len()]);
            mesh["extras"] = json!({ "targetNames": names });
        }
        let mesh = document.push("meshes", mesh);
        let root = self.joint_nodes(&mut document);
        let skin = self.skin(&mut document, root);
        let body = document.push("nodes", json!({ "name": self.name, "mesh": mesh, "skin": skin }));
        self.animation(&mut document, root, body);
        document.finish(&[body, root])
    }

    fn field(&self, p: DVec3) -> f64 {
        self.parts.iter().fold(f64::INFINITY, |sum, part| {
            let value = part.distance(p);
            if sum.is_finite() && value.is_finite() { smooth_union(sum, value, part.blend) } else { sum.min(value) }
        })
    }

    /// Joints at `p`: those of the nearest part, with a share for every part almost as near.
    fn influences(&self, p: DVec3) -> Influences {
        let distances: Vec<f64> = self.parts.iter().map(|part| part.distance(p)).collect();
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        let mut all = Influences::new();
        for (part, distance) in self.parts.iter().zip(distances) {
            let share = 1.0 - (distance - nearest) / self.sharing;
            if share > 0.0 {
                all.extend((part.influences)(p).into_iter().map(|(joint, w)| (joint, w * share * share * share)));
            }
        }
        all
    }

    fn primitive(&self, document: &mut Document, surface: &Surface) -> serde_json::Value {
        let vertices = Some(Target::Vertices);
        let (joints, weights): (Vec<_>, Vec<_>) = surface.positions.iter().map(|&p| pack(&self.influences(p))).unzip();
        let mut primitive = json!({
            "attributes": {
                "POSITION": document.floats(&flatten(&surface.positions), Shape::Vec3, vertices, true),
                "NORMAL": document.floats(&flatten(&surface.normals), Shape::Vec3, vertices, false),
                "JOINTS_0": document.joints(&joints),
                "WEIGHTS_0": document.weights(&weights),
            },
            "indices": document.indices(&surface.triangles),
            "material": self.glass.add_to(document),
        });
        if !self.morphs.is_empty() {
            let targets: Vec<_> = self.morphs.iter().map(|m| m.write(document, surface)).collect();
            primitive["targets"] = json!(targets);
        }
        primitive
    }

    /// Adds a node a joint, children after their parents, and returns the root's index.
    fn joint_nodes(&self, document: &mut Document) -> usize {
        let joints = &self.skeleton.joints;
        // Nothing else is a node yet, so joint i becomes node i.
        for (index, joint) in joints.iter().enumerate() {
            let children: Vec<usize> = (0..joints.len()).filter(|&j| joints[j].parent == Some(index)).collect();
            let offset = self.skeleton.offset(index).as_vec3();
            let mut node = json!({ "name": joint.name, "translation": offset.to_array() });
            if !children.is_empty() {
                node["children"] = json!(children);
            }
            document.push("nodes", node);
        }
        0
    }

    fn skin(&self, document: &mut Document, root: usize) -> usize {
        let mut matrices = Vec::new();
        for joint in &self.skeleton.joints {
            let [x, y, z] = (-joint.position).as_vec3().to_array();
            matrices.extend([1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0]);
        }
        let inverse_bind = document.floats(&matrices, Shape::Mat4, None, false);
        let joints: Vec<usize> = (root..root + self.skeleton.joints.len()).collect();
        document.push("skins", json!({ "skeleton": root, "joints": joints, "inverseBindMatrices": inverse_bind }))
    }

    fn animation(&self, document: &mut Document, root: usize, body: usize) {
        let Clip { name, duration, poses, weights } = &self.clip;
        let last = poses.len() - 1;
        let times: Vec<f32> = (0..=last).map(|i| (duration * i as f64 / last as f64) as f32).collect();
        let input = document.floats(&times, Shape::Scalar, None, true);
        let mut samplers = Vec::new();
        let mut channels = Vec::new();
        let mut channel = |node: usize, path: &str, sampler: serde_json::Value| {
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
            samplers.push(sampler);
        };
        let places: Vec<DVec3> = poses.iter().map(|pose| pose.root).collect();
        let output = document.floats(&flatten(&places), Shape::Vec3, None, false);
        channel(root, "translation", json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        for joint in 0..self.skeleton.joints.len() {
            let rotations = continuous(poses.iter().map(|pose| pose.rotations[joint]));
            let output = document.floats(&rotations, Shape::Vec4, None, false);
            channel(root + joint, "rotation", json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        }
        if !weights.is_empty() {
            let times: Vec<f32> = weights.iter().map(|key| key.time as f32).collect();
            // In-slope, value, out-slope for each key.
            let values: Vec<f32> = weights
                .iter()
                .flat_map(|key| key.slopes.iter().chain(&key.weights).chain(&key.slopes).map(|&v| v as f32))
                .collect();
            let input = document.floats(&times, Shape::Scalar, None, true);
            let output = document.floats(&values, Shape::Scalar, None, false);
            channel(body, "weights", json!({ "input": input, "output": output, "interpolation": "CUBICSPLINE" }));
        }
        document.push("animations", json!({ "name": name, "samplers": samplers, "channels": channels }));
    }
}

impl Morph {
    /// Writes position and normal differences and returns the target's JSON.
    fn write(&self, document: &mut Document, surface: &Surface) -> serde_json::Value {
        let mut positions = Vec::new();
        let mut normals = Vec::new();
        for (&p, &normal) in surface.positions.iter().zip(&surface.normals) {
            let shift = (self.displace)(p);
            if shift.length() < 2e-6 {
                positions.push([0.0; 3]);
                normals.push([0.0; 3]);
                continue;
            }
            positions.push(shift.as_vec3().to_array());
            normals.push((self.displaced_normal(p, normal) - normal).as_vec3().to_array());
        }
        json!({ "POSITION": document.sparse_vec3(&positions), "NORMAL": document.sparse_vec3(&normals) })
    }

    /// Normal of the displaced surface: the cofactor matrix of the displacement's Jacobian takes normals along.
    fn displaced_normal(&self, p: DVec3, normal: DVec3) -> DVec3 {
        let row = |axis: DVec3| {
            let component = |q: DVec3| (q + (self.displace)(q)).dot(axis);
            gradient(&component, p)
        };
        let (x, y, z) = (row(DVec3::X), row(DVec3::Y), row(DVec3::Z));
        DVec3::new(y.cross(z).dot(normal), z.cross(x).dot(normal), x.cross(y).dot(normal)).normalize()
    }
}

/// Quaternions as floats, each in the hemisphere of the one before, so that linear interpolation goes the short way.
fn continuous(rotations: impl Iterator<Item = DQuat>) -> Vec<f32> {
    let mut previous = DQuat::IDENTITY;
    rotations
        .flat_map(|rotation| {
            previous = if previous.dot(rotation) < 0.0 { -rotation } else { rotation };
            previous.as_quat().to_array()
        })
        .collect()
}

//! Bodies made in code, and the scenes that show them.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3, Vec3};
use murano_scene::{Local, Material, Mesh, Node, Primitive, Scene, Skin, Transform};

/// Triangles with smooth normals, metres; counter-clockwise seen from outside unless turned.
#[derive(Clone, Default)]
pub struct Body {
    pub positions: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Body {
    /// A ball about the origin of `rings` bands from pole to pole and `segments` around.
    pub fn ball(radius: f64, rings: u32, segments: u32) -> Self {
        let mut body = Self::default();
        let mut point = |polar: f64, around: f64| {
            let normal = DVec3::new(polar.sin() * around.cos(), polar.cos(), -polar.sin() * around.sin());
            body.positions.push(radius * normal);
            body.normals.push(normal);
        };
        point(0.0, 0.0);
        point(PI, 0.0);
        for ring in 1..rings {
            for segment in 0..segments {
                point(PI * f64::from(ring) / f64::from(rings), TAU * f64::from(segment) / f64::from(segments));
            }
        }
        let at = |ring: u32, segment: u32| 2 + (ring - 1) * segments + segment % segments;
        for segment in 0..segments {
            body.triangles.push([0, at(1, segment), at(1, segment + 1)]);
            for ring in 1..rings - 1 {
                let [a, b] = [at(ring, segment), at(ring, segment + 1)];
                let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
                body.triangles.extend([[a, c, d], [a, d, b]]);
            }
            body.triangles.push([1, at(rings - 1, segment + 1), at(rings - 1, segment)]);
        }
        body
    }

    /// The usual ball: radius 1, fine enough that its facets do not matter beside its truth, which has them too.
    pub fn unit_ball() -> Self {
        Self::ball(1.0, 32, 64)
    }

    /// A torus about the y axis.
    pub fn torus(major: f64, minor: f64, around: u32, across: u32) -> Self {
        let mut body = Self::default();
        for i in 0..around {
            let u = TAU * f64::from(i) / f64::from(around);
            let outwards = DVec3::new(u.cos(), 0.0, -u.sin());
            for j in 0..across {
                let v = TAU * f64::from(j) / f64::from(across);
                let normal = outwards * v.cos() + DVec3::Y * v.sin();
                body.positions.push(outwards * major + normal * minor);
                body.normals.push(normal);
            }
        }
        let at = |i: u32, j: u32| (i % around) * across + j % across;
        for i in 0..around {
            for j in 0..across {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                body.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        body
    }

    /// A plate with faces of their own normals, its upper and lower face cut into strips along z.
    pub fn plate(half: DVec3, strips: u32) -> Self {
        let mut body = Self::default();
        let mut face = |normal: DVec3, u: DVec3, v: DVec3, from: f64, to: f64| {
            let first = body.positions.len() as u32;
            for (s, t) in [(from, -1.0), (to, -1.0), (to, 1.0), (from, 1.0)] {
                body.positions.push((normal + s * u + t * v) * half);
                body.normals.push(normal);
            }
            body.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        };
        for (normal, u, v) in
            [(DVec3::X, DVec3::Y, DVec3::Z), (DVec3::Y, DVec3::Z, DVec3::X), (DVec3::Z, DVec3::X, DVec3::Y)]
        {
            let count = if normal == DVec3::Y { strips } else { 1 };
            for strip in 0..count {
                let edge = |k: u32| 2.0 * f64::from(k) / f64::from(count) - 1.0;
                face(normal, u, v, edge(strip), edge(strip + 1));
                face(-normal, v, u, -1.0, 1.0);
            }
        }
        body
    }

    /// Both bodies as one.
    pub fn and(mut self, other: &Self) -> Self {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.normals.extend(&other.normals);
        self.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
        self
    }

    /// With its outside turned in.
    pub fn inside_out(mut self) -> Self {
        self.normals.iter_mut().for_each(|normal| *normal = -*normal);
        self.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        self
    }

    /// Every vertex at another place.
    pub fn moved(mut self, to: impl Fn(DVec3) -> DVec3) -> Self {
        self.positions.iter_mut().for_each(|position| *position = to(*position));
        self
    }

    /// Only the triangles all of whose corners pass.
    pub fn kept(mut self, keep: impl Fn(DVec3) -> bool) -> Self {
        let Self { positions, triangles, .. } = &mut self;
        triangles.retain(|triangle| triangle.iter().all(|&vertex| keep(positions[vertex as usize])));
        self
    }

    /// As a primitive of the scene's first material.
    pub fn primitive(&self) -> Primitive {
        let narrow = |list: &[DVec3]| list.iter().map(|v| v.as_vec3()).collect::<Vec<Vec3>>();
        Primitive {
            positions: narrow(&self.positions),
            normals: Some(narrow(&self.normals)),
            triangles: self.triangles.clone(),
            material: Some(0),
            ..Primitive::default()
        }
    }

    /// Alone in a scene, at the origin.
    pub fn alone(&self, ior: f64) -> Scene {
        self.placed(ior, Transform::IDENTITY)
    }

    /// Alone in a scene.
    pub fn placed(&self, ior: f64, place: Transform) -> Scene {
        scene(self.primitive(), ior, vec![node(Local::Trs(place), Some(0))])
    }

    /// Alone in a scene, skinned: every vertex follows the joints by `weights_of` its place, and the joints are placed by
    /// `joints` with the identity at bind time.
    pub fn skinned(&self, ior: f64, joints: &[Transform], weights_of: impl Fn(DVec3) -> [f32; 4]) -> Scene {
        let mut primitive = self.primitive();
        primitive.joints = vec![vec![[0, 1, 0, 0]; self.positions.len()]];
        primitive.weights = vec![self.positions.iter().map(|&position| weights_of(position)).collect()];
        let mut nodes = vec![Node { skin: Some(0), ..node(Local::Trs(Transform::IDENTITY), Some(0)) }];
        nodes.extend(joints.iter().map(|joint| node(Local::Trs(*joint), None)));
        let mut scene = scene(primitive, ior, nodes);
        let inverse_bind = vec![glam::DMat4::IDENTITY; joints.len()];
        scene.skins.push(Skin { name: String::new(), joints: (1..=joints.len()).collect(), inverse_bind });
        scene
    }
}

/// A scale about the origin.
pub fn scaled(scale: DVec3) -> Transform {
    Transform { scale, ..Transform::IDENTITY }
}

/// A place in the world.
pub fn at(translation: DVec3) -> Transform {
    Transform { translation, ..Transform::IDENTITY }
}

/// A turn about an axis.
pub fn turned(axis: DVec3, degrees: f64) -> Transform {
    Transform { rotation: DQuat::from_axis_angle(axis, degrees.to_radians()), ..Transform::IDENTITY }
}

fn node(local: Local, mesh: Option<usize>) -> Node {
    Node {
        name: String::new(),
        parent: None,
        children: Vec::new(),
        local,
        mesh,
        skin: None,
        camera: None,
        light: None,
        weights: Vec::new(),
    }
}

/// Slightly absorbing glass, so that no index of refraction makes it vanish.
fn scene(primitive: Primitive, ior: f64, nodes: Vec<Node>) -> Scene {
    let glass =
        Material { attenuation_color: Vec3::new(0.8, 0.9, 0.95), attenuation_distance: 1.0, ..Material::glass(ior) };
    Scene {
        roots: (0..nodes.len()).collect(),
        nodes,
        meshes: vec![Mesh { name: "body".into(), primitives: vec![primitive] }],
        materials: vec![glass],
        ..Scene::default()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Volume by the divergence theorem; every edge of a closed body is run along as often as back.
    fn volume_if_closed(body: &Body) -> f64 {
        let key = |vertex: u32| body.positions[vertex as usize].to_array().map(|c| (c * 1e9).round() as i64);
        let mut edges: BTreeMap<_, i32> = BTreeMap::new();
        let mut volume = 0.0;
        for &[a, b, c] in &body.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((key(from), key(to))).or_default() += 1;
                *edges.entry((key(to), key(from))).or_default() -= 1;
            }
            let [p, q, r] = [a, b, c].map(|vertex| body.positions[vertex as usize]);
            volume += p.dot(q.cross(r)) / 6.0;
        }
        assert!(edges.values().all(|count| *count == 0), "open");
        volume
    }

    #[test]
    fn bodies_are_closed_and_their_outside_is_out() {
        let ball = volume_if_closed(&Body::ball(1.0, 64, 128));
        assert!((ball / (4.0 / 3.0 * PI) - 1.0).abs() < 2e-3, "{ball}");
        let torus = volume_if_closed(&Body::torus(1.0, 0.4, 128, 64));
        assert!((torus / (2.0 * PI * PI * 0.16) - 1.0).abs() < 3e-3, "{torus}");
        let plate = volume_if_closed(&Body::plate(DVec3::new(1.0, 0.2, 0.5), 1));
        assert!((plate - 0.8).abs() < 1e-12, "{plate}");
        assert!(volume_if_closed(&Body::unit_ball().inside_out()) < -4.0);
    }
}

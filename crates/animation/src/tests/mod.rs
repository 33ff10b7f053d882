//! Tests of poses and deformation as a whole, on scenes made by hand and on model files.

mod asset_generator;
mod corpus;
mod crowds;
mod deformation;
mod dual_quaternions;
mod layers;
mod packed;
mod posing;
mod properties;
mod variants;

use glam::{DMat4, DVec3, Vec3, Vec4};
use murano_scene::{Local, Mesh, Node, NodeIndex, Primitive, Scene, Skin, Transform};

use crate::targets::WORD;
use crate::{Deformed, Geometry, Pose, deform_f64};

/// A node without anything on it.
fn node(parent: Option<NodeIndex>, local: Local) -> Node {
    Node {
        name: String::new(),
        parent,
        children: Vec::new(),
        local,
        mesh: None,
        skin: None,
        camera: None,
        light: None,
        weights: Vec::new(),
    }
}

fn translated(x: f64, y: f64, z: f64) -> Local {
    Local::Trs(Transform { translation: DVec3::new(x, y, z), ..Transform::IDENTITY })
}

/// A scene of nodes, each with its parent before it; parentless ones are the roots.
fn scene_of(nodes: Vec<Node>) -> Scene {
    let mut scene = Scene { nodes, ..Scene::default() };
    for index in 0..scene.nodes.len() {
        match scene.nodes[index].parent {
            Some(parent) => scene.nodes[parent].children.push(index),
            None => scene.roots.push(index),
        }
    }
    scene
}

/// Hangs a primitive on a node as the scene's next mesh, with a weight of 0 per morph target.
fn hang(scene: &mut Scene, on: NodeIndex, primitive: Primitive) {
    scene.nodes[on].weights = vec![0.0; primitive.targets.len()];
    scene.nodes[on].mesh = Some(scene.meshes.len());
    scene.meshes.push(Mesh { name: "mesh".into(), primitives: vec![primitive] });
}

/// Binds the mesh of a node to joints in the rest pose.
fn bind(scene: &mut Scene, on: NodeIndex, joints: Vec<NodeIndex>) {
    let rest = Pose::rest(scene);
    let inverse_bind = joints.iter().map(|&joint| rest.world_from_node[joint].inverse()).collect();
    scene.nodes[on].skin = Some(scene.skins.len());
    scene.skins.push(Skin { name: String::new(), joints, inverse_bind });
}

/// The vertices given, with normals along +Z, in one triangle per three.
fn primitive(positions: &[[f32; 3]]) -> Primitive {
    let count = positions.len() as u32;
    Primitive {
        positions: positions.iter().copied().map(Vec3::from_array).collect(),
        normals: Some(vec![Vec3::Z; positions.len()]),
        triangles: (0..count / 3).map(|triangle| [3 * triangle, 3 * triangle + 1, 3 * triangle + 2]).collect(),
        ..Primitive::default()
    }
}

/// Geometry of everything shown, and its truth in a pose.
fn deform(scene: &Scene, pose: &Pose) -> (Geometry, Deformed) {
    let geometry = Geometry::build(scene, &crate::shown_primitives(scene)).unwrap();
    let deformed = deform_f64(&geometry, scene, pose);
    (geometry, deformed)
}

#[track_caller]
fn assert_near(actual: DVec3, expected: [f64; 3]) {
    let expected = DVec3::from_array(expected);
    assert!(actual.distance(expected) < 1e-12, "{actual} is not {expected}");
}

/// The packed arrays as the GPU evaluates them, in f32, brought back to world space.
fn deform_packed(geometry: &Geometry, pose: &Pose, origin: DVec3) -> Vec<DVec3> {
    let palette = geometry.palette(pose, origin);
    let (mut targets, mut ranges) = (Vec::new(), Vec::new());
    geometry.push_active_targets(pose, &mut targets, &mut ranges);
    let span = |offsets: &[u32], vertex: usize| offsets[vertex] as usize..offsets[vertex + 1] as usize;
    let vertex_at = |vertex: usize| {
        let mut rest = Vec3::from_array(geometry.vertices[vertex].position);
        let range = ranges[geometry.vertices[vertex].instance as usize];
        let place = vertex as u32 - range.vertex;
        let (word, bit) = (place / WORD as u32, 1u32 << (place % WORD as u32));
        for target in &targets[range.start as usize..range.end as usize] {
            let word = geometry.morph_words[(target.word + word * range.row) as usize];
            if word.moved & bit != 0 {
                let index = word.first + (word.moved & (bit - 1)).count_ones();
                rest += target.weight * Vec3::from_slice(&geometry.displacements[index as usize]);
            }
        }
        let mut posed = Vec3::ZERO;
        for influence in &geometry.influences[span(&geometry.influence_offsets, vertex)] {
            let rows = &palette[3 * influence.entry as usize..][..3];
            let coordinate = |row: usize| Vec4::from_array(rows[row]).dot(rest.extend(1.0));
            posed += influence.weight * Vec3::new(coordinate(0), coordinate(1), coordinate(2));
        }
        posed.as_dvec3() + origin
    };
    (0..geometry.vertices.len()).map(vertex_at).collect()
}

/// A matrix that turns about +Z by a quarter.
fn quarter_turn() -> DMat4 {
    DMat4::from_rotation_z(std::f64::consts::FRAC_PI_2)
}

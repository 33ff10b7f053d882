//! Deformation against results worked out by hand.

use glam::{DVec3, Vec3};
use murano_scene::{Local, MorphTarget, Primitive, Scene, Transform};

use super::{assert_near, bind, deform, hang, node, primitive, quarter_turn, scene_of, translated};
use crate::Pose;

/// Two joints up the y axis, one metre apart, and a mesh bound to them; its node stands elsewhere, which must not matter.
/// Posed, the upper joint is turned by a quarter about +Z.
fn bent(mut body: Primitive, weights: &[[f32; 4]]) -> (Scene, Pose) {
    body.joints = vec![vec![[0, 1, 0, 0]; weights.len()]];
    body.weights = vec![weights.to_vec()];
    let mut scene = scene_of(vec![
        node(None, translated(0.0, 0.0, 0.0)),
        node(Some(0), translated(0.0, 1.0, 0.0)),
        node(None, translated(100.0, 50.0, 0.0)),
    ]);
    hang(&mut scene, 2, body);
    bind(&mut scene, 2, vec![0, 1]);
    let Local::Trs(upper) = &mut scene.nodes[1].local else { unreachable!() };
    *upper = Transform { rotation: glam::DQuat::from_mat4(&quarter_turn()), ..*upper };
    let pose = Pose::rest(&scene);
    (scene, pose)
}

#[test]
fn two_joints_bend_a_body() {
    let positions = [[0.0, 2.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.5, 0.0]];
    let weights = [[0., 1., 0., 0.], [0.5, 0.5, 0., 0.], [0.5, 0.5, 0., 0.], [1., 0., 0., 0.]];
    let mut body = primitive(&positions);
    body.normals = Some(vec![Vec3::X; 4]);
    let (scene, pose) = bent(body, &weights);
    let (geometry, deformed) = deform(&scene, &pose);
    assert_near(deformed.positions[0], [-1.0, 1.0, 0.0]);
    assert_near(deformed.positions[1], [0.0, 1.0, 0.0]);
    assert_near(deformed.positions[2], [0.5, 1.5, 0.0]);
    assert_near(deformed.positions[3], [1.0, 0.5, 0.0]);
    assert_near(deformed.normals[0], [0.0, 1.0, 0.0]);
    assert_near(deformed.normals[2], [0.5f64.sqrt(), 0.5f64.sqrt(), 0.0]);
    assert_near(deformed.normals[3], [1.0, 0.0, 0.0]);
    assert_eq!(geometry.mirrored(&pose), [false]);
}

#[test]
fn weights_are_scaled_to_one_and_bad_ones_dropped() {
    let weights = [
        [0.25, 0.25, 0., 0.],
        [0., 3., 0., 0.],
        [f32::NAN, 1., 0., 0.],
        [-1., 0.5, 0., 0.],
        [f32::INFINITY, 1., 0., 0.],
    ];
    let (scene, pose) = bent(primitive(&[[1.0, 1.0, 0.0]; 5]), &weights);
    let (_, deformed) = deform(&scene, &pose);
    assert_near(deformed.positions[0], [0.5, 1.5, 0.0]);
    for position in &deformed.positions[1..] {
        assert_near(*position, [0.0, 2.0, 0.0]);
    }
}

#[test]
fn without_weight_a_vertex_follows_its_first_joint() {
    let (mut scene, pose) = bent(primitive(&[[1.0, 1.0, 0.0]; 3]), &[[0.0; 4]; 3]);
    scene.meshes[0].primitives[0].joints[0] = vec![[1, 0, 0, 0], [0, 1, 0, 0], [9, 0, 0, 0]];
    let (_, deformed) = deform(&scene, &pose);
    assert_near(deformed.positions[0], [0.0, 2.0, 0.0]);
    assert_near(deformed.positions[1], [1.0, 1.0, 0.0]);
    // Its first joint does not exist: the node moves it.
    assert_near(deformed.positions[2], [101.0, 51.0, 0.0]);
}

#[test]
fn all_sets_of_joints_count() {
    let (mut scene, pose) = bent(primitive(&[[1.0, 1.0, 0.0]; 3]), &[[0.25, 0.0, 0.0, 0.0]; 3]);
    let body = &mut scene.meshes[0].primitives[0];
    body.joints.push(vec![[1, 1, 0, 0]; 3]);
    body.weights.push(vec![[0.25, 0.25, 0.25, 0.0]; 3]);
    let (geometry, deformed) = deform(&scene, &pose);
    assert_near(deformed.positions[0], [0.5, 1.5, 0.0]);
    // Each joint once, though it is named several times.
    assert_eq!(geometry.influence_offsets, [0, 2, 4, 6]);
}

#[test]
fn morphs_come_before_the_skin() {
    let mut body = primitive(&[[1.0, 1.0, 0.0]; 3]);
    body.targets = vec![
        MorphTarget {
            positions: Some(vec![Vec3::new(0.0, 2.0, 0.0); 3]),
            normals: Some(vec![Vec3::X; 3]),
            tangents: None,
        },
        MorphTarget { positions: None, normals: Some(vec![-Vec3::Z; 3]), tangents: None },
    ];
    let (scene, mut pose) = bent(body, &[[0., 1., 0., 0.]; 3]);
    pose.weights[2] = vec![0.5, 1.0];
    let (_, deformed) = deform(&scene, &pose);
    // At rest (1, 1, 0), morphed (1, 2, 0), relative to the upper joint (1, 1, 0), turned (-1, 1, 0).
    assert_near(deformed.positions[0], [-1.0, 2.0, 0.0]);
    assert_near(deformed.normals[0], [0.0, 1.0, 0.0]);
}

#[test]
fn a_mirrored_body_keeps_its_normals_outward() {
    let scale = Transform { scale: DVec3::new(-2.0, 1.0, 1.0), ..Transform::IDENTITY };
    let mut scene = scene_of(vec![node(None, Local::Trs(scale))]);
    let mut body = primitive(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    body.normals = Some(vec![Vec3::ONE.normalize(); 3]);
    hang(&mut scene, 0, body);
    let pose = Pose::rest(&scene);
    let (geometry, deformed) = deform(&scene, &pose);
    assert_near(deformed.positions[0], [-2.0, 0.0, 0.0]);
    assert!(deformed.normals[0].distance(DVec3::new(-0.5, 1.0, 1.0).normalize()) < 1e-7);
    assert_eq!(geometry.mirrored(&pose), [true]);
    let [a, b, c] = geometry.oriented_triangles(&pose)[0].map(|index| deformed.positions[index as usize]);
    assert!((b - a).cross(c - a).dot(deformed.normals[0]) > 0.0);

    scene.meshes[0].primitives[0].normals = None;
    let (flat, flat_deformed) = deform(&scene, &pose);
    assert!(flat.instances[0].flat_normals);
    assert!(flat_deformed.normals[0].distance(deformed.normals[0]) < 1e-7);
}

#[test]
fn flat_normals_are_those_of_the_deformed_triangle() {
    let mut body =
        primitive(&[[0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, -1.0], [0., 2., 0.], [1., 2., 0.], [0., 2., -1.]]);
    body.normals = None;
    let mut target = vec![Vec3::ZERO; 6];
    target[5] = Vec3::new(0.0, 1.0, 1.0);
    body.targets = vec![MorphTarget { positions: Some(target), normals: Some(vec![Vec3::X; 6]), tangents: None }];
    let (scene, mut pose) = bent(body, &[[0., 1., 0., 0.]; 6]);
    pose.weights[2] = vec![1.0];
    let (geometry, deformed) = deform(&scene, &pose);
    for vertex in 0..3 {
        assert_near(deformed.normals[vertex], [-1.0, 0.0, 0.0]);
        assert_near(deformed.normals[3 + vertex], [0.0, 0.0, 1.0]);
        assert_eq!(geometry.vertices[vertex].corner, vertex as u32 + 1);
    }
}

#[test]
fn shared_vertices_are_split_for_flat_normals() {
    let mut body = primitive(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    body.normals = None;
    body.triangles = vec![[0, 1, 2], [9, 1, 2], [0, 3, 1]];
    let mut scene = scene_of(vec![node(None, translated(0.0, 0.0, 0.0))]);
    hang(&mut scene, 0, body);
    let (geometry, deformed) = deform(&scene, &Pose::rest(&scene));
    assert_eq!(geometry.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_near(deformed.normals[0], [0.0, 0.0, 1.0]);
    assert_near(deformed.normals[3], [0.0, 1.0, 0.0]);
}

#[test]
fn a_collapsed_body_has_a_normal_or_none_but_never_a_wrong_one() {
    let cases = [(DVec3::ZERO, 0.0), (DVec3::Z, 0.0), (DVec3::new(1.0, 1.0, 0.0), 1.0)];
    for (scale, length) in cases {
        let mut scene = scene_of(vec![node(None, Local::Trs(Transform { scale, ..Transform::IDENTITY }))]);
        hang(&mut scene, 0, primitive(&[[1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [1.0, 3.0, 3.0]]));
        for flat in [false, true] {
            if flat {
                scene.meshes[0].primitives[0].normals = None;
            }
            let (_, deformed) = deform(&scene, &Pose::rest(&scene));
            for normal in deformed.normals {
                assert_near(normal, [0.0, 0.0, length]);
            }
        }
    }
}

//! Skins blended as dual quaternions.

use glam::{DQuat, DVec3, Vec3};
use murano_scene::{Local, Primitive, Scene, Skinning, Transform};

use super::{bind, corpus, deform, hang, node, packed, primitive, scene_of, translated};
use crate::Pose;

/// A ring of vertices halfway between two joints on the y axis, of which the upper twists.
fn twisted(degrees: f64, skinning: Skinning) -> Vec<DVec3> {
    let mut scene = scene_of(vec![
        node(None, translated(0.0, 0.0, 0.0)),
        node(Some(0), translated(0.0, 2.0, 0.0)),
        node(None, translated(0.0, 0.0, 0.0)),
    ]);
    let ring: Vec<[f32; 3]> = (0..12).map(|k| [f32::cos(k as f32), 1.0, f32::sin(k as f32)]).collect();
    let body = Primitive {
        joints: vec![vec![[0, 1, 0, 0]; ring.len()]],
        weights: vec![vec![[0.5, 0.5, 0.0, 0.0]; ring.len()]],
        ..primitive(&ring)
    };
    hang(&mut scene, 2, body);
    bind(&mut scene, 2, vec![0, 1]);
    scene.skinning = skinning;
    let Local::Trs(upper) = scene.nodes[1].local else { unreachable!() };
    let rotation = DQuat::from_rotation_y(degrees.to_radians());
    scene.nodes[1].local = Local::Trs(Transform { rotation, ..upper });
    deform(&scene, &Pose::rest(&scene)).1.positions
}

#[test]
fn a_twist_keeps_its_radius() {
    let radius = |points: &[DVec3]| points.iter().map(|p| p.x.hypot(p.z)).fold(f64::INFINITY, f64::min);
    for degrees in [30.0, 90.0, 170.0] {
        let dual = twisted(degrees, Skinning::DualQuaternion);
        assert!((radius(&dual) - 1.0).abs() < 1e-6 && dual.iter().all(|p| (p.y - 1.0).abs() < 1e-6), "{degrees}");
        let linear = twisted(degrees, Skinning::Linear);
        assert!((radius(&linear) - (0.5 * f64::to_radians(degrees)).cos()).abs() < 1e-6, "a mean of matrices shrinks");
    }
}

#[test]
fn where_all_joints_agree_both_are_the_same() {
    let dual = twisted(0.0, Skinning::DualQuaternion);
    let off = dual.iter().zip(twisted(0.0, Skinning::Linear)).map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
    assert!(off < 1e-12, "{off}");
}

/// The posed box holds every vertex, and is no more than `slack` times as large.
fn assert_bounded(scene: &Scene, pose: &Pose, slack: f64, what: &str) {
    let (geometry, truth) = deform(scene, pose);
    let posed = geometry.posed_instance_bounds(pose);
    for (bounds, instance) in posed.iter().zip(&geometry.instances) {
        let range = instance.vertices.start as usize..instance.vertices.end as usize;
        let out = truth.positions[range].iter().find(|position| !bounds.contains(**position));
        assert_eq!(out, None, "{what}: not in {bounds:?}");
    }
    let (all, tight) = (geometry.posed_bounds(pose).diameter(), truth.bounds().diameter());
    assert!(all <= slack * tight, "{what}: {all} for {tight}");
}

#[test]
fn posed_bounds_hold_the_body() {
    for world in [DVec3::ZERO, DVec3::new(1e6, -2e6, 3e6)] {
        let (mut scene, pose) = packed::crowd(world, Vec3::new(0.0, 5.0, -2.0));
        scene.skinning = Skinning::DualQuaternion;
        assert_bounded(&scene, &pose, 6.0, "a cloud of all kinds of scale");
    }
    let Some(folder) = corpus::models() else { return };
    for file in ["gltf/Fox.glb", "gltf/CesiumMan.glb", "gltf/RiggedFigure.glb", "paper/bunny_69k.glb"] {
        let mut scene = corpus::load(&folder, file);
        scene.skinning = Skinning::DualQuaternion;
        for (when, [pose, _]) in corpus::poses(&scene).step_by(4) {
            assert_bounded(&scene, &pose, 1.7, &format!("{file}, {when}"));
        }
    }
}

#[test]
fn posed_bounds_hold_what_many_joints_move() {
    let joints = 24;
    let mut scene = scene_of((0..=joints).map(|k| node(None, translated(0.1 * f64::from(k), 0.0, 0.0))).collect());
    let points: Vec<[f32; 3]> =
        (0..30).map(|k| [0.1 * k as f32, f32::sin(2.0 * k as f32), f32::cos(3.0 * k as f32)]).collect();
    let sets = 0..joints as u16 / 4;
    let body = Primitive {
        joints: sets.clone().map(|set| vec![[0, 1, 2, 3].map(|joint| 4 * set + joint); points.len()]).collect(),
        weights: sets
            .map(|set| (0..30).map(|k| [1, 2, 3, 4].map(|w| ((w * k + set) % 7 + 1) as f32)).collect())
            .collect(),
        ..primitive(&points)
    };
    hang(&mut scene, joints as usize, body);
    bind(&mut scene, joints as usize, (0..joints as usize).collect());
    scene.skinning = Skinning::DualQuaternion;
    for degrees in [0.0, 40.0, 120.0] {
        for joint in 0..joints {
            let Local::Trs(own) = &mut scene.nodes[joint as usize].local else { unreachable!() };
            own.rotation = DQuat::from_rotation_z((degrees * f64::from(joint % 5) / 5.0).to_radians());
            own.scale = DVec3::new(1.0, 1.0 + 0.05 * f64::from(joint % 3), 1.0);
        }
        assert_bounded(&scene, &Pose::rest(&scene), 20.0, &format!("{degrees} degrees"));
    }
}

#[test]
fn a_rigid_crowd_is_the_same_either_way() {
    let (mut scene, _) = packed::crowd(DVec3::ZERO, Vec3::ZERO);
    scene.meshes[1].primitives[0].weights[0].iter_mut().for_each(|weights| *weights = [0.0, 1.0, 0.0, 0.0]);
    let pose = Pose::rest(&scene);
    let linear = deform(&scene, &pose).1;
    scene.skinning = Skinning::DualQuaternion;
    let dual = deform(&scene, &pose).1;
    for (a, b) in linear.positions.iter().zip(&dual.positions) {
        assert!(a.distance(*b) < 1e-10, "{a} {b}");
    }
    for (a, b) in linear.normals.iter().zip(&dual.normals) {
        assert!(a.distance(*b) < 1e-9, "{a} {b}");
    }
}

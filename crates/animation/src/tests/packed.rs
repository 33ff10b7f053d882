//! The arrays that go to the GPU: their layout, and that they say the same as the truth.

use std::mem::{offset_of, size_of};

use glam::{DMat4, DQuat, DVec3, Vec3};
use murano_scene::{Local, MorphTarget, Primitive, Scene, Transform};

use super::{bind, deform, deform_packed, hang, node, primitive, scene_of, translated};
use crate::{Geometry, GeometryError, Influence, Pose, RestVertex, shown_primitives};

/// A deterministic number in 0..1 for an index and a lane.
fn noise(index: usize, lane: usize) -> f32 {
    let mixed = ((index * 8 + lane) as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as f32 / (1u32 << 24) as f32
}

/// A cloud of triangles of about a metre, modelled away from its origin, with two targets and four joints.
fn cloud(offset: Vec3) -> Primitive {
    let count = 300;
    let point = |index: usize| offset + Vec3::new(noise(index, 0), noise(index, 1), noise(index, 2));
    let mut body = primitive(&(0..count).map(|index| point(index).to_array()).collect::<Vec<_>>());
    let displacement =
        |index: usize| if index.is_multiple_of(3) { Vec3::ZERO } else { Vec3::splat(noise(index, 3) - 0.3) };
    body.targets = [1.0, -0.5]
        .map(|factor| MorphTarget {
            positions: Some((0..count).map(|index| factor * displacement(index)).collect()),
            ..MorphTarget::default()
        })
        .into();
    body.joints = vec![vec![[0, 1, 2, 3]; count]];
    body.weights = vec![(0..count).map(|index| [4, 5, 6, 7].map(|lane| noise(index, lane))).collect()];
    body
}

/// The cloud on four joints with all kinds of scale, and once more rigid, far from the world's origin.
pub(super) fn crowd(world: DVec3, offset: Vec3) -> (Scene, Pose) {
    let scales = [DVec3::ONE, DVec3::new(1.5, 0.5, 1.0), DVec3::new(-1.0, 1.0, 1.0), DVec3::splat(0.8)];
    let mut nodes = vec![node(None, translated(world.x, world.y, world.z))];
    nodes.extend((0..4).map(|joint| node(Some(joint), translated(0.0, 0.3, 0.0))));
    nodes.push(node(Some(0), Local::Trs(Transform { scale: DVec3::new(1.0, -2.0, 1.0), ..Transform::IDENTITY })));
    nodes.push(node(None, Local::Trs(Transform::IDENTITY)));
    let mut scene = scene_of(nodes);
    hang(&mut scene, 5, Primitive { joints: Vec::new(), weights: Vec::new(), ..cloud(offset) });
    hang(&mut scene, 6, cloud(offset));
    bind(&mut scene, 6, vec![1, 2, 3, 4]);
    // Bound where the mesh is, not where the world is.
    for inverse in &mut scene.skins[0].inverse_bind {
        *inverse *= DMat4::from_translation(world - offset.as_dvec3());
    }
    for (joint, scale) in scales.into_iter().enumerate() {
        let Local::Trs(own) = &mut scene.nodes[joint + 1].local else { unreachable!() };
        *own = Transform { rotation: DQuat::from_rotation_x(0.4 * joint as f64), scale, ..*own };
    }
    let mut pose = Pose::rest(&scene);
    pose.weights[5] = vec![0.7, -0.4];
    pose.weights[6] = vec![-0.3, 1.2];
    (scene, pose)
}

#[test]
fn records_are_laid_out_as_wgsl_reads_them() {
    assert_eq!(
        (size_of::<RestVertex>(), offset_of!(RestVertex, instance), offset_of!(RestVertex, normal)),
        (32, 12, 16)
    );
    assert_eq!(offset_of!(RestVertex, corner), 28);
    assert_eq!((size_of::<Influence>(), offset_of!(Influence, weight)), (8, 4));
}

#[test]
fn packed_arrays_agree_with_the_truth_wherever_the_body_is() {
    for world in [DVec3::ZERO, DVec3::new(1e6, -2e6, 3e6)] {
        for offset in [Vec3::ZERO, Vec3::new(0.0, 500.0, -2000.0)] {
            let (scene, pose) = crowd(world, offset);
            let (geometry, truth) = deform(&scene, &pose);
            for instance in &geometry.instances {
                let range = instance.vertices.start as usize..instance.vertices.end as usize;
                let truth = &truth.positions[range.clone()];
                let bounds = crate::Bounds::of(truth.iter().copied());
                let packed = deform_packed(&geometry, &pose, bounds.center());
                let worst = truth.iter().zip(&packed[range]).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
                assert!(worst < 5e-7 * bounds.diameter(), "{world} {offset}: {} of {}", worst, bounds.diameter());
            }
        }
    }
}

#[test]
fn posed_bounds_hold_the_body_and_little_else() {
    for world in [DVec3::ZERO, DVec3::new(1e6, -2e6, 3e6)] {
        let (scene, pose) = crowd(world, Vec3::new(0.0, 500.0, -2000.0));
        let (geometry, truth) = deform(&scene, &pose);
        let posed = geometry.posed_instance_bounds(&pose);
        for (bounds, instance) in posed.iter().zip(&geometry.instances) {
            let range = instance.vertices.start as usize..instance.vertices.end as usize;
            assert!(truth.positions[range].iter().all(|&position| bounds.contains(position)));
        }
        let all = geometry.posed_bounds(&pose);
        assert!(truth.positions.iter().all(|&position| all.contains(position)));
        assert!(all.diameter() < 3.0 * truth.bounds().diameter(), "{} {}", all.diameter(), truth.bounds().diameter());
    }
}

#[test]
fn instances_partition_the_arrays() {
    let (scene, pose) = crowd(DVec3::ZERO, Vec3::ZERO);
    let geometry = Geometry::build(&scene, &shown_primitives(&scene)).unwrap();
    let [rigid, skinned] = &geometry.instances[..] else { panic!("two instances") };
    assert_eq!((rigid.vertices.clone(), skinned.vertices.clone()), (0..300, 300..600));
    assert_eq!((rigid.palette.clone(), skinned.palette.clone()), (0..1, 1..5));
    assert_eq!((rigid.targets, skinned.targets), (2, 2));
    assert_eq!((rigid.morph_words, skinned.morph_words), (0, 76));
    assert_eq!(3 * geometry.palette_len(), geometry.palette(&pose, DVec3::ZERO).len());
    // Every third vertex stays where it is.
    assert_eq!(geometry.displacements.len(), 4 * 200);
    assert!(geometry.displacements.iter().all(|displacement| displacement[..3] != [0.0; 3]));
    let last = geometry.vertices.last().unwrap();
    assert_eq!((last.instance, geometry.triangle_instances.last()), (1, Some(&1)));
    assert!(geometry.triangles[100..].iter().flatten().all(|index| skinned.vertices.contains(index)));
    let total = |vertex: usize| {
        let span = geometry.influence_offsets[vertex] as usize..geometry.influence_offsets[vertex + 1] as usize;
        geometry.influences[span].iter().map(|influence| influence.weight).sum::<f32>()
    };
    assert!((0..600).all(|vertex| (total(vertex) - 1.0).abs() < 1e-6));
}

#[test]
fn joints_too_light_to_be_a_number_are_left_out() {
    let mut scene = scene_of(vec![node(None, Local::default()), node(None, Local::default())]);
    let mut skinned = primitive(&[[0.0; 3]; 3]);
    skinned.joints = vec![vec![[0, 1, 0, 0]; 3]];
    skinned.weights = vec![vec![[1e-30, 1e30, 0.0, 0.0], [1e30, 1e-30, 0.0, 0.0], [1e-40, 1e-40, 0.0, 0.0]]];
    hang(&mut scene, 0, skinned);
    bind(&mut scene, 0, vec![0, 1]);
    let geometry = Geometry::build(&scene, &shown_primitives(&scene)).unwrap();
    let influence = |entry: u32, weight: f32| Influence { entry, weight };
    let expected = [influence(0, 1.0), influence(1, 1.0), influence(1, 0.5), influence(0, 0.5)];
    assert_eq!(geometry.influences, expected);
    assert_eq!(geometry.influence_offsets, [0, 1, 2, 4]);
}

#[test]
fn targets_at_weight_0_are_left_out() {
    let (scene, mut pose) = crowd(DVec3::ZERO, Vec3::ZERO);
    let geometry = Geometry::build(&scene, &shown_primitives(&scene)).unwrap();
    let active = |pose: &Pose| {
        let (mut targets, mut ranges) = (Vec::new(), Vec::new());
        geometry.push_active_targets(pose, &mut targets, &mut ranges);
        let ranges: Vec<_> = ranges.iter().map(|range| (range.vertex, range.start, range.end)).collect();
        (targets.iter().map(|target| (target.word, target.weight)).collect::<Vec<_>>(), ranges)
    };
    let all = vec![(0, 0.7), (1, -0.4), (76, -0.3), (77, 1.2)];
    assert_eq!(active(&pose), (all, vec![(0, 0, 2), (300, 2, 4)]));
    pose.weights[5] = vec![0.0, 0.5];
    pose.weights[6] = vec![0.0, 0.0];
    assert_eq!(active(&pose), (vec![(1, 0.5)], vec![(0, 0, 1), (300, 1, 1)]));
}

#[test]
fn a_joint_without_vertices_is_not_in_the_palette() {
    let (mut scene, pose) = crowd(DVec3::ZERO, Vec3::ZERO);
    for weights in &mut scene.meshes[1].primitives[0].weights[0] {
        weights[2] = 0.0;
    }
    let (geometry, _) = deform(&scene, &pose);
    assert_eq!(geometry.palette_len(), 4);
}

#[test]
fn what_is_not_there_is_an_error_and_nothing_is_fine() {
    let (scene, pose) = crowd(DVec3::ZERO, Vec3::ZERO);
    for (node, primitive) in [(0, 0), (5, 1), (99, 0)] {
        let error = Geometry::build(&scene, &[(node, primitive)]).unwrap_err();
        assert_eq!(error, GeometryError::NoSuchPrimitive { node, primitive, nodes: 7 });
    }
    let nothing = Geometry::build(&scene, &[]).unwrap();
    assert_eq!((nothing.influence_offsets.as_slice(), nothing.palette_len()), (&[0][..], 0));
    assert!(nothing.posed_bounds(&pose).is_empty());
    assert_eq!(nothing.posed_bounds(&pose).diameter(), 0.0);
}

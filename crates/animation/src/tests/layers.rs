//! Layers of clips, and that a rig poses as f64 does.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use murano_scene::{
    Channel, Clip, Interpolation, Local, Material, MaterialProperty, Path, Property, PropertyChannel, Sampler, Scene,
    Transform,
};

use super::{hang, node, primitive, scene_of, translated};
use crate::{Blend, Layer, Pose, Properties, Rig};

/// Numbers in -1..1 that depend on an index.
fn noise(index: usize) -> f32 {
    let mixed = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed ^ (mixed >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as f32 / (1u32 << 23) as f32 - 1.0
}

fn sampler(interpolation: Interpolation, width: usize, keys: usize, seed: usize) -> Sampler {
    let rows = if interpolation == Interpolation::CubicSpline { 3 * keys } else { keys };
    let values = (0..rows * width).map(|index| noise(1000 * seed + index)).collect();
    Sampler { interpolation, times: (0..keys).map(|key| 0.1 + 0.3 * key as f32).collect(), width, values }
}

/// A chain of five nodes with two targets on the last, and three clips of every interpolation; the third drives few nodes.
fn chain() -> Scene {
    let mut scene = scene_of((0..5usize).map(|k| node(k.checked_sub(1), translated(0.1, 0.5, 0.0))).collect());
    hang(&mut scene, 4, primitive(&[[0.0; 3]; 3]));
    scene.nodes[4].weights = vec![0.25, -0.5];
    let kinds = [Interpolation::Linear, Interpolation::Step, Interpolation::CubicSpline];
    for clip in 0..3 {
        let mut channels = Vec::new();
        for (k, path) in [Path::Translation, Path::Rotation, Path::Scale, Path::Weights].into_iter().enumerate() {
            let nodes = if path == Path::Weights {
                4..5
            } else if clip == 2 {
                1..3
            } else {
                0..5
            };
            for driven in nodes {
                let kind = kinds[(clip + k + driven) % 3];
                let width = [3, 4, 3, 2][k];
                channels.push(Channel {
                    node: driven,
                    path,
                    sampler: sampler(kind, width, 2 + clip, 7 * driven + k + 50 * clip),
                });
            }
        }
        let single = sampler(Interpolation::Linear, 1, 3, 900 + clip);
        let properties = vec![PropertyChannel { property: Property::Weight(4, 1), sampler: single }];
        scene.clips.push(Clip { name: clip.to_string(), channels, properties, duration: 1.0 });
    }
    scene
}

fn farthest(a: &Pose, b: &Pose) -> f64 {
    let matrices = a.world_from_node.iter().zip(&b.world_from_node).map(|(a, b)| (*a - *b).to_cols_array());
    let weights = a.weights.iter().flatten().zip(b.weights.iter().flatten()).map(|(a, b)| (a - b).abs());
    matrices.flatten().map(f64::abs).chain(weights).fold(0.0, f64::max)
}

#[test]
fn a_rig_poses_as_f64_does() {
    let scene = chain();
    let rig = Rig::new(&scene);
    let mask: Arc<[f32]> = [0.0, 1.0, 0.5, 1.0].into();
    let mut worst = 0.0f64;
    for step in 0..40 {
        let time = 0.03 * f64::from(step);
        let over = |clip: usize, weight: f64| Layer { weight, ..Layer::new(clip, time) };
        let added = |clip: usize, weight: f64| Layer { blend: Blend::Add, ..over(clip, weight) };
        let cases = [
            vec![],
            vec![over(0, 1.0)],
            vec![over(1, 1.0)],
            vec![over(2, 1.0)],
            vec![over(0, 0.3)],
            vec![over(0, 1.0), over(1, 0.4)],
            vec![over(0, 1.0), Layer { mask: Some(mask.clone()), ..over(1, 0.9) }, over(2, 0.2)],
            vec![over(0, 1.0), added(2, 0.5)],
            vec![over(1, 0.5), added(0, 1.0), over(2, 0.5), Layer { mask: Some(mask.clone()), ..added(1, -0.7) }],
            Layer::mean(&[(0, time, 2.0), (1, time, 1.0), (2, 0.5, 3.0), (1, 0.0, -1.0)]),
            vec![over(9, 1.0), over(0, 1.0)],
        ];
        for (number, playing) in cases.iter().enumerate() {
            let (found, truth) = (rig.pose(playing), Pose::sample(&scene, playing));
            let off = farthest(&found, &truth);
            let size =
                truth.world_from_node.iter().flat_map(glam::DMat4::to_cols_array).fold(1.0, |a: f64, b| a.max(b.abs()));
            assert!(off <= 3e-6 * size, "case {number} at {time}: {off:e} of {size}");
            worst = worst.max(off / size);
        }
    }
    assert!(worst > 0.0);
    eprintln!("f32 curves are within {worst:.1e} of f64");
}

#[test]
fn the_size_of_a_rotation_does_not_matter() {
    let clips = |size: f32| {
        let mut scene = chain();
        let samplers = scene.clips.iter_mut().flat_map(|clip| &mut clip.channels);
        for channel in samplers.filter(|channel| channel.path == Path::Rotation) {
            channel.sampler.values.iter_mut().for_each(|value| *value *= size);
        }
        scene
    };
    for size in [1e-25, 1e-30, 1e25] {
        let scene = clips(size);
        let rig = Rig::new(&scene);
        for (clip, time) in (0..3).flat_map(|clip| [0.1, 0.25, 0.9].map(|time| (clip, time))) {
            let playing = [Layer::new(clip, time)];
            let off = farthest(&rig.pose(&playing), &Pose::sample(&scene, &playing));
            assert!(off <= 1e-5, "clip {clip} at {time}, times {size}: {off:e}");
        }
    }
}

#[test]
fn the_rest_pose_keeps_its_precision() {
    let mut scene = chain();
    scene.nodes[0].local = translated(1e6 + 1e-4, 0.0, 0.0);
    scene.clips[2].channels.retain(|channel| channel.path == Path::Weights);
    let rig = Rig::new(&scene);
    assert_eq!(rig.pose(&[]), Pose::rest(&scene));
    assert_eq!(rig.pose(&[Layer::new(2, 0.5)]).world_from_node, Pose::rest(&scene).world_from_node);
}

#[test]
fn the_mean_of_clips_is_weighted_and_full_weight_hides_what_is_below() {
    let scene = chain();
    let at = |layers: &[Layer]| Pose::sample(&scene, layers);
    let alone = at(&[Layer::new(1, 0.5)]);
    assert_eq!(at(&[Layer::new(0, 0.2), Layer::new(1, 0.5)]), alone);
    assert_eq!(at(&Layer::mean(&[(1, 0.5, 7.0)])), alone);
    assert_eq!(at(&Layer::mean(&[])), Pose::rest(&scene));

    let [a, b, c] = [0, 1, 2].map(|clip| at(&[Layer::new(clip, 0.5)]).weights[4][0]);
    let mean = at(&Layer::mean(&[(0, 0.5, 1.0), (1, 0.5, 2.0), (2, 0.5, 1.0)])).weights[4][0];
    assert!((mean - (a + 2.0 * b + c) / 4.0).abs() < 1e-12);
}

/// Two nodes, the second on the first, with a clip that turns both about +Z from 0 to 60 degrees and moves and doubles the second.
fn turning() -> Scene {
    let mut scene = scene_of(vec![node(None, translated(0.0, 0.0, 0.0)), node(Some(0), translated(0.0, 1.0, 0.0))]);
    let curve = |width: usize, values: Vec<f32>| Sampler {
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        width,
        values,
    };
    let half = 30.0f32.to_radians();
    let turn = || curve(4, vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half.sin(), half.cos()]);
    scene.clips.push(Clip {
        name: "turn".into(),
        channels: vec![
            Channel { node: 0, path: Path::Rotation, sampler: turn() },
            Channel { node: 1, path: Path::Rotation, sampler: turn() },
            Channel { node: 1, path: Path::Translation, sampler: curve(3, vec![0.0, 1.0, 0.0, 0.0, 3.0, 0.0]) },
            Channel { node: 1, path: Path::Scale, sampler: curve(3, vec![1.0, 1.0, 1.0, 2.0, 2.0, 2.0]) },
        ],
        duration: 1.0,
        ..Clip::default()
    });
    scene
}

fn trs(pose: &Pose, node: usize) -> Transform {
    let Local::Trs(own) = pose.locals[node] else { panic!("no translation, rotation, scale") };
    own
}

#[test]
fn what_is_added_is_the_change_since_time_0() {
    let mut scene = turning();
    scene.nodes[1].local = Local::Trs(Transform {
        translation: DVec3::new(5.0, 0.0, 0.0),
        rotation: DQuat::from_rotation_x(0.5),
        scale: DVec3::new(3.0, 1.0, 1.0),
    });
    let added = Layer { blend: Blend::Add, ..Layer::new(0, 1.0) };
    for pose in [Pose::sample(&scene, std::slice::from_ref(&added)), Rig::new(&scene).pose(&[added])] {
        let own = trs(&pose, 1);
        assert!(own.translation.distance(DVec3::new(5.0, 2.0, 0.0)) < 1e-6);
        assert!(own.scale.distance(DVec3::new(6.0, 2.0, 2.0)) < 1e-6);
        let wanted = DQuat::from_rotation_x(0.5) * DQuat::from_rotation_z(60.0f64.to_radians());
        assert!(own.rotation.angle_between(wanted) < 1e-6);
    }
    let nothing = Layer { blend: Blend::Add, ..Layer::new(0, 0.0) };
    assert!(farthest(&Pose::sample(&scene, &[nothing]), &Pose::rest(&scene)) < 1e-12);
}

#[test]
fn a_mask_moves_its_nodes_alone() {
    let scene = turning();
    let masked = Layer { mask: Some([0.0, 1.0].into()), ..Layer::new(0, 1.0) };
    let pose = Pose::sample(&scene, std::slice::from_ref(&masked));
    assert_eq!(trs(&pose, 0), Transform::IDENTITY);
    assert_eq!(trs(&pose, 1).translation, DVec3::new(0.0, 3.0, 0.0));
    let short = Layer { mask: Some([1.0].into()), ..masked };
    assert_eq!(trs(&Pose::sample(&scene, &[short]), 1).translation, DVec3::new(0.0, 1.0, 0.0));
}

#[test]
fn a_cross_fade_goes_from_one_to_the_other() {
    let scene = turning();
    let angle = |weight: f64| {
        let playing = [Layer::new(0, 0.0), Layer { weight, ..Layer::new(0, 1.0) }];
        2.0 * trs(&Pose::sample(&scene, &playing), 0).rotation.z.asin().to_degrees()
    };
    let mut before = angle(0.0);
    assert_eq!(before, 0.0);
    for step in 1..=10 {
        let now = angle(0.1 * f64::from(step));
        assert!(now > before, "{before} {now}");
        before = now;
    }
    assert!((angle(0.5) - 30.0).abs() < 1e-5 && (angle(1.0) - 60.0).abs() < 1e-5);
}

/// A million metres away a node moves by its keys, not by what f32 leaves of its place; one that no clip drives does not move.
#[test]
fn far_away_nodes_keep_their_precision() {
    let mut scene = scene_of(vec![node(None, translated(0.0, 0.0, 0.0)), node(None, translated(1e6 + 0.1, 0.0, 0.0))]);
    let sampler = Sampler {
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        width: 3,
        values: vec![1e6, 0.0, 0.0, 1e6 + 1.0, 0.0, 0.0],
    };
    scene.clips.push(Clip {
        name: "go".into(),
        channels: vec![Channel { node: 0, path: Path::Translation, sampler }],
        duration: 1.0,
        ..Clip::default()
    });
    let rig = Rig::new(&scene);
    for step in 0..=100 {
        let share = f64::from(step) / 100.0;
        let place = |weight: f64| {
            let pose = rig.pose(&[Layer { weight, ..Layer::new(0, share) }]);
            [0, 1].map(|node: usize| pose.world_from_node[node].w_axis.x)
        };
        assert!((place(1.0)[0] - (1e6 + share)).abs() < 1e-9, "{share}");
        assert!((place(share)[1] - (1e6 + 0.1)).abs() < 1e-9, "{share}: {}", place(share)[1]);
    }
}

/// Keys half a turn apart about any axis: both ways round are as short, and rig and f64 take the same.
#[test]
fn half_turns_go_the_same_way_round() {
    for case in 0..2000 {
        let number = |lane: usize| f64::from(noise(4000 + 16 * case + lane));
        let from = DQuat::from_xyzw(number(0), number(1), number(2), number(3)).normalize();
        let axis = DVec3::new(number(4), number(5), number(6)).normalize();
        let to = DQuat::from_axis_angle(axis, std::f64::consts::PI) * from;
        let values = [from, to].iter().flat_map(|q| q.as_quat().to_array()).collect();
        let mut scene = scene_of(vec![node(None, translated(0.0, 0.0, 0.0))]);
        let sampler = Sampler { interpolation: Interpolation::Linear, times: vec![0.0, 1.0], width: 4, values };
        scene.clips.push(Clip {
            name: "turn".into(),
            channels: vec![Channel { node: 0, path: Path::Rotation, sampler }],
            duration: 1.0,
            ..Clip::default()
        });
        let playing = [Layer::new(0, 0.5)];
        let off = farthest(&Rig::new(&scene).pose(&playing), &Pose::sample(&scene, &playing));
        assert!(off < 2e-6, "case {case}: {off}");
    }
}

/// No attenuation is an infinite distance: blended as its reciprocal, as absorption is.
#[test]
fn properties_that_may_be_infinite_are_blended() {
    let curve = |value: f32| Sampler {
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        width: 1,
        values: vec![value, value],
    };
    let driven = |property, value| Clip {
        properties: vec![PropertyChannel { property: Property::Material(0, property), sampler: curve(value) }],
        duration: 1.0,
        ..Clip::default()
    };
    let scene = Scene {
        materials: vec![Material::glass(1.5)],
        clips: vec![driven(MaterialProperty::AttenuationDistance, 2.0), driven(MaterialProperty::Ior, 1.75)],
        ..Scene::default()
    };
    let at = |layers: &[Layer]| Properties::sample(&scene, layers).materials[0].1.clone();
    let weighed = |weight: f64| at(&[Layer { weight, ..Layer::new(0, 0.5) }]).attenuation_distance;
    assert_eq!([0.0, 0.5, 1.0].map(weighed), [f32::INFINITY, 4.0, 2.0]);
    let both = at(&[Layer::new(0, 0.5), Layer { blend: Blend::Add, ..Layer::new(1, 0.5) }]);
    assert_eq!(both.attenuation_distance, 2.0);
    assert_eq!(at(&[Layer::new(0, 0.5), Layer { weight: 0.5, ..Layer::new(1, 0.5) }]).ior, 1.625);
    assert_eq!(weighed(f64::NAN), f32::INFINITY);
}

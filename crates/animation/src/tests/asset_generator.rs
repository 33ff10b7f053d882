//! What the descriptions of the Khronos glTF-Asset-Generator's animated models say of their motion, in closed form.
//!
//! Where a description and its model disagree the model counts, and a comment says so.

use glam::{DMat3, DQuat, DVec3};
use murano_scene::{Interpolation, Local, NodeIndex, Path, Scene};

use super::corpus::{load, models};
use crate::{Layer, Pose};

/// Rounding of the models' f32 numbers, metres.
const TOLERANCE: f64 = 1e-6;

/// The models of a group that are asked for, each with its name; none where there are no models.
fn group<const N: usize>(name: &str, numbers: [usize; N]) -> Option<[(String, Scene); N]> {
    let folder = models()?;
    Some(numbers.map(|number| {
        let label = format!("{name}_{number:02}");
        let scene = load(&folder, &format!("gltf/asset-generator/{name}/{label}.gltf"));
        (label, scene)
    }))
}

fn model(name: &str, number: usize) -> Option<(String, Scene)> {
    group(name, [number]).map(|[model]| model)
}

/// Rest positions, in mesh space, and deformed ones of what a node shows, with the first clip at a time or without any.
fn moved(scene: &Scene, node: NodeIndex, playing: &[Layer]) -> Vec<[DVec3; 2]> {
    let (geometry, deformed) = super::deform(scene, &Pose::sample(scene, playing));
    let instance = geometry.instances.iter().find(|instance| instance.node == node).expect("a node that is shown");
    let rest = &scene.meshes[instance.mesh].primitives[instance.primitive].positions;
    let range = instance.vertices.start as usize..instance.vertices.end as usize;
    assert_eq!(rest.len(), range.len());
    rest.iter().zip(&deformed.positions[range]).map(|(rest, &posed)| [rest.as_dvec3(), posed]).collect()
}

/// Every vertex of what a node shows is where a closed form says.
#[track_caller]
fn assert_moved(label: &str, scene: &Scene, node: NodeIndex, playing: &[Layer], expected: impl Fn(DVec3) -> DVec3) {
    for [rest, posed] in moved(scene, node, playing) {
        let expected = expected(rest);
        let times: Vec<f64> = playing.iter().map(|layer| layer.time).collect();
        assert!(posed.distance(expected) < TOLERANCE, "{label}, {times:?} s: {rest} is at {posed}, not at {expected}");
    }
}

fn about_x(degrees: f64) -> DMat3 {
    DMat3::from_rotation_x(degrees.to_radians())
}

fn about_y(degrees: f64) -> DMat3 {
    DMat3::from_rotation_y(degrees.to_radians())
}

/// The first clip at a time.
fn at(time: f64) -> [Layer; 1] {
    [Layer::new(0, time)]
}

/// The angle of the clips that turn from a quarter to a quarter back and home, a key a second from a start on; degrees.
fn turning(start: f64, time: f64) -> f64 {
    let key = (time - start).clamp(0.0, 4.0);
    if key < 2.0 { 90.0 - 90.0 * key } else { 90.0 * key - 270.0 }
}

/// The course of the clips that go from one place to another and back, with three keys in so many seconds.
fn to_and_fro(start: f64, duration: f64, time: f64) -> f64 {
    let share = ((time - start) / duration).clamp(0.0, 1.0);
    0.1 - 0.4 * (share - 0.5).abs()
}

#[test]
fn nodes_move_by_what_is_animated_between_keys_of_each_kind() {
    let Some(models) = group("Animation_Node", [0, 1, 2, 3, 4, 5]) else { return };
    let kinds = [
        (Path::Translation, Interpolation::Linear),
        (Path::Rotation, Interpolation::Linear),
        (Path::Scale, Interpolation::Linear),
        (Path::Translation, Interpolation::Step),
        (Path::Translation, Interpolation::CubicSpline),
        (Path::Rotation, Interpolation::CubicSpline),
    ];
    for ((label, scene), kind) in models.iter().zip(kinds) {
        let [clip] = &scene.clips[..] else { panic!("{label}: one animation") };
        let [channel] = &clip.channels[..] else { panic!("{label}: one channel") };
        assert_eq!((channel.path, channel.sampler.interpolation), kind, "{label}: target and interpolation");
    }
    let [translated, rotated, scaled, stepped, splined, turned_smoothly] = &models;
    for time in [0.0, 0.25, 0.5, 1.0, 1.75, 2.0] {
        let along_x = DVec3::X * to_and_fro(0.0, 2.0, time);
        assert_moved(&translated.0, &translated.1, 0, &at(time), |rest| rest + along_x);
        let size = 1.0 + 2.0 * to_and_fro(0.0, 2.0, time);
        assert_moved(&scaled.0, &scaled.1, 0, &at(time), |rest| rest * size);
    }
    for time in [0.0, 0.5, 1.0, 1.25, 2.0, 2.5, 3.0, 3.9, 4.0] {
        assert_moved(&rotated.0, &rotated.1, 0, &at(time), |rest| about_y(turning(0.0, time)) * rest);
        let step = DVec3::X * ([-0.1, 0.0, 0.1, 0.0, -0.1][time as usize]);
        assert_moved(&stepped.0, &stepped.1, 0, &at(time), |rest| rest + step);
    }
    // Hermite with tangents of zero, but for that of the middle key towards -Y.
    for (time, x, y) in
        [(0.0, -0.1, 0.0), (0.5, 0.0, 0.0), (1.0, 0.1, 0.0), (1.25, 0.06875, -0.0421875), (1.5, 0.0, -0.0375)]
    {
        assert_moved(&splined.0, &splined.1, 0, &at(time), |rest| rest + DVec3::new(x, y, 0.0));
    }
    // Quaternions by component, then to unit length.
    for time in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let share = time * time * (3.0 - 2.0 * time);
        let (sine, cosine) = 45.0f64.to_radians().sin_cos();
        let angle = 2.0 * ((1.0 - share) * sine).atan2((1.0 - share) * cosine + share).to_degrees();
        assert_moved(&turned_smoothly.0, &turned_smoothly.1, 0, &at(time), |rest| about_y(angle) * rest);
    }
}

#[test]
fn two_channels_move_a_node_together() {
    let Some((label, scene)) = model("Animation_NodeMisc", 0) else { return };
    let paths: Vec<Path> = scene.clips[0].channels.iter().map(|channel| channel.path).collect();
    assert_eq!(paths, [Path::Translation, Path::Rotation], "{label}");
    for channel in &scene.clips[0].channels {
        let times = &channel.sampler.times;
        assert_eq!((times.first(), times.last()), (Some(&0.0), Some(&4.0)), "{label}: start and end");
    }
    for time in [0.0, 0.5, 1.0, 2.0, 3.25, 4.0] {
        let along_x = DVec3::X * to_and_fro(0.0, 4.0, time);
        assert_moved(&label, &scene, 0, &at(time), |rest| about_y(turning(0.0, time)) * rest + along_x);
    }
}

#[test]
fn curves_start_and_end_when_they_say_and_hold_their_ends() {
    let Some([(late, late_scene), (staggered, staggered_scene)]) = group("Animation_NodeMisc", [1, 2]) else { return };
    assert_eq!(late_scene.clips[0].channels[0].sampler.times[0], 1.0, "{late}: start");
    assert_eq!((late_scene.clips[0].duration, staggered_scene.clips[0].duration), (5.0, 6.0));
    for time in [0.0, 0.5, 0.75, 1.0, 1.5, 3.5, 5.0, 7.0] {
        assert_moved(&late, &late_scene, 0, &at(time), |rest| about_y(turning(1.0, time)) * rest);
    }
    let spans = staggered_scene.clips[0].channels.iter().map(|channel| {
        let times = &channel.sampler.times;
        (channel.path, times[0], times[times.len() - 1])
    });
    assert!(spans.eq([(Path::Translation, 2.0, 6.0), (Path::Rotation, 1.0, 5.0)]), "{staggered}: starts and ends");
    for time in [0.0, 1.5, 2.0, 2.5, 4.0, 5.5, 6.0] {
        let along_y = DVec3::Y * to_and_fro(2.0, 4.0, time);
        assert_moved(&staggered, &staggered_scene, 0, &at(time), |rest| about_y(turning(1.0, time)) * rest + along_y);
    }
}

#[test]
fn one_key_holds_at_all_times() {
    let Some((label, scene)) = model("Animation_NodeMisc", 3) else { return };
    assert_eq!(scene.clips[0].channels[0].sampler.times.len(), 1, "{label}: one key");
    for time in [0.0, 0.5, 100.0] {
        assert_moved(&label, &scene, 0, &at(time), |rest| rest + DVec3::new(-0.1, 0.0, 0.0));
    }
}

/// The description has the left one turn about X and the right one about Y; in the model it is the other way round.
#[test]
fn channels_of_one_clip_move_different_nodes() {
    let Some((label, scene)) = model("Animation_NodeMisc", 4) else { return };
    for time in [0.0, 0.5, 1.75, 3.0] {
        let place = DVec3::X * 0.2;
        assert_moved(&label, &scene, 0, &at(time), |rest| about_y(turning(0.0, time)) * (rest * 0.5) - place);
        assert_moved(&label, &scene, 1, &at(time), |rest| about_x(turning(0.0, time)) * (rest * 0.5) + place);
    }
}

#[test]
fn a_channel_overrides_its_property_and_leaves_the_others() {
    let Some([(constant, constant_scene), (moving, moving_scene)]) = group("Animation_NodeMisc", [5, 6]) else {
        return;
    };
    for (label, scene) in [(&constant, &constant_scene), (&moving, &moving_scene)] {
        assert_moved(label, scene, 0, &[], |rest| about_y(60.0) * rest);
    }
    for time in [0.0, 1.0, 3.0] {
        assert_moved(&constant, &constant_scene, 0, &at(time), |rest| about_y(-60.0) * rest);
        let along_x = DVec3::X * to_and_fro(0.0, 4.0, time);
        assert_moved(&moving, &moving_scene, 0, &at(time), |rest| about_y(60.0) * rest + along_x);
    }
}

#[test]
fn two_animations_are_two_clips() {
    let Some((label, scene)) = model("Animation_NodeMisc", 7) else { return };
    assert_eq!(scene.clips.len(), 2, "{label}");
    for time in [0.0, 0.5, 1.0, 3.5] {
        assert_moved(&label, &scene, 0, &at(time), |rest| about_y(turning(0.0, time)) * rest);
        let along_x = DVec3::X * to_and_fro(0.0, 4.0, time);
        assert_moved(&label, &scene, 0, &[Layer::new(1, time)], |rest| rest + along_x);
    }
}

/// The description has the channel without a node turn about X and the other about Y; in the model it is the other way round.
#[test]
fn a_channel_without_a_node_moves_nothing() {
    let Some((label, scene)) = model("Animation_NodeMisc", 8) else { return };
    assert_eq!(scene.clips[0].channels.len(), 1, "{label}: what drives nothing is dropped");
    assert!(matches!(&scene.report.warnings[..], [warning] if warning.contains("no target node")), "{label}: and said");
    for time in [0.0, 0.5, 1.0, 2.25] {
        assert_moved(&label, &scene, 0, &at(time), |rest| about_x(turning(0.0, time)) * rest);
    }
}

#[test]
fn rotations_in_integers_turn_as_those_in_floats() {
    let Some(models) = group("Animation_SamplerType", [0, 1, 2]) else { return };
    for (label, scene) in &models {
        for time in [0.0, 0.5, 1.0, 1.25, 2.0, 3.5, 4.0] {
            assert_moved(label, scene, 0, &at(time), |rest| about_y(turning(0.0, time)) * rest);
        }
    }
}

/// The strip of `skinA`: it stands upright in XY, and its upper half is bent back from its middle by an angle in degrees.
fn bent(degrees: f64) -> impl Fn(DVec3) -> DVec3 {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    move |rest| {
        let upper = rest.z.max(0.0);
        DVec3::new(rest.x, rest.z.min(0.0) + upper * cosine, -upper * sine)
    }
}

#[test]
fn a_skin_bends_its_mesh_at_rest() {
    let Some([(plain, plain_scene), (placed, placed_scene), (root, root_scene)]) = group("Animation_Skin", [0, 2, 6])
    else {
        return;
    };
    assert_moved(&plain, &plain_scene, 0, &[], bent(30.0));

    // Neither the skinned node's own transform nor its parent's counts.
    assert!(placed_scene.nodes[1].local != Local::default(), "{placed}: the node is turned");
    assert!(placed_scene.nodes[0].local != Local::default(), "{placed}: and so is its parent");
    assert_eq!((placed_scene.nodes[1].skin, placed_scene.nodes[1].parent), (Some(0), Some(0)), "{placed}");
    assert_moved(&placed, &placed_scene, 1, &[], bent(30.0));

    let [joint0, joint1] = root_scene.skins[0].joints[..] else { panic!("{root}: two joints") };
    assert!([joint0, joint1].iter().all(|joint| root_scene.roots.contains(joint)), "{root}: both are roots");
    assert_moved(&root, &root_scene, 0, &[], bent(30.0));
}

#[test]
fn a_skin_without_inverse_bind_matrices_has_identities() {
    let Some((label, scene)) = model("Animation_Skin", 3) else { return };
    assert_eq!(scene.skins[0].inverse_bind, [glam::DMat4::IDENTITY; 2], "{label}");
    // `joint0` stands 0.2 below the origin; `joint1`, at the origin, is bound by an identity in the other models too.
    let lowered = |rest: DVec3| if rest.z < 0.0 { DVec3::Y * -0.2 } else { DVec3::ZERO };
    assert_moved(&label, &scene, 0, &[], |rest| bent(30.0)(rest) + lowered(rest));
}

/// From upright to 45 degrees back and upright again.
#[test]
fn a_turning_joint_bends_its_part_and_takes_along_what_hangs_on_it() {
    let Some([(alone, alone_scene), (laden, laden_scene)]) = group("Animation_Skin", [1, 4]) else { return };
    for (time, degrees) in [(0.0, 0.0), (0.5, 22.5), (1.0, 45.0), (1.5, 22.5), (2.0, 0.0)] {
        assert_moved(&alone, &alone_scene, 0, &at(time), bent(degrees));
        assert_moved(&laden, &laden_scene, 0, &at(time), bent(degrees));
        let joint1 = laden_scene.skins[0].joints[1];
        assert_eq!((laden_scene.nodes[3].parent, laden_scene.nodes[3].skin), (Some(joint1), None), "{laden}: triangle");
        assert_moved(&laden, &laden_scene, 3, &at(time), |rest| about_x(-90.0 - degrees) * rest);
    }
}

#[test]
fn two_meshes_share_a_skin() {
    let Some((label, scene)) = model("Animation_Skin", 5) else { return };
    assert_eq!((scene.skins.len(), scene.nodes[0].skin, scene.nodes[3].skin), (1, Some(0), Some(0)), "{label}");
    assert_ne!(scene.nodes[0].mesh, scene.nodes[3].mesh, "{label}: two meshes");
    for node in [0, 3] {
        assert_moved(&label, &scene, node, &[], bent(30.0));
    }
}

/// The prisms' upper ends are bound to the joint that turns about the vertical, 15 degrees to and fro.
#[test]
fn two_skins_share_a_joint() {
    let Some((label, scene)) = model("Animation_Skin", 7) else { return };
    assert_eq!(scene.skins.len(), 2, "{label}");
    assert_eq!((scene.nodes[0].skin, scene.nodes[3].skin), (Some(0), Some(1)), "{label}");
    let joint1 = scene.nodes.iter().position(|node| node.name == "joint1").expect("joint1");
    assert!(scene.skins.iter().all(|skin| skin.joints.contains(&joint1)), "{label}: both refer to joint1");
    let [channel] = &scene.clips[0].channels[..] else { panic!("{label}: one channel") };
    assert_eq!((channel.node, channel.path), (joint1, Path::Rotation), "{label}: it is what turns");
    for (time, degrees) in [(0.0, 0.0), (0.5, -7.5), (1.0, -15.0), (1.75, -3.75)] {
        for node in [0, 3] {
            assert_moved(&label, &scene, node, &at(time), |rest| {
                let turn: f64 = if rest.z < 0.0 { degrees } else { 0.0 };
                about_x(90.0) * (DMat3::from_rotation_z(turn.to_radians()) * rest)
            });
        }
    }
}

/// Rows of `skinC` lie on its joints, 0.2 from one to the next.
#[test]
fn a_chain_of_joints_curls() {
    let Some((label, scene)) = model("Animation_Skin", 8) else { return };
    let joints = &scene.skins[0].joints;
    assert_eq!(joints.len(), 5, "{label}");
    for (index, &joint) in joints.iter().enumerate() {
        let Local::Trs(own) = scene.nodes[joint].local else { panic!("{label}: no matrix") };
        let degrees: f64 = if index == 0 { -90.0 } else { -10.0 };
        assert!(own.rotation.abs_diff_eq(DQuat::from_rotation_x(degrees.to_radians()), 1e-6), "{label}: joint{index}");
    }
    assert_moved(&label, &scene, 0, &[], |rest| {
        let row = ((rest.z + 0.4) / 0.2).round() as usize;
        (0..row).fold(DVec3::new(rest.x, -0.4, 0.0), |place, joint| {
            let (sine, cosine) = (10.0 * joint as f64).to_radians().sin_cos();
            place + 0.2 * DVec3::new(0.0, cosine, -sine)
        })
    });
}

/// The description has every joint of `skinD` turn; in the model all do but the first.
#[test]
fn a_node_between_joints_that_is_none_passes_their_motion_on() {
    let Some((label, scene)) = model("Animation_Skin", 9) else { return };
    let named = |name: &str| scene.nodes.iter().position(|node| node.name == name).expect("a node of that name");
    let joints = ["joint0", "joint1", "joint2", "joint3"].map(named);
    let between = named("transformNode");
    assert_eq!(scene.skins[0].joints, joints, "{label}: the transform node is no joint");
    assert_eq!(scene.nodes[between].parent, Some(joints[2]), "{label}");
    assert_eq!(scene.nodes[joints[3]].parent, Some(between), "{label}");
    assert!(scene.nodes[between].mesh.is_some(), "{label}: a mesh shows where it is");
    let driven = scene.clips[0].channels.iter().map(|channel| (channel.node, channel.path));
    assert!(driven.eq(joints[1..].iter().map(|&joint| (joint, Path::Rotation))), "{label}: joints that turn");

    for (time, share) in [(0.0, 0.0), (0.5, 0.5), (1.0, 1.0), (1.75, 0.25)] {
        // Degrees by which what is above each joint leans forward; a unit along it; and where the joints are.
        let [first, second, third] = [-45.0 * share, 45.0 * share, 135.0 * share];
        let along = |degrees: f64| DVec3::new(0.0, degrees.to_radians().cos(), degrees.to_radians().sin());
        let joint1 = DVec3::new(0.0, -0.3, 0.0);
        let joint2 = joint1 + 0.2 * along(first);
        let transform_node = joint2 + 0.2 * along(second);
        let joint3 = transform_node + 0.2 * along(second);
        assert_moved(&label, &scene, 0, &at(time), |rest| {
            let x = DVec3::X * rest.x;
            match rest.z {
                z if z < -0.4 => x + DVec3::Y * z,
                z if z < -0.2 => x + joint1,
                z if z < 0.2 => x + joint2 + (z + 0.1) * along(second),
                z => x + joint3 + (z - 0.3) * along(third),
            }
        });
        assert_moved(&label, &scene, between, &at(time), |rest| transform_node + about_x(second - 90.0) * rest);
    }
}

/// `skinE` forks: both arms lean back 15 degrees, their upper halves 30. The description says no more than its picture.
#[test]
fn a_skeleton_may_fork() {
    let Some((label, scene)) = model("Animation_Skin", 10) else { return };
    let joints = &scene.skins[0].joints;
    assert_eq!(scene.nodes[joints[1]].children, joints[2..4], "{label}: two joints hang on one");
    assert_moved(&label, &scene, 0, &[], |rest| {
        let back = |length: f64, degrees: f64| {
            length * DVec3::new(0.0, degrees.to_radians().cos(), -degrees.to_radians().sin())
        };
        let x = DVec3::X * rest.x;
        if rest.z < 0.1 { x + DVec3::Y * rest.z } else { x + back(0.25, 15.0) + back(rest.z - 0.25, 30.0) }
    });
}

#[test]
fn a_mesh_is_shown_by_two_skins() {
    let Some((label, scene)) = model("Animation_Skin", 11) else { return };
    assert_eq!((scene.nodes[0].mesh, scene.nodes[3].mesh), (Some(0), Some(0)), "{label}: one mesh");
    assert_eq!((scene.nodes[0].skin, scene.nodes[3].skin), (Some(0), Some(1)), "{label}: two skins");
    assert_moved(&label, &scene, 0, &[], bent(30.0));
    assert_moved(&label, &scene, 3, &[], |rest| bent(30.0)(rest) + DVec3::X * 0.6);
}

/// "Byte" and "Short" are unsigned. All weights are 0 or 1, so nothing is lost.
#[test]
fn joints_and_weights_of_every_type_bend_alike() {
    let Some(models) = group("Animation_SkinType", [0, 1, 2, 3]) else { return };
    for (label, scene) in &models {
        let primitive = &scene.meshes[0].primitives[0];
        assert!(primitive.weights[0].iter().all(|weights| *weights == [1.0, 0.0, 0.0, 0.0]), "{label}: weights");
        let joints = primitive.positions.iter().map(|rest| [u16::from(rest.z > -0.1), 0, 0, 0]);
        assert!(joints.eq(primitive.joints[0].iter().copied()), "{label}: joints");
        for (time, degrees) in [(0.0, 0.0), (0.5, -45.0), (1.0, -90.0), (1.5, -45.0)] {
            assert_moved(label, scene, 0, &at(time), bent(degrees));
        }
    }
}

#[test]
fn what_is_shared_is_shown_apart() {
    let Some([(nodes, nodes_scene), (skin, skin_scene), (joints, joints_scene), (matrices, matrices_scene)]) =
        group("Instancing", [6, 7, 8, 9])
    else {
        return;
    };
    // Nodes of a mesh have their own translations.
    assert_moved(&nodes, &nodes_scene, 0, &[], |rest| rest - DVec3::X * 0.6);
    assert_moved(&nodes, &nodes_scene, 1, &[], |rest| rest + DVec3::X * 0.6);
    // Meshes of a skin have their own positions: one left of the middle, one right of it.
    for (node, side) in [(0, -1.0), (3, 1.0)] {
        assert_moved(&skin, &skin_scene, node, &[], bent(30.0));
        let apart = moved(&skin_scene, node, &[]).iter().all(|[_, posed]| side * posed.x > 0.0);
        assert!(apart, "{skin}: nodes[{node}] is on its side");
    }
    // Of two skins of the same joints the second folds twice as far.
    assert_moved(&joints, &joints_scene, 0, &[], bent(30.0));
    assert_moved(&joints, &joints_scene, 3, &[], bent(60.0));
    // Skins of the same matrices stand where their own joints do.
    assert_moved(&matrices, &matrices_scene, 0, &[], |rest| bent(30.0)(rest) - DVec3::X * 0.3);
    assert_moved(&matrices, &matrices_scene, 3, &[], |rest| bent(30.0)(rest) + DVec3::X * 0.3);
}

#[test]
fn shared_curves_move_each_node_by_itself() {
    let Some([(sampler, sampler_scene), (input, input_scene), (output, output_scene)]) =
        group("Instancing", [10, 11, 12])
    else {
        return;
    };
    let place = DVec3::X * 0.6;
    for time in [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0] {
        let angle = turning(0.0, time);
        for (label, scene) in [(&sampler, &sampler_scene), (&input, &input_scene), (&output, &output_scene)] {
            assert_moved(label, scene, 0, &at(time), |rest| about_x(angle) * rest - place);
        }
        // The same curve; the same times with other values; the same values at times of 0, 0.5, 1, 2 and 4 s.
        assert_moved(&sampler, &sampler_scene, 1, &at(time), |rest| about_x(angle) * rest + place);
        assert_moved(&input, &input_scene, 1, &at(time), |rest| about_x(-angle) * rest + place);
        let key = match time {
            time if time < 1.0 => 2.0 * time,
            time if time < 2.0 => time + 1.0,
            time => 2.0 + 0.5 * time,
        };
        assert_moved(&output, &output_scene, 1, &at(time), |rest| about_x(turning(0.0, key)) * rest + place);
    }
}

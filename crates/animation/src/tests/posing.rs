//! Clips laid over the rest pose, and world matrices.

use glam::{DMat4, DVec3};
use murano_scene::{Channel, Clip, Interpolation, Local, Path, Sampler};

use super::{assert_near, hang, node, primitive, quarter_turn, scene_of, translated};
use crate::{Layer, Pose};

fn channel(node: usize, path: Path, width: usize, times: &[f32], values: &[f32]) -> Channel {
    let sampler =
        Sampler { interpolation: Interpolation::Linear, times: times.to_vec(), width, values: values.to_vec() };
    Channel { node, path, sampler }
}

fn clip(channels: Vec<Channel>) -> Clip {
    Clip { name: "clip".into(), channels, duration: 1.0, ..Clip::default() }
}

#[test]
fn a_clip_changes_what_it_drives_and_nothing_else() {
    let mut scene = scene_of(vec![node(None, translated(1.0, 0.0, 0.0)), node(Some(0), translated(0.0, 1.0, 0.0))]);
    let half = 0.5f32.sqrt();
    scene.clips.push(clip(vec![channel(0, Path::Rotation, 4, &[0.0, 1.0], &[0., 0., 0., 1., 0., 0., half, half])]));
    scene.clips.push(clip(vec![channel(1, Path::Scale, 3, &[0.0], &[2.0, 2.0, 2.0])]));

    let turned = Pose::sample(&scene, &Layer::alone(Some(0), 1.0));
    assert!(turned.world_from_node[1].transform_point3(DVec3::ZERO).distance(DVec3::ZERO) < 1e-7);
    assert_eq!(turned.locals[1], translated(0.0, 1.0, 0.0));
    let scaled = Pose::sample(&scene, &Layer::alone(Some(1), 0.0));
    assert_near(scaled.world_from_node[1].transform_point3(DVec3::X), [3.0, 1.0, 0.0]);
    assert_eq!(Pose::sample(&scene, &Layer::alone(None, 1.0)), Pose::rest(&scene));
    assert_eq!(Pose::sample(&scene, &Layer::alone(Some(9), 1.0)), Pose::rest(&scene));
}

#[test]
fn weights_replace_those_of_the_rest_pose() {
    let mut scene = scene_of(vec![node(None, translated(0.0, 0.0, 0.0))]);
    hang(&mut scene, 0, primitive(&[[0.0; 3]; 3]));
    scene.nodes[0].weights = vec![0.25, 0.5];
    scene.clips.push(clip(vec![channel(0, Path::Weights, 2, &[0.0, 1.0], &[0.0, 1.0, 1.0, 0.0])]));
    assert_eq!(Pose::rest(&scene).weights[0], [0.25, 0.5]);
    assert_eq!(Pose::sample(&scene, &Layer::alone(Some(0), 0.25)).weights[0], [0.25, 0.75]);
}

#[test]
fn a_matrix_is_kept_with_its_shear_and_never_animated() {
    let mut shear = DMat4::IDENTITY;
    shear.y_axis.x = 0.5;
    let mut scene = scene_of(vec![node(None, Local::Matrix(shear)), node(Some(0), Local::Matrix(quarter_turn()))]);
    scene.clips.push(clip(vec![channel(0, Path::Translation, 3, &[0.0], &[9.0; 3])]));
    let pose = Pose::sample(&scene, &Layer::alone(Some(0), 0.0));
    assert_near(pose.world_from_node[1].transform_point3(DVec3::X), [0.5, 1.0, 0.0]);
}

#[test]
fn channels_that_lead_nowhere_are_without_effect() {
    let mut scene = scene_of(vec![node(None, translated(1.0, 0.0, 0.0))]);
    scene.clips.push(clip(vec![
        channel(7, Path::Translation, 3, &[0.0], &[9.0; 3]),
        channel(0, Path::Translation, 3, &[], &[]),
        channel(0, Path::Rotation, 4, &[0.0], &[1.0]),
        channel(0, Path::Weights, 5, &[0.0], &[1.0; 5]),
    ]));
    assert_eq!(Pose::sample(&scene, &Layer::alone(Some(0), 0.0)), Pose::rest(&scene));
}

#[test]
fn nodes_outside_the_shown_scene_have_world_matrices() {
    let mut scene = scene_of(vec![
        node(Some(2), translated(0.0, 0.0, 1.0)),
        node(None, translated(5.0, 0.0, 0.0)),
        node(None, translated(0.0, 1.0, 0.0)),
    ]);
    scene.roots = vec![1];
    let pose = Pose::rest(&scene);
    assert_near(pose.world_from_node[0].transform_point3(DVec3::ZERO), [0.0, 1.0, 1.0]);
}

#[test]
fn deep_chains_and_loops_of_parents_end() {
    let count = 100_000;
    let chain = (0..count).map(|index: usize| node(index.checked_sub(1), translated(1.0, 0.0, 0.0)));
    let mut nodes: Vec<_> = chain.collect();
    // Reversed, so that the first node asked for is the deepest.
    nodes.reverse();
    for (index, node) in nodes.iter_mut().enumerate() {
        node.parent = Some(index + 1).filter(|&parent| parent < count);
    }
    let mut scene = scene_of(nodes);
    assert_near(Pose::rest(&scene).world_from_node[0].transform_point3(DVec3::ZERO), [count as f64, 0.0, 0.0]);

    scene.nodes[count - 1].parent = Some(0);
    assert_eq!(Pose::rest(&scene).world_from_node.len(), count);
}

//! Crowds against characters posed one by one.

use glam::{DMat4, DVec3};
use murano_scene::{Channel, Clip, Interpolation, Path, Sampler, Scene};

use super::{bind, hang, node, primitive, scene_of, translated};
use crate::{Character, Crowd, Geometry, Layer, Rig, shown_primitives};

/// A body on two joints of which the upper turns, with a target that comes and goes.
fn waving() -> Scene {
    let mut nodes = vec![node(None, translated(0.0, 0.0, 0.0)), node(Some(0), translated(0.0, 1.0, 0.0))];
    nodes.push(node(None, translated(0.0, 0.0, 0.0)));
    let mut scene = scene_of(nodes);
    let mut body = primitive(&[[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0]]);
    body.joints = vec![vec![[0, 1, 0, 0]; 3]];
    body.weights = vec![vec![[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]];
    body.targets = vec![murano_scene::MorphTarget {
        positions: Some(vec![glam::Vec3::X, glam::Vec3::ZERO, glam::Vec3::Y]),
        ..murano_scene::MorphTarget::default()
    }];
    hang(&mut scene, 2, body);
    bind(&mut scene, 2, vec![0, 1]);
    let curve = |width: usize, values: &[f32]| Sampler {
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        width,
        values: values.to_vec(),
    };
    let half = 0.5f32.sqrt();
    scene.clips.push(Clip {
        name: "wave".into(),
        channels: vec![
            Channel { node: 1, path: Path::Rotation, sampler: curve(4, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]) },
            Channel { node: 2, path: Path::Weights, sampler: curve(1, &[0.0, 1.0]) },
        ],
        duration: 1.0,
        ..Clip::default()
    });
    scene
}

fn characters(count: usize) -> Vec<Character> {
    (0..count)
        .map(|index| Character {
            playing: vec![Layer::new(0, index as f64 / count as f64)],
            place: DMat4::from_translation(DVec3::new(3.0 * index as f64, 0.0, 0.0)),
        })
        .collect()
}

#[test]
fn a_crowd_poses_as_each_by_itself() {
    let scene = waving();
    let geometry = Geometry::build(&scene, &shown_primitives(&scene)).unwrap();
    let mut crowd = Crowd::new(Rig::new(&scene), geometry.clone());
    let characters = characters(70);
    let origin = DVec3::new(1.0, 0.0, -2.0);
    assert_eq!(crowd.update(&characters, origin), 70);
    assert_eq!(crowd.blocks().iter().map(crate::Block::len).collect::<Vec<_>>(), [32, 32, 6]);
    let palettes: Vec<_> = crowd.blocks().iter().flat_map(|block| block.palette().to_vec()).collect();
    let rig = Rig::new(&scene);
    for (character, palette) in characters.iter().zip(palettes.chunks(geometry.palette_rows())) {
        let mut pose = rig.pose(&character.playing);
        pose.world_from_node.iter_mut().for_each(|matrix| *matrix = character.place * *matrix);
        let wanted = geometry.palette(&pose, origin);
        let off = wanted.as_flattened().iter().zip(palette.as_flattened());
        assert!(off.into_iter().all(|(a, b)| (a - b).abs() <= 2e-5 * a.abs().max(1.0)), "{character:?}");
    }
}

#[test]
fn only_what_changes_is_posed() {
    let scene = waving();
    let geometry = Geometry::build(&scene, &shown_primitives(&scene)).unwrap();
    let mut crowd = Crowd::new(Rig::new(&scene), geometry);
    let mut characters = characters(100);
    let mut update = |characters: &[Character], origin: DVec3| crowd.update(characters, origin);
    assert_eq!(update(&characters, DVec3::ZERO), 100);
    assert_eq!(update(&characters, DVec3::ZERO), 0);
    characters[40].playing[0].time = 0.77;
    characters[99].place.w_axis.y = 1.0;
    assert_eq!(update(&characters, DVec3::ZERO), 2);
    assert_eq!(update(&characters, DVec3::X), 100);
    characters.pop();
    assert_eq!(update(&characters, DVec3::X), 3, "the last block has lost one");
    assert_eq!(update(&[], DVec3::X), 0);
}

//! EXT_mesh_gpu_instancing: where instances come to be, and what is wrong with those that cannot.

mod common;

use common::Model;
use glam::{DQuat, DVec3};
use murano_scene::{ImportProblem, Local, Path};
use serde_json::{Value, json};

/// The triangle's node with instance attributes, and a node after it.
fn instanced(attributes: Value) -> Model {
    with_attributes(Model::triangle(), attributes)
}

fn with_attributes(mut model: Model, attributes: Value) -> Model {
    model.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    let nodes = model.json["nodes"].as_array_mut().expect("a list");
    nodes.push(json!({ "name": "other", "translation": [5, 0, 0] }));
    model
}

#[test]
fn each_instance_is_a_node_below_the_one_that_keeps_its_place() {
    let mut model = Model::triangle();
    let translations = model.floats("VEC3", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    // A quarter turn about Z in 16 bits, and none in a form that is not unit.
    let half = (32767.0 * std::f32::consts::FRAC_1_SQRT_2).round() as i16;
    let rotations: Vec<u8> = [0, 0, half, half, 0, 0, 0, 16384].iter().flat_map(|value| value.to_le_bytes()).collect();
    let rotations = model.accessor(5122, "VEC4", 2, &rotations);
    model.json["accessors"][rotations]["normalized"] = json!(true);
    let scales = model.floats("VEC3", &[2.0, 2.0, 2.0, 1.0, -1.0, 1.0]);
    let numbers = model.floats("SCALAR", &[7.0, 8.0]);
    model.json["nodes"][0]["rotation"] = json!([0, 1, 0, 0]);
    let attributes = json!({ "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_NUMBER": numbers });
    let scene = with_attributes(model, attributes).import().expect("a sound model");

    let names: Vec<&str> = scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["body", "other", "body[0]", "body[1]"]);
    assert_eq!(scene.roots, [0, 1]);
    assert_eq!((scene.nodes[0].mesh, &scene.nodes[0].children[..]), (None, &[2, 3][..]));
    let Local::Trs(kept) = scene.nodes[0].local else { panic!("no matrix") };
    assert_eq!(kept.rotation, DQuat::from_xyzw(0.0, 1.0, 0.0, 0.0));
    for (node, translation, rotation, scale) in [
        (2, DVec3::new(1.0, 2.0, 3.0), DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2), DVec3::splat(2.0)),
        (3, DVec3::new(4.0, 5.0, 6.0), DQuat::IDENTITY, DVec3::new(1.0, -1.0, 1.0)),
    ] {
        let node = &scene.nodes[node];
        assert_eq!((node.mesh, node.parent), (Some(0), Some(0)));
        let Local::Trs(transform) = node.local else { panic!("no matrix") };
        assert_eq!((transform.translation, transform.scale), (translation, scale));
        assert!(transform.rotation.is_normalized() && transform.rotation.abs_diff_eq(rotation, 1e-9));
    }
    assert!(scene.report.warnings.is_empty());
}

#[test]
fn attributes_that_disagree_are_refused() {
    let mut model = Model::triangle();
    let three = model.floats("VEC3", &[0.0; 9]);
    let two = model.floats("VEC3", &[1.0; 6]);
    let numbers = model.floats("SCALAR", &[0.0; 2]);
    for attributes in [json!({ "TRANSLATION": three, "SCALE": two }), json!({ "SCALE": three, "_NUMBER": numbers })] {
        let mut copy = Model { json: model.json.clone(), bytes: model.bytes.clone() };
        copy = with_attributes(copy, attributes);
        let problem = copy.problem();
        assert!(matches!(&problem, ImportProblem::Accessor { at, .. } if at.contains("body")), "{problem}");
    }
}

#[test]
fn wrong_attributes_are_refused() {
    let problem = instanced(json!({ "TRANSLATION": 9 })).problem();
    assert!(matches!(problem, ImportProblem::BadIndex { index: 9, .. }), "{problem}");
    let problem = instanced(json!({ "ROTATION": 0 })).problem();
    assert!(matches!(problem, ImportProblem::Accessor { .. }), "{problem}");
    let problem = instanced(json!([0])).problem();
    assert!(matches!(problem, ImportProblem::Schema { .. }), "{problem}");

    let mut model = Model::triangle();
    let rotations = model.floats("VEC4", &[0.0; 8]);
    let problem = with_attributes(model, json!({ "ROTATION": rotations })).problem();
    assert!(matches!(&problem, ImportProblem::Value { at, .. } if at.contains("instance 0")), "{problem}");
}

/// Instances that no byte stands behind are bounded like everything else.
#[test]
fn many_instances_are_refused_before_they_are_made() {
    let mut model = Model::triangle();
    let accessors = model.json["accessors"].as_array_mut().expect("a list");
    accessors.push(json!({ "componentType": 5121, "type": "SCALAR", "count": 60_000_000 }));
    let problem = with_attributes(model, json!({ "_NUMBER": 1 })).problem();
    assert!(matches!(&problem, ImportProblem::TooLarge { at, .. } if at.contains("body")), "{problem}");
}

#[test]
fn instancing_that_means_nothing_is_ignored_with_a_warning() {
    let mut skinned = instanced(json!({ "TRANSLATION": 0 }));
    skinned.json["nodes"][0]["skin"] = json!(0);
    skinned.json["skins"] = json!([{ "joints": [1] }]);
    let mut meshless = instanced(json!({ "TRANSLATION": 0 }));
    meshless.json["nodes"][0].as_object_mut().expect("an object").remove("mesh");
    for (model, reason) in
        [(skinned, "skinned"), (meshless, "no mesh"), (instanced(json!({})), "no instance attributes")]
    {
        let scene = model.import().expect("a sound model");
        assert_eq!(scene.nodes.len(), 2);
        let [warning] = &scene.report.warnings[..] else { panic!("{:?}", scene.report.warnings) };
        assert!(warning.contains("body") && warning.contains(reason), "{warning}");
    }
    let unknown = instanced(json!({ "COLOR_0": 0 })).import().expect("a sound model");
    assert_eq!(unknown.nodes.len(), 2 + 3);
    assert!(unknown.report.warnings[0].contains("COLOR_0"));
}

#[test]
fn a_clip_drives_the_weights_of_every_instance() {
    let mut model = Model::triangle();
    model.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]);
    let places = model.floats("VEC3", &[0.0; 6]);
    let (input, output) = (model.floats("SCALAR", &[0.0, 1.0]), model.floats("SCALAR", &[0.0, 1.0]));
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "weights" } });
    model.json["animations"] = json!([{ "channels": [channel], "samplers": [{ "input": input, "output": output }] }]);
    let scene = with_attributes(model, json!({ "TRANSLATION": places })).import().expect("a sound model");
    let driven: Vec<_> = scene.clips[0].channels.iter().map(|channel| (channel.node, channel.path)).collect();
    assert_eq!(driven, [(2, Path::Weights), (3, Path::Weights)]);
    assert!(scene.report.warnings.is_empty(), "{:?}", scene.report.warnings);
}

//! What meshes and clips become: topologies, component types, sparse accessors, flat shading.

mod common;

use common::Model;
use glam::{Vec2, Vec3, Vec4};
use murano_scene::{Interpolation, Path, Primitive};
use serde_json::json;

/// Points of a zigzag along +X in the plane z = 0, as a strip counter-clockwise from +Z.
const ZIGZAG: [f32; 15] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0, 0.0];

fn primitive(model: &Model) -> Primitive {
    model.import().expect("a sound model").meshes[0].primitives[0].clone()
}

fn normals_z(primitive: &Primitive) -> Vec<f32> {
    let corners = |triangle: &[u32; 3]| triangle.map(|vertex| primitive.positions[vertex as usize]);
    primitive.triangles.iter().map(corners).map(|[a, b, c]| (b - a).cross(c - a).z).collect()
}

fn with_positions(positions: &[f32], mode: u32) -> Model {
    let mut model = Model::triangle();
    let positions = model.floats("VEC3", positions);
    model.json["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": positions }, "mode": mode });
    model
}

#[test]
fn strips_keep_their_winding() {
    let strip = primitive(&with_positions(&ZIGZAG, 5));
    assert_eq!(strip.triangles.len(), 3);
    assert!(normals_z(&strip).iter().all(|&z| z > 0.0));
}

#[test]
fn stitches_of_strips_are_left_out() {
    let mut model = with_positions(&ZIGZAG, 5);
    let indices = model.accessor(5121, "SCALAR", 7, &[0, 1, 2, 2, 2, 3, 4]);
    model.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert_eq!(primitive(&model).triangles.len(), 2);
}

#[test]
fn fans_keep_their_winding() {
    let fan = primitive(&with_positions(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0], 6));
    assert_eq!(fan.triangles.len(), 2);
    assert!(normals_z(&fan).iter().all(|&z| z > 0.0));
}

#[test]
fn points_and_lines_are_dropped_with_a_warning() {
    for mode in 0..4 {
        let scene = with_positions(&ZIGZAG, mode).import().expect("a sound model");
        assert!(scene.meshes[0].primitives.is_empty());
        assert_eq!(scene.report.warnings.len(), 1);
    }
}

#[test]
fn vertices_without_normals_belong_to_one_triangle() {
    let mut model = with_positions(&ZIGZAG, 5);
    let displacements = model.floats("VEC3", &ZIGZAG.map(|value| 10.0 * value));
    let texcoords = model.floats("VEC2", &[0.0, 0.0, 0.1, 0.0, 0.2, 0.0, 0.3, 0.0, 0.4, 0.0]);
    let body = &mut model.json["meshes"][0]["primitives"][0];
    body["targets"] = json!([{ "POSITION": displacements, "NORMAL": displacements }]);
    body["attributes"]["TEXCOORD_0"] = json!(texcoords);
    let flat = primitive(&model);
    assert!(flat.normals.is_none() && flat.targets[0].normals.is_none());
    assert_eq!(flat.triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
    let displaced = flat.targets[0].positions.as_ref().expect("displacements");
    assert!(flat.positions.iter().zip(displaced).all(|(position, displacement)| *position * 10.0 == *displacement));
    assert_eq!(flat.texcoords[0][3], Vec2::new(0.1, 0.0));
}

#[test]
fn sparse_replaces_elements_of_stored_and_of_zero_bases() {
    for stored in [true, false] {
        let mut model = Model::triangle();
        let indices = model.view(&[1, 0, 2, 0]);
        let values: Vec<u8> = [5.0_f32, 6.0, 7.0, 0.0, 9.0, 0.0].iter().flat_map(|value| value.to_le_bytes()).collect();
        let values = model.view(&values);
        model.json["accessors"][0]["sparse"] = json!({
            "count": 2,
            "indices": { "bufferView": indices, "componentType": 5123 },
            "values": { "bufferView": values },
        });
        if !stored {
            model.json["accessors"][0].as_object_mut().expect("an object").remove("bufferView");
        }
        assert_eq!(
            primitive(&model).positions,
            [Vec3::ZERO, Vec3::new(5.0, 6.0, 7.0), Vec3::new(0.0, 9.0, 0.0)],
            "stored: {stored}"
        );
    }
}

#[test]
fn integers_decode_as_the_specification_says() {
    let mut model = Model::triangle();
    let normals = model.accessor(5120, "VEC3", 3, &[0, 0, 127, 0, 0, 127, 0, 0x80, 0]);
    model.json["accessors"][normals]["normalized"] = json!(true);
    let colors = model.accessor(5121, "VEC3", 3, &[255, 0, 51, 255, 0, 51, 255, 0, 51]);
    model.json["accessors"][colors]["normalized"] = json!(true);
    let texcoords = model.accessor(5123, "VEC2", 3, &[255, 255, 0, 0, 1, 0, 2, 0, 3, 0, 4, 0]);
    model.json["meshes"][0]["primitives"][0]["attributes"] =
        json!({ "POSITION": 0, "NORMAL": normals, "COLOR_0": colors, "TEXCOORD_0": texcoords });
    let body = primitive(&model);
    assert_eq!(body.normals.as_deref(), Some(&[Vec3::Z, Vec3::Z, Vec3::NEG_Y][..]));
    assert_eq!(body.colors.as_ref().expect("colours")[0], Vec4::new(1.0, 0.0, 0.2, 1.0));
    assert_eq!(body.texcoords[0], [Vec2::new(65535.0, 0.0), Vec2::new(1.0, 2.0), Vec2::new(3.0, 4.0)]);
}

#[test]
fn interleaved_attributes_are_told_apart() {
    let mut model = Model::new();
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let interleaved: Vec<u8> =
        corners.iter().flat_map(|[x, y]| [*x, *y, 0.0, 0.0, 0.0, 2.0_f32]).flat_map(f32::to_le_bytes).collect();
    let view = model.view(&interleaved);
    model.json["bufferViews"][view]["byteStride"] = json!(24);
    let accessor = |offset: usize| json!({ "bufferView": view, "byteOffset": offset, "componentType": 5126, "type": "VEC3", "count": 3 });
    model.json["accessors"] = json!([accessor(0), accessor(12)]);
    model.json["meshes"] = json!([{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 } }] }]);
    let body = primitive(&model);
    assert_eq!(body.positions[2], Vec3::Y);
    assert_eq!(body.normals.as_deref(), Some(&[Vec3::Z; 3][..]), "normals are made unit");
}

#[test]
fn normals_of_zero_length_come_from_the_triangles() {
    let mut model = Model::triangle();
    let normals = model.floats("VEC3", &[0.0; 9]);
    model.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let scene = model.import().expect("a sound model");
    assert_eq!(scene.meshes[0].primitives[0].normals.as_deref(), Some(&[Vec3::Z; 3][..]));
    assert_eq!(scene.report.warnings.len(), 1);
}

#[test]
fn hierarchy_keeps_the_precision_of_the_file() {
    let mut model = Model::triangle();
    model.json["nodes"][0]["translation"] = json!([1_000_000.001, 0, 0]);
    let scene = model.import().expect("a sound model");
    assert_eq!(scene.nodes[0].local.matrix().w_axis.x, 1_000_000.001);
}

/// A clip on the triangle's node: one channel a target.
fn animated(targets: &serde_json::Value, times: &[f32], output_type: &str, values: &[f32]) -> Model {
    let mut model = Model::triangle();
    let (input, output) = (model.floats("SCALAR", times), model.floats(output_type, values));
    let channels: Vec<_> =
        targets.as_array().expect("targets").iter().map(|target| json!({ "sampler": 0, "target": target })).collect();
    model.json["animations"] =
        json!([{ "name": "move", "channels": channels, "samplers": [{ "input": input, "output": output }] }]);
    model
}

#[test]
fn channels_that_drive_nothing_are_dropped_with_a_warning() {
    let targets = json!([
        { "path": "translation" },
        { "node": 0, "path": "translation" },
        { "node": 0, "path": "translation" },
        { "node": 0, "path": "weights" },
        { "node": 0, "path": "colour" },
        { "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": "/nodes/0/scale" } } },
        { "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": "/asset/generator" } } },
    ]);
    let model = animated(&targets, &[0.5, 2.5], "VEC3", &[0.0, 0.0, 0.0, 1.0, 2.0, 3.0]);
    let scene = model.import().expect("a sound model");
    let clip = &scene.clips[0];
    let driven: Vec<_> = clip.channels.iter().map(|channel| (channel.node, channel.path)).collect();
    assert_eq!(driven, [(0, Path::Translation), (0, Path::Scale)]);
    assert_eq!(scene.report.warnings.len(), 5);
    assert_eq!(clip.duration, 2.5);
    assert_eq!(clip.channels[0].sampler.interpolation, Interpolation::Linear);
}

/// One channel a pointer, each with a curve of the numbers it needs.
fn pointed(pointers: &[(&str, &str, &[f32])]) -> Model {
    let mut model = Model::triangle();
    model.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }, { "POSITION": 0 }]);
    model.json["materials"] = json!([{ "alphaMode": "MASK" }, {}]);
    model.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }]);
    model.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": { "outerConeAngle": 0.5 } }] } });
    let input = model.floats("SCALAR", &[0.0, 1.0]);
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    for (pointer, kind, values) in pointers {
        let output = model.floats(kind, values);
        let extensions = json!({ "KHR_animation_pointer": { "pointer": pointer } });
        channels.push(json!({ "sampler": samplers.len(), "target": { "path": "pointer", "extensions": extensions } }));
        samplers.push(json!({ "input": input, "output": output }));
    }
    model.json["animations"] = json!([{ "channels": channels, "samplers": samplers }]);
    model
}

#[test]
fn pointers_reach_materials_lights_cameras_and_weights() {
    use murano_scene::{CameraProperty, LightProperty, MaterialProperty as M, Property, TextureSlot};
    let glass = "/materials/1/extensions/KHR_materials_";
    let scene = pointed(&[
        (&format!("{glass}ior/ior"), "SCALAR", &[1.0, 2.0]),
        (&format!("{glass}volume/attenuationColor"), "VEC3", &[0.0; 6]),
        ("/materials/0/pbrMetallicRoughness/baseColorFactor", "VEC4", &[0.0; 8]),
        ("/materials/0/alphaCutoff", "SCALAR", &[0.0; 2]),
        ("/materials/0/normalTexture/extensions/KHR_texture_transform/offset", "VEC2", &[0.0; 4]),
        ("/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle", "SCALAR", &[0.0; 2]),
        ("/cameras/0/perspective/yfov", "SCALAR", &[0.0; 2]),
        ("/nodes/0/weights/1", "SCALAR", &[0.0; 2]),
        ("/meshes/0/weights/0", "SCALAR", &[0.0; 2]),
        ("/meshes/0/weights", "SCALAR", &[0.0; 4]),
    ])
    .import()
    .expect("a sound model");
    let driven: Vec<_> = scene.clips[0].properties.iter().map(|channel| channel.property).collect();
    assert_eq!(
        driven,
        [
            Property::Material(1, M::Ior),
            Property::Material(1, M::AttenuationColor),
            Property::Material(0, M::BaseColor),
            Property::Material(0, M::AlphaCutoff),
            Property::Material(0, M::TextureOffset(TextureSlot::Normal)),
            Property::Light(0, LightProperty::OuterCone),
            Property::Camera(0, CameraProperty::FieldOfView),
            Property::Weight(0, 1),
            Property::Weight(0, 0),
        ]
    );
    assert_eq!(scene.clips[0].properties[0].sampler.values, [1.0, 2.0]);
    let weights: Vec<_> = scene.clips[0].channels.iter().map(|channel| (channel.node, channel.path)).collect();
    assert_eq!(weights, [(0, Path::Weights)]);
    assert_eq!(scene.report.warnings, Vec::<String>::new());
    assert_eq!(scene.clips[0].duration, 1.0);
}

#[test]
fn what_is_driven_twice_by_other_ways_is_driven_once() {
    let curve: &[f32] = &[0.0; 4];
    let twice = [("/nodes/0/weights", "SCALAR", curve), ("/meshes/0/weights", "SCALAR", curve)];
    let scene = pointed(&twice).import().expect("a sound model");
    assert_eq!((scene.clips[0].channels.len(), scene.report.warnings.len()), (1, 1));
    let single = [("/meshes/0/weights/0", "SCALAR", &curve[..2]), ("/nodes/0/weights/0", "SCALAR", &curve[..2])];
    let scene = pointed(&single).import().expect("a sound model");
    assert_eq!((scene.clips[0].properties.len(), scene.report.warnings.len()), (1, 1));
}

/// By pointer, integers that are not normalised are what they say.
#[test]
fn integers_by_pointer_are_themselves() {
    let mut model = pointed(&[("/materials/1/extensions/KHR_materials_ior/ior", "SCALAR", &[1.0, 1.5])]);
    let bytes = model.accessor(5121, "SCALAR", 2, &[1, 2]);
    model.json["animations"][0]["samplers"][0]["output"] = json!(bytes);
    let scene = model.import().expect("a sound model");
    assert_eq!(scene.clips[0].properties[0].sampler.values, [1.0, 2.0]);
}

#[test]
fn pointers_to_nothing_are_dropped_or_refused() {
    for pointer in ["", "materials/0/alphaCutoff", "/materials/x/alphaCutoff", "/materials/0", "/nodes/0/weights/9"] {
        let scene = pointed(&[(pointer, "SCALAR", &[0.0; 2])]).import().expect("a sound model");
        assert!(scene.clips[0].properties.is_empty(), "{pointer}");
        assert_eq!(scene.report.warnings.len(), 1, "{pointer}");
    }
    for pointer in ["/materials/9/alphaCutoff", "/nodes/9/scale", "/cameras/1/perspective/yfov"] {
        let error = pointed(&[(pointer, "SCALAR", &[0.0; 2])]).import().expect_err(pointer).to_string();
        assert!(error.contains(pointer), "{error}");
    }
}

#[test]
fn keys_that_do_not_advance_are_dropped() {
    let targets = json!([{ "node": 0, "path": "translation" }]);
    let values: Vec<f32> = (0..12).map(|value| value as f32).collect();
    let scene = animated(&targets, &[0.0, 1.0, 1.0, 2.0], "VEC3", &values).import().expect("a sound model");
    let sampler = &scene.clips[0].channels[0].sampler;
    assert_eq!(sampler.times, [0.0, 1.0, 2.0]);
    assert_eq!(sampler.values, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 9.0, 10.0, 11.0]);
}

#[test]
fn animated_matrices_are_decomposed() {
    let targets = json!([{ "node": 0, "path": "translation" }]);
    let mut model = animated(&targets, &[0.0], "VEC3", &[1.0, 2.0, 3.0]);
    let scale = json!([2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 5, 6, 7, 1]);
    model.json["nodes"][0]["matrix"] = scale;
    let scene = model.import().expect("a sound model");
    assert!(matches!(scene.nodes[0].local, murano_scene::Local::Trs(transform)
        if transform.scale == glam::DVec3::new(2.0, 3.0, 4.0)));

    model.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    let scene = model.import().expect("a sound model");
    assert!(scene.clips[0].channels.is_empty() && scene.report.warnings.len() == 1, "a shear has no decomposition");
}

#[test]
fn too_few_values_for_the_keys_are_refused() {
    let targets = json!([{ "node": 0, "path": "translation" }]);
    let problem = animated(&targets, &[0.0, 1.0], "VEC3", &[1.0, 2.0, 3.0]).problem();
    assert!(matches!(problem, murano_scene::ImportProblem::Accessor { .. }), "{problem}");
}

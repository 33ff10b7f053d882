//! Compressed buffer views: sound ones give back what was compressed, wrong ones end in an error that names them.

mod common;

use std::time::{Duration, Instant};

use common::Model;
use glam::{Quat, Vec3, Vec4};
use meshopt::encoding::FilterComponent;
use meshopt::{EncodeExpMode, encode_filter_color, encode_filter_exp, encode_filter_oct, encode_filter_quat};
use meshopt::{encode_index_buffer, encode_index_sequence, encode_vertex_buffer_level};
use murano_scene::{ImportProblem, Scene};
use serde_json::{Value, json};

const EXT: &str = "EXT_meshopt_compression";

/// Corners of a unit square.
const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const TRIANGLES: [u32; 6] = [0, 1, 2, 0, 2, 3];

/// Adds a buffer view that holds `encoded`, `count` elements of `stride` bytes; returns its index.
fn compressed_view(model: &mut Model, encoded: &[u8], mode: &str, count: usize, stride: usize) -> usize {
    let view = model.view(encoded);
    let mut compression = model.json["bufferViews"][view].take();
    for (name, value) in [("mode", json!(mode)), ("count", json!(count)), ("byteStride", json!(stride))] {
        compression[name] = value;
    }
    let length = count * stride;
    model.json["bufferViews"][view] = json!({ "buffer": 1, "byteLength": length, "extensions": { EXT: compression } });
    view
}

/// A square of two triangles, positions and 16-bit indices compressed, with a fallback buffer that holds nothing.
fn square() -> Model {
    let mut model = Model::new();
    let encoded = encode_vertex_buffer_level(&SQUARE, 2, Some(0)).expect("positions");
    let positions = compressed_view(&mut model, &encoded, "ATTRIBUTES", 4, 12);
    let encoded = encode_index_buffer(&TRIANGLES, 4).expect("triangles");
    let indices = compressed_view(&mut model, &encoded, "TRIANGLES", 6, 2);
    model.json["accessors"] = json!([
        { "bufferView": positions, "componentType": 5126, "type": "VEC3", "count": 4 },
        { "bufferView": indices, "componentType": 5123, "type": "SCALAR", "count": 6 },
    ]);
    model.json["meshes"] = json!([{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }]);
    model.json["nodes"] = json!([{ "mesh": 0 }]);
    model.json["extensionsUsed"] = json!([EXT]);
    model.json["extensionsRequired"] = json!([EXT]);
    model
}

/// Imports from a GLB whose second buffer is a fallback without data.
fn import(model: &Model) -> Result<Scene, ImportProblem> {
    let fallback = json!({ "byteLength": 1_u64 << 40, "extensions": { EXT: { "fallback": true } } });
    common::import_bytes(&model.glb_with_buffers(&[fallback])).map_err(|error| error.problem)
}

/// Corners in order, each triangle from the origin: the encoder may begin with another corner.
fn corners(scene: &Scene) -> Vec<Vec3> {
    let primitive = &scene.meshes[0].primitives[0];
    let from_first = |triangle: &[u32; 3]| {
        let mut corners = triangle.map(|vertex| primitive.positions[vertex as usize]);
        let first = corners.iter().position(|corner| *corner == Vec3::ZERO).expect("both triangles meet in the origin");
        corners.rotate_left(first);
        corners
    };
    primitive.triangles.iter().flat_map(from_first).collect()
}

fn expected_corners() -> Vec<Vec3> {
    TRIANGLES.iter().map(|&vertex| Vec3::from_array(SQUARE[vertex as usize])).collect()
}

#[test]
fn attributes_and_triangles_come_back() {
    let scene = import(&square()).expect("a sound model");
    assert_eq!(corners(&scene), expected_corners());
    assert!(scene.report.extensions_ignored.is_empty() && scene.report.warnings.is_empty());
}

#[test]
fn both_names_and_both_versions_are_read() {
    let mut model = square();
    let encoded = encode_vertex_buffer_level(&SQUARE, 2, Some(1)).expect("positions");
    let view = compressed_view(&mut model, &encoded, "ATTRIBUTES", 4, 12);
    let extensions = &mut model.json["bufferViews"][view]["extensions"];
    extensions["KHR_meshopt_compression"] = extensions[EXT].take();
    extensions.as_object_mut().expect("an object").remove(EXT);
    model.json["accessors"][0]["bufferView"] = json!(view);
    assert_eq!(corners(&import(&model).expect("a sound model")), expected_corners());
}

#[test]
fn sequences_of_indices_come_back() {
    for (stride, component_type) in [(2, 5123), (4, 5125)] {
        let mut model = square();
        let encoded = encode_index_sequence(&TRIANGLES, 4).expect("indices");
        let view = compressed_view(&mut model, &encoded, "INDICES", 6, stride);
        model.json["accessors"][1] =
            json!({ "bufferView": view, "componentType": component_type, "type": "SCALAR", "count": 6 });
        assert_eq!(corners(&import(&model).expect("a sound model")), expected_corners());
    }
}

#[test]
fn exponents_come_back() {
    let mut model = square();
    let filtered = encode_filter_exp(&SQUARE, 15, EncodeExpMode::Separate);
    let encoded = encode_vertex_buffer_level(&filtered, 2, Some(0)).expect("positions");
    let view = compressed_view(&mut model, &encoded, "ATTRIBUTES", 4, 12);
    model.json["bufferViews"][view]["extensions"][EXT]["filter"] = json!("EXPONENTIAL");
    model.json["accessors"][0]["bufferView"] = json!(view);
    assert_eq!(corners(&import(&model).expect("a sound model")), expected_corners());
}

/// Adds a view of filtered attributes and an accessor of it; returns the accessor's index.
fn filtered<T>(model: &mut Model, elements: &[T], filter: &str, component_type: u32, element_type: &str) -> usize {
    let encoded = encode_vertex_buffer_level(elements, 2, Some(0)).expect("attributes");
    let view = compressed_view(model, &encoded, "ATTRIBUTES", elements.len(), size_of::<T>());
    model.json["bufferViews"][view]["byteStride"] = json!(size_of::<T>());
    model.json["bufferViews"][view]["extensions"][EXT]["filter"] = json!(filter);
    let accessors = model.json["accessors"].as_array_mut().expect("a list");
    accessors.push(json!({
        "bufferView": view, "componentType": component_type, "normalized": true,
        "type": element_type, "count": elements.len(),
    }));
    accessors.len() - 1
}

/// Normals of components `N` and colours of components `C`, whose glTF types are given, stored in so many bits.
fn check_directions_and_colors<N: FilterComponent, C: FilterComponent>(bits: i32, types: [u32; 2], tolerance: f32) {
    let directions = [Vec4::X, -Vec4::Y, Vec4::Z, Vec4::new(-0.6, 0.0, -0.8, 0.0)];
    let colors = [Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 0.5, 1.0, 0.25), Vec4::ONE, Vec4::splat(0.4)];
    let mut model = square();
    let stored = encode_filter_oct::<N>(&directions.map(|direction| direction.to_array()), bits);
    let normals = filtered(&mut model, &stored, "OCTAHEDRAL", types[0], "VEC3");
    let stored = encode_filter_color::<C>(&colors.map(|color| color.to_array()), bits);
    let tints = filtered(&mut model, &stored, "COLOR", types[1], "VEC4");
    let attributes = &mut model.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["NORMAL"] = json!(normals);
    attributes["COLOR_0"] = json!(tints);
    let scene = import(&model).expect("a sound model");
    let primitive = &scene.meshes[0].primitives[0];
    let normals = primitive.normals.as_ref().expect("normals").iter();
    assert!(normals.zip(directions).all(|(normal, direction)| normal.distance(direction.truncate()) < tolerance));
    let tints = primitive.colors.as_ref().expect("colours").iter();
    assert!(tints.zip(colors).all(|(tint, color)| tint.distance(color) < tolerance));
}

#[test]
fn directions_and_colors_come_back() {
    check_directions_and_colors::<i8, u8>(8, [5120, 5121], 0.03);
    check_directions_and_colors::<i16, u16>(12, [5122, 5123], 2e-3);
}

#[test]
fn rotations_come_back() {
    let rotations =
        [Quat::IDENTITY, Quat::from_rotation_x(1.0), Quat::from_rotation_y(-2.0), Quat::from_rotation_z(3.0)];
    let mut model = square();
    let stored = encode_filter_quat(&rotations.map(|rotation| rotation.to_array()), 16);
    let output = filtered(&mut model, &stored, "QUATERNION", 5122, "VEC4");
    let input = model.floats("SCALAR", &[0.0, 1.0, 2.0, 3.0]);
    model.json["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "rotation" } }],
        "samplers": [{ "input": input, "output": output }],
    }]);
    let scene = import(&model).expect("a sound model");
    let keys = scene.clips[0].channels[0].sampler.values.as_chunks::<4>().0;
    for (key, rotation) in keys.iter().zip(rotations) {
        assert!(Quat::from_array(*key).dot(rotation).abs() > 1.0 - 1e-6, "{key:?} {rotation}");
    }
}

/// What is wrong once one property of the positions' compression is another.
fn problem_with(name: &str, value: Value) -> ImportProblem {
    let mut model = square();
    model.json["bufferViews"][0]["extensions"][EXT][name] = value;
    let start = Instant::now();
    let problem = import(&model).expect_err("the model is malformed");
    assert!(start.elapsed() < Duration::from_millis(200), "{name}: {:?}", start.elapsed());
    assert!(problem.to_string().contains("bufferViews[0]"), "{name}: {problem}");
    problem
}

#[test]
fn wrong_properties_are_named() {
    for (name, value) in [
        ("mode", json!("POINTS")),
        ("mode", json!(0)),
        ("filter", json!("BLUR")),
        ("count", json!(-1)),
        ("count", json!(1.5)),
        ("byteLength", Value::Null),
    ] {
        let problem = problem_with(name, value);
        assert!(matches!(problem, ImportProblem::Schema { .. }), "{problem}");
    }
    for (name, value) in [
        ("mode", json!("TRIANGLES")),
        ("filter", json!("OCTAHEDRAL")),
        ("filter", json!("QUATERNION")),
        ("filter", json!("COLOR")),
        ("byteStride", json!(0)),
        ("byteStride", json!(300)),
        ("byteStride", json!(10)),
        ("byteStride", json!(u64::MAX)),
        ("count", json!(0)),
        ("count", json!(5)),
        ("count", json!(u64::MAX)),
    ] {
        let problem = problem_with(name, value);
        assert!(matches!(problem, ImportProblem::Value { .. }), "{problem}");
    }
    for (name, value) in
        [("byteLength", json!(u64::MAX)), ("byteOffset", json!(u64::MAX)), ("byteLength", json!(1 << 20))]
    {
        let problem = problem_with(name, value);
        assert!(matches!(problem, ImportProblem::OutOfBounds { .. }), "{problem}");
    }
    let problem = problem_with("buffer", json!(7));
    assert!(matches!(problem, ImportProblem::BadIndex { index: 7, .. }), "{problem}");
}

#[test]
fn a_fallback_is_never_read() {
    let mut model = square();
    model.json["bufferViews"][0]["extensions"][EXT]["buffer"] = json!(1);
    let problem = import(&model).expect_err("no data");
    assert!(matches!(problem, ImportProblem::MissingBuffer { buffer: 1, .. }), "{problem}");

    let mut plain = square();
    plain.json["bufferViews"][0].as_object_mut().expect("an object").remove("extensions");
    let problem = import(&plain).expect_err("no data");
    assert!(matches!(problem, ImportProblem::MissingBuffer { buffer: 1, .. }), "{problem}");
}

/// Counts that the view's length agrees with, but of which so few bytes can hold nothing.
#[test]
fn counts_are_held_against_the_bytes_before_anything_is_allocated() {
    for (view, mode, stride) in [(0, "ATTRIBUTES", 12_u64), (1, "TRIANGLES", 2), (1, "INDICES", 4)] {
        for count in [3_u64 << 16, 3 << 30] {
            let mut model = square();
            model.json["bufferViews"][view]["byteLength"] = json!(count * stride);
            let compression = &mut model.json["bufferViews"][view]["extensions"][EXT];
            compression["mode"] = json!(mode);
            compression["byteStride"] = json!(stride);
            compression["count"] = json!(count);
            let problem = import(&model).expect_err("too few bytes");
            assert!(matches!(problem, ImportProblem::OutOfBounds { .. }), "{mode}, {count}: {problem}");
        }
    }
}

#[test]
fn truncated_and_damaged_data_end_in_a_result() {
    for view in [0, 1] {
        let model = square();
        let sound = model.json["bufferViews"][view]["extensions"][EXT]["byteLength"].as_u64().expect("a length");
        let offset = model.json["bufferViews"][view]["extensions"][EXT]["byteOffset"].as_u64().expect("an offset");
        for length in 0..sound {
            let mut truncated = square();
            truncated.json["bufferViews"][view]["extensions"][EXT]["byteLength"] = json!(length);
            let problem = import(&truncated).expect_err("truncated");
            let named = problem.to_string().contains(&format!("bufferViews[{view}]"));
            assert!(named, "{length} bytes: {problem}");
            let known = matches!(problem, ImportProblem::OutOfBounds { .. } | ImportProblem::Compressed { .. });
            assert!(known, "{length} bytes: {problem}");
        }
        for place in offset..offset + sound {
            let mut damaged = square();
            damaged.bytes[place as usize] ^= 0xFF;
            let _ = import(&damaged);
        }
        let mut headless = square();
        headless.bytes[offset as usize] = 0;
        let problem = import(&headless).expect_err("no header");
        assert!(matches!(problem, ImportProblem::Compressed { .. }), "{problem}");
    }
}

//! Models made wrong in one way each: the error says which.

mod common;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use common::{Model, import_bytes};
use murano_scene::ImportProblem;
use serde_json::json;

#[test]
fn the_sound_model_imports_from_both_containers() {
    let model = Model::triangle();
    for bytes in [model.gltf(), model.glb()] {
        let scene = import_bytes(&bytes).expect("a sound model");
        assert_eq!(scene.meshes[0].primitives[0].triangles, [[0, 1, 2]]);
        assert_eq!(scene.roots, [0]);
        assert!(scene.report.warnings.is_empty());
    }
}

#[test]
fn a_model_in_memory_finds_no_files() {
    let mut model = Model::triangle();
    let scene = murano_scene::import_bytes(&model.gltf(), "made here").expect("a data URI");
    assert_eq!(scene.meshes[0].primitives[0].triangles, [[0, 1, 2]]);

    model.json["buffers"] = json!([{ "byteLength": 36, "uri": "body.bin" }]);
    let error = murano_scene::import_bytes(model.json.to_string().as_bytes(), "made here").expect_err("no folder");
    assert!(matches!(error.problem, ImportProblem::Uri { .. }), "{error}");
    assert!(error.to_string().contains("made here") && error.to_string().contains("body.bin"), "{error}");
}

#[test]
fn a_missing_file_is_named() {
    let error = murano_scene::import(std::path::Path::new("nowhere/fish.glb")).expect_err("no such file");
    assert!(matches!(&error.problem, ImportProblem::MissingFile { .. }));
    assert!(error.to_string().contains("nowhere/fish.glb"));

    let mut model = Model::triangle();
    model.json["buffers"] = json!([{ "byteLength": 36, "uri": "body%20parts.bin" }]);
    let error = import_bytes(model.json.to_string().as_bytes()).expect_err("no such buffer");
    assert!(error.to_string().contains("body parts.bin"), "{error}");
    assert!(matches!(error.problem, ImportProblem::MissingFile { .. }));
}

#[test]
fn every_prefix_of_a_glb_is_an_error() {
    let glb = Model::triangle().glb();
    for length in 0..glb.len() {
        assert!(import_bytes(&glb[..length]).is_err(), "{length} bytes");
    }
}

#[test]
fn every_flipped_byte_of_a_glb_ends_in_a_result() {
    let glb = Model::triangle().glb();
    for place in 0..glb.len() {
        for flip in [0x01, 0x80, 0xFF] {
            let mut damaged = glb.clone();
            damaged[place] ^= flip;
            let _ = import_bytes(&damaged);
        }
    }
}

#[test]
fn glb_lengths_are_checked() {
    let glb = Model::triangle().glb();
    for (place, value) in [(8, 4_u32), (8, u32::MAX), (12, u32::MAX), (12, 1 << 20)] {
        let mut damaged = glb.clone();
        damaged[place..place + 4].copy_from_slice(&value.to_le_bytes());
        let problem = import_bytes(&damaged).expect_err("a damaged container").problem;
        assert!(matches!(problem, ImportProblem::Glb { .. }), "{problem}");
    }
}

#[test]
fn a_cycle_is_found() {
    let mut model = Model::triangle();
    model.json["nodes"] = json!([
        { "name": "root", "children": [1] },
        { "name": "fine" },
        { "name": "head", "children": [3] },
        { "name": "tail", "children": [2] },
    ]);
    let problem = model.problem();
    assert!(matches!(&problem, ImportProblem::Cycle { at } if at.contains("head") || at.contains("tail")), "{problem}");

    model.json["nodes"] = json!([{ "children": [0] }]);
    assert!(matches!(model.problem(), ImportProblem::Cycle { .. }));
}

#[test]
fn a_deep_chain_is_no_cycle() {
    let mut model = Model::triangle();
    let depth = 100_000;
    let mut nodes: Vec<_> = (1..depth).map(|child| json!({ "children": [child] })).collect();
    nodes.push(json!({ "mesh": 0 }));
    model.json["nodes"] = json!(nodes);
    assert_eq!(model.import().expect("a deep chain").traversal().len(), depth);
}

#[test]
fn a_second_parent_is_refused() {
    let mut model = Model::triangle();
    model.json["nodes"] = json!([{ "children": [2] }, { "children": [2] }, { "name": "torn", "mesh": 0 }]);
    let problem = model.problem();
    assert!(matches!(&problem, ImportProblem::SharedParent { at, .. } if at.contains("torn")), "{problem}");

    model.json["nodes"] = json!([{ "children": [1] }, {}]);
    model.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    assert!(matches!(model.problem(), ImportProblem::SharedParent { .. }));
}

#[test]
fn nan_and_infinity_are_found() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut model = Model::triangle();
        model.bytes[20..24].copy_from_slice(&value.to_le_bytes());
        let problem = model.problem();
        assert!(matches!(problem, ImportProblem::NonFinite { element: 1, .. }), "{problem}");
    }
}

/// Whatever uses an accessor, the message names the accessor, its use and the element.
#[test]
fn nan_is_found_in_every_kind_of_accessor() {
    let mut directions = [0.0, 0.0, 1.0].repeat(3);
    directions[7] = f32::NAN;
    let mut shares = [0.25; 12];
    shares[4] = f32::INFINITY;
    for (attribute, kind, values) in [
        ("NORMAL", "VEC3", &directions[..]),
        ("TEXCOORD_0", "VEC2", &directions[3..]),
        ("COLOR_0", "VEC4", &shares[..]),
        ("WEIGHTS_0", "VEC4", &shares[..]),
    ] {
        let mut model = Model::triangle();
        let accessor = model.floats(kind, values);
        model.json["meshes"][0]["primitives"][0]["attributes"][attribute] = json!(accessor);
        let problem = model.problem();
        let element = values.iter().position(|value| !value.is_finite()).expect("planted") / (values.len() / 3);
        assert!(matches!(&problem, ImportProblem::NonFinite { element: found, .. } if *found == element), "{problem}");
        let message = problem.to_string();
        assert!(message.contains(&format!("accessors[{accessor}]")) && message.contains(attribute), "{message}");
    }
    for (planted, user) in [("input", "input"), ("output", "output")] {
        let mut model = Model::triangle();
        let keys = |name: &str, sound: [f32; 2]| if name == planted { [sound[0], f32::NAN] } else { sound };
        let input = model.floats("SCALAR", &keys("input", [0.0, 1.0]));
        let [first, second] = keys("output", [1.0, 2.0]);
        let output = model.floats("VEC3", &[first, 0.0, 0.0, second, 0.0, 0.0]);
        model.json["animations"] = json!([{
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
            "samplers": [{ "input": input, "output": output }],
        }]);
        let problem = model.problem();
        assert!(matches!(&problem, ImportProblem::NonFinite { at, element: 1 } if at.contains(user)), "{problem}");
    }
}

#[test]
fn indices_outside_their_list_are_found() {
    let mut beyond_the_vertices = Model::triangle();
    let indices = beyond_the_vertices.accessor(5121, "SCALAR", 3, &[0, 1, 3]);
    beyond_the_vertices.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let problem = beyond_the_vertices.problem();
    assert!(matches!(&problem, ImportProblem::BadIndex { index: 3, count: 3, .. }), "{problem}");

    for (pointer, value) in [
        ("/nodes/0/mesh", json!(7)),
        ("/nodes/0/skin", json!(0)),
        ("/nodes/0/camera", json!(0)),
        ("/nodes/0/children", json!([9])),
        ("/meshes/0/primitives/0/material", json!(3)),
        ("/meshes/0/primitives/0/indices", json!(9)),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(9)),
        ("/accessors/0/bufferView", json!(4)),
        ("/bufferViews/0/buffer", json!(1)),
        ("/scene", json!(2)),
        ("/scenes", json!([{ "nodes": [5] }])),
        ("/skins", json!([{ "joints": [1] }])),
        ("/textures", json!([{ "source": 0 }])),
        ("/materials", json!([{ "normalTexture": { "index": 0 } }])),
        ("/nodes/0/extensions", json!({ "KHR_lights_punctual": { "light": 0 } })),
        (
            "/animations",
            json!([{ "channels": [{ "sampler": 0, "target": { "node": 0, "path": "scale" } }], "samplers": [] }]),
        ),
    ] {
        let mut model = Model::triangle();
        let (parent, name) = pointer.rsplit_once('/').expect("a pointer");
        model.json.pointer_mut(parent).expect("the parent exists")[name] = value;
        let problem = model.problem();
        assert!(matches!(problem, ImportProblem::BadIndex { .. }), "{pointer}: {problem}");
    }
}

#[test]
fn joints_beyond_the_skin_are_found_unless_their_weight_is_zero() {
    let skinned = |weights: [f32; 4]| {
        let mut model = Model::triangle();
        let joints = model.accessor(5121, "VEC4", 3, &[0, 9, 0, 0].repeat(3));
        let weights = model.floats("VEC4", &weights.repeat(3));
        let attributes = &mut model.json["meshes"][0]["primitives"][0]["attributes"];
        attributes["JOINTS_0"] = json!(joints);
        attributes["WEIGHTS_0"] = json!(weights);
        model.json["nodes"] = json!([{ "mesh": 0, "skin": 0 }, {}, {}]);
        model.json["skins"] = json!([{ "joints": [1, 2] }]);
        model
    };
    let problem = skinned([0.5, 0.5, 0.0, 0.0]).problem();
    assert!(matches!(problem, ImportProblem::BadIndex { index: 9, count: 2, .. }), "{problem}");
    let scene = skinned([1.0, 0.0, 0.0, 0.0]).import().expect("the joint is not used");
    assert_eq!(scene.meshes[0].primitives[0].joints[0][0], [0; 4]);
}

#[test]
fn counts_are_checked_before_anything_is_allocated() {
    for (count, component_type) in [(4_u64, 5126), (1 << 40, 5126), (u64::MAX, 5126), (1 << 62, 5121)] {
        let mut model = Model::triangle();
        model.json["accessors"][0]["count"] = json!(count);
        model.json["accessors"][0]["componentType"] = json!(component_type);
        let problem = model.problem();
        assert!(matches!(problem, ImportProblem::OutOfBounds { .. }), "{count}: {problem}");
    }
    let mut none = Model::triangle();
    none.json["accessors"][0]["count"] = json!(0);
    assert!(matches!(none.problem(), ImportProblem::Accessor { .. }));

    let mut zeros = Model::triangle();
    zeros.json["accessors"][0]["count"] = json!(1_u64 << 33);
    zeros.json["accessors"][0].as_object_mut().expect("an object").remove("bufferView");
    assert!(matches!(zeros.problem(), ImportProblem::TooLarge { .. }));
}

#[test]
fn zeros_shared_by_many_primitives_are_bounded_together() {
    let mut model = Model::triangle();
    let zeros = json!({ "componentType": 5126, "type": "VEC3", "count": 3_000_000 });
    model.json["accessors"] = json!([zeros]);
    let primitive = json!({ "attributes": { "POSITION": 0 } });
    model.json["meshes"] = json!([{ "primitives": vec![primitive; 1000] }]);
    assert!(matches!(model.problem(), ImportProblem::TooLarge { .. }));
}

/// What multiplies without an accessor behind it: empty morph targets by primitives, weights by nodes.
#[test]
fn products_of_lists_are_bounded() {
    let morphing = |targets: usize, primitives: usize, nodes: usize| {
        let mut model = Model::triangle();
        let attributes = json!({ "POSITION": 0 });
        let mut list = vec![json!({ "attributes": attributes }); primitives];
        list.push(json!({ "attributes": attributes, "targets": vec![json!({}); targets] }));
        model.json["meshes"] = json!([{ "primitives": list }]);
        model.json["nodes"] = json!(vec![json!({ "mesh": 0 }); nodes]);
        model
    };
    let scene = morphing(5, 2, 2).import().expect("a sound model");
    assert!(scene.meshes[0].primitives.iter().all(|primitive| primitive.targets.len() == 5));
    assert!(scene.nodes.iter().all(|node| node.weights.len() == 5));
    for model in [morphing(10_000, 1000, 1), morphing(10_000, 0, 5000)] {
        let problem = model.problem();
        assert!(matches!(problem, ImportProblem::TooLarge { .. }), "{problem}");
    }
}

#[test]
fn strides_offsets_and_types_are_checked() {
    for (pointer, value) in [
        ("/bufferViews/0/byteStride", json!(4)),
        ("/bufferViews/0/byteStride", json!(0)),
        ("/accessors/0/type", json!("VEC2")),
        ("/accessors/0/componentType", json!(5125)),
    ] {
        let mut model = Model::triangle();
        let (parent, name) = pointer.rsplit_once('/').expect("a pointer");
        model.json.pointer_mut(parent).expect("the parent exists")[name] = value;
        let problem = model.problem();
        assert!(matches!(problem, ImportProblem::Accessor { .. }), "{pointer}: {problem}");
    }
    for (pointer, value) in [
        ("/bufferViews/0/byteStride", json!(u64::MAX)),
        ("/bufferViews/0/byteOffset", json!(u64::MAX)),
        ("/bufferViews/0/byteLength", json!(37)),
        ("/accessors/0/byteOffset", json!(u64::MAX)),
        ("/accessors/0/byteOffset", json!(1)),
    ] {
        let mut model = Model::triangle();
        let (parent, name) = pointer.rsplit_once('/').expect("a pointer");
        model.json.pointer_mut(parent).expect("the parent exists")[name] = value;
        let problem = model.problem();
        assert!(matches!(problem, ImportProblem::OutOfBounds { .. }), "{pointer}: {problem}");
    }
}

#[test]
fn attributes_of_another_length_are_refused() {
    let mut model = Model::triangle();
    let normals = model.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    model.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    assert!(matches!(model.problem(), ImportProblem::Accessor { .. }));
}

#[test]
fn required_extensions_are_refused_with_a_remedy() {
    for (name, remedy) in [
        ("KHR_draco_mesh_compression", "gltf-transform"),
        ("KHR_texture_basisu", "png"),
        ("ACME_unheard_of", "extensionsRequired"),
    ] {
        let mut model = Model::triangle();
        model.json["extensionsUsed"] = json!([name]);
        model.json["extensionsRequired"] = json!([name]);
        let problem = model.problem();
        assert!(problem.to_string().contains(name) && problem.to_string().contains(remedy), "{problem}");
        assert!(matches!(problem, ImportProblem::UnsupportedExtension { .. }));

        model.json["extensionsRequired"] = json!([]);
        assert_eq!(model.import().expect("optional").report.extensions_ignored, [name]);
    }
}

#[test]
fn compression_without_its_fallback_is_refused() {
    let mut draco = Model::triangle();
    draco.json["accessors"][0].as_object_mut().expect("an object").remove("bufferView");
    draco.json["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_draco_mesh_compression": {} });
    assert!(matches!(draco.problem(), ImportProblem::UnsupportedExtension { .. }));

    let mut empty = Model::triangle();
    empty.json["buffers"] = json!([{ "byteLength": 36 }]);
    let problem = import_bytes(empty.json.to_string().as_bytes()).expect_err("no data").problem;
    assert!(matches!(problem, ImportProblem::MissingBuffer { buffer: 0, .. }), "{problem}");
}

#[test]
fn json_is_named_by_place() {
    let problem = import_bytes(b"{ \"asset\": ").expect_err("cut short").problem;
    assert!(matches!(problem, ImportProblem::Json { .. }));
    let nested = "[".repeat(100_000);
    assert!(matches!(import_bytes(nested.as_bytes()).expect_err("nested").problem, ImportProblem::Json { .. }));

    let mut model = Model::triangle();
    model.json["nodes"][0]["rotation"] = json!([0, 0, 1]);
    assert!(matches!(model.problem(), ImportProblem::Schema { at, .. } if at == "nodes[0]"));
    model.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]);
    assert!(matches!(model.problem(), ImportProblem::Value { at, .. } if at.contains("body")));
}

#[test]
fn sparse_indices_and_values_are_checked() {
    let sparse = |index: u8, count: u64| {
        let mut model = Model::triangle();
        let (indices, values) = (model.view(&[index]), model.view(&[0; 12]));
        model.json["accessors"][0]["sparse"] = json!({
            "count": count,
            "indices": { "bufferView": indices, "componentType": 5121 },
            "values": { "bufferView": values },
        });
        model
    };
    assert!(sparse(2, 1).import().is_ok());
    assert!(matches!(sparse(3, 1).problem(), ImportProblem::BadIndex { index: 3, count: 3, .. }));
    assert!(matches!(sparse(0, 2).problem(), ImportProblem::OutOfBounds { .. }));
    assert!(matches!(sparse(0, u64::MAX).problem(), ImportProblem::OutOfBounds { .. }));

    let mut repeated = sparse(0, 4);
    let (indices, values) = (repeated.view(&[0, 1, 2, 0]), repeated.view(&[0; 48]));
    repeated.json["accessors"][0]["sparse"]["indices"]["bufferView"] = json!(indices);
    repeated.json["accessors"][0]["sparse"]["values"]["bufferView"] = json!(values);
    assert!(matches!(repeated.problem(), ImportProblem::Accessor { .. }));
}

#[test]
fn images_and_uris_are_checked() {
    let textured = |uri: &str| {
        let mut model = Model::triangle();
        model.json["images"] = json!([{ "name": "skin", "uri": uri }]);
        model.json["textures"] = json!([{ "source": 0 }]);
        model.json["materials"] = json!([{ "normalTexture": { "index": 0 } }]);
        model.problem()
    };
    assert!(matches!(textured("data:image/png;base64,AAAA"), ImportProblem::Image { at, .. } if at.contains("skin")));
    assert!(matches!(textured("data:image/png;base64,####"), ImportProblem::Uri { .. }));
    assert!(matches!(textured("https://example.com/skin.png"), ImportProblem::Uri { .. }));
    assert!(matches!(textured("skin.png"), ImportProblem::MissingFile { .. }));
    assert!(matches!(textured("."), ImportProblem::Unreadable { .. }));

    // One texel that says it is 16384x16384.
    let mut jpeg = Vec::new();
    image::codecs::jpeg::JpegEncoder::new(&mut jpeg).encode_image(&image::RgbImage::new(1, 1)).expect("encoded");
    let frame = jpeg.windows(2).position(|bytes| bytes == [0xFF, 0xC0]).expect("a frame");
    jpeg[frame + 5..frame + 9].copy_from_slice(&[0x40, 0, 0x40, 0]);
    let uri = format!("data:image/jpeg;base64,{}", STANDARD.encode(jpeg));
    assert!(matches!(textured(&uri), ImportProblem::Image { problem, .. } if problem.contains("truncated")));
}

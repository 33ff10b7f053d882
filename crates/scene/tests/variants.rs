//! KHR_materials_variants: each variant gives primitives their materials, in whatever order variants are selected.

mod common;

use common::Model;
use murano_scene::{ImportProblem, Scene};
use serde_json::{Value, json};

const NAME: &str = "KHR_materials_variants";

/// Three primitives, of which the first two have other materials in the variants "red" and "blue".
fn shoe(mappings: Value) -> Model {
    let mut model = Model::triangle();
    model.json["extensionsUsed"] = json!([NAME]);
    model.json["extensions"] =
        json!({ NAME: { "variants": [{ "name": "red" }, { "name": "blue" }, { "name": "bare" }] } });
    model.json["materials"] = json!([{ "name": "grey" }, { "name": "ruby" }, { "name": "sapphire" }]);
    let attributes = model.json["meshes"][0]["primitives"][0]["attributes"].clone();
    model.json["meshes"][0]["primitives"] = json!([
        { "attributes": attributes, "material": 0, "extensions": { NAME: { "mappings": mappings } } },
        { "attributes": attributes, "extensions": { NAME: { "mappings": [{ "material": 2, "variants": [1, 0] }] } } },
        { "attributes": attributes, "material": 0 },
    ]);
    model
}

fn sound() -> Model {
    shoe(json!([{ "material": 1, "variants": [0] }, { "material": 2, "variants": [1], "name": "of the sea" }]))
}

fn materials(scene: &Scene) -> Vec<Option<usize>> {
    scene.meshes[0].primitives.iter().map(|primitive| primitive.material).collect()
}

#[test]
fn variants_are_selected_in_any_order() {
    let mut scene = sound().import().expect("a sound model");
    assert_eq!(scene.variants, ["red", "blue", "bare"]);
    assert!(scene.report.extensions_ignored.is_empty() && scene.report.warnings.is_empty());
    let as_in_the_file = [Some(0), None, Some(0)];
    assert_eq!(materials(&scene), as_in_the_file);
    for (name, expected) in [
        ("blue", [Some(2), Some(2), Some(0)]),
        ("red", [Some(1), Some(2), Some(0)]),
        ("bare", as_in_the_file),
        ("red", [Some(1), Some(2), Some(0)]),
    ] {
        let index = scene.find_variant(name).expect("it is there");
        scene.select_variant(index).expect("it is there");
        assert_eq!(materials(&scene), expected, "{name}");
    }
}

#[test]
fn a_variant_that_is_not_there_is_answered_with_those_that_are() {
    let mut scene = sound().import().expect("a sound model");
    let by_name = scene.find_variant("green").expect_err("no such variant").to_string();
    let by_index = scene.select_variant(3).expect_err("no such variant").to_string();
    for (error, wanted) in [(by_name, "\"green\""), (by_index, "3")] {
        assert!(error.contains(wanted) && error.contains("0 \"red\", 1 \"blue\", 2 \"bare\""), "{error}");
    }
    assert_eq!(materials(&scene), [Some(0), None, Some(0)]);
    let mut plain = Model::triangle().import().expect("a sound model");
    assert!(plain.select_variant(0).expect_err("no variants").to_string().contains("has none"));
}

#[test]
fn wrong_mappings_are_found() {
    for mapping in [json!({ "material": 3, "variants": [0] }), json!({ "material": 0, "variants": [3] })] {
        let problem = shoe(json!([mapping])).problem();
        let ImportProblem::BadIndex { at, index: 3, .. } = &problem else { panic!("{problem}") };
        assert!(at.contains("primitives[0]") && at.contains("mappings[0]"), "{problem}");
    }
    for mappings in [json!(7), json!([{ "material": 0 }]), json!([{ "material": 0, "variants": ["red"] }])] {
        let problem = shoe(mappings).problem();
        assert!(matches!(problem, ImportProblem::Schema { .. }), "{problem}");
    }
    let twice = shoe(json!([{ "material": 1, "variants": [0] }, { "material": 2, "variants": [0] }]));
    let mut scene = twice.import().expect("the first counts");
    assert!(scene.report.warnings[0].contains("mappings[1]"), "{:?}", scene.report.warnings);
    scene.select_variant(0).expect("it is there");
    assert_eq!(materials(&scene)[0], Some(1));
}

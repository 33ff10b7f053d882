//! Real files: all of them import, or are refused for the reason known; malformed ones end in an error, never a panic.

mod common;

use std::collections::HashSet;
use std::panic::catch_unwind;
use std::time::{Duration, Instant};

use murano_scene::{ImportProblem, Interpolation, Local, Path, Primitive, Scene, import};

/// Files that need what this project refuses, by the extension or version.
const REFUSED: [(&str, &str); 4] = [
    ("CesiumMan_Draco/CesiumMan.gltf", "KHR_draco_mesh_compression"),
    ("derived/Fox_draco.glb", "KHR_draco_mesh_compression"),
    ("Compatibility/Compatibility_05.gltf", "FAKE_materials_quantumRendering"),
    ("Compatibility/Compatibility_04.gltf", "2.1"),
];

#[test]
fn every_model_imports_or_is_refused_for_the_known_reason() {
    let Some(folder) = common::data("gltf") else { return };
    let mut refused = 0;
    for path in common::models(&folder) {
        let known = REFUSED.iter().find(|(file, _)| path.ends_with(std::path::Path::new(file)));
        match (import(&path), known) {
            (Ok(scene), None) => check_invariants(&scene),
            (Err(error), Some((_, reason))) => {
                refused += 1;
                let (ImportProblem::UnsupportedExtension { name, .. } | ImportProblem::Version { version: name }) =
                    &error.problem
                else {
                    panic!("{error}");
                };
                assert_eq!(name, reason);
            }
            (Ok(_), Some(_)) => panic!("{} was not refused", path.display()),
            (Err(error), None) => panic!("{error}"),
        }
    }
    assert_eq!(refused, REFUSED.len());
}

#[test]
fn draco_is_refused_with_the_command_that_takes_it_out() {
    let Some(folder) = common::data("gltf") else { return };
    for file in ["CesiumMan_Draco/CesiumMan.gltf", "derived/Fox_draco.glb"] {
        let message = import(&folder.join(file)).expect_err("not supported").to_string();
        for part in [file, "KHR_draco_mesh_compression", "`gltf-transform copy in.glb out.glb`"] {
            assert!(message.contains(part), "{message}");
        }
    }
}

#[test]
fn scans_import() {
    let Some(folder) = common::data("paper") else { return };
    for (file, triangles) in [
        ("bunny_69k.glb", 69_451),
        ("buddha_100k.glb", 100_000),
        ("dragon_100k.glb", 100_000),
        ("armadillo_346k.glb", 345_928),
    ] {
        let scene = import(&folder.join(file)).expect(file);
        check_invariants(&scene);
        assert_eq!(triangle_count(&scene), triangles, "{file}");
        assert_eq!(scene.skins[0].joints.len(), 6, "{file}");
    }
}

/// Nodes, joints of the first skin, targets of the first primitive, clips, channels of all, length of the longest.
type Counts = (&'static str, usize, usize, usize, usize, usize, f64);

#[test]
fn known_files_have_their_known_counts() {
    let Some(folder) = common::data("gltf") else { return };
    let known: [Counts; 12] = [
        ("Fox.glb", 26, 24, 0, 3, 63, 3.416_67),
        ("CesiumMan.glb", 22, 19, 0, 1, 57, 2.0),
        ("RiggedFigure.glb", 22, 19, 0, 1, 57, 1.25),
        ("RiggedSimple.glb", 5, 2, 0, 1, 3, 2.083_33),
        ("RecursiveSkeletons.glb", 924, 10, 0, 1, 840, 2.0),
        ("AnimatedMorphCube.glb", 1, 0, 2, 1, 1, 4.2),
        ("AnimatedMorphSphere.glb", 1, 0, 2, 1, 1, 7.2),
        ("QuadSkin_JOINTS_0_1_2.glb", 23, 10, 0, 0, 0, 0.0),
        ("synthetic/Synth_1024joints_4influences.glb", 1025, 1024, 0, 1, 1024, 4.0),
        ("synthetic/Synth_64joints_12influences.glb", 65, 64, 0, 1, 64, 4.0),
        ("synthetic/Synth_256morphs_linear.glb", 1, 0, 256, 1, 1, 3.0),
        ("synthetic/Synth_12morphs_cubicspline.glb", 1, 0, 12, 1, 1, 3.0),
    ];
    for (file, nodes, joints, targets, clips, channels, duration) in known {
        let scene = import(&folder.join(file)).expect(file);
        assert_eq!(scene.nodes.len(), nodes, "{file}: nodes");
        assert_eq!(scene.skins.first().map_or(0, |skin| skin.joints.len()), joints, "{file}: joints");
        assert_eq!(scene.meshes[0].primitives[0].targets.len(), targets, "{file}: targets");
        assert_eq!(scene.clips.len(), clips, "{file}: clips");
        assert_eq!(scene.clips.iter().map(|clip| clip.channels.len()).sum::<usize>(), channels, "{file}: channels");
        let longest = scene.clips.iter().map(|clip| clip.duration).fold(0.0, f64::max);
        assert!((longest - duration).abs() < 1e-3, "{file}: {longest} s");
    }
}

#[test]
fn features_of_known_files_arrive() {
    let Some(folder) = common::data("gltf") else { return };
    let load = |file: &str| import(&folder.join(file)).expect(file);

    let quad = load("QuadSkin_JOINTS_0_1_2.glb");
    assert_eq!(quad.meshes[0].primitives[0].joints.len(), 3);
    assert!(quad.report.extensions_ignored.contains(&"FB_ngon_encoding".to_owned()));

    let ghost = load("Ghost_AnimationPointer.glb");
    assert!(!ghost.clips[0].channels.is_empty(), "pointers to nodes are channels");

    let splines = load("InterpolationTest.glb");
    let kinds: Vec<Interpolation> =
        splines.clips.iter().flat_map(|clip| &clip.channels).map(|channel| channel.sampler.interpolation).collect();
    for kind in [Interpolation::Step, Interpolation::Linear, Interpolation::CubicSpline] {
        assert_eq!(kinds.iter().filter(|&&k| k == kind).count(), 3);
    }

    let glass = load("synthetic/Synth_AnimationPointer_Material_Dispersion.glb");
    assert!(glass.materials.iter().any(|material| material.is_glass() && material.dispersion > 0.0));
    assert!(!glass.lights.is_empty() && !glass.cameras.is_empty());

    let attenuation = load("AttenuationTest.glb");
    assert!(attenuation.materials.iter().any(|material| material.attenuation_distance.is_finite()));
    assert!(!attenuation.images.is_empty());
    assert!(!load("PunctualLights.glb").lights.is_empty());
    assert_eq!(load("Cameras.gltf").cameras.len(), 2);
    assert_eq!(load("MultipleScenes.gltf").roots.len(), 1);
}

#[test]
fn quantized_equals_original() {
    let Some(folder) = common::data("gltf") else { return };
    let original = import(&folder.join("CesiumMan.glb")).expect("CesiumMan");
    let quantized = import(&folder.join("derived/CesiumMan_quantized_i16norm.glb")).expect("quantized");
    let positions = |scene: &Scene| scene.meshes[0].primitives[0].positions.clone();
    let (original_positions, quantized_positions) = (positions(&original), positions(&quantized));
    assert_eq!(original_positions.len(), quantized_positions.len());
    let (low, high) = original_positions
        .iter()
        .fold((glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    // The quantization's scale is in the inverse bind matrices; the fit of one axis gives it back.
    let spread = |positions: &[glam::Vec3]| {
        positions.iter().map(|p| p.y).fold(f32::NEG_INFINITY, f32::max)
            - positions.iter().map(|p| p.y).fold(f32::INFINITY, f32::min)
    };
    let scale = spread(&original_positions) / spread(&quantized_positions);
    let offset = original_positions[0] - quantized_positions[0] * scale;
    for (a, b) in original_positions.iter().zip(&quantized_positions) {
        assert!((*a - (*b * scale + offset)).length() < 2e-4 * (high - low).length(), "{a} {b}");
    }
    let (a, b) = (&original.meshes[0].primitives[0], &quantized.meshes[0].primitives[0]);
    // The quantizer sorted the influences of a vertex by weight.
    for vertex in 0..original_positions.len() {
        let influence = |primitive: &Primitive, joint: u16| -> f32 {
            let slots = primitive.joints[0][vertex].iter().zip(primitive.weights[0][vertex]);
            slots.filter(|(other, _)| **other == joint).map(|(_, weight)| weight).sum()
        };
        for joint in a.joints[0][vertex] {
            assert!((influence(a, joint) - influence(b, joint)).abs() < 0.01, "vertex {vertex}, joint {joint}");
        }
    }
    let normals = a.normals.as_ref().expect("normals").iter().zip(b.normals.as_ref().expect("normals"));
    for (a, b) in normals {
        assert!(a.dot(*b) > 0.999, "{a} {b}");
    }
}

#[test]
fn instances_of_known_files_arrive() {
    let Some(folder) = common::data("gltf") else { return };
    for (file, nodes, instances) in [("SimpleInstancing.glb", 1, 125), ("SharpGLTF_InstanceTest.glb", 1, 2500)] {
        let scene = import(&folder.join(file)).expect(file);
        check_invariants(&scene);
        assert!(scene.report.extensions_ignored.is_empty() && scene.report.warnings.is_empty(), "{file}");
        assert_eq!(scene.nodes.len(), nodes + instances, "{file}");
        assert_eq!(scene.nodes[0].mesh, None, "{file}");
        assert_eq!(scene.nodes[0].children.len(), instances, "{file}");
        assert_eq!(scene.traversal().len(), nodes + instances, "{file}");
        assert!(scene.nodes[1..].iter().all(|node| node.mesh == Some(0) && node.parent == Some(0)), "{file}");
        let distinct: HashSet<String> = scene.nodes[1..].iter().map(|node| format!("{:?}", node.local)).collect();
        assert_eq!(distinct.len(), instances, "{file}: no two instances coincide");
    }
}

/// Accessors, meshes, skins and their matrices that several elements share: one of each in the scene.
#[test]
fn shared_elements_are_imported_once() {
    let Some(folder) = common::data("gltf/asset-generator/Instancing") else { return };
    for path in common::models(&folder) {
        let scene = import(&path).expect("a sound model");
        check_invariants(&scene);
        let json: serde_json::Value =
            serde_json::from_slice(&std::fs::read(&path).expect("readable")).expect("it imports, so it parses");
        let listed = |name: &str| json[name].as_array().map_or(0, Vec::len);
        let counts = [scene.nodes.len(), scene.meshes.len(), scene.skins.len(), scene.clips.len()];
        assert_eq!(counts, ["nodes", "meshes", "skins", "animations"].map(listed), "{}", path.display());
        assert!(scene.report.warnings.is_empty(), "{}: {:?}", path.display(), scene.report.warnings);
    }
}

/// The same quantization of the fox, once as it is and once compressed. The compressor reorders triangles and vertices.
#[test]
fn compressed_equals_uncompressed() {
    let Some(folder) = common::data("gltf/derived") else { return };
    let plain = import(&folder.join("Fox_gltfpack_quant.glb")).expect("quantized");
    let compressed = import(&folder.join("Fox_gltfpack_meshopt.glb")).expect("compressed");
    let [ours, theirs] = [&compressed, &plain].map(|scene| sorted_triangles(&scene.meshes[0].primitives[0]));
    assert_eq!(ours.len(), theirs.len());
    for (place, name) in ATTRIBUTES.into_iter().enumerate() {
        let pairs = ours.iter().flatten().zip(theirs.iter().flatten());
        let difference = pairs.map(|(a, b)| largest_difference(&a[place], &b[place])).fold(0.0, f32::max);
        eprintln!("{name} differ by {difference}");
        assert_eq!(difference, 0.0, "{name}");
    }
    for (ours, theirs) in compressed.skins[0].inverse_bind.iter().zip(&plain.skins[0].inverse_bind) {
        assert_eq!(ours, theirs, "inverse bind matrices");
    }
    check_filtered_clips(&compressed, &plain);
}

/// The compressor's filters round what clips hold: quaternions, whose sign is free, to 1/4096, translations to 15 bits.
fn check_filtered_clips(compressed: &Scene, plain: &Scene) {
    let channels = |scene: &Scene| scene.clips.iter().flat_map(|clip| clip.channels.clone()).collect::<Vec<_>>();
    let (ours, theirs) = (channels(compressed), channels(plain));
    assert_eq!(ours.len(), theirs.len());
    let (mut rotations, mut translations) = (0.0_f32, 0.0_f32);
    for (ours, theirs) in ours.iter().zip(&theirs) {
        assert_eq!((ours.node, ours.path), (theirs.node, theirs.path));
        assert_eq!(ours.sampler.times, theirs.sampler.times);
        let (ours_values, theirs_values) = (&ours.sampler.values, &theirs.sampler.values);
        if ours.path == Path::Rotation {
            let keys = ours_values.as_chunks::<4>().0.iter().zip(theirs_values.as_chunks::<4>().0);
            let turned = keys.map(|(a, b)| largest_difference(a, b).min(largest_difference(a, &b.map(|value| -value))));
            rotations = turned.fold(rotations, f32::max);
        } else {
            translations = translations.max(largest_difference(ours_values, theirs_values));
        }
    }
    eprintln!("rotations differ by {rotations}, translations by {translations}");
    assert!(rotations < 3e-4 && translations < 1e-3, "{rotations}, {translations}");
}

const ATTRIBUTES: [&str; 4] = ["positions", "texcoords", "joints", "weights"];

/// The numbers of one vertex, by attribute.
type Corner = [Vec<f32>; ATTRIBUTES.len()];

/// The triangles of a primitive in an order of their own: each begins with its least corner, the least is first.
fn sorted_triangles(primitive: &Primitive) -> Vec<[Corner; 3]> {
    let corner = |vertex: u32| -> Corner {
        let vertex = vertex as usize;
        [
            primitive.positions[vertex].to_array().to_vec(),
            primitive.texcoords.iter().flat_map(|set| set[vertex].to_array()).collect(),
            primitive.joints.iter().flat_map(|set| set[vertex].map(f32::from)).collect(),
            primitive.weights.iter().flat_map(|set| set[vertex]).collect(),
        ]
    };
    let from_least = |triangle: &[u32; 3]| {
        let mut corners = triangle.map(corner);
        let turn = (0..3).min_by(|&a, &b| corners[a].partial_cmp(&corners[b]).expect("finite")).expect("three");
        corners.rotate_left(turn);
        corners
    };
    let mut triangles: Vec<[Corner; 3]> = primitive.triangles.iter().map(from_least).collect();
    triangles.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    triangles
}

fn largest_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn malformed_files_end_in_a_result_within_a_second() {
    let Some(folder) = common::data("malformed") else { return };
    let (mut imported, mut refused) = (0, 0);
    for path in common::models(&folder) {
        let start = Instant::now();
        let Ok(result) = catch_unwind(|| import(&path)) else { panic!("{} panics", path.display()) };
        assert!(start.elapsed() < Duration::from_secs(1), "{} takes {:?}", path.display(), start.elapsed());
        match result {
            Ok(scene) => {
                imported += 1;
                check_invariants(&scene);
            }
            Err(error) => {
                refused += 1;
                assert!(error.to_string().contains(&*path.to_string_lossy()), "{error}");
            }
        }
    }
    eprintln!("{imported} imported, {refused} refused");
    assert!(imported > 0 && refused > 0);
}

fn triangle_count(scene: &Scene) -> usize {
    scene.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|primitive| primitive.triangles.len()).sum()
}

/// What every imported scene promises to those who use it.
fn check_invariants(scene: &Scene) {
    for (index, node) in scene.nodes.iter().enumerate() {
        assert!(node.children.iter().all(|&child| scene.nodes[child].parent == Some(index)));
        assert!(node.mesh.is_none_or(|mesh| mesh < scene.meshes.len()));
        assert!(node.light.is_none_or(|light| light < scene.lights.len()));
        assert!(node.camera.is_none_or(|camera| camera < scene.cameras.len()));
        assert!(node.local.matrix().is_finite());
        if let Local::Trs(transform) = node.local {
            assert!(transform.rotation.is_normalized());
        }
        if let (Some(mesh), Some(skin)) = (node.mesh, node.skin) {
            let influences = scene.meshes[mesh].primitives.iter().flat_map(|primitive| &primitive.joints).flatten();
            let joints = scene.skins[skin].joints.len();
            assert!(influences.flatten().all(|&joint| usize::from(joint) < joints));
        }
        if let Some(mesh) = node.mesh {
            for primitive in &scene.meshes[mesh].primitives {
                assert_eq!(node.weights.len(), primitive.targets.len());
            }
        }
    }
    let mut visited = vec![false; scene.nodes.len()];
    for node in scene.traversal() {
        assert!(!visited[node] && scene.nodes[node].parent.is_none_or(|parent| visited[parent]));
        visited[node] = true;
    }
    for primitive in scene.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        check_primitive(scene, primitive);
    }
    for skin in &scene.skins {
        assert_eq!(skin.joints.len(), skin.inverse_bind.len());
        assert!(skin.joints.iter().all(|&joint| joint < scene.nodes.len()));
    }
    for clip in &scene.clips {
        for (index, channel) in clip.channels.iter().enumerate() {
            assert!(
                clip.channels[..index].iter().all(|other| (other.node, other.path) != (channel.node, channel.path))
            );
            let sampler = &channel.sampler;
            let tangents = if sampler.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
            assert_eq!(sampler.values.len(), sampler.times.len() * sampler.width * tangents);
            assert!(sampler.times.is_sorted_by(|a, b| a < b) && !sampler.times.is_empty());
            assert!(clip.duration >= f64::from(sampler.times[sampler.times.len() - 1]));
            let width = match channel.path {
                Path::Translation | Path::Scale => 3,
                Path::Rotation => 4,
                Path::Weights => scene.nodes[channel.node].weights.len(),
            };
            assert_eq!(sampler.width, width);
            assert!(channel.path == Path::Weights || matches!(scene.nodes[channel.node].local, Local::Trs(_)));
        }
    }
}

fn check_primitive(scene: &Scene, primitive: &Primitive) {
    let vertices = primitive.positions.len();
    assert!(primitive.triangles.iter().flatten().all(|&vertex| (vertex as usize) < vertices));
    assert!(primitive.positions.iter().all(|position| position.is_finite()));
    assert!(primitive.texcoords.iter().all(|set| set.len() == vertices));
    assert!(primitive.colors.as_ref().is_none_or(|colors| colors.len() == vertices));
    assert!(primitive.joints.iter().all(|set| set.len() == vertices));
    assert!(primitive.weights.iter().all(|set| set.len() == vertices));
    assert_eq!(primitive.joints.len(), primitive.weights.len());
    assert!(primitive.material.is_none_or(|material| material < scene.materials.len()));
    if let Some(normals) = &primitive.normals {
        assert_eq!(normals.len(), vertices);
        assert!(normals.iter().all(|normal| normal.is_normalized()));
    } else {
        assert_eq!(vertices, 3 * primitive.triangles.len());
        assert!(primitive.triangles.iter().flatten().enumerate().all(|(corner, &vertex)| corner as u32 == vertex));
    }
    for target in &primitive.targets {
        for list in [&target.positions, &target.normals, &target.tangents].into_iter().flatten() {
            assert_eq!(list.len(), vertices);
        }
    }
}

//! What the descriptions of the Khronos glTF-Asset-Generator's models say of the data in them. How the animated ones move is
//! tested where clips are played; what a picture of them shows is not repeated here.

mod common;

use std::path::PathBuf;

use glam::{DVec3, Vec2, Vec3, Vec4};
use murano_scene::{
    AlphaMode, ImportProblem, Interpolation, Local, Material, Path, Primitive, Sampler, Scene, TextureRef, Wrap, import,
};

/// Where the models of a group are; `None` where there are none.
fn files<const N: usize>(group: &str, numbers: [usize; N]) -> Option<[(String, PathBuf); N]> {
    let folder = common::data("gltf/asset-generator")?;
    Some(numbers.map(|number| {
        let label = format!("{group}_{number:02}");
        let file = folder.join(group).join(format!("{label}.gltf"));
        (label, file)
    }))
}

fn models<const N: usize>(group: &str, numbers: [usize; N]) -> Option<[(String, Scene); N]> {
    let files = files(group, numbers)?;
    Some(files.map(|(label, file)| {
        let scene = import(&file).unwrap_or_else(|error| panic!("{error}"));
        (label, scene)
    }))
}

fn model(group: &str, number: usize) -> Option<(String, Scene)> {
    models(group, [number]).map(|[model]| model)
}

fn primitive(scene: &Scene, mesh: usize) -> &Primitive {
    &scene.meshes[mesh].primitives[0]
}

/// Values of a vertex attribute at the corners of the triangles in turn. The models have no normals, so their triangles share no
/// vertices once imported.
fn at_corners<T: Copy>(primitive: &Primitive, values: &[T]) -> Vec<T> {
    primitive.triangles.iter().flatten().map(|&index| values[index as usize]).collect()
}

fn corners(primitive: &Primitive) -> Vec<Vec3> {
    at_corners(primitive, &primitive.positions)
}

fn texture(scene: &Scene, material: usize) -> TextureRef {
    scene.materials[material].base_color_texture.expect("a texture")
}

/// The name of the image that shows on a primitive.
fn image<'a>(scene: &'a Scene, primitive: &Primitive) -> &'a str {
    &scene.images[texture(scene, primitive.material.expect("a material")).image].name
}

/// The curve that drives a node, by a path.
fn curve<'a>(label: &str, scene: &'a Scene, node: usize, path: Path) -> &'a Sampler {
    let [clip] = &scene.clips[..] else { panic!("{label}: one animation") };
    let driving = clip.channels.iter().find(|channel| (channel.node, channel.path) == (node, path));
    &driving.unwrap_or_else(|| panic!("{label}: nodes[{node}] has no {path:?}")).sampler
}

#[track_caller]
fn assert_near(label: &str, actual: &[f32], expected: &[f32], tolerance: f32) {
    let near = actual.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(actual.len() == expected.len() && near, "{label}: {actual:?} are not {expected:?}");
}

#[test]
fn sparse_times_and_values_of_curves_replace_their_own_alone() {
    let Some([(input, input_scene), (output, output_scene)]) = models("Accessor_Sparse", [0, 1]) else { return };
    let [a, b] = [0, 1].map(|node| curve(&input, &input_scene, node, Path::Translation));
    assert_eq!((&a.times[..], &b.times[..]), (&[0.0, 1.0, 2.0][..], &[0.0, 1.5, 2.0][..]), "{input}: times");
    assert_eq!(a.values, b.values, "{input}: values are shared");

    let [a, b] = [0, 1].map(|node| curve(&output, &output_scene, node, Path::Translation));
    assert_eq!(a.times, b.times, "{output}: times are shared");
    assert_eq!(a.values, [0.0, 0.3, 0.0, 0.0, -0.3, 0.0, 0.0, 0.3, 0.0], "{output}: values of A");
    assert_eq!(b.values, [0.0, 0.3, 0.0, 0.0, 0.2, 0.0, 0.0, 0.3, 0.0], "{output}: values of B");
}

/// Both meshes are a square, but that in B the top left corner and the bottom right one are drawn in. `offset` leads from
/// the middle of A to that of B.
fn assert_two_corners_differ(label: &str, scene: &Scene, middle: Vec3, offset: Vec3) {
    let [a, b] = [0, 1].map(|mesh| corners(primitive(scene, mesh)));
    assert_eq!((a.len(), b.len()), (6, 6), "{label}: two triangles each");
    for (a, b) in a.into_iter().zip(b) {
        let moved = match (a - middle).to_array() {
            [x, y, _] if x < 0.0 && y > 0.0 => Vec3::X * 0.25,
            [x, y, _] if x > 0.0 && y < 0.0 => Vec3::X * -0.25,
            _ => Vec3::ZERO,
        };
        assert!((a + offset + moved).abs_diff_eq(b, 1e-6), "{label}: {a} has become {b}");
    }
    assert_eq!(image(scene, primitive(scene, 0)), "Textures/BaseColor_A.png", "{label}: mesh A");
    assert_eq!(image(scene, primitive(scene, 1)), "Textures/BaseColor_B.png", "{label}: mesh B");
}

#[test]
fn sparse_positions_and_indices_replace_two_corners() {
    let Some([(positions, positions_scene), (indices, indices_scene)]) = models("Accessor_Sparse", [2, 3]) else {
        return;
    };
    assert_two_corners_differ(&positions, &positions_scene, Vec3::ZERO, Vec3::ZERO);
    assert_two_corners_differ(&indices, &indices_scene, Vec3::ZERO, Vec3::ZERO);
    // Of six vertices each mesh uses four.
    for mesh in [0, 1] {
        let mut used = corners(primitive(&indices_scene, mesh));
        used.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).expect("finite"));
        used.dedup();
        assert_eq!(used.len(), 4, "{indices}: mesh {mesh}");
    }
}

#[test]
fn sparse_indices_of_every_type_find_their_elements() {
    let Some(times) = models("Accessor_SparseType", [0, 1, 2]) else { return };
    for (label, scene) in &times {
        let [a, b] = [0, 1].map(|node| curve(label, scene, node, Path::Rotation));
        assert_eq!((&a.times[..], &b.times[..]), (&[0.0, 1.0, 2.0][..], &[0.0, 1.5, 2.0][..]), "{label}: times");
        assert_eq!(a.values, b.values, "{label}: values are shared");
    }
    let Some((label, scene)) = model("Accessor_SparseType", 5) else { return };
    assert_two_corners_differ(&label, &scene, Vec3::X * -0.6, Vec3::X * 1.2);
}

/// Quaternions in normalised bytes and shorts: an eighth of a turn about X back and forth, in B a quarter back at the middle key.
#[test]
fn sparse_values_are_decoded_like_those_they_replace() {
    let Some(models) = models("Accessor_SparseType", [3, 4]) else { return };
    let (sine, cosine) = std::f32::consts::FRAC_PI_8.sin_cos();
    let quarter = std::f32::consts::FRAC_1_SQRT_2;
    for ((label, scene), full) in models.iter().zip([127.0, 32767.0]) {
        let [a, b] = [0, 1].map(|node| curve(label, scene, node, Path::Rotation));
        assert_eq!(a.times, b.times, "{label}: times are shared");
        let ends = [-sine, 0.0, 0.0, cosine];
        let with_middle = |middle: [f32; 4]| [ends, middle, ends].concat();
        assert_near(label, &a.values, &with_middle([sine, 0.0, 0.0, cosine]), 1.0 / full);
        assert_near(label, &b.values, &with_middle([-quarter, 0.0, 0.0, quarter]), 1.0 / full);
    }
}

#[test]
fn without_a_buffer_view_sparse_values_replace_zeros() {
    let Some((label, scene)) = model("Accessor_SparseType", 6) else { return };
    assert_eq!(scene.meshes.len(), 1, "{label}: one mesh");
    assert_eq!(image(&scene, primitive(&scene, 0)), "Textures/BaseColor_B.png", "{label}: it is B");
    let curve = curve(&label, &scene, 0, Path::Translation);
    assert_eq!(curve.values, [0.0, 0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 0.0], "{label}: values");
}

#[test]
fn rotations_are_fractions_of_their_type() {
    let Some(models) = models("Animation_SamplerType", [0, 1, 2]) else { return };
    let quarter = std::f32::consts::FRAC_1_SQRT_2;
    let [forth, none, back] = [[0.0, quarter, 0.0, quarter], [0.0, 0.0, 0.0, 1.0], [0.0, -quarter, 0.0, quarter]];
    let expected = [forth, none, back, none, forth].concat();
    for ((label, scene), step) in models.iter().zip([1e-6, 1.0 / 127.0, 1.0 / 32767.0]) {
        let curve = curve(label, scene, 0, Path::Rotation);
        assert_eq!(curve.interpolation, Interpolation::Linear, "{label}");
        assert_near(label, &curve.values, &expected, step);
    }
}

/// Texture coordinates and colours in floats, bytes and shorts, all in one buffer view: 0 and 1 are exact in each.
#[test]
fn interleaved_attributes_of_every_type_are_told_apart() {
    let Some(models) = models("Buffer_Interleaved", [0, 1, 2, 3, 4]) else { return };
    let [bottom_right, bottom_left, top_left, top_right] = [
        ([0.5, -0.5], [1.0, 1.0], [0.0, 1.0, 0.0]),
        ([-0.5, -0.5], [0.0, 1.0], [1.0, 0.0, 0.0]),
        ([-0.5, 0.5], [0.0, 0.0], [1.0, 1.0, 0.0]),
        ([0.5, 0.5], [1.0, 0.0], [0.0, 0.0, 1.0]),
    ];
    let square = [bottom_left, bottom_right, top_right, bottom_left, top_right, top_left];
    for (label, scene) in &models {
        let primitive = primitive(scene, 0);
        let positions = square.map(|(position, ..)| Vec2::from(position).extend(0.0));
        assert_eq!(corners(primitive), positions, "{label}: positions");
        let texcoords = square.map(|(_, texcoord, _)| Vec2::from(texcoord));
        assert_eq!(at_corners(primitive, &primitive.texcoords[0]), texcoords, "{label}: texture coordinates");
        let colors = square.map(|(.., color)| Vec3::from(color).extend(1.0));
        let stored = primitive.colors.as_ref().expect("colours");
        assert_eq!(at_corners(primitive, stored), colors, "{label}: colours");
        assert_eq!(image(scene, primitive), "Textures/BaseColor_Grey.png", "{label}: texture");
    }
}

#[test]
fn what_is_not_of_gltf_2_0_is_ignored() {
    let Some(models) = models("Compatibility", [0, 1, 2, 3, 6]) else { return };
    let [(_, control), (root, root_scene), (node, node_scene), (alpha, alpha_scene), (gloss, gloss_scene)] = &models;
    for (label, scene) in &models {
        assert_eq!(corners(primitive(scene, 0)), corners(primitive(control, 0)), "{label}: the square of the control");
        assert!(scene.report.warnings.is_empty(), "{label}: {:?}", scene.report.warnings);
    }
    assert_eq!(control.materials, [], "the control has minimal properties");
    assert!(root_scene.lights.is_empty(), "{root}: lights at the root are no lights");
    assert_eq!(node_scene.nodes[0].light, None, "{node}: a node's light is none");
    assert_eq!(alpha_scene.materials[0].alpha, AlphaMode::Blend, "{alpha}: of `alphaMode`, not of `alphaMode2`");

    // Specular-glossiness gives way to metallic-roughness.
    let name = "KHR_materials_pbrSpecularGlossiness".to_owned();
    assert_eq!(gloss_scene.report.extensions_ignored, [name], "{gloss}: ignored, and said");
    let fallback = Material { metallic: 0.0, ..Material::default() };
    assert_eq!(gloss_scene.materials, [fallback], "{gloss}: the material without the extension");
}

#[test]
fn what_cannot_be_loaded_is_refused_and_says_why() {
    let Some([(version, newer), (extension, extended)]) = files("Compatibility", [4, 5]) else { return };
    let error = import(&newer).expect_err("it needs glTF 2.1");
    assert!(matches!(&error.problem, ImportProblem::Version { version } if version == "2.1"), "{version}: {error}");
    assert!(error.to_string().contains("needs glTF 2.1, only 2.0 is supported"), "{version}: {error}");

    let error = import(&extended).expect_err("it needs an extension that nobody has");
    let name = "FAKE_materials_quantumRendering";
    let named = matches!(&error.problem, ImportProblem::UnsupportedExtension { name: found, .. } if found == name);
    assert!(named, "{extension}: {error}");
    assert!(error.to_string().contains(&format!("requires the extension {name}")), "{extension}: {error}");
}

#[test]
fn textures_share_images_and_samplers() {
    let Some([(image_only, wraps), (sampler_only, images), (both, factors)]) = models("Instancing", [0, 1, 2]) else {
        return;
    };
    assert_eq!(texture(&wraps, 0).image, texture(&wraps, 1).image, "{image_only}: the same image");
    assert_eq!(texture(&wraps, 0).wrap, [Wrap::Clamp; 2], "{image_only}: clamped to the edge");
    assert_eq!(texture(&wraps, 1).wrap, [Wrap::Mirror; 2], "{image_only}: mirrored");

    assert_eq!(texture(&images, 0).wrap, texture(&images, 1).wrap, "{sampler_only}: the same sampler");
    let names = [0, 1].map(|material| images.images[texture(&images, material).image].name.as_str());
    assert_eq!(names, ["Textures/BaseColor_A.png", "Textures/BaseColor_B.png"], "{sampler_only}: image A and image B");

    assert_eq!(texture(&factors, 0), texture(&factors, 1), "{both}: the same image");
    let colors = [0, 1].map(|material| factors.materials[material].base_color);
    assert_eq!(colors, [Vec4::ONE, Vec4::new(0.5, 0.5, 1.0, 1.0)], "{both}: no factor, and a blue one");
}

#[test]
fn primitives_share_materials_and_accessors() {
    let Some([(material, material_scene), (positions, positions_scene), (indices, indices_scene)]) =
        models("Instancing", [3, 4, 5])
    else {
        return;
    };
    let [whole, inner] = &material_scene.meshes[0].primitives[..] else { panic!("{material}: two primitives") };
    assert_eq!((whole.material, inner.material), (Some(0), Some(0)), "{material}: the same material");
    let extent = |primitive: &Primitive| {
        let texcoords = primitive.texcoords[0].iter();
        texcoords.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), &uv| (low.min(uv), high.max(uv)))
    };
    assert_eq!(extent(whole), (Vec2::ZERO, Vec2::ONE), "{material}: all of the texture");
    assert_eq!(extent(inner), (Vec2::splat(0.1), Vec2::splat(0.9)), "{material}: all but its border");

    for (label, scene) in [(&positions, &positions_scene), (&indices, &indices_scene)] {
        let [a, b] = [0, 1].map(|mesh| primitive(scene, mesh));
        assert_eq!(corners(a), corners(b), "{label}: the same square");
        assert_eq!(image(scene, a), "Textures/BaseColor_A.png", "{label}: texture A");
        assert_eq!(image(scene, b), "Textures/BaseColor_B.png", "{label}: texture B");
    }
}

#[test]
fn nodes_share_meshes_and_skins() {
    let Some([(mesh, mesh_scene), (skin, skin_scene)]) = models("Instancing", [6, 7]) else { return };
    assert_eq!((mesh_scene.nodes[0].mesh, mesh_scene.nodes[1].mesh), (Some(0), Some(0)), "{mesh}: the same mesh");
    let places = [0, 1].map(|node| match mesh_scene.nodes[node].local {
        Local::Trs(own) => own.translation,
        Local::Matrix(_) => panic!("{mesh}: no matrix"),
    });
    assert!(places[0].abs_diff_eq(DVec3::X * -0.6, 1e-7) && places[1].abs_diff_eq(DVec3::X * 0.6, 1e-7), "{mesh}");

    let [first, second] = [0, 3].map(|node| &skin_scene.nodes[node]);
    assert_eq!((first.skin, second.skin), (Some(0), Some(0)), "{skin}: the same skin");
    let [first, second] = [first, second].map(|node| corners(primitive(&skin_scene, node.mesh.expect("a mesh"))));
    assert_ne!(first, second, "{skin}: positions of their own");
}

#[test]
fn skins_share_joints_and_matrices() {
    let Some([(joints, joints_scene), (matrices, matrices_scene)]) = models("Instancing", [8, 9]) else { return };
    let [first, second] = &joints_scene.skins[..] else { panic!("{joints}: two skins") };
    assert_eq!(first.joints, second.joints, "{joints}: the same joints");
    assert_ne!(first.inverse_bind, second.inverse_bind, "{joints}: matrices of their own");

    let [first, second] = &matrices_scene.skins[..] else { panic!("{matrices}: two skins") };
    assert_eq!(first.inverse_bind, second.inverse_bind, "{matrices}: the same matrices");
    let base = |joint: usize| matrices_scene.nodes[joint].local.matrix().w_axis.truncate();
    let apart = base(second.joints[0]) - base(first.joints[0]);
    assert!(apart.abs_diff_eq(DVec3::X * 0.6, 1e-6), "{matrices}: base joints are {apart} apart");
}

#[test]
fn channels_and_samplers_share_samplers_times_and_values() {
    let Some(models) = models("Instancing", [10, 11, 12]) else { return };
    for ((label, scene), same) in models.iter().zip([[true, true], [true, false], [false, true]]) {
        let [first, second] = [0, 1].map(|node| curve(label, scene, node, Path::Rotation));
        assert_eq!([first.times == second.times, first.values == second.values], same, "{label}: times, values");
    }
}

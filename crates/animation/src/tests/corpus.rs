//! Every clip of model files that are kept beside the project; skipped where they are not.

use std::path::{Path, PathBuf};

use glam::{DMat4, DVec3};
use murano_scene::{ImportProblem, Interpolation, Local, LoopMode, Path as Property, Scene, import};

use super::{deform, deform_packed};
use crate::{Bounds, Deformed, Geometry, Layer, Pose, Rig, clip_time, deform_f64, shown_primitives};

/// Times at which each clip is looked at.
const SAMPLES: u32 = 50;

/// Largest difference allowed between the f32 arrays and the truth, in diameters of the body.
const TOLERANCE: f64 = 1e-5;

const SCANS: [&str; 2] = ["paper/bunny_69k.glb", "paper/armadillo_346k.glb"];

/// The folder of models, or `None` (said on stderr) where there is none.
pub(super) fn models() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: no models at {}", folder.display());
    None
}

pub(super) fn load(folder: &Path, file: &str) -> Scene {
    import(&folder.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// Every model below the folder of glTF files, by its path in the folder of models, but for those that the import refuses.
fn all(folder: &Path) -> Vec<(String, Scene)> {
    let mut files = Vec::new();
    let mut folders = vec![folder.join("gltf")];
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        let (inner, others): (Vec<PathBuf>, Vec<PathBuf>) = entries.partition(|path| path.is_dir());
        folders.extend(inner);
        files.extend(
            others.into_iter().filter(|path| path.extension().is_some_and(|kind| kind == "glb" || kind == "gltf")),
        );
    }
    files.sort();
    let named = |path: PathBuf| {
        let name = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
        match import(&path).map_err(|error| error.problem) {
            Ok(scene) => Some((name, scene)),
            // Which files these are is held where the import is tested.
            Err(ImportProblem::UnsupportedExtension { .. } | ImportProblem::Version { .. }) => None,
            Err(problem) => panic!("{name}: {problem}"),
        }
    };
    files.into_iter().filter_map(named).collect()
}

/// The rest pose and every clip at [`SAMPLES`] times over the whole of it: in f64, and as a rig poses it.
pub(super) fn poses(scene: &Scene) -> impl Iterator<Item = (String, [Pose; 2])> {
    let rig = Rig::new(scene);
    let of = move |playing: &[Layer]| [Pose::sample(scene, playing), rig.pose(playing)];
    let rest = of(&[]);
    let clips = (0..scene.clips.len()).flat_map(move |clip| {
        let time = move |sample: u32| scene.clips[clip].duration * f64::from(sample) / f64::from(SAMPLES - 1);
        (0..SAMPLES).map(move |sample| (clip, time(sample)))
    });
    let posed = clips.map(move |(clip, time)| (format!("clip {clip} at {time} s"), of(&[Layer::new(clip, time)])));
    std::iter::once(("rest".to_string(), rest)).chain(posed)
}

/// What must hold of a deformed body in any pose; returns the largest difference of the packed arrays, in diameters.
fn check(label: &str, geometry: &Geometry, pose: &Pose, truth: &Deformed) -> f64 {
    assert!(truth.positions.iter().all(|position| position.is_finite()), "{label}: a position is not finite");
    let is_direction = |normal: &DVec3| *normal == DVec3::ZERO || (normal.length() - 1.0).abs() < 1e-9;
    assert!(truth.normals.iter().all(is_direction), "{label}: a normal is not unit");

    let bounds = truth.bounds();
    let posed = geometry.posed_bounds(pose);
    assert!(truth.positions.iter().all(|&position| posed.contains(position)), "{label}: {posed:?} lacks {bounds:?}");

    let packed = deform_packed(geometry, pose, bounds.center());
    assert!(packed.iter().all(|&position| posed.contains(position)), "{label}: {posed:?} lacks the f32 body");
    let worst = truth.positions.iter().zip(&packed).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(worst <= TOLERANCE * bounds.diameter(), "{label}: {worst} m of {}", bounds.diameter());
    worst / bounds.diameter().max(f64::MIN_POSITIVE)
}

/// The rig's pose is that in f64, also of nodes that show nothing: within [`TOLERANCE`] of the largest number, or of 1.
fn check_pose(label: &str, exact: &Pose, posed: &Pose) {
    let numbers = |pose: &Pose| -> [Vec<f64>; 2] {
        let matrices = pose.world_from_node.iter().flat_map(DMat4::to_cols_array).collect();
        [matrices, pose.weights.iter().flatten().copied().collect()]
    };
    for (exact, posed) in numbers(exact).iter().zip(&numbers(posed)) {
        assert!(exact.iter().chain(posed).all(|number| number.is_finite()), "{label}: not finite");
        let largest = exact.iter().fold(1.0, |largest: f64, number| largest.max(number.abs()));
        let worst = exact.iter().zip(posed).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst <= TOLERANCE * largest, "{label}: differs by {worst} of {largest}");
    }
}

fn check_model(file: &str, scene: &Scene) {
    let geometry = Geometry::build(scene, &shown_primitives(scene)).unwrap();
    let mut worst = 0.0f64;
    for (when, [exact, posed]) in poses(scene) {
        let label = format!("{file}, {when}");
        check_pose(&label, &exact, &posed);
        let truth = deform_f64(&geometry, scene, &exact);
        worst = worst.max(check(&label, &geometry, &posed, &truth));
    }
    eprintln!("{file}: {} vertices, packed within {worst:.1e} of the diameter", geometry.vertices.len());
}

#[test]
fn every_model_deforms_in_every_clip() {
    let Some(folder) = models() else { return };
    for (file, scene) in all(&folder) {
        check_model(&file, &scene);
    }
}

#[test]
fn scans_deform_in_every_clip() {
    let Some(folder) = models() else { return };
    for file in SCANS {
        check_model(file, &load(&folder, file));
    }
}

#[test]
fn at_a_key_the_pose_has_the_key() {
    let Some(folder) = models() else { return };
    for (file, scene) in all(&folder) {
        for (clip_index, clip) in scene.clips.iter().enumerate() {
            // Every channel at a key of the longest: poses of large scenes are not free.
            let Some(longest) = clip.channels.iter().max_by_key(|channel| channel.sampler.times.len()) else {
                continue;
            };
            for &time in longest.sampler.times.iter().step_by(7) {
                let pose = Pose::sample(&scene, &Layer::alone(Some(clip_index), f64::from(time)));
                for channel in &clip.channels {
                    let sampler = &channel.sampler;
                    let Some(key) = sampler.times.iter().position(|&other| other == time) else { continue };
                    let row = if sampler.interpolation == Interpolation::CubicSpline { 3 * key + 1 } else { key };
                    let value = &sampler.values[row * sampler.width..(row + 1) * sampler.width];
                    assert_key(&file, &pose, channel.node, channel.path, value);
                }
            }
        }
    }
}

fn assert_key(file: &str, pose: &Pose, node: usize, property: Property, value: &[f32]) {
    let posed = match (property, pose.locals[node]) {
        (Property::Weights, _) => pose.weights[node].clone(),
        (Property::Translation, Local::Trs(own)) => own.translation.to_array().to_vec(),
        (Property::Scale, Local::Trs(own)) => own.scale.to_array().to_vec(),
        (Property::Rotation, Local::Trs(own)) => own.rotation.to_array().to_vec(),
        (_, Local::Matrix(_)) => return,
    };
    // Stored rotations are not quite unit, sampled ones are; all else is the key to the bit.
    let (length, tolerance) = match property {
        Property::Rotation => (value.iter().map(|&key| f64::from(key).powi(2)).sum::<f64>().sqrt(), 1e-14),
        _ => (1.0, 0.0),
    };
    let differs = posed.iter().zip(value).any(|(&posed, &key)| (posed - f64::from(key) / length).abs() > tolerance);
    assert!(!differs, "{file}, node {node}, {property:?}: {posed:?} is not {value:?}");
}

#[test]
fn a_step_clip_jumps_and_a_linear_one_glides() {
    let Some(folder) = models() else { return };
    let scene = load(&folder, "gltf/InterpolationTest.glb");
    assert_eq!(scene.clips.len(), 9);
    for (index, clip) in scene.clips.iter().enumerate() {
        let sampler = &clip.channels[0].sampler;
        let node = clip.channels[0].node;
        let local = |time: f64| Pose::sample(&scene, &Layer::alone(Some(index), time)).locals[node].matrix();
        let [first, second] = [sampler.times[0], sampler.times[1]].map(f64::from);
        let moved = !local(first).abs_diff_eq(local(0.5 * (first + second)), 1e-9);
        assert_eq!(moved, sampler.interpolation != Interpolation::Step, "clip {index} {:?}", clip.name);
    }
}

#[test]
fn known_bodies_have_their_known_sizes() {
    let Some(folder) = models() else { return };
    let bounds_of = |file: &str, clip: Option<usize>, time: f64| {
        let scene = load(&folder, file);
        let time = clip.map_or(0.0, |clip| clip_time(LoopMode::Loop, time, scene.clips[clip].duration));
        deform(&scene, &Pose::sample(&scene, &Layer::alone(clip, time))).1.bounds()
    };
    let size = |bounds: Bounds| bounds.max - bounds.min;
    for time in [0.0, 0.3, 0.6] {
        let fox = size(bounds_of("gltf/Fox.glb", Some(1), time));
        assert!((60.0..95.0).contains(&fox.y) && (120.0..200.0).contains(&fox.z), "{fox}");
        let man = size(bounds_of("gltf/CesiumMan.glb", Some(0), time));
        assert!((1.35..1.65).contains(&man.y) && man.x < 1.2 && man.z < 1.2, "{man}");
    }
    // The strip of the glTF tutorial is 1 by 2 metres and bends at half of its height.
    let strip = bounds_of("gltf/SimpleSkin.gltf", None, 0.0);
    assert_eq!((strip.min, strip.max), (DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.5, 2.0, 0.0)));
    let bent = bounds_of("gltf/SimpleSkin.gltf", Some(0), 1.0);
    assert!(bent.max.x > 0.9 || bent.min.x < -0.9, "{bent:?}");
}

#[test]
fn further_joint_sets_reach_the_vertices() {
    let Some(folder) = models() else { return };
    for (file, sets) in [
        ("gltf/QuadSkin_JOINTS_0_1_2.glb", 3),
        ("gltf/MagnumSkinMultipleSets_JOINTS_1/skin-multiple-sets.gltf", 2),
        ("gltf/synthetic/Synth_64joints_12influences.glb", 3),
    ] {
        let scene = load(&folder, file);
        let geometry = Geometry::build(&scene, &shown_primitives(&scene)).unwrap();
        assert!(scene.meshes.iter().flat_map(|mesh| &mesh.primitives).any(|primitive| primitive.joints.len() == sets));
        let most = geometry.influence_offsets.windows(2).map(|pair| pair[1] - pair[0]).max();
        assert!(most > Some(4), "{file}: at most {most:?} influences a vertex");
    }
}

#[test]
fn mirrored_models_are_recognised() {
    let Some(folder) = models() else { return };
    let scene = load(&folder, "gltf/NegativeScaleTest.glb");
    let pose = Pose::rest(&scene);
    let (geometry, truth) = deform(&scene, &pose);
    assert!(geometry.mirrored(&pose).contains(&true) && geometry.mirrored(&pose).contains(&false));
    let agrees = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|index| truth.positions[index as usize]);
        (b - a).cross(c - a).dot(truth.normals[triangle[0] as usize]) > 0.0
    };
    let triangles = geometry.oriented_triangles(&pose);
    let agreeing = triangles.iter().filter(|triangle| agrees(triangle)).count();
    assert!(agreeing * 100 > triangles.len() * 98, "{agreeing} of {}", triangles.len());
}

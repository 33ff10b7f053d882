//! The GPU's deformation against glTF's in f64: positions within 1e-5 of the body's diameter, normals within 0.1 degrees,
//! everything finite.
//!
//! A normal is compared where it is well-conditioned: where the f64 truth has one, and moving the body's points within
//! the tolerance for positions cannot turn it that far (see [`regular`]).

use std::{
    collections::HashSet,
    ffi::OsStr,
    fs,
    path::{Path, PathBuf},
    sync::{LazyLock, Mutex, PoisonError},
};

use glam::{DMat3, DMat4, DQuat, DVec3, DVec4, Vec2, Vec3, Vec4};
use murano_animation::{
    Character, Crowd, Deformed, Geometry, GeometryLeaves, Layer, Pose, Rig, deform_f64, shown_primitives,
};
use murano_gpu::{Gpu, Work};
use murano_render::{Renderer, World};
use murano_scene::{
    Image, Local, Material, Mesh, MorphTarget, Node, Primitive, Scene, Skin, Skinning, TextureRef, Transform, Wrap,
    import,
};
use murano_scheduler::{History, Plan, Skipping};
use murano_tests::bench::{asset, gpu, shared};

/// Largest difference allowed, in diameters of the posed body.
const POSITION: f64 = 1e-5;
/// Largest angle allowed between normals, degrees.
const NORMAL: f64 = 0.1;

/// Times at which each clip is looked at.
const SAMPLES: u32 = 50;

/// One device for all tests, one test at a time: what it keeps is then bounded once.
static GPU: LazyLock<Mutex<Gpu>> = LazyLock::new(|| Mutex::new(gpu()));

/// The largest differences found in a model.
#[derive(Clone, Copy, Default)]
struct Worst {
    poses: usize,
    vertices: usize,
    /// Diameters.
    position: f64,
    /// Degrees.
    normal: f64,
    /// Largest share of vertices whose normal says nothing, of any pose.
    irregular: f64,
}

impl Worst {
    fn row(&self, name: &str) -> String {
        format!(
            "{name:<60} {:>8} {:>5} {:>10.2e} {:>9.1e} {:>8.3} %",
            self.vertices,
            self.poses,
            self.position,
            self.normal,
            100.0 * self.irregular
        )
    }

    fn assert(&self, name: &str) {
        assert!(self.position <= POSITION, "{name}: off by {:e} of the diameter", self.position);
        assert!(self.normal <= NORMAL, "{name}: a normal is off by {} degrees", self.normal);
    }

    fn include(&mut self, geometry: &Geometry, truth: &Deformed, positions: &[DVec3], normals: &[DVec3], what: &str) {
        let diameter = truth.bounds().diameter();
        assert!(positions.iter().chain(normals).all(|v| v.is_finite()), "{what}: not finite");
        let mut irregular = 0;
        for (vertex, (found, wanted)) in positions.iter().zip(&truth.positions).enumerate() {
            let off = found.distance(*wanted);
            self.position = self.position.max(if off == 0.0 { 0.0 } else { off / diameter });
            let (found, wanted) = (normals[vertex], truth.normals[vertex]);
            if found != DVec3::ZERO && wanted != DVec3::ZERO && regular(geometry, truth, vertex, diameter) {
                let angle = found.cross(wanted).length().atan2(found.dot(wanted)).to_degrees();
                self.normal = self.normal.max(angle);
            } else {
                irregular += 1;
            }
        }
        self.poses += 1;
        self.vertices = positions.len();
        self.irregular = self.irregular.max(f64::from(irregular) / positions.len().max(1) as f64);
    }
}

/// Whether a normal is well-conditioned. A smooth one is that of the mesh, turned by a matrix. That of a deformed
/// triangle is turned by half the tolerance for positions over its height; below a height of 2e-3 diameters that alone
/// exceeds the tolerance for normals.
fn regular(geometry: &Geometry, truth: &Deformed, vertex: usize, diameter: f64) -> bool {
    let corner = geometry.vertices[vertex].corner as usize;
    if corner == 0 {
        return true;
    }
    let first = vertex + 1 - corner;
    let [a, b, c] = [0, 1, 2].map(|next| truth.positions[first + next]);
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let height = (b - a).cross(c - a).length() / longest;
    height > 2e-3 * diameter
}

/// The rest pose and every clip at `samples` times over the whole of it: in f64, and as a rig poses it.
fn poses(scene: &Scene, samples: u32) -> impl Iterator<Item = (String, [Pose; 2])> {
    let rig = Rig::new(scene);
    let of = move |playing: &[Layer]| [Pose::sample(scene, playing), rig.pose(playing)];
    let rest = of(&[]);
    let time = move |clip: usize, sample: u32| {
        scene.clips[clip].duration * f64::from(sample) / f64::from(samples - 1).max(1.0)
    };
    let moments =
        (0..scene.clips.len()).flat_map(move |clip| (0..samples).map(move |sample| (clip, time(clip, sample))));
    let posed = moments.map(move |(clip, time)| (format!("clip {clip} at {time} s"), of(&[Layer::new(clip, time)])));
    std::iter::once(("rest".to_owned(), rest)).chain(posed)
}

/// Rows of three numbers and one that does not matter here.
fn vectors(bytes: &[u8], count: usize) -> Vec<DVec3> {
    let number = |bytes: &[u8]| f64::from(f32::from_le_bytes(bytes.try_into().expect("4 bytes")));
    let row = |row: &[u8]| DVec3::new(number(&row[0..4]), number(&row[4..8]), number(&row[8..12]));
    bytes.chunks_exact(16).take(count).map(row).collect()
}

/// Deforms a model in many poses.
fn measure(gpu: &Gpu, path: &Path, samples: u32, skinning: Skinning) -> Option<Worst> {
    let mut scene = import(path).ok()?;
    scene.skinning = skinning;
    let geometry = Geometry::build(&scene, &shown_primitives(&scene)).unwrap_or_else(|error| panic!("{error}"));
    let leaves = GeometryLeaves::new(&geometry);
    let mut worst = Worst::default();
    for (when, [exact, pose]) in poses(&scene, samples) {
        let what = format!("{}, {when}", path.display());
        let origin = geometry.posed_bounds(&pose).center();
        let origin = if origin.is_finite() { origin } else { DVec3::ZERO };
        let mut plan: Plan<Work> = Plan::new();
        let deformed =
            leaves.deform(gpu, &mut plan, 0, &geometry, &pose, origin).unwrap_or_else(|e| panic!("{what}: {e}"));
        let targets = [deformed.positions, deformed.normals];
        let executed = gpu
            .execute(&plan, &targets, &mut History::new(), Skipping::Off)
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        let [mut positions, normals] = [0, 1].map(|i| vectors(&executed.targets[i], geometry.vertices.len()));
        for position in &mut positions {
            *position += origin;
        }
        worst.include(&geometry, &deform_f64(&geometry, &scene, &exact), &positions, &normals, &what);
    }
    Some(worst)
}

/// Measures models and prints a table; those that do not import are for the importer's tests.
fn survey(models: &[PathBuf], samples: u32, skinning: Skinning) {
    let gpu = GPU.lock().unwrap_or_else(PoisonError::into_inner);
    let heading = ["model", "vertices", "poses", "diameters", "degrees", "irregular"];
    let [model, vertices, poses, diameters, degrees, irregular] = heading;
    eprintln!("{model:<60} {vertices:>8} {poses:>5} {diameters:>10} {degrees:>9} {irregular:>10}");
    let mut all = Vec::new();
    for path in models {
        let name = path.iter().rev().take(2).collect::<Vec<&OsStr>>();
        let name = name.iter().rev().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/");
        match measure(&gpu, path, samples, skinning) {
            Some(worst) => {
                eprintln!("{}", worst.row(&name));
                all.push((name, worst));
            }
            None => eprintln!("{name:<60} does not import"),
        }
    }
    for (name, worst) in &all {
        worst.assert(name);
    }
    assert!(!all.is_empty(), "no model imports");
}

fn data(files: &[&str]) -> Vec<PathBuf> {
    files.iter().filter_map(|file| shared(&format!("data/{file}"))).collect()
}

/// Every model below a folder.
fn models_in(folder: &Path) -> Vec<PathBuf> {
    let mut models = Vec::new();
    let mut entries: Vec<PathBuf> =
        fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            models.extend(models_in(&path));
        } else if path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf") {
            models.push(path);
        }
    }
    models
}

#[test]
fn our_own_models_deform_as_in_f64() {
    survey(&models_in(&asset("")), SAMPLES, Skinning::Linear);
}

#[test]
fn known_characters_deform_as_in_f64() {
    let models = data(&["gltf/Fox.glb", "gltf/CesiumMan.glb", "gltf/RiggedFigure.glb", "gltf/AnimatedMorphCube.glb"]);
    if !models.is_empty() {
        survey(&models, SAMPLES, Skinning::Linear);
    }
}

#[test]
fn large_scans_deform_as_in_f64() {
    let models = data(&["paper/bunny_69k.glb", "paper/armadillo_346k.glb"]);
    if !models.is_empty() {
        survey(&models, SAMPLES, Skinning::Linear);
    }
}

#[test]
fn every_model_at_hand_deforms_as_in_f64() {
    let known: HashSet<PathBuf> =
        data(&["gltf/Fox.glb", "gltf/CesiumMan.glb", "gltf/RiggedFigure.glb", "gltf/AnimatedMorphCube.glb"])
            .into_iter()
            .collect();
    let Some(folder) = shared("data/gltf") else { return };
    let models: Vec<PathBuf> = models_in(&folder).into_iter().filter(|path| !known.contains(path)).collect();
    survey(&models, SAMPLES, Skinning::Linear);
}

#[test]
fn dual_quaternions_deform_as_in_f64() {
    let mut models = models_in(&asset(""));
    models.extend(data(&["gltf/Fox.glb", "gltf/CesiumMan.glb", "gltf/RiggedFigure.glb", "paper/bunny_69k.glb"]));
    survey(&models, 10, Skinning::DualQuaternion);
}

/// What the renderer makes of a model is what the deformation makes of it, however it is sorted into bodies.
#[test]
fn the_renderer_deforms_as_in_f64() {
    let path = asset("dancer.glb");
    let scene = import(&path).unwrap_or_else(|error| panic!("{error}"));
    let duration = scene.clips[0].duration;
    let world = World { scene, environment: None, floor: None };
    let mut renderer = Renderer::new(gpu(), world).unwrap_or_else(|error| panic!("{error}"));
    let mut worst = Worst::default();
    for sample in 0..5 {
        let time = duration * f64::from(sample) / 5.0;
        let meshes = renderer.deform(&Layer::alone(Some(0), time)).unwrap_or_else(|error| panic!("{error}"));
        assert!(meshes.iter().any(|mesh| !mesh.positions.is_empty()));
        for mesh in meshes.iter().filter(|mesh| !mesh.positions.is_empty()) {
            let scene = &renderer.world().scene;
            let truth = deform_f64(&mesh.geometry, scene, &Pose::sample(scene, &Layer::alone(Some(0), time)));
            worst.include(&mesh.geometry, &truth, &mesh.positions, &mesh.normals, &format!("dancer at {time} s"));
        }
    }
    worst.assert("dancer.glb");
}

/// Forty dancers in one dispatch a block, each at a time and place of its own; who stands still costs nothing the next time.
#[test]
fn a_crowd_deforms_as_each_by_itself() {
    let scene = import(&asset("dancer.glb")).unwrap_or_else(|error| panic!("{error}"));
    let geometry = Geometry::build(&scene, &shown_primitives(&scene)).unwrap_or_else(|error| panic!("{error}"));
    let leaves = GeometryLeaves::new(&geometry);
    let mut crowd = Crowd::new(Rig::new(&scene), geometry.clone());
    let character = |index: u32| Character {
        playing: Layer::alone(Some(0), 0.05 * f64::from(index)),
        place: DMat4::from_rotation_y(f64::from(index)) * DMat4::from_translation(DVec3::new(0.0, 0.0, 4.0)),
    };
    let mut characters: Vec<Character> = (0..40).map(character).collect();
    let gpu = GPU.lock().unwrap_or_else(PoisonError::into_inner);
    let mut history = History::new();
    for (moves, ran) in [(40, 2), (0, 0), (1, 1)] {
        if moves == 1 {
            characters[35] = character(60);
        }
        assert_eq!(crowd.update(&characters, DVec3::ZERO), moves);
        let mut plan: Plan<Work> = Plan::new();
        let blocks: Vec<_> = (0..)
            .zip(crowd.blocks())
            .map(|(number, block)| {
                leaves.deform_block(&gpu, &mut plan, number, block).unwrap_or_else(|e| panic!("{e}"))
            })
            .collect();
        let executed = gpu
            .execute(&plan, blocks.as_flattened(), &mut history, Skipping::On)
            .unwrap_or_else(|error| panic!("{error}"));
        let steps = executed.schedule.steps.iter().filter(|step| step.decision.name() == "ran").count();
        assert_eq!(steps, ran, "{moves} moved");
        let count = geometry.vertices.len();
        let all = |k: usize| -> Vec<DVec3> {
            let buffers = executed.targets.chunks(2).zip(crowd.blocks());
            buffers.flat_map(|(buffers, block)| vectors(&buffers[k], block.len() * count)).collect()
        };
        let (positions, normals) = (all(0), all(1));
        let mut worst = Worst::default();
        for (index, character) in characters.iter().enumerate() {
            let mut pose = Pose::sample(&scene, &character.playing);
            pose.world_from_node.iter_mut().for_each(|matrix| *matrix = character.place * *matrix);
            let own = index * count..(index + 1) * count;
            let truth = deform_f64(&geometry, &scene, &pose);
            worst.include(&geometry, &truth, &positions[own.clone()], &normals[own], &format!("dancer {index}"));
        }
        worst.assert("a crowd of dancers");
    }
}

/// A quad with tangents and a map of normals, whose target turns them, on a node that mirrors, and on two joints.
fn framed(scale: DVec3, skinning: Skinning) -> (Scene, Pose) {
    let texture = TextureRef {
        image: 0,
        texcoord: 0,
        wrap: [Wrap::Repeat; 2],
        offset: Vec2::ZERO,
        rotation: 0.0,
        scale: Vec2::ONE,
    };
    let quad = Primitive {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
        normals: Some(vec![Vec3::Z; 4]),
        tangents: Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.6, 0.8, 0.0, -1.0), Vec4::Y, Vec4::ZERO]),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        targets: vec![MorphTarget {
            tangents: Some(vec![Vec3::Y, Vec3::ZERO, Vec3::new(0.5, 0.0, 1.0), Vec3::X]),
            ..MorphTarget::default()
        }],
        joints: vec![vec![[0, 1, 0, 0]; 4]],
        weights: vec![vec![[0.75, 0.25, 0.0, 0.0]; 4]],
        material: Some(0),
        ..Primitive::default()
    };
    let turned = Transform { rotation: DQuat::from_rotation_x(0.8), scale, ..Transform::IDENTITY };
    let scene = Scene {
        nodes: vec![
            Node { mesh: Some(0), skin: Some(0), weights: vec![0.5], ..Node::default() },
            Node { local: Local::Trs(Transform { scale, ..Transform::IDENTITY }), ..Node::default() },
            Node { local: Local::Trs(turned), ..Node::default() },
        ],
        roots: vec![0, 1, 2],
        meshes: vec![Mesh { name: String::new(), primitives: vec![quad] }],
        skins: vec![Skin { name: String::new(), joints: vec![1, 2], inverse_bind: vec![DMat4::IDENTITY; 2] }],
        materials: vec![Material { normal_texture: Some(texture), ..Material::default() }],
        images: vec![Image { name: String::new(), width: 1, height: 1, rgba: vec![[128, 128, 255, 255]] }],
        skinning,
        ..Scene::default()
    };
    let pose = Pose::rest(&scene);
    (scene, pose)
}

#[test]
fn tangents_are_morphed_and_skinned_as_in_f64() {
    let gpu = GPU.lock().unwrap_or_else(PoisonError::into_inner);
    for skinning in [Skinning::Linear, Skinning::DualQuaternion] {
        for scale in [DVec3::ONE, DVec3::new(2.0, 1.0, 0.5), DVec3::new(-1.0, 1.0, 1.0)] {
            let (mut scene, pose) = framed(scale, skinning);
            let geometry = Geometry::build(&scene, &shown_primitives(&scene)).unwrap_or_else(|error| panic!("{error}"));
            let truth = deform_f64(&geometry, &scene, &pose);
            assert_eq!(truth.tangents.len(), 4);
            // By hand: the first is (1, .5, 0) before the joints; a mirror turns the sign of the bitangent.
            let mirror = if scale.x < 0.0 { -1.0 } else { 1.0 };
            assert_eq!([0, 1, 2, 3].map(|vertex| truth.tangents[vertex].w), [mirror, -mirror, 0.0, 0.0]);
            if scale == DVec3::ONE && skinning == Skinning::Linear {
                let joints = DMat3::IDENTITY * 0.75 + DMat3::from_rotation_x(0.8) * 0.25;
                let wanted = (joints * DVec3::new(1.0, 0.5, 0.0)).normalize();
                assert!(truth.tangents[0].truncate().distance(wanted) < 1e-12);
            }
            let mut plan: Plan<Work> = Plan::new();
            let deformed = GeometryLeaves::new(&geometry)
                .deform(&gpu, &mut plan, 0, &geometry, &pose, DVec3::ZERO)
                .unwrap_or_else(|error| panic!("{error}"));
            let tangents = deformed.tangents.expect("a map of normals needs them");
            let executed = gpu
                .execute(&plan, &[tangents], &mut History::new(), Skipping::Off)
                .unwrap_or_else(|error| panic!("{error}"));
            let rows = executed.targets[0].chunks_exact(16);
            for (row, wanted) in rows.zip(&truth.tangents) {
                let number = |at: usize| f64::from(f32::from_le_bytes(row[at..at + 4].try_into().expect("4 bytes")));
                let found = DVec4::new(number(0), number(4), number(8), number(12));
                assert!(found.distance(*wanted) < 1e-6, "{skinning:?} {scale}: {found} for {wanted}");
            }
            // Nobody asks for them without a map.
            scene.materials[0].normal_texture = None;
            let plain = Geometry::build(&scene, &shown_primitives(&scene)).unwrap_or_else(|error| panic!("{error}"));
            assert!(plain.tangents.is_empty() && deform_f64(&plain, &scene, &pose).tangents.is_empty());
        }
    }
}

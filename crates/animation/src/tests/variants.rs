//! Models that are kept in several forms: each form poses as the original does, up to what its numbers leave off.
//!
//! That the forms compressed by Draco are refused, with the command that takes the compression out, is held where the import
//! is tested.

use glam::DVec3;
use murano_scene::{Local, Scene};

use super::corpus::{load, models};
use crate::{Deformed, Geometry, Layer, Rig, deform_f64, shown_primitives};

/// Times over the whole of each clip, besides the form's keys.
const SAMPLES: u32 = 48;

/// Largest difference at rest, in diameters: half a step of positions in 14 bits is 5.3e-5 of a cube's edge along its diagonal.
const AT_REST: f64 = 6e-5;

/// Seconds by which a clip resampled at 30 Hz may be longer.
const FRAME: f64 = 1.0 / 30.0;

/// How far a form may be from the original: vertices in diameters of the posed body, at the keys of the form, where resampling
/// changes nothing, and at any time; normals in degrees, at the keys.
#[derive(Clone, Copy)]
struct Limits {
    at_keys: f64,
    at_any_time: f64,
    degrees: f64,
}

/// A model with what posing it needs.
struct Model {
    scene: Scene,
    rig: Rig,
    geometry: Geometry,
}

impl Model {
    fn new(scene: Scene) -> Self {
        let geometry = Geometry::build(&scene, &shown_primitives(&scene)).unwrap();
        Self { rig: Rig::new(&scene), geometry, scene }
    }

    fn posed(&self, playing: &[Layer]) -> Deformed {
        deform_f64(&self.geometry, &self.scene, &self.rig.pose(playing))
    }

    /// Times of the keys of a clip's longest curve.
    fn keys(&self, clip: usize) -> Vec<f64> {
        let times = self.scene.clips[clip].channels.iter().map(|channel| &channel.sampler.times);
        times.max_by_key(|times| times.len()).unwrap().iter().map(|&time| f64::from(time)).collect()
    }
}

/// An original, a form of it, and which vertices of one may be which of the other.
struct Pair {
    models: [Model; 2],
    /// For every vertex of the form those of the original, and the other way round.
    partners: [Vec<Vec<usize>>; 2],
}

impl Pair {
    fn new(original: Scene, form: Scene) -> Self {
        let models = [original, form].map(Model::new);
        let [original, form] = &models;
        assert_eq!(original.geometry.instances.len(), form.geometry.instances.len());
        let reach = AT_REST * original.posed(&[]).bounds().diameter();
        let partners = [partners(form, original, reach), partners(original, form, reach)];
        Self { models, partners }
    }

    /// Largest distance of a vertex from the nearest of its partners, in diameters, and angle of their normals, degrees.
    fn difference(&self, playing: &[Layer]) -> [f64; 2] {
        let [original, form] = self.models.each_ref().map(|model| model.posed(playing));
        let forth = apart(&self.partners[0], &form, &original);
        let back = apart(&self.partners[1], &original, &form);
        [forth[0].max(back[0]) / original.bounds().diameter(), forth[1].max(back[1])]
    }

    fn largest_difference(&self, clip: usize, times: impl Iterator<Item = f64>) -> [f64; 2] {
        let differences = times.map(|time| self.difference(&[Layer::new(clip, time)]));
        differences.fold([0.0; 2], |[a, b], [c, d]| [a.max(c), b.max(d)])
    }

    fn check(&self, label: &str, limits: Limits) {
        let [original, form] = &self.models;
        let [rest, _] = self.difference(&[]);
        eprintln!("{label}, rest: {rest:.1e} diameters");
        assert!(rest <= AT_REST, "{label}, rest: {rest} diameters");

        assert_eq!(original.scene.clips.len(), form.scene.clips.len(), "{label}: clips");
        for (index, (clip, other)) in original.scene.clips.iter().zip(&form.scene.clips).enumerate() {
            let label = format!("{label}, clip {:?}", clip.name);
            assert_eq!(clip.name, other.name, "{label}");
            let longer = other.duration - clip.duration;
            assert!((-1e-5..=FRAME).contains(&longer), "{label}: {} and {} s", clip.duration, other.duration);

            let [at_keys, degrees] = self.largest_difference(index, form.keys(index).into_iter());
            let times = (0..SAMPLES).map(|sample| clip.duration * f64::from(sample) / f64::from(SAMPLES - 1));
            let [at_any_time, _] = self.largest_difference(index, times);
            eprintln!("{label}: {at_keys:.1e} diameters at keys, {at_any_time:.1e} at any time; {degrees:.2} degrees");
            assert!(at_keys <= limits.at_keys, "{label}: {at_keys} diameters at keys");
            assert!(at_any_time <= limits.at_any_time, "{label}: {at_any_time} diameters");
            assert!(degrees <= limits.degrees, "{label}: {degrees} degrees");
        }
    }
}

/// For every vertex of `from` those of `to` that may be the same: in the same instance, no farther than `reach` at rest.
/// Compressors reorder vertices and merge those that are equal.
fn partners(from: &Model, to: &Model, reach: f64) -> Vec<Vec<usize>> {
    let [from_rest, to_rest] = [from, to].map(|model| model.posed(&[]).positions);
    let mut partners = Vec::with_capacity(from_rest.len());
    for (ours, theirs) in from.geometry.instances.iter().zip(&to.geometry.instances) {
        let theirs = theirs.vertices.start as usize..theirs.vertices.end as usize;
        for place in &from_rest[ours.vertices.start as usize..ours.vertices.end as usize] {
            let near: Vec<_> = theirs.clone().filter(|&vertex| to_rest[vertex].distance(*place) <= reach).collect();
            assert!(!near.is_empty(), "no vertex within {reach} m of {place}");
            partners.push(near);
        }
    }
    partners
}

/// Largest distance of vertices of `from` from the nearest of their partners, metres; the same of normals, degrees.
fn apart(partners: &[Vec<usize>], from: &Deformed, to: &Deformed) -> [f64; 2] {
    let largest = |difference: &dyn Fn(usize, usize) -> f64| {
        let least = |(vertex, partners): (usize, &Vec<usize>)| {
            partners.iter().map(|&partner| difference(vertex, partner)).fold(f64::INFINITY, f64::min)
        };
        partners.iter().enumerate().map(least).fold(0.0, f64::max)
    };
    let angle = |a: DVec3, b: DVec3| if a == b { 0.0 } else { a.angle_between(b).to_degrees() };
    [
        largest(&|ours, theirs| from.positions[ours].distance(to.positions[theirs])),
        largest(&|ours, theirs| angle(from.normals[ours], to.normals[theirs])),
    ]
}

fn check(original: &str, form: &str, limits: Limits) {
    let Some(folder) = models() else { return };
    Pair::new(load(&folder, original), load(&folder, form)).check(form, limits);
}

/// Weights in 8 bits move vertices between joints by half a step, 0.2 %, of how far apart these carry them. The gait's keys are 24
/// a second: resampled at 30, its corners are cut. Normals are those of the triangles, slivers among them.
#[test]
fn a_quantized_fox_poses_like_the_fox() {
    let limits = Limits { at_keys: 4e-4, at_any_time: 1.4e-2, degrees: 9.0 };
    check("gltf/Fox.glb", "gltf/derived/Fox_gltfpack_quant.glb", limits);
}

/// As [`a_quantized_fox_poses_like_the_fox`], and rotations in 12 bits, one upon the other along chains of joints.
#[test]
fn a_compressed_fox_poses_like_the_fox() {
    let limits = Limits { at_keys: 6e-4, at_any_time: 1.4e-2, degrees: 10.0 };
    check("gltf/Fox.glb", "gltf/derived/Fox_gltfpack_meshopt.glb", limits);
}

/// Weights in 8 bits that were made to sum to 1: off by up to 1.2 steps.
#[test]
fn a_quantized_man_poses_like_the_man() {
    let limits = Limits { at_keys: 1e-3, at_any_time: 1e-3, degrees: 0.35 };
    check("gltf/CesiumMan.glb", "gltf/derived/CesiumMan_quantized_i16norm.glb", limits);
}

/// Rotations in 12 bits, weights in 8; normals in 8 twice, on the octahedron and along each axis. Resampled at 30 Hz.
#[test]
fn a_compressed_man_poses_like_the_man() {
    let limits = Limits { at_keys: 7e-4, at_any_time: 3e-3, degrees: 1.2 };
    check("gltf/CesiumMan.glb", "gltf/derived/CesiumMan_gltfpack_meshopt.glb", limits);
}

/// Weights of both targets in 8 bits: half a step, 0.2 %, of displacements of half a diameter each.
#[test]
fn a_quantized_morph_poses_like_the_morph() {
    let limits = Limits { at_keys: 2.7e-3, at_any_time: 2.7e-3, degrees: 0.3 };
    check("gltf/AnimatedMorphCube.glb", "gltf/AnimatedMorphCube_Quantized/AnimatedMorphCube.gltf", limits);
}

/// The tentacles are kept twice: with weights in 8 bits, all of them 0 or 1, and branches scaled by 0.2 instead of 0.3. With
/// one's scales the other is the same but for the rounding of inverse bind matrices.
#[test]
fn tentacles_with_weights_in_8_bits_pose_like_those_in_floats() {
    let Some(folder) = models() else { return };
    let original = load(&folder, "gltf/RecursiveSkeletons.glb");
    let mut form = load(&folder, "gltf/SharpGLTF_InfiniteSkinnedTentacle_u8weights.glb");
    let mut scaled = 0;
    for (ours, theirs) in form.nodes.iter_mut().zip(&original.nodes) {
        let (Local::Trs(ours), Local::Trs(theirs)) = (&mut ours.local, theirs.local) else { unreachable!() };
        if ours.scale != theirs.scale {
            assert!(
                ours.scale.abs_diff_eq(DVec3::splat(0.2), 1e-6) && theirs.scale.abs_diff_eq(DVec3::splat(0.3), 1e-6)
            );
            ours.scale = theirs.scale;
            scaled += 1;
        }
    }
    assert_eq!(scaled, 80, "every branch but the four trunks");
    let limits = Limits { at_keys: 5e-7, at_any_time: 5e-7, degrees: 1e-3 };
    Pair::new(original, form).check("tentacles", limits);
}

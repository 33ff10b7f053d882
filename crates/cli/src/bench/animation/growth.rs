//! How the cost of a pose grows, on characters made in code.

use std::time::Instant;

use anyhow::{Context, Result};
use glam::{DMat4, DVec3, Vec3};
use murano_animation::{Geometry, Layer, Pose, shown_primitives};
use murano_gpu::Gpu;
use murano_metrics::spread::spread;
use murano_render::{Renderer, World};
use murano_scene::{Channel, Clip, Interpolation, Local, MorphTarget, Node, Path, Sampler, Scene, Skin, Transform};

use crate::{
    bench::{
        growth::{Growth, GrowthPoint},
        stability::bodies::{self, Body},
    },
    terminal::Progress,
    trial::time_deformation,
};

/// Bands of a ball: 1k to 1M triangles, half as many vertices.
const RINGS: [u32; 6] = [16, 32, 64, 128, 256, 512];
const JOINTS: [usize; 5] = [4, 16, 64, 256, 1024];
const TARGETS: [usize; 5] = [1, 4, 16, 64, 256];
const CHARACTERS: [usize; 5] = [1, 4, 16, 64, 256];
/// Keys of every curve.
const KEYS: usize = 32;

/// Measurements in all.
pub const POINTS: usize = RINGS.len() + JOINTS.len() + TARGETS.len() + CHARACTERS.len();

/// What grows.
#[derive(Clone, Copy)]
struct Character {
    rings: u32,
    joints: usize,
    targets: usize,
    copies: usize,
}

const USUAL: Character = Character { rings: 64, joints: 32, targets: 0, copies: 1 };

/// Measures all curves; those of the GPU only on an adapter with timestamps.
///
/// # Errors
/// The device's.
pub fn measure(gpu: Gpu, runs: usize, progress: &mut Progress) -> Result<Vec<Growth>> {
    let mut bench = Bench { gpu: Some(gpu), runs, progress };
    let mut curves = Vec::new();
    let vertices = RINGS.map(|rings| Character { rings, ..USUAL });
    let joints = JOINTS.map(|joints| Character { joints, ..USUAL });
    let targets = TARGETS.map(|targets| Character { targets, rings: 32, ..USUAL });
    let copies = CHARACTERS.map(|copies| Character { copies, rings: 16, ..USUAL });
    curves.extend(bench.curves("vertices", &vertices, |it| f64::from(2 * it.rings * (it.rings - 1) + 2))?);
    curves.extend(bench.curves("joints", &joints, |it| it.joints as f64)?);
    curves.extend(bench.curves("morph targets", &targets, |it| it.targets as f64)?);
    curves.extend(bench.curves("characters", &copies, |it| it.copies as f64)?);
    curves.retain(|curve| !curve.points.is_empty());
    Ok(curves)
}

struct Bench<'a> {
    gpu: Option<Gpu>,
    runs: usize,
    progress: &'a mut Progress,
}

impl Bench<'_> {
    /// Time on the GPU and on the processor over one quantity.
    fn curves(
        &mut self,
        quantity: &'static str,
        characters: &[Character],
        x: impl Fn(&Character) -> f64,
    ) -> Result<[Growth; 2]> {
        let (mut deform, mut pose) = (Vec::new(), Vec::new());
        for character in characters {
            let scene = character.scene();
            pose.push(GrowthPoint::new(x(character), self.time_pose(&scene)?));
            let gpu = self.gpu.take().context("the device is lost")?;
            let mut renderer = Renderer::new(gpu, World { scene, environment: None, floor: None })?;
            let time = time_deformation(&mut renderer, Layer::alone(Some(0), 0.4), self.runs)?;
            deform.extend(time.map(|time| GrowthPoint::new(x(character), time)));
            self.gpu = Some(renderer.into_gpu());
            self.progress.advance();
        }
        Ok([Growth::new(quantity, "GPU: deform", deform), Growth::new(quantity, "processor: pose and palette", pose)])
    }

    fn time_pose(&self, scene: &Scene) -> Result<murano_metrics::spread::Spread> {
        let geometry = Geometry::build(scene, &shown_primitives(scene))?;
        let times = (0..self.runs.max(3) * 4).map(|run| {
            let start = Instant::now();
            let pose = Pose::sample(scene, &Layer::alone(Some(0), 0.01 * run as f64));
            std::hint::black_box(geometry.palette(&pose, DVec3::ZERO));
            start.elapsed().as_secs_f64() * 1e3
        });
        Ok(spread(&times.collect::<Vec<_>>())?)
    }
}

impl Character {
    /// Balls with a chain of joints from pole to pole, four influences a vertex, every joint turning; every target moves
    /// every vertex.
    fn scene(self) -> Scene {
        let ball = Body::ball(1.0, self.rings, 2 * self.rings);
        let mut scene = ball.alone(1.5);
        scene.materials[0].transmission = 0.0;
        let primitive = &mut scene.meshes[0].primitives[0];
        let heights: Vec<f32> = primitive.positions.iter().map(|position| position.y).collect();
        let bind = |height: f32| {
            let place = 0.5 * (1.0 - height.clamp(-1.0, 1.0)) * (self.joints - 1) as f32;
            [0, 1, 2, 3].map(|k| (place as usize + k).min(self.joints - 1) as u16)
        };
        primitive.joints = vec![heights.iter().map(|&height| bind(height)).collect()];
        primitive.weights = vec![vec![[0.4, 0.3, 0.2, 0.1]; heights.len()]];
        primitive.targets = (0..self.targets)
            .map(|target| MorphTarget {
                positions: Some(heights.iter().map(|&y| Vec3::splat(0.01 * (y * (target + 1) as f32).sin())).collect()),
                ..MorphTarget::default()
            })
            .collect();
        scene.nodes.clear();
        scene.roots.clear();
        let mut channels = Vec::new();
        for copy in 0..self.copies {
            self.add_copy(&mut scene, copy, &mut channels);
        }
        scene.clips.push(Clip { name: "turn".into(), channels, duration: 1.0, ..Clip::default() });
        scene
    }

    fn add_copy(self, scene: &mut Scene, copy: usize, channels: &mut Vec<Channel>) {
        let first = scene.nodes.len();
        let node = |local: Transform, parent: Option<usize>| Node {
            name: String::new(),
            parent,
            children: Vec::new(),
            local: Local::Trs(local),
            mesh: None,
            skin: None,
            camera: None,
            light: None,
            weights: Vec::new(),
        };
        let step = 2.0 / self.joints as f64;
        let place = bodies::at(DVec3::new(2.5 * (copy % 16) as f64, 1.0, 2.5 * (copy / 16) as f64));
        for joint in 0..self.joints {
            let parent = joint.checked_sub(1).map(|previous| first + previous);
            let local = if joint == 0 { place } else { bodies::at(DVec3::new(0.0, -step, 0.0)) };
            scene.nodes.push(node(local, parent));
            if let Some(parent) = parent {
                scene.nodes[parent].children.push(first + joint);
            }
            channels.push(turning(first + joint, joint));
        }
        let inverse_bind = |joint: usize| DMat4::from_translation(DVec3::new(0.0, step * joint as f64 - 1.0, 0.0));
        scene.skins.push(Skin {
            name: String::new(),
            joints: (first..first + self.joints).collect(),
            inverse_bind: (0..self.joints).map(inverse_bind).collect(),
        });
        let body = scene.nodes.len();
        scene.nodes.push(Node {
            mesh: Some(0),
            skin: Some(copy),
            weights: vec![0.5; self.targets],
            ..node(Transform::IDENTITY, None)
        });
        scene.roots.extend([first, body]);
    }
}

/// A joint that turns about x and back.
fn turning(node: usize, joint: usize) -> Channel {
    let times: Vec<f32> = (0..KEYS).map(|key| key as f32 / (KEYS - 1) as f32).collect();
    let angle = |time: f32| 0.02 * (std::f32::consts::TAU * (time + 0.1 * joint as f32)).sin();
    let values = times.iter().flat_map(|&time| [(0.5 * angle(time)).sin(), 0.0, 0.0, (0.5 * angle(time)).cos()]);
    Channel {
        node,
        path: Path::Rotation,
        sampler: Sampler { interpolation: Interpolation::Linear, width: 4, values: values.collect(), times },
    }
}

//! An optical bench: bodies of glass, the device that renders them, and pictures read plane by plane.

use std::path::{Path, PathBuf};

use exr::prelude::{FlatSamples, f16, read_first_flat_layer_from_file};
use glam::{DVec3, Vec2, Vec3};
use murano_gpu::{AdapterChoice, Gpu, OutputChecks};
use murano_optics::Ior;
use murano_refraction::{Method, Refraction};
use murano_render::{Aov, Extent, FrameRequest, Renderer, Skipping, Stage, ToneMap, View, World};
use murano_scene::{EnvironmentChoice, FloorLevel, GlassBodies, Image, Projection, Scene, Shot, TextureRef, Wrap};

/// A file of `assets/`.
pub fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(name)
}

/// Gives the first mesh of a scene, which is round about the origin, a map of normals: waves around it and from pole to pole, of this slope.
pub fn under_waves(scene: &mut Scene, steepest: f64) {
    const TEXELS: u32 = 128;
    let wave = |at: u32, periods: f64| (std::f64::consts::TAU * periods * f64::from(at) / f64::from(TEXELS)).sin();
    let byte = |slope: f64| (127.5 + 127.5 * slope).round() as u8;
    let rgba = (0..TEXELS * TEXELS).map(|i| {
        let (x, y) = (steepest * wave(i % TEXELS, 6.0), steepest * wave(i / TEXELS, 3.0));
        [byte(x), byte(y), byte((1.0 - x * x - y * y).sqrt()), 255]
    });
    scene.images = vec![Image { name: "waves".into(), width: TEXELS, height: TEXELS, rgba: rgba.collect() }];
    let [offset, scale] = [Vec2::ZERO, Vec2::ONE];
    let waves = TextureRef { image: 0, texcoord: 0, wrap: [Wrap::Repeat; 2], offset, rotation: 0.0, scale };
    for primitive in &mut scene.meshes[0].primitives {
        let around = |p: &Vec3| {
            let up = p.normalize().y.acos();
            Vec2::new(p.x.atan2(p.z) / std::f32::consts::TAU, up / std::f32::consts::PI)
        };
        primitive.texcoords = vec![primitive.positions.iter().map(around).collect()];
        if let Some(material) = primitive.material {
            scene.materials[material].normal_texture = Some(waves);
        }
    }
}

/// A file of the reference data beside the project; `None`, said on stderr, where there is none.
pub fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(name);
    if !path.exists() {
        eprintln!("skipped: {} is not here", path.display());
        return None;
    }
    Some(path)
}

/// The adapter that tests run on: the best there is, often a software one. Everything that a pass writes is checked to be
/// finite.
///
/// # Panics
/// Without any adapter; the message says what to install.
pub fn gpu() -> Gpu {
    let gpu = Gpu::new(&AdapterChoice::Best).unwrap_or_else(|error| panic!("{error}"));
    gpu.with_output_checks(OutputChecks::NonFinite)
}

/// A model whose materials are all clear glass of one index of refraction, alone in the dark.
///
/// # Panics
/// If the model does not load.
pub fn glass_body(model: &Path, ior: Ior) -> World {
    let mut shot = Shot::for_model(model);
    shot.glass.bodies = GlassBodies::All;
    shot.glass.ior = Some(ior.get());
    shot.glass.attenuation_distance = Some(f32::INFINITY);
    alone(shot)
}

/// A model of the materials that it has, alone in the dark.
///
/// # Panics
/// If the model does not load.
pub fn body(model: &Path) -> World {
    alone(Shot::for_model(model))
}

fn alone(mut shot: Shot) -> World {
    shot.environment = EnvironmentChoice::Absent;
    shot.floor.level = FloorLevel::Absent;
    Stage::open(shot).unwrap_or_else(|error| panic!("{error}")).0
}

/// Puts another world on a renderer's device.
///
/// # Panics
/// If the world has too many vertices.
pub fn renderer(gpu: Gpu, world: World) -> Renderer {
    Renderer::new(gpu, world).unwrap_or_else(|error| panic!("{error}"))
}

/// Diameter of the ball around a world's rest pose, metres.
///
/// # Panics
/// If the world has too many vertices.
pub fn diameter(world: &World) -> f64 {
    Extent::measure(&world.scene, &[Vec::new()]).unwrap_or_else(|error| panic!("{error}")).diameter()
}

/// A picture of the rest pose without lamps, with its output variables.
pub fn still(view: View, size: [u32; 2], refraction: Refraction) -> FrameRequest {
    FrameRequest {
        playing: Vec::new(),
        size,
        view,
        lights: Vec::new(),
        refraction,
        caustics: None,
        samples: 1,
        exposure: 1.0,
        tone_map: ToneMap::Linear,
        aov: true,
        before: None,
        skipping: Skipping::On,
    }
}

/// The settings of a method with a number of steps; totally reflected light passes, the first interface mirrors nothing.
pub fn settings(method: Method, steps: u32) -> Refraction {
    Refraction { method, steps, reflection: false, ..Refraction::default() }
}

/// The ray through a pixel's centre: origin, unit direction.
pub fn pixel_ray(view: &View, size: [u32; 2], index: usize) -> (DVec3, DVec3) {
    let [width, height] = size.map(f64::from);
    let (column, row) = (index as u32 % size[0], index as u32 / size[0]);
    let x = (2.0 * (f64::from(column) + 0.5) / width - 1.0) * width / height;
    let y = 1.0 - 2.0 * (f64::from(row) + 0.5) / height;
    let (origin, direction) = match view.projection {
        Projection::Perspective { yfov } => {
            let scale = (0.5 * yfov).tan();
            (DVec3::ZERO, DVec3::new(scale * x, scale * y, -1.0))
        }
        Projection::Orthographic { half_height } => (DVec3::new(x, y, 0.0) * half_height, DVec3::NEG_Z),
    };
    let place = &view.world_from_view;
    (place.transform_point3(origin), place.transform_vector3(direction).normalize())
}

/// One layer's channels as vectors; what a layer lacks is zero.
///
/// # Panics
/// If there is no such layer.
pub fn vectors(aov: &Aov, name: &str) -> Vec<DVec3> {
    let layer = aov.layers.iter().find(|layer| layer.name == name).expect("a layer of AOV_LAYERS");
    let channel = |c: usize, index: usize| layer.planes.get(c).map_or(0.0, |plane| f64::from(plane[index]));
    (0..layer.planes[0].len()).map(|i| DVec3::new(channel(0, i), channel(1, i), channel(2, i))).collect()
}

/// The only, or the first, channel of a layer.
///
/// # Panics
/// If there is no such layer.
pub fn scalars(aov: &Aov, name: &str) -> Vec<f64> {
    vectors(aov, name).into_iter().map(|value| value.x).collect()
}

/// A multi-layer EXR file in memory.
pub struct ExrLayers {
    /// Width and height, pixels.
    pub size: [u32; 2],
    channels: Vec<(String, Vec<f32>)>,
}

impl ExrLayers {
    /// Reads a file.
    ///
    /// # Panics
    /// If it is no EXR file.
    pub fn read(path: &Path) -> Self {
        let image = read_first_flat_layer_from_file(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let size = [image.layer_data.size.width() as u32, image.layer_data.size.height() as u32];
        let channels = image.layer_data.channel_data.list.into_iter().map(|channel| {
            let values = match channel.sample_data {
                FlatSamples::F32(values) => values,
                FlatSamples::F16(values) => values.into_iter().map(f16::to_f32).collect(),
                FlatSamples::U32(values) => values.into_iter().map(|value| value as f32).collect(),
            };
            (channel.name.to_string(), values)
        });
        Self { size, channels: channels.collect() }
    }

    /// One channel by its full name, such as `status.V`.
    ///
    /// # Panics
    /// If there is none.
    pub fn channel(&self, name: &str) -> &[f32] {
        let found = self.channels.iter().find(|(channel, _)| channel == name);
        &found.unwrap_or_else(|| panic!("the file has no channel `{name}`")).1
    }

    /// Channels X, Y, Z of a layer.
    ///
    /// # Panics
    /// If there are none.
    pub fn vectors(&self, layer: &str) -> Vec<DVec3> {
        let [x, y, z] = ["X", "Y", "Z"].map(|suffix| self.channel(&format!("{layer}.{suffix}")));
        x.iter().zip(y).zip(z).map(|((x, y), z)| DVec3::new((*x).into(), (*y).into(), (*z).into())).collect()
    }
}

/// Angle between two directions, degrees; exact for small ones too.
pub fn degrees_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// Pixels that are covered, as are all their eight neighbours: the silhouette's outermost ring is left out, where a
/// triangulated outline and the true one differ by a part of a pixel and grazing light by everything.
pub fn inside_silhouette(covered: &[bool], size: [u32; 2]) -> Vec<bool> {
    let [width, height] = size.map(|n| n as i32);
    let at = |x: i32, y: i32| (0..width).contains(&x) && (0..height).contains(&y) && covered[(y * width + x) as usize];
    (0..width * height).map(|i| (-1..=1).all(|dy| (-1..=1).all(|dx| at(i % width + dx, i / width + dy)))).collect()
}

/// How errors are distributed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Distribution {
    /// How many there are.
    pub count: usize,
    /// Mean.
    pub mean: f64,
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

impl Distribution {
    /// Of a list; all zero for an empty one, NaN where one of them is.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let Some(&max) = values.last() else { return Self::default() };
        let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
        Self {
            count: values.len(),
            mean: values.iter().sum::<f64>() / values.len() as f64,
            p50: at(0.5),
            p95: at(0.95),
            max,
        }
    }
}

impl std::fmt::Display for Distribution {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "mean {:.5} p50 {:.5} p95 {:.5} max {:.4} ({} pixels)",
            self.mean, self.p50, self.p95, self.max, self.count
        )
    }
}

//! The whole picture: every reflection and refraction of the glass, the environment and the opaque scene.
//!
//! Each interface of glass splits the light by Fresnel's equations for unpolarised light, and both branches are followed
//! while both weigh enough; below that one of them is chosen by chance in proportion to its weight, which leaves the mean as
//! it is. Opaque surfaces reflect as glTF 2.0's metallic-roughness material does, any number of times; the sky is sampled by
//! its brightness and by the lobe, weighed by the balance heuristic (Veach 1997); punctual lights send shadow rays.
//!
//! A punctual light's light that meets glass cannot be found from the eye; it is taken from photons, blurred by the radius
//! of their [`PhotonMap`].
//!
//! What is not in it: polarisation between interfaces, light that facets of rough glass send to other facets, alpha cut-outs (drawn solid, as the renderer does),
//! dispersion. The factor of transmitted light (a material's colour times its transmission) applies once for each entry into
//! a body.

mod brdf;
mod lights;
mod photon_map;
mod sky;
mod surface;
mod tree;

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec2, DVec3};
use murano_scene::{Environment, PlacedLight, Scene};
use rayon::prelude::*;

pub use self::photon_map::PhotonMap;
use self::{
    sky::{Sky, luminance},
    tree::{Branches, Found, Tracer},
};
use crate::{Camera, World, sampler::Sampler};

/// Pixels that one task traces.
const TASK: usize = 64;

/// A material that melts into what lies behind it, as the floor of a stage does at its border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fade {
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// World, metres.
    pub centre: DVec3,
    /// Distance from the centre at which nothing is left, metres, positive.
    pub radius: f64,
}

impl Fade {
    /// Where it begins, as a share of the radius; smooth from there to the end.
    const BEGIN: f64 = 0.45;
}

/// What is seen.
#[derive(Clone, Copy)]
pub struct PathScene<'a> {
    /// Glass and opaque things, in the pose.
    pub world: &'a World,
    /// The scene that the world was made from: materials and images of the opaque things.
    pub scene: &'a Scene,
    /// Distant light; `None` is black.
    pub environment: Option<&'a Environment>,
    /// Lamps. Their light reaches opaque things in straight lines that no glass crosses.
    pub lights: &'a [PlacedLight],
    /// Light of the lamps that reached opaque things by way of glass; `None` leaves it out.
    pub photons: Option<&'a PhotonMap>,
    /// A material that fades with distance, if one does.
    pub fade: Option<Fade>,
}

/// How a picture is traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSettings {
    /// Samples a pixel side in each pass, at least 1: a pixel is cut into that many squared cells.
    pub samples: u32,
    /// Whether samples lie anywhere in their cells; else in the middle.
    pub jitter: bool,
    /// Most passes over the picture, at least 1.
    pub passes: u32,
    /// No further pass begins once [`PathPicture::noise`] is at most this.
    pub noise: f64,
    /// Most interfaces of glass along one branch; what goes on is cut off and counted in [`PathPicture::pruned`].
    pub interfaces: u32,
    /// Most reflections by opaque surfaces along one branch; what goes on is cut off and counted.
    pub scatterings: u32,
    /// Branches of less weight are followed by chance (Russian roulette), in (0, 1].
    pub smallest_weight: f64,
    /// Whether the environment is seen directly; else pixels are black where a ray meets nothing.
    pub background: bool,
    /// Equal seeds give equal pictures, whatever the number of threads.
    pub seed: u64,
}

impl Default for PathSettings {
    fn default() -> Self {
        Self {
            samples: 4,
            jitter: true,
            passes: 1,
            noise: 0.0,
            interfaces: 64,
            scatterings: 8,
            smallest_weight: 1e-3,
            background: true,
            seed: 0,
        }
    }
}

/// A traced picture; lists hold one entry a pixel, row by row from the upper left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathPicture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Linear Rec.709 radiance.
    pub radiance: Vec<[f32; 3]>,
    /// Standard error of the radiance, from the spread of a pixel's samples. It takes no account of their even placement,
    /// so it errs on the high side where a silhouette or a texture crosses the pixel.
    pub standard_error: Vec<[f32; 3]>,
    /// Share of the pixel that shows glass or something opaque.
    pub alpha: Vec<f32>,
    /// Weight of the branches that were cut off: what they would have added is at most this times the brightest radiance.
    pub pruned: Vec<f32>,
    /// Passes made.
    pub passes: u32,
    /// Rays traced, shadow rays included.
    pub rays: u64,
}

impl PathPicture {
    /// The noise level: mean over the pixels of the luminance's standard error, over the mean luminance; zero for a black
    /// picture.
    pub fn noise(&self) -> f64 {
        let mean = |list: &[[f32; 3]]| list.iter().map(|rgb| luminance(rgb.map(f64::from))).sum::<f64>();
        let light = mean(&self.radiance);
        if light > 0.0 { mean(&self.standard_error) / light } else { 0.0 }
    }
}

/// Sums over the samples of a pixel.
#[derive(Clone, Copy, Default)]
struct Pixel {
    radiance: DVec3,
    squares: DVec3,
    covered: f64,
    pruned: f64,
    rays: u64,
}

impl Pixel {
    fn add(&mut self, found: Found) {
        self.radiance += found.radiance;
        self.squares += found.radiance * found.radiance;
        self.covered += f64::from(u8::from(found.covered));
        self.pruned += found.pruned;
        self.rays += found.rays;
    }
}

/// Traces a picture. `progress` is told, from any thread, how many tasks are done of how many there are at most.
pub fn path_picture(
    scene: &PathScene<'_>,
    camera: &Camera,
    settings: &PathSettings,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> PathPicture {
    let settings = PathSettings {
        samples: settings.samples.max(1),
        passes: settings.passes.max(1),
        smallest_weight: settings.smallest_weight.clamp(f64::MIN_POSITIVE, 1.0),
        ..*settings
    };
    let tracer = Tracer { scene, settings: &settings, sky: Sky::new(scene.environment) };
    let mut pixels = vec![Pixel::default(); camera.pixels()];
    let tasks = pixels.len().div_ceil(TASK) * settings.passes as usize;
    let done = AtomicUsize::new(0);
    let mut picture = PathPicture::default();
    for pass in 0..settings.passes {
        pixels.par_chunks_mut(TASK).enumerate().for_each(|(task, chunk)| {
            let mut branches = Branches::default();
            for (pixel, sums) in (task * TASK..).zip(chunk) {
                trace_pixel(&tracer, camera, pixel, pass, sums, &mut branches);
            }
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, tasks);
        });
        picture = developed(camera.size, &pixels, settings.samples.pow(2), pass + 1);
        if picture.noise() <= settings.noise {
            break;
        }
    }
    picture
}

fn trace_pixel(
    tracer: &Tracer<'_>,
    camera: &Camera,
    pixel: usize,
    pass: u32,
    sums: &mut Pixel,
    branches: &mut Branches,
) {
    let side = tracer.settings.samples;
    let width = camera.size[0] as usize;
    let corner = DVec2::new((pixel % width) as f64, (pixel / width) as f64);
    for cell in 0..side * side {
        let sample = u64::from(pass) * u64::from(side * side) + u64::from(cell);
        let mut sampler = Sampler::new(tracer.settings.seed, pixel as u64, sample);
        let within = if tracer.settings.jitter { DVec2::from_array(sampler.pair()) } else { DVec2::splat(0.5) };
        let place = corner + (DVec2::new((cell % side).into(), (cell / side).into()) + within) / f64::from(side);
        sums.add(tracer.follow(camera.ray(place.x, place.y), &mut sampler, branches));
    }
}

fn developed(size: [u32; 2], pixels: &[Pixel], samples: u32, passes: u32) -> PathPicture {
    let count = f64::from(samples) * f64::from(passes);
    let error = |pixel: &Pixel| {
        let mean = pixel.radiance / count;
        let variance = (pixel.squares / count - mean * mean).max(DVec3::ZERO) / (count - 1.0).max(1.0);
        DVec3::from_array(variance.to_array().map(f64::sqrt))
    };
    PathPicture {
        size,
        radiance: pixels.iter().map(|pixel| (pixel.radiance / count).as_vec3().to_array()).collect(),
        standard_error: pixels.iter().map(|pixel| error(pixel).as_vec3().to_array()).collect(),
        alpha: pixels.iter().map(|pixel| (pixel.covered / count) as f32).collect(),
        pruned: pixels.iter().map(|pixel| (pixel.pruned / count) as f32).collect(),
        passes,
        rays: pixels.iter().map(|pixel| pixel.rays).sum(),
    }
}

//! Speed of the tracer's closest hit in f64, beside that of the hierarchy's library in f32, for the same rays.
//!
//! `cargo run --release -p murano-reference --example speed -- MODEL.glb ...`
//!
//! Every model is seen from the front left in a picture of 512x512. First rays are those through its pixels; second rays
//! are those that glass of index 1.5 refracts into the body. The best of five runs counts.

use std::path::Path;
use std::time::{Duration, Instant};

use glam::DVec3;
use murano_animation::Pose;
use murano_optics::snell;
use murano_reference::{Camera, Departure, Opaque, Ray, TriangleMesh, World};
use murano_scene::{Material, Scene};
use obvhs::{
    BvhBuildParams,
    cwbvh::{CwBvh, builder::build_cwbvh_from_tris},
    ray,
    rt_triangle::RtTriangle,
    triangle::Triangle,
};
use rayon::prelude::*;

/// Times that rays are traced.
const RUNS: usize = 5;
/// Rays that are timed together on one core.
const BATCH: usize = 2048;

/// A ray, and the triangle that it leaves.
type Start = (Ray, Departure);

/// The library's own hierarchy and triangle test, in f32.
struct Single {
    bvh: CwBvh,
    triangles: Vec<RtTriangle>,
}

impl Single {
    fn new(mesh: &TriangleMesh) -> Self {
        let corners = (0..mesh.len()).map(|index| mesh.triangle(index).map(DVec3::as_vec3a));
        let triangles: Vec<Triangle> = corners.map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect();
        let bvh = build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
        let ordered = bvh.primitive_indices.iter().map(|&index| triangles[index as usize]);
        Self { triangles: ordered.map(|t| RtTriangle::new(t.v0, t.v1, t.v2)).collect(), bvh }
    }

    fn hits(&self, (start, from): &Start, least: f32) -> bool {
        let least = if *from == Departure::Free { 0.0 } else { least };
        let ray = ray::Ray::new(start.origin.as_vec3a(), start.direction.as_vec3a(), least, f32::INFINITY);
        let mut hit = ray::RayHit::none();
        self.bvh.ray_traverse(ray, &mut hit, |ray, slot| self.triangles[slot].intersect(ray))
    }
}

fn mesh_of(model: &Path) -> Result<TriangleMesh, Box<dyn std::error::Error>> {
    let mut scene: Scene = murano_scene::import(model)?;
    let solid = Material::default();
    scene.materials.iter_mut().for_each(|material| material.clone_from(&solid));
    let Some(Opaque { mesh, .. }) = World::of_scene(&scene, &Pose::rest(&scene))?.opaque else {
        return Err(format!("{} shows no triangles", model.display()).into());
    };
    Ok(mesh)
}

fn first_rays(mesh: &TriangleMesh) -> Vec<Start> {
    let (centre, radius) = mesh.ball();
    let eye = centre + 3.2 * radius * DVec3::new(0.6, 0.4, 1.0).normalize();
    let camera = Camera::look_at(eye, centre, 40f64.to_radians(), [512, 512]);
    (0..camera.pixels()).map(|pixel| (camera.pixel_ray(pixel), Departure::Free)).collect()
}

fn second_rays(mesh: &TriangleMesh, first: &[Start]) -> Vec<Start> {
    let refracted = first.iter().filter_map(|(ray, from)| {
        let hit = mesh.nearest(ray, *from, None, f64::INFINITY)?;
        let direction = snell(ray.direction, hit.normal_against(ray.direction), 1.0 / 1.5).direction;
        Some((Ray { origin: hit.position, direction }, Departure::Element(hit.element)))
    });
    refracted.collect()
}

/// Millions of rays a second, and how many met something. On one core every batch of rays is timed by itself, and its best
/// run counts: other work on the machine then hardly matters.
fn speed(rays: &[Start], parallel: bool, meets: impl Fn(&Start) -> bool + Sync) -> (f64, usize) {
    let batches: Vec<&[Start]> = rays.chunks(if parallel { rays.len().max(1) } else { BATCH }).collect();
    let (mut seconds, mut met) = (0.0, 0);
    for batch in batches {
        let runs = (0..RUNS).map(|_| {
            let begun = Instant::now();
            met += if parallel {
                batch.par_iter().filter(|ray| meets(ray)).count()
            } else {
                batch.iter().filter(|ray| meets(ray)).count()
            };
            begun.elapsed().as_secs_f64()
        });
        seconds += runs.fold(f64::INFINITY, f64::min);
    }
    (rays.len() as f64 / seconds / 1e6, met / RUNS)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let models: Vec<String> = std::env::args().skip(1).collect();
    if models.is_empty() {
        return Err("give the paths of one or more models".into());
    }
    println!("closest hits, Mrays/s: one core | all {} cores; share of rays that hit", rayon::current_num_threads());
    for model in &models {
        let model = Path::new(model);
        let mesh = mesh_of(model)?;
        let single = Single::new(&mesh);
        let least = (1e-5 * mesh.ball().1) as f32;
        let first = first_rays(&mesh);
        let second = second_rays(&mesh, &first);
        println!("{} ({} triangles)", model.display(), mesh.len());
        for (name, rays) in [("first", &first), ("second", &second)] {
            let ours = |(ray, from): &Start| mesh.nearest(ray, *from, None, f64::INFINITY).is_some();
            let theirs = |start: &Start| single.hits(start, least);
            let [(one, met), (all, _)] = [false, true].map(|parallel| speed(rays, parallel, ours));
            let [(their_one, their_met), (their_all, _)] = [false, true].map(|parallel| speed(rays, parallel, theirs));
            let share = |met: usize| 100.0 * met as f64 / rays.len().max(1) as f64;
            println!("  {name:6} f64 {one:6.2} | {all:6.2}; {:6.3} %", share(met));
            println!("  {name:6} f32 {their_one:6.2} | {their_all:6.2}; {:6.3} %", share(their_met));
        }
    }
    Ok(())
}

//! How the cost of drawing glass grows, on bodies made in code.

use anyhow::{Context, Result};
use glam::DVec3;
use murano_gpu::Gpu;
use murano_refraction::{Method, Refraction};
use murano_render::{FrameRequest, Skipping, ToneMap, View, World};
use murano_scene::{Local, Node, Scene};

use super::super::{
    growth::{Growth, GrowthPoint},
    stability::bodies::{self, Body},
};
use crate::{
    compare::GLASS_PASSES,
    terminal::Progress,
    trial::{Subject, time_frames},
};

/// Bands of a ball from pole to pole; around, there are twice as many: 1k to 1M triangles.
const RINGS: [u32; 6] = [16, 32, 64, 128, 256, 512];
const SIDES: [u32; 5] = [64, 128, 256, 512, 1024];
const BODIES: [u32; 4] = [1, 2, 4, 8];
const STEPS: [u32; 5] = [1, 2, 4, 8, 16];
const METHODS: [Method; 2] = [Method::Dir, Method::Newton];

/// Measurements in all.
pub const POINTS: usize = RINGS.len() + SIDES.len() + BODIES.len() + METHODS.len() * STEPS.len();

/// Measures all curves; none on an adapter without timestamps.
///
/// # Errors
/// The device's.
pub fn measure(gpu: Gpu, runs: usize, progress: &mut Progress) -> Result<Vec<Growth>> {
    let mut bench = Bench { gpu: Some(gpu), runs, progress };
    let usual = Refraction { method: Method::Newton, ..Refraction::default() };
    let passes = "eye_map + refract";
    let triangles = RINGS.map(|rings| (f64::from(triangles(rings)), row_of_balls(rings, 1), 512, usual));
    let pixels = SIDES.map(|side| (f64::from(side) * f64::from(side), row_of_balls(64, 1), side, usual));
    let bodies = BODIES.map(|count| (f64::from(count), row_of_balls(64, count), 512, usual));
    let mut curves = vec![
        Growth::new("triangles", format!("newton:5, {passes}, 512x512"), bench.points(triangles.into())?),
        Growth::new(
            "pixels",
            format!("newton:5, {passes}, {} triangles", self::triangles(64)),
            bench.points(pixels.into())?,
        ),
        Growth::new("bodies behind one another", format!("newton:5, {passes}, 512x512"), bench.points(bodies.into())?),
    ];
    for method in METHODS {
        let steps =
            STEPS.map(|steps| (f64::from(steps), row_of_balls(64, 1), 512, Refraction { method, steps, ..usual }));
        curves.push(Growth::new("steps", format!("{method}, {passes}, 512x512"), bench.points(steps.into())?));
    }
    curves.retain(|curve| !curve.points.is_empty());
    Ok(curves)
}

/// Triangles of a ball.
fn triangles(rings: u32) -> u32 {
    4 * rings * (rings - 1)
}

/// Balls one behind another along the line of sight.
fn row_of_balls(rings: u32, count: u32) -> Scene {
    let ball = Body::ball(1.0, rings, 2 * rings);
    let mut scene = ball.alone(1.5);
    for k in 1..count {
        let place = bodies::at(DVec3::new(0.0, 0.0, -2.5 * f64::from(k)));
        scene.roots.push(scene.nodes.len());
        scene.nodes.push(Node { local: Local::Trs(place), ..scene.nodes[0].clone() });
    }
    scene
}

struct Bench<'a> {
    gpu: Option<Gpu>,
    runs: usize,
    progress: &'a mut Progress,
}

impl Bench<'_> {
    fn points(&mut self, cases: Vec<(f64, Scene, u32, Refraction)>) -> Result<Vec<GrowthPoint>> {
        let point = |(x, scene, side, refraction)| self.point(x, scene, side, refraction).transpose();
        cases.into_iter().filter_map(point).collect()
    }

    fn point(&mut self, x: f64, scene: Scene, side: u32, refraction: Refraction) -> Result<Option<GrowthPoint>> {
        let world = World { scene, environment: None, floor: None };
        let request = FrameRequest {
            clip: None,
            time: 0.0,
            size: [side, side],
            view: View::look_at(DVec3::new(0.0, 0.0, 3.2), DVec3::ZERO, 40_f64.to_radians()),
            lights: Vec::new(),
            refraction,
            caustics: None,
            exposure: 1.0,
            tone_map: ToneMap::Linear,
            aov: false,
            skipping: Skipping::Off,
        };
        let gpu = self.gpu.take().context("the device is lost")?;
        let mut subject = Subject::of_world(gpu, world, request, 2.0)?;
        let timing = time_frames(&mut subject.renderer, &subject.request, self.runs)?;
        self.gpu = Some(subject.into_gpu());
        self.progress.advance();
        Ok(timing.of_passes(&GLASS_PASSES).map(|time| GrowthPoint::new(x, time)))
    }
}

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
/// Of the ball in the picture, over half of its height.
const RADII: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.8];
const BODIES: [u32; 4] = [1, 2, 4, 8];
const STEPS: [u32; 5] = [1, 2, 4, 8, 16];
/// Methods whose time depends on their steps.
const STEPPED: [Method; 2] = [Method::Dir, Method::Newton];
/// Methods whose growth is measured.
const GROWN: [Method; 3] = [Method::Newton, Method::Layers, Method::Exact];

/// Measurements in all.
pub const POINTS: usize =
    GROWN.len() * (RINGS.len() + SIDES.len() + RADII.len() + BODIES.len()) + STEPPED.len() * STEPS.len();

/// Full angle of the picture, degrees.
const FIELD_OF_VIEW: f64 = 40.0;
/// From the eye to the nearest ball's middle, in its radii, unless that is what changes.
const DISTANCE: f64 = 3.2;

/// A picture of balls of radius 1.
struct Case {
    x: f64,
    scene: Scene,
    side: u32,
    distance: f64,
    refraction: Refraction,
}

/// Measures all curves; none on an adapter without timestamps.
///
/// # Errors
/// The device's.
pub fn measure(gpu: Gpu, runs: usize, progress: &mut Progress) -> Result<Vec<Growth>> {
    let mut bench = Bench { gpu: Some(gpu), runs, progress };
    let passes = GLASS_PASSES.join(" + ");
    let mut curves = Vec::new();
    let few = triangles(64);
    for method in GROWN {
        let refraction = Refraction { method, ..Refraction::default() };
        let usual = |x: f64, scene: Scene| Case { x, scene, side: 512, distance: DISTANCE, refraction };
        let by_triangles = RINGS.map(|rings| usual(f64::from(triangles(rings)), row_of_balls(rings, 1)));
        let by_pixels =
            SIDES.map(|side| Case { side, ..usual(f64::from(side) * f64::from(side), row_of_balls(64, 1)) });
        let by_coverage = RADII.map(|radius| {
            let distance = (radius * (0.5 * FIELD_OF_VIEW).to_radians().tan()).atan().sin().recip();
            let covered = (std::f64::consts::PI * (256.0 * radius).powi(2)).round();
            Case { distance, ..usual(covered, row_of_balls(64, 1)) }
        });
        let by_bodies = BODIES.map(|count| usual(f64::from(count), row_of_balls(64, count)));
        let mut add = |by: &'static str, of: String, cases: Vec<Case>| -> Result<()> {
            curves.push(Growth::new(by, format!("{method}, {passes}, {of}"), bench.points(cases)?));
            Ok(())
        };
        add("triangles", "512x512".into(), by_triangles.into())?;
        add("pixels of the picture", format!("{few} triangles"), by_pixels.into())?;
        add("pixels of glass", format!("512x512, {few} triangles"), by_coverage.into())?;
        add("bodies behind one another", "512x512".into(), by_bodies.into())?;
    }
    for method in STEPPED {
        let case = |steps: u32| {
            let refraction = Refraction { method, steps, ..Refraction::default() };
            Case { x: f64::from(steps), scene: row_of_balls(64, 1), side: 512, distance: DISTANCE, refraction }
        };
        let points = bench.points(STEPS.map(case).into())?;
        curves.push(Growth::new("steps", format!("{method}, {passes}, 512x512"), points));
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
    fn points(&mut self, cases: Vec<Case>) -> Result<Vec<GrowthPoint>> {
        cases.into_iter().filter_map(|case| self.point(case).transpose()).collect()
    }

    fn point(&mut self, case: Case) -> Result<Option<GrowthPoint>> {
        let Case { x, scene, side, distance, refraction } = case;
        let world = World { scene, environment: None, floor: None };
        let request = FrameRequest {
            playing: Vec::new(),
            size: [side, side],
            view: View::look_at(DVec3::new(0.0, 0.0, distance), DVec3::ZERO, FIELD_OF_VIEW.to_radians()),
            lights: Vec::new(),
            refraction,
            caustics: None,
            samples: 1,
            exposure: 1.0,
            tone_map: ToneMap::Linear,
            aov: false,
            before: None,
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

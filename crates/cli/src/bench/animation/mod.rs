//! `murano bench animation`: what a pose costs, and how far the GPU's deformation lies from that in f64.

mod crowd;
mod growth;
mod page;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use glam::DVec3;
use murano_animation::{Deformed, Geometry, Layer, Pose, deform_f64, shown_primitives};
use murano_gpu::Gpu;
use murano_metrics::spread::Spread;
use murano_render::{Renderer, World};
use murano_scene::Scene;
use serde::Serialize;

use crowd::{CrowdResult, Sampling};

use super::{
    growth::Growth,
    output::{Facts, Output, file_name},
};
use crate::{
    options::AdapterOption,
    pose::as_one_body,
    terminal::{Progress, Table, say},
    trial::time_deformation,
};

/// What a pose costs on the processor and the GPU, beside how far it lies from f64
///
/// Every clip is taken at several times. On the processor: sampling the clip, world matrices, the palette. On the GPU: the
/// deform passes. The error is the largest distance of a vertex from the deformation in f64, over the body's diameter. A crowd of
/// every model is posed where all move, where one in a hundred does, where none does, and deformed.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    murano bench animation assets/dancer.glb assets/octopus.glb\n  \
    murano bench animation fox.glb --samples 50 --no-growth --json out/fox.json")]
pub struct Arguments {
    /// Models (.glb, .gltf)
    #[arg(value_name = "INPUT", required_unless_present = "growth_only")]
    inputs: Vec<PathBuf>,
    /// Times taken of every clip
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    samples: u32,
    /// Frames timed for each figure
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// Characters in a crowd; 0 for none
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    crowd: u32,
    /// Leaves out how cost grows with vertices, joints, targets and characters
    #[arg(long, conflicts_with = "growth_only")]
    no_growth: bool,
    /// Measures only how cost grows
    #[arg(long)]
    growth_only: bool,
    #[command(flatten)]
    adapter: AdapterOption,
    #[command(flatten)]
    output: Output,
}

/// Everything measured.
#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    facts: Facts,
    runs: u32,
    models: Vec<ModelResult>,
    crowds: Vec<CrowdResult>,
    growth: Vec<Growth>,
}

/// One model over all its clips.
#[derive(Serialize)]
struct ModelResult {
    input: String,
    vertices: usize,
    joints: usize,
    targets: usize,
    channels: usize,
    clips: usize,
    poses: usize,
    /// Largest distance of a vertex from f64, over the body's diameter.
    max_error: f64,
    /// Largest angle of a normal from f64 where normals are smooth, degrees; `None` where none is.
    max_normal_deg: Option<f64>,
    /// How fast its first clip is sampled; `None` without a clip.
    sampling: Option<Sampling>,
    /// Median GPU time of all deform passes, milliseconds.
    deform_ms: Option<f64>,
    /// Between the quartiles of the same.
    deform_ms_spread: Option<f64>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    arguments.output.prepare()?;
    let mut gpu = arguments.adapter.open()?;
    let facts = Facts::gather(&gpu);
    let points = if arguments.no_growth { 0 } else { growth::POINTS };
    let mut progress = Progress::new("measurements", (arguments.inputs.len() + points) as u64);
    let mut results =
        Results { facts, runs: arguments.runs, models: Vec::new(), crowds: Vec::new(), growth: Vec::new() };
    for input in &arguments.inputs {
        let measured = arguments.measure(gpu, input).with_context(|| input.display().to_string())?;
        gpu = measured.1;
        results.models.push(measured.0);
        if arguments.crowd > 0 {
            let scene = murano_scene::import(input)?;
            let (count, runs) = (arguments.crowd as usize, arguments.runs as usize);
            results.crowds.extend(crowd::crowd(&gpu, file_name(input), &scene, count, runs)?);
        }
        progress.advance();
    }
    if !arguments.no_growth {
        results.growth = growth::measure(gpu, arguments.runs as usize, &mut progress)?;
    }
    progress.finish();
    if !arguments.output.json_on_stdout() {
        if !results.models.is_empty() {
            say(results.table())?;
        }
        if !results.crowds.is_empty() {
            say(Table::new(&CrowdResult::headings(), results.crowds.iter().map(CrowdResult::cells).collect()))?;
        }
        results.growth.iter().try_for_each(say)?;
    }
    arguments.output.write(&results, || page::page(&results))
}

impl Arguments {
    fn measure(&self, gpu: Gpu, input: &Path) -> Result<(ModelResult, Gpu)> {
        let mut scene = murano_scene::import(input)?;
        // Without glass the renderer has one geometry, with its vertices in the file's order.
        as_one_body(&mut scene);
        let geometry = Geometry::build(&scene, &shown_primitives(&scene))?;
        let mut renderer = Renderer::new(gpu, World { scene: scene.clone(), environment: None, floor: None })?;
        let mut errors = Errors::default();
        let poses = poses(&scene, self.samples);
        for &(clip, time) in &poses {
            let pose = Pose::sample(&scene, &Layer::alone(clip, time));
            let truth = deform_f64(&geometry, &scene, &pose);
            let deformed = renderer.deform(&Layer::alone(clip, time))?;
            let mut found = Deformed::default();
            for mesh in deformed {
                found.positions.extend(mesh.positions);
                found.normals.extend(mesh.normals);
            }
            errors.include(&geometry, &truth, &found)?;
        }
        let (clip, time) = poses[poses.len() / 2];
        let deform = time_deformation(&mut renderer, Layer::alone(clip, time), self.runs as usize)?;
        let targets =
            scene.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|primitive| primitive.targets.len()).max();
        let result = ModelResult {
            input: file_name(input),
            vertices: geometry.vertices.len(),
            joints: scene.skins.iter().map(|skin| skin.joints.len()).sum(),
            targets: targets.unwrap_or(0),
            channels: scene.clips.iter().map(|clip| clip.channels.len()).max().unwrap_or(0),
            clips: scene.clips.len(),
            poses: poses.len(),
            max_error: errors.position,
            max_normal_deg: errors.normal_deg,
            sampling: crowd::sampling(&scene, &geometry, self.runs),
            deform_ms: deform.map(|spread| spread.median),
            deform_ms_spread: deform.as_ref().map(Spread::interquartile),
        };
        Ok((result, renderer.into_gpu()))
    }
}

/// Every clip at `samples` times from its beginning to just before its end; the rest pose of a model without clips.
fn poses(scene: &Scene, samples: u32) -> Vec<(Option<usize>, f64)> {
    if scene.clips.is_empty() {
        return vec![(None, 0.0)];
    }
    let times = |clip: usize| {
        let duration = scene.clips[clip].duration;
        (0..samples).map(move |sample| (Some(clip), duration * f64::from(sample) / f64::from(samples)))
    };
    (0..scene.clips.len()).flat_map(times).collect()
}

/// How far the GPU is from f64.
#[derive(Default)]
struct Errors {
    position: f64,
    normal_deg: Option<f64>,
}

impl Errors {
    fn include(&mut self, geometry: &Geometry, truth: &Deformed, found: &Deformed) -> Result<()> {
        anyhow::ensure!(
            truth.positions.len() == found.positions.len(),
            "the GPU deformed {} vertices, the f64 path {}",
            found.positions.len(),
            truth.positions.len()
        );
        let diameter = truth.bounds().diameter().max(f64::MIN_POSITIVE);
        for (found, wanted) in found.positions.iter().zip(&truth.positions) {
            let off = found.distance(*wanted) / diameter;
            // A distance that is no number is as bad as can be.
            self.position = if off.is_nan() { f64::INFINITY } else { self.position.max(off) };
        }
        for ((found, wanted), vertex) in found.normals.iter().zip(&truth.normals).zip(&geometry.vertices) {
            // The normals of flat triangles are as good as the triangles are large; those are measured by position.
            if vertex.corner == 0 && *found != DVec3::ZERO && *wanted != DVec3::ZERO {
                let angle = found.cross(*wanted).length().atan2(found.dot(*wanted)).to_degrees();
                self.normal_deg = Some(self.normal_deg.unwrap_or(0.0).max(angle));
            }
        }
        Ok(())
    }
}

impl Results {
    fn headings() -> [&'static str; 13] {
        [
            "model",
            "vertices",
            "joints",
            "targets",
            "clips",
            "poses",
            "error/diam",
            "normal °",
            "joints/µs",
            "seeking",
            "blended",
            "with palette",
            "deform ms",
        ]
    }

    fn cells(&self) -> Vec<Vec<String>> {
        let rate = |model: &ModelResult, of: fn(&Sampling) -> f64| {
            model.sampling.as_ref().map_or_else(|| "-".into(), |sampling| format!("{:.0}", of(sampling)))
        };
        let line = |model: &ModelResult| {
            vec![
                model.input.clone(),
                model.vertices.to_string(),
                model.joints.to_string(),
                model.targets.to_string(),
                model.clips.to_string(),
                model.poses.to_string(),
                format!("{:.1e}", model.max_error),
                model.max_normal_deg.map_or_else(|| "-".into(), |degrees| format!("{degrees:.1e}")),
                rate(model, |it| it.forward),
                rate(model, |it| it.seeking),
                rate(model, |it| it.blended),
                rate(model, |it| it.with_palette),
                model.deform_ms.map_or_else(|| "-".into(), |ms| format!("{ms:.3}")),
            ]
        };
        self.models.iter().map(line).collect()
    }

    fn table(&self) -> Table {
        Table::new(&Self::headings(), self.cells())
    }
}

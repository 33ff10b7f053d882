//! Many copies of a character: what posing and deforming them costs when all move, when few do, when none does.

use std::time::Instant;

use anyhow::{Context, Result};
use encase::ShaderType;
use glam::{DMat4, DVec3};
use murano_animation::{BLOCK, Character, Crowd, Geometry, GeometryLeaves, Layer, Rig, Workspace, shown_primitives};
use murano_gpu::{ComputePass, Gpu, Groups, Leaf, ShaderSpec, Work};
use murano_metrics::spread::spread;
use murano_scene::Scene;
use murano_scheduler::{History, Output, Plan, Skipping};
use serde::Serialize;

/// Samplings of a clip for one figure.
const SAMPLINGS: usize = 2000;
/// One in so many moves in a mostly still crowd.
const STILL_TO_MOVING: usize = 100;

/// How fast curves are evaluated on one core, joints a microsecond.
#[derive(Clone, Copy, Serialize)]
pub struct Sampling {
    /// One clip, time going on.
    pub forward: f64,
    /// One clip, at times that jump.
    pub seeking: f64,
    /// Two clips (or one at two times), half and half.
    pub blended: f64,
    /// One clip, with world matrices and the palette.
    pub with_palette: f64,
}

/// A crowd.
#[derive(Serialize)]
pub struct CrowdResult {
    pub input: String,
    pub characters: usize,
    pub joints: usize,
    pub vertices: usize,
    /// Poses and palettes where every character moves, milliseconds on all cores.
    pub moving_ms: f64,
    /// What of it is asking who moves and remembering what all do, measured by itself on one core.
    pub tracking_ms: f64,
    /// Where one in a hundred moves.
    pub mostly_still_ms: f64,
    /// Where none does.
    pub still_ms: f64,
    /// Deformation of all of them on the GPU; `None` where the adapter has no timestamps.
    pub deform_ms: Option<f64>,
    /// Bytes that it reads and writes at least.
    pub deform_bytes: f64,
    /// Copying as many bytes with the simplest shader there is takes.
    pub copy_ms: Option<f64>,
    /// As many multiplications and additions in registers take.
    pub arithmetic_ms: Option<f64>,
}

/// Times `work` over many samplings, microseconds each: the best of several rounds, for whatever else the machine does only adds.
fn fastest(rounds: u32, mut work: impl FnMut(usize)) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..rounds {
        let start = Instant::now();
        (0..SAMPLINGS).for_each(&mut work);
        best = best.min(start.elapsed().as_secs_f64() * 1e6 / SAMPLINGS as f64);
    }
    best
}

/// Joints, or nodes that move where there is no skin.
pub fn joints(scene: &Scene) -> usize {
    let joints: usize = scene.skins.iter().map(|skin| skin.joints.len()).sum();
    if joints > 0 { joints } else { scene.nodes.len() }
}

/// Measures sampling; `None` without a clip.
pub fn sampling(scene: &Scene, geometry: &Geometry, rounds: u32) -> Option<Sampling> {
    let clip = scene.clips.first()?;
    let (rig, joints, last) = (Rig::new(scene), joints(scene) as f64, scene.clips.len() - 1);
    let time = |k: usize| clip.duration * (k % SAMPLINGS) as f64 / SAMPLINGS as f64;
    let mut workspace = Workspace::default();
    let forward = fastest(rounds, |k| rig.sample(&[Layer::new(0, time(k))], &mut workspace));
    let seeking = fastest(rounds, |k| rig.sample(&[Layer::new(0, time(k * 7919))], &mut workspace));
    let blended = fastest(rounds, |k| {
        let half = Layer { weight: 0.5, ..Layer::new(last, time(k + SAMPLINGS / 3)) };
        rig.sample(&[Layer::new(0, time(k)), half], &mut workspace);
    });
    let mut pose = rig.rest().clone();
    let mut palette = geometry.palette(&pose, DVec3::ZERO);
    let with_palette = fastest(rounds, |k| {
        rig.pose_into(&[Layer::new(0, time(k))], &mut workspace, &mut pose);
        geometry.palette_into(&pose, DVec3::ZERO, &mut palette);
    });
    let rate = |us: f64| joints / us;
    Some(Sampling {
        forward: rate(forward),
        seeking: rate(seeking),
        blended: rate(blended),
        with_palette: rate(with_palette),
    })
}

/// Measures a crowd of copies of a model that has a clip.
///
/// # Errors
/// The device's, or a model with too many vertices.
pub fn crowd(gpu: &Gpu, input: String, scene: &Scene, count: usize, runs: usize) -> Result<Option<CrowdResult>> {
    let Some(clip) = scene.clips.first() else { return Ok(None) };
    let geometry = Geometry::build(scene, &shown_primitives(scene))?;
    let leaves = GeometryLeaves::new(&geometry);
    let bytes = bytes_moved(&geometry, count);
    let (joints, vertices) = (joints(scene), geometry.vertices.len());
    let influences = geometry.influences.len() as f64 / vertices.max(1) as f64;
    let mut crowd = Crowd::new(Rig::new(scene), geometry);
    let mut characters: Vec<Character> = (0..count).map(|index| character(index, clip.duration)).collect();
    let (mut times, mut tracking) = ([const { Vec::new() }; 3], Vec::new());
    let mut update = |crowd: &mut Crowd, characters: &[Character], slot: usize| {
        let start = Instant::now();
        std::hint::black_box(crowd.update(characters, DVec3::ZERO));
        times[slot].push(start.elapsed().as_secs_f64() * 1e3);
    };
    crowd.update(&characters, DVec3::ZERO);
    for _ in 0..runs.max(5) {
        let step =
            |character: &mut Character| character.playing[0].time = (character.playing[0].time + 0.013) % clip.duration;
        characters.iter_mut().for_each(step);
        update(&mut crowd, &characters, 0);
        characters.iter_mut().step_by(STILL_TO_MOVING).for_each(step);
        update(&mut crowd, &characters, 1);
        update(&mut crowd, &characters, 2);
        let mut known = characters.clone();
        characters.iter_mut().for_each(step);
        let start = Instant::now();
        for (known, now) in known.iter_mut().zip(&characters) {
            if std::hint::black_box(known != now) {
                known.clone_from(now);
            }
        }
        tracking.push(start.elapsed().as_secs_f64() * 1e3);
        std::hint::black_box(&known);
    }
    let [moving_ms, mostly_still_ms, still_ms] = {
        let medians: Vec<f64> = times.iter().map(|times| Ok(spread(times)?.median)).collect::<Result<_>>()?;
        medians.try_into().ok().context("three figures")?
    };
    Ok(Some(CrowdResult {
        input,
        characters: count,
        joints,
        vertices,
        moving_ms,
        tracking_ms: spread(&tracking)?.median,
        mostly_still_ms,
        still_ms,
        deform_ms: time_deformation(gpu, &leaves, &crowd, runs)?,
        deform_bytes: bytes,
        copy_ms: time_copy(gpu, bytes, runs)?,
        arithmetic_ms: time_arithmetic(gpu, count * vertices, influences, runs)?,
    }))
}

fn character(index: usize, duration: f64) -> Character {
    Character {
        playing: vec![Layer::new(0, duration * (index as f64 * 0.618).fract())],
        place: DMat4::from_translation(DVec3::new((index % 32) as f64, 0.0, (index / 32) as f64)),
    }
}

/// Bytes that deforming a crowd reads and writes at least: rest pose and influences once a block, every position and normal.
fn bytes_moved(geometry: &Geometry, characters: usize) -> f64 {
    let vertices = geometry.vertices.len();
    let shared = 32 * vertices + 4 * geometry.influence_offsets.len() + 8 * geometry.influences.len();
    (shared * characters.div_ceil(BLOCK) + 32 * vertices * characters) as f64
}

/// GPU milliseconds of the deform passes of a crowd.
fn time_deformation(gpu: &Gpu, leaves: &GeometryLeaves, crowd: &Crowd, runs: usize) -> Result<Option<f64>> {
    let mut plan: Plan<Work> = Plan::new();
    let mut targets: Vec<Output> = Vec::new();
    for (number, block) in (0..).zip(crowd.blocks()) {
        targets.extend(leaves.deform_block(gpu, &mut plan, number, block)?);
    }
    // What is read back is the first block's; the others are wanted all the same, for nothing is skipped.
    time_plan(gpu, &plan, &targets, runs)
}

/// GPU milliseconds of a copy that reads and writes `bytes` together.
fn time_copy(gpu: &Gpu, bytes: f64, runs: usize) -> Result<Option<f64>> {
    // No buffer is larger than every adapter binds; longer copies are extrapolated.
    const LARGEST: f64 = 64.0 * 1024.0 * 1024.0;
    let half = (0.5 * bytes).min(LARGEST);
    let vectors = (half / 16.0) as usize;
    let shader = gpu.shader(&ShaderSpec::new("gpu::copy"))?;
    let mut plan: Plan<Work> = Plan::new();
    let (stamp, leaf) = Leaf::of(&vec![[1.0_f32; 4]; vectors]);
    let outputs = ComputePass::new("copy", 0)
        .input("source", plan.leaf("source", stamp, Work::Leaf(leaf)))
        .output("destination", 16 * vectors as u64)
        .dispatch(&shader, "main", Groups::linear(vectors, 64))
        .add_to(&mut plan)?;
    Ok(time_plan(gpu, &plan, &outputs, runs)?.map(|ms| ms * 0.5 * bytes / (16 * vectors) as f64))
}

/// Multiplications and additions of a vertex besides those of its influences: cofactors, position, normal, winding.
const OTHER_TERMS: f64 = 42.0;
/// And for each influence: three rows of four.
const TERMS_OF_INFLUENCE: f64 = 12.0;

#[derive(ShaderType)]
struct Multiply {
    threads: u32,
    steps: u32,
    factor: f32,
}

/// GPU milliseconds of the multiplications and additions of so many vertices, with nothing to read.
fn time_arithmetic(gpu: &Gpu, vertices: usize, influences: f64, runs: usize) -> Result<Option<f64>> {
    let terms = OTHER_TERMS + TERMS_OF_INFLUENCE * influences;
    let params = Multiply { threads: vertices as u32, steps: (terms / 4.0).round() as u32, factor: 0.5 };
    let shader = gpu.shader(&ShaderSpec::new("gpu::multiply"))?;
    let mut plan: Plan<Work> = Plan::new();
    let outputs = ComputePass::new("multiply", 0)
        .value("params", &params)
        .output("result", 256)
        .dispatch(&shader, "main", Groups::linear(vertices, 64))
        .add_to(&mut plan)?;
    time_plan(gpu, &plan, &outputs, runs)
}

fn time_plan(gpu: &Gpu, plan: &Plan<Work>, targets: &[Output], runs: usize) -> Result<Option<f64>> {
    let mut sums = Vec::new();
    for run in 0..=runs {
        let executed = gpu.execute(plan, targets, &mut History::new(), Skipping::Off)?;
        let times: Option<Vec<f64>> = executed.times.iter().map(|step| step.gpu_ms).collect();
        let Some(times) = times else { return Ok(None) };
        // The first run compiles and uploads.
        if run > 0 {
            sums.push(times.iter().sum());
        }
    }
    Ok(Some(spread(&sums)?.median))
}

impl CrowdResult {
    /// The part of the time, where all move, that tracking who does takes.
    pub fn tracking(&self) -> f64 {
        self.tracking_ms / self.moving_ms
    }

    /// Headings of [`CrowdResult::cells`].
    pub fn headings() -> [&'static str; 12] {
        [
            "model",
            "characters",
            "joints",
            "all move ms",
            "tracking %",
            "1 % moves ms",
            "none ms",
            "vertices",
            "deform ms",
            "vertices/ms",
            "by memory",
            "by arithmetic",
        ]
    }

    /// A row of the table.
    pub fn cells(&self) -> Vec<String> {
        let rate = |ms: Option<f64>, amount: f64| ms.map_or_else(|| "-".into(), |ms| format!("{:.3e}", amount / ms));
        let vertices = self.characters * self.vertices;
        vec![
            self.input.clone(),
            self.characters.to_string(),
            (self.characters * self.joints).to_string(),
            format!("{:.3}", self.moving_ms),
            format!("{:.1}", 100.0 * self.tracking()),
            format!("{:.3}", self.mostly_still_ms),
            format!("{:.3}", self.still_ms),
            vertices.to_string(),
            self.deform_ms.map_or_else(|| "-".into(), |ms| format!("{ms:.3}")),
            rate(self.deform_ms, vertices as f64),
            rate(self.copy_ms, vertices as f64),
            rate(self.arithmetic_ms, vertices as f64),
        ]
    }
}

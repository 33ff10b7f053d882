//! `murano bench cache`: what a frame runs, and what it costs, when only a part of the scene has changed.

mod page;
mod worlds;

use std::{path::PathBuf, time::Instant};

use anyhow::{Context, Result};
use clap::Args;
use glam::{DMat4, DVec3};
use murano_animation::Layer;
use murano_caustics::Caustics;
use murano_gpu::Gpu;
use murano_metrics::spread::{Spread, spread};
use murano_render::{FrameRequest, Renderer, Settings, Skipping, Stage, View, World, open_shot};
use murano_scene::GlassBodies;
use serde::Serialize;

use super::output::{Facts, Output, file_name};
use crate::{
    failure::OverThreshold,
    options::AdapterOption,
    terminal::{Progress, Table, say},
    values,
};

/// What a frame runs and costs when only a part of the scene has changed
///
/// Each scenario is played with the cache on, with it off, and verified: what would be reused is run again and compared, bit for
/// bit. The model is made glass over a floor under a spot; what single casters and receivers do is shown on ten balls of glass over
/// a plate. Times are medians over the frames behind the first; a looped clip is measured in its second round.
#[derive(Args)]
#[command(
    after_help = "With --threshold X: ends with status 1 if frames without change, or with a moving camera alone, cost more than X \
                        times the same frames without caustics, or if a repeated frame runs a pass.\n\nExamples:\n  \
    murano bench cache assets/dancer.glb --html out/cache.html\n  \
    murano bench cache fox.glb --frames 24 --size 512x512 --json out/cache.json"
)]
pub struct Arguments {
    /// Model (.glb, .gltf) or shot (.ron)
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    /// Frames of each scenario
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(2..=10_000))]
    frames: u32,
    /// Pixels of the picture
    #[arg(long, value_name = "WxH", value_parser = values::size, default_value = "512x512")]
    size: [u32; 2],
    /// Photons along each side of a caster's grid [default: as in pictures]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8192))]
    photons: Option<u32>,
    /// Texels along each side of the caustic map [default: as in pictures]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=8192))]
    caustic_size: Option<u32>,
    /// The most that caustics may cost where nothing of them has changed, as a ratio
    #[arg(long, value_name = "X", value_parser = values::number)]
    threshold: Option<f64>,
    #[command(flatten)]
    adapter: AdapterOption,
    #[command(flatten)]
    output: Output,
}

/// What changes from frame to frame.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Scenario {
    Static,
    Camera,
    Light,
    LightColour,
    Receiver,
    OneCaster,
    PausedClip,
    LoopedClip,
    Everything,
}

impl Scenario {
    const ALL: [Self; 9] = [
        Self::Static,
        Self::Camera,
        Self::Light,
        Self::LightColour,
        Self::Receiver,
        Self::OneCaster,
        Self::PausedClip,
        Self::LoopedClip,
        Self::Everything,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Static => "static",
            Self::Camera => "camera only",
            Self::Light => "light only",
            Self::LightColour => "light colour only",
            Self::Receiver => "receiver only",
            Self::OneCaster => "one of ten casters",
            Self::PausedClip => "paused clip",
            Self::LoopedClip => "looped clip",
            Self::Everything => "everything",
        }
    }

    /// Whether it is played on the balls rather than on the model.
    fn is_of_balls(self) -> bool {
        matches!(self, Self::Receiver | Self::OneCaster)
    }

    /// What the cache has seen before the frames that count: frame 0, or a whole round.
    fn warm_up(self, frames: u32) -> u32 {
        if self == Self::LoopedClip { frames } else { 1 }
    }

    /// Frame `k` of `frames`.
    fn frame(self, subject: &Subject, k: u32, frames: u32) -> FrameRequest {
        let mut request = subject.request.clone();
        // Only a looped clip comes back to where it was.
        let round = if self == Self::LoopedClip { frames } else { frames + 1 };
        let share = f64::from(k % round) / f64::from(round);
        let duration = subject.duration;
        let orbit = |view: View| {
            let turn = DMat4::from_translation(subject.centre)
                * DMat4::from_rotation_y(0.02 * f64::from(k))
                * DMat4::from_translation(-subject.centre);
            View { world_from_view: turn * view.world_from_view, ..view }
        };
        let moved = |request: &mut FrameRequest| {
            let shift = subject.centre.distance(request.lights[0].world_from_light.w_axis.truncate());
            request.lights[0].world_from_light.w_axis.x += 0.01 * shift * f64::from(k);
        };
        let play = |request: &mut FrameRequest, time: f64| {
            request.playing.iter_mut().for_each(|layer| layer.time = time);
        };
        match self {
            Self::Static => {}
            Self::Camera => request.view = orbit(request.view),
            Self::Light => moved(&mut request),
            Self::LightColour => request.lights[0].light.intensity *= 1.0 - 0.5 * share as f32,
            Self::Receiver => request.playing = Layer::alone(Some(worlds::RECEIVER), share * duration),
            Self::OneCaster => request.playing = Layer::alone(Some(worlds::CASTER), share * duration),
            Self::PausedClip => play(&mut request, 0.3 * duration),
            Self::LoopedClip => play(&mut request, share * duration),
            Self::Everything => {
                request.view = orbit(request.view);
                moved(&mut request);
                play(&mut request, share * duration);
            }
        }
        request
    }
}

/// A world's first frame, and what of it changes.
struct Subject {
    request: FrameRequest,
    centre: DVec3,
    /// Of the clip, seconds.
    duration: f64,
}

/// Everything measured.
#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    facts: Facts,
    input: String,
    size: [u32; 2],
    frames: u32,
    rows: Vec<Row>,
    /// GPU time of frames with caustics over the same without, cache on.
    camera_ratio: Option<f64>,
    /// Wall-clock time of static frames with caustics over the same without, cache on.
    static_ratio: f64,
}

/// Times with caustics over those without, cache on.
struct Cost {
    /// `None` where no pass ran, or the adapter has no timestamps.
    gpu: Option<f64>,
    frame: f64,
}

/// One scenario in one mode. Passes are means a frame, times medians.
#[derive(Serialize)]
struct Row {
    scenario: &'static str,
    caustics: bool,
    cache: &'static str,
    ran: f64,
    reused: f64,
    culled: f64,
    gpu_ms: f64,
    gpu_ms_spread: f64,
    frame_ms: f64,
    cache_mib: f64,
    passes: Vec<PassRow>,
}

/// One pass over its instances: how often it ran, and how long that took, a frame.
#[derive(Serialize)]
struct PassRow {
    name: String,
    ran: f64,
    gpu_ms: f64,
}

/// Times that the frames are repeated to tell what caustics cost.
const ROUNDS: u32 = 4;

const MODES: [(&str, Skipping); 3] = [("on", Skipping::On), ("off", Skipping::Off), ("verified", Skipping::Verify)];

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    arguments.output.prepare()?;
    let mut gpu = arguments.adapter.open()?;
    let facts = Facts::gather(&gpu);
    let unlit = [Scenario::Static, Scenario::Camera];
    let mut progress = Progress::new("scenarios", (MODES.len() * Scenario::ALL.len() + unlit.len()) as u64);
    let mut rows = Vec::new();
    let all = Scenario::ALL.into_iter().flat_map(|scenario| MODES.map(|mode| (scenario, mode, true)));
    for (scenario, mode, caustics) in all.chain(unlit.map(|scenario| (scenario, MODES[0], false))) {
        let measured = arguments
            .measure(gpu, scenario, mode, caustics)
            .with_context(|| format!("scenario `{}`, cache {}", scenario.name(), mode.0))?;
        gpu = measured.1;
        rows.push(measured.0);
        progress.advance();
    }
    progress.finish();
    drop(gpu);
    let [static_ratio, camera_ratio] = [Scenario::Static, Scenario::Camera].map(|scenario| arguments.cost(scenario));
    let results = Results {
        facts,
        input: file_name(&arguments.input),
        size: arguments.size,
        frames: arguments.frames,
        camera_ratio: camera_ratio?.gpu,
        static_ratio: static_ratio?.frame,
        rows,
    };
    if !arguments.output.json_on_stdout() {
        say(Table::new(&Results::HEADINGS, results.cells()))?;
        say(results.summary())?;
    }
    arguments.output.write(&results, || page::page(&results))?;
    results.judge(arguments.threshold)
}

impl Arguments {
    fn caustics(&self) -> Caustics {
        let usual = Caustics::default();
        Caustics {
            photons: self.photons.unwrap_or(usual.photons),
            map_size: self.caustic_size.unwrap_or(usual.map_size),
            ..usual
        }
    }

    fn subject(&self, scenario: Scenario, settings: &Settings) -> Result<(World, Subject)> {
        if scenario.is_of_balls() {
            let request = worlds::request(settings, self.size);
            return Ok((worlds::balls_over_plate(), Subject { request, centre: DVec3::ZERO, duration: 1.0 }));
        }
        let mut shot = open_shot(&self.input)?;
        shot.glass.bodies = GlassBodies::All;
        shot.output.size = self.size;
        let (world, stage) = Stage::open(shot)?;
        let duration = stage.clip().map_or(0.0, |clip| world.scene.clips[clip].duration);
        Ok((world, Subject { request: stage.request(0.0, settings), centre: stage.extent().center, duration }))
    }

    /// What caustics cost that do not change: frames with and without them by turns, each on a device of its own, so that
    /// whatever else the machine does meets both.
    fn cost(&self, scenario: Scenario) -> Result<Cost> {
        let usual = Settings::default();
        let mut sides = Vec::new();
        for caustics in [Some(self.caustics()), None] {
            let (world, subject) = self.subject(scenario, &Settings { caustics, ..usual })?;
            let mut renderer = Renderer::new(self.adapter.open()?, world)?;
            renderer.render(&scenario.frame(&subject, 0, self.frames))?;
            sides.push((subject, renderer, Vec::new(), Vec::new()));
        }
        for k in 1..=ROUNDS * self.frames {
            for (subject, renderer, gpu, frames) in &mut sides {
                let request = scenario.frame(subject, k, self.frames);
                let start = Instant::now();
                gpu.push(renderer.render(&request)?.gpu_ms);
                frames.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
        let ratio = |times: [&[f64]; 2]| -> Result<f64> { Ok(spread(times[0])?.median / spread(times[1])?.median) };
        let gpu = ratio([&sides[0].2, &sides[1].2])?;
        Ok(Cost { gpu: gpu.is_finite().then_some(gpu), frame: ratio([&sides[0].3, &sides[1].3])? })
    }

    /// With a cache that holds nothing of the scenarios before.
    fn measure(
        &self,
        gpu: Gpu,
        scenario: Scenario,
        (cache, skipping): (&'static str, Skipping),
        caustics: bool,
    ) -> Result<(Row, Gpu)> {
        let usual = Settings::default();
        let settings = Settings { skipping, caustics: caustics.then(|| self.caustics()), ..usual };
        let (world, subject) = self.subject(scenario, &settings)?;
        let mut renderer = Renderer::new(gpu.emptied(), world)?;
        let warm_up = scenario.warm_up(self.frames);
        for k in 0..warm_up {
            renderer.render(&scenario.frame(&subject, k, self.frames))?;
        }
        let (mut gpu_times, mut frame_times) = (Vec::new(), Vec::new());
        let mut decisions = [0_usize; 3];
        let mut passes: Vec<PassRow> = Vec::new();
        let mut cache_bytes = 0;
        let share = 1.0 / f64::from(self.frames);
        for k in warm_up..warm_up + self.frames {
            let request = scenario.frame(&subject, k, self.frames);
            let start = Instant::now();
            let frame = renderer.render(&request)?;
            frame_times.push(start.elapsed().as_secs_f64() * 1e3);
            gpu_times.push(frame.gpu_ms);
            cache_bytes = frame.cache_bytes;
            for pass in &frame.passes {
                let decision = ["ran", "reused", "culled"].iter().position(|name| *name == pass.decision);
                decisions[decision.context("a pass without a decision")?] += 1;
                let name = pass.name.split(':').next().unwrap_or_default();
                let row = passes.iter().position(|row| row.name == name).unwrap_or_else(|| {
                    passes.push(PassRow { name: name.to_owned(), ran: 0.0, gpu_ms: 0.0 });
                    passes.len() - 1
                });
                passes[row].ran += if pass.decision == "ran" { share } else { 0.0 };
                passes[row].gpu_ms += share * pass.gpu_ms.unwrap_or(0.0);
            }
        }
        let gpu_time: Spread = spread(&gpu_times)?;
        let [ran, reused, culled] = decisions.map(|count| count as f64 * share);
        let row = Row {
            scenario: scenario.name(),
            caustics,
            cache,
            ran,
            reused,
            culled,
            gpu_ms: gpu_time.median,
            gpu_ms_spread: gpu_time.interquartile(),
            frame_ms: spread(&frame_times)?.median,
            cache_mib: cache_bytes as f64 / f64::from(1 << 20),
            passes,
        };
        Ok((row, renderer.into_gpu()))
    }
}

impl Results {
    const HEADINGS: [&'static str; 10] =
        ["scenario", "caustics", "cache", "ran", "reused", "culled", "GPU ms", "±", "frame ms", "MiB held"];

    fn cells(&self) -> Vec<Vec<String>> {
        let line = |row: &Row| {
            vec![
                row.scenario.to_owned(),
                if row.caustics { "yes" } else { "no" }.to_owned(),
                row.cache.to_owned(),
                format!("{:.1}", row.ran),
                format!("{:.1}", row.reused),
                format!("{:.1}", row.culled),
                format!("{:.2}", row.gpu_ms),
                format!("{:.2}", row.gpu_ms_spread),
                format!("{:.2}", row.frame_ms),
                format!("{:.1}", row.cache_mib),
            ]
        };
        self.rows.iter().map(line).collect()
    }

    fn summary(&self) -> String {
        let camera = self.camera_ratio.map_or_else(|| "-".into(), |ratio| format!("{ratio:.3}"));
        format!(
            "{}: caustics cost a camera that moves alone {camera} of the GPU time without them, and a frame without change {:.3} \
             of the whole time",
            self.input, self.static_ratio
        )
    }

    /// Repeated frames that ran something, and ratios beyond a threshold.
    fn judge(&self, threshold: Option<f64>) -> Result<()> {
        let Some(threshold) = threshold else { return Ok(()) };
        let repeated = [Scenario::Static.name(), Scenario::PausedClip.name()];
        let busy =
            self.rows.iter().find(|row| row.cache == MODES[0].0 && repeated.contains(&row.scenario) && row.ran > 0.0);
        if let Some(row) = busy {
            return Err(OverThreshold(format!("repeated frames of `{}` run passes", row.scenario)).into());
        }
        let worst = self.camera_ratio.unwrap_or(0.0).max(self.static_ratio);
        if worst > threshold {
            return Err(
                OverThreshold(format!("caustics that do not change cost {worst:.3}, more than {threshold}")).into()
            );
        }
        Ok(())
    }
}

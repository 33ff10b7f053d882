//! `murano bench refraction`: every method's run time against its error, over models, poses and indices of refraction.

mod growth;
mod page;

pub use page::angle_map;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use murano_gpu::Gpu;
use murano_metrics::paths::Silhouette;
use murano_refraction::{Method, Refraction};
use murano_render::{Settings, open_shot};
use murano_scene::{ClipChoice, GlassBodies};
use serde::Serialize;

use super::{
    growth::Growth,
    output::{Facts, Output, file_name},
};
use crate::{
    compare::{RefractionRow, table},
    options::AdapterOption,
    terminal::{Progress, say},
    trial::{RefractionTrial, Subject, Truth},
    values::{self, MethodChoice},
};

/// Run time against error of every refraction method
///
/// Each model is made glass and taken at every time and every index of refraction. Errors are against the two-interface
/// path traced in f64; times are medians of the passes that find and draw the glass, on an adapter that is warm, with
/// nothing reused.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    murano bench refraction assets/bumpy.glb assets/swan.glb --html out/refraction.html\n  \
    murano bench refraction fox.glb --clip Run --times 0,0.4 --iors 1.5 --methods dir:5,newton:5 --json out/fox.json")]
pub struct Arguments {
    /// Models (.glb, .gltf) or shots (.ron)
    #[arg(value_name = "INPUT", required_unless_present = "growth_only")]
    inputs: Vec<PathBuf>,
    /// Clip that plays; the first one unless said otherwise
    #[arg(long, value_name = "NAME|INDEX", value_parser = values::clip())]
    clip: Option<ClipChoice>,
    /// Times in the clip, seconds
    #[arg(long, value_name = "S,...", value_delimiter = ',', value_parser = values::number, default_value = "0")]
    times: Vec<f64>,
    /// Indices of refraction
    #[arg(
        long, value_name = "N,...", value_delimiter = ',', value_parser = values::index_of_refraction,
        default_value = "1.2,1.5"
    )]
    iors: Vec<f64>,
    /// Picture size in pixels
    #[arg(long, value_name = "WxH", value_parser = values::size, default_value = "512x512")]
    size: [u32; 2],
    /// Methods, each with its steps or its forms after a colon, as for `murano compare`
    #[arg(
        long,
        value_name = "A:STEPS,...",
        value_delimiter = ',',
        default_value = "sir,isr,dir:2,dir:5,dir:12,newton:1,newton:2,newton:5,layers,exact"
    )]
    methods: Vec<MethodChoice>,
    /// Frames timed for each figure
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// Leaves out how cost grows with triangles, pixels, bodies and steps
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
    size: [u32; 2],
    runs: u32,
    subjects: Vec<SubjectResult>,
    growth: Vec<Growth>,
}

/// One model at one time and index of refraction.
#[derive(Serialize)]
struct SubjectResult {
    input: String,
    triangles: usize,
    time: f64,
    ior: f64,
    covered: usize,
    rows: Vec<RefractionRow>,
    #[serde(skip)]
    pictures: Vec<page::Portrait>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    arguments.output.prepare()?;
    let chosen = arguments.chosen()?;
    let mut gpu = arguments.adapter.open()?;
    let facts = Facts::gather(&gpu);
    let subjects = arguments.inputs.len() * arguments.times.len() * arguments.iors.len();
    let growth_points = if arguments.no_growth { 0 } else { growth::POINTS };
    let mut progress = Progress::new("measurements", (subjects * arguments.methods.len() + growth_points) as u64);
    let mut results = Results { facts, size: arguments.size, runs: arguments.runs, subjects: vec![], growth: vec![] };
    for input in &arguments.inputs {
        for &time in &arguments.times {
            for &ior in &arguments.iors {
                let (subject, device) = arguments
                    .measure(gpu, input, time, ior, &chosen, &mut progress)
                    .with_context(|| format!("{} at {time} s, n = {ior}", input.display()))?;
                gpu = device;
                results.subjects.push(subject);
            }
        }
    }
    if !arguments.no_growth {
        results.growth = growth::measure(gpu, arguments.runs as usize, &mut progress)?;
    }
    progress.finish();
    if !arguments.output.json_on_stdout() {
        for text in results.subjects.iter().map(SubjectResult::text).chain(results.growth.iter().map(Growth::to_string))
        {
            say(text)?;
        }
    }
    arguments.output.write(&results, || page::page(&results))
}

impl Arguments {
    /// The methods asked for.
    fn chosen(&self) -> Result<Vec<Refraction>> {
        let usual = Refraction::default();
        let refraction = |choice: &MethodChoice| match *choice {
            MethodChoice::Refraction(choice) => Ok(choice.of(usual)),
            MethodChoice::Caustics(..) => {
                bail!("--methods of `bench refraction` are methods of refraction; see `murano bench caustics`")
            }
        };
        self.methods.iter().map(refraction).collect()
    }

    #[allow(clippy::too_many_arguments)]
    fn measure(
        &self,
        gpu: Gpu,
        input: &Path,
        time: f64,
        ior: f64,
        chosen: &[Refraction],
        progress: &mut Progress,
    ) -> Result<(SubjectResult, Gpu)> {
        let mut shot = open_shot(input)?;
        shot.clip = self.clip.clone().unwrap_or(shot.clip);
        shot.hold = Some(time);
        shot.glass.bodies = GlassBodies::All;
        shot.glass.ior = Some(ior);
        shot.output.size = self.size;
        let settings = Settings { caustics: None, ..Settings::default() };
        let mut subject = Subject::open(gpu, shot, &settings)?;
        let truth = Truth::trace(&subject)?;
        let (mut rows, mut pictures) = (Vec::new(), Vec::new());
        let portrayed = self.output.page() && time == self.times[0] && ior == self.iors[self.iors.len() - 1];
        let truth_picture = truth.picture().filter(|_| portrayed);
        pictures.extend(truth_picture.map(page::Portrait::of_truth).transpose()?);
        for &refraction in chosen {
            let trial =
                RefractionTrial::run(&mut subject, &truth, refraction, Silhouette::Exclude, self.runs as usize)?;
            let row = RefractionRow::new(&trial);
            if portrayed && refraction.method != Method::Sir {
                pictures.extend(page::Portrait::of_trial(&row, &trial, self.size)?);
            }
            rows.push(row);
            progress.advance();
        }
        let result = SubjectResult {
            input: file_name(input),
            triangles: subject.glass_triangles(),
            time,
            ior,
            covered: truth.covered(),
            rows,
            pictures,
        };
        Ok((result, subject.into_gpu()))
    }
}

impl SubjectResult {
    fn title(&self) -> String {
        format!("{}, {} s, n = {}", self.input, self.time, self.ior)
    }

    fn text(&self) -> String {
        format!("{} ({} triangles, {} pixels)\n{}", self.title(), self.triangles, self.covered, table(&self.rows))
    }
}

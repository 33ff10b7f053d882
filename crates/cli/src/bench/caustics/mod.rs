//! `murano bench caustics`: every caustics method's run time against its error, over models and numbers of photons.

mod page;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use murano_caustics::Caustics;
use murano_gpu::Gpu;
use murano_refraction::{Interfaces, Refraction};
use murano_render::{Settings, open_shot};
use murano_scene::{ClipChoice, GlassBodies, ShotLightKind};
use serde::Serialize;

use super::{
    growth::{Growth, GrowthPoint},
    output::{Facts, Output, file_name},
};
use crate::{
    compare::{CausticRow, caustic_table},
    options::AdapterOption,
    terminal::{Progress, say, watched},
    trial::{CausticTrial, CausticTruth, Subject},
    values::{self, MethodChoice},
};

/// Run time against error of every caustics method
///
/// Each model is made glass over a floor, lit by every light asked for. The irradiance that reaches the floor is compared
/// with photons traced in f64: with the light that was refracted in and out, or with --interfaces all with all of it. Times are
/// medians of the passes from the light's interface map to the caustic map, with nothing reused.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    murano bench caustics assets/bumpy.glb assets/sphere.glb --html out/caustics.html\n  \
    murano bench caustics bunny.glb --photons 128,512 --map-sizes 512 --lights point --json out/bunny.json")]
pub struct Arguments {
    /// Models (.glb, .gltf) or shots (.ron)
    #[arg(value_name = "INPUT", required = true)]
    inputs: Vec<PathBuf>,
    /// Clip that plays; the first one unless said otherwise
    #[arg(long, value_name = "NAME|INDEX", value_parser = values::clip())]
    clip: Option<ClipChoice>,
    /// Time in the clip, seconds
    #[arg(long, value_name = "S", value_parser = values::number, default_value = "0")]
    time: f64,
    /// Index of refraction
    #[arg(long, value_name = "N", value_parser = values::index_of_refraction, default_value = "1.5")]
    ior: f64,
    /// Lights
    #[arg(
        long, value_name = "KIND,...", value_delimiter = ',', value_parser = values::light_kind,
        default_value = "spot,directional"
    )]
    lights: Vec<ShotLightKind>,
    /// Which light is drawn and counts as the truth: what is refracted in and out, or all that comes by way of the glass
    #[arg(
        long, value_name = "two|all", value_parser = values::one_of::<Interfaces, _>(Interfaces::ALL.map(Interfaces::name)),
        default_value = "two"
    )]
    interfaces: Interfaces,
    /// Methods, of caustics
    #[arg(long, value_name = "A,B", value_delimiter = ',', default_value = "splat,shah,beams,footprint")]
    methods: Vec<MethodChoice>,
    /// Photons along a side
    #[arg(
        long, value_name = "N,...", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=8192),
        default_value = "64,128,256,512"
    )]
    photons: Vec<u32>,
    /// Texels along a side of the caustic map
    #[arg(
        long, value_name = "N,...", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(16..=8192),
        default_value = "256,512,1024"
    )]
    map_sizes: Vec<u32>,
    /// Photons traced for the truth
    #[arg(long, value_name = "N", default_value_t = 4_000_000, value_parser = clap::value_parser!(u64).range(1..))]
    truth_photons: u64,
    /// Frames timed for each figure
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
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
    interfaces: &'static str,
    subjects: Vec<SubjectResult>,
    growth: Vec<Growth>,
}

/// One model under one light.
#[derive(Serialize)]
struct SubjectResult {
    input: String,
    light: &'static str,
    triangles: usize,
    ior: f64,
    /// Watts on the compared square, by the truth.
    flux: f64,
    rows: Vec<CausticRow>,
    #[serde(skip)]
    pictures: Vec<page::Portrait>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    arguments.output.prepare()?;
    let chosen = arguments.chosen()?;
    let mut gpu = arguments.adapter.open()?;
    let mut results = Results {
        facts: Facts::gather(&gpu),
        runs: arguments.runs,
        interfaces: arguments.interfaces.name(),
        subjects: Vec::new(),
        growth: Vec::new(),
    };
    let count = arguments.inputs.len() * arguments.lights.len() * chosen.len();
    let mut progress = Progress::new("measurements", count as u64);
    for input in &arguments.inputs {
        for &light in &arguments.lights {
            let measured = arguments
                .measure(gpu, input, light, &chosen, &mut progress)
                .with_context(|| format!("{} under a {} light", input.display(), values::light_name(light)))?;
            gpu = measured.1;
            results.subjects.push(measured.0);
        }
    }
    progress.finish();
    results.growth = results.subjects.iter().flat_map(SubjectResult::growth).collect();
    if !arguments.output.json_on_stdout() {
        results.subjects.iter().try_for_each(|subject| say(subject.text()))?;
        results.growth.iter().try_for_each(say)?;
    }
    arguments.output.write(&results, || page::page(&results))
}

impl Arguments {
    /// Every method with every number of photons and size of map.
    fn chosen(&self) -> Result<Vec<Caustics>> {
        let mut chosen = Vec::new();
        for choice in &self.methods {
            let MethodChoice::Caustics(method, photons) = *choice else {
                bail!("--methods of `bench caustics` are methods of caustics; see `murano bench refraction`");
            };
            let photons = photons.map_or_else(|| self.photons.clone(), |photons| vec![photons]);
            for &map_size in &self.map_sizes {
                for caustics in
                    photons.iter().map(|&photons| Caustics { method, photons, map_size, interfaces: self.interfaces })
                {
                    if !chosen.contains(&caustics) {
                        chosen.push(caustics);
                    }
                }
            }
        }
        Ok(chosen)
    }

    fn measure(
        &self,
        gpu: Gpu,
        input: &Path,
        light: ShotLightKind,
        chosen: &[Caustics],
        progress: &mut Progress,
    ) -> Result<(SubjectResult, Gpu)> {
        let mut shot = open_shot(input)?;
        shot.clip = self.clip.clone().unwrap_or(shot.clip);
        shot.hold = Some(self.time);
        shot.glass.bodies = GlassBodies::All;
        shot.glass.ior = Some(self.ior);
        shot.light.kind = light;
        // What is measured does not depend on the eye's picture.
        shot.output.size = [64, 64];
        let settings = Settings { refraction: Refraction::default(), ..Settings::default() };
        let mut subject = Subject::open(gpu, shot, &settings)?;
        let truth = watched("photons of the truth", |progress| {
            CausticTruth::trace(&subject, self.interfaces, self.truth_photons, progress)
        })?;
        let mut pictures = vec![page::Portrait::of_truth(&truth)?];
        let mut rows = Vec::new();
        for &caustics in chosen {
            let trial = CausticTrial::run(&mut subject, &truth, caustics, self.runs as usize)?;
            let row = CausticRow::new(&trial, truth.noise);
            pictures.push(page::Portrait::of_trial(&row, &trial, &truth)?);
            rows.push(row);
            progress.advance();
        }
        let result = SubjectResult {
            input: file_name(input),
            light: values::light_name(light),
            triangles: subject.glass_triangles(),
            ior: self.ior,
            flux: truth.map().flux(),
            rows,
            pictures,
        };
        Ok((result, subject.into_gpu()))
    }
}

impl SubjectResult {
    fn title(&self) -> String {
        format!("{}, {} light, n = {}", self.input, self.light, self.ior)
    }

    fn text(&self) -> String {
        format!("{} ({} triangles, {:.3} W)\n{}", self.title(), self.triangles, self.flux, caustic_table(&self.rows))
    }

    /// How time grows with photons, a curve a method and size of map; none with a single number of photons.
    fn growth(&self) -> Vec<Growth> {
        let mut curves: Vec<(&'static str, u32)> = self.rows.iter().map(|row| (row.method(), row.map_size())).collect();
        curves.sort_unstable();
        curves.dedup();
        let curve = |(method, map): (&'static str, u32)| {
            let rows = self.rows.iter().filter(|row| row.method() == method && row.map_size() == map);
            let points: Vec<GrowthPoint> = rows.filter_map(CausticRow::growth_point).collect();
            let measured = format!("{}: {method} into {map}²", self.title());
            (points.len() > 1).then(|| Growth::new("photons", measured, points))
        };
        curves.into_iter().filter_map(curve).collect()
    }
}

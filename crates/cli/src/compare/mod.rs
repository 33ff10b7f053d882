//! `murano compare`: error against ground truth beside time, a row a method.

mod heat_maps;
mod row;
mod sequence;

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use murano_caustics::Caustics;
use murano_metrics::paths::Silhouette;
use murano_refraction::{Interfaces, Method, Refraction};
use serde::Serialize;

use crate::{
    export::prepare_folder,
    failure::OverThreshold,
    options::{AdapterOption, ShotOptions},
    terminal::{say, say_json, watched},
    trial::{CausticTrial, CausticTruth, RefractionTrial, Subject, Truth},
    values::{self, FrameRange, MethodChoice},
};
use sequence::SequenceRow;

pub use row::{CausticRow, GLASS_PASSES, RefractionRow, caustic_table, table};

/// What counts as the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Reference {
    /// The path through two interfaces, in f64; light that was refracted twice
    Two,
    /// The whole picture, path-traced; all light that comes by way of the glass
    Path,
}

impl Reference {
    /// Of the caustics that it holds for the truth, and of those that are compared unless others are asked for.
    fn interfaces(self) -> Interfaces {
        match self {
            Self::Two => Interfaces::Two,
            Self::Path => Interfaces::All,
        }
    }
}

/// Measures methods against ground truth: error beside time, a row a method
///
/// The truth is traced on the CPU in f64 through the same pose and triangles. Angles are between directions after the
/// glass, over the pixels where truth and method both leave it. FLIP and RMSE are of the environment seen along them, or
/// with --reference path of the whole frame, which has --samples a pixel where the truth has smooth outlines and noise. Caustics
/// are compared as irradiance on the floor, within the square around 95 % of the light: of light that is refracted in and out, or
/// with --reference path of all of it.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    murano compare assets/bumpy.glb --methods sir,isr:baked,isr:view,dir,newton,layers,exact\n  \
    murano compare fox.glb --glass --time 0.4 --methods dir:5,dir:12,newton --heatmap out/heat\n  \
    murano compare assets/bumpy.glb --methods splat:512,footprint:128,footprint:256\n  \
    murano compare assets/sphere.glb --methods newton --threshold 0.05 --json\n  \
    murano compare fox.glb --glass --clip Run --methods dir,layers --frames 0..24 --threshold 1.1")]
pub struct Arguments {
    #[command(flatten)]
    shot: ShotOptions,
    #[command(flatten)]
    adapter: AdapterOption,

    /// Methods of refraction and of caustics; after colons what is to differ from the options: steps (dir:12) or photons a side
    /// (splat:256), the form of isr (isr:view:nearest), dir:uncorrected [default: --method, or all of refraction]
    #[arg(long, value_name = "A,B:NUMBER,...", value_delimiter = ',', help_heading = "Comparison")]
    methods: Vec<MethodChoice>,
    /// What counts as the truth
    #[arg(long, value_enum, default_value_t = Reference::Two, help_heading = "Comparison")]
    reference: Reference,
    /// Ends with status 1 if a row is over X: mean angle in degrees, FLIP with --reference path, relative L1 of caustics
    #[arg(long, value_name = "X", value_parser = values::number, help_heading = "Comparison")]
    threshold: Option<f64>,
    /// Compares how the picture through the glass changes from frame to frame, B excluded: flicker beside motion. With
    /// --threshold, of the change over the truth's
    #[arg(long, value_name = "A..B", conflicts_with_all = ["reference", "heatmap", "runs", "noise", "truth_photons"], help_heading = "Comparison")]
    frames: Option<FrameRange>,
    /// Frames a second [default: 24]
    #[arg(long, value_name = "N", value_parser = values::positive, requires = "frames", help_heading = "Comparison")]
    fps: Option<f64>,
    /// Writes pictures and heat maps of the errors there, and of the fixed-point range that caustics take
    #[arg(long, value_name = "DIR", help_heading = "Comparison")]
    heatmap: Option<PathBuf>,
    /// Counts the outermost ring of covered pixels too, where half a pixel of silhouette is any angle
    #[arg(long, help_heading = "Comparison")]
    silhouette: bool,
    /// Frames that are timed
    #[arg(
        long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000),
        help_heading = "Comparison"
    )]
    runs: u32,
    /// Path tracing goes on until the standard error is this part of the picture's brightness
    #[arg(long, value_name = "X", value_parser = values::positive, default_value_t = 0.1, help_heading = "Comparison")]
    noise: f64,
    /// Photons traced for the truth of caustics
    #[arg(
        long, value_name = "N", default_value_t = 4_000_000, value_parser = clap::value_parser!(u64).range(1..),
        help_heading = "Comparison"
    )]
    truth_photons: u64,
    /// One line of JSON on stdout
    #[arg(long, help_heading = "Comparison")]
    json: bool,
}

/// Everything measured.
struct Comparison {
    input: String,
    ior: f64,
    adapter: String,
    size: [u32; 2],
    /// Pixels of glass; `None` where no path was compared.
    covered: Option<usize>,
    /// Of the path-traced picture: mean standard error over mean luminance.
    noise: Option<f64>,
    rows: Vec<RefractionRow>,
    caustics: Vec<CausticRow>,
    sequences: Vec<SequenceRow>,
}

/// `--json`.
#[derive(Serialize)]
struct JsonComparison<'a> {
    input: &'a str,
    ior: f64,
    adapter: &'a str,
    size: [u32; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    covered: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise: Option<f64>,
    rows: Vec<JsonRow<'a>>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum JsonRow<'a> {
    Refraction(&'a RefractionRow),
    Caustics(&'a CausticRow),
    Sequence(&'a SequenceRow),
}

/// Most passes of path tracing, 16 samples a pixel each.
const MOST_PASSES: u32 = 64;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut shot = arguments.shot.shot()?;
    shot.output.fps = arguments.fps.unwrap_or(shot.output.fps);
    let settings = arguments.shot.settings();
    if let Some(folder) = &arguments.heatmap {
        prepare_folder(&folder.join("truth.png"))?;
    }
    let (mut subject, stage) = Subject::open_on_stage(arguments.adapter.open()?, shot, &settings)?;
    let (refractions, caustics) = arguments.chosen(settings.refraction);
    let mut comparison = Comparison {
        input: arguments.shot.input().display().to_string(),
        ior: subject.ior()?,
        adapter: subject.adapter(),
        size: subject.request.size,
        covered: None,
        noise: None,
        rows: Vec::new(),
        caustics: Vec::new(),
        sequences: Vec::new(),
    };
    if let Some(range) = arguments.frames {
        ensure!(caustics.is_empty(), "--frames compares pictures through glass; leave methods of caustics out");
        let ring = arguments.ring();
        comparison.sequences = sequence::compare(&mut subject, &stage, &settings, range, &refractions, ring)?;
    } else if !refractions.is_empty() {
        arguments.compare_refraction(&mut subject, &refractions, &mut comparison)?;
    }
    if !caustics.is_empty() {
        arguments.compare_caustics(&mut subject, &caustics, &mut comparison)?;
    }
    if arguments.json {
        say_json(&comparison.json())?;
    } else {
        comparison.say()?;
    }
    arguments.judge(&comparison)
}

impl Comparison {
    /// Rows of both kinds in one list.
    fn json(&self) -> JsonComparison<'_> {
        let refraction = self.rows.iter().map(JsonRow::Refraction);
        JsonComparison {
            input: &self.input,
            ior: self.ior,
            adapter: &self.adapter,
            size: self.size,
            covered: self.covered,
            noise: self.noise,
            rows: refraction
                .chain(self.caustics.iter().map(JsonRow::Caustics))
                .chain(self.sequences.iter().map(JsonRow::Sequence))
                .collect(),
        }
    }

    fn say(&self) -> Result<()> {
        let covered = self.covered.map_or_else(String::new, |pixels| format!(", {pixels} pixels of glass"));
        say(format_args!("{}, n = {}{covered}", self.adapter, self.ior))?;
        if let Some(noise) = self.noise {
            say(format_args!("FLIP and RMSE against a path-traced picture, standard error {:.2} %", 100.0 * noise))?;
        }
        if !self.rows.is_empty() {
            say(table(&self.rows))?;
        }
        if !self.caustics.is_empty() {
            say(caustic_table(&self.caustics))?;
        }
        if !self.sequences.is_empty() {
            say(sequence::table(&self.sequences))?;
        }
        Ok(())
    }
}

impl Arguments {
    /// The methods asked for.
    fn chosen(&self, usual: Refraction) -> (Vec<Refraction>, Vec<Caustics>) {
        if self.methods.is_empty() && self.shot.names_method() {
            return (vec![usual], Vec::new());
        }
        if self.methods.is_empty() {
            return (Method::ALL.map(|method| Refraction { method, ..usual }).to_vec(), Vec::new());
        }
        let (mut refractions, mut caustics) = (Vec::new(), Vec::new());
        for choice in &self.methods {
            match *choice {
                MethodChoice::Refraction(choice) => refractions.push(choice.of(usual)),
                MethodChoice::Caustics(method, photons) => {
                    let interfaces = self.reference.interfaces();
                    let usual = self.shot.caustics(Caustics { interfaces, ..Caustics::default() });
                    caustics.push(Caustics { method, photons: photons.unwrap_or(usual.photons), ..usual });
                }
            }
        }
        (refractions, caustics)
    }

    fn compare_refraction(
        &self,
        subject: &mut Subject,
        refractions: &[Refraction],
        comparison: &mut Comparison,
    ) -> Result<()> {
        let mut truth = Truth::trace(subject)?;
        comparison.covered = Some(truth.covered());
        if self.reference == Reference::Path {
            truth = watched("tasks of path tracing", |progress| {
                truth.with_path_traced_picture(subject, MOST_PASSES, self.noise, progress)
            })?;
            comparison.noise = truth.noise();
        }
        let ring = self.ring();
        for &refraction in refractions {
            let trial = RefractionTrial::run(subject, &truth, refraction, ring, self.runs as usize)
                .with_context(|| format!("method {}", refraction.method))?;
            if let Some(folder) = &self.heatmap {
                heat_maps::write_refraction(folder, subject.request.size, &truth, &trial)?;
            }
            comparison.rows.push(RefractionRow::new(&trial));
        }
        Ok(())
    }

    fn ring(&self) -> Silhouette {
        if self.silhouette { Silhouette::Include } else { Silhouette::Exclude }
    }

    fn compare_caustics(&self, subject: &mut Subject, chosen: &[Caustics], comparison: &mut Comparison) -> Result<()> {
        let light = self.reference.interfaces();
        let truth = watched("photons", |progress| CausticTruth::trace(subject, light, self.truth_photons, progress))?;
        for &caustics in chosen {
            let trial = CausticTrial::run(subject, &truth, caustics, self.runs as usize)
                .with_context(|| format!("method {}", caustics.method))?;
            if let Some(folder) = &self.heatmap {
                heat_maps::write_caustics(folder, &truth, &trial)?;
            }
            comparison.caustics.push(CausticRow::new(&trial, truth.noise));
        }
        Ok(())
    }

    /// Whether every row keeps the threshold. A row without anything to compare does not.
    fn judge(&self, comparison: &Comparison) -> Result<()> {
        let Some(threshold) = self.threshold else { return Ok(()) };
        let refraction = comparison.rows.iter().map(|row| match self.reference {
            Reference::Two => (row.label(), row.mean_deg(), "degrees"),
            Reference::Path => (row.label(), row.flip().unwrap_or(f64::NAN), "FLIP"),
        });
        let caustics = comparison.caustics.iter().map(|row| (row.label(), row.relative_l1(), "relative L1"));
        let sequences = comparison.sequences.iter().map(|row| (row.label(), row.ratio(), "times the truth's change"));
        let over: Vec<String> = refraction
            .chain(caustics)
            .chain(sequences)
            // What could not be measured keeps no threshold.
            .filter(|(_, value, _)| value.is_nan() || *value > threshold)
            .map(|(label, value, unit)| format!("{label} has {value:.4} {unit}"))
            .collect();
        if over.is_empty() {
            return Ok(());
        }
        Err(OverThreshold(format!("over the threshold of {threshold}: {}", over.join("; "))).into())
    }
}

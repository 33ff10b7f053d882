//! `murano export`: frames to files.

mod contact_sheet;
mod destination;
mod exr_file;
mod report;
mod video;
mod whole_file;
mod writers;

pub use destination::prepare_folder;
pub use whole_file::write_whole;

use std::time::Instant;
use std::{
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use anyhow::{Context, Result, bail};
use clap::{Args, builder::PossibleValuesParser};
use murano_render::{AOV_LAYERS, Frame, Renderer, Stage};
use murano_scene::Shot;

use crate::{
    failure::{INTERRUPTED, Interrupted},
    options::{AdapterOption, ShotOptions},
    terminal::{Progress, say_json},
    values::{self, FrameRange},
};
use contact_sheet::ContactSheet;
use destination::{Destination, Format};
use report::FrameLine;
use video::Video;
use writers::Writers;

/// Renders a sequence of frames to files
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    murano export animations/demo.ron -o out/frame_####.png\n  \
    murano export fox.glb --glass --frames 0..48 --orbit 15 -o 'out/fox_{frame:04}.png' --video out/fox.mp4\n  \
    murano export assets/sphere.glb -o out/sphere.exr --aov p1,n1,exit_direction,status")]
pub struct Arguments {
    #[command(flatten)]
    shot: ShotOptions,
    #[command(flatten)]
    adapter: AdapterOption,

    /// Files: .png or .exr, with #### or {frame:04} where the frame's number goes
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    output: Option<String>,
    /// Frames, B excluded [default: the whole shot, or one loop of the clip]
    #[arg(long, value_name = "A..B", help_heading = "Output")]
    frames: Option<FrameRange>,
    /// Frames a second [default: 24]
    #[arg(long, value_name = "N", value_parser = values::positive, help_heading = "Output")]
    fps: Option<f64>,
    /// Layers of a multi-layer .exr written beside each frame: linear f32, world space, metres
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', value_parser = PossibleValuesParser::new(AOV_LAYERS),
        help_heading = "Output"
    )]
    aov: Vec<String>,
    /// A film of all frames; needs ffmpeg
    #[arg(long, value_name = "FILE.mp4", help_heading = "Output")]
    video: Option<PathBuf>,
    /// One .png with every frame in small
    #[arg(long, value_name = "FILE.png", help_heading = "Output")]
    contact_sheet: Option<PathBuf>,
    /// One line of JSON a frame on stdout, and one at the end
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// What became of every pass of every frame, and why, on stderr
    #[arg(long, help_heading = "Scheduling")]
    explain: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut shot = arguments.shot.shot()?;
    shot.output.fps = arguments.fps.unwrap_or(shot.output.fps);
    let destination = arguments.destination()?;
    let stop = stop_on_interrupt()?;

    let (world, stage) = Stage::open(shot)?;
    let range = arguments.frames.unwrap_or(FrameRange { start: 0, end: stage.frame_count() });
    if let Some(destination) = &destination {
        destination.prepare(range.count())?;
    }
    let outputs = Outputs::open(arguments, destination, stage.shot(), range)?;
    let renderer = Renderer::new(arguments.adapter.open()?, world)?;
    Export { arguments, stage, renderer, range, stop }.run(outputs)
}

impl Arguments {
    /// Where frames go; `None` if only a film or a contact sheet is wanted.
    fn destination(&self) -> Result<Option<Destination>> {
        let Some(output) = &self.output else {
            if !self.aov.is_empty() {
                bail!("--aov needs a place to write to: -o out/frame_####.exr");
            }
            if self.video.is_none() && self.contact_sheet.is_none() {
                bail!("nothing to write to: give -o out/frame_####.png, --video or --contact-sheet");
            }
            return Ok(None);
        };
        Destination::parse(output).map(Some)
    }

    /// Layers of the .exr beside each frame. A frame that is itself an .exr holds linear radiance unless told otherwise.
    fn layers(&self, destination: Option<&Destination>) -> Vec<String> {
        let plain_exr = destination.is_some_and(|destination| destination.format() == Format::Exr);
        if self.aov.is_empty() && plain_exr {
            return vec!["radiance".into()];
        }
        let mut layers: Vec<String> = Vec::new();
        for layer in &self.aov {
            if !layers.contains(layer) {
                layers.push(layer.clone());
            }
        }
        layers
    }
}

/// A flag that Ctrl-C raises; a second Ctrl-C ends the program at once.
fn stop_on_interrupt() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })
    .context("Ctrl-C cannot be caught")?;
    Ok(stop)
}

/// Everything that frames are written to.
struct Outputs {
    destination: Option<Destination>,
    layers: Vec<String>,
    writers: Writers,
    video: Option<Video>,
    sheet: Option<ContactSheet>,
}

impl Outputs {
    /// Opens everything, so that a wrong path shows before the first frame is rendered.
    fn open(arguments: &Arguments, destination: Option<Destination>, shot: &Shot, range: FrameRange) -> Result<Self> {
        let size = shot.output.size;
        let video = arguments.video.as_deref().map(|path| Video::open(path, size, shot.output.fps)).transpose()?;
        let sheet = arguments.contact_sheet.as_deref().map(|path| ContactSheet::open(path, size, range.count()));
        let layers = arguments.layers(destination.as_ref());
        Ok(Self { destination, layers, writers: Writers::new()?, video, sheet: sheet.transpose()? })
    }

    /// Takes a frame; its files are written while the next one is rendered.
    fn take(&mut self, number: u32, mut frame: Frame) -> Result<()> {
        if let Some(sheet) = &mut self.sheet {
            sheet.add(&frame);
        }
        if let Some(video) = &mut self.video {
            video.add(&frame)?;
        }
        let Some(destination) = &self.destination else { return Ok(()) };
        if let Some(aov) = frame.aov.take().filter(|_| !self.layers.is_empty()) {
            let path = destination.path(number).with_extension("exr");
            let (layers, size) = (self.layers.clone(), frame.size);
            self.writers.submit(move || exr_file::write(&path, size, aov, &layers))?;
        }
        if destination.format() == Format::Png {
            let path = destination.path(number);
            self.writers.submit(move || writers::write_png(&path, frame.size, &frame.rgba))?;
        }
        Ok(())
    }

    /// Waits until everything is written.
    fn finish(self) -> Result<()> {
        self.writers.finish()?;
        self.video.map_or(Ok(()), Video::finish)?;
        self.sheet.map_or(Ok(()), |sheet| sheet.finish())
    }
}

/// An export under way.
struct Export<'a> {
    arguments: &'a Arguments,
    stage: Stage,
    renderer: Renderer,
    range: FrameRange,
    stop: Arc<AtomicBool>,
}

impl Export<'_> {
    fn run(mut self, mut outputs: Outputs) -> Result<()> {
        let mut settings = self.arguments.shot.settings();
        settings.aov = !outputs.layers.is_empty();
        let fps = self.stage.shot().output.fps;
        let mut progress = Progress::new("frames", u64::from(self.range.count()));
        for number in self.range.start..self.range.end {
            if self.stop.load(Ordering::SeqCst) {
                progress.finish();
                outputs.writers.finish()?;
                return Err(Interrupted.into());
            }
            let request = self.stage.request(f64::from(number) / fps, &settings);
            let start = Instant::now();
            let frame = self.renderer.render(&request).with_context(|| format!("frame {number}"))?;
            let cpu_ms = start.elapsed().as_secs_f64() * 1e3;
            if self.arguments.explain {
                progress.note(&report::explanation(number, request.time(), cpu_ms, &frame));
            }
            if self.arguments.json {
                say_json(&FrameLine::new(number, request.time(), cpu_ms, &frame))?;
            }
            outputs.take(number, frame)?;
            progress.advance();
        }
        outputs.finish()?;
        progress.finish();
        if self.arguments.json {
            say_json(&report::summary(self.range.count(), progress.seconds()))?;
        } else {
            progress.note(&format!("{} frames in {:.1} s", self.range.count(), progress.seconds()));
        }
        Ok(())
    }
}

//! How long frames take.

use std::time::Instant;

use anyhow::Result;
use glam::DVec3;
use murano_animation::Layer;
use murano_metrics::spread::{Spread, spread};
use murano_refraction::Refraction;
use murano_render::{FrameRequest, Renderer, Skipping, ToneMap, View};

/// Times of one request rendered again and again with nothing reused.
#[derive(Clone, Debug)]
pub struct Timing {
    /// GPU milliseconds of each pass (name without its instance), summed over its instances: one entry a run.
    passes: Vec<(String, Vec<f64>)>,
    /// Wall-clock milliseconds of a frame, planning and reading back included.
    pub frame: Spread,
}

impl Timing {
    /// GPU milliseconds of some passes together; `None` where the adapter has no timestamps or none of them ran.
    pub fn of_passes(&self, names: &[&str]) -> Option<Spread> {
        let chosen: Vec<_> = self.passes.iter().filter(|(name, _)| names.contains(&name.as_str())).collect();
        let runs = chosen.first()?.1.len();
        let sums: Vec<f64> = (0..runs).map(|run| chosen.iter().map(|(_, times)| times[run]).sum()).collect();
        spread(&sums).ok()
    }
}

/// Renders a request twice to warm up, then `runs` times, each time from nothing.
///
/// # Errors
/// The device's.
pub fn time_frames(renderer: &mut Renderer, request: &FrameRequest, runs: usize) -> Result<Timing> {
    let mut request = request.clone();
    request.skipping = Skipping::Off;
    request.aov = false;
    for _ in 0..2 {
        renderer.render(&request)?;
    }
    let mut frames = Vec::with_capacity(runs);
    let mut passes: Vec<(String, Vec<f64>)> = Vec::new();
    for run in 0..runs {
        let start = Instant::now();
        let frame = renderer.render(&request)?;
        frames.push(start.elapsed().as_secs_f64() * 1e3);
        for pass in &frame.passes {
            let Some(ms) = pass.gpu_ms else { continue };
            let name = pass.name.split(':').next().unwrap_or_default();
            let slot = passes.iter().position(|(known, _)| known == name).unwrap_or_else(|| {
                passes.push((name.to_owned(), vec![0.0; runs]));
                passes.len() - 1
            });
            passes[slot].1[run] += ms;
        }
    }
    Ok(Timing { passes, frame: spread(&frames)? })
}

/// GPU milliseconds of all deform passes of a pose, from nothing each time; `None` where the adapter has no timestamps.
///
/// # Errors
/// The device's.
pub fn time_deformation(renderer: &mut Renderer, playing: Vec<Layer>, runs: usize) -> Result<Option<Spread>> {
    // A picture of one pixel, so that little else is done.
    let request = FrameRequest {
        playing,
        size: [1, 1],
        view: View::look_at(DVec3::new(0.0, 0.0, 100.0), DVec3::ZERO, 0.1),
        lights: Vec::new(),
        refraction: Refraction::default(),
        caustics: None,
        samples: 1,
        exposure: 1.0,
        tone_map: ToneMap::Linear,
        aov: false,
        before: None,
        skipping: Skipping::Off,
    };
    Ok(time_frames(renderer, &request, runs)?.of_passes(&["deform"]))
}

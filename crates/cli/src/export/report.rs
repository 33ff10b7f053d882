//! What is said about frames.

use std::fmt::Write as _;

use murano_render::Frame;
use serde::Serialize;

/// One frame of `--json`.
#[derive(Serialize)]
pub struct FrameLine<'a> {
    frame: u32,
    time: f64,
    cpu_ms: f64,
    gpu_ms: f64,
    passes: Vec<PassLine<'a>>,
}

#[derive(Serialize)]
struct PassLine<'a> {
    name: &'a str,
    decision: &'a str,
    reason: &'a str,
    gpu_ms: Option<f64>,
}

impl<'a> FrameLine<'a> {
    /// `time` is the time in the clip, seconds; `cpu_ms` the wall time of planning, recording and waiting.
    pub fn new(number: u32, time: f64, cpu_ms: f64, frame: &'a Frame) -> Self {
        let passes = frame.passes.iter().map(|pass| PassLine {
            name: &pass.name,
            decision: pass.decision,
            reason: &pass.reason,
            gpu_ms: pass.gpu_ms,
        });
        Self { frame: number, time, cpu_ms, gpu_ms: frame.gpu_ms, passes: passes.collect() }
    }
}

/// The last line of `--json`.
#[derive(Serialize)]
pub struct Summary {
    frames: u32,
    seconds: f64,
    fps: f64,
}

/// Sums up an export.
pub fn summary(frames: u32, seconds: f64) -> Summary {
    Summary { frames, seconds, fps: f64::from(frames) / seconds.max(1e-9) }
}

/// `--explain`: a line a pass.
pub fn explanation(number: u32, time: f64, cpu_ms: f64, frame: &Frame) -> String {
    let mut text = format!(
        "frame {number}  t = {time:.4} s  cpu {cpu_ms:.1} ms  gpu {:.1} ms  cache {:.1} MiB",
        frame.gpu_ms,
        frame.cache_bytes as f64 / f64::from(1 << 20)
    );
    for pass in &frame.passes {
        let time = pass.gpu_ms.map_or_else(String::new, |ms| format!("{ms:.2} ms"));
        // Writing to a string cannot fail.
        let _ = write!(text, "\n  {:<20} {:<7} {time:>10}  {}", pass.name, pass.decision, pass.reason);
    }
    text
}

//! A loop played for long: its last frame is its first.

use anyhow::Result;
use glam::DVec3;
use murano_animation::{Layer, clip_time};
use murano_gpu::Gpu;
use murano_refraction::Method;
use murano_render::{Frame, FrameRequest, Renderer, Skipping};
use murano_scene::{Channel, Clip, Interpolation, LoopMode, Path, Sampler, Scene};

use super::{
    bodies::Body,
    case::{Case, Truth, looking},
    measure::{request, world},
    table::Row,
};

/// Frames a second; the clip lasts one.
const FPS: u32 = 25;

/// Renders so many frames of a loop and compares the last with the first, bit for bit, and every loop with the first one.
pub fn thousand_frames(gpu: Gpu, frames: u32) -> Result<Row> {
    let view = looking(DVec3::new(0.0, 1.0, 3.0), DVec3::ZERO, 50.0);
    let case = Case::new("loop", scene(), view, Truth::Unknown).sized([24, 24]).at_time(0.0);
    let mut renderer = Renderer::new(gpu, world(case.scene.clone(), None))?;
    let at = |number: u32, skipping: Skipping| FrameRequest {
        playing: Layer::alone(Some(0), clip_time(LoopMode::Loop, f64::from(number) / f64::from(FPS), 1.0)),
        skipping,
        ..request(&case, Method::Newton)
    };
    let mut problems = Vec::new();
    let mut first_loop: Vec<Frame> = Vec::new();
    let mut farthest = 0;
    for number in 0..frames {
        let frame = renderer.render(&at(number, Skipping::On))?;
        match first_loop.get((number % FPS) as usize).filter(|_| number >= FPS) {
            // Times of later loops are rounded elsewhere.
            Some(first) => farthest = farthest.max(largest_difference(first, &frame)),
            None => first_loop.push(frame),
        }
    }
    if farthest > 1 {
        problems.push(format!("a later loop differs from the first by {farthest} of 255"));
    }
    let last = renderer.render(&at(frames, Skipping::Off))?;
    if !same_bits(&first_loop[0], &last) {
        problems.push(format!("frame {frames}, rendered anew, differs from frame 0"));
    }
    if frames as usize >= 2 * first_loop.len() && same_bits(&first_loop[0], &first_loop[first_loop.len() / 2]) {
        problems.push("nothing moves".into());
    }
    Ok(Row::of_checks("a loop's last frame is its first", frames + 1, problems))
}

/// A ball that turns around and breathes, one second long.
fn scene() -> Scene {
    let mut scene = Body::torus(0.8, 0.3, 32, 16).alone(1.5);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let rotation = Sampler {
        interpolation: Interpolation::Linear,
        times: vec![0.0, 0.25, 0.5, 0.75, 1.0],
        width: 4,
        values: [
            [0.0, 0.0, 0.0, 1.0],
            [half, 0.0, 0.0, half],
            [1.0, 0.0, 0.0, 0.0],
            [half, 0.0, 0.0, -half],
            [0.0, 0.0, 0.0, -1.0],
        ]
        .concat(),
    };
    let scale = Sampler {
        interpolation: Interpolation::CubicSpline,
        times: vec![0.0, 0.5, 1.0],
        width: 3,
        values: [0.0, 1.0, 0.0, 0.0, 1.3, 0.0, 0.0, 1.0, 0.0].map(|value| [value; 3]).concat(),
    };
    let channels = [(Path::Rotation, rotation), (Path::Scale, scale)];
    scene.clips.push(Clip {
        name: "loop".into(),
        channels: channels.map(|(path, sampler)| Channel { node: 0, path, sampler }).into(),
        duration: 1.0,
        ..Clip::default()
    });
    scene
}

fn largest_difference(a: &Frame, b: &Frame) -> u8 {
    a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

fn same_bits(a: &Frame, b: &Frame) -> bool {
    let bits = |frame: &Frame| -> Vec<u32> {
        let layers = frame.aov.iter().flat_map(|aov| &aov.layers);
        layers.flat_map(|layer| &layer.planes).flatten().map(|value| value.to_bits()).collect()
    };
    a.rgba == b.rgba && bits(a) == bits(b)
}

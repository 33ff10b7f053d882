//! What a frame is asked for and what comes back.

use glam::{DMat4, DVec3};
use murano_animation::Layer;
use murano_caustics::Caustics;
use murano_refraction::Refraction;
use murano_scene::{Environment, PlacedLight, Projection, Scene, look_along};
use murano_scheduler::Skipping;

/// What stays the same over a sequence of frames.
pub struct World {
    /// The model.
    pub scene: Scene,
    /// Distant light; `None` is black.
    pub environment: Option<Environment>,
    /// Height of an infinite-looking diffuse floor, metres; `None` for no floor.
    pub floor: Option<Floor>,
}

/// A square diffuse floor at a height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// World y, metres.
    pub height: f64,
    /// World x and z of its centre, metres.
    pub center: [f64; 2],
    /// Half of its side, metres.
    pub half_extent: f64,
    /// Linear RGB reflectance.
    pub albedo: [f32; 3],
}

/// A camera placed in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// `world_from_view`: rigid; the camera looks along its -Z with +Y up.
    pub world_from_view: DMat4,
    /// Projection.
    pub projection: Projection,
    /// Nearest distance shown, metres.
    pub near: f64,
}

impl View {
    /// A perspective camera at `eye` that looks at `target` with +Y up; `yfov` in radians.
    pub fn look_at(eye: DVec3, target: DVec3, yfov: f64) -> Self {
        let distance = eye.distance(target);
        Self {
            world_from_view: look_along(eye, target - eye),
            projection: Projection::Perspective { yfov },
            near: distance.max(1e-9) * 1e-3,
        }
    }
}

/// Display transform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ToneMap {
    /// Clipped at 1.
    Linear,
    /// Khronos PBR Neutral.
    #[default]
    Neutral,
    /// AgX.
    Agx,
}

/// What a frame before showed, as far as its motion asks.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// What played.
    pub playing: Vec<Layer>,
    /// The eye; its picture had the size of this one.
    pub view: View,
}

/// One frame, complete: equal requests give equal pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRequest {
    /// What plays, laid over the rest pose in order.
    pub playing: Vec<Layer>,
    /// Width and height in pixels, each at least 1.
    pub size: [u32; 2],
    /// The eye.
    pub view: View,
    /// Lights.
    pub lights: Vec<PlacedLight>,
    /// Refraction settings.
    pub refraction: Refraction,
    /// Caustics settings; `None` for none.
    pub caustics: Option<Caustics>,
    /// Rays through each pixel, at least 1: the first through its middle, further ones spread over it, and the picture their mean.
    pub samples: u32,
    /// Exposure factor applied before the tone map.
    pub exposure: f32,
    /// Display transform.
    pub tone_map: ToneMap,
    /// Whether the arbitrary output variables are wanted too.
    pub aov: bool,
    /// The frame before, for the layer `motion`, which is 0 without.
    pub before: Option<Moment>,
    /// Caching.
    pub skipping: Skipping,
}

impl FrameRequest {
    /// Time in the clip that everything else is laid over, seconds; 0 where nothing plays.
    pub fn time(&self) -> f64 {
        self.playing.first().map_or(0.0, |layer| layer.time)
    }
}

/// What became of one pass.
#[derive(Clone, Debug, PartialEq)]
pub struct PassReport {
    /// Pass name, with its instance after a colon where there are several (`deform:0`).
    pub name: String,
    /// "ran", "reused" or "culled".
    pub decision: &'static str,
    /// Why: the first input that differed, or why nothing needed it.
    pub reason: String,
    /// GPU time in milliseconds; `None` where it did not run or the adapter has no timestamps.
    pub gpu_ms: Option<f64>,
}

impl PassReport {
    /// Takes on what became of the same pass for another sample.
    pub(crate) fn join(&mut self, other: Self) {
        let rank = |decision: &str| ["culled", "reused", "ran"].iter().position(|name| *name == decision);
        let gpu_ms = self.gpu_ms.map_or(other.gpu_ms, |own| Some(own + other.gpu_ms.unwrap_or(0.0)));
        if rank(other.decision) > rank(self.decision) {
            *self = other;
        }
        self.gpu_ms = gpu_ms;
    }
}

/// A finished frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// sRGB RGBA, 4 bytes a pixel, row 0 at the top, alpha 255.
    pub rgba: Vec<u8>,
    /// Arbitrary output variables, where asked for.
    pub aov: Option<Aov>,
    /// Every pass of the plan in order.
    pub passes: Vec<PassReport>,
    /// Sum of the passes' GPU times, milliseconds.
    pub gpu_ms: f64,
    /// Bytes of GPU memory the cache holds after this frame.
    pub cache_bytes: u64,
}

/// Arbitrary output variables: one plane of f32 per channel, `width * height` each, row 0 at the top; world space.
#[derive(Clone, Debug, Default)]
pub struct Aov {
    /// Layers in a fixed order.
    pub layers: Vec<AovLayer>,
}

/// One named layer.
#[derive(Clone, Debug)]
pub struct AovLayer {
    /// Name as on the command line, e.g. `exit_direction`.
    pub name: &'static str,
    /// Channel suffixes: `["X", "Y", "Z"]`, `["R", "G", "B"]` or a single empty one.
    pub channels: &'static [&'static str],
    /// One plane a channel.
    pub planes: Vec<Vec<f32>>,
}

/// Names of every layer there is, in the order of [`Aov::layers`].
pub const AOV_LAYERS: [&str; 17] = [
    "p1",
    "n1",
    "t1",
    "p2",
    "n2",
    "exit_direction",
    "path_length",
    "bounces",
    "status",
    "depth",
    "radiance",
    "caustic",
    "shadow",
    "entries",
    "triangles",
    "guessed",
    "motion",
];

//! The frame: opaque shading, background, composite, tone map. `FrameRequest` in, `Frame` out.

mod aov;
mod bodies;
mod compound;
mod distant;
mod frame;
mod glass;
mod lighting;
mod looks;
mod materials;
mod motion;
mod order;
mod overlap;
mod renderer;
mod request;
mod stage;

pub use murano_scene::PlacedLight;
pub use murano_scheduler::Skipping;
pub use renderer::{CausticAccount, DeformedMesh, RenderError, Renderer};
pub use request::{AOV_LAYERS, Aov, AovLayer, Floor, Frame, FrameRequest, Moment, PassReport, ToneMap, View, World};
pub use stage::{Extent, Settings, Stage, StageError, find_clip, open_shot};

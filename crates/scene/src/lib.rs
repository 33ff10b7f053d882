//! The scene: nodes, meshes, materials, lights, cameras, clips and environment, and their import from glTF 2.0.
//!
//! Everything here is plain data on the CPU; no GPU type appears. World space is metres, right-handed, +Y up; a camera
//! and a light look down their local -Z (glTF). Local and world transforms are f64. Colours are linear Rec.709.

mod camera;
mod clip;
mod environment;
mod graph;
mod import;
mod light;
mod material;
mod mesh;
mod property;
mod shot;
mod variant;

pub use camera::{Camera, Projection, look_along};
pub use clip::{Channel, Clip, Interpolation, Path, Sampler};
pub use environment::{Environment, EnvironmentError};
pub use graph::{Local, Node, NodeIndex, Scene, Skin, Skinning, Transform};
pub use import::{ImportError, ImportProblem, ImportReport, import, import_bytes};
pub use light::{Light, LightKind, PlacedLight};
pub use material::{AlphaMode, Image, Material, TextureRef, Wrap};
pub use mesh::{Mesh, MorphTarget, Primitive};
pub use property::{CameraProperty, LightProperty, MaterialProperty, Property, PropertyChannel, TextureSlot};
pub use shot::{
    Aim, CameraKey, ClipChoice, EnvironmentChoice, FloorLevel, GlassBodies, LoopMode, Shot, ShotCamera, ShotError,
    ShotFloor, ShotGlass, ShotLayer, ShotLight, ShotLightKind, ShotOutput, ToneMapChoice,
};
pub use variant::VariantError;

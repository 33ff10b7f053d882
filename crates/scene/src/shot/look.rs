//! What a shot's world is made of: glass, distant light, floor, display transform.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// Which materials are glass.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum GlassBodies {
    /// Those that the file says transmit light.
    #[default]
    AsFiled,
    /// Every one.
    All,
    /// Those of these names, besides those that transmit light.
    Named(Vec<String>),
}

/// The glass of a shot. What is `None` is as filed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShotGlass {
    /// What is glass.
    pub bodies: GlassBodies,
    /// Index of refraction relative to air, at least 1.
    pub ior: Option<f64>,
    /// Linear RGB that white turns into after `attenuation_distance`.
    pub attenuation_color: Option<[f32; 3]>,
    /// Metres.
    pub attenuation_distance: Option<f32>,
    /// 20 / Abbe number.
    pub dispersion: Option<f32>,
    /// Perceptual roughness, 0 to 1, in place of the materials' own and their textures.
    pub roughness: Option<f32>,
    /// Every body of glass is a sheet around nothing (or none is), whatever the thickness of its material.
    pub thin: Option<bool>,
}

/// Distant light.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum EnvironmentChoice {
    /// The one that comes with the program.
    #[default]
    Builtin,
    /// Black.
    Absent,
    /// A `.hdr` or `.exr`.
    File(PathBuf),
}

/// Where the floor is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum FloorLevel {
    /// At the model's lowest point over the clip.
    #[default]
    Auto,
    /// Nowhere.
    Absent,
    /// At this world y, metres.
    At(f64),
}

/// The floor of a shot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShotFloor {
    /// Its height.
    pub level: FloorLevel,
    /// Linear RGB reflectance.
    pub albedo: [f32; 3],
}

impl Default for ShotFloor {
    fn default() -> Self {
        Self { level: FloorLevel::Auto, albedo: [0.36; 3] }
    }
}

/// Display transform by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToneMapChoice {
    /// Clipped at 1.
    Linear,
    /// Khronos PBR Neutral.
    #[default]
    Neutral,
    /// AgX.
    Agx,
}

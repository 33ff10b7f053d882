//! Shots: which model plays what, seen from where, lit how, made of what, written where.
//!
//! A shot is a RON file of which every field but `model` may be left out; what is left out is chosen by the stage that
//! shows it, from the posed model's bounds. This module only holds the choice.
//!
//! ```ron
//! (
//!     model: "../assets/dancer.glb",
//!     clip: "spin",
//!     camera: (azimuth: 30, orbit: 20),
//!     glass: (bodies: All, ior: 1.5),
//! )
//! ```

mod camera;
mod check;
mod error;
mod light;
mod look;
mod playback;

use std::fs;
use std::path::{Path, PathBuf};

use ron::extensions::Extensions;
use serde::{Deserialize, Serialize};

use crate::Skinning;

pub use camera::{Aim, CameraKey, ShotCamera};
pub use error::ShotError;
pub use light::{ShotLight, ShotLightKind};
pub use look::{EnvironmentChoice, FloorLevel, GlassBodies, ShotFloor, ShotGlass, ToneMapChoice};
pub use playback::{ClipChoice, LoopMode, ShotLayer, ShotOutput};

/// A whole shot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shot {
    /// The model, relative to the shot file; after loading, to the working directory.
    pub model: PathBuf,
    /// The clip that plays.
    #[serde(default)]
    pub clip: ClipChoice,
    /// Seconds of the clip that pass in a second; negative plays it backwards.
    #[serde(default = "one_f64")]
    pub speed: f64,
    /// What happens outside the clip's span.
    #[serde(default)]
    pub repeat: LoopMode,
    /// Clips laid over it, in order.
    #[serde(default)]
    pub layers: Vec<ShotLayer>,
    /// How joints are blended that move a vertex together.
    #[serde(default)]
    pub skinning: Skinning,
    /// The model's variant (KHR_materials_variants), by name or index; `None` is as it comes.
    #[serde(default)]
    pub variant: Option<ClipChoice>,
    /// Time at which the pose is held, seconds; `None` plays the clip.
    #[serde(default)]
    pub hold: Option<f64>,
    /// The camera and its path.
    #[serde(default)]
    pub camera: ShotCamera,
    /// The light and its path.
    #[serde(default)]
    pub light: ShotLight,
    /// What is glass, and which.
    #[serde(default)]
    pub glass: ShotGlass,
    /// Distant light; a file is relative to the shot file, after loading to the working directory.
    #[serde(default)]
    pub environment: EnvironmentChoice,
    /// The floor.
    #[serde(default)]
    pub floor: ShotFloor,
    /// Picture size and frames.
    #[serde(default)]
    pub output: ShotOutput,
    /// Factor on radiance before the tone map.
    #[serde(default = "one")]
    pub exposure: f32,
    /// Display transform.
    #[serde(default)]
    pub tone_map: ToneMapChoice,
}

fn one() -> f32 {
    1.0
}

fn one_f64() -> f64 {
    1.0
}

impl Shot {
    /// The shot of a bare model: everything chosen by the stage.
    pub fn for_model(model: &Path) -> Self {
        Self {
            model: model.to_owned(),
            clip: ClipChoice::First,
            speed: 1.0,
            repeat: LoopMode::Loop,
            layers: Vec::new(),
            skinning: Skinning::Linear,
            variant: None,
            hold: None,
            camera: ShotCamera::default(),
            light: ShotLight::default(),
            glass: ShotGlass::default(),
            environment: EnvironmentChoice::Builtin,
            floor: ShotFloor::default(),
            output: ShotOutput::default(),
            exposure: 1.0,
            tone_map: ToneMapChoice::Neutral,
        }
    }

    /// Reads and checks a shot; its paths become relative to the working directory.
    ///
    /// # Errors
    /// [`ShotError`] names the file and the line or the field.
    pub fn load(path: &Path) -> Result<Self, ShotError> {
        let text =
            fs::read_to_string(path).map_err(|source| ShotError::Unreadable { path: path.to_owned(), source })?;
        let mut shot: Self = dialect()
            .from_str(&text)
            .map_err(|source| ShotError::Syntax { path: path.to_owned(), source: Box::new(source) })?;
        if let Err((field, problem)) = shot.check() {
            return Err(ShotError::Invalid { path: path.to_owned(), field, problem });
        }
        let directory = path.parent().unwrap_or(Path::new(""));
        shot.model = directory.join(&shot.model);
        if let EnvironmentChoice::File(file) = &mut shot.environment {
            *file = directory.join(&*file);
        }
        Ok(shot)
    }

    /// The shot as RON that [`Shot::load`] reads.
    ///
    /// # Errors
    /// [`ShotError::Unwritable`] if a path is not UTF-8.
    pub fn to_ron(&self) -> Result<String, ShotError> {
        Ok(dialect().to_string_pretty(self, ron::ser::PrettyConfig::default())?)
    }
}

/// RON in which an optional value may be written without `Some`.
fn dialect() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

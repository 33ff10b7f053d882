//! The stage: a shot and its model made into a [`World`], and a [`FrameRequest`] for every moment of it. What the shot
//! leaves open is chosen here, from what the body sweeps over its clip.

mod extent;
mod framing;
mod glass;
mod own;
mod playing;

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use murano_animation::{GeometryError, Layer};
use murano_caustics::Caustics;
use murano_refraction::Refraction;
use murano_scene::{
    Aim, ClipChoice, Environment, EnvironmentChoice, EnvironmentError, FloorLevel, ImportError, Light, Scene, Shot,
    ShotError, ToneMapChoice, VariantError,
};

pub use extent::Extent;

use crate::{Floor, FrameRequest, Moment, PlacedLight, Skipping, ToneMap, View, World};
use framing::FramedLight;
use own::Own;
use playing::Playing;

/// Environment of a shot that names none: the studio that comes with the program.
const STUDIO: &[u8] = include_bytes!("../../../../assets/studio.hdr");
/// Half of the floor's side in radii of the body: far enough that its border disappears.
const FLOOR_EXTENT: f64 = 60.0;

/// Why a shot could not be put on stage.
#[derive(Debug, thiserror::Error)]
pub enum StageError {
    /// The input is neither a model nor a shot.
    #[error("{} is neither a model (.glb, .gltf) nor a shot (.ron); give one of these", .0.display())]
    UnknownInput(PathBuf),
    /// The shot file.
    #[error(transparent)]
    Shot(#[from] ShotError),
    /// The model.
    #[error(transparent)]
    Model(#[from] ImportError),
    /// The environment.
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
    /// The model has too many vertices.
    #[error("{}: {source}", model.display())]
    Geometry {
        /// The model file.
        model: PathBuf,
        /// What there is too much of.
        source: GeometryError,
    },
    /// The clip asked for does not exist.
    #[error("{} has no clip {wanted}; choose one of: {choices}", model.display())]
    NoClip {
        /// The model file.
        model: PathBuf,
        /// Name or index.
        wanted: String,
        /// The clips there are.
        choices: String,
    },
    /// A node that a layer is to move does not exist.
    #[error("{} has no node `{wanted}`; choose one of: {choices}", model.display())]
    NoNode {
        /// The model file.
        model: PathBuf,
        /// Name.
        wanted: String,
        /// The nodes there are.
        choices: String,
    },
    /// The model has no such variant.
    #[error("{}: {source}", model.display())]
    Variant {
        /// The model file.
        model: PathBuf,
        /// Which, and those there are.
        source: VariantError,
    },
    /// The model's camera that is to see does not exist.
    #[error("{} has no camera `{wanted}`; choose one of: {choices}", model.display())]
    NoCamera {
        /// The model file.
        model: PathBuf,
        /// Name; empty for any.
        wanted: String,
        /// The cameras there are.
        choices: String,
    },
    /// The model's lights are to light, and there are none.
    #[error("{} has no light; leave the choice of the light to the program, or describe one", .0.display())]
    NoLights(PathBuf),
    /// The material that is to be glass does not exist.
    #[error("{} has no material `{wanted}`; choose one of: {choices}", model.display())]
    NoMaterial {
        /// The model file.
        model: PathBuf,
        /// Name.
        wanted: String,
        /// The materials there are.
        choices: String,
    },
}

/// The shot that an input stands for: a `.ron` file's, or the default shot of a bare `.glb` or `.gltf`.
///
/// # Errors
/// [`StageError`] when the file is of no known kind, or is a shot that does not load.
pub fn open_shot(input: &Path) -> Result<Shot, StageError> {
    let extension = input.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("ron") => Ok(Shot::load(input)?),
        Some("glb" | "gltf") => Ok(Shot::for_model(input)),
        _ => Err(StageError::UnknownInput(input.to_owned())),
    }
}

/// Index of the clip that a shot plays, `None` for the rest pose of a model without clips.
///
/// # Errors
/// [`StageError::NoClip`] names the clips there are.
pub fn find_clip(scene: &Scene, choice: &ClipChoice, model: &Path) -> Result<Option<usize>, StageError> {
    let found = match choice {
        ClipChoice::First => return Ok((!scene.clips.is_empty()).then_some(0)),
        ClipChoice::Index(index) => Some(*index).filter(|index| *index < scene.clips.len()),
        ClipChoice::Name(name) => scene.clips.iter().position(|clip| &clip.name == name),
    };
    found.map(Some).ok_or_else(|| StageError::NoClip {
        model: model.to_owned(),
        wanted: match choice {
            ClipChoice::First => String::new(),
            ClipChoice::Index(index) => index.to_string(),
            ClipChoice::Name(name) => format!("`{name}`"),
        },
        choices: listed(scene.clips.iter().map(|clip| clip.name.as_str())),
    })
}

/// Names with their indices, for a message.
fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let list: Vec<_> = names.enumerate().map(|(index, name)| format!("{index} `{name}`")).collect();
    if list.is_empty() { "none, it has no such thing".into() } else { list.join(", ") }
}

/// How a shot is rendered: what is no part of the shot itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Time in the clip at which the shot begins, seconds.
    pub start: f64,
    /// Refraction.
    pub refraction: Refraction,
    /// Caustics; `None` for none.
    pub caustics: Option<Caustics>,
    /// Whether arbitrary output variables are wanted.
    pub aov: bool,
    /// Caching.
    pub skipping: Skipping,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            start: 0.0,
            refraction: Refraction::default(),
            caustics: Some(Caustics::default()),
            aov: false,
            skipping: Skipping::default(),
        }
    }
}

/// A shot on stage: every moment of it can be asked for.
#[derive(Clone, Debug)]
pub struct Stage {
    shot: Shot,
    playing: Playing,
    own: Option<Own>,
    extent: Extent,
    light: FramedLight,
}

impl Stage {
    /// Imports the model, makes its glass, loads the environment and lays the floor.
    ///
    /// # Errors
    /// [`StageError`] says which file is wrong, or which name exists nowhere.
    pub fn open(shot: Shot) -> Result<(World, Self), StageError> {
        let mut scene = murano_scene::import(&shot.model)?;
        scene.skinning = shot.skinning;
        if let Some(variant) = &shot.variant {
            select_variant(&mut scene, variant)
                .map_err(|source| StageError::Variant { model: shot.model.clone(), source })?;
        }
        glass::apply(&shot.glass, &mut scene).map_err(|wanted| StageError::NoMaterial {
            model: shot.model.clone(),
            wanted,
            choices: listed(scene.materials.iter().map(|material| material.name.as_str())),
        })?;
        let environment = match &shot.environment {
            EnvironmentChoice::Builtin => Some(Environment::from_hdr(STUDIO, Path::new("(built in)"))?),
            EnvironmentChoice::Absent => None,
            EnvironmentChoice::File(path) => Some(Environment::load(path)?),
        };
        let playing = Playing::new(&shot, &scene)?;
        let own = Own::new(&shot, &scene)?;
        let seconds = f64::from(frame_count(&shot, &playing)) / shot.output.fps;
        let extent = Extent::measure(&scene, &playing.moments(seconds))
            .map_err(|source| StageError::Geometry { model: shot.model.clone(), source })?;
        let height = match shot.floor.level {
            FloorLevel::Auto => Some(extent.lowest),
            FloorLevel::At(height) => Some(height),
            FloorLevel::Absent => None,
        };
        let floor = height.map(|height| Floor {
            height,
            center: [extent.center.x, extent.center.z],
            half_extent: extent.radius * FLOOR_EXTENT,
            albedo: shot.floor.albedo,
        });
        let light = FramedLight::new(&shot.light, &extent, height.unwrap_or(extent.lowest));
        Ok((World { scene, environment, floor }, Self { shot, playing, own, extent, light }))
    }

    /// The shot as it stands.
    pub fn shot(&self) -> &Shot {
        &self.shot
    }

    /// The clip that plays, an index into the scene's clips; `None` for the rest pose.
    pub fn clip(&self) -> Option<usize> {
        self.playing.clip()
    }

    /// What plays at a moment, seconds after the shot's beginning; the shot's own clip begins at its time `start`.
    pub fn playing(&self, elapsed: f64, start: f64) -> Vec<Layer> {
        self.playing.at(elapsed, start)
    }

    /// What the body sweeps over the clip.
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// Frames of the shot: as it says, else its clip once, else one.
    pub fn frame_count(&self) -> u32 {
        frame_count(&self.shot, &self.playing)
    }

    /// The shot's camera at a moment, seconds after its beginning.
    pub fn camera(&self, elapsed: f64) -> Aim {
        let [width, height] = self.shot.output.size;
        let camera = &self.shot.camera;
        let eye = framing::eye(camera, &self.extent, f64::from(width) / f64::from(height));
        camera.at(elapsed, Aim { eye, target: self.extent.center, fov: camera.fov })
    }

    /// The shot's light at a moment, seconds after its beginning.
    pub fn placed_light(&self, elapsed: f64) -> PlacedLight {
        let framed = &self.light;
        let (position, forward): (DVec3, DVec3) =
            self.shot.light.at(elapsed, framed.position, framed.forward, self.extent.center);
        PlacedLight {
            world_from_light: framing::world_from_light(position, forward),
            light: Light {
                name: String::new(),
                kind: framed.kind,
                color: Vec3::from_array(self.shot.light.color),
                intensity: framed.intensity,
                range: f32::INFINITY,
            },
        }
    }

    fn moment(&self, elapsed: f64, settings: &Settings) -> Moment {
        let playing = self.playing.at(elapsed, settings.start);
        let aim = self.camera(elapsed);
        let usual = || View::look_at(aim.eye, aim.target, aim.fov.to_radians());
        let view = self.own.as_ref().and_then(|own| own.view(&playing)).unwrap_or_else(usual);
        Moment { playing, view }
    }

    /// The frame at a moment, seconds after the shot's beginning: `n / fps` for frame n.
    pub fn request(&self, elapsed: f64, settings: &Settings) -> FrameRequest {
        let Moment { playing, view } = self.moment(elapsed, settings);
        let own = self.own.as_ref();
        let before = settings.aov.then(|| self.moment(elapsed - 1.0 / self.shot.output.fps, settings));
        FrameRequest {
            size: self.shot.output.size,
            view,
            lights: own.and_then(|own| own.lights(&playing)).unwrap_or_else(|| vec![self.placed_light(elapsed)]),
            playing,
            refraction: settings.refraction,
            caustics: settings.caustics,
            samples: self.shot.output.samples,
            exposure: self.shot.exposure,
            tone_map: match self.shot.tone_map {
                ToneMapChoice::Linear => ToneMap::Linear,
                ToneMapChoice::Neutral => ToneMap::Neutral,
                ToneMapChoice::Agx => ToneMap::Agx,
            },
            before,
            aov: settings.aov,
            skipping: settings.skipping,
        }
    }
}

/// Gives a scene the materials of a variant; the first without a name or number.
fn select_variant(scene: &mut Scene, choice: &ClipChoice) -> Result<(), VariantError> {
    let index = match choice {
        ClipChoice::First => 0,
        ClipChoice::Index(index) => *index,
        ClipChoice::Name(name) => scene.find_variant(name)?,
    };
    scene.select_variant(index)
}

/// Frames of a shot: as it says, else one round of its clip, else one.
fn frame_count(shot: &Shot, playing: &Playing) -> u32 {
    let once = (playing.round() * shot.output.fps).round().max(1.0) as u32;
    shot.output.frames.unwrap_or(once)
}

#[cfg(test)]
mod tests;

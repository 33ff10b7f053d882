//! The light of a shot and its path.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::camera::turned;

/// Shape of a shot's light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ShotLightKind {
    /// A cone.
    #[default]
    Spot,
    /// All directions.
    Point,
    /// Parallel.
    Directional,
}

/// The light of a shot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShotLight {
    /// The model's own lights in place of this one, with whatever its clip makes of them; everything else here is then
    /// without effect.
    pub model: bool,
    /// Shape.
    pub kind: ShotLightKind,
    /// Metres; `None` is above the model.
    pub position: Option<[f64; 3]>,
    /// Where the light goes, any length; `None` is towards the model.
    pub direction: Option<[f64; 3]>,
    /// Linear RGB.
    pub color: [f32; 3],
    /// Candela, or lux if directional; `None` lights the floor well.
    pub intensity: Option<f32>,
    /// Full opening angle of a spot's cone, degrees; `None` holds the model.
    pub cone: Option<f64>,
    /// Turn about +Y through the model's centre, degrees per second, counter-clockwise seen from above.
    pub orbit: f64,
}

impl Default for ShotLight {
    fn default() -> Self {
        Self {
            model: false,
            kind: ShotLightKind::Spot,
            position: None,
            direction: None,
            color: [1.0; 3],
            intensity: None,
            cone: None,
            orbit: 0.0,
        }
    }
}

impl ShotLight {
    /// Position and direction at a time in seconds; `framed_position` and `framed_direction` are the stage's choice,
    /// `center` the point the light turns about.
    pub fn at(&self, time: f64, framed_position: DVec3, framed_direction: DVec3, center: DVec3) -> (DVec3, DVec3) {
        let position = self.position.map_or(framed_position, DVec3::from_array);
        let direction = self.direction.map_or(framed_direction, DVec3::from_array);
        let degrees = self.orbit * time;
        (turned(position, center, degrees), turned(direction, DVec3::ZERO, degrees).normalize_or(DVec3::NEG_Y))
    }
}

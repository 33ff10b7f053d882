//! Where camera and light go when a shot does not say: the whole body in the picture, and lit so that its shadow and
//! caustic fall where they can be seen.

use std::f64::consts::PI;

use glam::{DMat4, DQuat, DVec3, dcamera::rh::view::look_to_mat4};
use murano_scene::{LightKind, ShotCamera, ShotLight, ShotLightKind};

use super::Extent;

/// Share of the distance added so that the body keeps clear of the picture's border.
const MARGIN: f64 = 0.12;
/// Where the light stands: radians around +Y from +Z, and above the horizon. High and to the side, a little behind, so
/// that the caustic falls beside the body and towards a camera in front.
const LIGHT_AZIMUTH: f64 = -75.0 * PI / 180.0;
const LIGHT_ELEVATION: f64 = 52.0 * PI / 180.0;
/// Distance of the light from the body's middle in radii of the body.
const LIGHT_DISTANCE: f64 = 5.0;
/// Share of a cone's half-angle over which the light fades out.
const FALLOFF: f32 = 0.35;
/// Share by which a cone is wider than what it has to hold, so that this lies before the falloff.
const CONE_MARGIN: f64 = 1.6;
/// Widest half-angle of a cone chosen here, radians.
const WIDEST_CONE: f64 = 75.0 * PI / 180.0;
/// Irradiance that the light gives the floor, lux: a white diffuse floor would have radiance 1, and the shot's darker one
/// leaves room for the caustics above it.
const FLOOR_IRRADIANCE: f64 = PI;

/// A unit direction by azimuth around +Y from +Z towards +X and elevation above the horizon, radians.
fn direction(azimuth: f64, elevation: f64) -> DVec3 {
    DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos())
}

/// Eye from which the ball around the body fits into a picture of this shape (`aspect` = width / height), on the side
/// that the camera names.
pub fn eye(camera: &ShotCamera, extent: &Extent, aspect: f64) -> DVec3 {
    let half_height = (camera.fov.to_radians() / 2.0).tan();
    let half_angle = half_height.min(half_height * aspect).atan();
    let distance = extent.radius / half_angle.sin() * (1.0 + MARGIN);
    extent.center + direction(camera.azimuth.to_radians(), camera.elevation.to_radians()) * distance
}

/// `world_from_light` of a light at `position` that looks along `forward`.
pub fn world_from_light(position: DVec3, forward: DVec3) -> DMat4 {
    let up = if forward.y.abs() > 0.999 { DVec3::Z } else { DVec3::Y };
    look_to_mat4(position, forward, up).inverse()
}

/// A light with nothing left open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramedLight {
    /// World, metres.
    pub position: DVec3,
    /// Unit.
    pub forward: DVec3,
    /// Shape.
    pub kind: LightKind,
    /// Lux (directional) or candela.
    pub intensity: f32,
}

impl FramedLight {
    /// Fills in what the shot leaves open, at its beginning. `floor` is the height on which the caustic lands, metres.
    pub fn new(light: &ShotLight, extent: &Extent, floor: f64) -> Self {
        let framed = extent.center + direction(LIGHT_AZIMUTH, LIGHT_ELEVATION) * (LIGHT_DISTANCE * extent.radius);
        let position = light.position.map_or(framed, DVec3::from_array);
        let towards = light.direction.map_or(extent.center - position, DVec3::from_array);
        let forward = towards.normalize_or(DVec3::NEG_Y);
        let kind = match light.kind {
            ShotLightKind::Directional => LightKind::Directional,
            ShotLightKind::Point => LightKind::Point,
            ShotLightKind::Spot => {
                let half = light.cone.map_or_else(|| covering_cone(extent, position, forward, floor), half_radians);
                LightKind::Spot { inner: half as f32 * (1.0 - FALLOFF), outer: half as f32 }
            }
        };
        let intensity = light.intensity.unwrap_or_else(|| exposing_intensity(kind, extent, position, forward, floor));
        Self { position, forward, kind, intensity }
    }
}

/// Half of a full angle in degrees, in radians.
fn half_radians(degrees: f64) -> f64 {
    degrees.to_radians() / 2.0
}

/// Half-angle of the cone around `forward` that holds the ball around the body and its shadow on the floor, where the
/// caustic lands too; radians.
fn covering_cone(extent: &Extent, position: DVec3, forward: DVec3, floor: f64) -> f64 {
    let angle_to = |point: DVec3| forward.angle_between((point - position).normalize_or(forward));
    let to_body = extent.center - position;
    let half_angle = (extent.radius / to_body.length()).clamp(0.0, 0.99).asin();
    let ball = angle_to(extent.center) + half_angle;

    // The shadow is the tangent cone of the ball, cut by the floor. Its far side has no end under a low light: there,
    // a few radii behind the body are as far as one looks.
    let axis = to_body.normalize_or(DVec3::NEG_Y);
    let side = axis.any_orthonormal_vector();
    let farthest = to_body.length() + 6.0 * extent.radius;
    let shadow = (0..16)
        .map(|k| DQuat::from_axis_angle(axis, f64::from(k) * PI / 8.0) * side)
        .map(|around| axis * half_angle.cos() + around * half_angle.sin())
        .map(|ray| (ray, (floor - position.y) / ray.y))
        .filter(|(_, distance)| distance.is_finite() && *distance > 0.0)
        .map(|(ray, distance)| angle_to(position + ray * distance.min(farthest)))
        .fold(0.0, f64::max);
    (ball.max(shadow) * CONE_MARGIN).min(WIDEST_CONE)
}

/// Intensity at which a light gives the place under the body the irradiance of a well exposed picture.
fn exposing_intensity(kind: LightKind, extent: &Extent, position: DVec3, forward: DVec3, floor: f64) -> f32 {
    let below = DVec3::new(extent.center.x, floor, extent.center.z);
    let (incident, falloff) = match kind {
        LightKind::Directional => (forward, 1.0),
        LightKind::Point | LightKind::Spot { .. } => {
            ((below - position).normalize_or(DVec3::NEG_Y), position.distance_squared(below))
        }
    };
    // A grazing light would have to be infinitely bright.
    let cosine = incident.y.abs().max(0.1);
    (FLOOR_IRRADIANCE * falloff / cosine) as f32
}

//! Cameras and KHR_lights_punctual.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};
use std::f64::consts::PI;

use glam::Vec3;

use super::document::{self, Document, Spot, label};
use super::error::ImportProblem;
use crate::{Camera, Light, LightKind, Projection};

/// Imports every camera.
pub(super) fn import_cameras(document: &Document) -> Result<Vec<Camera>, ImportProblem> {
    document.cameras.iter().enumerate().map(|(index, camera)| import_camera(index, camera)).collect()
}

fn import_camera(index: usize, camera: &document::Camera) -> Result<Camera, ImportProblem> {
    let (name, projection, znear) = match camera {
        document::Camera::Perspective { name, perspective } => {
            (name, Projection::Perspective { yfov: perspective.yfov }, perspective.znear)
        }
        document::Camera::Orthographic { name, orthographic } => {
            (name, Projection::Orthographic { half_height: orthographic.ymag.abs() }, orthographic.znear)
        }
    };
    let problem = match projection {
        Projection::Perspective { yfov } if yfov <= 0.0 || yfov >= PI => Some("yfov is not between 0 and pi"),
        Projection::Perspective { .. } if znear <= 0.0 => Some("znear is not positive"),
        Projection::Orthographic { half_height: 0.0 } => Some("ymag is 0"),
        Projection::Orthographic { .. } if znear < 0.0 => Some("znear is negative"),
        _ => None,
    };
    match problem {
        Some(problem) => {
            Err(ImportProblem::Value { at: label("cameras", index, name.as_deref()), problem: problem.to_owned() })
        }
        None => Ok(Camera { name: name.clone().unwrap_or_default(), projection, znear }),
    }
}

/// Imports every light.
pub(super) fn import_lights(document: &Document) -> Result<Vec<Light>, ImportProblem> {
    document.lights.iter().enumerate().map(|(index, light)| import_light(index, light)).collect()
}

fn import_light(index: usize, light: &document::Light) -> Result<Light, ImportProblem> {
    let at = label("extensions.KHR_lights_punctual.lights", index, light.name.as_deref());
    let kind = match light.kind.as_str() {
        "directional" => LightKind::Directional,
        "point" => LightKind::Point,
        "spot" => cone(light.spot.as_ref().unwrap_or(&Spot::default()), &at)?,
        kind => {
            return Err(ImportProblem::Schema { at, problem: format!("unknown light type \"{kind}\"") });
        }
    };
    let (intensity, range) = (light.intensity.unwrap_or(1.0), light.range.unwrap_or(f32::INFINITY));
    let color = light.color.map_or(Vec3::ONE, Vec3::from_array);
    if !(intensity >= 0.0 && intensity.is_finite() && range > 0.0 && color.is_finite() && color.min_element() >= 0.0) {
        let problem = "colour and intensity must be finite and not negative, range must be positive".to_owned();
        return Err(ImportProblem::Value { at, problem });
    }
    Ok(Light { name: light.name.clone().unwrap_or_default(), kind, color, intensity, range })
}

fn cone(spot: &Spot, at: &str) -> Result<LightKind, ImportProblem> {
    let inner = spot.inner_cone_angle.unwrap_or(0.0);
    let outer = spot.outer_cone_angle.unwrap_or(FRAC_PI_4);
    // Exporters write an equal pair for a hard edge, and pi/2 rounded up.
    if !(0.0..=outer).contains(&inner) || outer <= 0.0 || outer > FRAC_PI_2 + 1e-3 {
        let problem = format!("cone angles {inner} and {outer} are not 0 <= inner < outer <= pi/2");
        return Err(ImportProblem::Value { at: at.to_owned(), problem });
    }
    Ok(LightKind::Spot { inner, outer: outer.min(FRAC_PI_2) })
}

//! A bench for caustics: lamps, a floor, and what a caster throws on it. Fluxes are those of a lamp of intensity 1.

use glam::{DMat4, DVec3, Vec3};
use murano_caustics::{Caustics, Method};
use murano_refraction::{Interfaces, Refraction};
use murano_render::{CausticAccount, Floor, Frame, FrameRequest, PlacedLight, Renderer, View};
use murano_scene::{Light, LightKind, Projection, look_along};

use crate::bench::still;

/// Texels along a side of the caustic maps.
pub const MAP_SIZE: u32 = 512;

/// A lamp of intensity 1 at a place, towards a direction.
pub fn light(kind: LightKind, position: DVec3, direction: DVec3) -> PlacedLight {
    PlacedLight {
        world_from_light: look_along(position, direction),
        light: Light { name: String::new(), kind, color: Vec3::ONE, intensity: 1.0, range: f32::INFINITY },
    }
}

/// A wide grey floor at a height.
pub fn floor(height: f64) -> Floor {
    Floor { height, center: [0.0, 0.0], half_extent: 40.0, albedo: [0.5; 3] }
}

/// Looks straight down from a height at a square around the origin, row 0 at -z.
pub fn from_above(height: f64, half_extent: f64) -> View {
    let place = DMat4::from_cols(
        DVec3::X.extend(0.0),
        DVec3::NEG_Z.extend(0.0),
        DVec3::Y.extend(0.0),
        (DVec3::Y * height).extend(1.0),
    );
    View { world_from_view: place, projection: Projection::Orthographic { half_height: half_extent }, near: 1e-4 }
}

/// A still picture of this many pixels a side, of caustics of light that is refracted in and out.
pub fn request(view: View, size: u32, lamp: PlacedLight, photons: u32) -> FrameRequest {
    FrameRequest {
        lights: vec![lamp],
        caustics: Some(Caustics { method: Method::Splat, photons, map_size: MAP_SIZE, interfaces: Interfaces::Two }),
        ..still(view, [size, size], Refraction::default())
    }
}

/// The same by another method.
pub fn with_method(request: FrameRequest, method: Method) -> FrameRequest {
    FrameRequest { caustics: request.caustics.map(|caustics| Caustics { method, ..caustics }), ..request }
}

/// The only caster's account under the only lamp.
///
/// # Panics
/// On a device's error, and if there is not exactly one.
pub fn account(renderer: &mut Renderer, request: &FrameRequest) -> CausticAccount {
    renderer.caustic_accounts(request).expect("an account").pop().expect("one caster under one lamp")
}

/// The frame.
///
/// # Panics
/// On a device's error.
pub fn picture(renderer: &mut Renderer, request: &FrameRequest) -> Frame {
    renderer.render(request).expect("a picture")
}

/// How far a value is off the truth, as a part of it.
pub fn off(value: f64, truth: f64) -> f64 {
    (value / truth - 1.0).abs()
}

/// Half a percent: what 64 cells across a disc cannot resolve of its outline, and Fresnel's law there.
pub const ENERGY: f64 = 0.005;

/// Part of the flux that lies in texels brighter than one and a half times the brightest of the truth's texels around.
pub fn streaks(ours: &[f64], truth: &[f64], size: usize) -> f64 {
    let brightest = |x: usize, y: usize| {
        let around = |at: usize| at.saturating_sub(1)..(at + 2).min(size);
        around(y).flat_map(|y| around(x).map(move |x| truth[y * size + x])).fold(0.0, f64::max)
    };
    let is_streak = |index: &usize| ours[*index] > 1.5 * brightest(index % size, index / size);
    (0..ours.len()).filter(is_streak).map(|index| ours[index]).sum::<f64>() / ours.iter().sum::<f64>()
}

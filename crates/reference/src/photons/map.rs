//! Irradiance on a plane.

use glam::DVec3;
use murano_scene::PlacedLight;
use rayon::prelude::*;

use super::emission::Source;
use super::{PhotonAccount, PhotonClass, PhotonError, PhotonTracing, Receiver, Window, trace_photons};
use crate::{Departure, Ray, World};

/// How far a map is expected to be from the truth, estimated from the difference of its independent halves. Two maps of
/// different seeds differ by the square root of 2 times as much.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Mean absolute error over mean irradiance.
    pub relative_l1: f64,
    /// Root of the mean square error over the root of the mean square irradiance.
    pub relative_l2: f64,
}

/// What photons make of a window.
#[derive(Clone, Debug, PartialEq)]
pub struct CausticMap {
    /// Where it lies.
    pub window: Window,
    /// By [`PhotonClass`]: irradiance of the texels, W/m^2, linear RGB, row by row.
    pub irradiance: [Vec<DVec3>; 5],
    /// Two independent estimates whose mean that is: each from half of the photons, as if they were all of the light.
    pub halves: [[Vec<DVec3>; 5]; 2],
    /// Where the light went.
    pub account: PhotonAccount,
}

impl CausticMap {
    /// Irradiance by light of a class.
    pub fn class(&self, class: PhotonClass) -> &[DVec3] {
        &self.irradiance[class as usize]
    }

    /// Irradiance by all light that went by way of the glass.
    pub fn total(&self) -> Vec<DVec3> {
        (0..self.window.texels()).map(|texel| self.irradiance.iter().map(|class| class[texel]).sum()).collect()
    }

    /// Expected error of the map of a class; zero where there is no light.
    pub fn noise(&self, class: PhotonClass) -> Noise {
        let [first, second] = self.halves.each_ref().map(|half| half[class as usize].iter());
        let errors = first.zip(second).map(|(a, b)| 0.5 * (*a - *b));
        let (absolute, square) = sums(errors);
        let (mean, mean_square) = sums(self.class(class).iter().copied());
        let over = |error: f64, irradiance: f64| if irradiance > 0.0 { error / irradiance } else { 0.0 };
        Noise { relative_l1: over(absolute, mean), relative_l2: over(square, mean_square).sqrt() }
    }
}

/// Of all channels: absolute values and squares.
fn sums(values: impl Iterator<Item = DVec3>) -> (f64, f64) {
    values.fold((0.0, 0.0), |(absolute, square), value| {
        (absolute + value.abs().element_sum(), square + value.length_squared())
    })
}

/// The irradiance that light which goes by way of the glass makes on a window, class by class. Light that misses the glass is
/// not in it: see [`direct_irradiance`].
///
/// # Errors
/// [`PhotonError`]: the window has no area, or a body no bounds and the light nothing to aim at.
pub fn caustic_map(
    world: &World,
    light: &PlacedLight,
    window: Window,
    tracing: &PhotonTracing,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<CausticMap, PhotonError> {
    window.check()?;
    let black = || std::array::from_fn(|_| vec![DVec3::ZERO; window.texels()]);
    let mut halves: [[Vec<DVec3>; 5]; 2] = [black(), black()];
    let density = 2.0 / window.texel_area();
    let account = trace_photons(world, light, &Receiver::Plane(window), tracing, progress, &mut |landing| {
        if let Some(texel) = window.texel(landing.position) {
            halves[landing.half][landing.class as usize][texel] += landing.flux * density;
        }
    })?;
    let mean = |class: usize| halves[0][class].iter().zip(&halves[1][class]).map(|(a, b)| 0.5 * (*a + *b)).collect();
    Ok(CausticMap { window, irradiance: std::array::from_fn(mean), halves, account })
}

/// The irradiance at the texels' centres by light that meets nothing on its way, W/m^2, linear RGB: the inverse-square law and
/// the cosine, in the shadow of glass and of opaque things. With [`caustic_map`] it is all the light there is; in a world
/// without bodies it is the light without them.
///
/// # Errors
/// [`PhotonError::NoWindow`].
pub fn direct_irradiance(world: &World, light: &PlacedLight, window: &Window) -> Result<Vec<DVec3>, PhotonError> {
    window.check()?;
    let source = Source::new(light);
    let normal = window.normal();
    let texel = |index: usize| {
        let point = window.texel_centre(index);
        let (direction, distance) = source.ray_to(point);
        let cosine = -direction.dot(normal);
        let back = Ray { origin: point, direction: -direction };
        let glass =
            || world.bodies.iter().any(|body| body.shape.nearest(&back, Departure::Free, None, distance).is_some());
        if cosine <= 0.0 || world.blocked(&back, distance) || glass() {
            return DVec3::ZERO;
        }
        source.irradiance_across(point) * cosine
    };
    Ok((0..window.texels()).into_par_iter().map(texel).collect())
}

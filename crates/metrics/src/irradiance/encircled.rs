//! Encircled energy.

use super::{IrradianceMap, lit};
use crate::MetricsError;

/// Halvings of the interval that holds the radius: 2^-48 of the map's diagonal, finer than any map can tell.
const HALVINGS: usize = 48;

/// The radius of the circle about `centre` that holds `fraction` of the map's flux, metres.
///
/// `centre` is in texels, centres at half-integers; without one it is the centroid. Irradiance is constant within a
/// texel and the area in which the circle cuts a texel is exact, so a spot smaller than a texel gives that texel's
/// radius, not zero.
///
/// # Errors
/// [`MetricsError::Dark`] if the map has no flux, [`MetricsError::Range`] if the fraction is not above 0 and at most 1,
/// or the centre not finite.
pub fn encircled_energy_radius(
    map: &IrradianceMap,
    fraction: f64,
    centre: Option<[f64; 2]>,
) -> Result<f64, MetricsError> {
    if !(fraction > 0.0 && fraction <= 1.0) {
        return Err(MetricsError::Range {
            what: "the fraction of the flux",
            value: fraction,
            need: "above 0, at most 1",
        });
    }
    lit(map)?;
    let centre = centre.or_else(|| map.centroid()).unwrap_or_default();
    if let Some(value) = centre.into_iter().find(|c| !c.is_finite()) {
        return Err(MetricsError::Range { what: "the centre of the circle", value, need: "finite texel coordinates" });
    }
    let texels = LitTexels::about(map, centre);
    let wanted = fraction * texels.total;
    let (mut inner, mut outer) = (0.0, texels.reach);
    for _ in 0..HALVINGS {
        let radius = 0.5 * (inner + outer);
        if texels.within(radius) < wanted {
            inner = radius;
        } else {
            outer = radius;
        }
    }
    Ok(outer * map.texel_area().sqrt())
}

/// The texels that hold flux, by their lower corners relative to the centre of the circles.
struct LitTexels {
    texels: Vec<([f64; 2], f64)>,
    total: f64,
    reach: f64,
}

impl LitTexels {
    fn about(map: &IrradianceMap, centre: [f64; 2]) -> Self {
        let texels: Vec<_> = map
            .centres()
            .zip(map.values())
            .filter(|(_, value)| **value > 0.0)
            .map(|([x, y], value)| ([x - 0.5 - centre[0], y - 0.5 - centre[1]], *value))
            .collect();
        let farthest = |[x, y]: [f64; 2]| x.abs().max((x + 1.0).abs()).hypot(y.abs().max((y + 1.0).abs()));
        Self {
            total: texels.iter().map(|(_, value)| value).sum(),
            reach: texels.iter().map(|(corner, _)| farthest(*corner)).fold(0.0, f64::max),
            texels,
        }
    }

    /// The sum of irradiance times covered area, texels, in the circle.
    fn within(&self, radius: f64) -> f64 {
        self.texels.iter().map(|&(corner, value)| value * overlap(corner, radius)).sum()
    }
}

/// The area in which the unit square with the lower corner `[x, y]` meets the disc about the origin.
fn overlap([x, y]: [f64; 2], radius: f64) -> f64 {
    // Within this distance of the square's centre lies no part, beyond the other all of it.
    const HALF_DIAGONAL: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let distance = (x + 0.5).hypot(y + 0.5);
    if distance >= radius + HALF_DIAGONAL {
        0.0
    } else if distance + HALF_DIAGONAL <= radius {
        1.0
    } else {
        from_axes(x + 1.0, y + 1.0, radius) - from_axes(x, y + 1.0, radius) - from_axes(x + 1.0, y, radius)
            + from_axes(x, y, radius)
    }
}

/// The area in which the rectangle from the origin to (x, y) meets the disc about the origin, signed as x y is.
fn from_axes(x: f64, y: f64, radius: f64) -> f64 {
    let sign = x.signum() * y.signum();
    let (x, y) = (x.abs().min(radius), y.abs().min(radius));
    if x * x + y * y <= radius * radius {
        return sign * x * y;
    }
    // Up to where the circle crosses the height y the rectangle is full; from there the circle bounds it.
    let crossing = (radius * radius - y * y).max(0.0).sqrt();
    let below_circle = |t: f64| {
        0.5 * (t * (radius * radius - t * t).max(0.0).sqrt() + radius * radius * (t / radius).clamp(-1.0, 1.0).asin())
    };
    sign * (crossing * y + below_circle(x) - below_circle(crossing))
}

//! What a light sends towards the glass.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use glam::{DVec2, DVec3};
use murano_scene::{LightKind, PlacedLight};

use super::PhotonError;
use crate::{Ray, World};

/// A ball, world, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its centre.
    pub centre: DVec3,
    /// Its radius, positive.
    pub radius: f64,
}

impl Ball {
    /// The smallest ball around this one and another.
    #[must_use]
    pub fn around(self, other: Self) -> Self {
        let apart = other.centre - self.centre;
        let distance = apart.length();
        if distance + other.radius <= self.radius {
            return self;
        }
        if distance + self.radius <= other.radius {
            return other;
        }
        let radius = 0.5 * (distance + self.radius + other.radius);
        Self { centre: self.centre + apart * ((radius - self.radius) / distance), radius }
    }
}

/// A ball around all the glass; `None` without any.
pub(super) fn glass_ball(world: &World) -> Result<Option<Ball>, PhotonError> {
    world.bodies.iter().enumerate().try_fold(None, |around: Option<Ball>, (body, glass)| {
        let ball = glass.shape.ball().ok_or(PhotonError::Unbounded(body))?;
        Ok(Some(around.map_or(ball, |around| around.around(ball))))
    })
}

/// A light as physics sees it; world space.
pub(super) struct Source {
    kind: LightKind,
    position: DVec3,
    /// Unit; where it looks.
    axis: DVec3,
    /// Lux (parallel light) or candela on the axis, linear RGB.
    strength: DVec3,
}

impl Source {
    pub(super) fn new(light: &PlacedLight) -> Self {
        Self {
            kind: light.light.kind,
            position: light.world_from_light.w_axis.truncate(),
            axis: light.world_from_light.transform_vector3(DVec3::NEG_Z).normalize_or(DVec3::NEG_Z),
            strength: light.light.color.as_dvec3() * f64::from(light.light.intensity),
        }
    }

    /// Radiant intensity towards a direction as a part of that on the axis.
    fn falloff(&self, direction: DVec3) -> f64 {
        self.kind.falloff(direction.dot(self.axis))
    }

    /// The ray that carries light to a point, and the length it runs; infinite for parallel light.
    pub(super) fn ray_to(&self, point: DVec3) -> (DVec3, f64) {
        if self.kind == LightKind::Directional {
            return (self.axis, f64::INFINITY);
        }
        let to = point - self.position;
        (to.normalize_or(self.axis), to.length())
    }

    /// Irradiance across the light at a point, W/m^2 (lux).
    pub(super) fn irradiance_across(&self, point: DVec3) -> DVec3 {
        let (direction, distance) = self.ray_to(point);
        if distance == f64::INFINITY {
            self.strength
        } else {
            self.strength * self.falloff(direction) / distance.powi(2)
        }
    }

    /// The part of the light that can meet a ball; parallel light starts `upstream` metres before the ball's centre.
    pub(super) fn towards(&self, ball: Ball, upstream: f64) -> Emission<'_> {
        if self.kind == LightKind::Directional {
            let frame = frame(self.axis);
            let start = ball.centre - self.axis * upstream;
            let shape = Beam::Parallel { start, radius: ball.radius };
            return Emission { source: self, frame, shape, measure: PI * ball.radius * ball.radius };
        }
        let to = ball.centre - self.position;
        let (distance, axis) = (to.length(), to.normalize_or(self.axis));
        let half_angle = if distance > ball.radius { (ball.radius / distance).asin() } else { PI };
        let (axis, half_angle) = match self.kind {
            LightKind::Spot { outer, .. } if f64::from(outer) < half_angle => (self.axis, f64::from(outer)),
            _ => (axis, half_angle),
        };
        // 1 - cos, without cancellation.
        let height = 2.0 * (0.5 * half_angle).sin().powi(2);
        Emission { source: self, frame: frame(axis), shape: Beam::Cone { height }, measure: 2.0 * PI * height }
    }
}

/// A pencil of a light's rays.
pub(super) struct Emission<'a> {
    source: &'a Source,
    /// Two directions across the pencil's axis, and the axis.
    frame: [DVec3; 3],
    shape: Beam,
    /// Area across the light, m^2, or solid angle, sr.
    measure: f64,
}

enum Beam {
    /// A disc of parallel light.
    Parallel { start: DVec3, radius: f64 },
    /// A cone; `height` is 1 - the cosine of its half-angle.
    Cone { height: f64 },
}

impl Emission<'_> {
    /// The ray of a place in the unit square, which is mapped to the pencil so that equal areas carry equal area or solid
    /// angle; and the flux, watts, of a photon that stands for `share` of the pencil.
    pub(super) fn photon(&self, place: DVec2, share: f64) -> (Ray, DVec3) {
        let disc = concentric_disc(place);
        let [across, up, axis] = self.frame;
        let ray = match self.shape {
            Beam::Parallel { start, radius } => {
                Ray { origin: start + radius * (disc.x * across + disc.y * up), direction: axis }
            }
            Beam::Cone { height } => {
                // Equal heights of a sphere's cap have equal solid angles (Archimedes).
                let below = height * disc.length_squared();
                let sideways = (height * (2.0 - below)).sqrt();
                let direction = sideways * (disc.x * across + disc.y * up) + (1.0 - below) * axis;
                Ray { origin: self.source.position, direction: direction.normalize() }
            }
        };
        (ray, self.source.strength * (self.source.falloff(ray.direction) * self.measure * share))
    }
}

/// A right-handed orthonormal frame whose third axis is given.
fn frame(axis: DVec3) -> [DVec3; 3] {
    let across = axis.any_orthonormal_vector();
    [across, axis.cross(across), axis]
}

/// The unit square onto the unit disc, area for area, neighbours to neighbours (Shirley and Chiu, JGT 1997).
fn concentric_disc(place: DVec2) -> DVec2 {
    let p = 2.0 * place - DVec2::ONE;
    if p == DVec2::ZERO {
        return DVec2::ZERO;
    }
    let (radius, angle) =
        if p.x.abs() > p.y.abs() { (p.x, FRAC_PI_4 * (p.y / p.x)) } else { (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y)) };
    radius * DVec2::from_angle(angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_around_two_touches_both() {
        let a = Ball { centre: DVec3::new(1.0, 2.0, 3.0), radius: 0.5 };
        let b = Ball { centre: DVec3::new(4.0, 2.0, -1.0), radius: 1.5 };
        let both = a.around(b);
        for ball in [a, b] {
            assert!((both.centre.distance(ball.centre) + ball.radius - both.radius).abs() < 1e-12);
        }
        let inner = Ball { centre: b.centre, radius: 1.0 };
        assert_eq!(b.around(inner), b);
        assert_eq!(inner.around(b), b);
    }

    #[test]
    fn the_disc_is_filled_evenly() {
        const SIDE: u32 = 400;
        let rim = |within: f64| {
            let places = (0..SIDE * SIDE).map(|i| DVec2::new(f64::from(i % SIDE), f64::from(i / SIDE)));
            let discs = places.map(|place| concentric_disc((place + 0.5) / f64::from(SIDE)));
            let (count, mean) =
                discs.filter(|p| p.length() <= within).fold((0, DVec2::ZERO), |(n, s), p| (n + 1, s + p));
            (f64::from(count) / f64::from(SIDE * SIDE), mean / f64::from(SIDE * SIDE))
        };
        for within in [0.25, 0.5, 0.9, 1.0] {
            let (share, mean) = rim(within);
            assert!((share - within * within).abs() < 2e-3, "{share} of the disc within {within}");
            assert!(mean.length() < 1e-12);
        }
    }
}

//! The caustic of a ball in parallel light.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::{Ior, analytic::Sphere, fresnel_dielectric, pair_transmittance};

/// A ball lit along an axis, and a plane across that axis behind it. Rays are told apart by their height h, the
/// distance of the incident ray from the axis; all lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallLens {
    /// The ball.
    pub sphere: Sphere,
    /// Distance L from the ball's centre to the plane, at least the radius.
    pub distance: f64,
}

/// Steps in height over which landings are searched for sign changes.
const SCAN: usize = 2048;

impl BallLens {
    /// A ball of a radius and index at a distance from the plane.
    pub fn new(radius: f64, ior: Ior, distance: f64) -> Self {
        Self { sphere: Sphere { radius, ior }, distance }
    }

    /// Distance from the centre to where rays near the axis meet, nR / (2 (n - 1)); infinite for n = 1.
    pub fn paraxial_focus(&self) -> f64 {
        let n = self.sphere.ior.get();
        n * self.sphere.radius / (2.0 * (n - 1.0))
    }

    /// Angle towards the axis by which the ball turns a ray, 2 (asin(h/R) - asin(h/nR)).
    pub fn deviation(&self, height: f64) -> f64 {
        self.sphere.deviation(height)
    }

    /// Signed distance from the axis at which a ray meets the plane, (h - L sin delta) / cos delta; negative beyond the
    /// axis. `None` if it never meets it: above the ball, or turned by a right angle or more.
    pub fn landing(&self, height: f64) -> Option<f64> {
        let deviation = self.deviation(height);
        let meets = (0.0..=self.sphere.radius).contains(&height) && deviation < FRAC_PI_2;
        meets.then(|| (height - self.distance * deviation.sin()) / deviation.cos())
    }

    /// Derivative of the landing by the height.
    fn landing_slope(&self, height: f64) -> f64 {
        let (radius, n) = (self.sphere.radius, self.sphere.ior.get());
        let leg = |hypotenuse: f64| ((hypotenuse - height) * (hypotenuse + height)).sqrt();
        let turn = 2.0 * (1.0 / leg(radius) - 1.0 / leg(n * radius));
        let (sin, cos) = self.deviation(height).sin_cos();
        (1.0 - self.distance * cos * turn) / cos + (height - self.distance * sin) * sin * turn / (cos * cos)
    }

    /// Fraction of unpolarised light of a height that passes both interfaces without being reflected.
    pub fn transmittance(&self, height: f64) -> f64 {
        let sin_i = (height / self.sphere.radius).clamp(0.0, 1.0);
        // A chord meets the sphere under equal angles at both ends.
        let reflectance = fresnel_dielectric((1.0 - sin_i * sin_i).sqrt(), self.sphere.ior.eta_entering());
        pair_transmittance(reflectance, reflectance)
    }

    /// Irradiance by refracted light on the plane at a distance from the axis, as a multiple of the irradiance E0 of
    /// the incident light across the axis: the sum of T h |dh/dy| / |y| over all heights that land there (the folds).
    /// Infinite on the caustic itself. Two folds that land together but differ by less than R/2048 in height are missed.
    pub fn irradiance(&self, radius: f64) -> f64 {
        let on_axis = 1.0 / self.landing_slope(0.0).powi(2);
        let folds = self.heights_landing_at(radius);
        if radius == 0.0 {
            return if folds.is_empty() { self.transmittance(0.0) * on_axis } else { f64::INFINITY };
        }
        let spread = |height: f64| self.transmittance(height) * height / (self.landing_slope(height).abs() * radius);
        folds.into_iter().map(spread).sum()
    }

    /// Refracted flux that lands within a distance from the axis, as a multiple of E0 (so in square metres): the
    /// integral of 2 pi h T, with `rings` steps in h. Infinite distance gives all that reaches the plane.
    pub fn flux_within(&self, radius: f64, rings: usize) -> f64 {
        let step = self.sphere.radius / rings as f64;
        (0..rings)
            .map(|ring| (ring as f64 + 0.5) * step)
            .filter(|height| self.landing(*height).is_some_and(|landing| landing.abs() <= radius))
            .map(|height| TAU * height * step * self.transmittance(height))
            .sum()
    }

    /// Heights above 0 whose rays land at a distance from the axis, on either side of it.
    fn heights_landing_at(&self, radius: f64) -> Vec<f64> {
        let rays = |k: usize| {
            let height = self.sphere.radius * k as f64 / SCAN as f64;
            self.landing(height).map(|landing| (height, landing))
        };
        let sides: &[f64] = if radius == 0.0 { &[0.0] } else { &[radius, -radius] };
        // The ray along the axis lands on the axis whatever the lens does: no fold.
        let first = usize::from(radius == 0.0);
        let mut heights = Vec::new();
        let mut low = rays(first);
        for high in (first + 1..=SCAN).map(rays) {
            if let (Some((bottom, below)), Some((top, above))) = (low, high) {
                let crosses = |side: &&f64| below == **side || (below - **side) * (above - **side) < 0.0;
                let fold = |side: &f64| bisect(bottom, top, |height| self.landing(height).unwrap_or(above) - side);
                heights.extend(sides.iter().filter(crosses).map(fold));
            }
            low = high;
        }
        heights
    }
}

/// The zero of a function that changes sign between two arguments.
fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let rising = f(high) > 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (f(middle) <= 0.0) == rising { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

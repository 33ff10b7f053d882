//! Metallic-roughness reflection, as glTF 2.0 (appendix B.3) defines it.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::sky::luminance;

/// Reflectance of a dielectric of index 1.5 at normal incidence.
const DIELECTRIC: DVec3 = DVec3::splat(0.04);
/// Narrowest lobe; what is smoother is drawn as if it were this rough.
const NARROWEST: f64 = 1e-3;
/// Most grazing cosine of the eye.
const GRAZING: f64 = 1e-4;

/// A surface as it reflects towards one direction.
pub(super) struct Reflection {
    /// Shading normal, unit; the frame's third axis.
    axes: [DVec3; 3],
    /// Towards the viewer, in the frame.
    view: DVec3,
    diffuse: DVec3,
    /// Reflectance at normal incidence.
    specular: DVec3,
    /// Width of the GGX lobe: roughness squared.
    alpha: f64,
    /// Probability of drawing from the specular lobe.
    specular_share: f64,
}

impl Reflection {
    /// `normal` and `view` are unit and on one side; `albedo` linear; roughness perceptual.
    pub fn new(normal: DVec3, view: DVec3, albedo: DVec3, roughness: f64, metallic: f64) -> Self {
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let mut local = DVec3::new(tangent.dot(view), bitangent.dot(view), normal.dot(view));
        if local.z < GRAZING {
            local = DVec3::new(local.x, local.y, GRAZING).normalize();
        }
        let diffuse = albedo * (1.0 - metallic);
        let specular = DIELECTRIC.lerp(albedo, metallic);
        let shine = luminance(fresnel(specular, local.z).to_array());
        let matte = luminance(diffuse.to_array());
        // Neither lobe is starved: at a tenth, its worst sample weighs ten times the mean.
        let specular_share = if matte == 0.0 { 1.0 } else { (shine / (shine + matte)).clamp(0.1, 0.9) };
        Self {
            axes: [tangent, bitangent, normal],
            view: local,
            diffuse,
            specular,
            alpha: (roughness * roughness).max(NARROWEST),
            specular_share,
        }
    }

    /// BRDF times cosine for light from a unit direction, and the density with which [`Reflection::sample`] draws it.
    pub fn evaluate(&self, towards: DVec3) -> (DVec3, f64) {
        let light = DVec3::from_array(self.axes.map(|axis| axis.dot(towards)));
        if light.z <= 0.0 {
            return (DVec3::ZERO, 0.0);
        }
        let half = (light + self.view).normalize();
        let fresnel = fresnel(self.specular, self.view.dot(half).max(0.0));
        let distribution = self.distribution(half.z);
        let [masked_view, masked_light] = [self.view.z, light.z].map(|cosine| self.masked(cosine));
        // 0.5 / (n.l sqrt(..n.v..) + n.v sqrt(..n.l..)): the height-correlated Smith term over 4 (n.l) (n.v).
        let visibility = 0.5 / (light.z * masked_view + self.view.z * masked_light);
        let value = (1.0 - fresnel) * self.diffuse / PI + fresnel * (distribution * visibility);
        // Visible normals: G1 D (v.h) / n.v, and 1 / (4 v.h) for the reflection about them.
        let shine = 0.5 * distribution / (self.view.z + masked_view);
        let density = self.specular_share * shine + (1.0 - self.specular_share) * light.z / PI;
        (value * light.z, density)
    }

    /// BRDF for light from a unit direction.
    pub fn brdf(&self, towards: DVec3) -> DVec3 {
        let cosine = self.axes[2].dot(towards);
        if cosine > 0.0 { self.evaluate(towards).0 / cosine } else { DVec3::ZERO }
    }

    /// A direction to look for light in, unit, world; it may lie below the surface, where there is none to be had.
    pub fn sample(&self, choice: f64, [u, v]: [f64; 2]) -> DVec3 {
        let (sin_phi, cos_phi) = (TAU * u).sin_cos();
        let local = if choice < self.specular_share {
            let half = visible_normal(self.view, self.alpha, [u, v]);
            2.0 * self.view.dot(half) * half - self.view
        } else {
            DVec3::new(v.sqrt() * cos_phi, v.sqrt() * sin_phi, (1.0 - v).sqrt())
        };
        (local.x * self.axes[0] + local.y * self.axes[1] + local.z * self.axes[2]).normalize()
    }

    /// GGX (Trowbridge and Reitz 1975).
    fn distribution(&self, cos_half: f64) -> f64 {
        let squared = self.alpha * self.alpha;
        // (n.h)^2 (a^2 - 1) + 1, written so that nothing cancels where it is small.
        let d = squared * cos_half * cos_half + (1.0 - cos_half * cos_half).max(0.0);
        squared / (PI * d * d)
    }

    fn masked(&self, cosine: f64) -> f64 {
        masked(self.alpha, cosine)
    }
}

/// A normal of GGX's facets as seen from `view`, both in the frame whose third axis is the mean normal, unit (by spherical caps:
/// Dupuy and Benyoub 2023).
pub(super) fn visible_normal(view: DVec3, alpha: f64, [u, v]: [f64; 2]) -> DVec3 {
    let (sin_phi, cos_phi) = (TAU * u).sin_cos();
    let stretched = DVec3::new(alpha * view.x, alpha * view.y, view.z).normalize();
    let z = (1.0 - v) * (1.0 + stretched.z) - stretched.z;
    let level = (1.0 - z * z).max(0.0).sqrt();
    let cap = DVec3::new(level * cos_phi, level * sin_phi, z) + stretched;
    DVec3::new(alpha * cap.x, alpha * cap.y, cap.z.max(0.0)).normalize_or(DVec3::Z)
}

/// Share of the facets that a direction at this cosine to the mean normal sees past the others (Smith's G1 for GGX).
pub(super) fn unshadowed(alpha: f64, cosine: f64) -> f64 {
    2.0 * cosine / (cosine + masked(alpha, cosine))
}

fn masked(alpha: f64, cosine: f64) -> f64 {
    let squared = alpha * alpha;
    (squared + (1.0 - squared) * cosine * cosine).sqrt()
}

/// Schlick 1994.
fn fresnel(at_normal: DVec3, cosine: f64) -> DVec3 {
    at_normal + (1.0 - at_normal) * (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;

    const NORMAL: DVec3 = DVec3::new(0.36, 0.48, 0.8);

    fn viewed(cosine: f64, roughness: f64, metallic: f64) -> Reflection {
        let (tangent, _) = NORMAL.any_orthonormal_pair();
        let view = cosine * NORMAL + (1.0 - cosine * cosine).sqrt() * tangent;
        Reflection::new(NORMAL, view, DVec3::ONE, roughness, metallic)
    }

    /// Integral of the BRDF times cosine over the hemisphere by a rule of midpoints.
    fn albedo(reflection: &Reflection, steps: usize) -> (f64, f64) {
        let (tangent, bitangent) = NORMAL.any_orthonormal_pair();
        let (mut reflected, mut drawn) = (0.0, 0.0);
        for i in 0..steps {
            for j in 0..2 * steps {
                let cosine = (i as f64 + 0.5) / steps as f64;
                let (sin, cos) = (PI * (j as f64 + 0.5) / steps as f64).sin_cos();
                let level = (1.0 - cosine * cosine).sqrt();
                let light = level * cos * tangent + level * sin * bitangent + cosine * NORMAL;
                let (value, density) = reflection.evaluate(light);
                let cell = PI / (steps * steps) as f64;
                reflected += value.x * cell;
                drawn += density * cell;
            }
        }
        (reflected, drawn)
    }

    #[test]
    fn sampling_gives_the_integral_and_no_energy_is_made() {
        for (cosine, roughness, metallic) in
            [(0.9, 1.0, 0.0), (0.3, 0.9, 0.0), (0.5, 0.6, 1.0), (0.2, 0.5, 0.5), (1.0, 0.7, 1.0)]
        {
            let reflection = viewed(cosine, roughness, metallic);
            let (truth, drawn) = albedo(&reflection, 400);
            assert!(truth <= 1.0 && truth > 0.4, "{cosine} {roughness} {metallic}: {truth}");
            // The specular lobe loses what it would send below the surface; nothing is drawn twice.
            assert!(drawn <= 1.0 + 1e-3, "{drawn}");
            let mut sampler = Sampler::new(11, 0, 0);
            let samples = 40_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..samples {
                let towards = reflection.sample(sampler.unit(), sampler.pair());
                let (value, density) = reflection.evaluate(towards);
                let estimate = if density > 0.0 { value.x / density } else { 0.0 };
                sum += estimate;
                squares += estimate * estimate;
            }
            let mean = sum / f64::from(samples);
            let error = ((squares / f64::from(samples) - mean * mean) / f64::from(samples)).sqrt();
            assert!((mean - truth).abs() < 4.0 * error + 1e-3, "{mean} +- {error}, {truth}");
        }
    }

    #[test]
    fn light_and_view_may_be_swapped() {
        let (a, b) = (DVec3::new(0.1, 0.9, 0.8).normalize(), DVec3::new(0.8, 0.1, 0.5).normalize());
        let albedo = DVec3::new(0.9, 0.5, 0.2);
        let there = Reflection::new(NORMAL, a, albedo, 0.4, 0.3).evaluate(b).0 / NORMAL.dot(b);
        let back = Reflection::new(NORMAL, b, albedo, 0.4, 0.3).evaluate(a).0 / NORMAL.dot(a);
        assert!(there.abs_diff_eq(back, 1e-12 * there.max_element()));
    }

    #[test]
    fn the_smoothest_surface_is_nearly_a_mirror() {
        let reflection = viewed(0.6, 0.0, 1.0);
        let mirrored = 2.0 * 0.6 * NORMAL - (reflection.axes[0] * reflection.view.x + reflection.axes[2] * 0.6);
        let mut sampler = Sampler::new(5, 0, 0);
        for _ in 0..200 {
            let towards = reflection.sample(sampler.unit(), sampler.pair());
            assert!(towards.angle_between(mirrored) < 0.2);
            let (value, density) = reflection.evaluate(towards);
            assert!((value.x / density - 1.0).abs() < 0.05, "{value} {density}");
        }
    }
}

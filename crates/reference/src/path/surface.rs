//! What an opaque surface looks like where a ray meets it.

use glam::DVec3;
use murano_scene::{Material, Scene};

use super::Fade;
use crate::{Hit, Opaque, textures::Encoding};

/// A point of an opaque surface. Normals are unit and on the viewer's side: both sides of a surface are drawn.
pub(super) struct Surface {
    /// World, metres.
    pub position: DVec3,
    /// Of the triangle.
    pub geometric: DVec3,
    /// Interpolated and bent by the normal map.
    pub normal: DVec3,
    /// Linear RGB.
    pub albedo: DVec3,
    /// Perceptual.
    pub roughness: f64,
    /// 0 dielectric, 1 metal.
    pub metallic: f64,
    /// Radiance of its own.
    pub emitted: DVec3,
}

/// Looks a surface up for a ray of unit `direction` that meets it; material and textures are the scene's.
pub(super) fn surface(opaque: &Opaque, scene: &Scene, hit: &Hit, direction: DVec3) -> Surface {
    let default = Material::default();
    let material = opaque.data.material_index(hit).and_then(|index| scene.materials.get(index)).unwrap_or(&default);
    let there = opaque.data.at(hit, &scene.images);
    let base = material.base_color.truncate().as_dvec3() * there.vertex_colour();
    let shine = there.texture(material.metallic_roughness_texture, Encoding::Linear).unwrap_or(DVec3::ONE);
    let side = if hit.geometric.dot(direction) < 0.0 { 1.0 } else { -1.0 };
    let normal = there.bent(hit.normal, opaque.mesh.triangle(hit.element as usize), material);
    let emitted = material.emissive.as_dvec3() * f64::from(material.emissive_strength);
    let (geometric, normal) = (side * hit.geometric, side * normal);
    Surface {
        position: hit.position,
        geometric,
        normal: if normal.dot(direction) < 0.0 { normal } else { geometric },
        albedo: base * there.texture(material.base_color_texture, Encoding::Srgb).unwrap_or(DVec3::ONE),
        roughness: f64::from(material.roughness) * shine.y,
        metallic: f64::from(material.metallic) * shine.z,
        emitted: emitted * there.texture(material.emissive_texture, Encoding::Srgb).unwrap_or(DVec3::ONE),
    }
}

/// How much of a surface is there at a hit; below 1 only where a material fades.
pub(super) fn kept(opaque: &Opaque, fade: Option<&Fade>, hit: &Hit) -> f64 {
    let Some(fade) = fade.filter(|fade| opaque.data.material_index(hit) == Some(fade.material)) else { return 1.0 };
    let share = hit.position.distance(fade.centre) / fade.radius;
    let x = ((share - Fade::BEGIN) / (1.0 - Fade::BEGIN)).clamp(0.0, 1.0);
    1.0 - x * x * (3.0 - 2.0 * x)
}

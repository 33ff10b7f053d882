//! What an opaque surface looks like where a ray meets it.

use glam::{DVec2, DVec3, DVec4};
use murano_scene::{Material, Scene};

use super::{
    Fade,
    textures::{Encoding, sample},
};
use crate::{Hit, Opaque};

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
    let geometry = &opaque.geometry;
    let default = Material::default();
    let material = material_index(opaque, hit).and_then(|index| scene.materials.get(index)).unwrap_or(&default);
    let corners = opaque.triangles[hit.element as usize].map(|vertex| vertex as usize);
    let weights = hit.barycentric.to_array();
    let blend = |of: &dyn Fn(usize) -> DVec4| {
        corners.iter().zip(weights).fold(DVec4::ZERO, |sum, (&corner, weight)| sum + weight * of(corner))
    };
    let sets_of = |corner: usize| DVec4::from_array(geometry.texcoords[corner].map(f64::from));
    let sets = blend(&sets_of);
    let sets = [sets.truncate().truncate(), DVec2::new(sets.z, sets.w)];
    let look = |slot, encoding| sample(scene, slot, sets, encoding).map(DVec4::truncate);

    let vertex_colour = blend(&|corner| DVec4::from_array(geometry.colors[corner].map(f64::from))).truncate();
    let base = material.base_color.truncate().as_dvec3() * vertex_colour;
    let shine = look(material.metallic_roughness_texture, Encoding::Linear).unwrap_or(DVec3::ONE);
    let side = if hit.geometric.dot(direction) < 0.0 { 1.0 } else { -1.0 };
    let mut normal = hit.normal;
    if let Some(stored) = look(material.normal_texture, Encoding::Linear)
        && let Some(slot) = material.normal_texture
    {
        let uv = corners.map(|corner| {
            let sets = sets_of(corner);
            if slot.texcoord == 1 { DVec2::new(sets.z, sets.w) } else { sets.truncate().truncate() }
        });
        let places = opaque.mesh.triangle(hit.element as usize);
        normal = bent(normal, places, uv, 2.0 * stored - 1.0, f64::from(material.normal_scale));
    }
    let (geometric, normal) = (side * hit.geometric, side * normal);
    Surface {
        position: hit.position,
        geometric,
        normal: if normal.dot(direction) < 0.0 { normal } else { geometric },
        albedo: base * look(material.base_color_texture, Encoding::Srgb).unwrap_or(DVec3::ONE),
        roughness: f64::from(material.roughness) * shine.y,
        metallic: f64::from(material.metallic) * shine.z,
        emitted: material.emissive.as_dvec3() * look(material.emissive_texture, Encoding::Srgb).unwrap_or(DVec3::ONE),
    }
}

/// How much of a surface is there at a hit; below 1 only where a material fades.
pub(super) fn kept(opaque: &Opaque, fade: Option<&Fade>, hit: &Hit) -> f64 {
    let Some(fade) = fade.filter(|fade| material_index(opaque, hit) == Some(fade.material)) else { return 1.0 };
    let share = hit.position.distance(fade.centre) / fade.radius;
    let x = ((share - Fade::BEGIN) / (1.0 - Fade::BEGIN)).clamp(0.0, 1.0);
    1.0 - x * x * (3.0 - 2.0 * x)
}

fn material_index(opaque: &Opaque, hit: &Hit) -> Option<usize> {
    let instance = opaque.geometry.triangle_instances[hit.element as usize];
    opaque.geometry.instances[instance as usize].material
}

/// A normal bent by a tangent-space one, on the frame of the triangle's own texture gradient.
fn bent(normal: DVec3, [a, b, c]: [DVec3; 3], [ta, tb, tc]: [DVec2; 3], stored: DVec3, scale: f64) -> DVec3 {
    let (e1, e2, d1, d2) = (b - a, c - a, tb - ta, tc - ta);
    let determinant = d1.x * d2.y - d2.x * d1.y;
    if determinant == 0.0 {
        return normal;
    }
    let across = |v: DVec3| (v - v.dot(normal) * normal).normalize_or_zero();
    let tangent = across((e1 * d2.y - e2 * d1.y) / determinant);
    // glTF's v runs down the image, its bitangent up.
    let bitangent = -across((e2 * d1.x - e1 * d2.x) / determinant);
    (scale * (stored.x * tangent + stored.y * bitangent) + stored.z * normal).normalize_or(normal)
}

//! What throws caustics.

use glam::Vec3;
use murano_refraction::{Glass, Interfaces, Method, Refraction};
use murano_scene::Material;

/// What a caster is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Caster {
    /// Light goes through it, and some is mirrored off it.
    Glass(Glass),
    /// Light is mirrored off it.
    Mirror(Mirror),
}

/// A polished metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Fraction of light reflected at normal incidence, linear RGB; Schlick's law says how much more there is at others.
    pub reflectance: [f32; 3],
}

/// The roughest surface that counts as polished, perceptual: GGX lobes of half a degree.
const ROUGHEST: f32 = 0.1;

impl Mirror {
    /// A material as a mirror; `None` for glass, for what is rough, black or no metal, and for what a texture changes from place to place.
    pub fn of(material: &Material) -> Option<Self> {
        let polished = material.metallic >= 0.5 && material.roughness <= ROUGHEST;
        let textures = [material.metallic_roughness_texture, material.base_color_texture, material.normal_texture];
        let even = textures.iter().all(Option::is_none);
        let reflectance = (material.base_color.truncate() * material.metallic).clamp(Vec3::ZERO, Vec3::ONE);
        (polished && even && !material.is_glass() && reflectance != Vec3::ZERO)
            .then(|| Self { reflectance: reflectance.to_array() })
    }

    /// Settings that follow light from one mirror to the next.
    pub fn refraction() -> Refraction {
        Refraction { method: Method::Layers, interfaces: Interfaces::All, ..Refraction::default() }
    }
}

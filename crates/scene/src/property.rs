//! Numbers of materials, lights and cameras that a clip can drive (KHR_animation_pointer).

use std::f32::consts::FRAC_PI_2;

use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::{AlphaMode, Camera, Light, LightKind, Material, NodeIndex, Projection, Sampler, TextureRef};

/// A texture slot of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureSlot {
    /// [`Material::base_color_texture`].
    BaseColor,
    /// [`Material::metallic_roughness_texture`].
    MetallicRoughness,
    /// [`Material::normal_texture`].
    Normal,
    /// [`Material::emissive_texture`].
    Emissive,
    /// [`Material::transmission_texture`].
    Transmission,
}

/// A number, or a few, of a [`Material`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MaterialProperty {
    /// [`Material::base_color`], RGBA.
    BaseColor,
    /// [`Material::metallic`].
    Metallic,
    /// [`Material::roughness`].
    Roughness,
    /// [`Material::normal_scale`].
    NormalScale,
    /// [`Material::emissive`], RGB.
    Emissive,
    /// [`Material::emissive_strength`].
    EmissiveStrength,
    /// The threshold of [`AlphaMode::Mask`].
    AlphaCutoff,
    /// [`Material::transmission`].
    Transmission,
    /// [`Material::ior`].
    Ior,
    /// [`Material::thickness`].
    Thickness,
    /// [`Material::attenuation_distance`].
    AttenuationDistance,
    /// [`Material::attenuation_color`], RGB.
    AttenuationColor,
    /// [`Material::dispersion`].
    Dispersion,
    /// [`TextureRef::offset`].
    TextureOffset(TextureSlot),
    /// [`TextureRef::rotation`].
    TextureRotation(TextureSlot),
    /// [`TextureRef::scale`].
    TextureScale(TextureSlot),
}

/// A number, or a few, of a [`Light`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LightProperty {
    /// [`Light::color`], RGB.
    Color,
    /// [`Light::intensity`].
    Intensity,
    /// [`Light::range`].
    Range,
    /// Inner half-angle of a spot.
    InnerCone,
    /// Outer half-angle of a spot.
    OuterCone,
}

/// A number of a [`Camera`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CameraProperty {
    /// Vertical field of view of a perspective camera.
    FieldOfView,
    /// Half-height of an orthographic camera.
    HalfHeight,
    /// [`Camera::znear`].
    Near,
}

/// What a [`PropertyChannel`] drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Property {
    /// Of `Scene::materials`.
    Material(usize, MaterialProperty),
    /// Of `Scene::lights`.
    Light(usize, LightProperty),
    /// Of `Scene::cameras`.
    Camera(usize, CameraProperty),
    /// One morph weight of a node: node, target.
    Weight(NodeIndex, usize),
}

/// One sampler applied to one property.
#[derive(Clone, Debug)]
pub struct PropertyChannel {
    /// What is driven.
    pub property: Property,
    /// The curve; its width is [`Property::width`].
    pub sampler: Sampler,
}

impl Property {
    /// Numbers in a value.
    pub fn width(self) -> usize {
        use MaterialProperty as M;
        match self {
            Self::Material(_, M::BaseColor) => 4,
            Self::Material(_, M::Emissive | M::AttenuationColor) | Self::Light(_, LightProperty::Color) => 3,
            Self::Material(_, M::TextureOffset(_) | M::TextureScale(_)) => 2,
            _ => 1,
        }
    }
}

impl MaterialProperty {
    /// Its value; `None` if the material has no such thing (a texture, a cut-out).
    pub fn get(self, material: &Material) -> Option<Vec<f64>> {
        let one = |value: f32| Some(vec![f64::from(value)]);
        let wide = |values: &[f32]| Some(values.iter().copied().map(f64::from).collect());
        match self {
            Self::BaseColor => wide(&material.base_color.to_array()),
            Self::Metallic => one(material.metallic),
            Self::Roughness => one(material.roughness),
            Self::NormalScale => one(material.normal_scale),
            Self::Emissive => wide(&material.emissive.to_array()),
            Self::EmissiveStrength => one(material.emissive_strength),
            Self::AlphaCutoff => match material.alpha {
                AlphaMode::Mask(cutoff) => one(cutoff),
                _ => None,
            },
            Self::Transmission => one(material.transmission),
            Self::Ior => Some(vec![material.ior]),
            Self::Thickness => one(material.thickness),
            Self::AttenuationDistance => one(material.attenuation_distance),
            Self::AttenuationColor => wide(&material.attenuation_color.to_array()),
            Self::Dispersion => one(material.dispersion),
            Self::TextureOffset(slot) => wide(&slot.of(material)?.offset.to_array()),
            Self::TextureRotation(slot) => one(slot.of(material)?.rotation),
            Self::TextureScale(slot) => wide(&slot.of(material)?.scale.to_array()),
        }
    }

    /// Sets it, brought into its legal range. Values that are too few or no numbers change nothing.
    pub fn set(self, material: &mut Material, values: &[f64]) {
        let numbers: Vec<f32> = values.iter().map(|&value| value as f32).collect();
        if numbers.iter().any(|number| number.is_nan()) {
            return;
        }
        match (self, numbers.as_slice()) {
            (Self::BaseColor, &[r, g, b, a]) => {
                material.base_color = Vec4::new(r, g, b, a).clamp(Vec4::ZERO, Vec4::ONE);
            }
            (Self::Emissive, &[r, g, b]) => material.emissive = Vec3::new(r, g, b).max(Vec3::ZERO),
            (Self::AttenuationColor, &[r, g, b]) => {
                material.attenuation_color = Vec3::new(r, g, b).clamp(Vec3::ZERO, Vec3::ONE);
            }
            (Self::TextureOffset(slot), &[u, v]) => slot.change(material, |it| it.offset = Vec2::new(u, v)),
            (Self::TextureScale(slot), &[u, v]) => slot.change(material, |it| it.scale = Vec2::new(u, v)),
            (Self::TextureRotation(slot), &[angle]) => slot.change(material, |it| it.rotation = angle),
            (Self::Metallic, &[value]) => material.metallic = value.clamp(0.0, 1.0),
            (Self::Roughness, &[value]) => material.roughness = value.clamp(0.0, 1.0),
            (Self::NormalScale, &[value]) => material.normal_scale = value,
            (Self::EmissiveStrength, &[value]) => material.emissive_strength = value.max(0.0),
            (Self::AlphaCutoff, &[value]) => {
                if let AlphaMode::Mask(cutoff) = &mut material.alpha {
                    *cutoff = value.max(0.0);
                }
            }
            (Self::Transmission, &[value]) => material.transmission = value.clamp(0.0, 1.0),
            // 0 stands for total reflection in KHR_materials_ior; glass of it does not exist, as in a material at rest.
            (Self::Ior, _) => {
                material.ior = values.first().map_or(material.ior, |&ior| if ior < 1.0 { 1.5 } else { ior });
            }
            (Self::Thickness, &[value]) => material.thickness = value.max(0.0),
            (Self::AttenuationDistance, &[value]) => {
                material.attenuation_distance = if value > 0.0 { value } else { f32::INFINITY };
            }
            (Self::Dispersion, &[value]) => material.dispersion = value.max(0.0),
            _ => {}
        }
    }
}

impl TextureSlot {
    fn of(self, material: &Material) -> Option<&TextureRef> {
        match self {
            Self::BaseColor => material.base_color_texture.as_ref(),
            Self::MetallicRoughness => material.metallic_roughness_texture.as_ref(),
            Self::Normal => material.normal_texture.as_ref(),
            Self::Emissive => material.emissive_texture.as_ref(),
            Self::Transmission => material.transmission_texture.as_ref(),
        }
    }

    fn change(self, material: &mut Material, change: impl FnOnce(&mut TextureRef)) {
        let texture = match self {
            Self::BaseColor => &mut material.base_color_texture,
            Self::MetallicRoughness => &mut material.metallic_roughness_texture,
            Self::Normal => &mut material.normal_texture,
            Self::Emissive => &mut material.emissive_texture,
            Self::Transmission => &mut material.transmission_texture,
        };
        if let Some(texture) = texture {
            change(texture);
        }
    }
}

impl LightProperty {
    /// Its value; `None` if the light has no such thing (a cone).
    pub fn get(self, light: &Light) -> Option<Vec<f64>> {
        match (self, light.kind) {
            (Self::Color, _) => Some(light.color.to_array().map(f64::from).to_vec()),
            (Self::Intensity, _) => Some(vec![light.intensity.into()]),
            (Self::Range, _) => Some(vec![light.range.into()]),
            (Self::InnerCone, LightKind::Spot { inner, .. }) => Some(vec![inner.into()]),
            (Self::OuterCone, LightKind::Spot { outer, .. }) => Some(vec![outer.into()]),
            _ => None,
        }
    }

    /// Sets it, brought into its legal range. Values that are too few or no numbers change nothing.
    pub fn set(self, light: &mut Light, values: &[f64]) {
        if values.iter().any(|value| value.is_nan()) {
            return;
        }
        match (self, values, &mut light.kind) {
            (Self::Color, &[r, g, b], _) => light.color = DVec3::new(r, g, b).as_vec3().max(Vec3::ZERO),
            (Self::Intensity, &[value], _) => light.intensity = (value as f32).max(0.0),
            (Self::Range, &[value], _) => light.range = if value > 0.0 { value as f32 } else { f32::INFINITY },
            (Self::InnerCone, &[value], LightKind::Spot { inner, outer }) => *inner = (value as f32).clamp(0.0, *outer),
            (Self::OuterCone, &[value], LightKind::Spot { inner, outer }) => {
                *outer = (value as f32).clamp(1e-3, FRAC_PI_2);
                *inner = inner.min(*outer);
            }
            _ => {}
        }
    }
}

impl CameraProperty {
    /// Its value; `None` if the camera is of the other kind.
    pub fn get(self, camera: &Camera) -> Option<Vec<f64>> {
        match (self, camera.projection) {
            (Self::FieldOfView, Projection::Perspective { yfov }) => Some(vec![yfov]),
            (Self::HalfHeight, Projection::Orthographic { half_height }) => Some(vec![half_height]),
            (Self::Near, _) => Some(vec![camera.znear]),
            _ => None,
        }
    }

    /// Sets it, brought into its legal range. A value that is missing or no number changes nothing.
    pub fn set(self, camera: &mut Camera, values: &[f64]) {
        let &[value] = values else { return };
        if value.is_nan() {
            return;
        }
        match (self, &mut camera.projection) {
            (Self::FieldOfView, Projection::Perspective { yfov }) => {
                *yfov = value.clamp(1e-6, std::f64::consts::PI - 1e-6);
            }
            (Self::HalfHeight, Projection::Orthographic { half_height }) => {
                *half_height = value.abs().max(f64::MIN_POSITIVE);
            }
            (Self::Near, _) => camera.znear = value.max(f64::MIN_POSITIVE),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_set_is_what_is_got() {
        use MaterialProperty as M;
        let texture = TextureRef {
            image: 0,
            texcoord: 0,
            wrap: [crate::Wrap::Repeat; 2],
            offset: Vec2::ZERO,
            rotation: 0.0,
            scale: Vec2::ONE,
        };
        let mut material =
            Material { alpha: AlphaMode::Mask(0.5), normal_texture: Some(texture), ..Material::glass(1.5) };
        let properties = [
            M::BaseColor,
            M::Metallic,
            M::Roughness,
            M::NormalScale,
            M::Emissive,
            M::EmissiveStrength,
            M::AlphaCutoff,
            M::Transmission,
            M::Thickness,
            M::AttenuationDistance,
            M::AttenuationColor,
            M::Dispersion,
            M::TextureOffset(TextureSlot::Normal),
            M::TextureRotation(TextureSlot::Normal),
            M::TextureScale(TextureSlot::Normal),
        ];
        for property in properties {
            let values = vec![0.25; Property::Material(0, property).width()];
            property.set(&mut material, &values);
            assert_eq!(property.get(&material), Some(values), "{property:?}");
            property.set(&mut material, &[f64::NAN; 4]);
            assert!(property.get(&material).unwrap().iter().all(|value| *value == 0.25), "{property:?}");
        }
        M::Ior.set(&mut material, &[1.25]);
        assert_eq!(M::Ior.get(&material), Some(vec![1.25]));
        M::Ior.set(&mut material, &[0.0]);
        assert_eq!(M::Ior.get(&material), Some(vec![1.5]));
        M::BaseColor.set(&mut material, &[-0.5, 2.0, 0.5, 1.0]);
        assert_eq!(M::BaseColor.get(&material), Some(vec![0.0, 1.0, 0.5, 1.0]));
        assert_eq!(M::TextureScale(TextureSlot::BaseColor).get(&material), None);
    }
}

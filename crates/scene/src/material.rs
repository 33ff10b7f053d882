//! Surface materials: metallic-roughness and the glass extensions.

use glam::{Vec2, Vec3, Vec4};

/// Texture address mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Tile.
    #[default]
    Repeat,
    /// Extend the edge texel.
    Clamp,
    /// Tile with every other copy flipped.
    Mirror,
}

/// A decoded image, 8 bits a channel, row 0 at the top.
#[derive(Clone, Debug)]
pub struct Image {
    /// Name or file in the source, for messages.
    pub name: String,
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// `width * height` RGBA texels as stored (sRGB or linear is up to the slot that uses it).
    pub rgba: Vec<[u8; 4]>,
}

/// A texture slot: which image, which coordinates, how addressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into `Scene::images`.
    pub image: usize,
    /// TEXCOORD set.
    pub texcoord: usize,
    /// Horizontal and vertical addressing.
    pub wrap: [Wrap; 2],
    /// KHR_texture_transform: offset.
    pub offset: Vec2,
    /// KHR_texture_transform: rotation, radians counter-clockwise.
    pub rotation: f32,
    /// KHR_texture_transform: scale.
    pub scale: Vec2,
}

/// How alpha is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Cut out below the threshold.
    Mask(f32),
    /// Blended (drawn as a cut-out at one half where blending is not available).
    Blend,
}

/// A glTF material with KHR_materials_transmission, _ior, _volume and _dispersion.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file, or empty.
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: Vec4,
    /// sRGB base colour.
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness (alpha = roughness squared).
    pub roughness: f32,
    /// Linear: G roughness, B metallic.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normals.
    pub normal_texture: Option<TextureRef>,
    /// Scale of the normal texture's xy.
    pub normal_scale: f32,
    /// Emitted radiance factor, linear RGB, before `emissive_strength`.
    pub emissive: Vec3,
    /// KHR_materials_emissive_strength: factor on `emissive`.
    pub emissive_strength: f32,
    /// sRGB emissive.
    pub emissive_texture: Option<TextureRef>,
    /// Alpha handling.
    pub alpha: AlphaMode,
    /// Draw both sides.
    pub double_sided: bool,
    /// Fraction of light transmitted, 0 opaque, 1 glass.
    pub transmission: f32,
    /// R multiplies `transmission`.
    pub transmission_texture: Option<TextureRef>,
    /// Index of refraction relative to air.
    pub ior: f64,
    /// KHR_materials_volume thickness; 0 marks a thin wall. The traced length is used, not this.
    pub thickness: f32,
    /// Colour that white light turns into after `attenuation_distance`, linear RGB.
    pub attenuation_color: Vec3,
    /// Metres; infinite for clear glass.
    pub attenuation_distance: f32,
    /// KHR_materials_dispersion: 20 / Abbe number.
    pub dispersion: f32,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emissive: Vec3::ZERO,
            emissive_strength: 1.0,
            emissive_texture: None,
            alpha: AlphaMode::Opaque,
            double_sided: false,
            transmission: 0.0,
            transmission_texture: None,
            ior: 1.5,
            thickness: 0.0,
            attenuation_color: Vec3::ONE,
            attenuation_distance: f32::INFINITY,
            dispersion: 0.0,
        }
    }
}

impl Material {
    /// Clear glass of the given index of refraction.
    pub fn glass(ior: f64) -> Self {
        Self {
            name: "glass".into(),
            metallic: 0.0,
            roughness: 0.0,
            transmission: 1.0,
            ior,
            thickness: 1.0,
            ..Self::default()
        }
    }

    /// Whether bodies of this material are drawn by refraction rather than shaded.
    pub fn is_glass(&self) -> bool {
        self.transmission > 0.0
    }
}

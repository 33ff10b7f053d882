//! Materials: metallic-roughness and the glass extensions.

use glam::{Vec2, Vec3, Vec4};
use serde::Deserialize;

use super::document::{self, Document, Extensions, TextureInfo, extension, get, label};
use super::error::ImportProblem;
use super::images::Images;
use crate::{AlphaMode, Material, TextureRef, Wrap};

const CLAMP_TO_EDGE: u32 = 33071;
const MIRRORED_REPEAT: u32 = 33648;

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Transmission {
    transmission_factor: f32,
    transmission_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
struct Ior {
    ior: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Volume {
    thickness_factor: f32,
    attenuation_distance: Option<f32>,
    attenuation_color: Option<[f32; 3]>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Dispersion {
    dispersion: f32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct EmissiveStrength {
    emissive_strength: Option<f32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct TextureTransform {
    #[serde(default)]
    offset: [f32; 2],
    #[serde(default)]
    rotation: f32,
    #[serde(default = "unit_scale")]
    scale: [f32; 2],
    tex_coord: Option<usize>,
}

fn unit_scale() -> [f32; 2] {
    [1.0; 2]
}

/// Imports every material and, through `images`, the images they use.
pub(super) fn import(
    document: &Document,
    images: &mut Images,
    warnings: &mut Vec<String>,
) -> Result<Vec<Material>, ImportProblem> {
    let mut materials = Vec::with_capacity(document.materials.len());
    for (index, source) in document.materials.iter().enumerate() {
        let at = label("materials", index, source.name.as_deref());
        materials.push(MaterialReader { document, images, warnings, at: &at }.read(source)?);
    }
    Ok(materials)
}

struct MaterialReader<'a, 'i> {
    document: &'a Document,
    images: &'a mut Images<'i>,
    warnings: &'a mut Vec<String>,
    at: &'a str,
}

impl MaterialReader<'_, '_> {
    fn read(&mut self, source: &document::Material) -> Result<Material, ImportProblem> {
        let pbr = &source.pbr_metallic_roughness;
        let mut material = Material {
            name: source.name.clone().unwrap_or_default(),
            base_color: pbr.base_color_factor.map_or(Vec4::ONE, Vec4::from_array),
            base_color_texture: self.texture(pbr.base_color_texture.as_ref())?,
            metallic: pbr.metallic_factor.unwrap_or(1.0),
            roughness: pbr.roughness_factor.unwrap_or(1.0),
            metallic_roughness_texture: self.texture(pbr.texture.as_ref())?,
            normal_texture: self.texture(source.normal_texture.as_ref())?,
            normal_scale: source.normal_texture.as_ref().and_then(|info| info.scale).unwrap_or(1.0),
            emissive: source.emissive_factor.map_or(Vec3::ZERO, Vec3::from_array),
            emissive_texture: self.texture(source.emissive_texture.as_ref())?,
            alpha: self.alpha(source),
            double_sided: source.double_sided,
            ..Material::default()
        };
        self.read_glass(&source.extensions, &mut material)?;
        if let Some(strength) =
            self.extension::<EmissiveStrength>(&source.extensions, "KHR_materials_emissive_strength")?
        {
            material.emissive_strength = strength.emissive_strength.unwrap_or(1.0);
        }
        self.check(&mut material)?;
        Ok(material)
    }

    fn read_glass(&mut self, extensions: &Extensions, material: &mut Material) -> Result<(), ImportProblem> {
        if let Some(transmission) = self.extension::<Transmission>(extensions, "KHR_materials_transmission")? {
            material.transmission = transmission.transmission_factor;
            material.transmission_texture = self.texture(transmission.transmission_texture.as_ref())?;
        }
        if let Some(Ior { ior: Some(ior) }) = self.extension(extensions, "KHR_materials_ior")? {
            material.ior = ior;
        }
        if let Some(volume) = self.extension::<Volume>(extensions, "KHR_materials_volume")? {
            material.thickness = volume.thickness_factor;
            material.attenuation_color = volume.attenuation_color.map_or(Vec3::ONE, Vec3::from_array);
            material.attenuation_distance = volume.attenuation_distance.unwrap_or(f32::INFINITY);
        }
        if let Some(Dispersion { dispersion }) = self.extension(extensions, "KHR_materials_dispersion")? {
            material.dispersion = dispersion;
        }
        Ok(())
    }

    fn extension<T: serde::de::DeserializeOwned>(
        &self,
        extensions: &Extensions,
        name: &str,
    ) -> Result<Option<T>, ImportProblem> {
        extension(extensions, name, self.at)
    }

    fn alpha(&mut self, source: &document::Material) -> AlphaMode {
        match source.alpha_mode.as_deref() {
            None | Some("OPAQUE") => AlphaMode::Opaque,
            Some("MASK") => AlphaMode::Mask(source.alpha_cutoff.unwrap_or(0.5)),
            Some("BLEND") => AlphaMode::Blend,
            Some(mode) => {
                self.warnings.push(format!("{}: unknown alphaMode \"{mode}\", taken as OPAQUE", self.at));
                AlphaMode::Opaque
            }
        }
    }

    fn texture(&mut self, info: Option<&TextureInfo>) -> Result<Option<TextureRef>, ImportProblem> {
        let Some(info) = info else { return Ok(None) };
        let texture = get(&self.document.textures, info.index, "textures", self.at)?;
        let Some(source) = texture.source else {
            self.warnings.push(format!("{}: textures[{}] has no PNG or JPEG source; ignored", self.at, info.index));
            return Ok(None);
        };
        let wrap = match texture.sampler {
            Some(sampler) => {
                let sampler = get(&self.document.samplers, sampler, "samplers", &format!("textures[{}]", info.index))?;
                [wrap(sampler.wrap_s), wrap(sampler.wrap_t)]
            }
            None => [Wrap::Repeat; 2],
        };
        let transform: Option<TextureTransform> = self.extension(&info.extensions, "KHR_texture_transform")?;
        let transform = transform.unwrap_or(TextureTransform {
            offset: [0.0; 2],
            rotation: 0.0,
            scale: unit_scale(),
            tex_coord: None,
        });
        let TextureTransform { offset: [x, y], rotation, scale: [width, height], .. } = transform;
        if ![x, y, rotation, width, height].iter().all(|value| value.is_finite()) {
            let problem = "a number in KHR_texture_transform is too large for a 32-bit float".to_owned();
            return Err(ImportProblem::Value { at: self.at.to_owned(), problem });
        }
        Ok(Some(TextureRef {
            image: self.images.import(source, &format!("textures[{}]", info.index))?,
            texcoord: transform.tex_coord.unwrap_or(info.tex_coord),
            wrap,
            offset: Vec2::from_array(transform.offset),
            rotation: transform.rotation,
            scale: Vec2::from_array(transform.scale),
        }))
    }

    /// Refuses numbers that no exporter means; brings the merely unusual into range.
    fn check(&mut self, material: &mut Material) -> Result<(), ImportProblem> {
        // 0 is legal and stands for total reflection in KHR_materials_ior; glass of it does not exist.
        if material.ior < 1.0 {
            self.warnings.push(format!("{}: index of refraction {} taken as 1.5", self.at, material.ior));
            material.ior = 1.5;
        }
        if material.attenuation_distance <= 0.0 {
            self.warnings.push(format!("{}: attenuationDistance is not positive, taken as infinite", self.at));
            material.attenuation_distance = f32::INFINITY;
        }
        let finite = [
            ("baseColorFactor", material.base_color.is_finite()),
            ("metallicFactor", material.metallic.is_finite()),
            ("roughnessFactor", material.roughness.is_finite()),
            ("emissiveFactor", (material.emissive * material.emissive_strength).is_finite()),
            ("normalTexture.scale", material.normal_scale.is_finite()),
            ("transmissionFactor", material.transmission.is_finite()),
            ("thicknessFactor", material.thickness.is_finite()),
            ("attenuationColor", material.attenuation_color.is_finite()),
            ("dispersion", material.dispersion.is_finite()),
        ];
        if let Some((name, _)) = finite.iter().find(|(_, finite)| !finite) {
            let problem = format!("{name} is too large for a 32-bit float");
            return Err(ImportProblem::Value { at: self.at.to_owned(), problem });
        }
        material.metallic = material.metallic.clamp(0.0, 1.0);
        material.roughness = material.roughness.clamp(0.0, 1.0);
        material.transmission = material.transmission.clamp(0.0, 1.0);
        material.attenuation_color = material.attenuation_color.clamp(Vec3::ZERO, Vec3::ONE);
        material.thickness = material.thickness.max(0.0);
        material.dispersion = material.dispersion.max(0.0);
        Ok(())
    }
}

fn wrap(mode: Option<u32>) -> Wrap {
    match mode {
        Some(CLAMP_TO_EDGE) => Wrap::Clamp,
        Some(MIRRORED_REPEAT) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

//! Materials and their textures as the opaque shader reads them.

use bytemuck::{Pod, Zeroable};
use murano_scene::{Material, Scene, TextureRef, Wrap};

/// Slot number for "no texture".
const NO_SLOT: u32 = u32::MAX;

/// One material (`lib::material_row::MaterialRow`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct MaterialRow {
    base_color: [f32; 4],
    emissive: [f32; 3],
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    pub(crate) fade_radius: f32,
    base_color_slot: u32,
    metallic_roughness_slot: u32,
    normal_slot: u32,
    emissive_slot: u32,
    transmission_slot: u32,
    transmission: f32,
    padding: [u32; 3],
}

/// One use of an image (`lib::texels::TextureSlot`).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct TextureSlot {
    row_u: [f32; 3],
    offset: u32,
    row_v: [f32; 3],
    width: u32,
    height: u32,
    levels: u32,
    wrap: u32,
    flags: u32,
}

/// Materials, texture slots and texels of a scene.
#[derive(Default)]
pub(crate) struct MaterialTable {
    pub(crate) rows: Vec<MaterialRow>,
    pub(crate) slots: Vec<TextureSlot>,
    pub(crate) texels: Vec<[u8; 4]>,
    /// First texel and levels of each image that has been stored.
    stored: std::collections::BTreeMap<usize, (u32, u32)>,
}

impl MaterialTable {
    /// The materials of a scene in order, then the default material.
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut table = Self::default();
        table.fill(scene, &scene.materials);
        table
    }

    /// Rows and slots of a scene's materials as they have become; its `texels` are the same, and not in it.
    pub(crate) fn with_materials(&self, scene: &Scene, materials: &[Material]) -> Self {
        let mut table = Self { stored: self.stored.clone(), ..Self::default() };
        table.fill(scene, materials);
        table
    }

    fn fill(&mut self, scene: &Scene, materials: &[Material]) {
        let default = Material::default();
        for material in materials.iter().chain([&default]) {
            let row = MaterialRow {
                base_color: material.base_color.to_array(),
                emissive: (material.emissive * material.emissive_strength).to_array(),
                metallic: material.metallic,
                roughness: material.roughness,
                normal_scale: material.normal_scale,
                fade_radius: 0.0,
                base_color_slot: self.slot(scene, material.base_color_texture, true),
                metallic_roughness_slot: self.slot(scene, material.metallic_roughness_texture, false),
                normal_slot: self.slot(scene, material.normal_texture, false),
                emissive_slot: self.slot(scene, material.emissive_texture, true),
                transmission_slot: self.slot(scene, material.transmission_texture, false),
                transmission: material.transmission,
                padding: [0; 3],
            };
            self.rows.push(row);
        }
    }

    /// Texture slot and scale of each material's map of normals.
    pub(crate) fn relief_rows(&self) -> Vec<[u32; 2]> {
        self.rows.iter().map(|row| [row.normal_slot, row.normal_scale.to_bits()]).collect()
    }

    fn slot(&mut self, scene: &Scene, texture: Option<TextureRef>, srgb: bool) -> u32 {
        let Some(texture) = texture else { return NO_SLOT };
        let Some(image) = scene.images.get(texture.image) else { return NO_SLOT };
        if image.width == 0 || image.height == 0 || texture.texcoord > 1 {
            return NO_SLOT;
        }
        let (offset, levels) = self.store(scene, texture.image);
        let (sin, cos) = texture.rotation.sin_cos();
        let wrap = |mode| match mode {
            Wrap::Repeat => 0,
            Wrap::Clamp => 1,
            Wrap::Mirror => 2,
        };
        let slot = TextureSlot {
            row_u: [cos * texture.scale.x, sin * texture.scale.y, texture.offset.x],
            offset,
            row_v: [-sin * texture.scale.x, cos * texture.scale.y, texture.offset.y],
            width: image.width,
            height: image.height,
            levels,
            wrap: wrap(texture.wrap[0]) | wrap(texture.wrap[1]) << 2,
            flags: texture.texcoord as u32 | u32::from(srgb) << 1,
        };
        let index = self.slots.iter().position(|other| *other == slot).unwrap_or_else(|| {
            self.slots.push(slot);
            self.slots.len() - 1
        });
        index as u32
    }

    /// Stores an image with its mip chain once; returns its first texel and the number of levels.
    fn store(&mut self, scene: &Scene, image: usize) -> (u32, u32) {
        if let Some(&place) = self.stored.get(&image) {
            return place;
        }
        let source = &scene.images[image];
        let offset = self.texels.len() as u32;
        let (mut width, mut height) = (source.width as usize, source.height as usize);
        let mut level = source.rgba.clone();
        let mut levels = 1;
        self.texels.extend_from_slice(&level);
        while width > 1 || height > 1 {
            let (next_width, next_height) = ((width / 2).max(1), (height / 2).max(1));
            level = halve(&level, width, height, next_width, next_height);
            (width, height) = (next_width, next_height);
            self.texels.extend_from_slice(&level);
            levels += 1;
        }
        self.stored.insert(image, (offset, levels));
        (offset, levels)
    }
}

/// Box filter by two; the last row or column of an odd size is dropped.
fn halve(level: &[[u8; 4]], width: usize, height: usize, to_width: usize, to_height: usize) -> Vec<[u8; 4]> {
    let mut out = Vec::with_capacity(to_width * to_height);
    for y in 0..to_height {
        for x in 0..to_width {
            let (x0, y0) = (2 * x, 2 * y);
            let (x1, y1) = ((x0 + 1).min(width - 1), (y0 + 1).min(height - 1));
            let four = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| level[y * width + x]);
            let mean = |c: usize| ((four.iter().map(|texel| u16::from(texel[c])).sum::<u16>() + 2) / 4) as u8;
            out.push([mean(0), mean(1), mean(2), mean(3)]);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, ShaderSpec, check_storage_layout};

    use super::*;

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let opaque = Shader::link(&ShaderSpec::new("render::opaque").feature("textured", true)).unwrap();
        check_storage_layout!(
            opaque,
            "MaterialRow",
            MaterialRow {
                base_color,
                emissive,
                metallic,
                roughness,
                normal_scale,
                fade_radius,
                base_color_slot,
                metallic_roughness_slot,
                normal_slot,
                emissive_slot,
                transmission_slot,
                transmission,
                padding,
            }
        )
        .unwrap();
        check_storage_layout!(
            opaque,
            "TextureSlot",
            TextureSlot { row_u, offset, row_v, width, height, levels, wrap, flags }
        )
        .unwrap();
    }
}

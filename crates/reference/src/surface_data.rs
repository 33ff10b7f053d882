//! What the surface of a mesh is sampled from, and what it is at a hit.

use glam::{DVec2, DVec3, DVec4};
use murano_animation::Geometry;
use murano_scene::{Image, Material, TextureRef};

use crate::{
    Hit,
    textures::{Encoding, sample},
};

/// Texture coordinates, colours and tangents of a traced mesh.
#[derive(Clone, Default)]
pub struct SurfaceData {
    /// The mesh with its instances, texture coordinates and colours.
    pub geometry: Geometry,
    /// Vertices in `geometry` of each triangle's corners, in the mesh's order: a mirrored instance is wound the other way.
    pub triangles: Vec<[u32; 3]>,
    /// Of the deformed vertices, with the sign of the bitangent (`murano_animation::Deformed::tangents`).
    pub tangents: Vec<DVec4>,
}

impl SurfaceData {
    /// Index of a hit's material.
    pub(crate) fn material_index(&self, hit: &Hit) -> Option<usize> {
        let instance = self.geometry.triangle_instances[hit.element as usize];
        self.geometry.instances[instance as usize].material
    }

    /// A hit on it, ready to be looked up.
    pub(crate) fn at<'a>(&'a self, hit: &Hit, images: &'a [Image]) -> Sampled<'a> {
        let corners = self.triangles[hit.element as usize].map(|vertex| vertex as usize);
        let mut sampled =
            Sampled { data: self, corners, weights: hit.barycentric.to_array(), images, sets: [DVec2::ZERO; 2] };
        let sets = sampled.blend(|corner| DVec4::from_array(self.geometry.texcoords[corner].map(f64::from)));
        sampled.sets = [sets.truncate().truncate(), DVec2::new(sets.z, sets.w)];
        sampled
    }
}

/// A place on a surface.
pub(crate) struct Sampled<'a> {
    data: &'a SurfaceData,
    corners: [usize; 3],
    weights: [f64; 3],
    images: &'a [Image],
    /// TEXCOORD_0 and TEXCOORD_1.
    sets: [DVec2; 2],
}

impl Sampled<'_> {
    fn blend(&self, of: impl Fn(usize) -> DVec4) -> DVec4 {
        self.corners.iter().zip(self.weights).fold(DVec4::ZERO, |sum, (&corner, weight)| sum + weight * of(corner))
    }

    /// Linear RGB of the vertices.
    pub(crate) fn vertex_colour(&self) -> DVec3 {
        self.blend(|corner| DVec4::from_array(self.data.geometry.colors[corner].map(f64::from))).truncate()
    }

    /// A texture's first three channels; `None` where the slot names nothing that can be shown.
    pub(crate) fn texture(&self, slot: Option<TextureRef>, encoding: Encoding) -> Option<DVec3> {
        sample(self.images, slot, self.sets, encoding).map(DVec4::truncate)
    }

    /// An interpolated normal as the material's map of normals bends it (glTF 2.0, section 3.9.3): on the file's own tangents where it has
    /// some, else on the frame of the triangle's texture gradient. `places` are the triangle's corners.
    pub(crate) fn bent(&self, normal: DVec3, places: [DVec3; 3], material: &Material) -> DVec3 {
        let Some(stored) = self.texture(material.normal_texture, Encoding::Linear) else { return normal };
        let Some(slot) = material.normal_texture else { return normal };
        let stored = 2.0 * stored - 1.0;
        let across = |v: DVec3| (v - v.dot(normal) * normal).normalize_or_zero();
        let framed = self.data.tangents.get(self.corners[0]).is_some();
        let tangent = if framed { self.blend(|corner| self.data.tangents[corner]) } else { DVec4::ZERO };
        let (tangent, bitangent) = if tangent.w.abs() > 0.0 {
            let along = across(tangent.truncate());
            (along, tangent.w.signum() * normal.cross(along))
        } else {
            let [ta, tb, tc] = self.corners.map(|corner| {
                let [u0, v0, u1, v1] = self.data.geometry.texcoords[corner].map(f64::from);
                if slot.texcoord == 1 { DVec2::new(u1, v1) } else { DVec2::new(u0, v0) }
            });
            let [a, b, c] = places;
            let (e1, e2, d1, d2) = (b - a, c - a, tb - ta, tc - ta);
            let determinant = d1.x * d2.y - d2.x * d1.y;
            if determinant == 0.0 {
                return normal;
            }
            // glTF's v runs down the image, its bitangent up.
            (across((e1 * d2.y - e2 * d1.y) / determinant), -across((e2 * d1.x - e1 * d2.x) / determinant))
        };
        let scale = f64::from(material.normal_scale);
        (scale * (stored.x * tangent + stored.y * bitangent) + stored.z * normal).normalize_or(normal)
    }
}

/// The surface of a body of glass that is not the same everywhere.
pub struct GlassSurface {
    /// What it is sampled from.
    pub data: SurfaceData,
    /// Of the scene.
    pub materials: Vec<Material>,
    /// Of the scene.
    pub images: Vec<Image>,
}

impl GlassSurface {
    fn material(&self, hit: &Hit) -> Option<&Material> {
        self.materials.get(self.data.material_index(hit)?)
    }

    /// Linear RGB factor on what enters there: base colour and transmission, with their textures and the vertices' colours.
    pub(crate) fn tint(&self, hit: &Hit) -> DVec3 {
        let Some(material) = self.material(hit) else { return DVec3::ONE };
        let there = self.data.at(hit, &self.images);
        let colour = there.texture(material.base_color_texture, Encoding::Srgb).unwrap_or(DVec3::ONE);
        let share = there.texture(material.transmission_texture, Encoding::Linear).map_or(1.0, |red| red.x);
        let base = material.base_color.truncate().as_dvec3() * there.vertex_colour();
        f64::from(material.transmission) * share * colour * base
    }

    /// Perceptual roughness.
    pub(crate) fn roughness(&self, hit: &Hit) -> f64 {
        let Some(material) = self.material(hit) else { return 0.0 };
        let texture = self.data.at(hit, &self.images).texture(material.metallic_roughness_texture, Encoding::Linear);
        f64::from(material.roughness) * texture.map_or(1.0, |shine| shine.y)
    }

    /// A hit with its normal bent, but where that would turn it away from the side of the surface that the ray meets.
    pub(crate) fn bend(&self, hit: Hit, direction: DVec3, places: [DVec3; 3]) -> Hit {
        let Some(material) = self.material(&hit).filter(|material| material.normal_texture.is_some()) else {
            return hit;
        };
        let bent = self.data.at(&hit, &self.images).bent(hit.normal, places, material);
        let same_side = bent.dot(direction) * hit.geometric.dot(direction) > 0.0;
        Hit { normal: if same_side { bent } else { hit.normal }, ..hit }
    }
}

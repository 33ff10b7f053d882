//! What bodies look like at a moment: glass, mirrors and the table of materials, anew where a clip drives materials.

use glam::Vec3;
use murano_animation::GeometryError;
use murano_caustics::Mirror;
use murano_gpu::{Leaf, Work};
use murano_refraction::{Glass, Relief};
use murano_scene::{Material, Scene};
use murano_scheduler::{Plan, Stamp};

use crate::{
    Floor,
    bodies::{Body, Kind, Part, Sorted, material_of, sort},
    materials::MaterialTable,
};

/// A constant buffer: the name that shaders bind it by, its stamp, its content.
pub(crate) type Constant = (&'static str, Stamp, Leaf);

pub(crate) fn constant(name: &'static str, (stamp, leaf): (Stamp, Leaf)) -> Constant {
    (name, stamp, leaf)
}

/// What the surface of a glass body is sampled from.
#[derive(Clone)]
pub(crate) struct SurfaceSource {
    /// Whether any of its materials has a texture.
    pub(crate) textured: bool,
    /// What a map of normals is looked up in where a ray ends on a triangle, if any has one: buffers as [`Relief`] names them.
    pub(crate) relief: Option<[Constant; 4]>,
    /// Constant buffers by the names that `render::glass_surface` binds.
    pub(crate) buffers: Vec<Constant>,
}

impl SurfaceSource {
    /// What bends the body's normals.
    pub(crate) fn relief(&self, plan: &mut Plan<Work>) -> Option<Relief> {
        let [texcoords, rows, texture_slots, texels] = self
            .relief
            .as_ref()?
            .each_ref()
            .map(|(name, stamp, leaf)| plan.leaf(name, *stamp, Work::Leaf(leaf.clone())));
        Some(Relief { texcoords, rows, texture_slots, texels })
    }
}

/// What a glass body looks like.
#[derive(Clone)]
pub(crate) struct Look {
    pub(crate) glass: Glass,
    /// What its surface is sampled from, where that is not the same everywhere; `glass` then has the means of its materials'
    /// tints and roughnesses.
    pub(crate) surface: Option<SurfaceSource>,
    /// Whether any part of it is rough.
    pub(crate) rough: bool,
}

impl Look {
    /// Whether light passes as if there were nothing.
    pub(crate) fn is_invisible(&self) -> bool {
        self.surface.is_none() && self.glass.is_invisible()
    }
}

/// What everything looks like.
#[derive(Clone)]
pub(crate) struct Looks {
    /// Of each glass body.
    pub(crate) bodies: Vec<Look>,
    /// Of each polished body.
    pub(crate) mirrors: Vec<Mirror>,
    /// Whether any material has a texture.
    pub(crate) textured: bool,
    /// The table of materials and its textures, by the names that shaders bind.
    pub(crate) materials: [Constant; 3],
    /// The materials, and each one's row for maps of normals.
    list: Vec<Material>,
    relief_rows: Vec<[u32; 2]>,
}

impl Looks {
    /// What several bodies as one look like: `glass` then has the means of their tints and roughnesses.
    pub(crate) fn of_compound(&self, scene: &Scene, body: &Body) -> Look {
        look(body, &materials_of(scene, body, &self.list), &self.materials, &self.relief_rows)
    }
}

fn materials_of<'a>(scene: &Scene, body: &Body, materials: &'a [Material]) -> Vec<&'a Material> {
    let of = |&(node, primitive): &Part| Some(&materials[material_of(scene, node, primitive)?]);
    body.parts.iter().filter_map(of).collect()
}

/// What looks are made from besides bodies and materials: textures are decoded and hashed once.
pub(crate) struct LookSource {
    table: MaterialTable,
    texels: Constant,
    /// Material of the floor, and the radius at which it fades.
    fading: Option<(usize, f32)>,
}

impl LookSource {
    /// Of a scene whose floor has a material.
    pub(crate) fn new(scene: &Scene, floor: Option<(usize, &Floor)>) -> Self {
        let table = MaterialTable::new(scene);
        let fading = floor.map(|(material, floor)| (material, floor.half_extent as f32));
        let texels = constant("texels", Leaf::of(&table.texels));
        Self { table, texels, fading }
    }

    /// What bodies sorted by these materials look like.
    pub(crate) fn looks(&self, scene: &Scene, sorted: &Sorted, materials: &[Material]) -> Looks {
        let table = self.table.with_materials(scene, materials);
        looks(scene, materials, sorted, &table, &self.texels, self.fading)
    }
}

/// Bodies sorted by what their materials are at some moments, and what they look like at the last of these.
pub(crate) struct Arrangement {
    /// How each material is drawn.
    kinds: Vec<Kind>,
    materials: Vec<Material>,
    pub(crate) sorted: Sorted,
    pub(crate) looks: Looks,
}

impl Arrangement {
    /// Sorts what a scene shows of these materials.
    pub(crate) fn new(scene: &Scene, source: &LookSource, materials: Vec<Material>) -> Result<Self, GeometryError> {
        let sorted = sort(scene, &materials)?;
        let looks = source.looks(scene, &sorted, &materials);
        Ok(Self { kinds: materials.iter().map(Kind::of).collect(), materials, sorted, looks })
    }

    /// Takes on other materials; `false` if these are drawn in other ways than its own, so that bodies have to be sorted anew.
    pub(crate) fn take(&mut self, scene: &Scene, source: &LookSource, materials: &[Material]) -> bool {
        if !self.kinds.iter().copied().eq(materials.iter().map(Kind::of)) {
            return false;
        }
        if self.materials != materials {
            self.looks = source.looks(scene, &self.sorted, materials);
            self.materials = materials.to_vec();
        }
        true
    }
}

fn looks(
    scene: &Scene,
    materials: &[Material],
    sorted: &Sorted,
    table: &MaterialTable,
    texels: &Constant,
    fading: Option<(usize, f32)>,
) -> Looks {
    let mut rows = table.rows.clone();
    if let Some((material, radius)) = fading {
        rows[material].fade_radius = radius;
    }
    let shared =
        [constant("materials", Leaf::of(&rows)), constant("texture_slots", Leaf::of(&table.slots)), texels.clone()];
    let relief_rows = table.relief_rows();
    let of = |&(node, primitive): &Part| Some(&materials[material_of(scene, node, primitive)?]);
    Looks {
        bodies: sorted
            .bodies
            .iter()
            .map(|body| look(body, &materials_of(scene, body, materials), &shared, &relief_rows))
            .collect(),
        mirrors: sorted.mirrors.iter().filter_map(|mirror| of(&mirror.part).and_then(Mirror::of)).collect(),
        textured: !table.slots.is_empty(),
        materials: shared,
        list: materials.to_vec(),
        relief_rows,
    }
}

/// A body of these materials.
fn look(body: &Body, materials: &[&Material], shared: &[Constant; 3], relief_rows: &[[u32; 2]]) -> Look {
    let count = materials.len().max(1) as f32;
    let tint = materials.iter().map(|material| Vec3::from(Glass::of(material).tint)).sum::<Vec3>() / count;
    let roughness = materials.iter().map(|material| material.roughness).sum::<f32>() / count;
    let optics = materials.first().map_or_else(|| Glass::of(&Material::default()), |material| Glass::of(material));
    Look {
        glass: Glass { tint: tint.to_array(), roughness, ..optics },
        surface: surface_of(body, materials, shared, relief_rows),
        // A map of normals that is seen from afar is roughness too.
        rough: materials.iter().any(|material| material.roughness > 0.0 || material.normal_texture.is_some()),
    }
}

/// What a body's surface is sampled from, unless it is the same everywhere.
fn surface_of(
    body: &Body,
    materials: &[&Material],
    shared: &[Constant; 3],
    relief_rows: &[[u32; 2]],
) -> Option<SurfaceSource> {
    let textures = |material: &Material| {
        [
            material.base_color_texture,
            material.transmission_texture,
            material.metallic_roughness_texture,
            material.normal_texture,
        ]
    };
    let textured = materials.iter().any(|material| textures(material).iter().any(Option::is_some));
    let coloured = body.geometry.colors.iter().any(|[r, g, b, _]| [*r, *g, *b] != [1.0; 3]);
    let of = |material: &Material| (Glass::of(material).tint, material.roughness);
    if !textured && !coloured && materials.windows(2).all(|pair| of(pair[0]) == of(pair[1])) {
        return None;
    }
    let mut buffers = body.surface_buffers().to_vec();
    // Textures are bound where they are sampled.
    buffers.extend(shared.iter().take(if textured { 3 } else { 1 }).cloned());
    let [texcoords, ..] = body.surface_buffers();
    let [_, slots, texels] = shared;
    let bends = materials.iter().any(|material| material.normal_texture.is_some());
    let relief = bends.then(|| {
        let rows: Vec<[u32; 2]> = body.triangle_materials.iter().map(|&row| relief_rows[row as usize]).collect();
        [texcoords.clone(), constant("relief_rows", Leaf::of(&rows)), slots.clone(), texels.clone()]
    });
    Some(SurfaceSource { textured, relief, buffers })
}

//! Interface maps: what a viewpoint sees of a geometry, by compute rasterisation and exact per-texel intersection.

use encase::ShaderType;
use murano_animation::DeformedGeometry;
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, ShaderSpec, Work};
use murano_scheduler::{Output, Plan};

use crate::{FrameViewpoint, LISTED_TILES, RefittedTree, over_listed_tiles, texels, tile_threads, tiles::tiles};

/// Which back faces an interface map keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layers {
    /// The nearest face of either side, in `front` alone: receivers and opaque things.
    Nearest,
    /// Nearest front face, nearest back face.
    NearestBack,
    /// Nearest front face, farthest back face.
    FarthestBack {
        /// And the range of the back's depths.
        depth_range: bool,
    },
    /// Nearest front face, nearest back face, and the list of all layers of every texel.
    All(Hierarchy),
    /// Of what lies behind the surfaces of another map (its `front`), the nearest front face and the nearest back face.
    Behind(Output),
}

/// What lists of layers have above them, to skip what lies clear of all layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hierarchy {
    /// For rays inside the body.
    Cores,
    /// For those outside too.
    CoresAndHulls,
}

/// The surfaces a viewpoint sees: `vec4f` a texel, view-space normal and linear depth, all zero where there is nothing.
#[derive(Clone, Copy, Debug)]
pub struct InterfaceMap {
    /// Nearest front face (or nearest face).
    pub front: Output,
    /// Back face; `None` for [`Layers::Nearest`].
    pub back: Option<Output>,
    /// Smallest and largest depth of `back` as bits `[~smallest, largest]`; for [`Layers::FarthestBack`] where it is asked for.
    pub depth_range: Option<Output>,
    /// Every layer; for [`Layers::All`].
    pub layer_lists: Option<LayerLists>,
    /// `f32` a texel: the way from `front` along its inward normal to the far side, metres; for what has a
    /// [`Mapped::thickness`].
    pub thickness: Option<Output>,
    /// `u32` a texel: index plus one of the triangle of `front`, 0 for none; for what [`Mapped::shows_triangles`].
    pub front_triangles: Option<Output>,
    /// As of what is mapped.
    pub tree: Option<RefittedTree>,
    /// As of what is mapped.
    pub relief: Option<Relief>,
    /// As of what is mapped.
    pub media: Option<Media>,
    /// As of what is mapped.
    pub geometry: DeformedGeometry,
}

/// The glass of several bodies that are mapped as one: each is a shell of the geometry
/// ([`Geometry::of_shells`](murano_animation::Geometry::of_shells)). Where they overlap, the first of them displaces the others.
#[derive(Clone, Copy, Debug)]
pub struct Media {
    /// `refraction::media::Medium`: a row of all bodies, and one more for each wavelength.
    pub(crate) rows: Output,
    pub(crate) bodies: u32,
}

impl Media {
    /// As many as there may be: light is within them by the bits of a word.
    pub const MOST: usize = 32;
}

/// Maps of normals, for methods that know which triangle they end on ([`crate::Method::knows_triangles`]): their textures and where on
/// these the triangles lie.
#[derive(Clone, Copy, Debug)]
pub struct Relief {
    /// `vec4f` a vertex: TEXCOORD_0 and TEXCOORD_1.
    pub texcoords: Output,
    /// `u32` and `f32` a triangle: texture slot (`u32::MAX`: none) and scale of its map of normals.
    pub rows: Output,
    /// `lib::texels::TextureSlot`.
    pub texture_slots: Output,
    /// RGBA8, red in the low byte.
    pub texels: Output,
}

/// A geometry in a pose, and what methods may need besides.
#[derive(Clone, Copy, Debug)]
pub struct Mapped {
    /// Its triangles.
    pub geometry: DeformedGeometry,
    /// The hierarchy over them, for methods that trace it ([`crate::Method::traces`]).
    pub tree: Option<RefittedTree>,
    /// `f32` a vertex: [`crate::thickness`].
    pub thickness: Option<Output>,
    /// Whether maps with a back tell which triangles they see in front.
    pub shows_triangles: bool,
    /// What bends its normals.
    pub relief: Option<Relief>,
    /// The bodies that it is made of, if there are several; it [shows triangles](Self::shows_triangles) then.
    pub media: Option<Media>,
}

impl From<DeformedGeometry> for Mapped {
    fn from(geometry: DeformedGeometry) -> Self {
        Self { geometry, tree: None, thickness: None, shows_triangles: false, relief: None, media: None }
    }
}

/// All triangles under each texel's centre, nearest first: at most 16 a texel, as many altogether as four times the texels.
#[derive(Clone, Copy, Debug)]
pub struct LayerLists {
    /// Two `u32` a texel: where its layers lie, and how many there are; 65536 is added where farther ones were dropped.
    pub lists: Output,
    /// Three `u32` a layer: bits of its depth; twice the triangle's index, plus one for a back face; its flat outward normal
    /// in view space on the octahedron, 16 bits a coordinate.
    pub layers: Output,
    /// `vec4f` a cell: depths between which every texel of the cell and around it is inside, two intervals. Cells of 2x2
    /// texels, then of 4x4, up to 64x64, each level padded to whole cells of the last.
    pub cores: Output,
    /// `vec4f` a cell of these: depths between which all layers lie, and between which there is none.
    pub hulls: Option<Output>,
}

#[derive(ShaderType)]
struct ListParams {
    triangle_count: u32,
    capacity: u32,
}

#[derive(ShaderType)]
struct Raster {
    triangle_count: u32,
    layers: u32,
    farthest_back: u32,
}

/// Adds the dispatches that find each texel's triangle: they read `positions`, `triangles` and the uniform `viewpoint`
/// and fill the buffer `seen`, all by these names; `seen` must be cleared.
///
/// # Errors
/// [`GpuError`] if the shader is defective.
pub fn rasterise(
    gpu: &Gpu,
    pass: ComputePass,
    geometry: &DeformedGeometry,
    size: [u32; 2],
    layers: Layers,
) -> Result<ComputePass, GpuError> {
    rasterise_over(gpu, pass, geometry, size, layers, [over_triangles(geometry), SHARED])
}

/// Enough workgroups to fill a large GPU; they share out what there is.
const SHARED: Groups = Groups::Direct([64, 16, 1]);

fn over_triangles(geometry: &DeformedGeometry) -> Groups {
    Groups::linear(geometry.triangle_count, 64)
}

fn rasterise_over(
    gpu: &Gpu,
    pass: ComputePass,
    geometry: &DeformedGeometry,
    size: [u32; 2],
    layers: Layers,
    [small, large]: [Groups; 2],
) -> Result<ComputePass, GpuError> {
    let seen_first = if let Layers::Behind(seen_first) = layers { Some(seen_first) } else { None };
    let shader = gpu.shader(&ShaderSpec::new("refraction::visibility").feature("peeled", seen_first.is_some()))?;
    let count = if layers == Layers::Nearest { 1 } else { 2 };
    let pass = match seen_first {
        Some(seen_first) => pass.input("seen_first", seen_first),
        None => pass,
    };
    Ok(pass
        .value(
            "raster",
            &Raster {
                triangle_count: geometry.triangle_count as u32,
                layers: count,
                farthest_back: u32::from(matches!(layers, Layers::FarthestBack { .. })),
            },
        )
        .input("positions", geometry.positions)
        .input("triangles", geometry.triangles)
        .scratch("keys", 4 * u64::from(count) * texels(size))
        .scratch("large_count", 4)
        .workspace("large", 4 * geometry.triangle_count as u64)
        .scratch("kept", 4 * geometry.triangle_count as u64)
        .scratch("kept_arguments", 16)
        .dispatch(&shader, "small_depth", small)
        .dispatch(&shader, "large_depth", large)
        .dispatch(&shader, "small_triangle", Groups::Indirect("kept_arguments", 0))
        .dispatch(&shader, "large_triangle", large))
}

/// Adds the pass `name:instance` that maps a geometry from a viewpoint.
///
/// # Errors
/// [`GpuError`] if a shader or the plan is defective.
pub fn interface_map(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    (name, instance): (&'static str, u32),
    mapped: &Mapped,
    viewpoint: &FrameViewpoint,
    layers: Layers,
) -> Result<InterfaceMap, GpuError> {
    let geometry = &mapped.geometry;
    let thickness = mapped.thickness.filter(|_| !matches!(layers, Layers::Nearest | Layers::All(_)));
    let shows_triangles = mapped.shows_triangles && layers != Layers::Nearest;
    let spec = ShaderSpec::new("refraction::interface_map")
        .feature("thickness", thickness.is_some())
        .feature("front_triangles", shows_triangles);
    let resolve = gpu.shader(&spec)?;
    let size = viewpoint.viewpoint.size;
    let count = texels(size);
    let mut pass = viewpoint
        .tell(ComputePass::new(name, instance), "viewpoint")
        .input("normals", geometry.normals)
        .scratch("seen", if layers == Layers::Nearest { 4 } else { 8 } * count)
        .cleared_output("front", 16 * count);
    if layers != Layers::Nearest {
        pass = pass.cleared_output("back", 16 * count);
    }
    if let Some(thickness) = thickness {
        pass = pass.input("thickness", thickness).cleared_output("thickness_map", 4 * count);
    }
    pass = over_listed_tiles(pass, size);
    let list = tile_threads(size);
    let mut pass =
        match layers {
            Layers::All(hierarchy) => list_layers(gpu, pass, mapped, size, hierarchy)?,
            Layers::Nearest => rasterise(gpu, pass, geometry, size, layers)?
                .dispatch(&resolve, "list_one", list)
                .dispatch(&resolve, "one_layer", LISTED_TILES),
            Layers::NearestBack | Layers::Behind(_) | Layers::FarthestBack { depth_range: false } => rasterise(
                gpu, pass, geometry, size, layers,
            )?
            .dispatch(&resolve, "list_two", list)
            .dispatch(&resolve, "two_layers", LISTED_TILES),
            Layers::FarthestBack { depth_range: true } => rasterise(gpu, pass, geometry, size, layers)?
                .cleared_output("depth_range", 8)
                .dispatch(&resolve, "list_two", list)
                .dispatch(&resolve, "two_layers", LISTED_TILES)
                .dispatch(&resolve, "reduce", Groups::tiles(size)),
        };
    if shows_triangles {
        pass = pass.cleared_output("front_triangles", 4 * count);
    }
    let mut outputs = pass.add_to(plan)?;
    let front_triangles = if shows_triangles { outputs.pop() } else { None };
    let back = outputs.get(1).copied();
    let more = outputs.get(2 + usize::from(thickness.is_some())).copied();
    Ok(InterfaceMap {
        front: outputs[0],
        back,
        depth_range: more.filter(|_| layers == Layers::FarthestBack { depth_range: true }),
        thickness: outputs.get(2).copied().filter(|_| thickness.is_some()),
        layer_lists: match outputs[1..] {
            [_, lists, layers, cores, ref hulls @ ..] => {
                Some(LayerLists { lists, layers, cores, hulls: hulls.first().copied() })
            }
            _ => None,
        },
        front_triangles,
        tree: mapped.tree,
        relief: mapped.relief,
        media: mapped.media,
        geometry: *geometry,
    })
}

/// Layers that there is room for, by texel on average; for each of several bodies that are mapped as one, up to so many.
const ROOM: u64 = 4;
const MOST_WITH_ROOM: u32 = 4;
/// The largest buffer that every adapter binds, bytes.
const LARGEST_BUFFER: u64 = 1 << 27;

fn list_layers(
    gpu: &Gpu,
    pass: ComputePass,
    mapped: &Mapped,
    size: [u32; 2],
    hierarchy: Hierarchy,
) -> Result<ComputePass, GpuError> {
    let geometry = &mapped.geometry;
    let spec = ShaderSpec::new("refraction::layer_lists").feature("front_triangles", mapped.shows_triangles);
    let shader = gpu.shader(&spec)?;
    let count = texels(size);
    let room = ROOM * mapped.media.map_or(1, |media| u64::from(media.bodies.min(MOST_WITH_ROOM)));
    let fragments = (room * count).min(LARGEST_BUFFER / 16);
    let pass = pass
        .value(
            "list_params",
            &ListParams { triangle_count: geometry.triangle_count as u32, capacity: fragments as u32 },
        )
        .cleared_output("lists", 8 * count)
        // Two a texel where there are too many.
        .cleared_output("layers", 12 * fragments.max(2 * count))
        .scratch("counts", 4 * count)
        .scratch("appended", 4)
        .scratch("large_triangle_count", 4)
        .workspace("large_triangles", 4 * geometry.triangle_count as u64)
        .workspace("fragments", 16 * fragments)
        .scratch("list_arguments", 48)
        .scratch("list_total", 8)
        .workspace("tile_sums", 4 * tiles(size))
        .dispatch(&shader, "small_fragments", over_triangles(geometry))
        .dispatch(&shader, "large_fragments", SHARED)
        .dispatch(&shader, "sum_tiles", tile_threads(size))
        .dispatch(&shader, "scan", Groups::Direct([1, 1, 1]));
    let [small, large] = [16, 32].map(|offset| Groups::Indirect("list_arguments", offset));
    let mut pass = rasterise_over(gpu, pass, geometry, size, Layers::NearestBack, [small, large])?
        .dispatch(&shader, "place", LISTED_TILES)
        .dispatch(&shader, "gather", Groups::Indirect("list_arguments", 0))
        .dispatch(&shader, "finish", LISTED_TILES);
    let hulls = hierarchy == Hierarchy::CoresAndHulls;
    let shader = gpu.shader(&ShaderSpec::new("refraction::cores").feature("hulls", hulls))?;
    pass = pass.cleared_output("cores", 16 * cells_of_cores(size));
    if hulls {
        pass = pass.cleared_output("hulls", 16 * cells_of_cores(size));
    }
    let above = |level: u32| Groups::tiles(size.map(|side| side.div_ceil(1 << level)));
    Ok(pass
        .dispatch(&shader, "tile_cores", LISTED_TILES)
        .dispatch(&shader, "raise_to_4", above(4))
        .dispatch(&shader, "raise_to_5", above(5))
        .dispatch(&shader, "raise_to_6", above(6)))
}

/// Cells of levels 1 to 6 (`refraction::core_layout`).
fn cells_of_cores(size: [u32; 2]) -> u64 {
    let padded = texels(size.map(|side| side.next_multiple_of(64)));
    (padded - (padded >> 12)) / 3
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, check_uniform_layout};

    use super::*;

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let shader = Shader::link(&ShaderSpec::new("refraction::visibility")).unwrap();
        check_uniform_layout!(shader, "Raster", Raster { triangle_count: 1, layers: 2, farthest_back: 3 }).unwrap();
    }
}

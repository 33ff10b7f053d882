//! Interface maps: what a viewpoint sees of a geometry, by compute rasterisation and exact per-texel intersection.

use encase::ShaderType;
use glam::DVec3;
use murano_animation::DeformedGeometry;
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, ShaderSpec, Work};
use murano_scheduler::{Output, Plan};

use crate::{LISTED_TILES, Viewpoint, over_listed_tiles, texels, tile_threads};

/// Which back faces an interface map keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layers {
    /// The nearest face of either side, in `front` alone: receivers and opaque things.
    Nearest,
    /// Nearest front face, nearest back face.
    NearestBack,
    /// Nearest front face, farthest back face, and the range of the back's depths.
    FarthestBack,
}

/// The surfaces a viewpoint sees: `vec4f` a texel, view-space normal and linear depth, all zero where there is nothing.
#[derive(Clone, Copy, Debug)]
pub struct InterfaceMap {
    /// Nearest front face (or nearest face).
    pub front: Output,
    /// Back face; `None` for [`Layers::Nearest`].
    pub back: Option<Output>,
    /// Smallest and largest depth of `back` as bits `[~smallest, largest]`; for [`Layers::FarthestBack`].
    pub depth_range: Option<Output>,
    /// Index of the triangle seen plus one, per layer and texel; 0 for none.
    pub seen: Output,
    /// What is mapped.
    pub geometry: DeformedGeometry,
}

#[derive(ShaderType)]
struct Raster {
    triangle_count: u32,
    layers: u32,
    farthest_back: u32,
}

/// Adds the dispatches that find each texel's triangle: they read `positions`, `triangles` and the uniform `viewpoint`
/// and fill the buffer `seen`, all by these names; `seen` must be a cleared output of the pass.
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
    let shader = gpu.shader(&ShaderSpec::new("refraction::visibility"))?;
    let count = if layers == Layers::Nearest { 1 } else { 2 };
    let each = Groups::linear(geometry.triangle_count, 64);
    // Enough workgroups to fill a large GPU; they share out what there is.
    let shared = Groups::Direct([64, 16, 1]);
    Ok(pass
        .value(
            "raster",
            &Raster {
                triangle_count: geometry.triangle_count as u32,
                layers: count,
                farthest_back: u32::from(layers == Layers::FarthestBack),
            },
        )
        .input("positions", geometry.positions)
        .input("triangles", geometry.triangles)
        .scratch("keys", 4 * u64::from(count) * texels(size))
        .scratch("large_count", 4)
        .scratch("large", 4 * geometry.triangle_count as u64)
        .scratch("kept", 4 * geometry.triangle_count as u64)
        .scratch("kept_arguments", 16)
        .dispatch(&shader, "small_depth", each)
        .dispatch(&shader, "large_depth", shared)
        .dispatch(&shader, "small_triangle", Groups::Indirect("kept_arguments", 0))
        .dispatch(&shader, "large_triangle", shared))
}

/// Adds the pass `name:instance` that maps a geometry from a viewpoint.
///
/// # Errors
/// [`GpuError`] if a shader or the plan is defective.
pub fn interface_map(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    (name, instance): (&'static str, u32),
    geometry: &DeformedGeometry,
    viewpoint: &Viewpoint,
    origin: DVec3,
    layers: Layers,
) -> Result<InterfaceMap, GpuError> {
    let resolve = gpu.shader(&ShaderSpec::new("refraction::interface_map"))?;
    let count = texels(viewpoint.size);
    let two = layers != Layers::Nearest;
    let pass = ComputePass::new(name, instance)
        .value("viewpoint", &viewpoint.uniform(origin))
        .input("normals", geometry.normals)
        .cleared_output("seen", if two { 8 } else { 4 } * count)
        .cleared_output("front", 16 * count);
    let mut pass = rasterise(gpu, pass, geometry, viewpoint.size, layers)?;
    pass = over_listed_tiles(pass, viewpoint.size);
    let list = tile_threads(viewpoint.size);
    if two {
        pass = pass.cleared_output("back", 16 * count).dispatch(&resolve, "list_two", list).dispatch(
            &resolve,
            "two_layers",
            LISTED_TILES,
        );
    } else {
        pass = pass.dispatch(&resolve, "list_one", list).dispatch(&resolve, "one_layer", LISTED_TILES);
    }
    if layers == Layers::FarthestBack {
        pass = pass.cleared_output("depth_range", 8).dispatch(&resolve, "reduce", Groups::tiles(viewpoint.size));
    }
    let outputs = pass.add_to(plan)?;
    Ok(InterfaceMap {
        seen: outputs[0],
        front: outputs[1],
        back: outputs.get(2).copied(),
        depth_range: outputs.get(3).copied(),
        geometry: *geometry,
    })
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

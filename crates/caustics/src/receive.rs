//! What a caster does to a lamp's light at the points that the eye sees.

use encase::ShaderType;
use glam::{DMat4, DVec4, Mat4, UVec4, Vec3, Vec4};
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, ShaderSpec, Work};
use murano_refraction::{Glass, Viewpoint, listed_tiles, over_tile_lists, texels, tile_threads};
use murano_scheduler::{Output, Plan};

use crate::{Cast, Caster, CausticMap, Surfaces, level_texels, photons::texels_before};

#[derive(ShaderType)]
struct Params {
    texel_from_eye: Mat4,
    caster_from_eye: Mat4,
    lamp: Vec4,
    texel_area: f32,
    fine_starts: UVec4,
    coarse_starts: UVec4,
    level_texels: u32,
    cell: u32,
    sample_width: f32,
}

#[derive(ShaderType)]
struct ShadeParams {
    cell: u32,
}

#[derive(ShaderType)]
struct Pane {
    absorption: Vec3,
    ior: f32,
    tint: Vec3,
}

/// Adds the pass `receive:instance`, or `receive_hidden:instance` for what the lamp does not see (there is no direct light to take away
/// there): `vec4f` a pixel of the eye, irradiance by caustics for a lamp of intensity 1 (RGB) and
/// the share of direct light that the caster takes away (w); without a caustic map the share of direct light, RGB, that neither passes the
/// caster nor comes straight through it: Fresnel's law at both interfaces, and absorption between them. Runs over the tiles where there may
/// be any of either, and is zero elsewhere. Glass has a pass `shade:instance` for its shadow. `sample_width` is the side of what a ray samples
/// of its pixel, pixels.
///
/// # Errors
/// [`GpuError`] if a shader or the plan is defective.
pub fn receive(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    cast: &Cast<'_>,
    eye: &Viewpoint,
    sample_width: f32,
    surfaces: Output,
    (caustic_map, on): (Option<&CausticMap>, Surfaces),
) -> Result<Output, GpuError> {
    let cell = (cast.viewpoint.viewpoint.size[0] / LEAST_CELLS).max(1);
    let shade = match (cast.caster, cast.map.back) {
        (Caster::Glass(glass), Some(back)) if on == Surfaces::Seen => {
            Some(shade(gpu, plan, cast, glass, back, caustic_map.is_some(), cell)?)
        }
        // What is opaque throws its shadow with everything else.
        _ => None,
    };
    let shader = |root, shades, dark| {
        let spec = ShaderSpec::new(root)
            .feature("shades", shades)
            .feature("dark", dark)
            .feature("caustic", caustic_map.is_some())
            .feature("monochrome", caustic_map.is_some_and(|map| map.monochrome));
        gpu.shader(&spec)
    };
    let from_eye = |viewpoint: &Viewpoint| viewpoint.world_from_view.inverse() * eye.world_from_view;
    let receivers = &cast.lamp.receivers;
    let to_lamp = if receivers.perspective { DVec4::W } else { DVec4::Z };
    let map_size = receivers.size;
    let starts: [u32; 8] = std::array::from_fn(|mip| texels_before(map_size, mip as u32) as u32);
    let params = Params {
        // What is not looked up does not matter.
        texel_from_eye: caustic_map
            .map_or(DMat4::ZERO, |_| receivers.texel_from_view() * from_eye(receivers))
            .as_mat4(),
        caster_from_eye: shade.map_or(DMat4::ZERO, |_| from_eye(&cast.viewpoint.viewpoint)).as_mat4(),
        lamp: caustic_map.map_or(DVec4::ZERO, |_| from_eye(receivers).inverse() * to_lamp).as_vec4(),
        texel_area: (4.0 * receivers.half_extent.x * receivers.half_extent.y / texels(map_size) as f64) as f32,
        fine_starts: UVec4::from_slice(&starts[..4]),
        coarse_starts: UVec4::from_slice(&starts[4..]),
        level_texels: level_texels(map_size) as u32,
        cell,
        sample_width,
    };
    let name = match on {
        Surfaces::Seen => "receive",
        Surfaces::Hidden => "receive_hidden",
    };
    let mut pass = ComputePass::new(name, cast.instance)
        .value("params", &params)
        .value("eye", &eye.uniform(cast.viewpoint.origin))
        .input("surfaces", surfaces)
        .cleared_output("received", 16 * texels(eye.size));
    if let Some(shade) = shade {
        pass = cast.viewpoint.tell(pass, "caster_viewpoint").input("shade", shade);
    }
    if let Some(caustic_map) = caustic_map {
        pass = cast
            .receivers()
            .tell(pass, "receiver_viewpoint")
            .input("caustic_map", caustic_map.flux)
            .input("detail", caustic_map.detail);
    }
    let list = shader("caustics::receive_tiles", shade.is_some(), false)?;
    pass = over_tile_lists(pass, eye.size, 3).dispatch(&list, "list", tile_threads(eye.size));
    // In the caster's shadow and its caustic, in one alone, in the other.
    let shades = shade.is_some();
    let lights = caustic_map.is_some();
    for (list, shades, dark) in [(0, true, false), (1, false, false), (2, true, true)]
        .into_iter()
        .filter(|&(_, wants_shade, dark)| (shades || !wants_shade) && (lights || (wants_shade && !dark)))
    {
        pass = pass.dispatch(&shader("caustics::receive", shades, dark)?, "main", listed_tiles(list));
    }
    Ok(pass.add_to(plan)?[0])
}

/// The most casters, or groups of them, that one pass gathers.
const GATHERED: usize = 4;

#[derive(ShaderType)]
struct GatherParams {
    pixels: u32,
}

/// What all casters of a lamp do to its light, from what each of them does ([`receive`]); `None` without casters. A tree of passes
/// `gather` (`gather_hidden`), numbered from `instance` on, so that where one of many casters changes most of them are reused.
///
/// # Errors
/// [`GpuError`] if a shader or the plan is defective.
pub fn gather(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    (on, mut instance): (Surfaces, u32),
    mut received: Vec<Output>,
    size: [u32; 2],
    with_caustics: bool,
) -> Result<Option<Output>, GpuError> {
    // More pixels than that fit no device.
    let params = GatherParams { pixels: u32::try_from(texels(size)).unwrap_or(u32::MAX) };
    while received.len() > 1 {
        let mut gathered = Vec::new();
        for group in received.chunks(GATHERED) {
            if let [alone] = group {
                gathered.push(*alone);
                continue;
            }
            let spec = ShaderSpec::new("caustics::gather")
                .feature("third", group.len() > 2)
                .feature("fourth", group.len() > 3)
                .feature("caustic", with_caustics);
            let name = match on {
                Surfaces::Seen => "gather",
                Surfaces::Hidden => "gather_hidden",
            };
            let mut pass =
                ComputePass::new(name, instance).value("params", &params).output("received", 16 * texels(size));
            for (name, output) in ["first", "second", "third", "fourth"].into_iter().zip(group) {
                pass = pass.input(name, *output);
            }
            let groups = Groups::linear(params.pixels as usize, 64);
            gathered.push(pass.dispatch(&gpu.shader(&spec)?, "main", groups).add_to(plan)?[0]);
            instance += 1;
        }
        received = gathered;
    }
    Ok(received.pop())
}

/// The least number of cells that a caster's map is divided into along a side.
const LEAST_CELLS: u32 = 320;

/// Adds the pass `shade:instance`: a `caustics::cell::Cell` for each cell of `cell` x `cell` texels of the caster's map, what of the
/// light comes past the caster, or without caustics straight through it, and the range of depths behind which that is so.
fn shade(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    cast: &Cast<'_>,
    glass: &Glass,
    back: Output,
    caustic: bool,
    cell: u32,
) -> Result<Output, GpuError> {
    let surface = cast.surface.filter(|_| !caustic);
    let spec = ShaderSpec::new("caustics::shade")
        .feature("thin", glass.thin)
        .feature("caustic", caustic)
        .feature("surface_map", surface.is_some());
    let cells = cast.viewpoint.viewpoint.size.map(|side| side.div_ceil(cell));
    let mut pass = cast
        .viewpoint
        .tell(ComputePass::new("shade", cast.instance), "caster_viewpoint")
        .value("params", &ShadeParams { cell })
        .input("front", cast.map.front)
        .output("shade", if caustic { 8 } else { 16 } * texels(cells));
    if glass.thin || !caustic {
        pass = pass.input("back", back);
    }
    if !caustic {
        let pane = Pane { absorption: glass.absorption.into(), ior: glass.ior as f32, tint: glass.tint.into() };
        pass = pass.value("pane", &pane);
    }
    if let Some(surface) = surface {
        pass = pass.input("glass_surface", surface);
    }
    Ok(pass.dispatch(&gpu.shader(&spec)?, "main", Groups::tiles(cells)).add_to(plan)?[0])
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, check_uniform_layout};

    use super::*;

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let shader = Shader::link(&ShaderSpec::new("caustics::receive").feature("shades", true)).unwrap();
        let matrix = |first: f32| Mat4::from_cols_array(&std::array::from_fn(|i| i as f32 + first));
        check_uniform_layout!(
            shader,
            "Params",
            Params {
                texel_from_eye: matrix(1.0),
                caster_from_eye: matrix(20.0),
                lamp: Vec4::new(40.0, 41.0, 42.0, 43.0),
                texel_area: 44.0,
                fine_starts: UVec4::new(1, 2, 3, 4),
                coarse_starts: UVec4::new(5, 6, 7, 8),
                level_texels: 9,
                cell: 10,
                sample_width: 0.5,
            }
        )
        .unwrap();
        let shader = Shader::link(&ShaderSpec::new("caustics::gather")).unwrap();
        check_uniform_layout!(shader, "Params", GatherParams { pixels: 1 }).unwrap();
        let shader = Shader::link(&ShaderSpec::new("caustics::shade")).unwrap();
        check_uniform_layout!(shader, "Params", ShadeParams { cell: 1 }).unwrap();
        check_uniform_layout!(
            shader,
            "Pane",
            Pane { absorption: Vec3::new(1.0, 2.0, 3.0), ior: 4.0, tint: Vec3::new(5.0, 6.0, 7.0) }
        )
        .unwrap();
    }
}

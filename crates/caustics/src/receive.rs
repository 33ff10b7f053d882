//! What a caster does to a lamp's light at the points that the eye sees.

use encase::ShaderType;
use glam::{Mat4, UVec4, Vec3};
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, ShaderSpec, Work};
use murano_refraction::{Glass, Viewpoint, texels};
use murano_scheduler::{Output, Plan};

use crate::{Cast, Caster, CausticMap, level_texels, photons::texels_before};

#[derive(ShaderType)]
struct Params {
    receivers_from_eye: Mat4,
    caster_from_eye: Mat4,
    mip_starts: [UVec4; 2],
    level_texels: u32,
}

#[derive(ShaderType)]
struct Pane {
    absorption: Vec3,
    ior: f32,
    tint: Vec3,
}

/// Adds the pass `receive:instance`: `vec4f` a pixel of the eye, irradiance by caustics for a lamp of intensity 1 (RGB) and
/// the share of direct light that passes the caster (w); without a caustic map the share of direct light, RGB, that passes the
/// caster or comes straight through it: Fresnel's law at both interfaces, and absorption between them. Sheets, and shadows without caustics, have a pass `shade:instance` of their own.
///
/// # Errors
/// [`GpuError`] if a shader or the plan is defective.
pub fn receive(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    cast: &Cast<'_>,
    eye: &Viewpoint,
    surfaces: Output,
    caustic_map: Option<&CausticMap>,
) -> Result<Output, GpuError> {
    // What is opaque throws its shadow with everything else.
    let glass = match cast.caster {
        Caster::Glass(glass) => Some(glass),
        Caster::Mirror(_) => None,
    };
    let caster = match (glass, cast.map.back) {
        // A sheet throws a shadow from either side.
        (Some(glass), Some(back)) if glass.thin || caustic_map.is_none() => Some(shade(gpu, plan, cast, glass, back)?),
        (Some(_), _) => Some(cast.map.front),
        (None, _) => None,
    };
    let spec = ShaderSpec::new("caustics::receive")
        .feature("shades", caster.is_some())
        .feature("caustic", caustic_map.is_some());
    let shader = gpu.shader(&spec)?;
    let from_eye = |viewpoint: &Viewpoint| (viewpoint.world_from_view.inverse() * eye.world_from_view).as_mat4();
    let map_size = cast.lamp.receivers.size;
    let starts: [u32; 8] = std::array::from_fn(|mip| texels_before(map_size, mip as u32) as u32);
    let params = Params {
        // What is not looked up does not matter.
        receivers_from_eye: caustic_map.map_or(Mat4::ZERO, |_| from_eye(&cast.lamp.receivers)),
        caster_from_eye: caster.map_or(Mat4::ZERO, |_| from_eye(cast.viewpoint)),
        mip_starts: [0, 4].map(|first| UVec4::from_slice(&starts[first..first + 4])),
        level_texels: level_texels(map_size) as u32,
    };
    let mut pass = ComputePass::new("receive", cast.instance)
        .value("params", &params)
        .value("eye", &eye.uniform(cast.origin))
        .input("surfaces", surfaces)
        .output("received", 16 * texels(eye.size));
    if let Some(caster) = caster {
        pass = pass.value("caster_viewpoint", &cast.viewpoint.uniform(cast.origin)).input("caster", caster);
    }
    if let Some(caustic_map) = caustic_map {
        pass = pass
            .value("receiver_viewpoint", &cast.lamp.receivers.uniform(cast.origin))
            .input("caustic_map", caustic_map.flux)
            .input("detail", caustic_map.detail);
    }
    Ok(pass.dispatch(&shader, "main", Groups::tiles(eye.size)).add_to(plan)?[0])
}

/// The most casters, or groups of them, that one pass gathers.
const GATHERED: usize = 4;

#[derive(ShaderType)]
struct GatherParams {
    pixels: u32,
}

/// What all casters of a lamp do to its light, from what each of them does ([`receive`]); `None` without casters. A tree of passes
/// `gather`, numbered from `instance` on, so that where one of many casters changes most of them are reused.
///
/// # Errors
/// [`GpuError`] if a shader or the plan is defective.
pub fn gather(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    mut instance: u32,
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
            let mut pass =
                ComputePass::new("gather", instance).value("params", &params).output("received", 16 * texels(size));
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

/// Adds the pass `shade:instance`: `vec4f` a texel of the caster's map, what of the light comes straight through, RGB, and the depth of the
/// nearest face.
fn shade(gpu: &Gpu, plan: &mut Plan<Work>, cast: &Cast<'_>, glass: &Glass, back: Output) -> Result<Output, GpuError> {
    let spec =
        ShaderSpec::new("caustics::shade").feature("thin", glass.thin).feature("surface_map", cast.surface.is_some());
    let pane = Pane { absorption: glass.absorption.into(), ior: glass.ior as f32, tint: glass.tint.into() };
    let size = cast.viewpoint.size;
    let mut pass = ComputePass::new("shade", cast.instance)
        .value("pane", &pane)
        .value("caster_viewpoint", &cast.viewpoint.uniform(cast.origin))
        .input("front", cast.map.front)
        .input("back", back)
        .output("shade", 16 * texels(size));
    if let Some(surface) = cast.surface {
        pass = pass.input("glass_surface", surface);
    }
    Ok(pass.dispatch(&gpu.shader(&spec)?, "main", Groups::tiles(size)).add_to(plan)?[0])
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
                receivers_from_eye: matrix(1.0),
                caster_from_eye: matrix(20.0),
                mip_starts: [UVec4::new(1, 2, 3, 4), UVec4::new(5, 6, 7, 8)],
                level_texels: 9,
            }
        )
        .unwrap();
        let shader = Shader::link(&ShaderSpec::new("caustics::gather")).unwrap();
        check_uniform_layout!(shader, "Params", GatherParams { pixels: 1 }).unwrap();
        let shader = Shader::link(&ShaderSpec::new("caustics::shade")).unwrap();
        check_uniform_layout!(
            shader,
            "Pane",
            Pane { absorption: Vec3::new(1.0, 2.0, 3.0), ior: 4.0, tint: Vec3::new(5.0, 6.0, 7.0) }
        )
        .unwrap();
    }
}

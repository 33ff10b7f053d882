//! What a caster does to a lamp's light at the points that the eye sees.

use encase::ShaderType;
use glam::Mat4;
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, ShaderSpec, Work};
use murano_refraction::{Viewpoint, texels};
use murano_scheduler::{Output, Plan};

use crate::{Cast, CausticMap};

#[derive(ShaderType)]
struct Params {
    render_from_eye: Mat4,
}

/// Adds the pass `receive:instance`: `vec4f` a pixel of the eye, irradiance by caustics for a lamp of intensity 1 (RGB) and
/// the share of direct light that passes all casters so far (w). `before` is the pass of the lamp's previous caster.
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
    before: Option<Output>,
) -> Result<Output, GpuError> {
    let back = cast.map.back.filter(|_| cast.glass.thin);
    let spec = ShaderSpec::new("caustics::receive")
        .feature("thin", back.is_some())
        .feature("chained", before.is_some())
        .feature("caustic", caustic_map.is_some());
    let shader = gpu.shader(&spec)?;
    let params = Params { render_from_eye: eye.view_from_render(cast.origin).inverse().as_mat4() };
    let mut pass = ComputePass::new("receive", cast.instance)
        .value("params", &params)
        .value("eye", &eye.uniform(cast.origin))
        .value("receiver_viewpoint", &cast.lamp.receivers.uniform(cast.origin))
        .value("caster_viewpoint", &cast.viewpoint.uniform(cast.origin))
        .input("surfaces", surfaces)
        .input("caster", cast.map.front)
        .output("received", 16 * texels(eye.size));
    if let Some(back) = back {
        pass = pass.input("caster_back", back);
    }
    if let Some(before) = before {
        pass = pass.input("received_before", before);
    }
    if let Some(caustic_map) = caustic_map {
        pass = pass.input("caustic_map", caustic_map.flux).input("detail", caustic_map.detail);
    }
    Ok(pass.dispatch(&shader, "main", Groups::tiles(eye.size)).add_to(plan)?[0])
}

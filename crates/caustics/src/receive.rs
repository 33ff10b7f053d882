//! What a caster does to a lamp's light at the points that the eye sees.

use encase::ShaderType;
use glam::{Mat4, Vec3};
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, ShaderSpec, Work};
use murano_refraction::{Viewpoint, texels};
use murano_scheduler::{Output, Plan};

use crate::{Cast, Caster, CausticMap};

#[derive(ShaderType)]
struct Params {
    render_from_eye: Mat4,
}

#[derive(ShaderType)]
struct Pane {
    absorption: Vec3,
    ior: f32,
    tint: Vec3,
}

/// Adds the pass `receive:instance`: `vec4f` a pixel of the eye, irradiance by caustics for a lamp of intensity 1 (RGB) and
/// the share of direct light that passes all casters so far (w); without a caustic map the share of direct light, RGB, that passes all
/// casters or comes straight through them: Fresnel's law at both interfaces, and absorption between them. `before` is the pass of the lamp's previous caster.
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
    // What is opaque throws its shadow with everything else.
    let glass = match cast.caster {
        Caster::Glass(glass) => Some(glass),
        Caster::Mirror(_) => None,
    };
    let thin = glass.is_some_and(|glass| glass.thin);
    let pane = glass.filter(|_| caustic_map.is_none());
    let back = cast.map.back.filter(|_| thin || pane.is_some());
    let spec = ShaderSpec::new("caustics::receive")
        .feature("shades", glass.is_some())
        .feature("thin", thin)
        .feature("chained", before.is_some())
        .feature("caustic", caustic_map.is_some());
    let shader = gpu.shader(&spec)?;
    let params = Params { render_from_eye: eye.view_from_render(cast.origin).inverse().as_mat4() };
    let mut pass = ComputePass::new("receive", cast.instance)
        .value("params", &params)
        .value("eye", &eye.uniform(cast.origin))
        .value("receiver_viewpoint", &cast.lamp.receivers.uniform(cast.origin))
        .input("surfaces", surfaces)
        .output("received", 16 * texels(eye.size));
    if glass.is_some() {
        pass = pass.value("caster_viewpoint", &cast.viewpoint.uniform(cast.origin)).input("caster", cast.map.front);
    }
    if let Some(glass) = pane {
        let pane = Pane { absorption: glass.absorption.into(), ior: glass.ior as f32, tint: glass.tint.into() };
        pass = pass.value("pane", &pane);
    }
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

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, check_uniform_layout};

    use super::*;

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let shader = Shader::link(&ShaderSpec::new("caustics::receive").feature("shades", true)).unwrap();
        check_uniform_layout!(
            shader,
            "Pane",
            Pane { absorption: Vec3::new(1.0, 2.0, 3.0), ior: 4.0, tint: Vec3::new(5.0, 6.0, 7.0) }
        )
        .unwrap();
    }
}

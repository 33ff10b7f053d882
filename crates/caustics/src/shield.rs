//! Casters in each other's light.

use murano_gpu::{ComputePass, Gpu, GpuError, Groups, ShaderSpec, Work};
use murano_refraction::{FrameViewpoint, InterfaceMap, texels};
use murano_scheduler::{Output, Plan};

/// A caster as a lamp sees it.
#[derive(Clone, Copy)]
pub struct SeenCaster<'a> {
    /// The lamp's view of it.
    pub viewpoint: &'a FrameViewpoint,
    /// Its map from there.
    pub map: &'a InterfaceMap,
    /// Whether it is a sheet of glass around nothing.
    pub thin: bool,
}

impl SeenCaster<'_> {
    /// Back faces where light may meet them first.
    fn back(&self) -> Option<Output> {
        self.map.back.filter(|_| self.thin)
    }
}

/// Adds the pass `shield:instance`: what another caster leaves of a lamp's light on this one, besides those `before` it (what this gave
/// for them). `u32` a texel of the caster's map: 1 where the other one is met first, and passes the light on; 2, of a sheet that gives way, where
/// the other one stands behind it, so that light which goes straight through is the other one's; else 0.
///
/// # Errors
/// [`GpuError`] if the shader or the plan is defective.
pub fn shield(
    gpu: &Gpu,
    plan: &mut Plan<Work>,
    instance: u32,
    caster: SeenCaster<'_>,
    other: SeenCaster<'_>,
    (gives_way, before): (bool, Option<Output>),
) -> Result<Output, GpuError> {
    let spec = ShaderSpec::new("caustics::shield")
        .feature("thin", caster.back().is_some())
        .feature("other_thin", other.back().is_some())
        .feature("gives_way", gives_way && caster.thin)
        .feature("has_before", before.is_some());
    let shader = gpu.shader(&spec)?;
    let size = caster.viewpoint.viewpoint.size;
    let pass = caster.viewpoint.tell(ComputePass::new("shield", instance), "caster_viewpoint");
    let mut pass = other
        .viewpoint
        .tell(pass, "other_viewpoint")
        .input("front", caster.map.front)
        .input("other_front", other.map.front)
        .output("shielded", 4 * texels(size));
    if let Some(back) = caster.back() {
        pass = pass.input("back", back);
    }
    if let Some(back) = other.back() {
        pass = pass.input("other_back", back);
    }
    if let Some(before) = before {
        pass = pass.input("shielded_before", before);
    }
    Ok(pass.dispatch(&shader, "main", Groups::tiles(size)).add_to(plan)?[0])
}

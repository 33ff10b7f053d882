//! Motion vectors: where everything was in the frame before, for the layer `motion` alone.

use encase::ShaderType;
use glam::{DVec3, Mat4};
use murano_animation::{DeformedGeometry, Pose};
use murano_gpu::{ComputePass, GpuError, Groups, ShaderSpec, Work};
use murano_refraction::{Layers, Viewpoint, rasterise, texels};
use murano_scheduler::{Output, Plan};

use crate::frame::{FramePlan, eye};
use crate::request::Moment;

#[derive(ShaderType)]
struct MotionParams {
    previous_from_view: Mat4,
    surroundings: u32,
}

impl FramePlan<'_> {
    /// Adds a pass `motion:k` for the opaque scene (0) and every glass body in the picture, each with the deform pass of what it was,
    /// which the frame before has usually left.
    pub(crate) fn motion(
        &self,
        plan: &mut Plan<Work>,
        (moment, before): (&Moment, &Pose),
        deformed: &[(u32, DeformedGeometry)],
        origin: DVec3,
    ) -> Result<Vec<Output>, GpuError> {
        let previous = eye(&moment.view, self.eye.size);
        let mut motions = Vec::new();
        for (instance, geometry) in deformed {
            let sorted = self.stock.sorted;
            let (shape, leaves) = match instance.checked_sub(1).and_then(|body| sorted.bodies.get(body as usize)) {
                Some(body) => (&body.geometry, &body.leaves),
                None => (&sorted.opaque.geometry, &sorted.opaque.leaves),
            };
            let earlier = leaves.deform_as_before(self.stock.gpu, plan, *instance, shape, before, origin)?;
            motions.push(self.motion_of(plan, *instance, geometry, &earlier, &previous)?);
        }
        Ok(motions)
    }

    fn motion_of(
        &self,
        plan: &mut Plan<Work>,
        instance: u32,
        geometry: &DeformedGeometry,
        earlier: &DeformedGeometry,
        previous: &Viewpoint,
    ) -> Result<Output, GpuError> {
        let gpu = self.stock.gpu;
        let shader = gpu.shader(&ShaderSpec::new("render::motion"))?;
        let count = texels(self.eye.size);
        let params = MotionParams {
            previous_from_view: (previous.world_from_view.inverse() * self.eye.world_from_view).as_mat4(),
            surroundings: u32::from(instance == 0),
        };
        let pass = ComputePass::new("motion", instance)
            .value("params", &params)
            .value("viewpoint", &self.eye.uniform(self.origin))
            .value("previous_viewpoint", &previous.uniform(self.origin))
            .input("previous_positions", earlier.positions)
            .scratch("seen", 4 * count)
            .output("motion", 16 * count);
        let pass = rasterise(gpu, pass, geometry, self.eye.size, Layers::Nearest)?;
        Ok(pass.dispatch(&shader, "main", Groups::tiles(self.eye.size)).add_to(plan)?[0])
    }
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, check_uniform_layout};

    use super::*;

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let matrix = Mat4::from_cols_array(&std::array::from_fn(|i| i as f32 + 100.0));
        let motion = Shader::link(&ShaderSpec::new("render::motion")).unwrap();
        check_uniform_layout!(motion, "Params", MotionParams { previous_from_view: matrix, surroundings: 1 }).unwrap();
    }
}

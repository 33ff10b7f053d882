//! Viewpoints: the eye or a lamp, looking at the world through a grid of texels.

use encase::ShaderType;
use glam::{DMat4, DVec2, DVec3, DVec4, Mat4, UVec2, Vec2};
use murano_animation::{Bounds, DeformedGeometry};
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, ShaderSpec, Work};
use murano_scheduler::{Output, Plan};

/// A camera or lamp that sees the world through a grid of texels; looks along its -Z with +Y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// Rigid.
    pub world_from_view: DMat4,
    /// Whether rays meet in a point; else they are parallel.
    pub perspective: bool,
    /// Half of the picture's extent on the image plane: at depth 1 (perspective), or in metres.
    pub half_extent: DVec2,
    /// Where the picture's centre lies on the image plane, same unit.
    pub center: DVec2,
    /// Texels across and down.
    pub size: [u32; 2],
    /// Nearest depth seen, metres, positive.
    pub near: f64,
}

/// [`Viewpoint`] as shaders see it (`lib::viewpoint::Viewpoint`).
#[derive(Clone, Copy, Debug, ShaderType)]
pub struct ViewpointUniform {
    view_from_render: Mat4,
    half_extent: Vec2,
    center: Vec2,
    size: UVec2,
    perspective: f32,
    near: f32,
}

/// A viewpoint in a frame, as its passes are told of it.
#[derive(Clone, Copy, Debug)]
pub struct FrameViewpoint {
    /// What it sees at most.
    pub viewpoint: Viewpoint,
    /// Origin of render space.
    pub origin: DVec3,
    /// The uniform whose picture is drawn in, where the GPU alone knows it ([`FrameViewpoint::fitted`]).
    pub drawn_in: Option<Output>,
}

#[derive(ShaderType)]
struct FitParams {
    vertex_count: u32,
    rim: f32,
}

/// Texels between a fitted picture's border and what it holds.
const RIM: f32 = 0.5;

impl FrameViewpoint {
    /// Tells a pass, which reads `lib::viewpoint::Viewpoint` by this name.
    #[must_use]
    pub fn tell(&self, pass: ComputePass, name: &'static str) -> ComputePass {
        match self.drawn_in {
            Some(uniform) => pass.input(name, uniform),
            None => pass.value(name, &self.viewpoint.uniform(self.origin)),
        }
    }

    /// Draws the picture in around the vertices of a geometry that it holds: adds the pass `fit:instance`. Bounds of a posed body are
    /// boxes, of which a lamp sees the body in a quarter to a half.
    ///
    /// # Errors
    /// [`GpuError`] if the shader or the plan is defective.
    pub fn fitted(
        self,
        gpu: &Gpu,
        plan: &mut Plan<Work>,
        instance: u32,
        geometry: &DeformedGeometry,
    ) -> Result<Self, GpuError> {
        let shader = gpu.shader(&ShaderSpec::new("refraction::fit"))?;
        let params = FitParams { vertex_count: geometry.vertex_count as u32, rim: RIM };
        let pass = ComputePass::new("fit", instance)
            .value("params", &params)
            .value("viewpoint", &self.viewpoint.uniform(self.origin))
            .input("positions", geometry.positions)
            .scratch("extent", 16)
            .output("fitted", ViewpointUniform::min_size().get());
        let outputs = pass
            .dispatch(&shader, "measure", Groups::linear(geometry.vertex_count, 256))
            .dispatch(&shader, "draw_in", Groups::Direct([1; 3]))
            .add_to(plan)?;
        Ok(Self { drawn_in: Some(outputs[0]), ..self })
    }
}

impl Viewpoint {
    /// The same, but with rays through another point of each texel than its middle, 0 to 1 along each side from its upper left corner.
    #[must_use]
    pub fn through(self, point: DVec2) -> Self {
        let [width, height] = self.size.map(f64::from);
        let texel = 2.0 * self.half_extent / DVec2::new(width, -height);
        Self { center: self.center + texel * (point - 0.5), ..self }
    }

    /// In a frame with this origin.
    pub fn in_frame(self, origin: DVec3) -> FrameViewpoint {
        FrameViewpoint { viewpoint: self, origin, drawn_in: None }
    }

    /// `view_from_render`, where render space is the world moved by `-origin`.
    pub fn view_from_render(&self, origin: DVec3) -> DMat4 {
        self.world_from_view.inverse() * DMat4::from_translation(origin)
    }

    /// Texel coordinates (`lib::viewpoint`) of a point in view space: x and y, to be divided by w, which is the depth or 1.
    pub fn texel_from_view(&self) -> DMat4 {
        let [width, height] = self.size.map(|side| 0.5 * f64::from(side));
        let DVec2 { x: across, y: up } = self.half_extent;
        let depth = if self.perspective { DVec4::NEG_Z } else { DVec4::W };
        let x = DVec4::X / across + depth * (1.0 - self.center.x / across);
        let y = DVec4::NEG_Y / up + depth * (1.0 + self.center.y / up);
        DMat4::from_cols(width * x, height * y, DVec4::ZERO, depth).transpose()
    }

    /// The uniform of this viewpoint for a frame with this origin.
    pub fn uniform(&self, origin: DVec3) -> ViewpointUniform {
        ViewpointUniform {
            view_from_render: self.view_from_render(origin).as_mat4(),
            half_extent: self.half_extent.as_vec2(),
            center: self.center.as_vec2(),
            size: UVec2::from_array(self.size),
            perspective: f32::from(u8::from(self.perspective)),
            near: self.near as f32,
        }
    }

    /// Whether any part of a box may be seen (never false for a box that is).
    pub fn sees(&self, bounds: &Bounds) -> bool {
        if bounds.is_empty() {
            return false;
        }
        let view_from_world = self.world_from_view.inverse();
        let mut outside = [true; 5];
        for corner in corners(bounds) {
            let p = view_from_world.transform_point3(corner);
            let depth = -p.z;
            let scale = if self.perspective { depth } else { 1.0 };
            let low = (self.center - self.half_extent) * scale;
            let high = (self.center + self.half_extent) * scale;
            let here = [depth < self.near, p.x < low.x, p.x > high.x, p.y < low.y, p.y > high.y];
            for (all, one) in outside.iter_mut().zip(here) {
                *all &= one;
            }
        }
        !outside.contains(&true)
    }

    /// Whether a ray of this viewpoint may begin (on the near plane) in the ball around a box; never false if one does.
    pub fn begins_within(&self, bounds: &Bounds) -> bool {
        let ball = self.sphere(bounds);
        let to_corner = (self.center.abs() + self.half_extent).length();
        let sideways = if self.perspective { self.near * to_corner } else { to_corner };
        !bounds.is_empty() && ball.truncate().length() <= ball.w + self.near + sideways
    }

    /// The smallest centred or off-centre picture that holds a box, with a margin; `None` if part of the box lies behind
    /// the near plane, where no picture could.
    pub fn fitted(&self, bounds: &Bounds, margin: f64) -> Option<Self> {
        let view_from_world = self.world_from_view.inverse();
        let mut low = DVec2::INFINITY;
        let mut high = DVec2::NEG_INFINITY;
        for corner in corners(bounds) {
            let p = view_from_world.transform_point3(corner);
            if -p.z <= self.near {
                return None;
            }
            let plane = if self.perspective { p.truncate() / -p.z } else { p.truncate() };
            low = low.min(plane);
            high = high.max(plane);
        }
        let half = (0.5 * (high - low)).max(DVec2::splat(1e-9)) * margin;
        Some(Self { half_extent: half, center: 0.5 * (low + high), ..*self })
    }

    /// What of the picture lies within a rectangle of the image plane, lowest and highest; `None` if nothing does.
    pub fn cut(&self, [low, high]: [DVec2; 2]) -> Option<Self> {
        let low = low.max(self.center - self.half_extent);
        let high = high.min(self.center + self.half_extent);
        low.cmplt(high).all().then(|| Self { half_extent: 0.5 * (high - low), center: 0.5 * (low + high), ..*self })
    }

    /// Sphere around a box, in this viewpoint's view space: centre, radius.
    pub fn sphere(&self, bounds: &Bounds) -> DVec4 {
        let center = self.world_from_view.inverse().transform_point3(bounds.center());
        center.extend(0.5 * bounds.diameter() * 1.0001)
    }
}

fn corners(bounds: &Bounds) -> impl Iterator<Item = DVec3> {
    let (low, high) = (bounds.min, bounds.max);
    (0..8).map(move |i| {
        DVec3::new(
            if i & 1 == 0 { low.x } else { high.x },
            if i & 2 == 0 { low.y } else { high.y },
            if i & 4 == 0 { low.z } else { high.z },
        )
    })
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, check_uniform_layout};

    use super::*;

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let fit = Shader::link(&ShaderSpec::new("refraction::fit")).unwrap();
        check_uniform_layout!(fit, "Params", FitParams { vertex_count: 1, rim: 2.0 }).unwrap();
        let shader = Shader::link(&ShaderSpec::new("refraction::interface_map")).unwrap();
        check_uniform_layout!(
            shader,
            "Viewpoint",
            ViewpointUniform {
                view_from_render: Mat4::from_cols_array(&std::array::from_fn(|i| i as f32 + 100.0)),
                half_extent: Vec2::new(1.0, 2.0),
                center: Vec2::new(3.0, 4.0),
                size: UVec2::new(5, 6),
                perspective: 7.0,
                near: 8.0,
            }
        )
        .unwrap();
    }
}

//! Viewpoints: the eye or a lamp, looking at the world through a grid of texels.

use encase::ShaderType;
use glam::{DMat4, DVec2, DVec3, DVec4, Mat4, UVec2, Vec2};
use murano_animation::Bounds;

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

impl Viewpoint {
    /// `view_from_render`, where render space is the world moved by `-origin`.
    pub fn view_from_render(&self, origin: DVec3) -> DMat4 {
        self.world_from_view.inverse() * DMat4::from_translation(origin)
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
    use murano_gpu::{Shader, ShaderSpec, check_uniform_layout};

    use super::*;

    #[test]
    fn shader_and_rust_agree_on_layouts() {
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

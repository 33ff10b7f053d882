//! The eye: one ray through each pixel.

use glam::{DMat4, DVec3};
use murano_scene::{Projection, look_along};

use crate::Ray;

/// A pinhole or parallel camera over a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Rigid; the camera looks along its -Z with +Y up.
    pub world_from_view: DMat4,
    /// Projection.
    pub projection: Projection,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

impl Camera {
    /// A perspective camera at `eye` that looks at `target` with +Y up; `yfov` in radians.
    pub fn look_at(eye: DVec3, target: DVec3, yfov: f64, size: [u32; 2]) -> Self {
        Self { world_from_view: look_along(eye, target - eye), projection: Projection::Perspective { yfov }, size }
    }

    /// The ray through a point of the picture in pixels from its upper left corner; pixel centres are at half-integers.
    /// Parallel cameras start on the eye's plane.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let [width, height] = self.size.map(f64::from);
        let right = (2.0 * x - width) / height;
        let up = (height - 2.0 * y) / height;
        let (origin, direction) = match self.projection {
            Projection::Perspective { yfov } => {
                let half = (0.5 * yfov).tan();
                (DVec3::ZERO, DVec3::new(right * half, up * half, -1.0))
            }
            Projection::Orthographic { half_height } => {
                (DVec3::new(right * half_height, up * half_height, 0.0), DVec3::NEG_Z)
            }
        };
        Ray {
            origin: self.world_from_view.transform_point3(origin),
            direction: self.world_from_view.transform_vector3(direction).normalize(),
        }
    }

    /// The ray through the centre of pixel `index`, counted row by row from the upper left.
    pub fn pixel_ray(&self, index: usize) -> Ray {
        let width = self.size[0] as usize;
        self.ray((index % width) as f64 + 0.5, (index / width) as f64 + 0.5)
    }

    /// Pixels of the picture.
    pub fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }
}

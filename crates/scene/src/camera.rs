//! Cameras.

use glam::{DMat4, DVec3};

/// How a camera maps view space to the picture. Distances in metres, angles in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Pinhole with a vertical field of view.
    Perspective {
        /// Full vertical angle.
        yfov: f64,
    },
    /// Parallel projection with a vertical half-extent.
    Orthographic {
        /// Half of the height seen, metres.
        half_height: f64,
    },
}

/// A camera; its node's transform places it, looking down -Z with +Y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name in the file, or empty.
    pub name: String,
    /// Projection; the aspect ratio is the picture's.
    pub projection: Projection,
    /// Nearest distance shown.
    pub znear: f64,
}

/// `world_from_view` of something at `eye` that looks along `direction` (any length; -Z if zero), +Y up, or +Z where it
/// looks almost straight up or down.
pub fn look_along(eye: DVec3, direction: DVec3) -> DMat4 {
    let back = -direction.normalize_or(DVec3::NEG_Z);
    let up = if back.y.abs() > 0.9999 { DVec3::Z } else { DVec3::Y };
    let right = up.cross(back).normalize();
    DMat4::from_cols(right.extend(0.0), back.cross(right).extend(0.0), back.extend(0.0), eye.extend(1.0))
}

//! Bodies of air-surrounded glass whose refraction and caustics are known in closed form.
//!
//! They are written from their own geometry (angles, chords, foci), not as calls to the search that they judge.

mod ball_lens;
mod ellipsoid;
mod prism;
mod slab;
mod sphere;
mod thick_lens;

use glam::DVec3;

pub use ball_lens::BallLens;
pub use ellipsoid::Ellipsoid;
pub use prism::Prism;
pub use slab::Slab;
pub use sphere::Sphere;
pub use thick_lens::ThickLens;

use crate::Refracted;

/// A ray that went through two interfaces of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// Where it enters.
    pub entry: DVec3,
    /// Outward unit normal there.
    pub entry_normal: DVec3,
    /// Unit direction inside the body (T1).
    pub inside: DVec3,
    /// Where it meets the surface again (P2).
    pub exit: DVec3,
    /// Outward unit normal there.
    pub exit_normal: DVec3,
    /// What becomes of it there: the direction that leaves (T2), or total reflection back into the body.
    pub leaving: Refracted,
}

impl Passage {
    /// Distance travelled inside, metres.
    pub fn path_length(&self) -> f64 {
        self.entry.distance(self.exit)
    }
}

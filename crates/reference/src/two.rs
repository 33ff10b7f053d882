//! The two-interface path.

use glam::DVec3;
use murano_optics::snell;
use rayon::prelude::*;

use crate::{Camera, Departure, Facing, Ray, World};

/// What became of a two-interface path, numbered as the `status` layer of an exported frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// No glass, or something opaque in front of it.
    #[default]
    NoGlass = 0,
    /// The light left through the second interface.
    Left = 1,
    /// It is totally reflected there (for [`crate::all_interfaces`]: still inside at the last bounce).
    TotallyReflected = 2,
    /// Nothing lies ahead inside the body: an open mesh.
    NoExit = 3,
}

/// A path from the eye through the first front face it meets and out of the next back face of the same body. World space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TwoInterfaces {
    /// What became of it; the fields below it are zero where it did not come so far.
    pub status: Status,
    /// Body met, an index into [`World::bodies`].
    pub body: usize,
    /// First interface: point, metres.
    pub p1: DVec3,
    /// Its interpolated normal, unit, outward.
    pub n1: DVec3,
    /// Direction inside, unit (outside, where the first interface reflects totally: light inside denser matter).
    pub t1: DVec3,
    /// Second interface: point, metres.
    pub p2: DVec3,
    /// Its interpolated normal, unit, outward.
    pub n2: DVec3,
    /// Direction after the second interface, unit; zero unless the light left.
    pub exit: DVec3,
    /// From `p1` to `p2`, metres.
    pub path_length: f64,
}

/// Follows one ray.
pub fn trace_two(world: &World, ray: &Ray) -> TwoInterfaces {
    let Some(first) = world.first_glass(ray) else { return TwoInterfaces::default() };
    let body = &world.bodies[first.body];
    if body.thin {
        // Straight on through the sheet.
        return TwoInterfaces {
            status: Status::Left,
            body: first.body,
            p1: first.hit.position,
            n1: first.hit.normal,
            t1: ray.direction,
            p2: first.hit.position,
            n2: -first.hit.normal,
            exit: ray.direction,
            path_length: 0.0,
        };
    }
    let into = snell(ray.direction, first.hit.normal_against(ray.direction), body.ior.recip());
    let mut path = TwoInterfaces {
        status: Status::TotallyReflected,
        body: first.body,
        p1: first.hit.position,
        n1: first.hit.normal,
        t1: into.direction,
        ..TwoInterfaces::default()
    };
    if into.tir {
        return path;
    }
    let inside = Ray { origin: path.p1, direction: path.t1 };
    let from = Departure::Element(first.hit.element);
    let Some(second) = body.nearest(&inside, from, Some(Facing::Back), f64::INFINITY) else {
        return TwoInterfaces { status: Status::NoExit, ..path };
    };
    path.p2 = second.position;
    path.n2 = second.normal;
    path.path_length = second.t;
    let out = snell(path.t1, second.normal_against(path.t1), body.ior);
    if !out.tir {
        path.status = Status::Left;
        path.exit = out.direction;
    }
    path
}

/// The two-interface path through the centre of every pixel, row by row from the upper left: first front face, refract,
/// first exit, refract. Total reflection at the second interface is said, not followed.
pub fn two_interfaces(world: &World, camera: &Camera) -> Vec<TwoInterfaces> {
    (0..camera.pixels()).into_par_iter().map(|pixel| trace_two(world, &camera.pixel_ray(pixel))).collect()
}

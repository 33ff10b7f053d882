//! Every interface that the refracted light meets.

use glam::DVec3;
use murano_optics::snell;
use rayon::prelude::*;

use crate::{Camera, Departure, Ray, Status, Within, World};

/// Light refracted through all interfaces ahead of it: total reflection is followed, and so is what enters a body again.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Chain {
    /// [`Status::TotallyReflected`] stands for a chain still inside the glass after the last bounce.
    pub status: Status,
    /// Where it left the glass for the last time, or was at the last bounce, metres; zero where no surface lay ahead inside.
    pub origin: DVec3,
    /// Its direction from there, unit; zero where no surface lay ahead inside.
    pub exit: DVec3,
    /// Interfaces met.
    pub bounces: u32,
    /// Length inside of glass, metres.
    pub path_length: f64,
}

/// Follows one ray over at most `bounces` interfaces. The first interface refracts; nothing is reflected but totally.
pub fn trace_all(world: &World, ray: &Ray, bounces: u32) -> Chain {
    follow(world, ray, bounces, false)
}

/// `until_out`: to where the light first leaves the body, whatever it meets after that.
fn follow(world: &World, ray: &Ray, bounces: u32, until_out: bool) -> Chain {
    let Some(first) = world.first_glass(ray) else { return Chain::default() };
    if world.bodies[first.body].thin {
        // Straight on through the sheet, as `trace_two` goes.
        return Chain { status: Status::Left, origin: first.hit.position, exit: ray.direction, ..Chain::default() };
    }
    let mut chain = Chain { status: Status::TotallyReflected, ..Chain::default() };
    let (mut ray, mut contact, mut within) = (*ray, first, Within::default());
    loop {
        if !within.is_none() {
            chain.path_length += contact.hit.t;
        }
        ray.origin = contact.hit.position;
        // Light goes straight on through a sheet, and what is no interface.
        if !world.bodies[contact.body].thin {
            let [here, beyond] = within.across(contact.body, contact.hit.facing(ray.direction));
            within = beyond;
            if let Some([before, behind]) = world.interface([here, beyond]) {
                let eta = world.ior(before) / world.ior(behind);
                let refracted = snell(ray.direction, contact.hit.normal_against(ray.direction), eta);
                within = if refracted.tir { here } else { beyond };
                ray.direction = refracted.direction;
                chain.bounces += 1;
            }
        }
        let inside = !within.is_none();
        let left = Chain { status: Status::Left, origin: ray.origin, exit: ray.direction, ..chain };
        if until_out && !inside {
            return left;
        }
        let Some(next) = world.next_glass(&ray, contact.body, Departure::Element(contact.hit.element)) else {
            return if inside { Chain { status: Status::NoExit, ..chain } } else { left };
        };
        if chain.bounces >= bounces {
            return Chain { origin: ray.origin, exit: ray.direction, ..chain };
        }
        contact = next;
    }
}

/// The chain through the centre of every pixel, row by row from the upper left, over at most `bounces` interfaces.
pub fn all_interfaces(world: &World, camera: &Camera, bounces: u32) -> Vec<Chain> {
    (0..camera.pixels()).into_par_iter().map(|pixel| trace_all(world, &camera.pixel_ray(pixel), bounces)).collect()
}

/// The same to where the light first leaves the body that it entered: total reflection is followed, re-entry is not.
pub fn until_out(world: &World, camera: &Camera, bounces: u32) -> Vec<Chain> {
    (0..camera.pixels()).into_par_iter().map(|pixel| follow(world, &camera.pixel_ray(pixel), bounces, true)).collect()
}

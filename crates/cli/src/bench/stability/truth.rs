//! What a picture should show, traced in f64 through the same triangles.

use anyhow::{Context, Result};
use glam::DVec3;
use murano_animation::Pose;
use murano_optics::snell;
use murano_reference::{Camera, Departure, Facing, GlassBody, Ray, Status, World, trace_two};
use murano_refraction::Method;

use super::case::{Case, Truth};

/// What one pixel should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// No glass.
    Nothing,
    /// Light leaves in this direction.
    Leaves(DVec3),
    /// Light is totally reflected.
    Reflected,
    /// There is no answer, which the picture must say.
    Flagged,
    /// There may be an answer, but nobody knows it.
    Unknown,
}

/// The right answers of a case.
pub struct Answers {
    /// What two interfaces do, a pixel.
    two: Vec<Expected>,
    /// What the first one does.
    one: Vec<Expected>,
    /// Whether a pixel and its neighbours are all of the body, or all not: at its outline grazing light turns a part of a
    /// pixel into any angle.
    pub inner: Vec<bool>,
}

impl Answers {
    /// What a method should show: one that searches no second interface knows the first one alone.
    pub fn of(&self, method: Method) -> &[Expected] {
        if method == Method::Sir { &self.one } else { &self.two }
    }

    /// Traces a case; `None` where nothing is known.
    pub fn traced(case: &Case) -> Result<Option<Self>> {
        if case.truth == Truth::Unknown {
            return Ok(None);
        }
        let pose = Pose::sample(&case.scene, &case.playing());
        let world = World::of_scene(&case.scene, &pose).context("the case cannot be traced")?;
        let camera =
            Camera { world_from_view: case.view.world_from_view, projection: case.view.projection, size: case.size };
        let forward = camera.world_from_view.transform_vector3(DVec3::NEG_Z).normalize();
        let (mut two, mut one) = (Vec::new(), Vec::new());
        for pixel in 0..camera.pixels() {
            let ray = camera.pixel_ray(pixel);
            // What lies before the near plane is not there.
            let start = ray.at(case.view.near / ray.direction.dot(forward));
            let (second, first) = answer(&world, &Ray { origin: start, ..ray }, case.truth);
            two.push(second);
            one.push(first);
        }
        let covered: Vec<bool> = two.iter().map(|expected| *expected != Expected::Nothing).collect();
        Ok(Some(Self { two, one, inner: away_from_outlines(&covered, case.size) }))
    }
}

/// What two interfaces do to a ray, and what the first alone does.
fn answer(world: &World, ray: &Ray, truth: Truth) -> (Expected, Expected) {
    let Some(body) = world.bodies.first() else { return (Expected::Nothing, Expected::Nothing) };
    let Some(first) = body.shape.nearest(ray, Departure::Free, None, f64::INFINITY) else {
        return (Expected::Nothing, Expected::Nothing);
    };
    if body.thin {
        return (Expected::Leaves(ray.direction), Expected::Leaves(ray.direction));
    }
    if truth == Truth::Sheet {
        let into = snell(ray.direction, first.normal_against(ray.direction), body.ior.recip()).direction;
        return (Expected::Leaves(ray.direction), Expected::Leaves(into));
    }
    if first.facing(ray.direction) == Facing::Back {
        let met = match truth {
            Truth::Closed => leaves(body, ray, first.normal_against(ray.direction)),
            _ if world.first_glass(ray).is_some() => Expected::Unknown,
            _ => Expected::Flagged,
        };
        return (met, met);
    }
    let path = trace_two(world, ray);
    let two = match path.status {
        Status::NoGlass => Expected::Nothing,
        Status::Left => Expected::Leaves(path.exit),
        Status::TotallyReflected => Expected::Reflected,
        Status::NoExit => Expected::Flagged,
    };
    let entered = !snell(ray.direction, first.normal_against(ray.direction), body.ior.recip()).tir;
    (two, if entered { Expected::Leaves(path.t1) } else { Expected::Reflected })
}

/// A ray that begins inside the body and meets its surface.
fn leaves(body: &GlassBody, ray: &Ray, inward: DVec3) -> Expected {
    let out = snell(ray.direction, inward, body.ior);
    if out.tir { Expected::Reflected } else { Expected::Leaves(out.direction) }
}

/// Pixels that agree with their neighbours, as far as the picture goes.
fn away_from_outlines(covered: &[bool], size: [u32; 2]) -> Vec<bool> {
    let [width, height] = size.map(|side| side as usize);
    let agrees = |pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
        let columns = x.saturating_sub(1)..=(x + 1).min(width - 1);
        rows.flat_map(|y| columns.clone().map(move |x| y * width + x)).all(|other| covered[other] == covered[pixel])
    };
    (0..covered.len()).map(agrees).collect()
}

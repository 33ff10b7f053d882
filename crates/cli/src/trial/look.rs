//! What a path through glass shows: the environment, shaded alike for the truth's paths and a method's, so that the two
//! pictures differ by nothing but the paths.

use anyhow::Result;
use glam::DVec3;
use murano_metrics::images::Picture;
use murano_optics::{beer_lambert, fresnel_unpolarised};
use murano_reference::{Camera, Status, TwoInterfaces, World};
use murano_refraction::Interfaces;
use murano_scene::Environment;
use rayon::prelude::*;

use super::{Subject, paths::PathSample};

/// Glass of a pixel.
#[derive(Clone, Copy)]
struct PixelGlass {
    ior: f64,
    absorption: DVec3,
    tint: DVec3,
}

/// Everything that the pictures of one subject share.
pub(super) struct Look {
    environment: Option<Environment>,
    directions: Vec<DVec3>,
    /// `None` where the truth sees no glass.
    glass: Vec<Option<PixelGlass>>,
    size: [u32; 2],
    exposure: f32,
    two_interfaces: bool,
}

impl Look {
    pub(super) fn of(subject: &Subject, world: &World, camera: &Camera, paths: &[TwoInterfaces]) -> Self {
        let glass = paths.iter().map(|path| {
            let body = &world.bodies[path.body];
            let glass = PixelGlass { ior: body.ior, absorption: body.absorption, tint: body.tint };
            (path.status != Status::NoGlass).then_some(glass)
        });
        Self {
            environment: subject.renderer.world().environment.clone(),
            directions: (0..camera.pixels()).map(|pixel| camera.pixel_ray(pixel).direction).collect(),
            glass: glass.collect(),
            size: camera.size,
            exposure: subject.request.exposure,
            two_interfaces: subject.request.refraction.interfaces == Interfaces::Two,
        }
    }

    /// The picture of some paths; `None` without an environment. Pixels without glass show the environment.
    pub(super) fn picture(&self, samples: &[PathSample]) -> Result<Option<Picture>> {
        let Some(environment) = &self.environment else { return Ok(None) };
        let radiance: Vec<[f32; 3]> = samples
            .par_iter()
            .enumerate()
            .map(|(pixel, sample)| self.radiance(environment, pixel, sample).as_vec3().to_array())
            .collect();
        Ok(Some(Picture::from_linear(self.size, &radiance, self.exposure)?))
    }

    /// As the refract pass without its reflection (`shaders/refraction/refract.wesl`).
    fn radiance(&self, environment: &Environment, pixel: usize, sample: &PathSample) -> DVec3 {
        let incident = self.directions[pixel];
        let glass = self.glass[pixel].filter(|_| sample.status != Status::NoGlass as u8);
        let Some(glass) = glass else { return environment.sample(incident).into() };
        let into = 1.0 - fresnel_unpolarised(-incident.dot(sample.n1), glass.ior.recip());
        // Of more than two interfaces, what the others let through is not known to a frame's output variables.
        let out = if self.two_interfaces && sample.status == Status::Left as u8 && sample.length > 0.0 {
            1.0 - fresnel_unpolarised(sample.t1.dot(sample.n2), glass.ior)
        } else {
            1.0
        };
        let seen = DVec3::from(environment.sample(sample.exit));
        into * out * glass.tint * beer_lambert(glass.absorption, sample.length) * seen
    }
}

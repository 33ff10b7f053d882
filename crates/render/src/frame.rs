//! The frame as a plan: one function, read from top to bottom, each line a pass or a pure step on the CPU.

use encase::ShaderType;
use glam::{DVec2, DVec3, Mat4, UVec2, Vec3, Vec4};
use murano_animation::{Bounds, DeformedGeometry, Pose};
use murano_caustics::Mirror;
use murano_gpu::{ComputePass, Gpu, GpuError, Groups, ShaderSpec, Work};
use murano_refraction::{
    Glass, LISTED_TILES, Layered, Layers, Mapped, Refraction, Viewpoint, over_listed_tiles, rasterise, texels,
    thickness, tile_threads,
};
use murano_scene::{Projection, Scene};
use murano_scheduler::{Output, Plan};

use crate::{
    FrameRequest, Moment, ToneMap, View,
    bodies::{Body, Sorted},
    distant::Distant,
    lighting::Deposited,
    looks::{Looks, SurfaceSource},
    order::back_to_front,
};

/// What a frame is made from: a world made ready.
pub(crate) struct Stock<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) scene: &'a Scene,
    pub(crate) sorted: &'a Sorted,
    pub(crate) looks: &'a Looks,
    pub(crate) distant: &'a Distant,
    /// Where fading surfaces have their centre, world.
    pub(crate) fade_centre: DVec3,
}

/// The outputs of a frame's plan.
pub(crate) struct Planned {
    pub(crate) plan: Plan<Work>,
    pub(crate) origin: DVec3,
    /// Packed sRGB.
    pub(crate) picture: Output,
    /// Linear radiance and depth: sums over more and more samples of each pixel, of which the last is their mean. Each is computed in
    /// its own round of the plan.
    pub(crate) sums: Vec<Output>,
    /// Paths of each body drawn.
    pub(crate) paths: Vec<Output>,
    /// Caustic irradiance and direct light of each lamp.
    pub(crate) light_layers: Vec<Output>,
    /// Every caustic map with its energy account.
    pub(crate) accounts: Vec<Deposited>,
    /// Motion of the opaque scene and of each body, where asked for.
    pub(crate) motions: Vec<Output>,
}

impl Planned {
    /// Linear radiance, the mean over the samples, and depth.
    pub(crate) fn colour(&self) -> Output {
        self.sums[self.sums.len() - 1]
    }
}

/// What the eye sees of the opaque scene.
pub(crate) struct OpaquePicture {
    pub(crate) layered: Layered,
    pub(crate) surfaces: Output,
    pub(crate) albedo: Output,
}

#[derive(ShaderType)]
struct OpaqueParams {
    render_from_view: Mat4,
    ambient: [Vec4; 9],
    fade_centre: Vec3,
    sample_width: f32,
}

#[derive(ShaderType)]
struct AccumulateParams {
    pixels: u32,
    scale: f32,
}

#[derive(ShaderType)]
struct CompositeParams {
    size: UVec2,
    exposure: f32,
    curve: u32,
}

/// Declares a frame.
pub(crate) fn plan(
    stock: &Stock<'_>,
    pose: &Pose,
    before: Option<(&Moment, &Pose)>,
    request: &FrameRequest,
) -> Result<Planned, GpuError> {
    let mut plan = Plan::new();
    let posed: Vec<Bounds> = stock.sorted.bodies.iter().map(|body| body.geometry.posed_bounds(pose)).collect();
    let opaque_bounds = stock.sorted.opaque.geometry.posed_bounds(pose);
    let visible = stock.looks.bodies.iter().zip(&posed).filter(|(look, _)| !look.is_invisible());
    let glass_bounds = visible.fold(Bounds::EMPTY, |all, (_, one)| all.union(*one));
    let origin = origin(if glass_bounds.is_empty() { &opaque_bounds } else { &glass_bounds });
    let eye = eye(&request.view, request.size);
    // A power of two, so that a body moving about does not change it.
    let reach = (4.0 * glass_bounds.union(opaque_bounds).diameter()).max(1e-12).log2().ceil().exp2();
    let environment = plan.leaf("environment", stock.distant.stamp, Work::Leaf(stock.distant.leaf.clone()));

    let mut frame = FramePlan {
        stock,
        request,
        origin,
        eye,
        reach,
        environment,
        sample: 0,
        aov: request.aov,
        accounts: Vec::new(),
        pose,
        wholes: Vec::new(),
    };
    let opaque =
        stock.sorted.opaque.leaves.deform(stock.gpu, &mut plan, 0, &stock.sorted.opaque.geometry, pose, origin)?;
    let bodies = frame.deform_bodies(&mut plan, pose, &posed)?;
    let mirrors = frame.deform_mirrors(&mut plan, pose)?;
    let seen = frame.seen_together(&mut plan, &bodies)?;
    let scene = PosedScene { opaque, opaque_bounds, bodies, seen, glass_bounds, mirrors };
    let (layered, paths, light_layers) = frame.see(&mut plan, &scene)?;
    let shown = scene.bodies.iter().filter(|body| frame.eye.sees(&body.bounds));
    let shown = shown.map(|body| (body.index + 1, body.mapped.geometry));
    let deformed: Vec<_> = std::iter::once((0, opaque)).chain(shown).collect();
    let motions = before.map(|before| frame.motion(&mut plan, before, &deformed, origin)).transpose()?;
    let accounts = std::mem::take(&mut frame.accounts);

    let mut sums = vec![layered.colour];
    // What more samples of a pixel have to tell is its colour.
    frame.aov = false;
    for sample in 1..request.samples {
        plan.next_round();
        frame.sample = sample;
        frame.eye = eye.through(within_pixel(sample, request.samples));
        let (layered, ..) = frame.see(&mut plan, &scene)?;
        sums.push(frame.accumulate(&mut plan, sample, sums[sums.len() - 1], layered.colour)?);
    }
    let colour = sums[sums.len() - 1];
    let picture = frame.composite(&mut plan, Layered { colour, ..layered })?;
    let motions = motions.unwrap_or_default();
    Ok(Planned { plan, origin, picture, sums, paths, light_layers, accounts, motions })
}

/// Where in a pixel one of its samples lies, 0 to 1 along each side. The first is in the middle, where the layers beside the picture
/// are taken. The others are pairs on opposite sides of it, along the R2 sequence (Roberts 2018), any beginning of which covers the square
/// evenly; of an even number three lie around it instead, at the distance that gives them a pixel's variance. So the mean of all is the
/// middle, but for two.
fn within_pixel(sample: u32, samples: u32) -> DVec2 {
    // One over the root of x^3 = x + 1, and its square.
    const STEP: DVec2 = DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_2);
    const DISTANCE: f64 = 0.47;
    let middle = DVec2::splat(0.5);
    let around = if samples.is_multiple_of(2) && samples > 2 { 3 } else { 0 };
    if sample == 0 {
        return middle;
    }
    if sample <= around {
        return middle + DISTANCE * DVec2::from_angle(std::f64::consts::TAU * (f64::from(sample) / 3.0 + 0.04));
    }
    let pair = (sample - around).div_ceil(2);
    let aside = (middle + f64::from(pair) * STEP).fract() - middle;
    if (sample - around).is_multiple_of(2) { middle - aside } else { middle + aside }
}

/// What is in the scene at a moment, whoever looks at it.
struct PosedScene {
    opaque: DeformedGeometry,
    opaque_bounds: Bounds,
    bodies: Vec<PosedBody>,
    /// As the eye sees them.
    seen: Vec<PosedBody>,
    glass_bounds: Bounds,
    mirrors: Vec<PosedMirror>,
}

/// Added to the instance of passes over a body at rest.
const RESTING: u32 = 1 << 31;

/// A glass body in this frame.
#[derive(Clone)]
pub(crate) struct PosedBody {
    pub(crate) index: u32,
    pub(crate) glass: Glass,
    pub(crate) mapped: Mapped,
    pub(crate) bounds: Bounds,
    /// What its surface is sampled from, where that is not the same everywhere.
    pub(crate) surface: Option<SurfaceSource>,
    /// Whether any part of it is rough.
    pub(crate) rough: bool,
    /// Whether it is made of facets.
    pub(crate) faceted: bool,
}

impl PosedBody {
    /// What of a frame's settings this body's glass asks for.
    pub(crate) fn refraction(&self, asked: &Refraction) -> Refraction {
        if self.glass.thin { asked.through_walls() } else { *asked }
    }
}

/// A polished metal body in this frame.
pub(crate) struct PosedMirror {
    /// Among glass bodies and mirrors, which follow them.
    pub(crate) index: u32,
    pub(crate) mirror: Mirror,
    pub(crate) mapped: Mapped,
    pub(crate) bounds: Bounds,
}

/// A point near what is shown, on a grid coarse enough that a body moving about keeps its origin.
fn origin(bounds: &Bounds) -> DVec3 {
    if bounds.is_empty() {
        return DVec3::ZERO;
    }
    let grid = (8.0 * bounds.diameter()).max(1e-9).log2().ceil().exp2();
    (bounds.center() / grid).round() * grid
}

/// The camera as a viewpoint.
pub(crate) fn eye(view: &View, size: [u32; 2]) -> Viewpoint {
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let (perspective, half_height) = match view.projection {
        Projection::Perspective { yfov } => (true, (0.5 * yfov).tan()),
        Projection::Orthographic { half_height } => (false, half_height),
    };
    Viewpoint {
        world_from_view: view.world_from_view,
        perspective,
        half_extent: DVec2::new(half_height * aspect, half_height),
        center: DVec2::ZERO,
        size,
        near: view.near,
    }
}

/// A frame while it is declared.
pub(crate) struct FramePlan<'a> {
    pub(crate) stock: &'a Stock<'a>,
    pub(crate) request: &'a FrameRequest,
    pub(crate) origin: DVec3,
    pub(crate) eye: Viewpoint,
    /// How far photons are followed, metres.
    pub(crate) reach: f64,
    pub(crate) environment: Output,
    /// Of each pixel, from 0.
    pub(crate) sample: u32,
    /// Whether the layers beside the picture are wanted of this sample.
    pub(crate) aov: bool,
    pub(crate) accounts: Vec<Deposited>,
    pub(crate) pose: &'a Pose,
    /// Bodies that are one, by their indices.
    pub(crate) wholes: Vec<(Vec<usize>, PosedBody)>,
}

impl FramePlan<'_> {
    /// What the eye sees through one point of each pixel, with the paths of each drawing of a body and the layers of each lamp.
    fn see(
        &mut self,
        plan: &mut Plan<Work>,
        scene: &PosedScene,
    ) -> Result<(Layered, Vec<Output>, Vec<Output>), GpuError> {
        let PosedScene { opaque, opaque_bounds, bodies, seen: seen_bodies, glass_bounds, mirrors } = scene;
        let seen = self.opaque(plan, opaque)?;
        let (mut layered, light_layers) =
            self.light(plan, (opaque, opaque_bounds), (bodies, glass_bounds), mirrors, &seen)?;
        let mut paths = Vec::new();
        // Each body is in the picture that the next, nearer one looks at.
        let mut drawn = *opaque_bounds;
        let (visible, unseen): (Vec<_>, Vec<_>) = seen_bodies.iter().partition(|body| self.eye.sees(&body.bounds));
        for body in unseen {
            plan.cull("eye_map", body.index, "the body is out of the picture")?;
            plan.cull("refract", body.index, "the body is out of the picture")?;
        }
        let boxes: Vec<Bounds> = visible.iter().map(|body| body.bounds).collect();
        for group in back_to_front(&boxes, &self.eye) {
            let group: Vec<_> = group.into_iter().map(|placed| (visible[placed.body], placed.rounds)).collect();
            layered = self.draw_glass(plan, &group, layered, &mut drawn, &mut paths)?;
        }
        Ok((layered, paths, light_layers))
    }

    /// Side of what a sample stands for, pixels.
    pub(crate) fn sample_width(&self) -> f32 {
        1.0 / (self.request.samples as f32).sqrt()
    }

    /// Adds a sample to the sum of those before it; behind the last one it is their mean.
    fn accumulate(
        &self,
        plan: &mut Plan<Work>,
        sample: u32,
        before: Output,
        colour: Output,
    ) -> Result<Output, GpuError> {
        let shader = self.stock.gpu.shader(&ShaderSpec::new("render::accumulate"))?;
        let pixels = texels(self.request.size);
        let is_last = sample + 1 == self.request.samples;
        let params = AccumulateParams {
            // More pixels than that fit no device.
            pixels: u32::try_from(pixels).unwrap_or(u32::MAX),
            scale: if is_last { 1.0 / self.request.samples as f32 } else { 1.0 },
        };
        let pass = ComputePass::new("accumulate", 0)
            .value("params", &params)
            .input("before", before)
            .input("colour", colour)
            .output("sum", 16 * pixels);
        Ok(pass.dispatch(&shader, "main", Groups::linear(params.pixels as usize, 64)).add_to(plan)?[0])
    }

    /// Deforms every body that light can tell from air.
    fn deform_bodies(&self, plan: &mut Plan<Work>, pose: &Pose, posed: &[Bounds]) -> Result<Vec<PosedBody>, GpuError> {
        let mut bodies = Vec::new();
        for (index, (body, bounds)) in (0..).zip(self.stock.sorted.bodies.iter().zip(posed)) {
            let look = &self.stock.looks.bodies[index as usize];
            if look.is_invisible() {
                plan.cull("deform", index + 1, "index of refraction 1 and clear: it changes nothing")?;
                continue;
            }
            let deformed = body.leaves.deform(self.stock.gpu, plan, index + 1, &body.geometry, pose, self.origin)?;
            let mut mapped = Mapped::from(deformed);
            mapped.shows_triangles = look.surface.is_some();
            mapped.relief = look.surface.as_ref().and_then(|surface| surface.relief(plan));
            let refraction =
                if look.glass.thin { self.request.refraction.through_walls() } else { self.request.refraction };
            if refraction.method.traces() {
                let tree = body.tree(self.stock.scene);
                mapped.tree = Some(tree.refit(self.stock.gpu, plan, ("refit", index), &deformed)?);
            }
            if refraction.bakes()
                && let Some(scale) = body.rigid_scale(self.stock.scene, pose)
            {
                mapped.thickness = Some(self.bake_thickness(plan, index, body, scale)?);
            }
            bodies.push(PosedBody {
                index,
                glass: look.glass,
                mapped,
                bounds: *bounds,
                surface: look.surface.clone(),
                rough: look.rough,
                faceted: body.faceted,
            });
        }
        Ok(bodies)
    }

    /// Deforms every mirror that throws caustics.
    fn deform_mirrors(&self, plan: &mut Plan<Work>, pose: &Pose) -> Result<Vec<PosedMirror>, GpuError> {
        let Sorted { bodies, mirrors, .. } = self.stock.sorted;
        let mut posed = Vec::new();
        for (index, (body, mirror)) in (bodies.len() as u32..).zip(mirrors.iter().zip(&self.stock.looks.mirrors)) {
            if self.request.caustics.is_none() || self.request.lights.is_empty() {
                plan.cull("deform", index + 1, "a mirror, and nothing asks for caustics")?;
                continue;
            }
            let deformed = body.leaves.deform(self.stock.gpu, plan, index + 1, &body.geometry, pose, self.origin)?;
            let bounds = body.geometry.posed_bounds(pose);
            posed.push(PosedMirror { index, mirror: *mirror, mapped: deformed.into(), bounds });
        }
        Ok(posed)
    }

    /// How thick a rigid body is behind each vertex, from its rest pose: no pose is among what it depends on.
    fn bake_thickness(&self, plan: &mut Plan<Work>, index: u32, body: &Body, scale: f64) -> Result<Output, GpuError> {
        let Stock { gpu, scene, .. } = *self.stock;
        let rest = Pose::rest(scene);
        let origin = body.geometry.posed_bounds(&rest).center();
        let deformed = body.leaves.deform(gpu, plan, RESTING | index, &body.geometry, &rest, origin)?;
        let tree = body.tree(scene).refit(gpu, plan, ("refit_at_rest", index), &deformed)?;
        thickness(gpu, plan, index, &deformed, &tree, scale)
    }

    /// Opaque things, lit by the environment, before it where there is nothing.
    fn opaque(&self, plan: &mut Plan<Work>, geometry: &DeformedGeometry) -> Result<OpaquePicture, GpuError> {
        let tangents = geometry.tangents.filter(|_| self.stock.looks.textured);
        let spec = ShaderSpec::new("render::opaque")
            .feature("textured", self.stock.looks.textured)
            .feature("framed", tangents.is_some());
        let shader = self.stock.gpu.shader(&spec)?;
        let count = texels(self.eye.size);
        let params = OpaqueParams {
            render_from_view: self.eye.view_from_render(self.origin).inverse().as_mat4(),
            ambient: self.stock.distant.ambient,
            fade_centre: (self.stock.fade_centre - self.origin).as_vec3(),
            sample_width: self.sample_width(),
        };
        let pass = ComputePass::new("opaque", 0)
            .value("params", &params)
            .value("viewpoint", &self.eye.uniform(self.origin))
            .input("normals", geometry.normals)
            .input("environment", self.environment)
            .scratch("seen", 4 * count)
            .output("surfaces", 16 * count)
            .output("albedo", 16 * count)
            .output("colour", 16 * count)
            .output("cover", 4 * count);
        let mut pass = rasterise(self.stock.gpu, pass, geometry, self.eye.size, Layers::Nearest)?;
        if let Some(tangents) = tangents {
            pass = pass.input("tangents", tangents);
        }
        for (name, stamp, leaf) in self.stock.sorted.opaque.buffers.iter().chain(&self.stock.looks.materials) {
            pass = pass.input(name, plan.leaf(name, *stamp, Work::Leaf(leaf.clone())));
        }
        let outputs =
            over_listed_tiles(pass.dispatch(&shader, "background", Groups::tiles(self.eye.size)), self.eye.size)
                .dispatch(&shader, "list", tile_threads(self.eye.size))
                .dispatch(&shader, "surface", LISTED_TILES)
                .add_to(plan)?;
        Ok(OpaquePicture {
            surfaces: outputs[0],
            albedo: outputs[1],
            layered: Layered { colour: outputs[2], cover: outputs[3] },
        })
    }

    /// Maps tones, packs sRGB; filters silhouettes where one sample of each pixel is all there is.
    fn composite(&self, plan: &mut Plan<Work>, layered: Layered) -> Result<Output, GpuError> {
        let shader = self.stock.gpu.shader(&ShaderSpec::new("render::composite"))?;
        let params = CompositeParams {
            size: UVec2::from_array(self.request.size),
            exposure: self.request.exposure,
            curve: match self.request.tone_map {
                ToneMap::Linear => 0,
                ToneMap::Neutral => 1,
                ToneMap::Agx => 2,
            },
        };
        let size = self.request.size;
        let pass = ComputePass::new("composite", 0)
            .value("params", &params)
            .input("colour", layered.colour)
            .input("cover", layered.cover)
            .output("picture", 4 * texels(size));
        let mut pass = pass.dispatch(&shader, "plain", Groups::tiles(size));
        if self.request.samples == 1 {
            pass = over_listed_tiles(pass, size).dispatch(&shader, "list", tile_threads(size)).dispatch(
                &shader,
                "silhouettes",
                LISTED_TILES,
            );
        }
        Ok(pass.add_to(plan)?[0])
    }
}

#[cfg(test)]
mod tests {
    use murano_gpu::{Shader, check_uniform_layout};

    use super::*;

    #[test]
    fn samples_cover_the_pixel_around_its_middle() {
        for samples in 1..=64 {
            let all: Vec<DVec2> = (0..samples).map(|sample| within_pixel(sample, samples)).collect();
            assert_eq!(all[0], DVec2::splat(0.5));
            assert!(
                all.iter().all(|at| at.cmpge(DVec2::ZERO).all() && at.cmple(DVec2::ONE).all()),
                "{samples}: {all:?}"
            );
            let mean = all.iter().sum::<DVec2>() / f64::from(samples) - 0.5;
            assert!(mean.length() < if samples == 2 { 0.25 } else { 1e-12 }, "{samples}: {mean} aside");
            let variance = all.iter().map(|at| (*at - 0.5).powf(2.0)).sum::<DVec2>() / f64::from(samples);
            let whole = DVec2::splat(1.0 / 12.0);
            assert!(samples < 4 || variance.abs_diff_eq(whole, 0.04), "{samples}: {variance}, not {whole}");
        }
    }

    #[test]
    fn shader_and_rust_agree_on_layouts() {
        let matrix = Mat4::from_cols_array(&std::array::from_fn(|i| i as f32 + 100.0));
        let opaque = Shader::link(&ShaderSpec::new("render::opaque")).unwrap();
        check_uniform_layout!(
            opaque,
            "Params",
            OpaqueParams {
                render_from_view: matrix,
                ambient: std::array::from_fn(|i| Vec4::splat(i as f32 + 1.0)),
                fade_centre: Vec3::new(20.0, 21.0, 22.0),
                sample_width: 23.0,
            }
        )
        .unwrap();
        let accumulate = Shader::link(&ShaderSpec::new("render::accumulate")).unwrap();
        check_uniform_layout!(accumulate, "Params", AccumulateParams { pixels: 1, scale: 2.0 }).unwrap();
        let composite = Shader::link(&ShaderSpec::new("render::composite")).unwrap();
        let size = UVec2::new(1, 2);
        check_uniform_layout!(composite, "Params", CompositeParams { size: size, exposure: 3.0, curve: 4 }).unwrap();
    }
}

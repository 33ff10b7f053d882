//! Caustics measured: the irradiance on the floor against traced photons, and the time it takes.

use anyhow::{Context, Result, bail, ensure};
use glam::{DMat4, DVec3};
use murano_caustics::Caustics;
use murano_metrics::irradiance::{
    IrradianceMap, RidgeError, RidgeSettings, encircled_energy_radius, energy_ratio, relative_l1, relative_l2,
    ridge_position,
};
use murano_reference::{PhotonClass, PhotonTracing, Receiver, Window, World, caustic_map, trace_photons};
use murano_refraction::Interfaces;
use murano_render::{CausticAccount, View};
use murano_scene::{PlacedLight, Projection};

use super::{Subject, Timing, layers::vectors, time_frames};

/// Passes that find where light lands and sum it up: all that depends on the number of photons and on nothing the eye sees.
const CAUSTIC_PASSES: [&str; 3] = ["light_map", "emit", "deposit"];
/// Texels a side of the compared map.
const TEXELS: u32 = 256;
/// Pixels a side of each of them: a picture samples points, and a focus can be narrower than a texel.
const FINER: u32 = 4;
/// Share of the light that lands within the compared map.
const SHARE: f64 = 0.95;
/// Photons that find out where the light lands.
const PILOT: u64 = 1 << 16;

/// The exact irradiance of a subject's caustic on its floor.
pub struct CausticTruth {
    /// W/m^2, luminance, row by row.
    map: IrradianceMap,
    /// Expected relative L1 of the truth's own noise.
    pub noise: f64,
    window: Window,
}

impl CausticTruth {
    /// Traces `photons` from the subject's lamp onto its floor: what was refracted in and out, or everything that comes by way of the
    /// glass.
    ///
    /// # Errors
    /// If the subject has no floor, no lamp, or opaque things that would lie over the floor, or if no light lands.
    pub fn trace(
        subject: &Subject,
        interfaces: Interfaces,
        photons: u64,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self> {
        let world = glass_over_floor(subject)?;
        let floor = subject
            .renderer
            .world()
            .floor
            .context("caustics are compared on the floor, and this shot has none; lay one with --floor Y")?;
        let lamp = lamp(subject)?;
        let middle = DVec3::new(floor.center[0], floor.height, floor.center[1]);
        let window = window(&world, lamp, middle, floor.half_extent)?;
        let tracing = PhotonTracing { photons, ..PhotonTracing::default() };
        let traced = caustic_map(&world, lamp, window, &tracing, progress)?;
        let counted = |class: &&PhotonClass| match interfaces {
            Interfaces::Two => **class == PhotonClass::TwoRefractions,
            Interfaces::All => true,
        };
        let sum = |by_class: &[Vec<DVec3>]| -> Vec<f64> {
            let classes = || PhotonClass::ALL.iter().filter(counted);
            let texel = |texel: usize| classes().map(|&class| luminance(by_class[class as usize][texel])).sum();
            (0..window.texels()).map(texel).collect()
        };
        let values = sum(&traced.irradiance);
        // The mean of two independent estimates is off by half of their difference.
        let halves = traced.halves.each_ref().map(|half| sum(half));
        let off: f64 = halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (a - b).abs()).sum();
        let noise = off / values.iter().sum::<f64>();
        Ok(Self { map: IrradianceMap::new(window.size, window.texel_area(), values)?, noise, window })
    }

    /// The truth's map.
    pub fn map(&self) -> &IrradianceMap {
        &self.map
    }
}

/// Linear Rec.709.
fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

fn lamp(subject: &Subject) -> Result<&PlacedLight> {
    subject.request.lights.first().context("the shot has no light, so it throws no caustic")
}

/// The glass alone: the floor is the plane on which light is received.
fn glass_over_floor(subject: &Subject) -> Result<World> {
    let mut scene = subject.scene().into_owned();
    if subject.renderer.world().floor.is_some() {
        // The renderer appends its floor as the last root.
        scene.roots.pop();
    }
    let world = World::of_scene(&scene, &subject.pose()).context("the reference tracer")?;
    if world.bodies.is_empty() {
        bail!("the input shows no glass, so it throws no caustic; make it glass with --glass");
    }
    ensure!(
        world.opaque.is_none(),
        "caustics are compared on the bare floor, and parts of the model are opaque; make them glass with --glass"
    );
    Ok(world)
}

/// A square on the floor around most of the light that was refracted in and out.
fn window(world: &World, lamp: &PlacedLight, middle: DVec3, half_extent: f64) -> Result<Window> {
    let everywhere = Receiver::Plane(Window::horizontal(middle, half_extent, 1));
    let tracing = PhotonTracing { photons: PILOT, ..PhotonTracing::default() };
    let mut landings: Vec<(DVec3, f64)> = Vec::new();
    trace_photons(world, lamp, &everywhere, &tracing, &|_, _| {}, &mut |landing| {
        if landing.class == PhotonClass::TwoRefractions {
            landings.push((landing.position, luminance(landing.flux)));
        }
    })?;
    let total: f64 = landings.iter().map(|(_, flux)| flux).sum();
    ensure!(total > 0.0, "no light comes through the glass to the floor; change --light or --floor");
    let centre = landings.iter().map(|(position, flux)| *position * *flux).sum::<DVec3>() / total;
    let mut distances: Vec<(f64, f64)> =
        landings.iter().map(|(position, flux)| ((*position - centre).abs().max_element(), *flux)).collect();
    distances.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut sum = 0.0;
    let reached = distances.iter().find(|(_, flux)| {
        sum += flux;
        sum >= SHARE * total
    });
    let half = reached.map_or(half_extent, |(distance, _)| *distance);
    // As the view straight down sees it: rows towards -z, columns towards -x (see `look_along`).
    Ok(Window {
        centre: DVec3::new(centre.x, middle.y, centre.z),
        half_u: half * DVec3::NEG_X,
        half_v: half * DVec3::Z,
        size: [TEXELS, TEXELS],
    })
}

/// A parallel view straight down on a window.
fn view_down(window: &Window, height: f64) -> View {
    let axis = |v: DVec3| v.normalize().extend(0.0);
    let eye = window.centre + height * DVec3::Y;
    let world_from_view =
        DMat4::from_cols(axis(window.half_u), axis(window.half_v), DVec3::Y.extend(0.0), eye.extend(1.0));
    View {
        world_from_view,
        projection: Projection::Orthographic { half_height: window.half_v.length() },
        near: 1e-3 * height,
    }
}

/// One caustics method on one subject.
pub struct CausticTrial {
    /// The method and its parameters.
    pub caustics: Caustics,
    /// Flux within the window over the truth's.
    pub energy_ratio: f64,
    /// Sum of absolute differences over the truth's sum.
    pub relative_l1: f64,
    /// Root of the sum of squared differences over the truth's.
    pub relative_l2: f64,
    /// Radius of the circle that holds half of the flux, over the truth's.
    pub radius_ratio: f64,
    /// How far its ridges lie from the truth's, texels of the window; `None` if the truth has none.
    pub ridge: Option<RidgeError>,
    /// What was drawn.
    pub map: IrradianceMap,
    /// The caustic map of the first caster.
    pub account: CausticAccount,
    /// How long it takes.
    pub timing: Timing,
}

impl CausticTrial {
    /// Renders the floor under the subject and measures the caustic that the method adds to it.
    ///
    /// # Errors
    /// The device's, and those of measuring.
    pub fn run(subject: &mut Subject, truth: &CausticTruth, caustics: Caustics, runs: usize) -> Result<Self> {
        let height = 4.0 * subject.diameter;
        let frame = subject.render(|request| {
            request.view = view_down(&truth.window, height);
            request.size = truth.window.size.map(|side| FINER * side);
            request.lights.truncate(1);
            request.caustics = Some(caustics);
            request.samples = 1;
            request.aov = true;
        })?;
        let aov = frame.aov.context("the frame lacks its output variables")?;
        let values = vectors(&aov, "caustic")?.into_iter().map(|irradiance| luminance(irradiance.max(DVec3::ZERO)));
        let area = truth.window.texel_area() / f64::from(FINER * FINER);
        let fine = IrradianceMap::new(truth.window.size.map(|side| FINER * side), area, values.collect())?;
        let map = fine.downsampled(FINER)?;
        let mut request = subject.request.clone();
        request.caustics = Some(caustics);
        request.samples = 1;
        let timing = time_frames(&mut subject.renderer, &request, runs)?;
        request.lights.truncate(1);
        let account = subject.renderer.caustic_accounts(&request)?.into_iter().next();
        let account = account.context("nothing of the shot throws a caustic")?;
        let centre = truth.map.centroid();
        let radius = |map: &IrradianceMap| encircled_energy_radius(map, 0.5, centre);
        Ok(Self {
            caustics,
            energy_ratio: energy_ratio(&truth.map, &map)?,
            relative_l1: relative_l1(&truth.map, &map)?,
            relative_l2: relative_l2(&truth.map, &map)?,
            radius_ratio: if map.flux() > 0.0 { radius(&map)? / radius(&truth.map)? } else { 0.0 },
            ridge: ridge_position(&truth.map, &map, RidgeSettings::default()).ok(),
            map,
            account,
            timing,
        })
    }

    /// Median and spread of the GPU time of the caustics, milliseconds.
    pub fn gpu_ms(&self) -> Option<(f64, f64)> {
        self.timing.of_passes(&CAUSTIC_PASSES).map(|spread| (spread.median, spread.interquartile()))
    }
}

//! Refraction measured: a method's paths and picture against the truth's, and its time.

use anyhow::{Context, Result, ensure};
use glam::{DVec3, Vec3};
use murano_metrics::{
    images::{DEFAULT_PIXELS_PER_DEGREE, FlipMap, Picture, flip, rmse, ssim},
    paths::{PathErrors, Paths, Silhouette, path_errors},
};
use murano_optics::{critical_clamp, reflected};
use murano_reference::{
    Ball, Chain, Fade, Landing, PathScene, PathSettings, PhotonMap, PhotonTracing, Receiver, Status, TwoInterfaces,
    World, all_interfaces, path_picture, trace_photons, two_interfaces, until_out,
};
use murano_refraction::{Interfaces, Refraction, TirPolicy};
use murano_render::Aov;

use super::{
    Subject, Timing,
    layers::{scalars, vectors},
    look::Look,
    time_frames,
};

/// Photons of each lamp in a path-traced picture.
const PATH_PHOTONS: u64 = 1_000_000;
/// How far they are blurred, in diameters of the body.
const PHOTON_RADIUS: f64 = 0.008;

/// A two-interface path as both the renderer and the tracer know it. World space.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathSample {
    /// As the `status` layer.
    pub(super) status: u8,
    pub(super) n1: DVec3,
    pub(super) t1: DVec3,
    pub(super) p2: DVec3,
    pub(super) n2: DVec3,
    /// The direction in which the pixel looks after the glass, whatever the status.
    pub(super) exit: DVec3,
    /// Within the glass, metres.
    pub(super) length: f64,
}

/// The paths of a picture as the metrics take them.
struct PathLists {
    exit: Vec<Vec3>,
    p2: Vec<Vec3>,
    status: Vec<u8>,
}

impl PathLists {
    /// Points are taken relative to `origin`, so that f32 holds them.
    fn of(samples: &[PathSample], origin: DVec3) -> Self {
        Self {
            exit: samples.iter().map(|sample| sample.exit.as_vec3()).collect(),
            p2: samples.iter().map(|sample| (sample.p2 - origin).as_vec3()).collect(),
            status: samples.iter().map(|sample| sample.status).collect(),
        }
    }

    fn paths(&self) -> Paths<'_> {
        Paths { exit: &self.exit, p2: &self.p2, status: &self.status }
    }
}

/// The exact paths of a subject's picture.
pub struct Truth {
    samples: Vec<PathSample>,
    lists: PathLists,
    look: Look,
    picture: Option<Picture>,
    /// Whether `picture` is the whole frame, path-traced.
    whole: bool,
    /// Of the path-traced picture: mean standard error over mean luminance.
    noise: Option<f64>,
    origin: DVec3,
    tir: TirPolicy,
    interfaces: Interfaces,
    /// Of the ball around all glass, metres.
    diameter: f64,
}

impl Truth {
    /// Traces the subject's picture through every pixel's centre, in f64: two interfaces, or as many as followed paths may meet, as the
    /// subject's settings ask for.
    ///
    /// # Errors
    /// If the scene cannot be traced.
    pub fn trace(subject: &Subject) -> Result<Self> {
        let world = subject.traced()?;
        let camera = subject.camera();
        ensure!(
            world.bodies.iter().any(|body| (body.ior - 1.0).abs() > 1e-9),
            "glass of index 1 refracts nothing, so there is nothing to compare; give another --ior"
        );
        let Refraction { tir, interfaces, most_interfaces, .. } = subject.request.refraction;
        let paths = two_interfaces(&world, &camera);
        ensure!(
            paths.iter().any(|path| path.status != Status::NoGlass),
            "the camera sees no glass from outside, so there is nothing to compare; change --camera"
        );
        let chains = match (interfaces, tir) {
            (Interfaces::All, _) => all_interfaces(&world, &camera, most_interfaces),
            (Interfaces::Two, TirPolicy::Trace) => until_out(&world, &camera, most_interfaces),
            (Interfaces::Two, _) => Vec::new(),
        };
        let sample = |(pixel, path): (usize, &TwoInterfaces)| match chains.get(pixel) {
            Some(chain) if interfaces == Interfaces::All => chain_sample(path, chain),
            chain => traced_sample(&world, path, tir, chain),
        };
        let samples: Vec<PathSample> = paths.iter().enumerate().map(sample).collect();
        let origin = camera.world_from_view.w_axis.truncate();
        let look = Look::of(subject, &world, &camera, &paths);
        let picture = look.picture(&samples)?;
        Ok(Self {
            lists: PathLists::of(&samples, origin),
            samples,
            look,
            picture,
            whole: false,
            noise: None,
            origin,
            tir,
            interfaces,
            diameter: diameter(&world)?,
        })
    }

    /// The truth's picture: the environment through the glass; `None` without an environment.
    pub fn picture(&self) -> Option<&Picture> {
        self.picture.as_ref()
    }

    /// Replaces the picture by the whole frame, path-traced with at most `passes` times 16 samples a pixel, until its noise
    /// is at most `noise`.
    ///
    /// # Errors
    /// If the scene cannot be traced.
    pub fn with_path_traced_picture(
        self,
        subject: &Subject,
        passes: u32,
        noise: f64,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self> {
        let shown = subject.renderer.world();
        let world = subject.traced()?;
        let fade = shown.floor.map(|floor| Fade {
            // The renderer appends its floor's material to the scene's.
            material: shown.scene.materials.len() - 1,
            centre: DVec3::new(floor.center[0], floor.height, floor.center[1]),
            radius: floor.half_extent,
        });
        let photons = subject.request.caustics.map(|_| caustic_photons(subject, &world)).transpose()?;
        let materials = subject.scene();
        let scene = PathScene {
            world: &world,
            scene: &materials,
            environment: shown.environment.as_ref(),
            lights: &subject.request.lights,
            photons: photons.as_ref(),
            fade,
        };
        let settings = PathSettings { passes, noise, ..PathSettings::default() };
        let traced = path_picture(&scene, &subject.camera(), &settings, progress);
        let picture = Picture::from_linear(subject.request.size, &traced.radiance, subject.request.exposure)?;
        Ok(Self { picture: Some(picture), whole: true, noise: Some(traced.noise()), ..self })
    }

    /// Noise of the path-traced picture: mean standard error over mean luminance.
    pub fn noise(&self) -> Option<f64> {
        self.noise
    }

    /// What a method's frame shows, for comparison with the truth's picture.
    fn tested_picture(&self, subject: &Subject, aov: &Aov, samples: &[PathSample]) -> Result<Option<Picture>> {
        if !self.whole {
            return self.look.picture(samples);
        }
        let radiance: Vec<[f32; 3]> =
            vectors(aov, "radiance")?.into_iter().map(|radiance| radiance.as_vec3().to_array()).collect();
        Ok(Some(Picture::from_linear(subject.request.size, &radiance, subject.request.exposure)?))
    }

    /// Renders the subject by a method and measures its paths; its picture is what it shows of the environment through the glass, or
    /// the whole frame where the truth's is.
    ///
    /// # Errors
    /// The device's, and those of measuring.
    pub fn measure(&self, subject: &mut Subject, refraction: Refraction, ring: Silhouette) -> Result<Measured> {
        let frame = subject.render(|request| {
            request.refraction = refraction;
            request.aov = true;
        })?;
        let aov = frame.aov.context("the frame lacks its output variables")?;
        let samples = rendered_samples(&aov)?;
        let lists = PathLists::of(&samples, self.origin);
        let paths = path_errors(self.lists.paths(), lists.paths(), self.diameter, subject.request.size, ring)?;
        let seen = samples.iter().filter(|sample| sample.status != 0).count().max(1) as f64;
        let mean =
            |name| Ok::<f64, anyhow::Error>(scalars(&aov, name)?.iter().map(|&n| f64::from(n)).sum::<f64>() / seen);
        Ok(Measured {
            paths,
            picture: self.tested_picture(subject, &aov, &samples)?,
            entries: mean("entries")?,
            triangles: mean("triangles")?,
        })
    }

    /// Pixels that show glass.
    pub fn covered(&self) -> usize {
        self.samples.iter().filter(|sample| sample.status != 0).count()
    }
}

/// Diameter of a ball around all glass, metres.
fn diameter(world: &World) -> Result<f64> {
    let balls = world.bodies.iter().filter_map(|body| body.shape.ball());
    let ball = balls.reduce(Ball::around).context("the glass has no triangles, so there is nothing to compare")?;
    Ok(2.0 * ball.radius)
}

/// Photons of every lamp on the opaque things of a subject.
fn caustic_photons(subject: &Subject, world: &World) -> Result<PhotonMap> {
    let mut landings = Vec::new();
    let tracing = PhotonTracing { photons: PATH_PHOTONS, ..PhotonTracing::default() };
    for light in &subject.request.lights {
        let mut keep = |landing: &Landing| landings.push(*landing);
        trace_photons(world, light, &Receiver::Opaque, &tracing, &|_, _| {}, &mut keep)?;
    }
    Ok(PhotonMap::new(landings, PHOTON_RADIUS * diameter(world)?))
}

/// Where the light leaves, or goes on to at the last bounce; `None` where it came to no end.
fn direction_at_end(chain: &Chain) -> Option<DVec3> {
    (chain.exit != DVec3::ZERO).then_some(chain.exit)
}

fn chain_sample(path: &TwoInterfaces, chain: &Chain) -> PathSample {
    PathSample {
        status: chain.status as u8,
        n1: path.n1,
        t1: path.t1,
        p2: chain.origin,
        n2: path.n2,
        exit: direction_at_end(chain).unwrap_or(path.t1),
        length: chain.path_length,
    }
}

/// `chain` is the same ray's, followed on.
fn traced_sample(world: &World, path: &TwoInterfaces, tir: TirPolicy, chain: Option<&Chain>) -> PathSample {
    let exit = match path.status {
        Status::NoGlass | Status::Left => path.exit,
        Status::NoExit => path.t1,
        Status::TotallyReflected => match tir {
            TirPolicy::Pass => path.t1,
            TirPolicy::Clamp => critical_clamp(path.t1, -path.n2, world.bodies[path.body].ior),
            TirPolicy::Reflect => reflected(path.t1, path.n2),
            TirPolicy::Trace => chain.and_then(direction_at_end).unwrap_or(path.t1),
        },
    };
    PathSample {
        status: path.status as u8,
        n1: path.n1,
        t1: path.t1,
        p2: path.p2,
        n2: path.n2,
        exit,
        length: path.path_length,
    }
}

/// The paths that a frame's output variables tell.
fn rendered_samples(aov: &Aov) -> Result<Vec<PathSample>> {
    let [status, length] = [scalars(aov, "status")?, scalars(aov, "path_length")?];
    let [n1, t1, p2, n2, exit] = [
        vectors(aov, "n1")?,
        vectors(aov, "t1")?,
        vectors(aov, "p2")?,
        vectors(aov, "n2")?,
        vectors(aov, "exit_direction")?,
    ];
    let sample = |pixel: usize| PathSample {
        status: status[pixel] as u8,
        n1: n1[pixel],
        t1: t1[pixel],
        p2: p2[pixel],
        n2: n2[pixel],
        exit: exit[pixel],
        length: f64::from(length[pixel]),
    };
    Ok((0..status.len()).map(sample).collect())
}

/// A frame by one method.
pub struct Measured {
    /// How far its paths lie from the truth's.
    pub paths: PathErrors,
    /// What it shows; `None` without an environment.
    pub picture: Option<Picture>,
    /// Texels, layers, squares and nodes of hierarchies that the search of a pixel of glass reads, in the mean.
    pub entries: f64,
    /// Triangles likewise.
    pub triangles: f64,
}

/// One method on one subject.
pub struct RefractionTrial {
    /// The method and its parameters.
    pub refraction: Refraction,
    /// How far its paths lie from the truth's.
    pub errors: RefractionErrors,
    /// How long it takes.
    pub timing: Timing,
    /// What it shows of the environment through the glass; `None` without an environment.
    pub picture: Option<Picture>,
    /// As [`Measured::entries`].
    pub entries: f64,
    /// As [`Measured::triangles`].
    pub triangles: f64,
}

/// How far a method lies from the truth.
pub struct RefractionErrors {
    /// Exit directions, exit points, statuses.
    pub paths: PathErrors,
    /// Of the environment seen through the glass, both shaded alike, or of the whole frame where the truth's picture is
    /// path-traced; `None` without a picture.
    pub flip: Option<FlipMap>,
    /// Likewise.
    pub rmse: Option<f64>,
    /// Likewise; `None` too for a picture smaller than the window of the measure.
    pub ssim: Option<f64>,
}

impl RefractionTrial {
    /// Renders the subject by a method, measures it against the truth and times it.
    ///
    /// # Errors
    /// The device's, and those of measuring.
    pub fn run(
        subject: &mut Subject,
        truth: &Truth,
        refraction: Refraction,
        ring: Silhouette,
        runs: usize,
    ) -> Result<Self> {
        // The path tracer knows one wavelength.
        let wavelengths = if truth.whole { 1 } else { refraction.wavelengths };
        let refraction = Refraction { tir: truth.tir, interfaces: truth.interfaces, wavelengths, ..refraction };
        let Measured { paths, picture, entries, triangles } = truth.measure(subject, refraction, ring)?;
        let both = truth.picture.as_ref().zip(picture.as_ref());
        let errors = RefractionErrors {
            paths,
            flip: both.map(|(truth, tested)| flip(truth, tested, DEFAULT_PIXELS_PER_DEGREE)).transpose()?,
            rmse: both.map(|(truth, tested)| rmse(truth, tested)).transpose()?,
            ssim: both.and_then(|(truth, tested)| ssim(truth, tested).ok()),
        };
        let mut request = subject.request.clone();
        request.refraction = refraction;
        let timing = time_frames(&mut subject.renderer, &request, runs)?;
        Ok(Self { refraction, errors, timing, picture, entries, triangles })
    }
}

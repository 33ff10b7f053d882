//! Options that several commands share, and the shot and settings they make.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use murano_caustics::Caustics;
use murano_gpu::{AdapterChoice, Gpu, OutputChecks};
use murano_refraction::{
    BackSurface, Interfaces, MOST_BRANCHES, MOST_INTERFACES, MOST_WAVELENGTHS, Method, NormalDistance, Refraction,
    TirPolicy,
};
use murano_render::{Settings, Skipping, open_shot};
use murano_scene::{ClipChoice, EnvironmentChoice, FloorLevel, GlassBodies, LoopMode, Shot, ShotLight, Skinning};

use crate::layer::{LayerOption, loop_mode};
use crate::values::{self, CameraWord, CausticsChoice, LightWord};

/// Which adapter renders, and how it is watched.
#[derive(Args)]
pub struct AdapterOption {
    /// Adapter whose name contains NAME, or `software`; see `murano adapters`
    #[arg(long, value_name = "NAME|software")]
    adapter: Option<String>,
    /// Look for NaN and infinity in everything that a pass writes, and stop there
    #[arg(long)]
    check_outputs: bool,
}

impl AdapterOption {
    /// Opens the adapter.
    pub fn open(&self) -> Result<Gpu> {
        let choice = match self.adapter.as_deref() {
            None => AdapterChoice::Best,
            Some("software") => AdapterChoice::Software,
            Some(name) => AdapterChoice::Named(name.into()),
        };
        let checks = if self.check_outputs { OutputChecks::NonFinite } else { OutputChecks::Off };
        Ok(Gpu::new(&choice)?.with_output_checks(checks))
    }
}

/// A model or a shot, and what is changed about it.
#[derive(Args)]
pub struct ShotOptions {
    /// A model (.glb, .gltf) or a shot (.ron)
    input: PathBuf,

    /// Clip that plays; the first one unless said otherwise
    #[arg(long, value_name = "NAME|INDEX", value_parser = values::clip(), help_heading = "Scene")]
    clip: Option<ClipChoice>,
    /// Time in the clip at which the first frame is taken, seconds
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true, help_heading = "Scene")]
    time: Option<f64>,
    /// Seconds of the clip that pass in a second; negative plays it backwards
    #[arg(long, value_name = "X", value_parser = values::number, allow_negative_numbers = true, help_heading = "Scene")]
    speed: Option<f64>,
    /// What the clip does outside its span: once, loop, ping-pong, clamp
    #[arg(long, value_name = "MODE", value_parser = loop_mode, help_heading = "Scene")]
    repeat: Option<LoopMode>,
    /// A clip laid over it: clip=NAME|INDEX,weight=W,speed=S,repeat=MODE,from=S,until=S,fade=S,blend=over|add,mask=NODE+NODE,
    /// all but the clip optional; a mask is nodes with all that hangs on them; may be given several times
    #[arg(long, value_name = "LAYER", help_heading = "Scene")]
    layer: Vec<LayerOption>,
    /// How joints are blended that move a vertex together: linear, dual-quaternion (keeps the volume of what twists)
    #[arg(long, value_name = "WAY", value_parser = values::skinning, help_heading = "Scene")]
    skinning: Option<Skinning>,
    /// Material variant of the model; see `murano inspect`
    #[arg(long, value_name = "NAME|INDEX", value_parser = values::clip(), help_heading = "Scene")]
    variant: Option<ClipChoice>,
    /// The pose stays as it is at --time
    #[arg(long, help_heading = "Scene")]
    hold: bool,
    /// Every material becomes glass
    #[arg(long, help_heading = "Scene")]
    glass: bool,
    /// Index of refraction of all glass
    #[arg(long, value_name = "N", value_parser = values::index_of_refraction, help_heading = "Scene")]
    ior: Option<f64>,
    /// Dispersion of all glass: 20 over the Abbe number, 0 for none (crown glass .34, flint .56, diamond .36)
    #[arg(long, value_name = "X", value_parser = values::not_negative, help_heading = "Scene")]
    dispersion: Option<f64>,
    /// Roughness of all glass, 0 to 1, as its materials' own would be (frosted glass .3 to .5)
    #[arg(long, value_name = "X", value_parser = values::fraction, help_heading = "Scene")]
    roughness: Option<f64>,
    /// All glass is a thin sheet around nothing, such as a bubble or a window: light goes straight on through it
    #[arg(long, help_heading = "Scene")]
    thin: bool,
    /// Light from far away: an equirectangular file (.hdr, .exr)
    #[arg(long, value_name = "FILE|none", value_parser = values::environment(), help_heading = "Scene")]
    env: Option<EnvironmentChoice>,
    /// Height of the floor, metres; at the model's lowest point unless said otherwise
    #[arg(
        long, value_name = "Y|none", value_parser = values::floor, allow_negative_numbers = true, help_heading = "Scene"
    )]
    floor: Option<FloorLevel>,

    /// Picture size in pixels [default: 512x512]
    #[arg(long, value_name = "WxH", value_parser = values::size, help_heading = "Picture")]
    size: Option<[u32; 2]>,
    /// Rays through each pixel, whose mean the picture shows: what one ray cannot sample, edges above all, comes right with more, and
    /// each costs as much as the first but for bodies, light and caustics, which are there [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024), help_heading = "Picture")]
    samples: Option<u32>,
    /// Camera: eye=X,Y,Z target=X,Y,Z fov=DEG (vertical), each of them optional; or the model's own: model[=NAME]
    #[arg(long, value_name = "WORD", num_args = 1..=3, help_heading = "Picture")]
    camera: Vec<CameraWord>,
    /// The camera turns around its target, degrees a second
    #[arg(
        long, value_name = "DEG/S", value_parser = values::number, allow_negative_numbers = true, help_heading = "Picture"
    )]
    orbit: Option<f64>,
    /// Light: spot|point|directional pos=X,Y,Z dir=X,Y,Z intensity=I cone=DEG, each of them optional; or the model's own: model
    #[arg(long, value_name = "WORD", num_args = 1..=5, help_heading = "Picture")]
    light: Vec<LightWord>,
    /// The light turns around the model, degrees a second
    #[arg(
        long, value_name = "DEG/S", value_parser = values::number, allow_negative_numbers = true, help_heading = "Picture"
    )]
    light_orbit: Option<f64>,

    /// How the second interface is found
    #[arg(long, value_parser = values::one_of::<Method, _>(Method::ALL.map(Method::name)), help_heading = "Glass")]
    method: Option<Method>,
    /// Steps of that search (dir and newton)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64), help_heading = "Glass")]
    steps: Option<u32>,
    /// isr: the way along the inward normal, d_N, as traced in the rest pose, as 0, or left out for the way along the view
    #[arg(
        long, value_parser = values::one_of::<NormalDistance, _>(NormalDistance::ALL.map(NormalDistance::name)),
        help_heading = "Glass"
    )]
    isr_distance: Option<NormalDistance>,
    /// isr: the back surface that counts as the second interface
    #[arg(
        long, value_parser = values::one_of::<BackSurface, _>(BackSurface::ALL.map(BackSurface::name)),
        help_heading = "Glass"
    )]
    isr_back: Option<BackSurface>,
    /// Wavelengths in which glass that disperses is seen; 1 switches dispersion off [default: 8]
    #[arg(
        long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_WAVELENGTHS)),
        help_heading = "Glass"
    )]
    wavelengths: Option<u32>,
    /// dir: as its paper prints it, errors included
    #[arg(long, help_heading = "Glass")]
    uncorrected: bool,
    /// Total internal reflection at the second interface
    #[arg(long, value_parser = values::one_of::<TirPolicy, _>(TirPolicy::ALL.map(TirPolicy::name)), help_heading = "Glass")]
    tir: Option<TirPolicy>,
    /// How many interfaces a refracted ray meets: two, or all ahead of it (--most-interfaces). All follow total reflection whatever
    /// --tir says; light that enters the body again, or another one that it touches or lies within, is followed by layers and exact alone
    #[arg(
        long, value_parser = values::one_of::<Interfaces, _>(Interfaces::ALL.map(Interfaces::name)),
        help_heading = "Glass"
    )]
    interfaces: Option<Interfaces>,
    /// Paths through the glass that a pixel follows with --interfaces all or --tir trace: the transmitted one, then the heaviest
    /// part that the last one left aside; the last path of a photon, or of one of several --samples, carries all light that is left and
    /// goes by chance [default: 2]
    #[arg(
        long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_BRANCHES)),
        help_heading = "Glass"
    )]
    branches: Option<u32>,
    /// Interfaces that such a path meets at most; light that is still inside then counts as if it left [default: 8]
    #[arg(
        long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=i64::from(MOST_INTERFACES)),
        help_heading = "Glass"
    )]
    most_interfaces: Option<u32>,
    /// The first interface does not reflect, and only transmitted paths are followed
    #[arg(long, help_heading = "Glass")]
    no_reflection: bool,
    /// How landed photons become light
    #[arg(long, value_parser = CausticsChoice::parser(), help_heading = "Glass")]
    caustics: Option<CausticsChoice>,
    /// Photons along each side of a caster's grid
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8192), help_heading = "Glass")]
    photons: Option<u32>,
    /// Texels along each side of the caustic map
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=8192), help_heading = "Glass")]
    caustic_size: Option<u32>,
    /// Which light makes caustics: only what is refracted in and out, or also what the glass mirrors, reflects inside and lets in
    /// again [default: all]
    #[arg(
        long, value_parser = values::one_of::<Interfaces, _>(Interfaces::ALL.map(Interfaces::name)),
        help_heading = "Glass"
    )]
    caustic_interfaces: Option<Interfaces>,

    /// Reuse nothing: every pass that the picture needs is run
    #[arg(long, conflicts_with = "verify_skips", help_heading = "Scheduling")]
    no_skip: bool,
    /// Rerun what would be reused and compare the bits
    #[arg(long, help_heading = "Scheduling")]
    verify_skips: bool,
}

impl ShotOptions {
    /// The file given.
    pub fn input(&self) -> &Path {
        &self.input
    }

    /// The input's shot with every change made.
    pub fn shot(&self) -> Result<Shot> {
        let mut shot = open_shot(&self.input)?;
        if !shot.model.exists() {
            return Err(std::io::Error::from(std::io::ErrorKind::NotFound))
                .with_context(|| format!("the model {} does not exist; check the path", shot.model.display()));
        }
        if let Some(clip) = &self.clip {
            shot.clip = clip.clone();
        }
        shot.speed = self.speed.unwrap_or(shot.speed);
        shot.repeat = self.repeat.unwrap_or(shot.repeat);
        shot.skinning = self.skinning.unwrap_or(shot.skinning);
        shot.variant = self.variant.clone().or(shot.variant);
        shot.layers.extend(self.layer.iter().map(|LayerOption(layer)| layer.clone()));
        if self.hold {
            shot.hold = Some(self.time.or(shot.hold).unwrap_or(0.0));
        } else if self.time.is_some() {
            shot.hold = None;
        }
        if self.glass {
            shot.glass.bodies = GlassBodies::All;
        }
        shot.glass.ior = self.ior.or(shot.glass.ior);
        shot.glass.dispersion = self.dispersion.map(|value| value as f32).or(shot.glass.dispersion);
        shot.glass.roughness = self.roughness.map(|value| value as f32).or(shot.glass.roughness);
        shot.glass.thin = self.thin.then_some(true).or(shot.glass.thin);
        if let Some(environment) = &self.env {
            shot.environment = environment.clone();
        }
        shot.floor.level = self.floor.unwrap_or(shot.floor.level);
        shot.output.size = self.size.unwrap_or(shot.output.size);
        shot.output.samples = self.samples.unwrap_or(shot.output.samples);
        self.change_camera(&mut shot);
        self.change_light(&mut shot);
        Ok(shot)
    }

    /// `--camera` takes the place of the shot's path.
    fn change_camera(&self, shot: &mut Shot) {
        if !self.camera.is_empty() {
            shot.camera.model = None;
            shot.camera.keys.clear();
        }
        for word in &self.camera {
            match word {
                CameraWord::Model(name) => shot.camera.model = Some(name.clone()),
                CameraWord::Eye(eye) => shot.camera.eye = Some(eye.to_array()),
                CameraWord::Target(target) => shot.camera.target = Some(target.to_array()),
                CameraWord::Fov(fov) => shot.camera.fov = *fov,
            }
        }
        shot.camera.orbit = self.orbit.unwrap_or(shot.camera.orbit);
    }

    /// `--light` takes the place of the shot's light; what it leaves open is chosen as for a bare model.
    fn change_light(&self, shot: &mut Shot) {
        if !self.light.is_empty() {
            let ShotLight { color, orbit, .. } = shot.light;
            shot.light = ShotLight { color, orbit, ..ShotLight::default() };
        }
        for word in &self.light {
            match *word {
                LightWord::Model => shot.light.model = true,
                LightWord::Kind(kind) => shot.light.kind = kind,
                LightWord::Position(position) => shot.light.position = Some(position.to_array()),
                LightWord::Direction(direction) => shot.light.direction = Some(direction.to_array()),
                LightWord::Intensity(intensity) => shot.light.intensity = Some(intensity as f32),
                LightWord::Cone(cone) => shot.light.cone = Some(cone),
            }
        }
        shot.light.orbit = self.light_orbit.unwrap_or(shot.light.orbit);
    }

    /// Whether `--method` is given.
    pub fn names_method(&self) -> bool {
        self.method.is_some()
    }

    /// Photons and size of the map of caustics, their method and light, unless they are switched off.
    pub fn caustics(&self, usual: Caustics) -> Caustics {
        Caustics {
            method: self.caustics.and_then(|choice| choice.0).unwrap_or(usual.method),
            photons: self.photons.unwrap_or(usual.photons),
            map_size: self.caustic_size.unwrap_or(usual.map_size),
            interfaces: self.caustic_interfaces.unwrap_or(usual.interfaces),
        }
    }

    /// How the shot is rendered.
    pub fn settings(&self) -> Settings {
        let default = Settings::default();
        let refraction = Refraction {
            method: self.method.unwrap_or(default.refraction.method),
            steps: self.steps.unwrap_or(default.refraction.steps),
            tir: self.tir.unwrap_or(default.refraction.tir),
            interfaces: self.interfaces.unwrap_or(default.refraction.interfaces),
            reflection: !self.no_reflection,
            branches: self.branches.unwrap_or(default.refraction.branches),
            most_interfaces: self.most_interfaces.unwrap_or(default.refraction.most_interfaces),
            normal_distance: self.isr_distance.unwrap_or(default.refraction.normal_distance),
            back_surface: self.isr_back.unwrap_or(default.refraction.back_surface),
            uncorrected: self.uncorrected,
            wavelengths: self.wavelengths.unwrap_or(default.refraction.wavelengths),
        };
        let off = self.caustics == Some(CausticsChoice(None));
        let caustics = (!off).then(|| self.caustics(Caustics::default()));
        let skipping = match (self.no_skip, self.verify_skips) {
            (true, _) => Skipping::Off,
            (_, true) => Skipping::Verify,
            _ => Skipping::On,
        };
        Settings { start: self.time.unwrap_or(0.0), refraction, caustics, aov: false, skipping }
    }
}

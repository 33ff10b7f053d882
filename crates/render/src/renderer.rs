//! The renderer: a world made ready for a device, and the frames it is asked for.

use std::collections::{HashMap, hash_map::Entry};

use glam::{DVec3, DVec4};
use murano_animation::{Geometry, GeometryError, Layer, Properties, Rig};
use murano_caustics::level_texels;
use murano_gpu::{Executed, Gpu, GpuError, StepTime, Work};
use murano_refraction::texels;
use murano_scene::{PlacedLight, Projection};
use murano_scheduler::{History, Output, Plan};

use crate::{
    Frame, FrameRequest, PassReport, Skipping, World,
    aov::{self, Layers},
    bodies,
    distant::Distant,
    frame::{self, Planned, Stock},
    lighting::Deposited,
    looks::{Arrangement, LookSource},
};

/// Why a frame could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The scene.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The request makes no sense.
    #[error("{0}")]
    Request(String),
}

/// Steps beyond which no search gains anything in f32.
const MOST_STEPS: u32 = 64;
/// Rays through a pixel.
const MOST_SAMPLES: u32 = 1024;
/// Photons, and texels of a map, along a side.
const MOST_PHOTONS: u32 = 8192;

/// Ways to sort the bodies of a world that are kept: a clip may make glass of things, and undo it.
const MOST_ARRANGEMENTS: usize = 4;

/// A world on a device.
pub struct Renderer {
    gpu: Gpu,
    world: World,
    rig: Rig,
    look_source: LookSource,
    /// The one in use first.
    arrangements: Vec<Arrangement>,
    distant: Distant,
    fade_centre: DVec3,
    history: History,
}

/// One geometry as the GPU deformed it.
pub struct DeformedMesh {
    /// World, metres.
    pub positions: Vec<DVec3>,
    /// World, unit (zero where the mesh collapses).
    pub normals: Vec<DVec3>,
    /// What was deformed, for comparison with `murano_animation::deform_f64`.
    pub geometry: Geometry,
}

impl Renderer {
    /// Sorts a world into bodies and hashes what never changes.
    ///
    /// # Errors
    /// [`RenderError::Geometry`] if the scene has more vertices than can be indexed.
    pub fn new(gpu: Gpu, mut world: World) -> Result<Self, RenderError> {
        let floor = world.floor;
        let material = floor.as_ref().map(|floor| bodies::add_floor(&mut world.scene, floor));
        let look_source = LookSource::new(&world.scene, material.zip(floor.as_ref()));
        let arrangement = Arrangement::new(&world.scene, &look_source, world.scene.materials.clone())?;
        let fade_centre = floor.map_or(DVec3::ZERO, |floor| DVec3::new(floor.center[0], floor.height, floor.center[1]));
        let distant = Distant::new(world.environment.as_ref());
        let rig = Rig::new(&world.scene);
        Ok(Self {
            gpu,
            world,
            rig,
            look_source,
            arrangements: vec![arrangement],
            distant,
            fade_centre,
            history: History::new(),
        })
    }

    /// The world, with the floor as a node of its scene.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Gives the device back with everything computed on it: another world on it finds what it has in common with this
    /// one still there.
    pub fn into_gpu(self) -> Gpu {
        self.gpu
    }

    /// Sorts bodies by what their materials are while this plays, where they are drawn in other ways than before.
    fn arrange(&mut self, playing: &[Layer]) -> Result<(), GeometryError> {
        let scene = &self.world.scene;
        let materials = Properties::sample(scene, playing).all_materials(scene);
        let source = &self.look_source;
        let place = self.arrangements.iter_mut().position(|arrangement| arrangement.take(scene, source, &materials));
        if let Some(place) = place {
            self.arrangements.swap(0, place);
        } else {
            self.arrangements.insert(0, Arrangement::new(scene, source, materials)?);
            self.arrangements.truncate(MOST_ARRANGEMENTS);
        }
        Ok(())
    }

    fn stock(&self) -> Stock<'_> {
        let Arrangement { sorted, looks, .. } = &self.arrangements[0];
        Stock {
            gpu: &self.gpu,
            scene: &self.world.scene,
            sorted,
            looks,
            distant: &self.distant,
            fade_centre: self.fade_centre,
        }
    }

    /// Renders one frame. Equal requests give equal bits, whatever was rendered before.
    ///
    /// # Errors
    /// [`RenderError`]: an impossible request, or the device.
    pub fn render(&mut self, request: &FrameRequest) -> Result<Frame, RenderError> {
        check(request, &self.world)?;
        let pose = self.rig.pose(&request.playing);
        self.arrange(&request.playing)?;
        let before = request.before.as_ref().filter(|_| request.aov);
        let before = before.map(|moment| (moment, self.rig.pose(&moment.playing)));
        let before = before.as_ref().map(|(moment, pose)| (*moment, pose));
        let planned = frame::plan(&self.stock(), &pose, before, request)?;
        let mut reports = Reports::default();
        let mut beside = Vec::new();
        let mut first = self.first_missing(&planned, request.skipping);
        if request.aov {
            // What is told of the first sample alone, before others take its place.
            beside.extend(&planned.paths);
            beside.extend(&planned.light_layers);
            beside.extend(&planned.motions);
            beside.push(planned.sums[0]);
        }
        let beside =
            if beside.is_empty() { Vec::new() } else { self.round(&planned, &beside, 0, request, &mut reports)? };
        first = first.max(u32::from(request.aov));
        let last = request.samples - 1;
        for sample in first..last {
            let executed = self.gpu.execute_round(
                &planned.plan,
                (&planned.sums[sample as usize..=sample as usize], false),
                sample,
                &mut self.history,
                request.skipping,
            )?;
            reports.add(&executed);
        }
        let mut targets = vec![planned.picture];
        if request.aov {
            targets.push(planned.colour());
        }
        let shown = self.round(&planned, &targets, last, request, &mut reports)?;
        let passes = reports.all;
        let pixels = request.size[0] as usize * request.size[1] as usize;
        Ok(Frame {
            size: request.size,
            rgba: shown[0][..4 * pixels].to_vec(),
            aov: request.aov.then(|| gather(&planned, &shown[1], &beside, pixels)),
            gpu_ms: passes.iter().filter_map(|pass| pass.gpu_ms).sum(),
            passes,
            cache_bytes: self.gpu.cache_bytes(),
        })
    }

    /// The first sample that has to be computed, with those behind it; the last one's sum is the frame's own business.
    fn first_missing(&self, planned: &Planned, skipping: Skipping) -> u32 {
        if skipping != Skipping::On {
            return 0;
        }
        let held = planned.sums.iter().rposition(|sum| self.gpu.holds(*sum));
        held.map_or(0, |last| last as u32 + 1)
    }

    /// Computes targets of one round and reads them back.
    fn round(
        &mut self,
        planned: &Planned,
        targets: &[Output],
        round: u32,
        request: &FrameRequest,
        reports: &mut Reports,
    ) -> Result<Vec<Vec<u8>>, RenderError> {
        let executed =
            self.gpu.execute_round(&planned.plan, (targets, true), round, &mut self.history, request.skipping)?;
        reports.add(&executed);
        Ok(executed.targets)
    }

    /// The GPU's deformation of every geometry, glass bodies first, the opaque rest last.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] of the device.
    pub fn deform(&mut self, playing: &[Layer]) -> Result<Vec<DeformedMesh>, RenderError> {
        self.arrange(playing)?;
        let pose = self.rig.pose(playing);
        let mut plan: Plan<Work> = Plan::new();
        let sorted = &self.arrangements[0].sorted;
        let all = sorted.bodies.iter().map(|body| (&body.geometry, &body.leaves));
        let all = all.chain([(&sorted.opaque.geometry, &sorted.opaque.leaves)]);
        let mut meshes = Vec::new();
        let mut targets: Vec<Output> = Vec::new();
        for (instance, (geometry, leaves)) in (0..).zip(all) {
            let origin = geometry.posed_bounds(&pose).center();
            let deformed = leaves.deform(&self.gpu, &mut plan, instance, geometry, &pose, origin)?;
            targets.extend([deformed.positions, deformed.normals]);
            meshes.push((geometry, origin));
        }
        let executed = self.gpu.execute(&plan, &targets, &mut History::new(), Skipping::On)?;
        Ok(meshes
            .into_iter()
            .zip(executed.targets.chunks(2))
            .map(|((geometry, origin), buffers)| DeformedMesh {
                positions: aov::rows(&buffers[0], geometry.vertices.len()).map(|p| origin + p.truncate()).collect(),
                normals: aov::rows(&buffers[1], geometry.vertices.len()).map(DVec4::truncate).collect(),
                geometry: geometry.clone(),
            })
            .collect())
    }

    /// Flux of each caustic map of a request, per lamp and caster in order: watts sent out of the glass and watts landed
    /// on receivers, before absorption, for a lamp of intensity 1.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn caustic_accounts(&mut self, request: &FrameRequest) -> Result<Vec<CausticAccount>, RenderError> {
        check(request, &self.world)?;
        let pose = self.rig.pose(&request.playing);
        self.arrange(&request.playing)?;
        let request = &FrameRequest { samples: 1, ..request.clone() };
        let planned = frame::plan(&self.stock(), &pose, None, request)?;
        let targets: Vec<Output> = planned
            .accounts
            .iter()
            .flat_map(|Deposited { seen, hidden }| {
                let seen_first = [seen.account, seen.flux, seen.detail, seen.range];
                // Without anything hidden, its place is taken by what counts for nothing.
                seen_first.into_iter().chain([hidden.as_ref().map_or(seen.account, |hidden| hidden.account)])
            })
            .collect();
        let executed = self.gpu.execute(&planned.plan, &targets, &mut self.history, Skipping::On)?;
        let size = [request.caustics.map_or(0, |caustics| caustics.map_size); 2];
        let (finest, level) = (texels(size) as usize, level_texels(size) as usize);
        Ok(planned
            .accounts
            .iter()
            .zip(executed.targets.chunks(5))
            .map(|(Deposited { seen: deposited, hidden }, buffers)| {
                let units_hidden: &[u32] = bytemuck::cast_slice(&buffers[4]);
                let hidden = hidden.map_or(0.0, |hidden| f64::from(units_hidden[1]) * hidden.watts_per_unit);
                let units: &[u32] = bytemuck::cast_slice(&buffers[0]);
                let flux: &[u32] = bytemuck::cast_slice(&buffers[1]);
                let place: &[f32] = bytemuck::cast_slice(&buffers[2]);
                let range: &[f32] = bytemuck::cast_slice(&buffers[3]);
                let texels_from =
                    |first: usize| (first..first + finest).map(|texel| deposited.watts(flux, texel)).collect();
                CausticAccount {
                    sent: f64::from(units[0]) * deposited.watts_per_unit,
                    landed: f64::from(units[1]) * deposited.watts_per_unit + hidden,
                    map: texels_from(0),
                    detail: texels_from(level),
                    range: range[..2 * finest].to_vec(),
                    detail_offset: [place[0], place[1]],
                    detail_scale: [place[2], place[3]],
                }
            })
            .collect())
    }
}

/// The energy of one caustic map, for a lamp of intensity 1.
#[derive(Clone, Debug)]
pub struct CausticAccount {
    /// Watts that left the glass.
    pub sent: f64,
    /// Watts that met a receiver within the lamp's view, or one that such hides.
    pub landed: f64,
    /// The lamp's whole view of what it sees: watts a texel, RGB, row by row.
    pub map: Vec<[f32; 3]>,
    /// The part of it where the light lands, in as many texels.
    pub detail: Vec<[f32; 3]>,
    /// Of each texel of the whole view, then of the detail: the part of the fixed-point range that its fullest channel takes.
    pub range: Vec<f32>,
    /// The corner of that part, texels of the whole view.
    pub detail_offset: [f32; 2],
    /// Its texels over those of the whole view, along each axis.
    pub detail_scale: [f32; 2],
}

impl CausticAccount {
    /// The part of the range of fixed-point sums that the fullest texel takes; a quarter, and what rounding adds, at the most.
    pub fn range_used(&self) -> f32 {
        self.range.iter().copied().fold(0.0, f32::max)
    }
}

fn gather(planned: &Planned, colour: &[u8], beside: &[Vec<u8>], pixels: usize) -> crate::Aov {
    let (paths, others) = beside.split_at(planned.paths.len());
    let (lights, others) = others.split_at(planned.light_layers.len());
    let motions = &others[..planned.motions.len()];
    Layers { origin: planned.origin, pixels, colour, paths, lights, motions }.gather()
}

fn check(request: &FrameRequest, world: &World) -> Result<(), RenderError> {
    let wrong = |message: String| Err(RenderError::Request(message));
    if request.size.contains(&0) {
        return wrong(format!("a picture of {}x{} pixels is empty", request.size[0], request.size[1]));
    }
    let clips = world.scene.clips.len();
    if let Some(layer) = request.playing.iter().find(|layer| layer.clip >= clips) {
        return wrong(format!("there is no clip {}; the model has {clips}", layer.clip));
    }
    let ahead = request.view.near > 0.0;
    let before = request.before.iter().flat_map(|before| &before.playing);
    if let Some(layer) = before.clone().find(|layer| layer.clip >= clips) {
        return wrong(format!("there was no clip {}; the model has {clips}", layer.clip));
    }
    let timely = request.playing.iter().chain(before).all(|layer| layer.time.is_finite() && layer.weight.is_finite());
    if !timely || !request.view.world_from_view.is_finite() || !ahead {
        return wrong("times, weights and the camera must be finite, and the near distance positive".into());
    }
    let sound_projection = match request.view.projection {
        Projection::Perspective { yfov } => yfov > 0.0 && yfov < std::f64::consts::PI,
        Projection::Orthographic { half_height } => half_height > 0.0 && half_height.is_finite(),
    };
    if !sound_projection || request.view.world_from_view.determinant() == 0.0 {
        return wrong("the camera needs a field of view between 0 and 180 degrees and a rigid place".into());
    }
    let unsound_light = |lamp: &PlacedLight| {
        !lamp.world_from_light.is_finite() || !lamp.light.color.is_finite() || !lamp.light.intensity.is_finite()
    };
    if !request.exposure.is_finite() || request.lights.iter().any(unsound_light) {
        return wrong("exposure, and every light's place, colour and intensity must be finite".into());
    }
    if request.samples == 0 || request.samples > MOST_SAMPLES {
        return wrong(format!("{} samples of a pixel; 1 to {MOST_SAMPLES} make sense", request.samples));
    }
    if request.refraction.steps > MOST_STEPS {
        return wrong(format!("{} search steps; at most {MOST_STEPS} make sense", request.refraction.steps));
    }
    if let Some(caustics) = request.caustics
        && [caustics.photons, caustics.map_size].iter().any(|&side| side == 0 || side > MOST_PHOTONS)
    {
        return wrong(format!("photons and texels a side of a caustic map must lie between 1 and {MOST_PHOTONS}"));
    }
    Ok(())
}

/// What became of each pass over all samples: it ran if it did for any of them, and its time is the sum.
#[derive(Default)]
struct Reports {
    all: Vec<PassReport>,
    /// By name and instance.
    places: HashMap<(&'static str, u32), usize>,
}

impl Reports {
    fn add(&mut self, executed: &Executed) {
        let time = |time: &StepTime| ((time.name, time.round, time.instance), time.gpu_ms);
        let times: HashMap<_, _> = executed.times.iter().map(time).collect();
        for step in &executed.schedule.steps {
            let report = PassReport {
                name: format!("{}:{}", step.name, step.instance),
                decision: step.decision.name(),
                reason: step.decision.reason(),
                gpu_ms: times.get(&(step.name, step.round, step.instance)).copied().flatten(),
            };
            match self.places.entry((step.name, step.instance)) {
                Entry::Vacant(place) => {
                    place.insert(self.all.len());
                    self.all.push(report);
                }
                Entry::Occupied(place) => self.all[*place.get()].join(report),
            }
        }
    }
}

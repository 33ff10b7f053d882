//! One moment of a shot, on a device.

use std::borrow::Cow;

use anyhow::{Context, Result};
use murano_animation::{Pose, Properties, shown_primitives};
use murano_gpu::Gpu;
use murano_reference as reference;
use murano_render::{Frame, FrameRequest, Renderer, Settings, Stage, World};
use murano_scene::{Material, Primitive, Scene, Shot};

/// One moment of a shot, ready to be rendered and to be traced.
pub struct Subject {
    /// Its renderer.
    pub renderer: Renderer,
    /// The frame that is asked for, in the settings that the subject was opened with.
    pub request: FrameRequest,
    /// Diameter of what the bodies sweep over the clip, metres.
    pub diameter: f64,
}

impl Subject {
    /// Puts the first frame of a shot on stage.
    ///
    /// # Errors
    /// Whatever is wrong with the shot, its files or the device.
    pub fn open(gpu: Gpu, shot: Shot, settings: &Settings) -> Result<Self> {
        Ok(Self::open_on_stage(gpu, shot, settings)?.0)
    }

    /// The same, with the stage that knows the shot's other frames.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_on_stage(gpu: Gpu, shot: Shot, settings: &Settings) -> Result<(Self, Stage)> {
        let (world, stage) = Stage::open(shot)?;
        let request = stage.request(0.0, settings);
        Ok((Self { renderer: Renderer::new(gpu, world)?, request, diameter: stage.extent().diameter() }, stage))
    }

    /// Puts a world made in code before a camera, in the usual settings.
    ///
    /// # Errors
    /// If the world has too many vertices.
    pub fn of_world(gpu: Gpu, world: World, request: FrameRequest, diameter: f64) -> Result<Self> {
        Ok(Self { renderer: Renderer::new(gpu, world)?, request, diameter })
    }

    /// Triangles of all glass.
    pub fn glass_triangles(&self) -> usize {
        let scene = &self.renderer.world().scene;
        let glass = |primitive: &&Primitive| {
            primitive.material.and_then(|index| scene.materials.get(index)).is_some_and(Material::is_glass)
        };
        shown_primitives(scene)
            .into_iter()
            .filter_map(|(node, primitive)| scene.meshes[scene.nodes[node].mesh?].primitives.get(primitive))
            .filter(glass)
            .map(|primitive| primitive.triangles.len())
            .sum()
    }

    /// The device, for the next subject.
    pub fn into_gpu(self) -> Gpu {
        self.renderer.into_gpu()
    }

    /// Renders the subject's frame as changed by `change`.
    ///
    /// # Errors
    /// The device's.
    pub fn render(&mut self, change: impl FnOnce(&mut FrameRequest)) -> Result<Frame> {
        let mut request = self.request.clone();
        change(&mut request);
        Ok(self.renderer.render(&request)?)
    }

    /// The scene that the frame shows: with its materials as clips have made them.
    pub fn scene(&self) -> Cow<'_, Scene> {
        let scene = &self.renderer.world().scene;
        let properties = Properties::sample(scene, &self.request.playing);
        if properties.materials.is_empty() {
            return Cow::Borrowed(scene);
        }
        Cow::Owned(Scene { materials: properties.all_materials(scene), ..scene.clone() })
    }

    /// The pose that the frame shows.
    pub fn pose(&self) -> Pose {
        Pose::sample(&self.renderer.world().scene, &self.request.playing)
    }

    /// The posed scene for the reference tracer, deformed in f64.
    ///
    /// # Errors
    /// If the pose is not finite or the scene shows no glass.
    pub fn traced(&self) -> Result<reference::World> {
        let world = reference::World::of_scene(&self.scene(), &self.pose()).context("the reference tracer")?;
        anyhow::ensure!(
            !world.bodies.is_empty(),
            "the input shows no glass, so there is nothing to compare; make it glass with --glass"
        );
        Ok(world)
    }

    /// Index of refraction of the first body.
    ///
    /// # Errors
    /// If there is none.
    pub fn ior(&self) -> Result<f64> {
        Ok(self.traced()?.bodies[0].ior)
    }

    /// The eye for the reference tracer.
    pub fn camera(&self) -> reference::Camera {
        let view = &self.request.view;
        reference::Camera {
            world_from_view: view.world_from_view,
            projection: view.projection,
            size: self.request.size,
        }
    }

    /// Name of the adapter.
    pub fn adapter(&self) -> String {
        self.renderer.gpu().adapter_name()
    }
}

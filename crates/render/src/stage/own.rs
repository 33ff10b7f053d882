//! The model's own camera and lights in a shot.

use glam::{DMat4, DVec3};
use murano_animation::{Layer, Properties, Rig};
use murano_scene::{NodeIndex, PlacedLight, Scene, Shot};

use super::{StageError, listed};
use crate::View;

/// What of a model is needed to place its camera and lights at any moment.
#[derive(Clone, Debug)]
pub struct Own {
    /// Without meshes, materials and images.
    scene: Scene,
    rig: Rig,
    camera: Option<NodeIndex>,
    lights: Vec<NodeIndex>,
}

impl Own {
    /// Finds what a shot asks for of its model; `None` if it asks for neither.
    pub fn new(shot: &Shot, scene: &Scene) -> Result<Option<Self>, StageError> {
        if shot.camera.model.is_none() && !shot.light.model {
            return Ok(None);
        }
        let shown = scene.traversal();
        let camera = shot.camera.model.as_ref().map(|name| find_camera(shot, scene, &shown, name)).transpose()?;
        let lit = |&node: &NodeIndex| shot.light.model && scene.nodes[node].light.is_some();
        let lights: Vec<NodeIndex> = shown.iter().copied().filter(lit).collect();
        if shot.light.model && lights.is_empty() {
            return Err(StageError::NoLights(shot.model.clone()));
        }
        let scene = Scene {
            nodes: scene.nodes.clone(),
            roots: scene.roots.clone(),
            clips: scene.clips.clone(),
            cameras: scene.cameras.clone(),
            lights: scene.lights.clone(),
            ..Scene::default()
        };
        Ok(Some(Self { rig: Rig::new(&scene), scene, camera, lights }))
    }

    /// The camera's view while this plays; `None` if the shot has a camera of its own.
    pub fn view(&self, playing: &[Layer]) -> Option<View> {
        let node = self.camera?;
        let properties = Properties::sample(&self.scene, playing);
        let camera = properties.camera(&self.scene, self.scene.nodes[node].camera?);
        let world_from_view = rigid(&self.rig.pose(playing).world_from_node[node]);
        Some(View { world_from_view, projection: camera.projection, near: camera.znear.max(f64::MIN_POSITIVE) })
    }

    /// The lights while this plays; `None` if the shot has a light of its own.
    pub fn lights(&self, playing: &[Layer]) -> Option<Vec<PlacedLight>> {
        if self.lights.is_empty() {
            return None;
        }
        let properties = Properties::sample(&self.scene, playing);
        let pose = self.rig.pose(playing);
        let placed = |&node: &NodeIndex| {
            let light = properties.light(&self.scene, self.scene.nodes[node].light?).clone();
            Some(PlacedLight { world_from_light: rigid(&pose.world_from_node[node]), light })
        };
        Some(self.lights.iter().filter_map(placed).collect())
    }
}

/// The node of the camera of a name, its own or its node's, or of a number among those shown; of the first if there is no name.
fn find_camera(shot: &Shot, scene: &Scene, shown: &[NodeIndex], name: &str) -> Result<NodeIndex, StageError> {
    let names = |node: NodeIndex| {
        let camera = scene.nodes[node].camera.map_or("", |camera| scene.cameras[camera].name.as_str());
        [scene.nodes[node].name.as_str(), camera]
    };
    let mut cameras = shown.iter().copied().filter(|&node| scene.nodes[node].camera.is_some());
    let place = name.parse::<usize>().ok().and_then(|index| cameras.clone().nth(index));
    let found = cameras.clone().find(|&node| name.is_empty() || names(node).contains(&name)).or(place);
    found.ok_or_else(|| StageError::NoCamera {
        model: shot.model.clone(),
        wanted: name.to_owned(),
        choices: listed(
            cameras.by_ref().map(|node| names(node).into_iter().find(|name| !name.is_empty()).unwrap_or("")),
        ),
    })
}

/// A node's place and direction without its scale.
fn rigid(world_from_node: &DMat4) -> DMat4 {
    let z = world_from_node.z_axis.truncate().normalize_or(DVec3::Z);
    let y = world_from_node.y_axis.truncate();
    let x = y.cross(z).try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
    DMat4::from_cols(x.extend(0.0), z.cross(x).extend(0.0), z.extend(0.0), world_from_node.w_axis)
}

//! What layers make of materials, lights and cameras (KHR_animation_pointer).

use murano_scene::{Camera, Clip, Light, LightProperty, Material, MaterialProperty, Property, Scene};

use crate::layer::{Blend, Layer};
use crate::sample::sample_weights;

/// Materials, lights and cameras that clips drive, as they are at a moment; all others are as in the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Properties {
    /// Index into `Scene::materials`, and what it has become.
    pub materials: Vec<(usize, Material)>,
    /// Index into `Scene::lights`, and what it has become.
    pub lights: Vec<(usize, Light)>,
    /// Index into `Scene::cameras`, and what it has become.
    pub cameras: Vec<(usize, Camera)>,
}

impl Properties {
    /// What layers make of a scene's properties, in order. Masks are for nodes and have no effect here.
    pub fn sample(scene: &Scene, playing: &[Layer]) -> Self {
        let mut properties = Self::default();
        let clips = playing.iter().filter_map(|layer| scene.clips.get(layer.clip));
        let mut driven: Vec<Property> = Vec::new();
        for channel in clips.flat_map(|clip| &clip.properties) {
            if !driven.contains(&channel.property) {
                driven.push(channel.property);
            }
        }
        // An inner cone is held to the outer one as that is at the moment.
        driven.sort_by_key(|property| matches!(property, Property::Light(_, LightProperty::InnerCone)));
        for property in driven {
            let Some(rest) = rest_value(scene, property) else { continue };
            let value = blended(scene, playing, property, &rest);
            properties.set(scene, property, &value);
        }
        properties
    }

    /// All materials of the scene at the moment.
    pub fn all_materials(&self, scene: &Scene) -> Vec<Material> {
        let mut materials = scene.materials.clone();
        for (index, material) in &self.materials {
            materials[*index].clone_from(material);
        }
        materials
    }

    /// A light of the scene at the moment.
    pub fn light<'a>(&'a self, scene: &'a Scene, index: usize) -> &'a Light {
        self.lights.iter().find(|(other, _)| *other == index).map_or(&scene.lights[index], |(_, light)| light)
    }

    /// A camera of the scene at the moment.
    pub fn camera<'a>(&'a self, scene: &'a Scene, index: usize) -> &'a Camera {
        self.cameras.iter().find(|(other, _)| *other == index).map_or(&scene.cameras[index], |(_, camera)| camera)
    }

    fn set(&mut self, scene: &Scene, property: Property, value: &[f64]) {
        match property {
            Property::Material(index, property) => {
                property.set(entry(&mut self.materials, index, &scene.materials), value);
            }
            Property::Light(index, property) => property.set(entry(&mut self.lights, index, &scene.lights), value),
            Property::Camera(index, property) => property.set(entry(&mut self.cameras, index, &scene.cameras), value),
            Property::Weight(..) => {}
        }
    }
}

/// The element of an index among those that have changed, copied from `all` at first.
fn entry<'a, T: Clone>(changed: &'a mut Vec<(usize, T)>, index: usize, all: &[T]) -> &'a mut T {
    let place = changed.iter().position(|(other, _)| *other == index).unwrap_or_else(|| {
        changed.push((index, all[index].clone()));
        changed.len() - 1
    });
    &mut changed[place].1
}

/// The value in the scene; `None` where there is no such thing, and for morph weights, which belong to the pose.
fn rest_value(scene: &Scene, property: Property) -> Option<Vec<f64>> {
    match property {
        Property::Material(index, property) => property.get(scene.materials.get(index)?),
        Property::Light(index, property) => property.get(scene.lights.get(index)?),
        Property::Camera(index, property) => property.get(scene.cameras.get(index)?),
        Property::Weight(..) => None,
    }
}

fn blended(scene: &Scene, playing: &[Layer], property: Property, rest: &[f64]) -> Vec<f64> {
    // What may be infinite, and acts by its reciprocal, is blended as that.
    let reciprocal = matches!(
        property,
        Property::Material(_, MaterialProperty::AttenuationDistance) | Property::Light(_, LightProperty::Range)
    );
    // A value that is not above zero stands for infinity, as it does where it is set.
    let turned = |values: Vec<f64>, otherwise: f64| -> Vec<f64> {
        let turn = |value: f64| if value > 0.0 { value.recip() } else { otherwise };
        if reciprocal { values.into_iter().map(turn).collect() } else { values }
    };
    let inward = |values: Vec<f64>| turned(values, 0.0);
    let mut below = inward(rest.to_vec());
    for layer in playing {
        let Some(clip) = scene.clips.get(layer.clip) else { continue };
        let weight = layer.whole_weight();
        let above = driven(clip, property, layer.time).map(inward);
        match layer.blend {
            Blend::Over => {
                let above = above.unwrap_or_else(|| inward(rest.to_vec()));
                let mixed = |(below, above): (&mut f64, f64)| *below = *below * (1.0 - weight) + above * weight;
                below.iter_mut().zip(above).for_each(mixed);
            }
            Blend::Add => {
                let (Some(above), Some(start)) = (above, driven(clip, property, 0.0).map(inward)) else { continue };
                let changes = above.iter().zip(start).map(|(above, start)| (above - start) * weight);
                below.iter_mut().zip(changes).for_each(|(below, change)| *below += change);
            }
        }
    }
    turned(below, f64::INFINITY)
}

/// The value that a clip gives a property; `None` if it drives it not.
fn driven(clip: &Clip, property: Property, time: f64) -> Option<Vec<f64>> {
    let channel = clip.properties.iter().find(|channel| channel.property == property)?;
    sample_weights(&channel.sampler, time)
}
